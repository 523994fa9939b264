"""`camrob calibrate`: a cell's error parameters from measured poses."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibrate import fit_cell
from camrob.calibration.calibration import Calibration
from camrob.calibration.calibration_file import calibration_figures, calibration_text
from camrob.calibration.measurements import Measurements, measurements_of
from camrob.calibration.pose_by_pose import CalibrationEvidence
from camrob.calibration.terms import standard_names
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.controller.replay import replay
from camrob.errors import InputError, JobError, LogError, SingularError
from camrob.gap.observation.mistakes.misfit import check_measured, coarse, misfit
from camrob.jobs.files.output import check_calibration_name, staged_output
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.solving.measuring import plan_measuring
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log
from camrob.progress import Progress, silent
from camrob.report.calibration.page import calibration_report
from camrob.summaries.calibration_summary import CalibrationSummary, MeasuringFigures, WithheldLog

__all__ = ["CalibrateResult", "calibrate"]


@dataclass(frozen=True, slots=True)
class CalibrateResult:
    """The calibration, what it rests on, and its summary."""

    calibration: Calibration
    evidence: CalibrationEvidence
    summary: CalibrationSummary


@takes_paths
def calibrate(
    measured: Path,
    *,
    cell: Path,
    out: Path,
    more: Sequence[Path] = (),
    withheld: Sequence[Path] = (),
    parameters: Sequence[str] = (),
    harmonics: int = 0,
    share: float = 0.2,
    poses: int = 0,
    path: Path | None = None,
    progress: Progress | None = None,
) -> CalibrateResult:
    """Calibrate a cell from one or several logs; write CALIBRATION.toml and, beside it, the report CALIBRATION.html.

    Args:
        measured: a log of measured poses.
        cell: the cell's folder.
        out: CALIBRATION.toml.
        more: further logs; one of an unknown instrument gets a base and a reflector of its own.
        withheld: logs whose poses take no part; without, a share of the poses. Where the instrument of such a log is
            unknown, base and reflector are refitted on half of it and the other half judges the robot's parameters.
        parameters: names to fit, all of them or none; without, the standard ones, as far as the poses tell them.
        harmonics: orders of gear ripple among the standard parameters.
        share: the share of the poses that is withheld where no logs are, 0 to below 1.
        poses: how many poses to measure next are wanted, as a program NAME_poses beside the file.
        path: the program for whose accuracy they are chosen; None: the poses measured.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The calibration (SI), what it rests on, and the summary.

    Raises:
        CellError, LogError, ProgramError, InputError: input that is wrong.
        SingularError, JobError: a fit that can't be had honestly.
        CollisionError: no poses that can be visited.

    Example:
        >>> cell, out = Path("cells/kr15_track_table"), Path("out/calibration.toml")
        >>> result = camrob.calibrate(Path("out/log.csv"), cell=cell, out=out)
        >>> out.is_file() and result.calibration.cell_name
        'kr15_track_table'
    """
    start = time.perf_counter()
    tell = progress or silent
    _check(out, share, poses, path)
    _once([measured, *more], withheld)
    machine = read_cell(cell).checked_for("camrob calibrate --next", controller=poses > 0)
    tell("read", 0.1)
    logs = [read_log(path) for path in (measured, *more, *withheld)]
    data = [measurements_of(log, machine) for log in logs]
    for log in logs:
        check_measured(log, machine)
    fitted, others = data[: 1 + len(more)], data[1 + len(more) :]
    names: Sequence[str] | None = tuple(dict.fromkeys(parameters)) or None
    table = any(data.in_base for data in fitted)
    standard = standard_names(machine, table=table, harmonics=harmonics if names is None else 0)
    tell("fit", 0.3)
    try:
        study = fit_cell(machine, fitted, names=names, candidates=standard, withheld=others or None, share=share)
    except (LogError, JobError, SingularError) as error:
        raise _told(error, logs, machine) from None
    tell("write", 0.9)
    calibration = _with_coarse(study.calibration, logs, machine)
    report = out.with_suffix(".html").name
    files: Mapping[str, bytes] = {}
    following: MeasuringFigures | None = None
    if poses > 0:
        way = _way(path, fitted, machine)
        plan = plan_measuring(machine, fitted[0], standard, way, poses, f"{_program_stem(out)}_poses")
        files, following = plan.files, plan.figures
    summary = CalibrationSummary(
        figures=calibration_figures(calibration),
        file=out.name,
        report=report,
        withheld=tuple(
            WithheldLog(file=p.log, poses=len(p.rows), refitted=p.refitted) for p in study.evidence.poses if p.withheld
        ),
        next=following,
    )
    with staged_output(out.parent) as folder:
        (folder / out.name).write_text(calibration_text(calibration), encoding="utf-8")
        page = calibration_report(summary, study.evidence, machine.axis_names)
        (folder / report).write_text(page, encoding="utf-8")
        for name, content in files.items():
            (folder / name).write_bytes(content)
    summary = replace(summary, seconds=time.perf_counter() - start)
    return CalibrateResult(calibration, study.evidence, summary)


def _way(path: Path | None, fitted: Sequence[Measurements], cell: Cell) -> NDArray[np.float64]:
    """The postures (M, n) that poses are chosen for: those of a program, else those measured."""
    if path is None:
        return np.concatenate([data.q for data in fitted])
    return np.asarray(replay(language_of_file(path).read(path, cell.controller_section), cell).q)


def _check(out: Path, share: float, poses: int, path: Path | None) -> None:
    """Raise InputError for a name that is no calibration's, a share that is none, or a program that no poses are chosen for."""
    check_calibration_name(out)
    if path is not None and poses == 0:
        raise InputError(
            "--for says which program poses are chosen for, and none are wanted", hint="give --next N with it"
        )
    if not 0.0 <= share < 1.0:
        raise InputError(f"a share of {share:g} can't be withheld", hint="give a number from 0 to below 1")


def _told(error: LogError | JobError | SingularError, logs: Sequence[MeasurementLog], cell: Cell) -> Exception:
    """Why a fit ended where no robot is: what was mixed up in a log, as the diagnosis finds it, else what the fit says."""
    cause = next((found for log in logs if (found := misfit(log, cell)) is not None), None)
    if cause is not None or not isinstance(error, LogError):
        return cause or error
    # the fit knows a log by its name alone
    given = next((log.path for log in logs if log.path and error.path == Path(log.path.name)), error.path)
    return LogError(error.what, hint=error.hint, path=given, line=error.line)


def _with_coarse(found: Calibration, logs: Sequence[MeasurementLog], cell: Cell) -> Calibration:
    """What was found, with what coarse steps in the logs leave of it."""
    beside = float(np.sqrt(3.0)) * found.scatter_position
    said = [words for log in logs for words in coarse(log, cell, beside=beside)]
    return replace(found, warnings=(*said, *found.warnings))


def _once(fitted: Sequence[Path], withheld: Sequence[Path]) -> None:
    """Every log has one part to play. Raises LogError."""
    seen: set[Path] = set()
    for path in (*fitted, *withheld):
        if path.resolve() in seen:
            raise LogError("is given twice", hint="give each log once, to fit or to withhold", path=path)
        seen.add(path.resolve())


def _program_stem(out: Path) -> str:
    """A name for a program, after a file's."""
    plain = re.sub(r"\W+", "_", out.stem, flags=re.ASCII).strip("_")
    return plain[:18] if plain[:1].isalpha() else f"P_{plain[:16]}"
