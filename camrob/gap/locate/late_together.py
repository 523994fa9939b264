"""Whether all drives fall behind their set-points together, as where a controller stalls or the amplifiers' common supply sags.

Each axis is then off by its own speed times one lateness, which changes with the time. What several axes lack alike belongs to
none of them, though one that moves fast shows most of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene

__all__ = ["late_together"]

Array = NDArray[np.float64]

_TOLD = 0.3  # share of an axis's error that the lateness of all others has to show
_FEWEST = 2  # such axes
_QUIET = 1.5  # times its noise that an axis's error has to be to count
_HARDLY = 0.005  # of the mean square of speed: what moves less tells nothing
_BETWEEN = 2.0  # the square of what noise does from one row to the next is as many times its own


def late_together(scenes: Sequence[Scene]) -> bool:
    """True where the lateness that the others show at each moment foretells the errors of two axes and more, that of the axis
    that is off most among them.
    """
    if any(s.servo_gap is None or s.poses for s in scenes):
        return False
    error = np.concatenate([s.servo_gap for s in scenes if s.servo_gap is not None])
    speed = np.concatenate([s.velocity(s.command) for s in scenes])
    noise = np.sqrt(np.mean(np.diff(error, axis=0) ** 2, axis=0) / _BETWEEN)
    noise = np.minimum(noise, _told(scenes))
    rms = np.sqrt(np.mean(error**2, axis=0))
    off = [k for k in range(error.shape[1]) if rms[k] > _QUIET * noise[k] > 0.0 and np.ptp(speed[:, k]) > 0.0]
    if len(off) < _FEWEST:
        return False
    in_noises = np.where(noise > 0.0, noise, np.inf)
    told = [k for k in off if _share(error / in_noises, speed / in_noises, k, [j for j in off if j != k]) > _TOLD]
    return len(told) >= _FEWEST and max(off, key=lambda k: rms[k] / noise[k]) in told


def _told(scenes: Sequence[Scene]) -> Array:
    """(k,) the noise of each axis's encoder as the logs tell it, infinite where one doesn't."""
    cell, axes = scenes[0].cell, scenes[0].axes
    linear = np.array([cell.joints[cell.index(a)].prismatic for a in axes])
    stated = [np.where(linear, s.log.info.sigma_axis_length, s.log.info.sigma_axis) for s in scenes]
    return np.asarray(np.where(np.isfinite(stated), stated, np.inf).max(axis=0))


def _share(error: Array, speed: Array, k: int, others: Sequence[int]) -> float:
    """Share of axis k's energy that its speed times the lateness of `others` at each row shows; (N, n) in noises."""
    behind, fast = np.sum(error[:, others] * speed[:, others], axis=1), np.sum(speed[:, others] ** 2, axis=1)
    late = behind / np.maximum(fast, 1e-30)
    left = error[:, k] - late * speed[:, k]
    # where the others hardly move, they tell nothing
    told = fast > _HARDLY * float(np.mean(fast))
    return 1.0 - float(np.sum(left[told] ** 2)) / max(float(np.sum(error[told, k] ** 2)), 1e-30)
