"""Triangles of a cell's shapes, for pictures."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.meshes import read_triangles
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.shape import Shape, ShapeKind
from camrob.errors import InputError
from camrob.kinematics import frames as kinematics

__all__ = ["Mesh", "box_corners", "joined", "role_of", "shape_mesh", "sphere", "thinned", "world_T_frames"]

Array = NDArray[np.float64]


class Mesh(NamedTuple):
    """Triangles that share corners. vertices: (V, 3), m; faces: (F, 3), which of them, counter-clockwise seen from outside.

    trimesh has all of this too, but its import, with those of networkx and SciPy, takes as long as posting a small part.
    """

    vertices: Array
    faces: NDArray[np.int64]

    @property
    def triangles(self) -> Array:
        """The corners (F, 3, 3), m."""
        return np.asarray(self.vertices[self.faces])

    @property
    def bounds(self) -> Array:
        """The lowest and the highest corner (2, 3), m, of a box round it."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def placed(self, frame_T_mesh: Array) -> Mesh:
        """The same mesh in the frame in which its pose is frame_T_mesh (4, 4)."""
        return self._replace(vertices=self.vertices @ frame_T_mesh[:3, :3].T + frame_T_mesh[:3, 3])


def joined(triangles: Array) -> Mesh:
    """The mesh of triangles (T, 3, 3), m, whose corners at the same place are one."""
    corners = triangles.reshape(-1, 3)
    order = np.lexsort(corners.T)
    first = np.append(True, np.any(corners[order[1:]] != corners[order[:-1]], axis=1))
    index = np.empty(len(corners), np.int64)
    index[order] = np.cumsum(first) - 1
    return Mesh(corners[order[first]], index.reshape(-1, 3))


def shape_mesh(shape: Shape, folder: Path, *, sides: int = 40) -> Mesh:
    """The shape's triangles in its frame, metres. `folder` is the cell's, for meshes; `sides` of what is round.

    Raises InputError where a mesh file can't be read.
    """
    size = shape.size
    if shape.kind is ShapeKind.BOX:
        mesh = Mesh(box_corners(np.stack([-0.5 * size, 0.5 * size])), _BOX_FACES)
    elif shape.kind is ShapeKind.CYLINDER:
        radius, half = float(size[0]), 0.5 * float(size[1])
        mesh = _revolved(np.array([0.0, radius, radius, 0.0]), np.array([-half, -half, half, half]), sides)
    elif shape.kind is ShapeKind.CAPSULE:
        mesh = sphere(float(size[0]), sides, 0.5 * float(size[1]))
    elif shape.kind is ShapeKind.SPHERE:
        mesh = sphere(float(size[0]), sides)
    else:
        mesh = joined(read_triangles(folder / shape.file, float(size[0]), InputError))
    return mesh.placed(np.asarray(shape.frame_T_shape))


def sphere(radius: float, sides: int, half: float = 0.0) -> Mesh:
    """A sphere about the origin, m, or where `half` is above 0 a capsule, whose two centres lie so far along z."""
    angle = np.linspace(0.0, np.pi, 2 * (sides // 4) + 2)  # an even number: the middle is a cylinder
    across, height = radius * np.sin(angle), -radius * np.cos(angle)
    across[[0, -1]] = 0.0
    return _revolved(across, height + np.where(height < 0.0, -half, half), sides)


def box_corners(bounds: Array) -> Array:
    """The eight corners (8, 3) of a box between its lowest and its highest (2, 3); x changes first."""
    return np.stack([bounds[[k & 1, k >> 1 & 1, k >> 2], [0, 1, 2]] for k in range(8)])


# of `box_corners`
_BOX_FACES = np.array(
    [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
)  # fmt: skip


def _revolved(radius: Array, height: Array, sides: int) -> Mesh:
    """What a line of radii and heights (K,), from below to above, closed on the axis, sweeps about z."""
    angle = 2.0 * np.pi / sides * np.arange(sides)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    rings = radius[:, None, None] * ring + height[:, None, None] * np.array([0.0, 0.0, 1.0])
    a, d = rings[:-1], rings[1:]
    b, c = np.roll(a, -1, axis=1), np.roll(d, -1, axis=1)
    lower, upper = np.stack([a, b, c], axis=2)[radius[:-1] > 0.0], np.stack([a, c, d], axis=2)[radius[1:] > 0.0]
    return joined(np.concatenate([lower.reshape(-1, 3, 3), upper.reshape(-1, 3, 3)]))


def thinned(mesh: Mesh, faces: int) -> Mesh:
    """A mesh of about `faces` triangles at most: its vertices gathered on a grid, coarser until it fits."""
    if len(mesh.faces) <= faces:
        return mesh
    corner = mesh.bounds[0]
    extent = max(float(np.max(mesh.bounds[1] - corner)), 1e-9)
    cells = 2.0 * np.sqrt(faces)
    while True:
        grid = np.rint((mesh.vertices - corner) * (cells / extent)).astype(np.int64)
        _, first, group = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        group = group.reshape(-1)
        corners = np.sort(group[mesh.faces], axis=1)
        solid = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
        _, keep = np.unique(corners[solid], axis=0, return_index=True)
        if len(keep) <= faces or cells < 4:
            return Mesh(mesh.vertices[first], group[mesh.faces][solid][keep])
        cells *= 0.85


def role_of(cell: Cell, frame: str) -> str:
    """What a frame's bodies are, for their colour: "floor", "table", "carriage", "arm", "spindle" or "tool"."""
    named = {"world": "floor", "base": "table", "root": "carriage", "flange": "spindle", "tool": "tool"}
    if frame in named:
        return named[frame]
    role = cell.joints[cell.index(frame)].role
    return {Role.WORKPIECE: "floor", Role.CARRIAGE: "carriage", Role.ARM: "arm", Role.ROLL: "tool"}[role]


def world_T_frames(cell: Cell, q: Array) -> dict[str, Array]:
    """Poses (P, 4, 4) in `world` of every frame that a shape may stand in, by name, in postures q (P, n)."""
    world_T_base = kinematics.world_T_base(cell, q)
    base_T_joints = kinematics.base_T_joint_frames(cell, q)
    frames: dict[str, Array] = {"world": np.broadcast_to(np.eye(4), world_T_base.shape), "base": world_T_base}
    frames["root"] = np.asarray(world_T_base @ kinematics.base_T_root(cell, q))
    frames["flange"] = np.asarray(world_T_base @ kinematics.base_T_flange(cell, q))
    frames["tool"] = np.asarray(world_T_base @ kinematics.base_T_tool(cell, q))
    for i, joint in enumerate(cell.joints):
        frames[joint.name] = np.asarray(world_T_base @ base_T_joints[i])
    return frames
