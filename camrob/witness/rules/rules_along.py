"""One motion of the program beside one of the file: how far it runs along it, and how a hole is drilled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Pecks
from camrob.witness.rules.rules_geometry import AXIS, POSITION, Motion, Track, Vec, along_ray, distance
from camrob.witness.units import deg_to_rad, m_to_mm

__all__ = ["MOVED", "Stroke", "Tolerance", "step_along", "strokes", "unlike_pecks"]

_SOFT, _FREE = 0.1, 0.3  # of a turn: within a statement, and in a rapid
_SOFT_MOST = deg_to_rad(0.5)
MOVED = 1e-6  # m: less than this of a motion is rounding
_JOINED = 0.01  # of a peck: what is left of less at the bottom may go with the one before it


@dataclass(frozen=True, slots=True)
class Tolerance:
    """`chord`: m, for arcs that the program runs in chords. `decimated`: m, where the set-up lets points be left out."""

    chord: float = 0.0
    decimated: float = 0.0

    @property
    def place(self) -> float:
        """Of the tip, m."""
        return POSITION + self.decimated

    @property
    def axis(self) -> float:
        """Of the tool's axis, rad. A point left out takes its axis along: as far as tip and a point 50 mm up go likewise."""
        return AXIS + self.decimated / 0.05


def step_along(
    leg: Motion,
    v: float,
    way: Motion,
    u: float,
    tol: Tolerance,
    beyond: Motion | None,
    soft: bool = False,
    free: bool = False,
    statement: Motion | None = None,
) -> tuple[float, float] | None:
    """How far the program's motion (from its fraction v) and the file's (from u) run together: fractions (u, v) of both.

    u is 1 at the file's own end, v 1 at the program's; None where they part at once. beyond: the file's next motion, for
    points that lie nearer together than the tolerance: the program's end is then the nearest of them. soft: the file's
    motion ends within a statement (rotary axes that turn evenly): a motion of the program that goes by there keeps to its own
    great arc, and may be off by a tenth of its turn, half a degree at most. free: the way is a rapid, on which axes turn as
    they can: three tenths. statement: the straight motion that the file's is a piece of, where axes turn evenly along it; where
    the program's ends within, its axis may lie on the great arc of the whole, no farther off than `soft` lets it.
    """
    turn = _FREE * distance(way.axis_start, way.axis_end) if free else 0.0
    within = _within(leg, v, way, u, tol, turn, statement)
    if within is not None and (1.0 - within[0]) * way.length > 2.0 * MOVED:
        return within  # short of the end, be it by less than the tolerance
    return _to_end(leg, v, way, u, tol, beyond, statement if soft else None, soft) or within


def _to_end(
    leg: Motion,
    v: float,
    way: Motion,
    u: float,
    tol: Tolerance,
    beyond: Motion | None,
    statement: Motion | None,
    soft: bool,
) -> tuple[float, float] | None:
    """To the end of the file's motion, where that lies on the rest of the program's."""
    turn = distance(way.axis(u), way.axis_end)
    short = way.length * (1.0 - u) <= 2.0 * tol.place and turn <= 2.0 * tol.axis
    to_end = distance(leg.end, way.end)
    ends = to_end <= tol.place and distance(leg.axis_end, way.axis_end) <= tol.axis
    if leg.angle and ends and way.angle and _on_arc(leg, v, way, u, tol) is not None:
        return 1.0, 1.0
    if leg.angle:  # only what is left of a motion too short to tell
        near = short and distance(way.end, leg.point(v)) <= tol.place
        return (1.0, v) if near and distance(leg.axis(v), way.axis_end) <= tol.axis else None
    w, off = leg.nearest(way.end, way.axis_end, v)
    slack = (
        tol.chord if way.curved and tol.decimated else 0.0
    )  # with points left out, a chord goes on past a curve's end
    if off > tol.place + slack or way.sagitta(u, 1.0) > tol.place + tol.chord or (w == v and not short):
        return None
    if ends and not (beyond and not beyond.angle and distance(beyond.end, leg.end) < to_end):
        return 1.0, 1.0
    turn = min(_SOFT * distance(leg.axis_start, leg.axis_end), _SOFT_MOST) if soft else 0.0
    beside = distance(leg.axis(w), way.axis_end)
    fits = beside <= tol.axis + turn or _on_whole(leg.point(w), leg.axis(w), beside, statement, tol)
    return (1.0, w) if fits else None


def _within(
    leg: Motion, v: float, way: Motion, u: float, tol: Tolerance, turn: float, statement: Motion | None
) -> tuple[float, float] | None:
    """To the end of the program's motion, where that lies on the rest of the file's."""
    if leg.angle:
        reached = _on_arc(leg, v, way, u, tol) if way.angle else None
        return None if reached is None or reached <= u else (reached, 1.0)
    reached, off = way.nearest(leg.end, leg.axis_end, u)
    if off > tol.place or way.sagitta(u, reached) > tol.place + tol.chord or reached <= u:
        return None
    beside = distance(leg.axis_end, way.axis(reached))
    fits = beside <= tol.axis + turn or _on_whole(leg.end, leg.axis_end, beside, statement, tol)
    return (reached, 1.0) if fits else None


def _on_whole(tip: Vec, axis: Vec, beside: float, statement: Motion | None, tol: Tolerance) -> bool:
    """Whether a tool whose axis is so far `beside` the file's is on the great arc of the whole statement."""
    if statement is None or beside > min(_SOFT * distance(statement.axis_start, statement.axis_end), _SOFT_MOST):
        return False
    at, off = statement.nearest(tip, axis)
    return off <= tol.place and distance(axis, statement.axis(at)) <= tol.axis


def _on_arc(leg: Motion, v: float, way: Motion, u: float, tol: Tolerance) -> float | None:
    """The fraction of the file's arc that a program's arc reaches, never off it and never backwards; None where it does."""
    count = max(4, math.ceil(leg.angle / 0.4))
    for k in range(1, count + 1):
        f = v + (1.0 - v) * k / count
        w, off = way.nearest(leg.point(f), leg.axis(f), u)
        turned = (w - u) * way.angle > math.pi
        if off > tol.place or turned or distance(leg.axis(f), way.axis(w)) > tol.axis:
            return None
        u = w
    return u


class Stroke(NamedTuple):
    """One motion in a hole.

    peck: how deep the peck is at its end, m, 0 where it goes no deeper than those before it. low: m below where the hole's motion
    starts that it ends.
    """

    peck: float
    low: float


def strokes(prog: Track, ptp: NDArray[np.bool_], j: int, hole: Motion, tol: Tolerance) -> list[Stroke] | None:
    """The motions of the program from j on that drill a hole. A peck goes on until the tool is drawn back.

    They run on the tool's axis, never deeper than the bottom; the last one reaches it. None where they don't.
    """
    depth, deepest, peck, cuts, last = hole.length, 0.0, 0.0, list[Stroke](), 0
    while j + len(cuts) < len(prog) and prog.known[j + len(cuts)] and not ptp[j + len(cuts)]:
        leg = prog.motion(j + len(cuts))
        ends = [along_ray(p, hole.start, hole.axis_end) for p in (leg.end, leg.start)]
        kept = max(distance(axis, hole.axis_end) for axis in (leg.axis_start, leg.axis_end)) <= tol.axis
        low = -ends[0][0]
        if leg.angle or not kept or max(off for _, off in ends) > tol.place or low > depth + POSITION:
            break
        peck = peck + low - deepest if low > deepest else peck * (low >= deepest - POSITION)
        cuts.append(Stroke(peck if low > deepest + MOVED else 0.0, low))
        deepest = max(deepest, low)
        if cuts[-1].peck > 0.0 and deepest >= depth - POSITION:
            last = len(cuts)  # but a last peck may go a little deeper yet
    return cuts[:last] or None


def unlike_pecks(cuts: list[Stroke], most: Pecks) -> Iterator[tuple[int, str, str]]:
    """Which of a hole's `strokes` stand against the file's pecks, the first of each kind: code and what it does.

    Where the file has the tool drawn out at a feed, that is to where the hole's motion starts, and no way through the clear.
    """
    higher = next((k for k, cut in enumerate(cuts) if cut.low < -POSITION), None) if most.fed else None
    if higher is not None:
        up = m_to_mm(-cuts[higher].low)
        yield (
            higher,
            "peck-higher",
            f"is drawn {up:.3f} mm above the height from which the file drills, within the hole",
        )
    deeper, stays = _too_deep(cuts, most), _left_in(cuts, most.breaks) if most.out else None
    if deeper is not None:
        k, limit = deeper
        deep_mm, most_mm = m_to_mm(cuts[k].peck), m_to_mm(limit)
        yield k, "peck-deeper", f"drills {deep_mm:.3f} mm at once, where the file's peck is {most_mm:.3f} mm"
    ends = None if deeper is not None else _ends_elsewhere(cuts, most)
    if ends is not None:
        k, wanted = ends
        yield (
            k,
            "peck-ends",
            f"a peck ends {m_to_mm(cuts[k].low):.3f} mm down, where the file's ends at {m_to_mm(wanted):.3f} mm",
        )
    if stays is not None:
        yield stays, "peck-left-in", "begins another peck, and the tool was not drawn out of the hole before it"
    lifted = None if most.lift is None else _lifted_otherwise(cuts, most.lift)
    if lifted is not None:
        k, back = lifted
        named = m_to_mm(most.lift or 0.0)
        yield k, "chip-break", f"breaks the chip {m_to_mm(back):.3f} mm back, where the file says {named:.3f} mm"


def _too_deep(cuts: list[Stroke], most: Pecks) -> tuple[int, float] | None:
    """The first of a hole's `strokes` whose peck goes deeper than the file's first, or others, and which of the two that is; None
    where none does.
    """
    n, back = -1, True
    for k, (peck, low) in enumerate(cuts):
        n += back and peck > 0.0
        back = not peck
        spare = 0.0 if most.lows else _JOINED * most.others
        if peck > most.deepest(max(n, 0)) + spare + POSITION or (peck and low > most.low(n) + POSITION):
            return k, most.deepest(max(n, 0))
    return None


def _ends_elsewhere(cuts: list[Stroke], most: Pecks) -> tuple[int, float] | None:
    """The first of a hole's `strokes` with which a peck ends that the file, whose pecks differ, has end elsewhere, and where that
    is; None where there is none. More and shallower pecks would leave chips in the hole that these ends keep clear.
    """
    if not most.lows:
        return None
    n, deepest, last = -1, 0.0, 0
    for k, (peck, low) in enumerate([*cuts, Stroke(0.0, 0.0)]):
        if peck:
            n, deepest, last = n + (not cuts[k - 1].peck if k else 1), max(deepest, low), k
        elif n >= 0 and abs(deepest - most.low(n)) > POSITION:
            return last, most.low(n)
    return None


def _left_in(cuts: list[Stroke], breaks: int) -> int | None:
    """The first of a hole's `strokes` that begins another peck without the tool's having been drawn out of the hole, more than
    `breaks` of them in a row; None where there is none.
    """
    highest, kept = 0.0, 0  # m below the start that the tool has come back to since the last peck
    for k, (peck, low) in enumerate(cuts):
        if not peck:
            highest = min(highest, low)
            continue
        if k and not cuts[k - 1].peck:
            kept = kept + 1 if highest > POSITION else 0
            if kept > breaks:
                return k
        highest = low
    return None


def _lifted_otherwise(cuts: list[Stroke], lift: float) -> tuple[int, float] | None:
    """The first of a hole's `strokes` that breaks the chip, which is to begin another peck from within the hole, by another way
    back than `lift`, and that way; None where there is none.
    """
    deepest = 0.0
    for k, (peck, low) in enumerate(cuts[:-1]):
        deepest = max(deepest, low)
        back = deepest - low
        broken = not peck and low > POSITION and cuts[k - 1].peck > 0.0 and cuts[k + 1].peck > 0.0
        if k and broken and abs(back - min(lift, deepest)) > POSITION:
            return k, back
    return None
