"""Dynamic programming over candidate postures in layers: the cheapest way through, with re-postures where they are allowed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare, kernel, part

__all__ = ["Layers", "Way", "cheapest_way"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_SHELVES = 48  # by one coordinate at most: with more of them looking them up takes longer than what lies in them
_ROUNDED = 1.0 + 1e-9  # so that rounding puts no two nodes within a window two shelves apart


class Layers(NamedTuple):
    """Candidates of T layers, one after another.

    offset (T + 1,): nodes of layer t are offset[t] .. offset[t + 1]. x (M, n): coordinates; price (M,): of standing in a
    node. window (T, n): how far each coordinate may move on the way to layer t (the first one, within one turn where it is
    endless, bands the search); rate, square (T, n): the way's price a unit of |dx| and of dx^2; top (T, n): how far a
    coordinate may move without haste; haste (T,): price of (|dx| / top - 1)+^2. endless (n,): coordinates that wrap at a
    turn. jump (T,): price of a re-posture at the layer, inf where there may be none.
    """

    offset: Ints
    x: Array
    price: Array
    window: Array
    rate: Array
    square: Array
    top: Array
    haste: Array
    endless: NDArray[np.bool_]
    jump: Array


class Way(NamedTuple):
    """The cheapest way: nodes that each layer is reached in and left in (T,), -1 beyond `reached` layers; its price.

    Where `reached` < T no candidate of layer `reached` can be come to, and the price is inf.
    """

    arrive: Ints
    leave: Ints
    price: float
    reached: int


@bare
def _apart(one: float, other: float, endless: bool) -> float:
    """How far a coordinate moves from one value to another."""
    d = other - one
    if endless:
        d -= 2.0 * np.pi * np.floor(d / (2.0 * np.pi) + 0.5)
    return float(abs(d))


@bare
def _edge(layers: Layers, t: int, before: Array, j: int, k: int) -> float:
    """Price of the way from row j of `before` (K, n) to node k of layer t, inf where a coordinate would move too far."""
    n = before.shape[1]
    for i in range(n):
        if _apart(before[j, i], layers.x[k, i], layers.endless[i]) > layers.window[t, i]:
            return np.inf
    total = 0.0
    for i in range(n):
        d = _apart(before[j, i], layers.x[k, i], layers.endless[i])
        total += layers.rate[t, i] * d + layers.square[t, i] * d * d
        if d > layers.top[t, i]:
            over = d / layers.top[t, i] - 1.0
            total += layers.haste[t] * over * over
    return total


@bare
def _shelves(layers: Layers, t: int, i: int) -> tuple[float, float, int]:
    """Where the shelves begin that the layer before t is sorted into by coordinate i, how wide each is (no narrower than the
    window), and how many there are.
    """
    if layers.endless[i]:
        low, span = 0.0, 2.0 * np.pi
    else:
        low, high = np.inf, -np.inf
        for j in range(layers.offset[t - 1], layers.offset[t]):
            low, high = min(low, layers.x[j, i]), max(high, layers.x[j, i])
        span = high - low
    width = max(_ROUNDED * layers.window[t, i], span / _SHELVES)
    count = int(span / width) if span > 0.0 and width < span else 1
    return low, (span / count if count > 1 else width), count


@bare
def _shelf(layers: Layers, j: int, i: int, low: float, width: float, count: int) -> int:
    """The shelf of node j by coordinate i; outside the shelves' range the nearest one, but -2 where none is beside it."""
    if count == 1:
        return 0
    at = int(np.floor((layers.x[j, i] - low) / width))
    if layers.endless[i]:
        return at % count
    if at < -1 or at > count + 1:
        return -2
    return min(max(at, 0), count - 1)


@bare
def _beside(layers: Layers, i: int, count: int) -> int:
    """How many shelves to look into: the own one, and those beside it."""
    return min(count, 3) if layers.endless[i] or count == 1 else 3


@bare
def _neighbour(layers: Layers, i: int, count: int, at: int, which: int) -> int:
    """Shelf `at` (which 0), the one after it (1) and the one before it (2); -1 where there is none."""
    shelf = at if which == 0 else at + 3 - 2 * which
    if layers.endless[i]:
        return shelf % count
    return shelf if 0 <= shelf < count else -1


@part
def _arrive(layers: Layers, t: int, leave: Array, arrive: Array, back: Ints) -> None:
    """arrive (K,) <- the cheapest price at which each node of layer t is come to, and back (M,) from where.

    The layer before is sorted into shelves by its first and its last coordinate, each in the order of `leave`: a shelf is looked
    through until what is left of it can't be cheaper, however short the way from there.
    """
    before, start, stop = layers.offset[t - 1], layers.offset[t], layers.offset[t + 1]
    last = layers.x.shape[1] - 1
    low, width, count = _shelves(layers, t, 0)
    low_last, width_last, count_last = _shelves(layers, t, last) if last > 0 else (0.0, 1.0, 1)
    begin = np.zeros(count * count_last + 1, np.int64)
    own = np.empty(start - before, np.int64)
    for j in range(before, start):
        shelf = _shelf(layers, j, 0, low, width, count) * count_last
        own[j - before] = shelf + (_shelf(layers, j, last, low_last, width_last, count_last) if last > 0 else 0)
        begin[own[j - before] + 1] += 1
    for s in range(len(begin) - 1):
        begin[s + 1] += begin[s]
    place, filled = np.empty(start - before, np.int64), begin.copy()
    for r in np.argsort(leave[before:start], kind="mergesort"):
        place[filled[own[r]]] = before + r
        filled[own[r]] += 1
    rows, paid = layers.x[place], leave[place]
    for k in range(start, stop):
        best = np.inf
        at = _shelf(layers, k, 0, low, width, count)
        at_last = _shelf(layers, k, last, low_last, width_last, count_last) if last > 0 else 0
        if at < 0 or at_last < 0:
            arrive[k - start] = best
            continue
        for a in range(_beside(layers, 0, count)):
            one = _neighbour(layers, 0, count, at, a)
            for b in range(_beside(layers, last, count_last)):
                other = _neighbour(layers, last, count_last, at_last, b)
                if one < 0 or other < 0:
                    continue
                shelf = one * count_last + other
                for r in range(begin[shelf], begin[shelf + 1]):
                    if paid[r] >= best:
                        break
                    price = paid[r] + _edge(layers, t, rows, r, k)
                    if price < best:
                        best = price
                        back[k] = place[r]
        arrive[k - start] = best


@kernel(nogil=True)
def cheapest_way(layers: Layers) -> Way:
    """Viterbi's algorithm with banded transitions; memory of two indices a node, time linear in the layers.

    A node's price is paid half on arriving and half on leaving, so that a way and its reverse cost the same.
    """
    T = layers.offset.shape[0] - 1
    M = layers.x.shape[0]
    back = np.full(M, -1, np.int64)  # the node before
    swap = np.full(M, -1, np.int64)  # the node of the same layer that it is re-postured from
    leave = np.full(M, np.inf)
    arrive_at, leave_at = np.full(T, -1, np.int64), np.full(T, -1, np.int64)
    reached = T
    for t in range(T):
        start, stop = layers.offset[t], layers.offset[t + 1]
        cheapest, from_node = np.inf, -1
        arrive = np.full(stop - start, np.inf)
        if t > 0:
            _arrive(layers, t, leave, arrive, back)
        for k in range(start, stop):
            best = arrive[k - start] if t > 0 else 0.0
            arrive[k - start] = best + 0.5 * layers.price[k]
            if arrive[k - start] < cheapest:
                cheapest, from_node = arrive[k - start], k
        if from_node < 0:
            reached = t
            break
        for k in range(start, stop):
            stay = arrive[k - start]
            swap[k] = k
            if cheapest + layers.jump[t] < stay:
                stay = cheapest + layers.jump[t]
                swap[k] = from_node
            leave[k] = stay + 0.5 * layers.price[k]
    if reached == 0:
        return Way(arrive_at, leave_at, np.inf, reached)
    last = reached - 1
    node, best = -1, np.inf
    for k in range(layers.offset[last], layers.offset[last + 1]):
        if leave[k] < best:
            node, best = k, leave[k]
    for t in range(last, -1, -1):
        leave_at[t] = node
        arrive_at[t] = swap[node]
        node = back[swap[node]]
    return Way(arrive_at, leave_at, best if reached == T else np.inf, reached)
