"""Moves through air between regions, and the whole path in `base`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import ToolpathError
from camrob.kinematics.frames import base_T_tool
from camrob.resolve.frames import rotation_minimising
from camrob.resolve.path import TRANSIT, ToolPathInBase
from camrob.se3 import pose
from camrob.toolpath.region import Move
from camrob.toolpath.toolpath import Toolpath

__all__ = ["build_path"]

Array = NDArray[np.float64]

SAME_AXIS = 0.0087  # rad (half a degree): below it two regions count as worked from one side
_ARC_STEP = 0.1  # rad between points of a move around the part


@dataclass(frozen=True, slots=True)
class _End:
    """Where a region begins or ends: tip (3,), unit axis (3,), and whether the CL file has the tool in the air there."""

    tip: Array
    axis: Array
    in_air: bool
    operation: str


def build_path(
    cell: Cell, toolpath: Toolpath, base_T_part: Array, *, clearance: float, bounds: Array | None = None
) -> ToolPathInBase:
    """The toolpath placed in `base`, with moves through air before, between and after its regions.

    clearance: m above all that the file mentions (and `bounds` (K, 3), points of the stock in `base`). Regions worked from
    one side are linked above the highest point; regions worked from different sides around a sphere about the part, along
    which the tool axis turns. A link's points are safe places for revisions and file borders. Raises ToolpathError for
    a toolpath without points.
    """
    regions = [r for r in toolpath.regions if len(r)]
    if not regions:
        raise ToolpathError("holds no motion", cure="give a file with GOTO points", path=toolpath.source)
    R, p = base_T_part[:3, :3], base_T_part[:3, 3]
    tips = [r.position @ R.T + p for r in regions]
    axes = [r.axis @ R.T for r in regions]
    everything = np.concatenate([*tips, bounds]) if bounds is not None else np.concatenate(tips)
    parts: list[tuple[Array, Array, NDArray[np.int8], Array, NDArray[np.int64], int, NDArray[np.bool_]]] = []
    leave: _End | None = None
    for k, region in enumerate(regions):
        in_air = region.move[0] == Move.RAPID
        come = _End(tips[k][0], axes[k][0], in_air, region.operation)
        parts.append(_link(leave, come, everything, clearance))
        safe = _air_points(region.move)
        parts.append((tips[k], axes[k], region.move, region.feed, region.line, k, safe))
        leave = _End(tips[k][-1], axes[k][-1], region.move[-1] == Move.RAPID, region.operation)
    parts.append(_link(leave, None, everything, clearance))
    axis = np.concatenate([part[1] for part in parts])
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    home = base_T_tool(cell, cell.q_home)  # x starts at HOME's roll and is carried to the first point from there
    rotations = rotation_minimising(np.concatenate([home[None, :3, 2], axis]), np.ascontiguousarray(home[:3, 0]))[1:]
    frames = pose(rotations, np.concatenate([part[0] for part in parts]))
    return ToolPathInBase(
        base_T_tip=frames,
        move=np.concatenate([part[2] for part in parts]),
        feed=np.concatenate([part[3] for part in parts]),
        line=np.concatenate([part[4] for part in parts]),
        region=np.concatenate([np.full(len(part[0]), part[5]) for part in parts]),
        source=np.concatenate(
            [np.arange(len(part[0])) if part[5] != TRANSIT else np.full(len(part[0]), -1) for part in parts]
        ),
        safe=np.concatenate([part[6] for part in parts]),
    )


def _air_points(move: NDArray[np.int8]) -> NDArray[np.bool_]:
    """(N,) True where the tool came in rapid and leaves in rapid: it is clear of the part there."""
    rapid = move == Move.RAPID
    return np.asarray(rapid & np.append(rapid[1:], True))


def _link(
    leave: _End | None, come: _End | None, everything: Array, clearance: float
) -> tuple[Array, Array, NDArray[np.int8], Array, NDArray[np.int64], int, NDArray[np.bool_]]:
    """Points through air from the end of one region to the begin of the next (None: from or to HOME)."""
    points: list[tuple[Array, Array]] = []
    if leave is not None and come is not None:
        turn = np.arccos(np.clip(leave.axis @ come.axis, -1.0, 1.0))
        if turn <= SAME_AXIS:
            if not (leave.in_air and come.in_air and leave.operation == come.operation):
                points = [_lifted(leave, everything, clearance), _lifted(come, everything, clearance)]
        else:
            points = _around(leave, come, everything, clearance)
    elif leave is not None:
        points = [_lifted(leave, everything, clearance)]
    elif come is not None:
        points = [_lifted(come, everything, clearance)]
    n = len(points)
    tips = np.array([t for t, _ in points]).reshape(n, 3)
    axes = np.array([a for _, a in points]).reshape(n, 3)
    move = np.full(n, int(Move.LINK), np.int8)
    return tips, axes, move, np.full(n, np.nan), np.zeros(n, np.int64), TRANSIT, np.ones(n, np.bool_)


def _lifted(end: _End, everything: Array, clearance: float) -> tuple[Array, Array]:
    """The end drawn back along its axis above everything."""
    height = float(np.max(everything @ end.axis)) + clearance
    return end.tip + max(height - float(end.tip @ end.axis), clearance) * end.axis, end.axis


def _around(leave: _End, come: _End, everything: Array, clearance: float) -> list[tuple[Array, Array]]:
    """Out along the one axis, around the part on a sphere while the axis turns, in along the other."""
    center = 0.5 * (everything.min(axis=0) + everything.max(axis=0))
    radius = float(np.max(np.linalg.norm(everything - center, axis=1))) + clearance
    out, back = (_on_sphere(e, center, radius) for e in (leave, come))
    far = max(_angle(out - center, back - center), _angle(leave.axis, come.axis))
    count = max(2, int(np.ceil(far / _ARC_STEP)))
    points = []
    for s in np.linspace(0.0, 1.0, count + 1):
        direction = _between(out - center, back - center, float(s))
        points.append((center + radius * direction, _between(leave.axis, come.axis, float(s))))
    return points


def _on_sphere(end: _End, center: Array, radius: float) -> Array:
    """Where the ray from the tip along the axis leaves the sphere."""
    d = end.tip - center
    b = float(d @ end.axis)
    return np.asarray(end.tip + (-b + np.sqrt(b * b - float(d @ d) + radius * radius)) * end.axis)


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _between(a: Array, b: Array, s: float) -> Array:
    """Unit vector at the share s of the great arc from a to b; of the many arcs between opposites, one over +z or +x."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    v = np.cross(a, b)
    sine = float(np.linalg.norm(v))
    if sine < 1e-9:
        if a @ b > 0.0:
            return np.asarray(a)
        over = np.array([0.0, 0.0, 1.0]) if abs(a[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
        side = over - (over @ a) * a
        side = side / np.linalg.norm(side)
        return np.asarray(np.cos(s * np.pi) * a + np.sin(s * np.pi) * side)
    turn = np.arctan2(sine, a @ b)
    side = np.cross(v / sine, a)
    return np.asarray(np.cos(s * turn) * a + np.sin(s * turn) * side)
