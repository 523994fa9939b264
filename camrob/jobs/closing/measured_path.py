"""How far the tool of a measured run was off the path that was meant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from camrob.cell.cell import Cell
from camrob.controller.programmed_path import ProgrammedPath, programmed_path
from camrob.controller.replay import replay
from camrob.errors import LogError
from camrob.gap.observation.program_track import motions_of_lines, nearest_on_path
from camrob.gap.observation.scene import make_scene
from camrob.gap.tool_stretches import ToolStretch, tool_stretches
from camrob.jobs.closing.off_way import OffWay
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame
from camrob.program.program_text import ProgramText
from camrob.se3 import inverse
from camrob.units import mm_to_m

__all__ = ["OffPath", "intended_path", "measured_off_path"]

Array = NDArray[np.float64]

_FAR = 0.05  # m: a row farther away belongs to no motion of this program
_PARTS, _WHOLE = 40, 0.9  # of the way that is cut, and of those parts in which a run has to have been seen
_NEAR = mm_to_m(10.0)  # of a place on the path that was seen, where rows don't tell their motion


class OffPath(NamedTuple):
    """In the order of the log: places along the intended path (K,), m from its beginning, and how far off the tool was there,
    which counts by the way that the set-points ask for since the row before: an instrument's noise adds no way where the tool
    stands.
    """

    along: Array
    distance: OffWay


def intended_path(program: ProgramText, cell: Cell) -> ProgrammedPath:
    """The path that a program asks for, with the roundings that it allows."""
    return programmed_path(program, replay(program, cell))


def measured_off_path(
    log: MeasurementLog,
    program: ProgramText,
    cell: Cell,
    intended: ProgrammedPath,
    meant: NDArray[np.int64],
    cuts: NDArray[np.bool_],
) -> OffPath:
    """From the measured tool to the intended path, at the rows of motions that cut.

    program: what ran. meant: (M,) the motion that `intended` has for each of its motions; cuts: (M,) those that cut. Frames that
    nobody gave (the instrument's, the reflector's) are those that bring the nominal poses nearest: their part of an error can't
    be seen. Raises LogError for a log without measured positions, of another program, or of a piece of the run.
    """
    if not log.has_position:
        raise LogError("has no measured position", hint="log the tool with an instrument: x, y, z", path=log.path)
    parts = [_stretch(part, program, intended, meant) for part in tool_stretches([log], [program], cell)]
    tip, motion, way = (np.concatenate(column) for column in zip(*parts, strict=True))
    place, segment, _ = nearest_on_path(tip, intended, motion)
    owner = np.asarray(intended.motion)[np.minimum(segment + 1, len(intended.motion) - 1)]
    cut = cuts[np.searchsorted(meant, owner, side="right") - 1]
    nodes = np.asarray(intended.points)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    along = length[segment] + np.linalg.norm(place - nodes[segment], axis=1)
    off = np.linalg.norm(tip - place, axis=1)[cut]
    if not len(off) or np.median(off) > _FAR:
        raise LogError("is not a run of this program", hint=f"give the log of {program.name}", path=log.path)
    seen = _seen(tip[cut], along[cut], cuts, intended, meant, by_line=log.has("line"))
    if seen < _WHOLE:
        what = f"shows the tool on {100.0 * seen:.0f} % of the way along which {program.name} cuts"
        raise LogError(what, hint="log the whole run: the rest may be off by anything", path=log.path)
    way = way * (cut & np.append(False, cut[:-1]))
    return OffPath(along[cut], OffWay(np.asarray(off), way[cut], owner[cut]))


def _stretch(
    part: ToolStretch, program: ProgramText, intended: ProgrammedPath, meant: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64], Array]:
    """Of the rows (K,) of a log between two changes of tools where the tool was (K, 3), m, in the frame of the intended path; the
    motion (K,) that `intended` has for that of the row, -1 where the log tells none; and the way (K,), m, that the set-points ask
    for since the row before.
    """
    scene = make_scene(part.log, part.cell)
    poses = np.array(scene.measured)
    unseen = ~scene.seen[:, 3:].all(axis=1)
    poses[unseen, :3, :3] = np.asarray(scene.nominal)[unseen, :3, :3]
    tip = (inverse(scene.frames.left) @ poses @ inverse(scene.frames.right))[:, :3, 3]
    in_base = part.log.info.measured_frame is MeasuredFrame.BASE
    if in_base != (not intended.in_world):
        frames = world_T_base(part.cell, scene.postures(scene.link))
        frames = frames if in_base else inverse(frames)
        tip = np.einsum("nij,nj->ni", frames[:, :3, :3], tip) + frames[:, :3, 3]
    motion = np.full(len(tip), -1, np.int64)
    if scene.log.has("line"):
        motion = meant[motions_of_lines(program, scene.log.line)]
    asked = base_T_tool(part.cell, scene.postures(scene.command))[:, :3, 3]
    return tip, motion, np.append(0.0, np.linalg.norm(np.diff(asked, axis=0), axis=1))


def _seen(
    tip: Array,
    along: Array,
    cuts: NDArray[np.bool_],
    intended: ProgrammedPath,
    meant: NDArray[np.int64],
    *,
    by_line: bool,
) -> float:
    """The share of the way that is cut on which rows (K, 3), at places (K,) along the path, lie.

    cuts, meant: (M,) as in `measured_off_path`. by_line: whether the places are sure; what is passed twice is told apart by them
    alone.
    """
    nodes, owner = np.asarray(intended.points), np.asarray(intended.motion)[1:]
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    cut = cuts[np.searchsorted(meant, owner, side="right") - 1]
    done = np.concatenate([[0.0], np.cumsum(np.where(cut, length, 0.0))])
    way = np.concatenate([[0.0], np.cumsum(length)])
    if by_line:
        parts = max(min(_PARTS, len(along) // 2), 1)
        part = np.interp(along, way, done) / max(done[-1], 1e-12) * parts
        return len(np.unique(np.clip(part, 0, parts - 1).astype(np.int64))) / parts
    at = np.searchsorted(done, (np.arange(_PARTS) + 0.5) / _PARTS * done[-1], side="left") - 1
    share = ((np.arange(_PARTS) + 0.5) / _PARTS * done[-1] - done[at]) / length[at]
    places = nodes[at] + share[:, None] * (nodes[at + 1] - nodes[at])
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    near = max(_NEAR, 2.0 * float(np.quantile(step, 0.99))) if len(step) else _NEAR
    return float(np.mean(cKDTree(tip).query(places)[0] <= near))
