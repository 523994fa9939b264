"""Which two bodies are nearest to each other in single postures, for pictures: the check itself follows the whole way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.advance import Riders, chain_links, pair_distances
from camrob.bodies.bodies import JOB_GROUPS, Body, cell_bodies, job_body
from camrob.bodies.tree import join_pieces
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.setup import ToolSetup
from camrob.checks.air import AirRuns
from camrob.checks.pairs import plan_pairs

__all__ = ["Nearest", "nearest_bodies"]

Array = NDArray[np.float64]

_NEIGHBOURS = 2  # axes between two limbs of the arm that are near each other in every posture


@dataclass(frozen=True, slots=True)
class Nearest:
    """pairs: two bodies' names each; pair (K,): which of them are nearest in a posture; distance (K,) m, 0 where they touch."""

    pairs: tuple[tuple[str, str], ...]
    pair: NDArray[np.int64]
    distance: Array


def nearest_bodies(
    cell: Cell,
    q: Array,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
) -> Nearest | None:
    """The nearest two of the bodies that `check_collisions` follows, in postures q (K, n); None where it follows none.

    The tool beside part and stock is left out, as it cuts them, and so are limbs next to each other: the check follows them, but
    how near they always are tells nothing. Meshes, pose and tool as there. Raises CellError for a mesh of
    the cell that can't be read.
    """
    q = np.ascontiguousarray(q, float)
    base_T_part = np.eye(4) if base_T_part is None else np.asarray(base_T_part, float)
    job = [
        job_body(group, np.asarray(mesh, float), base_T_part)
        for group, mesh in zip(JOB_GROUPS, (part_mesh, stock_mesh), strict=True)
        if mesh is not None
    ]
    nowhere = np.zeros(len(q), bool)
    still = AirRuns(q, np.arange(len(q)), nowhere, nowhere)
    bodies, pairs, _ = plan_pairs((*cell_bodies(cell, tool), *job), still, 0.0)
    arm = cell.indices(Role.ARM)
    pairs = tuple(p for p in pairs if not _neighbours(bodies[p.far], bodies[p.near], arm))
    if not pairs or not len(q):
        return None
    pieces, roots = join_pieces([b.pieces for b in bodies])
    riders = Riders(np.array([b.link for b in bodies]), np.stack([b.link_T_body for b in bodies]), roots, pieces)
    links = chain_links(cell)
    distance = np.stack([pair_distances(links, riders, p.far, p.near, q) for p in pairs])
    pair = np.argmin(distance, axis=0)
    names = tuple((bodies[p.far].name, bodies[p.near].name) for p in pairs)
    return Nearest(names, pair, distance[pair, np.arange(len(q))])


def _neighbours(one: Body, other: Body, arm: Sequence[int]) -> bool:
    links = {one.link, other.link}
    return links <= set(arm) and max(links) - min(links) <= _NEIGHBOURS
