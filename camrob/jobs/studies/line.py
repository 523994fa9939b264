"""`camrob study line`: speed, acceleration and jerk of the axes on the straight line of a cell's published case."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.jobs.derivatives import SOLVED, Coordinates, analyses_of, calibrated, compensated_by
from camrob.jobs.feed import FeedResult, derivatives, written
from camrob.jobs.files.takes_paths import takes_paths
from camrob.kinematics.frames import base_T_tool
from camrob.progress import Progress, silent
from camrob.report.derivatives.statements import derivative_statements
from camrob.studies.published_file import own_case
from camrob.studies.published_robot import case_line, drawn_errors
from camrob.units import m_to_mm

__all__ = ["line"]


@takes_paths
def line(
    *,
    cell: Path,
    out: Path,
    calibration: Path | None = None,
    axis: str | None = "all",
    rate: float = 1.0,
    progress: Progress | None = None,
) -> FeedResult:
    """Write feed.html and feed.json into `out`: the derivatives of the axes on the line of the cell's published.toml.

    Beside the nominal ones stand those compensated for the errors that the case draws, or with a calibration (CALIBRATION.toml).
    axis: whose curves are drawn. rate: rad/s. Raises InputError where the cell has no such case; UnreachableError, SingularError.
    """
    machine = read_cell(cell)
    (progress or silent)("feed", 0.1)
    nominal, drawn = _published_line(machine)
    both = [nominal, drawn if calibration is None else calibrated(machine, nominal, calibration)]
    tips = base_T_tool(machine, nominal.q)[:, :3, 3]
    length = float(m_to_mm(float(np.sum(np.linalg.norm(np.diff(tips, axis=0), axis=1)))))
    analyses = analyses_of(machine, both)
    statements = derivative_statements(analyses, rate=rate, points=len(tips), length_mm=length)
    return written(
        *derivatives(machine, both, axis, rate, analyses=analyses, place="point", statements=statements), out
    )


def _published_line(cell: Cell) -> tuple[Coordinates, Coordinates]:
    """The straight line of the cell's published case, lines being numbers of its points; nominal, and compensated for the
    errors that the case draws (gear ripple left out, which the published model doesn't know).

    Raises InputError, UnreachableError, SingularError.
    """
    case = own_case(cell)
    q = case_line(case, cell)
    errors = {name: e for name, e in drawn_errors(case, cell).items() if ".cos" not in name and ".sin" not in name}
    nominal = Coordinates(q, np.arange(1, len(q) + 1), SOLVED, f"straight line of {len(q)} points ({case.source})")
    model, values = ErrorModel.of(cell, tuple(errors), in_base=True), np.array(list(errors.values()))
    return nominal, compensated_by(cell, nominal, model, values, "compensated for the errors that the case draws")
