"""Displacements that are products of rotations about screw axes: forward, back, and mended by Newton's method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import part
from camrob.kinematics.subproblems import rotate
from camrob.small_matrices import solved

__all__ = ["displace", "polish", "put_back"]

Array = NDArray[np.float64]

_MET = 1e-10  # m and rad within which a pose is met
_ENOUGH = 1e-12  # m and rad at which nothing is left to mend
_STEPS = 12  # of Newton's method
_DAMPING = 1e-14  # m2, rad2: keeps the system regular where two axes are one


@part
def put_back(M: Array, d: Array) -> None:
    """The displacement M (3, 3), d (3,) becomes its inverse."""
    x, y, z = d[0], d[1], d[2]
    for r in range(3):
        d[r] = -(M[0, r] * x + M[1, r] * y + M[2, r] * z)
    for r in range(3):
        for c in range(r):
            M[r, c], M[c, r] = M[c, r], M[r, c]


@part
def displace(h: Array, o: Array, q: Array, R: Array, p: Array, Z: Array, P: Array) -> None:
    """R (3, 3), p (3,) <- the displacement by angles q (n,) about axes h, o (n, 3); Z, P (n, 3): where the axes come to lie."""
    x = np.empty(3)
    for r in range(3):
        p[r] = 0.0
        for c in range(3):
            R[r, c] = 1.0 if r == c else 0.0
    for i in range(h.shape[0]):
        for r in range(3):
            Z[i, r] = R[r, 0] * h[i, 0] + R[r, 1] * h[i, 1] + R[r, 2] * h[i, 2]
            P[i, r] = R[r, 0] * o[i, 0] + R[r, 1] * o[i, 1] + R[r, 2] * o[i, 2] + p[r]
        c, s = np.cos(q[i]), np.sin(q[i])
        # behind what is there already: about the axis where it has come to lie
        for k in range(3):
            for r in range(3):
                x[r] = R[r, k]
            rotate(Z[i], c, s, x, x)
            for r in range(3):
                R[r, k] = x[r]
        for r in range(3):
            x[r] = p[r] - P[i, r]
        rotate(Z[i], c, s, x, x)
        for r in range(3):
            p[r] = x[r] + P[i, r]


@part
def polish(h: Array, o: Array, M: Array, d: Array, q: Array) -> bool:
    """Mend q (6,) until it displaces by M (3, 3), d (3,); False where it is not met."""
    R, p, Z, P = np.empty((3, 3)), np.empty(3), np.empty((6, 3)), np.empty((6, 3))
    J, H, error, step = np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty((6, 1))
    before = np.inf
    for _step in range(_STEPS):
        displace(h, o, q, R, p, Z, P)
        vx = vy = vz = worst = 0.0
        for c in range(3):
            vx += 0.5 * (R[1, c] * M[2, c] - R[2, c] * M[1, c])
            vy += 0.5 * (R[2, c] * M[0, c] - R[0, c] * M[2, c])
            vz += 0.5 * (R[0, c] * M[1, c] - R[1, c] * M[0, c])
            for r in range(3):
                worst = max(worst, abs(R[r, c] - M[r, c]))
        for r in range(3):
            worst = max(worst, abs(d[r] - p[r]))
        if worst < _ENOUGH or (worst < _MET and worst > 0.1 * before):
            return True
        if worst > 1.0 and _step > 2:
            return False
        before = worst
        error[0], error[1], error[2], error[3], error[4], error[5] = d[0] - p[0], d[1] - p[1], d[2] - p[2], vx, vy, vz
        for i in range(6):
            x, y, z = -P[i, 0], -P[i, 1], -P[i, 2]  # rows (v, w) of the displaced origin, which lies at p
            x, y, z = x + p[0], y + p[1], z + p[2]
            J[0, i] = Z[i, 1] * z - Z[i, 2] * y
            J[1, i] = Z[i, 2] * x - Z[i, 0] * z
            J[2, i] = Z[i, 0] * y - Z[i, 1] * x
            J[3, i], J[4, i], J[5, i] = Z[i, 0], Z[i, 1], Z[i, 2]
        for i in range(6):
            step[i, 0] = 0.0
            for r in range(6):
                step[i, 0] += J[r, i] * error[r]
            for k in range(i + 1):
                H[i, k] = 0.0
                for r in range(6):
                    H[i, k] += J[r, i] * J[r, k]
                H[k, i] = H[i, k]
            H[i, i] += _DAMPING
        solved(H, step)
        for i in range(6):
            q[i] += step[i, 0]
    return worst < _MET
