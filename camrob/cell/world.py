"""Where the part of a cell's chain that stands on the floor begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.se3 import rotation_exp

__all__ = ["world_T_floor"]


def world_T_floor(cell: Cell) -> NDArray[np.float64]:
    """The frame (4, 4) that the last workpiece joint ends in, seen from `world`, which is `base` with these axes at
    0.
    """
    world_T_next = np.asarray(cell.base_T_first)  # frames: world is base
    for i in cell.indices(Role.WORKPIECE):
        joint = cell.joints[i]
        q = float(joint.q_value(np.zeros(())))
        M = np.eye(4)
        if joint.prismatic:
            M[2, 3] = q
        else:
            M[:3, :3] = rotation_exp([0.0, 0.0, q])
        world_T_next = world_T_next @ joint.before @ M @ joint.after
    return np.asarray(world_T_next)
