"""`camrob study`: the papers' own cases, each repeated on the cell that it was made with, its figures beside ours."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from camrob.cli.console import job_of, perform, renderer
from camrob.cli.options import JsonOption, QuietOption, known_cell
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
    own = {"cell": cell, "out": out / "calibration.toml", "progress": progress}
    return job_of("published_case")(_folder(cell) / "published.toml", **own)


def _line(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("feed")(None, cell=cell, out=out, axis="all", progress=progress)


def _weld(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("feed")(None, cell=cell, out=out, progress=progress)


def _tracker(cell: Path, out: Path, progress: Progress) -> Any:
    return job_of("tracker")(cell=cell, out=out, progress=progress)


def _folder(cell: Path) -> Path:
    """A cell may be named by its cell.toml."""
    return cell.parent if cell.is_file() else cell


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


def _known(asked: Path | None) -> Path | None:
    return None if asked is None else known_cell(asked)


def study(
    name: Annotated[str, typer.Argument(metavar="NAME", help=f"Which: {', '.join(STUDIES)}.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives report and figures.")],
    cell: Annotated[
        Path | None,
        typer.Option("--cell", metavar="CELL", callback=_known, help="Another cell. Default: the paper's own."),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Repeat a paper's own case, its figures beside ours."""

    def job(progress: Progress) -> Any:
        if name not in STUDIES:
            raise InputError(f"no study {name[:60]!r} comes with camrob", hint=f"take one of {', '.join(STUDIES)}")
        from camrob.shipped import shipped_cell

        return STUDIES[name].run(cell if cell is not None else shipped_cell(STUDIES[name].cell), out, progress)

    render = STUDIES[name].render if name in STUDIES else _feed
    return perform(job, as_json=as_json, quiet=quiet, render=render)


study.__doc__ = f"{study.__doc__}\n\n{_listed()}"


def has_become(name: str, status: int, quiet: bool) -> int:
    """Say on standard error that what was done under other words is `camrob study NAME`; gives the status on."""
    if status == 0 and not quiet:
        typer.echo(f"camrob: this is `camrob study {name}` now; the old words work for one version", err=True)
    return status
