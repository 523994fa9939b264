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
    table = Table(box=None, padding=(0, 2), show_edge=False)
    for title in ("way", "price, fitted", "price, withheld", "1/k_F mean (lowest)", "travel", "feed held"):
        table.add_column(title, justify="left" if title == "way" else "right", no_wrap=title == "way")
    for way in summary.ways:
        figures: TunedFigures = getattr(way, judged)
        table.add_row(
            shown_text(way.way),
            _price(way.trained),
            _price(way.withheld),
            f"{_number(figures.inv_kf_mean, 3)} ({_number(figures.inv_kf_min, 3)})",
            ", ".join(f"{shown_number(v, 0)} {k.replace('_', ' ')}" for k, v in figures.travel.items()),
            f"{_number(figures.feed_held_percent, 1)} %",
        )
    where = ", ".join(f"{axis} {shown_number(v)}" for axis, v in summary.table_error_at.items())
    return Group(
        Text(f"{summary.engine} of {summary.cell}: {summary.budget} candidates a fit, {summary.seeds} seeds"),
        Text("price: metres for each metre cut (conditioning, margins, external travel, feed); less is better"),
        Text(""),
        table,
        Text(""),
        Text(f"Least by {summary.judged_by}: {summary.best}", style="bold"),
        Text(f"The compiled table is at most {shown_number(summary.table_error_percent)} % off, at {where}"),
        Text(f"Files: {', '.join(summary.files)}"),
    )


def _price(figures: TunedFigures | None) -> str:
    """A price with its spread over the seeds, and paths that were not followed."""
    if figures is None:
        return "-"
    text = shown_number(figures.price, 4)
    if len(figures.price_by_seed) > 1:
        text += f" ({shown_number(min(figures.price_by_seed), 4)} to {shown_number(max(figures.price_by_seed), 4)})"
    lost = figures.paths - figures.followed
    return f"{text}; {lost} not followed" if lost else text


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else shown_number(value, digits)
