"""Frames along a path whose tool spins freely: z the tool axis, x turning as little as can be."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

__all__ = ["refine", "rotation_minimising"]

Array = NDArray[np.float64]


@numba.njit(cache=True)
def rotation_minimising(axis: Array, x_first: Array) -> Array:
    """Rotations (N, 3, 3) with z = axis (N, 3), unit, and x carried along by the least rotation from one z to the next.

    x starts as near to `x_first` (3,) as the first axis allows. The paper's Frenet frame (section 3) has no tangent
    normal on straight lines and flips at each turn of a zig-zag, which would spin the tool; this frame does neither, and
    the virtual joint makes up for whatever roll is better.
    """
    N = axis.shape[0]
    out = np.empty((N, 3, 3))
    x = x_first.copy()
    for k in range(N):
        z = axis[k]
        if k > 0:
            before = axis[k - 1]
            v = np.cross(before, z)
            c = before[0] * z[0] + before[1] * z[1] + before[2] * z[2]
            if c > -1.0 + 1e-12:  # the rotation from one axis to the next; a half turn keeps x
                cross = np.cross(v, x)
                x = x + cross + np.cross(v, cross) / (1.0 + c)
        along = x[0] * z[0] + x[1] * z[1] + x[2] * z[2]
        x = x - along * z
        norm = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        if norm < 1e-9:  # x_first lies along the first axis: any x across it
            pick = np.zeros(3)
            pick[int(np.argmin(np.abs(z)))] = 1.0
            x = np.cross(pick, z)
            norm = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        x = x / norm
        y = np.cross(z, x)
        for r in range(3):
            out[k, r, 0], out[k, r, 1], out[k, r, 2] = x[r], y[r], z[r]
    return out


@numba.njit(cache=True)
def refine(position: Array, axis: Array, step: float, angle: float) -> tuple[Array, Array, NDArray[np.int64]]:
    """Points (M, 3) and unit axes (M, 3) with others put between where neighbours are more than `step` m or `angle` rad apart.

    Returns also where (N,) the given points are among them. Axes go along the great arc.
    """
    N = position.shape[0]
    counts = np.ones(N, np.int64)
    for k in range(1, N):
        length = np.sqrt(np.sum((position[k] - position[k - 1]) ** 2))
        v = np.cross(axis[k - 1], axis[k])
        turn = np.arctan2(np.sqrt(np.sum(v * v)), np.sum(axis[k - 1] * axis[k]))
        counts[k] = max(1, int(np.ceil(max(length / step, turn / angle) - 1e-9)))
    where = np.cumsum(counts) - 1
    M = int(where[-1]) + 1
    points, axes = np.empty((M, 3)), np.empty((M, 3))
    points[0], axes[0] = position[0], axis[0]
    for k in range(1, N):
        v = np.cross(axis[k - 1], axis[k])
        sine = np.sqrt(np.sum(v * v))
        turn = np.arctan2(sine, np.sum(axis[k - 1] * axis[k]))
        side = np.cross(v / sine, axis[k - 1]) if sine > 1e-12 else np.zeros(3)
        for j in range(1, counts[k] + 1):
            s = j / counts[k]
            i = where[k] - counts[k] + j
            if j == counts[k]:
                points[i], axes[i] = position[k], axis[k]
            else:
                points[i] = position[k - 1] + s * (position[k] - position[k - 1])
                axes[i] = np.cos(s * turn) * axis[k - 1] + np.sin(s * turn) * side
                axes[i] /= np.sqrt(np.sum(axes[i] ** 2))
    return points, axes, where
