"""Triangles of a cell's shapes, for pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.shape import Shape, ShapeKind
from camrob.errors import InputError
from camrob.kinematics import frames as kinematics

__all__ = ["role_of", "shape_mesh", "thinned", "world_T_frames"]

Array = NDArray[np.float64]


def shape_mesh(shape: Shape, folder: Path, *, sides: int = 40) -> trimesh.Trimesh:
    """The shape's triangles in its frame, metres. `folder` is the cell's, for meshes; `sides` of what is round.

    Raises InputError where a mesh file can't be read.
    """
    size = shape.size
    if shape.kind is ShapeKind.BOX:
        mesh = trimesh.creation.box(size)
    elif shape.kind is ShapeKind.CYLINDER:
        mesh = trimesh.creation.cylinder(radius=size[0], height=size[1], sections=sides)
    elif shape.kind is ShapeKind.CAPSULE:
        mesh = trimesh.creation.capsule(radius=size[0], height=size[1], count=[sides, sides])
        mesh.apply_translation([0.0, 0.0, -0.5 * (mesh.bounds[0, 2] + mesh.bounds[1, 2])])
    elif shape.kind is ShapeKind.SPHERE:
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=size[0])
    else:
        file = folder / shape.file
        try:
            mesh = trimesh.load_mesh(file)
        except (OSError, ValueError) as error:
            raise InputError(
                f"the mesh of shape {shape.name!r} can't be read: {error}",
                hint="give an STL, OBJ or PLY file",
                path=file,
            ) from error
        mesh.apply_scale(float(size[0]))
    mesh.apply_transform(np.asarray(shape.frame_T_shape))
    return mesh


def thinned(mesh: trimesh.Trimesh, faces: int) -> trimesh.Trimesh:
    """A mesh of about `faces` triangles at most: its vertices gathered on a grid, coarser until it fits."""
    if len(mesh.faces) <= faces:
        return mesh
    corner, extent = mesh.bounds[0], max(float(np.max(mesh.extents)), 1e-9)
    cells = 2.0 * np.sqrt(faces)
    while True:
        grid = np.rint((mesh.vertices - corner) * (cells / extent)).astype(np.int64)
        _, first, group = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        group = group.reshape(-1)
        corners = np.sort(group[mesh.faces], axis=1)
        solid = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
        _, keep = np.unique(corners[solid], axis=0, return_index=True)
        if len(keep) <= faces or cells < 4:
            return trimesh.Trimesh(mesh.vertices[first], group[mesh.faces][solid][keep], process=False)
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
