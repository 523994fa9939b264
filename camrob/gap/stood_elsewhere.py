"""Runs between which the instrument was set up anew, though their logs say one frame: each then has a frame of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camrob.gap.effects.measurement_drift import APART
from camrob.gap.evidence.model import Model
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame

__all__ = ["moved_between", "own_frame", "stood_elsewhere"]

# times what stays otherwise: less may be what a cause does in one part of the work space and not in another
_FARTHER = 3.0
# of the energy of what stays, that frames of their own leave at the most, where the logs lie less far apart
_LESS = 0.5


def moved_between(model: Model) -> bool:
    """Whether the best set says that the instrument's frame is elsewhere on one log than on the first."""
    return any(model.units[i].key.startswith(APART) for i in model.best.members)


def stood_elsewhere(model: Model, own: Model) -> bool:
    """Whether logs have frames of their own: the frame is farther off from log to log than all that the best set leaves, or what
    stays is far less with a frame a log (own: the same logs, laid out so).
    """
    rms = []
    for i in model.best.members:
        name = model.units[i].key.removeprefix(APART)
        values = model.values(frozenset([i]), model.best)
        rms += [
            float(np.sqrt(np.mean(np.sum(p.moves(values) ** 2, axis=1)))) for p in model.panels if p.scene.name == name
        ]
    return max(rms, default=0.0) > _FARTHER * _left(model) or _left(own) ** 2 < _LESS * _left(model) ** 2


def _left(model: Model) -> float:
    """m: noise, discrepancy, and what is beyond both."""
    return float(np.linalg.norm([model.noise, model.discrepancy, model.excess]))


def own_frame(log: MeasurementLog) -> MeasurementLog:
    """A log whose instrument may have stood anywhere."""
    return MeasurementLog(log.columns, replace(log.info, measured_frame=MeasuredFrame.UNKNOWN), log.path)
