"""Heidenhain's cycles of before the TNC 426: 1 (pecking), 2 and 17 (taps), a line for each value (TNC 407/415, "Fixed cycles").

They name no surface: a hole begins where the tool stands, which is to be the set-up clearance above it.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_words import VALUE

__all__ = ["BACK", "OLD_CYCLES", "OldCycle"]

OLD_CYCLES = {
    1: ("set-up clearance", "depth", "pecking depth", "dwell", "feed"),
    2: ("set-up clearance", "depth", "dwell", "feed"),
    17: ("set-up clearance", "depth", "pitch"),
}
"""What the lines 1.1, 1.2, ... of each give."""
BACK = -1
"""Beside the Q numbers of a newer cycle: how far above the last bite a rapid back into the hole ends."""
_LINE = re.compile(rf"[^-+0-9Q]*({VALUE})")
# mm: the advanced stop is _STOP, of holes deeper than _SHALLOW a part, _MOST at most
_SHALLOW, _STOP, _PART, _MOST = 30.0, 0.6, 50.0, 7.0


class OldCycle:
    """The values of one, line by line."""

    def __init__(self, number: int) -> None:
        self.number = number
        self._said: dict[str, float] = {}

    def say(self, line: int, text: str, worth: Callable[[str], float]) -> None:
        """Line 1.1, 1.2, ... of its definition. Raises ToolpathError for one that it doesn't have, or without a number."""
        names, match = OLD_CYCLES[self.number], _LINE.fullmatch(text.strip())
        if match is None or not 1 <= line <= len(names):
            raise ToolpathError(
                f"CYCL DEF {self.number}.{line} {text[:24]} is not read", hint="check the cycle's lines"
            )
        self._said[names[line - 1]] = worth(match[1])

    def twin(self, start: float, mm: float) -> tuple[int, dict[int, float]]:
        """The newer cycle that makes the same hole from height `start`, and its Q; `mm` is one of the program's unit.

        Raises ToolpathError for values left out, and for a depth upwards.
        """
        missing = [name for name in OLD_CYCLES[self.number] if name not in self._said]
        if missing:
            raise ToolpathError(f"cycle {self.number} without its {missing[0]}", hint="name all its values")
        said = self._said
        above, depth = abs(said["set-up clearance"]), said["depth"]
        if depth >= 0.0:
            raise ToolpathError(f"cycle {self.number} with a depth that makes no hole", hint="a depth below zero")
        q = {200: above, 201: depth, 203: start - above, 204: above, 211: said.get("dwell", 0.0)}
        if self.number == 1:
            stop = _STOP if -depth * mm <= _SHALLOW else min(-depth * mm / _PART, _MOST)
            return 200, {**q, 202: abs(said["pecking depth"]), 206: said["feed"], BACK: stop / mm}
        return (206, {**q, 206: said["feed"]}) if self.number == 2 else (207, {**q, 239: said["pitch"]})

    def placed(self, said: dict[int, float], mm: float) -> tuple[int, dict[int, float]]:
        """The same below the surface Q203 and from the clearance Q200 that cycle 220 or 221 names.

        Raises ToolpathError where that clearance is another one than its own.
        """
        number, q = self.twin(said[203] + said[200], mm)
        if abs(q[200] - said[200]) * mm > 1e-6:  # mm
            raise ToolpathError(
                f"cycle {self.number} at places by another set-up clearance than its own", hint="name the same in both"
            )
        return number, q | {204: said[204]}
