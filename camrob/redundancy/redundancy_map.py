"""The map of the redundancy: along the path, what each spare freedom could be while the others stay as they were chosen.

A slice through the chosen postures, a freedom at a time: where the tool is out of reach, where an axis of the arm is beyond its
limit, where something touches, and 1/k_F elsewhere. The chosen line runs through the middle of all slices.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.errors import CellError
from camrob.kinematics.arm import reach
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.freedoms import PlanSpace, conditioning, plan_space, plan_work, pose_in_foot
from camrob.redundancy.solution import Solution

__all__ = [
    "BEYOND_LIMIT",
    "ELSEWHERE",
    "OUT_OF_REACH",
    "TOUCHES",
    "FreedomMap",
    "RedundancyMap",
    "Touches",
    "redundancy_map",
]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Touches = Callable[[Array, Ints], NDArray[np.bool_]]
"""Whether postures (K, n), at points (K,) of the path, touch something."""

OUT_OF_REACH, BEYOND_LIMIT, ELSEWHERE, TOUCHES = -1.0, -2.0, -3.0, -4.0  # what stands for a 1/k_F that isn't there
_COLUMNS, _ROWS = 208, 101  # places of the path, values of a freedom: what a page is wide, and a picture high
_PER_TOUCH = (16, 10)  # columns and rows for which one posture is asked what it touches: that costs milliseconds
_BRANCHES = 8  # of an arm, at most


@dataclass(frozen=True, slots=True)
class FreedomMap:
    """One freedom's slice. joint: its index in the chain; values (M,), rad or m; look (P, M): 1/k_F of the arm on the branch that
    it has there, or OUT_OF_REACH, BEYOND_LIMIT, ELSEWHERE (the arm has to be in another of its postures), TOUCHES.
    """

    joint: int
    values: Array
    look: Array


@dataclass(frozen=True, slots=True)
class RedundancyMap:
    """Slices through a solution at points (P,) of its path, evenly along its length; touched: whether touching was asked."""

    point: Ints
    freedoms: tuple[FreedomMap, ...]
    touched: bool


def redundancy_map(
    cell: Cell, path: ToolPathInBase, solution: Solution, touches: Touches | None = None
) -> RedundancyMap | None:
    """The map of a solution's freedoms; None where the cell has none, or the arm's geometry no closed form.

    Cost: some 60 000 postures, 0.3 s, and what `touches` takes for one in 160 of those that are possible.
    """
    try:
        space = plan_space(cell)
    except CellError:
        return None
    if not len(space.free) or len(path) < 2:
        return None
    length = np.asarray(path.length)
    point = np.searchsorted(length, np.linspace(0.0, length[-1], _COLUMNS)).clip(0, len(path) - 1).astype(np.int64)
    q = np.asarray(solution.q)[point]
    base_T_tip = np.ascontiguousarray(base_T_tool(cell, q))  # frames: tool is tip
    u, arm = np.ascontiguousarray(q[:, space.free]), np.ascontiguousarray(q[:, cell.arm_slice])
    branch = _branches(space, base_T_tip, u, arm)
    maps = []
    for f, joint in enumerate(space.free.tolist()):
        values = _range(space, f, np.asarray(solution.q)[:, joint])
        look, postures = _slice(space, base_T_tip, u, arm, branch, f, values)
        if touches is not None:
            _mark_touching(look, postures, q, cell, joint, values, point, touches)
        maps.append(FreedomMap(joint, values, look))
    return RedundancyMap(point, tuple(maps), touches is not None)


def _range(space: PlanSpace, f: int, used: Array) -> Array:
    """The values (M,) of a freedom that are looked at: its range, or a whole turn about what is used of an endless one."""
    low, high = float(space.u_lower[f]), float(space.u_upper[f])
    if not (np.isfinite(low) and np.isfinite(high)):
        middle = 0.5 * (float(used.min()) + float(used.max()))
        half = max(np.pi, 0.55 * float(np.ptp(used)))
        low, high = middle - half, middle + half
    return np.linspace(low, high, _ROWS)


@kernel
def _branches(space: PlanSpace, base_T_tip: Array, u: Array, arm: Array) -> Ints:
    """The branch (P,) that the arm's postures (P, 6) are on, -1 for none."""
    out = np.full(len(u), -1)
    work = plan_work()
    for k in range(len(u)):
        pose_in_foot(space, base_T_tip[k], u[k], work)
        reach(space.arm, space.screws, work.Rt, work.pt, arm[k], work.Q, work.why)
        least = 1e-4  # rad: two branches that are nearer than this are one
        for b in range(_BRANCHES):
            if work.why[b] == BRANCH_OK:
                off = 0.0
                for i in range(6):
                    off = max(off, abs(work.Q[b, i] - arm[k, i]))
                if off < least:
                    least, out[k] = off, b
    return out


@kernel
def _slice(
    space: PlanSpace, base_T_tip: Array, u: Array, arm: Array, branch: Ints, f: int, values: Array
) -> tuple[Array, Array]:
    """What the values (M,) of freedom f come to at each place: (P, M) as in `FreedomMap`, and the arm's postures (P, M, 6)."""
    P, M = len(u), len(values)
    look, postures = np.full((P, M), OUT_OF_REACH), np.zeros((P, M, 6))
    work = plan_work()
    own = np.empty(u.shape[1])
    for k in range(P):
        own[:] = u[k]
        for m in range(M):
            own[f] = values[m]
            pose_in_foot(space, base_T_tip[k], own, work)
            if reach(space.arm, space.screws, work.Rt, work.pt, arm[k], work.Q, work.why) == 0:
                continue
            look[k, m] = BEYOND_LIMIT
            for b in range(_BRANCHES):
                if work.why[b] != BRANCH_OK:
                    continue
                inside = True
                for i in range(6):
                    inside = inside and space.lower[i] <= work.Q[b, i] <= space.upper[i]
                if not inside:
                    continue
                if b == branch[k]:
                    postures[k, m] = work.Q[b]
                    look[k, m] = conditioning(space, postures[k, m], work)
                    break
                look[k, m] = ELSEWHERE
    return look, postures


def _mark_touching(
    look: Array, postures: Array, q: Array, cell: Cell, joint: int, values: Array, point: Ints, touches: Touches
) -> None:
    """TOUCHES where a posture does, asked in the middle of each block of `_PER_TOUCH`; not beside what was chosen, which is
    checked point by point elsewhere.
    """
    (by_k, by_m), (P, M) = _PER_TOUCH, look.shape
    k, m = (x.ravel() for x in np.meshgrid(np.arange(by_k // 2, P, by_k), np.arange(by_m // 2, M, by_m), indexing="ij"))
    possible = look[k, m] >= 0.0
    k, m = k[possible], m[possible]
    if not len(k):
        return
    asked = q[k].copy()
    asked[:, joint] = values[m]
    asked[:, cell.arm_slice] = postures[k, m]
    hit = touches(asked, point[k])
    beside = np.abs(values - q[:, joint, None]) < 1.5 * (values[1] - values[0])
    for a, b in zip(k[hit], m[hit], strict=True):
        part = slice(a - by_k // 2, a + by_k // 2), slice(b - by_m // 2, b + by_m // 2)
        block = look[part]
        block[(block >= 0.0) & ~beside[part]] = TOUCHES
