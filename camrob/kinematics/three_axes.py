"""Three turning axes that bring a point to a place: at most four ways, each in a row that it keeps while the place moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import part
from camrob.kinematics.subproblems import cone, dot, rotate, triple, turn_between
from camrob.kinematics.trig_quartic import lasting_angles, square_onto

__all__ = ["closest", "first_three"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_MEET = 1e-9  # of the point's reach, within which two axes meet
_SINGULAR = 1e-9  # sine below which two axes are one


@part
def closest(h: Array, o: Array, i: int, j: int, out: Array) -> float:
    """out (3,) <- the point of axis i that is nearest to axis j; returns the sine between them."""
    along = dot(h[i], h[j])
    # of the sine: from the part of one across the other, as 1 - cos^2 is all rounding where they are parallel
    square = 0.0
    for r in range(3):
        part_across = h[j, r] - along * h[i, r]
        square += part_across * part_across
    if square < _SINGULAR * _SINGULAR:
        for r in range(3):
            out[r] = o[i, r]
        return 0.0
    x = y = 0.0
    for r in range(3):
        d = o[j, r] - o[i, r]
        x += d * h[i, r]
        y += d * h[j, r]
    t = (x - along * y) / square
    for r in range(3):
        out[r] = o[i, r] + t * h[i, r]
    return float(np.sqrt(square))


@part
def first_three(h: Array, o: Array, w: Array, t: Array, out: Array, there: Ints) -> None:
    """out (4, 3) <- the angles of axes 1 to 3 that bring the point w to t, there (4,): 1 at the rows that are any.

    The point's distance from a point of the first axis and its height along it are what the first angle can't change.
    """
    o1, o2, e = np.empty(3), np.empty(3), np.empty(3)
    sine = closest(h, o, 0, 1, o1)
    closest(h, o, 1, 0, o2)
    for r in range(3):
        e[r] = o2[r] - o1[r]
    # r = r0 + rc cos + rs sin: from o2 to the point that the third angle has turned
    r0, rc, rs, arm = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for r in range(3):
        arm[r] = w[r] - o[2, r]
    along = dot(h[2], arm)
    for r in range(3):
        rc[r] = arm[r] - along * h[2, r]
        r0[r] = o[2, r] + along * h[2, r] - o2[r]
    rs[0] = h[2, 1] * arm[2] - h[2, 2] * arm[1]
    rs[1] = h[2, 2] * arm[0] - h[2, 0] * arm[2]
    rs[2] = h[2, 0] * arm[1] - h[2, 1] * arm[0]
    k1 = k2 = 0.0
    for r in range(3):
        k1 += (t[r] - o1[r]) * (t[r] - o1[r])
        k2 += h[0, r] * (t[r] - o1[r])
    square = dot(r0, r0) + dot(rc, rc)  # |r|^2 = square + 2 r0.rc cos + 2 r0.rs sin
    height, e_along, g_along = np.empty(3), dot(e, h[1]), dot(h[0], h[1])
    height[0], height[1], height[2] = dot(h[1], r0), dot(h[1], rc), dot(h[1], rs)
    A, B = np.empty(3), np.empty(3)  # e and h1 across the second axis, times the point there: affine in cos and sin
    A[0] = 0.5 * (k1 - square - dot(e, e)) - e_along * height[0]
    A[1] = -dot(r0, rc) - e_along * height[1]
    A[2] = -dot(r0, rs) - e_along * height[2]
    B[0] = k2 - dot(h[0], e) - g_along * height[0]
    B[1], B[2] = -g_along * height[1], -g_along * height[2]
    gap = np.sqrt(dot(e, e))
    reach = max(np.sqrt(square), gap)
    third = np.empty(4)
    for k in range(4):
        there[k] = 0
    meeting, parallel = gap < _MEET * reach, sine == 0.0
    if parallel:
        found = 2 if cone(B[1], B[2], -B[0], third) else 0
    elif meeting:
        found = 2 if cone(A[1], A[2], -A[0], third) else 0
    else:
        found = 4
        # e is across both axes here, so e and h1's part across the second are at right angles: each gives one component
        f = np.zeros(6)
        square_onto(f, 1.0, A[0] / gap, A[1] / gap, A[2] / gap)
        square_onto(f, 1.0, B[0] / sine, B[1] / sine, B[2] / sine)
        square_onto(f, 1.0, height[0], height[1], height[2])
        f[0] -= square
        f[1] -= 2.0 * dot(r0, rc)
        f[2] -= 2.0 * dot(r0, rs)
        lasting_angles(f, np.arctan2(dot(r0, rs), dot(r0, rc)), third, there)  # of the sides of the elbow, stretched
    for r in range(3):
        o2[r] = t[r] - o1[r]
    _first_two(h, e, o2, r0, rc, rs, A, B, third[:found], sine, meeting, out, there)


@part
def _first_two(
    h: Array, e: Array, to: Array, r0: Array, rc: Array, rs: Array, A: Array, B: Array, third: Array, sine: float,
    meeting: bool, out: Array, there: Ints,
) -> None:  # fmt: skip
    """The rest of `first_three`: for each third angle the second and the first; `to`: the point's place from the first axis.

    Where cones do, each third angle has two rows; else there are four of them, each with a row that is there or is not.
    """
    e_along, g_along, gap, parallel = dot(e, h[1]), dot(h[0], h[1]), np.sqrt(dot(e, e)), sine == 0.0
    x_axis, v, y, pair = np.empty(3), np.empty(3), np.empty(3), np.empty(2)
    coned = parallel or meeting
    for k in range(third.shape[0]):
        if not coned and not there[k]:
            continue
        c, s = np.cos(third[k]), np.sin(third[k])
        for r in range(3):
            v[r] = r0[r] + rc[r] * c + rs[r] * s
        a, b = A[0] + A[1] * c + A[2] * s, B[0] + B[1] * c + B[2] * s
        ways, row = 1, k
        if coned:
            for r in range(3):  # across the second axis: e there, or h1
                x_axis[r] = e[r] - e_along * h[1, r] if parallel else h[0, r] - g_along * h[1, r]
            if not cone(dot(x_axis, v), triple(x_axis, h[1], v), a if parallel else b, pair):
                continue
            ways, row = 2, 2 * k
        else:
            for r in range(3):  # where the point is to come to, across the second axis
                y[r] = a / (gap * gap) * e[r] + b / (sine * sine) * (h[0, r] - g_along * h[1, r])
            pair[0] = turn_between(h[1], v, y)
        for i in range(ways):
            rotate(h[1], np.cos(pair[i]), np.sin(pair[i]), v, y)
            for r in range(3):
                y[r] += e[r]
            out[row + i, 0] = turn_between(h[0], y, to)
            out[row + i, 1], out[row + i, 2] = pair[i], third[k]
            there[row + i] = 1
