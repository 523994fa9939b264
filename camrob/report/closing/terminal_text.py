"""What `close-loop` shows a person in the terminal."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from camrob.report.diagnosis.sentences import plain_name
from camrob.report.terminal.tables import columns
from camrob.report.words import shown_text
from camrob.summaries.closing.close_loop_summary import CloseLoopSummary

__all__ = ["render_ledger"]


def render_ledger(summary: CloseLoopSummary) -> RenderableType:
    """The turns side by side, how the loop stands, and what to do next."""
    headings = ("turn", "program", "predicted rms", "measured rms", "95 %", "worst", "found")
    table = columns(*headings, left=("program", "found"), fold=True)
    for turn in summary.turns:
        size = turn.measured
        table.add_row(
            str(turn.turn),
            shown_text(turn.made),
            "-" if turn.predicted is None else f"{turn.predicted.rms_mm:.3f}",
            *(["-"] * 3 if size is None else [f"{v:.3f}" for v in (size.rms_mm, size.p95_mm, size.max_mm)]),
            shown_text(", ".join(map(plain_name, turn.found)) or "-"),
        )
    style = "bold" if summary.kept else "bold red"
    return Group(
        Text(f"mm off the intended path; 95 % of it shall be within {summary.tolerance_mm:g}"),
        Text(),
        table,
        Text(),
        Text(summary.outcome, style=style),
        shown_text(summary.next),
    )
