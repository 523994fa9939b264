"""Small dense linear algebra for the solver's inner loop: a QR factorisation of a tall matrix with six columns.

Householder reflections, in place, no allocation. With J^T = Q [R; 0] the first six columns of Q span the joints' task
space and the others its null space, so that one factorisation gives the pseudoinverse step, the null-space basis and
the multipliers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare

__all__ = ["apply_q", "apply_q_transposed", "qr_six", "solve_positive", "solve_r", "solve_r_transposed", "solve_stable"]

Array = NDArray[np.float64]

_CLEAR = 1e-3  # of a matrix's norm, by which its eigenvalues have to clear the imaginary axis


@bare
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


@bare
def _reflect(A: Array, m: int, tau: Array, j: int, x: Array) -> None:
    s = x[j]
    for i in range(j + 1, m):
        s += A[i, j] * x[i]
    s *= tau[j]
    x[j] -= s
    for i in range(j + 1, m):
        x[i] -= s * A[i, j]


@bare
def apply_q(A: Array, m: int, tau: Array, x: Array) -> None:
    """x[:m] <- Q x, in place."""
    for j in range(5, -1, -1):
        _reflect(A, m, tau, j, x)


@bare
def apply_q_transposed(A: Array, m: int, tau: Array, x: Array) -> None:
    """x[:m] <- Q^T x, in place."""
    for j in range(6):
        _reflect(A, m, tau, j, x)


@bare
def solve_r(A: Array, x: Array) -> None:
    """x[:6] <- R^-1 x, in place."""
    for i in range(5, -1, -1):
        s = x[i]
        for k in range(i + 1, 6):
            s -= A[i, k] * x[k]
        x[i] = s / A[i, i]


@bare
def solve_r_transposed(A: Array, x: Array) -> None:
    """x[:6] <- R^-T x, in place."""
    for i in range(6):
        s = x[i]
        for k in range(i):
            s -= A[k, i] * x[k]
        x[i] = s / A[i, i]


@bare
def _stable(h00: float, h11: float, h22: float, minors: float, det: float) -> bool:
    """Whether all eigenvalues of a 3x3 matrix lie right of the imaginary axis (Hurwitz), from its invariants."""
    trace = h00 + h11 + h22
    return bool(trace > 0.0 and det > 0.0 and trace * minors > det)


@bare
def solve_stable(
    h: tuple[float, float, float, float, float, float, float, float, float],
    b: tuple[float, float, float],
    r: int,
    shift: float,
) -> tuple[float, float, float, float]:
    """(M + s I)^-1 b for a matrix M of size r up to 3, by rows in h, and the least s >= shift of a rising row that is stable.

    Stable: the flow x' = -(M + s I) x dies away, which is what keeps a step from climbing. Eigenvalues tell that, whatever
    basis M is written in. Rows and columns from r on don't count.
    """
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = h
    if r < 3:
        a2 = b2 = c0 = c1 = c2 = 0.0
    if r < 2:
        a1 = b0 = b1 = 0.0
    if r < 1:
        a0 = 0.0
    scale = np.sqrt(a0 * a0 + a1 * a1 + a2 * a2 + b0 * b0 + b1 * b1 + b2 * b2 + c0 * c0 + c1 * c1 + c2 * c2)
    scale = max(1e-12, scale)
    d0 = a0 if r > 0 else scale
    d1 = b1 if r > 1 else scale
    d2 = c2 if r > 2 else scale
    margin = _CLEAR * scale
    while True:
        e0, e1, e2 = d0 + shift - margin, d1 + shift - margin, d2 + shift - margin
        m0, m1, m2 = e1 * e2 - b2 * c1, b2 * c0 - b0 * e2, b0 * c1 - e1 * c0
        minors = m0 + (e0 * e2 - a2 * c0) + (e0 * e1 - a1 * b0)
        if _stable(e0, e1, e2, minors, e0 * m0 + a1 * m1 + a2 * m2):
            break
        shift = max(2.0 * shift, 0.05 * scale)
    e0, e1, e2 = d0 + shift, d1 + shift, d2 + shift
    m0, m1, m2 = e1 * e2 - b2 * c1, b2 * c0 - b0 * e2, b0 * c1 - e1 * c0
    k = 1.0 / (e0 * m0 + a1 * m1 + a2 * m2)
    x, y, z = b
    return (
        k * (m0 * x + (a2 * c1 - a1 * e2) * y + (a1 * b2 - a2 * e1) * z),
        k * (m1 * x + (e0 * e2 - a2 * c0) * y + (a2 * b0 - e0 * b2) * z),
        k * (m2 * x + (a1 * c0 - e0 * c1) * y + (e0 * e1 - a1 * b0) * z),
        shift,
    )


@bare
def solve_positive(M: Array, r: int, shift: float, W: Array, x: Array) -> float:
    """x[:r] <- (M + s I)^-1 x, with the least s >= shift of a rising row that makes it stable; returns s.

    M needs not be symmetric. Beyond three rows positive pivots of an elimination without exchanges in W stand for stable.
    """
    if 1 <= r <= 3:
        a, c = min(1, r - 1), min(2, r - 1)  # what lies beyond r is read twice and doesn't count
        h = M[0, 0], M[0, a], M[0, c], M[a, 0], M[a, a], M[a, c], M[c, 0], M[c, a], M[c, c]
        b = x[0], (x[1] if r > 1 else 0.0), (x[2] if r > 2 else 0.0)
        x0, x1, x2, shift = solve_stable(h, b, r, shift)
        found = x0, x1, x2
        for i in range(r):
            x[i] = found[i]
        return float(shift)
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
