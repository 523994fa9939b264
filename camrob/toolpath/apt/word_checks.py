"""Checks that the handlers of APT words share: numbers that are none, out of range, or a part program's names."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import LARGEST

__all__ = ["all_numbers", "coordinates", "holds_codes", "in_range", "placed", "source_refusal"]

_CODES = re.compile(r"\b[GMTS]\s*\d", re.I)
# Codes by which a machine shifts, turns, mirrors or scales all points behind them, as Fanuc's and Siemens' write them
_FRAMES = re.compile(
    r"(?<![A-Z\d])G0*(?:10|16|51(?:\.1)?|52|68(?:\.[1-4])?|92|101)(?![\d.])"
    r"|\bA?(?:TRANS|ROT|MIRROR|SCALE) *(?:[XYZ] *[-+=\d]|RPL)",
    re.I,
)
# A text that is codes and nothing else, and those among them that move the tool or switch what camrob accounts for
_BLOCK = re.compile(r"(?:[A-Z][-+]?(?:\d+\.?\d*|\.\d+)\s*)+", re.I)
_ACTS = {
    "moves the tool": r"G0*[0123](?![\d.])|[XYZABC][-+.\d]+",
    "switches the spindle": r"M0*(?:3|4|5|13|14|19)(?!\d)|S[\d.]+",
    "changes the tool": r"M0*6(?!\d)",
    "calls a subprogram": r"M0*9[78](?!\d)|G6[56](?![\d.])",
    "changes the feed": r"F[\d.]+|G9[35](?![\d.])",
    "makes steps of the points behind it": r"G91(?![\d.])",
    "offsets the path": r"G4[12](?![\d.])",
}
_OWN_AXES = re.compile(
    r"G(?:0*4|28|30|53)(?![\d.])", re.I
)  # X is a time, or the machine goes home, as camrob does by itself
_MINOR = re.compile(r"RAPID|MMPM|IPM|MMPR|IPR|INCR|ABSOL|F[-+.\d]+")  # not a name of a part program's
_NO_NUMBER = re.compile(r"[+-]?(NAN|INF|INFINITY)")


def coordinates(s: Statement, counts: tuple[int, ...]) -> list[float]:
    """The numbers of a motion statement, as many as one of `counts` (a trailing comma is let pass).

    Raises ToolpathError for a name, not-a-number, infinity, damage, or another count.
    """
    values: list[float] = []
    for arg in s.args[: len(s.args) - (len(s.args) > 1 and s.args[-1] == "")]:
        if isinstance(arg, str):
            if _NO_NUMBER.fullmatch(arg):
                raise ToolpathError(f"{s.word} holds {arg}", hint="output the path again", line=s.line)
            if _MINOR.fullmatch(arg):
                hint = "output no more than the place and the tool axis"
                raise ToolpathError(f"{s.word} holds {arg}, which is not read there", hint=hint, line=s.line)
            if re.match(r"[A-Z(]", arg):
                what = (
                    f"{s.word} holds {arg[:40]!r}, a name where a number belongs: an APT or NCL part program, or damage"
                )
                hint = "process a part program with its APT system, and give the CL file that it writes; get a CL file again"
                raise ToolpathError(what, hint=hint, line=s.line)
            hint = "the line is damaged; get the file again"
            raise ToolpathError(f"{s.word} holds {arg[:40]!r}, no number", hint=hint, line=s.line)
        values.append(arg)
    if len(values) not in counts:
        more = len(values) > max(counts)
        raise ToolpathError(
            f"{s.word} has {len(values)} numbers, not {' or '.join(map(str, counts))}",
            hint="output no more than the place and the tool axis"
            if more
            else "the line is damaged or cut off; get the file again",
            line=s.line,
        )
    return values


def all_numbers(s: Statement) -> None:
    """Refuse a statement that holds not-a-number or infinity where a number belongs."""
    for word in s.words:
        if _NO_NUMBER.fullmatch(word):
            raise ToolpathError(f"{s.word} holds {word}", hint="output the path again", line=s.line)


def holds_codes(s: Statement) -> bool:
    """Whether a text for the machine holds its codes. Raises ToolpathError for those that would move all points
    behind them, and for a block of codes that moves the tool or switches spindle, tool or feed.
    """
    found = _FRAMES.search(s.text)
    if found:
        raise ToolpathError(
            f"{s.word} hands {found[0]!r} to the machine, which shifts, turns, mirrors or scales the points behind it",
            hint="have the CAM system output the points as they are to be cut",
            line=s.line,
        )
    text = re.sub(r"\([^)]*\)|^\s*N\d+", "", s.text).strip()
    if _BLOCK.fullmatch(text) and not _OWN_AXES.search(text):
        for what, pattern in _ACTS.items():
            if act := re.search(pattern, text, re.I):
                raise ToolpathError(
                    f"{s.word} hands {act[0]!r} to the machine, which {what}, and is not done",
                    hint="have the CAM system say it in APT words (GOTO, SPINDL, LOADTL, FEDRAT), or delete the line",
                    line=s.line,
                )
    return _CODES.search(s.text) is not None


def in_range(numbers: list[float]) -> None:
    """Refuse numbers that no machine has use for, and infinity."""
    for value in numbers:
        if not abs(value) <= LARGEST:
            raise ToolpathError(f"the number {value:g} is out of range", hint="the line is damaged; get the file again")


def placed(error: ToolpathError, line: int) -> ToolpathError:
    """The same error with its line, where it had none."""
    return ToolpathError(error.what, hint=error.hint, path=error.path, line=error.line or line)


def source_refusal(line: int) -> ToolpathError:
    """The refusal of a part program."""
    return ToolpathError(
        "this is an APT or NCL part program (source with names and geometry), not cutter data",
        hint="process it with its APT system and give camrob the CL file that it writes",
        line=line,
    )
