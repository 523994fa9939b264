"""Matrices of a few rows, in place and without a library: calling one takes longer than the arithmetic. For compiled code."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare, part

__all__ = ["made_positive", "solved"]

Array = NDArray[np.float64]

_SWEEPS = 12  # of Jacobi's method at most; it converges quadratically, and five do for 8 x 8
_TURNED = 1e-30  # share of the diagonal's square below which what lies beside it is nothing


@part
def made_positive(H: Array) -> None:
    """H (F, F), symmetric <- the matrix with the same eigenvectors and the absolute values of its eigenvalues.

    By Jacobi's rotations (Golub, Van Loan, Matrix Computations, 8.5).
    """
    F = H.shape[0]
    V = np.zeros((F, F))
    for i in range(F):
        V[i, i] = 1.0
    for _sweep in range(_SWEEPS):
        beside = along = 0.0
        for i in range(F):
            along += H[i, i] * H[i, i]
            for j in range(i):
                beside += H[i, j] * H[i, j]
        if beside <= _TURNED * along:
            break
        for i in range(F):
            for j in range(i):
                _rotated(H, V, i, j)
    for i in range(F):
        size = abs(H[i, i])
        for j in range(F):
            H[j, i] = size * V[j, i]
    _times_transposed(H, V)


@bare
def _rotated(H: Array, V: Array, i: int, j: int) -> None:
    """H <- J^T H J, V <- V J with the rotation J that makes H[i, j] zero."""
    if H[i, j] == 0.0:
        return
    ratio = (H[j, j] - H[i, i]) / (2.0 * H[i, j])
    t = 1.0 / (abs(ratio) + np.sqrt(ratio * ratio + 1.0))
    if ratio < 0.0:
        t = -t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(H.shape[0]):
        a, b = H[k, i], H[k, j]
        H[k, i], H[k, j] = c * a - s * b, s * a + c * b
    for k in range(H.shape[0]):
        a, b = H[i, k], H[j, k]
        H[i, k], H[j, k] = c * a - s * b, s * a + c * b
    for k in range(H.shape[0]):
        a, b = V[k, i], V[k, j]
        V[k, i], V[k, j] = c * a - s * b, s * a + c * b


@part
def _times_transposed(A: Array, V: Array) -> None:
    """A (F, F) <- A V^T."""
    F = A.shape[0]
    row = np.empty(F)
    for i in range(F):
        for j in range(F):
            row[j] = 0.0
            for k in range(F):
                row[j] += A[i, k] * V[j, k]
        for j in range(F):
            A[i, j] = row[j]


@bare
def solved(A: Array, X: Array) -> float:
    """X (F, K) <- A^-1 X by elimination with pivots; A (F, F) is used up: its diagonal holds the pivots.

    Returns 1 or -1: the determinant of A is that times the product of the pivots. X holds no numbers where a pivot is 0.
    """
    F, K = X.shape
    exchanged = 1.0
    for c in range(F):
        best = c
        for r in range(c + 1, F):
            if abs(A[r, c]) > abs(A[best, c]):
                best = r
        if best != c:
            exchanged = -exchanged
            for k in range(F):
                A[c, k], A[best, k] = A[best, k], A[c, k]
            for k in range(K):
                X[c, k], X[best, k] = X[best, k], X[c, k]
        for r in range(c + 1, F):
            share = A[r, c] / A[c, c]
            for k in range(c + 1, F):
                A[r, k] -= share * A[c, k]
            for k in range(K):
                X[r, k] -= share * X[c, k]
    for c in range(F - 1, -1, -1):
        for k in range(K):
            value = X[c, k]
            for r in range(c + 1, F):
                value -= A[c, r] * X[r, k]
            X[c, k] = value / A[c, c]
    return exchanged
