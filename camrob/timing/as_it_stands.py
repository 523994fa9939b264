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
from camrob.compiled import inlined, kernel
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
    use, code = np.empty((len(square) - 1, 3)), np.empty((len(square) - 1, 3), np.int64)
    _span_uses(np.ascontiguousarray(run.control), run.spacing, np.ascontiguousarray(square), bounds, use, code)
    return use, code


@kernel(nogil=True)
def _span_uses(
    control: Array, h: float, square: Array, bounds: MotionBounds, use: Array, code: NDArray[np.int64]
) -> None:
    """`span_uses`: fills use and code (K, 3). Speed, acceleration and push change evenly over a span: its ends say the most."""
    for i in range(use.shape[0]):
        u = (square[i + 1] - square[i]) / (2.0 * h)
        use[i, :] = 0.0
        code[i, 0], code[i, 1], code[i, 2] = 0, 1, 1
        for side in range(2):
            x = square[i + side]
            v = np.sqrt(x)
            tool = turning = turned = 0.0
            for d in range(3):
                d1, d2 = _two(control, i + side, d, h)
                tool += (d1 * u + d2 * x) ** 2
                d1, d2 = _two(control, i + side, 3 + d, h)
                turning += (d1 * v) ** 2
                turned += (d1 * u + d2 * x) ** 2
            _most(use, code, i, 1, np.sqrt(tool) / bounds.tool_acceleration, 1)
            _most(use, code, i, 0, np.sqrt(turning) / bounds.turn_speed, 2)
            _most(use, code, i, 1, np.sqrt(turned) / bounds.turn_acceleration, 3)
            for k in range(bounds.speed.shape[0]):
                d1, d2 = _two(control, i + side, 6 + k, h)
                d3 = (_two(control, i + 1, 6 + k, h)[1] - _two(control, i, 6 + k, h)[1]) / h
                _most(use, code, i, 0, abs(d1 * v) / bounds.speed[k], 4 + 3 * k)
                _most(use, code, i, 1, abs(d1 * u + d2 * x) / bounds.acceleration[k], 5 + 3 * k)
                _most(use, code, i, 2, abs(d3 * v**3 + 3.0 * d2 * v * u) / bounds.jerk[k], 6 + 3 * k)


@inlined
def _two(control: Array, i: int, d: int, h: float) -> tuple[float, float]:
    """First and second derivative of column d at knot i."""
    a, b, c = control[i, d], control[i + 1, d], control[i + 2, d]
    return (c - a) / (2.0 * h), (c - 2.0 * b + a) / h**2


@inlined
def _most(use: Array, code: NDArray[np.int64], i: int, kind: int, share: float, which: int) -> None:
    if share > use[i, kind] or (share == use[i, kind] and share > 0.0 and which < code[i, kind]):
        use[i, kind], code[i, kind] = share, which
