"""Controls that read ISO 6983 as Fanuc does: Fanuc itself, Haas, Mitsubishi, Mazak, Brother and most others."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import Control, State
from camrob.toolpath.gcode.controls.fanuc_macro import INCREMENT, SUBPROGRAMS, run_macro
from camrob.toolpath.gcode.controls.fanuc_programs import wanted_programs
from camrob.toolpath.gcode.lexer import ACCURACY, Block, lex, strip_comments

__all__ = ["ISO", "check_points"]

_POINTED = re.compile(r"[XYZIJKR][ \t]*[-+]?[0-9]+\.(?![0-9])")
_UNPOINTED = re.compile(r"(?<![A-Z#\[])([XYZABCIJK])[ \t]*([-+]?[0-9]*[1-9][0-9]*)(?![0-9.\]])")
_COUNTS = re.compile(r"G0*(?:7[346]|8[1-9]|3[4-7])(?![0-9])|M0*98(?![0-9])")  # in whose blocks K counts
_COUNTED = re.compile(r"K[ \t]*[0-9]+(?![0-9.])")
_BEHIND = re.compile(r"\s*[A-Z/%][^;(]*;((?:\s*[A-Z]\s*[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))+)\s*;?\s*$")
_MOVES = re.compile(r"[XYZABCIJKR]")
_PROGRAM = re.compile(r"^[ \t]*[O:][0-9]{1,8}\b", re.M)


def _blocks(lines: list[str], path: Path, state: State) -> Iterator[Block]:
    """The blocks of a program; it is run where it computes or calls, and only read where it does not."""
    check_points(lines, path, "Fanuc's controls take it for {:g}")
    _one_block_a_line(lines, path)
    bare = "\n".join(line for line in lines if not line.lstrip().startswith((";", "(")))
    if SUBPROGRAMS.search(bare):
        return run_macro(lines, path, state)
    return lex(lines, path)


def _one_block_a_line(lines: list[str], path: Path) -> None:
    """Refuse a block behind a semicolon in a program with a number: Fanuc ends a block there, others begin a comment."""
    if not _PROGRAM.search("\n".join(lines).upper()):
        return
    for number, raw in enumerate(lines, 1):
        match = _BEHIND.match(raw.upper()) if ";" in raw else None
        if match and _MOVES.search(match[1]):
            raise ToolpathError(
                f"a block behind a semicolon ({match[1].strip()[:24]}): on Fanuc's controls it ends one, on others a comment "
                "begins there",
                hint="write each block on a line of its own, or put what is a comment in parentheses",
                path=path,
                line=number,
            )


def check_points(lines: list[str], path: Path, whose: str) -> None:
    """Refuse a coordinate without decimal point among others that end in one: Fanuc counts it in thousandths.

    A program that never ends a number in a bare point is of a control that reads 10 as ten. whose: who takes it for what.
    Raises ToolpathError.
    """
    text = "\n".join(lines).upper()
    if not (_PROGRAM.search(text) and _POINTED.search(text)):
        return
    for number, raw in enumerate(lines, 1):
        if "(" in raw or ";" in raw:
            try:
                raw = strip_comments(raw)[0]
            except ToolpathError:  # said where the line is read
                continue
        upper = ACCURACY.sub("", raw.upper())
        if "G" in upper and re.search(r"G0*(?:65|66|4|10|5|05)(?![0-9])", upper):
            continue
        match = _UNPOINTED.search(_COUNTED.sub("", upper) if _COUNTS.search(upper) else upper)
        if match:
            raise ToolpathError(
                f"{match[1]}{match[2]} has no decimal point, and other coordinates end in one: "
                + whose.format(float(match[2]) * INCREMENT),
                hint=f"write {match[1]}{match[2]}. where it is meant whole",
                path=path,
                line=number,
            )


ISO = Control(
    "iso",
    "Fanuc, Haas, Mitsubishi and others that read ISO 6983 alike",
    lambda text: 1,
    _blocks,
    plain=True,
    keeps_motion=True,
    rolls=True,
    clamps=True,
    wanted=wanted_programs,
)
