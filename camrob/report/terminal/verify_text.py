"""The summary of `camrob verify` for a terminal: the verdict, what stands against the program, what was not judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import shown_number, shown_text

__all__ = ["render_verify"]

Summary = Mapping[str, Any]

_MOST = 20  # findings of a kind that are shown
_AREAS = ("path", "frames", "process", "collisions", "limits")


def render_verify(summary: Summary) -> RenderableType:
    """What stands against the program first, then what could not be judged, warnings and figures."""
    parts: list[RenderableType] = [_verdict(summary)]
    for title, key, style in (("against it", "errors", "red"), ("to read", "warnings", "yellow")):
        rows = [row for row in summary.get(key) or [] if row.get("code") != "not-judged"]  # listed below
        if rows:
            parts += [Text(""), Text(title.capitalize(), style=f"bold {style}"), *_rows(rows, style)]
    open_ends = summary.get("not_judged") or []
    if open_ends:
        parts += [Text(""), Text("Not judged", style="bold yellow")]
        parts += [shown_text(f"  {text}") for text in open_ends[:_MOST]]
        if len(open_ends) > _MOST:
            parts.append(Text(f"  ... and {len(open_ends) - _MOST} more (--json shows all)"))
    return Group(*parts, Text(""), _figures(summary))


def _verdict(summary: Summary) -> Text:
    """One line: good, bad, or open."""
    name, ok = summary.get("program", "-"), summary.get("ok")
    count = len(summary.get("errors") or [])
    if ok:
        return Text(f"{name}: nothing stands against it", style="bold green")
    if ok is None:
        return Text(f"{name}: nothing was found against it, but not all of it could be judged", style="bold yellow")
    return Text(f"{name}: {count} thing{'s' if count != 1 else ''} against it", style="bold red")


def _rows(rows: Sequence[Summary], style: str) -> Iterator[RenderableType]:
    grid = Table.grid(padding=(0, 2))
    grid.add_column(justify="right", no_wrap=True, style=style)
    grid.add_column()
    for row in rows[:_MOST]:
        line, count = row.get("line"), row.get("count", 1)
        times = f" ({count} times)" if count > 1 else ""
        grid.add_row(f"line {line}" if line else "", shown_text(f"{row.get('text', '')}{_by(row)}{times}"))
    yield grid
    if len(rows) > _MOST:
        yield Text(f"... and {len(rows) - _MOST} more (--json shows all)", style=style)


def _by(row: Summary) -> str:
    """How far a value is off, where the finding has one."""
    value, limit, unit = row.get("value"), row.get("limit"), row.get("unit") or ""
    if value is None:
        return ""
    return f": {shown_number(value, 4)} {unit}" + ("" if limit is None else f", allowed {shown_number(limit, 4)}")


def _figures(summary: Summary) -> RenderableType:
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column()
    judged = summary.get("judged") or {}
    words = {True: "good", False: "bad", None: "not judged"}
    grid.add_row("Judged", ", ".join(f"{area} {words[judged.get(area)]}" for area in _AREAS))
    against = summary.get("against")
    if against:
        grid.add_row(
            "Against",
            shown_text(
                f"{against.get('file', '-')}: {against.get('met', '-')} of {against.get('points', '-')} points met, at most "
                f"{shown_number(against.get('position_error_mm_max'), 4)} mm off"
            ),
        )
    if summary.get("motions") is not None:
        files = ", ".join(summary.get("files") or [])
        grid.add_row("Program", shown_text(f"{shown_number(summary['motions'], 0)} motions in {files}"))
        conditioning = (summary.get("conditioning") or {}).get("inv_kf_min")
        grid.add_row("Conditioning", f"1/k_F lowest {shown_number(conditioning, 3)} (0 is singular, 1 ideal)")
    return grid
