"""Summaries in the terminal, in the words of the shop: what needs attention first, then what was made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.post.feed_sentences import feed_rows
from camrob.report.post.plan_text import plan_lines
from camrob.report.words import shown_duration, shown_number, shown_text

__all__ = ["render_post", "render_summary"]

Summary = Mapping[str, Any]

_MOST_WARNINGS = 20
_MOST_REGIONS = 12
_NEAREST = 3  # axes shown with their margin


def _linear(summary: Summary) -> set[str]:
    """The axes that move in mm, as the names of the external travels tell."""
    return {key.removesuffix("_mm") for key in _part(summary, "external_travel") if key.endswith("_mm")}


def _part(summary: Summary, key: str) -> Summary:
    """The object below a key, empty where there is none."""
    value = summary.get(key)
    return value if isinstance(value, Mapping) else {}


def _grid() -> Table:
    """A two-column layout without lines."""
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column()
    return grid


def _warnings(summary: Summary) -> Iterator[RenderableType]:
    """The warnings, with their lines of the CL file."""
    warnings = summary.get("warnings") or []
    if not warnings:
        yield Text("No warnings.", style="green")
        return
    yield Text(f"{len(warnings)} warning{'s' if len(warnings) > 1 else ''} to read first", style="bold yellow")
    grid = Table.grid(padding=(0, 2))
    grid.add_column(justify="right", no_wrap=True, style="yellow")
    grid.add_column()
    for warning in warnings[:_MOST_WARNINGS]:
        line = warning.get("line")
        grid.add_row(f"line {line}" if line else "", shown_text(warning.get("text", "")))
    yield grid
    if len(warnings) > _MOST_WARNINGS:
        yield Text(f"... and {len(warnings) - _MOST_WARNINGS} more, in the report and NAME.json", style="yellow")


def _limits(summary: Summary) -> Text:
    """The axes that come nearest to their limits."""
    limits = _part(summary, "limits")
    margins = {k: v for k, v in _part(limits, "margin_min").items() if isinstance(v, int | float)}
    # degrees and millimetres don't compare: the linear axes are named apart
    linear = _linear(summary)
    turning = sorted((v, k) for k, v in margins.items() if k not in linear)[:_NEAREST]
    near = [f"{k} {shown_number(v)} deg" for v, k in turning]
    near += [f"{k} {shown_number(v)} mm" for k, v in margins.items() if k in linear]
    violations = limits.get("violations")
    text = Text(f"least margin to a limit: {', '.join(near) or '-'}")
    if violations:
        text.append(f"; {violations} points past a limit", style="bold red")
    return text


def _collisions(summary: Summary) -> Text:
    """Collisions and the least clearance."""
    part = _part(summary, "collisions")
    if not part.get("checked"):
        return Text("not checked", style="yellow")
    clearance = part.get("clearance_min_mm")
    beside = "" if clearance is None else f"; least clearance {shown_number(clearance)} mm"
    if part.get("count"):
        return Text(f"{part['count']} found{beside}", style="bold red")
    return Text(f"none{beside}")


def _conditioning(summary: Summary) -> Text:
    """1/k_F in words, and singular points."""
    part = _part(summary, "conditioning")
    text = Text(
        f"1/k_F lowest {shown_number(part.get('inv_kf_min'), 3)}, mean {shown_number(part.get('inv_kf_mean'), 3)}"
        " (0 is singular, 1 ideal)"
    )
    if summary.get("singular"):
        text.append(f"; {summary['singular']} singular points", style="bold red")
    return text


def _verified(summary: Summary) -> Text:
    """What the read-back and replay of the program found."""
    part = _part(summary, "verified")
    if not part:
        return Text("no", style="bold red")
    error = shown_number(part.get("position_error_mm_max"), 4)
    return shown_text(
        f"{part.get('points', '-')} points read back and replayed; at most {error} mm off ({part.get('by', '-')})"
    )


def _regions(regions: Sequence[Summary]) -> RenderableType:
    """One row a region."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("region", "CL lines", "points", "1/k_F at its start"):
        table.add_column(heading, justify="left" if heading == "region" else "right")
    for region in regions[:_MOST_REGIONS]:
        before, after = shown_number(region.get("inv_kf_before"), 3), shown_number(region.get("inv_kf_after"), 3)
        table.add_row(
            shown_text(region.get("name") or region.get("index", "")),
            f"{region.get('first_line', '-')} to {region.get('last_line', '-')}",
            shown_number(region.get("points"), 0),
            f"{before} to {after} by revision" if region.get("revised") else before,
        )
    if len(regions) > _MOST_REGIONS:
        table.add_row(f"... and {len(regions) - _MOST_REGIONS} more", "", "", "")
    return table


def render_post(summary: Summary) -> RenderableType:
    """The summary of `camrob post` (the JSON object of the contract) for a terminal; what is absent shows as '-'."""
    source, regions = _part(summary, "source"), summary.get("regions") or []
    time, travel = _part(summary, "time_s"), _part(summary, "external_travel")
    tracking = _part(summary, "tracking")
    grid = _grid()
    grid.add_row(
        "Program",
        shown_text(
            f"{summary.get('program', '-')} for {summary.get('cell', '-')}, method {summary.get('method', '-')}"
        ),
    )
    grid.add_row(
        "From", shown_text(f"{source.get('file', '-')} ({source.get('dialect', '-')}, {source.get('units', '-')})")
    )
    grid.add_row(
        "Points", f"{shown_number(summary.get('points'), 0)} in {len(regions)} region{'s' if len(regions) != 1 else ''}"
    )
    optimal = time.get("optimal")
    beside = "" if optimal is None else f"; {shown_duration(optimal)} at the fastest safe feed"
    grid.add_row("Time", f"{shown_duration(time.get('program'))} as programmed{beside}")
    for label, text in feed_rows(summary):
        grid.add_row(label, shown_text(text))
    grid.add_row("Conditioning", _conditioning(summary))
    grid.add_row("Axes", _limits(summary))
    grid.add_row("Collisions", _collisions(summary))
    moved = (
        ", ".join(f"{k.partition('_')[0]} {shown_number(v)} {k.partition('_')[2]}" for k, v in travel.items()) or "-"
    )
    grid.add_row("External axes", f"travel {moved}")
    grid.add_row("Tracking", f"at most {shown_number(tracking.get('position_error_mm_max'), 4)} mm before rounding")
    whole = bool(_part(summary, "witness").get("complete")) or not _part(summary, "verified")
    grid.add_row("Verified" if whole else "Verified in part", _verified(summary))
    files = [str(f) for f in summary.get("files") or []]
    if files:
        shown = files if len(files) <= 8 else [*files[:4], f"... {len(files) - 7} more ...", *files[-3:]]
        grid.add_row("Written", shown_text(", ".join(shown)))
    parts: list[RenderableType] = [*_warnings(summary), Text(""), grid]
    if len(regions) > 1:
        parts += [Text(""), _regions(regions)]
    return Group(*parts, *plan_lines(_part(summary, "plan")))


def render_summary(summary: Summary) -> RenderableType:
    """Any summary as a list of its entries, warnings first; nested objects under dotted names."""
    grid = _grid()
    for key, value in _flat({k: v for k, v in summary.items() if k != "warnings"}):
        grid.add_row(shown_text(key), shown_text(value))
    parts: list[RenderableType] = [*_warnings(summary), Text("")] if "warnings" in summary else []
    return Group(*parts, grid)


def _flat(value: object, prefix: str = "") -> Iterator[tuple[str, object]]:
    """Entries of nested objects with dotted names; lists of plain values in one line, of objects numbered from 1."""
    if isinstance(value, Mapping):
        for key, below in value.items():
            yield from _flat(below, f"{prefix}.{key}" if prefix else str(key))
    elif isinstance(value, list | tuple) and any(isinstance(v, Mapping) for v in value):
        for i, below in enumerate(value, start=1):
            yield from _flat(below, f"{prefix} {i}")
    elif isinstance(value, list | tuple):
        yield prefix, ", ".join(map(str, value)) or "none"
    elif isinstance(value, bool):
        yield prefix, "yes" if value else "no"
    else:
        yield prefix, "-" if value is None else value
