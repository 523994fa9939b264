"""A cell's bodies for collision checks: which frame each follows, and as what convex pieces it is seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.convex import BOX, CYLINDER, Pieces
from camrob.bodies.meshes import read_triangles
from camrob.bodies.tree import mesh_pieces, solid_pieces
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.setup import ToolSetup
from camrob.cell.shape import Shape, ShapeKind
from camrob.errors import CellError
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_joint_frames, world_T_base
from camrob.se3 import inverse

__all__ = ["JOB_GROUPS", "TOOL_GROUP", "Body", "base_T_bodies", "cell_bodies", "follows", "job_body", "slimmer"]

Array = NDArray[np.float64]

TOOL_GROUP = "tool"
"""The group of what cuts: it may touch the job's bodies while it cuts."""
JOB_GROUPS = ("part", "stock")
"""The groups of the bodies that a job brings."""


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body that follows the frame behind joint `link` of the chain (-1: `base`), link_T_body (4, 4) in it.

    shape: the cell's shape that it stands for, None for a job's body. triangles: (k, 3, 3) in the body's frame, of a
    mesh; None for a primitive.
    """

    name: str
    group: str
    link: int
    link_T_body: Array
    pieces: Pieces
    ignore: tuple[str, ...] = ()
    shape: Shape | None = None
    triangles: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "link_T_body", locked(self.link_T_body, shape=(4, 4), name="link_T_body"))


def follows(cell: Cell, frame: str) -> tuple[int, Array]:
    """The joint (index in the chain, -1 for `base`) behind which a frame of the cell rides, and its pose (4, 4) there.

    `tool` is the real tool's frame, the virtual roll at 0. Raises KeyError for an unknown frame.
    """
    arm = cell.indices(Role.ARM)
    if frame == "base":
        return -1, np.eye(4)
    if frame == "world":
        workpiece = cell.indices(Role.WORKPIECE)
        if not workpiece:
            return -1, np.eye(4)
        home = cell.q_home
        base_T_floor = base_T_joint_frames(cell, home)[workpiece[-1]]
        return workpiece[-1], inverse(world_T_base(cell, home) @ base_T_floor)
    if frame == "root":
        link_T_foot = cell.base_T_first if arm[0] == 0 else np.eye(4)
        return arm[0] - 1, link_T_foot @ cell.foot_T_root
    if frame == "flange":
        return arm[-1], np.array(cell.wrist_T_flange)
    if frame == "tool":
        return arm[-1], np.asarray(cell.wrist_T_flange @ cell.flange_T_tool)
    return cell.index(frame), np.eye(4)


def cell_bodies(cell: Cell, tool: ToolSetup | None = None) -> tuple[Body, ...]:
    """The bodies of a cell's shapes; a tool whose diameter and length are known takes the place of the group "tool".

    Raises CellError where a mesh of the cell can't be read.
    """
    shapes = cell.shapes
    if tool is not None and tool.diameter > 0.0 and tool.length > 0.0:
        ignored = {g for s in shapes if s.group == TOOL_GROUP for g in s.ignore}
        tip_T_middle = np.eye(4)
        tip_T_middle[2, 3] = 0.5 * tool.length
        size = np.array([0.5 * tool.diameter, tool.length])
        mounted = Shape(
            tool.name or "tool", TOOL_GROUP, "tool", ShapeKind.CYLINDER, size, tip_T_middle, "", tuple(sorted(ignored))
        )
        shapes = (*(s for s in shapes if s.group != TOOL_GROUP), mounted)
    return tuple(_body(cell, s) for s in shapes)


def _body(cell: Cell, shape: Shape) -> Body:
    """The body of one shape."""
    link, link_T_frame = follows(cell, shape.frame)
    link_T_body = link_T_frame @ shape.frame_T_shape
    triangles = None
    if shape.kind is ShapeKind.MESH:
        triangles = read_triangles(cell.folder / shape.file, float(shape.size[0]), CellError)
        pieces = _tree(triangles)
    else:
        pieces = _solid(shape)
    return Body(shape.name, shape.group, link, link_T_body, pieces, shape.ignore, shape, triangles)


def _solid(shape: Shape, less: float = 0.0, *, rounded: bool = False) -> Pieces:
    """A primitive, its surface moved inwards by `less`; `rounded`: the upright capsule within a cylinder."""
    size = shape.size
    thin = 0.1  # a body that is thinner than the allowance keeps a core
    if shape.kind is ShapeKind.BOX:
        return solid_pieces(BOX, [max(thin * s, 0.5 * s - less) for s in size])
    radius = max(thin * float(size[0]), float(size[0]) - less)
    if shape.kind is ShapeKind.SPHERE:
        return solid_pieces(BOX, [0.0, 0.0, 0.0], radius)
    if shape.kind is ShapeKind.CAPSULE:
        return solid_pieces(BOX, [0.0, 0.0, 0.5 * float(size[1])], radius)
    half = max(thin * float(size[1]), 0.5 * float(size[1]) - less)
    if rounded:
        return solid_pieces(BOX, [0.0, 0.0, max(0.0, half - radius)], min(radius, half))
    return solid_pieces(CYLINDER, [radius, radius, half])


def job_body(group: str, triangles: Array, base_T_part: Array) -> Body:
    """The part's or the stock's body from its triangles (k, 3, 3) in the frame `part`."""
    return Body(group, group, -1, base_T_part, _tree(triangles), (), None, triangles)


def _tree(triangles: Array) -> Pieces:
    """`mesh_pieces`, kept: a plan looks at the same bodies some ten times, and making a tree of 20 000 triangles takes 0.1 s."""
    return _kept_tree(np.ascontiguousarray(triangles, float).tobytes())


@lru_cache(maxsize=16)
def _kept_tree(data: bytes) -> Pieces:
    return mesh_pieces(np.frombuffer(data).reshape(-1, 3, 3))


def slimmer(body: Body, less: float, *, rounded: bool = False) -> Body:
    """A body of the cell with its surface moved inwards by `less` (m), for contacts that are to be allowed.

    `rounded`: of a cylinder, the upright capsule within it, as if the tool were a ball cutter. A mesh is drawn in about
    the middle of its bounding box.
    """
    if body.shape is not None and body.triangles is None:
        return replace(body, pieces=_solid(body.shape, less, rounded=rounded))
    if body.triangles is None:
        return body
    corners = body.triangles.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-9)
    triangles = middle + (body.triangles - middle) * np.maximum(0.1, 1.0 - less / half)
    return replace(body, pieces=mesh_pieces(triangles), triangles=triangles)


def base_T_bodies(cell: Cell, bodies: tuple[Body, ...], q: Array) -> Array:
    """Poses (K, ..., 4, 4) in `base` of K bodies in postures q (..., n): for pictures, and the twin of the kernels."""
    base_T_link = base_T_joint_frames(cell, q)
    out = np.empty((len(bodies), *q.shape[:-1], 4, 4))
    for k, body in enumerate(bodies):
        out[k] = body.link_T_body if body.link < 0 else base_T_link[body.link] @ body.link_T_body
    return out
