"""Drilling cycles as their motions: to the clear point, down, and out again as the cycle's kind has it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.source import number
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Kind, Pecks, Way
from camrob.witness.units import INCH_MM, mm_min_to_m_s, mm_to_m

__all__ = ["CYCLES", "UPWARD", "Cycle", "Out", "apt_cycle", "drill", "feed_unit", "renewed"]

Array = NDArray[np.float64]


class Out(Enum):
    """How the tool leaves the bottom."""

    RAPID = "rapid"
    FEED = "feed"
    STOPPED = "stopped"  # in rapid, with the spindle off
    REVERSED = "reversed"  # at the cycle's feed, with the spindle the other way (tapping)


CYCLES = {
    **dict.fromkeys(("73", "81", "82", "83"), Out.RAPID),
    **dict.fromkeys(("85", "89"), Out.FEED),
    **dict.fromkeys(("74", "84"), Out.REVERSED),
    "86": Out.STOPPED,
}  # of ISO's G codes


UPWARD = "CYCLE whose depth lies above its point"

_KINDS = {
    **dict.fromkeys(
        ("DRILL", "DEEP", "DEEP2", "DEEPHL", "BRKCHP", "BRKCHP2", "FACE", "CSINK", "CBORE", "SPOT", "SPTDRL"), Out.RAPID
    ),
    **dict.fromkeys(("REAM", "BORE"), Out.FEED),
    "DRAG": Out.STOPPED,
    "TAP": Out.REVERSED,
}
_PECKS = ("STEP", "1STPECK", "SUBPECK", "INCR", "STEP1", "STEP2", "STEP3")
_LEVEL = 2e-6  # m: heights that differ by less are printed alike, and no motion leads from the one to the other
_BREAKS = frozenset({"BRKCHP", "BRKCHP2"})  # the chip is broken, and left in the hole
_HEIGHTS = {
    "RAPTO": "clear",
    "CLEAR": "clear",
    "FEDTO": "depth",
    "DEPTH": "depth",
    "RTRCTO": "retract",
    "RETURN": "retract",
}
_PER_MINUTE = {"MMPM": 1.0, "IPM": INCH_MM}
_PER_TURN = {"MMPR": 1.0, "IPR": INCH_MM}


def feed_unit(word: str, scale: float, *, forced: bool = False) -> tuple[float, str] | None:
    """What 1 of a feed in this unit is, as `Teller.set_feed` takes it; scale: metres in one of the file's units.

    forced: the caller has named the file's unit. A file that is wrong about it is wrong about its feeds, too: of two the slower.
    """
    if word in _PER_MINUTE:
        own = mm_min_to_m_s(_PER_MINUTE[word])
        return (min(own, scale / 60.0) if forced else own), "min"
    if word in _PER_TURN:
        own = mm_to_m(_PER_TURN[word])
        return (min(own, scale) if forced else own), "rev"
    return {
        "PERMIN": (scale / 60.0, "min"),
        "UPM": (scale / 60.0, "min"),
        "PERREV": (scale, "rev"),
        "UPR": (scale, "rev"),
    }.get(word)


@dataclass(frozen=True, slots=True)
class Cycle:
    """A cycle in force. Heights in metres along the tool's axis from the point of the GOTO; problem: why it can't be read.

    retract None: to the clear point. pecks: the first one from the GOTO's point, None where it is drilled at once. start: where
    the tool stood when the cycle began, for RTRCTO,AUTO. feed None: the modal one. high: the tool comes over the hole no lower
    than it leaves it.
    """

    out: Out = Out.RAPID
    depth: float = 0.0
    clear: float = 0.0
    retract: float | None = None
    start: Array | None = None
    feed: tuple[float, str] | None = None
    dwell: float = 0.0
    pecks: Pecks | None = None
    problem: str = ""
    high: bool = False


_ONE_OF = ("RAPTO|CLEAR", "RTRCTO|RETURN", "MMPM|MMPR|IPM|IPR|PERMIN|PERREV|TPI")
_WORTH = r"(?:,(?:AUTO|NONE|REV|[-+.\d][^,]*))"


def renewed(before: list[str], new: list[str], *, by_values: bool) -> list[str]:
    """The fields of a cycle that is on again, with what is said anew (NX: by_values), or as they were; else those of `new`."""
    if new[:1] != ["ON"] or not before or (len(new) > 1 and (not by_values or number(new[1]) is not None)):
        return new
    text = ",".join(before)
    for word in re.finditer(rf"([A-Z]\w*){_WORTH}*", ",".join(new[1:])):
        same = next((group for group in _ONE_OF if word[1] in group.split("|")), word[1])
        text = re.sub(rf",(?:{same})(?:{_WORTH}+|(?=,|$))", "", text) + "," + word[0]
    return text.split(",")


def apt_cycle(fields: list[str], scale: float, unit_last: bool, tell: Teller, *, forced: bool = False) -> Cycle:
    """The cycle of CYCLE/`fields`, words or positions. unit_last: a feed stands before its unit (CATIA).

    forced: as `feed_unit` has it.
    """
    tokens = [t for f in fields for t in f.split()]
    said: dict[str, float] = {}
    plain: list[float] = []
    kind: Out | None = None
    feed: tuple[float, str] | None = None
    auto, pecks = False, dict[str, list[float]]()
    while tokens:
        word = tokens.pop(0)
        value, after = number(word), number(tokens[0]) if tokens else None
        per = feed_unit(word, scale, forced=forced)
        if value is not None:
            plain.append(value)
        elif word in _KINDS and (kind in (None, Out.RAPID) or word == "DRAG"):
            kind = _KINDS[word]
        elif per or word == "TPI":
            if len(plain) > 1 and not unit_last:
                return Cycle(problem=f"CYCLE whose feed may stand before or behind {word}")
            if per and len(plain) > 1:
                feed = (plain.pop() * per[0], per[1])
            elif after:
                feed = (after * per[0], per[1]) if per else (mm_to_m(INCH_MM) / after, "rev")
                tokens.pop(0)
        elif word in _HEIGHTS and after is not None:
            said[_HEIGHTS[word]] = after * scale
            tokens.pop(0)
        elif word == "RTRCTO" and tokens[:1] in (["AUTO"], ["NONE"]):
            auto = tokens.pop(0) == "AUTO"
        elif word in _PECKS or word == "PECKING":
            while after is not None and (word == "PECKING" or word not in pecks):
                pecks.setdefault(word, []).append(abs(after) * scale)
                tokens.pop(0)
                after = number(tokens[0]) if tokens else None
        elif word == "DWELL" and tokens[:1] == ["REV"] and len(tokens) > 1 and (turns := number(tokens[1])) is not None:
            said["dwell"] = turns * 60.0 / tell.rpm if tell.rpm else float("nan")
            del tokens[:2]
        elif word == "DWELL" and after is not None:
            said["dwell"] = after
            tokens.pop(0)
        elif word not in ("G98", "G99", "RIGID", "FLOAT", "NODRAG"):
            return Cycle(problem=f"CYCLE with {word}")
    for name, height in zip(("depth", "clear", "retract"), plain, strict=False):
        if name in said:
            return Cycle(problem="CYCLE with numbers beside its words")
        said[name] = height * scale
    if kind is None or "depth" not in said or "clear" not in said or said.get("dwell", 0.0) != said.get("dwell", 0.0):
        return Cycle(problem="CYCLE whose kind, depth, clear height or dwell is not known")
    if auto and tell.here is None:
        return Cycle(problem="CYCLE that retracts to where it began, which is not known")
    retract = None if "G99" in fields else said.get("retract")
    start = tell.here if auto else None
    dwell = said.get("dwell", 0.0)
    out_between = not _BREAKS & {t for f in fields for t in f.split()}
    return Cycle(
        kind, abs(said["depth"]), said["clear"], retract, start, feed, dwell, _pecks(pecks, out_between), high=True
    )


def _pecks(said: dict[str, list[float]], out: bool) -> Pecks | None:
    """How far the first peck goes, and the others: what isn't said of one holds for both; zero is none."""
    first = next((said[word][0] for word in ("1STPECK", "PECKING") if said.get(word)), 0.0)
    others = [v for word, values in said.items() if word != "1STPECK" for v in (values[1:] or values)]
    most = max(others, default=0.0)
    return Pecks(first or most, most or first, out) if first or most else None


def _approach(tell: Teller, clear: Array, axis: Array, line: int, level: float) -> None:
    """In rapid over the hole at the height where the tool stands, `level` above the clear point at least, then to that point."""
    here = tell.here
    if here is not None and np.allclose(axis, tell.axis, atol=1e-9):
        height = float((here - clear) @ axis)
        if height < level - _LEVEL:
            tell.move(here + (level - height) * axis, axis, Way.RAPID, line)
        if max(height, level) > _LEVEL:
            tell.move(clear + max(height, level) * axis, axis, Way.RAPID, line)
    tell.move(clear, axis, Way.RAPID, line)


def drill(tell: Teller, cycle: Cycle, top: Array, axis: Array, line: int) -> None:
    """One hole. top, axis: (3,) m and unit, in the part."""
    if cycle.problem:
        tell.gap(line, cycle.problem)
        return
    if tell.hidden:
        tell.move(top, axis, Way.RAPID, line)
        return
    level = cycle.retract
    if cycle.start is not None:
        level = max(float((cycle.start - top) @ axis), cycle.clear)
    elif level is None:
        level = cycle.clear
    clear, away = top + cycle.clear * axis, top + level * axis
    slow = top + min(level, cycle.clear) * axis  # as far as a tap or reamer is drawn out at its feed
    feed = tell.speed(line, cycle.feed)
    _approach(tell, clear, axis, line, max(level - cycle.clear, 0.0) if cycle.high else 0.0)
    if cycle.pecks is not None:
        tell.pecks[tell.n] = cycle.pecks._replace(first=cycle.clear + cycle.pecks.first)
    tell.move(top - cycle.depth * axis, axis, Way.HOLE, line, feed)
    if cycle.dwell > 0.0:
        tell.event(Kind.DWELL, line, cycle.dwell)
    if cycle.out is Out.FEED:
        tell.move(slow, axis, Way.FEED, line, feed)
    elif cycle.out is Out.REVERSED:
        sense = tell.sense
        if not tell.turning:
            tell.gap(line, "a tap with the spindle off", lost=False)
        tell.spindle(line, sense="CCLW" if sense == "CLW" else "CLW")
        tell.move(slow, axis, Way.FEED, line, feed)
        tell.spindle(line, sense=sense)
    stopped = cycle.out is Out.STOPPED and tell.turning
    if stopped:
        tell.spindle_off(line)
    tell.move(away, axis, Way.RAPID, line)
    if stopped:
        tell.spindle(line)
