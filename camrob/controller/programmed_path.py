"""The path that a program leads the tool along, by place alone: as it is written, or with its corners rounded off."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.controller.interpolate import ARC, PTP
from camrob.controller.layout import REACH, Layout, lay_out
from camrob.controller.motion_settings import motion_settings
from camrob.controller.replay import Replay, replay
from camrob.controller.tool_runs import tool_runs
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_tool, seen_by_program
from camrob.program.program_text import ProgramText

__all__ = ["ProgrammedPath", "programmed_path"]

Array = NDArray[np.float64]

_SAGITTA = 1e-6  # m that a chord may keep from its arc
_PTP_STEP = 0.003  # rad of the fastest axis between nodes of a PTP
_BLEND_STEPS = 24


@dataclass(frozen=True, slots=True)
class ProgrammedPath:
    """points: (K, 3) m, joined by straight lines, in `world` where in_world, else in the turning `base`; motion: (K,) row of the
    program that leads to each. corners: how many are rounded.
    """

    points: Array
    motion: NDArray[np.int64]
    corners: int
    in_world: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", locked(self.points, shape=(None, 3), name="points"))
        object.__setattr__(self, "motion", locked(self.motion, dtype=np.int64, name="motion"))


def programmed_path(program: ProgramText, replayed: Replay, *, distance: float | None = None) -> ProgrammedPath:
    """The tool's path. Where the tool is changed it goes straight from the old tip to the new one.

    distance: m of rounding off, throughout instead of the program's own; 0 for no rounding of any kind. Raises UnreachableError
    where the replay could not follow the program, and ProgramError for settings that no controller takes.
    """
    replayed.demand_followed()
    if replayed.others:
        return _joined(program, replayed, distance)
    settings = motion_settings(program, replayed.cell)
    if distance is not None:
        settings = replace(settings, distance=np.full(len(program), distance))
    layout = lay_out(program, replayed, settings)
    reach = np.zeros_like(layout.reach) if distance == 0.0 else np.asarray(layout.reach)
    points, motion = _points(layout, reach, replayed)
    return ProgrammedPath(points, layout.row[motion + 1], int(np.sum(reach > 0.0)), layout.in_world)


def _joined(program: ProgramText, replayed: Replay, distance: float | None) -> ProgrammedPath:
    """The paths of all tools one behind another."""
    points, motion, corners, in_world = [], [], 0, False
    for text, cell, rows in tool_runs(program, replayed):
        path = programmed_path(text, replay(text, cell), distance=distance)
        points.append(path.points)
        motion.append(rows[path.motion])
        corners += path.corners
        in_world = path.in_world
    return ProgrammedPath(np.concatenate(points), np.concatenate(motion), corners, in_world)


def _points(layout: Layout, reach: Array, replayed: Replay) -> tuple[Array, NDArray[np.int64]]:
    """Nodes of all motions and roundings in their order, and the motion that each belongs to."""
    motions = layout.motions
    M = len(motions.kind)
    before = np.concatenate([[0.0], reach[:-1]]) if M else np.zeros(0)
    whole = motions.size - before - reach
    radius = np.linalg.norm(motions.u, axis=1)
    bent = np.abs(motions.angle) / np.sqrt(8.0 * _SAGITTA / np.maximum(radius, 1e-3))
    own = np.where(motions.kind == ARC, np.ceil(bent), 1.0)
    own = np.where(motions.kind == PTP, np.ceil(motions.size / (REACH * _PTP_STEP)), own).astype(np.int64)
    own = np.where(whole > 1e-9 * motions.size, own + 1, 0)
    rounding = np.where(reach > 0.0, _BLEND_STEPS + 1, 0)
    counts = np.stack([own, rounding], axis=1).ravel()
    part = np.repeat(np.arange(2 * M), counts)
    step = np.arange(len(part)) - np.repeat(np.cumsum(counts) - counts, counts)
    m, rounded = part // 2, part % 2 == 1
    share = step / np.maximum(counts[part] - 1, 1)
    s = before[m] + share * whole[m]
    d = reach[m]
    tau = (2.0 * share - 1.0) * d
    with np.errstate(invalid="ignore", divide="ignore"):
        s_before = motions.size[m] - (d - tau) ** 2 / (4.0 * d)
        s_after = (d + tau) ** 2 / (4.0 * d)
    points = _at(layout, m, np.where(rounded, s_before, s))
    if rounded.any():
        following = np.minimum(m + 1, M - 1)
        points[rounded] += (_at(layout, following, s_after) - motions.p[m + 1])[rounded]
    direct = motions.kind[m] == PTP
    if direct.any():
        points[direct] = _ptp(
            layout, replayed, m, np.where(rounded, s_before, s), np.where(rounded, s_after, 0.0), direct
        )
    if not len(points):
        return np.asarray(motions.p[:1]).copy(), np.zeros(0, np.int64)
    return points, m


def _at(layout: Layout, m: NDArray[np.int64], s: Array) -> Array:
    """Places (K, 3) at s of motions m, lines and arcs."""
    motions = layout.motions
    share = (s / motions.size[m])[:, None]
    angle = share * motions.angle[m][:, None]
    line = motions.p[m] + share * (motions.p[m + 1] - motions.p[m])
    arc = motions.center[m] + np.cos(angle) * motions.u[m] + np.sin(angle) * motions.v[m]
    return np.asarray(np.where((motions.kind[m] == ARC)[:, None], arc, line))


def _ptp(
    layout: Layout, replayed: Replay, m: NDArray[np.int64], s: Array, after: Array, rows: NDArray[np.bool_]
) -> Array:
    """Places of the tool where the axes go straight; in the frame that the layout's poses are in."""
    motions, cell = layout.motions, replayed.cell
    m, s, after = m[rows], s[rows], after[rows]
    following = np.minimum(m + 1, len(motions.kind) - 1)
    q = motions.q[m] + (s / motions.size[m])[:, None] * (motions.q[m + 1] - motions.q[m])
    step = motions.q[np.minimum(m + 2, len(motions.q) - 1)] - motions.q[m + 1]
    q = q + (after / motions.size[following])[:, None] * step
    poses = seen_by_program(cell, q, base_T_tool(cell, q))
    return np.asarray(poses[:, :3, 3])
