"""Torques that gravity exerts on a cell's joints, for many postures at once: compiled, and by Pinocchio.

A torque is positive where gravity pushes the chain's q upward: tau = -dV/dq. Prismatic joints get forces, N.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.cell.urdf import cell_urdf
from camrob.cell.world import world_T_floor
from camrob.compiled import kernel, part
from camrob.frame_steps import compose, move_joint

__all__ = ["GRAVITY", "GravityArrays", "gravity_arrays", "gravity_stiffness", "gravity_torques", "pinocchio_torques"]

Array = NDArray[np.float64]

GRAVITY = 9.80665  # m/s2, along -z of `world`


class GravityArrays(NamedTuple):
    """What the compiled torques need of a cell.

    before, after (n, 4, 4): constant transforms around each joint's motion. up (3,): `world`'s z seen from the frame
    where the part of the chain that stands on the floor begins. first: the first joint of that part (those of the
    workpiece bear the part, not the robot). prismatic (n,). joint, mass, center: (M,), (M,), (M, 3), the masses,
    centred in the frames behind their joints' motion.
    """

    before: Array
    after: Array
    up: Array
    first: int
    prismatic: NDArray[np.bool_]
    joint: NDArray[np.int64]
    mass: Array
    center: Array


def gravity_arrays(cell: Cell, masses: Sequence[PointMass] | None = None) -> GravityArrays:
    """The cell as arrays, with its own masses or others."""
    loads = cell.masses if masses is None else tuple(masses)
    first = len(cell.indices(Role.WORKPIECE))
    up = world_T_floor(cell)[2, :3]
    before = np.stack([np.asarray(j.before) for j in cell.joints])
    after = np.stack([np.asarray(j.after) for j in cell.joints])
    last = cell.indices(Role.ARM)[-1]
    after[last] = after[last] @ cell.wrist_T_flange @ cell.flange_T_tool
    joints = [cell.index(m.after) for m in loads]
    centers = [
        cell.joints[i].after[:3, :3] @ m.center + cell.joints[i].after[:3, 3]
        for i, m in zip(joints, loads, strict=True)
    ]
    return GravityArrays(
        before,
        after,
        np.array(up),
        first,
        np.array([j.prismatic for j in cell.joints]),
        np.array(joints, np.int64),
        np.array([m.mass for m in loads], float),
        np.array(centers, float).reshape(-1, 3),
    )


def gravity_torques(arrays: GravityArrays, q: Array) -> Array:
    """Torques (N, n), Nm, of postures q (N, n); about a microsecond each."""
    return np.asarray(_torques(arrays, np.array(q, np.float64, order="C")))


def gravity_stiffness(arrays: GravityArrays, q: Array) -> Array:
    """How the torques change with the posture: d tau_i / d q_j (N, n, n), Nm/rad, symmetric."""
    return np.asarray(_stiffness(arrays, np.array(q, np.float64, order="C")))


@part
def _walk(arrays: GravityArrays, q: Array, Z: Array, P: Array, C: Array) -> None:
    """Axes Z and points P (n, 3) of the joints, centres C (M, 3) of the masses, in the frame that `up` is given in."""
    R, p = np.eye(3), np.zeros(3)
    for i in range(arrays.first, q.shape[0]):
        compose(R, p, arrays.before[i])
        for r in range(3):
            Z[i, r] = R[r, 2]
            P[i, r] = p[r]
        move_joint(R, p, arrays.prismatic[i], q[i])
        for k in range(arrays.joint.shape[0]):
            if arrays.joint[k] == i:
                c = arrays.center[k]
                for r in range(3):
                    C[k, r] = p[r] + R[r, 0] * c[0] + R[r, 1] * c[1] + R[r, 2] * c[2]
        compose(R, p, arrays.after[i])


@kernel(nogil=True)
def _torques(arrays: GravityArrays, q: Array) -> Array:
    n, count = q.shape[1], arrays.joint.shape[0]
    Z, P, C = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((count, 3))
    out = np.zeros(q.shape)
    for row in range(q.shape[0]):
        _walk(arrays, q[row], Z, P, C)
        for k in range(count):
            force = -GRAVITY * arrays.mass[k]
            for i in range(arrays.first, arrays.joint[k] + 1):
                along = Z[i] if arrays.prismatic[i] else np.cross(Z[i], C[k] - P[i])
                out[row, i] += force * np.dot(arrays.up, along)
    return out


@kernel(nogil=True)
def _stiffness(arrays: GravityArrays, q: Array) -> Array:
    n, count = q.shape[1], arrays.joint.shape[0]
    Z, P, C = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((count, 3))
    out = np.zeros((q.shape[0], n, n))
    for row in range(q.shape[0]):
        _walk(arrays, q[row], Z, P, C)
        for k in range(count):
            force = -GRAVITY * arrays.mass[k]
            for i in range(arrays.first, arrays.joint[k] + 1):
                along = Z[i] if arrays.prismatic[i] else np.cross(Z[i], C[k] - P[i])
                for j in range(arrays.first, i + 1):
                    if not arrays.prismatic[j]:
                        h = force * np.dot(arrays.up, np.cross(Z[j], along))
                        out[row, i, j] += h
                        if i != j:
                            out[row, j, i] += h
    return out


def pinocchio_torques(cell: Cell, q: Array) -> Array:
    """Torques (N, n) of postures q (N, n) by Pinocchio, from the cell's URDF; a second opinion, 10 microseconds each.

    The workpiece axes' entries are 0, as in `gravity_torques`: on the floor it is the part that they turn.
    """
    import pinocchio as pin

    model = pin.buildModelFromXML(cell_urdf(cell))
    data = model.createData()
    first = len(cell.indices(Role.WORKPIECE))
    arrays = gravity_arrays(cell)
    out = np.zeros(q.shape)
    for row, posture in enumerate(np.asarray(q, float)):
        resting = posture.copy()
        for i, joint in enumerate(cell.joints[:first]):
            resting[i] = float(joint.q_value(np.zeros(())))  # the chain begins in `base`, which then is `world`
        x = pin.neutral(model)
        for joint, value in zip(cell.joints, resting, strict=True):
            at = model.joints[model.getJointId(joint.name)]
            # a joint without limits is stored as its cosine and sine
            x[at.idx_q : at.idx_q + at.nq] = [value] if at.nq == 1 else [np.cos(value), np.sin(value)]
        model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
        effort = -pin.computeGeneralizedGravity(model, data, x)
        for i, joint in enumerate(cell.joints):
            if i >= arrays.first:
                out[row, i] = effort[model.joints[model.getJointId(joint.name)].idx_v]
    return out
