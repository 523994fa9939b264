"""Distance of two convex pieces, compiled: Gilbert, Johnson and Keerthi's algorithm with a certified lower bound.

A piece is a box, an upright cylinder or a triangle about its own centre, swept by a sphere: a point swept is a sphere,
a segment swept a capsule. Every support point bounds the distance from below (Gilbert, Johnson, Keerthi 1988, theorem
2: the pieces lie on two sides of a slab of width v.w/|v|), so what comes back is never more than the true distance,
however early the search stops.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined
from camrob.triples import copy3

__all__ = ["BOX", "CYLINDER", "TRIANGLE", "Pieces", "piece_distance", "scratch"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

BOX = 0
CYLINDER = 1
TRIANGLE = 2

_ROUNDS = 60  # of GJK, each of which comes nearer: an end for a pair that rounding turns in circles
_TOUCH = 1e-9  # m: nearer than this is touching


class Pieces(NamedTuple):
    """Trees of convex pieces, all bodies in one table; a leaf is what is solid, an inner node a box about it.

    kind (m,); half (m, 3): half lengths of a box, (radius, radius, half height) of a cylinder, of a triangle its
    bounding box's; center (m, 3) in the body's frame; sweep (m,) radius; reach (m,) radius of the ball about `center`
    that holds the piece; left, right (m,) children or -1; corner (m,) index into triangles, or -1; triangles (k, 3, 3)
    corners relative to their piece's centre.
    """

    kind: Index
    half: Array
    center: Array
    sweep: Array
    reach: Array
    left: Index
    right: Index
    corner: Index
    triangles: Array


@inlined
def _support(pieces: Pieces, node: int, x: float, y: float, z: float, out: Array) -> None:
    """out <- the point of a piece, relative to its centre, that lies farthest along (x, y, z)."""
    kind = pieces.kind[node]
    if kind == BOX:
        out[0] = pieces.half[node, 0] if x >= 0.0 else -pieces.half[node, 0]
        out[1] = pieces.half[node, 1] if y >= 0.0 else -pieces.half[node, 1]
        out[2] = pieces.half[node, 2] if z >= 0.0 else -pieces.half[node, 2]
    elif kind == CYLINDER:
        across = np.sqrt(x * x + y * y)
        scale = pieces.half[node, 0] / across if across > 1e-300 else 0.0
        out[0] = x * scale
        out[1] = y * scale
        out[2] = pieces.half[node, 2] if z >= 0.0 else -pieces.half[node, 2]
    else:
        corners = pieces.triangles[pieces.corner[node]]
        best, pick = -np.inf, 0
        for k in range(3):
            along = corners[k, 0] * x + corners[k, 1] * y + corners[k, 2] * z
            if along > best:
                best, pick = along, k
        for r in range(3):
            out[r] = corners[pick, r]


@inlined
def _on_edge(W: Array, i: int, j: int, v: Array) -> int:
    """v <- the point of an edge nearest to the origin; bits say which of the two corners carry it."""
    along, length2 = 0.0, 0.0
    for r in range(3):
        e = W[j, r] - W[i, r]
        along -= W[i, r] * e
        length2 += e * e
    t = along / length2 if length2 > 0.0 else 0.0
    mask = 3
    if t <= 0.0:
        t, mask = 0.0, 1
    elif t >= 1.0:
        t, mask = 1.0, 2
    for r in range(3):
        v[r] = W[i, r] + t * (W[j, r] - W[i, r])
    return mask


@inlined
def _on_triangle(W: Array, i: int, j: int, k: int, v: Array) -> int:
    """v <- the point of a triangle nearest to the origin; bits say which corners carry it (Ericson, section 5.1.5)."""
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for r in range(3):
        ab, ac = W[j, r] - W[i, r], W[k, r] - W[i, r]
        d1 -= ab * W[i, r]
        d2 -= ac * W[i, r]
        d3 -= ab * W[j, r]
        d4 -= ac * W[j, r]
        d5 -= ab * W[k, r]
        d6 -= ac * W[k, r]
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        copy3(W[i], v)
        return 1
    if d3 >= 0.0 and d4 <= d3:
        copy3(W[j], v)
        return 2
    if d6 >= 0.0 and d5 <= d6:
        copy3(W[k], v)
        return 4
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return int(_on_edge(W, i, j, v))
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        mask = int(_on_edge(W, i, k, v))
        return (mask & 1) | ((mask & 2) << 1)
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        return int(_on_edge(W, j, k, v)) << 1
    total = va + vb + vc
    if total <= 0.0:
        return int(_on_edge(W, i, j, v))
    for r in range(3):
        v[r] = W[i, r] + (vb * (W[j, r] - W[i, r]) + vc * (W[k, r] - W[i, r])) / total
    return 7


@inlined
def _beyond(W: Array, i: int, j: int, k: int, apex: int) -> bool:
    """Whether the origin lies on the other side of a face than the apex (also where there is no telling)."""
    ax, ay, az = W[j, 0] - W[i, 0], W[j, 1] - W[i, 1], W[j, 2] - W[i, 2]
    bx, by, bz = W[k, 0] - W[i, 0], W[k, 1] - W[i, 1], W[k, 2] - W[i, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    here = -(nx * W[i, 0] + ny * W[i, 1] + nz * W[i, 2])
    there = nx * (W[apex, 0] - W[i, 0]) + ny * (W[apex, 1] - W[i, 1]) + nz * (W[apex, 2] - W[i, 2])
    flat = 1e-9 * np.sqrt(nx * nx + ny * ny + nz * nz)  # apex within a nanometre of the face: no volume
    return bool(here * there <= 0.0 or abs(there) < flat)


# the corners of each face of a tetrahedron, then the corner across from it
_FACES = np.array([[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]])


@inlined
def _nearest(W: Array, n: int, v: Array, trial: Array) -> int:
    """v <- the point of a simplex of n corners nearest to the origin; keeps the corners that carry it, says how many.

    5: the origin lies within the tetrahedron.
    """
    if n == 1:
        copy3(W[0], v)
        return 1
    mask = 0
    if n == 2:
        mask = _on_edge(W, 0, 1, v)
    elif n == 3:
        mask = _on_triangle(W, 0, 1, 2, v)
    else:
        best = np.inf
        for f in range(4):
            i, j, k = _FACES[f, 0], _FACES[f, 1], _FACES[f, 2]
            if _beyond(W, i, j, k, _FACES[f, 3]):
                bits = _on_triangle(W, i, j, k, trial)
                size2 = trial[0] ** 2 + trial[1] ** 2 + trial[2] ** 2
                if size2 < best:
                    best = size2
                    copy3(trial, v)
                    mask = (1 << i) * (bits & 1) | (1 << j) * ((bits >> 1) & 1) | (1 << k) * ((bits >> 2) & 1)
        if mask == 0:
            return 5
    kept = 0
    for i in range(n):
        if mask & (1 << i):
            if kept != i:
                copy3(W[i], W[kept])
            kept += 1
    return kept


@inlined
def piece_distance(
    pieces: Pieces, a: int, b: int, R: Array, p: Array, enough: float, tolerance: float, work: Array
) -> float:
    """Distance of piece `a` from piece `b`, m, 0.0 where they touch; never above the true one.

    R (3, 3), p (3,): a's body seen from b's. The search ends once the distance is known to be `enough`, or to within
    `tolerance` of itself. work: see `scratch`.
    """
    W, v, s, x, trial = work[:5], work[5], work[6], work[7], work[8]
    sweep = pieces.sweep[a] + pieces.sweep[b]
    ca, cb = pieces.center[a], pieces.center[b]
    for r in range(3):  # from b's centre to a's
        trial[r] = R[r, 0] * ca[0] + R[r, 1] * ca[1] + R[r, 2] * ca[2] + p[r] - cb[r]
    ox, oy, oz = trial[0], trial[1], trial[2]
    copy3(trial, v)
    if ox * ox + oy * oy + oz * oz < 1e-18:
        v[0] = 1.0
    n, low, size = 0, -np.inf, np.inf
    for _ in range(_ROUNDS):
        norm = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
        if n > 0:
            if norm <= max(_TOUCH, sweep):
                return 0.0
            if norm >= size:  # no nearer than before: at the end of what float64 tells
                break
            size = norm
        _support(
            pieces,
            a,
            -(R[0, 0] * v[0] + R[1, 0] * v[1] + R[2, 0] * v[2]),
            -(R[0, 1] * v[0] + R[1, 1] * v[1] + R[2, 1] * v[2]),
            -(R[0, 2] * v[0] + R[1, 2] * v[1] + R[2, 2] * v[2]),
            s,
        )
        _support(pieces, b, v[0], v[1], v[2], x)
        W[n, 0] = ox + R[0, 0] * s[0] + R[0, 1] * s[1] + R[0, 2] * s[2] - x[0]
        W[n, 1] = oy + R[1, 0] * s[0] + R[1, 1] * s[1] + R[1, 2] * s[2] - x[1]
        W[n, 2] = oz + R[2, 0] * s[0] + R[2, 1] * s[1] + R[2, 2] * s[2] - x[2]
        low = max(low, (v[0] * W[n, 0] + v[1] * W[n, 1] + v[2] * W[n, 2]) / norm)
        if low - sweep >= enough or (n > 0 and norm - low <= tolerance * (norm - sweep) + _TOUCH):
            return float(max(0.0, low - sweep))
        n = _nearest(W, n + 1, v, trial)
        if n == 5:
            break
    return float(max(0.0, low - sweep))


def scratch() -> Array:
    """The work space of `piece_distance`."""
    return np.zeros((9, 3))
