"""What gravity does to the axes and to the foot of an arm, posture by posture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.dynamics.gravity import GRAVITY, gravity_torques
from camrob.kinematics.frames import base_T_joint_frames, base_T_root
from camrob.se3 import inverse

__all__ = ["gravity_moments", "gravity_on_axes"]

Array = NDArray[np.float64]


def gravity_on_axes(model: ErrorModel, cell: Cell, q: Array, axes: tuple[str, ...]) -> Array:
    """(N, k) gravity's torques in the controller's sign."""
    torque = gravity_torques(model.gravity, q)
    return np.stack([cell.joints[cell.index(a)].sign * torque[:, cell.index(a)] for a in axes], axis=1)


def gravity_moments(cell: Cell, q: Array) -> Array:
    """(M, N, 2): force (0, 0, -m g) at every mass's centre, seen from `root`."""
    frames, root_T_base = base_T_joint_frames(cell, q), inverse(base_T_root(cell, q))
    total = np.zeros((len(cell.masses), len(q), 2))
    for k, load in enumerate(cell.masses):
        base_p_mass = frames[cell.index(load.after)] @ np.append(load.center, 1.0)
        root_p_mass = (root_T_base @ base_p_mass[..., None])[..., 0]
        total[k] = load.mass * GRAVITY * np.stack([-root_p_mass[:, 1], root_p_mass[:, 0]], axis=1)
    return total
