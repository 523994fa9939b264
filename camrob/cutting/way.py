"""A densely sampled way of a tool as the few straight moves that it can't be told from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Moves

__all__ = ["Way"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_LONGEST = 400  # rows of one move: what the search for its end may cost


@dataclass(frozen=True, slots=True)
class Way:
    """Moves along a way of N rows. kept: (K + 1,) rows at which moves begin and end; along: (N,) m gone up to each row."""

    moves: Moves
    kept: Ints
    along: Array

    @classmethod
    def of(cls, tip: Array, axis: Array, cutter: Cutter, *, tolerance: float, label: Ints | None = None) -> Way:
        """The moves of a cutter along rows (N, 3) m of its tip and (N, 3) unit vectors from it to the holder.

        tolerance: m that a row's tip, and the cutter's upper end, may lie off their place on the move. label: (N,) a number of
        each row; no move goes on where it changes.
        """
        top = tip + cutter.length * axis
        step = np.linalg.norm(np.diff(tip, axis=0), axis=1) + np.linalg.norm(np.diff(top, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(step)])
        ends = np.zeros(len(tip), np.bool_)
        ends[-1] = True
        if label is not None:
            ends[:-1] = label[1:] != label[:-1]
        kept = np.flatnonzero(_corners(tip, top, along, np.flatnonzero(ends), tolerance))
        return cls(Moves.along(tip[kept], axis[kept], cutter), kept, along)

    def rows(self, move: Ints, at: Array) -> tuple[Ints, Array]:
        """The rows (P,) behind which shares (P,) of moves (P,) lie, and which share of the way to the next row."""
        first, last = self.kept[move], self.kept[move + 1]
        place = self.along[first] * (1.0 - at) + self.along[last] * at
        row = np.clip(np.searchsorted(self.along, place, side="right") - 1, first, last - 1)
        step = self.along[row + 1] - self.along[row]
        share = np.divide(place - self.along[row], step, out=np.zeros(len(row)), where=step > 0.0)
        return row, np.clip(share, 0.0, 1.0)


@kernel
def _corners(tip: Array, top: Array, along: Array, ends: Ints, tolerance: float) -> NDArray[np.bool_]:
    """Rows (N,) that have to be kept: from each, the farthest next one whose rows between lie near their places on the move, and
    no farther than the next of the ends, the last of which is the last row.
    """
    kept = np.zeros(len(tip), np.bool_)
    a, e = 0, 0
    kept[0] = kept[-1] = True
    while a < len(tip) - 1:
        while ends[e] <= a:
            e += 1
        b, far = a + 1, min(ends[e], a + _LONGEST)
        leap = 1
        # twice as far while it holds, then back to the farthest that does
        while b + leap <= far and _straight(tip, top, along, a, b + leap, tolerance):
            b, leap = b + leap, 2 * leap
        while leap > 0:
            if b + leap <= far and _straight(tip, top, along, a, b + leap, tolerance):
                b += leap
            leap //= 2
        kept[b] = True
        a = b
    return kept


@part
def _straight(tip: Array, top: Array, along: Array, a: int, b: int, tolerance: float) -> bool:
    """Whether the rows between a and b lie within the tolerance of where the straight move from a to b has them."""
    long = along[b] - along[a]
    for k in range(a + 1, b):
        t = (along[k] - along[a]) / long if long > 0.0 else 0.0
        for x in (tip, top):
            off = 0.0
            for i in range(3):
                off += (x[k, i] - x[a, i] - t * (x[b, i] - x[a, i])) ** 2
            if math.sqrt(off) > tolerance:
                return False
    return True
