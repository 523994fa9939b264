"""What tests of the witness share."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.witness.cl import read_story
from camrob.witness.happenings import Story


@pytest.fixture
def tell(tmp_path: Path):
    """Reads the text of a CL file."""

    def read(text: str, name: str = "a.apt", **options) -> Story:
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_story(path, **options)

    return read
