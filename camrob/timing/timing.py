"""How long a program takes as the controller runs it, and where and why it falls short of its feed.

The model: CP motion on straight pieces with the tool's acceleration `$ACC.CP`, speed and acceleration of its rotation
(`$VEL.ORI1/2`, `$ACC.ORI1/2`), speed and acceleration of every axis, the external ones too; corners rounded within
`$APO.CDIS` (at most half of the shorter neighbour) at the speed that all accelerations allow there; look-ahead without
end, so that the tool slows in time; exact stops where cutting begins or ends. Ramps of jerk are left out: the real
controller is a little slower. The way that a rounded corner saves is left out too. No motion takes less than the cell's
`block_ms` (`block_time`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.frozen import locked
from camrob.redundancy.path import ToolPathInBase
from camrob.timing.block_time import BLOCK_TIME, block_ceilings
from camrob.timing.losses import PROGRAMMED_FEED, FeedLoss, feed_losses, lost_by_axis
from camrob.timing.straight_pieces import PathRates, path_rates

__all__ = ["CAUSES", "Timing", "exact_stops", "program_time"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

CAUSES = (
    PROGRAMMED_FEED,
    "exact stop",
    "tool acceleration",
    "tool rotation speed",
    "tool rotation acceleration",
    BLOCK_TIME,
)
"""What may hold the tool back, before the axes: then come `A1 speed`, ..., and `A1 acceleration`, ..."""
_FEED, _STOP, _TOOL, _TURN, _TURN_UP, _BLOCK, _AXES = range(7)


@dataclass(frozen=True, slots=True)
class Timing:
    """When a program is where. total: s from the path's first point to its last. at: (N,) s at each point.

    speed: (N,) m/s at each point. mean: (N,) m/s on the way to each point, NaN for the first and where the tip stands
    still. cause: (N,) index into `causes` of what held the tool back on the way to the point. losses: runs of cutting
    where the feed is not reached, in order. lost_by_axis: s lost while cutting, by axis ("" where no axis causes it).
    """

    total: float
    at: Array
    speed: Array
    mean: Array
    cause: NDArray[np.int16]
    causes: tuple[str, ...]
    losses: tuple[FeedLoss, ...]

    def __post_init__(self) -> None:
        at = locked(self.at, shape=(None,), name="at")
        object.__setattr__(self, "at", at)
        for name, dtype in (("speed", np.float64), ("mean", np.float64), ("cause", np.int16)):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(len(at),), dtype=dtype, name=name))

    @property
    def lost_by_axis(self) -> dict[str, float]:
        """Seconds lost while cutting, by axis; most first."""
        return lost_by_axis(self.losses)


def exact_stops(path: ToolPathInBase) -> NDArray[np.bool_]:
    """(N,) True where the tool comes to rest in any case: at both ends, where cutting begins or ends, where it is changed."""
    cutting = path.cutting
    stops = np.ones(len(path), np.bool_)
    stops[1:-1] = (cutting[1:-1] != cutting[2:]) | (path.stretch[1:-1] != path.stretch[2:])
    return stops


def program_time(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    *,
    speed: Array,
    stops: NDArray[np.bool_] | None = None,
    motion_ends: NDArray[np.bool_] | None = None,
) -> Timing:
    """Time of a path with postures q (N, n) at `speed` (N,), m/s with which the tool comes to each point, air included.

    stops: (N,) True where the motion ends exactly; by default `exact_stops`. motion_ends: (N,) True where a motion of the program
    ends, by default everywhere: one that stands for several points is one block. Where points are far apart, the axes are
    taken to move evenly between them. Raises ValueError for arrays that don't fit and for speeds that are no positive
    number. Cost: a few microseconds a point.
    """
    speed = np.asarray(speed, float)
    stop = exact_stops(path) if stops is None else np.asarray(stops, bool)
    if speed.shape != (len(path),) or stop.shape != speed.shape:
        raise ValueError(f"speed and stops must have one value for each of {len(path)} points")
    if not np.all(np.isfinite(speed[1:]) & (speed[1:] > 0.0)):
        raise ValueError("speed holds a value that is not a positive number")
    rates = path_rates(cell, path, q)
    count = len(rates.end)
    causes = (
        *CAUSES,
        *(f"{name} speed" for name in cell.names),
        *(f"{name} acceleration" for name in cell.names),
    )
    # a stop at a point that nothing moves to belongs to the end of the last piece before it
    stop_after = np.zeros(count, np.bool_)
    belongs = np.searchsorted(rates.end, np.flatnonzero(stop), side="right") - 1
    stop_after[belongs[belongs >= 0]] = True
    told = np.where(rates.translates, speed[rates.end], np.inf)
    block = block_ceilings(cell, rates, motion_ends)
    why_told = np.where(block < told, _BLOCK, _FEED)
    top, top_cause, push, corner, corner_cause = _ceilings(rates, np.minimum(told, block), why_told, stop_after)
    reached, seconds, cause = _trapezoids(rates.length, top, top_cause, push, corner, corner_cause)
    step = np.zeros(len(path))
    step[rates.end] = seconds
    at = np.cumsum(step)
    at_point = np.zeros(len(path))
    if count:
        at_point = reached[np.searchsorted(rates.end, np.arange(len(path)), side="right")]
    mean, why = np.full(len(path), np.nan), np.zeros(len(path), np.int16)
    mean[rates.end[rates.translates]] = (rates.length / seconds)[rates.translates]
    why[rates.end] = cause
    axes = ("",) * _AXES + 2 * cell.names
    losses = feed_losses(path, speed, step, mean, why, causes, axes)
    return Timing(float(at[-1]) if len(at) else 0.0, at, at_point, mean, why, causes, losses)


@kernel(nogil=True)
def _ceilings(
    rates: PathRates, feed: Array, feed_cause: Indices, stop: NDArray[np.bool_]
) -> tuple[Array, Indices, Array, Array, Indices]:
    """Top speed (M,) with its cause, acceleration along the path (M,), and speed of the M + 1 ends with its cause.

    feed, feed_cause: (M,) the speed that is told or that the block time leaves, inf where there is none, and which it is.
    """
    count, width = rates.rate.shape
    n = width - 6
    top, top_cause = np.empty(count), feed_cause.copy()
    push, corner, corner_cause = np.empty(count), np.zeros(count + 1), np.full(count + 1, _STOP)
    for i in range(count):
        d = rates.rate[i]
        top[i] = feed[i]
        turn = np.sqrt(d[3] * d[3] + d[4] * d[4] + d[5] * d[5])
        push[i] = rates.tool_acceleration
        if turn > 0.0:
            push[i] = min(push[i], rates.rotation_acceleration / turn)
            if rates.rotation_speed < top[i] * turn:
                top[i], top_cause[i] = rates.rotation_speed / turn, _TURN
        for k in range(n):
            share = abs(d[6 + k])
            if share > 0.0:
                push[i] = min(push[i], rates.acceleration[k] / share)
                if rates.speed[k] < top[i] * share:
                    top[i], top_cause[i] = rates.speed[k] / share, _AXES + k
    for i in range(1, count):
        if stop[i - 1]:
            continue
        a, b = rates.rate[i - 1], rates.rate[i]
        # speed at which rounding over `way` on both sides takes no more than each acceleration
        way = min(rates.blend, 0.5 * min(rates.length[i - 1], rates.length[i]))
        square = min(top[i - 1], top[i]) ** 2
        corner_cause[i] = top_cause[i - 1] if top[i - 1] < top[i] else top_cause[i]
        bend = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
        if rates.tool_acceleration * 2.0 * way < square * bend:
            square, corner_cause[i] = rates.tool_acceleration * 2.0 * way / bend, _TOOL
        bend = np.sqrt((b[3] - a[3]) ** 2 + (b[4] - a[4]) ** 2 + (b[5] - a[5]) ** 2)
        if rates.rotation_acceleration * 2.0 * way < square * bend:
            square, corner_cause[i] = rates.rotation_acceleration * 2.0 * way / bend, _TURN_UP
        for k in range(n):
            bend = abs(b[6 + k] - a[6 + k])
            if rates.acceleration[k] * 2.0 * way < square * bend:
                square, corner_cause[i] = rates.acceleration[k] * 2.0 * way / bend, _AXES + n + k
        corner[i] = np.sqrt(square)
    return top, top_cause, push, corner, corner_cause


@kernel(nogil=True)
def _trapezoids(
    length: Array, top: Array, top_cause: Indices, push: Array, corner: Array, corner_cause: Indices
) -> tuple[Array, Array, NDArray[np.int16]]:
    """Speed at the M + 1 ends, seconds on the M pieces, and what held each back; ramps inherit their end's cause."""
    count = length.shape[0]
    v, why = corner.copy(), corner_cause.copy()
    for i in range(count):
        limit = np.sqrt(v[i] * v[i] + 2.0 * push[i] * length[i])
        if limit < v[i + 1]:
            v[i + 1], why[i + 1] = limit, why[i]
    for i in range(count - 1, -1, -1):
        limit = np.sqrt(v[i + 1] * v[i + 1] + 2.0 * push[i] * length[i])
        if limit < v[i]:
            v[i], why[i] = limit, why[i + 1]
    seconds, cause = np.empty(count), np.empty(count, np.int16)
    for i in range(count):
        peak = np.sqrt(0.5 * (v[i] * v[i] + v[i + 1] * v[i + 1]) + push[i] * length[i])
        if peak <= top[i]:
            cause[i] = why[i] if v[i] < v[i + 1] else why[i + 1]
            seconds[i] = (2.0 * peak - v[i] - v[i + 1]) / push[i]
        else:
            c = top[i]
            ramps = (2.0 * c * c - v[i] * v[i] - v[i + 1] * v[i + 1]) / (2.0 * push[i])
            seconds[i] = (2.0 * c - v[i] - v[i + 1]) / push[i] + max(length[i] - ramps, 0.0) / c
            cause[i] = top_cause[i]
            if (top_cause[i] == _FEED or top_cause[i] == _BLOCK) and length[i] < 0.98 * c * seconds[
                i
            ]:  # ramps: the slower end's cause
                cause[i] = why[i] if v[i] < v[i + 1] else why[i + 1]
    return v, seconds, cause
