"""A job as a parcel: all files that it reads, and where they lie, so that it can be done anywhere.

Where the job is done, a sandbox mirrors the places of the files (and of `out`), so that whatever a job writes about
places relative to each other is true at home too.
"""

from __future__ import annotations

import re
import shutil
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camrob.errors import InputError
from camrob.jobs.batching.jobs_file import BatchJob
from camrob.jobs.batching.verbs import Kind
from camrob.languages import language_suffixes

__all__ = ["Parcel", "Place", "load_parcel", "pack_parcel", "sandbox_path", "unpack_parcel"]

MOST_BYTES = 2**30  # of a cell's folder: beyond it, something else than a cell was named


@dataclass(frozen=True, slots=True)
class Place:
    """The parts of an absolute path; the first stands for the root or the drive."""

    parts: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Parcel:
    """A job's verb, its plain arguments, those that are paths, and the files it reads with what the user calls them."""

    index: int
    verb: str
    plain: Mapping[str, Any]
    places: Mapping[str, Place | tuple[Place, ...]]
    files: tuple[tuple[Place, str], ...]
    shown: tuple[tuple[Place, str], ...]
    out: Place | None


def _place(path: Path) -> Place:
    """Where a path lies, whatever system it is on."""
    drive = re.sub(r"[^A-Za-z0-9]", "", path.drive)
    return Place((drive or "root", *path.parts[1:]))


def sandbox_path(sandbox: Path, place: Place) -> Path:
    """Where a place is in a sandbox."""
    return sandbox.joinpath(*place.parts)


def pack_parcel(job: BatchJob) -> Parcel:
    """The parcel of a job: no file is read but set-ups and heads of programs. Raises InputError for a cell too large."""
    plain: dict[str, Any] = {}
    places: dict[str, Place | tuple[Place, ...]] = {}
    files: dict[Place, str] = {}
    for key, value in job.arguments.items():
        kind = job.verb.keys[key]
        if kind not in (Kind.FILE, Kind.FILES):
            plain[key] = value
            continue
        paths = value if kind is Kind.FILES else (value,)
        of_key = tuple(_place(path) for path in paths)
        places[key] = of_key if kind is Kind.FILES else of_key[0]
        if key != "out":
            found = (file for path in paths for file in _FILES.get(key, _alone)(path))
            files.update({_place(file): str(file) for file in found})
    shown = tuple((_place(path), name) for path, name in job.shown.items())
    out = None if job.out is None else _place(job.out)
    return Parcel(job.index, job.verb.name, plain, places, tuple(files.items()), shown, out)


def load_parcel(parcel: Parcel) -> dict[Place, bytes]:
    """The contents of a parcel's files. Raises OSError."""
    return {place: Path(file).read_bytes() for place, file in parcel.files}


def unpack_parcel(parcel: Parcel, sandbox: Path, contents: Mapping[Place, bytes] | None = None) -> dict[str, Any]:
    """Lay a parcel's files into a sandbox and give the job's arguments; without `contents`, they are copied."""
    for place, file in parcel.files:
        target = sandbox_path(sandbox, place)
        target.parent.mkdir(parents=True, exist_ok=True)
        if contents is None:
            shutil.copyfile(file, target)
        else:
            target.write_bytes(contents[place])
    arguments = dict(parcel.plain)
    for key, placed in parcel.places.items():
        arguments[key] = (
            sandbox_path(sandbox, placed)
            if isinstance(placed, Place)
            else tuple(sandbox_path(sandbox, place) for place in placed)
        )
    return arguments


def _alone(path: Path) -> Iterator[Path]:
    """A file and nothing else; one that isn't there is the job's to complain of."""
    if path.is_file():
        yield path


def _cell(path: Path) -> Iterator[Path]:
    """Every file of a cell's folder, links that lead out of it left aside."""
    folder = path.parent if path.is_file() else path
    if not (folder / "cell.toml").is_file() and not path.is_file():
        return
    size = 0
    for file in sorted(folder.rglob("*")):
        inside = file.relative_to(folder)
        if any(part.startswith((".", "__")) for part in inside.parts) or not file.is_file():
            continue
        if not file.resolve().is_relative_to(folder.resolve()):
            continue
        size += file.stat().st_size
        if size > MOST_BYTES:
            raise InputError("is too large for a cell's folder", hint="is another folder meant?", path=folder)
        yield file


def _setup(path: Path) -> Iterator[Path]:
    """A set-up and the files beside it that it names."""
    yield from _alone(path)
    data = _toml(path)
    bodies = [body.get("mesh") for body in (data.get("part"), data.get("stock")) if isinstance(body, dict)]
    for name in (*bodies, data.get("machine"), data.get("tool_library")):
        if (
            isinstance(name, str)
            and name.isprintable()
            and not Path(name).is_absolute()
            and ".." not in Path(name).parts
        ):
            yield from _alone(path.parent / name)


def _clfile(path: Path) -> Iterator[Path]:
    """A CL file and the set-up beside it."""
    yield from _alone(path)
    yield from _setup(path.parent / "setup.toml")


def _program(path: Path) -> Iterator[Path]:
    """A program and those files beside it whose names it, or one of them, says."""
    if not path.is_file():
        return
    beside: dict[str, list[Path]] = {}
    suffixes = language_suffixes()
    for file in path.parent.iterdir():
        if file.suffix.lower() in suffixes and file.is_file():
            beside.setdefault(file.stem.casefold(), []).append(file)
    names = {path.stem.casefold()}
    todo = [path, *beside.pop(path.stem.casefold(), [])]
    while todo:
        file = todo.pop()
        yield file
        if beside:
            words = {w.decode("ascii").casefold() for w in re.findall(rb"[A-Za-z_$]\w*", file.read_bytes())}
            for name in (words - names) & beside.keys():
                names.add(name)
                todo += beside.pop(name)


def _log(path: Path) -> Iterator[Path]:
    """A log, its facts, and the program that they name, where it lies beside."""
    yield from _alone(path)
    info = path.with_suffix(".toml")
    yield from _alone(info)
    program = _toml(info).get("program")
    if isinstance(program, str) and program.isprintable() and Path(program).name == program:
        yield from _program(path.parent / program)


def _toml(path: Path) -> dict[str, Any]:
    """A TOML file's contents, {} where it can't be read: whoever needs it says so."""
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return {}


_FILES: Mapping[str, Callable[[Path], Iterable[Path]]] = {
    "cell": _cell,
    "setup": _setup,
    "clfile": _clfile,
    "against": _clfile,
    "program": _program,
    "log": _log,
    "withheld": _log,
    "measured": _log,
}
"""What comes along with the file of a key."""
