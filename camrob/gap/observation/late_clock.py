"""Recordings that were begun apart: how far, by how fast the tool moves, whatever frame sees it; and brought together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.measurements import sampled_rows
from camrob.cell.cell import Cell
from camrob.gap.observation.scene import make_scene
from camrob.gap.observation.signals import delayed, pieces_of
from camrob.measurement.log import AXES, CURRENT, EXTERNAL, EXTERNAL_TORQUE, MOTOR, TORQUE, MeasurementLog
from camrob.units import mm_to_m

__all__ = ["CommonClock", "brought_together"]

Array = NDArray[np.float64]

_FAR = mm_to_m(30.0)  # that no gap of a working cell is larger than
_FARTHEST = 5.0  # s that clocks are tried apart
_LEAST = 50  # rows
_MANY = 5000  # rows that tell it, of those from the first on
_LEFT = 0.2  # of the gap that may be left, for the clock to be its cause
_TRIES = 5  # steps to either side, ever finer
_BESIDE = (*AXES, *EXTERNAL, *(f"c{n}" for n in AXES + EXTERNAL), *TORQUE, *EXTERNAL_TORQUE, *MOTOR, *CURRENT)


@dataclass(frozen=True, slots=True)
class CommonClock:
    """Logs with what the controller says brought to the time of the readings, and by how many s, by log; 0 where it was there."""

    logs: tuple[MeasurementLog, ...]
    delays: tuple[float, ...]


def brought_together(logs: Sequence[MeasurementLog], cells: Sequence[Cell]) -> CommonClock:
    """Logs whose readings come so late behind their axis values, or before them, that this alone is nearly all of an incredible
    gap: two recordings that were laid beside each other. Others are as they were.
    """
    found = [_late(log, cell) for log, cell in zip(logs, cells, strict=True)]
    moved = tuple(_moved(log, d) if d else log for log, d in zip(logs, found, strict=True))
    return CommonClock(moved, tuple(found))


def _late(log: MeasurementLog, cell: Cell) -> float:
    """s by which the readings of a run trail its axis values; 0 where its gap is no such one."""
    if (
        log.info.poses
        or not log.has_position
        or len(log) < _LEAST
        or not all(log.has(n) or log.has(f"c{n}") for n in cell.axis_names)
    ):
        return 0.0
    scene = make_scene(log.select(sampled_rows(len(log), _MANY)), cell)
    whole = float(np.median(np.linalg.norm(scene.tcp_gap[:, :3], axis=1)))
    if whole <= _FAR:
        return 0.0
    log = log.select(slice(_MANY))
    scene = make_scene(log, cell)
    step = float(np.median(np.diff(scene.t)))
    grid = np.arange(scene.t[0], scene.t[-1], step)
    seen, axes = (_speeds(grid, scene.t, p[:, :3, 3]) for p in (scene.measured, scene.nominal))
    farthest = min(int(_FARTHEST / step), len(grid) // 2)
    lags = np.arange(-farthest, farthest + 1)
    delay = step * float(lags[int(np.argmax([_likeness(seen, axes, int(k)) for k in lags]))])
    left = whole
    for finer in (step, step / _TRIES, step / _TRIES**2):
        tried = [(_left(log, cell, d), d) for d in delay + finer * np.arange(-_TRIES, _TRIES + 1)]
        left, delay = min(tried)
    return float(delay) if left < _LEFT * whole else 0.0


def _left(log: MeasurementLog, cell: Cell, delay: float) -> float:
    """m: the median gap of a log, had its readings been taken `delay` s before."""
    return float(np.median(np.linalg.norm(make_scene(_moved(log, delay), cell).tcp_gap[:, :3], axis=1)))


def _moved(log: MeasurementLog, delay: float) -> MeasurementLog:
    """A log with what the controller says as it was `delay` s before; without rows of which it says nothing then."""
    names = [n for n in _BESIDE if n in log.columns and not np.isnan(log.columns[n]).all()]
    whole = log.select(
        np.flatnonzero(log.complete([n for n in names if n in log.axis_names or n[1:] in log.axis_names]))
    )
    pieces = pieces_of(whole.t)
    known = [n for n in names if not np.isnan(whole.columns[n]).any()]
    then = delayed(whole.matrix(known), whole.t, pieces, delay)
    inside = np.zeros(len(whole), bool)
    for run in pieces:
        own = whole.t[run]
        inside[run] = (own - delay >= own[0]) & (own - delay <= own[-1])
    columns = {n: v for n, v in whole.columns.items() if n in known or n not in names} | dict(
        zip(known, then.T, strict=True)
    )
    return MeasurementLog(columns, log.info, log.path, whole.file_lines).select(np.flatnonzero(inside))


def _speeds(grid: Array, t: Array, place: Array) -> Array:
    """m/s on a grid of times, of places (N, 3)."""
    smooth = np.stack([np.interp(grid, t, p) for p in place.T], axis=1)
    return np.asarray(np.linalg.norm(np.gradient(smooth, grid, axis=0), axis=1))


def _likeness(seen: Array, axes: Array, lag: int) -> float:
    """Correlation of two courses, the first `lag` steps behind."""
    count = len(seen) - abs(lag)
    a, b = seen[max(lag, 0) :][:count], axes[max(-lag, 0) :][:count]
    return float(np.corrcoef(a, b)[0, 1]) if a.std() > 0.0 and b.std() > 0.0 else -1.0
