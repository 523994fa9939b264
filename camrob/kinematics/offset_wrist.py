"""Postures of an arm whose fourth and fifth axes meet, wherever the sixth lies: wrists with an offset (FANUC CRX, Yaskawa HC10).

Once the sixth angle is known, so is where the point in which axes 4 and 5 meet has to come to, and the first three axes take it
there as they do a wrist (four ways at most). What is left, that the two turn by the rest, is one equation in the sixth
angle for each way. Its roots are bracketed at even steps and closed in on: a pair nearer to each other than a step, between
which the arm is singular, may be missed, so that what is not found is not proved to be none.

A root at which the equation falls and one at which it rises have determinants of opposite signs, and each way has a row for
either; of several of a kind (such arms have up to sixteen postures) the row holds the one whose sixth angle is nearest to the
one that it is asked near to.

Hundreds of sixth angles are tried a pose. Where the first two axes meet or are parallel the four ways are worked out of sines and
cosines, without an angle and without an array made anew; in between `three_axes` finds them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import part
from camrob.kinematics.subproblems import dot, rotate, triple, turn_between
from camrob.kinematics.three_axes import closest, first_three

__all__ = ["by_offset"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_STEPS = 60  # round the sixth angle
_STEP = 2.0 * np.pi / _STEPS
_CLOSINGS = 12  # evaluations between two steps; Newton's method on the whole arm does the rest
_CLOSE = 1e-9  # of the equation
_HALVINGS = 10  # of a step in which a way begins or ends
_MEET = 1e-9  # of the point's reach, within which two axes meet
_REACH_SLACK = 1e-12  # rounding allowed to put a cosine beyond 1


class _Search(NamedTuple):
    """What a pose is sought with: the arm's axes h, o (6, 3), its displacement M (3, 3), p (3,), the point `meet` (3,) of axes 4
    and 5, and what `first_three` makes of these (names as there; apart: `e` and `across` the part of x that it needs across the
    second axis; size: |r|^2, e along the second axis, the first along it, e . e, the first along e).

    coned: 0 where the first two axes neither meet nor are parallel, 1 where they are parallel, 2 where they meet. turns (4, 6):
    cosine and sine of the first three angles of each way; some, left (4,): which ways there are, and what each leaves over. only:
    the row that is wanted, -1 for all. x, y, to, v (3,), three (4, 3): room.
    """

    h: Array
    o: Array
    M: Array
    p: Array
    meet: Array
    o1: Array
    e: Array
    r0: Array
    rc: Array
    rs: Array
    across: Array
    A: Array
    B: Array
    size: Array
    coned: int
    turns: Array
    some: Ints
    left: Array
    only: int
    x: Array
    y: Array
    to: Array
    v: Array
    three: Array


@part
def _search(h: Array, o: Array, M: Array, p: Array, only: int) -> _Search:
    """All that does not depend on the sixth angle."""
    meet, o1, o2, e = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    closest(h, o, 3, 4, meet)
    sine = closest(h, o, 0, 1, o1)
    closest(h, o, 1, 0, o2)
    r0, rc, rs, across = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for r in range(3):
        e[r] = o2[r] - o1[r]
        across[r] = meet[r] - o[2, r]
    along = dot(h[2], across)
    rs[0] = h[2, 1] * across[2] - h[2, 2] * across[1]
    rs[1] = h[2, 2] * across[0] - h[2, 0] * across[2]
    rs[2] = h[2, 0] * across[1] - h[2, 1] * across[0]
    for r in range(3):
        rc[r] = across[r] - along * h[2, r]
        r0[r] = o[2, r] + along * h[2, r] - o2[r]
    size, A, B = np.empty(5), np.zeros(3), np.zeros(3)
    size[0], size[1], size[2] = dot(r0, r0) + dot(rc, rc), dot(e, h[1]), dot(h[0], h[1])
    size[3], size[4] = dot(e, e), dot(h[0], e)
    A[1], A[2] = -dot(r0, rc) - size[1] * dot(h[1], rc), -dot(r0, rs) - size[1] * dot(h[1], rs)
    B[1], B[2] = -size[2] * dot(h[1], rc), -size[2] * dot(h[1], rs)
    gap = np.sqrt(size[3])
    coned = 1 if sine == 0.0 else (2 if gap < _MEET * max(np.sqrt(size[0]), gap) else 0)
    for r in range(3):
        across[r] = e[r] - size[1] * h[1, r] if coned == 1 else h[0, r] - size[2] * h[1, r]
    return _Search(
        h, o, M, p, meet, o1, e, r0, rc, rs, across, A, B, size, coned, np.empty((4, 6)), np.zeros(4, np.int64),
        np.zeros(4), only, np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((4, 3)),
    )  # fmt: skip


@part
def _cosines(a: float, b: float, c: float, out: Array) -> bool:
    """out (4,) <- cosine and sine of the two angles of a `cone`, in its order; False where there is none."""
    r = np.sqrt(a * a + b * b)
    if r == 0.0 or abs(c) > r * (1.0 + _REACH_SLACK):
        return False
    cosine = min(1.0, max(-1.0, c / r))
    sine = np.sqrt(1.0 - cosine * cosine)
    a, b = a / r, b / r
    out[0], out[1] = a * cosine - b * sine, b * cosine + a * sine
    out[2], out[3] = a * cosine + b * sine, b * cosine - a * sine
    return True


@part
def _coned(f: _Search) -> None:
    """turns, some <- the ways to take the point to `to` of an arm whose first two axes meet or are parallel."""
    third, second = f.three[0:2].reshape(6), f.three[2:4].reshape(6)
    for k in range(4):
        f.some[k] = 0
    for r in range(3):
        f.to[r] -= f.o1[r]
    h1r0 = dot(f.h[1], f.r0)
    f.A[0] = 0.5 * (dot(f.to, f.to) - f.size[0] - f.size[3]) - f.size[1] * h1r0
    f.B[0] = dot(f.h[0], f.to) - f.size[4] - f.size[2] * h1r0
    one, other = (f.B, f.A) if f.coned == 1 else (f.A, f.B)
    if not _cosines(one[1], one[2], -one[0], third):
        return
    for j in range(2):
        c3, s3 = third[2 * j], third[2 * j + 1]
        for r in range(3):
            f.v[r] = f.r0[r] + f.rc[r] * c3 + f.rs[r] * s3
        wanted = other[0] + other[1] * c3 + other[2] * s3
        if not _cosines(dot(f.across, f.v), triple(f.across, f.h[1], f.v), wanted, second):
            continue
        for i in range(2):
            k, c2, s2 = 2 * j + i, second[2 * i], second[2 * i + 1]
            rotate(f.h[1], c2, s2, f.v, f.y)
            for r in range(3):
                f.y[r] += f.e[r]
            s1 = triple(f.h[0], f.y, f.to)
            c1 = dot(f.y, f.to) - dot(f.h[0], f.y) * dot(f.h[0], f.to)
            long = np.sqrt(c1 * c1 + s1 * s1)
            f.turns[k, 0], f.turns[k, 1] = (c1 / long, s1 / long) if long > 0.0 else (1.0, 0.0)
            f.turns[k, 2], f.turns[k, 3], f.turns[k, 4], f.turns[k, 5] = c2, s2, c3, s3
            f.some[k] = 1


@part
def _rest(f: _Search, angle: float) -> None:
    """turns, some, left <- the ways to take the point there with the sixth angle given, and what each leaves over."""
    h, o, M, x = f.h, f.o, f.M, f.x
    c, s = np.cos(angle), np.sin(angle)
    for r in range(3):
        x[r] = f.meet[r] - o[5, r]
    rotate(h[5], c, -s, x, x)
    for r in range(3):
        x[r] += o[5, r]
    for r in range(3):
        f.to[r] = f.p[r] + M[r, 0] * x[0] + M[r, 1] * x[1] + M[r, 2] * x[2]
    if f.coned:
        _coned(f)
    else:
        first_three(h, o, f.meet, f.to, f.three, f.some)
        for k in range(4):
            for i in range(3):
                if f.some[k]:
                    f.turns[k, 2 * i], f.turns[k, 2 * i + 1] = np.cos(f.three[k, i]), np.sin(f.three[k, i])
    rotate(h[5], c, -s, h[4], x)
    for r in range(3):
        f.y[r] = M[r, 0] * x[0] + M[r, 1] * x[1] + M[r, 2] * x[2]
    turned = dot(h[3], h[4])
    for k in range(4):
        if f.some[k]:
            for r in range(3):
                x[r] = h[3, r]
            for i in range(2, -1, -1):
                rotate(h[i], f.turns[k, 2 * i], f.turns[k, 2 * i + 1], x, x)
            f.left[k] = dot(x, f.y) - turned


@part
def _write(f: _Search, k: int, angle: float, row: Array) -> None:
    """row (6,) <- the posture of way k, of its first three angles and the sixth."""
    h, M, v, w = f.h, f.M, f.v, f.x
    rotate(h[5], np.cos(angle), -np.sin(angle), h[4], w)
    for r in range(3):
        v[r] = M[r, 0] * w[0] + M[r, 1] * w[1] + M[r, 2] * w[2]
    for r in range(3):
        w[r] = h[3, r]
    for i in range(3):
        rotate(h[i], f.turns[k, 2 * i], -f.turns[k, 2 * i + 1], v, v)
    for i in range(2, -1, -1):
        rotate(h[i], f.turns[k, 2 * i], f.turns[k, 2 * i + 1], w, w)
    row[3] = turn_between(h[3], h[4], v)
    for r in range(3):
        v[r] = M[0, r] * w[0] + M[1, r] * w[1] + M[2, r] * w[2]
    rotate(h[5], np.cos(angle), np.sin(angle), v, v)
    row[4] = turn_between(h[4], v, h[3])
    for i in range(3):
        row[i] = np.arctan2(f.turns[k, 2 * i + 1], f.turns[k, 2 * i])
    row[5] = angle


@part
def _look(f: _Search, start: float, n: int, left: Array, ways: Ints) -> None:
    """left, ways (N, 4) <- at row n what the ways of that step leave over, and which there are; -1: not looked at yet."""
    if ways[n, 0] < 0:
        _rest(f, start + n * _STEP)
        for k in range(4):
            left[n, k], ways[n, k] = f.left[k], f.some[k]


@part
def by_offset(h: Array, o: Array, M: Array, p: Array, near: Array, Q: Array, there: Ints, only: int) -> None:
    """Rows of Q (8, 6) <- postures of an arm whose axes 4 and 5 meet, that displace by M, p; there (8,): 1 at those.

    only: the one row that is looked for, from `near` on to both sides until it is found; -1 for all.
    """
    f = _search(h, o, M, p, only)
    left, ways, apart = np.zeros((_STEPS + 3, 4)), np.full((_STEPS + 3, 4), -1), np.full(8, np.inf)
    start = near[5] - np.pi
    for i in range(_STEPS):
        n = _STEPS // 2 + (i // 2 if i % 2 == 0 else -1 - i // 2)
        if only >= 0 and apart[only] <= (i // 2 - 1) * _STEP:
            break
        for m in range(n, n + 3):  # the last two are a turn on
            _look(f, start, m, left, ways)
        for k in range(4):
            if only < 0 or k == only // 2:
                _between(f, k, start + n * _STEP, left[n : n + 3, k], ways[n : n + 3, k], near[5], apart, Q, there)


@part
def _between(
    f: _Search, k: int, low: float, left: Array, ways: Ints, near: float, apart: Array, Q: Array, there: Ints
) -> None:
    """The roots of way k between a step at `low` and the next one; left, ways (3,): there, a step on, and two."""
    high, a, b = low + _STEP, left[0], left[1]
    if ways[0] and ways[1]:
        if (a > 0.0) != (b > 0.0):
            _root(f, k, low, high, a, b, near, apart, Q, there)
        elif ways[2] and (b - a) * b < 0.0 and (left[2] - b) * b > 0.0:
            # nearest to nothing here: a parabola's peak may lie beyond
            bend = left[2] - 2.0 * b + a
            peak = high - 0.5 * _STEP * (left[2] - a) / bend
            _rest(f, peak)
            top = f.left[k]
            if f.some[k] and (top > 0.0) != (b > 0.0):
                _root(f, k, low, peak, a, top, near, apart, Q, there)
                _root(f, k, peak, high + _STEP, top, left[2], near, apart, Q, there)
    elif ways[0] or ways[1]:
        inside, outside, a = (low, high, a) if ways[0] else (high, low, b)
        for _halving in range(_HALVINGS):  # up to where the way begins or ends
            middle = 0.5 * (inside + outside)
            _rest(f, middle)
            if not f.some[k]:
                outside = middle
                continue
            b = f.left[k]
            if (a > 0.0) != (b > 0.0):
                if inside < middle:
                    _root(f, k, inside, middle, a, b, near, apart, Q, there)
                else:
                    _root(f, k, middle, inside, b, a, near, apart, Q, there)
            inside, a = middle, b


@part
def _root(
    f: _Search, k: int, low: float, high: float, f_low: float, f_high: float, near: float, apart: Array, Q: Array,
    there: Ints,
) -> None:  # fmt: skip
    """Write the posture of way k whose sixth angle lies between two, at which the equation has opposite signs (Illinois), where
    it is nearer than what its row holds.
    """
    row = 2 * k + (1 if f_high > 0.0 else 0)
    if (f.only >= 0 and row != f.only) or max(low - near, near - high) > apart[row]:
        return
    angle = low
    for _closing in range(_CLOSINGS):
        angle = high - f_high * (high - low) / (f_high - f_low)
        _rest(f, angle)
        if not f.some[k]:
            return
        if abs(f.left[k]) < _CLOSE:
            break
        if (f.left[k] > 0.0) == (f_high > 0.0):
            high, f_high, f_low = angle, f.left[k], 0.5 * f_low
        else:
            low, f_low, high, f_high = high, f_high, angle, f.left[k]
    if abs(angle - near) < apart[row]:
        apart[row], there[row] = abs(angle - near), 1
        _write(f, k, angle, Q[row])
