"""What stands in the way of a plan: the bodies of a job's cell, part and stock, as the planner asks for them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.room import Room, rooms
from camrob.cell.cell import Cell
from camrob.checks.collision_report import CollisionReport
from camrob.checks.collisions import check_collisions
from camrob.checks.rooms import job_room
from camrob.jobs.files.inputs import JobInputs
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.clear_air import ClearAir
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Lead, Revision, Solution
from camrob.redundancy.stretches import change_values, home_values

__all__ = ["collisions_at", "free_routes", "job_collisions", "job_leads", "job_obstacles"]

Array = NDArray[np.float64]

_SOME = 3  # of so many postures of a way one is asked for its room while candidates are compared
_STEP = 0.1  # rad or m between the postures of a PTP that are looked at


def job_obstacles(inputs: JobInputs) -> Callable[[ToolPathInBase, Solution], NDArray[np.bool_]]:
    """`obstacles` for `resolve_planned`: at which points (N,) of a path a solution's bodies touch, its re-postures and the ways
    from and to HOME (or where tools are changed) included, on the routes that are chosen.
    """

    def touching(path: ToolPathInBase, solution: Solution) -> NDArray[np.bool_]:
        report, point = _looked_at(inputs, path, solution, touches=True)
        out = np.zeros(len(path), np.bool_)
        out[point[np.asarray(report.hit)]] = True
        return out

    return touching


def job_collisions(inputs: JobInputs, path: ToolPathInBase, solution: Solution) -> CollisionReport:
    """What touches what along a solution of a path, re-postures on their best routes, ways from and to HOME included."""
    return _looked_at(inputs, path, solution)[0]


def _looked_at(
    inputs: JobInputs, path: ToolPathInBase, solution: Solution, *, touches: bool = False
) -> tuple[CollisionReport, NDArray[np.int64]]:
    """The report over K postures, and the path point (K,) that each belongs to."""
    solution = free_routes(inputs, path, solution)
    n, lead = len(path), solution.leads[0]
    q = [np.asarray(solution.q)]
    order = [np.arange(n, dtype=float)]
    first, last = _lead_ends(inputs, solution)
    ways = [(-0.5, _along(first, np.asarray(lead.into))), (n - 0.9, _along(last, np.asarray(lead.out)))]
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
    rows, cut = np.concatenate(q)[sort], path.cutting[point] & own
    return collisions_at(inputs, path, rows, point, cut, touches=touches), point


def free_routes(inputs: JobInputs, path: ToolPathInBase, solution: Solution) -> Solution:
    """The solution of a stretch with each way that goes by axis values on the first route that touches nothing: straight, with
    the arm by way of HOME, with the external axes moved while it stands there, or with its shoulder drawn back before all else;
    the straight one where all touch. Such ways are re-postures, and those from and to HOME or where tools are changed.
    """
    air = _clear_air(inputs, path)
    revisions = []
    for r in solution.revisions:
        if r.kept and r.by_axes and path.clear[r.point]:
            ends = np.asarray(r.q)[[0, -1]]
            r = replace(r, q=np.insert(ends, 1, _free_vias(inputs, path, air, ends, r.point), axis=0))
        revisions.append(r)
    begin, end = _lead_ends(inputs, solution)
    lead = Lead(_free_vias(inputs, path, air, begin, 0), _free_vias(inputs, path, air, end, len(path) - 1))
    return replace(solution, revisions=tuple(revisions), leads=(lead,))


def _clear_air(inputs: JobInputs, path: ToolPathInBase) -> ClearAir:
    """What a tool in the clear lies above, of a job."""
    base_T_part = np.asarray(inputs.setup.base_T_part)
    bodies = [body.reshape(-1, 3) for body in (inputs.part, inputs.stock) if body is not None]
    corners = [points @ base_T_part[:3, :3].T + base_T_part[:3, 3] for points in bodies]
    return ClearAir.of(path, corners)


def job_leads(inputs: JobInputs) -> Callable[[Array, bool, float], Array]:
    """`leads` for `resolve_planned`: the room on the first free one of the routes that `free_routes` has to choose from, in some
    postures of the way and with the tool held to the part.
    """

    @cache  # few plans ask
    def ground() -> tuple[Room | None, ClearAir]:
        return job_room(inputs.cell, **inputs.bodies, tool=inputs.tool, touch=0.0), _clear_air(inputs, inputs.path)

    def led(q: Array, last: bool, wanted: float) -> Array:
        room, air = ground()
        out = np.full(len(q), wanted if room is None else 0.0)
        for k, one in enumerate(q):
            ends = np.stack([one, _goal(inputs, one)] if last else [inputs.cell.q_home, one])
            for vias in _routes(inputs.cell, air, ends):
                if room is None or out[k] > 0.0:
                    break
                out[k] = float(rooms(room, _along(ends, vias)[::_SOME].copy(), wanted).min())
        return out

    return led


def _lead_ends(inputs: JobInputs, solution: Solution) -> tuple[Array, Array]:
    """Where the ways to and from a stretch begin and end (2, n): HOME, or where tools are changed."""
    q = np.asarray(solution.q)
    return np.stack([inputs.cell.q_home, q[0]]), np.stack([q[-1], _goal(inputs, q[-1])])


def _goal(inputs: JobInputs, q: Array) -> Array:
    """Where the way from a stretch's last posture (n,) ends (n,): HOME, or where tools are changed."""
    cell, last = inputs.cell, inputs.cell.to_axis_values(q)
    return np.asarray(cell.to_q(change_values(cell, last) if inputs.to_change else home_values(cell, last)))


def _routes(cell: Cell, air: ClearAir, ends: Array) -> Iterator[Array]:
    """Postures (K, n), clear of the part, by which PTP may go from one of `ends` (2, n) to the other; none for straight."""
    shoulder = cell.arm_slice.start + 1
    middle, folded, raised = 0.5 * (ends[:1] + ends[1:]), ends.copy(), ends.copy()
    middle[:, cell.arm_slice] = folded[:, cell.arm_slice] = cell.q_home[cell.arm_slice]
    raised[:, shoulder] = cell.q_home[shoulder]
    for vias in (ends[:0], middle, folded, np.stack([raised[0], *folded, raised[1]])):
        vias = vias[np.abs(vias[:, None] - ends).max(axis=2, initial=0.0).min(axis=1, initial=np.inf) > 0.0]
        if air.holds(base_T_tool(cell, vias)).all():
            yield np.asarray(vias)


def _free_vias(inputs: JobInputs, path: ToolPathInBase, air: ClearAir, ends: Array, point: int) -> Array:
    """The first of `_routes` that touches nothing; none where all do."""
    for vias in _routes(inputs.cell, air, ends):
        if not _blocked(inputs, path, _along(ends, vias), point):
            return vias
    return ends[:0]


def _blocked(inputs: JobInputs, path: ToolPathInBase, rows: Array, at: int) -> bool:
    point = np.full(len(rows), at)
    return bool(np.any(collisions_at(inputs, path, rows, point, np.zeros(len(rows), np.bool_), touches=True).hit))


def _route(r: Revision) -> Array:
    """The postures that a re-posture passes."""
    q = np.asarray(r.q)
    return _along(q[[0, -1]], q[1:-1]) if r.by_axes else q


def _along(ends: Array, vias: Array) -> Array:
    """Postures (K, n) along the PTP from one of `ends` (2, n) by way of `vias` (M, n) to the other, all of these among them."""
    q = np.insert(ends, 1, vias, axis=0)
    return np.concatenate([*(_ptp(a[None], b[None])[:-1] for a, b in pairwise(q)), q[-1:]])


def _ptp(first: Array, last: Array) -> Array:
    """Postures (K, n) along a PTP, the ends among them."""
    count = max(2, int(np.ceil(float(np.max(np.abs(last - first))) / _STEP)) + 1)
    return np.asarray(first + np.linspace(0.0, 1.0, count)[:, None] * (last - first))


def collisions_at(
    inputs: JobInputs,
    path: ToolPathInBase,
    q: Array,
    point: NDArray[np.int64],
    cutting: NDArray[np.bool_],
    *,
    touches: bool = False,
) -> CollisionReport:
    """What postures (K, n), at path points (K,), touch; touches: clearances are of no matter."""
    return check_collisions(
        inputs.cell,
        q,
        cutting=cutting,
        line=path.line[point],
        region=path.region[point],
        **inputs.bodies,
        tool=inputs.tool,
        touches=touches,
    )
