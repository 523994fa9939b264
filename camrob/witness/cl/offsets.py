"""Offsets of a control's own: which words of cutter radius and tool length ask for a path that only it can make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.witness.cl.source import Statement
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Kind

__all__ = ["OFFSET", "TCP", "Offsets"]

TCP = ("43.4", "43.5", "234")
"""Tool centre point, each with the tool's length."""

OFFSET = "the path has to be offset by the tool's radius"


class Offsets:
    """Watches one file. wear: the set-up says that its paths are the tool centre's; contour: its author writes the part's own."""

    def __init__(self, tell: Teller, wear: bool, contour: bool = False) -> None:
        self._tell, self._wear = tell, wear
        self._radius = ""  # the D word in force, "" for one that isn't said
        self._on, self._contour = False, contour
        self.edges = False  # D names the tool's length, too (Siemens)
        self._measured = ""  # whether G43 or G49 is in force, "" as long as no length has been named
        self._number = ""  # of the length in force: H, or Siemens' D
        self._changed = False  # and no block has named Z in G90 since
        self._held = False  # G43 since the last change of tools
        self._cut_with: dict[float, str] = {}  # by tool, "" for no length

    def block(self, g: Sequence[str], m: Sequence[str], words: Mapping[str, str], line: int) -> None:
        """G40, G41, G42 and D: no radius behind D0, and one of the control's own behind any other and behind a change of tool."""
        self._lengths(g, m, words)
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

    def _lengths(self, g: Sequence[str], m: Sequence[str], words: Mapping[str, str]) -> None:
        for code in g:
            if code in ("43", "44", "49", *TCP):
                on = "off" if code == "49" else "on"
                self._measured = on if self._measured or code in ("43", "44") else ""
        if self.edges and ("T" in words or "6" in m):
            self._number = "1"
        before = self._number
        if not {"10", "15", "16"} & set(g):
            self._number = words.get("D" if self.edges else "H", self._number)
        begins = not self._held and bool({"43", *TCP} & set(g))
        self._held = (self._held or begins) and "6" not in m
        if not self.edges and (begins or before != self._number):
            self._changed = True

    def way(self, words: Mapping[str, str], motion: str, absolute: bool, z: float | None, *, cuts: bool) -> str:
        """Before a motion from the height z: why it isn't known how high it goes, or how long the tool is as against before."""
        hidden = self._hidden(words, motion, absolute) if {*"XYZABC"} & set(words) else ""
        return (self._other() if cuts else "") or (hidden if z is not None else "")

    def _hidden(self, words: Mapping[str, str], motion: str, absolute: bool) -> str:
        """Why the height isn't known behind another length; "" where it is, or where nothing is cut across."""
        changed, placed = self._changed, "Z" in words and absolute
        self._changed = changed and not (placed and motion in ("", "0", "1", "2", "3"))
        if not changed or motion in ("", "0", "80"):
            return ""
        down = placed and motion == "1" and not {"X", "Y"} & set(words)
        cycle = motion not in ("1", "2", "3") and absolute
        return "" if down or cycle else "a cut since whose tool's length (G43) Z has not been named"

    def _other(self) -> str:
        """Why the tool's length isn't the one of its cuts before; "" where it is."""
        if self._measured == "off":
            return "a cut without the tool's length (G49), behind others with it"
        if not self._number and (self.edges or self._measured):
            return ""
        mounted = next((event.value for event in reversed(self._tell.events) if event.kind is Kind.TOOL), 0.0)
        number = f"{float(self._number):g}" if self._number else ""
        same = self._cut_with.setdefault(mounted, number) == number
        return "" if same else "a cut with another of the tool's lengths than before"

    def comment(self, s: Statement) -> None:
        """Creo says in a comment whether it writes the part's profile."""
        if "CUTCOM_GEOMETRY_TYPE" in s.rest.upper():
            self._contour = "ON_PROFILE" in s.rest.upper()

    def cutcom(self, s: Statement) -> None:
        """CL data is where the tool goes, but a profile is not."""
        if not {"LEFT", "RIGHT", "ON"} & set(s.words) or "LENGTH" in s.words:
            return
        if self._contour and not self._wear:
            self._tell.gap(s.line, f"{s.major} of a profile: {OFFSET}", last=s.last, lost=False)
        else:
            self._tell.note(f"{s.major}: the radius offset is not applied, the path is as it is printed")
