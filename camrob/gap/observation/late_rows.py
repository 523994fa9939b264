"""Encoder values, or set-points, that a recorder writes some rows late: brought to the others before anything is compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.gap.observation.mistakes.mistaken_drives import made_of_encoders
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import MeasurementLog

__all__ = ["rows_in_time"]

Array = NDArray[np.float64]

_MANY = 5000  # rows that tell it, of those from the first on
_LEAST = 100  # rows
_FARTHEST = 10  # rows that they are late at the most
# of a row: how far off a whole number of them the delays of all axes, and of each, are at the most
_WHOLE, _AXIS = 0.1, 0.25
_EVEN = 0.1  # of the step in time that rows differ by at the most
_STILL = 1e-3  # of the fastest axis: a slower one tells no delay


def rows_in_time(log: MeasurementLog, cell: Cell) -> tuple[MeasurementLog, str]:
    """A log with encoder values and set-points of one time, and what is to be said of that; itself and "" where they were.

    Encoder values that all trail their set-points by a whole number of rows, and their readings by the same: the two agree, and
    a recorder that writes encoders a cycle late is one cause where a delay of every drive and an instrument that is as early are
    two. Set-points that trail all encoders by a whole number: no drive is ahead of what it was told.
    """
    found = _late_rows(log, cell)
    if found is None:
        return log, ""
    kind, rows = found
    name, step = log.name, float(np.median(np.diff(log.t)))
    by = f"{rows} row{'s' if rows > 1 else ''} ({rows * step:.3f} s)"
    if kind:
        words = f"the set-points of {name} stand {by} behind its encoder values, which no drive is ahead of"
    else:
        words = (
            f"the encoder values of {name} stand {by} behind its set-points and readings, which agree (drives that are all so "
            "late, read by an instrument that is as early, would look the same)"
        )
    return _earlier(log, [f"{kind}{a}" for a in cell.axis_names], rows), f"{words}: they were brought together"


def _late_rows(log: MeasurementLog, cell: Cell) -> tuple[str, int] | None:
    """Which columns are late ("" or "c" before an axis's name), and by how many rows; None where none are."""
    names = [f"{kind}{a}" for a in cell.axis_names for kind in ("", "c")]
    if log.info.poses or len(log) < _LEAST or not log.has(*names):
        return None
    steps = np.diff(log.t)
    step = float(np.median(steps))
    part = log.select(slice(_MANY))
    if np.abs(steps - step).max() > _EVEN * step or part.complete([*names, *part.place_names]).sum() < _LEAST:
        return None
    scene = make_scene(part, cell)
    if scene.setpoint is None or scene.encoder is None:
        return None
    behind, each = _behind_setpoints(scene)
    count = round(behind / step)
    whole = abs(behind / step - count) < _WHOLE and np.abs(each / step - count).max() < _AXIS
    if not whole or not 1 <= abs(count) <= _FARTHEST:
        return None
    if count < 0:
        told, is_ = np.asarray(scene.setpoint), np.asarray(scene.encoder)
        # a program's own values, which are refused, look late too
        made = (made_of_encoders(told[:, k], is_[:, k], axis) for k, axis in enumerate(scene.axes))
        return None if any(made) else ("c", -count)
    ahead = _readings_ahead(scene) if scene.tracked else 0.0
    return ("", count) if abs(ahead / step - count) < _WHOLE else None


def _behind_setpoints(scene: Scene) -> tuple[float, Array]:
    """s by which encoders trail their set-points: all together, and each axis that moves."""
    told, is_ = np.asarray(scene.setpoint), np.asarray(scene.encoder)
    speed = scene.velocity(0.5 * (told + is_))
    moved = np.sum(speed**2, axis=0)
    along = -np.sum((is_ - told) * speed, axis=0)
    moves = moved > _STILL * moved.max()
    return float(along.sum() / max(moved.sum(), 1e-30)), along[moves] / moved[moves]


def _readings_ahead(scene: Scene) -> float:
    """s by which readings are ahead of the encoder values that stand beside them."""
    speed = scene.told(scene.velocity(scene.nominal[:, :3, 3]))
    moved = float(np.sum(speed**2))
    return float(np.sum(scene.tcp_gap[:, :3] * speed)) / max(moved, 1e-30)


def _earlier(log: MeasurementLog, names: Sequence[str], rows: int) -> MeasurementLog:
    """A log with some columns `rows` rows earlier; without the last rows, which then have none."""
    columns = {n: v[rows:] if n in names else v[:-rows] for n, v in log.columns.items()}
    lines = None if log.file_lines is None else log.file_lines[:-rows]
    return MeasurementLog(columns, log.info, log.path, lines)
