"""`camrob feed`: the welding robot's feed and torques, or the derivative analysis of a solved path."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.jobs.derivatives import (
    LINE,
    Coordinates,
    analyses_of,
    calibrated,
    coordinates_of,
    derivative_figures,
    published_line,
)
from camrob.jobs.files.files import staged_output
from camrob.jobs.files.takes_paths import takes_paths
from camrob.kinematics.frames import base_T_tool
from camrob.progress import Progress, silent
from camrob.report.derivatives.page import derivative_report
from camrob.report.derivatives.statements import derivative_statements
from camrob.report.feed.page import weld_report, weld_statements
from camrob.report.page.statements import Statement
from camrob.studies.seam import read_seam
from camrob.studies.weld_study import SeamOptimum, WeldStudy, study_weld
from camrob.summaries.feed_summary import (
    DerivativeSummary,
    FeedSummary,
    KindFigures,
    OptimumFigures,
    SchemeFigures,
    SeamFigures,
    StatementFigures,
    UniformFeed,
    WeldSummary,
)
from camrob.units import m_to_mm

__all__ = ["FeedResult", "feed"]

_FILES = ("feed.html", "feed.json")


@dataclass(frozen=True, slots=True)
class FeedResult:
    """The summary, a WeldSummary of a seam and a DerivativeSummary else, and the files in `out`."""

    summary: FeedSummary
    out: Path
    files: tuple[str, ...]


@takes_paths
def feed(
    solution: Path | None,
    *,
    cell: Path,
    out: Path,
    compensated: Path | None = None,
    calibration: Path | None = None,
    axis: str | None = None,
    rate: float = 1.0,
    progress: Progress | None = None,
) -> FeedResult:
    """Write feed.html and feed.json into `out`: the derivatives of a path's coordinates over the axes' total displacement.

    Args:
        solution: NAME.path.npz or a program; None: the study of the cell's weld seam (seam.toml), or of the straight line of
            its published case (published.toml).
        cell: the cell's folder.
        out: the folder to write into.
        compensated: the same path, compensated, to stand beside it.
        calibration: CALIBRATION.toml, whose coordinates stand beside it.
        axis: whose curves are drawn, "all" for all; None: the arm's first.
        rate: ds/dt, rad/s.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError and its kin: input that is wrong.

    Example:
        >>> path, cell = Path("out/engraving.path.npz"), Path("cells/kr15_track_table")
        >>> camrob.feed(path, cell=cell, out=Path("out/feed")).files
        ('feed.html', 'feed.json')
    """
    machine = read_cell(cell)
    if compensated is not None and solution is None:
        raise InputError("--compensated has nothing to be compared with", hint="give the nominal path with --solution")
    (progress or silent)("feed", 0.1)
    summary: FeedSummary
    if solution is None and calibration is None and (machine.folder / "seam.toml").is_file():
        study = study_weld(machine, read_seam(machine.folder))
        summary, text = _weld_summary(machine, study), weld_report(machine, study)
    else:
        summary, text = _derivatives(machine, _coordinates(machine, solution, compensated, calibration), axis, rate)
    with staged_output(out) as folder:
        (folder / "feed.html").write_text(text, encoding="utf-8")
        (folder / "feed.json").write_text(
            json.dumps(summary.to_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8"
        )
    return FeedResult(summary, out, _FILES)


def _coordinates(
    machine: Cell, solution: Path | None, other: Path | None, calibration: Path | None
) -> tuple[list[Coordinates], bool]:
    """Nominal coordinates, compensated ones where there are any, and whether they are the published line."""
    if other is not None and calibration is not None:
        raise InputError("--compensated and --calibration exclude each other", hint="give one of them")
    if solution is not None:
        both = [coordinates_of(solution, machine)]
        if other is not None:
            both.append(coordinates_of(other, machine))
    elif (machine.folder / LINE).is_file():
        nominal, drawn = published_line(machine)
        both = [nominal] if calibration is not None else [nominal, drawn]
    else:
        hint = "give a solved path or a program with --solution"
        raise InputError("this cell has no weld seam and no published line", hint=hint, path=machine.folder)
    if calibration is not None:
        both.append(calibrated(machine, both[0], calibration))
    return both, solution is None


def _derivatives(
    machine: Cell, found: tuple[list[Coordinates], bool], axis: str | None, rate: float
) -> tuple[DerivativeSummary, str]:
    """Summary and page of a derivative analysis."""
    if not (np.isfinite(rate) and rate > 0.0):
        raise InputError(f"--rate {rate:g} is not a rate", hint="give a positive number, rad/s")
    both, published = found
    analyses = analyses_of(machine, both)
    known = analyses["smooth"][0].axes
    shown = known if axis == "all" else (axis if axis is not None else machine.names[machine.arm_slice.start],)
    if shown[0] not in known:
        raise InputError(f"--axis {axis!r} is not an axis of this cell", hint=f"use {', '.join(known)} or all")
    statements: tuple[Statement, ...] = ()
    if published:
        tips = base_T_tool(machine, both[0].q)[:, :3, 3]
        length = float(m_to_mm(float(np.sum(np.linalg.norm(np.diff(tips, axis=0), axis=1)))))
        statements = derivative_statements(analyses, rate=rate, points=len(tips), length_mm=length)
    place = "point" if published else "line"
    summary = DerivativeSummary(
        cell=machine.name,
        sources=tuple(one.source for one in both),
        displacement_rad=float(analyses["smooth"][0].s[-1]),
        rate_rad_s=rate,
        analyses=derivative_figures(analyses, rate),
        line_counts=place,
        statements=_stated(statements) if statements else None,
        files=_FILES,
    )
    text = derivative_report(
        machine,
        analyses,
        axes=shown,
        rate=rate,
        source="; ".join(one.source for one in both),
        place=place,
        statements=statements,
    )
    return summary, text


def _weld_summary(cell: Cell, study: WeldStudy) -> WeldSummary:
    names = cell.names
    return WeldSummary(
        cell=cell.name,
        seam=SeamFigures(
            length_mm=float(m_to_mm(float(study.fine.s[-1]))),
            position_error_mm_max=float(m_to_mm(float(study.points.error.max()))),
        ),
        constant_feed_m_s=_kinds(study.bound.min(axis=0)),
        schemes=tuple(
            SchemeFigures(
                feed_top_m_s=s.top,
                published=UniformFeed(
                    feed_m_s=(float(s.published.feed.min()), float(s.published.feed.max())),
                    time_s=float(s.at[-1]),
                    use=_kinds(s.use),
                ),
                optimum_moving=_optimum(s.moving),
                optimum_resting=_optimum(s.resting),
            )
            for s in study.schemes
        ),
        torque_max_nm=dict(zip(names, np.abs(study.torques.total).max(axis=0).tolist(), strict=True)),
        gravity_max_nm=dict(zip(names, np.abs(study.torques.gravity).max(axis=0).tolist(), strict=True)),
        statements=_stated(weld_statements(cell, study)),
        files=_FILES,
    )


def _optimum(found: SeamOptimum) -> OptimumFigures:
    return OptimumFigures(time_s=float(found.grid.at[-1]), use=_kinds(found.use))


def _kinds(values: NDArray[np.float64]) -> KindFigures:
    """Of speed, acceleration and jerk (3,)."""
    speed, acceleration, jerk = values.tolist()
    return KindFigures(speed=speed, acceleration=acceleration, jerk=jerk)


def _stated(statements: Iterable[Statement]) -> tuple[StatementFigures, ...]:
    return tuple(StatementFigures(published=s.published, found=s.found, verdict=s.verdict) for s in statements)
