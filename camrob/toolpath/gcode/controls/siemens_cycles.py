"""Siemens' drilling cycles 81 to 85, 89 and 840 as the moves that they stand for (840D sl, "Job planning", drilling cycles)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import Block

__all__ = ["CYCLES", "NOT_DONE", "TAPS", "Hole", "hole_of"]

_NAMES = {
    "CYCLE81": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE82": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE83": "RTP RFP SDIS DP DPR FDEP FDPR DAM DTB DTS FRF VARI AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE",
    "CYCLE84": "RTP RFP SDIS DP DPR DTB SDAC MPIT PIT POSS SST SST1 AXN PITA TECHNO VARI DAM VRT PITM PTAB PTABA GMODE DMODE"
    " AMODE",
    "CYCLE840": "RTP RFP SDIS DP DPR DTB SDR SDAC ENC MPIT PIT AXN PITA TECHNO PITM PTAB PTABA GMODE DMODE AMODE",
    "CYCLE85": "RTP RFP SDIS DP DPR DTB FFR RFF GMODE DMODE AMODE",
    "CYCLE89": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
}
_STOPS = "the spindle stands at the hole's bottom, and an operator draws the tool out"
NOT_DONE = {
    "CYCLE86": "the spindle stands at an angle at the hole's bottom, and the tool is drawn out beside the wall",
    "CYCLE87": _STOPS,
    "CYCLE88": _STOPS,
}
"""Drilling cycles that no robot's spindle does, and why."""
CYCLES = frozenset(_NAMES)
TAPS = frozenset(("CYCLE84", "CYCLE840"))
# mm: the coarse pitch of a metric thread by its size (ISO 261), which MPIT names
_COARSE: dict[float, float] = {
    3: 0.5,
    4: 0.7,
    5: 0.8,
    6: 1.0,
    8: 1.25,
    10: 1.5,
    12: 1.75,
    14: 2.0,
    16: 2.0,
    18: 2.5,
    20: 2.5,
    22: 2.5,
    24: 3.0,
    27: 3.0,
    30: 3.5,
    33: 3.5,
    36: 4.0,
    39: 4.0,
    42: 4.5,
    45: 4.5,
    48: 5.0,
}
_MOST_PECKS = 2000  # of one hole: a slip of the decimal point has more
_EVEN = 1e-9  # of the program's unit
_PERCENT = 100.0  # above 1 FRF is a share of the feed in hundredths
_BREAK = 1.0  # mm: VRT where it is left out or 0
# DIS1 where it is left out or 0: how far above the last bite's end the rapid back into the hole ends, mm; of a hole deeper than
# _SHALLOW its depth by _SHARE, at most _FARTHEST (840D sl, "Job planning", CYCLE83)
_NEAREST, _SHALLOW, _SHARE, _FARTHEST = 0.6, 30.0, 50.0, 7.0


@dataclass(frozen=True, slots=True)
class Hole:
    """A cycle with its values by Siemens' names; lengths in the program's unit, what is left out is None."""

    name: str
    value: dict[str, float | None]

    def __getitem__(self, name: str) -> float:
        return self.value.get(name) or 0.0

    @property
    def depth(self) -> float:
        """The height of the bottom."""
        absolute, relative = self.value["DP"], self.value["DPR"]
        return absolute if absolute is not None else self["RFP"] - abs(relative or 0.0)

    def blocks(self, feed: float | None, line: int, speed: float | None, mm: float = 1.0) -> Iterator[Block]:
        """One hole from where the tool stands; `feed` and `speed` are the modal F and S, as written, `mm` is one of its units.

        Raises ToolpathError without a feed, or for a tap without its pitch or speed.
        """
        if self.name in TAPS:
            yield from self._tapped(feed, speed, line)
            return
        top, depth, out = self["RFP"] + self["SDIS"], self.depth, self["RTP"]
        feed = self["FFR"] or feed
        if not feed:
            raise ToolpathError(f"{self.name} without a feed", hint="program F before it")
        yield Block(line, {"Z": top}, (0,))
        if self.name == "CYCLE83":
            yield from self._pecks(top, feed, line, mm)
        else:
            yield Block(line, {"Z": depth, "F": feed}, (10,))
        if self.name != "CYCLE81":
            yield from _dwell(self["DTD"] or self["DTB"], line)
        if self.name in ("CYCLE85", "CYCLE89"):
            yield Block(line, {"Z": top, "F": self["RFF"] or feed}, (10,))
        yield Block(line, {"Z": max(out, top)}, (0,))

    def _tapped(self, feed: float | None, speed: float | None, line: int) -> Iterator[Block]:
        """CYCLE84 and CYCLE840, as a tap in a floating holder goes: G84 or, for a left-hand thread, G74."""
        pitch = self["PIT"] or math.copysign(_COARSE.get(abs(self["MPIT"]), math.nan), self["MPIT"]) * bool(
            self["MPIT"]
        )
        rpm = self["SST"] or speed
        if math.isnan(pitch) or not rpm or (not pitch and not (feed and self.name == "CYCLE840")):
            raise ToolpathError(
                f"{self.name} without its pitch or speed: the control would not know either",
                hint="name PIT (or MPIT), and SST or S",
            )
        if self["SST"] and self["SST1"] not in (0.0, self["SST"]):
            raise ToolpathError("CYCLE84 that comes out at another speed (SST1)", hint="leave SST1 out")
        words = {"Z": self.depth, "R": self["RFP"] + self["SDIS"], "F": abs(pitch) * rpm if pitch else feed or 0.0}
        if self["DTB"]:
            words["P"] = self["DTB"]
        if rpm != speed:
            yield Block(line, {"S": rpm})
        yield Block(line, words, (990, 740 if pitch < 0.0 else 840))
        if rpm != speed and speed is not None:
            yield Block(line, {"S": speed})
        yield Block(line, {"Z": max(self["RTP"], self["RFP"] + self["SDIS"])}, (0,))

    def _pecks(self, top: float, feed: float, line: int, mm: float) -> Iterator[Block]:
        """Bites: the first one to FDEP, each later one shorter by DAM (below 0: by that factor), none below DAM or MDEP."""
        first, depth, less = self._first, self.depth, self["DAM"]
        bite, at = self["RFP"] - first, first
        least = self["MDEP"] or max(less, 0.0)
        share = self["FRF"] / _PERCENT if self["FRF"] > 1.0 else self["FRF"] or 1.0
        yield Block(line, {"Z": first, "F": feed * share}, (10,))
        while at > depth + _EVEN:
            yield from _dwell(self["DTB"], line)
            if self["VARI"]:
                yield Block(line, {"Z": top}, (0,))
                yield from _dwell(self["DTS"], line)
                yield Block(line, {"Z": min(top, at + (self["DIS1"] or self._ahead(mm)))}, (0,))
            else:
                yield Block(line, {"Z": min(top, at + (self["VRT"] or _BREAK / mm)), "F": feed}, (10,))
            bite = max(least, bite - less if less >= 0.0 else bite * -less)
            at = max(depth, at - bite)
            yield Block(line, {"Z": at, "F": feed}, (10,))

    def _ahead(self, mm: float) -> float:
        """DIS1 as the control finds it, in the program's unit."""
        deep = (self["RFP"] - self.depth) * mm
        return (_NEAREST if deep <= _SHALLOW else min(deep / _SHARE, _FARTHEST)) / mm

    @property
    def _first(self) -> float:
        """The height of the first bite's end."""
        absolute, relative = self.value["FDEP"], self.value["FDPR"]
        named = absolute if absolute is not None else self["RFP"] - abs(relative or 0.0)
        return max(named, self.depth) if named < self["RFP"] - _EVEN else self.depth


def _dwell(seconds: float, line: int) -> Iterator[Block]:
    if seconds:
        yield Block(line, {"P": seconds}, (40,))


def hole_of(name: str, arguments: Sequence[float | None]) -> Hole:
    """The cycle `name` with its arguments (None: left out). Raises ToolpathError for values whose meaning is not certain."""
    names = _NAMES[name].split()
    if len(arguments) > len(names) and any(arguments[len(names) :]):
        raise ToolpathError(
            f"{name} with more than {len(names)} values", hint="have the post-processor write plain moves"
        )
    hole = Hole(name, dict(zip(names, [*arguments, *[None] * len(names)], strict=False)))
    for a, b in (("DP", "DPR"), ("FDEP", "FDPR")):
        both = hole.value.get(a) is not None and hole.value.get(b)
        if both and abs(hole["RFP"] - abs(hole[b]) - hole[a]) > _EVEN:
            raise ToolpathError(f"{name} with {a} and {b} of two depths", hint=f"leave {b} out")
    if hole.value["DP"] is None and not hole["DPR"]:
        raise ToolpathError(f"{name} without its depth DP or DPR", hint="name one of them")
    if hole["GMODE"] or hole["DMODE"] % 10 > 1 or hole["AMODE"] % 10 == 1 or hole["AXN"] not in (0.0, 3.0):
        raise ToolpathError(
            f"{name} with _GMODE, _DMODE, _AMODE or _AXN that count depths in another way",
            hint="post with DP, absolute",
        )
    if min(hole["DTB"], hole["DTS"], hole["DTD"]) < 0.0 or hole["AMODE"] // 10 % 10 == 2:
        raise ToolpathError(f"{name} with a dwell in turns of the spindle", hint="name it in seconds")
    if hole["SDIS"] < 0.0 or hole.depth >= hole["RFP"] or hole["RTP"] < hole["RFP"]:
        raise ToolpathError(f"{name} whose heights make no hole", hint="check RTP, RFP, SDIS and DP")
    if name == "CYCLE83" and not (hole["DAM"] >= -1.0 and 0.0 <= hole["FRF"] <= _PERCENT):
        raise ToolpathError(f"{name} with DAM or FRF out of what is known", hint="check them")
    if name in TAPS and hole["PITA"] not in (0.0, 1.0):
        raise ToolpathError(
            f"{name} with its pitch in another unit (_PITA {hole['PITA']:g})", hint="name it in mm, by PIT"
        )
    if name in TAPS and hole["VARI"]:
        raise ToolpathError(f"{name} in bites (_VARI {hole['VARI']:g})", hint="tap in one go")
    _check_pecks(hole)
    return hole


def _check_pecks(hole: Hole) -> None:
    """Raises ToolpathError where the bites never end."""
    if hole.name != "CYCLE83":
        return
    least = hole["MDEP"] or max(hole["DAM"], 0.0) or (hole["RFP"] - hole._first if hole["DAM"] == 0.0 else 0.0)
    if not least > 0.0 or (hole["RFP"] - hole.depth) / least > _MOST_PECKS:
        raise ToolpathError("CYCLE83 with bites that never end", hint="check FDEP, DAM and MDEP")
