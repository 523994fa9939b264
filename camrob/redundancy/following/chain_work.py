"""Pieces of the follower that know the chain and nothing of its criterion: scratch arrays, pose error, second
derivatives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare
from camrob.kinematics.kernels import ChainArrays

__all__ = ["FollowerWork", "NearWork", "clear", "curvature", "follower_work", "largest", "pose_error", "put"]

Array = NDArray[np.float64]


class NearWork(NamedTuple):
    """Scratch of a posture beside another: the chain's frames there, and k_F's slope."""

    q: Array
    Z: Array
    P: Array
    R: Array
    p: Array
    plate: Array
    slope: Array


class FollowerWork(NamedTuple):
    """Arrays of the follower's inner loop, made once a path and overwritten at every step.

    slope, slope_cond (3, n): of the terms' vectors by the axes that their weights depend on. kf_bend (n, n): the rest of h_cond's
    derivative in its gradient form. near: scratch of a posture beside the one that is looked at.
    """

    Z: Array
    P: Array
    R: Array
    p: Array
    plate: Array
    J: Array
    A: Array
    tau: Array
    g: Array
    x: Array
    N: Array
    C: Array
    H: Array
    L: Array
    s: Array
    error: Array
    weight: Array
    slope: Array
    weight_cond: Array
    slope_cond: Array
    kf_slope: Array
    kf_bend: Array
    kf_part: Array
    reduced: Array
    multipliers: Array
    moved: Array
    free: NDArray[np.int64]
    rows: Array
    lever: Array
    U: Array
    V: Array
    Y: Array
    F: Array
    z: Array
    split: NDArray[np.bool_]
    near: NearWork


def follower_work(n: int) -> FollowerWork:
    """Arrays for a chain of n joints."""
    return FollowerWork(
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(3),
        np.empty((6, n)),
        np.empty((n, 6)),
        np.empty(6),
        np.empty(n),
        np.empty(n),
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty(n),
        np.empty(6),
        np.empty(n),
        np.empty((3, n)),
        np.empty(n),
        np.empty((3, n)),
        np.empty(n),
        np.zeros((n, n)),
        np.empty(n),
        np.empty(n),
        np.empty(6),
        np.empty(n),
        np.empty(n, np.int64),
        np.empty((6, 3)),
        np.empty(3),
        np.empty((n, 4)),
        np.empty((n, 4)),
        np.empty((n, 3)),
        np.empty(6),
        np.empty(3),
        np.zeros(1, np.bool_),
        NearWork(
            np.empty(n), np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(n)
        ),
    )


@bare
def _dot(A: Array, i: int, B: Array, k: int) -> float:
    """Row i of A times row k of B."""
    return float(A[i, 0] * B[k, 0] + A[i, 1] * B[k, 1] + A[i, 2] * B[k, 2])


@bare
def pose_error(R: Array, p: Array, R_target: Array, p_target: Array, error: Array) -> None:
    """error (6,) <- (position, rotation vector) in `base` from (R, p) to the target; a logarithm, exact at any angle."""
    for r in range(3):
        error[r] = p_target[r] - p[r]
    # axial vector and cosine of D = R_target R^T
    dxx, dxy, dxz = _dot(R_target, 0, R, 0), _dot(R_target, 0, R, 1), _dot(R_target, 0, R, 2)
    dyx, dyy, dyz = _dot(R_target, 1, R, 0), _dot(R_target, 1, R, 1), _dot(R_target, 1, R, 2)
    dzx, dzy, dzz = _dot(R_target, 2, R, 0), _dot(R_target, 2, R, 1), _dot(R_target, 2, R, 2)
    vx, vy, vz = 0.5 * (dzy - dyz), 0.5 * (dxz - dzx), 0.5 * (dyx - dxy)
    square = vx * vx + vy * vy + vz * vz
    cosine = 0.5 * (dxx + dyy + dzz - 1.0)
    if square < 1e-6 and cosine > 0.0:  # the arcsine's series over the sine; the next term is 1e-20
        k = 1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0))
        error[3], error[4], error[5] = k * vx, k * vy, k * vz
        return
    sine = np.sqrt(square)
    if sine > 1e-8:
        k = np.arctan2(sine, cosine) / sine
        error[3], error[4], error[5] = k * vx, k * vy, k * vz
    else:  # half a turn: any axis of it will do for a step
        diagonal = dxx, dyy, dzz
        i = 0 if dxx >= dyy and dxx >= dzz else 1 if dyy >= dzz else 2
        norm = np.sqrt(max(1e-12, 0.5 * (1.0 + diagonal[i])))
        column = (dxx, dyx, dzx) if i == 0 else (dxy, dyy, dzy) if i == 1 else (dxz, dyz, dzz)
        for r in range(3):
            error[3 + r] = np.pi * (norm if r == i else 0.5 * column[r] / norm)


@bare
def curvature(chain: ChainArrays, m: int, scale: float, multipliers: Array, w: FollowerWork) -> None:
    """w.C[:m, :m] <- sum of multiplier times second derivative of the task (v scaled, rotation as logarithm)."""
    lx, ly, lz = multipliers[0] * scale, multipliers[1] * scale, multipliers[2] * scale
    ax, ay, az = 0.5 * multipliers[3], 0.5 * multipliers[4], 0.5 * multipliers[5]
    for a in range(m):
        j = w.free[a]
        zx, zy, zz = w.Z[j, 0], w.Z[j, 1], w.Z[j, 2]
        for b in range(a, m):
            if chain.prismatic[j]:
                w.C[a, b] = 0.0
            else:
                k = w.free[b]
                vx, vy, vz = w.J[0, k], w.J[1, k], w.J[2, k]
                c = lx * (zy * vz - zz * vy) + ly * (zz * vx - zx * vz) + lz * (zx * vy - zy * vx)
                if b > a and not chain.prismatic[k]:
                    ux, uy, uz = w.Z[k, 0], w.Z[k, 1], w.Z[k, 2]
                    c += ax * (zy * uz - zz * uy) + ay * (zz * ux - zx * uz) + az * (zx * uy - zy * ux)
                w.C[a, b] = c
            w.C[b, a] = w.C[a, b]


@bare
def largest(error: Array) -> float:
    """The largest component (6,) of a pose error."""
    worst = 0.0
    for r in range(6):
        worst = max(worst, abs(error[r]))
    return float(worst)


@bare
def put(source: Array, out: Array) -> None:
    """out (n,) <- source (n,)."""
    for i in range(out.shape[0]):
        out[i] = source[i]


@bare
def clear(out: Array) -> None:
    """out (n,) <- 0."""
    for i in range(out.shape[0]):
        out[i] = 0.0
