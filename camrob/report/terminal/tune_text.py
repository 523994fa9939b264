"""The summary of `camrob tune-engines` for a terminal: which weights cost least where they were not fitted."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import shown_number, shown_text
from camrob.summaries.tune_summary import TunedFigures, TuneSummary

__all__ = ["render_tune"]


def render_tune(summary: TuneSummary) -> RenderableType:
    """The ways side by side, then the best, the compiled table's error, and the files."""
    judged = "withheld" if summary.withheld else "trained"
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for title in ("price", "fitted", "withheld", "1/k_F", "least", "travel", "feed %"):
        table.add_column(title, justify="left" if title == "price" else "right", no_wrap=True)
    for way in summary.ways:
        figures: TunedFigures = getattr(way, judged)
        table.add_row(
            shown_text(way.way),
            _price(way.trained),
            _price(way.withheld),
            shown_number(figures.inv_kf_mean, 3),
            shown_number(figures.inv_kf_min, 3),
            "\n".join(f"{k.partition('_')[0]} {shown_number(v, 0)}" for k, v in figures.travel.items()),
            shown_number(figures.feed_held_percent, 1),
        )
    where = ", ".join(f"{axis} {shown_number(v)}" for axis, v in summary.table_error_at.items())
    return Group(
        Text(f"{summary.engine} of {summary.cell}: {summary.budget} candidates a fit, {summary.seeds} seeds"),
        Text("price: metres for each metre cut (conditioning, margins, travel, feed)"),
        Text("travel: external axes while cutting, mm and degrees; feed %: of the length at it"),
        Text(""),
        table,
        Text(""),
        Text(f"Cheapest on {summary.judged_by}: {summary.best}", style="bold"),
        Text(f"The compiled table is at most {shown_number(summary.table_error_percent)} % off, at {where}"),
        Text(f"Files: {', '.join(summary.files)}"),
    )


def _price(figures: TunedFigures | None) -> str:
    """A price with its spread over the seeds, and paths that were not followed."""
    if figures is None:
        return "-"
    text = shown_number(figures.price, 3)
    if len(figures.price_by_seed) > 1:
        text += f"\n{shown_number(min(figures.price_by_seed), 3)} to {shown_number(max(figures.price_by_seed), 3)}"
    lost = figures.paths - figures.followed
    return f"{text}\n{lost} not followed" if lost else text
