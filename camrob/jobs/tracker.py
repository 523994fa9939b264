"""`camrob tracker`: the tracker loop's study, the paper's two tests in simulation and what does better."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.jobs.files.files import staged_output
from camrob.loop.analysis import Margins
from camrob.loop.case import read_tracker_case
from camrob.loop.measures import RunMeasure, Size
from camrob.report.loop.page import tracker_report
from camrob.report.loop.sentences import circle_places, reduction, tracker_comparisons
from camrob.studies.loop_study import Sensitivity, TrackerStudy, study_tracker
from camrob.units import m_to_mm, rad_to_deg, s_to_ms

__all__ = ["TrackerResult", "tracker"]

_AXES = ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")


@dataclass(frozen=True, slots=True)
class TrackerResult:
    """The summary as JSON, the files in `out`, and the status to end with."""

    summary: Mapping[str, Any]
    out: Path
    files: tuple[str, ...]
    status: int = 0


def tracker(
    *,
    cell: Path | None,
    out: Path | None,
    gain: float | None = None,
    laps: int = 3,
    progress: Callable[[str, float], None] | None = None,
) -> TrackerResult:
    """Write tracker.html and tracker.json into `out`: the study of the cell's tracker.toml, about a minute.

    Args:
        cell: the cell's folder, with tracker.toml.
        out: the folder to write into.
        gain: one more gain to run.
        laps: to learn from.
        progress: is told a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError and its kin: input that is wrong.
        JobError: the loop isn't stable, or the paths can't be run.

    Example:
        >>> camrob.tracker(cell=Path("cells/kr15_track_table"), out=Path("out/loop"))
        Traceback (most recent call last):
        camrob.errors.InputError: ...this cell has no tracker loop; add tracker.toml, as in cells/rx160_tracker
    """
    if cell is None:
        raise InputError("no cell is given", cure="give --cell, a folder with cell.toml and tracker.toml")
    if out is None:
        raise InputError("no folder for the report is given", cure="give --out DIR")
    machine = read_cell(cell)
    if not (machine.folder / "tracker.toml").is_file():
        raise InputError(
            "this cell has no tracker loop", cure="add tracker.toml, as in cells/rx160_tracker", path=machine.folder
        )
    study = study_tracker(machine, read_tracker_case(machine.folder), laps=laps, gain=gain, progress=progress)
    files = ("tracker.html", "tracker.json")
    summary = {"cell": machine.name, **_summary(machine.names, study), "files": list(files)}
    with staged_output(out) as folder:
        (folder / "tracker.html").write_text(tracker_report(machine, study), encoding="utf-8")
        (folder / "tracker.json").write_text(json.dumps(summary, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return TrackerResult(summary, out, files)


def _summary(names: tuple[str, ...], study: TrackerStudy) -> dict[str, Any]:
    case, none, published = study.case, study.variant("none"), study.variant("published")
    return {
        "law": {"gain": case.law.gain, "cycle_ms": s_to_ms(case.law.cycle_s), "latency_cycles": case.latency},
        "published": [c._asdict() for c in tracker_comparisons(study)],
        "square": {
            "switched_on_s": case.switched_on,
            "before": _measure(study.before),
            "after": _measure(study.of_switched),
            "reduction": _reduction(study.before, study.of_switched),
        },
        "circle": {
            "before": _measure(none.of_circle),
            "after": _measure(published.of_circle),
            "reduction": _reduction(none.of_circle, published.of_circle),
            "reversals_deg": [round(at, 1) for at, _joints in circle_places(study)],
        },
        "variants": [
            {"key": v.key, "name": v.name, "square": _measure(v.of_square), "circle": _measure(v.of_circle)}
            for v in study.variants
        ],
        "gain": {
            "chosen": study.choice.chosen,
            "gains": study.choice.gains.tolist(),
            "expected_rms_mm": [
                [float(m_to_mm(float(e))) if np.isfinite(e) else None for e in row] for row in study.choice.expected
            ],
            "simulated": [{"gain": g, "circle_rms_mm": float(m_to_mm(rms))} for g, rms in study.tried],
        },
        "latency": [
            {"cycles": x.cycles, "limit": x.limit, "published": _margins(x.published), "chosen": _margins(x.chosen)}
            for x in study.latencies
        ],
        "gain_needs": [
            {
                "latency_cycles": n.latency, "noise_mm": float(m_to_mm(n.noise)), "gain": n.gain,
                "expected_rms_mm": None if n.rms is None else float(m_to_mm(n.rms)),
            }
            for n in study.needs
        ],
        "learning": [
            {
                "name": one.name, "lead_cycles": one.lead, "factor": one.factor,
                "square_rms_mm": [float(m_to_mm(s.tool.rms)) for s, _c in one.laps],
                "circle_rms_mm": [float(m_to_mm(c.tool.rms)) for _s, c in one.laps],
            }
            for one in study.learning
        ],
        "lags": {
            name: {"late_ms": s_to_ms(float(t)), "lost_deg": float(rad_to_deg(float(b)))} if moved else None
            for name, t, b, moved in zip(names, study.lags.late, study.lags.lost, study.lags.moved, strict=True)
        },
        "sensitivity": [_sensitivity(s) for s in study.sensitivity],
        "equation_2_off_mm": float(m_to_mm(study.order_off)),
        "standings": dict(case.provenance),
    }  # fmt: skip


def _size(size: Size) -> dict[str, float]:
    return {name: float(m_to_mm(v)) for name, v in size._asdict().items()}


def _measure(m: RunMeasure) -> dict[str, Any]:
    def axes(sizes: tuple[Size, ...]) -> dict[str, dict[str, float]]:
        return {
            name: {k: float(m_to_mm(v) if i < 3 else rad_to_deg(v)) for k, v in s._asdict().items()}
            for i, (name, s) in enumerate(zip(_AXES, sizes, strict=True))
        }

    return {
        "axes": axes(m.axes),
        "axes_seen": axes(m.seen_axes),
        "tool_mm": _size(m.tool),
        "tool_seen_mm": _size(m.seen_tool),
        "path_mm": _size(m.path),
        "path_seen_mm": _size(m.seen_path),
        "corners_mm": m_to_mm(m.corners).tolist(),
        "reversal_peaks_mm": m_to_mm(m.peaks).tolist(),
        "static": [*m_to_mm(m.static[:3]).tolist(), *rad_to_deg(m.static[3:]).tolist()],
        "increments_cut_later": m.late_cuts,
    }


def _reduction(before: RunMeasure, after: RunMeasure) -> dict[str, float]:
    return {
        "tool_rms": reduction(before.tool.rms, after.tool.rms),
        "tool_mean": reduction(before.tool.mean, after.tool.mean),
        "path_mean": reduction(before.path.mean, after.path.mean),
        "path_seen_mean": reduction(before.seen_path.mean, after.seen_path.mean),
        **{
            f"{name.partition('_')[0]}_rms": reduction(b.rms, a.rms)
            for name, b, a in zip(_AXES, before.axes, after.axes, strict=True)
        },
    }


def _margins(m: Margins | None) -> dict[str, float] | None:
    if m is None:
        return None
    return {
        "gain": m.gain, "phase_deg": float(rad_to_deg(m.phase)), "delay_cycles": m.delay, "peak": m.peak,
        "bandwidth_hz": m.bandwidth, "noise_variance": m.noise,
    }  # fmt: skip


def _sensitivity(s: Sensitivity) -> dict[str, Any]:
    return {
        "name": s.name,
        "before_path_mean_mm": float(m_to_mm(s.before.path.mean)),
        "after_path_mean_mm": float(m_to_mm(s.after.path.mean)),
        "reduction": reduction(s.before.path.mean, s.after.path.mean),
        "reduction_seen": reduction(s.before.seen_path.mean, s.after.seen_path.mean),
        "after_tool_rms_mm": float(m_to_mm(s.after.tool.rms)),
    }
