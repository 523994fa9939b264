"""Small dense linear algebra for the solver's inner loop: a QR factorisation of a tall matrix with six columns.

Householder reflections, in place, no allocation. With J^T = Q [R; 0] the first six columns of Q span the joints' task
space and the others its null space, so that one factorisation gives the pseudoinverse step, the null-space basis and
the multipliers.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

__all__ = ["apply_q", "apply_q_transposed", "qr_six", "solve_positive", "solve_r", "solve_r_transposed"]

Array = NDArray[np.float64]


@numba.njit(cache=True, forceinline=True)
def qr_six(A: Array, m: int, tau: Array) -> float:
    """Factor A[:m, :6] in place: R above the diagonal, reflectors below it, their factors in tau (6,).

    Returns the smallest ratio of a diagonal element of R to the largest one, 0 where A loses rank.
    """
    least, most = np.inf, 0.0
    for j in range(6):
        norm = 0.0
        for i in range(j, m):
            norm += A[i, j] * A[i, j]
        norm = np.sqrt(norm)
        if norm == 0.0:
            tau[j] = 0.0
            return 0.0
        alpha = -norm if A[j, j] >= 0.0 else norm
        tau[j] = (alpha - A[j, j]) / alpha
        scale = 1.0 / (A[j, j] - alpha)
        A[j, j] = alpha
        for i in range(j + 1, m):
            A[i, j] *= scale
        for k in range(j + 1, 6):
            s = A[j, k]
            for i in range(j + 1, m):
                s += A[i, j] * A[i, k]
            s *= tau[j]
            A[j, k] -= s
            for i in range(j + 1, m):
                A[i, k] -= s * A[i, j]
        least = min(least, norm)
        most = max(most, norm)
    return float(least / most)


@numba.njit(cache=True, forceinline=True)
def _reflect(A: Array, m: int, tau: Array, j: int, x: Array) -> None:
    s = x[j]
    for i in range(j + 1, m):
        s += A[i, j] * x[i]
    s *= tau[j]
    x[j] -= s
    for i in range(j + 1, m):
        x[i] -= s * A[i, j]


@numba.njit(cache=True, forceinline=True)
def apply_q(A: Array, m: int, tau: Array, x: Array) -> None:
    """x[:m] <- Q x, in place."""
    for j in range(5, -1, -1):
        _reflect(A, m, tau, j, x)


@numba.njit(cache=True, forceinline=True)
def apply_q_transposed(A: Array, m: int, tau: Array, x: Array) -> None:
    """x[:m] <- Q^T x, in place."""
    for j in range(6):
        _reflect(A, m, tau, j, x)


@numba.njit(cache=True, forceinline=True)
def solve_r(A: Array, x: Array) -> None:
    """x[:6] <- R^-1 x, in place."""
    for i in range(5, -1, -1):
        s = x[i]
        for k in range(i + 1, 6):
            s -= A[i, k] * x[k]
        x[i] = s / A[i, i]


@numba.njit(cache=True, forceinline=True)
def solve_r_transposed(A: Array, x: Array) -> None:
    """x[:6] <- R^-T x, in place."""
    for i in range(6):
        s = x[i]
        for k in range(i):
            s -= A[k, i] * x[k]
        x[i] = s / A[i, i]


@numba.njit(cache=True, forceinline=True)
def solve_positive(M: Array, r: int, shift: float, W: Array, x: Array) -> float:
    """x[:r] <- (M + s I)^-1 x, with the least s >= shift of a rising row for which every pivot is positive; returns s.

    M needs not be symmetric. Gaussian elimination without exchanges in W: positive pivots mean that the flow
    x' = -(M + s I) x loses volume in every leading subspace, which is what keeps a step from climbing.
    """
    scale = 1e-12
    for i in range(r):
        scale = max(scale, abs(M[i, i]))
    while True:
        good = True
        for i in range(r):
            for j in range(r):
                W[i, j] = M[i, j] + (shift if i == j else 0.0)
        for k in range(r):
            if W[k, k] <= 1e-3 * scale:
                good = False
                break
            for i in range(k + 1, r):
                f = W[i, k] / W[k, k]
                W[i, k] = f
                for j in range(k + 1, r):
                    W[i, j] -= f * W[k, j]
        if good:
            break
        shift = max(2.0 * shift, 0.05 * scale)
    for i in range(r):
        for k in range(i):
            x[i] -= W[i, k] * x[k]
    for i in range(r - 1, -1, -1):
        for k in range(i + 1, r):
            x[i] -= W[i, k] * x[k]
        x[i] /= W[i, i]
    return float(shift)
