"""`camrob tracker`: the tracker loop's study, the paper's two tests in simulation and what does better."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.loop.analysis import Margins
from camrob.loop.case import read_tracker_case
from camrob.loop.measures import RunMeasure, Size
from camrob.progress import Progress
from camrob.report.loop.page import tracker_report
from camrob.report.loop.sentences import circle_places, reduction, tracker_comparisons
from camrob.studies.loop_study import Sensitivity, TrackerStudy, study_tracker
from camrob.summaries.tracker_summary import (
    AxesErrors,
    CircleFigures,
    ComparisonFigures,
    ErrorSizes,
    GainFigures,
    GainNeeded,
    JointLagFigures,
    LapFigures,
    LatencyFigures,
    LawFigures,
    MarginFigures,
    RunFigures,
    SensitivityFigures,
    Shrinks,
    SimulatedGain,
    SquareFigures,
    TrackerSummary,
    VariantFigures,
)
from camrob.units import m_to_mm, rad_to_deg, s_to_ms

__all__ = ["TrackerResult", "tracker"]

_FILES = ("tracker.html", "tracker.json")


@dataclass(frozen=True, slots=True)
class TrackerResult:
    """The summary, the files in `out`, and the status to end with."""

    summary: TrackerSummary
    out: Path
    files: tuple[str, ...]
    status: int = 0


@takes_paths
def tracker(
    *,
    cell: Path | None,
    out: Path | None,
    gain: float | None = None,
    laps: int = 3,
    progress: Progress | None = None,
) -> TrackerResult:
    """Write tracker.html and tracker.json into `out`: the study of the cell's tracker.toml, about a minute.

    Args:
        cell: the cell's folder, with tracker.toml.
        out: the folder to write into.
        gain: one more gain to run.
        laps: to learn from.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError and its kin: input that is wrong.
        JobError: the loop isn't stable, or the paths can't be run.

    Example:
        >>> camrob.tracker(cell=Path("cells/kr15_track_table"), out=Path("out/loop"))
        Traceback (most recent call last):
        camrob.errors.InputError: ...this cell has no tracker loop; add tracker.toml, as in cells/rx160_tracker
    """
    if cell is None:
        raise InputError("no cell is given", hint="give --cell, a folder with cell.toml and tracker.toml")
    if out is None:
        raise InputError("no folder for the report is given", hint="give --out DIR")
    machine = read_cell(cell)
    if not (machine.folder / "tracker.toml").is_file():
        raise InputError(
            "this cell has no tracker loop", hint="add tracker.toml, as in cells/rx160_tracker", path=machine.folder
        )
    study = study_tracker(machine, read_tracker_case(machine.folder), laps=laps, gain=gain, progress=progress)
    summary = _summary(machine, study)
    with staged_output(out) as folder:
        (folder / "tracker.html").write_text(tracker_report(machine, study), encoding="utf-8")
        write_summary(folder / "tracker.json", summary, indent=1)
    return TrackerResult(summary, out, _FILES)


def _summary(cell: Cell, study: TrackerStudy) -> TrackerSummary:
    case, none, published = study.case, study.variant("none"), study.variant("published")
    return TrackerSummary(
        cell=cell.name,
        law=LawFigures(gain=case.law.gain, cycle_ms=s_to_ms(case.law.cycle_s), latency_cycles=case.latency),
        published=tuple(ComparisonFigures(**c._asdict()) for c in tracker_comparisons(study)),
        square=SquareFigures(
            switched_on_s=case.switched_on,
            before=_run(study.before),
            after=_run(study.of_switched),
            reduction=_reduction(study.before, study.of_switched),
        ),
        circle=CircleFigures(
            before=_run(none.of_circle),
            after=_run(published.of_circle),
            reduction=_reduction(none.of_circle, published.of_circle),
            reversals_deg=tuple(round(at, 1) for at, _joints in circle_places(study)),
        ),
        variants=tuple(
            VariantFigures(key=v.key, name=v.name, square=_run(v.of_square), circle=_run(v.of_circle))
            for v in study.variants
        ),
        gain=_gain(study),
        latency=tuple(
            LatencyFigures(cycles=x.cycles, limit=x.limit, published=_margins(x.published), chosen=_margins(x.chosen))
            for x in study.latencies
        ),
        gain_needs=tuple(
            GainNeeded(
                latency_cycles=n.latency,
                noise_mm=float(m_to_mm(n.noise)),
                gain=n.gain,
                expected_rms_mm=None if n.rms is None else float(m_to_mm(n.rms)),
            )
            for n in study.needs
        ),
        learning=tuple(
            LapFigures(
                name=one.name,
                lead_cycles=one.lead,
                factor=one.factor,
                square_rms_mm=tuple(float(m_to_mm(s.tool.rms)) for s, _c in one.laps),
                circle_rms_mm=tuple(float(m_to_mm(c.tool.rms)) for _s, c in one.laps),
            )
            for one in study.learning
        ),
        lags={
            name: JointLagFigures(late_ms=s_to_ms(float(t)), lost_deg=float(rad_to_deg(float(b)))) if moved else None
            for name, t, b, moved in zip(cell.names, study.lags.late, study.lags.lost, study.lags.moved, strict=True)
        },
        sensitivity=tuple(_sensitivity(s) for s in study.sensitivity),
        equation_2_off_mm=float(m_to_mm(study.order_off)),
        provenance=case.provenance,
        files=_FILES,
    )


def _gain(study: TrackerStudy) -> GainFigures:
    return GainFigures(
        chosen=study.choice.chosen,
        gains=tuple(study.choice.gains.tolist()),
        expected_rms_mm=tuple(
            tuple(float(m_to_mm(float(e))) if np.isfinite(e) else None for e in row) for row in study.choice.expected
        ),
        simulated=tuple(SimulatedGain(gain=g, circle_rms_mm=float(m_to_mm(rms))) for g, rms in study.tried),
    )


def _size(size: Size, *, angle: bool = False) -> ErrorSizes:
    scale = rad_to_deg if angle else m_to_mm
    return ErrorSizes(**{name: float(scale(v)) for name, v in size._asdict().items()})


def _axes(sizes: tuple[Size, ...]) -> AxesErrors:
    x, y, z = (_size(s) for s in sizes[:3])
    a, b, c = (_size(s, angle=True) for s in sizes[3:])
    return AxesErrors(x_mm=x, y_mm=y, z_mm=z, a_deg=a, b_deg=b, c_deg=c)


def _run(m: RunMeasure) -> RunFigures:
    return RunFigures(
        axes=_axes(m.axes),
        axes_seen=_axes(m.seen_axes),
        tool_mm=_size(m.tool),
        tool_seen_mm=_size(m.seen_tool),
        path_mm=_size(m.path),
        path_seen_mm=_size(m.seen_path),
        corners_mm=tuple(m_to_mm(m.corners).tolist()),
        reversal_peaks_mm=tuple(m_to_mm(m.peaks).tolist()),
        static=(*m_to_mm(m.static[:3]).tolist(), *rad_to_deg(m.static[3:]).tolist()),
        increments_cut_later=m.late_cuts,
    )


def _reduction(before: RunMeasure, after: RunMeasure) -> Shrinks:
    x, y, z, a, b, c = (reduction(was.rms, now.rms) for was, now in zip(before.axes, after.axes, strict=True))
    return Shrinks(
        tool_rms=reduction(before.tool.rms, after.tool.rms),
        tool_mean=reduction(before.tool.mean, after.tool.mean),
        path_mean=reduction(before.path.mean, after.path.mean),
        path_seen_mean=reduction(before.seen_path.mean, after.seen_path.mean),
        x_rms=x,
        y_rms=y,
        z_rms=z,
        a_rms=a,
        b_rms=b,
        c_rms=c,
    )


def _margins(m: Margins | None) -> MarginFigures | None:
    if m is None:
        return None
    return MarginFigures(
        gain=m.gain,
        phase_deg=float(rad_to_deg(m.phase)),
        delay_cycles=m.delay,
        peak=m.peak,
        bandwidth_hz=m.bandwidth,
        noise_variance=m.noise,
    )


def _sensitivity(s: Sensitivity) -> SensitivityFigures:
    return SensitivityFigures(
        name=s.name,
        before_path_mean_mm=float(m_to_mm(s.before.path.mean)),
        after_path_mean_mm=float(m_to_mm(s.after.path.mean)),
        reduction=reduction(s.before.path.mean, s.after.path.mean),
        reduction_seen=reduction(s.before.seen_path.mean, s.after.seen_path.mean),
        after_tool_rms_mm=float(m_to_mm(s.after.tool.rms)),
    )
