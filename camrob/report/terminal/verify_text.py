"""The summary of `camrob verify` for a terminal: the verdict, what was found against the program, what was not judged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from camrob.report.terminal.tables import labelled
from camrob.report.verify.grouped import grouped
from camrob.report.words import shown_blocks, shown_number, shown_text
from camrob.summaries.remarks import JudgedRemark
from camrob.summaries.verify_summary import VerifySummary

__all__ = ["render_verify"]

_MOST = 20  # findings of a kind that are shown


def render_verify(summary: VerifySummary) -> RenderableType:
    """What was found against the program first, then what could not be judged, warnings and figures."""
    parts: list[RenderableType] = [_verdict(summary)]
    kinds = (("against it", grouped(summary.errors), "red"), ("to read", summary.warnings, "yellow"))
    for title, remarks, style in kinds:
        rows = [row for row in remarks if row.code != "not-judged"]  # listed below
        if rows:
            parts += [Text(""), Text(title.capitalize(), style=f"bold {style}"), *_rows(rows, style)]
    open_ends = summary.not_judged
    if open_ends:
        parts += [Text(""), Text("Not judged", style="bold yellow")]
        parts += [Padding(shown_text(text), (0, 0, 0, 2)) for text in open_ends[:_MOST]]
        if len(open_ends) > _MOST:
            parts.append(Text(f"  ... and {len(open_ends) - _MOST} more (--json shows all)"))
    return Group(*parts, Text(""), _figures(summary))


def _verdict(summary: VerifySummary) -> Text:
    """One line: good, bad, or open."""
    name, ok, count = summary.program, summary.ok, len(grouped(summary.errors))
    if ok:
        return Text(f"{name}: nothing was found against it", style="bold green")
    if ok is None:
        return Text(f"{name}: nothing was found against it, but not all of it could be judged", style="bold yellow")
    return Text(f"{name}: {count} thing{'s' if count != 1 else ''} against it", style="bold red")


def _rows(rows: Sequence[JudgedRemark], style: str) -> Iterator[RenderableType]:
    grid = Table(box=None, padding=(0, 2, 0, 0), header_style=style)
    with_file, with_cl = any(row.file for row in rows[:_MOST]), any(row.cl_line for row in rows[:_MOST])
    for heading in ("program line", *(["of"] if with_file else []), *(["CL line"] if with_cl else [])):
        grid.add_column(heading, justify="left" if heading == "of" else "right", no_wrap=True, style=style)
    grid.add_column("what")
    for row in rows[:_MOST]:
        times = f" ({row.count} times)" if row.count > 1 else ""
        lines: list[RenderableType] = [
            str(row.line or "-"),
            *([shown_text(row.file)] if with_file else []),
            *([str(row.cl_line or "-")] if with_cl else []),
        ]
        grid.add_row(*lines, shown_text(f"{row.text}{_by(row)}{times}"))
    yield grid
    if len(rows) > _MOST:
        yield Text(f"... and {len(rows) - _MOST} more (--json shows all)", style=style)


def _by(row: JudgedRemark) -> str:
    """How far a value is off, where the finding has one."""
    if row.value is None:
        return ""
    value, allowed = shown_number(row.value, 4), "" if row.limit is None else f", allowed {shown_number(row.limit, 4)}"
    return f": {value} {row.unit}{allowed}" if f"{value} {row.unit}" not in row.text else allowed


def _figures(summary: VerifySummary) -> RenderableType:
    grid = labelled()
    judged, against, replay = summary.judged, summary.against, summary.replay
    words = {True: "good", False: "bad", None: "not judged"}
    areas = {
        "path": judged.path,
        "frames": judged.frames,
        "process": judged.process,
        "collisions": judged.collisions,
        "limits": judged.limits,
    }
    grid.add_row("Judged", ", ".join(f"{area} {words[good]}" for area, good in areas.items()))
    if against is not None:
        off = f", at most {shown_number(against.position_error_mm_max, 4)} mm off" if against.met else ""
        grid.add_row("Against", shown_text(f"{against.file}: {against.met} of {against.points} points met{off}"))
    if (made := summary.corrected) is not None:
        what = f"{made.original}, all else alike: targets moved by {shown_number(made.moved_mm_max, 3)} mm at most, the robot of "
        what += f"{made.calibration} at most {shown_number(made.position_error_mm_max, 4)} mm off what was meant"
        grid.add_row("Corrected", shown_text(what))
    if replay is not None:
        files = ", ".join(summary.files)
        grid.add_row("Program", shown_text(f"{shown_number(summary.motions, 0)} motions in {files}"))
        if replay.blocks is not None and replay.blocks.short:
            grid.add_row("Too short", shown_text(shown_blocks(replay.blocks)))
        lowest = shown_number(replay.conditioning.inv_kf_min, 3)
        grid.add_row("Conditioning", f"1/k_F lowest {lowest}, moves through air included (0 is singular, 1 ideal)")
    return grid
