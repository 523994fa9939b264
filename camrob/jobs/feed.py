"""`camrob feed`: the welding robot's feed and torques, or the derivative analysis of a solved path."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError
from camrob.feed.derivative_analysis import DerivativeAnalysis, Interpolation, analyse_derivatives
from camrob.feed.seam import read_seam
from camrob.feed.weld_study import SeamOptimum, WeldStudy, study_weld
from camrob.jobs.files import staged_output
from camrob.report.derivative_report import derivative_report
from camrob.report.feed_report import weld_report, weld_statements
from camrob.units import m_to_mm

__all__ = ["FeedResult", "feed"]

Array = NDArray[np.float64]

_KINDS = ("speed", "acceleration", "jerk")
_LISTED = 40  # violations in the summary


@dataclass(frozen=True, slots=True)
class FeedResult:
    """The summary as JSON, and the files in `out`."""

    summary: Mapping[str, Any]
    out: Path
    files: tuple[str, ...]


def feed(
    solution: Path | None,
    *,
    cell: Path,
    out: Path,
    compensated: Path | None = None,
    axis: str | None = None,
    rate: float = 1.0,
    progress: Callable[[str, float], None] | None = None,
) -> FeedResult:
    """Write feed.html and feed.json into `out`.

    Without `solution`, the study of the cell's weld seam (seam.toml). With it (NAME.path.npz), the derivatives of its
    coordinates over the axes' total displacement, `compensated` coordinates beside them, at a rate ds/dt of `rate` rad/s;
    `axis`: whose curves are drawn, the first by default. Raises InputError and its kin.
    """
    machine = read_cell(cell)
    if progress is not None:
        progress("feed", 0.1)
    if solution is None:
        if not (machine.folder / "seam.toml").is_file():
            raise InputError(
                "this cell has no weld seam", cure="give a solved path, NAME.path.npz", path=machine.folder
            )
        study = study_weld(machine, read_seam(machine.folder))
        summary, text = _weld_summary(machine, study), weld_report(machine, study)
    else:
        shown = axis if axis is not None else machine.names[machine.arm_slice.start]
        files = [solution, *([compensated] if compensated is not None else [])]
        paths = [(file, *_load(file, machine)) for file in files]
        analyses = {
            kind.value: [analyse_derivatives(machine, q, line=line, interpolation=kind) for _f, q, line in paths]
            for kind in Interpolation
        }
        if shown not in analyses["smooth"][0].axes:
            raise InputError(
                f"--axis {shown!r} is no axis of this cell", cure=f"use {', '.join(analyses['smooth'][0].axes)}"
            )
        if not (np.isfinite(rate) and rate > 0.0):
            raise InputError(f"--rate {rate:g} is no rate", cure="give a positive number, rad/s")
        summary = _derivative_summary(machine, analyses, rate)
        text = derivative_report(machine, analyses, axis=shown, rate=rate)
    with staged_output(out) as folder:
        (folder / "feed.html").write_text(text, encoding="utf-8")
        (folder / "feed.json").write_text(json.dumps(summary, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return FeedResult(summary, out, ("feed.html", "feed.json"))


def _load(file: Path, cell: Cell) -> tuple[Array, NDArray[np.int64]]:
    """Postures and lines of a NAME.path.npz. Raises InputError."""
    try:
        with np.load(file, allow_pickle=False) as data:
            q, line = np.asarray(data["q"], float), np.asarray(data["line"], np.int64)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(
            "is no solved path", cure="give the NAME.path.npz that camrob post wrote", path=file
        ) from error
    if q.ndim != 2 or q.shape[1] != len(cell) or line.shape != (len(q),) or not np.all(np.isfinite(q)):
        raise InputError("holds postures of another cell", cure=f"post it for {cell.name}", path=file)
    if len(np.unique(q, axis=0)) < 8:
        raise InputError("holds fewer than 8 different postures", cure="give a longer path", path=file)
    return q, line


def _weld_summary(cell: Cell, study: WeldStudy) -> dict[str, Any]:
    names = cell.names
    return {
        "cell": cell.name,
        "seam": {
            "length_mm": float(m_to_mm(float(study.fine.s[-1]))),
            "position_error_mm_max": float(m_to_mm(float(study.points.error.max()))),
        },
        "constant_feed_m_s": {k: float(v) for k, v in zip(_KINDS, study.bound.min(axis=0), strict=True)},
        "schemes": [
            {
                "feed_top_m_s": s.top,
                "published": {
                    "feed_m_s": [float(s.published.feed.min()), float(s.published.feed.max())],
                    "time_s": float(s.at[-1]),
                    "use": dict(zip(_KINDS, s.use.tolist(), strict=True)),
                },
                "optimum_moving": _optimum(s.moving),
                "optimum_resting": _optimum(s.resting),
            }
            for s in study.schemes
        ],
        "torque_max_nm": dict(zip(names, np.abs(study.torques.total).max(axis=0).tolist(), strict=True)),
        "gravity_max_nm": dict(zip(names, np.abs(study.torques.gravity).max(axis=0).tolist(), strict=True)),
        "statements": [s._asdict() for s in weld_statements(cell, study)],
        "files": ["feed.html", "feed.json"],
    }  # fmt: skip


def _optimum(found: SeamOptimum) -> dict[str, Any]:
    return {"time_s": float(found.grid.at[-1]), "use": dict(zip(_KINDS, found.use.tolist(), strict=True))}


def _derivative_summary(cell: Cell, analyses: Mapping[str, list[DerivativeAnalysis]], rate: float) -> dict[str, Any]:
    table = []
    for kind, both in analyses.items():
        for which, analysis in zip(("nominal", "compensated"), both, strict=False):
            found = analysis.violations(rate)
            table.append(
                {
                    "interpolation": kind,
                    "coordinates": which,
                    "rate_admitted": {
                        "speed": float(analysis.rate_speed.min()),
                        "acceleration": float(analysis.rate_acceleration.min()),
                        "jerk": float(analysis.rate_jerk.min()),
                    },
                    "violations": len(found),
                    "worst": [
                        {"axis": v.axis, "quantity": v.quantity, "s": v.worst_at, "line": v.line, "times": v.worst}
                        for v in sorted(found, key=lambda v: -v.worst)[:_LISTED]
                    ],
                }
            )
    smooth = analyses["smooth"][0]
    return {
        "cell": cell.name,
        "displacement_rad": float(smooth.s[-1]),
        "rate_rad_s": rate,
        "analyses": table,
        "files": ["feed.html", "feed.json"],
    }
