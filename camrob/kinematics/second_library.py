"""Poses of the tool by another library: Pinocchio's forward kinematics, the chain built from the cell's own segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.world import segments

__all__ = ["pinocchio_poses"]

Array = NDArray[np.float64]


def pinocchio_poses(cell: Cell, q: Array) -> Array:
    """base_T_tool (N, 4, 4) of postures q (N, n) by Pinocchio; a second opinion, a few microseconds a posture.

    The library is imported on the first call. Raises ValueError for postures of another width.
    """
    values = np.asarray(q, float)
    if values.ndim != 2 or values.shape[1] != len(cell):
        raise ValueError(f"postures have shape {values.shape}, expected (N, {len(cell)})")
    import pinocchio as pin

    model = pin.Model()
    last, last_T_segment = 0, np.eye(4)
    for segment in segments(cell):
        last_T_segment = last_T_segment @ segment.parent_T_joint
        if segment.joint is not None:
            kind = pin.JointModelPZ() if segment.joint.prismatic else pin.JointModelRZ()
            last = model.addJoint(last, kind, pin.SE3(last_T_segment), segment.joint.name)
            last_T_segment = np.eye(4)
    frame = model.addFrame(pin.Frame("tool", last, pin.SE3(last_T_segment), pin.FrameType.OP_FRAME))
    data = model.createData()
    out = np.empty((len(values), 4, 4))
    for k, posture in enumerate(values):
        pin.forwardKinematics(model, data, posture)
        out[k] = pin.updateFramePlacement(model, data, frame).homogeneous
    return out
