"""Postures of an arm whose fourth and fifth axes meet, wherever the sixth lies: wrists with an offset (FANUC CRX, Yaskawa HC10).

Once the sixth angle is known, so is where the point in which axes 4 and 5 meet has to come to, and the first three axes take it
there as they do a wrist (four ways at most). What is left, that the two turn by the rest, is one equation in the sixth
angle for each way. Its roots are bracketed at even steps and closed in on: a pair nearer to each other than a step, between
which the arm is singular, may be missed, so that what is not found is not proved to be none.

A root at which the equation falls and one at which it rises have determinants of opposite signs, and each way has a row for
either; of several of a kind (such arms have up to sixteen postures) the row holds the one whose sixth angle is nearest to the
one that it is asked near to.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import part
from camrob.kinematics.subproblems import dot, rotate, turn_between
from camrob.kinematics.three_axes import closest, first_three

__all__ = ["by_offset"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_STEPS = 60  # round the sixth angle
_CLOSINGS = 12  # evaluations between two steps; Newton's method on the whole arm does the rest
_CLOSE = 1e-9  # of the equation
_HALVINGS = 10  # of a step in which a way begins or ends


@part
def _rest(
    h: Array, o: Array, M: Array, p: Array, meet: Array, angle: float, three: Array, some: Ints, left: Array
) -> None:
    """three (4, 3), some, left (4,) <- the ways to take the point there with the sixth angle given, which there are, and what
    each leaves over.
    """
    x, y, target = np.empty(3), np.empty(3), np.empty(3)
    c, s = np.cos(angle), np.sin(angle)
    for r in range(3):
        x[r] = meet[r] - o[5, r]
    rotate(h[5], c, -s, x, x)
    for r in range(3):
        x[r] += o[5, r]
    for r in range(3):
        target[r] = p[r] + M[r, 0] * x[0] + M[r, 1] * x[1] + M[r, 2] * x[2]
    first_three(h, o, meet, target, three, some)
    rotate(h[5], c, -s, h[4], x)
    for r in range(3):
        y[r] = M[r, 0] * x[0] + M[r, 1] * x[1] + M[r, 2] * x[2]
    for k in range(4):
        if some[k]:
            for r in range(3):
                x[r] = h[3, r]
            for i in range(2, -1, -1):
                rotate(h[i], np.cos(three[k, i]), np.sin(three[k, i]), x, x)
            left[k] = dot(x, y) - dot(h[3], h[4])


@part
def _write(h: Array, M: Array, three: Array, angle: float, row: Array) -> None:
    """row (6,) <- the posture of one way, of its first three angles and the sixth."""
    v, w = np.empty(3), np.empty(3)
    rotate(h[5], np.cos(angle), -np.sin(angle), h[4], w)
    for r in range(3):
        v[r] = M[r, 0] * w[0] + M[r, 1] * w[1] + M[r, 2] * w[2]
    for r in range(3):
        w[r] = h[3, r]
    for i in range(3):
        rotate(h[i], np.cos(three[i]), -np.sin(three[i]), v, v)
    for i in range(2, -1, -1):
        rotate(h[i], np.cos(three[i]), np.sin(three[i]), w, w)
    row[3] = turn_between(h[3], h[4], v)
    for r in range(3):
        v[r] = M[0, r] * w[0] + M[1, r] * w[1] + M[2, r] * w[2]
    rotate(h[5], np.cos(angle), np.sin(angle), v, v)
    row[4] = turn_between(h[4], v, h[3])
    for i in range(3):
        row[i] = three[i]
    row[5] = angle


@part
def by_offset(h: Array, o: Array, M: Array, p: Array, near: Array, Q: Array, there: Ints) -> None:
    """Rows of Q (8, 6) <- postures of an arm whose axes 4 and 5 meet, that displace by M, p; there (8,): 1 at those."""
    meet, three, some = np.empty(3), np.empty((4, 3)), np.empty(4, np.int64)
    closest(h, o, 3, 4, meet)
    left, is_there, step, apart = (
        np.zeros((_STEPS + 2, 4)),
        np.zeros((_STEPS + 2, 4)),
        2.0 * np.pi / _STEPS,
        np.full(8, np.inf),
    )
    start, rest = near[5] - np.pi, np.zeros(4)
    for n in range(_STEPS + 2):  # one more than a turn
        _rest(h, o, M, p, meet, start + (n % _STEPS) * step, three, some, rest)
        for k in range(4):
            left[n, k], is_there[n, k] = rest[k], some[k]
    for n in range(_STEPS):
        for k in range(4):
            low, high, f, g = start + n * step, start + (n + 1) * step, left[n, k], left[n + 1, k]
            if is_there[n, k] and is_there[n + 1, k]:
                if (f > 0.0) != (g > 0.0):
                    _root(h, o, M, p, meet, k, low, high, f, g, near[5], three, some, apart, Q, there)
                elif is_there[n + 2, k] and (g - f) * g < 0.0 and (left[n + 2, k] - g) * g > 0.0:
                    # nearest to nothing here: a parabola's peak may lie beyond
                    bend = left[n + 2, k] - 2.0 * g + f
                    peak = high - 0.5 * step * (left[n + 2, k] - f) / bend
                    _rest(h, o, M, p, meet, peak, three, some, rest)
                    top = rest[k]
                    if some[k] and (top > 0.0) != (g > 0.0):
                        end = high + step
                        _root(h, o, M, p, meet, k, low, peak, f, top, near[5], three, some, apart, Q, there)
                        _root(
                            h, o, M, p, meet, k, peak, end, top, left[n + 2, k], near[5], three, some, apart, Q, there
                        )
            elif is_there[n, k] or is_there[n + 1, k]:
                inside, outside, f = (low, high, f) if is_there[n, k] else (high, low, g)
                for _halving in range(_HALVINGS):  # up to where the way begins or ends
                    middle = 0.5 * (inside + outside)
                    _rest(h, o, M, p, meet, middle, three, some, rest)
                    if not some[k]:
                        outside = middle
                        continue
                    g = rest[k]
                    if (f > 0.0) != (g > 0.0):
                        if inside < middle:
                            _root(h, o, M, p, meet, k, inside, middle, f, g, near[5], three, some, apart, Q, there)
                        else:
                            _root(h, o, M, p, meet, k, middle, inside, g, f, near[5], three, some, apart, Q, there)
                    inside, f = middle, g


@part
def _root(
    h: Array, o: Array, M: Array, p: Array, meet: Array, k: int, low: float, high: float, f_low: float, f_high: float,
    near: float, three: Array, some: Ints, apart: Array, Q: Array, there: Ints,
) -> None:  # fmt: skip
    """Write the posture of way k whose sixth angle lies between two, at which the equation has opposite signs (Illinois), where
    it is nearer than what its row holds.
    """
    row = 2 * k + (1 if f_high > 0.0 else 0)
    if max(low - near, near - high) > apart[row]:
        return
    rest, angle = np.zeros(4), low
    for _closing in range(_CLOSINGS):
        angle = high - f_high * (high - low) / (f_high - f_low)
        _rest(h, o, M, p, meet, angle, three, some, rest)
        if not some[k]:
            return
        if abs(rest[k]) < _CLOSE:
            break
        if (rest[k] > 0.0) == (f_high > 0.0):
            high, f_high, f_low = angle, rest[k], 0.5 * f_low
        else:
            low, f_low, high, f_high = high, f_high, angle, rest[k]
    if abs(angle - near) < apart[row]:
        apart[row], there[row] = abs(angle - near), 1
        _write(h, M, three[k], angle, Q[row])
