"""The fastest feed along a path: as fast as the programmed feed, the axes and the tool allow, slowing in time.

Cutting is planned run by run between exact stops, with speed, acceleration and jerk of every axis, the external ones too,
acceleration of the tool and speed and acceleration of its rotation; moves through air keep the controller model's time.
What is written into the program, `speed`, leaves the ramps at stops to the controller.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.feed.losses import FeedLoss, feed_losses, lost_by_axis
from camrob.feed.path_spline import MotionBounds, smoothed
from camrob.feed.profile import FEWEST_SPANS, fastest_profile, fine_grid, worst_use
from camrob.feed.segments import PathRates, path_rates
from camrob.feed.timing import exact_stops, program_time
from camrob.frozen import locked
from camrob.resolve.path import ToolPathInBase
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["FeedPlan", "coarsen", "optimal_feed"]

Array = NDArray[np.float64]

_SAMPLES = 4  # a span, for times between points
_FINER = 10  # times finer: the grid that the plan is checked on
_SETTLE = (
    0.1  # s that acceleration takes to build up: shorter waves of the path are the program's rounding, not the part
)
_ROUNDING = 0.1  # of `$APO.CDIS`: how far the planned curve may round the program's polyline
_SMALLEST = mm_to_m(0.1)  # taken for `$APO.CDIS` where it is less
_TURNING = deg_to_rad(0.05)  # likewise for the tool's rotation
_LONG = 4  # spans: on a longer piece the program says its top speed, for the controller itself slows before a corner
_WINDOW = 500  # spans at each end that are planned anew without the stop
_STEP = 1e-5  # m/s: `$VEL.CP` is printed so, rounded down here
_UNBOUND = 1e3  # m/s where the tip stands still and has no feed


@dataclass(frozen=True, slots=True)
class FeedPlan:
    """A planned feed. speed: (N,) m/s to write as `$VEL.CP` for the motion to each point (rapid in air).

    planned: (N,) m/s at each point; at: (N,) s. total: s, cutting: s of it at the programmed feed's moves; unjerked: s that
    cutting would take were jerk without bounds. use: the largest share of the bounds on "speed", "acceleration" and
    "jerk" that is taken anywhere on a 10 times finer grid; 1.0 is all. cause: (N,) index into `causes` of what binds most
    on the way to a point; losses: where the plan stays below the programmed feed. changes: how often `speed` changes.
    deviation: m that the planned curve rounds the program's corners at most.
    """

    speed: Array
    planned: Array
    at: Array
    total: float
    cutting: float
    unjerked: float
    use: dict[str, float]
    cause: NDArray[np.int16]
    causes: tuple[str, ...]
    losses: tuple[FeedLoss, ...]
    changes: int
    deviation: float

    def __post_init__(self) -> None:
        speed = locked(self.speed, shape=(None,), name="speed")
        object.__setattr__(self, "speed", speed)
        for name, dtype in (("planned", np.float64), ("at", np.float64), ("cause", np.int16)):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(len(speed),), dtype=dtype, name=name))

    @property
    def lost_by_axis(self) -> dict[str, float]:
        """Seconds lost while cutting, by axis; most first."""
        return lost_by_axis(self.losses)


class _Run(NamedTuple):
    """A run's plan: at its P pieces' ends v (P + 1,) and seconds (P,), ceilings (P,), causes (P,); and for the whole."""

    v: Array
    seconds: Array
    ceiling: Array
    cause: NDArray[np.int64]
    unjerked: float
    use: Array
    deviation: float


def optimal_feed(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    *,
    rapid_speed: float,
    stops: NDArray[np.bool_] | None = None,
    tolerance: float = 0.02,
    progress: Callable[[float], None] | None = None,
) -> FeedPlan:
    """The fastest feed of a path with postures q (N, n) under its programmed feed; air at `rapid_speed`, m/s.

    stops: (N,) True where the tool comes to rest, by default `exact_stops`. tolerance: how far `speed` may stay below the
    plan so that it changes rarely; it is never above it. Raises ValueError for arrays that don't fit. Cost: linear;
    about 0.1 ms a millimetre of path.
    """
    programmed = np.where(path.cutting, path.feed, rapid_speed)
    stop = exact_stops(path) if stops is None else np.asarray(stops, bool)
    slow = program_time(cell, path, q, speed=programmed, stops=stop)
    rates = path_rates(cell, path, q)
    bounded = np.flatnonzero(np.isfinite(rates.speed))
    bounds = _bounds(rates, bounded)
    columns = np.concatenate([np.arange(6), 6 + bounded])
    step = np.diff(slow.at, prepend=0.0)
    planned, speed, cause = slow.speed.copy(), programmed.copy(), np.zeros(len(path), np.int16)
    unjerked, use, deviation = 0.0, np.zeros(3), 0.0
    feed = np.where(rates.translates, programmed[rates.end], _UNBOUND)
    within = np.array([_ROUNDING * max(rates.blend, _SMALLEST), _TURNING])
    runs = _runs(rates, path.cutting, stop)
    for k, (first, last) in enumerate(runs):
        pieces = slice(first, last)
        run = _plan(rates, pieces, columns, bounds, feed[pieces], within)
        ends = rates.end[pieces]
        planned[ends], step[ends], cause[ends] = run.v[1:], run.seconds, run.cause
        speed[ends] = coarsen(np.minimum(run.ceiling, programmed[ends]), tolerance)
        unjerked, use = unjerked + run.unjerked, np.maximum(use, run.use)
        deviation = max(deviation, run.deviation)
        if progress is not None:
            progress((k + 1) / len(runs))
    mean = np.full(len(path), np.nan)
    travels = rates.end[rates.translates]
    mean[travels] = rates.length[rates.translates] / step[travels]
    causes, axes = _causes(cell, bounded)
    at = np.cumsum(step)
    return FeedPlan(
        speed=speed,
        planned=planned,
        at=at,
        total=float(at[-1]) if len(at) else 0.0,
        cutting=float(np.sum(step[path.cutting])),
        unjerked=unjerked,
        use=dict(zip(("speed", "acceleration", "jerk"), use.tolist(), strict=True)),
        cause=cause,
        causes=causes,
        losses=feed_losses(path, programmed, step, mean, cause, causes, axes),
        changes=int(np.count_nonzero(np.diff(speed))),
        deviation=deviation,
    )


def _bounds(rates: PathRates, bounded: NDArray[np.int64]) -> MotionBounds:
    """Bounds of the tool and of the joints that have any."""
    return MotionBounds(
        rates.tool_acceleration,
        rates.rotation_speed,
        rates.rotation_acceleration,
        rates.speed[bounded],
        rates.acceleration[bounded],
        rates.jerk[bounded],
    )


def _runs(rates: PathRates, cutting: NDArray[np.bool_], stop: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Pieces first .. last of every stretch of cutting without an exact stop within."""
    cuts = cutting[rates.end]
    stops_at = np.searchsorted(rates.end, np.flatnonzero(stop), side="right")  # pieces before the stop
    borders = np.flatnonzero(np.diff(cuts.astype(np.int8))) + 1
    marks = np.unique(np.concatenate([[0, len(cuts)], borders, stops_at]))
    return [(int(a), int(b)) for a, b in pairwise(marks) if b > a and cuts[a]]


def _plan(
    rates: PathRates, pieces: slice, columns: NDArray[np.int64], bounds: MotionBounds, feed: Array, tolerance: Array
) -> _Run:
    """Plan one run of pieces from rest to rest, and once more without its stops for what the program says."""
    length = np.concatenate([[0.0], np.cumsum(rates.length[pieces])])
    moves = rates.rate[pieces][:, columns] * rates.length[pieces][:, None]
    values = np.vstack([np.zeros(len(columns)), np.cumsum(moves, axis=0)])
    whole = float(length[-1])
    wanted = whole / len(feed)
    if rates.blend > 0.0:
        wanted = min(max(wanted, 0.1 * rates.blend), rates.blend)
    count = max(FEWEST_SPANS, int(np.ceil(whole / wanted)))
    spacing = whole / count
    reach = float(np.median(feed)) * _SETTLE
    control, deviation = smoothed(length, values, count, min(reach, 40.0 * spacing), tolerance)
    knots = np.linspace(0.0, whole, count + 1)
    first = np.clip(np.searchsorted(length, knots[:-1], side="right") - 1, 0, len(feed) - 1)
    last = np.clip(np.searchsorted(length, knots[1:], side="left") - 1, first, len(feed) - 1)
    span_feed = _least_between(feed, first, last)
    resting = fastest_profile(control, spacing, span_feed, bounds)
    use, which = worst_use(control, resting, bounds, span_feed, _FINER)
    grid = fine_grid(resting, _SAMPLES)
    at = np.interp(length, grid.s, grid.at)
    begins = np.clip((length[:-1] / spacing).astype(np.int64), 0, count - 1)
    stops = np.clip(np.ceil(length[1:] / spacing).astype(np.int64) - 1, begins, count - 1)
    free = _without_stops(control, spacing, span_feed, bounds, grid.v)
    parts = np.lib.stride_tricks.sliding_window_view(free, _SAMPLES + 1)[::_SAMPLES]
    least, most = _least_between(parts.min(axis=1), begins, stops), -_least_between(-parts.max(axis=1), begins, stops)
    ceiling = np.where(stops - begins < _LONG, least, most)
    v = np.interp(length, grid.s, grid.v)
    v[[0, -1]] = 0.0
    middle = which[np.minimum((begins + stops) // 2, count - 1)]
    return _Run(v, np.diff(at), ceiling, middle, resting.shortest_time, use.max(axis=0), float(deviation[:, 0].max()))


def _without_stops(control: Array, spacing: float, feed: Array, bounds: MotionBounds, v: Array) -> Array:
    """Speeds (F,) of a plan with its ramps from and to rest replaced by what could be run there without the stops.

    Only the ends are planned anew; from where the new plan meets the old one on, the old one stands.
    """
    count = len(feed)
    window = count if count < 3 * _WINDOW else _WINDOW
    out = v.copy()
    for at_end in (False, True):
        part = slice(count - window, count) if at_end else slice(0, window)
        inner = np.ascontiguousarray(control[part.start : part.stop + 3])
        new = fastest_profile(inner, spacing, feed[part], bounds, start=False, end=False)
        free = fine_grid(new, _SAMPLES).v
        if window == count:
            return np.asarray(np.maximum(free, v))
        old = v[part.start * _SAMPLES : part.stop * _SAMPLES + 1]
        if at_end:
            free, old = free[::-1], old[::-1]
        meets = np.flatnonzero(old > 0.99 * free)
        upto = int(meets[0]) if len(meets) else 0
        ramp = np.concatenate([free[:upto], old[upto:]])
        out[part.start * _SAMPLES : part.stop * _SAMPLES + 1] = ramp[::-1] if at_end else ramp
    return out


def _least_between(values: Array, first: NDArray[np.int64], last: NDArray[np.int64]) -> Array:
    """Least of values first .. last (inclusive) for each pair."""
    padded = np.append(values, np.inf)
    pairs = np.column_stack([first, last + 1]).ravel()
    return np.asarray(np.minimum.reduceat(padded, pairs)[::2])


def coarsen(speed: Array, tolerance: float) -> Array:
    """Speeds (P,) in runs as long as can be: never above the given ones, below them by no more than the share `tolerance`.

    Values are rounded down to what a program prints.
    """
    out = np.empty(len(speed))
    start, low = 0, np.inf
    high = 0.0
    values = speed.tolist()
    for i, value in enumerate(values):
        if max(high, value) * (1.0 - tolerance) > min(low, value):
            out[start:i] = low
            start, low, high = i, value, value
        else:
            low, high = min(low, value), max(high, value)
    out[start:] = low
    return np.maximum(np.floor(out / _STEP) * _STEP, _STEP)


def _causes(cell: Cell, bounded: NDArray[np.int64]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the causes in `worst_use`'s order, and the axis of each."""
    names, axes = (
        ["programmed feed", "tool acceleration", "tool rotation speed", "tool rotation acceleration"],
        [""] * 4,
    )
    for k in bounded.tolist():
        names += [f"{cell.names[k]} {what}" for what in ("speed", "acceleration", "jerk")]
        axes += [cell.names[k]] * 3
    return tuple(names), tuple(axes)
