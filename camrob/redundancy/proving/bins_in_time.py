"""Bins of tools seen alike and the planes below their prices, as many as there is time for; the rest keep what wider bins say."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.objective import Objective
from camrob.redundancy.proving.arm_shape import ArmShape
from camrob.redundancy.proving.bin_prices import planes_of_bins
from camrob.redundancy.proving.seen_bins import Bins, lies_within

__all__ = ["Priced", "merged", "priced_in_time"]

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

_AT_ONCE, _THREADS = 100, 2  # bins of a thread between two looks at the clock: about a second


class Priced(NamedTuple):
    """B bins with planes below their prices: frame (B, 3, 3), box (B, 2, 5) as of `Bins`; cap (B,): 1/k_F up to which postures
    are passed over; offset (B + 1,) into planes (P, 5), middle and slopes a half box.
    """

    frame: Array
    box: Array
    cap: Array
    offset: Ints
    planes: Array

    def take(self, some: Ints) -> Priced:
        """Those bins alone."""
        offset, row = (
            self.offset,
            np.concatenate([np.arange(self.offset[b], self.offset[b + 1]) for b in some] or [np.zeros(0, np.int64)]),
        )
        count = np.diff(offset)[some]
        return Priced(
            self.frame[some], self.box[some], self.cap[some], np.append(0, np.cumsum(count)), self.planes[row]
        )

    def beside(self, other: Priced) -> Priced:
        """These bins, and others behind them."""
        offset = np.concatenate([self.offset, self.offset[-1] + other.offset[1:]])
        frame, box, cap, planes = (
            np.concatenate([getattr(self, name), getattr(other, name)]) for name in ("frame", "box", "cap", "planes")
        )
        return Priced(frame, box, cap, offset, planes)


def priced_in_time(
    shape: ArmShape,
    objective: Objective,
    bins: Bins,
    cap: Array,
    order: Ints,
    effort: tuple[float, int],
    over: Callable[[float], bool],
) -> tuple[Priced, Bools]:
    """Planes of bins, worked out in an order (B,) until over(share that is done); the others get one level plane each, at the
    least that any posture costs. Which (B,) were worked out. effort: half of the least piece of the roll, and the boxes that a
    rough piece is worth.
    """
    least = np.array([[objective.threshold**objective.power, 0.0, 0.0, 0.0, 0.0]])
    found: list[Array] = [least] * len(order)
    told = np.zeros(len(order), np.bool_)

    def work(now: Ints) -> tuple[Ints, Array]:
        offset, planes = planes_of_bins(
            shape, objective.power, objective.threshold, bins.frame[now], bins.box[now], cap[now], *effort
        )
        return offset, planes

    with ThreadPoolExecutor(_THREADS) as pool:  # the kernel releases the interpreter's lock
        for begin in range(0, len(order), _AT_ONCE * _THREADS):
            if over(begin / len(order)):
                break
            parts = [order[begin + _AT_ONCE * i : begin + _AT_ONCE * (i + 1)] for i in range(_THREADS)]
            for now, (offset, planes) in zip(parts, pool.map(work, parts), strict=True):
                told[now] = True
                for i, b in enumerate(now):
                    found[b] = planes[offset[i] : offset[i + 1]]
    offset = np.cumsum([0, *(len(p) for p in found)])
    return Priced(bins.frame, bins.box, cap, offset, np.concatenate([*found, least[:0]])), told


def merged(seen: Array, own: Ints, new: Priced, told: Bools, before: Priced, parent: Ints) -> tuple[Priced, Ints]:
    """Bins of cells seen (M, SEEN, 4), and the one of each: its own (M,) where that was worked out (B,), else the one in which
    the cell that it is a part of lies (parent (M,), -1 for none), if its box holds the part, too.
    """
    from_before = ~told[own] & (parent >= 0)
    asked = np.flatnonzero(from_before)
    from_before[asked] = lies_within(seen[asked], before.frame[parent[asked]], before.box[parent[asked]])
    kept, mine = np.unique(own[~from_before], return_inverse=True)
    older, theirs = np.unique(parent[from_before], return_inverse=True)
    out = np.empty(len(own), np.int64)
    out[~from_before], out[from_before] = mine, len(kept) + theirs
    return new.take(kept).beside(before.take(older)), out
