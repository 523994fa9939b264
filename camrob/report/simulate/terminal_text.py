"""What `camrob simulate` shows a person in the terminal: warnings first, then how the program runs."""

from __future__ import annotations

from collections.abc import Mapping

from rich.console import Group, RenderableType
from rich.text import Text

from camrob.report.terminal.tables import labelled
from camrob.report.words import shown_blocks, shown_duration, shown_number, shown_text
from camrob.summaries.simulate_summary import SimulateSummary

__all__ = ["render_simulation"]

_MOST = 20  # warnings, a screen's height
_NAMED = 3  # axes that a line has room for


def render_simulation(summary: SimulateSummary) -> RenderableType:
    """Warnings, then times, what holds the tool back, and how near the axes come to what they can."""
    parts: list[RenderableType] = []
    if summary.warnings:
        parts.append(Text(f"{len(summary.warnings)} to read first", style="bold yellow"))
        parts += [
            shown_text(f"  {w.text}" + (f" (program line {w.line})" if w.line else ""), "yellow")
            for w in summary.warnings[:_MOST]
        ]
        if len(summary.warnings) > _MOST:
            parts.append(Text(f"  ... and {len(summary.warnings) - _MOST} more (--json shows all)", style="yellow"))
    grid = labelled()
    grid.add_row("Program", shown_text(f"{summary.program} on {summary.cell}: {summary.motions:,} motions"))
    grid.add_row("Takes", f"{shown_duration(summary.duration_s)} on the ideal controller, from HOME to HOME")
    grid.add_row("Held back", _held_back(summary))
    if summary.blocks is not None and summary.blocks.short:
        grid.add_row("Too short", shown_text(shown_blocks(summary.blocks)))
    rounded = summary.approximation
    off = (
        f", at most {shown_number(rounded.deviation_mm_max, 3)} mm off (program line {rounded.line})"
        if rounded.line
        else ""
    )
    grid.add_row("Corners", f"{rounded.corners:,} rounded{off}")
    grid.add_row("Axes", shown_text(_shares("speed", summary.limits.speed_share_max)))
    grid.add_row("", shown_text(_shares("acceleration", summary.limits.acceleration_share_max)))
    grid.add_row(
        "Written", shown_text(f"{', '.join(summary.files)}; {summary.rows:,} rows, every {summary.cycle_ms:g} ms")
    )
    return Group(*parts, grid)


def _held_back(summary: SimulateSummary) -> Text:
    causes = ", ".join(
        f"{cause} {seconds:.1f} s" for cause, seconds in summary.feed.by_cause.items() if seconds >= 0.05
    )
    lost = summary.feed.lost_s
    return shown_text(
        f"{lost:.1f} s against the programmed speed ({causes})"
        if causes
        else "by nothing: the programmed speed is kept"
    )


def _shares(what: str, shares: Mapping[str, float]) -> str:
    """The axes that take most of what they have."""
    largest = sorted(shares, key=lambda axis: -shares[axis])[:_NAMED]
    return f"{what}: " + ", ".join(f"{axis} {100.0 * shares[axis]:.0f} %" for axis in largest) + " of its limit at most"
