"""`camrob calibrate --published`: a published calibration repeated on a simulated robot, its figures beside the paper's."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibrate import CalibrationFit, fit_cell
from camrob.calibration.calibration import Calibration
from camrob.calibration.calibration_file import calibration_figures, calibration_text
from camrob.calibration.compensate import compensate_postures
from camrob.calibration.measurements import Measurements
from camrob.calibration.terms import standard_names
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.jobs.files.output import check_calibration_name, staged_output
from camrob.jobs.files.takes_paths import takes_paths
from camrob.kinematics.frames import base_T_tool
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.write_log import write_log
from camrob.progress import Progress, silent
from camrob.report.calibration.page import calibration_report
from camrob.report.page.line_charts import Curve, LineChart
from camrob.se3 import rotation_to_abc
from camrob.studies.published_file import PublishedCase, own_case, read_published
from camrob.studies.published_robot import TapeLine, drawn_errors, measured_poses, tape_line
from camrob.summaries.calibration_summary import CalibrationSummary, PublishedFigure, WithheldLog
from camrob.timing.derivative_analysis import DerivativeAnalysis
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["PublishedResult", "published_case"]

Array = NDArray[np.float64]

_MANY = 100_000  # points that compensation is timed with
_FITTED_SEED, _WITHHELD_SEED = 1, 2
_RATES = ("rate_speed", "rate_acceleration", "rate_jerk")


@dataclass(frozen=True, slots=True)
class PublishedResult:
    """Both calibrations, the tape's line, and the summary."""

    plain: Calibration
    extended: Calibration
    line: TapeLine
    summary: CalibrationSummary


@takes_paths
def published_case(
    case: Path | None = None, *, cell: Path, out: Path, progress: Progress | None = None
) -> PublishedResult:
    """Repeat a published calibration and write its report.

    Written beside `out`, the calibration of the published size: NAME.html, NAME_extended.toml (the model that knows the
    rest, too), and the simulated logs NAME_measured.csv and NAME_withheld.csv, from which `calibrate` makes the same.

    Args:
        case: published.toml; None for the cell's own.
        cell: the cell's folder.
        out: CALIBRATION.toml.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError, CellError: input that is wrong.
        UnreachableError: the case's line leaves the arm's reach.

    Example:
        >>> cell = Path("cells/kr500_afp")
        >>> camrob.published_case(Path("case.toml"), cell=cell, out=Path("out/published.toml"))
        Traceback (most recent call last):
        camrob.errors.InputError: case.toml: ...
    """
    start = time.perf_counter()
    tell = progress or silent
    check_calibration_name(out)
    machine = read_cell(cell)
    case_read = own_case(machine) if case is None else read_published(case, machine)
    errors = drawn_errors(case_read, machine)
    logs = {
        part: measured_poses(case_read, machine, errors, count, seed, f"{out.stem}_{part}.csv")
        for part, count, seed in (
            ("measured", case_read.poses, _FITTED_SEED),
            ("withheld", case_read.withheld, _WITHHELD_SEED),
        )
    }
    studies: list[CalibrationFit] = []
    for harmonics in (0, case_read.ripple_orders):
        tell("fit", 0.1 + 0.4 * len(studies))
        names = standard_names(machine, harmonics=harmonics)
        studies.append(fit_cell(machine, logs["measured"], candidates=names, withheld=logs["withheld"]))
    plain, extended = (study.calibration for study in studies)
    tell("compensate", 0.8)
    line = tape_line(case_read, machine, errors, plain, extended)
    rows = _rows(case_read, plain, extended, line, _seconds_of_many(machine, plain, line))
    summary = CalibrationSummary(
        figures=calibration_figures(plain),
        file=out.name,
        report=out.with_suffix(".html").name,
        published=tuple(PublishedFigure(what=what, published=theirs, ours=ours) for what, theirs, ours in rows),
        withheld=(WithheldLog(file=logs["withheld"].name, poses=case_read.withheld, refitted=False),),
    )
    with staged_output(out.parent) as folder:
        (folder / out.name).write_text(calibration_text(plain), encoding="utf-8")
        (folder / f"{out.stem}_extended.toml").write_text(calibration_text(extended), encoding="utf-8")
        page = calibration_report(
            summary,
            studies[0].evidence,
            machine.axis_names,
            published=rows,
            charts=_charts(line),
            source=case_read.source,
        )
        (folder / summary.report).write_text(page, encoding="utf-8")
        for data in logs.values():
            write_log(_as_log(machine, data), folder / data.name)
    summary = replace(summary, seconds=time.perf_counter() - start)
    return PublishedResult(plain, extended, line, summary)


def _seconds_of_many(cell: Cell, plain: Calibration, line: TapeLine) -> float:
    """How long the compensation of a long path takes."""
    count = len(line.planned)
    q = np.tile(line.planned, (-(-_MANY // count), 1))[:_MANY]
    targets = np.tile(base_T_tool(cell, np.asarray(line.planned)), (-(-_MANY // count), 1, 1))[:_MANY]
    model, values = plain.model(cell)
    start = time.perf_counter()
    compensate_postures(model, values, q, targets)
    return time.perf_counter() - start


def _pair(mean: tuple[float, float]) -> str:
    return f"{mean[0]:.3f} mm, {mean[1]:.4f} deg"


def _means(calibration: Calibration, stage: str) -> tuple[float, float]:
    """Mean errors, mm and degrees, of the withheld poses."""
    size = calibration.errors[f"{stage}/withheld"]
    return m_to_mm(size.mean), rad_to_deg(size.mean_angle)


def _of_line(errors: Array) -> str:
    return f"{m_to_mm(float(errors[:, 0].mean())):.4f} mm, {rad_to_deg(float(errors[:, 1].mean())):.4f} deg"


def _slowest(analysis: DerivativeAnalysis, k: int) -> float:
    """The least ds/dt that the axes' speeds, accelerations or jerks allow, rad/s."""
    return float(np.min(getattr(analysis, _RATES[k])))


def _rows(
    case: PublishedCase, plain: Calibration, extended: Calibration, line: TapeLine, seconds: float
) -> list[tuple[str, str, str]]:
    """Each published figure beside ours; a dash where the paper says nothing."""
    own = sum(1 for n in plain.parameters if not n.startswith(("base", "tool")))
    asked = own + len(plain.held)
    rows = [
        (
            "parameters of the robot",
            "30 geometric, 5 stiffness",
            f"{asked} besides base and tool, {own} distinguishable from these",
        ),
        ("mean error before", _pair(case.before), _pair(_means(plain, "nominal"))),
        ("base and tool fitted alone", "-", _pair(_means(plain, "frames"))),
        ("mean error after, 30 geometric and 5 stiffness", _pair(case.after), _pair(_means(plain, "calibrated"))),
        ("mean error, gear ripple fitted too", "-", _pair(_means(extended, "calibrated"))),
        (f"tape's line of {len(line.planned)} points, uncompensated", "-", _of_line(np.asarray(line.before))),
        ("the line, compensated", "-", _of_line(np.asarray(line.after))),
        ("the line, compensated with ripple too", "-", _of_line(np.asarray(line.extended))),
        (
            "iterations as published (delta 1e-8, eps 1e-15)",
            "{}-{}".format(*case.iterations),
            "{}-{}".format(*line.published_iterations),
        ),
        ("iterations, analytic Jacobian, to 1e-11 m", "-", f"at most {line.iterations}"),
        ("largest difference between the two", "-", f"{line.difference:.1e} rad"),
    ]
    for k, name in enumerate(("speed", "acceleration", "jerk")):
        before, after = (_slowest(a, k) for a in line.analysis)
        what = f"least ds/dt that {name} limits allow, planned, then compensated, rad/s"
        rows.append((what, "no violation by compensation", f"{before:.4f}, then {after:.4f}"))
    rows.append((f"compensation of {_MANY:,} points", "-", f"{seconds:.1f} s"))
    return rows


def _charts(line: TapeLine) -> list[LineChart]:
    """The simulated robot's error along the line."""
    number_of = np.arange(1.0, len(line.planned) + 1.0)
    curves = tuple(
        Curve(name, number_of, m_to_mm(np.asarray(errors)[:, 0]), "solid", color)
        for name, errors, color in (
            ("uncompensated", line.before, 1),
            ("compensated", line.after, 0),
            ("compensated, gear ripple fitted too", line.extended, 2),
        )
    )
    caption = "What the simulated robot truly does, gear ripple included, which the published model doesn't know."
    return [
        LineChart(
            "tape-line",
            "The tape's line on the simulated robot",
            caption,
            "point of the line",
            "off the line [mm]",
            curves,
        )
    ]


def _as_log(cell: Cell, data: Measurements) -> MeasurementLog:
    """Simulated poses in the log format."""
    frames = np.asarray(data.frames)
    columns = {"t": np.arange(len(data), dtype=float)}
    columns |= {n: m_to_mm(frames[:, k, 3]) for k, n in enumerate("xyz")}
    abc = rad_to_deg(rotation_to_abc(frames[:, :3, :3]))
    columns |= {n: abc[:, k] for k, n in enumerate("abc")}
    values = cell.to_axis_values(np.asarray(data.q))
    columns |= {n: values[:, k] for k, n in enumerate(cell.axis_names)}
    info = LogInfo(
        sigma_position=data.sigma_position,
        sigma_angle=data.sigma_angle,
        poses=True,
        note="simulated robot with drawn errors",
    )
    return MeasurementLog(columns, info)
