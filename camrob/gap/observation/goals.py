"""Set-points that are none: goals of moves from pose to pose, which jump, while the drives go there in their own time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.observation.signals import pieces_of
from camrob.measurement.log import MeasurementLog

__all__ = ["goal_axes"]

_STILL = 1e-3  # degrees or mm: an axis that moves less tells nothing
_FAR = 5.0  # times the encoder's farthest step from row to row: no drive follows that
_WAY = 0.5  # share of the set-points' way that is made in such steps
_STAIRS = 10.0  # times the encoder's ordinary step, by which set-points that else stand still go on: more than a slow bus makes
_RESTS = 0.05  # of an encoder's farthest step: it rests below


def goal_axes(log: MeasurementLog, axes: Sequence[str]) -> tuple[str, ...]:
    """Axes of a run whose set-points jump from goal to goal, while their encoders move on between."""
    runs = pieces_of(log.t)
    found = []
    for axis in axes:
        commands, encoders = np.asarray(log.columns[f"c{axis}"]), np.asarray(log.columns[axis])
        asked = np.concatenate([np.abs(np.diff(commands[run])) for run in runs])
        made = np.concatenate([np.abs(np.diff(encoders[run])) for run in runs])
        if len(made) == 0 or float(np.ptp(encoders)) < _STILL or not asked.any():
            continue
        far = asked > _FAR * made.max()
        moving = made > _RESTS * made.max()
        held = moving & (asked == 0.0)
        stairs = np.median(asked[asked > 0.0]) > _STAIRS * np.median(made[moving])
        if asked[far].sum() > _WAY * asked.sum() or (held.sum() > _WAY * moving.sum() and stairs):
            found.append(axis)
    return tuple(found)
