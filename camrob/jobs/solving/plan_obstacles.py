"""What stands in the way of a plan: the bodies of a job's cell, part and stock, as the planner asks for them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.checks.collision_report import CollisionReport
from camrob.checks.collisions import check_collisions
from camrob.jobs.files.inputs import JobInputs
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Revision, Solution
from camrob.redundancy.stretches import change_values

__all__ = ["collisions_at", "free_routes", "job_collisions", "job_obstacles"]

Array = NDArray[np.float64]

_STEP = 0.1  # rad or m between the postures of a PTP that are looked at


def job_obstacles(inputs: JobInputs) -> Callable[[ToolPathInBase, Solution], NDArray[np.bool_]]:
    """`obstacles` for `resolve_planned`: at which points (N,) of a path a solution's bodies touch, its re-postures on their best
    routes and the ways from and to HOME (or where tools are changed) included.
    """

    def touching(path: ToolPathInBase, solution: Solution) -> NDArray[np.bool_]:
        report, point = _looked_at(inputs, path, solution)
        out = np.zeros(len(path), np.bool_)
        out[point[np.asarray(report.hit)]] = True
        return out

    return touching


def job_collisions(inputs: JobInputs, path: ToolPathInBase, solution: Solution) -> CollisionReport:
    """What touches what along a solution of a path, re-postures on their best routes, ways from and to HOME included."""
    return _looked_at(inputs, path, solution)[0]


def _looked_at(
    inputs: JobInputs, path: ToolPathInBase, solution: Solution
) -> tuple[CollisionReport, NDArray[np.int64]]:
    """The report over K postures, and the path point (K,) that each belongs to."""
    solution = free_routes(inputs, path, solution)
    n, home = len(path), inputs.cell.q_home[None]
    goal = home
    if inputs.to_change:
        last = inputs.cell.to_axis_values(np.asarray(solution.q[-1]))
        goal = inputs.cell.to_q(change_values(inputs.cell, last))[None]
    q = [np.asarray(solution.q)]
    order = [np.arange(n, dtype=float)]
    ways = [(-0.5, _ptp(home, solution.q[:1])), (n - 0.9, _ptp(solution.q[-1:], goal))]
    for r in solution.revisions:
        if r.kept:  # the last posture of a re-posture is the solution's own at the point
            ways.append((r.point - 0.5, _route(r)[:-1]))
    for begin, rows in ways:
        q.append(rows)
        order.append(begin + 0.4 * np.arange(len(rows)) / len(rows))
    place = np.concatenate(order)
    sort = np.argsort(place, kind="stable")
    point = np.clip(np.ceil(place[sort]).astype(np.int64), 0, n - 1)
    own = place[sort] == np.floor(place[sort])
    return collisions_at(inputs, path, np.concatenate(q)[sort], point, path.cutting[point] & own), point


def free_routes(inputs: JobInputs, path: ToolPathInBase, solution: Solution) -> Solution:
    """The solution with each re-posture by axis values on the first route that touches nothing: straight, with the arm by way
    of HOME, or with the external axes moved while it stands there; the straight one where all touch.
    """
    revisions = []
    for r in solution.revisions:
        if r.kept and r.by_axes:
            r = next((other for other in _routes(inputs, r) if not _blocked(inputs, path, other)), r)
        revisions.append(r)
    return replace(solution, revisions=tuple(revisions))


def _routes(inputs: JobInputs, r: Revision) -> Iterator[Revision]:
    """Routes of a re-posture, straight first."""
    yield r
    cell = inputs.cell
    ends = np.asarray(r.q)[[0, -1]]
    middle = np.stack([0.5 * (ends[0] + ends[1]), ends[0], ends[1]])
    middle[:, cell.arm_slice] = cell.q_home[cell.arm_slice]
    for between in (middle[:1], middle[1:]):
        yield replace(r, q=np.concatenate([ends[:1], between, ends[1:]]))


def _blocked(inputs: JobInputs, path: ToolPathInBase, r: Revision) -> bool:
    rows = _route(r)
    point = np.full(len(rows), r.point)
    return bool(np.any(collisions_at(inputs, path, rows, point, np.zeros(len(rows), np.bool_)).hit))


def _route(r: Revision) -> Array:
    """The postures that a re-posture passes."""
    q = np.asarray(r.q)
    if not r.by_axes:
        return q
    return np.concatenate([*(_ptp(a[None], b[None])[:-1] for a, b in pairwise(q)), q[-1:]])


def _ptp(first: Array, last: Array) -> Array:
    """Postures (K, n) along a PTP, the ends among them."""
    count = max(2, int(np.ceil(float(np.max(np.abs(last - first))) / _STEP)) + 1)
    return np.asarray(first + np.linspace(0.0, 1.0, count)[:, None] * (last - first))


def collisions_at(
    inputs: JobInputs, path: ToolPathInBase, q: Array, point: NDArray[np.int64], cutting: NDArray[np.bool_]
) -> CollisionReport:
    """What postures (K, n), at path points (K,), touch."""
    return check_collisions(
        inputs.cell,
        q,
        cutting=cutting,
        line=path.line[point],
        region=path.region[point],
        part_mesh=inputs.part,
        stock_mesh=inputs.stock,
        base_T_part=np.asarray(inputs.setup.base_T_part),
        tool=inputs.tool,
    )
