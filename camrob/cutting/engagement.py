"""How much a tool takes away on its way: the area across each move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.dexels import Dexels, Moves

__all__ = ["removed_area"]

Array = NDArray[np.float64]


def removed_area(stock: Dexels, moves: Moves, *, parts: int = 200) -> Array:
    """(N,) m2 that each of N moves cuts across its way, the mean over the part of the path that it lies in; the stock is left
    as it is.

    parts: of equal length, into which the path is taken apart; each is carved by itself, so that what was cut before is gone.
    """
    left = stock.copy()
    length = np.linalg.norm(moves.tip[:, 1] - moves.tip[:, 0], axis=1)
    reached = np.cumsum(length)
    part = np.minimum((reached / max(reached[-1], 1e-12) * parts).astype(np.int64), parts - 1)
    area = np.zeros(len(length))
    before = _volume(left)
    for k in np.unique(part):
        some = part == k
        left.carve(Moves(moves.tip[some], moves.axis[some], moves.cutter[some], moves.cutters))
        after = _volume(left)
        if length[some].sum() > 0.0:
            area[some] = (before - after) / length[some].sum()
        before = after
    return area


def _volume(stock: Dexels) -> float:
    """m3, the mean of what the three directions say."""
    return float(np.mean([stock.volume(d) for d in range(3)]))
