"""Meshes from formulas: surface nets on a signed field, polar height fields, rounded slabs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import NDArray

__all__ = ["polar_relief", "rounded_slab", "stl", "surface_net"]

Array = NDArray[np.float64]


def surface_net(field: Callable[[Array], Array], low: Array, high: Array, cell: float) -> trimesh.Trimesh:
    """The zero surface of `field` (negative inside) as one vertex a cell, drawn onto the surface along the gradient."""
    size = np.ceil((high - low) / cell).astype(int) + 1
    axes = [low[i] + cell * np.arange(size[i]) for i in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    inside = field(grid.reshape(-1, 3)).reshape(size) < 0
    corners = [inside[i : size[0] - 1 + i, j : size[1] - 1 + j, k : size[2] - 1 + k] for i, j, k in np.ndindex(2, 2, 2)]
    full = np.sum(corners, axis=0)
    index = np.full(size - 1, -1)
    active = np.nonzero((full > 0) & (full < 8))
    index[active] = np.arange(len(active[0]))
    vertices = low + cell * (np.stack(active, axis=1) + 0.5)
    for _ in range(6):
        value = field(vertices)
        step = np.eye(3) * 0.05
        gradient = np.stack([(field(vertices + s) - field(vertices - s)) / 0.1 for s in step], axis=1)
        square = np.maximum((gradient**2).sum(1), 0.05)
        move = -(value / square)[:, None] * gradient
        vertices = vertices + np.clip(move, -0.4 * cell, 0.4 * cell)
    quads = []
    for axis in range(3):
        first = np.take(inside, range(size[axis] - 1), axis)
        second = np.take(inside, range(1, size[axis]), axis)
        i = np.stack(np.nonzero(first != second), axis=1)
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        quad = np.stack([index[tuple((i - d).T)] for d in (u + v, v, 0 * u, u)], axis=1)
        leaving = first[tuple(i.T)]  # inside, then outside: the face looks along +axis
        quads.append(np.where(leaving[:, None], quad, quad[:, ::-1]))
    q = np.concatenate(quads)
    return trimesh.Trimesh(vertices, np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]]), process=False)


def polar_relief(
    height: Callable[[Array, Array], Array], radius: float, rings: int, sectors: int, bottom: float
) -> trimesh.Trimesh:
    """A round body: its top is height(x, y), its wall upright, its bottom flat."""
    r = radius * np.arange(1, rings + 1) / rings
    angle = 2 * np.pi * np.arange(sectors) / sectors
    x, y = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
    top = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    middle = np.array([[0.0, 0.0, float(height(np.zeros(1), np.zeros(1))[0])]])
    foot = top[-sectors:] * [1, 1, 0] + [0, 0, bottom]
    vertices = np.concatenate([middle, top, foot, [[0.0, 0.0, bottom]]])
    i = np.arange(sectors)
    j = (i + 1) % sectors
    faces = [np.stack([0 * i, 1 + i, 1 + j], axis=1)]
    for ring in range(rings):  # the last strip is the wall
        a, b = 1 + ring * sectors, 1 + (ring + 1) * sectors
        faces += [np.stack([a + i, b + i, b + j], axis=1), np.stack([a + i, b + j, a + j], axis=1)]
    a = 1 + rings * sectors
    faces.append(np.stack([0 * i + len(vertices) - 1, a + j, a + i], axis=1))
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def rounded_slab(size: tuple[float, float, float], corner: float, arc_steps: int = 6) -> trimesh.Trimesh:
    """A slab centred in x and y, z from 0 up, with upright edges rounded by `corner`."""
    a = np.concatenate([np.linspace(q, q + 0.5 * np.pi, arc_steps + 1) for q in np.arange(4) * 0.5 * np.pi])
    sx = np.repeat([1, -1, -1, 1], arc_steps + 1) * (size[0] / 2 - corner)
    sy = np.repeat([1, 1, -1, -1], arc_steps + 1) * (size[1] / 2 - corner)
    rim = np.round(np.stack([sx + corner * np.cos(a), sy + corner * np.sin(a)], axis=1), 6)
    n = len(rim)
    rings = [np.column_stack([rim, np.full(n, z)]) for z in (0.0, size[2])]
    vertices = np.concatenate([*rings, [[0, 0, 0.0], [0, 0, size[2]]]])
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.concatenate(
        [
            np.stack([i, j, n + j], axis=1),
            np.stack([i, n + j, n + i], axis=1),
            np.stack([0 * i + 2 * n, j, i], axis=1),
            np.stack([0 * i + 2 * n + 1, n + i, n + j], axis=1),
        ]
    )
    return trimesh.Trimesh(vertices, faces, process=False)


def stl(mesh: trimesh.Trimesh) -> tuple[bytes, Array]:
    """The mesh as binary STL, rounded to micrometres, and its triangles (m, 3, 3) as a reader of that file has them."""
    triangles = np.round(mesh.vertices, 3).astype("<f4")[mesh.faces]
    side = triangles.astype(float)
    normal = np.cross(side[:, 1] - side[:, 0], side[:, 2] - side[:, 0])
    length = np.linalg.norm(normal, axis=1)
    keep = length > 1e-6
    rows = np.zeros(int(keep.sum()), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["n"] = np.round(normal[keep] / length[keep, None], 5)
    rows["v"] = triangles[keep]
    header = b"camrob sample, units mm".ljust(80)
    return header + np.uint32(len(rows)).tobytes() + rows.tobytes(), side[keep]
