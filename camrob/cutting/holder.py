"""Where a tool's holder meets the stock, as it is at that moment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, Moves
from camrob.progress import Share

__all__ = ["holder_takes"]

Array = NDArray[np.float64]


def holder_takes(
    stock: Dexels, moves: Moves, holder: Sequence[tuple[float, float]], progress: Share | None = None
) -> Array:
    """(N,) m3 of material that the holder goes through on each of N moves, behind the cutter on the same move; the stock is left
    as it is.

    holder: diameter and length (m) of its cylinders, from the cutter's upper end on, one above another. What it goes through is
    gone afterwards, so that a place is counted once. progress: called with the share that is carved.
    """
    own = moves.shape[:, 2]
    bottoms = np.cumsum([0.0, *(length for _, length in holder)])[:-1]
    tips = [moves.tip, *(moves.tip + (own + h)[:, None, None] * moves.axis for h in bottoms)]
    cylinders = tuple(Cutter(0.5 * diameter, 0.0, length) for diameter, length in holder)
    many, count, first = len(tips), len(moves.tip), len(moves.cutters)
    number = np.tile(np.arange(first - 1, first - 1 + many), (count, 1))
    number[:, 0] = moves.cutter
    turns = Moves(
        np.stack(tips, axis=1).reshape(-1, 2, 3),
        np.repeat(moves.axis, many, axis=0),
        number.reshape(-1),
        (*moves.cutters, *cylinders),
    )
    taken = stock.copy().carve(turns, progress).reshape(count, many)
    return np.asarray(taken[:, 1:].sum(axis=1))
