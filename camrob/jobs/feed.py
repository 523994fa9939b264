"""`camrob feed`: the derivative analysis of a program or a solved path."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.jobs.derivatives import Coordinates, analyses_of, calibrated, coordinates_of, derivative_figures
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.progress import Progress, silent
from camrob.report.derivatives.page import derivative_report
from camrob.report.page.statements import Statement
from camrob.summaries.feed_summary import FILES, DerivativeSummary, FeedSummary, StatementFigures
from camrob.timing.derivative_analysis import DerivativeAnalysis

__all__ = ["FeedResult", "derivatives", "feed", "stated", "written"]


@dataclass(frozen=True, slots=True)
class FeedResult:
    """The summary, and the files in `out`. A WeldSummary is that of `camrob study weld`, which has the same files."""

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
        solution: NAME.path.npz or a program; None is deprecated: `camrob study weld` or `line` of the cell.
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
    if not (np.isfinite(rate) and rate > 0.0):
        raise InputError(f"--rate {rate:g} is not a rate", hint="give a positive number, rad/s")
    if compensated is not None and solution is None:
        raise InputError("--compensated has nothing to be compared with", hint="give the nominal path with --solution")
    if solution is None:
        return _study(cell, out, calibration, axis, rate, progress)
    if compensated is not None and calibration is not None:
        raise InputError("--compensated and --calibration exclude each other", hint="give one of them")
    machine = read_cell(cell)
    (progress or silent)("feed", 0.1)
    both = [coordinates_of(solution, machine)]
    if compensated is not None:
        both.append(coordinates_of(compensated, machine))
    if calibration is not None:
        both.append(calibrated(machine, both[0], calibration))
    return written(*derivatives(machine, both, axis, rate), out)


def _study(
    cell: Path, out: Path, calibration: Path | None, axis: str | None, rate: float, progress: Progress | None
) -> FeedResult:
    """What `feed` without a solution did before `camrob study weld` and `line`: the cell's own, for one more version."""
    from camrob.jobs.studies.line import line
    from camrob.jobs.studies.weld import weld
    from camrob.studies.published_file import PUBLISHED
    from camrob.studies.seam import SEAM

    warnings.warn("feed without a solution is `camrob study weld` or `line` now", DeprecationWarning, stacklevel=4)
    folder = read_cell(cell).folder
    if calibration is None and (folder / SEAM).is_file():
        return weld(cell=cell, out=out, progress=progress)
    if not (folder / PUBLISHED).is_file():
        hint = "give a solved path or a program with --solution"
        raise InputError("there is no path to analyse, and this cell has no paper's own", hint=hint, path=folder)
    return line(cell=cell, out=out, calibration=calibration, axis=axis, rate=rate, progress=progress)


def written(summary: FeedSummary, text: str, out: Path) -> FeedResult:
    """The result, once the page's text and the summary are files of `out`."""
    with staged_output(out) as folder:
        page, figures = (folder / name for name in FILES)
        page.write_text(text, encoding="utf-8")
        write_summary(figures, summary, indent=1)
    return FeedResult(summary, out, FILES)


def derivatives(
    machine: Cell,
    both: list[Coordinates],
    axis: str | None,
    rate: float,
    *,
    analyses: Mapping[str, list[DerivativeAnalysis]] | None = None,
    place: str = "line",
    statements: tuple[Statement, ...] = (),
) -> tuple[DerivativeSummary, str]:
    """Summary and page of a derivative analysis: of `both`, or of `analyses` of them; `place` is what their lines count.

    Raises InputError for an axis that the cell lacks.
    """
    analyses = analyses_of(machine, both) if analyses is None else analyses
    known = analyses["smooth"][0].axes
    shown = known if axis == "all" else (axis if axis is not None else machine.names[machine.arm_slice.start],)
    if shown[0] not in known:
        raise InputError(f"--axis {axis!r} is not an axis of this cell", hint=f"use {', '.join(known)} or all")
    summary = DerivativeSummary(
        cell=machine.name,
        sources=tuple(one.source for one in both),
        displacement_rad=float(analyses["smooth"][0].s[-1]),
        rate_rad_s=rate,
        analyses=derivative_figures(analyses, rate),
        line_counts=place,
        statements=stated(statements) if statements else None,
        files=FILES,
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


def stated(statements: Iterable[Statement]) -> tuple[StatementFigures, ...]:
    """The statements of a paper as figures of the summary."""
    return tuple(StatementFigures(published=s.published, found=s.found, verdict=s.verdict) for s in statements)
