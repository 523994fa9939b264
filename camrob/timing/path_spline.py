"""A path as a uniform cubic B-spline in its length: tip, tool rotation and axes, with the bounds on their motion.

A spline has what a polyline lacks: a curvature and a third derivative everywhere, so that acceleration and jerk are
defined between the points. Taken as control polygon, a polyline is left at a corner by no more than one spacing of the
spline before and behind it, as `C_DIS` allows the controller.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined, kernel, part

__all__ = ["MotionBounds", "axis_terms", "interpolated", "smoothed", "speed_caps", "spline_at"]

Array = NDArray[np.float64]

_ROUNDS = 12  # of weighing more where the tolerance is missed


class MotionBounds(NamedTuple):
    """What may not be passed; inf where there is no bound. All SI.

    A spline's columns are tip (3), accumulated rotation vector (3), axes (n): tool_acceleration bounds the norm of the
    tip's acceleration, turn_speed and turn_acceleration those of the rotation, the arrays (n,) the axes one by one.
    """

    tool_acceleration: float
    turn_speed: float
    turn_acceleration: float
    speed: Array
    acceleration: Array
    jerk: Array


def smoothed(length: Array, values: Array, count: int, reach: float, tolerance: Array) -> tuple[Array, Array]:
    """Control values (count + 3, D) of a smoothing spline near a polyline, and its deviation (count + 1, 2) at the knots.

    A sum of squared distances at the knots and of squared third differences is least; the latter weigh so much that
    waves shorter than about `reach` (m) vanish, except where the tip (columns 0 to 2, m) or the rotation (3 to 5, rad)
    would leave the polyline by more than `tolerance` (2,): there the distances weigh more, until they stay below it or the
    spline follows as closely as it can. All columns are smoothed alike, so that they stay together; both ends are kept.
    """
    grid = np.linspace(length[0], length[-1], count + 1)
    target = np.column_stack([np.interp(grid, length, values[:, d]) for d in range(values.shape[1])])
    stiffness = float(reach / (2.0 * np.pi * (grid[1] - grid[0]))) ** 6
    control, deviation = np.empty((count + 3, values.shape[1])), np.zeros((count + 1, 2))
    _smooth(np.ascontiguousarray(target), stiffness, np.asarray(tolerance, dtype=np.float64), control, deviation)
    return control, deviation


@kernel(nogil=True)
def _smooth(target: Array, stiffness: float, tolerance: Array, control: Array, deviation: Array) -> None:
    """`smoothed`, of knots' target (K + 1, D): fills control (K + 3, D) and deviation (K + 1, 2)."""
    knots = target.shape[0]
    heaviest = 1e6 * max(1.0, stiffness)
    weight, excess, factor = np.ones(knots), np.empty(knots), np.empty((knots + 2, 4))
    weight[0] = weight[-1] = heaviest
    for _round in range(_ROUNDS):
        _penalised(target, weight, stiffness, factor, control)
        most = 0.0
        for i in range(knots):
            off = turn = 0.0
            for d in range(6):
                e = (control[i, d] + 4.0 * control[i + 1, d] + control[i + 2, d]) / 6.0 - target[i, d]
                if d < 3:
                    off += e * e
                else:
                    turn += e * e
            deviation[i, 0], deviation[i, 1] = np.sqrt(off), np.sqrt(turn)
            excess[i] = max(deviation[i, 0] / tolerance[0], deviation[i, 1] / tolerance[1])
            most = max(most, excess[i])
        if most <= 1.0:
            break
        for i in range(1, knots - 1):
            around = 0.7
            for k in range(max(0, i - 2), min(knots, i + 3)):
                around = max(around, excess[k])
            weight[i] = min(weight[i] * around**2, heaviest)


@part
def _penalised(target: Array, weight: Array, stiffness: float, factor: Array, control: Array) -> None:
    """control (n, D) <- least sum of weight * distance^2 + stiffness * (third difference)^2; a matrix of seven diagonals.

    By its Cholesky factor, row by row into factor (n, 4): one over what stands on the diagonal, then what stands before it.
    """
    n, width = control.shape
    for i in range(n):
        a0, a1, a2, a3 = _matrix_row(weight, stiffness, i, n)
        l1 = l2 = l3 = 0.0
        if i > 2:
            l3 = a3 * factor[i - 3, 0]
        if i > 1:
            l2 = (a2 - l3 * factor[i - 2, 1]) * factor[i - 2, 0]
        if i > 0:
            l1 = (a1 - l3 * factor[i - 1, 2] - l2 * factor[i - 1, 1]) * factor[i - 1, 0]
        scale = 1.0 / np.sqrt(a0 - l3 * l3 - l2 * l2 - l1 * l1)
        factor[i, 0], factor[i, 1], factor[i, 2], factor[i, 3] = scale, l1, l2, l3
        w0 = weight[i] / 6.0 if i < n - 2 else 0.0
        w1 = weight[i - 1] * 4.0 / 6.0 if 0 < i < n - 1 else 0.0
        w2 = weight[i - 2] / 6.0 if i > 1 else 0.0
        t0, t1, t2 = min(i, n - 3), min(max(i - 1, 0), n - 3), max(i - 2, 0)
        b1, b2, b3 = max(i - 1, 0), max(i - 2, 0), max(i - 3, 0)
        for d in range(width):
            right = w0 * target[t0, d] + w1 * target[t1, d] + w2 * target[t2, d]
            if i > 0:
                right -= l1 * control[b1, d] + l2 * control[b2, d] + l3 * control[b3, d]
            control[i, d] = right * scale
    for i in range(n - 1, -1, -1):
        l1 = factor[i + 1, 1] if i < n - 1 else 0.0
        l2 = factor[i + 2, 2] if i < n - 2 else 0.0
        l3 = factor[i + 3, 3] if i < n - 3 else 0.0
        c1, c2, c3 = min(i + 1, n - 1), min(i + 2, n - 1), min(i + 3, n - 1)
        for d in range(width):
            further = l1 * control[c1, d] + l2 * control[c2, d] + l3 * control[c3, d]
            control[i, d] = (control[i, d] - further) * factor[i, 0]


@inlined
def _matrix_row(weight: Array, stiffness: float, i: int, n: int) -> tuple[float, float, float, float]:
    """Entries (i, i), (i, i - 1), (i, i - 2), (i, i - 3): values at the knots are (1, 4, 1) / 6 of three control values."""
    a0 = a1 = a2 = a3 = 0.0
    if i < n - 3:
        a0 += stiffness
    if 0 < i < n - 2:
        a0, a1 = a0 + 9.0 * stiffness, a1 - 3.0 * stiffness
    if 1 < i < n - 1:
        a0, a1, a2 = a0 + 9.0 * stiffness, a1 - 9.0 * stiffness, a2 + 3.0 * stiffness
    if 2 < i:
        a0, a1, a2, a3 = a0 + stiffness, a1 - 3.0 * stiffness, a2 + 3.0 * stiffness, -stiffness
    if i < n - 2:
        a0 += weight[i] / 36.0
    if 0 < i < n - 1:
        a0, a1 = a0 + weight[i - 1] * 16.0 / 36.0, a1 + weight[i - 1] * 4.0 / 36.0
    if 1 < i:
        w = weight[i - 2] / 36.0
        a0, a1, a2 = a0 + w, a1 + 4.0 * w, a2 + w
    return a0, a1, a2, a3


def interpolated(values: Array, spacing: float) -> Array:
    """Control values (K + 3, D) of the spline through `values` (K + 1, D) at equal `spacing`, not-a-knot at its ends."""
    from scipy.interpolate import make_interp_spline

    count = len(values) - 1
    knots = spacing * np.arange(count + 1)
    spline = make_interp_spline(knots, values, k=3)
    first, last = (np.stack([spline(knots[e], nu) for nu in range(4)]) for e in (0, -1))
    curve = spline(knots, 2)
    # a uniform spline's control value: the value less a sixth of the second difference there
    inner = values - curve * spacing**2 / 6.0
    before = _beyond(first, -spacing)
    behind = _beyond(last, spacing)
    return np.ascontiguousarray(np.vstack([before[None], inner, behind[None]]))


def _beyond(at_end: Array, step: float) -> Array:
    """The control value one step beyond an end, of value and three derivatives (4, D) there, the end cubic carried on."""
    value = at_end[0] + at_end[1] * step + at_end[2] * step**2 / 2.0 + at_end[3] * step**3 / 6.0
    return np.asarray(value - (at_end[2] + at_end[3] * step) * step**2 / 6.0)


@inlined
def axis_terms(control: Array, i: int, d: int, h: float) -> tuple[float, float, float, float, float, float]:
    """First derivative of column d on span i as three Bernstein coefficients, the second at both ends, the third."""
    p0, p1, p2, p3 = control[i, d], control[i + 1, d], control[i + 2, d], control[i + 3, d]
    e0 = (p0 - 2.0 * p1 + p2) / (h * h)
    e1 = (p1 - 2.0 * p2 + p3) / (h * h)
    a0 = (p2 - p0) / (2.0 * h)
    return a0, a0 + 0.5 * h * e0, (p3 - p1) / (2.0 * h), e0, e1, (e1 - e0) / h


@part
def spline_at(control: Array, h: float, i: int, w: float, order: int, out: Array) -> None:
    """Derivative of `order` (0 to 3) of all columns at the share w of span i."""
    if order == 0:
        f0, f1 = (1.0 - w) ** 3 / 6.0, (3.0 * w**3 - 6.0 * w**2 + 4.0) / 6.0
        f2, f3 = (-3.0 * w**3 + 3.0 * w**2 + 3.0 * w + 1.0) / 6.0, w**3 / 6.0
    elif order == 1:
        f0, f1 = -0.5 * (1.0 - w) ** 2 / h, (1.5 * w**2 - 2.0 * w) / h
        f2, f3 = (-1.5 * w**2 + w + 0.5) / h, 0.5 * w**2 / h
    elif order == 2:
        f0, f1, f2, f3 = (1.0 - w) / h**2, (3.0 * w - 2.0) / h**2, (1.0 - 3.0 * w) / h**2, w / h**2
    else:
        f0, f1, f2, f3 = -1.0 / h**3, 3.0 / h**3, -3.0 / h**3, 1.0 / h**3
    for d in range(control.shape[1]):
        out[d] = f0 * control[i, d] + f1 * control[i + 1, d] + f2 * control[i + 2, d] + f3 * control[i + 3, d]


@kernel(nogil=True)
def speed_caps(control: Array, h: float, feed: Array, bounds: MotionBounds) -> Array:
    """Square of the top speed (K,) on every span: programmed feed (K,), rotation and axes, anywhere on the span."""
    count, width = control.shape[0] - 3, control.shape[1]
    out = np.empty(count)
    for i in range(count):
        top = feed[i] * feed[i]
        t0 = t1 = t2 = 0.0
        for d in range(3, 6):
            a0, a1, a2, _e0, _e1, _f = axis_terms(control, i, d, h)
            t0, t1, t2 = t0 + a0 * a0, t1 + a1 * a1, t2 + a2 * a2
        turn = max(t0, max(t1, t2))
        if bounds.turn_speed**2 < top * turn:
            top = bounds.turn_speed**2 / turn
        for d in range(6, width):
            a0, a1, a2, _e0, _e1, _f = axis_terms(control, i, d, h)
            most = max(abs(a0), max(abs(a1), abs(a2)))
            if bounds.speed[d - 6] ** 2 < top * most * most:
                top = (bounds.speed[d - 6] / most) ** 2
        out[i] = top
    return out
