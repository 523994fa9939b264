"""The follower's Newton step where the arm's Jacobian has an inverse in closed form: all that a QR factorisation gives, for less.

The free joints outside of the arm span the null space: one of them moves by one and the arm takes the pose back. With
these vectors N and a step x_p of the arm that does the task, everything else is algebra in as many dimensions as there are
such joints. Rows with an entry for x_p and one for each vector are four long always, unused ones zero, and are worked on
as tuples, which the compiler keeps in registers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare
from camrob.kinematics.kernels import ChainArrays
from camrob.kinematics.spherical_inverse import inverse_blocks
from camrob.redundancy.following.chain_work import FollowerWork
from camrob.redundancy.following.linear_algebra import solve_stable

__all__ = ["split_multipliers", "split_self_motion", "split_share", "split_task"]

Array = NDArray[np.float64]
Four = tuple[float, float, float, float]
Three = tuple[float, float, float]


@bare
def _row(A: Array, i: int) -> Four:
    return A[i, 0], A[i, 1], A[i, 2], A[i, 3]


@bare
def _put(A: Array, i: int, x: Four) -> None:
    A[i, 0], A[i, 1], A[i, 2], A[i, 3] = x


@bare
def _plus(x: Four, k: float, y: Four) -> Four:
    """x + k y."""
    return x[0] + k * y[0], x[1] + k * y[1], x[2] + k * y[2], x[3] + k * y[3]


@bare
def _mix(a: float, x: Four, b: float, y: Four, c: float, z: Four) -> Four:
    """a x + b y + c z."""
    return (
        a * x[0] + b * y[0] + c * z[0],
        a * x[1] + b * y[1] + c * z[1],
        a * x[2] + b * y[2] + c * z[2],
        a * x[3] + b * y[3] + c * z[3],
    )


@bare
def split_task(chain: ChainArrays, n: int, side: NDArray[np.int64], locked: NDArray[np.bool_], w: FollowerWork) -> int:
    """w.U (n, 4) <- x_p and the null-space vectors, w.x <- pseudoinverse step to w.error. Returns the free joints' number.

    0 where the closed form can't be used: an arm without it or near a singular posture, an arm's joint at its limit, more
    than three free joints outside of the arm.
    """
    if not chain.spherical:
        return 0
    start, stop, m = chain.arm_start, chain.arm_stop, 0
    for i in range(n):
        if side[i] == 0 and not locked[i]:
            w.free[m] = i
            m += 1
        elif start <= i < stop:
            return 0
    if m > 9 or not inverse_blocks(w.Z, w.P, w.p, start, chain.wrist, w.rows, w.lever):
        return 0
    zero = (0.0, 0.0, 0.0, 0.0)
    i0 = i1 = i2 = 0
    k0 = k1 = k2 = 0.0
    for k in range(m):
        i = w.free[k]
        if i < start or i >= stop:
            _put(w.U, i, (0.0, 1.0 - k0, k0 - k1, k1))
            if k0 == 0.0:
                i0, k0 = i, 1.0
            elif k1 == 0.0:
                i1, k1 = i, 1.0
            else:
                i2, k2 = i, 1.0
    for i in range(n):
        if (i < start or i >= stop) and (side[i] != 0 or locked[i]):
            _put(w.U, i, zero)
    _arm_steps(start, i0, i1, i2, k0, k1, k2, w)
    y0, y1, y2 = _gram(n, m - 6, w)
    for k in range(m):  # the least step: x_p less its part in the null space
        u = _row(w.U, w.free[k])
        w.x[k] = u[0] - u[1] * y0 - u[2] * y1 - u[3] * y2
    return m


@bare
def _twists(r: int, i0: int, i1: int, i2: int, k0: float, k1: float, k2: float, w: FollowerWork) -> Four:
    """Component r of the twists that the arm has to answer: the task's, and what the other joints do, taken back."""
    return w.error[r], -k0 * w.J[r, i0], -k1 * w.J[r, i1], -k2 * w.J[r, i2]


@bare
def _arm_steps(start: int, i0: int, i1: int, i2: int, k0: float, k1: float, k2: float, w: FollowerWork) -> None:
    """w.U's rows of the arm <- the arm's steps for the task and for the joints i0 .. i2 outside (k 0 where there is none)."""
    lx, ly, lz, rows, Z = w.lever[0], w.lever[1], w.lever[2], w.rows, w.Z
    t3 = _twists(3, i0, i1, i2, k0, k1, k2, w)
    t4 = _twists(4, i0, i1, i2, k0, k1, k2, w)
    t5 = _twists(5, i0, i1, i2, k0, k1, k2, w)
    t0 = _plus(_plus(_twists(0, i0, i1, i2, k0, k1, k2, w), lz, t4), -ly, t5)  # velocities at the wrist
    t1 = _plus(_plus(_twists(1, i0, i1, i2, k0, k1, k2, w), lx, t5), -lz, t3)
    t2 = _plus(_plus(_twists(2, i0, i1, i2, k0, k1, k2, w), ly, t3), -lx, t4)
    u0 = _mix(rows[0, 0], t0, rows[0, 1], t1, rows[0, 2], t2)
    u1 = _mix(rows[1, 0], t0, rows[1, 1], t1, rows[1, 2], t2)
    u2 = _mix(rows[2, 0], t0, rows[2, 1], t1, rows[2, 2], t2)
    t3 = _plus(t3, -1.0, _mix(Z[start, 0], u0, Z[start + 1, 0], u1, Z[start + 2, 0], u2))
    t4 = _plus(t4, -1.0, _mix(Z[start, 1], u0, Z[start + 1, 1], u1, Z[start + 2, 1], u2))
    t5 = _plus(t5, -1.0, _mix(Z[start, 2], u0, Z[start + 1, 2], u1, Z[start + 2, 2], u2))
    u3 = _mix(rows[3, 0], t3, rows[3, 1], t4, rows[3, 2], t5)
    u4 = _mix(rows[4, 0], t3, rows[4, 1], t4, rows[4, 2], t5)
    u5 = _mix(rows[5, 0], t3, rows[5, 1], t4, rows[5, 2], t5)
    _put(w.U, start, u0)
    _put(w.U, start + 1, u1)
    _put(w.U, start + 2, u2)
    _put(w.U, start + 3, u3)
    _put(w.U, start + 4, u4)
    _put(w.U, start + 5, u5)


@bare
def _gram(n: int, r: int, w: FollowerWork) -> Three:
    """w.F <- the Cholesky factor of N^T N (diagonal inverted; unused vectors as if they stood alone).

    Returns the shares of the null-space vectors in x_p, which are kept in w.z too.
    """
    e00 = e11 = e22 = e10 = e20 = e21 = a0 = a1 = a2 = 0.0
    for i in range(n):
        x, u, v, s = _row(w.U, i)
        e00, e11, e22 = e00 + u * u, e11 + v * v, e22 + s * s
        e10, e20, e21 = e10 + u * v, e20 + u * s, e21 + v * s
        a0, a1, a2 = a0 + x * u, a1 + x * v, a2 + x * s
    if r < 3:
        e22 = 1.0
        if r < 2:
            e11 = 1.0
            if r < 1:
                e00 = 1.0
    d0 = 1.0 / np.sqrt(e00)
    f10, f20 = e10 * d0, e20 * d0
    d1 = 1.0 / np.sqrt(e11 - f10 * f10)
    f21 = (e21 - f20 * f10) * d1
    d2 = 1.0 / np.sqrt(e22 - f20 * f20 - f21 * f21)
    F = w.F
    F[0], F[1], F[2], F[3], F[4], F[5] = d0, d1, d2, f10, f20, f21
    y0, y1, y2 = _solve_gram(F, a0, a1, a2)
    w.z[0], w.z[1], w.z[2] = y0, y1, y2
    return y0, y1, y2


@bare
def _forward_gram(F: Array, y0: float, y1: float, y2: float) -> Three:
    """L^-1 y."""
    y0 = y0 * F[0]
    y1 = (y1 - F[3] * y0) * F[1]
    return y0, y1, (y2 - F[4] * y0 - F[5] * y1) * F[2]


@bare
def _back_gram(F: Array, y0: float, y1: float, y2: float) -> Three:
    """L^-T y."""
    y2 = y2 * F[2]
    y1 = (y1 - F[5] * y2) * F[1]
    return (y0 - F[3] * y1 - F[4] * y2) * F[0], y1, y2


@bare
def _solve_gram(F: Array, y0: float, y1: float, y2: float) -> Three:
    """(L L^T)^-1 y."""
    y0, y1, y2 = _forward_gram(F, y0, y1, y2)
    y: Three = _back_gram(F, y0, y1, y2)
    return y


@bare
def split_multipliers(chain: ChainArrays, n: int, multipliers: Array, w: FollowerWork) -> None:
    """multipliers (6,) <- those with which the task's rows (v over the length) meet w.g best over the free joints.

    What is left of g without its part in the null space, the rows can meet; the arm's columns tell how.
    """
    rows, start, Z = w.rows, chain.arm_start, w.Z
    g0 = g1 = g2 = 0.0
    for i in range(n):
        _x, u, v, s = _row(w.U, i)
        g0, g1, g2 = g0 + u * w.g[i], g1 + v * w.g[i], g2 + s * w.g[i]
    w.reduced[0], w.reduced[1], w.reduced[2] = g0, g1, g2
    y = _solve_gram(w.F, g0, g1, g2)
    f0, f1, f2 = _met(start + 3, y, w), _met(start + 4, y, w), _met(start + 5, y, w)
    bx = rows[3, 0] * f0 + rows[4, 0] * f1 + rows[5, 0] * f2
    by = rows[3, 1] * f0 + rows[4, 1] * f1 + rows[5, 1] * f2
    bz = rows[3, 2] * f0 + rows[4, 2] * f1 + rows[5, 2] * f2
    f0 = _met(start, y, w) - (Z[start, 0] * bx + Z[start, 1] * by + Z[start, 2] * bz)
    f1 = _met(start + 1, y, w) - (Z[start + 1, 0] * bx + Z[start + 1, 1] * by + Z[start + 1, 2] * bz)
    f2 = _met(start + 2, y, w) - (Z[start + 2, 0] * bx + Z[start + 2, 1] * by + Z[start + 2, 2] * bz)
    ax = rows[0, 0] * f0 + rows[1, 0] * f1 + rows[2, 0] * f2
    ay = rows[0, 1] * f0 + rows[1, 1] * f1 + rows[2, 1] * f2
    az = rows[0, 2] * f0 + rows[1, 2] * f1 + rows[2, 2] * f2
    lx, ly, lz = w.lever[0], w.lever[1], w.lever[2]
    multipliers[0], multipliers[1], multipliers[2] = ax * chain.length, ay * chain.length, az * chain.length
    multipliers[3], multipliers[4], multipliers[5] = (
        bx + ly * az - lz * ay,
        by + lz * ax - lx * az,
        bz + lx * ay - ly * ax,
    )


@bare
def _met(i: int, y: Three, w: FollowerWork) -> float:
    """Joint i's gradient less its part in the null space."""
    return float(w.g[i] - w.U[i, 1] * y[0] - w.U[i, 2] * y[1] - w.U[i, 3] * y[2])


@bare
def _curved(chain: ChainArrays, n: int, scale: float, multipliers: Array, w: FollowerWork) -> None:
    """w.V (n, 4) <- minus the task's second derivatives times the multipliers, times w.U, without that matrix.

    For a before b it is z_a . y_b with y_b = v_b x l + z_b x w / 2, so that sums over the joints behind and before are enough.
    """
    lx, ly, lz = multipliers[0] * scale, multipliers[1] * scale, multipliers[2] * scale
    ax, ay, az = 0.5 * multipliers[3], 0.5 * multipliers[4], 0.5 * multipliers[5]
    J, Z = w.J, w.Z
    sx = sy = sz = (0.0, 0.0, 0.0, 0.0)
    for i in range(n - 1, -1, -1):
        yx = J[1, i] * lz - J[2, i] * ly
        yy = J[2, i] * lx - J[0, i] * lz
        yz = J[0, i] * ly - J[1, i] * lx
        zx, zy, zz = Z[i, 0], Z[i, 1], Z[i, 2]
        if chain.prismatic[i]:
            zx = zy = zz = 0.0
        yx += zy * az - zz * ay
        yy += zz * ax - zx * az
        yz += zx * ay - zy * ax
        w.Y[i, 0], w.Y[i, 1], w.Y[i, 2] = yx, yy, yz
        u = _row(w.U, i)
        sx, sy, sz = _plus(sx, yx, u), _plus(sy, yy, u), _plus(sz, yz, u)
        _put(w.V, i, _mix(-zx, sx, -zy, sy, -zz, sz))
    sx = sy = sz = (0.0, 0.0, 0.0, 0.0)
    for i in range(n):
        v, u = _row(w.V, i), _row(w.U, i)
        _put(w.V, i, _plus(v, -1.0, _mix(w.Y[i, 0], sx, w.Y[i, 1], sy, w.Y[i, 2], sz)))
        if not chain.prismatic[i]:
            sx, sy, sz = _plus(sx, Z[i, 0], u), _plus(sy, Z[i, 1], u), _plus(sz, Z[i, 2], u)


@bare
def split_self_motion(
    chain: ChainArrays,
    joint_axis: NDArray[np.int64],
    condition_axis: NDArray[np.int64],
    n: int,
    m: int,
    acting: bool,
    gradient: bool,
    shift: float,
    multipliers: Array,
    exact: bool,
    w: FollowerWork,
) -> float:
    """w.s[:m] <- the Newton step of the reduced criterion in the null space, w.x taken into account; the shift it needed."""
    U = w.U
    _curved(chain, n, 1.0 / chain.length, multipliers, w)
    by_first, by_second, by_third = _row(U, joint_axis[0]), _row(U, joint_axis[1]), _row(U, joint_axis[2])
    by_kf = (0.0, 0.0, 0.0, 0.0)
    if acting:
        first, second, third = _row(U, condition_axis[0]), _row(U, condition_axis[1]), _row(U, condition_axis[2])
        if exact:
            for i in range(chain.arm_start, chain.arm_stop):
                by_kf = _plus(by_kf, w.kf_slope[i], _row(U, i))
        for i in range(n):
            v = _plus(_plus(_row(w.V, i), w.slope_cond[0, i], first), w.slope_cond[1, i], second)
            v = _plus(v, w.slope_cond[2, i], third)
            if gradient:
                for k in range(chain.arm_start, chain.arm_stop):
                    v = _plus(v, w.kf_bend[i, k], _row(U, k))
            _put(w.V, i, _plus(v, w.kf_part[i], by_kf))
    m0 = m1 = m2 = (0.0, 0.0, 0.0, 0.0)
    for i in range(n):
        u = _row(U, i)
        v = _plus(_row(w.V, i), w.weight[i], u)
        v = _plus(_plus(_plus(v, w.slope[0, i], by_first), w.slope[1, i], by_second), w.slope[2, i], by_third)
        m0, m1, m2 = _plus(m0, u[1], v), _plus(m1, u[2], v), _plus(m2, u[3], v)
    return float(_step(m, shift, m0, m1, m2, w))


@bare
def _step(m: int, shift: float, m0: Four, m1: Four, m2: Four, w: FollowerWork) -> float:
    """w.s[:m] <- the step from the reduced curvature m0, m1, m2 (first column: of x_p), in an orthonormal basis; the shift."""
    F, y0, y1, y2 = w.F, w.z[0], w.z[1], w.z[2]  # w.x = x_p - N y
    b0, b1, b2 = _forward_gram(
        F,
        m0[1] * y0 + m0[2] * y1 + m0[3] * y2 - m0[0] - w.reduced[0],
        m1[1] * y0 + m1[2] * y1 + m1[3] * y2 - m1[0] - w.reduced[1],
        m2[1] * y0 + m2[2] * y1 + m2[3] * y2 - m2[0] - w.reduced[2],
    )
    h00, h10, h20 = _forward_gram(F, m0[1], m1[1], m2[1])
    h01, h11, h21 = _forward_gram(F, m0[2], m1[2], m2[2])
    h02, h12, h22 = _forward_gram(F, m0[3], m1[3], m2[3])
    h00, h01, h02 = _forward_gram(F, h00, h01, h02)
    h10, h11, h12 = _forward_gram(F, h10, h11, h12)
    h20, h21, h22 = _forward_gram(F, h20, h21, h22)
    b0, b1, b2, shift = solve_stable((h00, h01, h02, h10, h11, h12, h20, h21, h22), (b0, b1, b2), m - 6, shift)
    b0, b1, b2 = _back_gram(F, b0, b1, b2)
    for k in range(m):
        _x, u, v, s = _row(w.U, w.free[k])
        w.s[k] = u * b0 + v * b1 + s * b2
    return shift


@bare
def split_share(m: int, q: Array, q_before: Array, w: FollowerWork) -> None:
    """w.s[:m] <- the part of the motion from q_before to q that is self-motion."""
    a0 = a1 = a2 = 0.0
    for k in range(m):
        i = w.free[k]
        d = q[i] - q_before[i]
        _x, u, v, s = _row(w.U, i)
        a0, a1, a2 = a0 + u * d, a1 + v * d, a2 + s * d
    a0, a1, a2 = _solve_gram(w.F, a0, a1, a2)
    for k in range(m):
        _x, u, v, s = _row(w.U, w.free[k])
        w.s[k] = u * a0 + v * a1 + s * a2
