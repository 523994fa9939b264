"""Stretches of cutting between exact stops as smooth curves: what a feed is planned on, and a program's own is judged on."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.path import ToolPathInBase
from camrob.timing.losses import PROGRAMMED_FEED
from camrob.timing.path_spline import MotionBounds, smoothed
from camrob.timing.profile import FEWEST_SPANS
from camrob.timing.straight_pieces import PathRates
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["SmoothRun", "cause_names", "least_between", "piece_feeds", "run_bounds", "run_pieces", "smooth_run"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_SETTLE = 0.1  # s that acceleration takes to build up: shorter waves of the path are rounding, not the part
_ROUNDING = 0.3  # of `$APO.CDIS`: how far the curve may leave the polyline; a right angle rounded there does by 0.35
_SMALLEST = mm_to_m(0.1)  # taken for `$APO.CDIS` where it is less
_TURNING = deg_to_rad(0.05)  # likewise for the tool's rotation
_UNBOUND = 1e3  # m/s where the tip stands still and has no feed
_RAMPS = 0.02, 0.005  # s, and share of a run's time: what a first and a last span may cost, for they are one ramp each


class SmoothRun(NamedTuple):
    """P pieces of a path, `pieces` of its M, between exact stops, as a spline of K spans of length `spacing` (m).

    length: (P + 1,) m at the pieces' ends. control: (K + 3, 6 + n) of tip, rotation and the bounded axes. feed: (K,) m/s,
    the least of the pieces that a span touches. first, last: (P,) spans that a piece touches. deviation: m off the
    polyline at most.
    """

    pieces: slice
    length: Array
    control: Array
    spacing: float
    feed: Array
    first: Indices
    last: Indices
    deviation: float

    def derivatives(self, at: Array) -> tuple[Array, Array]:
        """First and second derivative (F, 6 + n) over the length at places `at` (F,), m."""
        place = np.clip(np.asarray(at) / self.spacing, 0.0, len(self.feed))
        span = np.minimum(place.astype(np.int64), len(self.feed) - 1)
        step = np.diff(self.control, axis=0)[span[:, None] + np.arange(3)]
        w, h = (place - span)[:, None], self.spacing
        lower, upper = step[:, 1] - step[:, 0], step[:, 2] - step[:, 1]
        rate = 0.5 * (step[:, 0] + step[:, 1]) + w * lower + 0.5 * w**2 * (upper - lower)
        return rate / h, (lower + w * (upper - lower)) / h**2


def run_bounds(rates: PathRates) -> tuple[MotionBounds, Indices]:
    """Bounds of the tool and of the joints that have any, and which joints those are."""
    bounded = np.flatnonzero(np.isfinite(rates.speed))
    bounds = MotionBounds(
        rates.tool_acceleration,
        rates.rotation_speed,
        rates.rotation_acceleration,
        rates.speed[bounded],
        rates.acceleration[bounded],
        rates.jerk[bounded],
    )
    return bounds, bounded


def cause_names(names: tuple[str, ...], bounded: Indices) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of what may bind, in `worst_use`'s order, and the axis of each ("" for none)."""
    causes = [PROGRAMMED_FEED, "tool acceleration", "tool rotation speed", "tool rotation acceleration"]
    axes = [""] * len(causes)
    for k in bounded.tolist():
        causes += [f"{names[k]} {what}" for what in ("speed", "acceleration", "jerk")]
        axes += [names[k]] * 3
    return tuple(causes), tuple(axes)


def run_pieces(rates: PathRates, path: ToolPathInBase, stop: NDArray[np.bool_]) -> list[slice]:
    """Pieces of every stretch of cutting without an exact stop within."""
    cuts = path.cutting[rates.end]
    stops_at = np.searchsorted(rates.end, np.flatnonzero(stop), side="right")  # pieces before the stop
    borders = np.flatnonzero(np.diff(cuts.astype(np.int8))) + 1
    marks = np.unique(np.concatenate([[0, len(cuts)], borders, stops_at]))
    return [slice(int(a), int(b)) for a, b in pairwise(marks) if b > a and cuts[a]]


def piece_feeds(rates: PathRates, speed: Array) -> Array:
    """Feed (M,) of the pieces for speeds (N,), m/s, of the points; without bound where the tip stands still."""
    return np.where(rates.translates, speed[rates.end], _UNBOUND)


def smooth_run(rates: PathRates, pieces: slice, bounded: Indices, feed: Array) -> SmoothRun:
    """The curve of one run of pieces at feeds (P,), m/s, within what the controller's rounding leaves the polyline by."""
    columns = np.concatenate([np.arange(6), 6 + bounded])
    length = np.concatenate([[0.0], np.cumsum(rates.length[pieces])])
    moves = rates.rate[pieces][:, columns] * rates.length[pieces][:, None]
    values = np.vstack([np.zeros(len(columns)), np.cumsum(moves, axis=0)])
    whole = float(length[-1])
    count = max(FEWEST_SPANS, int(np.ceil(whole / _wanted(rates, length, feed))))
    spacing = whole / count
    # waves shorter than a span are not on the grid; where nothing else binds the curve's ends, it is not unique
    reach = max(float(np.median(feed)) * _SETTLE, 0.5 * spacing)
    within = np.array([_ROUNDING * max(rates.blend, _SMALLEST), _TURNING])
    control, deviation = smoothed(length, values, count, min(reach, 40.0 * spacing), within)
    knots = np.linspace(0.0, whole, count + 1)
    first = np.clip(np.searchsorted(length, knots[:-1], side="right") - 1, 0, len(feed) - 1)
    last = np.clip(np.searchsorted(length, knots[1:], side="left") - 1, first, len(feed) - 1)
    begins = np.clip((length[:-1] / spacing).astype(np.int64), 0, count - 1)
    ends = np.clip(np.ceil(length[1:] / spacing).astype(np.int64) - 1, begins, count - 1)
    slowest = least_between(feed, first, last)
    return SmoothRun(pieces, length, control, spacing, slowest, begins, ends, float(deviation[:, 0].max()))


def _wanted(rates: PathRates, length: Array, feed: Array) -> float:
    """Length of a span: as the points lie, no longer than the rounding, and short where a run begins or ends slowly."""
    wanted = float(length[-1]) / len(feed)
    if rates.blend > 0.0:
        wanted = min(max(wanted, 0.1 * rates.blend), rates.blend)
    seconds = float(np.sum(np.diff(length) / feed))
    ramps = 0.5 * max(_RAMPS[0], _RAMPS[1] * seconds) / (1.0 / feed[0] + 1.0 / feed[-1])
    return float(min(wanted, max(ramps, 0.1 * max(rates.blend, _SMALLEST))))


def least_between(values: Array, first: Indices, last: Indices) -> Array:
    """Least of values first .. last (inclusive) for each pair."""
    padded = np.append(values, np.inf)
    pairs = np.column_stack([first, last + 1]).ravel()
    return np.asarray(np.minimum.reduceat(padded, pairs)[::2])
