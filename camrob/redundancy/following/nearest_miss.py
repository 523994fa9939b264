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
from camrob.kinematics.screw_arm import solve_screws_many
from camrob.kinematics.spherical_wrist import BRANCH_OK, solve_arm_many
from camrob.product_grid import product_grid

__all__ = ["IN_REACH", "Miss", "beyond_span", "nearest_miss", "way_into_span"]

Array = NDArray[np.float64]

IN_REACH = "in reach"
"""What a tally calls branches that reach a pose within limits."""

_TURN, _SPAN = 12, 9  # values of an endless axis, and of one with limits, that a scan goes through
_FROM = 8  # of its nodes, the nearest, from which a compass search goes on
_LAST = 1e-4  # rad and m, its last step
# axes at most that a search also moves together: what is passed has edges, along which no axis alone leads on
_ASKEW = 5
_NODES, _TOGETHER = 20_000, 4_096  # of a scan at most, and of them at once: some 10 MB
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
    values = _scanned([_values(cell.joints[i]) for i in free])
    grid = product_grid(values)
    tally: dict[str, int] = {}

    def past(u: Array, count: bool = False) -> tuple[Array, Array]:
        q = np.tile(near, (len(u), 1))
        q[:, free] = u
        return _excess(arm, base_T_tip, q, cell.arm_slice, tally if count else None)

    parts = [past(grid[k : k + _TOGETHER], count=True)[0] for k in range(0, len(grid), _TOGETHER)]
    excess = np.concatenate(parts)
    order = np.argsort(excess, kind="stable")[:_FROM]
    u = grid[order[:1]]
    if (
        0.0 < excess[order[0]] < np.inf and not arm.searched
    ):  # where each posture is a search, the scan alone takes minutes
        some = order[np.isfinite(excess[order])]
        steps = np.array([(v[1] - v[0]) / 2.0 for v in values])
        u = _searched(past, grid[some], excess[some], steps, cell.q_lower[free], cell.q_upper[free])
    least, posture = past(u)
    k = int(np.argmin(least))
    if not np.isfinite(least[k]):
        return Miss(tally, len(grid), names, {}, None)
    if least[k] <= 0.0 and not tally.get(IN_REACH):
        tally[IN_REACH] = 1
    best = posture[k]
    over = dict(zip(cell.names[cell.arm_slice], _past_limits(arm, best[cell.arm_slice]).tolist(), strict=True))
    return Miss(tally, len(grid), names, {name: v for name, v in over.items() if v > 0.0}, best)


def _scanned(values: list[Array]) -> list[Array]:
    """The values with every second one of the longest left out until the scan has no more than _NODES."""
    while np.prod([len(v) for v in values]) > _NODES:
        k = int(np.argmax([len(v) for v in values]))
        values[k] = values[k][::2]
    return values


def _values(joint: Joint) -> Array:
    low, high = (-np.pi, np.pi) if joint.endless else (joint.q_lower, joint.q_upper)
    if not joint.prismatic and high - low >= 2.0 * np.pi:  # a turn is all there is
        middle = 0.5 * (low + high)
        return np.linspace(middle - np.pi, middle + np.pi, _TURN, endpoint=False)
    return np.linspace(low, high, _SPAN)


def _excess(arm: Arm, base_T_tip: Array, q: Array, part: slice, tally: dict[str, int] | None) -> tuple[Array, Array]:
    """By how much (M,), rad, all joints together, the branch that passes the limits least passes them, and its posture (M, n).

    q (M, n): the values of the joints that are not the arm's, and angles that turns are to be near to. Infinite, and q itself,
    where there is no branch; tally <- what all of them meet.
    """
    Q, met = _postures(arm, arm.foot_T_tool(base_T_tip, q), q[:, part])  # frames: tip is tool
    passed = np.maximum(arm.lower - Q, Q - arm.upper) > 1e-9
    if tally is not None:
        beyond = np.where(passed.any(axis=2), passed.argmax(axis=2), 6)
        names = [*(f"at A{i + 1}'s limit" for i in range(6)), IN_REACH, "out of reach"]
        counts = [*np.bincount(beyond[met], minlength=7).tolist(), arm.together * int(np.sum(~met.any(axis=1)))]
        for name, count in zip(names, counts, strict=True):
            if count:
                tally[name] = tally.get(name, 0) + count
    over = np.where(met, _past_limits(arm, Q).sum(axis=2), np.inf)
    best = over.argmin(axis=1)
    each = np.arange(len(q))
    posture, least = q.copy(), over[each, best]
    found = np.isfinite(least)
    posture[found, part] = Q[each, best][found]
    return least, posture


def _postures(arm: Arm, foot_T_tool: Array, near: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Postures (M, B, 6) of poses (M, 4, 4) and which there are (M, B): `Arm.turned` of many poses at once."""
    if arm.searched:
        each = [arm.turned(pose, own) for pose, own in zip(foot_T_tool, near, strict=True)]
        Q = np.zeros((len(each), max(1, *map(len, each)), 6))
        for own, solutions in zip(Q, each, strict=True):
            own[: len(solutions)] = np.reshape(solutions, (-1, 6))  # there may be none
        return Q, np.arange(Q.shape[1]) < np.array([len(solutions) for solutions in each])[:, None]
    poses, starts = np.array(foot_T_tool, float, order="C"), np.array(near, float, order="C")
    if arm.closed is not None:
        Q, why = solve_arm_many(arm.closed, poses, starts)
    else:
        Q, why = solve_screws_many(arm.screws, poses, starts)
    turn = 2.0 * np.pi  # as many as bring an angle into its range, and none that would bring it past the range
    Q += turn * np.maximum(np.minimum(np.ceil((arm.lower - Q) / turn), np.floor((arm.upper - Q) / turn)), 0.0)
    Q -= turn * np.maximum(np.minimum(np.ceil((Q - arm.upper) / turn), np.floor((Q - arm.lower) / turn)), 0.0)
    return Q, why == BRANCH_OK


def _past_limits(arm: Arm, q: Array) -> Array:
    """rad, by joint (..., 6)."""
    over = np.maximum(arm.lower - q, q - arm.upper)
    return np.asarray(np.where(over > 1e-9, over, 0.0))


def _searched(
    past: Callable[[Array], tuple[Array, Array]], u: Array, value: Array, steps: Array, lower: Array, upper: Array
) -> Array:
    """Values (S, F) of the free axes in which limits are passed less, from u (S, F) on, by compass searches side by side.

    One that is within the limits ends them all. steps (F,): the first.
    """
    u, before, best, share = u.copy(), u.copy(), value.copy(), np.ones(len(u))
    if len(steps) <= _ASKEW:
        ways = steps * product_grid([np.array([-1.0, 1.0, 0.0])] * len(steps))
    else:
        ways = np.vstack([np.diag(steps), -np.diag(steps), np.zeros(len(steps))])
    each = np.arange(len(u))
    while best.min() > 0.0 and share.max() * steps.max(initial=0.0) > _LAST:
        trial = u[:, None] + share[:, None, None] * ways
        trial[:, -1] += u - before  # on as it went
        trial = np.clip(trial, lower, upper)
        there = past(trial.reshape(-1, u.shape[1]))[0].reshape(len(u), -1)
        way = there.argmin(axis=1)
        better = there[each, way] < best
        before = u.copy()
        u[better], best[better] = trial[each, way][better], there[each, way][better]
        share[~better] *= 0.5
    return u


def beyond_span(cell: Cell, arm: Arm, base_T_tip: Array) -> float:
    """m: the tip is farther from the arm's first axis than the arm is long, stretched, by this at least, wherever the external
    axes stand; 0 where that is not shown.
    """
    return float(np.linalg.norm(way_into_span(cell, arm, base_T_tip)))


def way_into_span(cell: Cell, arm: Arm, base_T_tip: Array) -> Array:
    """(3,) m in `base`: towards where the foot stands nearest, as long as the tip is at least beyond the stretched arm; else 0.

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

    def towards(u: Array) -> Array:
        q = np.tile(cell.q_home, (len(u), 1))
        q[:, outer] = u
        base_T_foot = base_T_root(cell, q) @ np.linalg.inv(np.asarray(cell.foot_T_root))
        return np.asarray((base_T_foot @ foot_P)[:, :3] - base_T_tip[:3, 3])

    def distance(u: Array) -> Array:
        return np.asarray(np.linalg.norm(towards(u), axis=1))

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
    beyond = max(float(least.min()) - span - 1e-9, 0.0)
    way = towards(middle[np.argmin(at)][None])[0]
    return np.asarray(way * (beyond / max(float(np.linalg.norm(way)), 1e-9)))


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
