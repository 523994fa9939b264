"""A plan's dips as a program can say them: a speed for every motion, and a few more targets where one motion holds a dip.

A program has one `$VEL.CP` a motion. Where the planned speed falls within a long motion, before a corner, say, points are put
onto the motion, so that its slow part has a speed of its own. What the controller's ramps then still pass is lowered
(`held_speeds`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.frozen import locked
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.spherical_wrist import BRANCH_OK, solve_arm_many
from camrob.redundancy.path import ToolPathInBase
from camrob.se3 import pose, rotation_exp, slerp
from camrob.timing.held import held_speeds
from camrob.timing.optimal import FeedPlan, coarsen
from camrob.timing.smooth_runs import least_between
from camrob.units import mm_to_m

__all__ = ["WrittenFeed", "written_feed"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_DIP = 0.85  # of the fastest speed on a motion: a slower place than that gets a speed of its own
_LOST = 0.05  # s that a motion, or a part of it, may lose by going at its slowest place's speed
# mm between targets at the least; twice `$APO.CDIS` where that is more, so that none cuts a rounding short
_APART = 1.0
_OFF = 0.05  # rad: an arm posture farther from its neighbours' than this is on another branch
_TOLERANCE = 0.02  # how far a speed may stay below the plan so that it changes rarely


@dataclass(frozen=True, slots=True)
class WrittenFeed:
    """A path with a program's targets: `added` (N,) True for those that lie between the given path's points.

    q: (N, n) postures, speed: (N,) m/s to write for the motion to each point.
    """

    path: ToolPathInBase
    q: Array
    speed: Array
    added: NDArray[np.bool_]

    def __post_init__(self) -> None:
        n = len(self.path)
        object.__setattr__(self, "q", locked(self.q, shape=(n, None), name="q"))
        object.__setattr__(self, "speed", locked(self.speed, shape=(n,), name="speed"))
        object.__setattr__(self, "added", locked(self.added, shape=(n,), dtype=np.bool_, name="added"))

    def spread(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the given path's points (M, ...) for these (N, ...): an added point has those of the point it leads to."""
        own = np.cumsum(~self.added)
        return np.asarray(values)[np.where(self.added, own, own - 1)]


def written_feed(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    plan: FeedPlan,
    *,
    cells: Sequence[Cell] = (),
    motion_ends: NDArray[np.bool_] | None = None,
) -> WrittenFeed:
    """The targets and speeds that say a plan of a path with postures q (N, n), as the controller's model can hold them.

    cells: the cell with the tool of each stretch of the path, where they differ. motion_ends: (N,) True where a motion of the
    program ends without the added points, by default everywhere.

    Added points lie on the straight way between their neighbours, the tool's axis on its great arc, turned about it as far as
    the orientation is on its own, external axes in between; the arm follows by its closed form (an arm without one gets no
    points). Raises ValueError for arrays that don't fit.
    """
    q = np.asarray(q, float)
    point, share = _cuts(path, plan, max(mm_to_m(_APART), 2.0 * mm_to_m(cell.controller.apo_cdis_mm)))
    between, new, reached = (
        np.zeros((len(point), len(cell))),
        np.zeros((len(point), 4, 4)),
        np.zeros(len(point), np.bool_),
    )
    for k, tooled in enumerate(cells or (cell,)):
        here = np.flatnonzero(path.stretch[point] == k) if cells else np.arange(len(point))
        arm = Arm.of(tooled)
        if arm.closed is not None and len(here):
            before = point[here] - 1
            between[here], reached[here] = _postures(arm, q[before], q[before + 1], share[here])
            new[here] = base_T_tool(tooled, between[here])
    point, share, between, new = point[reached], share[reached], between[reached], new[reached]
    added = np.insert(np.zeros(len(path), np.bool_), point, True)
    frames = np.insert(np.asarray(path.base_T_tip), point, new, axis=0)
    columns = {
        name: np.insert(getattr(path, name), point, getattr(path, name)[point])
        for name in ("move", "feed", "line", "region", "safe", "stretch")
    }
    refined = ToolPathInBase(base_T_tip=frames, source=np.insert(path.source, point, -1), **columns)
    postures = np.insert(q, point, between, axis=0)
    at = np.arange(len(path), dtype=np.float64)
    at = np.insert(at, point, point - 1 + share)
    speed = _speeds(refined, plan, added, at)
    programmed = np.where(refined.cutting, refined.feed, speed)
    stops = None if motion_ends is None else np.insert(motion_ends, point, True)
    held = held_speeds(cell, refined, postures, speed, programmed, stops)
    return WrittenFeed(refined, postures, held, added)


def _cuts(path: ToolPathInBase, plan: FeedPlan, apart: float) -> tuple[Indices, Array]:
    """Where motions are parted: the point (E,) that each leads to, and the share (E,) of its way."""
    way = path.step
    ends = np.flatnonzero(path.cutting & (way >= 2.0 * apart))
    ends = ends[ends > 0]
    if not len(ends) or not len(plan.place):
        return np.zeros(0, np.int64), np.zeros(0)
    first, last = _samples(plan, (ends - 1).astype(np.float64), ends.astype(np.float64))
    slow, fast = least_between(plan.free, first, last), -least_between(-np.asarray(plan.free), first, last)
    points: list[int] = []
    shares: list[float] = []
    for k in np.flatnonzero((slow < _DIP * fast) | (way[ends] * (1.0 / slow - 1.0 / fast) > _LOST)).tolist():
        end, length, part = int(ends[k]), float(way[ends[k]]), slice(int(first[k]), int(last[k]) + 1)
        share = np.clip(np.asarray(plan.place[part]) - (end - 1), 0.0, 1.0)
        found = _parts(length * share, np.asarray(plan.free[part]), apart)
        points += [end] * len(found)
        shares += [at / length for at in found]
    return np.array(points, np.int64), np.array(shares)


def _parts(way: Array, speed: Array, apart: float) -> list[float]:
    """Places, m, at which a motion is parted, so that on no part its slowest speed says too little (`_DIP`, `_LOST`)."""
    cuts: list[float] = []
    start, before, seconds = float(way[0]), float(way[0]), 0.0
    last = low = high = float(speed[0])
    for at, value in zip(way[1:].tolist(), speed[1:].tolist(), strict=True):
        slow, fast = min(low, value), max(high, value)
        spent = seconds + 2.0 * (at - before) / (value + last)
        too_little = slow < _DIP * fast or (at - start) / slow - spent > _LOST
        if too_little and before - start >= apart and way[-1] - before >= apart:
            cuts.append(before)
            start, low, high = before, min(last, value), max(last, value)
            spent -= seconds
        else:
            low, high = slow, fast
        seconds, before, last = spent, at, value
    return cuts


def _samples(plan: FeedPlan, start: Array, stop: Array) -> tuple[Indices, Indices]:
    """First and last sample of the plan that bear on stretches from `start` to `stop`, in points."""
    most = len(plan.place) - 1
    first = np.clip(np.searchsorted(plan.place, start, side="right") - 1, 0, most)
    return first, np.clip(np.searchsorted(plan.place, stop, side="left"), first, most)


def _postures(arm: Arm, before: Array, after: Array, share: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Postures (E, n) on the straight motions between two, and which of them the arm reaches on the same branch (E,)."""
    cell, part = arm.cell, arm.cell.arm_slice
    q = before + share[:, None] * (after - before)
    ends = []
    for posture in (before, after):
        real = posture.copy()
        real[:, list(cell.indices(Role.ROLL))] = 0.0
        ends.append(base_T_tool(cell, real))
    between = ends[0][:, :3, 3] + share[:, None] * (ends[1][:, :3, 3] - ends[0][:, :3, 3])
    turned = slerp(ends[0][:, :3, :3], ends[1][:, :3, :3], share)
    target = pose(_leaning(turned, ends[0][:, :3, 2], ends[1][:, :3, 2], share), between)
    unrolled = q.copy()
    unrolled[:, list(cell.indices(Role.ROLL))] = 0.0
    near = np.ascontiguousarray(q[:, part])
    if arm.closed is None:
        return q, np.zeros(len(q), np.bool_)
    found, why = solve_arm_many(arm.closed, np.ascontiguousarray(arm.foot_T_tool(target, unrolled)), near)
    off = np.abs(found - near[:, None]).max(axis=2)
    off[why != BRANCH_OK] = np.inf
    best = np.argmin(off, axis=1)
    rows = np.arange(len(q))
    q[:, part] = found[rows, best]
    inside = np.all((q[:, part] >= cell.q_lower[part]) & (q[:, part] <= cell.q_upper[part]), axis=1)
    return q, inside & (off[rows, best] < _OFF)


def _leaning(turned: Array, start: Array, end: Array, share: Array) -> Array:
    """Orientations (E, 3, 3) with their tool axes brought onto the great arcs from `start` to `end` (E, 3), the shortest way.

    Where a motion also turns the tool about its axis, an orientation on the great arc of orientations has its axis beside
    that of the axes, and that is the file's. Opposite axes have no great arc of their own and keep what they have.
    """
    turn = _turn(start, end)
    wanted = (rotation_exp(share[:, None] * turn) @ start[:, :, None])[:, :, 0]
    known = np.any(turn, axis=1, keepdims=True)
    return np.asarray(rotation_exp(_turn(turned[:, :, 2], wanted) * known) @ turned)


def _turn(start: Array, end: Array) -> Array:
    """Rotation vectors (E, 3) that bring axes `start` to `end` (E, 3) the shortest way; zero for opposite ones."""
    across = np.cross(start, end)
    sine = np.linalg.norm(across, axis=1)
    known = sine > 1e-12
    angle = np.arctan2(sine, np.sum(start * end, axis=1))
    return np.asarray(across * np.where(known, angle / np.where(known, sine, 1.0), 0.0)[:, None])


def _speeds(path: ToolPathInBase, plan: FeedPlan, added: NDArray[np.bool_], at: Array) -> Array:
    """Speeds (N,) of a path's motions: the slowest that the plan has on each, alike where they differ little.

    at: (N,) the points' places in the plan.
    """
    cutting = path.cutting.copy()
    cutting[:1] = False
    speed = np.insert(plan.speed, np.flatnonzero(added) - np.arange(np.count_nonzero(added)), 0.0)
    ends = np.flatnonzero(cutting)
    if not len(ends) or not len(plan.place):
        return speed
    first, last = _samples(plan, at[ends - 1], at[ends])
    speed[ends] = np.minimum(least_between(plan.free, first, last), path.feed[ends])
    borders = np.flatnonzero(np.diff(cutting.astype(np.int8), prepend=0, append=0))
    for start, stop in pairwise(borders.tolist()):
        if cutting[start]:
            speed[start:stop] = coarsen(speed[start:stop], _TOLERANCE)
    return speed
