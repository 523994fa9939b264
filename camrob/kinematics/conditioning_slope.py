"""1/k_F of the bare arm with its slope by every joint, compiled: what a Newton step on a criterion with k_F in it needs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare
from camrob.kinematics.kernels import ChainArrays, gram_factor
from camrob.kinematics.spherical_inverse import closed_inverse_kf, homogeneous_inverse

__all__ = ["inverse_kf_within", "kf_and_slope"]

Array = NDArray[np.float64]

_LARGEST = 1e7  # k_F from where on an arm counts as singular


@bare
def kf_and_slope(
    chain: ChainArrays, Z: Array, P: Array, plate: Array, slope: Array, H: Array, G: Array, L: Array
) -> float:
    """k_F (eq. 16) and slope (n,) <- its derivative by q, from the axes that `forward` filled; inf, 0 where singular.

    H, G, L: scratch, at least (6, 6) with a column for every joint of the arm in H and G. The slope of the traces by H is
    contracted with the columns' own derivatives: behind a joint all axes and the plate turn with it, before it the plate moves.
    """
    m, scale = chain.arm_stop - chain.arm_start, 1.0 / chain.length
    for i in range(slope.shape[0]):
        slope[i] = 0.0
    _columns(chain, Z, P, plate, H)
    trace = 0.0
    if chain.spherical:
        for r in range(6):
            for k in range(6):
                trace += H[r, k] * H[r, k]
        inverse_trace = homogeneous_inverse(Z, P, plate, chain.arm_start, chain.wrist, chain.length, L)
        if not trace * inverse_trace < 36.0 * _LARGEST * _LARGEST:
            return np.inf
        _thrice(G, L)
    else:
        trace, inverse_trace = _by_cholesky(H, G, L, m)
        if inverse_trace == np.inf:
            return np.inf
    kf = np.sqrt(trace * inverse_trace) / 6.0
    for r in range(6):
        share = scale if r < 3 else 1.0
        for k in range(m):
            G[r, k] = kf * (H[r, k] / trace - G[r, k] / inverse_trace) * share
    for r in range(3):
        for k in range(m):
            H[r, k] /= scale
    _contract(chain.arm_start, m, H, G, slope)
    return float(kf)


@bare
def _columns(chain: ChainArrays, Z: Array, P: Array, plate: Array, H: Array) -> None:
    """H (6, m) <- the arm's homogeneous Jacobian at `plate`."""
    m, scale = chain.arm_stop - chain.arm_start, 1.0 / chain.length
    for k in range(m):
        i = chain.arm_start + k
        dx, dy, dz = plate[0] - P[i, 0], plate[1] - P[i, 1], plate[2] - P[i, 2]
        H[0, k] = (Z[i, 1] * dz - Z[i, 2] * dy) * scale
        H[1, k] = (Z[i, 2] * dx - Z[i, 0] * dz) * scale
        H[2, k] = (Z[i, 0] * dy - Z[i, 1] * dx) * scale
        for r in range(3):
            H[3 + r, k] = Z[i, r]


@bare
def inverse_kf_within(chain: ChainArrays, Z: Array, P: Array, plate: Array, H: Array, G: Array, L: Array) -> float:
    """1/k_F alone, 0 where the arm is singular, with scratch as `kf_and_slope`'s: nothing is allocated."""
    if chain.spherical:
        return float(closed_inverse_kf(Z, P, plate, chain.arm_start, chain.wrist, chain.length))
    _columns(chain, Z, P, plate, H)
    trace, inverse_trace = _by_cholesky(H, G, L, chain.arm_stop - chain.arm_start)
    return float(6.0 / np.sqrt(trace * inverse_trace))


@bare
def _thrice(G: Array, L: Array) -> None:
    """G <- (L L^T L)^T, with L (6, 6) the inverse of H: the slope of its squared norm by H, over -2."""
    for k in range(6):
        p0 = p1 = p2 = p3 = p4 = p5 = 0.0
        for r in range(6):
            p0 += L[k, r] * L[0, r]
            p1 += L[k, r] * L[1, r]
            p2 += L[k, r] * L[2, r]
            p3 += L[k, r] * L[3, r]
            p4 += L[k, r] * L[4, r]
            p5 += L[k, r] * L[5, r]
        for r in range(6):
            G[r, k] = p0 * L[0, r] + p1 * L[1, r] + p2 * L[2, r] + p3 * L[3, r] + p4 * L[4, r] + p5 * L[5, r]


@bare
def _by_cholesky(H: Array, G: Array, L: Array, m: int) -> tuple[float, float]:
    """G <- (H H^T)^-2 H; the traces of H H^T and of its inverse, inf where it is singular."""
    trace = gram_factor(H, L, m)
    if trace == np.inf:
        return trace, np.inf
    return trace, _inverse_twice(H, G, L, m)


@bare
def _inverse_twice(H: Array, G: Array, L: Array, m: int) -> float:
    """G <- (L L^T)^-2 H; returns the trace of (L L^T)^-1."""
    trace = 0.0
    for c in range(6):  # the inverse of L below its diagonal, kept transposed above the diagonal of L
        x0 = 1.0 / L[c, c]
        trace += x0 * x0
        for r in range(c + 1, 6):
            s = -L[r, c] * x0
            for k in range(c + 1, r):
                s -= L[r, k] * L[c, k]
            L[c, r] = s / L[r, r]
            trace += L[c, r] * L[c, r]
    for k in range(m):
        for r in range(6):
            G[r, k] = H[r, k]
        for _ in range(2):
            for r in range(5, -1, -1):  # G <- L^-1 G
                s = G[r, k] / L[r, r]
                for c in range(r):
                    s += L[c, r] * G[c, k]
                G[r, k] = s
            for r in range(6):  # G <- L^-T G
                s = G[r, k] / L[r, r]
                for c in range(r + 1, 6):
                    s += L[r, c] * G[c, k]
                G[r, k] = s
    return trace


@bare
def _contract(first: int, m: int, H: Array, G: Array, slope: Array) -> None:
    """slope of the arm's joints from the columns (v, z) in H and the slopes by them in G."""
    x = y = z = 0.0
    for j in range(m - 1, -1, -1):
        slope[first + j] = H[3, j] * x + H[4, j] * y + H[5, j] * z
        x += H[1, j] * G[2, j] - H[2, j] * G[1, j] + H[4, j] * G[5, j] - H[5, j] * G[4, j]
        y += H[2, j] * G[0, j] - H[0, j] * G[2, j] + H[5, j] * G[3, j] - H[3, j] * G[5, j]
        z += H[0, j] * G[1, j] - H[1, j] * G[0, j] + H[3, j] * G[4, j] - H[4, j] * G[3, j]
    x = y = z = 0.0
    for j in range(m):
        x += G[1, j] * H[5, j] - G[2, j] * H[4, j]
        y += G[2, j] * H[3, j] - G[0, j] * H[5, j]
        z += G[0, j] * H[4, j] - G[1, j] * H[3, j]
        slope[first + j] += H[0, j] * x + H[1, j] * y + H[2, j] * z
