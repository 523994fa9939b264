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

__all__ = ["Rooms", "job_room", "named_pairs", "pair_rooms"]

Array = NDArray[np.float64]
Keep = Callable[[Body, Body], bool]


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
    names, room = named_pairs(
        cell, part_mesh=part_mesh, stock_mesh=stock_mesh, base_T_part=base_T_part, tool=tool, touch=touch
    )
    if room is None:
        return Rooms((), np.empty((0, len(q))))
    distance = np.stack([pair_distances(room.links, room.riders, int(a), int(b), q) for a, b in room.pairs])
    return Rooms(names, distance)


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
    return named_pairs(
        cell, part_mesh=part_mesh, stock_mesh=stock_mesh, base_T_part=base_T_part, tool=tool, touch=touch
    )[1]


def named_pairs(
    cell: Cell,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
    touch: float | None = None,
    keep: Keep | None = None,
) -> tuple[tuple[tuple[str, str], ...], Room | None]:
    """Names of the bodies of each pair of `pair_rooms`, and the pairs; keep: which two bodies are looked at."""
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
