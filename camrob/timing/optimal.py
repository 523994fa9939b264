"""The fastest feed along a path: as fast as the programmed feed, the axes and the tool allow, slowing in time.

Cutting is planned run by run between exact stops, with speed, acceleration and jerk of every axis, the external ones too,
acceleration of the tool and speed and acceleration of its rotation; moves through air keep the controller model's time.
What is written into the program, `speed`, leaves the ramps at stops to the controller.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.timing.block_time import BLOCK_TIME, block_ceilings
from camrob.timing.losses import FeedLoss, feed_losses, lost_by_axis
from camrob.timing.path_spline import MotionBounds
from camrob.timing.profile import fastest_profile, fine_grid, worst_use
from camrob.timing.smooth_runs import (
    SmoothRun,
    cause_names,
    least_between,
    piece_feeds,
    run_bounds,
    run_pieces,
    smooth_run,
)
from camrob.timing.straight_pieces import PathRates, path_rates
from camrob.timing.timing import exact_stops, program_time

__all__ = ["FeedPlan", "coarsen", "optimal_feed"]

Array = NDArray[np.float64]

_SAMPLES = 4  # a span, for times between points
_FINER = 10  # times finer: the grid that the plan is checked on
_GAP = 1e-4  # of the time: as near to the optimum as a program needs
_LONG = 4  # spans: on a longer piece the program says its top speed, for the controller itself slows before a corner
_WINDOW = 500  # spans at each end that are planned anew without the stop
_STEP = 1e-5  # m/s: `$VEL.CP` is printed so, rounded down here


@dataclass(frozen=True, slots=True)
class FeedPlan:
    """A planned feed. speed: (N,) m/s to write as `$VEL.CP` for the motion to each point (rapid in air).

    planned, push: (N,) m/s and m/s2 at each point; at: (N,) s. total: s, cutting: s of it at the programmed feed's moves;
    unjerked: s that cutting would take were jerk without bounds. use: the largest share of the bounds on "speed",
    "acceleration" and "jerk" that is taken anywhere on a 10 times finer grid; 1.0 is all. cause: (N,) index into `causes`
    of what binds most on the way to a point; losses: where the plan stays below the programmed feed. changes: how often
    `speed` changes. deviation: m that the planned curve rounds the program's corners at most. free: (F,) m/s that could be
    run without the stops of cutting, on a fine grid; place: (F,) where that is, in points (1.5: half-way from 1 to 2).
    """

    speed: Array
    planned: Array
    push: Array
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
    free: Array
    place: Array

    def __post_init__(self) -> None:
        speed = locked(self.speed, shape=(None,), name="speed")
        object.__setattr__(self, "speed", speed)
        for name in ("planned", "push", "at", "cause"):
            dtype = np.int16 if name == "cause" else np.float64
            object.__setattr__(self, name, locked(getattr(self, name), shape=(len(speed),), dtype=dtype, name=name))
        for name in ("free", "place"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(None,), name=name))

    @property
    def lost_by_axis(self) -> dict[str, float]:
        """Seconds lost while cutting, by axis; most first."""
        return lost_by_axis(self.losses)


class _Planned(NamedTuple):
    """A run's plan: at its P pieces' ends v, u (P + 1,), seconds (P,), ceilings (P,), causes (P,); and for the whole.

    free: (F,) m/s without the stops at lengths (F,), m.
    """

    v: Array
    u: Array
    seconds: Array
    ceiling: Array
    cause: NDArray[np.int64]
    unjerked: float
    use: Array
    free: Array
    length: Array


def optimal_feed(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    *,
    rapid_speed: float,
    stops: NDArray[np.bool_] | None = None,
    motion_ends: NDArray[np.bool_] | None = None,
    tolerance: float = 0.02,
    progress: Share | None = None,
) -> FeedPlan:
    """The fastest feed of a path with postures q (N, n) under its programmed feed; air at `rapid_speed`, m/s.

    stops: (N,) True where the tool comes to rest, by default `exact_stops`. motion_ends: (N,) True where a motion of the program
    ends, by default everywhere, for the controller's block time. tolerance: how far `speed` may stay below the
    plan so that it changes rarely; it is never above it. Raises ValueError for arrays that don't fit. Cost: linear;
    about 0.1 ms a millimetre of path.
    """
    programmed = np.where(path.cutting, path.feed, rapid_speed)
    stop = exact_stops(path) if stops is None else np.asarray(stops, bool)
    slow = program_time(cell, path, q, speed=programmed, stops=stop, motion_ends=motion_ends)
    rates = path_rates(cell, path, q)
    bounds, bounded = run_bounds(rates)
    step = np.diff(slow.at, prepend=0.0)
    planned, speed, push = slow.speed.copy(), programmed.copy(), np.zeros(len(path))
    cause = np.zeros(len(path), np.int16)
    unjerked, use, deviation = 0.0, np.zeros(3), 0.0
    commanded, block = piece_feeds(rates, programmed), block_ceilings(cell, rates, motion_ends)
    feed = np.minimum(commanded, block)
    runs = run_pieces(rates, path, stop)
    free, place = [np.zeros(0)], [np.zeros(0)]
    for k, pieces in enumerate(runs):
        run = smooth_run(rates, pieces, bounded, feed[pieces])
        plan = _plan(run, bounds)
        ends = rates.end[pieces]
        planned[ends], push[ends], step[ends], cause[ends] = plan.v[1:], plan.u[1:], plan.seconds, plan.cause
        speed[ends] = coarsen(np.minimum(plan.ceiling, programmed[ends]), tolerance)
        unjerked, use = unjerked + plan.unjerked, np.maximum(use, plan.use)
        deviation = max(deviation, run.deviation)
        free.append(plan.free)
        place.append(_in_points(run, ends, plan.length))
        if progress is not None:
            progress((k + 1) / len(runs))
    mean = _mean_speeds(rates, step)
    causes, axes = cause_names(cell.names, bounded)
    causes, axes = (*causes, BLOCK_TIME), (*axes, "")
    short = np.zeros(len(path), np.bool_)
    short[rates.end] = block < commanded
    cause[short & (cause == 0)] = len(causes) - 1
    at = np.cumsum(step)
    return FeedPlan(
        speed=speed,
        planned=planned,
        push=push,
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
        free=np.concatenate(free),
        place=np.concatenate(place),
    )


def _plan(run: SmoothRun, bounds: MotionBounds) -> _Planned:
    """Plan one run from rest to rest, and once more without its stops for what the program says."""
    count = len(run.feed)
    resting = fastest_profile(run.control, run.spacing, run.feed, bounds, gap=_GAP)
    use, which = worst_use(run.control, resting, bounds, run.feed, _FINER)
    grid = fine_grid(resting, _SAMPLES)
    at = np.interp(run.length, grid.s, grid.at)
    free = _without_stops(run.control, run.spacing, run.feed, bounds, grid.v)
    parts = np.lib.stride_tricks.sliding_window_view(free, _SAMPLES + 1)[::_SAMPLES]
    least = least_between(parts.min(axis=1), run.first, run.last)
    most = -least_between(-parts.max(axis=1), run.first, run.last)
    ceiling = np.where(run.last - run.first < _LONG, least, most)
    v, u = np.interp(run.length, grid.s, grid.v), np.interp(run.length, grid.s, grid.u)
    v[[0, -1]] = u[[0, -1]] = 0.0
    # what holds a piece back is what binds on the span that loses most of its time
    lost = np.diff(grid.at[::_SAMPLES]) - run.spacing / run.feed
    rank = np.empty(count)
    rank[np.argsort(lost, kind="stable")] = np.arange(count)
    worst = np.argsort(rank)[(-least_between(-rank, run.first, run.last)).astype(np.int64)]
    return _Planned(v, u, np.diff(at), ceiling, which[worst], resting.shortest_time, use.max(axis=0), free, grid.s)


def _mean_speeds(rates: PathRates, step: Array) -> Array:
    """Mean speed (N,) on the way to each point for seconds (N,), m/s; NaN where the tip stands still."""
    mean = np.full(len(step), np.nan)
    travels = rates.end[rates.translates]
    mean[travels] = rates.length[rates.translates] / step[travels]
    return mean


def _in_points(run: SmoothRun, ends: NDArray[np.int64], length: Array) -> Array:
    """Lengths (F,) of a run, m, as places in points; `ends` (P,) are the points that its pieces lead to."""
    piece = np.clip(np.searchsorted(run.length, length, side="left") - 1, 0, len(ends) - 1)
    share = (length - run.length[piece]) / np.diff(run.length)[piece]
    return np.asarray(ends[piece] - 1.0 + np.clip(share, 0.0, 1.0))


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
        new = fastest_profile(inner, spacing, feed[part], bounds, start=False, end=False, gap=_GAP)
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
