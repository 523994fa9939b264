"""The ledger of a loop as a page: how far the tool was off, turn by turn, and what was found."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from camrob.report.diagnosis.sentences import compensable_text, plain_name, sentence
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
from camrob.report.page.parts import card_row, framed, page_body, section, table, verdict_bar
from camrob.summaries.closing.close_loop_summary import CloseLoopSummary, LoopTurn
from camrob.summaries.compensate_summary import CompensateSummary
from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.units import m_to_mm

__all__ = ["ledger_report"]

_LEVELS = {"awaiting a log": "info", "within tolerance": "good"}  # others leave the path off, and say why
_MOST_TICKS = 30  # turns that have a number each below the chart

Along = tuple[NDArray[np.float64], NDArray[np.float64]]


def ledger_report(
    ledger: CloseLoopSummary,
    seen: Mapping[int, Along],
    understood: Mapping[int, DiagnosisSummary],
    corrected: Mapping[int, CompensateSummary],
) -> str:
    """The page as text.

    seen: of each turn that was measured, places along the path (K,), m, and how far the tool was off there (K,), m. understood:
    what was said of each that was diagnosed; corrected: and of each whose program was compensated.
    """
    charts = [_chart(ledger), _along_chart(ledger, seen)] if seen else []
    body = page_body(
        f"The loop of {escape(ledger.toolpath)}",
        f"on the cell <b>{escape(ledger.cell)}</b>",
        _verdict(ledger),
        _cards(ledger),
        *(chart_section(c) for c in charts),
        _turns(ledger),
        *(_turn(ledger, t, understood.get(t.turn), corrected.get(t.turn + 1)) for t in ledger.turns),
        note="Measured figures include the instrument's noise; predicted ones include neither noise nor what stays unexplained.",
    )
    return page(f"The loop of {ledger.toolpath}", body, {"names": {}, "charts": chart_data(charts)})


def _verdict(ledger: CloseLoopSummary) -> str:
    level = _LEVELS.get(ledger.outcome, "warn")
    word = escape(ledger.outcome[:1].upper() + ledger.outcome[1:])
    step = escape(ledger.next[:1].upper() + ledger.next[1:])
    return verdict_bar(level, f"{word}.", f"{step}.")


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
        "turns",
        "Off the intended path, turn by turn",
        "Along the way that is cut.",
        "turn",
        "off the path [mm]",
        tuple(curves),
        counted=len(seen) < _MOST_TICKS,
    )


def _along_chart(ledger: CloseLoopSummary, seen: Mapping[int, Along]) -> LineChart:
    shown = {min(seen), max(seen), ledger.best}
    curves = []
    for turn, (along, off) in seen.items():
        order = np.argsort(along, kind="stable")
        curves.append(Curve(f"turn {turn}", m_to_mm(along[order]), m_to_mm(off[order]), shown=turn in shown))
    ends = m_to_mm(
        np.array([min(along.min() for along, _ in seen.values()), max(along.max() for along, _ in seen.values())])
    )
    curves.append(Curve("tolerance", ends, np.full(2, ledger.tolerance_mm), "dash", 3))
    return LineChart(
        "along",
        "Where the tool was off",
        "As measured, along the path that was meant. Other turns than the first, the best and the last are drawn when their name "
        "is clicked.",
        "along the intended path [mm]",
        "off the path [mm]",
        tuple(curves),
    )


def _turn(
    ledger: CloseLoopSummary, turn: LoopTurn, said: DiagnosisSummary | None, corrected: CompensateSummary | None
) -> str:
    """From program to correction: what was run, measured, found, and taken off in the next turn (`corrected`)."""
    folder = quote(turn.program.rpartition("/")[0])
    stem = quote(turn.program.rpartition("/")[2].rpartition(".")[0])
    steps = [("Program", f'<a href="{folder}/{stem}.html">{escape(turn.program)}</a>, {escape(turn.made)}.')]
    if turn.predicted is not None:
        steps.append(
            ("Predicted", f"{number(turn.predicted.rms_mm, 3, 'mm')} rms beside noise and what is unexplained.")
        )
    if turn.measured is None:
        steps.append(("Run", "its log is awaited."))
    else:
        rms, most, worst = (
            number(v, 3, "mm") for v in (turn.measured.rms_mm, turn.measured.p95_mm, turn.measured.max_mm)
        )
        figures = f"{rms} rms, 95 % within {most}, worst {worst}"
        steps.append(("Run", f"<code>{escape(turn.log)}</code>: {figures}."))
    if said is not None:
        link = f'<a href="{quote(turn.diagnosis)}/diagnosis.html">the whole diagnosis</a>'
        steps.append(("Diagnosis", f"{escape(sentence(said))} ({link})"))
        after = next((t for t in ledger.turns if t.turn == turn.turn + 1), None)
        if after is not None and corrected is not None:
            page_of = quote(f"{after.program.rpartition('.')[0]}.html")
            text = f'<a href="{page_of}">{escape(after.program)}</a> {escape(_taken_off(said, corrected))}'
            steps.append(("Correction", text))
        elif text := compensable_text(said):
            steps.append(("Correction", escape(text)))
    if turn.experiment:
        steps.append(("Experiment", f"<code>{escape(turn.experiment)}</code> tells two sets of causes apart."))
    best = ": nearest to the path so far" if turn.turn == ledger.best else ""
    rows = "".join(f"<tr><th>{name}</th><td>{text}</td></tr>" for name, text in steps)
    return section(f"Turn {turn.turn}{best}", framed(f"<table><tbody>{rows}</tbody></table>"))


def _taken_off(said: DiagnosisSummary, corrected: CompensateSummary) -> str:
    """What a compensated program takes off, by how much its targets were moved, and what that makes of the path."""
    effects = said.compensable.effects if corrected.calibration is not None else ()
    axes = {e.effect: ", ".join(e.axes) for e in said.claimed}
    constants = [f"{e} of {axes[e]}" if axes.get(e) else e for e in effects]
    further = () if corrected.machine is None else corrected.machine.causes
    named = [plain_name(", ".join(n)) + w for n, w in ((constants, " (constants of the chain)"), (further, "")) if n]
    moved = f"its targets moved by up to {corrected.correction.max_mm:.3f} mm, {corrected.correction.mean_mm:.3f} mm in the mean"
    text = f"takes off {' and '.join(named) or 'nothing'}: {moved}"
    if corrected.machine is not None:
        before, now = corrected.machine.before, corrected.machine.after
        count = sum(map(len, corrected.machine.targets_added.values()))
        text += f"{f', {count:,} added' if count else ''}. As diagnosed that takes {before.rms_mm:.3f} to {now.rms_mm:.3f} mm rms"
        text += f", 95 % from {before.p95_mm:.3f} to {now.p95_mm:.3f} mm"
    return f"{text}."


def _turns(ledger: CloseLoopSummary) -> str:
    rows = []
    for t in ledger.turns:
        size = t.measured
        links = [f'<a href="{quote(t.diagnosis)}/diagnosis.html">diagnosis</a>'] if t.diagnosis else []
        rows.append(
            [
                f"{t.turn}",
                f"<code>{escape(t.program)}</code><br>{escape(t.made)}",
                "<br>".join([escape(", ".join(map(plain_name, t.found))) or "–", *links]),
                *(["–"] * 3 if size is None else [number(v, 3) for v in (size.rms_mm, size.p95_mm, size.max_mm)]),
                *(
                    "–" if v is None else f"{v:.3f}"
                    for v in (t.predicted and t.predicted.rms_mm, t.noise_mm, t.rest_mm)
                ),
            ]
        )
    head = ("turn", "program", "found", "rms mm", "95 %", "worst", "predicted rms", "noise", "unexplained")
    return section("The turns", table(head, rows, left=3))
