"""Where along a path the cutter may touch the part, and where it moves through air."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["AirRuns", "air_runs"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class AirRuns:
    """A path of postures q (K, n) with points added where an air move leaves the neighbourhood of a cut.

    point: (K,) the given point that each one is, or lies on the way to. free: (K,) True where the motion into the point
    goes through air away from cuts; near: (K,) through air close to where a cut ends or begins.
    """

    q: Array
    point: NDArray[np.int64]
    free: NDArray[np.bool_]
    near: NDArray[np.bool_]


def air_runs(q: Array, tip: Array, cutting: NDArray[np.bool_], distance: float) -> AirRuns:
    """Splits air moves at `distance` (m, along the tip's path) from a cut.

    q: (M, n) postures; tip: (M, 3) the tool's tip in `base`; cutting: (M,) True for points that the tool comes to while
    it cuts.
    """
    count = len(q)
    air = ~cutting
    if count < 2:
        return AirRuns(q, np.arange(count), air, np.zeros(count, bool))
    air[0] = False  # no motion leads to the first point
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(step)])
    edge = np.diff(np.concatenate([[False], air, [False]]).astype(np.int8))
    first, last = np.flatnonzero(edge == 1), np.flatnonzero(edge == -1) - 1  # of the points that a run comes to
    after_cut = cutting[first - 1]
    before_cut = last + 1 < count
    begin = np.where(after_cut, length[first - 1] + distance, -np.inf)  # before it, the run is near
    end = np.where(before_cut, length[last] - distance, np.inf)  # behind it, too
    cuts = np.concatenate([begin[np.isfinite(begin)], end[np.isfinite(end)]])
    runs = np.concatenate([np.flatnonzero(np.isfinite(begin)), np.flatnonzero(np.isfinite(end))])
    within = (cuts > length[first[runs] - 1]) & (cuts < length[last[runs]])
    cuts = np.unique(cuts[within])
    into = np.searchsorted(length, cuts)  # the point whose segment holds the cut
    part = (cuts - length[into - 1]) / (length[into] - length[into - 1])
    inner = (part > 1e-9) & (part < 1.0 - 1e-9)
    into, part, cuts = into[inner], part[inner], cuts[inner]
    added = q[into - 1] + part[:, None] * (q[into] - q[into - 1])
    point = np.insert(np.arange(count), into, into)
    dense_length = np.insert(length, into, cuts)
    run = np.cumsum(edge[:-1] == 1)[point] - 1
    middle = 0.5 * (dense_length + np.concatenate([[0.0], dense_length[:-1]]))
    in_air = air[point]
    close = np.zeros(len(point), bool)
    if len(first):
        mine = np.maximum(run, 0)
        close = in_air & ((middle < begin[mine]) | (middle > end[mine]))
    return AirRuns(np.insert(q, into, added, axis=0), point, in_air & ~close, close)
