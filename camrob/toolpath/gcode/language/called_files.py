"""Programs that a program calls and that lie in files of their own beside it: appended to it, as its user would do by hand."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import decode

__all__ = ["Beside", "Wanted", "calls", "with_called"]

_MOST_FILES = 100  # a main program of a large mould calls some ten
_LARGEST_BYTES = 1 << 26  # of one of them
_MOST_BESIDE = 10_000  # files in the folder that are looked at
_TAPE = re.compile(r"\s*%[ \t]*\Z")


class Wanted(NamedTuple):
    """A program that is called. name: as people say it; stems: of the files that it may lie in, lower case, without suffix.

    suffixes: theirs, lower case; head: the line that names the program; named: whether a line is such a head of any program.
    """

    name: str
    stems: frozenset[str]
    suffixes: frozenset[str]
    head: str
    named: re.Pattern[str]


class Beside(NamedTuple):
    """The lines of a program and of all that it calls. files: what was appended, and its first line, counting from 1."""

    lines: list[str]
    files: tuple[tuple[str, int], ...]
    sha256: str

    def place(self, error: ToolpathError) -> ToolpathError:
        """The error with the file and line that it belongs to."""
        own = next(((name, first) for name, first in reversed(self.files) if error.line >= first), None)
        if own is None or error.path is None:
            return error
        line = error.line - own[1] + 1
        return ToolpathError(error.what, hint=error.hint, path=error.path.parent / own[0], line=max(line, 1))


def calls(pattern: re.Pattern[str], lines: Iterable[str]) -> list[str]:
    """What the first group of a pattern finds in lines without their comments, each once, in order, upper case."""
    found: dict[str, None] = {}
    for raw in lines:
        bare = re.sub(r"\([^()]*\)|;.*", " ", raw).upper()
        found.update(dict.fromkeys(match for match in pattern.findall(bare)))
    return list(found)


def with_called(lines: list[str], data: bytes, path: Path, wanted: Callable[[list[str]], list[Wanted]]) -> Beside:
    """A program and, behind it, the programs that it calls and doesn't hold, where they lie beside `path`.

    `wanted` says which of a text's calls lead out of it. A program that isn't found is left to the control's own words. The
    digest is of all files' bytes. Raises ToolpathError where two files may be one program, and for one that can't be read.
    """
    digest, files, found = hashlib.sha256(data), list[tuple[str, int]](), list(lines)
    folder: dict[str, list[Path]] | None = None
    looked: set[str] = set()
    while True:
        missing = [want for want in wanted(found) if want.name not in looked]
        if not missing:
            return Beside(found, tuple(files), digest.hexdigest())
        looked |= {want.name for want in missing}
        if folder is None:
            folder = _folder(path)
        for want in missing:
            file = _file(want, folder, path)
            if file is None:
                continue
            if len(files) >= _MOST_FILES:
                raise ToolpathError(
                    f"more than {_MOST_FILES} programs in files of their own are called",
                    hint="have the path written out as plain blocks",
                    path=path,
                )
            body = file.read_bytes()
            digest.update(body)
            files.append((file.name, len(found) + 2))
            found += [want.head, *_body(file, body, want)]


def _folder(path: Path) -> dict[str, list[Path]]:
    """The files beside a program by their stems, lower case; none where it lies nowhere."""
    files: dict[str, list[Path]] = {}
    try:
        for k, file in enumerate(path.parent.iterdir()):
            if k >= _MOST_BESIDE:
                break
            if file.name != path.name and file.is_file():
                files.setdefault(file.stem.lower(), []).append(file)
    except OSError:
        return {}
    return files


def _file(want: Wanted, folder: dict[str, list[Path]], path: Path) -> Path | None:
    """The file that a wanted program lies in, None where there is none. Raises ToolpathError where it is one of several."""
    found = [
        file
        for stem in sorted(want.stems & folder.keys())
        for file in sorted(folder[stem])
        if file.suffix.lower() in want.suffixes
    ]
    if len(found) > 1:
        names = " and ".join(file.name for file in found[:3])
        raise ToolpathError(
            f"{want.name} is called, and {names} beside the program may both be it",
            hint="leave one of them there, or append it to the program",
            path=path,
        )
    if found and found[0].stat().st_size > _LARGEST_BYTES:
        raise ToolpathError(f"{found[0].name}, which is called, has more than 64 MiB", hint="split it", path=path)
    return found[0] if found else None


def _body(file: Path, body: bytes, want: Wanted) -> list[str]:
    """A file's lines without its head and the marks of a tape. Raises ToolpathError where it holds another program."""
    lines = decode(body, file)
    heads = {k: match[1] for k, line in enumerate(lines) if (match := want.named.match(line.upper()))}
    kept = ["" if _TAPE.match(line) or k in heads else line for k, line in enumerate(lines)]
    own = want.named.match(want.head)
    if heads and (own is None or list(heads.values()) != [own[1]]):
        raise ToolpathError(
            f"the file of {want.name}, which is called, holds another program",
            hint="append the program that is called to the one that calls it",
            path=file,
            line=min(heads) + 1,
        )
    return kept
