"""`camrob study`: the papers' own cases, each repeated on the cell that it was made with, its figures beside ours."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from camrob.cli.console import job_of, perform, renderer
from camrob.cli.options import JsonOption, QuietOption, cells_to_complete, known_cell
from camrob.errors import InputError
from camrob.progress import Progress

__all__ = ["STUDIES", "Study", "has_become", "study"]


class Study(NamedTuple):
    """One paper's case: the cell that comes with camrob for it, what is repeated, what runs it, and what shows it."""

    cell: str
    repeats: str
    run: Callable[[Path, Path, Progress], Any]
    render: Callable[[Any], Any]


def _calibration(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("published_case")(cell=cell, out=out / "calibration.toml", progress=progress)


def _line(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("studies.line")(cell=cell, out=out, progress=progress)


def _weld(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("studies.weld")(cell=cell, out=out, progress=progress)


def _tracker(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("tracker")(cell=cell, out=out, progress=progress)


_feed = renderer("feed.terminal_text", "render_feed")
STUDIES = {
    "calibration": Study(
        "kr500_afp",
        "calibration of a fibre placement cell, compensation of its postures",
        _calibration,
        renderer("calibration.terminal_text", "render_calibration"),
    ),
    "line": Study("kr500_afp", "the axes' speed, acceleration and jerk on a line, compensated", _line, _feed),
    "weld": Study("ta1400_weld", "optimal feed and joint torques on a weld seam", _weld, _feed),
    "tracker": Study(
        "rx160_tracker",
        "path accuracy with a laser tracker in the loop",
        _tracker,
        renderer("loop.terminal_text", "render_tracker"),
    ),
}


def _listed() -> str:
    """The studies, one a line; a backspace keeps the lines as they are."""
    return "\b\n" + "\n".join(f"{name:12} {s.repeats} ({s.cell})" for name, s in STUDIES.items())


def _to_complete(incomplete: str) -> list[str]:
    """Names of studies that begin so, for the shell."""
    return [name for name in STUDIES if name.startswith(incomplete)]


def study(
    name: Annotated[
        str, typer.Argument(metavar="NAME", autocompletion=_to_complete, help=f"Which: {', '.join(STUDIES)}.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives report and figures.")],
    cell: Annotated[
        Path | None,
        typer.Option(
            "--cell",
            metavar="CELL",
            callback=known_cell,
            autocompletion=cells_to_complete,
            help="Another cell. Default: the paper's own.",
        ),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Repeat a paper's own case, its figures beside ours."""

    def job(progress: Progress) -> Any:
        if name not in STUDIES:
            raise InputError(f"no study {name[:60]!r} comes with camrob", hint=f"take one of {', '.join(STUDIES)}")
        from camrob.shipped import shipped_cell

        machine = shipped_cell(STUDIES[name].cell) if cell is None else cell
        return STUDIES[name].run(machine, out, progress)

    render = STUDIES[name].render if name in STUDIES else _feed
    return perform(job, as_json=as_json, quiet=quiet, render=render)


study.__doc__ = f"{study.__doc__}\n\n{_listed()}"


def has_become(status: int, quiet: bool, *names: str) -> int:
    """Say on standard error that what was done under other words is `camrob study NAME` for one of names; gives the status on."""
    if status == 0 and not quiet:
        now = " or ".join(f"`camrob study {name}`" for name in names)
        typer.echo(f"camrob: this is {now} now; the old command works for one more version", err=True)
    return status
