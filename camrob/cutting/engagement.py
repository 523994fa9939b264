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

    parts: of equal length, into which the path is taken apart: a single short move meets too few rays.
    """
    volume = stock.copy().carve(moves)
    length = np.linalg.norm(moves.tip[:, 1] - moves.tip[:, 0], axis=1)
    reached = np.cumsum(length)
    part = np.minimum((reached / max(reached[-1], 1e-12) * parts).astype(np.int64), parts - 1)
    cut, way = (np.bincount(part, weights=x, minlength=parts) for x in (volume, length))
    area = np.divide(cut, way, out=np.zeros(parts), where=way > 0.0)
    return np.asarray(area[part])
