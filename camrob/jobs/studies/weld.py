"""`camrob study weld`: optimal feed and joint torques on the weld seam of a cell's seam.toml."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.jobs.feed import FeedResult, stated, written
from camrob.jobs.files.takes_paths import takes_paths
from camrob.progress import Progress, silent
from camrob.report.feed.page import weld_report, weld_statements
from camrob.studies.seam import SEAM, read_seam
from camrob.studies.weld_study import SeamOptimum, WeldStudy, study_weld
from camrob.summaries.feed_summary import (
    FILES,
    KindFigures,
    OptimumFigures,
    SchemeFigures,
    SeamFigures,
    UniformFeed,
    WeldSummary,
)
from camrob.units import m_to_mm

__all__ = ["weld"]


@takes_paths
def weld(*, cell: Path, out: Path, progress: Progress | None = None) -> FeedResult:
    """Write feed.html and feed.json into `out`: the study of the seam in the cell's seam.toml.

    Raises InputError where the cell has none; CellError; SingularError for a seam out of reach.
    """
    machine = read_cell(cell)
    if not (machine.folder / SEAM).is_file():
        raise InputError(
            f"this cell has no {SEAM}, the weld seam that the study runs on",
            hint="add it, as in cells/ta1400_weld, or take that cell",
            path=machine.folder,
        )
    (progress or silent)("feed", 0.1)
    study = study_weld(machine, read_seam(machine.folder))
    return written(_weld_summary(machine, study), weld_report(machine, study), out)


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
        statements=stated(weld_statements(cell, study)),
        files=FILES,
    )


def _optimum(found: SeamOptimum) -> OptimumFigures:
    return OptimumFigures(time_s=float(found.grid.at[-1]), use=_kinds(found.use))


def _kinds(values: NDArray[np.float64]) -> KindFigures:
    """Of speed, acceleration and jerk (3,)."""
    speed, acceleration, jerk = values.tolist()
    return KindFigures(speed=speed, acceleration=acceleration, jerk=jerk)
