"""Still figures (PNG): 1/k_F along the path, the cell with the path coloured by it, and the cell at one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imsave
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.shape import ShapeKind
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.path_charts import Along
from camrob.report.page.render import Facets, render, screen_R_world
from camrob.report.page.thinning import curve_indices, path_indices
from camrob.report.page.triangles import role_of, shape_mesh, sphere, world_T_frames
from camrob.report.page.viewer import ROLE_COLORS
from camrob.se3 import pose
from camrob.units import deg_to_rad

__all__ = ["figure_conditioning", "figure_overview", "place_picture"]

Array = NDArray[np.float64]

_COLORS = ("#e08a1e", "#8a63d2", "#8a93a0", "#b5651d")
_POINTS = 4000  # more than a figure has pixels across
_DPI = 160  # a page's width at twice a screen's resolution
_SIDES = 120  # of a cylinder
# where the eye stands: turned from the line robot to tool, and so high above it
_TURN, _ABOVE = deg_to_rad(-58.0), 0.52
_FLOOR = 1.4  # m of floor round all that moves
_PATH_WIDTH_PX = 2.4
_FADE = (0.6, 1.3)  # m from the middle where floor and track begin to fade and are gone
_SMALLEST = 0.02  # m, width of a picture
_WHOLE, _CLOSE = (1120, 1056), (576, 634)  # pixels of the two pictures
_PLACE = (520, 520)  # pixels of each of the two pictures of a place
_NEAR = 0.3  # m, width of the nearer one
_BALL, _MARK = 0.02, "#d6302b"  # radius of what marks a place, as a share of the picture's width, and its colour
_SCALE = [(0.0, "#67001f"), (0.44, "#d6302b"), (0.625, "#f5a623"), (0.74, "#35a883"), (1.0, "#2166ac")]


def _save(figure: Figure, file: Path) -> None:
    FigureCanvasAgg(figure)
    figure.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})


def figure_conditioning(
    path: ToolPathInBase,
    solution: Solution,
    *,
    file: Path,
    threshold: float,
    names: Mapping[int, str] | None = None,
    comparison: Mapping[str, Array] | None = None,
    bound: Array | None = None,
) -> None:
    """Writes 1/k_F along the path, beside other solutions' and the bound where given (after the paper's Figure 10).

    names: the regions', written above their stretches. comparison: (N,) each, NaN where there is none. bound: (N,).
    """
    along = Along.of(path, names or {})
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    curves = [(name, kf, _COLORS[k % len(_COLORS)], 1.0) for k, (name, kf) in enumerate((comparison or {}).items())]
    if bound is not None:
        curves.append(("upper bound at each point", bound, "#2f9e77", 1.0))
    curves.append(("this program", solution.inv_kf, "#2f7fd1", 1.8))
    for name, kf, color, width in curves:
        picked = curve_indices(np.asarray(kf, float), _POINTS)
        axes.plot(along.s_mm[picked], kf[picked], color=color, linewidth=width, label=name.replace("$", r"\$"))
    axes.axhline(threshold, color="#d64545", linestyle="--", linewidth=1.0, label=f"threshold {threshold:g}")
    if along.banded:
        for region, first, last in along.runs():
            tint = "#2f7fd1" if region % 2 == 0 else "#e08a1e"
            axes.axvspan(along.s_mm[first], along.s_mm[last], color=tint, alpha=0.08, linewidth=0)
            if names and len(names) <= 8:
                middle = 0.5 * (along.s_mm[first] + along.s_mm[last])
                text = names.get(region, "").replace("$", r"\$")
                axes.annotate(text, (middle, 1.01), xycoords=("data", "axes fraction"), ha="center", fontsize=8)
    axes.set_xlabel("path length of the tool tip [mm]")
    axes.set_ylabel(r"$1/k_F$ (0: singular)")
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)
    axes.grid(color="#e6e9ee")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside lower center", ncols=len(curves) + 1, frameon=False, fontsize=9, handlelength=1.6)
    _save(figure, file)


def figure_overview(
    cell: Cell,
    path: ToolPathInBase,
    solution: Solution,
    *,
    file: Path,
    point: int,
    part_mesh: Array | None = None,
    base_T_part: Array | None = None,
) -> None:
    """Writes a picture of the cell at a point of the path: bodies, part, and the path coloured by 1/k_F.

    part_mesh: triangles (T, 3, 3) in its own frame, m, placed by base_T_part (the identity by default).
    """
    poses = {name: poses_[0] for name, poses_ in world_T_frames(cell, solution.q[point][None]).items()}
    towards_eye = _towards_eye(poses)
    colors = LinearSegmentedColormap.from_list("kf", _SCALE)
    norm = Normalize(0.0, 1.6 * cell.resolve.threshold)
    bodies = _body_facets(cell, poses, part_mesh, np.eye(4) if base_T_part is None else base_T_part)
    moving = np.concatenate([f.corners.reshape(-1, 3) for name, f in bodies if name != "world"])
    cut = path.base_T_tip[path.cutting if path.cutting.any() else slice(None), :3, 3]
    tips = cut @ poses["base"][:3, :3].T + poses["base"][:3, 3]
    rgba = colors(norm(solution.inv_kf))
    pictures = []
    for shown, pixels, room in ((moving, _WHOLE, 1.06), (tips, _CLOSE, 1.3)):
        center, width_m = _framed(shown, towards_eye, pixels, room)
        way = np.asarray(path.base_T_tip[:, :3, 3])
        ribbon = _path_facets(way, path.cutting, poses["base"], towards_eye, width_m / pixels[0], rgba)
        every = Facets.joined([*(f for _, f in bodies), ribbon])
        pictures.append(
            render(every, towards_eye=towards_eye, center=center, width_m=width_m, pixels=pixels, fade=_FADE)
        )
    figure = Figure(figsize=(10.0, 6.6))
    axes = figure.add_axes((0.3, 0.0, 0.7, 1.0))
    axes.imshow(pictures[0], interpolation="lanczos")
    axes.set_axis_off()
    close = figure.add_axes((0.015, 0.36, 0.36, 0.6))
    close.imshow(pictures[1], interpolation="lanczos")
    close.set(xticks=[], yticks=[])
    close.spines[:].set_color("#8a93a0")
    bar = figure.colorbar(
        ScalarMappable(norm, colors), cax=figure.add_axes((0.03, 0.2, 0.33, 0.026)), orientation="horizontal"
    )
    bar.ax.axvline(cell.resolve.threshold, color="#1d2530", linewidth=1.5)
    bar.outline.set_visible(False)
    bar.set_label(f"$1/k_F$ along the path (0: singular; line: threshold {cell.resolve.threshold:g})", fontsize=9)
    _save(figure, file)


def place_picture(cell: Cell, q: Array, base_p: Array, shown: NDArray[np.bool_]) -> bytes:
    """A PNG of the cell in a posture q (n,), and of what is about the tool's tip, at which is a red ball; the way base_p (N, 3)
    of the tip in grey, where a move to a point is shown (N,).
    """
    poses = {name: poses_[0] for name, poses_ in world_T_frames(cell, q[None]).items()}
    towards_eye = _towards_eye(poses)
    bodies = _body_facets(cell, poses, None, np.eye(4))
    moving = [f.corners.reshape(-1, 3) for name, f in bodies if name != "world"]
    tip = poses["tool"][:3, 3]
    whole = _framed(np.concatenate([*moving, tip[None]]), towards_eye, _PLACE, 1.06)
    grey = np.tile(to_rgb("#5c6773"), (len(base_p), 1))
    pictures = []
    for center, width_m in (whole, (tip, _NEAR)):
        ball = sphere(_BALL * width_m, _SIDES).triangles
        marked = _facets(ball, pose(np.eye(3), tip), _MARK, len(cell.shapes) + 1)
        ribbon = _path_facets(base_p, shown, poses["base"], towards_eye, width_m / _PLACE[0], grey)
        every = Facets.joined([*(f for _, f in bodies), ribbon, marked])
        pictures.append(
            render(every, towards_eye=towards_eye, center=center, width_m=width_m, pixels=_PLACE, fade=_FADE)
        )
    file = BytesIO()
    imsave(file, np.ascontiguousarray(np.clip(np.hstack(pictures), 0.0, 1.0)), format="png")
    return file.getvalue()


def _towards_eye(poses: Mapping[str, Array]) -> Array:
    """The way (3,) to the eye in `world`: to the side of the line from the robot to the tool, and from above."""
    away = poses["tool"][:2, 3] - poses["root"][:2, 3]
    heading = np.arctan2(away[1], away[0]) + _TURN
    return np.array([np.cos(heading), np.sin(heading), _ABOVE])


def _framed(p: Array, towards_eye: Array, pixels: tuple[int, int], room: float) -> tuple[Array, float]:
    """Centre, m in `world`, and width, m, of a picture that holds points p (K, 3) with some room round them."""
    view_R = screen_R_world(towards_eye)
    seen = p @ view_R.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width_m = room * max(high[0] - low[0], (high[1] - low[1]) * pixels[0] / pixels[1], _SMALLEST)
    return 0.5 * (low + high) @ view_R, float(width_m)


def _facets(triangles: Array, world_T_mesh: Array, color: str, body: int, *, fades: bool = False) -> Facets:
    corners = triangles @ world_T_mesh[:3, :3].T + world_T_mesh[:3, 3]
    n = len(corners)
    return Facets(corners, np.tile(to_rgb(color), (n, 1)), np.full(n, body), np.ones(n, dtype=bool), np.full(n, fades))


def _body_facets(
    cell: Cell, poses: Mapping[str, Array], part_mesh: Array | None, base_T_part: Array
) -> list[tuple[str, Facets]]:
    """Every body's triangles in `world` by its frame; boxes fixed in the world are cut off some way round what moves."""
    out: list[tuple[str, Facets]] = []
    for k, shape in enumerate(cell.shapes):
        mesh = shape_mesh(shape, cell.folder, sides=_SIDES)
        out.append(
            (
                shape.frame,
                _facets(
                    mesh.triangles,
                    poses[shape.frame],
                    ROLE_COLORS[role_of(cell, shape.frame)],
                    k,
                    fades=shape.frame == "world",
                ),
            )
        )
    if part_mesh is not None and len(part_mesh):
        world_T_part = poses["base"] @ base_T_part
        color = ROLE_COLORS["part"]
        out.append(("base", _facets(part_mesh, world_T_part, color, len(cell.shapes))))  # frames: mesh is part
    moving = [f.corners.reshape(-1, 3) for name, f in out if name != "world"]
    if not moving:
        return out
    every = np.concatenate(moving)
    low, high = every.min(axis=0) - _FLOOR, every.max(axis=0) + _FLOOR
    boxes = [shape.kind is ShapeKind.BOX and shape.frame == "world" for shape in cell.shapes]
    for k, fixed in enumerate(boxes):
        if fixed:
            name, f = out[k]
            out[k] = (name, replace(f, corners=np.clip(f.corners, low, high)))
    return out


def _path_facets(
    base_p: Array, shown: NDArray[np.bool_], world_T_base: Array, towards_eye: Array, pixel_m: float, rgba: Array
) -> Facets:
    """The moves that are shown, to points base_p (N, 3), as a ribbon that faces the eye, a hair above the surface."""
    picked = path_indices(base_p, np.zeros(len(base_p), dtype=bool), 60_000)
    world_p = base_p[picked] @ world_T_base[:3, :3].T + world_T_base[:3, 3]
    back = towards_eye / np.linalg.norm(towards_eye)
    a, b = world_p[:-1], world_p[1:]
    across = np.cross(b - a, back)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    across = across / np.maximum(length, 1e-12) * (0.5 * _PATH_WIDTH_PX * pixel_m)
    lift = 1.5 * pixel_m * back
    quads = np.stack([a + across, a - across, b - across, b + across], axis=1) + lift
    keep = shown[picked[1:]] & (length[:, 0] > 1e-12)
    corners = np.concatenate([quads[keep][:, [0, 1, 2]], quads[keep][:, [0, 2, 3]]])
    color = np.tile(rgba[picked[1:]][keep][:, :3], (2, 1))
    n = len(corners)
    return Facets(corners, color, np.full(n, -2), np.zeros(n, dtype=bool), np.zeros(n, dtype=bool))
