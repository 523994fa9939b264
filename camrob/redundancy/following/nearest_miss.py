"""Whether any posture reaches a pose, and how far the nearest one is from doing so: what a refusal may say, and what it rests on.

Out of the arm's span wherever the external axes stand is proved; that every branch passes a limit is searched, but for a cell
without spare freedoms, whose branches are all there is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_root
from camrob.product_grid import product_grid

__all__ = ["Miss", "beyond_span", "nearest_miss"]

Array = NDArray[np.float64]

_TURN, _SPAN = 12, 9  # values of an endless axis, and of one with limits, that a scan goes through
_FROM = 4  # of its nodes, the nearest, from which a compass search goes on
_LAST = 1e-4  # rad and m, its last step
_BOXES = 2000  # of external axes at most, in which the least distance is looked for: half a second
_FINE = 0.01  # m within which it is found


@dataclass(frozen=True, slots=True)
class Miss:
    """What was found at a pose.

    tally: what the scan's branches meet, reason to count, "in reach" among them. values: how many values of `axes` were tried;
    q: the posture that passes the arm's limits least, None where the arm reaches the pose by none whatever its limits; past: by
    how much each joint passes them there, rad.
    """

    tally: dict[str, int]
    values: int
    axes: tuple[str, ...]
    past: dict[str, float]
    q: Array | None

    @property
    def reached(self) -> bool:
        """Whether a posture reaches the pose."""
        return self.q is not None and not self.past


def nearest_miss(cell: Cell, arm: Arm, base_T_tip: Array, near: Array) -> Miss:
    """What an even scan over external axes, roll and branches meets at a pose, and a search from its nearest nodes on."""
    free = [i for i, joint in enumerate(cell.joints) if joint.role is not Role.ARM]
    names = tuple(cell.joints[i].name for i in free)
    grid = product_grid([_values(cell.joints[i]) for i in free])
    tally: dict[str, int] = {}
    excess = np.empty(len(grid))

    def past(u: Array, count: bool = False) -> tuple[float, Array | None]:
        q = near.copy()
        q[free] = u
        foot_T_tool = arm.foot_T_tool(base_T_tip, q)  # frames: tip is tool
        return _excess(arm, foot_T_tool, q, cell.arm_slice, tally if count else None)

    for k, u in enumerate(grid):
        excess[k] = past(u, count=True)[0]
    order = np.argsort(excess, kind="stable")[:_FROM]
    found = [grid[order[0]]]
    if (
        0.0 < excess[order[0]] < np.inf and not arm.searched
    ):  # where each posture is a search, the scan alone takes minutes
        found = [_searched(cell, free, past, grid[k], excess[k]) for k in order if excess[k] < np.inf]
    least, best = min((past(u) for u in found), key=lambda v: v[0])
    if best is None:
        return Miss(tally, len(grid), names, {}, None)
    if least <= 0.0 and not tally.get("in reach"):
        tally["in reach"] = 1
    over = dict(zip(cell.names[cell.arm_slice], _past_limits(arm, best[cell.arm_slice]).tolist(), strict=True))
    return Miss(tally, len(grid), names, {name: v for name, v in over.items() if v > 0.0}, best)


def _values(joint: Joint) -> Array:
    low, high = (-np.pi, np.pi) if joint.endless else (joint.q_lower, joint.q_upper)
    if not joint.prismatic and high - low >= 2.0 * np.pi:  # a turn is all there is
        middle = 0.5 * (low + high)
        return np.linspace(middle - np.pi, middle + np.pi, _TURN, endpoint=False)
    return np.linspace(low, high, _SPAN)


def _excess(
    arm: Arm, foot_T_tool: Array, q: Array, part: slice, tally: dict[str, int] | None
) -> tuple[float, Array | None]:
    """By how much, rad, all joints together, the branch that passes the limits least passes them, and its posture.

    Infinite, and None, where there is no branch; tally <- what all of them meet.
    """
    least, posture = np.inf, None
    solutions = arm.turned(foot_T_tool, q[part])
    if tally is not None:
        for met in [arm.passed(own) or "in reach" for own in solutions] or ["out of reach"] * arm.together:
            tally[met] = tally.get(met, 0) + 1
    for own in solutions:
        over = float(_past_limits(arm, own).sum())
        if over < least:
            least, posture = over, q.copy()
            posture[part] = own
    return least, posture


def _past_limits(arm: Arm, q: Array) -> Array:
    """rad, by joint (6,)."""
    over = np.maximum(arm.lower - q, q - arm.upper)
    return np.asarray(np.where(over > 1e-9, over, 0.0))


def _searched(
    cell: Cell, free: list[int], past: Callable[[Array], tuple[float, Array | None]], start: Array, value: float
) -> Array:
    """Values of the free axes from `start` on, by a compass search, in which the limits are passed less."""
    lower, upper = cell.q_lower[free], cell.q_upper[free]
    u, best = start.copy(), value
    steps = np.array([(v[1] - v[0]) / 2.0 for v in (_values(cell.joints[i]) for i in free)])
    while best > 0.0 and len(free) and steps.max() > _LAST:
        moved = False
        for i in range(len(u)):
            for sign in (1.0, -1.0):
                trial = u.copy()
                trial[i] = np.clip(trial[i] + sign * steps[i], lower[i], upper[i])
                there = past(trial)[0]
                if there < best:
                    u, best, moved = trial, there, True
                    break
        if not moved:
            steps = 0.5 * steps
    return u


def beyond_span(cell: Cell, arm: Arm, base_T_tip: Array) -> float:
    """m: the tip is farther from the arm's first axis than the arm is long, stretched, by this at least, wherever the external
    axes stand; 0 where that is not shown.

    From the middle of a box of the external axes the foot moves by no more than each axis's half times its lever.
    """
    chain = arm.chain
    span = float(np.linalg.norm(chain.after[:, :3, 3], axis=1).sum())
    outer = [i for i, joint in enumerate(cell.joints) if joint.role not in (Role.ARM, Role.ROLL)]
    low, high = cell.q_lower[outer].copy(), cell.q_upper[outer].copy()
    turning = np.array([not cell.joints[i].prismatic for i in outer], bool)
    whole = turning & ~(high - low < 2.0 * np.pi)  # a turn is all there is
    low[whole], high[whole] = -np.pi, np.pi
    lever = _levers(cell, outer, arm)
    foot_P = np.append(chain.first[:3, 3], 1.0)

    def distance(u: Array) -> Array:
        q = np.tile(cell.q_home, (len(u), 1))
        q[:, outer] = u
        base_T_foot = base_T_root(cell, q) @ np.linalg.inv(np.asarray(cell.foot_T_root))
        return np.asarray(np.linalg.norm((base_T_foot @ foot_P)[:, :3] - base_T_tip[:3, 3], axis=1))

    middle, half = np.atleast_2d(0.5 * (low + high)), np.atleast_2d(0.5 * (high - low))
    at = distance(middle)
    least = at - half @ lever
    while len(outer) and len(least) < _BOXES and at.min() > span and least.min() < at.min() - _FINE:
        k = int(np.argmin(least))
        i = int(np.argmax(half[k] * lever))
        half[k, i] *= 0.5
        pair = np.repeat(middle[k : k + 1], 2, axis=0)
        pair[:, i] += (-half[k, i], half[k, i])
        there = distance(pair)
        middle[k], at[k] = pair[0], there[0]
        middle, half, at = np.vstack([middle, pair[1:]]), np.vstack([half, half[k]]), np.append(at, there[1])
        least = np.append(least, there[1] - half[k] @ lever)
        least[k] = there[0] - half[k] @ lever
    return float(max(least.min() - span - 1e-9, 0.0))


def _levers(cell: Cell, outer: list[int], arm: Arm) -> Array:
    """How far each external axis (E,) moves the foot at most, m a rad or m a m: what stands between them, stretched."""
    levers, behind = np.zeros(len(outer)), float(np.linalg.norm(arm.chain.first[:3, 3]))
    for n in range(len(outer) - 1, -1, -1):
        joint = cell.joints[outer[n]]
        behind += float(np.linalg.norm(joint.after[:3, 3]))
        levers[n] = 1.0 if joint.prismatic else behind
        behind += float(np.linalg.norm(joint.before[:3, 3]))
        if joint.prismatic:
            behind += float(max(abs(joint.q_lower), abs(joint.q_upper)))
    return levers
