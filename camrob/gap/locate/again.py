"""Whether what stays at a posture is the same when the arm comes there again.

A gust, a truck in the hall or a tow drawn off a creel is smooth along a path, and so fits functions of posture well on stretches
left out; but at the same posture a minute later it is another one. What follows the posture is not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.discrepancy import normalised
from camrob.gap.evidence.model import some_rows, whole_gap

__all__ = ["not_by_posture"]

Array = NDArray[np.float64]

# of a log; rows that are looked at about each; of another time, that are kept
_MOST_ROWS, _NEIGHBOURS, _KEPT = 1500, 40, 4
# a log's rows by the distance of neighbours in time; share of a log that another time is off
_BESIDE, _APART = 150, 0.04
_SMOOTH = 0.9  # share that neighbours in time show of what is smooth along a path
# share of the axes' own places that such neighbours in posture show: the run comes back to where it was
_COMES_BACK = 0.7
_SAME = 0.4  # of that share, below which what stays is another one there


def not_by_posture(panels: Sequence[Panel], noise: float, axes: Sequence[str]) -> bool:
    """Whether what paths show is smooth along them, comes back to the same postures and is another one there. noise: m, 3-D rms;
    axes: those by which a posture is told from another. False of single poses.
    """
    if any(p.scene.poses for p in panels):
        return False
    energy, beside, there, ways = 0.0, 0.0, 0.0, []
    for p in panels:
        rows = some_rows(p, _MOST_ROWS)
        if len(rows) < 2 * _NEIGHBOURS:
            return False
        gap = whole_gap(p)[rows]
        gap, t, at = gap - gap.mean(axis=0), p.scene.t[rows], normalised(p.scene, axes)[rows]
        own, step = len(rows) * noise**2, max(2, len(rows) // _BESIDE)
        index = np.arange(len(rows))
        middle = 0.5 * (gap[np.maximum(index - step, 0)] + gap[np.minimum(index + step, len(rows) - 1)])
        energy += float(np.sum(gap**2)) - own
        beside += float(np.sum((gap - middle) ** 2)) - 1.5 * own
        centred = at - at.mean(axis=0)
        whole = np.concatenate([gap, centred, centred**2 - np.mean(centred**2, axis=0)], axis=1)
        away = max(_APART * float(np.ptp(t)), 3.0 * float(t[step] - t[0]))
        found = _elsewhen(at, t, whole, away)
        there += float(np.sum((gap - found[:, :3]) ** 2)) - (1.0 + 1.0 / _KEPT) * own
        size = np.sum(whole[:, 3:] ** 2, axis=0)
        moved = size > 1e-9 * size.max()
        ways.append(np.mean(1.0 - np.sum((whole - found)[:, 3:][:, moved] ** 2, axis=0) / size[moved]))
    if energy <= 0.0:
        return False
    by_time, by_posture, ways_back = 1.0 - beside / energy, 1.0 - there / energy, float(np.mean(ways))
    return bool(by_time > _SMOOTH and ways_back > _COMES_BACK and by_posture < _SAME * ways_back)


def _elsewhen(at: Array, t: Array, values: Array, away: float) -> Array:
    """(N, k) the mean of values (N, k) at the nearest postures (N, d) of other times, `away` s and more off; 0 where none is."""
    _, near = cKDTree(at).query(at, k=min(_NEIGHBOURS, len(at)))
    other = np.abs(t[near] - t[:, None]) > away
    taken = other & (np.cumsum(other, axis=1) <= _KEPT)
    total = np.einsum("nk,nkd->nd", taken.astype(float), values[near])
    return np.asarray(total / np.maximum(taken.sum(axis=1), 1)[:, None])
