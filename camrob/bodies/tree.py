"""Trees of convex pieces: a primitive is one piece, a mesh a balanced tree of boxes with one triangle a leaf."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.convex import BOX, CYLINDER, TRIANGLE, Pieces, piece_distance
from camrob.compiled import inlined, part

__all__ = ["Search", "ball_distance", "join_pieces", "mesh_pieces", "new_search", "solid_pieces", "tree_distance"]

Array = NDArray[np.float64]

_COARSE = 0.05  # how well boxes on the way to the leaves need be told apart
_FINE = 1e-3  # how well leaves are


def solid_pieces(kind: int, half: Sequence[float], sweep: float = 0.0) -> Pieces:
    """A body of one piece, BOX or CYLINDER, about its frame's origin, swept by a radius."""
    size = np.array([half], float)
    across = np.hypot(size[0, 0], size[0, 2]) if kind == CYLINDER else np.linalg.norm(size)
    none = np.array([-1])
    return Pieces(
        np.array([kind]),
        size,
        np.zeros((1, 3)),
        np.array([sweep]),
        np.array([across + sweep]),
        none,
        none.copy(),
        none.copy(),
        np.zeros((0, 3, 3)),
    )


def mesh_pieces(triangles: Array) -> Pieces:
    """A body of triangles (k, 3, 3), k > 0, in its frame: halved at the median of the longest side, level by level."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    middle = 0.5 * (low + high)
    order = np.arange(len(triangles))
    start = np.array([0])  # segments of `order`, one a node of the level
    lows, highs, lefts, corners = [], [], [], []
    made = 1
    while len(start):
        stop = np.append(start[1:], len(order))
        node_low = np.minimum.reduceat(low[order], start)
        node_high = np.maximum.reduceat(high[order], start)
        size = stop - start
        inner = size > 1
        left = np.full(len(start), -1)
        left[inner] = made + 2 * np.arange(inner.sum())
        made += 2 * int(inner.sum())
        lows.append(node_low)
        highs.append(node_high)
        lefts.append(left)
        corners.append(np.where(inner, -1, order[start]))
        segment = np.repeat(np.arange(len(start)), size)
        side = np.argmax(node_high - node_low, axis=1)[segment]
        keep = inner[segment]
        order, segment, side, size = order[keep], segment[keep], side[keep], size[inner]
        order = order[np.lexsort((middle[order, side], segment))]
        parts = np.stack([size // 2, size - size // 2], axis=1).ravel()
        start = np.concatenate([[0], np.cumsum(parts)[:-1]]) if len(parts) else parts
    lower, upper = np.concatenate(lows), np.concatenate(highs)
    left, corner = np.concatenate(lefts), np.concatenate(corners)
    center, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    leaf = np.flatnonzero(corner >= 0)
    relative = np.empty_like(triangles)
    relative[corner[leaf]] = triangles[corner[leaf]] - center[leaf, None, :]
    return Pieces(
        np.where(corner >= 0, TRIANGLE, BOX),
        half,
        center,
        np.zeros(len(half)),
        np.linalg.norm(half, axis=1),
        left,
        np.where(left >= 0, left + 1, -1),
        corner,
        relative,
    )


def join_pieces(bodies: Sequence[Pieces]) -> tuple[Pieces, NDArray[np.int64]]:
    """All bodies in one table, and which row is each body's root."""
    roots = np.cumsum([0, *(len(b.kind) for b in bodies)])[:-1]
    first = np.cumsum([0, *(len(b.triangles) for b in bodies)])[:-1]

    def moved(values: NDArray[np.int64], by: int) -> NDArray[np.int64]:
        return np.where(values >= 0, values + by, -1)

    kind, half, center, sweep, reach = (np.concatenate([b[k] for b in bodies]) for k in range(5))
    left = np.concatenate([moved(b.left, int(r)) for b, r in zip(bodies, roots, strict=True)])
    right = np.concatenate([moved(b.right, int(r)) for b, r in zip(bodies, roots, strict=True)])
    corner = np.concatenate([moved(b.corner, int(f)) for b, f in zip(bodies, first, strict=True)])
    triangles = np.concatenate([b.triangles for b in bodies])
    table = Pieces(kind, half, center, sweep, reach, left, right, corner, triangles)
    return table, roots


@inlined
def ball_distance(pieces: Pieces, a: int, b: int, R: Array, p: Array) -> float:
    """Distance of the balls about two pieces, a lower bound that costs little."""
    c = pieces.center[a]
    gap2 = 0.0
    for r in range(3):
        d = R[r, 0] * c[0] + R[r, 1] * c[1] + R[r, 2] * c[2] + p[r] - pieces.center[b, r]
        gap2 += d * d
    return float(np.sqrt(gap2) - pieces.reach[a] - pieces.reach[b])


class Search(NamedTuple):
    """What a search for the distance of two bodies leaves for the next one, and its working space.

    witness (2,): the two leaves that were nearest, or -1. stack (s, 2) and bounds (s,): pairs of nodes still to be
    looked at; s = 256 is beyond what trees of 2^100 triangles need. work: see `scratch`.
    """

    witness: NDArray[np.int64]
    stack: NDArray[np.int64]
    bounds: Array
    work: Array


@part
def new_search() -> Search:
    """A search that knows nothing yet."""
    return Search(np.full(2, -1), np.empty((256, 2), np.int64), np.empty(256), np.zeros((9, 3)))


@part
def tree_distance(
    pieces: Pieces,
    root_a: int,
    root_b: int,
    R: Array,
    p: Array,
    tolerance: float,
    search: Search,
    enough: float = np.inf,
) -> float:
    """Distance of two bodies, m, to within `tolerance` of itself and never above the true one; 0.0 where they touch. Of bodies
    farther apart than `enough` no more is found out than that.

    R (3, 3), p (3,): body a seen from body b. search: of the same two bodies in a posture close by, or a new one.
    """
    witness, stack, bounds, work = search
    if pieces.left[root_a] < 0 and pieces.left[root_b] < 0:
        return float(piece_distance(pieces, root_a, root_b, R, p, enough, min(tolerance, _FINE), work))
    best = enough
    if witness[0] >= 0:
        best = min(enough, piece_distance(pieces, witness[0], witness[1], R, p, np.inf, _FINE, work))
        if best <= 0.0:
            return 0.0
    low = best  # of what is passed over
    stack[0, 0], stack[0, 1], bounds[0] = root_a, root_b, 0.0
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] >= (1.0 - tolerance) * best:
            low = min(low, bounds[top])
            continue
        a, b = stack[top, 0], stack[top, 1]
        split_a = pieces.left[a] >= 0 and (pieces.left[b] < 0 or pieces.reach[a] > pieces.reach[b])
        base = top
        for side in range(2):
            na, nb = a, b
            if split_a:
                na = pieces.left[a] if side == 0 else pieces.right[a]
            else:
                nb = pieces.left[b] if side == 0 else pieces.right[b]
            close = (1.0 - tolerance) * best
            d = ball_distance(pieces, na, nb, R, p)
            leaf = pieces.left[na] < 0 and pieces.left[nb] < 0
            if d < close:
                d = piece_distance(pieces, na, nb, R, p, close, _FINE if leaf else _COARSE, work)
            if d >= close:
                low = min(low, d)
            elif leaf:
                best = d
                witness[0], witness[1] = na, nb
                if best <= 0.0:
                    return 0.0
            else:
                stack[top, 0], stack[top, 1], bounds[top] = na, nb, d
                top += 1
        if top == base + 2 and bounds[base] < bounds[base + 1]:  # the nearer one on top
            for c in range(2):
                stack[base, c], stack[base + 1, c] = stack[base + 1, c], stack[base, c]
            bounds[base], bounds[base + 1] = bounds[base + 1], bounds[base]
    return min(low, best)
