"""The report of a derivative analysis: the paper's Figure 1 for any axis, violations axis by axis, admitted rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
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
    charts = [chart for axis in axes for kind, both in analyses.items() for chart in _figure(kind, both, axis, place)]
    charts += [_rates(kind, both) for kind, both in analyses.items()]
    body = "\n".join(
        [
            "<main>",
            f"<h1>Machine coordinates along the total displacement of the axes</h1><p class='made'>{escape(cell.title)}; "
            f"{escape(source)}{'; ' if source else ''}curves of {escape(', '.join(axes))}; violations at ds/dt = {rate:g} "
            "rad/s</p>",
            statements_section(statements) if statements else "",
            *(_table(kind, both, rate, place) for kind, both in analyses.items()),
            *(chart_section(chart) for chart in charts),
            "<footer>Made by camrob. This page is complete in itself: it loads nothing and sends nothing.</footer>",
            "</main>",
        ]
    )
    return page("Derivatives of the machine coordinates", body, {"names": {}, "charts": chart_data(charts)})


def _figure(kind: str, both: Sequence[DerivativeAnalysis], axis: str, place: str) -> list[LineChart]:
    """The eight diagrams of Figure 1: over the whole path, and over a short stretch in its middle."""
    k = both[0].axes.index(axis)
    v, a, j = (float(b[k]) for b in (both[0].bounds.speed, both[0].bounds.acceleration, both[0].bounds.jerk))
    rows = (
        ("q", "coordinate", "rad or m", ()),
        ("q_s", "first derivative", "per rad of s", (("speed", v, 2), ("acceleration", a, 4), ("jerk", j, 5))),
        ("q_ss", "second derivative", "per rad² of s", (("acceleration", a, 4), ("jerk", j, 5))),
        ("q_sss", "third derivative", "per rad³ of s", (("jerk", j, 5),)),
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
                    f"{sign}{limit}",
                    np.array(window),
                    np.full(2, value if sign == "+" else -value),
                    "dot",
                    color,
                    value < _FAR * most,
                )
                for limit, value, color in limits
                for sign in "+-"
            )
            closer = f", s from {window[0]:.3f} to {window[1]:.3f} rad" if name else ""
            charts.append(
                LineChart(
                    f"{kind}-{axis}-{quantity}{name}",
                    f"{escape(axis)}: {title}, {kind} interpolation{closer} (Figure 1)",
                    "Dotted: the axis's bounds where ds/dt and its two derivatives are 1 rad/s, 1 rad/s², 1 rad/s³, as in the "
                    "paper; those far beyond the curves are in the legend: click to see them. Drag to look closer.",
                    "s, rad",
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
        "s, rad",
        "rad/s",
        curves,
        True,
    )


def _table(kind: str, both: Sequence[DerivativeAnalysis], rate: float, place: str) -> str:
    """Violations axis by axis: how many stretches, the worst, and where; nominal beside compensated."""
    head = "".join(
        f'<th class="n">{which}: past it</th><th class="n">at most</th><th class="n">s</th>'
        f'<th class="n">{escape(place)}</th>'
        for which, _one in zip(_NAMES, both, strict=False)
    )
    rows = []
    for k, axis in enumerate(both[0].axes):
        for quantity, key in _LIMITS:
            cells = "".join(_cells(one, np.abs(one.constraints(rate)[key][:, k]), kind) for one in both)
            rows.append(f"<tr><td>{escape(axis)}</td><td>{quantity}</td>{cells}</tr>")
    total = ", ".join(f"{which} {len(one.violations(rate)):,}" for which, one in zip(_NAMES, both, strict=False))
    note = "" if kind != _CORNERED else f" {_SAMPLING}"
    return (
        f"<section><h2>Limits axis by axis, {escape(kind)} interpolation</h2><p>Stretches past a limit at ds/dt = {rate:g} "
        f"rad/s: {total}. At most: times the limit, and where.{note}</p><div class='scroll'><table><thead><tr><th>axis</th>"
        f"<th>limit</th>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div></section>"
    )


def _cells(one: DerivativeAnalysis, use: Array, kind: str) -> str:
    worst = int(np.argmax(use))
    over = use > 1.0
    stretches = int(np.count_nonzero(over[1:] & ~over[:-1])) + int(over[0])
    low = " low" if stretches and kind != _CORNERED else ""
    line = int(one.line[worst])
    return (
        f'<td class="n{low}">{stretches}</td><td class="n{low}">{number(float(use[worst]), 3)}</td>'
        f'<td class="n">{number(float(one.s[worst]), 4, "rad")}</td><td class="n">{line if line else "–"}</td>'
    )
