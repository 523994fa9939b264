"""What a set of effects is worth with one unit more or less, for all units at once.

The posterior of a set gives that of every set that differs in one unit: only the widths of that unit's priors change, so that
the evidence changes by the determinant and the quadratic form of a matrix as small as the unit (matrix determinant lemma).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.small_matrices import solved

__all__ = ["single_changes"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_NO_CHANGE = 1e-12  # of a prior's precision: its unit is as it was


@kernel
def single_changes(
    starts: Ints,
    columns: Ints,
    to: Array,
    widths: Array,
    mean: Array,
    base: Array,
    R: Array,
    scale: Array,
    moves: Array,
) -> tuple[Array, Array]:
    """(U,) by how much the log evidence changes where the priors of one unit get other widths, at the best of S, -inf where it
    can't be told; and (U,) m by which that unit then moves the TCP.

    starts: (U + 1,) where the columns of each unit begin in `columns` (C,); to: (S, C) widths that are tried; widths, mean: (K,)
    of the priors and of the posterior; base, R, scale: the posterior's covariance, see `Spread`; moves: (K, K) mean
    products of what columns move the TCP by.
    """
    count, at = len(starts) - 1, 0
    best, size = np.full(count, -np.inf), np.zeros(count)
    most, more = _grown(starts, columns, R)
    M, step, own = np.empty((most, most)), np.empty((most, 1)), np.empty((most, most))
    for u in range(count):
        first, k = starts[u], starts[u + 1] - starts[u]
        for i in range(k):
            a = columns[first + i]
            for j in range(i + 1):
                b = columns[first + j]
                own[i, j] = (base[a, b] + more[at]) * (scale[a] / widths[a]) * (scale[b] / widths[b])
                own[j, i] = own[i, j]
                at += 1
        for s in range(len(to)):
            changes, half_log, bend = False, 0.0, 0.0
            for i in range(k):
                a = columns[first + i]
                ratio = (widths[a] / to[s, first + i]) ** 2
                change = ratio - 1.0
                changes = changes or abs(change) >= _NO_CHANGE
                half_log += 0.5 * np.log(ratio)
                step[i, 0] = change * mean[a] / widths[a]
                for j in range(k):
                    M[i, j] = change * own[i, j]
                M[i, i] += 1.0
            log_det, positive = _log_determinant(M, solved(M[:k, :k], step[:k]), k)
            if not (changes and positive):
                continue
            for i in range(k):
                bend += mean[columns[first + i]] / widths[columns[first + i]] * step[i, 0]
            gain = -0.5 * bend - 0.5 * log_det + half_log
            if gain > best[u]:
                best[u], size[u] = gain, _moved(columns[first : first + k], own, step, widths, mean, moves)
    return best, size


@part
def _grown(starts: Ints, columns: Ints, R: Array) -> tuple[int, Array]:
    """How many columns a unit has at most; and by how much the covariance of each unit's columns has grown, R.T R, unit after
    unit the lower halves, row after row. R is run through once, along memory.
    """
    most, pairs = 0, 0
    for u in range(len(starts) - 1):
        k = starts[u + 1] - starts[u]
        most, pairs = max(most, k), pairs + k * (k + 1) // 2
    more = np.zeros(pairs)
    for n in range(len(R)):
        at = 0
        for u in range(len(starts) - 1):
            for i in range(starts[u], starts[u + 1]):
                value = R[n, columns[i]]
                for j in range(starts[u], i + 1):
                    more[at] += value * R[n, columns[j]]
                    at += 1
    return most, more


@part
def _log_determinant(pivots: Array, exchanged: float, k: int) -> tuple[float, bool]:
    """The log of the determinant of an eliminated matrix (k, k), from its diagonal, and whether it is positive."""
    log_det, sign = 0.0, exchanged
    for c in range(k):
        if pivots[c, c] == 0.0:
            return 0.0, False
        sign = -sign if pivots[c, c] < 0.0 else sign
        log_det += np.log(abs(pivots[c, c]))
    return log_det, sign > 0.0


@part
def _moved(own_columns: Ints, own: Array, step: Array, widths: Array, mean: Array, moves: Array) -> float:
    """m by which a unit moves the TCP where its mean, in widths of the priors, is less by `own` (k, k) times step (k, 1)."""
    k, energy = len(own_columns), 0.0
    then = np.empty(k)
    for i in range(k):
        at = mean[own_columns[i]] / widths[own_columns[i]]
        for j in range(k):
            at -= own[i, j] * step[j, 0]
        then[i] = at * widths[own_columns[i]]
    for i in range(k):
        for j in range(k):
            energy += then[i] * moves[own_columns[i], own_columns[j]] * then[j]
    return float(np.sqrt(max(energy, 0.0)))
