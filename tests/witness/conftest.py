"""What tests of the witness share."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.witness.cl import read_story
from camrob.witness.happenings import Story


@pytest.fixture
def tell(tmp_path: Path):
    """Reads the text of a CL file; an operation that it opens last, and leaves open, is closed for it (`whole`)."""

    def read(text: str, name: str = "a.apt", *, whole: bool = True, **options) -> Story:
        path = tmp_path / name
        if whole and isinstance(text, str):
            for begin, end in (("TOOL PATH", "END-OF-PATH"), ("OPFEATSTART", "OPFEATEND/")):
                text += f"\n{end}\n" * (text.rfind(begin) > text.rfind(end))
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_story(path, **options)

    return read
