"""A published feed scheme, raised in steps until a constraint breaks (Duong and others 2020, Figure 2), as it can be read: at
each point by itself, or a step a point along the seam.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.timing.path_spline import MotionBounds

__all__ = ["PublishedFeed", "constant_feed_bound", "marched_feed", "motion_along", "profile_excess", "raised_feed"]

Array = NDArray[np.float64]


class PublishedFeed(NamedTuple):
    """feed (N,), m/s; stopped (N,): which bound stopped the next step, 0 speed, 1 acceleration, 2 jerk, -1 the top feed.

    axis (N,): the joint whose bound it is, -1 for none.
    """

    feed: Array
    stopped: NDArray[np.int64]
    axis: NDArray[np.int64]


def motion_along(d1: Array, d2: Array, d3: Array, f: Array, u: Array, w: Array) -> tuple[Array, Array, Array]:
    """Speed, acceleration and jerk (N, n) of joints with derivatives over arc length, at feed f, its first and second
    derivative over time u and w (N,), m/s, m/s2, m/s3.
    """
    f, u, w = f[:, None], u[:, None], w[:, None]
    return d1 * f, d2 * f**2 + d1 * u, d3 * f**3 + 3.0 * d2 * f * u + d1 * w


def constant_feed_bound(d1: Array, d2: Array, d3: Array, bounds: MotionBounds) -> Array:
    """The fastest constant feed (N, 3) that speed, acceleration and jerk of all joints allow, point by point."""
    with np.errstate(divide="ignore"):
        return np.stack(
            [
                np.min(bounds.speed / np.abs(d1), axis=1),
                np.sqrt(np.min(bounds.acceleration / np.abs(d2), axis=1)),
                np.cbrt(np.min(bounds.jerk / np.abs(d3), axis=1)),
            ],
            axis=1,
        )


def raised_feed(
    d1: Array, d2: Array, d3: Array, bounds: MotionBounds, *, first: float, step: float, top: float
) -> PublishedFeed:
    """The scheme: from `first` by `step` up to `top`, each point by itself and as if its feed were constant (eq. 18, 19).

    d1, d2, d3: (N, n) derivatives of the joints over arc length, 1/m and so on.
    """
    limits = constant_feed_bound(d1, d2, d3, bounds)
    least = limits.min(axis=1)
    steps = np.floor((np.minimum(least, top) - first) / step + 1e-9)
    feed = first + step * np.maximum(steps, 0.0)
    free = feed + step > top + 1e-12
    stopped = np.where(free & (least >= top), -1, np.argmin(limits, axis=1))
    with np.errstate(divide="ignore"):
        ratios = np.stack(
            [np.abs(d1) / bounds.speed, np.abs(d2) / bounds.acceleration, np.abs(d3) / bounds.jerk], axis=1
        )
    axis = np.argmax(ratios[np.arange(len(feed)), np.maximum(stopped, 0)], axis=1)
    return PublishedFeed(feed, stopped, np.where(stopped < 0, -1, axis))


def marched_feed(
    s: Array, d1: Array, d2: Array, d3: Array, bounds: MotionBounds, *, first: float, step: float, top: float
) -> Array:
    """The scheme read as a march along s (N,): the feed (N,), one `step` higher than at the point before as long as no bound
    breaks with the feed's own df/dt and d2f/dt2, else the highest of the steps below that breaks none; `first` where all do.
    """
    feed = np.full(len(s), first)
    before = 0.0
    for k in range(1, len(s)):
        steps = int(np.floor((min(feed[k - 1] + step, top) - first) / step + 1e-9))
        for f in first + step * np.arange(steps, -1, -1):
            u = (f * f - feed[k - 1] ** 2) / (2.0 * (s[k] - s[k - 1]))
            w = (u - before) * (f + feed[k - 1]) / (2.0 * (s[k] - s[k - 1]))
            moved = motion_along(d1[k], d2[k], d3[k], *(np.array([v]) for v in (f, u, w)))
            limits = (bounds.speed, bounds.acceleration, bounds.jerk)
            if f == first or all(np.all(np.abs(m) <= limit) for m, limit in zip(moved, limits, strict=True)):
                break
        feed[k], before = f, u
    return feed


def profile_excess(s: Array, feed: Array, d1: Array, d2: Array, d3: Array, bounds: MotionBounds) -> tuple[Array, Array]:
    """How far a profile over arc length s (N,) uses the bounds (N, 3) once its own df/dt and d2f/dt2 count; and its time (N,).

    The feed is taken as linear in time between points; its derivatives are differences on the given points.
    """
    at = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (feed[1:] + feed[:-1]))])
    u = np.gradient(feed, at)
    w = np.gradient(u, at)
    motion = motion_along(d1, d2, d3, feed, u, w)
    limits = (bounds.speed, bounds.acceleration, bounds.jerk)
    use = np.stack([np.max(np.abs(m) / limit, axis=1) for m, limit in zip(motion, limits, strict=True)], axis=1)
    return use, at
