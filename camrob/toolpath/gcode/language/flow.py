"""What bounds a program that computes: its steps, its calls, and how lines are prepared for running."""

from __future__ import annotations

import re
from typing import NamedTuple

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import strip_comments

__all__ = ["DEEPEST", "MOST_STEPS", "Line", "StepCount", "prepared", "unset"]

MOST_STEPS = 100_000  # lines run: a surface by a macro has half of it
DEEPEST = 15  # calls in calls: Fanuc allows 4 + 10, LinuxCNC 10, Siemens 16
_LABEL = re.compile(r"N([0-9]+)")


class Line(NamedTuple):
    """A line as it is run: `text` upper case without blanks, comments, slash and N word; `number` counts from 1."""

    number: int
    text: str
    label: int  # of its N word, -1 without
    comment: str
    optional: bool


def prepared(raw: str, number: int) -> Line:
    """One line of a program. Raises ToolpathError for a comment without its end."""
    text, comment = strip_comments(raw)
    text = "".join(text.split()).upper()
    optional = text.startswith("/")
    if optional:
        text = re.sub(r"^/[0-9]?", "", text)
    match = _LABEL.match(text)
    label = int(match[1]) if match else -1
    return Line(number, text[match.end() :] if match else text, label, comment, optional)


class StepCount:
    """Counts the lines that a program runs, and says so where it doesn't end."""

    def __init__(self) -> None:
        self.steps = 0

    def one(self, line: int) -> None:
        """One line more. Raises ToolpathError beyond `MOST_STEPS`."""
        self.steps += 1
        if self.steps > MOST_STEPS:
            raise ToolpathError(
                f"the program has not ended after {MOST_STEPS} lines: a loop without an end, or more than is run here",
                hint="check the loop's condition, or have the path written out as plain blocks",
                line=line,
            )


def unset(name: str, given: str = "") -> ToolpathError:
    """That a variable's value is not to be had from the file, as an error to be raised; `given`: what may have set it else."""
    if given:
        return ToolpathError(
            f"{name} is read and the program has given it no value: it is what {given}, or the machine's state",
            hint=f"post the program that calls this one with both in one file, or set {name} before it is used",
        )
    return ToolpathError(
        f"{name} is read and the program has given it no value: what it holds is the machine's state",
        hint=f"set {name} in the program before it is used, or have the path written out as plain blocks",
    )
