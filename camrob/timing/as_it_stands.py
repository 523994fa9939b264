"""What a program's own feed asks of tool and axes: limits it passes and where, its time once it keeps them, axis motion.

The controller's model (`timing`) knows speed and acceleration only. Here its speed profile is laid onto the same smooth
curve that a feed is planned on, so that jerk has a meaning, and held to the same limits as the plan. What the corners of
its ramps add to the jerk is left out (in the model they are without bound), so that what is found is the least.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.redundancy.path import ToolPathInBase
from camrob.timing.block_time import block_ceilings
from camrob.timing.optimal import FeedPlan
from camrob.timing.path_spline import MotionBounds
from camrob.timing.smooth_runs import SmoothRun, cause_names, piece_feeds, run_bounds, run_pieces, smooth_run
from camrob.timing.straight_pieces import PathRates, path_rates
from camrob.timing.timing import Timing, exact_stops

__all__ = ["AsItStands", "PassedLimit", "program_as_it_stands", "ramped_squares", "span_uses"]

Array = NDArray[np.float64]

_KINDS = ("speed", "acceleration", "jerk")
_OVER = 1.0 + 1e-6  # a use of 1 is the limit itself; what lies beyond by rounding is none
_STRETCH = 100_000  # pieces of a cut whose curve is held at a time, so that memory doesn't grow with the cut
_BESIDE = 300  # pieces that such a curve takes along on either side: its own ends are none of the cut's


class PassedLimit(NamedTuple):
    """The place where a program takes most of the limits on `kind`: `times` of `cause`'s limit, 1 being all of it.

    axis: the axis whose limit it is, "" for the tool's. point, line: of the path and the CL file.
    """

    kind: str
    times: float
    cause: str
    axis: str
    point: int
    line: int


@dataclass(frozen=True, slots=True)
class AsItStands:
    """A program at its own feed. worst: for speed, acceleration and jerk the place of most use; past: share of the way
    of cutting on which any limit is passed.

    total, cutting: s, each cut slowed evenly (as by the override switch) until it keeps all limits; override: the least
    share of any cut. speed, acceleration: (N, n) of the joints at each point as it will be run, 0 in air.
    """

    worst: tuple[PassedLimit, ...]
    past: float
    total: float
    cutting: float
    override: float
    speed: Array
    acceleration: Array

    def __post_init__(self) -> None:
        count, n = np.shape(self.speed)
        for name in ("speed", "acceleration"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count, n), name=name))


def program_as_it_stands(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    timing: Timing,
    *,
    speed: Array,
    plan: FeedPlan | None = None,
    programmed: Array | None = None,
    motion_ends: NDArray[np.bool_] | None = None,
) -> AsItStands:
    """Judge a path with postures q (N, n) at `speed` (N,), m/s, timed as `timing`.

    programmed: (N,) m/s of the CL file, by default `speed`: the curve is smoothed for it, as the plan's is.
    plan: the feed that is run instead, whose motion the joints' speeds and accelerations then are. motion_ends: (N,)
    True where a motion of the program ends, by default everywhere. Raises ValueError for
    arrays that don't fit. Cost: linear, about ten microseconds a span.
    """
    rates = path_rates(cell, path, q)
    bounds, bounded = run_bounds(rates)
    told = piece_feeds(rates, speed)
    feed = np.minimum(told, block_ceilings(cell, rates, motion_ends))
    smooth_for = told if programmed is None else piece_feeds(rates, programmed)
    seconds = np.diff(timing.at, prepend=0.0)
    motion = np.zeros((2, *np.shape(q)))
    most, found = np.zeros(3), [(0, 0)] * 3
    past, way, override, slowed = 0.0, 0.0, 1.0, float(np.sum(seconds[path.cutting]))
    for pieces in run_pieces(rates, path, exact_stops(path)):
        peak = np.zeros(3)
        for wide, counted in _stretches(pieces):
            run = smooth_run(rates, wide, bounded, smooth_for[wide])
            square, ends = ramped_squares(rates, run, timing.speed, feed)
            use, which = span_uses(run, square, bounds)
            own = slice(counted.start - wide.start, counted.stop - wide.start)
            spans = slice(*np.ceil(run.length[[own.start, own.stop]] / run.spacing - 0.5).astype(np.int64).tolist())
            here = use[spans].max(axis=0, initial=0.0)
            for k in np.flatnonzero(here > most):
                span = spans.start + int(np.argmax(use[spans, k]))
                place = np.searchsorted(run.length, (span + 0.5) * run.spacing) - 1
                most[k], found[k] = here[k], (int(rates.end[wide][place]), int(which[span, k]))
            peak = np.maximum(peak, here)
            past += float(np.count_nonzero(use[spans].max(axis=1) > _OVER)) * run.spacing
            way += float(run.length[own.stop] - run.length[own.start])
            points = rates.end[counted]
            v, u = (ends[0][1:][own], ends[1][1:][own]) if plan is None else (plan.planned[points], plan.push[points])
            d1, d2 = (d[:, 6:] for d in run.derivatives(run.length[1:][own]))
            motion[0][np.ix_(points, bounded)] = d1 * v[:, None]
            motion[1][np.ix_(points, bounded)] = d1 * u[:, None] + d2 * v[:, None] ** 2
        share = 1.0 / max(1.0, peak[0], np.sqrt(peak[1]), np.cbrt(peak[2]))
        override = min(override, share)
        slowed += float(np.sum(seconds[rates.end[pieces]])) * (1.0 / share - 1.0)
    causes, axes = cause_names(cell.names, bounded)
    worst = tuple(
        PassedLimit(kind, float(times), causes[code], axes[code], point, int(path.line[point]))
        for kind, times, (point, code) in zip(_KINDS, most, found, strict=True)
    )
    air = float(np.sum(seconds[~path.cutting]))
    return AsItStands(worst, past / way if way > 0.0 else 0.0, slowed + air, slowed, override, motion[0], motion[1])


def _stretches(pieces: slice) -> Iterator[tuple[slice, slice]]:
    """Stretches of a run's pieces: those that a curve is laid through, and those of them that it is judged on."""
    for start in range(pieces.start, pieces.stop, _STRETCH):
        stop = min(start + _STRETCH, pieces.stop)
        yield slice(max(start - _BESIDE, pieces.start), min(stop + _BESIDE, pieces.stop)), slice(start, stop)


def ramped_squares(rates: PathRates, run: SmoothRun, reached: Array, feed: Array) -> tuple[Array, tuple[Array, Array]]:
    """Square speeds (K + 1,) at a run's knots as the controller's model ramps; speed and push (P + 1,) at its pieces' ends.

    reached: (N,) m/s at the path's points by that model (`Timing.speed`). feed: (M,) m/s of the path's pieces.
    """
    pieces = run.pieces
    rate = np.abs(rates.rate[pieces])
    turn = np.linalg.norm(rates.rate[pieces, 3:6], axis=1)
    with np.errstate(divide="ignore"):
        push = np.minimum(rates.tool_acceleration, rates.rotation_acceleration / turn)
        push = np.minimum(push, np.min(rates.acceleration / rate[:, 6:], axis=1))
        top = np.minimum(feed[pieces], rates.rotation_speed / turn)
        top = np.minimum(top, np.min(rates.speed / rate[:, 6:], axis=1)) ** 2
    ends = np.concatenate([[0.0], reached[rates.end[pieces]] ** 2])
    at = run.spacing * np.arange(len(run.feed) + 1)
    k = np.clip(np.searchsorted(run.length, at, side="right") - 1, 0, len(push) - 1)
    up = ends[k] + 2.0 * push[k] * np.maximum(at - run.length[k], 0.0)
    down = ends[k + 1] + 2.0 * push[k] * np.maximum(run.length[k + 1] - at, 0.0)
    square = np.minimum(np.minimum(up, down), top[k])
    mean = 0.5 * np.diff(ends) / np.diff(run.length)
    own = np.concatenate([mean[:1], 0.5 * (mean[1:] + mean[:-1]), mean[-1:]])
    return square, (np.sqrt(ends), own)


def span_uses(run: SmoothRun, square: Array, bounds: MotionBounds) -> tuple[Array, NDArray[np.int64]]:
    """Share (K, 3) of the limits on speed, acceleration and jerk that each span takes, and which one that is (K, 3)."""
    h, c = run.spacing, run.control
    d1 = (c[2:] - c[:-2]) / (2.0 * h)
    d2 = (c[2:] - 2.0 * c[1:-1] + c[:-2]) / h**2
    d3 = np.diff(d2, axis=0) / h
    u = np.diff(square) / (2.0 * h)
    shares = np.zeros((len(u), 3, 2 + len(bounds.speed)))
    for side in (slice(None, -1), slice(1, None)):
        x = square[side][:, None]
        v = np.sqrt(x)
        accelerations = d1[side] * u[:, None] + d2[side] * x
        jerks = d3 * v**3 + 3.0 * d2[side] * v * u[:, None]
        now = np.zeros_like(shares)
        now[:, 0, 1] = np.linalg.norm(d1[side][:, 3:6] * v, axis=1) / bounds.turn_speed
        now[:, 0, 2:] = np.abs(d1[side][:, 6:] * v) / bounds.speed
        now[:, 1, 0] = np.linalg.norm(accelerations[:, :3], axis=1) / bounds.tool_acceleration
        now[:, 1, 1] = np.linalg.norm(accelerations[:, 3:6], axis=1) / bounds.turn_acceleration
        now[:, 1, 2:] = np.abs(accelerations[:, 6:]) / bounds.acceleration
        now[:, 2, 2:] = np.abs(jerks[:, 6:]) / bounds.jerk
        shares = np.maximum(shares, now)
    which = np.argmax(shares, axis=2)
    code = np.where(which >= 2, 4 + 3 * (which - 2) + np.arange(3), np.array([[0, 1, 1]]))
    code = np.where(which == 1, np.array([[2, 3, 3]]), code)
    return shares.max(axis=2), code
