"""What steps of a lattice cost that together are nowhere dearer than a move as the planner prices it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.objective import MotionPrice

__all__ = ["step_prices"]

Array = NDArray[np.float64]

_HALVINGS = 50  # of a step: down to rounding
_BELOW = 1e-9  # relative: rounding is some 1e-13


def step_prices(motion: MotionPrice, axis: int, step: float, count: int) -> Array:
    """Prices (W, count) of the first step (m or rad) on the way to each waypoint, of the second, and so on; the last also of all
    further ones. None is cheaper than the one before.

    The line through their sums is nowhere above the motion's price g of coordinate `axis`, which is convex: the first piece is as
    steep as g begins, each further one as steep as a tangent of g that touches it on the piece and is not below where it begins.
    """
    rate, square, top = motion.rate[:, axis], motion.square[:, axis], motion.top[:, axis]
    haste = np.asarray(motion.haste)

    def line(t: Array, at: float) -> Array:
        over = np.maximum(t / top - 1.0, 0.0)
        price = rate * t + square * t * t + haste * over * over
        return np.asarray(price + slope(t) * (at - t))

    def slope(t: Array) -> Array:
        return np.asarray(rate + 2.0 * square * t + 2.0 * haste / top * np.maximum(t / top - 1.0, 0.0))

    out, reached = np.empty((len(rate), count)), np.zeros(len(rate))
    for n in range(count):
        low, high = np.full(len(rate), n * step), np.full(len(rate), (n + 1) * step)
        fits = line(high, n * step) >= reached
        for _again in range(_HALVINGS):
            middle = 0.5 * (low + high)
            good = line(middle, n * step) >= reached
            low, high = np.where(good, middle, low), np.where(good, high, middle)
        touch = np.where(fits, (n + 1) * step, low)
        steep = slope(touch) if n else rate
        known = line(touch, n * step) >= reached
        out[:, n] = np.where(known | (n == 0), steep, out[:, n - 1])
        reached = reached + out[:, n] * step
    return out * (step * (1.0 - _BELOW))
