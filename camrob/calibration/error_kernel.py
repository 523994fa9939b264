"""Compiled poses of a chain with errors, and their analytic derivatives.

The chain is walked once a posture. On the way every place that an error may stand at leaves its twist (v, w), taken
at the origin of the frame that poses are measured in; at the end the twists are moved to the target. Slots of twists:

    0-5    base: x, y, z, rx, ry, rz, on the left of world_T_root, in the axes of `world`
    6-11   tool: on the right of the tip, in the axes of `tool`
    12-17  root: at the robot's foot, in the axes of `root`; its values are given posture by posture
    18 + 7 i + k   joint i: k = 0..5 its axis, in the axes of the joint's own frame; k = 6 its motion
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.frame_steps import compose, move_joint

__all__ = ["BASE", "JOINT", "JOINT_SLOTS", "MOTION", "ROOT", "TOOL", "Displacements", "ModelArrays", "poses_and_twists"]

Array = NDArray[np.float64]

# where the columns of each begin, and how many a joint and a motion have
BASE, TOOL, ROOT, JOINT, JOINT_SLOTS, MOTION = 0, 6, 12, 18, 7, 6


class ModelArrays(NamedTuple):
    """The constant part of the chain.

    left (4, 4): the measured frame seen to `world` or `base`. start: the first joint walked; workpiece: the first
    joint that stands on the floor; arm: the first of the arm. floor, floor_inverse: world_T_floor with all workpiece axes
    at 0. root, root_inverse: foot_T_root. before, after (n, 4, 4): around each joint's motion; last (4, 4): behind
    the last one, to the tip; right (4, 4): the target seen from the tip. prismatic (n,); zero (n,): q where the axis
    value is 0.
    """

    left: Array
    start: int
    workpiece: int
    arm: int
    floor: Array
    floor_inverse: Array
    root: Array
    root_inverse: Array
    before: Array
    after: Array
    last: Array
    right: Array
    prismatic: NDArray[np.bool_]
    zero: Array


class Displacements(NamedTuple):
    """The errors' values as rigid motions: T = Trans(x, y, z) exp(rx, ry, rz), and the left Jacobians of their
    rotations.

    base, tool (4, 4) with base_J, tool_J (3, 3); joints (n, 4, 4) with joints_J (n, 3, 3); moved (n,) True where a
    joint's is not the identity or is differentiated. root (N, 6), x, y, z, rx, ry, rz posture by posture, or (0, 6)
    for none.
    """

    base: Array
    base_J: Array
    tool: Array
    tool_J: Array
    joints: Array
    joints_J: Array
    moved: NDArray[np.bool_]
    root: Array


@part
def _inverse(T: Array, out: Array) -> None:
    """out <- the inverse of a rigid motion."""
    for r in range(3):
        out[r, 3] = 0.0
        for c in range(3):
            out[r, c] = T[c, r]
            out[r, 3] -= T[c, r] * T[c, 3]


@part
def _turn(w: Array, R: Array, J: Array) -> None:
    """R <- exp(w), J <- the left Jacobian of exp at w (Rodrigues' formula and its integral)."""
    angle = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-5:
        a, b, c = 1.0 - angle * angle / 6.0, 0.5, 1.0 / 6.0
    else:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2
        c = (1.0 - a) / angle**2
    S = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    for r in range(3):
        for k in range(3):
            S2 = w[r] * w[k] - (angle * angle if r == k else 0.0)
            one = 1.0 if r == k else 0.0
            R[r, k] = one + a * S[r, k] + b * S2
            J[r, k] = one + b * S[r, k] + c * S2


@part
def _rotation(twist: Array, sign: float, wx: float, wy: float, wz: float, p: Array) -> None:
    """twist += sign * the turn w about the point p."""
    wx, wy, wz = sign * wx, sign * wy, sign * wz
    twist[0] += p[1] * wz - p[2] * wy
    twist[1] += p[2] * wx - p[0] * wz
    twist[2] += p[0] * wy - p[1] * wx
    twist[3] += wx
    twist[4] += wy
    twist[5] += wz


@part
def _leave(S: Array, slot: int, R: Array, p: Array, T: Array, J: Array, right: bool) -> None:
    """Twists of the six displacements of T = Trans(t) exp(w), where the walk stands at (R, p) before T.

    right: T is inverted and the walk stands before the inverse; the twists are added to those that are there.
    """
    point = np.empty(3)
    for r in range(3):
        point[r] = p[r]
        if not right:
            point[r] += R[r, 0] * T[0, 3] + R[r, 1] * T[1, 3] + R[r, 2] * T[2, 3]
    w = np.empty(3)
    for k in range(3):
        # the inverse: -(exp(-w) e_k), and the right Jacobian, which is exp(-w) J
        for r in range(3):
            w[r] = J[r, k]
        if right:
            x, y, z = w[0], w[1], w[2]
            for r in range(3):
                w[r] = T[0, r] * x + T[1, r] * y + T[2, r] * z
        for r in range(3):
            if right:
                S[slot + k, r] -= R[r, 0] * T[k, 0] + R[r, 1] * T[k, 1] + R[r, 2] * T[k, 2]
            else:
                S[slot + k, r] += R[r, k]
        wx = R[0, 0] * w[0] + R[0, 1] * w[1] + R[0, 2] * w[2]
        wy = R[1, 0] * w[0] + R[1, 1] * w[1] + R[1, 2] * w[2]
        wz = R[2, 0] * w[0] + R[2, 1] * w[1] + R[2, 2] * w[2]
        _rotation(S[slot + 3 + k], -1.0 if right else 1.0, wx, wy, wz, point)


@part
def _move(S: Array, slot: int, R: Array, p: Array, prismatic: bool, q: float) -> None:
    """A joint's motion, its twist left in `slot`."""
    if prismatic:
        for r in range(3):
            S[slot, r] = R[r, 2]
            S[slot, 3 + r] = 0.0
    else:
        for r in range(6):
            S[slot, r] = 0.0
        _rotation(S[slot], 1.0, R[0, 2], R[1, 2], R[2, 2], p)
    move_joint(R, p, prismatic, q)


@part
def _walk(model: ModelArrays, given: Displacements, row: int, q: Array, S: Array, R: Array, p: Array) -> None:
    """One posture: R, p the target's pose; S (slots + 1, 6) the twists of all errors at the origin."""
    n = q.shape[0]
    back, turn, turn_J = np.zeros((4, 4)), np.eye(4), np.eye(3)
    S[:] = 0.0
    scratch = JOINT + JOINT_SLOTS * n
    for r in range(3):
        p[r] = model.left[r, 3]
        for c in range(3):
            R[r, c] = model.left[r, c]
    for i in range(model.start, n):
        if i == model.workpiece:
            if model.start < model.workpiece:
                compose(R, p, model.floor_inverse)
            _leave(S, BASE, R, p, given.base, given.base_J, False)
            compose(R, p, given.base)
            compose(R, p, model.floor)
        if i == model.arm:
            compose(R, p, model.root)
            if given.root.shape[0] > 0:
                _turn(given.root[row, 3:], turn, turn_J)
                for r in range(3):
                    turn[r, 3] = given.root[row, r]
            _leave(S, ROOT, R, p, turn, turn_J, False)
            compose(R, p, turn)
            compose(R, p, model.root_inverse)
        compose(R, p, model.before[i])
        slot = JOINT + JOINT_SLOTS * i
        if i >= model.arm:
            if given.moved[i]:
                _leave(S, slot, R, p, given.joints[i], given.joints_J[i], False)
                compose(R, p, given.joints[i])
            _move(S, slot + MOTION, R, p, model.prismatic[i], q[i])
        else:  # the displacement moves the axis alone: nothing happens where the axis stands at 0
            if given.moved[i]:
                _leave(S, slot, R, p, given.joints[i], given.joints_J[i], False)
                compose(R, p, given.joints[i])
            _move(S, slot + MOTION, R, p, model.prismatic[i], q[i] - model.zero[i])
            if given.moved[i]:
                _leave(S, slot, R, p, given.joints[i], given.joints_J[i], True)
                _inverse(given.joints[i], back)
                compose(R, p, back)
            _move(S, scratch, R, p, model.prismatic[i], model.zero[i])
        compose(R, p, model.after[i])
    compose(R, p, model.last)
    _leave(S, TOOL, R, p, given.tool, given.tool_J, False)
    compose(R, p, given.tool)
    compose(R, p, model.right)


@kernel(nogil=True)
def poses_and_twists(
    model: ModelArrays,
    given: Displacements,
    q: Array,
    slots: NDArray[np.int64],
    factors: Array,
    factor_of: NDArray[np.int64],
) -> tuple[Array, Array]:
    """Target poses (N, 4, 4) of postures q (N, n), and Jacobian (N, 6, K), rows (v, w) of the target in the measured
    frame.

    Column k is the twist of slots[k], times factors[:, factor_of[k]] where factor_of[k] is not negative.
    """
    N, n, K = q.shape[0], q.shape[1], slots.shape[0]
    S = np.zeros((JOINT + JOINT_SLOTS * n + 1, 6))
    R, p = np.empty((3, 3)), np.empty(3)
    poses, J = np.zeros((N, 4, 4)), np.empty((N, 6, K))
    for row in range(N):
        _walk(model, given, row, q[row], S, R, p)
        for r in range(3):
            poses[row, r, 3] = p[r]
            for c in range(3):
                poses[row, r, c] = R[r, c]
        poses[row, 3, 3] = 1.0
        for k in range(K):
            s = S[slots[k]]
            f = factors[row, factor_of[k]] if factor_of[k] >= 0 else 1.0
            J[row, 0, k] = f * (s[0] + s[4] * p[2] - s[5] * p[1])
            J[row, 1, k] = f * (s[1] + s[5] * p[0] - s[3] * p[2])
            J[row, 2, k] = f * (s[2] + s[3] * p[1] - s[4] * p[0])
            for r in range(3):
                J[row, 3 + r, k] = f * s[3 + r]
    return poses, J
