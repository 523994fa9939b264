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
    stock: Dexels, moves: Moves, holders: Sequence[Sequence[tuple[float, float]]], progress: Share | None = None
) -> Array:
    """(N,) m3 of material that the holder goes through on each of N moves, behind the cutter on the same move; the stock is left
    as it is.

    holders: of each of the moves' cutters the diameter and length (m) of its holder's cylinders, from the cutter's upper end on,
    one above another. What it goes through is gone afterwards, so that a place is counted once. progress: called with the share
    that is carved.
    """
    many, count = max(len(h) for h in holders), len(moves.tip)
    tips, number = [moves.tip], [moves.cutter]
    cutters, own = list(moves.cutters), moves.shape[:, 2]
    for k in range(many):
        up, which = own.copy(), np.full(count, -1)
        for n, holder in enumerate(holders):
            if k < len(holder):
                mine = moves.cutter == n
                up[mine] += sum(length for _, length in holder[:k])
                which[mine] = len(cutters)
                cutters.append(Cutter(0.5 * holder[k][0], 0.0, holder[k][1]))
        tips.append(moves.tip + up[:, None, None] * moves.axis)
        number.append(which)
    turns = Moves(
        np.stack(tips, axis=1).reshape(-1, 2, 3),
        np.repeat(moves.axis, many + 1, axis=0),
        np.stack(number, axis=1).reshape(-1),
        tuple(cutters),
    )
    taken = stock.copy().carve(turns, progress).reshape(count, many + 1)
    return np.asarray(taken[:, 1:].sum(axis=1))
