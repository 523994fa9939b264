"""What tells one CAM system's CL text from another's: a few facts and the reading of its cycles."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from camrob.toolpath.apt.cycles import Cycle
from camrob.toolpath.apt.lexer import Statement

__all__ = ["Dialect", "message", "score"]


@dataclass(frozen=True, slots=True)
class Dialect:
    """One dialect over the shared APT grammar.

    `recognise` gives a score for the file's beginning (0: not this one). `cycle` reads a CYCLE statement that opens
    a cycle. `pprint` turns operator text into ("operation", name), ("message", text) or None to drop it. `words` are the
    dialect's own, or mean something else in it than elsewhere: each is given the `Machine` of `apt/state.py` (which imports
    this module) and the statement, and raises ToolpathError where it can't be read honestly.
    """

    name: str
    recognise: Callable[[str], int]
    cycle: Callable[[Statement], Cycle]
    pprint: Callable[[str], tuple[str, str] | None]
    left_handed_arcs: bool | None = False  # the printed axis of CIRCLE is reversed; None: as its form says
    on: str = ""  # CYCLE/ON: "values" names new ones of the cycle before it, "heading" may stand before the first cycle
    msys: bool = False  # MSYS: the following points are in that frame
    csys_sets_axis: bool = False  # the third column of CSYS is the tool axis until a GOTO names another
    table_radians: bool = False  # ROTABL is in radians, and points are in the frame of the turned part
    cutter_is_tool: bool = False  # there is no LOAD: another CUTTER means another tool
    insert_names_tool: bool = False  # INSERT before CUTTER holds the tool's name
    contour_behind_cutcom: bool = False  # CUTCOM means that the points are the part's contour ("in control")
    must_end: bool = False  # the system always writes FINI: a file without it was cut off
    words: Mapping[str, Callable[[Any, Statement], None]] = field(default_factory=dict)


def score(head: str, weights: Mapping[str, int]) -> int:
    """Sum of the weights of the patterns (regular expressions, line by line, capitals or not) that occur in `head`."""
    return sum(weight for pattern, weight in weights.items() if re.search(pattern, head, re.M | re.I))


def message(text: str) -> tuple[str, str] | None:
    """Operator text as it is."""
    return ("message", text)
