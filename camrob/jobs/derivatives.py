"""Where `camrob feed` has machine coordinates from, a solved path or a program, and what is found of their derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.compensate import compensate_postures
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.controller.replay import replay
from camrob.errors import InputError, SingularError
from camrob.jobs.files.solved_path import read_solution
from camrob.kinematics.frames import base_T_tool
from camrob.languages import language_of_file, program_suffixes
from camrob.summaries.feed_summary import DerivativeFigures, KindFigures, PassedBound
from camrob.timing.derivative_analysis import DerivativeAnalysis, Interpolation, analyse_derivatives

__all__ = [
    "SOLVED",
    "Coordinates",
    "analyses_of",
    "calibrated",
    "compensated_by",
    "coordinates_of",
    "derivative_figures",
]

Array = NDArray[np.float64]

_LISTED = 40  # violations in the summary
# rad or m that coordinates are known to: from a solver, and from a program's four decimals
SOLVED, _PRINTED = 1e-6, 2e-6


class Coordinates(NamedTuple):
    """Postures q (N, n) with their source lines (N,), what they are known to, rad or m, and where they are from."""

    q: Array
    line: NDArray[np.int64]
    resolution: float
    source: str


def coordinates_of(file: Path, cell: Cell) -> Coordinates:
    """Of a NAME.path.npz or a program, with lines of the CL file or of the program. Raises InputError, ProgramError."""
    if file.suffix.lower() in program_suffixes():
        program = language_of_file(file).read(file, cell.controller_section)
        found = Coordinates(
            np.asarray(replay(program, cell).q), np.asarray(program.line, np.int64), _PRINTED, file.name
        )
    else:
        found = Coordinates(*read_solution(file, cell), SOLVED, file.name)
    if not np.all(np.isfinite(found.q)):
        raise InputError("holds postures of another cell", hint=f"post it for {cell.name}", path=file)
    if len(np.unique(found.q, axis=0)) < 8:
        raise InputError("holds fewer than 8 different postures", hint="give a longer path", path=file)
    return found


def calibrated(cell: Cell, nominal: Coordinates, calibration: Path) -> Coordinates:
    """The same poses by the calibrated robot. Raises LogError, StaleInputError, SingularError."""
    model, values = read_calibration(calibration, cell).model(cell, in_base=True)
    return compensated_by(cell, nominal, model, values, f"compensated with {calibration.name}")


def compensated_by(cell: Cell, nominal: Coordinates, model: ErrorModel, values: Array, source: str) -> Coordinates:
    """The same poses by a robot with these errors; `source` names them. Raises SingularError."""
    unrolled = np.array(nominal.q)
    unrolled[:, cell.indices(Role.ROLL)] = 0.0  # virtual: no robot has it, and the model's poses don't
    try:
        q = compensate_postures(model, values, nominal.q, base_T_tool(cell, unrolled)).q
    except SingularError as error:
        what = "the pose can't be compensated: the arm is singular there; lead the path past that posture"
        raise SingularError(what, line=int(nominal.line[int(error.value or 0.0)])) from None
    return nominal._replace(q=np.asarray(q), source=source)


def analyses_of(cell: Cell, both: list[Coordinates]) -> dict[str, list[DerivativeAnalysis]]:
    """For each interpolation, the analyses of the nominal coordinates and of the compensated ones where there are any."""
    return {
        kind.value: [
            analyse_derivatives(cell, one.q, line=one.line, interpolation=kind, resolution=one.resolution)
            for one in both
        ]
        for kind in Interpolation
    }


def derivative_figures(analyses: Mapping[str, list[DerivativeAnalysis]], rate: float) -> tuple[DerivativeFigures, ...]:
    """The figures of each analysis at a rate, rad/s."""
    table = []
    for kind, of_kind in analyses.items():
        for which, analysis in zip(("nominal", "compensated"), of_kind, strict=False):
            found = analysis.violations(rate)
            table.append(
                DerivativeFigures(
                    interpolation=kind,
                    coordinates=which,
                    rate_admitted=KindFigures(
                        speed=float(analysis.rate_speed.min()),
                        acceleration=float(analysis.rate_acceleration.min()),
                        jerk=float(analysis.rate_jerk.min()),
                    ),
                    violations=len(found),
                    worst=tuple(
                        PassedBound(axis=v.axis, quantity=v.quantity, s=v.worst_at, line=v.line, times=v.worst)
                        for v in sorted(found, key=lambda v: -v.worst)[:_LISTED]
                    ),
                )
            )
    return tuple(table)
