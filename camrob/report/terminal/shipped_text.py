"""What `camrob cell` and `camrob samples` show in a terminal."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from camrob.report.words import shown_number, shown_text
from camrob.summaries.shipped_summary import (
    CellCheckSummary,
    CellListSummary,
    ConditionSummary,
    ListedCell,
    NewCellSummary,
    SamplesSummary,
)

__all__ = ["render_cell_check", "render_cells", "render_condition", "render_new_cell", "render_samples"]

_INDENT = (0, 0, 0, 2)  # above, right, below, left


def _path(path: str) -> Text:
    """A path on a line of its own, however long: one that is broken can't be copied from there."""
    line = shown_text(" " * _INDENT[3] + path)
    line.no_wrap, line.overflow = True, "ignore"
    return line


def render_cells(summary: CellListSummary) -> RenderableType:
    """A cell a paragraph: name, what it is, its axes, what it can't do, its folder."""
    parts: list[RenderableType] = []
    for cell in summary.cells:
        parts += [
            Text(cell.name, style="bold"),
            Padding(shown_text(cell.title), _INDENT, expand=False),
            Padding(shown_text(f"axes {', '.join(cell.axes)}{_lacks(cell)}"), _INDENT, expand=False),
            _path(cell.folder),
        ]
    return Group(*parts, Text("--cell NAME takes one as it is; camrob cell new copies it"))


def _lacks(cell: ListedCell) -> str:
    missing = [name for name, there in (("[controller]", cell.controller), ("[resolve]", cell.resolve)) if not there]
    return f"; without {' and '.join(missing)}, which post needs" if missing else ""


def render_cell_check(summary: CellCheckSummary) -> RenderableType:
    """Whether the cell meets its poses, a line a pose, and where its numbers come from."""
    count, missed = len(summary.poses), sum(not pose.ok for pose in summary.poses)
    verdict = (
        "no poses.csv: nothing holds its chain against the machine; write two or three postures read off a pendant"
        if summary.ok is None
        else f"{missed} of {count} poses missed"
        if missed
        else f"all {count} poses met"
    )
    bounds = f"{summary.position_bound_mm:g} mm and {summary.orientation_bound_deg:g} degrees"
    parts: list[RenderableType] = [Text(f"{summary.cell}: {verdict}", style="bold")]
    for pose in summary.poses:
        errors = f"{shown_number(pose.position_error_mm, 4)} mm, {shown_number(pose.orientation_error_deg, 4)} degrees"
        wrong = f": {pose.text}" if pose.text else ""
        parts.append(Padding(shown_text(f"{pose.name} (line {pose.line}) {errors}{wrong}"), _INDENT, expand=False))
    if summary.poses:
        parts.append(Text(f"allowed are {bounds}"))
    parts += [shown_text(text) for text in (*summary.bare, *summary.home, summary.length, summary.coupled) if text]
    stated = ", ".join(f"{number} {kind}" for kind, number in summary.provenance.items())
    return Group(*parts, Text(f"entries of cell.toml: {stated}"))


def render_condition(summary: ConditionSummary) -> RenderableType:
    """The length, the condition number, and the posture."""
    best = f"k_F {shown_number(summary.kf, 4)} (1/k_F {shown_number(summary.inv_kf, 4)}) at best"
    posture = ", ".join(f"{axis} {shown_number(value)}" for axis, value in summary.posture.items())
    return Group(
        Text(f"{summary.cell}: {best}", style="bold"),
        Text(
            f"characteristic length {shown_number(summary.characteristic_length_mm)} mm; "
            f"cell.toml has {shown_number(summary.stated_mm)} mm"
        ),
        Text(f"posture {posture}; HOME has 1/k_F {shown_number(summary.home_inv_kf, 3)}"),
    )


def render_new_cell(summary: NewCellSummary) -> RenderableType:
    """The folder, its files, and what to do next."""
    return Group(
        Text(f"{summary.name}: axes {', '.join(summary.axes)}", style="bold"),
        shown_text(f"written to {summary.folder}: {', '.join(summary.files)}"),
        *(Padding(shown_text(sentence), _INDENT, expand=False) for sentence in summary.next),
    )


def render_samples(summary: SamplesSummary) -> RenderableType:
    """A sample a paragraph, and how one posts it."""
    parts: list[RenderableType] = []
    for sample in summary.samples:
        parts += [
            Text(sample.name, style="bold"),
            Padding(shown_text(sample.title), _INDENT, expand=False),
            _path(f"{sample.folder}/{sample.clfile}"),
        ]
    then = "camrob post CLFILE --cell kr15_track_table --out DIR posts one"
    return Group(*parts, Text(then if summary.copied else f"{then}; --out DIR copies them"))
