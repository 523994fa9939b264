"""How far each two bodies that may not touch are apart in single postures: the check itself follows the way between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.advance import pair_distances
from camrob.bodies.bodies import JOB_GROUPS, Body, cell_bodies, job_body
from camrob.bodies.room import Room, room_of
from camrob.cell.cell import Cell
from camrob.cell.setup import ToolSetup
from camrob.checks.air import AirRuns
from camrob.checks.pairs import plan_pairs

__all__ = ["Rooms", "job_room", "nearest_pairs", "pair_rooms"]

Array = NDArray[np.float64]
Keep = Callable[[Body, Body], bool]

_EXACT = 2e-3  # of a distance, to which `pair_distances` finds it, twice


@dataclass(frozen=True, slots=True)
class Rooms:
    """names: two bodies' names for each of P pairs; distance (P, K), m, in K postures, 0 where they touch."""

    names: tuple[tuple[str, str], ...]
    distance: Array


def pair_rooms(
    cell: Cell,
    q: Array,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
    touch: float | None = None,
) -> Rooms:
    """The room between the bodies that `check_collisions` follows, in postures q (K, n), some 10 us a pair and posture.

    Meshes, pose and tool as there. touch: m that the tool may sink into the part; None: it isn't held to the part at all, as it
    cuts it. A body that lies wholly within another one's mesh doesn't touch it here. Raises
    CellError for a mesh of the cell that can't be read.
    """
    q = np.ascontiguousarray(q, float)
    names, room = _pairs(cell, part_mesh, stock_mesh, base_T_part, tool, touch, None)
    if room is None:
        return Rooms((), np.empty((0, len(q))))
    distance = np.stack([pair_distances(room.links, room.riders, int(a), int(b), q) for a, b in room.pairs])
    return Rooms(names, distance)


def nearest_pairs(
    cell: Cell,
    q: Array,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
    keep: Keep | None = None,
) -> tuple[tuple[tuple[str, str], ...], NDArray[np.int64], Array]:
    """Names of the bodies of P pairs that `check_collisions` follows, which pair (K,) is nearest in postures q (K, n), and how
    far (K,), m, it is apart, 0 where it touches. Some 10 us a posture and pair whose balls come that near.

    Meshes, pose, tool and errors as there; the tool isn't held to the part, as it cuts it. keep: which two bodies are looked at.
    """
    q = np.ascontiguousarray(q, float)
    names, room = _pairs(cell, part_mesh, stock_mesh, base_T_part, tool, None, keep)
    nearest, distance = np.zeros(len(q), np.int64), np.full(len(q), np.inf)
    if room is None:
        return (), nearest, distance
    least = _between_balls(room, q)
    for k in np.argsort(least.mean(axis=1), kind="stable").tolist():
        rows = np.flatnonzero(least[k] <= distance)
        if not len(rows):
            continue
        far, near = (int(body) for body in room.pairs[k])
        apart = pair_distances(room.links, room.riders, far, near, q[rows])
        closer = (apart < distance[rows]) | ((apart == distance[rows]) & (k < nearest[rows]))
        distance[rows[closer]], nearest[rows[closer]] = apart[closer], k
    return names, nearest, distance


def _between_balls(room: Room, q: Array) -> Array:
    """What each pair (P,) is apart at the least in postures q (K, n): by the balls about its bodies."""
    links, riders = room.links, room.riders
    frame = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    frames = []
    for i, slides in enumerate(links.prismatic.tolist()):
        move = np.broadcast_to(np.eye(4), (len(q), 4, 4)).copy()
        if slides:
            move[:, 2, 3] = q[:, i]
        else:
            cosine, sine = np.cos(q[:, i]), np.sin(q[:, i])
            move[:, 0, 0], move[:, 0, 1], move[:, 1, 0], move[:, 1, 1] = cosine, -sine, sine, cosine
        frame = frame @ links.before[i] @ move @ links.after[i]
        frames.append(frame)
    frames.append(np.broadcast_to(np.eye(4), (len(q), 4, 4)))  # link -1: `base`
    middle = np.c_[riders.pieces.center[riders.root], np.ones(len(riders.root))]
    places = [
        (frames[link] @ (T @ at))[:, :3] for link, T, at in zip(riders.link, riders.link_T_body, middle, strict=True)
    ]
    reach = riders.pieces.reach[riders.root]
    apart = [np.linalg.norm(places[a] - places[b], axis=1) - reach[a] - reach[b] for a, b in room.pairs]
    return np.asarray((1.0 - _EXACT) * np.array(apart))


def job_room(
    cell: Cell,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
    touch: float | None = None,
) -> Room | None:
    """The pairs of `pair_rooms` for `rooms`, which finds the least distance of all of them in one pass, some microseconds a
    posture; touch as there. None where no two bodies may not touch.
    """
    return _pairs(cell, part_mesh, stock_mesh, base_T_part, tool, touch, None)[1]


def _pairs(
    cell: Cell,
    part_mesh: Array | None,
    stock_mesh: Array | None,
    base_T_part: Array | None,
    tool: ToolSetup | None,
    touch: float | None,
    keep: Keep | None,
) -> tuple[tuple[tuple[str, str], ...], Room | None]:
    """Names of the bodies of each pair, and the pairs."""
    base_T_part = np.eye(4) if base_T_part is None else np.asarray(base_T_part, float)
    job = [
        job_body(group, np.asarray(mesh, float), base_T_part)
        for group, mesh in zip(JOB_GROUPS, (part_mesh, stock_mesh), strict=True)
        if mesh is not None
    ]
    free, near = np.full(1, touch is not None), np.zeros(1, np.bool_)
    every = (*cell_bodies(cell, tool), *job)
    bodies, pairs, _ = plan_pairs(every, AirRuns(cell.q_home[None], np.zeros(1, np.int64), free, near), touch or 0.0)
    pairs = tuple(p for p in pairs if keep is None or keep(bodies[p.far], bodies[p.near]))
    if not pairs:
        return (), None
    names = tuple((bodies[p.far].name, bodies[p.near].name) for p in pairs)
    return names, room_of(cell, bodies, [(p.far, p.near) for p in pairs])
