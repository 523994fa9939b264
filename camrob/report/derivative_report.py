"""The report of a derivative analysis: the paper's Figure 1 for an axis, admitted rates and violations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.cell.cell import Cell
from camrob.feed.derivative_analysis import DerivativeAnalysis
from camrob.report.html import escape, number, page
from camrob.report.line_charts import Curve, LineChart, chart_data, chart_section

__all__ = ["derivative_report"]

_ROWS = 60
_NAMES = ("nominal", "compensated")


def derivative_report(
    cell: Cell, analyses: Mapping[str, Sequence[DerivativeAnalysis]], *, axis: str, rate: float
) -> str:
    """The page as text. analyses: for each interpolation, that of the nominal coordinates and maybe the compensated ones.

    axis: whose curves are drawn; rate: ds/dt, rad/s, that violations are counted at.
    """
    charts = [chart for kind, both in analyses.items() for chart in _figure(kind, both, axis)]
    charts += [_rates(kind, both[0]) for kind, both in analyses.items()]
    body = "\n".join(
        [
            "<main>",
            f"<h1>Machine coordinates along the total displacement of the axes</h1><p class='made'>{escape(cell.title)}; axis "
            f"{escape(axis)}; violations at ds/dt = {rate:g} rad/s</p>",
            *(_table(kind, both, rate) for kind, both in analyses.items()),
            *(chart_section(chart) for chart in charts),
            "<footer>Made by camrob. This page is complete in itself: it loads nothing and sends nothing.</footer>",
            "</main>",
        ]
    )
    return page("Derivatives of the machine coordinates", body, {"names": {}, "charts": chart_data(charts)})


def _figure(kind: str, both: Sequence[DerivativeAnalysis], axis: str) -> list[LineChart]:
    """The four diagrams of Figure 1."""
    k = both[0].axes.index(axis)
    v, a, j = (float(b[k]) for b in (both[0].bounds.speed, both[0].bounds.acceleration, both[0].bounds.jerk))
    s = both[0].s
    ends = np.array([s[0], s[-1]])

    def limits(*named: tuple[str, float]) -> tuple[Curve, ...]:
        return tuple(
            Curve(f"{sign}{name}", ends, np.full(2, value if sign == "+" else -value), "dot", color)
            for color, (name, value) in enumerate(named, start=2)
            for sign in "+-"
        )

    rows = (
        ("q", "coordinate", "rad or m", ()),
        ("q_s", "first derivative", "per rad of s", limits(("speed", v), ("acceleration", a), ("jerk", j))),
        ("q_ss", "second derivative", "per rad² of s", limits(("acceleration", a), ("jerk", j))),
        ("q_sss", "third derivative", "per rad³ of s", limits(("jerk", j))),
    )
    charts = []
    for name, title, unit, bounds in rows:
        curves = tuple(
            Curve(which, one.s, np.asarray(getattr(one, name))[:, k], "solid", 0 if which == "nominal" else 3)
            for which, one in zip(_NAMES, both, strict=False)
        )
        charts.append(
            LineChart(
                f"{kind}-{name}", f"{escape(axis)}: {title}, {kind} interpolation (Figure 1)",
                "Dotted: the axis's bounds at ds/dt = 1 rad/s and its derivatives 1. Drag to look closer, as the paper's "
                "last four diagrams do.", "s, rad", unit, curves + bounds,
            )
        )  # fmt: skip
    return charts


def _rates(kind: str, one: DerivativeAnalysis) -> LineChart:
    curves = tuple(
        Curve(name, one.s, np.minimum(rate, 1e6))
        for name, rate in (
            ("speed (eq. 21)", one.rate_speed),
            ("acceleration (eq. 27)", one.rate_acceleration),
            ("jerk (eq. 28)", one.rate_jerk),
        )
    )
    return LineChart(
        f"{kind}-rates", f"Rate ds/dt that all axes admit, {kind} interpolation", "Each bound by itself, at a constant rate.",
        "s, rad", "rad/s", curves, True,
    )  # fmt: skip


def _table(kind: str, both: Sequence[DerivativeAnalysis], rate: float) -> str:
    rows = []
    for which, one in zip(_NAMES, both, strict=False):
        found = sorted(one.violations(rate), key=lambda v: -v.worst)
        rows.append(
            f"<tr><td>{which}</td><td>{len(found)} violations</td><td></td><td class='n'></td><td class='n'></td></tr>"
        )
        rows += [
            f"<tr><td>{which}</td><td>{escape(v.axis)} {escape(v.quantity)}</td><td>{f'line {v.line}' if v.line else '–'}</td>"
            f"<td class='n'>{number(v.worst_at, 4, 'rad')}</td><td class='n low'>{number(v.worst, 2)}</td></tr>"
            for v in found[:_ROWS]
        ]
    return (
        f"<section><h2>Violations, {escape(kind)} interpolation</h2><div class='scroll'><table><thead><tr><th>coordinates</th>"
        "<th>bound</th><th>place</th><th class='n'>s</th><th class='n'>times the bound</th></tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table></div></section>"
    )
