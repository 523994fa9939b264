"""Drilling cycles and swivelled planes of Siemens and Heidenhain, by their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.foreign.foreign_words import ForeignReader, UnreadError
from camrob.witness.frames import rotation
from camrob.witness.happenings import Kind, Pecks, Way
from camrob.witness.units import deg_to_rad

__all__ = [
    "ACROSS",
    "Hole",
    "drill_here",
    "klartext_hole",
    "places",
    "siemens_hole",
    "spatial_plane",
    "swivelled_plane",
]

Array = NDArray[np.float64]

ACROSS = "a drilling cycle in G18 or G19, which is not along the tool"
_SIEMENS = {
    "CYCLE81": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE82": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE83": "RTP RFP SDIS DP DPR FDEP FDPR DAM DTB DTS FRF VARI AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE",
    "CYCLE84": "RTP RFP SDIS DP DPR DTB SDAC MPIT PIT POSS SST SST1 AXN PITA TECHNO VARI DAM VRT M1 M2 M3 GMODE DMODE AMODE",
    "CYCLE840": "RTP RFP SDIS DP DPR DTB SDR SDAC ENC MPIT PIT AXN PITA TECHNO M1 M2 M3 GMODE DMODE AMODE",
    "CYCLE85": "RTP RFP SDIS DP DPR DTB FFR RFF GMODE DMODE AMODE",
    "CYCLE89": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
}
# the Q parameters that each cycle asks for
_KLARTEXT = {
    "200": (200, 201, 202, 203, 204, 206),
    "201": (200, 201, 203, 204, 206, 208),
    "203": (200, 201, 202, 203, 204, 205, 206, 208, 212, 213),
    "205": (200, 201, 202, 203, 204, 205, 206, 212, 257, 258, 259),
    "206": (200, 201, 203, 204, 206),
    "207": (200, 201, 203, 204, 239),
    "240": (200, 201, 203, 204, 206),
}
# mm: what a metric thread rises in a turn, by its size (ISO 261, coarse)
_RISES: dict[float, float] = {
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
_MOST_BITES = 5000  # of one hole
_FMAX = 99999.0  # a feed that stands for the rapid


class Hole(NamedTuple):
    """Heights in the program's unit: where it goes in rapid, its bottom, where it ends. feed_in, feed_out: a minute, None: the
    modal one, in rapid. bite: 0 in one go.
    """

    clear: float
    bottom: float
    level: float
    surface: float
    feed_in: float | None = None
    feed_out: float | None = None
    dwell: float = 0.0
    bite: float = 0.0
    tap: float | None = None  # the thread's rise a turn, left-handed below 0, 0: by the modal feed
    rpm: float | None = None  # of the tap, None: the modal one
    drawn: bool = False  # out at the feed at which it went in
    bites: tuple[float, ...] = ()  # where each of several bites that differ ends
    breaks: int = 0  # so many times the chip is broken before the tool comes out
    lift: float | None = None  # by so much the tool is drawn back for that, None: by a machine parameter
    kept: bool = False  # the tool stays in the hole between its bites
    entry: float = 1.0  # the first bite's share of the feed
    swift: bool = False  # out in rapid between its bites, whatever the feed out of its bottom


def drill_here(reader: ForeignReader, hole: Hole, line: int) -> None:
    """The hole's motions where the tool stands. Raises UnreadError where that, or a way along the tool, isn't known."""
    tell, stand, scale = reader.tell, reader.stand, reader.scale * reader.stand.stretch[1]
    pose = stand.pose()
    if pose is None or stand.odd or not np.allclose(pose[1], stand.direction(np.array([0.0, 0.0, 1.0])), atol=1e-9):
        raise UnreadError("a cycle whose place or way along the tool isn't known")
    zero, axis = stand.floor, pose[1]

    def at(height: float) -> Array:
        return stand.point(np.array([pose[0][0], pose[0][1], height * scale + zero]))

    if pose[0][2] < hole.clear * scale + zero - 1e-9:
        raise UnreadError("a cycle from below its clear height")
    sense, before = tell.sense, tell.rpm
    if hole.tap is not None:
        feed = _threaded(reader, hole, line)
        tell.move(at(hole.clear), axis, Way.RAPID, line)
        tell.move(at(hole.bottom), axis, Way.HOLE, line, feed)
        if hole.dwell:
            tell.event(Kind.DWELL, line, hole.dwell)
        tell.spindle(line, sense="CCLW" if sense == "CLW" else "CLW")
        tell.move(at(hole.clear), axis, Way.FEED, line, feed)
        tell.spindle(line, sense=sense)
        if hole.rpm and before and hole.rpm != before:
            tell.spindle(line, before)
        tell.move(at(hole.level), axis, Way.RAPID, line)
        stand.at["Z"] = hole.level * scale + zero
        return
    feed = tell.speed(line, None if hole.feed_in is None else (hole.feed_in * reader.scale / 60.0, "min"))
    tell.move(at(hole.clear), axis, Way.RAPID, line)
    entry = None
    if hole.entry != 1.0 and (hole.bite or hole.bites):
        entry = hole.entry * feed
    elif hole.entry != 1.0:
        feed *= hole.entry
    fed, lift = hole.feed_out is not None and not hole.swift, None if hole.lift is None else hole.lift * scale
    if hole.bites:
        lows = tuple((hole.clear - low) * scale for low in hole.bites)
        most = max(b - a for a, b in zip((0.0, *lows), lows, strict=False))
        tell.pecks[tell.n] = Pecks(lows[0], most, not hole.kept, lows, hole.breaks, fed, lift, entry)
    elif hole.bite:
        first = hole.clear - hole.surface + hole.bite
        tell.pecks[tell.n] = Pecks(first * scale, hole.bite * scale, not hole.kept, (), hole.breaks, fed, lift, entry)
    tell.move(at(hole.bottom), axis, Way.HOLE, line, feed)
    if hole.dwell:
        tell.event(Kind.DWELL, line, hole.dwell)
    if hole.drawn:
        tell.move(at(hole.clear), axis, Way.FEED, line, feed)
    if hole.feed_out is not None:
        tell.move(at(hole.clear), axis, Way.FEED, line, hole.feed_out * reader.scale / 60.0)
    tell.move(at(hole.level), axis, Way.RAPID, line)
    stand.at["Z"] = hole.level * scale + zero


def _threaded(reader: ForeignReader, hole: Hole, line: int) -> float:
    """The speed, m/s, at which a tap goes in and comes out; starts the spindle at the tap's own speed."""
    tell = reader.tell
    if not tell.turning or tell.sense != ("CCLW" if (hole.tap or 0.0) < 0.0 else "CLW"):
        raise UnreadError("a tap whose spindle stands, or turns the other way")
    if hole.rpm and hole.rpm != tell.rpm:
        tell.spindle(line, hole.rpm)
    if hole.feed_in is not None:
        return tell.speed(line, (hole.feed_in * reader.scale / 60.0, "min"))
    return tell.speed(line, (abs(hole.tap) * reader.scale, "rev") if hole.tap else None)


def places(name: str, values: Sequence[float | None]) -> list[tuple[float, float]]:
    """X and Y of the holes of HOLES1 (a row), HOLES2 (a circle) and CYCLE802 (any). Raises UnreadError for what makes none."""
    if name == "CYCLE802":
        pairs = [p for p in zip(values[2:20:2], values[3:20:2], strict=False) if p != (None, None)]
        tail = [p != (None, None) for p in zip(values[2:20:2], values[3:20:2], strict=False)]
        whole = all(v is not None and set(str(int(v))) == {"1"} for v in values[:2])
        if (
            not whole
            or not pairs
            or tail != sorted(tail, reverse=True)
            or any(v not in (None, 0.0, 1.0) for v in values[20:])
        ):
            raise UnreadError("CYCLE802 of places that count otherwise")
        if any(x is None or y is None for x, y in pairs):
            raise UnreadError("CYCLE802 of places that lack a coordinate")
        return [(float(x or 0.0), float(y or 0.0)) for x, y in pairs]
    x, y, a, b, c, n = [value or 0.0 for value in (*values, *[None] * 6)][:6]
    if any(values[6:]) or n % 1 or not 1 <= n <= 1000:
        raise UnreadError(f"{name} of holes that aren't known")
    if name == "HOLES1":
        ray = np.array([np.cos(deg_to_rad(a)), np.sin(deg_to_rad(a))])
        found = np.array([x, y]) + np.outer(b + c * np.arange(n), ray)
    else:
        turns = deg_to_rad(b) + np.arange(n) * (deg_to_rad(c) if c else 2.0 * np.pi / n)
        found = np.array([x, y]) + a * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    return [(float(u), float(v)) for u, v in found]


def siemens_hole(name: str, values: Sequence[float | None], mm: float) -> Hole:
    """CYCLE81 to CYCLE85 and CYCLE840 by their values. Raises UnreadError for others, and for depths that count otherwise."""
    names = _SIEMENS.get(name, "").split()
    if not names or any(values[len(names) :]):
        raise UnreadError(f"{name}, a cycle of Siemens'")
    said = dict(zip(names, values, strict=False))
    value = {key: said.get(key) or 0.0 for key in names}
    bottom, deep = said.get("DP"), value["DPR"]
    mode = value.get("AMODE", 0.0)
    odd = value.get("GMODE") or value.get("DMODE", 0.0) % 10 > 1 or mode % 10 == 1 or mode // 10 % 10 == 2
    if odd or value["DTB"] < 0.0 or (bottom is None and not deep):
        raise UnreadError(f"{name} whose depth or dwell counts in another way")
    end = value["RFP"] - abs(deep) if bottom is None else bottom
    if bottom is not None and deep and abs(value["RFP"] - abs(deep) - bottom) > 1e-9:
        raise UnreadError(f"{name} of two depths")
    clear = value["RFP"] + value["SDIS"]
    if "PIT" in value:
        if value["PITA"] not in (0.0, 1.0) or value.get("VARI") or value["AXN"] not in (0.0, 3.0):
            raise UnreadError(f"{name} in bites, or with a pitch in another unit")
        rise = value["PIT"] or np.sign(value["MPIT"]) * _RISES.get(abs(value["MPIT"]), 0.0)
        if (not rise and (name == "CYCLE84" or value["MPIT"])) or value.get("SST1", 0.0) not in (0.0, value.get("SST")):
            raise UnreadError(f"{name} whose pitch or speed isn't known")
        level = max(value["RTP"], clear)
        return Hole(clear, end, level, value["RFP"], dwell=value["DTB"], tap=float(rise), rpm=value.get("SST") or None)
    if name == "CYCLE83":
        return _deep(value, said.get("FDEP"), end, mm)
    inwards, back = value.get("FFR") or None, value.get("RFF") or value.get("FFR")
    if back == 0.0:
        raise UnreadError("CYCLE85 without its feeds")
    dwell = value["DTB"] if name != "CYCLE81" else 0.0
    slow = name == "CYCLE89"  # out as it went in
    return Hole(clear, end, max(value["RTP"], clear), value["RFP"], inwards, back, dwell, drawn=slow)


def _deep(value: Mapping[str, float], first: float | None, end: float, mm: float) -> Hole:
    """CYCLE83 in one go (FDEP, or FDPR below the reference plane, is its bottom), or in bites that don't dwell: by VARI the tool
    comes out in rapid between them, or is drawn back by VRT, 1 mm where it names none (`mm` is one of the program's units). How
    far above the last bite it goes back in rapid isn't asked. Raises UnreadError else.
    """
    surface = value["RFP"]
    named = surface - abs(value["FDPR"]) if first is None else first
    odd = first is not None and value["FDPR"] and abs(surface - abs(value["FDPR"]) - first) > 1e-9
    share = value["FRF"] / 100.0 if value["FRF"] > 1.0 else value["FRF"] or 1.0
    if (
        value["DTD"] < 0.0
        or value["AXN"] not in (0.0, 3.0)
        or odd
        or value["DAM"] < -1.0
        or not 0.0 < share <= 1.0
        or value["VARI"] not in (0.0, 1.0)
    ):
        raise UnreadError("CYCLE83 whose depth, dwell or feed counts in another way")
    bite = surface - named if end + 1e-9 < named < surface - 1e-9 else 0.0
    if bite and (value["MDEP"] > bite or value["DTB"] or value["DTS"]):
        raise UnreadError("CYCLE83 in bites that dwell")
    clear = surface + value["SDIS"]
    hole = Hole(clear, end, max(value["RTP"], clear), surface, dwell=value["DTD"] or value["DTB"], bite=bite)
    if bite and value["DAM"]:
        hole = hole._replace(bites=_shorter(surface, bite, end, value))
    kept = bite > 0.0 and not value["VARI"]
    return hole._replace(entry=share, kept=kept, lift=(value["VRT"] or 1.0 / mm) if kept else None)


def _shorter(surface: float, bite: float, end: float, value: Mapping[str, float]) -> tuple[float, ...]:
    """Where each bite of CYCLE83 ends: one is shorter than that before it by DAM, or, DAM below 0, -DAM times as long; none is
    shorter than MDEP, or than DAM. Raises UnreadError where that leads nowhere.
    """
    less, lows = value["DAM"], [surface - bite]
    least = value["MDEP"] if value["MDEP"] else max(0.0, less)
    while lows[-1] > end + 1e-9:
        bite = bite - less if less > 0.0 else -less * bite
        if bite < least:
            bite = least
        if bite <= 0.0 or len(lows) > _MOST_BITES:
            raise UnreadError("CYCLE83 in bites that never end")
        lows.append(max(end, lows[-1] - bite))
    return tuple(lows)


def klartext_hole(number: str, q: Mapping[int, float]) -> Hole:
    """Cycles 200 to 207 and 240 by their Q numbers, some of them. Raises UnreadError for the others."""
    if any(name not in q for name in _KLARTEXT.get(number, (-1,))) or q.get(395) or q.get(343):
        raise UnreadError(f"CYCL DEF {number}, a cycle of Heidenhain's")
    surface, deep, universal = q[203], -q[201], number == "205"
    if universal and (q[257] < 0.0 or q.get(379)):
        raise UnreadError("CYCL DEF 205 that begins inside the hole")
    bite = q[202] if number in ("200", "203", "205") and 0.0 < q[202] < deep - 1e-9 else 0.0
    breaks = q[213] if bite and number == "203" else 0.0
    if breaks % 1.0 or breaks < 0.0:
        raise UnreadError("CYCL DEF 203 that breaks its chips an odd number of times")
    less = (
        q[212] if bite and number in ("203", "205") else 0.0
    )  # by so much a bite is shorter than that before it, down to Q205
    if less < 0.0 or (less and not 0.0 < q[205] <= bite):
        raise UnreadError(f"CYCL DEF {number} in bites that grow, or have no least depth")
    if bite and q.get(210):
        raise UnreadError("a cycle that dwells between its bites")
    back = (q[208] or q[206]) if number in ("201", "203") or (universal and 208 in q) else None
    clear = surface + q[200]
    level = max(clear, surface + q[204])
    lows = _shorter(surface, bite, surface - deep, {"DAM": less, "MDEP": q[205]}) if less else ()
    if universal and q[257]:
        lows, breaks = _broken(surface, lows or _even(surface, bite or deep, surface - deep), q[257])
    if number in ("206", "207"):
        per = None if number == "207" else q[206]
        return Hole(clear, surface - deep, level, surface, per, dwell=q.get(211, 0.0), tap=q.get(239, 0.0))
    return Hole(
        clear,
        surface - deep,
        level,
        surface,
        q[206],
        None if back is None or back >= _FMAX else back,
        q.get(211, 0.0),
        0.0 if lows else bite,
        bites=lows,
        breaks=int(breaks),
        lift=(q.get(256) or None) if breaks else None,
        swift=universal,
    )


def _even(surface: float, bite: float, end: float) -> tuple[float, ...]:
    """Where bites of one depth end."""
    return (*np.arange(surface - bite, end + 1e-9, -bite).tolist(), end)


def _broken(surface: float, lows: Sequence[float], every: float) -> tuple[tuple[float, ...], int]:
    """Where the tool stops on its way down if within each bite it breaks the chip behind every `every`, and how often it does in
    one. Raises UnreadError where it would for ever.
    """
    stops, most = list[float](), 0
    for start, end in zip((surface, *lows), lows, strict=False):
        if (start - end) / every > _MOST_BITES:
            raise UnreadError("CYCL DEF 205 that breaks its chips for ever")
        within = [
            low for low in (start - every * k for k in range(1, int((start - end) / every) + 1)) if low > end + 1e-9
        ]
        stops += [*within, end]
        most = max(most, len(within))
    return tuple(stops), most


def _turns(order: Sequence[int], degrees: Sequence[float]) -> Array:
    """Turns about axes (0 to 2) of the frame as it has been turned so far."""
    whole = np.eye(3)
    for axis, angle in zip(order, degrees, strict=True):
        whole = whole @ rotation(axis, np.array([deg_to_rad(angle)]))[0]
    return whole


def spatial_plane(spatial: Sequence[float]) -> Array:
    """(3, 3): PLANE SPATIAL turns about the fixed X by SPA, then the fixed Y by SPB, then the fixed Z by SPC."""
    a, b, c = spatial
    return _turns((2, 1, 0), (c, b, a))


def swivelled_plane(values: Sequence[float | None]) -> tuple[Array, Array] | None:
    """(3, 3) and origin (3,) in the program's unit that CYCLE800 sets, None for its call without values.

    Raises UnreadError for modes other than axis by axis, and for a plane that adds to another.
    """
    if not values:
        return None
    state, mode, *rest = [value or 0.0 for value in (*values, *[0.0] * 13)][2:13]
    order = [(int(mode) >> shift & 3) - 1 for shift in (0, 2, 4)]
    if int(mode) >> 6 or int(state) % 10 == 1 or -1 in order:
        raise UnreadError("CYCLE800 other than axis by axis, or that adds to another")
    turned = _turns(order, rest[3:6])
    return turned, np.array(rest[:3]) + turned @ np.array(rest[6:9])
