"""Heidenhain's cycles 1, 2 and 17, whose heights count from where the tool stands (TNC 407/415, "Fixed cycles")."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from camrob.witness.cl.foreign.foreign_cycles import Hole
from camrob.witness.cl.foreign.foreign_words import UnreadError

__all__ = ["OldValues"]

_LINES = {"1": 5, "2": 4, "17": 3}  # so many values has each
_SAME = 1e-9  # m


class OldValues:
    """The lines 1.1, 1.2, ... of one: clearance, depth, then bite, dwell and feed, or dwell and feed, or pitch."""

    def __init__(self, number: str, scale: float) -> None:
        self.number, self._scale = number, scale
        self._values: dict[int, float] = {}

    def say(self, line: int, rest: str, worth: Callable[[str], float]) -> None:
        """One of them; `worth` is a parameter's or number's value. Raises UnreadError for another line."""
        found = re.search(r"([-+]?(?:Q[LR]?\d+|\d+\.?\d*|\.\d+))$", rest)
        if found is None or re.search(r"\d", rest[: found.start()]) or not 1 <= line <= _LINES[self.number]:
            raise UnreadError(f"CYCL DEF {self.number}.{line} {rest[:16]}")
        self._values[line] = worth(found[1])

    def hole(self, height: float) -> Hole:
        """From this height, where it also ends. Raises UnreadError for values left out, and a depth upwards."""
        said = self._values
        if len(said) < _LINES[self.number] or said[2] >= 0.0:
            raise UnreadError(f"cycle {self.number} without its values, or upwards")
        surface = height - abs(said[1])
        bottom = surface + said[2]
        if self.number == "17":
            return Hole(height, bottom, height, surface, tap=said[3])
        if self.number == "2":
            return Hole(height, bottom, height, surface, said[4], dwell=said[3], tap=0.0)
        bite = abs(said[3]) if abs(said[3]) < -said[2] - _SAME else 0.0
        return Hole(height, bottom, height, surface, said[5], dwell=said[4], bite=bite)

    def placed(self, q: Mapping[int, float]) -> Hole:
        """At the places of cycle 220 or 221, by its surface and clearances. Raises UnreadError for another clearance."""
        hole = self.hole(q[203] + q[200])
        if abs(hole.clear - hole.surface - q[200]) * self._scale > _SAME:
            raise UnreadError(f"cycle {self.number} at places by another clearance than its own")
        return hole._replace(level=max(hole.level, q[203] + q[204]))
