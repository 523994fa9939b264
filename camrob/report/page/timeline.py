"""What the player runs by: the chain as numbers, and the postures at times, thinned where nothing is lost to the eye."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.checks.nearest import Nearest
from camrob.cutting.cutter import Cutter
from camrob.cutting.way import Way
from camrob.kinematics import frames as kinematics
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import plot_text
from camrob.report.page.pack import packed_floats, packed_integers, packed_lines
from camrob.report.page.path_charts import axis_limits
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["Run", "chain_data", "timeline_data"]

Array = NDArray[np.float64]

_AXIS = 5e-6  # rad, or mm: what axis values are rounded to
_TIME = 1e-4  # s
_WAY = 0.01  # mm
SAMPLES = 40_000  # what a page stays small with
# m that a point left out may lie off the lines between its neighbours; more where the run is still too long
_CLOSE = 2e-5
_STICK = Cutter(1e-3, 0.0, 0.1)  # how far up the tool its direction counts as much as its tip
_REVISION_SAMPLES = 12  # of each posture revision, the pose held


@dataclass(frozen=True, slots=True)
class Run:
    """When the program is where.

    at: (N,) s at each point of the path; lines: what the program says of each point, where known. unlined: what a point without
    a CL line is, in air and while cutting. nearest: the nearest bodies at some points, `nearest_at` (K,); None where unknown.
    """

    at: Array
    lines: Sequence[str] | None = None
    unlined: tuple[str, str] = ("camrob's own move through air", "camrob's own move into the cut")
    nearest: Nearest | None = None
    nearest_at: NDArray[np.int64] | None = None


def _rows(T: Array) -> list[float]:
    """The first three rows of a pose, lengths in mm, row by row."""
    out = np.array(T[:3, :4], float)
    out[:, 3] = m_to_mm(out[:, 3])
    return [float(v) for v in out.ravel()]


def chain_data(cell: Cell) -> dict[str, Any]:
    """The chain from `base` to the tool as player.js walks it: twelve numbers a pose, mm, and what each joint does.

    It is walked as `kinematics.frames` does: first, then each joint's before, motion, after; flange and tool hang behind the last
    joint of the arm.
    """
    arm, workpiece = cell.indices(Role.ARM), cell.indices(Role.WORKPIECE)
    floor = np.eye(4)
    if workpiece:  # where `base` would be with all workpiece axes at 0, seen from `world`
        zero = np.array(cell.q_home)
        for i in workpiece:
            zero[i] = float(cell.joints[i].q_value(np.zeros(())))
        floor = kinematics.base_T_joint_frames(cell, zero)[workpiece[-1]]
    return {
        "first": _rows(np.asarray(cell.base_T_first)),
        "joints": [
            {
                "name": j.name,
                "prismatic": bool(j.prismatic),
                "before": _rows(np.asarray(j.before)),
                "after": _rows(np.asarray(j.after)),
            }
            for j in cell.joints
        ],
        "workpiece": workpiece[-1] if workpiece else -1,
        "arm": [arm[0], arm[-1]],
        "roll": bool(cell.indices(Role.ROLL)),
        "floor": _rows(floor),
        "root": _rows(np.asarray(cell.foot_T_root)),
        "flange": _rows(np.asarray(cell.wrist_T_flange)),
        "tool": _rows(np.asarray(cell.flange_T_tool)),
    }


def _thinned(base_T_tip: Array, keep: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The points, rising, that the run is drawn by: those of `keep` (N,), and as many as lie `_CLOSE` to all others."""
    n = len(keep)
    if n <= SAMPLES:
        return np.arange(n)
    tip, axis = base_T_tip[:, :3, 3].copy(), base_T_tip[:, :3, 2].copy()
    label, close = np.cumsum(keep.astype(np.int64)), _CLOSE
    while True:
        kept = Way.of(tip, axis, _STICK, tolerance=close, label=label).kept
        if len(kept) <= SAMPLES or close > 1.0:
            return np.union1d(kept, [0, n - 1]).astype(np.int64)
        close *= 2.0


def _samples(
    path: ToolPathInBase, solution: Solution, names: Mapping[int, str], run: Run
) -> tuple[NDArray[np.int64], Array, Array, list[str]]:
    """Points, postures (K, n), times (K,) and remarks of the run: the thinned path, and through each posture revision."""
    n = len(path)
    revised = [r for r in solution.revisions if r.kept]
    keep = np.zeros(n, np.bool_)
    cuts = np.flatnonzero(np.diff(path.cutting.astype(np.int8)))
    keep[cuts] = keep[cuts + 1] = True
    keep[int(np.argmin(solution.inv_kf))] = True
    for r in revised:
        keep[[max(r.point - 1, 0), r.point]] = True
    picked = _thinned(np.asarray(path.base_T_tip), keep)
    rows = [(int(i), float(run.at[i]), np.asarray(solution.q[i]), "") for i in picked]
    added = []
    for r in revised[: SAMPLES // (4 * _REVISION_SAMPLES)]:
        begin, end = float(run.at[max(r.point - 1, 0)]), float(run.at[r.point])
        postures = np.asarray(r.q)
        steps = np.unique(np.linspace(0, len(postures) - 1, _REVISION_SAMPLES).astype(int))
        remark = f"posture revision before {names.get(r.region, f'region {r.region}')}"
        # the way to the point first, then table and track with the tool held still
        times = 0.5 * (begin + end) + 0.5 * (end - begin) * np.linspace(0.0, 1.0, len(steps) + 1)[:-1]
        added += [(r.point, float(t), postures[k], remark) for k, t in zip(steps, times, strict=True)]
    rows = sorted(rows + added, key=lambda row: row[1])
    points = np.array([row[0] for row in rows], np.int64)
    q = np.stack([row[2] for row in rows])
    return points, q, np.array([row[1] for row in rows]), [row[3] for row in rows]


def timeline_data(
    cell: Cell, path: ToolPathInBase, solution: Solution, names: Mapping[int, str], run: Run
) -> dict[str, Any]:
    """The run for player.js. q: rad and mm in the chain's order; t: s; s: mm; the rest at each sample; `said`: the program's
    lines, where known, one text a sample; off: mm that the farthest point left out lies off the lines drawn.
    """
    points, q, at, remarks = _samples(path, solution, names, run)
    prismatic = [k for k, j in enumerate(cell.joints) if j.prismatic]
    sent = q.copy()
    sent[:, prismatic] = m_to_mm(sent[:, prismatic])
    limits = axis_limits(cell)
    axes = []
    for name in cell.axis_names:
        k = cell.index(name)
        joint = cell.joints[k]
        # of q as it is sent: mm stay mm, radians become degrees
        factor = joint.sign * (1.0 if joint.prismatic else float(rad_to_deg(1.0)))
        unit = "mm" if joint.prismatic else "°"
        axes.append(
            {
                "name": name,
                "unit": unit,
                "limits": list(limits[name]),
                "joint": k,
                "factor": factor,
                "offset": joint.to_edge(joint.offset),
            }
        )
    return {
        "count": len(points),
        "points": len(path),
        "off": _off(path, points),
        "q": packed_floats(sent, _AXIS),
        "t": packed_floats(at, _TIME),
        "s": packed_floats(m_to_mm(path.length[points]), _WAY),
        "kf": packed_floats(solution.inv_kf[points]),
        "line": packed_integers(path.line[points]),
        "region": packed_integers(path.region[points]),
        "cut": packed_integers(path.cutting[points]),
        "remarks": {str(k): plot_text(remark) for k, remark in enumerate(remarks) if remark},
        "unlined": [plot_text(text) for text in run.unlined],
        "near": _near(run),
        "said": None if run.lines is None else packed_lines([plot_text(run.lines[i]) for i in points]),
        "axes": axes,
    }


def _near(run: Run) -> dict[str, Any] | None:
    """The nearest bodies for player.js: s, the names of two, mm."""
    if run.nearest is None or run.nearest_at is None:
        return None
    return {
        "t": packed_floats(run.at[run.nearest_at]),
        "pairs": [[plot_text(a), plot_text(b)] for a, b in run.nearest.pairs],
        "pair": packed_integers(run.nearest.pair),
        "mm": packed_floats(m_to_mm(run.nearest.distance)),
    }


def _off(path: ToolPathInBase, points: NDArray[np.int64]) -> float:
    """mm that the farthest point of the path lies off the straight lines between the points (K,) that are kept."""
    kept = np.unique(points)
    p = np.asarray(path.base_T_tip[:, :3, 3])
    if len(kept) == len(p) or len(kept) < 2:
        return 0.0
    after = np.clip(np.searchsorted(kept, np.arange(len(p)), side="left"), 1, len(kept) - 1)
    a, b = p[kept[after - 1]], p[kept[after]]
    length2 = np.maximum(np.sum((b - a) ** 2, axis=1), 1e-24)
    share = np.clip(np.sum((p - a) * (b - a), axis=1) / length2, 0.0, 1.0)[:, None]
    return float(m_to_mm(np.linalg.norm(p - a - share * (b - a), axis=1).max()))
