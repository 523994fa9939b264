"""Which two bodies are nearest to each other in single postures, for pictures: the check itself follows the whole way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.advance import pair_distances
from camrob.bodies.bodies import Body
from camrob.bodies.room import Room
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.setup import ToolSetup
from camrob.checks.rooms import named_pairs
from camrob.kinematics.frames import base_T_joint_frames

__all__ = ["Nearest", "nearest_bodies"]

Array = NDArray[np.float64]

_EXACT = 2e-3  # of a distance, to which `pair_distances` finds it, twice
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
    arm, q = cell.indices(Role.ARM), np.ascontiguousarray(q, float)
    names, room = named_pairs(
        cell,
        part_mesh=part_mesh,
        stock_mesh=stock_mesh,
        base_T_part=base_T_part,
        tool=tool,
        keep=lambda one, other: not _neighbours(one, other, arm),
    )
    return None if room is None or not len(q) else Nearest(names, *_nearest(cell, room, q))


def _nearest(cell: Cell, room: Room, q: Array) -> tuple[NDArray[np.int64], Array]:
    """Which pair (K,) is nearest in postures q (K, n), and how far (K,), m, it is apart: asked of pairs whose balls come near."""
    nearest, distance = np.zeros(len(q), np.int64), np.full(len(q), np.inf)
    least = _between_balls(cell, room, q)
    for k in np.argsort(least.mean(axis=1), kind="stable").tolist():
        rows = np.flatnonzero(least[k] <= distance)
        if not len(rows):
            continue
        far, near = (int(body) for body in room.pairs[k])
        apart = pair_distances(room.links, room.riders, far, near, q[rows])
        closer = (apart < distance[rows]) | ((apart == distance[rows]) & (k < nearest[rows]))
        distance[rows[closer]], nearest[rows[closer]] = apart[closer], k
    return nearest, distance


def _between_balls(cell: Cell, room: Room, q: Array) -> Array:
    """What each pair (P,) is apart at the least in postures q (K, n): by the balls about its bodies."""
    riders = room.riders
    fixed = np.broadcast_to(np.eye(4), (1, len(q), 4, 4))  # link -1: `base`
    frames = np.concatenate([base_T_joint_frames(cell, q), fixed])
    middle = np.c_[riders.pieces.center[riders.root], np.ones(len(riders.root))]
    places = [
        (frames[link] @ (T @ at))[:, :3] for link, T, at in zip(riders.link, riders.link_T_body, middle, strict=True)
    ]
    reach = riders.pieces.reach[riders.root]
    apart = [np.linalg.norm(places[a] - places[b], axis=1) - reach[a] - reach[b] for a, b in room.pairs]
    return np.asarray((1.0 - _EXACT) * np.array(apart))


def _neighbours(one: Body, other: Body, arm: Sequence[int]) -> bool:
    links = {one.link, other.link}
    return links <= set(arm) and max(links) - min(links) <= _NEIGHBOURS
