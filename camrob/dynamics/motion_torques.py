"""Torques along a whole path at once: Newton and Euler over point masses, every posture in one go.

The same as `joint_torques` by Pinocchio, which the tests hold it to, without its import and its loop over postures.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.cell.world import world_T_floor
from camrob.dynamics.gravity import GRAVITY
from camrob.dynamics.torques import JointTorques

__all__ = ["motion_torques"]

Array = NDArray[np.float64]

_CHUNK = 20_000  # samples at once, so that memory stays small


def motion_torques(cell: Cell, q: Array, speed: Array, acceleration: Array) -> JointTorques:
    """Torques of motions with postures q, speeds and accelerations (N, n), SI; some microseconds a posture.

    Joints of the workpiece and the virtual roll get 0. Raises ValueError for arrays that don't fit each other and the
    cell.
    """
    q, speed, acceleration = (np.asarray(a, float) for a in (q, speed, acceleration))
    if q.ndim != 2 or q.shape[1] != len(cell) or q.shape != speed.shape or q.shape != acceleration.shape:
        raise ValueError(f"q, speed and acceleration must be (N, {len(cell)})")
    total, still = np.zeros(q.shape), np.zeros(q.shape)
    for start in range(0, len(q), _CHUNK):
        part = slice(start, start + _CHUNK)
        total[part] = _newton_euler(cell, q[part].T, speed[part].T, acceleration[part].T).T
        rest = np.zeros_like(q[part].T)
        still[part] = _newton_euler(cell, q[part].T, rest, rest).T
    return JointTorques(total, still)


class _Frames:
    """N moving frames in `world`: rotations R (3, 3, N), places p, spin, its rate `twist`, acceleration `push` (3, N)."""

    def __init__(self, start: Array, count: int) -> None:
        self.R = np.repeat(start[:3, :3, None], count, axis=2)
        self.p = np.repeat(start[:3, 3, None], count, axis=1)
        self.spin, self.twist, self.push = (np.zeros((3, count)) for _ in range(3))
        self.push[2] = GRAVITY  # resting on the ground is falling upwards

    def point(self, offset: Array) -> tuple[Array, Array]:
        """Place and acceleration (3, N) of a point `offset` (3,) off the origin."""
        arm = np.einsum("ijn,j->in", self.R, offset)
        return self.p + arm, self.push + _cross(self.twist, arm) + _cross(self.spin, _cross(self.spin, arm))

    def carry(self, fixed: Array) -> None:
        """Go on by a constant transform (4, 4)."""
        self.p, self.push = self.point(fixed[:3, 3])
        self.R = np.einsum("ijn,jk->ikn", self.R, fixed[:3, :3])

    def move(self, joint: Joint, q: Array, rate: Array, rise: Array) -> None:
        """Go on by a joint's motion about or along z: value q, its rate and rise (N,)."""
        axis = self.R[:, 2]
        if joint.prismatic:
            way = axis * q
            self.push = self.push + _cross(self.twist, way) + _cross(self.spin, _cross(self.spin, way))
            self.push, self.p = self.push + axis * rise + 2.0 * _cross(self.spin, axis * rate), self.p + way
            return
        self.twist = self.twist + axis * rise + _cross(self.spin, axis * rate)
        self.spin = self.spin + axis * rate
        co, si = np.cos(q), np.sin(q)
        x, y = self.R[:, 0] * co + self.R[:, 1] * si, self.R[:, 1] * co - self.R[:, 0] * si
        self.R = np.stack([x, y, axis], axis=1)


def _newton_euler(cell: Cell, q: Array, speed: Array, acceleration: Array) -> Array:
    """Torques (n, N): outwards the motion of every mass, inwards the forces that it takes, about `world`'s origin."""
    frames = _Frames(world_T_floor(cell), q.shape[1])
    joints, forces = [], []
    for i, joint in enumerate(cell.joints[: cell.arm_slice.stop]):
        if joint.role in (Role.WORKPIECE, Role.ROLL):
            continue
        frames.carry(np.asarray(joint.before))
        frames.move(joint, q[i], speed[i], acceleration[i])
        joints.append((i, joint.prismatic, frames.R[:, 2], frames.p))
        after = np.asarray(joint.after)
        force, moment = np.zeros_like(frames.p), np.zeros_like(frames.p)
        for mass in cell.masses:
            if mass.after == joint.name:
                centre, pull = frames.point(after[:3, :3] @ mass.center + after[:3, 3])
                force += mass.mass * pull
                moment += _cross(centre, mass.mass * pull)
        forces.append((force, moment))
        frames.carry(after)
    out = np.zeros((len(cell), q.shape[1]))
    force, moment = np.zeros_like(frames.p), np.zeros_like(frames.p)
    for (i, prismatic, axis, at), (own_force, own_moment) in zip(joints[::-1], forces[::-1], strict=True):
        force, moment = force + own_force, moment + own_moment
        out[i] = np.sum(axis * (force if prismatic else moment - _cross(at, force)), axis=0)
    return out


def _cross(a: Array, b: Array) -> Array:
    """Cross products of columns (3, N)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
