"""Collisions along a path of postures: who touches whom, where first, and how much room is left."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.bodies.advance import Riders, block_ranges, chain_links, follow_pair
from camrob.bodies.bodies import JOB_GROUPS, TOOL_GROUP, Body, base_T_bodies, cell_bodies, job_body
from camrob.bodies.meshes import wraps
from camrob.bodies.tree import join_pieces
from camrob.cell.cell import Cell
from camrob.cell.setup import ToolSetup
from camrob.checks.air import AirRuns, air_runs
from camrob.checks.collision_report import CollisionReport, PairClearance
from camrob.checks.pairs import Pair, plan_pairs
from camrob.findings import Finding, Severity
from camrob.kinematics.kernels import chain_arrays, forward_many
from camrob.progress import Share
from camrob.se3 import inverse

__all__ = ["check_collisions"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEP = 0.001  # m that any point of a body may move between two looks
TOUCH = 0.0005  # m: nearer than this is a touch, half the step
MAX_SAMPLES = 20_000_000  # postures of one check: beyond it time and memory, and it is said
_CHUNK = 16_384  # postures
_NEAR_RADII = 3.0  # how far from a cut, in tool radii, an air move still counts as leaving or entering it


def check_collisions(
    cell: Cell,
    q: Array,
    *,
    cutting: ArrayLike | None = None,
    line: ArrayLike | None = None,
    region: ArrayLike | None = None,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
    step: float = STEP,
    touch: float = TOUCH,
    max_samples: int = MAX_SAMPLES,
    touches: bool = False,
    progress: Share | None = None,
) -> CollisionReport:
    """Follows every pair of bodies that may not touch along postures q (M, n), straight in the joints between points.

    cutting (M,): True for points that the tool comes to while it cuts; line (M,): CL lines, 0 for camrob's own points;
    region (M,), -1 between regions. Without them nothing is cut, by no line and in no region. part_mesh, stock_mesh: triangles
    (k, 3, 3) in the frame `part`, m (see `body_triangles`), posed by base_T_part. tool: its diameter and length, where known,
    replace the cell's own tool body.

    Bodies of one group, of groups that ignore each other, or that don't move against each other are left out. The tool
    may touch the part while it cuts; in air it may not by more than `touch` (m), and close to where a cut ends or
    begins it is seen as a ball cutter. The stock never stops the tool, which cuts it; everything else may touch
    neither. Samples are as far apart as the clearance allows, and at least `step` (m); where max_samples would not do,
    the step grows. touches: nothing is found out but these, in a part of the time; clearances are 0 then, or inf. progress is
    called after each pair. Raises ValueError for arrays that don't fit,
    CellError for a mesh of the cell that can't be read.
    """
    q = np.ascontiguousarray(q, float)
    count = len(q)
    if q.shape != (count, len(cell)) or not np.all(np.isfinite(q)):
        raise ValueError(f"postures are {q.shape} or not finite, expected ({count}, {len(cell)}) finite numbers")
    cut = np.zeros(count, bool) if cutting is None else np.asarray(cutting, bool)
    lines = np.zeros(count, np.int64) if line is None else np.asarray(line, np.int64)
    regions = np.full(count, -1, np.int64) if region is None else np.asarray(region, np.int64)
    if any(v.shape != (count,) for v in (cut, lines, regions)):
        raise ValueError("cutting, line and region need one value a posture")
    base_T_part = np.eye(4) if base_T_part is None else np.asarray(base_T_part, float)
    fixed = [
        job_body(group, np.asarray(mesh, float), base_T_part)
        for group, mesh in zip(JOB_GROUPS, (part_mesh, stock_mesh), strict=True)
        if mesh is not None
    ]
    mounted = cell_bodies(cell, tool)
    air = _air(cell, mounted, q, cut)
    bodies, pairs, skipped = plan_pairs((*mounted, *fixed) if count else (), air, touch)
    budget = max(1000, max_samples // max(1, len(pairs)))
    found = _follow(cell, bodies, pairs, air, step, budget, touches, progress)
    rooms, touched = [room for room, _ in found], [points for _, points in found]
    return _report(rooms, touched, pairs, cut, lines, regions, skipped)


def _air(cell: Cell, bodies: Sequence[Body], q: Array, cut: Mask) -> AirRuns:
    """The path with its air moves, split where they leave the neighbourhood of a cut."""
    roots = [b.pieces for b in bodies if b.group == TOOL_GROUP]
    radius = max((float(p.half[0, 0] + p.sweep[0]) for p in roots), default=0.0)
    chain = chain_arrays(cell)
    tip = np.empty((len(q), 3))
    for start in range(0, len(q), _CHUNK):  # whole poses of a long path would be the job's largest array
        tip[start : start + _CHUNK] = forward_many(chain, q[start : start + _CHUNK])[:, :3, 3]
    return air_runs(q, tip, cut, _NEAR_RADII * radius)


def _follow(
    cell: Cell,
    bodies: Sequence[Body],
    pairs: Sequence[Pair],
    air: AirRuns,
    step: float,
    budget: int,
    touches: bool,
    progress: Share | None,
) -> list[tuple[PairClearance, NDArray[np.int64]]]:
    """For each pair its clearance and the points at which, or on the way to which, it touches."""
    if not pairs:
        return []
    pieces, roots = join_pieces([b.pieces for b in bodies])
    riders = Riders(np.array([b.link for b in bodies]), np.stack([b.link_T_body for b in bodies]), roots, pieces)
    links, ranges = chain_links(cell), block_ranges(air.q)

    def one(pair: Pair) -> tuple[PairClearance, NDArray[np.int64]]:
        hit = np.zeros(len(air.q), bool)
        along = follow_pair(links, riders, pair.far, pair.near, air.q, ranges, pair.active, step, budget, touches, hit)
        return _pair_report(cell, bodies, pair, air, hit, along)

    out = []
    pool = ThreadPoolExecutor(min(len(pairs), os.cpu_count() or 1))  # the kernel lets other threads run
    try:
        for found in pool.map(one, pairs):
            out.append(found)
            if progress is not None:
                progress(len(out) / len(pairs))
    finally:
        pool.shutdown(cancel_futures=True)
    return out


def _pair_report(
    cell: Cell, bodies: Sequence[Body], pair: Pair, air: AirRuns, hit: Mask, along: tuple[float, int, float, int]
) -> tuple[PairClearance, NDArray[np.int64]]:
    """One pair's clearance and the points at which, or on the way to which, it touches. along: what `follow_pair` found."""
    clearance, at, gap, samples = along
    start = _inside_at_start(cell, bodies[pair.far], bodies[pair.near], air.q, pair.active)
    if start >= 0:
        hit[start], clearance, at = True, 0.0, start
    if len(hit) > 1:  # a touch where a run begins belongs to the motion that leaves from there
        hit[1:] |= (hit & ~pair.active)[:-1]
        hit &= pair.active
    points = np.unique(air.point[hit])
    far, near = bodies[pair.far], bodies[pair.near]
    room = PairClearance(
        pair=(far.name, near.name),
        groups=(far.group, near.group),
        count=len(points),
        first=int(points[0]) if len(points) else -1,
        clearance=float(clearance),
        at=int(air.point[at]),
        samples=int(samples),
        largest_step=max(0.0, float(gap)),
    )
    return room, points


def _inside_at_start(cell: Cell, far: Body, near: Body, q: Array, active: Mask) -> int:
    """The dense point at which a pair begins to count, if one of the two lies wholly within the other's mesh; else -1.

    Later, a body can only get inside through the surface, and that is seen.
    """
    if (far.triangles is None and near.triangles is None) or not active.any():
        return -1
    start = max(0, int(np.argmax(active)) - 1)
    base_T_far, base_T_near = base_T_bodies(cell, (far, near), q[start])
    for outer, base_T_outer, inner, base_T_inner in (
        (near, base_T_near, far, base_T_far),
        (far, base_T_far, near, base_T_near),
    ):
        if outer.triangles is not None:
            point = np.append(np.zeros(3) if inner.triangles is None else inner.triangles[0, 0], 1.0)
            outer_T_inner = inverse(base_T_outer) @ base_T_inner
            if wraps(outer.triangles, (outer_T_inner @ point)[:3]):
                return start
    return -1


def _report(
    rooms: Sequence[PairClearance],
    touched: Sequence[NDArray[np.int64]],
    pairs: Sequence[Pair],
    cut: Mask,
    lines: NDArray[np.int64],
    regions: NDArray[np.int64],
    skipped: tuple[str, ...],
) -> CollisionReport:
    """All pairs in one."""
    hit = np.zeros(len(cut), bool)
    for points in touched:
        hit[points] = True
    # the set-up's tool and part alone are no cell: that they don't touch says nothing of the machine
    own = [room for room, pair in zip(rooms, pairs, strict=True) if room.samples and (pair.in_clearance or room.count)]
    telling = [room for room, pair in zip(rooms, pairs, strict=True) if pair.in_clearance and room.samples]
    least = min(telling, key=lambda room: room.clearance, default=None)
    return CollisionReport(
        checked=bool(own),
        count=int(hit.sum()),
        findings=_findings(rooms, touched, cut, lines, regions),
        clearance_min=None if least is None else least.clearance,
        clearance_at=-1 if least is None else least.at,
        clearance_pair=() if least is None else least.pair,
        pairs=tuple(room for room in rooms if room.samples),
        points=len(cut),
        samples=sum(room.samples for room in rooms),
        largest_step=max((room.largest_step for room in rooms), default=0.0),
        hit=hit,
        skipped=skipped,
    )


def _findings(
    rooms: Sequence[PairClearance],
    touched: Sequence[NDArray[np.int64]],
    cut: Mask,
    lines: NDArray[np.int64],
    regions: NDArray[np.int64],
) -> tuple[Finding, ...]:
    """One finding for each two groups that touch, in the order of their first points."""
    groups: dict[tuple[str, ...], list[int]] = {}
    for k, room in enumerate(rooms):
        if room.count:
            groups.setdefault(tuple(sorted(room.groups)), []).append(k)
    out = []
    for members in groups.values():
        points = np.unique(np.concatenate([touched[k] for k in members]))
        first = rooms[min(members, key=lambda k: rooms[k].first)]
        point = first.first
        named = lines[: point + 1][lines[: point + 1] > 0]  # camrob's own points carry no line: the last one before
        code, how = ("collision-in-cut", "while it cuts") if cut[point] else ("collision", "on a move through air")
        out.append(
            Finding(
                code=code,
                text=f"{first.pair[0]} touches {first.pair[1]} {how}",
                severity=Severity.ERROR,
                line=int(named[-1]) if len(named) else 0,
                region=int(regions[point]),
                point=point,
                value=0.0,
                unit="mm",
                count=len(points),
            )
        )
    return tuple(sorted(out, key=lambda f: f.point))
