"""Digital filters of low order. `scipy.signal` has them too, but loads for a third of a second, longer than they take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.linalg.lapack import dtbtrs, ztbtrs

__all__ = ["filtered", "sampled"]

Array = NDArray[np.float64]
Signal = TypeVar("Signal", NDArray[np.float64], NDArray[np.complex128])


def filtered(b: Array, a: Array, x: Signal) -> Signal:
    """(N,) or (N, d) of x behind the filter a0 y[n] + a1 y[n - 1] + .. = b0 x[n] + b1 x[n - 1] + .., at rest before it."""
    rows = x.reshape(len(x), -1)
    driven = np.zeros_like(rows)
    for k, part in enumerate(b[: len(rows)]):
        driven[k:] += part * rows[: len(rows) - k]
    # y's equations are triangular, with as many diagonals as the filter is long
    diagonals = np.repeat(np.asarray(a, x.dtype)[:, None], len(rows), axis=1)
    solve = ztbtrs if np.iscomplexobj(x) else dtbtrs
    y, _ = solve(diagonals, driven, uplo="L")
    return np.asarray(y.reshape(x.shape), x.dtype)


def sampled(top: Sequence[float], bottom: Sequence[float], step: float) -> tuple[Array, Array]:
    """The filter's b and a that a system top(s) / bottom(s) is on a clock of so many s, with what drives it held for a step; the
    system is strictly proper, the first of bottom 1.
    """
    n = len(bottom) - 1
    # the system's state, and what drives it, over a step
    over = np.zeros((n + 1, n + 1))
    over[: n - 1, 1:n] = np.eye(n - 1)
    over[n - 1, :n] = -np.asarray(bottom)[:0:-1]
    over[n - 1, n] = 1.0
    whole = expm(step * over)
    A, state = whole[:n, :n], whole[:n, n]
    seen = np.zeros(n)
    seen[: len(top)] = np.asarray(top)[::-1]
    response = [0.0]
    for _ in range(n):
        response.append(float(seen @ state))
        state = A @ state
    a = np.real(np.poly(A))
    return np.convolve(a, response)[: n + 1], a
