"""The summary of `camrob tracker` in the terminal: published beside ours, then what does better.

Turns are the places where joints reverse.
"""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.terminal.tables import columns
from camrob.report.words import shown_text
from camrob.summaries.tracker_summary import TrackerSummary
from camrob.units import m_to_um, mm_to_m

__all__ = ["render_tracker"]


def render_tracker(summary: TrackerSummary) -> RenderableType:
    """The summary as tables."""
    return Group(
        shown_text(f"Tracker loop of {summary.cell}, K = {summary.law.gain:g} every {summary.law.cycle_ms:g} ms"),
        Text("A simulation: errors of the robot are assumed, and tuned where it says so.", style="yellow"),
        Text(""),
        _published(summary),
        Text(""),
        _better(summary),
        Text(""),
        Text(f"Written: {', '.join(summary.files)}"),
    )


def _published(summary: TrackerSummary) -> Table:
    headings = ("", "published", "ours, in simulation", "")
    table = columns(*headings, left=headings)
    for row in summary.published:
        table.add_row(*(Text(text) for text in (row.what, row.published, row.found, row.kind)))
    return table


def _better(summary: TrackerSummary) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="bold")
    table.add_column("micrometres, in truth", min_width=28)
    for heading in ("square tool rms", "corners most", "turns most", "circle tool rms", "off path mean", "turns most"):
        table.add_column(heading, justify="right", width=7)
    for v in summary.variants:
        square, circle = v.square, v.circle
        values = (
            square.tool_mm.rms,
            max(square.corners_mm, default=0.0),
            max(square.reversal_peaks_mm, default=0.0),
            circle.tool_mm.rms,
            circle.path_mm.mean,
            max(circle.reversal_peaks_mm, default=0.0),
        )
        table.add_row(Text(v.name), *(f"{float(m_to_um(mm_to_m(value))):.0f}" for value in values))
    return table
