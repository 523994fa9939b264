"""Pieces of the tracker that know the chain and nothing of its criterion: scratch arrays, pose error, second
derivatives.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from camrob.kinematics.kernels import ChainArrays

__all__ = ["TrackerWork", "curvature", "pose_error", "tracker_work"]

Array = NDArray[np.float64]


class TrackerWork(NamedTuple):
    """Arrays of the tracker's inner loop, made once a path and overwritten at every step."""

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
    slope0: Array
    slope1: Array
    weight_cond: Array
    slope_cond0: Array
    slope_cond1: Array
    kf_slope: Array
    kf_part: Array
    reduced: Array
    moved: Array
    free: NDArray[np.int64]


@numba.njit(cache=True, forceinline=True)
def tracker_work(n: int) -> TrackerWork:
    """Arrays for a chain of n joints."""
    return TrackerWork(
        np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((6, n)),
        np.empty((n, 6)), np.empty(6), np.empty(n), np.empty(n), np.empty((n, n)), np.empty((n, n)),
        np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(6), np.empty(n), np.empty(n), np.empty(n),
        np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n, np.int64),
    )  # fmt: skip


@numba.njit(cache=True, forceinline=True)
def pose_error(R: Array, p: Array, R_target: Array, p_target: Array, error: Array) -> None:
    """error (6,) <- (position, rotation vector) in `base` from (R, p) to the target; a logarithm, exact at any angle."""
    for r in range(3):
        error[r] = p_target[r] - p[r]
    # axial vector and cosine of D = R_target R^T
    d = np.empty((3, 3))
    for r in range(3):
        for c in range(3):
            d[r, c] = R_target[r, 0] * R[c, 0] + R_target[r, 1] * R[c, 1] + R_target[r, 2] * R[c, 2]
    vx, vy, vz = 0.5 * (d[2, 1] - d[1, 2]), 0.5 * (d[0, 2] - d[2, 0]), 0.5 * (d[1, 0] - d[0, 1])
    sine = np.sqrt(vx * vx + vy * vy + vz * vz)
    cosine = 0.5 * (d[0, 0] + d[1, 1] + d[2, 2] - 1.0)
    if sine > 1e-8:
        k = np.arctan2(sine, cosine) / sine
        error[3], error[4], error[5] = k * vx, k * vy, k * vz
    elif cosine > 0.0:
        error[3], error[4], error[5] = vx, vy, vz
    else:  # half a turn: any axis of it will do for a step
        i = int(np.argmax(np.array([d[0, 0], d[1, 1], d[2, 2]])))
        norm = np.sqrt(max(1e-12, 0.5 * (1.0 + d[i, i])))
        for r in range(3):
            error[3 + r] = np.pi * (norm if r == i else 0.5 * d[r, i] / norm)


@numba.njit(cache=True, forceinline=True)
def curvature(chain: ChainArrays, m: int, scale: float, multipliers: Array, w: TrackerWork) -> None:
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
