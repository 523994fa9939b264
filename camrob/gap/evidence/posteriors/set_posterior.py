"""The posterior of one set of units, from that with every unit out: the widths of its priors that speak best, and what they give.

Letting the priors of n parameters loose is one factorisation as small as they are (Woodbury). With C the covariance with every
unit out, in widths of the narrow priors, and s^2 = 1 - (narrow / wide)^2 of each that is let loose, the covariance grows by
C s (1 - s C s)^-1 s C, which is R.T R.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["effects_moves", "fitted_widths", "let_loose"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_TURNS = 2  # in which widths and values are found in turn
_WIDEST = 5.0  # times the ordinary sizes
_KNOWN = 0.3  # parameters that an effect is taken to be told of at least
_LEAST_PIVOT = 1e-14  # a pivot of what is 1 at the most: rounding may leave less


@kernel
def fitted_widths(
    base: Array, start: Array, scale: Array, usual: Array, effect: Ints, least: Array, own: Ints
) -> tuple[Array, Array]:
    """(K,) widths of the priors where the parameters `own` (n,), effect after effect, are in, and by effect (E,) what they are of
    the ordinary sizes, NaN where they are these.

    base: (K, K), start: (K,) covariance and mean with every unit out, in widths `scale` (K,); usual: (K,) ordinary sizes;
    effect: (K,) number of each parameter's effect, -1 for none; least: (E,) smallest share of the ordinary sizes, NaN for
    effects whose widths are not fitted.
    """
    n = len(own)
    widths, shares = scale.copy(), np.full(len(least), np.nan)
    turns, few = 0, np.empty((n, n + 1))
    for i in range(n):
        widths[own[i]] = usual[own[i]]
        if effect[own[i]] >= 0 and not np.isnan(least[effect[own[i]]]):
            turns = _TURNS
    if turns == 0:
        return widths, shares
    loose, factor = np.empty(n), np.empty((n, n))
    for _ in range(turns):
        _loosened(scale, widths, own, loose)
        for i in range(n):
            for j in range(n):
                few[i, j] = loose[i] * base[own[i], own[j]]
            few[i, n] = loose[i] * start[own[i]]
        _factored(base, own, loose, factor)
        _substituted(factor, few)
        first = 0
        while first < n:
            last = first + 1
            while last < n and effect[own[last]] == effect[own[first]]:
                last += 1
            number = effect[own[first]]
            if number >= 0 and not np.isnan(least[number]):
                known, sizes = 0.0, 0.0
                for j in range(first, last):
                    c = own[j]
                    mean, spread = start[c], base[c, c]
                    for i in range(n):
                        mean += few[i, j] * few[i, n]
                        spread += few[i, j] * few[i, j]
                    known += 1.0 - spread * (scale[c] / widths[c]) ** 2
                    sizes += (mean * scale[c] / usual[c]) ** 2
                share = np.sqrt(sizes / max(known, _KNOWN))
                shares[number] = min(max(share, least[number]), _WIDEST)
                for j in range(first, last):
                    widths[own[j]] = max(shares[number] * usual[own[j]], scale[own[j]])
            first = last
    return widths, shares


@kernel
def let_loose(base: Array, start: Array, scale: Array, own: Ints, widths: Array) -> tuple[Array, Array, float, float]:
    """The posterior at widths (K,) of the priors, which are not `scale` for the parameters `own` (n,) alone.

    The mean (K,), SI; R (n, K) with the covariance (base + R.T R) scale scale.T; by how much the fit gets better, and what the
    determinant costs, both in log units.
    """
    n, K = len(own), len(scale)
    loose, factor, more = np.empty(n), np.empty((n, n)), np.empty((n, K + 1))
    _loosened(scale, widths, own, loose)
    for i in range(n):
        for j in range(K):
            more[i, j] = loose[i] * base[own[i], j]
        more[i, K] = loose[i] * start[own[i]]
    _factored(base, own, loose, factor)
    _substituted(factor, more)
    mean, R, fit, half = start.copy(), np.empty((n, K)), 0.0, 0.0
    for i in range(n):
        for j in range(K):
            R[i, j] = more[i, j]
            mean[j] += more[i, j] * more[i, K]
        fit += 0.5 * more[i, K] ** 2
        half += np.log(factor[i, i]) - np.log(scale[own[i]] / widths[own[i]])
    for j in range(K):
        mean[j] *= scale[j]
    return mean, R, fit, half


@kernel
def effects_moves(
    base: Array, R: Array, scale: Array, mean: Array, moves: Array, effect: Ints, own: Ints, count: int
) -> tuple[Array, Array, float]:
    """By effect (E,) m2 (mean square) by which it moves the TCP, and m4, the variance of half of that; and by how much all of
    them together move it, m2.

    own: (n,) the parameters of a set, effect after effect; base, R, scale: of `let_loose`, as its mean (K,); moves: (K, K) mean
    products of what parameters move the TCP by; effect: (K,) number of each parameter's effect, -1 for none; count: E.
    """
    n = len(own)
    energy, spread, whole = np.zeros(count), np.zeros(count), 0.0
    pull = np.empty(n)
    first = 0
    while first < n:
        last = first + 1
        while last < n and effect[own[last]] == effect[own[first]]:
            last += 1
        number = effect[own[first]]
        if number >= 0:
            for i in range(first, last):
                pull[i] = 0.0
                for j in range(first, last):
                    pull[i] += moves[own[i], own[j]] * mean[own[j]]
                energy[number] += pull[i] * mean[own[i]]
                for j in range(n):
                    if effect[own[j]] >= 0:
                        whole += mean[own[i]] * moves[own[i], own[j]] * mean[own[j]]
                pull[i] *= scale[own[i]]
            for i in range(first, last):
                for j in range(first, last):
                    spread[number] += pull[i] * base[own[i], own[j]] * pull[j]
            for m in range(len(R)):
                along = 0.0
                for i in range(first, last):
                    along += R[m, own[i]] * pull[i]
                spread[number] += along * along
        first = last
    return energy, spread, whole


@part
def _loosened(scale: Array, widths: Array, own: Ints, loose: Array) -> None:
    """loose (n,) <- s of each parameter that is let loose."""
    for i in range(len(own)):
        loose[i] = np.sqrt(max(1.0 - (scale[own[i]] / widths[own[i]]) ** 2, 0.0))


@part
def _factored(base: Array, own: Ints, loose: Array, factor: Array) -> None:
    """factor (n, n) <- the upper Cholesky factor of 1 - s C s, row by row, so that each step runs along memory."""
    n = len(own)
    for i in range(n):
        for j in range(i, n):
            factor[i, j] = -loose[i] * base[own[i], own[j]] * loose[j]
        factor[i, i] += 1.0
    for i in range(n):
        for k in range(i):
            share = factor[k, i]
            for j in range(i, n):
                factor[i, j] -= share * factor[k, j]
        root = np.sqrt(max(factor[i, i], _LEAST_PIVOT))
        for j in range(i, n):
            factor[i, j] /= root


@part
def _substituted(factor: Array, right: Array) -> None:
    """right (n, m) <- the transposed upper factor's inverse, times it."""
    n, m = right.shape
    for i in range(n):
        for k in range(i):
            share = factor[k, i]
            for j in range(m):
                right[i, j] -= share * right[k, j]
        for j in range(m):
            right[i, j] /= factor[i, i]
