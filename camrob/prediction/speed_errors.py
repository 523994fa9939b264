"""How far the speed alone carries the tool of the machine as diagnosed off its way: what a lower feed would take off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.cell.cell import Cell
from camrob.gap.fitted_units import FittedUnits
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.prediction.true_path import TruePath, true_path

__all__ = ["SLOWLY", "SpeedErrors", "beside_way", "causes_of_speed", "twist_of"]

Array = NDArray[np.float64]

SLOWLY = 10.0
"""Times the time: what then is less than half as large comes of the speed."""
_CYCLE, _LONGEST = 0.004, 0.02  # s from row to row of the run, and of one that takes long because it is slow
_ROWS = 20_000  # of a run, as long as rows are no farther apart than that
_CHUNK, _BEFORE = 20_000, 500  # rows that are reckoned at once, and rows before them that they are reckoned with: 2 s
_LEAST = 12  # rows: fewer have no speed to speak of
# times what the tool is moved: how far along its way it is looked for, and at how many places
_AROUND, _PLACES = 2.0, 33
_SETTLED = 0.5  # s at an exact stop, where a controller waits until its drives are there: the slowest are within that


def causes_of_speed(path: TruePath, slowly: TruePath) -> frozenset[str]:
    """The causes of a path that come of the speed; slowly: the same way in SLOWLY times the time."""
    return frozenset(
        a.name
        for a, b in zip(path.causes, slowly.causes, strict=True)
        if np.linalg.norm(b.twist[:, :3]) < 0.5 * np.linalg.norm(a.twist[:, :3])
    )


def twist_of(path: TruePath, names: frozenset[str]) -> Array:
    """(N, 6) the part of a path's twists that some of its causes make."""
    return np.asarray(sum((c.twist for c in path.causes if c.name in names), np.zeros((len(path.t), 6))))


def beside_way(way: Array, moved: Array) -> Array:
    """(N, 3) m from the nearest place of a way (N, 3) m, thereabouts, to the tool, which is moved off it by (N, 3) m.

    A tool that is late is on its way still, round a corner, too, where the way on is another.
    """
    done = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1)))
    reach, tool = _AROUND * np.linalg.norm(moved, axis=1), way + moved
    beside, before = moved.copy(), way
    for share in np.linspace(-1.0, 1.0, _PLACES):
        at = done + share * reach
        place = np.stack([np.interp(at, done, column) for column in way.T], axis=1)
        step = place - before if share > -1.0 else np.zeros_like(way)
        length = np.maximum(np.sum(step**2, axis=1), 1e-18)
        along = np.clip(np.sum((tool - before) * step, axis=1) / length, 0.0, 1.0)
        found = tool - before - along[:, None] * step
        nearer = np.sum(found**2, axis=1) < np.sum(beside**2, axis=1)
        beside[nearer], before = found[nearer], place
    return beside


@dataclass(frozen=True)
class SpeedErrors:
    """The machine as diagnosed. constants: of its chain, None for a chain that is as it should be; units: what was found."""

    constants: Calibration | None
    units: FittedUnits

    def across(self, cell: Cell, q: Array, at: Array, stops: NDArray[np.bool_], of_speed: frozenset[str]) -> Array:
        """(N,) m that the tool lies off its way at the most, on the way to each of postures q (N, n) that are reached at
        `at` (N,) s, straight between them in the axes, by the causes `of_speed`; stops: (N,) True at exact stops.

        cell: with the tool that is mounted. What lies along the way is left out: the tool gets there, only later; round a
        corner, too, where it still goes the way before.
        """
        rest = _SETTLED * stops
        at = at + np.cumsum(rest) - rest
        knots = np.stack([at, at + rest], axis=1).ravel()
        cycle = min(max(_CYCLE, (at[-1] - at[0]) / _ROWS), _LONGEST)
        t = np.arange(at[0], at[-1] + cycle, cycle)
        if len(t) < _LEAST:
            return np.zeros(len(at))
        axes = np.repeat(cell.to_axis_values(q), 2, axis=0)
        rows = np.stack([np.interp(t, knots, column) for column in axes.T], axis=1)
        way, moved = np.empty((2, len(t), 3))
        for start in range(0, len(t), _CHUNK):
            stop, begin = min(start + _CHUNK, len(t)), max(0, min(start - _BEFORE, len(t) - _LEAST))
            path = self._path(cell, t[begin:stop], rows[begin:stop])
            way[start:stop] = path.ideal[start - begin :, :3, 3]
            moved[start:stop] = twist_of(path, of_speed)[start - begin :, :3]
        off = np.asarray(np.linalg.norm(beside_way(way, moved), axis=1), np.float64)
        most = np.interp(at, t, off)
        to = np.minimum(np.searchsorted(at, t), len(at) - 1)
        moving = t > (at + rest)[np.maximum(to - 1, 0)]  # what settles at a stop is no part of the way on
        np.maximum.at(most, to[moving], off[moving])
        return most

    def of_speed(self, cell: Cell, q: Array, at: Array) -> frozenset[str]:
        """The causes that come of the speed, at postures q (N, n) reached at `at` (N,) s; cell: with the tool."""
        begin, end = at[0], max(at[-1], at[0] + _LEAST * _CYCLE)
        t = np.linspace(begin, end, int(np.clip((end - begin) / _CYCLE, _LEAST, _CHUNK)))
        rows = np.stack([np.interp(t, at, column) for column in cell.to_axis_values(q).T], axis=1)
        return causes_of_speed(self._path(cell, t, rows), self._path(cell, SLOWLY * t, rows))

    def _path(self, cell: Cell, t: Array, rows: Array) -> TruePath:
        """The machine's path at axis values (M, k) at times t (M,)."""
        columns = {"t": t, "line": np.zeros(len(t))}
        for name, values in zip(cell.axis_names, rows.T, strict=True):
            columns[name] = columns[f"c{name}"] = values
        return true_path(MeasurementLog(columns, LogInfo()), cell, self.constants, self.units, rest=0.0)
