"""The fastest profile under speed and acceleration bounds: reachability analysis over a spline's spans.

Square speed x is linear and acceleration u constant on a span, x1 = x0 + 2 h u. Backward, the fastest speed from which
the rest can still be done; forward, the hardest acceleration that stays below it (Pham and Pham, TOPP-RA). Standing
still is always allowed, so that the set of controllable speeds begins at 0 and one number a point says it all. Bounds
hold all along a span, not at its ends only: they are put on the Bernstein coefficients of the acceleration.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.timing.path_spline import MotionBounds, axis_terms

__all__ = ["fastest_squares"]

Array = NDArray[np.float64]
_ROUNDS = 60  # an end for a speed that nothing can be reached from


@part
def _span(control: Array, i: int, h: float, bounds: MotionBounds, lines: Array, cones: Array) -> tuple[int, int]:
    """Bounds of span i: lines (L, 2) with |u0 u + x0 x| <= 1, cones (C, 3) with uu u^2 + 2 ux u x + xx x^2 <= 1."""
    width = control.shape[1]
    count = 0
    for d in range(6, width):
        limit = bounds.acceleration[d - 6]
        if not np.isfinite(limit):
            continue
        a0, a1, a2, e0, e1, _f = axis_terms(control, i, d, h)
        lines[count, 0], lines[count, 1] = a0 / limit, e0 / limit
        lines[count + 1, 0], lines[count + 1, 1] = (a1 + h * e0) / limit, 0.5 * (e0 + e1) / limit
        lines[count + 2, 0], lines[count + 2, 1] = (a2 + 2.0 * h * e1) / limit, e1 / limit
        count += 3
    round_count = 0
    for g in range(2):
        limit = bounds.tool_acceleration if g == 0 else bounds.turn_acceleration
        if not np.isfinite(limit):
            continue
        cones[round_count : round_count + 3] = 0.0
        for d in range(3 * g, 3 * g + 3):
            a0, a1, a2, e0, e1, _f = axis_terms(control, i, d, h)
            for k in range(3):
                if k == 0:
                    u, x = a0 / limit, e0 / limit
                elif k == 1:
                    u, x = (a1 + h * e0) / limit, 0.5 * (e0 + e1) / limit
                else:
                    u, x = (a2 + 2.0 * h * e1) / limit, e1 / limit
                cones[round_count + k, 0] += u * u
                cones[round_count + k, 1] += u * x
                cones[round_count + k, 2] += x * x
        round_count += 3
    return count, round_count


@part
def _range(x: float, lines: Array, count: int, cones: Array, round_count: int, out: Array) -> bool:
    """Accelerations that x allows: out = lowest, its slope over x, highest, its slope. False where a cone allows none."""
    out[0], out[1], out[2], out[3] = -np.inf, 0.0, np.inf, 0.0
    for k in range(count):
        u, c = lines[k, 0], lines[k, 1]
        if abs(u) < 1e-12:
            continue
        size = abs(u)
        slope = -c / u
        low, high = slope * x - 1.0 / size, slope * x + 1.0 / size
        if low > out[0]:
            out[0], out[1] = low, slope
        if high < out[2]:
            out[2], out[3] = high, slope
    for k in range(round_count):
        uu, ux, xx = cones[k, 0], cones[k, 1], cones[k, 2]
        if uu < 1e-24:
            continue
        root = ux * ux * x * x - uu * (xx * x * x - 1.0)
        if root < 0.0:
            return False
        root = np.sqrt(root)
        steep = (ux * ux - uu * xx) * x / max(root, 1e-12)
        low, high = (-ux * x - root) / uu, (-ux * x + root) / uu
        if low > out[0]:
            out[0], out[1] = low, (-ux - steep) / uu
        if high < out[2]:
            out[2], out[3] = high, (-ux + steep) / uu
    return True


@part
def _highest(top: float, following: float, h: float, lines: Array, count: int, cones: Array, round_count: int) -> float:
    """The largest x <= top from which some allowed u leads to 0 <= x + 2 h u <= following (Newton's method from above)."""
    x = top
    for k in range(count):  # what binds x whatever u
        if abs(lines[k, 0]) < 1e-12 and abs(lines[k, 1]) * x > 1.0:
            x = 1.0 / abs(lines[k, 1])
    for k in range(round_count):
        across = cones[k, 2] - (cones[k, 1] ** 2 / cones[k, 0] if cones[k, 0] > 1e-24 else 0.0)
        if across * x * x > 1.0:
            x = np.sqrt(1.0 / across) * (1.0 - 1e-9)
    out = np.empty(4)
    for _round in range(_ROUNDS):
        if not _range(x, lines, count, cones, round_count, out):
            x *= 1.0 - 1e-6
            continue
        low, low_slope, high, high_slope = out[0], out[1], out[2], out[3]
        if -x / (2.0 * h) > low:
            low, low_slope = -x / (2.0 * h), -0.5 / h
        if (following - x) / (2.0 * h) < high:
            high, high_slope = (following - x) / (2.0 * h), -0.5 / h
        gap = low - high
        if gap <= 1e-12 * (1.0 + abs(low)):
            return x
        x = max(x - gap / max(low_slope - high_slope, 1e-12), 0.0)
    return x * 0.999


@kernel(nogil=True)
def fastest_squares(control: Array, h: float, caps: Array, bounds: MotionBounds, first: float, last: float) -> Array:
    """Squares of the fastest speeds (K + 1,) at the knots of a spline of K spans, from `first` to at most `last`.

    caps: (K,) square of the top speed on each span. first and last are squares too, taken as upper bounds.
    """
    count = caps.shape[0]
    lines, cones = np.empty((3 * (control.shape[1] - 6), 2)), np.empty((6, 3))
    x = np.empty(count + 1)
    x[count] = min(last, caps[count - 1])
    for i in range(count - 1, -1, -1):
        top = caps[i] if i == 0 else min(caps[i], caps[i - 1])
        n_lines, n_cones = _span(control, i, h, bounds, lines, cones)
        x[i] = _highest(top, min(x[i + 1], caps[i]), h, lines, n_lines, cones, n_cones)
    x[0] = min(x[0], first)
    out = np.empty(4)
    for i in range(count):
        n_lines, n_cones = _span(control, i, h, bounds, lines, cones)
        most = x[i + 1]
        if _range(x[i], lines, n_lines, cones, n_cones, out):
            most = min(most, x[i] + 2.0 * h * out[2])
        x[i + 1] = max(most, 0.0)
    return x
