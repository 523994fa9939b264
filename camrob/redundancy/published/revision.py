"""Periodic posture revision (section 3.2 of the paper).

In the void motion between regions the table first, then the track, are moved to raise 1/k_F while the cutter's pose is held.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.kinematics.arm import Arm
from camrob.kinematics.kernels import ChainArrays, forward_many, inverse_kf_many

__all__ = ["GAIN", "revise_posture"]

Array = NDArray[np.float64]

REVOLUTE_STEP = 0.0175  # rad (1 degree) between the postures that are checked
PRISMATIC_STEP = 0.01  # m
REVOLUTE_SPAN = np.pi
PRISMATIC_SPAN = 3.0  # m: longer tracks are not searched from end to end for one posture
GAIN = 0.005  # of 1/k_F below which a move isn't worth it
MARGIN = 0.0873  # rad (5 degrees) that the arm's joints keep from their limits
PRISMATIC_MARGIN = 0.02  # m
_JUMP = 0.35  # rad that a joint may move between two checked postures


def revise_posture(cell: Cell, chain: ChainArrays, arm: Arm, q: Array) -> Array:
    """Postures (K, n) to move through from q (n,), q first: one more for every external axis that was worth moving.

    Workpiece axes come first, then carriages. Along each the posture is followed on the arm's branch, a degree or 10 mm at a
    time, within limits, as far as it goes, and the best 1/k_F is taken, so that every posture between has been checked.
    """
    path = [q.copy()]
    for role in (Role.WORKPIECE, Role.CARRIAGE):
        for index in cell.indices(role):
            better = _along(cell, chain, arm, path[-1], index)
            if better is not None:
                path.append(better)
    return np.array(path)


def _along(cell: Cell, chain: ChainArrays, arm: Arm, q: Array, index: int) -> Array | None:
    """The best posture (n,) reached by moving one external axis, None where none is better."""
    prismatic = cell.joints[index].prismatic
    step, span = (PRISMATIC_STEP, PRISMATIC_SPAN) if prismatic else (REVOLUTE_STEP, REVOLUTE_SPAN)
    margin = PRISMATIC_MARGIN if prismatic else MARGIN
    part = cell.arm_slice
    base_T_tool = forward_many(chain, q[None])[0]
    best_value, best = float(inverse_kf_many(chain, q[None])[0]) + GAIN, None
    for direction in (1.0, -1.0):
        values = q[index] + direction * step * np.arange(1, int(span / step) + 1)
        values = values[(values >= cell.q_lower[index] + margin) & (values <= cell.q_upper[index] - margin)]
        if len(values) == 0:
            continue
        postures = np.tile(q, (len(values), 1))
        postures[:, index] = values
        followed, _code, count = arm.follow(arm.foot_T_tool(base_T_tool, postures), q[part], step=_JUMP)
        postures = postures[:count]
        postures[:, part] = followed[:count]
        good = np.all((postures[:, part] >= arm.lower + MARGIN) & (postures[:, part] <= arm.upper - MARGIN), axis=1)
        if not np.any(good):
            continue
        conditioning = np.where(good, inverse_kf_many(chain, postures), 0.0)
        k = int(np.argmax(conditioning))
        if conditioning[k] > best_value:
            best_value, best = float(conditioning[k]), postures[k].copy()
    return best
