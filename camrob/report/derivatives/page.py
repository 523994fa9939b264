"""The report of a derivative analysis: the paper's Figure 1 for any axis, violations axis by axis, admitted rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_pair, chart_section
from camrob.report.page.parts import chooser, page_body, section, table, verdict_bar
from camrob.report.page.statements import Statement, statements_section
from camrob.timing.derivative_analysis import DerivativeAnalysis

__all__ = ["derivative_report"]

Array = NDArray[np.float64]
Analyses = Mapping[str, Sequence[DerivativeAnalysis]]

_NAMES = ("nominal", "compensated")
_COLORS = (0, 3)  # of the palette: the two that lie farthest apart
_FAR = 5.0  # times the curves' size: bounds beyond would flatten them
_ZOOM = 0.015  # rad of s: as wide as the paper's last four diagrams
_CORNERED = "linear"  # the published interpolation
_SAMPLING = (
    "Between points it is a straight line, so that each point is a corner: what it shows of acceleration and jerk measures how "
    "finely the path is sampled, not the machine. Read the smooth one for that."
)
_DOTTED = (
    "Dotted: the axis's bounds where ds/dt and its two derivatives are 1 rad/s, 1 rad/s², 1 rad/s³, as in the paper; those far "
    "beyond the curves are in the legend: click to see them. Drag to look closer."
)
_LIMITS = (("speed", "q_s / v (20)"), ("acceleration", "q_ss / a (24)"), ("jerk", "q_sss / j (26)"))


def derivative_report(
    cell: Cell,
    analyses: Analyses,
    *,
    axes: Sequence[str],
    rate: float,
    source: str = "",
    place: str = "line",
    statements: Sequence[Statement] = (),
) -> str:
    """The page as text. analyses: for each interpolation, that of the nominal coordinates and maybe the compensated ones.

    axes: whose curves are drawn; rate: ds/dt, rad/s, that violations are counted at; source: what was analysed, as plain
    text; place: what the analyses' lines count; statements: the paper's beside what was found.
    """
    figures = {(axis, kind): _figure(kind, both, axis) for axis in axes for kind, both in analyses.items()}
    rates = [_rates(kind, both) for kind, both in analyses.items()]
    body = page_body(
        "Speed, acceleration and jerk of the axes along the path",
        f"{escape(cell.title)}; {escape(source)}. s: the way of all axes together, rad",
        _verdict(analyses, rate, place),
        statements_section(statements) if statements else "",
        *(_table(kind, both, rate, place) for kind, both in analyses.items()),
        chooser(
            "Curves axis by axis (Figure 1)",
            {"axis": axes, "between points": list(analyses)},
            {words: "".join(map(chart_pair, _pairs(charts))) for words, charts in figures.items()},
            f'<p class="caption">{_DOTTED}</p>',
        ),
        *(chart_section(chart) for chart in rates),
    )
    every = [*(chart for charts in figures.values() for chart in charts), *rates]
    return page("Speed, acceleration and jerk of the axes", body, {"names": {}, "charts": chart_data(every)})


def _verdict(analyses: Analyses, rate: float, place: str) -> str:
    """How fast s may run, by the curve that says something of the machine."""
    kind = next((k for k in analyses if k != _CORNERED), _CORNERED)
    last = analyses[kind][-1]
    least = min(float(np.min(r)) for r in (last.rate_speed, last.rate_acceleration, last.rate_jerk))
    over = last.violations(rate)
    text = f"At {rate:g} rad/s no axis passes a limit of speed, acceleration or jerk"
    if over:
        worst = max(over, key=lambda v: v.worst)
        text = (
            f"At {rate:g} rad/s limits are passed in {len(over):,} stretches, the worst by {worst.axis} {worst.quantity}, "
            f"{worst.worst:,.1f} times its limit{f' at {place} {worst.line}' if worst.line else ''}"
        )
    word = f"All limits are kept up to ds/dt = {number(least, 3, 'rad/s')}."
    return verdict_bar("warn" if over else "good", word, escape(f"{text} ({kind} interpolation)."))


def _pairs(charts: Sequence[LineChart]) -> list[tuple[LineChart, LineChart]]:
    """Each quantity over the whole path beside the same over a short stretch."""
    half = len(charts) // 2
    return list(zip(charts[:half], charts[half:], strict=True))


def _figure(kind: str, both: Sequence[DerivativeAnalysis], axis: str) -> list[LineChart]:
    """The eight diagrams of Figure 1: over the whole path, and over a short stretch in its middle."""
    k = both[0].axes.index(axis)
    v, a, j = (float(b[k]) for b in (both[0].bounds.speed, both[0].bounds.acceleration, both[0].bounds.jerk))
    rows = (
        ("q", "coordinate", "q [rad, or m]", ()),
        ("q_s", "first derivative", "dq/ds [per rad]", (("speed", v, 2), ("acceleration", a, 4), ("jerk", j, 5))),
        ("q_ss", "second derivative", "d²q/ds² [per rad²]", (("acceleration", a, 4), ("jerk", j, 5))),
        ("q_sss", "third derivative", "d³q/ds³ [per rad³]", (("jerk", j, 5),)),
    )
    whole = (0.0, max(float(one.s[-1]) for one in both))
    middle = 0.5 * whole[1]
    charts = []
    for name, window in (("", whole), ("-close", (middle - 0.5 * _ZOOM, middle + 0.5 * _ZOOM))):
        for quantity, title, unit, limits in rows:
            curves = _curves(both, quantity, k, window)
            most = max(float(np.max(np.abs(c.y), initial=0.0)) for c in curves)
            bounds = tuple(
                Curve(
                    f"{limit}'s bounds",
                    np.array([*window, np.nan, *window]),
                    np.array([value, value, np.nan, -value, -value]),
                    "dot",
                    color,
                    value < _FAR * most,
                )
                for limit, value, color in limits
            )
            closer = f", s from {window[0]:.3f} to {window[1]:.3f} rad" if name else ""
            charts.append(
                LineChart(
                    f"{kind}-{axis}-{quantity}{name}",
                    f"{escape(axis)}: {title}{closer}",
                    "",
                    "s [rad]",
                    unit,
                    curves + bounds,
                )
            )
    return charts


def _curves(
    both: Sequence[DerivativeAnalysis], quantity: str, k: int, window: tuple[float, float]
) -> tuple[Curve, ...]:
    out = []
    for which, color, one in zip(_NAMES, _COLORS, both, strict=False):
        s = np.asarray(one.s)
        inside = (s >= window[0]) & (s <= window[1])
        out.append(Curve(which, s[inside], np.asarray(getattr(one, quantity))[inside, k], "solid", color))
    return tuple(out)


def _rates(kind: str, both: Sequence[DerivativeAnalysis]) -> LineChart:
    curves = tuple(
        Curve(f"{name}, {which}", one.s, np.minimum(rate, 1e6), dash, color)
        for which, dash, one in zip(_NAMES, ("solid", "dot"), both, strict=False)
        for color, (name, rate) in enumerate(
            (
                ("speed (eq. 21)", one.rate_speed),
                ("acceleration (eq. 27)", one.rate_acceleration),
                ("jerk (eq. 28)", one.rate_jerk),
            )
        )
    )
    return LineChart(
        f"{kind}-rates",
        f"Rate ds/dt that all axes admit, {kind} interpolation",
        "Each bound by itself, at a constant rate; the derivatives' sizes count, whatever their sign.",
        "s [rad]",
        "ds/dt [rad/s]",
        curves,
        True,
    )


def _table(kind: str, both: Sequence[DerivativeAnalysis], rate: float, place: str) -> str:
    """Violations axis by axis: how many stretches, the worst, and where; nominal beside compensated."""
    heads = [
        heading
        for which, _one in zip(_NAMES, both, strict=False)
        for heading in (f"{which}: stretches past it", "at most, times it", "s", place)
    ]
    rows = [
        [
            escape(axis),
            quantity,
            *(c for one in both for c in _cells(one, np.abs(one.constraints(rate)[key][:, k]), kind)),
        ]
        for k, axis in enumerate(both[0].axes)
        for quantity, key in _LIMITS
    ]
    total = ", ".join(f"{which} {len(one.violations(rate)):,}" for which, one in zip(_NAMES, both, strict=False))
    note = "" if kind != _CORNERED else f" {_SAMPLING}"
    words = f"<p>Stretches past a limit at ds/dt = {rate:g} rad/s: {total}.{note}</p>"
    return section(f"Limits axis by axis, {kind} interpolation", words, table(("axis", "limit", *heads), rows, left=2))


def _cells(one: DerivativeAnalysis, use: Array, kind: str) -> list[str]:
    worst = int(np.argmax(use))
    over = use > 1.0
    stretches = int(np.count_nonzero(over[1:] & ~over[:-1])) + int(over[0])
    marked = '<span class="low">{}</span>' if stretches and kind != _CORNERED else "{}"
    line = int(one.line[worst])
    return [
        marked.format(stretches),
        marked.format(number(float(use[worst]), 3)),
        number(float(one.s[worst]), 4, "rad"),
        str(line) if line else "–",
    ]
