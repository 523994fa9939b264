"""Frames along a path whose tool spins freely: z the tool axis, x turning as little as can be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel
from camrob.triples import between, copy3, cross, dot

__all__ = ["refine", "rotation_minimising"]

Array = NDArray[np.float64]


@kernel
def rotation_minimising(axis: Array, x_first: Array) -> Array:
    """Rotations (N, 3, 3) with z = axis (N, 3), unit, and x carried along by the least rotation from one z to the next.

    x starts as near to `x_first` (3,) as the first axis allows. The paper's Frenet frame (section 3) has no tangent
    normal on straight lines and flips at each turn of a zig-zag, which would spin the tool; this frame does neither, and
    the virtual joint makes up for whatever roll is better.
    """
    N = axis.shape[0]
    out = np.empty((N, 3, 3))
    x = (x_first[0], x_first[1], x_first[2])
    for k in range(N):
        z = axis[k]
        if k > 0:
            before = axis[k - 1]
            v = cross(before, z)
            c = before[0] * z[0] + before[1] * z[1] + before[2] * z[2]
            if c > -1.0 + 1e-12:  # the rotation from one axis to the next; a half turn keeps x
                once = cross(v, x)
                twice = cross(v, once)
                x = (
                    x[0] + once[0] + twice[0] / (1.0 + c),
                    x[1] + once[1] + twice[1] / (1.0 + c),
                    x[2] + once[2] + twice[2] / (1.0 + c),
                )
        along = x[0] * z[0] + x[1] * z[1] + x[2] * z[2]
        x = x[0] - along * z[0], x[1] - along * z[1], x[2] - along * z[2]
        norm = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        if norm < 1e-9:  # x_first lies along the first axis: any x across it
            least = 0
            for r in range(1, 3):
                if abs(z[r]) < abs(z[least]):
                    least = r
            x = cross((1.0 if least == 0 else 0.0, 1.0 if least == 1 else 0.0, 1.0 if least == 2 else 0.0), z)
            norm = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        x = x[0] / norm, x[1] / norm, x[2] / norm
        y = cross(z, x)
        for r in range(3):
            out[k, r, 0], out[k, r, 1], out[k, r, 2] = x[r], y[r], z[r]
    return out


@kernel
def refine(position: Array, axis: Array, step: float, angle: float) -> tuple[Array, Array, NDArray[np.int64]]:
    """Points (M, 3) and unit axes (M, 3) with others put between where neighbours are more than `step` m or `angle` rad apart.

    Returns also where (N,) the given points are among them. Axes go along the great arc.
    """
    N = position.shape[0]
    counts, where = np.ones(N, np.int64), np.empty(N, np.int64)
    M = 1
    for k in range(N):
        if k > 0:
            way = between(position[k - 1], position[k])
            v = cross(axis[k - 1], axis[k])
            turn = np.arctan2(np.sqrt(dot(v, v)), dot(axis[k - 1], axis[k]))
            counts[k] = max(1, int(np.ceil(max(np.sqrt(dot(way, way)) / step, turn / angle) - 1e-9)))
            M += counts[k]
        where[k] = M - 1
    points, axes = np.empty((M, 3)), np.empty((M, 3))
    copy3(position[0], points[0])
    copy3(axis[0], axes[0])
    for k in range(1, N):
        way = between(position[k - 1], position[k])
        v = cross(axis[k - 1], axis[k])
        sine = np.sqrt(dot(v, v))
        turn = np.arctan2(sine, dot(axis[k - 1], axis[k]))
        side = (0.0, 0.0, 0.0)
        if sine > 1e-12:
            side = cross((v[0] / sine, v[1] / sine, v[2] / sine), axis[k - 1])
        for j in range(1, counts[k]):
            s = j / counts[k]
            i = where[k] - counts[k] + j
            along, across = np.cos(s * turn), np.sin(s * turn)
            for r in range(3):
                points[i, r] = position[k - 1, r] + s * way[r]
                axes[i, r] = along * axis[k - 1, r] + across * side[r]
            norm = np.sqrt(dot(axes[i], axes[i]))
            for r in range(3):
                axes[i, r] /= norm
        copy3(position[k], points[where[k]])
        copy3(axis[k], axes[where[k]])
    return points, axes, where
