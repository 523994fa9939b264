"""Postures forbidden along a stretch of a path, because one there touches something or can't be followed.

A posture is known by its features (`posture_features`: the arm's shape, A1 and whole turns apart), and the stretch by its ends
in m of s (`Waypoints.s`): rows (K, 9) of `Objective.blocked`. The lattice's nodes nearer than half of BLOCKED_REACH are taken
out of the search there; farther ones, and what is refined, pay BLOCKED_PRICE.

And candidates that touch something where they stand, which the search finds out for itself: of the way that it has found it asks
how much room there is, where there is none of all candidates of the layers about, and goes on; so what is nowhere near costs
nothing. In the first and the last layer the way from HOME or back to it counts, too: PTP makes it, with the whole turns that a
posture has.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.layers import Nodes
from camrob.redundancy.planning.objective import BLOCKED_PRICE, BLOCKED_REACH, Objective, posture_features

__all__ = [
    "FEATURES",
    "LOOKS",
    "WANTED",
    "Leads",
    "RoomOf",
    "forbidden",
    "forbidden_price",
    "marks",
    "narrow",
    "room_price",
]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
Leads: TypeAlias = Callable[[Array, bool, float], Array]
"""leads(q, last, wanted): the room (K,), m, as far as it is below `wanted`, on a way by PTP from HOME to postures
(K, n) of a path's first point, or (last) from those of its last one to where it goes on.
"""


class RoomOf(NamedTuple):
    """at(u, q): the room (M,), m, that the bodies have with freedoms u (M, F) and the arm in q (M, 6), as far as it is below
    WANTED; led(u, q, last): on the way to such postures of the first layer, or from those of the last one.
    """

    at: Callable[[Array, Array], Array]
    led: Callable[[Array, Array, bool], Array]


WANTED = 0.01
"""m: less room than that has its price, and less than a tenth of it is none."""
LOOKS = 8
"""How often a search asks for the room of what it has found: each time of layers twice as far about."""
FEATURES = 7  # numbers of `posture_features`
_SHUT = 0.5  # share of BLOCKED_REACH within which a node of the lattice is taken out
_NONE = 0.9  # share of WANTED that is missing where there is none
_ASKED = 16  # ways from and to HOME at a look
_ALIKE = 0.4  # rad and m within which postures go the same way from HOME
_MOST = 64  # marks that one plan's touches make; what is beyond them is found in the next round


def forbidden(objective: Objective, s: Array) -> Mask:
    """(W, K): which of the forbidden postures hold at places s (W,)."""
    begin, end = objective.blocked[:, FEATURES], objective.blocked[:, FEATURES + 1]
    return np.ascontiguousarray((s[:, None] >= begin) & (s[:, None] <= end))


def forbidden_price(objective: Objective, offset: Ints, q: Array, s: Array) -> Array:
    """What being forbidden adds to the price of a metre in each of a lattice's postures q (M, 6); inf: taken out.

    offset (T + 1,): where its layers begin, which are at places s (T,).
    """
    out = np.zeros(len(q))
    here = forbidden(objective, s)
    for t in np.flatnonzero(here.any(axis=1)):
        rows = slice(int(offset[t]), int(offset[t + 1]))
        feature = np.array([posture_features(objective.wrist_zero, one) for one in q[rows]]).reshape(-1, FEATURES)
        for mark in objective.blocked[here[t], :FEATURES]:
            far = np.linalg.norm(feature - mark, axis=1) / BLOCKED_REACH
            out[rows] += np.where(far < _SHUT, np.inf, BLOCKED_PRICE * np.maximum(1.0 - far, 0.0) ** 2)
    return out


def room_price(nodes: Nodes) -> Array:
    """What little room adds to the price of a metre in each candidate (M,); inf: taken out, as it touches. A layer of which
    nothing would be left keeps all: the whole plan tells what touches there.
    """
    near = np.nan_to_num(np.maximum(1.0 - nodes.room / WANTED, 0.0), nan=0.0)
    price = np.where(near > _NONE, np.inf, BLOCKED_PRICE * near * near)
    layer = np.repeat(np.arange(len(nodes.offset) - 1), np.diff(nodes.offset))
    left = np.bincount(layer, np.isfinite(price), len(nodes.offset) - 1) > 0
    return np.where(left[layer], price, 0.0)


def narrow(nodes: Nodes, way: Ints, room_of: RoomOf, about: int) -> bool:
    """Whether candidates on a way through the lattice, indices (K,), have less room than WANTED and weren't known to; then that
    of all candidates up to `about` layers from those is known.
    """
    unknown = way[np.isnan(nodes.room[way])]
    _look(nodes, unknown, room_of)
    found = unknown[nodes.room[unknown] < WANTED]
    if not len(found):
        return False
    layer = np.searchsorted(nodes.offset, found, side="right") - 1
    last = len(nodes.offset) - 2
    layers = np.unique(np.clip(layer[:, None] + np.arange(-about, about + 1), 0, last))
    _look(nodes, np.concatenate([np.arange(nodes.offset[t], nodes.offset[t + 1]) for t in layers]), room_of)
    return True


def _look(nodes: Nodes, some: Ints, room_of: RoomOf) -> None:
    """Fill in the room of some candidates; those that differ by whole turns stand alike."""
    some = some[np.isnan(nodes.room[some])]
    if not len(some):
        return
    turned = np.concatenate([nodes.u[some], np.cos(nodes.q[some]), np.sin(nodes.q[some])], axis=1)
    _rows, first, alike = np.unique(np.round(turned, 9), axis=0, return_index=True, return_inverse=True)
    nodes.room[some] = room_of.at(nodes.u[some[first]], nodes.q[some[first]])[alike.ravel()]
    ends = ((some[some < nodes.offset[1]], False), (some[some >= nodes.offset[-2]], True))
    for end, last in ends:
        _look_at_leads(nodes, end[nodes.room[end] > 0.0], room_of, last)


def _look_at_leads(nodes: Nodes, some: Ints, room_of: RoomOf, last: bool) -> None:
    """What the ways from and to HOME leave of the room of candidates of one layer: the cheapest of those that are nearly alike is
    asked for, and stands for them all. The dear ones stay unknown, to be asked for where the search comes to them.
    """
    left = some[np.argsort(nodes.price[some], kind="stable")]
    whole = np.concatenate([nodes.u, nodes.q], axis=1)
    for _asked in range(_ASKED):
        if not len(left):
            return
        alike = np.abs(whole[left] - whole[left[0]]).max(axis=1) < _ALIKE
        found = float(room_of.led(nodes.u[left[:1]], nodes.q[left[:1]], last)[0])
        nodes.room[left[alike]] = np.minimum(nodes.room[left[alike]], found)
        left = left[~alike]
    nodes.room[left] = np.nan


def marks(wrist_zero: float, q: Array, s: Array, pad: float) -> Array:
    """Rows (K, 9) that forbid postures q (N, 6) at places s (N,), increasing, and `pad` m of s to either side.

    Touches that look alike become one mark for as long as they follow each other within `pad`.
    """
    out: list[Array] = []
    for posture, place in zip(np.ascontiguousarray(q), s, strict=True):
        feature = posture_features(wrist_zero, posture)
        for mark in out:
            if np.linalg.norm(mark[:FEATURES] - feature) < 0.5 * BLOCKED_REACH and place - pad <= mark[-1]:
                mark[-1] = max(mark[-1], place + pad)
                break
        else:
            if len(out) < _MOST:
                out.append(np.array([*feature, place - pad, place + pad]))
    return np.array(out).reshape(-1, FEATURES + 2)
