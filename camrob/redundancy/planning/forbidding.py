"""Postures forbidden along a stretch of a path, because one there touches something or can't be followed.

A posture is known by its features (`posture_features`: the arm's shape, A1 and whole turns apart), and the stretch by its ends
in m of s (`Waypoints.s`): rows (K, 9) of `Objective.blocked`. The lattice's nodes nearer than half of BLOCKED_REACH are taken
out of the search there; farther ones, and what is refined, pay BLOCKED_PRICE.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.objective import BLOCKED_PRICE, BLOCKED_REACH, Objective, posture_features

__all__ = ["FEATURES", "forbidden", "forbidden_price", "marks"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

FEATURES = 7  # numbers of `posture_features`
_SHUT = 0.5  # share of BLOCKED_REACH within which a node of the lattice is taken out
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
