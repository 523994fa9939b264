"""A ball-end mill let down on a triangle mesh: where its centre comes to rest. Exact on facets, edges and vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["distance_to_triangles", "drop", "thin"]

Array = NDArray[np.float64]
_CHUNK = 256


def drop(triangles: Array, xy: Array, radius: float, floor: float) -> Array:
    """Heights (n,) of the ball's centre over the places xy (n, 2), never below `floor`.

    triangles: (m, 3, 3) in the frame whose +z the tool comes from. All lengths are in mm.
    """
    low, high = triangles[:, :, :2].min(1) - radius, triangles[:, :, :2].max(1) + radius
    height = np.full(len(xy), floor)
    for start in range(0, len(xy), _CHUNK):
        p = xy[start : start + _CHUNK]
        i, k = _near(p, low, high)
        if len(i):
            best = np.maximum(_on_facet(triangles[k], p[i], radius), _on_corner(triangles[k], p[i], radius))
            for a, b in ((0, 1), (1, 2), (2, 0)):
                best = np.maximum(best, _on_edge(triangles[k, a], triangles[k, b], p[i], radius))
            np.maximum.at(height, start + i, best)
    return height


def _near(p: Array, low: Array, high: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs (point, box) where the point lies in the box."""
    boxes = np.flatnonzero(np.all((high >= p.min(0)) & (low <= p.max(0)), axis=1))
    i, k = np.nonzero(np.all((p[:, None] >= low[boxes]) & (p[:, None] <= high[boxes]), axis=2))
    return i, boxes[k]


def _on_facet(t: Array, p: Array, radius: float) -> Array:
    d, e = (t[:, 1] - t[:, 0])[:, :2], (t[:, 2] - t[:, 0])[:, :2]
    clockwise = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0] < 0  # an underside: the ball rests on the plane all the same
    t = np.where(clockwise[:, None, None], t[:, ::-1], t)
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0, length, 1.0)[:, None]
    ok = normal[:, 2] > 1e-6
    nz = np.where(ok, normal[:, 2], 1.0)
    z = (radius + (normal * t[:, 0]).sum(1) - (normal[:, :2] * p).sum(1)) / nz
    touch = p - radius * normal[:, :2]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        d, w = t[:, b, :2] - t[:, a, :2], touch - t[:, a, :2]
        ok &= d[:, 0] * w[:, 1] - d[:, 1] * w[:, 0] >= -1e-9
    return np.where(ok, z, -np.inf)


def _on_corner(t: Array, p: Array, radius: float) -> Array:
    gap = radius**2 - ((t[:, :, :2] - p[:, None]) ** 2).sum(2)
    return np.where(gap >= 0, t[:, :, 2] + np.sqrt(np.maximum(gap, 0)), -np.inf).max(1)


def _on_edge(a: Array, b: Array, p: Array, radius: float) -> Array:
    d = b - a
    length = np.linalg.norm(d, axis=1)
    u = d / np.where(length > 0, length, 1.0)[:, None]
    w = p - a[:, :2]
    along = (w * u[:, :2]).sum(1)
    square = 1.0 - u[:, 2] ** 2  # the ball's centre is `radius` off the edge's line: a quadratic in its height
    ok = square > 1e-9
    square = np.where(ok, square, 1.0)
    half = along * u[:, 2] / square
    root = half**2 - ((w**2).sum(1) - along**2 - radius**2) / square
    rise = half + np.sqrt(np.maximum(root, 0))
    t = along + u[:, 2] * rise
    return np.where(ok & (root >= 0) & (t >= 0) & (t <= length), a[:, 2] + rise, -np.inf)


def thin(points: Array, tolerance: float, longest: float = np.inf) -> NDArray[np.intp]:
    """Indices of the points (n, d) to keep so that no dropped one is further than `tolerance` from its chord."""
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    todo = [(0, len(points) - 1)]
    while todo:
        a, b = todo.pop()
        if b - a < 2:
            continue
        chord = points[b] - points[a]
        length = float(np.linalg.norm(chord))
        w = points[a + 1 : b] - points[a]
        t = np.clip(w @ chord / max(length**2, 1e-12), 0.0, 1.0)
        off = np.linalg.norm(w - t[:, None] * chord, axis=1)
        worst = int(np.argmax(np.round(off, 6)))
        split = a + 1 + worst if off[worst] > tolerance else (a + b) // 2
        if off[worst] > tolerance or length > longest:
            keep[split] = True
            todo += [(a, split), (split, b)]
    return np.flatnonzero(keep)


def distance_to_triangles(points: Array, triangles: Array, within: float) -> Array:
    """Distances (n,) of points (n, 3) to the mesh; those beyond `within` are given as `within`."""
    low, high = triangles.min(1) - within, triangles.max(1) + within
    found = np.full(len(points), within)
    for start in range(0, len(points), _CHUNK):
        p = points[start : start + _CHUNK]
        i, k = _near(p, low, high)
        if len(i):
            np.minimum.at(found, start + i, _point_triangle(p[i], triangles[k]))
    return found


def _point_triangle(p: Array, t: Array) -> Array:
    best = np.full(len(p), np.inf)
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    inside = np.ones(len(p), dtype=bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        d, w = t[:, b] - t[:, a], p - t[:, a]
        s = np.clip((w * d).sum(1) / np.maximum((d**2).sum(1), 1e-18), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(w - s[:, None] * d, axis=1))
        inside &= (np.cross(d, w) * normal).sum(1) >= 0
    length = np.linalg.norm(normal, axis=1)
    plane = np.abs(((p - t[:, 0]) * normal).sum(1)) / np.where(length > 0, length, np.inf)
    return np.where(inside & (length > 0), np.minimum(best, plane), best)
