"""Postures along a straight line of the tool: the use case of section III of Samak and others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import UnreachableError
from camrob.kinematics.arm import FOLLOWED, Arm
from camrob.kinematics.frames import base_T_tool

__all__ = ["straight_line"]

Array = NDArray[np.float64]

_LARGEST_STEP = 0.5  # rad between neighbours


def straight_line(cell: Cell, q_start: Array, direction: Array, *, step: float, count: int) -> Array:
    """Postures (count, n) whose tool lies on a line from that of q_start (n,), `step` m apart, its orientation held.

    direction: (3,) in `base`. Only the arm moves; it stays on the branch of q_start. Raises UnreachableError where the
    line leaves the arm's reach, passes a limit or a singular posture.
    """
    poses = np.repeat(base_T_tool(cell, q_start)[None], count, axis=0)
    along = np.asarray(direction, float) / np.linalg.norm(direction)
    poses[:, :3, 3] += step * np.arange(count)[:, None] * along
    arm = Arm.of(cell)
    q = np.repeat(np.asarray(q_start, float)[None], count, axis=0)
    found, code, reached = arm.follow(arm.foot_T_tool(poses, q), q_start[cell.arm_slice], step=_LARGEST_STEP)
    if code != FOLLOWED:
        raise UnreachableError(f"the line can't be followed beyond its point {reached} of {count}")
    q[:, cell.arm_slice] = found
    return q
