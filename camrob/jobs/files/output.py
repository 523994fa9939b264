"""Output files that appear whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

from camrob.errors import InputError, VerificationError
from camrob.jobs.exit_status import disk_full
from camrob.jobs.files.summary_file import said_in
from camrob.languages import language_suffixes, program_suffixes

__all__ = [
    "check_calibration_name",
    "check_file_name",
    "check_folder",
    "demand_apart",
    "demand_own_name",
    "staged_output",
]

_STAGING = ".camrob-unfinished-"
_RESERVED = {"CON", "PRN", "AUX", "NUL", *(f"{port}{n}" for port in ("COM", "LPT") for n in range(1, 10))}
_SHOWN = 60  # of one that is refused
_LONGEST = 200  # characters of a file's name: what every file system takes, with room for a suffix


def check_file_name(name: str) -> str:
    """The name itself, where it is good as a file's name on any system. Raises InputError where it isn't."""
    if not name or len(name) > _LONGEST or not name.isprintable() or re.search(r'[/\\:*?"<>|]', name):
        long = f", {len(name):,} characters long," if len(name) > _LONGEST else ""
        raise InputError(f"{name[:_SHOWN]!r}{long} can't be a file's name", hint="use letters, digits, - and _")
    if name[0] in ".-" or name[-1] in ". " or name.partition(".")[0].upper() in _RESERVED:
        raise InputError(f"{name!r} can't be a file's name", hint="use letters, digits, - and _, a letter first")
    return name


def check_calibration_name(out: Path) -> None:
    """Raise InputError where a path can't be CALIBRATION.toml's."""
    if out.suffix.lower() != ".toml":
        raise InputError(f"{out.name!r} is not a .toml", hint="name the file CALIBRATION.toml", path=out)
    check_file_name(out.name)


def demand_own_name(out: Path, name: str, clfile: Path) -> None:
    """Raise InputError where program NAME of a CL file of another name lies in `out`: a controller's names are short, and two
    long ones, or two that differ in what no name may hold, become one.
    """
    manifest = said_in(out / f"{name}.json").get("manifest")
    made_of = manifest.get("cl_file") if isinstance(manifest, Mapping) else None
    files = made_of if isinstance(made_of, Mapping) else ()
    others = [file for file in files if file.partition(".")[0] != clfile.name.partition(".")[0]]
    if others:
        what = f"{name} there is the program of {others[0][:_SHOWN]}, and {clfile.name[:_SHOWN]} comes to the same name"
        raise InputError(what, hint="name this one (--name), or choose another --out", path=out)


def demand_apart(names: Sequence[str]) -> None:
    """Raise VerificationError where two programs of a job have a file of one name: the later one would lie there for both."""
    twice = next((name for k, name in enumerate(names) if name.lower() in {other.lower() for other in names[:k]}), None)
    if twice is not None:
        what = f"two of the job's programs are written into {twice}; name it (--name) or its clampings otherwise"
        raise VerificationError(f"the program was not released: {what}")


@contextmanager
def staged_output(out: Path, *, name: str | None = None) -> Iterator[Path]:
    """A folder to write into; its files move into `out` together when the block ends well.

    Until then, and for good when the block raises or is interrupted, `out` holds what it held before (and isn't made,
    where it wasn't there). Files of the same names are replaced; should that fail half-way, the old ones are put back.
    Programs come last, that of the name as the very last, so that a program never runs with another one's data. With
    `name`, files that the older `NAME.json` lists under "files" and that are no longer made (parts of a longer program)
    are removed; a file of another program's there is no part of this one, whatever its name. Two runs into one folder publish
    one after the other, each as a whole; what a run that was killed left behind is cleared by the next one.

    Raises InputError when `out` can't be made, written or has vanished, and where another program there has a file of a name that
    this one needs.
    """
    out = Path(out)
    made = _make_folder(out)
    staging: Path | None = None
    owned: int | None = None
    try:
        try:
            turn = _lock(out, wait=True)  # nobody clears the new folder away before it is locked
            try:
                _clear_abandoned(out)
                staging = Path(tempfile.mkdtemp(prefix=_STAGING, dir=out))
                owned = _lock(staging, wait=False)
            finally:
                _unlock(turn)
        except OSError as error:
            raise _failed(out, error) from None
        try:
            yield staging
        except OSError as error:
            about = [name for name in (error.filename, error.filename2) if name is not None]
            if (disk_full(error) and not about) or any(
                Path(os.fsdecode(name)).is_relative_to(staging) for name in about
            ):
                raise _failed(out, error) from None
            raise
        try:
            turn = _lock(out, wait=True)
            try:
                _publish(staging, out, name)
            finally:
                _unlock(turn)
        except OSError as error:
            raise _failed(out, error) from None
    except BaseException:
        if staging is not None:
            shutil.rmtree(staging, ignore_errors=True)
        for folder in made:
            with suppress(OSError):  # not empty any more: somebody else's files are in it
                folder.rmdir()
        raise
    finally:
        _unlock(owned)
    shutil.rmtree(staging, ignore_errors=True)


def _lock(folder: Path, *, wait: bool) -> int | None:
    """A lock on a folder, which ends with this process at the latest; None where there is none to be had.

    Raises BlockingIOError where another process holds it and `wait` is False. Systems without flock do without locks.
    """
    try:
        flock = import_module("fcntl")
    except ImportError:
        return None
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        flock.flock(descriptor, flock.LOCK_EX | (0 if wait else flock.LOCK_NB))
    except BlockingIOError:
        os.close(descriptor)
        raise
    except OSError:  # a file system that knows no locks
        os.close(descriptor)
        return None
    return descriptor


def _unlock(descriptor: int | None) -> None:
    if descriptor is not None:
        os.close(descriptor)


def _clear_abandoned(out: Path) -> None:
    """Remove what runs that were killed left in `out`; one that was killed while it replaced files keeps the old ones."""
    for folder in out.glob(f"{_STAGING}*"):
        before = folder / "before"
        try:
            lock = _lock(folder, wait=False)
        except OSError:  # somebody is at work in it, or it has just gone
            continue
        if lock is not None:
            if not (before.is_dir() and any(before.iterdir())):
                shutil.rmtree(folder, ignore_errors=True)
            _unlock(lock)


def _failed(out: Path, error: OSError) -> InputError:
    """The error of a folder that can't be written."""
    if disk_full(error):
        hint = "free some space there and where temporary files are kept, or choose another --out"
        return InputError(f"can't be written: disk full ({error.strerror})", hint=hint, path=out)
    if not out.exists():
        return InputError("the folder vanished while it was being written", hint="run the command again", path=out)
    return InputError(
        f"can't be written ({error.strerror or error})",
        hint="check the folder and its permissions",
        path=out,
    )


def check_folder(out: Path) -> None:
    """Refuse, before any work, a file where a folder is to be written. Raises InputError."""
    if out.exists() and not out.is_dir():
        raise InputError("is a file, not a folder", hint="choose another --out", path=out)


def _make_folder(out: Path) -> list[Path]:
    """Make a folder and those above it; gives those that were made, the innermost first."""
    missing: list[Path] = []
    folder = out
    while not folder.exists() and folder != folder.parent:
        missing.append(folder)
        folder = folder.parent
    try:
        out.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError("is a file, not a folder", hint="choose another --out", path=out) from None
    except OSError as error:
        if disk_full(error):
            raise _failed(out, error) from None
        raise InputError(f"can't be made ({error.strerror})", hint="choose another --out", path=out) from None
    return missing


def _publish(staging: Path, out: Path, name: str | None) -> None:
    """Move every file of the staging folder into `out`, all or none."""
    files = sorted((f for f in staging.iterdir() if f.is_file()), key=lambda f: _turn(f.name, name))
    for file in files:
        check_file_name(file.name)
        _to_disk(file)
    names = {f.name for f in files}
    if name is not None:
        _demand_own(out, name, names)
    obsolete = _obsolete(out, name, names)
    backup = staging / "before"
    backup.mkdir()
    moved_away: list[str] = []
    moved_in: list[str] = []
    try:
        for old in (*(f.name for f in reversed(files)), *obsolete):
            if (out / old).is_file() or (out / old).is_symlink():
                moved_away.append(old)
                os.rename(out / old, backup / old)
        for file in files:
            moved_in.append(file.name)
            os.rename(file, out / file.name)
    except BaseException:
        for new in moved_in:
            with suppress(OSError):
                (out / new).unlink()
        for old in moved_away:
            with suppress(OSError):
                os.replace(backup / old, out / old)
        raise
    _to_disk(out)


def _turn(file: str, name: str | None) -> tuple[int, str]:
    """Where in the order of publication a file stands: what says how to read another (LOG.toml) is there before it."""
    suffixes = program_suffixes()
    if name is not None and file in {f"{name}{suffix}" for suffix in suffixes}:
        return 2, file
    return int(file.endswith(suffixes)) - int(file.endswith(".toml")), file


def _to_disk(path: Path) -> None:
    """Make sure that a file or folder survives a power cut; file systems that can't promise it are left alone."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        with suppress(OSError):
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _listed(summary: Path) -> list[str]:
    """The files that a NAME.json lists; none where it isn't there, or isn't ours."""
    listed = said_in(summary).get("files")
    return [file for file in listed if isinstance(file, str)] if isinstance(listed, list) else []


def _demand_own(out: Path, name: str, new: set[str]) -> None:
    """Raise InputError where a program file in `out` bears a new one's name, and another program's NAME.json lists it, or
    nobody's does and it would stay: a controller sees neither capitals nor who made what, and takes any data list of a
    program's name for its own.
    """
    suffixes = {Path(file).suffix for file in new} & set(language_suffixes())
    stems = {Path(file).stem.lower() for file in new if Path(file).suffix in suffixes}
    mine = _listed(out / f"{name}.json")
    for file in sorted(out.iterdir()):
        if file.name in mine or file.suffix.lower() not in suffixes or file.stem.lower() not in stems:
            continue
        others = (summary for summary in sorted(out.glob("*.json")) if summary.stem != name)
        owner = next((summary.stem for summary in others if file.name in _listed(summary)), "")
        if owner:
            what = f"{file.name} there is a file of program {owner}, and {name} needs one of that name"
            raise InputError(what, hint="give it another name (--name) or another --out", path=out)
        if file.name not in new:
            what = f"{file.name} there would be taken for a file of {name}, which didn't make it"
            raise InputError(what, hint="move it away, or choose another --out", path=out)


def _obsolete(out: Path, name: str | None, new: set[str]) -> list[str]:
    """Files that the older NAME.json lists, that bear the program's name, and that aren't made again."""
    if name is None:
        return []
    mine = [file for file in _listed(out / f"{name}.json") if file not in new and _bears(file, name)]
    return [file for file in dict.fromkeys(mine) if (out / file).is_file()]


def _bears(file: str, name: str) -> bool:
    """Whether a file is NAME.* or a numbered part of it; a list in a file may say anything."""
    program = "|".join(re.escape(suffix[1:]) for suffix in language_suffixes())
    if re.fullmatch(rf"{re.escape(name)}(\.path)?\.({program}|json|npz|html|sha256)", file):
        return True
    part = re.fullmatch(rf"(\w+?)P?_\d{{3,}}\.({program})", file, re.ASCII)
    # a controller's names may be short: a long program's parts bear only the beginning of its name
    return part is not None and name.startswith(part[1]) and len(part[1]) >= min(len(name), 12)
