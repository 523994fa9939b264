"""Verbs about what comes with camrob: its cells, cells made after them, and samples."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from camrob.cli.console import perform, renderer
from camrob.cli.options import CellArgument, JsonOption, QuietOption, cells_to_complete, known_cell
from camrob.progress import Progress

__all__ = ["cell_app", "check", "condition", "from_urdf", "list_cells", "new", "samples"]

_render_list = renderer("terminal.shipped_text", "render_cells")
_render_new = renderer("terminal.shipped_text", "render_new_cell")
_render_condition = renderer("terminal.shipped_text", "render_condition")
_render_check = renderer("terminal.shipped_text", "render_cell_check")
_render_samples = renderer("terminal.shipped_text", "render_samples")

_OutOption = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="Where the cell's folder is made. Default: here.")
]


def list_cells(as_json: JsonOption = False, quiet: QuietOption = False) -> int:
    """List the cells that come with camrob."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.files.cells_and_samples import list_cells

        return list_cells()

    return perform(job, as_json=as_json, quiet=quiet, render=_render_list)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The new cell's name, and its folder's.")],
    source: Annotated[
        Path,
        typer.Option(
            "--from",
            metavar="CELL",
            callback=known_cell,
            autocompletion=cells_to_complete,
            help="The cell that is most like it.",
        ),
    ],
    out: _OutOption = Path(),
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Make a cell's folder: a copy of another cell, under a new name."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.files.cells_and_samples import new_cell

        return new_cell(name, source=source, out=out)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_new)


def from_urdf(
    urdf: Annotated[Path, typer.Argument(metavar="FILE", help="A URDF; it is copied into the folder.")],
    name: Annotated[str | None, typer.Option("--name", help="The cell's name. Default: after the file.")] = None,
    tip: Annotated[
        str | None, typer.Option("--tip", metavar="LINK", help="Where the chain ends. Default: the only end there is.")
    ] = None,
    post: Annotated[
        bool, typer.Option("--post", help="Add what programs need beside the chain, at assumed values to be replaced.")
    ] = False,
    out: _OutOption = Path(),
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Make a cell's folder out of a URDF, for calibrate and diagnose, or for programs too."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.files.cells_and_samples import cell_from_urdf

        return cell_from_urdf(urdf, name=name, tip=tip, post=post, out=out)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_new)


def condition(
    cell: CellArgument,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Find the arm's characteristic length and its best-conditioned posture."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.solving.cell_condition import cell_condition

        return cell_condition(cell)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_condition)


def check(
    cell: CellArgument,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Hold a cell against the poses of its poses.csv, and count where its numbers come from."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.files.cell_check import cell_check

        return cell_check(cell)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_check, holds=lambda r: bool(r.summary.ok))


def samples(
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Copy them into this folder.")] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """List the samples that come with camrob, or copy them, ready to be posted."""

    def job(progress: Progress) -> Any:
        from camrob.jobs.files.cells_and_samples import samples

        return samples(out=out)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_samples)


def cell_app() -> typer.Typer:
    """`camrob cell`, a group of five."""
    group = typer.Typer(help="Cells that come with camrob, and new ones.", rich_markup_mode=None)
    group.command("list")(list_cells)
    group.command("new")(new)
    group.command("from-urdf")(from_urdf)
    group.command("condition")(condition)
    group.command("check")(check)
    return group
