"""What the machine's speed does to a job's path, as its diagnosis has it; apart, because few posts read a diagnosis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration_file import read_calibration
from camrob.errors import InputError
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.feed_within import OffAtSpeed
from camrob.jobs.solving.sought import Sought
from camrob.prediction.speed_errors import SpeedErrors
from camrob.timing.timing import exact_stops

__all__ = ["machine_at_speed"]

Array = NDArray[np.float64]


def machine_at_speed(sought: Sought, inputs: JobInputs) -> OffAtSpeed:
    """From postures (N, n) and times (N,) of a job's path to what the speed carries the tool off across its way, (N,) m.

    Raises InputError and its kin for files that are wrong or don't belong together.
    """
    found = None if sought.calibration is None else read_calibration(sought.calibration, inputs.cell)
    units = diagnosed(sought.diagnosis, found, sought.cell, inputs.cell)[0]
    if units is None:
        raise InputError("holds no fitted units", hint="diagnose again with this camrob", path=sought.diagnosis)
    errors, stops = SpeedErrors(found, units), exact_stops(inputs.path)

    causes: dict[int, frozenset[str]] = {}

    def across(q: Array, at: Array) -> Array:
        off = np.zeros(len(at))
        for k, (where, mounted) in enumerate(zip(inputs.path.stretches, inputs.mounted, strict=True)):
            if k not in causes:  # by the first run, which is the fastest
                causes[k] = errors.of_speed(mounted.cell, q[where], at[where])
            off[where] = errors.across(mounted.cell, q[where], at[where], stops[where], causes[k])
        return off

    return across
