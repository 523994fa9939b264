"""What a program was made from, file by file: SHA-256 of CL file, set-up and its meshes, cell, program and what was known.

    {"camrob": "0.1.0", "cl_file": {"part.cls": "..."}, "setup": {"setup.toml": "...", "part.stl": "..."},
     "cell": {"cell.toml": "...", "poses.csv": "..."}, "program": {"part.src": "...", "part.dat": "..."},
     "known": {"fitted.toml": "...", "diagnosis.json": "..."}, "source": {"part.src": "...", "part.dat": "..."}}

known: calibration, diagnosis and force that postures, feed or targets went by, where any did. source: the program whose targets
were moved, of one that is compensated; CL file and set-up are then that one's, as its own manifest has them. Names are relative
to the folder that holds the file (of the set-up's: to the set-up's). A file that can't be read has the digest "": it is in the
list, and it matches nothing.
"""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from camrob.witness.happenings import Objection

__all__ = ["check_manifest", "check_upload", "digests", "make_manifest"]

_HINT = "post again, or leave the manifest out (--no-manifest)"
_OTHER = f"give what the program was posted with, {_HINT}"  # for it may be another cell, file or set-up
_PROSE = (".md", ".txt")  # of a cell's folder: words for people change no program
_GROUPS = {"cl_file": "CL file", "setup": "set-up", "cell": "cell", "program": "program"}


def make_manifest(
    program: Iterable[Path],
    cell: Path,
    *,
    clfile: Path | None = None,
    setup: Path | None = None,
    known: Iterable[Path] = (),
) -> dict[str, Any]:
    """The manifest of a program's files, its cell (folder or cell.toml), CL file, set-up and further files, as they are now."""
    folder = cell if cell.is_dir() else cell.parent
    inside = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix.lower() not in _PROSE)
    return {
        "camrob": _version(),
        "cl_file": digests([] if clfile is None else [clfile]),
        "setup": digests(_setup_files(setup), None if setup is None else setup.parent),
        "cell": digests(inside, folder),
        "program": digests(sorted(program)),
    } | ({"known": digests(further)} if (further := sorted(known)) else {})


def check_manifest(
    manifest: Mapping[str, Any],
    program: Iterable[Path],
    cell: Path,
    *,
    clfile: Path | None = None,
    setup: Path | None = None,
) -> list[Objection]:
    """What differs between a manifest and the files as they are now: changed, missing and further ones, one objection each.

    CL file and set-up are compared where they are given; what was known, and the source of a compensated program, by nobody.
    Another version of camrob is a warning.
    """
    now = make_manifest(program, cell, clfile=clfile, setup=setup)
    found = []
    for group, title in _GROUPS.items():
        then = manifest.get(group)
        if not isinstance(then, dict):
            found.append(Objection("manifest-broken", f"the manifest has no list of the {title}'s files"))
            continue
        if (group == "cl_file" and clfile is None) or (group == "setup" and setup is None):
            continue
        hint = _HINT if group == "program" else _OTHER
        for name in sorted({*then, *now[group]}):
            if name not in now[group]:
                found.append(
                    Objection(
                        "manifest-missing", f"{name} ({title}), which the program was posted with, is not here; {hint}"
                    )
                )
            elif name not in then:
                found.append(
                    Objection("manifest-further", f"{name} ({title}) is none that the program was posted with; {hint}")
                )
            elif not then[name] or then[name] != now[group][name]:
                found.append(
                    Objection(
                        "manifest-differs", f"{name} ({title}) is not as it was when the program was posted; {hint}"
                    )
                )
    if manifest.get("camrob") != now["camrob"]:
        text = f"the manifest is of camrob {manifest.get('camrob')}, this is {now['camrob']}"
        found.append(Objection("manifest-version", text, severity="warning"))
    return found


def check_upload(text: str, main: Path, program: Iterable[Path]) -> list[Objection]:
    """What is wrong with a list for the upload of a program's files, whose lines are those of sha256sum: digest, place.

    Each of the program's files has to be in it, once, as it is now, all in one folder of the controller, and the main program
    last, so that the controller never links it to parts that aren't there yet.
    """
    rows = [re.fullmatch(r"([0-9a-f]{64})  (\S+)/([^/\s]+)", row) for row in text.splitlines()]
    listed = [(row[1], row[2], row[3]) for row in rows if row is not None]
    if not listed or None in rows:
        return [Objection("upload-broken", f"the list for the upload can't be read; {_HINT}")]
    found, now = [], digests(program)
    names = [name.upper() for _, _, name in listed]
    if len(set(names)) < len(names) or len({place for _, place, _ in listed}) > 1:
        found.append(Objection("upload-places", f"the list for the upload names a file twice, or two folders; {_HINT}"))
    if listed[-1][2] != main.name:
        found.append(Objection("upload-order", f"{main.name} is not the last one of the list for the upload; {_HINT}"))
    for name in sorted(now.keys() | {name for _, _, name in listed}):
        said = {digest for digest, _, file in listed if file == name}
        if said != {now.get(name, "")}:
            text = f"{name} is not as the list for the upload has it"
            found.append(Objection("upload-differs", f"{text}; {_HINT}"))
    return found


def _version() -> str:
    try:
        return version("camrob")
    except PackageNotFoundError:
        return ""


def _setup_files(setup: Path | None) -> list[Path]:
    """The set-up and the files that it names: meshes, a machine tool, a tool library."""
    if setup is None:
        return []
    try:
        table = tomllib.loads(setup.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return [setup]
    bodies = [table.get(name) for name in ("part", "stock")]
    names = [body.get("mesh") for body in bodies if isinstance(body, dict)]
    names += [table.get("machine"), table.get("tool_library")]
    return [setup, *(setup.parent / name for name in names if isinstance(name, str))]


def digests(paths: Iterable[Path], folder: Path | None = None) -> dict[str, str]:
    """Name to digest; names relative to `folder` where they lie in it."""
    out = {}
    for path in paths:
        inside = folder is not None and path.is_relative_to(folder)
        out[path.relative_to(folder).as_posix() if folder is not None and inside else path.name] = _digest(path)
    return out


def _digest(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
