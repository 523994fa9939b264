"""Summaries in the terminal, in the words of the shop: what needs attention first, then what was made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.post.feed_sentences import feed_rows
from camrob.report.post.plan_text import plan_lines
from camrob.report.terminal.tables import columns, labelled
from camrob.report.words import shown_duration, shown_number, shown_text
from camrob.summaries.base import Summary
from camrob.summaries.post_summary import CollisionFigures, PostSummary, RegionFigures
from camrob.summaries.remarks import Remark

__all__ = ["render_post", "render_summary"]

_MOST_WARNINGS = 20  # a screen's height; the report has all
_MOST_REGIONS = 12  # half a screen's height; the report has all
_NEAREST = 3  # axes shown with their margin
_SOLVED_MM = 1e-4  # off a point, below which nobody wants to know by how much


def _warnings(warnings: Sequence[Remark]) -> Iterator[RenderableType]:
    """The warnings, with their lines of the CL file."""
    if not warnings:
        yield Text("No warnings.", style="green")
        return
    yield Text(f"{len(warnings)} warning{'s' if len(warnings) > 1 else ''} to read first", style="bold yellow")
    grid = Table.grid(padding=(0, 2))
    grid.add_column(justify="right", no_wrap=True, style="yellow")
    grid.add_column()
    for warning in warnings[:_MOST_WARNINGS]:
        grid.add_row(f"line {warning.line}" if warning.line else "", shown_text(warning.text))
    yield grid
    if len(warnings) > _MOST_WARNINGS:
        yield Text(f"... and {len(warnings) - _MOST_WARNINGS} more, in the report and NAME.json", style="yellow")


def _limits(summary: PostSummary) -> Text:
    """The axes that come nearest to their limits."""
    margins = {k: v for k, v in summary.limits.margin_min.items() if v is not None}
    # degrees and millimetres don't compare: the linear axes, as the external travels name them, are told apart
    linear = {key.removesuffix("_mm") for key in summary.external_travel if key.endswith("_mm")}
    turning = sorted((v, k) for k, v in margins.items() if k not in linear)[:_NEAREST]
    near = [f"{k} {shown_number(v)} deg" for v, k in turning]
    near += [f"{k} {shown_number(v)} mm" for k, v in margins.items() if k in linear]
    text = Text(f"least margin to a limit: {', '.join(near) or '-'}")
    if summary.limits.violations:
        text.append(f"; {summary.limits.violations} points past a limit", style="bold red")
    return text


def _collisions(found: CollisionFigures) -> Text:
    """Collisions and the least clearance."""
    if not found.checked:
        return Text("not checked", style="yellow")
    clearance = found.clearance_min_mm
    beside = "" if clearance is None else f"; least clearance {shown_number(clearance)} mm"
    return Text(f"{found.count} found{beside}", style="bold red") if found.count else Text(f"none{beside}")


def _conditioning(summary: PostSummary) -> Text:
    """1/k_F in words, and singular points."""
    part = summary.conditioning
    text = Text(
        f"1/k_F lowest {shown_number(part.inv_kf_min, 3)}, mean {shown_number(part.inv_kf_mean, 3)}"
        " (0 is singular, 1 ideal)"
    )
    if summary.singular:
        text.append(f"; {summary.singular} singular points", style="bold red")
    return text


def _regions(regions: Sequence[RegionFigures]) -> RenderableType:
    """One row a region."""
    table = columns("region", "CL lines", "points", "1/k_F at its start", left=("region",))
    for region in regions[:_MOST_REGIONS]:
        before, after = shown_number(region.inv_kf_before, 3), shown_number(region.inv_kf_after, 3)
        table.add_row(
            shown_text(region.name or region.index),
            f"{region.first_line} to {region.last_line}",
            shown_number(region.points, 0),
            f"{before} to {after} by revision" if region.revised else before,
        )
    if len(regions) > _MOST_REGIONS:
        table.add_row(f"... and {len(regions) - _MOST_REGIONS} more", "", "", "")
    return table


def render_post(summary: PostSummary) -> RenderableType:
    """The summary of `camrob post` for a terminal."""
    source, regions, time, verified = summary.source, summary.regions, summary.time_s, summary.verified
    grid = labelled()
    grid.add_row("Program", shown_text(f"{summary.program} for {summary.cell}, method {summary.method}"))
    grid.add_row("From", shown_text(f"{source.file} ({source.dialect}, {source.units})"))
    grid.add_row(
        "Points", f"{shown_number(summary.points, 0)} in {len(regions)} region{'s' if len(regions) != 1 else ''}"
    )
    beside = "" if time.optimal is None else f"; {shown_duration(time.optimal)} at the fastest safe feed"
    grid.add_row("Time", f"{shown_duration(time.program)} as programmed{beside}")
    for label, text in feed_rows(summary.feed, summary.torques):
        grid.add_row(label, shown_text(text))
    grid.add_row("Conditioning", _conditioning(summary))
    grid.add_row("Axes", _limits(summary))
    grid.add_row("Collisions", _collisions(summary.collisions))
    travel = ((shown_number(value), *key.partition("_")) for key, value in summary.external_travel.items())
    moved = ", ".join(f"{axis} {value} {unit}" for value, axis, _, unit in travel) or "-"
    grid.add_row("External axes", f"travel {moved}")
    left = summary.tracking.position_error_mm_max
    off = f"at most {shown_number(left, 4)}" if left >= _SOLVED_MM else f"less than {_SOLVED_MM:.4f}"
    grid.add_row("Solved", f"{off} mm off the path, before rounding")
    error = shown_number(verified.position_error_mm_max, 4)
    grid.add_row(
        "Verified" if summary.witness.complete else "Verified in part",
        shown_text(f"{verified.points} points read back and replayed; at most {error} mm off ({verified.by})"),
    )
    for side in summary.clampings:
        grid.add_row(
            f"Clamping {side.name}", shown_text(f"{side.program}, lines {side.first_line} to {side.last_line}")
        )
    files = summary.files
    if files:
        shown = files if len(files) <= 8 else [*files[:4], f"... {len(files) - 7} more ...", *files[-3:]]
        grid.add_row("Written", shown_text(", ".join(shown)))
    parts: list[RenderableType] = [*_warnings(summary.warnings), Text(""), grid]
    if len(regions) > 1:
        parts += [Text(""), _regions(regions)]
    return Group(*parts, *plan_lines(summary.plan))


def render_summary(summary: Summary) -> RenderableType:
    """Any summary as a list of its entries, warnings first; nested objects under dotted names."""
    grid = labelled()
    said = summary.to_json()
    for key, value in _flat({k: v for k, v in said.items() if k != "warnings"}):
        grid.add_row(shown_text(key), shown_text(value))
    warnings = said.get("warnings")
    parts: list[RenderableType] = []
    if warnings is not None:
        parts = [*_warnings([Remark.from_json(w) for w in warnings]), Text("")]
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
