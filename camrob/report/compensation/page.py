"""The report of a compensation: errors along the program before and after, corrections, derivatives, what was left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
from camrob.report.page.parts import card_row, page_body, section, table, verdict_bar
from camrob.summaries.compensate_summary import CompensateSummary, OnDiagnosedMachine, Violations
from camrob.timing.derivative_analysis import DerivativeAnalysis
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["PathErrors", "compensation_report"]

Array = NDArray[np.float64]

_STRETCHES = 150  # as many as a chart has room for
_FASTEST = 1e3  # rad/s: what stands still admits any rate
_FLOOR_MM, _FLOOR_DEG = 1e-6, 1e-7  # below, a logarithmic picture says nothing any more
_SEEN = 1e-6  # degrees or mm of a correction: below, it is what the iteration leaves


@dataclass(frozen=True, slots=True)
class PathErrors:
    """A program motion by motion: line (N,), errors of the calibrated robot before and after (N, 2), m and rad, and the
    corrections (N, 6) of the arm's `axes`, rad. shown (N,): False for auxiliary points, which no axis stops at.
    """

    line: NDArray[np.int64]
    axes: tuple[str, ...]
    before: Array
    after: Array
    correction: Array
    shown: NDArray[np.bool_]

    def __post_init__(self) -> None:
        count = len(self.line)
        object.__setattr__(self, "line", locked(self.line, shape=(count,), dtype=np.int64, name="line"))
        object.__setattr__(self, "shown", locked(self.shown, shape=(count,), dtype=np.bool_, name="shown"))
        for name, width in (("before", 2), ("after", 2), ("correction", len(self.axes))):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count, width), name=name))


def compensation_report(
    summary: CompensateSummary, path: PathErrors, analyses: tuple[DerivativeAnalysis, DerivativeAnalysis] | None
) -> str:
    """The page as text. analyses: the paper's section III, before and after, None for a program too short for it."""
    along = [*_errors_along(path, _chain(summary)), _corrections_along(path)]
    rates = [] if analyses is None else [_rates(analyses)]
    body = page_body(
        f"Compensation of {escape(summary.program)}",
        f"for the cell <b>{escape(summary.cell)}</b>, {escape(_source(summary))}",
        _verdict(summary),
        _cards(summary),
        _left(summary),
        _on_machine(summary),
        _errors(summary),
        *(chart_section(c) for c in along),
        _axes(summary),
        _derivatives(summary),
        *(chart_section(c) for c in rates),
        note=f"Errors are those of the {_chain(summary)} chain; what the robot truly does is measured, not computed.",
    )
    charts = [{**c, "ruler": "motion"} for c in chart_data(along)] + [{**c, "ruler": "s"} for c in chart_data(rates)]
    for chart in charts:
        if chart["layout"]["yaxis"]["type"] == "log":
            chart["layout"]["yaxis"] |= {"dtick": 1, "tickformat": "~g"}
    return page(f"Compensation of {summary.program}", body, {"names": {}, "charts": charts})


def _source(summary: CompensateSummary) -> str:
    """Where what is corrected comes from."""
    if summary.calibration is not None:
        return f"calibrated from {', '.join(summary.calibration.logs)}"
    return f"after the diagnosis {summary.machine.diagnosis}" if summary.machine is not None else ""


def _chain(summary: CompensateSummary) -> str:
    """What the chain is called that the errors at the motions' ends are of."""
    return "calibrated" if summary.calibration is not None else "diagnosed"


def _verdict(summary: CompensateSummary) -> str:
    """What was gained, and what the program as written does worse than it could."""
    found = summary.machine
    if found is None:
        before, after, between = summary.error_before, summary.error_after, summary.error_between
        text = (
            f"On the calibrated robot the mean error falls from {number(before.mean_mm, 3)} to {number(after.mean_mm, 4, 'mm')}, "
            f"the worst from {number(before.max_mm, 3)} to {number(after.max_mm, 4, 'mm')}, at the motions' ends."
        )
        if between is not None and between.max_mm > after.max_mm:
            text += f" Half-way through a line up to {number(between.max_mm, 3, 'mm')} remain."
    else:
        text = (
            f"On the machine as diagnosed 95 % of the path was within {number(found.before.p95_mm, 3, 'mm')} and is within "
            f"{number(found.after.p95_mm, 3, 'mm')}; the worst place goes from {number(found.before.max_mm, 3)} to "
            f"{number(found.after.max_mm, 3, 'mm')}. {_likely(found)}"
        )
    if not summary.warnings:
        return verdict_bar("good", "Corrected.", text)
    return verdict_bar("warn", "Corrected, with warnings.", text)


def _on_machine(summary: CompensateSummary) -> str:
    """The program before and after on the machine as diagnosed; nothing without a diagnosis."""
    found = summary.machine
    if found is None:
        return ""
    rows = [[name, *(number(v, 4) for v in (s.rms_mm, s.p95_mm, s.max_mm))] for name, s in found.steps()]
    more = (
        f"Corrected beyond the constants: {escape(', '.join(found.causes))}."
        if found.causes
        else "Beyond the constants nothing was corrected: on the machine as diagnosed it would not have helped."
    )
    count = sum(map(len, found.targets_added.values()))
    if count:
        more += f" {count:,} targets were added within lines, where the correction changes faster than two targets can follow."
    caption = (
        f"{more} Distance of the tool from the intended path while it moves along lines and arcs{_without_air(found)}, on the "
        "machine as diagnosed. "
        f"What no cause explains ({found.rest_mm:.3f} mm) is not included. {_likely(found)}"
    )
    head = ("on the machine as diagnosed", "rms mm", "95 % mm", "worst mm")
    return section(
        "How far off the path the tool is, on the machine as diagnosed",
        table(head, rows),
        f'<p class="caption">{caption}</p>',
    )


def _likely(found: OnDiagnosedMachine) -> str:
    """How far off the tool is with all that the diagnosis leaves open, in words."""
    likely = found.likely
    if likely is None:
        return ""
    return (
        f"With all that the diagnosis leaves open 95 % of it is likely within {number(likely.p95_mm, 3, 'mm')}, and within "
        f"{number(likely.p95_low_mm, 3)} to {number(likely.p95_high_mm, 3, 'mm')} on 95 of 100 such machines."
    )


def _without_air(found: OnDiagnosedMachine) -> str:
    """Which of them do not count, in words."""
    most = found.fastest_cut_mm_min
    return (
        "" if most is None else f" (those faster than {number(most, 0, 'mm/min')} are moves in air, and do not count)"
    )


def _cards(summary: CompensateSummary) -> str:
    before, after = summary.error_before, summary.error_after
    known = summary.calibrated_withheld_mm
    found = summary.machine
    if found is None:
        cards = [
            (
                "Mean error on the calibrated chain",
                f"{number(before.mean_mm, 3)} → {number(after.mean_mm, 4, 'mm')}",
                f"{summary.motions:,} motions",
            ),
            (
                "Worst error",
                f"{number(before.max_mm, 3)} → {number(after.max_mm, 4, 'mm')}",
                f"orientation {after.max_deg:.5f} degrees at the worst",
            ),
        ]
    else:
        cards = [
            (
                "Off the path, as diagnosed",
                f"{number(found.before.rms_mm, 3)} → {number(found.after.rms_mm, 3, 'mm')}",
                f"rms; {summary.motions:,} motions",
            ),
            (
                "95 % are within",
                f"{number(found.before.p95_mm, 3)} → {number(found.after.p95_mm, 3, 'mm')}",
                f"worst {found.before.max_mm:.3f} → {found.after.max_mm:.3f} mm",
            ),
        ]
    cards += [
        (
            "Largest correction of the tip",
            number(summary.correction.max_mm, 3, "mm"),
            f"mean {summary.correction.mean_mm:.3f} mm; found in {summary.iterations.max} steps a point at most",
        ),
    ]
    if known is not None and not (summary.machine and summary.machine.causes):
        note = "mean error on withheld poses: no program can do better"
        cards.append(("What the calibration leaves", number(known, 3, "mm"), note))
    return card_row(cards)


def _left(summary: CompensateSummary) -> str:
    rows = [
        [escape(w.text), f"program line {w.line}" if w.line else "–", f"<code>{escape(w.code)}</code>"]
        for w in summary.warnings
    ]
    if not rows:
        return ""
    return section("What is not corrected, and what to look at", table(("what", "where", "code"), rows, left=3))


def _errors(summary: CompensateSummary) -> str:
    named = [
        (f"the program as it was, on the {_chain(summary)} robot", summary.error_before),
        ("the compensated program", summary.error_after),
        ("half-way through its LINs", summary.error_between),
    ]
    rows = [
        [escape(name), *(number(v, 5) for v in (size.mean_mm, size.max_mm, size.mean_deg, size.max_deg))]
        for name, size in named
        if size is not None
    ]
    caption = (
        "By replay: the written text is read back, the controller's nominal model makes axis values of it, and the "
        f"{_chain(summary)} chain makes poses of these. What is left of the second row is rounding to four and five decimals."
    )
    head = ("errors", "mean mm", "worst mm", "mean °", "worst °")
    return section(
        f"Errors before and after at the motions' ends, on the {_chain(summary)} chain",
        table(head, rows),
        f'<p class="caption">{caption}</p>',
    )


def _errors_along(path: PathErrors, chain: str) -> list[LineChart]:
    """Errors at the motions' ends, on the chain of that name."""
    shown = np.asarray(path.shown)
    number_of = np.flatnonzero(shown).astype(np.float64) + 1.0
    charts = []
    for k, (what, unit, floor) in enumerate((("position", "mm", _FLOOR_MM), ("orientation", "degrees", _FLOOR_DEG))):
        scale = m_to_mm if k == 0 else rad_to_deg
        curves = tuple(
            Curve(name, number_of, np.maximum(scale(np.asarray(errors)[shown, k]), floor), "solid", color)
            for name, errors, color in (("before", path.before, 1), ("after", path.after, 0))
        )
        charts.append(
            LineChart(
                f"error-{what}",
                f"Error of {what} at the motions' ends, along the program",
                f"On the {chain} chain; logarithmic.",
                "motion of the program",
                f"error [{unit}]",
                curves,
                True,
            )
        )
    return charts


def _corrections_along(path: PathErrors) -> LineChart:
    shown = np.asarray(path.shown)
    number_of = np.flatnonzero(shown).astype(np.float64) + 1.0
    curves = tuple(
        Curve(axis, number_of, rad_to_deg(np.asarray(path.correction)[shown, k])) for k, axis in enumerate(path.axes)
    )
    return LineChart(
        "corrections",
        "Corrections of the arm's axes",
        "Compensated less planned. External axes stay as planned.",
        "motion of the program",
        "correction [degrees]",
        curves,
    )


def _axes(summary: CompensateSummary) -> str:
    margins, before = summary.limits.margin_min, summary.limits.margin_min_before
    rows = []
    for name, entry in summary.correction.axes.items():
        unit, mean, most = (
            ("°", entry.mean_deg, entry.max_deg) if entry.max_mm is None else ("mm", entry.mean_mm, entry.max_mm)
        )
        planned = (most or 0.0) < _SEEN
        rows.append(
            [
                escape(name),
                "as planned" if planned else number(mean, 4),
                "" if planned else number(most, 4),
                unit,
                "" if planned else f"{entry.line}",
                number(before.get(name), 3),
                number(margins.get(name), 3),
            ]
        )
    head = ("axis", "mean correction", "largest", "unit", "program line", "to its limit before", "and after")
    return section("Axis by axis", table(head, rows))


def _derivatives(summary: CompensateSummary) -> str:
    if not summary.derivatives:
        return section("How fast the axes can follow", "<p>The program holds too few postures to differentiate.</p>")
    rows = [
        [
            escape(name),
            number(rates.before, 4),
            number(rates.after, 4),
            number(100.0 * (rates.after / rates.before - 1.0), 2, "%"),
        ]
        for name, rates in summary.derivatives.items()
    ]
    head = ("limits of", "least ds/dt before, rad/s", "after", "change")
    note = (
        "s is the way of all axes together, in radians, and ds/dt the rate at which the program goes along it (section III of "
        "the paper)."
    )
    words = _violations(summary.violations)
    return section(
        "How fast the axes can follow, before and after", words, table(head, rows), f'<p class="caption">{note}</p>'
    )


def _violations(found: Violations | None) -> str:
    if found is None:
        return "<p>The program states no speed, so the bounds can't be evaluated.</p>"
    rate = f"At the program's own mean rate, ds/dt = {number(found.rate_rad_s, 4, 'rad/s')},"
    if found.new:
        items = "".join(
            f"<li>{escape(v.axis)}: {escape(v.quantity)}, {number(v.times, 2)} times, program line {v.line}</li>"
            for v in found.new
        )
        return f"<p>{rate} compensation brings new violations:</p><ul>{items}</ul>"
    return (
        f"<p>{rate} compensation brings no new violation: {found.before} stretches pass a bound before and "
        f"{found.after} after, none by an axis that kept its bound before, or by a quarter more.</p>"
    )


def _rates(analyses: tuple[DerivativeAnalysis, DerivativeAnalysis]) -> LineChart:
    """The least rates that the axes admit, stretch by stretch, before and after."""
    curves = []
    named = (("speed", "rate_speed"), ("acceleration", "rate_acceleration"), ("jerk", "rate_jerk"))
    for k, (name, attribute) in enumerate(named):
        for which, analysis, dash in zip(("before", "after"), analyses, ("solid", "dot"), strict=True):
            s, rate = _least(np.asarray(analysis.s), np.asarray(getattr(analysis, attribute)))
            curves.append(Curve(f"{name}, {which}", s, rate, dash, 2 * k + (which == "after")))
    return LineChart(
        "rates",
        "How fast the axes can follow along the program: rate ds/dt, before and after",
        f"Above {_FASTEST:g} rad/s nothing holds them back. The least in each of {_STRETCHES} stretches; linear interpolation, "
        "as the paper's eq. 21, 27 and 28.",
        "s, the way of all axes, rad",
        "rad/s",
        tuple(curves),
        True,
    )


def _least(s: Array, rate: Array) -> tuple[Array, Array]:
    """Middle of each stretch, and the least rate in it."""
    edges = np.unique(np.linspace(0, len(s), _STRETCHES + 1).astype(np.int64))
    least = np.minimum.reduceat(rate, edges[:-1])
    return np.asarray(0.5 * (s[edges[:-1]] + s[edges[1:] - 1])), np.asarray(np.minimum(least, _FASTEST))
