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

__all__ = ["MotionBounds", "axis_terms", "interpolated", "rounded", "smoothed", "speed_caps", "spline_at"]

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


def rounded(length: Array, values: Array, count: int) -> Array:
    """Control values (count + 3, D) over `count` spans of a polyline with `values` (M, D) at `length` (M,).

    The spline runs within the polyline's corners and begins and ends at its ends, without curvature there.
    """
    grid = np.linspace(length[0], length[-1], count + 1)
    inner = np.column_stack([np.interp(grid, length, values[:, d]) for d in range(values.shape[1])])
    return np.ascontiguousarray(np.vstack([2.0 * inner[:1] - inner[1:2], inner, 2.0 * inner[-1:] - inner[-2:-1]]))


def smoothed(length: Array, values: Array, count: int, reach: float, tolerance: Array) -> tuple[Array, Array]:
    """Control values (count + 3, D) of a smoothing spline near a polyline, and its deviation (count + 1, 2) at the knots.

    A sum of squared distances at the knots and of squared third differences is least; the latter weigh so much that
    waves shorter than about `reach` (m) vanish, except where the tip (columns 0 to 2, m) or the rotation (3 to 5, rad)
    would leave the polyline by more than `tolerance` (2,): there the distances weigh more, until they stay below it or the
    spline follows as closely as it can. All columns are smoothed alike, so that they stay together; both ends are kept.
    """
    grid = np.linspace(length[0], length[-1], count + 1)
    target = np.column_stack([np.interp(grid, length, values[:, d]) for d in range(values.shape[1])])
    stiffness = (reach / (2.0 * np.pi * (grid[1] - grid[0]))) ** 6
    weight = np.ones(count + 1)
    weight[[0, -1]] = 1e6 * max(1.0, stiffness)
    from scipy.ndimage import maximum_filter1d

    control = rounded(length, values, count)
    deviation = np.zeros((count + 1, 2))
    for _round in range(_ROUNDS):
        control = _penalised(target, weight, stiffness)
        off = (control[:-2] + 4.0 * control[1:-1] + control[2:]) / 6.0 - target
        deviation = np.column_stack([np.linalg.norm(off[:, :3], axis=1), np.linalg.norm(off[:, 3:6], axis=1)])
        excess = np.max(deviation / tolerance, axis=1)
        if excess.max() <= 1.0:
            break
        around = maximum_filter1d(excess, 5, mode="nearest")
        weight[1:-1] = np.minimum(weight * np.maximum(around, 0.7) ** 2, 1e6 * max(1.0, stiffness))[1:-1]
    return np.ascontiguousarray(control), deviation


def _penalised(target: Array, weight: Array, stiffness: float) -> Array:
    """Control values of least sum of weight * distance^2 + stiffness * (third difference)^2; a matrix of seven diagonals."""
    from scipy.linalg import solveh_banded

    n = len(target) + 2
    band = np.zeros((4, n))  # band[k, i]: entry (i, i + k)
    value, third = np.array([1.0, 4.0, 1.0]) / 6.0, np.array([-1.0, 3.0, -3.0, 1.0])
    for k in range(4):
        for r in range(4 - k):
            band[k, r : n - 3 + r] += stiffness * third[r] * third[r + k]
        for r in range(3 - k):
            band[k, r : n - 2 + r] += weight * value[r] * value[r + k]
    right = np.zeros((n, target.shape[1]))
    for r in range(3):
        right[r : n - 2 + r] += weight[:, None] * value[r] * target
    lower = np.zeros_like(band)
    for k in range(4):
        lower[k, : n - k] = band[k, : n - k]
    return np.asarray(solveh_banded(lower, right, lower=True, check_finite=False))


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
