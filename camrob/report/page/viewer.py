"""The 3D view's data: bodies sent once in their own frames, and the frames' poses at points that a slider picks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.shape import Shape, ShapeKind
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import plot_text
from camrob.report.page.pack import packed_floats, packed_integers
from camrob.report.page.path_charts import axis_limits
from camrob.report.page.thinning import path_indices
from camrob.report.page.triangles import role_of, shape_mesh, thinned, world_T_frames
from camrob.units import deg_to_rad, m_to_mm

__all__ = ["ROLE_COLORS", "Stop", "scene_data", "stops"]

Array = NDArray[np.float64]

ROLE_COLORS = {
    "floor": "#b4bcc6",
    "table": "#8d97a5",
    "carriage": "#76818e",
    "arm": "#ee7d25",
    "spindle": "#5f6b7a",
    "tool": "#e8d27a",
    "part": "#ded6c4",
}
"""Colours of bodies by what they belong to."""

PART_FACES = 20_000  # what a page stays small with; the part is thinned to it
SHAPE_FACES = 8_000  # likewise, each body of the cell
PATH_POINTS = 16_000  # likewise, the path
_STOPS = 100  # postures that the slider stops at
_LOOK_SIDE_DEG = 62.0  # from aside, so that the arm hides neither tool nor table
_MARGIN = 0.08  # m round all that moves
_SEAM = 0.002  # m between a cut and the edge of the view
_MOST_STOPS = 240
_STOPS_OF_REVISION = 5

Stop = tuple[int, Array, str]
"""A stop of the slider: the path's point, the posture (n,), and a remark ('' but in a revision)."""


def stops(path: ToolPathInBase, solution: Solution, names: Mapping[int, str]) -> list[Stop]:
    """Where the robot is shown: evenly along the path, at each region's ends, at the lowest 1/k_F, and through each
    posture revision (of many regions or revisions as many as fit).
    """
    n = len(path)
    if not n:
        return []
    length = path.length
    even = np.searchsorted(length, np.linspace(0.0, length[-1], _STOPS)).clip(0, n - 1)
    turns = np.flatnonzero(np.diff(path.region)) + 1
    ends = np.unique(np.concatenate([turns, turns - 1]))
    if len(ends) > _STOPS // 2:
        ends = ends[np.linspace(0, len(ends) - 1, _STOPS // 2).astype(int)]
    picked = np.unique(np.concatenate([even, ends, [0, n - 1, int(np.argmin(solution.inv_kf))]]).astype(int))
    out: list[tuple[int, int, Array, str]] = [(int(i), _STOPS_OF_REVISION, solution.q[i], "") for i in picked]
    for revision in solution.revisions:
        if not revision.kept or len(out) + _STOPS_OF_REVISION > _MOST_STOPS:
            continue
        name = names.get(revision.region, f"region {revision.region}")
        steps = np.unique(np.linspace(0, len(revision.q) - 1, _STOPS_OF_REVISION).astype(int))
        remark = f"posture revision before {name}"
        out += [(revision.point, k, revision.q[i], remark) for k, i in enumerate(steps)]
    out.sort(key=lambda stop: stop[:2])
    return [(point, q, remark) for point, _, q, remark in out]


def _body(name: str, role: str, frame: int, mesh: trimesh.Trimesh) -> dict[str, Any]:
    return {
        "name": plot_text(name),
        "role": role,
        "color": ROLE_COLORS[role],
        "frame": frame,
        "vertices": packed_floats(m_to_mm(np.asarray(mesh.vertices, float))),
        "faces": packed_integers(mesh.faces),
    }


def _view(path: ToolPathInBase, poses: Mapping[str, Array], meshes: list[tuple[Shape, trimesh.Trimesh]]) -> Array:
    """Corners (2, 3), m in `world`, of a box round all that moves in any of the stops; what stands may be cut off."""
    corners = [np.zeros((1, 3))]
    for shape, mesh in meshes:
        if shape.frame != "world":
            box = np.c_[trimesh.bounds.corners(mesh.bounds), np.ones(8)]
            corners.append((poses[shape.frame] @ box.T)[:, :3].swapaxes(1, 2).reshape(-1, 3))
    tips = path.base_T_tip[:: max(1, len(path) // 500), :, 3]
    corners.append((poses["base"] @ tips.T)[:, :3].swapaxes(1, 2).reshape(-1, 3))
    every = np.concatenate(corners)
    return np.stack([every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN])


def _cut_off(mesh: trimesh.Trimesh, view: Array) -> trimesh.Trimesh:
    """A fixed box (floor, track bed) as far as the view goes, so that its cut is clean."""
    cut = mesh.copy()
    cut.vertices = np.clip(mesh.vertices, view[0], view[1])
    return cut


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
    *,
    part_mesh: trimesh.Trimesh | None,
    base_T_part: Array,
    threshold: float,
) -> dict[str, Any]:
    """All that page.js draws the 3D view from; lengths in mm, poses as the first three rows of world_T_frame."""
    chosen = stops(path, solution, names)
    q = np.stack([posture for _, posture, _ in chosen]) if chosen else cell.q_home[None]
    poses = world_T_frames(cell, q)
    used = {shape.frame for shape in cell.shapes} | {"base", "tool"}
    frames = [name for name in poses if name in used]
    matrices = np.stack([poses[name][:, :3, :].copy() for name in frames], axis=1)
    matrices[..., 3] = m_to_mm(matrices[..., 3])
    meshes = [(shape, thinned(shape_mesh(shape, cell.folder), SHAPE_FACES)) for shape in cell.shapes]
    view = _view(path, poses, meshes)
    bodies = []
    for shape, mesh in meshes:
        fixed = shape.frame == "world" and shape.kind is ShapeKind.BOX
        shown = _cut_off(mesh, view) if fixed else mesh
        bodies.append(_body(shape.name, role_of(cell, shape.frame), frames.index(shape.frame), shown))
    if part_mesh is not None and len(part_mesh.faces):
        placed = thinned(part_mesh, PART_FACES).copy()
        placed.apply_transform(np.asarray(base_T_part))
        bodies.append(_body("part", "part", frames.index("base"), placed))
    points = np.array([point for point, _, _ in chosen], dtype=np.int64)
    s_mm = m_to_mm(path.length)
    return {
        "frames": frames,
        "bodies": bodies,
        "look": _look(poses),
        "view": m_to_mm(view + np.array([[-_SEAM], [_SEAM]])).tolist(),
        "stops": {
            "matrices": packed_floats(matrices),
            "count": len(q),
            "axes": packed_floats(cell.to_axis_values(q)),
            "s": packed_floats(s_mm[points]),
            "line": packed_integers(path.line[points]),
            "region": packed_integers(path.region[points]),
            "kf": packed_floats(solution.inv_kf[points]),
            "remarks": [plot_text(remark) for _, _, remark in chosen],
        },
        "axes": [
            {"name": name, "unit": "mm" if cell.joints[cell.index(name)].prismatic else "°", "limits": list(limits)}
            for name, limits in axis_limits(cell).items()
        ],
        "path": _path_data(path, solution),
        "threshold": threshold,
        "highest": float(max(0.8, np.ceil(10.0 * float(np.max(solution.inv_kf, initial=0.0))) / 10.0)),
    }


def _path_data(path: ToolPathInBase, solution: Solution) -> dict[str, Any]:
    """The thinned path in `base`, mm: a point's `cut` says whether the tool came to it cutting."""
    cutting = path.cutting
    change = np.zeros(len(path), dtype=bool)
    if len(path) > 1:
        differs = np.flatnonzero(np.diff(cutting.astype(np.int8)))
        change[differs] = change[differs + 1] = True
        change[int(np.argmin(solution.inv_kf))] = True
    picked = path_indices(np.asarray(path.base_T_tip[:, :3, 3]), change, PATH_POINTS)
    return {
        "p": packed_floats(m_to_mm(path.base_T_tip[picked, :3, 3])),
        "kf": packed_floats(solution.inv_kf[picked]),
        "line": packed_integers(path.line[picked]),
        "region": packed_integers(path.region[picked]),
        "cut": packed_integers(cutting[picked]),
    }
