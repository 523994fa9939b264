"""The summary of `camrob feed` for a terminal: the paper's statements beside what was found, or the limits that are passed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import shown_number, shown_text
from camrob.summaries.feed_summary import DerivativeSummary, FeedSummary, StatementFigures, WeldSummary

__all__ = ["render_feed"]

_STYLES = {"holds": "green", "does not hold": "red", "unclear": "yellow"}
_WORST = 3  # a screen's room; the JSON has all


def render_feed(summary: FeedSummary) -> RenderableType:
    """Statements, schemes or analyses, and the files."""
    found = _schemes(summary) if isinstance(summary, WeldSummary) else _analyses(summary)
    return Group(*_statements(summary.statements or ()), *found, Text(f"Written: {', '.join(summary.files)}"))


def _statements(rows: Sequence[StatementFigures]) -> Iterator[RenderableType]:
    if rows:
        table = Table(box=None, padding=(0, 2, 1, 0), header_style="bold")
        for heading in ("published", "found", ""):
            table.add_column(heading)
        for row in rows:
            verdict = shown_text(row.verdict, _STYLES.get(row.verdict, ""))
            table.add_row(shown_text(row.published), shown_text(row.found), verdict)
        yield table


def _schemes(summary: WeldSummary) -> Iterator[RenderableType]:
    for scheme in summary.schemes:
        times = {
            "published": scheme.published.time_s,
            "optimum": scheme.optimum_moving.time_s,
            "from rest to rest": scheme.optimum_resting.time_s,
        }
        text = ", ".join(f"{name} {shown_number(seconds, 4)} s" for name, seconds in times.items())
        yield Text(f"At most {shown_number(scheme.feed_top_m_s, 1)} m/s: {text}")
    text = ", ".join(f"{axis} {shown_number(value, 0)}" for axis, value in summary.torque_max_nm.items() if value > 0.5)
    yield shown_text(f"Largest torques, Nm, with assumed centres of mass: {text}")


def _analyses(summary: DerivativeSummary) -> Iterator[RenderableType]:
    for one in summary.analyses:
        worst = [
            f"{w.axis} {w.quantity} {shown_number(w.times, 2)} times at {summary.line_counts} {w.line}"
            for w in one.worst[:_WORST]
        ]
        least = min(one.rate_admitted.speed, one.rate_admitted.acceleration, one.rate_admitted.jerk)
        count = shown_number(one.violations, 0)
        text = f"{one.coordinates}, {one.interpolation} interpolation: stretches past a limit at "
        text += f"{shown_number(summary.rate_rad_s, 2)} rad/s {count}; all limits admit {shown_number(least, 3)} rad/s"
        yield shown_text(text + (f"; worst: {', '.join(worst)}" if worst else ""))
