"""Checks that the handlers of APT words share: numbers that are none, out of range, or a part program's names."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import LARGEST

__all__ = ["all_numbers", "coordinates", "in_range", "placed", "source_refusal"]

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
            if re.match(r"[A-Z(]", arg):
                raise source_refusal(s.line)
            raise ToolpathError(f"{s.word} holds {arg!r}, no number", hint="the line is damaged", line=s.line)
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
