"""Cutter radius compensation: which of its words ask for a path that only a control can make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.witness.cl.source import Statement
from camrob.witness.cl.teller import Teller

__all__ = ["OFFSET", "Offsets"]

OFFSET = "the path has to be offset by the tool's radius"


class Offsets:
    """Watches one file. wear: the set-up says that its paths are the tool centre's."""

    def __init__(self, tell: Teller, wear: bool) -> None:
        self._tell, self._wear = tell, wear
        self._radius = ""  # the D word in force, "" for one that isn't said
        self._on, self._contour = False, False

    def block(self, g: Sequence[str], m: Sequence[str], words: Mapping[str, str], line: int) -> None:
        """G40, G41, G42 and D: no radius behind D0, and one of the control's own behind any other and behind a change of tool."""
        radius = words.get("D", "" if "T" in words or "6" in m else self._radius)
        began = bool({"41", "42"} & set(g))
        changed, self._radius = radius != self._radius, radius
        self._on = began or (self._on and "40" not in g)
        if not self._on or not (began or changed):
            return
        if self._wear or (radius and float(radius) == 0.0):
            self._tell.note("G41, G42: the radius offset is not applied, the path is as it is printed")
        else:
            self._tell.gap(line, f"G41 or G42 of D{radius or ' without a number'}: {OFFSET}", lost=False)

    def comment(self, s: Statement) -> None:
        """Creo says in a comment whether it writes the part's profile."""
        if "CUTCOM_GEOMETRY_TYPE" in s.rest.upper():
            self._contour = "ON_PROFILE" in s.rest.upper()

    def cutcom(self, s: Statement) -> None:
        """CL data is where the tool goes, but a profile is not."""
        if not {"LEFT", "RIGHT", "ON"} & set(s.words):
            return
        if self._contour and not self._wear:
            self._tell.gap(s.line, f"{s.major} of a profile: {OFFSET}", last=s.last, lost=False)
        else:
            self._tell.note(f"{s.major}: the radius offset is not applied, the path is as it is printed")
