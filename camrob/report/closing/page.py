"""The ledger of a loop as a page: how far the tool was off, turn by turn, and what was found."""

from __future__ import annotations

from urllib.parse import quote

import numpy as np

from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
from camrob.report.page.parts import card_row, section, table
from camrob.summaries.closing.close_loop_summary import CloseLoopSummary

__all__ = ["ledger_report"]


def ledger_report(ledger: CloseLoopSummary) -> str:
    """The page as text."""
    charts = [_chart(ledger)] if any(t.measured is not None for t in ledger.turns) else []
    body = "\n".join(
        [
            "<main>",
            f'<header><h1>The loop of {escape(ledger.toolpath)}</h1><p class="made">on the cell '
            f"<b>{escape(ledger.cell)}</b></p></header>",
            section("How it stands", f"<p><b>{escape(ledger.outcome)}</b>: {escape(ledger.next)}.</p>", _cards(ledger)),
            *(chart_section(c) for c in charts),
            _turns(ledger),
            "<footer>Made by camrob. Measured figures include the instrument's noise; predicted ones include neither noise nor "
            "what stays unexplained. This page is complete in itself: it loads nothing and sends nothing.</footer></main>",
        ]
    )
    return page(f"The loop of {ledger.toolpath}", body, {"names": {}, "charts": chart_data(charts)})


def _cards(ledger: CloseLoopSummary) -> str:
    seen = [t.measured for t in ledger.turns if t.measured is not None]
    cards = [("Tolerance", number(ledger.tolerance_mm, 3, "mm"), "for 95 % of the path")]
    if seen:
        best = min(seen, key=lambda size: size.rms_mm)
        cards.append(("95 % at first", number(seen[0].p95_mm, 3, "mm"), f"rms {seen[0].rms_mm:.3f} mm"))
        cards.append((f"95 % at best, turn {ledger.best}", number(best.p95_mm, 3, "mm"), f"rms {best.rms_mm:.3f} mm"))
    return card_row(cards)


def _chart(ledger: CloseLoopSummary) -> LineChart:
    seen = [t for t in ledger.turns if t.measured is not None]
    predicted = [t for t in ledger.turns if t.predicted is not None]
    turn = np.array([float(t.turn) for t in seen])
    curves = [
        Curve("95 %, measured", turn, np.array([t.measured.p95_mm for t in seen if t.measured]), "solid", 0),
        Curve("rms, measured", turn, np.array([t.measured.rms_mm for t in seen if t.measured]), "solid", 1),
        Curve("tolerance", turn, np.full(len(seen), ledger.tolerance_mm), "dash", 3),
    ]
    if predicted:
        at = np.array([float(t.turn) for t in predicted])
        curves.append(
            Curve("rms, predicted", at, np.array([t.predicted.rms_mm for t in predicted if t.predicted]), "dot", 1)
        )
    return LineChart(
        "turns", "Off the intended path, turn by turn", "Along lines and arcs.", "turn", "mm", tuple(curves)
    )


def _turns(ledger: CloseLoopSummary) -> str:
    rows = []
    for t in ledger.turns:
        size = t.measured
        links = [f'<a href="{quote(t.diagnosis)}/diagnosis.html">diagnosis</a>'] if t.diagnosis else []
        rows.append(
            [
                f"{t.turn}",
                f"<code>{escape(t.program)}</code><br>{escape(t.made)}",
                "<br>".join([escape(", ".join(t.found)) or "–", *links]),
                *(["–"] * 3 if size is None else [number(v, 3) for v in (size.rms_mm, size.p95_mm, size.max_mm)]),
                *(
                    "–" if v is None else f"{v:.3f}"
                    for v in (t.predicted and t.predicted.rms_mm, t.noise_mm, t.rest_mm)
                ),
            ]
        )
    head = ("turn", "program", "found", "rms mm", "95 %", "worst", "predicted rms", "noise", "unexplained")
    return section("The turns", table(head, rows, left=3))
