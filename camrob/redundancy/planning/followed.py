"""A plan followed by the follower as its moving reference posture, and what the follower made of it as a solution's parts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.course import Draft
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.refinement import arm_along
from camrob.redundancy.planning.waypoints import Waypoints
from camrob.redundancy.published.virtual_joint import PathFollower
from camrob.redundancy.published.weighting import even_weights
from camrob.redundancy.solution import Revision
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["Followed", "follow_plan"]

Array = NDArray[np.float64]

_ROOM = 1e-4  # rad or m that the plan lies inside the margins where the follower is held to them
_HELD_STEP = 0.05  # rad or m between the postures that are checked where a pose is held while external axes move
_HELD_JUMP = 0.35  # rad that an arm's joint may move between them
_NEAR, _GAIN, _WOUND = 0.15, 0.1, 0.5  # shares of an axis's range: near a limit, room gained, a whole way back
_TORN = 0.9  # rad that A1 to A3 move at most between the waypoints of the search, which lie no nearer than the plan's
_LEG = 0.5  # rad or m of a freedom in one of the moves that a held revision is made of


class Followed(NamedTuple):
    """Postures q (N, n), 1/k_F (N,) along a path, and its re-postures; stuck: the path point at which the follower could not
    follow the plan, -1 where it could, and why. What lies behind that point is without meaning. torn: what the arm's closed form
    calls one branch is several along the plan, so that there is nothing to follow.
    """

    q: Array
    inv_kf: Array
    revisions: tuple[Revision, ...]
    stuck: int = -1
    why: JobError | None = None
    torn: bool = False


def follow_plan(
    cell: Cell, path: ToolPathInBase, space: PlanSpace, w: Waypoints, draft: Draft, *, still: bool, margin: Array
) -> Followed:
    """Follow the path with the draft as the moving reference posture.

    `still` locks the external axes to the draft's. margin (n,): what the joints keep from their limits, where the draft does.
    """
    tear = _tear(space, draft)
    if tear is not None:
        at, why = int(w.point[draft.index[tear[0]]]), _torn_arm(cell, path, *tear, w, draft)
        return Followed(np.empty((0, len(cell))), np.empty(0), (), at, why, torn=True)
    follower = PathFollower(cell, path, weighting=even_weights(cell))
    locked = np.zeros(len(cell), np.bool_)
    if still:
        locked[space.free[: len(space.free) - space.roll]] = True
    lower, upper = _bounds(cell, space, draft, margin)
    follower.settings = follower.settings._replace(lower=lower, upper=upper, locked=locked, threshold=0.0)
    begins = np.flatnonzero(~draft.joined)
    q, inv_kf = np.empty((len(path), len(cell))), np.empty(len(path))
    revisions: list[Revision] = []
    first = 0
    for begin, end in zip(begins, [*begins[1:], len(draft)], strict=True):
        part = slice(int(begin), int(end))
        start, stop = int(w.point[draft.index[part.start]]), int(w.point[draft.index[part.stop - 1]]) + 1
        rows = _references(cell, path, space, w, draft, part, start, stop)
        if begin > 0:  # the posture jumps at point `start`, which has been reached
            revisions.append(
                _revision(
                    cell,
                    follower,
                    space,
                    path,
                    start,
                    q[start],
                    rows[0],
                    int(draft.branch[part.start - 1]) == int(draft.branch[part.start]),
                )
            )
            q[start], inv_kf[start] = rows[0], follower.inv_kf(rows[0])
            first = start + 1
        attempt = follower.follow(
            follower.at(rows[0]), rows[first - start :], first, stop, bounded=False, tolerant=True
        )
        if attempt.failure is not None:
            return Followed(q, inv_kf, tuple(revisions), attempt.failure.point, follower.explain(attempt.failure))
        q[first:stop], inv_kf[first:stop] = attempt.q, attempt.inv_kf
    return Followed(q, inv_kf, tuple(revisions))


def _tear(space: PlanSpace, draft: Draft) -> tuple[int, int] | None:
    """The waypoint of a draft and which of A1 to A3 jumps most on the way there, on one branch by name; None where none does.

    Of cuspidal arms two rows of `solve_screws` may change places between singular postures.
    """
    if space.screws is None or len(draft) < 2:
        return None
    moved = np.abs(np.diff(draft.q[:, :3], axis=0)) * draft.joined[1:, None]
    k, axis = np.unravel_index(int(np.argmax(moved)), moved.shape)
    return (int(k) + 1, int(axis)) if moved[k, axis] > _TORN else None


def _torn_arm(cell: Cell, path: ToolPathInBase, k: int, axis: int, w: Waypoints, draft: Draft) -> JobError:
    point, moved = int(w.point[draft.index[k]]), float(rad_to_deg(abs(draft.q[k, axis] - draft.q[k - 1, axis])))
    name = cell.axis_names[axis]
    return JobError(
        f"this arm's postures can't be told apart along the path ({name} jumps by {moved:.0f} degrees within what should be one "
        "branch), as of arms that pass from one posture of a pose to another without a singular one between, so that no plan can "
        "be made; use --method vjm",
        line=int(path.line[point]),
        axis=name,
    )


def _bounds(cell: Cell, space: PlanSpace, draft: Draft, margin: Array) -> tuple[Array, Array]:
    """The limits (n,) that the follower is held to: drawn in by the margin at each joint whose plan keeps it all along."""
    lower, upper = cell.q_lower, cell.q_upper
    whole = np.empty((len(draft), len(cell)))
    whole[:, space.free] = draft.u
    whole[:, cell.arm_slice] = draft.q
    low, high = lower + margin, upper - margin
    lower = np.where(whole.min(axis=0) > low + _ROOM, low, lower)
    upper = np.where(whole.max(axis=0) < high - _ROOM, high, upper)
    return lower, upper


def _references(
    cell: Cell, path: ToolPathInBase, space: PlanSpace, w: Waypoints, draft: Draft, part: slice, start: int, stop: int
) -> Array:
    """Reference postures (stop - start, n) at the path's points: freedoms by monotone cubics, exactly constant where the
    waypoints about them are; the arm in closed form.
    """
    from scipy.interpolate import PchipInterpolator

    at = w.s[draft.index[part]]
    place = np.clip(w.place[start:stop], at[0], at[-1])
    last = np.append(np.diff(at) > 0.0, True)
    knots, values = at[last], draft.u[part][last]
    if len(knots) > 1:
        u = PchipInterpolator(knots, values, axis=0)(place)
        k = np.clip(np.searchsorted(knots, place, side="right") - 1, 0, len(knots) - 2)
        u = np.where(values[k] == values[k + 1], values[k], u)
    else:
        u = np.repeat(values, len(place), axis=0)
    n = len(place)
    u[0] = draft.u[part][0]
    frames = np.array(path.base_T_tip[start:stop], order="C")
    branch, joined = np.full(n, draft.branch[part.start]), np.arange(n) > 0
    begin = np.repeat(draft.q[part][:1], n, axis=0)
    arm, _good = arm_along(space, frames, branch, joined, np.ascontiguousarray(u), begin)
    rows = np.empty((n, len(cell)))
    rows[:, space.free] = u
    rows[:, cell.arm_slice] = arm
    return rows


def _revision(
    cell: Cell,
    follower: PathFollower,
    space: PlanSpace,
    path: ToolPathInBase,
    point: int,
    before: Array,
    after: Array,
    same_branch: bool,
) -> Revision:
    """The re-posture at a path point: with the pose held where the arm can follow from one to the other, else by axis values."""
    ahead = path.region[point:]
    named = ahead[ahead >= 0]
    region = int(named[0]) if len(named) else int(path.region[path.region >= 0][-1])
    value = follower.inv_kf(before), follower.inv_kf(after)
    if same_branch:
        legs = _held(cell, follower, path, point, before, after)
        if legs is not None:
            return Revision(region, point, legs, True, *value, reason="external axes moved to the next stop")
    reason = _reason(cell, before, after, same_branch)
    return Revision(region, point, np.array([before, after]), True, *value, reason=reason, by_axes=True)


def _reason(cell: Cell, before: Array, after: Array, same_branch: bool) -> str:
    """Why the posture jumps: the axis nearest to its limit that is taken back from it, else what changes."""
    limited = np.flatnonzero(np.isfinite(cell.q_lower) & np.isfinite(cell.q_upper))
    room = np.minimum(before - cell.q_lower, cell.q_upper - before)[limited]
    share = room / (cell.q_upper - cell.q_lower)[limited]
    for k in np.argsort(share):
        i = limited[k]
        span = cell.q_upper[i] - cell.q_lower[i]
        gained = min(after[i] - cell.q_lower[i], cell.q_upper[i] - after[i]) - room[k]
        turned = abs(after[i] - before[i])
        if share[k] < _NEAR and (gained > _GAIN * span or turned > _WOUND * span):
            name, prismatic = cell.names[i], cell.joints[i].prismatic
            left, back = (m_to_mm(room[k]), m_to_mm(turned)) if prismatic else (rad_to_deg(room[k]), rad_to_deg(turned))
            unit = "mm" if prismatic else "degrees"
            return f"{name} has {left:.0f} {unit} left to its limit and is taken back by {back:.0f} {unit}"
    return (
        "another turn of the arm suits what follows" if same_branch else "another branch of the arm suits what follows"
    )


def _held(
    cell: Cell, follower: PathFollower, path: ToolPathInBase, point: int, before: Array, after: Array
) -> Array | None:
    """Postures (K, n) from `before` to `after` with the pose of the point held, checked between; None where it can't be held."""
    far = float(np.max(np.abs(after - before)))
    count = max(2, int(np.ceil(far / _HELD_STEP)) + 1)
    rows = before + np.linspace(0.0, 1.0, count)[:, None] * (after - before)
    frames = np.repeat(path.base_T_tip[point][None], count, axis=0)
    part = cell.arm_slice
    arm, _code, followed = follower.arm.follow(follower.arm.foot_T_tool(frames, rows), before[part], step=_HELD_JUMP)
    if followed < count or np.max(np.abs(arm[-1] - after[part])) > 1e-6:
        return None
    rows[:, part] = arm
    legs = max(1, int(np.ceil(far / _LEG)))
    pick = np.unique(np.round(np.linspace(0, count - 1, legs + 1)).astype(np.int64))
    out = rows[pick]
    out[0], out[-1] = before, after
    return np.asarray(out)
