"""KRL files as they lie on disk: routines, blocks, data lists."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from camrob.errors import KrlError
from camrob.languages.krl.reader.line_scan import Scan, scan_lines
from camrob.languages.krl.reader.tokens import shown, statement_of

__all__ = ["Block", "Module", "Routine", "load_module", "no_program_of_its_own", "read_bytes"]

_DEF = re.compile(
    r"(?:GLOBAL\s+)?(DEF|DEFFCT)\s+(?:[$A-Za-z_]\w*(?:\s*\[[\s,]*\])?\s+)?([$A-Za-z_]\w*)\s*(?:\((.*)\))?\s*",
    re.I | re.ASCII,
)
_OPENERS = {
    "FOR": "ENDFOR",
    "IF": "ENDIF",
    "WHILE": "ENDWHILE",
    "LOOP": "ENDLOOP",
    "REPEAT": "UNTIL",
    "SWITCH": "ENDSWITCH",
    "SPLINE": "ENDSPLINE",
    "PTP_SPLINE": "ENDSPLINE",
}
_CLOSERS = frozenset(_OPENERS.values())


@dataclass(frozen=True, slots=True)
class Block:
    """Lines of a control structure, from 0: its first word, ELSE (-1 for none), and its last word."""

    start: int
    middle: int
    end: int


@dataclass(frozen=True, slots=True)
class Routine:
    """A DEF or DEFFCT: lines `start` to `end` (exclusive) are its body; names of its parameters, those handed back, those
    of which that isn't said.
    """

    name: str
    start: int
    end: int
    parameters: tuple[str, ...]
    outputs: frozenset[str]
    unsaid: frozenset[str]


@contextmanager
def no_program_of_its_own(routine: Routine) -> Iterator[None]:
    """Of a main routine that is handed values and can't be read without them, say that. Raises KrlError."""
    try:
        yield
    except KrlError as error:
        if not routine.parameters:
            raise
        handed = ", ".join(routine.parameters[:3])
        raise KrlError(
            f"{shown(routine.name)} is handed {shown(handed)}: a routine of another program's ({error.what})",
            hint="give the program that calls it",
            path=error.path,
            line=error.line,
        ) from None


@dataclass(frozen=True, slots=True)
class Module:
    """A .src file: its index among the program's files, its statements by line (from 0), its routines in order."""

    path: Path
    index: int
    scan: Scan
    statements: Mapping[int, str]
    routines: Mapping[str, Routine]
    blocks: Mapping[int, Block]

    @property
    def main(self) -> Routine:
        """The routine that stands first."""
        return next(iter(self.routines.values()))


def read_bytes(path: Path) -> bytes:
    """A file's bytes, line ends as LF. Raises KrlError where it can't be read or is no text."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise KrlError(f"can't be read: {error.strerror}", hint="check the path", path=path) from error
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise KrlError("this is a binary file", hint="name a KRL .src file", path=path, line=line)
    # A lone CR ends a line too, so that no statement hides behind one in a comment.
    returns = data.count(b"\r")
    return data if returns == data.count(b"\r\n") else data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def load_module(path: Path, index: int) -> Module:
    """Reads a .src file. Raises KrlError for one that is no KRL, is cut off, or has statements outside of routines."""
    data = read_bytes(path)
    scan = scan_lines(data)
    starts = scan.starts
    statements: dict[int, str] = {}
    for line in scan.general.tolist():
        text = statement_of(data[starts[line] : starts[line + 1]].decode("latin-1"))
        if text and not text.startswith("&"):
            statements[line] = text
    routines = _routines(path, statements)
    if not routines:
        raise KrlError("holds no DEF", hint="name a KRL .src file", path=path)
    _check_outside(path, scan, statements, routines)
    return Module(path, index, scan, statements, routines, _blocks(path, statements, routines))


def _word(text: str) -> str:
    """The first word of a statement, upper case."""
    found = re.match(r"[$A-Za-z_][\w$]*", text)
    return found[0].upper() if found else ""


def _routines(path: Path, statements: Mapping[int, str]) -> dict[str, Routine]:
    """Routines of a file, by name in upper case, in their order."""
    routines: dict[str, Routine] = {}
    open_at: tuple[int, str, str] | None = None
    for line, text in statements.items():
        word = _word(text)
        found = _DEF.fullmatch(text) if word in ("DEF", "DEFFCT", "GLOBAL") else None
        if found is not None:
            if open_at is not None:
                raise KrlError(
                    f"DEF {shown(open_at[1])} has no END", hint="the file is damaged", path=path, line=open_at[0] + 1
                )
            open_at = (line, found[2].upper(), found[3] or "")
        elif word in ("DEF", "DEFFCT"):
            raise KrlError(f"{shown(text)!r} is not a DEF line", hint="write DEF NAME ( )", path=path, line=line + 1)
        elif word in ("END", "ENDFCT") and text.upper() == word:
            if open_at is None:
                raise KrlError(f"{word} without a DEF before it", hint="the file is damaged", path=path, line=line + 1)
            start, name, parameters = open_at
            if name in routines:
                raise KrlError(f"{shown(name)} is defined twice", hint="rename one", path=path, line=start + 1)
            pairs = [p.partition(":") for p in parameters.split(",") if p.strip()]
            names = tuple(p[0].strip().upper().removesuffix("[]") for p in pairs)
            outputs = frozenset(n for n, p in zip(names, pairs, strict=True) if p[2].strip().upper() == "OUT")
            unsaid = frozenset(
                n for n, p in zip(names, pairs, strict=True) if p[2].strip().upper() not in ("IN", "OUT")
            )
            routines[name] = Routine(name, start + 1, line, names, outputs, unsaid)
            open_at = None
    if open_at is not None:
        raise KrlError(
            f"DEF {shown(open_at[1])} has no END", hint="the file is cut off", path=path, line=open_at[0] + 1
        )
    return routines


def _check_outside(path: Path, scan: Scan, statements: Mapping[int, str], routines: Mapping[str, Routine]) -> None:
    """Raises KrlError for a statement that stands in no routine."""
    spans = sorted((r.start - 1, r.end) for r in routines.values())
    gaps = zip([-1, *(end for _, end in spans)], [*(start for start, _ in spans), len(scan.starts)], strict=True)
    for before, after in gaps:
        inside = scan.lin_line.searchsorted([before + 1, after])
        if inside[0] < inside[1]:
            line = int(scan.lin_line[inside[0]])
            raise KrlError("a LIN outside of DEF and END", hint="the file is damaged", path=path, line=line + 1)
        for line in scan.general[slice(*scan.general.searchsorted([before + 1, after]))].tolist():
            if line in statements:
                what = f"{shown(statements[line])!r} stands outside of DEF and END"
                raise KrlError(what, hint="is this a KRL .src file?", path=path, line=line + 1)


def _blocks(path: Path, statements: Mapping[int, str], routines: Mapping[str, Routine]) -> dict[int, Block]:
    """Control structures by their first line."""
    blocks: dict[int, Block] = {}
    stack: list[tuple[int, str, int]] = []
    ends = {r.end for r in routines.values()}
    for line, text in statements.items():
        word = _word(text)
        if word in _OPENERS and not re.match(r"\w+\s*=", text):
            stack.append((line, word, -1))
        elif word == "ELSE" and stack and stack[-1][1] == "IF":
            stack[-1] = (stack[-1][0], "IF", line)
        elif word in _CLOSERS:
            if not stack or _OPENERS[stack[-1][1]] != word:
                raise KrlError(f"{word} without its beginning", hint="the file is damaged", path=path, line=line + 1)
            start, _, middle = stack.pop()
            blocks[start] = Block(start, middle, line)
        if line in ends and stack:
            raise KrlError(f"{stack[-1][1]} has no end", hint="the file is damaged", path=path, line=stack[-1][0] + 1)
    return blocks
