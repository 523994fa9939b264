"""Fewer points for a picture, chosen so that the picture doesn't change: extremes of curves, corners of paths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["curve_indices", "path_indices"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def curve_indices(y: Array, limit: int) -> Indices:
    """At most `limit` + 2 indices, rising, of a curve y (N,): smallest and largest of each of equal runs, and the ends.

    NaN (a gap) is kept where a run holds nothing else or where it is next to a number, so that gaps stay gaps.
    """
    n = len(y)
    if n <= limit:
        return np.arange(n)
    runs = max(1, limit // 4)
    size = -(-n // runs)
    padded = np.full(size * runs, np.nan)
    padded[:n] = y
    rows = padded.reshape(runs, size)
    gap = np.isnan(rows)
    start = np.arange(runs) * size
    low = np.argmin(np.where(gap, np.inf, rows), axis=1) + start
    high = np.argmax(np.where(gap, -np.inf, rows), axis=1) + start
    first_gap = np.where(gap.any(axis=1), np.argmax(gap, axis=1), 0) + start
    last_gap = np.where(gap.any(axis=1), size - 1 - np.argmax(gap[:, ::-1], axis=1), 0) + start
    picked = np.unique(np.concatenate([low, high, first_gap, last_gap, [0, n - 1]]))
    return picked[picked < n].astype(np.int64)


def path_indices(p: Array, keep: NDArray[np.bool_], limit: int) -> Indices:
    """At most about `limit` indices, rising, of a path p (N, 3): of each of equal runs the first point and the one
    farthest from the line between its ends, and every point of `keep` (N,) as far as it fits.
    """
    n = len(p)
    if n <= limit:
        return np.arange(n)
    runs = max(1, limit // 2)
    size = -(-n // runs)
    index = np.minimum(np.arange(size * runs), n - 1).reshape(runs, size)
    rows = p[index]
    start, chord = rows[:, :1], rows[:, -1:] - rows[:, :1]
    along = np.einsum("rsk,rsk->rs", rows - start, np.broadcast_to(chord, rows.shape))
    length2 = np.maximum(np.einsum("rsk,rsk->rs", chord, chord), 1e-24)
    off = np.linalg.norm(rows - start - (along / length2)[..., None] * chord, axis=-1)
    corner = np.take_along_axis(index, np.argmax(off, axis=1)[:, None], axis=1)[:, 0]
    wanted = np.flatnonzero(keep)
    if len(wanted) > limit:
        wanted = wanted[np.linspace(0, len(wanted) - 1, limit).astype(int)]
    return np.unique(np.concatenate([index[:, 0], corner, wanted, [n - 1]])).astype(np.int64)
