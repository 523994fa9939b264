"""Torques that a motion asks of a cell's joints, by Pinocchio's recursive Newton-Euler algorithm.

The robot stands on the floor and moves the tool; axes that turn the workpiece carry the part and not the robot, so they are
left out, and so is the virtual roll. A torque is what the joint has to bring up: positive drives the chain's q upward.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.cell.world import world_T_floor

__all__ = ["STANDARD_GRAVITY", "JointTorques", "joint_torques"]

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665  # m/s2, along -z of `world`


class JointTorques(NamedTuple):
    """Torques (N, n), Nm (forces, N, of prismatic joints), in the chain's order; 0 for workpiece axes and roll.

    total = M(q) q'' + C(q, q') q' + g(q) (eq. 17 of Duong and others); gravity is g(q) alone.
    """

    total: Array
    gravity: Array


def joint_torques(
    cell: Cell,
    q: Array,
    speed: Array,
    acceleration: Array,
    *,
    masses: tuple[PointMass, ...] | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> JointTorques:
    """Torques of motions with postures q, speeds and accelerations (N, n); about ten microseconds a posture.

    masses: the cell's by default. Raises ValueError for arrays that don't fit each other and the cell.
    """
    q, speed, acceleration = (np.asarray(a, float) for a in (q, speed, acceleration))
    if q.ndim != 2 or q.shape[1] != len(cell) or q.shape != speed.shape or q.shape != acceleration.shape:
        raise ValueError(f"q, speed and acceleration must be (N, {len(cell)})")
    import pinocchio as pin

    loads = cell.masses if masses is None else masses
    model, order = _model(pin, cell, loads)
    model.gravity.linear = np.array([0.0, 0.0, -gravity])
    data = model.createData()
    total, still = np.zeros(q.shape), np.zeros(q.shape)
    columns = np.array(order)
    picked = [np.ascontiguousarray(a[:, columns]) for a in (q, speed, acceleration)]
    for k, (x, v, a) in enumerate(zip(*picked, strict=True)):
        total[k, columns] = pin.rnea(model, data, x, v, a)
        still[k, columns] = pin.computeGeneralizedGravity(model, data, x)
    return JointTorques(total, still)


def _model(pin: Any, cell: Cell, masses: tuple[PointMass, ...]) -> tuple[Any, list[int]]:
    """Pinocchio's model of the carriage and arm in `world`, and which of the chain's joints its joints are."""
    model = pin.Model()
    order: list[int] = []
    parent, parent_T_next = 0, world_T_floor(cell)
    arm_end = cell.arm_slice.stop - 1
    for i, joint in enumerate(cell.joints):
        if joint.role in (Role.WORKPIECE, Role.ROLL):
            continue
        placement = pin.SE3(np.asarray(parent_T_next @ joint.before))
        kind = pin.JointModelPZ() if joint.prismatic else pin.JointModelRZ()
        parent = model.addJoint(parent, kind, placement, joint.name)
        order.append(i)
        for mass in masses:
            if mass.after == joint.name:
                center = joint.after[:3, :3] @ mass.center + joint.after[:3, 3]
                inertia = pin.Inertia(mass.mass, center, np.zeros((3, 3)))
                model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
        parent_T_next = joint.after
        if i == arm_end:
            break
    return model, order
