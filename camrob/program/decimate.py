"""Leaving out points that a straight motion passes anyway."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.triples import between, cross, dot, gap2

__all__ = ["decimated"]

Array = NDArray[np.float64]

AXIS_TOLERANCE = 8.7e-5  # rad (0.005 degrees) that the tool axis may leave its great arc: half of what verify allows
EXTERNAL_TOLERANCE = 1e-3  # rad, m that an external axis may leave its straight line: it moves the arm, not the tool


@part
def _passes(
    p: Array, z: Array, e: Array, start: int, trial: int, tolerance: float, turn: float, external: float
) -> bool:
    """Whether a straight motion from point `start` to `trial` passes all between, in order and within the tolerances."""
    d, turning = between(p[start], p[trial]), between(z[start], z[trial])
    n2 = dot(d, d)
    last = 0.0
    for k in range(start + 1, trial):
        s = dot(between(p[start], p[k]), d) / n2 if n2 > 0.0 else -1.0
        if not last <= s <= 1.0:
            return False
        last = s
        here = p[start, 0] + s * d[0], p[start, 1] + s * d[1], p[start, 2] + s * d[2]
        axis = z[start, 0] + s * turning[0], z[start, 1] + s * turning[1], z[start, 2] + s * turning[2]
        across = cross(axis, z[k])
        if gap2(here, p[k]) > tolerance * tolerance or dot(across, across) > turn * turn * dot(axis, axis):
            return False
        for i in range(e.shape[1]):
            if abs(e[start, i] + s * (e[trial, i] - e[start, i]) - e[k, i]) > external:
                return False
    return True


@kernel
def _greedy(
    p: Array,
    z: Array,
    e: Array,
    fixed: NDArray[np.bool_],
    tolerance: float,
    turn: float,
    external: float,
    keep: NDArray[np.bool_],
) -> None:
    """keep <- the points where motions end, each as far on as it may go."""
    N = p.shape[0]
    start = 0
    keep[0] = True
    longest = 500  # points that one motion may stand for, so that the work stays linear
    while start < N - 1:
        end = start + 1
        while end < N - 1 and not fixed[end] and end - start < longest:
            if not _passes(p, z, e, start, end + 1, tolerance, turn, external):
                break
            end += 1
        keep[end] = True
        start = end


def decimated(path: ToolPathInBase, solution: Solution, tolerance: float) -> NDArray[np.bool_]:
    """(N,) True for points to keep, so that every other one lies within `tolerance` (m) of the motion that passes it.

    Points where the feed, the kind of move or the region changes are kept, and all points for a tolerance of 0.
    """
    keep = np.ones(len(path), np.bool_)
    if tolerance <= 0.0 or len(path) < 3:
        return keep
    feed = np.nan_to_num(np.asarray(path.feed))
    fixed = np.ones(len(path), np.bool_)
    same = (path.move[1:-1] == path.move[2:]) & (path.region[1:-1] == path.region[2:]) & (feed[1:-1] == feed[2:])
    same &= (path.move[1:-1] == path.move[:-2]) & (path.region[1:-1] == path.region[:-2])
    fixed[1:-1] = ~same | path.safe[1:-1]
    keep[:] = False
    external = np.asarray(solution.q)[:, :2] if solution.q.shape[1] > 6 else np.zeros((len(path), 0))
    frames = np.asarray(path.base_T_tip)
    _greedy(
        np.ascontiguousarray(frames[:, :3, 3]),
        np.ascontiguousarray(frames[:, :3, 2]),
        np.ascontiguousarray(external),
        fixed,
        tolerance,
        AXIS_TOLERANCE,
        EXTERNAL_TOLERANCE,
        keep,
    )
    return keep
