"""The report of a calibration: what was found, how well it is known, what it is worth, what stays unexplained."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from camrob.calibration.pose_by_pose import CalibrationEvidence
from camrob.report.calibration.charts import STAGES, calibration_charts, correlation_section
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import LineChart, chart_data, chart_section
from camrob.report.page.parts import card_row, figure, page_body, section, table, verdict_bar
from camrob.summaries.calibration_summary import CalibrationFigures, CalibrationSummary, ErrorFigures, MeasuringFigures
from camrob.units import m_to_mm

__all__ = ["calibration_report"]

_BEYOND = 0.1  # of the noise's energy: what the parameters' own uncertainty may add; chance is reckoned beside
_WHY = {
    "merged": "can't be told from",
    "unseen": "has no effect on what was measured",
    "weak": "the poses say too little about it",
}


def calibration_report(
    summary: CalibrationSummary,
    evidence: CalibrationEvidence,
    axes: Sequence[str],
    *,
    published: Sequence[Sequence[str]] = (),
    charts: Sequence[LineChart] = (),
    source: str = "",
) -> str:
    """The page as text.

    axes: names of the cell's axes, as evidence's axis values hold them.
    published: rows (what, published, ours), text, for a case that stands in a paper, `source`, with charts of its own.
    """
    found = summary.figures
    drawn = calibration_charts(evidence, found, axes)
    place = {c["id"]: figure(c) for c in drawn}
    poses = [html for name, html in place.items() if name.startswith(("spread-", "poses-"))]
    files = ", ".join(log.file for log in found.logs)
    body = page_body(
        f"Calibration of {escape(found.cell)}",
        f"from {escape(files)}",
        _verdict(found, evidence),
        _cards(found, evidence),
        _warnings(found),
        _published(published, source),
        *(chart_section(c) for c in charts),
        _errors(found, evidence),
        *poses,
        place["parameters"],
        _parameters(found),
        place["singular"],
        _identifiable(found),
        correlation_section(evidence),
        place["remaining"],
        _remaining(found, evidence),
        _next(summary.next),
    )
    data: dict[str, Any] = {"names": {}}
    data["charts"] = [{k: c[k] for k in ("id", "traces", "layout", "ruler")} for c in drawn]
    data["charts"] += [{**c, "ruler": "line"} for c in chart_data(charts)]
    return page(f"Calibration of {found.cell}", body, data)


def _judged(summary: CalibrationFigures) -> tuple[ErrorFigures, ErrorFigures, str]:
    """Errors before and after on the poses that count, and what these are called."""
    errors = summary.errors
    part = "withheld" if "calibrated/withheld" in errors else "fitted"
    first = "nominal" if f"nominal/{part}" in errors else "frames"
    return errors[f"{first}/{part}"], errors[f"calibrated/{part}"], part


def _verdict(summary: CalibrationFigures, evidence: CalibrationEvidence) -> str:
    """What it is worth on poses that took no part, and whether something is left that was not fitted."""
    before, after, part = _judged(summary)
    text = (
        f"On {after.poses:,} {part} poses the mean error of position goes from {number(before.mean_mm, 3)} to "
        f"{number(after.mean_mm, 3, 'mm')}; 95 % lie within {number(after.p95_mm, 3, 'mm')}."
    )
    if part == "fitted":
        text += " No poses were withheld: how good it is elsewhere is not known."
    if after.mean_mm >= before.mean_mm:
        return verdict_bar("bad", "Don’t use it.", f"It makes the robot no better. {text}")
    rest = _unexplained(summary, evidence)
    if rest is not None and rest > 0.0:
        text += " More is at work than was fitted: what remains is more than the instrument's noise."
    careful = part == "fitted" or rest is None or rest > 0.0
    return verdict_bar("warn" if careful else "good", "Better, with limits." if careful else "Calibrated.", text)


def _cards(summary: CalibrationFigures, evidence: CalibrationEvidence) -> str:
    before, after, part = _judged(summary)
    cards = [
        (
            "Mean error of position",
            f"{number(before.mean_mm, 3)} → {number(after.mean_mm, 3, 'mm')}",
            f"on {after.poses:,} {part} poses",
        ),
        (
            "Worst error of position",
            f"{number(before.max_mm, 3)} → {number(after.max_mm, 3, 'mm')}",
            f"95 % lie below {after.p95_mm:.3f} mm",
        ),
    ]
    if after.mean_deg is not None:
        value = f"{number(before.mean_deg, 4)} → {number(after.mean_deg, 4, '°')}"
        cards.append(("Mean error of orientation", value, f"worst {after.max_deg:.4f} degrees"))
    held = len(summary.held)
    cards.append(("Parameters", str(len(summary.parameters)), f"{held} more asked for and left out"))
    cards.append(("Poses fitted", f"{summary.poses:,}", f"{summary.outliers} outliers, with little weight"))
    noise = _noise(evidence)
    note = f"the instrument's noise is {noise:.4f} mm" if noise is not None else "the instrument's noise isn't known"
    cards.append(("Scatter that remains, per axis", number(summary.scatter_mm, 4, "mm"), note))
    return card_row(cards)


def _noise(evidence: CalibrationEvidence) -> float | None:
    """The instrument's noise an axis, mm, where it is known."""
    sigma = max(p.sigma for p in evidence.poses)
    return float(m_to_mm(sigma)) if sigma > 0.0 else None


def _warnings(summary: CalibrationFigures) -> str:
    if not summary.warnings:
        return ""
    rows = "".join(f"<li>{escape(w.text)}</li>" for w in summary.warnings)
    return section("Before you trust the numbers", f"<ul>{rows}</ul>")


def _published(rows: Sequence[Sequence[str]], source: str) -> str:
    if not rows:
        return ""
    return section(
        "Published, and ours",
        f'<p class="caption">{escape(source)}</p>',
        table(("", "published", "ours"), [[escape(c) for c in row] for row in rows]),
        '<p class="caption">Ours is a simulated robot with drawn errors, sized so that the published means before and '
        "after come out; a dash: the paper says nothing.</p>",
    )


def _errors(summary: CalibrationFigures, evidence: CalibrationEvidence) -> str:
    rows = []
    for stage, size in summary.errors.items():
        name, _, part = stage.partition("/")
        values = (size.mean_mm, size.rms_mm, size.p95_mm, size.max_mm, size.mean_deg, size.max_deg)
        numbers = [number(value, 4) for value in values]
        rows.append([f"{escape(STAGES.get(name, name))}, {escape(part)}", f"{size.poses:,}", *numbers])
    head = ("errors", "poses", "mean mm", "rms mm", "95 % mm", "worst mm", "mean °", "worst °")
    again = any(p.refitted for p in evidence.poses)
    note = (
        "Only the robot's parameters carry over to the withheld log: its instrument stood elsewhere, so base and "
        "reflector were fitted to half of it, and the other half judges."
        if again
        else "Withheld poses took no part in choosing or fitting."
    )
    return section("Errors before and after", table(head, rows), f'<p class="caption">{note}</p>')


def _parameters(summary: CalibrationFigures) -> str:
    rows = []
    for p in summary.parameters:
        decimals = {"mm": 4, "deg": 5}.get(p.unit)
        plain = [number(v, decimals) if decimals else f"{v:.3e}" for v in (p.value, p.std)]
        sure = abs(p.value) / p.std if p.std else float("nan")
        whose = "instrument" if p.nuisance else "robot"
        told = number(sure, 1) + (", may be 0" if p.may_be_none else "")
        rows.append([escape(p.name), f"of the {whose}", escape(p.unit), *plain, told])
    head = ("parameter", "", "unit", "value", "standard error", "value / error")
    caption = (
        "base, tool: the frames' errors. A3.x .. ry: where the axis stands; zero: what the real axis value is beyond the "
        "reported one; compliance: by how much gravity's torque turns the link. Below 2, a value may be 0."
    )
    return section("Parameters", table(head, rows, left=3), f'<p class="caption">{caption}</p>')


def _identifiable(summary: CalibrationFigures) -> str:
    rows = [
        [escape(h.name), escape(_WHY[h.why]) + (f" {escape(', '.join(h.others))}" if h.others else "")]
        for h in summary.held
    ]
    o = summary.observability
    indices = ", ".join(f"O{k} {number(v, 4)}" for k, v in enumerate((o.o1, o.o2, o.o3, o.o4, o.o5), start=1))
    pairs = [[escape(" and ".join(c.pair)), number(c.value, 3)] for c in summary.correlations if abs(c.value) >= 0.5]
    words = (
        f"<p>Condition of the fit {number(summary.condition, 0)} (1: every parameter as well known as every other); the "
        f"literature's indices of observability, larger is better: {indices}.</p>"
    )
    left = table(("left out", "why"), rows, left=2) if rows else "<p>Every parameter asked for could be fitted.</p>"
    strong = (
        table(("strongest correlations", "r"), pairs) if pairs else "<p>No two are correlated by more than 0.5.</p>"
    )
    return section("What the poses can tell apart", words, left, strong)


def _remaining(summary: CalibrationFigures, evidence: CalibrationEvidence) -> str:
    """In words: what is explained, what is noise, what is neither."""
    before, after, part = _judged(summary)
    share = 100.0 * (1.0 - (after.rms_mm / before.rms_mm) ** 2) if before.rms_mm > 0.0 else 0.0
    text = f"Of the energy of the errors on {part} poses, {number(share, 1, '%')} is explained. "
    noise, rest = _noise(evidence), _unexplained(summary, evidence)
    if noise is None or rest is None:
        text += "How much of the rest is the instrument's noise isn't known: LOG.toml gives no sigma_mm."
    else:
        floor = float(np.sqrt(3.0)) * noise
        text += f"{number(after.rms_mm, 4, 'mm')} rms stay, of which the instrument's noise makes {number(floor, 4, 'mm')}; "
        text += (
            f"{number(rest, 4, 'mm')} rms remain unexplained."
            if rest > 0.0
            else "nothing stays that the noise doesn't explain."
        )
    return section("What stays unexplained", f"<p>{text}</p>")


def _unexplained(summary: CalibrationFigures, evidence: CalibrationEvidence) -> float | None:
    """What stays beyond the instrument's noise, mm rms; 0 where that may be chance, None where the noise isn't known."""
    after, noise = _judged(summary)[1], _noise(evidence)
    if noise is None:
        return None
    floor = float(np.sqrt(3.0)) * noise
    by_chance = _BEYOND + 3.0 * float(np.sqrt(2.0 / (3.0 * after.poses)))
    return float(np.sqrt(after.rms_mm**2 - floor**2)) if (after.rms_mm / floor) ** 2 - 1.0 > by_chance else 0.0


def _next(plan: MeasuringFigures | None) -> str:
    if plan is None:
        return ""
    rows = [
        [str(k), ", ".join(f"{v:g}" for v in q), ", ".join(f"{v:g}" for v in tip)]
        for k, (q, tip) in enumerate(zip(plan.axis_values, plan.tip_mm, strict=True), start=1)
    ]
    words = (
        f"<p>{plan.poses} poses, chosen for the accuracy on the path that matters: its expected error falls from "
        f"{number(plan.expected_before_mm, 4, 'mm')} to {number(plan.expected_after_mm, 4, 'mm')}.</p>"
    )
    return section("Poses to measure next", words, table(("pose", "axis values", "tip in base, mm"), rows, left=3))
