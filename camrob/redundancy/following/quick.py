"""The follower's quick way: where a path goes on smoothly, the next posture is predicted and one Newton step settles it.

The posture is extrapolated from the last ones, by the order that did best at the point before, and set right by
Newton's method without shift or bound. What comes out counts only if nothing else was called for: no joint at a limit,
a stable posture, self-motion within its bound, and a last step so small that the next one would change nothing. In all
other cases, whichever form h_cond has, the follower goes its long way from the posture before, as if nothing had been tried.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare
from camrob.kinematics.kernels import ChainArrays, forward, jacobian
from camrob.redundancy.following.chain_work import FollowerWork, clear, largest, pose_error
from camrob.redundancy.following.newton_step import (
    FollowerSettings,
    FollowState,
    gradient_and_multipliers,
    inwards,
    self_motion,
    self_share,
    task_step,
)

__all__ = ["History", "history", "predict", "quick_point", "remember"]

Array = NDArray[np.float64]

_QUICK = 4  # forward passes of the quick way at most
_QUICK_FIRST = 0.02  # rad or m that a predicted posture may be off
_QUICK_STEP = 1e-6  # rad or m of a Newton step that the next one is nothing beside
_QUICK_SHARE = 0.9  # of the bound on self-motion that the quick way may use
_TASK_TOLERANCE = 1e-11  # m and rad, as the long way's
_STRAIGHT = 0.8  # cosine between two steps of the path's pose below which it has a corner


class History(NamedTuple):
    """The last postures q (4, n), newest first, and their places t (4,) along the path; guess (4, n): what the orders
    0 to 3 predicted; last (12,): the last step of the pose; known (2,): how many, and the order that did best.
    """

    q: Array
    t: Array
    guess: Array
    last: Array
    known: NDArray[np.int64]


def history(n: int) -> History:
    """A history of nothing, for a chain of n joints."""
    return History(np.zeros((4, n)), np.zeros(4), np.zeros((4, n)), np.zeros(12), np.zeros(2, np.int64))


@bare
def predict(h: History, before: Array, target: Array, length: float, q: Array) -> float:
    """q (n,) <- the posture expected at `target` (4, 4), which comes after the pose `before`. Returns its place t.

    Rotations enter a step's size by the characteristic length. At a corner only the last posture is left.
    """
    square, along, last = 0.0, 0.0, 0.0
    for r in range(3):
        for c in range(4):
            step = (target[r, c] - before[r, c]) * (length if c < 3 else 1.0)
            square += step * step
            along += step * h.last[4 * r + c]
            last += h.last[4 * r + c] * h.last[4 * r + c]
            h.last[4 * r + c] = step
    size = np.sqrt(square)
    if size < 1e-9:
        h.known[0] = 0  # no way to divide by
    elif along < _STRAIGHT * size * np.sqrt(last):
        h.known[0] = min(h.known[0], 1)
    t = h.t[0] + size
    known = h.known[0]
    for order in range(max(1, known)):  # the polynomial through the last order + 1 postures, at t
        for i in range(q.shape[0]):
            h.guess[order, i] = 0.0
        for j in range(order + 1):
            share = 1.0
            for other in range(order + 1):
                if other != j:
                    share *= (t - h.t[other]) / (h.t[j] - h.t[other])
            for i in range(q.shape[0]):
                h.guess[order, i] += share * h.q[j, i]
    order = min(h.known[1], max(0, known - 1))
    for i in range(q.shape[0]):
        q[i] = h.guess[order, i]
    return float(t)


@bare
def remember(h: History, t: float, q: Array) -> None:
    """Put the posture q (n,) found at place t on top of the history, and note which order had predicted it best."""
    known = h.known[0]
    best, h.known[1] = np.inf, 0
    for order in range(max(1, known)):
        worst = 0.0
        for i in range(q.shape[0]):
            worst = max(worst, abs(q[i] - h.guess[order, i]))
        if worst < best:
            best, h.known[1] = worst, order
    for i in range(q.shape[0]):
        h.q[3, i], h.q[2, i], h.q[1, i], h.q[0, i] = h.q[2, i], h.q[1, i], h.q[0, i], q[i]
    h.t[3], h.t[2], h.t[1], h.t[0] = h.t[2], h.t[1], h.t[0], t
    h.known[0] = min(4, known + 1)


@bare
def quick_point(
    chain: ChainArrays,
    settings: FollowerSettings,
    target: Array,
    q: Array,
    q_before: Array,
    q_reference: Array,
    state: FollowState,
    limit: Array,
    w: FollowerWork,
) -> bool:
    """Set the predicted posture q right by Newton's method; True where it is the constrained optimum, beyond doubt."""
    n = q.shape[0]
    acting = state.flags[0] == 1
    multipliers = w.multipliers
    settled = False
    m = 0
    for _ in range(_QUICK):
        for i in range(n):
            if state.side[i] == 0 and not settings.lower[i] < q[i] < settings.upper[i]:
                return False
        forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
        pose_error(w.R, w.p, target[:3, :3], target[:3, 3], w.error)
        if settled:
            return bool(largest(w.error) <= _TASK_TOLERANCE and _within(m, q, q_before, limit, w))
        jacobian(chain, w.Z, w.P, w.p, w.J)
        m = task_step(chain, n, state.side, settings.locked, w)
        if m < 6:
            return False
        gradient_and_multipliers(settings, q, q_reference, state, chain, m, multipliers, w)
        for i in range(n):
            if state.side[i] != 0 and inwards(i, state.side[i], multipliers, 1.0 / chain.length, w):
                return False
        if m > 6:
            if self_motion(chain, settings, m, acting, 0.0, multipliers, True, w) > 0.0:
                return False
        else:
            clear(w.s)
        far = 0.0
        for k in range(m):
            step = w.x[k] + w.s[k]
            q[w.free[k]] += step
            far = max(far, abs(step))
        if not far < _QUICK_FIRST:
            return False
        settled = far <= _QUICK_STEP
    return False


@bare
def _within(m: int, q: Array, q_before: Array, limit: Array, w: FollowerWork) -> bool:
    """Whether the part of the point's motion that is self-motion stays clear of its bound."""
    self_share(m, q, q_before, w)
    for k in range(m):
        if not abs(w.s[k]) <= _QUICK_SHARE * limit[w.free[k]]:
            return False
    return True
