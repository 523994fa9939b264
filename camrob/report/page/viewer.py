"""The player's data: bodies sent once in their own frames, the chain that moves them, the run, and the stock as it is cut."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.shape import Shape, ShapeKind
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import plot_text
from camrob.report.page.pack import packed_floats, packed_integers
from camrob.report.page.stock import StockOnPage
from camrob.report.page.timeline import Run, chain_data, timeline_data
from camrob.report.page.triangles import Mesh, box_corners, joined, role_of, shape_mesh, thinned, world_T_frames
from camrob.units import deg_to_rad, m_to_mm

__all__ = ["ROLE_COLORS", "scene_data"]

Array = NDArray[np.float64]

ROLE_COLORS = {
    "floor": "#b4bcc6",
    "table": "#8d97a5",
    "carriage": "#76818e",
    "arm": "#ee7d25",
    "spindle": "#5f6b7a",
    "tool": "#e8d27a",
    "part": "#ded6c4",
    "stock": "#b98d5a",
}
"""Colours of bodies by what they belong to."""

PART_FACES = 20_000  # what a page stays small with; the part is thinned to it
SHAPE_FACES = 8_000  # likewise, each body of the cell
_VERTEX = 0.002  # mm: what corners of bodies are rounded to
_SIDES = 28  # of what is round
_POSTURES = 240  # in which the room that everything needs is looked at
_LOOK_SIDE_DEG = 62.0  # from aside, so that the arm hides neither tool nor table
_MARGIN = 0.08  # m round all that moves
_SEAM = 0.002  # m between a cut and the edge of the view


def _body(name: str, role: str, frame: str, mesh: Mesh) -> dict[str, Any]:
    return {
        "name": plot_text(name),
        "role": role,
        "color": ROLE_COLORS[role],
        "frame": frame,
        "vertices": packed_floats(m_to_mm(np.asarray(mesh.vertices, float)), _VERTEX),
        "faces": packed_integers(mesh.faces),
    }


def _view(path: ToolPathInBase, poses: Mapping[str, Array], meshes: list[tuple[Shape, Mesh]]) -> Array:
    """Corners (2, 3), m in `world`, of a box round all that moves in any of the stops; what stands may be cut off."""
    corners = [np.zeros((1, 3))]
    for shape, mesh in meshes:
        if shape.frame != "world":
            box = np.c_[box_corners(mesh.bounds), np.ones(8)]
            corners.append((poses[shape.frame] @ box.T)[:, :3].swapaxes(1, 2).reshape(-1, 3))
    tips = path.base_T_tip[:: max(1, len(path) // 500), :, 3]
    corners.append((poses["base"] @ tips.T)[:, :3].swapaxes(1, 2).reshape(-1, 3))
    every = np.concatenate(corners)
    return np.stack([every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN])


def _cut_off(mesh: Mesh, view: Array) -> Mesh:
    """A fixed box (floor, track bed) as far as the view goes, so that its cut is clean."""
    return mesh._replace(vertices=np.clip(mesh.vertices, view[0], view[1]))


def _look(poses: Mapping[str, Array]) -> list[float]:
    """Unit vector in `world` towards the eye: facing the robot, above, on the side that the tool faces."""
    world_p_root = poses["root"][:, :2, 3].mean(axis=0)
    away = poses["tool"][:, :2, 3].mean(axis=0) - world_p_root
    heading = float(np.arctan2(away[1], away[0])) if np.linalg.norm(away) > 1e-6 else 0.0
    world_z_tool = poses["tool"][:, :2, 2].mean(axis=0)
    facing_left = away[0] * world_z_tool[1] - away[1] * world_z_tool[0] > 1e-6
    heading += deg_to_rad(_LOOK_SIDE_DEG) * (1.0 if facing_left else -1.0)
    eye = np.array([np.cos(heading), np.sin(heading), 0.5])
    return [float(v) for v in eye / np.linalg.norm(eye)]


def scene_data(
    cell: Cell,
    path: ToolPathInBase,
    solution: Solution,
    names: Mapping[int, str],
    run: Run,
    *,
    part_mesh: Array | None,
    base_T_part: Array,
    threshold: float,
    stock: StockOnPage | None = None,
) -> dict[str, Any]:
    """All that player.js draws from; lengths in mm.

    part_mesh: the part's triangles (T, 3, 3), m, placed by base_T_part (4, 4).
    """
    q = np.asarray(solution.q)[np.unique(np.linspace(0, len(path) - 1, _POSTURES).astype(int))]
    poses = world_T_frames(cell, q)
    meshes = [(shape, thinned(shape_mesh(shape, cell.folder, sides=_SIDES), SHAPE_FACES)) for shape in cell.shapes]
    view = _view(path, poses, meshes)
    bodies = []
    for shape, mesh in meshes:
        fixed = shape.frame == "world" and shape.kind is ShapeKind.BOX
        shown = _cut_off(mesh, view) if fixed else mesh
        bodies.append(_body(shape.name, role_of(cell, shape.frame), shape.frame, shown))
    if part_mesh is not None and len(part_mesh):
        placed = thinned(joined(part_mesh), PART_FACES).placed(np.asarray(base_T_part))
        bodies.append(_body("part", "part", "base", placed))
    return {
        "chain": chain_data(cell),
        "bodies": bodies,
        "look": _look(poses),
        "view": m_to_mm(view + np.array([[-_SEAM], [_SEAM]])).tolist(),
        "run": timeline_data(cell, path, solution, names, run),
        "stock": None if stock is None else stock.data(base_T_part),
        "threshold": threshold,
        "highest": float(max(0.8, np.ceil(10.0 * float(np.max(solution.inv_kf, initial=0.0))) / 10.0)),
    }
