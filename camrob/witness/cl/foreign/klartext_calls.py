"""Heidenhain's cycle calls: where the tool stands, at a place, at the places of a pattern (TNC 640, "Machining Cycles")."""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from collections.abc import Collection, Sequence

from camrob.witness.cl.foreign.foreign_cycles import drill_here
from camrob.witness.cl.foreign.foreign_words import ForeignReader, UnreadError
from camrob.witness.cl.foreign.klartext_places import FIRST, MODAL_CALL
from camrob.witness.cl.foreign.klartext_values import NUMBER, CycleInForce

__all__ = ["CALL", "CycleCalls"]

CALL = re.compile(
    rf"CYCL CALL( POS X ?({NUMBER}) Y ?({NUMBER}) Z ?[-+]?0+\.?0*(?= .*F ?MAX)( R0| F ?MAX)*| PAT(?= .*F ?MAX))?"
    r"(( M\d+| F ?MAX)*)"
)
"""A call: a place, or a pattern; M functions."""


class CycleCalls(ForeignReader):
    """A reader that has a cycle in force, a pattern's places, and X, Y, Z as the program counts them (`_here`)."""

    _here: dict[str, float]
    _in_force: CycleInForce
    _pattern: Sequence[tuple[float, float]]
    _modal = False  # M89: the cycle is called behind every motion

    @abstractmethod
    def _switch(self, codes: list[str], line: int, *, first: bool) -> None:
        """The M functions that come first in their block, or the others."""

    def _call(self, found: re.Match[str], line: int) -> None:
        """What CALL has found."""
        codes = re.findall(r"M0*(\d+)", found[5])
        if not found[1]:
            self._hole(codes, line)
            return
        self._switch([code for code in codes if code in FIRST], line, first=True)
        self._holes(self._pattern if found[1] == " PAT" else [(float(found[2]), float(found[3]))], line)
        self._switch([code for code in codes if code not in FIRST], line, first=False)

    def _retracted(self, text: str, line: int) -> bool:
        """Whether a block is M140, with other M functions or none: back along the tool, how far isn't known."""
        found = re.fullmatch(r"((?:M\d+ )*)M140 MB ?(?:MAX|[-+\d.]+)(?: F ?\w+)?((?: M\d+)*)", text)
        if found is None:
            return False
        codes = re.findall(r"M0*(\d+)", found[1] + found[2])
        self._switch(codes, line, first=True)
        self._here = {}
        self._forget()
        self._switch(codes, line, first=False)
        return True

    def _due(self, codes: list[str], axes: Collection[str]) -> bool:
        """Whether a block that has moved these axes ends in the cycle: by M99, or by M89 in it or before it, up to M99."""
        modal = self._modal or "89" in codes
        if ("89" in codes and not axes) or (modal and "Z" in axes):
            raise UnreadError(MODAL_CALL)
        self._modal = modal and "99" not in codes
        return "99" in codes or (modal and bool(axes))

    def _holes(self, places: Sequence[tuple[float, float]], line: int) -> None:
        """The cycle in force at each of the places."""
        if not places:
            raise UnreadError("a cycle call without places")
        for x, y in places:
            self._over(x, y, line)
            self._hole([], line)

    def _over(self, x: float, y: float, line: int) -> None:
        """In rapid over a place, at the height where the cycle in force ends, or where the tool stands above that."""
        level = self._in_force.hole.level
        if self._here.get("Z", -math.inf) < level:
            self._block(["G0", f"Z{level:.9f}"], line)
            self._here["Z"] = level
        self._block(["G0", f"X{x:.9f}", f"Y{y:.9f}"], line)
        self._here |= {"X": x, "Y": y}

    def _hole(self, codes: list[str], line: int) -> None:
        """The cycle in force where the tool stands."""
        hole = self._in_force.hole_from(self._here.get("Z"))
        self._switch(codes, line, first=True)
        drill_here(self, hole, line)
        self._here["Z"] = hole.level
        self._switch(codes, line, first=False)
