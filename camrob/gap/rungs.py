"""The gap by rung: program to set-point, set-point to encoder, encoder to measured TCP; the vectors add up to the whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibrate.error_model import ErrorModel
from camrob.controller.replay import base_poses, program_cell
from camrob.gap.scene import Scene
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measure.log_info import MeasuredFrame
from camrob.post.krl_program import KrlMotion, KrlProgram

__all__ = ["RUNGS", "Ladder", "ladder"]

Array = NDArray[np.float64]

RUNGS = ("program_to_setpoint", "setpoint_to_encoder", "encoder_to_tcp")
_AROUND = 6  # motions to each side of the reported one that a sample may lie on


@dataclass(frozen=True)
class Ladder:
    """Vectors (N, 3) at the TCP, m, in the measured frame; None where the log lacks a rung.

    Where set-points are absent, the first two rungs are one, told as program to set-point's None and the second's None; the
    whole is the sum of what is there. whole: measured less the program's place (less the nominal pose, without a program).
    """

    program_to_setpoint: Array | None
    setpoint_to_encoder: Array | None
    encoder_to_tcp: Array
    whole: Array
    missing: tuple[str, ...]

    def rms(self) -> dict[str, float | None]:
        """m of every rung, None where it is missing."""
        parts = {name: getattr(self, name) for name in RUNGS}
        return {n: None if v is None else float(np.sqrt(np.mean(np.sum(v**2, axis=1)))) for n, v in parts.items()}


def ladder(scene: Scene, program: KrlProgram | None) -> Ladder:
    """The rungs of one log."""
    missing: list[str] = []
    measured = scene.measured[:, :3, 3]
    at_link = scene.nominal[:, :3, 3]
    second: Array | None = None
    commanded = at_link
    if scene.encoder is not None and scene.setpoint is not None:
        commanded = _nominal(scene)
        second = at_link - commanded
    elif scene.setpoint is None:
        missing.append("no set-points: what the drives do can't be told from what the arm does before the encoders")
    else:
        missing.append(
            "no encoders: drives and arm can't be told apart, so lag looks like latency and friction like play"
        )
    third = measured - at_link
    first: Array | None = None
    if program is None:
        missing.append("no program: corner rounding and errors of the post can't be seen")
    elif scene.setpoint is not None and not scene.poses:
        first = commanded - _places(scene, program, commanded)
    whole = third + (0.0 if second is None else second) + (0.0 if first is None else first)
    return Ladder(first, second, third, whole, tuple(missing))


def _nominal(scene: Scene) -> Array:
    """(N, 3) nominal TCP at the set-points, in the measured frame."""
    cell = scene.cell
    in_base = scene.log.info.measured_frame is MeasuredFrame.BASE
    model = ErrorModel.of(cell, [], in_base=in_base, left=scene.frames.left, right=scene.frames.right)
    q = cell.to_q(scene.log.setpoints(scene.axes))
    return model.poses(np.zeros(0), q)[:, :3, 3]


def _places(scene: Scene, program: KrlProgram, commanded: Array) -> Array:
    """(N, 3) the nearest places on the program's path, in the measured frame; approximate positioning left out."""
    cell, _ = program_cell(program, scene.cell)
    q = cell.to_q(scene.log.setpoints(scene.axes))
    N = len(program)
    externals = np.zeros((N, len(cell.external_names)))
    for k, name in enumerate(cell.external_names):
        if name in program.external_names:
            externals[:, k] = np.nan_to_num(np.asarray(program.external)[:, program.external_names.index(name)])
    q_targets = cell.to_q(np.concatenate([np.nan_to_num(np.asarray(program.axes)), externals], axis=1))
    targets, _ = base_poses(program, cell, q_targets)
    by_axes = program.kind == KrlMotion.PTP_AXES
    targets = np.where(by_axes[:, None, None], base_T_tool(cell, q_targets), targets)
    points = targets[:, :3, 3]
    actual = base_T_tool(cell, q)[:, :3, 3]
    place = _nearest(actual, points, _motion_of(scene, program, actual, points))
    offset = actual - place
    if scene.log.info.measured_frame is not MeasuredFrame.BASE:
        offset = (world_T_base(cell, q)[:, :3, :3] @ offset[..., None])[..., 0]
    return np.asarray(commanded - offset @ scene.frames.left[:3, :3].T)


def _motion_of(scene: Scene, program: KrlProgram, actual: Array, points: Array) -> NDArray[np.int64]:
    """(N,) the motion that each sample is on: by the log's line, else by the nearest end, in order."""
    if scene.log.has("line"):
        lines = np.asarray(program.line)
        order = np.argsort(lines, kind="stable")
        at = np.searchsorted(lines[order], scene.log.line)
        return np.asarray(order[np.clip(at, 0, len(order) - 1)])
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(points).query(actual)[1], np.int64)


def _nearest(actual: Array, points: Array, motion: NDArray[np.int64]) -> Array:
    """(N, 3) nearest points on the lines between neighbouring targets about each sample's motion."""
    best = np.full(len(actual), np.inf)
    place = actual.copy()
    for shift in range(-_AROUND, _AROUND + 1):
        end = np.clip(motion + shift, 1, len(points) - 1)
        a, b = points[end - 1], points[end]
        along = b - a
        s = np.clip(np.sum((actual - a) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-18), 0.0, 1.0)
        here = a + s[:, None] * along
        off = np.sum((actual - here) ** 2, axis=1)
        nearer = off < best
        best[nearer], place[nearer] = off[nearer], here[nearer]
    return place
