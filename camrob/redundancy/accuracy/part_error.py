"""The expected squared error of the part in a posture, for the planner's kernels, and what it weighs in the objective.

A force f on the tool's tip turns arm axis i about its line by c_i v_i . f + s_i g_i, with v_i = z_i x (tip - p_i) the axis's
lever, c_i its compliance, g_i gravity's torque and s_i the sag found under it, and the tip moves by d = sum_i v_i (c_i v_i . f
+ s_i g_i + shift_i), with a coupling's share in shift_i, and by how far frames that stand off carry it and tool and holder give:
the directional compliance J C J^T of the posture under the force. Of d only what lies along the normal n of the surface that
is left there moves the surface: its square, in the mean over that surface, is d^T M d with M the mean of n n^T. Where the
surface is not known, M = 1 - t t^T with t the feed's direction: what lies along the feed leaves any surface where it is. What is
not known counts by its variance: with |d|_M^2 = d^T M d,

    E e^2 = |d|_M^2 + sum_k |d_k|_M^2 + sum_i (swing_i^2 + (granted_i v_i . f)^2) |v_i|_M^2 + doubt^2 |d_f|_M^2
            + any_force^2 sum_a |C_a|_M^2 + (rest^2 + g) tr M

without its first term where the program is compensated afterwards, with d_k the d of a standard deviation in direction k of what
was fitted, d_f the force's part of d, C_a the columns of C, rest what nobody has explained, and g the variance of its part that
follows posture. What was measured of that part near by belongs to d, and by how much less it would be beside a larger constant to
d_k: where the logs were, the two make up for each other, so that staying costs little, and leaving costs the constants' doubt.

In the objective a metre cut costs `accuracy` E e^2 / e_0^2 (`part_error`), times the surface that is left there, which is 1 in
the mean over what is cut; what is cut away again later costs nothing. e_0^2 is the mean over the path at the best-conditioned
posture of each waypoint: at 1 an error like that costs as much as conditioning at the cell's threshold. An axis with friction
leaves a mark where it turns round in a cut. A search over waypoints does not see turns, but it sees how far
axes move back and forth: each radian in a cut costs what a mark of the axis's jump would, over MARK m, once a STROKE
(`turned_back`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel, part
from camrob.dynamics.gravity import GRAVITY, GravityArrays, gravity_arrays
from camrob.frame_steps import compose, move_joint
from camrob.redundancy.accuracy.posture_errors import ARM_AXES, PostureErrors
from camrob.redundancy.accuracy.smooth_rest import ALIKE, RestNumbers, rest_numbers, smooth_rest

__all__ = ["NO_ERRORS", "SHARE", "ErrorNumbers", "error_numbers", "expected_square", "expected_squares", "local_pushes"]

Array = NDArray[np.float64]

MARK, STROKE = 0.01, 0.1
"""m along which a turn of an axis shows, and rad that an axis moves from one turn to the next, as on a raster."""
PUSH, SHARE = 10, 9
"""Numbers of a waypoint's push: the force (N) and M (xx, yy, zz, xy, xz, yz) in the waypoint's frame; at SHARE, how much of what
is cut it counts for beside others, 0 where nothing does.
"""


class ErrorNumbers(NamedTuple):
    """`PostureErrors` for the kernels. weight: price of a metre cut and a m2 of E e^2, 0 for a planner that doesn't look at it;
    turning (6,): price of a radian that an axis moves in a cut; roll: 1 where the last of u is the roll; known: 0 where what is
    known is taken off afterwards, else 1.
    """

    weight: float
    turning: Array
    gravity: GravityArrays
    roll: int
    sagging: Array
    compliance: Array
    shift: Array
    swing: Array
    granted: Array
    root: Array
    tip: Array
    doubt: float
    any_force: float
    rest: float
    unexplained: RestNumbers
    known: float
    couples: NDArray[np.int64]
    coupling: Array
    places: Array


# a machine without an error, in the same types: nothing to count, and arrays of three and six without a row
NO_ERRORS = ErrorNumbers(
    0.0,
    np.zeros(ARM_AXES),
    GravityArrays(
        np.zeros((0, 4, 4)),
        np.zeros((0, 4, 4)),
        np.zeros(3),
        0,
        np.zeros(0, np.bool_),
        np.zeros(0, np.int64),
        np.zeros(0),
        np.zeros((0, 3)),
    ),
    0,
    np.zeros(ARM_AXES),
    np.zeros(ARM_AXES),
    np.zeros(ARM_AXES),
    np.zeros(ARM_AXES),
    np.zeros(ARM_AXES),
    np.zeros((2 * ARM_AXES, 0)),
    np.zeros(2),
    0.0,
    0.0,
    0.0,
    ALIKE,
    1.0,
    np.zeros((0, 2), np.int64),
    np.zeros(0),
    np.zeros((0, 6)),
)


def error_numbers(cell: Cell, roll: int, errors: PostureErrors) -> ErrorNumbers:
    """The numbers of a cell's errors, nothing weighed yet; roll: 1 where the cell has a virtual one."""
    plain = (errors.sagging, errors.compliance, errors.shift, errors.swing, errors.granted, errors.root, errors.tip)
    sagging, c, shift, swing, granted, root, tip = (np.ascontiguousarray(x, np.float64) for x in plain)
    return ErrorNumbers(
        0.0,
        np.zeros(ARM_AXES),
        gravity_arrays(cell),
        roll,
        sagging,
        c,
        shift,
        swing,
        granted,
        root,
        tip,
        float(errors.doubt),
        float(errors.any_force),
        float(errors.rest),
        rest_numbers(cell, errors.unexplained),
        0.0 if errors.corrected else 1.0,
        np.ascontiguousarray(errors.couples, np.int64),
        np.ascontiguousarray(errors.coupling, np.float64),
        np.ascontiguousarray(errors.places, np.float64),
    )


def local_pushes(
    base_T_tip: Array, cutting: NDArray[np.bool_], feed: Array, errors: PostureErrors, squares: Array | None = None
) -> Array:
    """(N, PUSH) pushes at frames (N, 4, 4) in the order of travel; cutting (N,): the move to each one cuts, feed (N,) m/s.

    squares: (N, 3, 3) sums of n n^T in `base` over the surface left at each, its trace what it counts for; None where the surface
    is not known.
    """
    tip = base_T_tip[:, :3, 3]
    ahead = np.diff(tip, axis=0, append=tip[-1:])
    behind = np.diff(tip, axis=0, prepend=tip[:1])
    leaves = np.append(cutting[1:], False)
    way = behind * cutting[:, None] + ahead * leaves[:, None]
    size = np.linalg.norm(way, axis=1)
    counts = (size > 0.0) & (cutting | leaves)
    t = way / np.maximum(size, 1e-300)[:, None]
    z = base_T_tip[:, :3, 2]
    x = t - np.sum(t * z, axis=1, keepdims=True) * z
    level = np.linalg.norm(x, axis=1)
    x = np.where((level > _UPRIGHT)[:, None], x / np.maximum(level, _UPRIGHT)[:, None], 0.0)
    along, across, axial = errors.force.mean(np.where(np.isfinite(feed), feed, 0.0)).T[:, :, None]
    force = along * x + across * np.cross(z, x) + axial * z
    R, out = base_T_tip[:, :3, :3], np.zeros((len(tip), PUSH))
    out[:, :3] = np.einsum("nji,nj->ni", R, force)
    share = np.ones(len(tip)) if squares is None else np.trace(squares, axis1=1, axis2=2)
    across = (
        np.eye(3) - t[:, :, None] * t[:, None]
        if squares is None
        else squares / np.maximum(share, 1e-300)[:, None, None]
    )
    M = np.einsum("nji,njk,nkl->nil", R, across, R)
    out[:, 3:SHARE] = M[:, (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    out[:, SHARE] = share
    out[~counts] = 0.0
    return out


_UPRIGHT = 1e-6
"""Of the feed's direction across the tool: a tool that plunges has no sides."""


@part
def _arm_in_world(
    errors: ErrorNumbers, u: Array, q: Array, Z: Array, P: Array, C: Array, R: Array, p: Array, frames: Array
) -> None:
    """Axes Z and points P (6, 3) of the arm, centres C (M, 3) of the masses, the tool R, p, in the frame of gravity's `up`.

    frames: (PLACES, 3, 3), filled where places are known of; their points are the floor's origin, P and p.
    """
    g, E = errors.gravity, u.shape[0] - errors.roll
    for i in range(g.first, E + 6):
        compose(R, p, g.before[i])
        if i >= E:
            for r in range(3):
                Z[i - E, r], P[i - E, r] = R[r, 2], p[r]
            if frames.shape[0] > 0:
                frames[i - E + 1] = R
        move_joint(R, p, g.prismatic[i], q[i - E] if i >= E else u[i])
        for k in range(g.joint.shape[0]):
            if g.joint[k] == i:
                c = g.center[k]
                for r in range(3):
                    C[k, r] = p[r] + R[r, 0] * c[0] + R[r, 1] * c[1] + R[r, 2] * c[2]
        compose(R, p, g.after[i])
    if frames.shape[0] > 0:
        frames[0], frames[frames.shape[0] - 1] = np.eye(3), R


@part
def _carry(x: Array, frames: Array, P: Array, p: Array, moved: Array) -> None:
    """moved (3,) += how far frames that stand off by x (6 PLACES,) carry the tip p; P (6, 3): the axes' points."""
    for f in range(frames.shape[0]):
        R, k, last = frames[f], 6 * f, f == frames.shape[0] - 1
        lx = p[0] - (0.0 if f == 0 else p[0] if last else P[f - 1, 0])
        ly = p[1] - (0.0 if f == 0 else p[1] if last else P[f - 1, 1])
        lz = p[2] - (0.0 if f == 0 else p[2] if last else P[f - 1, 2])
        wx = R[0, 0] * x[k + 3] + R[0, 1] * x[k + 4] + R[0, 2] * x[k + 5]
        wy = R[1, 0] * x[k + 3] + R[1, 1] * x[k + 4] + R[1, 2] * x[k + 5]
        wz = R[2, 0] * x[k + 3] + R[2, 1] * x[k + 4] + R[2, 2] * x[k + 5]
        moved[0] += R[0, 0] * x[k] + R[0, 1] * x[k + 1] + R[0, 2] * x[k + 2] + wy * lz - wz * ly
        moved[1] += R[1, 0] * x[k] + R[1, 1] * x[k + 1] + R[1, 2] * x[k + 2] + wz * lx - wx * lz
        moved[2] += R[2, 0] * x[k] + R[2, 1] * x[k + 1] + R[2, 2] * x[k + 2] + wx * ly - wy * lx


@part
def _gravity_torque(g: GravityArrays, i: int, joint: int, Z: Array, P: Array, C: Array) -> float:
    """Nm about the arm's axis i, which is joint `joint` of the chain."""
    total = 0.0
    for k in range(g.joint.shape[0]):
        if g.joint[k] >= joint:
            x, y, z = C[k, 0] - P[i, 0], C[k, 1] - P[i, 1], C[k, 2] - P[i, 2]
            along = g.up[0] * (Z[i, 1] * z - Z[i, 2] * y)
            along += g.up[1] * (Z[i, 2] * x - Z[i, 0] * z) + g.up[2] * (Z[i, 0] * y - Z[i, 1] * x)
            total -= GRAVITY * g.mass[k] * along
    return float(total)


@part
def expected_square(errors: ErrorNumbers, u: Array, q: Array, push: Array, levers: Array) -> float:
    """E e^2 (m2) in a posture u (F,), q (6,) under a push (PUSH,); levers (6,) <- |v_i|_M^2, m2."""
    E = u.shape[0] - errors.roll
    R, p, Z, P, v = np.eye(3), np.zeros(3), np.empty((6, 3)), np.empty((6, 3)), np.empty((6, 3))
    C, frames = np.empty((errors.gravity.joint.shape[0], 3)), np.empty((errors.places.shape[0], 3, 3))
    _arm_in_world(errors, u, q, Z, P, C, R, p, frames)
    f, Q, M = np.empty(3), R.copy(), np.empty((3, 3))
    co, si = 1.0, 0.0
    if errors.roll == 1:
        co, si = np.cos(u[u.shape[0] - 1]), np.sin(u[u.shape[0] - 1])
    for r in range(3):  # the waypoint's frame is the tool's, rolled
        Q[r, 0], Q[r, 1] = co * R[r, 0] + si * R[r, 1], co * R[r, 1] - si * R[r, 0]
        f[r] = Q[r, 0] * push[0] + Q[r, 1] * push[1] + Q[r, 2] * push[2]
    _in_world(Q, push, M)
    moved, pushed, own, loose = np.zeros(3), np.zeros(3), np.empty(6), np.empty(6)
    for i in range(6):
        dx, dy, dz = p[0] - P[i, 0], p[1] - P[i, 1], p[2] - P[i, 2]
        v[i, 0] = Z[i, 1] * dz - Z[i, 2] * dy
        v[i, 1] = Z[i, 2] * dx - Z[i, 0] * dz
        v[i, 2] = Z[i, 0] * dy - Z[i, 1] * dx
        torque = v[i, 0] * f[0] + v[i, 1] * f[1] + v[i, 2] * f[2]
        sag = _gravity_torque(errors.gravity, i, E + i, Z, P, C)
        own[i], loose[i] = sag + torque, errors.granted[i] * torque
        for r in range(3):
            moved[r] += v[i, r] * (errors.sagging[i] * sag + errors.compliance[i] * torque + errors.shift[i])
            pushed[r] += v[i, r] * errors.compliance[i] * torque
    for m in range(errors.couples.shape[0]):
        i, shift = errors.couples[m, 0], errors.coupling[m] * q[errors.couples[m, 1]]
        for r in range(3):
            moved[r] += v[i, r] * shift
    _carry(errors.places.ravel(), frames, P, p, moved)
    axial = f[0] * R[0, 2] + f[1] * R[1, 2] + f[2] * R[2, 2]
    for r in range(3):
        give = errors.tip[0] * f[r] + (errors.tip[1] - errors.tip[0]) * axial * R[r, 2]
        moved[r] += give
        pushed[r] += give
    beside = np.zeros((3, 1 + errors.root.shape[1]))
    total = (errors.rest * errors.rest + smooth_rest(errors.unexplained, errors.gravity, u, q, E, beside)) * (
        M[0, 0] + M[1, 1] + M[2, 2]
    )
    for r in range(3):
        moved[r] += beside[r, 0]
    total += errors.known * _square(M, moved) + errors.doubt * errors.doubt * _square(M, pushed)
    for i in range(6):
        levers[i] = _square(M, v[i])
        total += (errors.swing[i] * errors.swing[i] + loose[i] * loose[i]) * levers[i]
    return float(total + _unfitted(errors, v, own, q, frames, P, p, M, beside) + _unforeseen(errors, v, R, M))


@part
def _unfitted(
    errors: ErrorNumbers, v: Array, own: Array, q: Array, frames: Array, P: Array, p: Array, M: Array, beside: Array
) -> float:
    """m2 by what was fitted with doubt, of levers v (6, 3) and torques own (6,), less what the smooth rest makes up for."""
    total, moved, pairs = 0.0, np.empty(3), errors.couples.shape[0]
    for k in range(errors.root.shape[1]):
        for r in range(3):
            moved[r] = -beside[r, 1 + k]
        for i in range(6):
            turn = errors.root[i, k] * own[i] + errors.root[6 + i, k]
            for r in range(3):
                moved[r] += v[i, r] * turn
        for m in range(pairs):
            i, turn = errors.couples[m, 0], errors.root[12 + m, k] * q[errors.couples[m, 1]]
            for r in range(3):
                moved[r] += v[i, r] * turn
        _carry(errors.root[12 + pairs :, k], frames, P, p, moved)
        total += _square(M, moved)
    return float(total)


@part
def _unforeseen(errors: ErrorNumbers, v: Array, R: Array, M: Array) -> float:
    """m2 by a force of which nothing is known."""
    total, moved = 0.0, np.empty(3)
    if errors.any_force > 0.0:
        for a in range(3):
            for r in range(3):
                moved[r] = (errors.tip[1] - errors.tip[0]) * R[a, 2] * R[r, 2]
            moved[a] += errors.tip[0]
            for i in range(6):
                for r in range(3):
                    moved[r] += v[i, r] * errors.compliance[i] * v[i, a]
            total += errors.any_force * errors.any_force * _square(M, moved)
    return float(total)


@part
def _in_world(Q: Array, push: Array, M: Array) -> None:
    """M (3, 3) <- a push's, turned by Q."""
    for r in range(3):
        x = Q[r, 0] * push[3] + Q[r, 1] * push[6] + Q[r, 2] * push[7]
        y = Q[r, 0] * push[6] + Q[r, 1] * push[4] + Q[r, 2] * push[8]
        z = Q[r, 0] * push[7] + Q[r, 1] * push[8] + Q[r, 2] * push[5]
        for c in range(3):
            M[r, c] = x * Q[c, 0] + y * Q[c, 1] + z * Q[c, 2]


@part
def _square(M: Array, d: Array) -> float:
    """d^T M d of a d (3,)."""
    total = 0.0
    for r in range(3):
        total += d[r] * (M[r, 0] * d[0] + M[r, 1] * d[1] + M[r, 2] * d[2])
    return total


@kernel(nogil=True)
def expected_squares(errors: ErrorNumbers, u: Array, q: Array, push: Array) -> tuple[Array, Array]:
    """E e^2 (N,) m2 of postures u (N, F), q (N, 6) under pushes (N, PUSH), and |v_i|_M^2 (N, 6) m2."""
    N = u.shape[0]
    out, levers = np.zeros(N), np.zeros((N, 6))
    for k in range(N):
        out[k] = expected_square(errors, u[k], q[k], push[k], levers[k])
    return out, levers
