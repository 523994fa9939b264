"""The routines of a KRL file, each a tree of statements, blocks and rows, and the data lists beside them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from camrob.errors import KrlError
from camrob.witness.krl.text import Line, Source, read_source
from camrob.witness.krl.values import split_top

__all__ = ["Block", "Module", "Node", "Routine", "Rows", "beside", "data_lines", "read_module"]

_HEAD = re.compile(
    r"(?:GLOBAL )?(?:DEF|DEFFCT (?P<type>[A-Z0-9_\[\]]+)) (?P<name>[A-Z_$][A-Z0-9_$]*) ?\((?P<inputs>.*)\)"
)
_WORD = re.compile(r"[A-Z_$][A-Z0-9_$]*")
_OPENS = re.compile(r"(IF|WHILE|SWITCH)\b(?!\$| ?[=.\[])|(FOR|REPEAT|LOOP|SPLINE)\b(?!\$| ?[=.\[(])")
_ENDS = {"IF": "ENDIF", "FOR": "ENDFOR", "WHILE": "ENDWHILE", "REPEAT": "UNTIL", "LOOP": "ENDLOOP"}
_ENDS |= {"SWITCH": "ENDSWITCH", "SPLINE": "ENDSPLINE"}
_PARTS = {"IF": ("ELSE",), "SWITCH": ("CASE", "DEFAULT")}
_DEEP = 40  # blocks in blocks; no honest program nests deeper


@dataclass(frozen=True, slots=True)
class Rows:
    """A stretch of lines that were read as columns: lines first to last of the source."""

    first: int
    last: int


@dataclass(slots=True)
class Block:
    """IF, FOR and the like: `parts` from the line that begins each part (the block's own first) to its nodes."""

    kind: str
    head: Line
    parts: list[tuple[Line, list[Node]]]
    tail: Line


Node = Line | Rows | Block


@dataclass(slots=True)
class Routine:
    """A DEF, or a DEFFCT that returns a value of a type, `kind`: `inputs` are its parameters' names, True where they hand a
    value back.
    """

    name: str
    kind: str
    inputs: list[tuple[str, bool]]
    source: Source
    head: Line
    nodes: list[Node] = field(default_factory=list)
    last: int = 0


@dataclass(slots=True)
class Module:
    """A .src file: its routines by name, the first of them the one that carries its name, and lines outside any routine."""

    source: Source
    routines: dict[str, Routine]
    outside: list[Line]
    data: list[Line]  # statements of the .dat beside it
    data_path: Path | None


def beside(folder: Path, name: str) -> Path | None:
    """The file of this name in a folder, capitals or not; None where there is none."""
    try:
        return next((item for item in sorted(folder.iterdir()) if item.name.upper() == name.upper()), None)
    except OSError:
        return None


def _sequence(source: Source) -> Iterator[Line | Rows]:
    """Statements and stretches of rows, in order."""
    rows = np.sort(np.concatenate([source.row_line, source.speed_line]))
    ends = np.searchsorted(rows, [line.number for line in source.lines]).tolist()
    at = 0
    for line, end in zip(source.lines, ends, strict=True):
        if end > at:
            yield Rows(int(rows[at]), int(rows[end - 1]))
            at = end
        yield line
    if at < len(rows):
        yield Rows(int(rows[at]), int(rows[-1]))


class _Builder:
    """Puts statements into routines and blocks; raises KrlError where they do not close."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.routines: dict[str, Routine] = {}
        self.outside: list[Line] = []
        self.routine: Routine | None = None
        self.open: list[Block] = []

    def wrong(self, line: int, what: str, hint: str) -> KrlError:
        return KrlError(what, hint=hint, path=self.source.path, line=line)

    def add(self, node: Node) -> None:
        if self.open:
            self.open[-1].parts[-1][1].append(node)
        elif self.routine is not None:
            self.routine.nodes.append(node)
        elif isinstance(node, Line):
            self.outside.append(node)
        elif isinstance(node, Rows):
            self.outside.append(Line(node.first, "motions", "", "motions"))

    def begin(self, line: Line, match: re.Match[str]) -> None:
        if self.routine is not None:
            raise self.wrong(line.number, f"{match['name']} begins before {self.routine.name} has ended", "write END")
        inputs = []
        for text in split_top(match["inputs"]) if match["inputs"].strip() else []:
            name, _, way = text.replace(" ", "").partition(":")
            inputs.append((name.split("[")[0], way != "IN"))
        self.routine = Routine(match["name"], match["type"] or "", inputs, self.source, line)

    def end(self, line: Line) -> None:
        if self.open:
            raise self.wrong(
                self.open[-1].head.number, f"{self.open[-1].kind} has no {_ENDS[self.open[-1].kind]}", "write it"
            )
        if self.routine is not None:
            self.routine.last = line.number
            self.routines.setdefault(self.routine.name, self.routine)
            self.routine = None

    def take(self, line: Line) -> None:
        """One statement."""
        word = begin[0] if (begin := _WORD.match(line.code)) else ""
        match = _HEAD.fullmatch(line.code) if word in ("DEF", "DEFFCT", "GLOBAL") else None
        if match is not None:
            self.begin(line, match)
        elif word in ("END", "ENDFCT"):
            self.end(line)
        elif self.open and word == _ENDS[self.open[-1].kind]:
            block = self.open.pop()
            block.tail = line
            self.add(block)
        elif self.open and word in _PARTS.get(self.open[-1].kind, ()):
            self.open[-1].parts.append((line, []))
        elif word in _ENDS.values():
            raise self.wrong(line.number, f"{word} closes nothing", "remove it, or open its block")
        elif opens := _OPENS.match(line.code):
            if len(self.open) >= _DEEP:
                raise self.wrong(line.number, "blocks nest too deep", f"use {_DEEP} levels at most")
            self.open.append(Block(opens[1] or opens[2], line, [(line, [])], line))
        else:
            self.add(line)


def data_lines(path: Path) -> list[Line]:
    """The lines of a data list, DEFDAT and ENDDAT among them. Raises KrlError where it can't be read."""
    source = read_source(path)
    odd = [Line(source.odd, "CONTROL CHARACTER", "", "a control character")] if source.odd else []
    return odd + source.lines


def read_module(path: Path) -> Module:
    """Reads a .src file and the .dat beside it. Raises KrlError where one can't be read or its blocks don't close."""
    source = read_source(path)
    builder = _Builder(source)
    for item in _sequence(source):
        if isinstance(item, Rows):
            builder.add(item)
        else:
            builder.take(item)
    if builder.routine is not None:
        raise builder.wrong(source.count, f"{builder.routine.name} has no END", "the file may have been cut off")
    if not builder.routines:
        raise KrlError("holds no DEF: it is not a KRL program", hint="name a KRL .src file", path=path)
    data_path = beside(path.parent, path.stem + ".dat")
    data = data_lines(data_path) if data_path is not None else []
    return Module(source, builder.routines, builder.outside, data, data_path)
