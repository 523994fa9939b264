"""Dynamic programming over candidate postures in layers: the cheapest way through, with re-postures where they are allowed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["Layers", "Way", "cheapest_way"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


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


@part
def _edge(layers: Layers, t: int, j: int, k: int) -> float:
    """Price of the way from node j to node k of layer t, inf where a coordinate would move too far."""
    total = 0.0
    for i in range(layers.x.shape[1]):
        d = layers.x[k, i] - layers.x[j, i]
        if layers.endless[i]:
            d -= 2.0 * np.pi * np.round(d / (2.0 * np.pi))
        d = abs(d)
        if d > layers.window[t, i]:
            return np.inf
        total += layers.rate[t, i] * d + layers.square[t, i] * d * d
        if d > layers.top[t, i]:
            over = d / layers.top[t, i] - 1.0
            total += layers.haste[t] * over * over
    return total


@part
def _arrive(layers: Layers, t: int, leave: Array, arrive: Array, back: Ints) -> None:
    """arrive (K,) <- the cheapest price at which each node of layer t is come to, and back (M,) from where."""
    before, start, stop = layers.offset[t - 1], layers.offset[t], layers.offset[t + 1]
    order = np.argsort(layers.x[before:start, 0])
    column = layers.x[before:start, 0][order]
    width = layers.window[t, 0]
    for k in range(start, stop):
        best = np.inf
        for turn in range(-1, 2):
            if turn != 0 and not layers.endless[0]:
                continue
            place = layers.x[k, 0] + 2.0 * np.pi * turn
            low = np.searchsorted(column, place - width)
            high = np.searchsorted(column, place + width, side="right")
            for i in range(low, high):
                j = before + order[i]
                if leave[j] < best:
                    price = leave[j] + _edge(layers, t, j, k)
                    if price < best:
                        best = price
                        back[k] = j
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
