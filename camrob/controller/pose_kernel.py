"""Compiled pieces of geometry that replay and simulation share: great arcs, circles, where the arm's foot stands."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from camrob.frame_steps import compose, move_joint
from camrob.kinematics.kernels import ChainArrays

__all__ = ["circle", "foot", "rotation_vector", "turned"]

Array = NDArray[np.float64]


@numba.njit(cache=True, forceinline=True)
def rotation_vector(A: Array, B: Array, out: Array) -> None:
    """out <- rotation vector of A^T B, in A's axes."""
    m = np.empty((3, 3))
    for r in range(3):
        for c in range(3):
            m[r, c] = A[0, r] * B[0, c] + A[1, r] * B[1, c] + A[2, r] * B[2, c]
    v0, v1, v2 = 0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1])
    sine = np.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    if sine > 1e-7:
        out[0], out[1], out[2] = v0 * angle / sine, v1 * angle / sine, v2 * angle / sine
    elif cosine > 0.0:
        out[0], out[1], out[2] = v0, v1, v2
    else:  # half a turn: the controller may take either way; the axis with the largest share decides
        i = int(np.argmax(np.array([m[0, 0], m[1, 1], m[2, 2]])))
        norm = np.sqrt(max(1e-12, 0.5 * (1.0 + m[i, i])))
        for r in range(3):
            out[r] = np.pi * (norm if r == i else 0.5 * m[r, i] / norm)


@numba.njit(cache=True, forceinline=True)
def turned(A: Array, w: Array, s: float, out: Array) -> None:
    """out <- A exp(s w)."""
    angle = s * np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-12:
        out[:] = A
        return
    k = s / angle
    x, y, z = w[0] * k, w[1] * k, w[2] * k
    c, si = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    e = np.array(
        [
            [c + x * x * t, x * y * t - z * si, x * z * t + y * si],
            [y * x * t + z * si, c + y * y * t, y * z * t - x * si],
            [z * x * t - y * si, z * y * t + x * si, c + z * z * t],
        ]
    )
    for r in range(3):
        for col in range(3):
            out[r, col] = A[r, 0] * e[0, col] + A[r, 1] * e[1, col] + A[r, 2] * e[2, col]


@numba.njit(cache=True, forceinline=True)
def circle(a: Array, via: Array, b: Array, center: Array, u: Array, v: Array) -> float:
    """Centre and axes u, v: the arc from a over via to b is centre + cos u + sin v; returns its angle, 0 if flat."""
    ab, ac = via - a, b - a
    normal = np.cross(ab, ac)
    n2 = np.sum(normal * normal)
    if n2 < 1e-20:
        return 0.0
    center[:] = a + (np.sum(ab * ab) * np.cross(ac, normal) + np.sum(ac * ac) * np.cross(normal, ab)) / (2.0 * n2)
    normal = normal / np.sqrt(n2)
    u[:] = a - center
    v[:] = np.cross(normal, u)
    d = b - center
    angle = np.arctan2(np.sum(d * v), np.sum(d * u))
    return float(angle if angle > 0.0 else angle + 2.0 * np.pi)


@numba.njit(cache=True, forceinline=True)
def foot(chain: ChainArrays, fixed: Array, q: Array, R: Array, p: Array) -> None:
    """Pose of the arm's foot in `base`: the joints before the arm, with `fixed` (arm_start + 1, 4, 4) around them."""
    for r in range(3):
        p[r] = fixed[0, r, 3]
        for c in range(3):
            R[r, c] = fixed[0, r, c]
    for i in range(chain.arm_start):
        move_joint(R, p, chain.prismatic[i], q[i])
        compose(R, p, fixed[i + 1])
