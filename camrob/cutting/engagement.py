"""How much a tool takes away on its way: the area across each move."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.dexels import Dexels, Moves

__all__ = ["carved_area", "removed_area"]

Array = NDArray[np.float64]

_ELSEWHERE = 1e-6  # of the surface on the whole path: counts where a part of it leaves none


def removed_area(stock: Dexels, moves: Moves, *, parts: int = 200) -> Array:
    """(N,) m2 that each of N moves cuts across its way, the mean over the part of the path that it lies in; the stock is left
    as it is. Moves without a cutter are no part of the path.

    parts: of equal length, into which the path is taken apart: a single short move meets too few rays.
    """
    return carved_area(stock.copy(), moves, parts=parts)


def carved_area(stock: Dexels, moves: Moves, *, parts: int = 200) -> Array:
    """As `removed_area`; what is cut is gone from the stock.

    Of a thin layer rays within it tell little, as it lies between two of them or does not, and rays across it all. The surface
    that is left looks across it, too: each direction counts by how many of its rays end there.
    """
    volume, cuts = stock.carve_by_direction(moves), moves.cutter >= 0
    length = np.linalg.norm(moves.tip[:, 1] - moves.tip[:, 0], axis=1) * cuts
    reached = np.cumsum(length)
    part = np.minimum((reached / max(reached[-1], 1e-12) * parts).astype(np.int64), parts - 1)

    def summed(values: NDArray[Any]) -> Array:
        return np.stack([np.bincount(part, weights=v, minlength=parts) for v in values])

    cut, way, ends = summed(volume), summed(length[None])[0], summed(stock.ends_of(len(length)))
    ends += _ELSEWHERE * (ends.sum(axis=1, keepdims=True) + 1.0)
    taken = np.sum(ends * cut, axis=0) / ends.sum(axis=0)
    area = np.divide(taken, way, out=np.zeros(parts), where=way > 0.0)
    return np.asarray(area[part] * cuts)
