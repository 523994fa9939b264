"""Compiled pieces of geometry that replay and simulation share: great arcs, circles, where the arm's foot stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined
from camrob.frame_steps import compose, move_joint
from camrob.kinematics.kernels import ChainArrays
from camrob.triples import between, cross, dot

__all__ = ["circle", "foot", "rotation_vector", "turned"]

Array = NDArray[np.float64]


@inlined
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
        i = 0
        for r in range(1, 3):
            if m[r, r] > m[i, i]:
                i = r
        norm = np.sqrt(max(1e-12, 0.5 * (1.0 + m[i, i])))
        for r in range(3):
            out[r] = np.pi * (norm if r == i else 0.5 * m[r, i] / norm)


@inlined
def turned(A: Array, w: Array, s: float, out: Array) -> None:
    """out <- A exp(s w)."""
    angle = s * np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-12:
        for r in range(3):
            for col in range(3):
                out[r, col] = A[r, col]
        return
    k = s / angle
    x, y, z = w[0] * k, w[1] * k, w[2] * k
    c, si = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    e00, e01, e02 = c + x * x * t, x * y * t - z * si, x * z * t + y * si
    e10, e11, e12 = y * x * t + z * si, c + y * y * t, y * z * t - x * si
    e20, e21, e22 = z * x * t - y * si, z * y * t + x * si, c + z * z * t
    for r in range(3):
        a, b, d = A[r, 0], A[r, 1], A[r, 2]
        out[r, 0] = a * e00 + b * e10 + d * e20
        out[r, 1] = a * e01 + b * e11 + d * e21
        out[r, 2] = a * e02 + b * e12 + d * e22


@inlined
def circle(a: Array, via: Array, b: Array, center: Array, u: Array, v: Array) -> float:
    """Centre and axes u, v: the arc from a over via to b is centre + cos u + sin v; returns its angle, 0 if flat."""
    ab, ac = between(a, via), between(a, b)
    normal = cross(ab, ac)
    n2 = dot(normal, normal)
    if n2 < 1e-20:
        return 0.0
    to_b, to_via, ab2, ac2 = cross(ac, normal), cross(normal, ab), dot(ab, ab), dot(ac, ac)
    for r in range(3):
        center[r] = a[r] + (ab2 * to_b[r] + ac2 * to_via[r]) / (2.0 * n2)
        u[r] = a[r] - center[r]
    size = np.sqrt(n2)
    v[0], v[1], v[2] = cross((normal[0] / size, normal[1] / size, normal[2] / size), u)
    d = between(center, b)
    angle = np.arctan2(dot(d, v), dot(d, u))
    return float(angle if angle > 0.0 else angle + 2.0 * np.pi)


@inlined
def foot(chain: ChainArrays, fixed: Array, q: Array, R: Array, p: Array) -> None:
    """Pose of the arm's foot in `base`: the joints before the arm, with `fixed` (arm_start + 1, 4, 4) around them."""
    for r in range(3):
        p[r] = fixed[0, r, 3]
        for c in range(3):
            R[r, c] = fixed[0, r, c]
    for i in range(chain.arm_start):
        move_joint(R, p, chain.prismatic[i], q[i])
        compose(R, p, fixed[i + 1])
