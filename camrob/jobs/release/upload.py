"""The list of what goes where on the controller, with checksums."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import VerificationError
from camrob.program.language import Language
from camrob.witness.manifest import check_upload

__all__ = ["SUFFIX", "write_upload"]

SUFFIX = ".sha256"
"""Of the list's name: what `sha256sum --check` takes."""


def write_upload(
    folder: Path, name: str, files: Sequence[str], language: Language, controller: ControllerSettings
) -> list[str]:
    """Write NAME.sha256 for a program's `files`, which lie in `folder`, and hand back its name; nothing where none is asked for.

    Its lines, digest and place on the controller, are in the order of copying. Raises VerificationError where the witness
    finds the list wrong.
    """
    places = language.upload(name, files, controller)
    if not places:
        return []
    rows = [f"{hashlib.sha256((folder / file).read_bytes()).hexdigest()}  {place}\n" for file, place in places]
    listed = folder / f"{name}{SUFFIX}"
    listed.write_text("".join(rows), encoding="ascii", newline="\n")
    main = folder / f"{name}{language.suffixes[0]}"
    found = check_upload(listed.read_text(encoding="ascii"), main, [folder / file for file in files])
    if found:
        raise VerificationError(f"the list for the upload is wrong: {found[0].text}; report it with the files")
    return [listed.name]
