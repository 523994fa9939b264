"""The postures that a program passes, close enough together for a collision check to go straight between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.controller.replay import Replay
from camrob.kinematics.arm import Arm
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.se3 import pose, slerp

__all__ = ["posture_trace"]

Array = NDArray[np.float64]

LENGTH = 0.02  # m between postures
ANGLE = 0.05  # rad, likewise
_JUMP = 0.5  # rad that a joint may move between two of them; the replay has seen to it that none does


def posture_trace(program: ProgramText, replay: Replay) -> tuple[Array, NDArray[np.int64]]:
    """Postures (K, n) along the program and the motion (K,) that each belongs to; every motion's end is among them.

    LIN motions (and CIRC, whose rows lie on the arc) are followed through the arm's inverse where they are long; PTP goes
    straight in the axes, which needs nothing between.
    """
    cell = replay.cell
    q, targets = np.asarray(replay.q), np.asarray(replay.base_T_tool)
    part = cell.arm_slice
    arms = [Arm.of(tooled) for tooled in replay.cells]
    step = np.zeros(len(q))
    step[1:] = np.linalg.norm(np.diff(targets[:, :3, 3], axis=0), axis=1) / LENGTH
    turn = np.abs(np.diff(q, axis=0)).max(axis=1) / ANGLE
    step[1:] = np.maximum(step[1:], turn)
    linear = (program.kind == Motion.LIN) & (np.arange(len(q)) > 0)
    long = np.flatnonzero(linear & (step > 1.5))
    pieces: list[Array] = []
    owners: list[NDArray[np.int64]] = []
    begin = 0
    for row in long.tolist():
        pieces.append(q[begin:row])
        owners.append(np.arange(begin, row))
        arm = arms[int(replay.mounted[row])]
        between = _between((targets[row - 1], targets[row]), q[row - 1], q[row], arm, part, int(np.ceil(step[row])))
        pieces.append(between)
        owners.append(np.full(len(between), row))
        begin = row
    pieces.append(q[begin:])
    owners.append(np.arange(begin, len(q)))
    return np.concatenate(pieces), np.concatenate(owners)


def _between(ends: tuple[Array, Array], q0: Array, q1: Array, arm: Arm, part: slice, count: int) -> Array:
    """Postures (count - 1, n) between the ends of a LIN."""
    s = np.arange(1, count)[:, None] / count
    postures = q0 + s * (q1 - q0)
    start, end = ends
    tips = start[:3, 3] + s * (end[:3, 3] - start[:3, 3])
    frames = pose(slerp(start[None, :3, :3], end[None, :3, :3], s[:, 0]), tips)
    followed, _code, good = arm.follow(arm.foot_T_tool(frames, postures), q0[part], step=_JUMP)
    postures[:good, part] = followed[:good]
    return np.asarray(postures)
