"""Rows that stand far from all others and share where they are: then the place is wrong, and not the reading of each."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial.distance import cdist

from camrob.frozen import locked
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad

__all__ = ["LocalRows", "local_rows"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SAME = deg_to_rad(0.05)  # and m / 1000: postures that differ by less are one
_FEWEST = 4  # postures that share something at the least
_TOGETHER = 3  # of them beside each other, that count
_CHANCE = 1e-3  # that as many stand beside each other by accident, over all that they may share
_DRAWS = 2000  # of as many postures at random, beside which the tool's places are judged
_SEED = 20240
_JITTER = 1e-9  # m: a tree through places that are the same


@dataclass(frozen=True)
class LocalRows:
    """Which rows (N,) of a log are off and share a place: between `low` and `high` of an axis (rad, m), or in a box of the room
    (3,) m of the measured frame, where axis is "". off: (N,) m, what all constants of the chain leave of each row.
    """

    rows: Mask
    axis: str
    low: Array
    high: Array
    off: Array

    def __post_init__(self) -> None:
        for name in ("low", "high", "off"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))
        object.__setattr__(self, "rows", locked(self.rows, dtype=np.bool_, name="rows"))


def local_rows(scene: Scene, wrong: Mask, off: Array) -> LocalRows | None:
    """Of the poses that are `wrong` (N,), those that fill a stretch of one axis or a part of the room where hardly any other
    stands: what is wrong there comes back, as gross readings do not. None where they share nothing. off: (N,) m.

    Along an axis the runs of such postures are counted (Wald and Wolfowitz, Ann. Math. Stat. 11, 1940, 147); over the tool's
    places, the pairs that the shortest tree through all joins (Friedman and Rafsky, Ann. Stat. 7, 1979, 697).
    """
    _, first, which = np.unique(np.round(scene.link / _SAME), axis=0, return_index=True, return_inverse=True)
    count = len(first)
    once = np.bincount(which.ravel(), wrong, count) > 0.5 * np.bincount(which.ravel(), minlength=count)
    if not _FEWEST <= once.sum() <= count // 2:
        return None
    moved = [(a, x) for a, x in zip(scene.axes, scene.link.T, strict=True) if np.ptp(x) > _SAME]
    found = [(a, x[:, None], _along(x[first], once, len(moved))) for a, x in moved]
    found.append(("", scene.nominal[:, :3, 3], _over(scene.nominal[first, :3, 3], once)))
    best, least = None, len(once)
    for axis, values, together in found:
        if not together.any():
            continue
        low, high = values[first][together].min(axis=0), values[first][together].max(axis=0)
        inside = ((values >= low) & (values <= high)).all(axis=1)
        strange = int(np.sum(inside[first] != once))
        if strange < least:
            best, least = LocalRows(wrong & inside, axis, low, high, off), strange
    return best


def _along(values: Array, wrong: Mask, tries: int) -> Mask:
    """(n,) which postures stand together along one axis, by its values (n,); none where that may be chance."""
    order = np.argsort(values, kind="stable")
    own = wrong[order]
    starts = own & ~np.r_[False, own[:-1]]
    n, k = len(own), int(own.sum())
    fewer = sum(comb(k - 1, r - 1) * comb(n - k + 1, r) for r in range(1, int(starts.sum()) + 1))
    out = np.zeros(n, bool)
    if tries * fewer < _CHANCE * comb(n, k):
        run = np.cumsum(starts) * own
        out[order] = own & (np.bincount(run)[run] >= _TOGETHER)
    return out


def _over(places: Array, wrong: Mask) -> Mask:
    """(n,) which postures stand together in the room, by the tool's places (n, 3) m; none where that may be chance."""
    tree = minimum_spanning_tree(cdist(places, places) + _JITTER).tocoo()
    a, b = tree.row, tree.col
    both = wrong[a] & wrong[b]
    rng = np.random.default_rng(_SEED)
    drawn = [rng.permutation(wrong) for _ in range(_DRAWS)]
    if max(int(np.sum(d[a] & d[b])) for d in drawn) >= both.sum():
        return np.zeros(len(wrong), bool)
    joined = np.zeros((len(wrong), len(wrong)))
    joined[a[both], b[both]] = 1.0
    piece = connected_components(joined, directed=False)[1]
    return np.asarray(wrong & (np.bincount(piece)[piece] >= _TOGETHER))
