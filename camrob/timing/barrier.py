"""The fastest profile under speed, acceleration and jerk bounds together, by an interior-point method of linear cost.

On every span of the path's spline the square of the speed is a quadratic with Bernstein coefficients from control values
c: (c0 + c1) / 2, c1, (c1 + c2) / 2. Acceleration along the path is then continuous, and the acceleration of an axis,
q' u + q'' x, and its jerk over speed, q' u' + 3 q'' u + q''' x, are linear in c; their Bernstein coefficients are bounded.
Jerk is bounded by J / sqrt(x), which is convex in x, so that its tangent is a safe linear bound (the sequential convex
scheme); the Newton steps of a logarithmic barrier take a new tangent each. A span's bounds see three values of c, so the
Newton matrix has five diagonals and a step costs as much as the path is long.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined, kernel, part
from camrob.timing.path_spline import MotionBounds, axis_terms

__all__ = ["RAMP", "centre", "merit", "squares_of_span"]

Array = NDArray[np.float64]

RAMP = 0.2  # c0 / c1 behind a start from rest with constant jerk over one span: x ~ s^(4/3), so u = 2/3 x / s


_CENTRED = 1e-3  # of Newton's decrement per value: close enough to the middle


@inlined
def squares_of_span(c0: float, c1: float, c2: float) -> tuple[float, float, float]:
    """Bernstein coefficients of the square speed on a span."""
    return 0.5 * (c0 + c1), c1, 0.5 * (c1 + c2)


@part
def _rows(control: Array, i: int, d: int, h: float, out: Array) -> None:
    """Rows out (7, 3) over (c0, c1, c2): four Bernstein coefficients of column d's acceleration, three of jerk / speed."""
    a0, a1, a2, e0, e1, f = axis_terms(control, i, d, h)
    w = 0.5 / h
    b0, b1, b2 = a0 * w, a1 * w, a2 * w
    out[0, 0], out[0, 1], out[0, 2] = -b0 + 0.5 * e0, b0 + 0.5 * e0, 0.0
    out[1, 0], out[1, 1], out[1, 2] = (
        (-2.0 * b1 + 0.5 * e1) / 3.0,
        (2.0 * b1 - b0 + 2.0 * e0 + 0.5 * e1) / 3.0,
        b0 / 3.0,
    )
    out[2, 0], out[2, 1], out[2, 2] = (
        -b2 / 3.0,
        (b2 - 2.0 * b1 + 0.5 * e0 + 2.0 * e1) / 3.0,
        (2.0 * b1 + 0.5 * e0) / 3.0,
    )
    out[3, 0], out[3, 1], out[3, 2] = 0.0, -b2 + 0.5 * e1, b2 + 0.5 * e1
    j = 1.0 / h
    out[4, 0], out[4, 1], out[4, 2] = b0 * j - 3.0 * e0 * w + 0.5 * f, -2.0 * b0 * j + 3.0 * e0 * w + 0.5 * f, b0 * j
    out[5, 0] = b1 * j - 1.5 * e1 * w
    out[5, 1] = -2.0 * b1 * j + 1.5 * (e1 - e0) * w + f
    out[5, 2] = b1 * j + 1.5 * e0 * w
    out[6, 0], out[6, 1], out[6, 2] = b2 * j, -2.0 * b2 * j - 3.0 * e1 * w + 0.5 * f, b2 * j + 3.0 * e1 * w + 0.5 * f


@kernel(nogil=True)
def merit(
    c: Array, t: float, weight: Array, caps: Array, ease: Array, control: Array, h: float, bounds: MotionBounds
) -> float:
    """t times the time less the logarithms of all slacks; inf where a bound is met or passed."""
    spans, width = c.shape[0] - 2, control.shape[1]
    rows, g = np.empty((7, 3)), np.empty((4, 3))
    total = 0.0
    for j in range(c.shape[0]):
        if c[j] <= 0.0 or c[j] >= caps[j]:
            return np.inf
        total += t * weight[j] / np.sqrt(c[j]) - (np.log(1.0 - c[j] / caps[j]) if weight[j] > 0.0 else 0.0)
    for i in range(spans):
        c0, c1, c2 = c[i], c[i + 1], c[i + 2]
        x0, x1, x2 = squares_of_span(c0, c1, c2)
        r0, r1, r2 = 1.0 / np.sqrt(x0), 1.0 / np.sqrt(x1), 1.0 / np.sqrt(x2)
        most = 4 if i == spans - 1 else 3
        product = 1.0
        for group in range(2):
            limit = bounds.tool_acceleration if group == 0 else bounds.turn_acceleration
            if not np.isfinite(limit):
                continue
            for m in range(3):
                _rows(control, i, 3 * group + m, h, rows)
                for k in range(most):
                    g[k, m] = (rows[k, 0] * c0 + rows[k, 1] * c1 + rows[k, 2] * c2) / limit
            for k in range(most):
                slack = 1.0 - (g[k, 0] ** 2 + g[k, 1] ** 2 + g[k, 2] ** 2)
                if slack <= 0.0:
                    return np.inf
                product *= slack
        total -= np.log(product)
        for d in range(6, width):
            acceleration, jerk = bounds.acceleration[d - 6], bounds.jerk[d - 6] * ease[i]
            _rows(control, i, d, h, rows)
            product = 1.0
            if np.isfinite(acceleration):
                for k in range(most):
                    value = (rows[k, 0] * c0 + rows[k, 1] * c1 + rows[k, 2] * c2) / acceleration
                    if abs(value) >= 1.0:
                        return np.inf
                    product *= 1.0 - value * value
            if np.isfinite(jerk):
                for k in range(3):
                    value = (rows[4 + k, 0] * c0 + rows[4 + k, 1] * c1 + rows[4 + k, 2] * c2) / jerk
                    room = r0 if k == 0 else (r1 if k == 1 else r2)
                    if abs(value) >= room:
                        return np.inf
                    product *= room * room - value * value
            total -= np.log(product)
    return total


@inlined
def _add(grad: Array, H: Array, i: int, r0: float, r1: float, r2: float, first: float, second: float) -> None:
    """Add first * r to the gradient and second * r r^T to the banded Hessian, r over (c_i, c_i+1, c_i+2)."""
    grad[i] += first * r0
    grad[i + 1] += first * r1
    grad[i + 2] += first * r2
    H[i, 0] += second * r0 * r0
    H[i, 1] += second * r0 * r1
    H[i, 2] += second * r0 * r2
    H[i + 1, 0] += second * r1 * r1
    H[i + 1, 1] += second * r1 * r2
    H[i + 2, 0] += second * r2 * r2


@part
def _add_axes(
    c: Array,
    i: int,
    ease: float,
    control: Array,
    h: float,
    bounds: MotionBounds,
    rows: Array,
    grad: Array,
    H: Array,
) -> None:
    """The axes' part of a span in gradient and Hessian."""
    c0, c1, c2 = c[i], c[i + 1], c[i + 2]
    x0, x1, x2 = squares_of_span(c0, c1, c2)
    last = i == c.shape[0] - 3
    for d in range(6, control.shape[1]):
        acceleration, jerk = bounds.acceleration[d - 6], bounds.jerk[d - 6] * ease
        _rows(control, i, d, h, rows)
        if np.isfinite(acceleration):
            for k in range(4 if last else 3):
                r0, r1, r2 = rows[k, 0] / acceleration, rows[k, 1] / acceleration, rows[k, 2] / acceleration
                value = r0 * c0 + r1 * c1 + r2 * c2
                below, above = 1.0 / (1.0 - value), 1.0 / (1.0 + value)
                _add(grad, H, i, r0, r1, r2, below - above, below * below + above * above)
        if np.isfinite(jerk):
            for k in range(3):
                r0, r1, r2 = rows[4 + k, 0] / jerk, rows[4 + k, 1] / jerk, rows[4 + k, 2] / jerk
                value = r0 * c0 + r1 * c1 + r2 * c2
                x = x0 if k == 0 else (x1 if k == 1 else x2)
                room = 1.0 / np.sqrt(x)
                fall = 0.5 * room / x  # the room's slope over x, negative
                f0 = 0.5 * fall if k == 0 else 0.0
                f1 = fall if k == 1 else 0.5 * fall
                f2 = 0.5 * fall if k == 2 else 0.0
                below, above = 1.0 / (room - value), 1.0 / (room + value)
                _add(grad, H, i, r0 + f0, r1 + f1, r2 + f2, below, below * below)
                _add(grad, H, i, -r0 + f0, -r1 + f1, -r2 + f2, above, above * above)


@part
def _add_norms(
    c: Array, i: int, last: bool, control: Array, h: float, bounds: MotionBounds, rows: Array, grad: Array, H: Array
) -> None:
    """The part of tool and rotation acceleration of a span in gradient and Hessian."""
    c0, c1, c2 = c[i], c[i + 1], c[i + 2]
    of = np.empty((4, 3, 3))
    for group in range(2):
        limit = bounds.tool_acceleration if group == 0 else bounds.turn_acceleration
        if not np.isfinite(limit):
            continue
        for m in range(3):
            _rows(control, i, 3 * group + m, h, rows)
            for k in range(4):
                for r in range(3):
                    of[k, m, r] = rows[k, r] / limit
        for k in range(4 if last else 3):
            slack, s0, s1, s2 = 1.0, 0.0, 0.0, 0.0
            for m in range(3):
                value = of[k, m, 0] * c0 + of[k, m, 1] * c1 + of[k, m, 2] * c2
                slack -= value * value
                s0, s1, s2 = s0 + value * of[k, m, 0], s1 + value * of[k, m, 1], s2 + value * of[k, m, 2]
            for m in range(3):
                _add(grad, H, i, of[k, m, 0], of[k, m, 1], of[k, m, 2], 0.0, 2.0 / slack)
            _add(grad, H, i, s0, s1, s2, 2.0 / slack, 4.0 / (slack * slack))


@part
def _fold(grad: Array, H: Array, start: bool, end: bool) -> None:
    """Take out the outermost values where they hang on their neighbours (c0 = RAMP c1), so that their step is zero."""
    n = grad.shape[0]
    if start:
        grad[1] += RAMP * grad[0]
        H[1, 0] += 2.0 * RAMP * H[0, 1] + RAMP * RAMP * H[0, 0]
        H[1, 1] += RAMP * H[0, 2]
        grad[0], H[0, 0], H[0, 1], H[0, 2] = 0.0, 1.0, 0.0, 0.0
    if end:
        grad[n - 2] += RAMP * grad[n - 1]
        H[n - 2, 0] += 2.0 * RAMP * H[n - 2, 1] + RAMP * RAMP * H[n - 1, 0]
        H[n - 3, 1] += RAMP * H[n - 3, 2]
        grad[n - 1], H[n - 1, 0], H[n - 2, 1], H[n - 3, 2] = 0.0, 1.0, 0.0, 0.0


@part
def _solve(H: Array, grad: Array, step: Array) -> None:
    """step = -H^-1 grad for the matrix with diagonals H (N, 3), factored in place as L D L^T."""
    n = grad.shape[0]
    for i in range(n):
        if i >= 1:
            if i >= 2:
                H[i, 0] -= H[i - 2, 2] ** 2 * H[i - 2, 0]
            H[i, 0] -= H[i - 1, 1] ** 2 * H[i - 1, 0]
            if i + 1 < n:
                H[i, 1] -= H[i - 1, 1] * H[i - 1, 0] * H[i - 1, 2]
        pivot = max(H[i, 0], 1e-300)
        H[i, 0] = pivot
        H[i, 1] /= pivot
        H[i, 2] /= pivot
    for i in range(n):
        step[i] = -grad[i]
        if i >= 1:
            step[i] -= H[i - 1, 1] * step[i - 1]
        if i >= 2:
            step[i] -= H[i - 2, 2] * step[i - 2]
    for i in range(n - 1, -1, -1):
        step[i] /= H[i, 0]
        if i + 1 < n:
            step[i] -= H[i, 1] * step[i + 1]
        if i + 2 < n:
            step[i] -= H[i, 2] * step[i + 2]


@kernel(nogil=True)
def centre(
    c: Array,
    t: float,
    weight: Array,
    caps: Array,
    ease: Array,
    control: Array,
    h: float,
    bounds: MotionBounds,
    start: bool,
    end: bool,
    rounds: int,
) -> int:
    """Newton steps towards the minimum of `merit` from c (M + 2), strictly within bounds, in place; how many were taken.

    weight: (M + 2) of 1 / sqrt(c) in the time (0 takes the value's own cap out: it hangs on its neighbour). caps:
    (M + 2).
    ease: (M,) share of the jerk bounds that each span may use. control: (M + 3, D).
    start, end: True where the motion comes from rest or ends at rest one span outside.
    """
    n = c.shape[0]
    grad, H, step, rows = np.empty(n), np.empty((n, 3)), np.empty(n), np.empty((7, 3))
    now = merit(c, t, weight, caps, ease, control, h, bounds)
    for taken in range(rounds):
        grad[:] = 0.0
        H[:] = 0.0
        for j in range(n):
            if weight[j] > 0.0:
                root = np.sqrt(c[j])
                slack = 1.0 / (caps[j] - c[j])
                grad[j] = slack - 0.5 * t * weight[j] / (c[j] * root)
                H[j, 0] = slack * slack + 0.75 * t * weight[j] / (c[j] * c[j] * root)
        for i in range(n - 2):
            _add_axes(c, i, ease[i], control, h, bounds, rows, grad, H)
            _add_norms(c, i, i == n - 3, control, h, bounds, rows, grad, H)
        _fold(grad, H, start, end)
        _solve(H, grad, step)
        if start:
            step[0] = RAMP * step[1]
        if end:
            step[n - 1] = RAMP * step[n - 2]
        inner = slice(1 if start else 0, n - 1 if end else n)
        slope = np.dot(grad[inner], step[inner])
        if -slope < _CENTRED * n:
            return taken
        share = 1.0
        while share > 1e-6:
            following = merit(c + share * step, t, weight, caps, ease, control, h, bounds)
            if following <= now + 0.1 * share * slope:
                break
            share *= 0.6
        if share <= 1e-6:
            return taken
        c += share * step
        now = following
    return rounds
