"""What a diagnosis and a calibration say of a machine, as jobs read it from their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.calibration.calibration import Calibration
from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.gap.cell_effects import cell_effects
from camrob.gap.effects.registry import library
from camrob.gap.fitted_units import FittedUnits, fitted_units
from camrob.jobs.files.summary_file import read_summary
from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.units import mm_to_m

__all__ = ["diagnosed"]


def diagnosed(
    folder: Path | None, calibration: Calibration | None, cell: Path, machine: Cell
) -> tuple[FittedUnits | None, float]:
    """What a diagnosis found, None without one, and m in one direction that stays unexplained beside its field over posture.
    Where it has none, as none was found or it is older, that is all that stays on withheld samples, alike everywhere.
    """
    if folder is None:
        if calibration is None:
            hint = "give --calibration FITTED.toml, --diagnosis DIR, or both where one command wrote them"
            raise InputError("nothing says what is wrong with the machine", hint=hint)
        size = calibration.errors.get("calibrated/withheld")
        if size is None:
            hint = "calibrate with withheld poses, or give --diagnosis"
            raise InputError("the calibration does not say how far it is off", hint=hint)
        return None, size.rms / np.sqrt(3.0)
    file = Path(folder) / "diagnosis.json"
    if not file.is_file():
        hint = "give the folder that `camrob diagnose --out` wrote"
        raise InputError("is a file" if Path(folder).is_file() else "holds no diagnosis.json", hint=hint, path=folder)
    found = read_summary(file, hint="diagnose the logs again")
    try:
        said = DiagnosisSummary.from_json(found)
    except (ValueError, InputError) as error:
        what = "is not a diagnosis that this camrob reads: it may be an older one's"
        raise InputError(what, hint="diagnose the logs again", path=file) from error
    if said.compensable.fitted is None:
        raise InputError("holds no fitted units", hint="diagnose again with this camrob", path=file)
    units = fitted_units(said.compensable.fitted, library(extra=cell_effects(cell, machine)))
    if units.unexplained is not None:
        return units, units.unexplained.rest
    return units, mm_to_m(said.unexplained_mm) / float(np.sqrt(3.0))
