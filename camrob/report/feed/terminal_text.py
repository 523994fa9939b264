"""The summary of `camrob feed` for a terminal: the paper's statements beside what was found, or the limits that are passed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import shown_number, shown_text

__all__ = ["render_feed"]

Summary = Mapping[str, Any]

_STYLES = {"holds": "green", "holds not": "red", "unclear": "yellow"}
_WORST = 3  # a screen's room; the JSON has all


def render_feed(summary: Summary) -> RenderableType:
    """Statements, schemes or analyses, and the files."""
    parts: list[RenderableType] = [*_statements(summary), *_schemes(summary), *_analyses(summary)]
    return Group(*parts, Text(f"Written: {', '.join(map(str, summary.get('files') or []))}"))


def _statements(summary: Summary) -> Iterator[RenderableType]:
    rows = summary.get("statements") or []
    if rows:
        table = Table(box=None, padding=(0, 2, 1, 0), header_style="bold")
        for heading in ("published", "found", ""):
            table.add_column(heading)
        for row in rows:
            verdict = str(row.get("verdict"))
            table.add_row(
                shown_text(row.get("published")),
                shown_text(row.get("found")),
                shown_text(verdict, _STYLES.get(verdict, "")),
            )
        yield table


def _schemes(summary: Summary) -> Iterator[RenderableType]:
    for scheme in summary.get("schemes") or []:
        times = {
            name: shown_number((scheme.get(key) or {}).get("time_s"), 4)
            for name, key in (
                ("published", "published"),
                ("optimum", "optimum_moving"),
                ("from rest to rest", "optimum_resting"),
            )
        }
        text = ", ".join(f"{name} {seconds} s" for name, seconds in times.items())
        yield Text(f"At most {shown_number(scheme.get('feed_top_m_s'), 1)} m/s: {text}")
    torques = summary.get("torque_max_nm")
    if isinstance(torques, Mapping):
        text = ", ".join(f"{axis} {shown_number(value, 0)}" for axis, value in torques.items() if value > 0.5)
        yield shown_text(f"Largest torques, Nm, with assumed centres of mass: {text}")


def _analyses(summary: Summary) -> Iterator[RenderableType]:
    place = summary.get("line_counts", "line")
    for one in summary.get("analyses") or []:
        worst = [
            f"{w['axis']} {w['quantity']} {shown_number(w['times'], 2)} times at {place} {w['line']}"
            for w in (one.get("worst") or [])[:_WORST]
        ]
        least = min((one.get("rate_admitted") or {"": 0.0}).values())
        count = shown_number(one.get("violations"), 0)
        text = f"{one.get('coordinates')}, {one.get('interpolation')} interpolation: stretches past a limit at "
        text += f"{shown_number(summary.get('rate_rad_s'), 2)} rad/s {count}; all limits admit {shown_number(least, 3)} rad/s"
        yield shown_text(text + (f"; worst: {', '.join(worst)}" if worst else ""))
