"""Whether a posture has room: all pairs of bodies that may not touch, in one pass over the chain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.advance import Links, Riders, chain_links
from camrob.bodies.bodies import Body, cell_bodies
from camrob.bodies.tree import Search, join_pieces, new_search, tree_distance
from camrob.cell.cell import Cell
from camrob.compiled import kernel, part
from camrob.errors import CellError
from camrob.frame_steps import compose, move_joint

__all__ = ["Room", "RoomWork", "cell_room", "has_room", "room_of", "room_work", "rooms"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_EXACT = 1e-3  # of a distance


class Room(NamedTuple):
    """links, riders: the chain and the bodies on it; pairs (P, 2): bodies that may not touch."""

    links: Links
    riders: Riders
    pairs: Ints


class RoomWork(NamedTuple):
    """Where the bodies stand, R (K, 3, 3), p (K, 3), the chain's frames, and what `tree_distance` works with."""

    R: Array
    p: Array
    link_R: Array
    link_p: Array
    seen_R: Array
    seen_p: Array
    search: Search


def cell_room(cell: Cell) -> Room:
    """The pairs of a cell's bodies that are of two groups, neither of which ignores the other, and that move against each other.

    Raises CellError where it has none.
    """
    bodies = cell_bodies(cell)
    if not bodies:
        raise CellError("has no bodies", hint="give it [[shape]]s, or plan without room")
    pairs = [
        (i, j)
        for i, a in enumerate(bodies)
        for j, b in enumerate(bodies[:i])
        if a.group != b.group and a.group not in b.ignore and b.group not in a.ignore and a.link != b.link
    ]
    return room_of(cell, bodies, pairs)


def room_of(cell: Cell, bodies: Sequence[Body], pairs: Sequence[tuple[int, int]]) -> Room:
    """The room that pairs of bodies (indices) leave each other along a cell's chain."""
    pieces, roots = join_pieces([b.pieces for b in bodies])
    riders = Riders(np.array([b.link for b in bodies]), np.stack([b.link_T_body for b in bodies]), roots, pieces)
    return Room(chain_links(cell), riders, np.array(pairs, np.int64).reshape(-1, 2))


@kernel
def room_work(room: Room) -> RoomWork:
    """Arrays for one thread."""
    K, n = room.riders.link.shape[0], room.links.prismatic.shape[0]
    return RoomWork(
        np.empty((K, 3, 3)),
        np.empty((K, 3)),
        np.empty((n, 3, 3)),
        np.empty((n, 3)),
        np.empty((3, 3)),
        np.empty(3),
        new_search(),
    )


@part
def _place_bodies(room: Room, q: Array, work: RoomWork) -> None:
    """work.R, work.p <- where the bodies stand in `base` in posture q (n,)."""
    R, p, links = work.seen_R, work.seen_p, room.links
    for r in range(3):
        p[r] = 0.0
        for c in range(3):
            R[r, c] = 1.0 if r == c else 0.0
    for i in range(links.prismatic.shape[0]):
        compose(R, p, links.before[i])
        move_joint(R, p, links.prismatic[i], q[i])
        compose(R, p, links.after[i])
        for r in range(3):
            work.link_p[i, r] = p[r]
            for c in range(3):
                work.link_R[i, r, c] = R[r, c]
    for k in range(room.riders.link.shape[0]):
        link = room.riders.link[k]
        for r in range(3):
            work.p[k, r] = work.link_p[link, r] if link >= 0 else 0.0
            for c in range(3):
                work.R[k, r, c] = work.link_R[link, r, c] if link >= 0 else (1.0 if r == c else 0.0)
        compose(work.R[k], work.p[k], room.riders.link_T_body[k])


@part
def has_room(room: Room, q: Array, wanted: float, work: RoomWork) -> float:
    """The least distance of all pairs in posture q (n,), m, as far as it is below `wanted`; as soon as one touches, 0."""
    _place_bodies(room, q, work)
    pieces, least = room.riders.pieces, wanted
    R, p = work.seen_R, work.seen_p
    for k in range(room.pairs.shape[0]):
        a, b = room.pairs[k, 0], room.pairs[k, 1]
        root_a, root_b = room.riders.root[a], room.riders.root[b]
        x, y, z = work.p[a, 0] - work.p[b, 0], work.p[a, 1] - work.p[b, 1], work.p[a, 2] - work.p[b, 2]
        gap2 = 0.0
        for r in range(3):  # between the middles of the balls about them
            d = x if r == 0 else (y if r == 1 else z)
            for c in range(3):
                d += work.R[a, r, c] * pieces.center[root_a, c] - work.R[b, r, c] * pieces.center[root_b, c]
            gap2 += d * d
        reach = pieces.reach[root_a] + pieces.reach[root_b] + least
        if gap2 > reach * reach:
            continue
        for r in range(3):
            p[r] = work.R[b, 0, r] * x + work.R[b, 1, r] * y + work.R[b, 2, r] * z
            for c in range(3):
                R[r, c] = (
                    work.R[b, 0, r] * work.R[a, 0, c]
                    + work.R[b, 1, r] * work.R[a, 1, c]
                    + work.R[b, 2, r] * work.R[a, 2, c]
                )
        work.search.witness[:] = -1
        least = min(least, tree_distance(pieces, root_a, root_b, R, p, _EXACT, work.search, least))
        if least <= 0.0:
            return 0.0
    return least


@kernel(nogil=True)
def rooms(room: Room, q: Array, wanted: float) -> Array:
    """`has_room` of postures q (M, n)."""
    work = room_work(room)
    out = np.empty(len(q))
    for k in range(len(q)):
        out[k] = has_room(room, q[k], wanted, work)
    return out
