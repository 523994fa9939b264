"""The command line: thin verbs that parse, hand over to a job, and print what it returns.

A verb is offered where its job, `camrob/jobs/<verb>.py`, is there; a job is imported when its verb runs, so that the
command line itself starts at once.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from camrob.console import ProgressHook, error_line, perform
from camrob.options import CellOption, Feed, JsonOption, Method, QuietOption, SetupOption, Units

__all__ = [
    "batch",
    "build_app",
    "calibrate",
    "compensate",
    "diagnose",
    "feed",
    "main",
    "place",
    "post",
    "regress",
    "run",
    "simulate",
    "verify",
    "version",
]


def post(
    clfile: Annotated[Path, typer.Argument(metavar="CLFILE", help="CL data or 5-axis G-code.")],
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the program.")],
    setup: SetupOption = None,
    name: Annotated[str | None, typer.Option("--name", help="The program's name. Default: after the CL file.")] = None,
    method: Annotated[Method, typer.Option("--method", help="How the redundancy is resolved.")] = Method.VJM,
    feed: Annotated[Feed, typer.Option("--feed", help="The CL file's feed, or the fastest safe one.")] = Feed.PROGRAM,
    max_lines: Annotated[
        int | None, typer.Option("--max-lines", min=1, metavar="N", help="Motions a sub-program may hold.")
    ] = None,
    dialect: Annotated[str | None, typer.Option("--dialect", help="Read the CL file as this dialect.")] = None,
    units: Annotated[Units | None, typer.Option("--units", help="Units of the CL file, whatever it says.")] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Leave NAME.html out.")] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Turn a CL file into a verified KRL program."""

    def job(progress: ProgressHook) -> Any:
        return _job("post")(
            clfile,
            cell=cell,
            out=out,
            setup=setup,
            name=name,
            method=method.value,
            feed=feed.value,
            max_lines=max_lines,
            dialect=dialect,
            units=units.value if units else None,
            report=not no_report,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_post)


def verify(
    program: Annotated[Path, typer.Argument(metavar="PROGRAM.src", help="A KRL program, of any post.")],
    cell: CellOption,
    against: Annotated[
        Path | None, typer.Option("--against", metavar="CLFILE", help="The CL file that the program should follow.")
    ] = None,
    setup: SetupOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Read a KRL program back, replay it and check it."""

    def job(progress: ProgressHook) -> Any:
        return _job("verify")(program, cell=cell, against=against, setup=setup, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_plain, holds=lambda result: bool(result.ok))


def regress(
    toolpaths: Annotated[Path, typer.Argument(metavar="TOOLPATHS", help="The folder of samples.")],
    cell: CellOption,
    update: Annotated[bool, typer.Option("--update", help="Make what comes out now the golden files.")] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Post every sample and compare programs and summaries with the golden files."""

    def job(progress: ProgressHook) -> Any:
        return _job("regress")(toolpaths, cell=cell, update=update, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_regress, holds=lambda result: bool(result.ok))


def calibrate(
    measured: Annotated[Path, typer.Argument(metavar="MEASURED.csv", help="A log of axis values and measured poses.")],
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="CALIBRATION.toml", help="The file to write.")],
    withheld: Annotated[
        Path | None, typer.Option("--withheld", metavar="LOG.csv", help="A log that takes no part, to judge by.")
    ] = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", metavar="NAME", help="Fit these alone (may be repeated).")
    ] = None,
    harmonics: Annotated[
        int, typer.Option("--harmonics", min=0, max=12, metavar="N", help="Orders of gear ripple to fit.")
    ] = 0,
    share: Annotated[
        float, typer.Option("--share", metavar="X", help="The share of the poses that is withheld without --withheld.")
    ] = 0.2,
    poses: Annotated[
        int,
        typer.Option("--next", min=0, max=500, metavar="N", help="Choose N poses to measure next, as a KRL program."),
    ] = 0,
    path: Annotated[
        Path | None, typer.Option("--for", metavar="PROGRAM.src", help="The program that these poses are to serve.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Fit a cell's error parameters to measured poses."""

    def job(progress: ProgressHook) -> Any:
        return _job("calibrate")(
            measured,
            cell=cell,
            out=out,
            withheld=withheld,
            parameters=parameter or (),
            harmonics=harmonics,
            share=share,
            poses=poses,
            path=path,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_calibration)


def compensate(
    program: Annotated[Path, typer.Argument(metavar="PROGRAM.src", help="A KRL program.")],
    cell: CellOption,
    calibration: Annotated[
        Path, typer.Option("--calibration", metavar="CALIBRATION.toml", help="What `calibrate` wrote for the cell.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the program.")],
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Rewrite a program so that the calibrated robot meets its poses."""

    def job(progress: ProgressHook) -> Any:
        return _job("compensate")(program, cell=cell, calibration=calibration, out=out, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_compensation)


def place(
    clfile: Annotated[Path, typer.Argument(metavar="CLFILE", help="The CL file.")],
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the map and the numbers go.")],
    setup: Annotated[Path | None, typer.Option("--setup", metavar="SETUP.toml", help="The job's set-up.")] = None,
    x: Annotated[float, typer.Option("--x", metavar="MM", help="Freedom along X, to either side.")] = 200.0,
    y: Annotated[float, typer.Option("--y", metavar="MM", help="Freedom along Y, to either side.")] = 200.0,
    z: Annotated[float, typer.Option("--z", metavar="MM", help="Freedom along Z, upwards.")] = 0.0,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Propose where on the table the part is worked best."""

    def job(progress: ProgressHook) -> Any:
        return _job("place")(clfile, cell=cell, out=out, setup=setup, x_mm=x, y_mm=y, z_mm=z, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_plain)


def simulate(
    program: Annotated[Path, typer.Argument(metavar="PROGRAM.src", help="A KRL program, of any post.")],
    cell: CellOption,
    out: Annotated[
        Path, typer.Option("--out", metavar="LOG.csv", help="The log (.csv or .parquet); LOG.toml beside it.")
    ],
    cycle_ms: Annotated[
        float, typer.Option("--cycle-ms", metavar="MS", help="Milliseconds a row, such as 12 or 4.")
    ] = 12.0,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Run a KRL program on the ideal controller and write what it does as a log."""

    def job(progress: ProgressHook) -> Any:
        return _job("simulate")(program, cell=cell, out=out, cycle_ms=cycle_ms, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_plain)


def feed(
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the report.")],
    solution: Annotated[
        Path | None,
        typer.Option("--solution", metavar="NAME.path.npz", help="A solved path, to analyse its derivatives."),
    ] = None,
    compensated: Annotated[
        Path | None, typer.Option("--compensated", metavar="OTHER.path.npz", help="Compensated coordinates beside it.")
    ] = None,
    axis: Annotated[str | None, typer.Option("--axis", help="The axis that is drawn. Default: A1.")] = None,
    rate: Annotated[float, typer.Option("--rate", help="Rate along the axes' displacement, rad/s.")] = 1.0,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Feed, time and torque on a cell's weld seam, or the derivatives of a solved path."""

    def job(progress: ProgressHook) -> Any:
        return _job("feed")(
            solution, cell=cell, out=out, compensated=compensated, axis=axis, rate=rate, progress=progress
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_plain)


def diagnose(
    cell: CellOption,
    log: Annotated[
        list[Path], typer.Option("--log", metavar="LOG.csv", help="A measured run; may be given several times.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="The folder that receives diagnosis.json and .html.")
    ],
    withheld: Annotated[
        list[Path] | None,
        typer.Option("--withheld", metavar="LOG.csv", help="A run that takes no part in choosing or fitting."),
    ] = None,
    program: Annotated[
        Path | None,
        typer.Option("--program", metavar="PROGRAM.src", help="What was run. Default: what each LOG.toml names."),
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option("--without", metavar="EFFECT", help="Leave an effect out of the library.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Say where the gap between simulation and measurement lies, what causes it, and how far it shrinks without that."""

    def job(progress: ProgressHook) -> Any:
        return _job("diagnose")(
            cell=cell,
            log=log,
            withheld=withheld or [],
            program=program,
            without=without or [],
            out=out,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_diagnosis)


def batch(
    jobs: Annotated[Path, typer.Argument(metavar="JOBS.toml", help="The jobs: [defaults], and a [[job]] for each.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="What `out` is relative to. Default: JOBS.toml's folder."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, metavar="N", help="Processes. Default: one a core.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Use this Dask cluster: tcp://host:port.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Do many jobs side by side; the worst one's status is the batch's."""

    def job(progress: ProgressHook) -> Any:
        return _job("batch")(jobs, out=out, workers=workers, scheduler=scheduler, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_batch, status=lambda result: int(result.status))


VERBS: tuple[Callable[..., int], ...] = (
    post,
    place,
    verify,
    simulate,
    regress,
    calibrate,
    compensate,
    feed,
    diagnose,
    batch,
)


def _job(name: str) -> Callable[..., Any]:
    """The job behind a verb: the function of the verb's name in `camrob/jobs/<verb>.py`."""
    return getattr(importlib.import_module(f"camrob.jobs.{name}"), name)  # type: ignore[no-any-return]


def _render(module: str, name: str) -> Callable[[Mapping[str, Any]], Any]:
    """What a verb shows a person; what draws it is imported when it is needed."""
    return lambda summary: getattr(importlib.import_module(f"camrob.report.{module}"), name)(summary)


_render_post = _render("terminal", "render_post")
_render_regress = _render("regress_text", "render_regress")
_render_diagnosis = _render("diagnosis_words", "render_diagnosis")
_render_batch = _render("batch_text", "render_batch")
_render_calibration = _render("calibration_text", "render_calibration")
_render_compensation = _render("calibration_text", "render_compensation")
_render_plain = _render("terminal", "render_summary")


def version(asked: bool) -> None:
    """Print camrob's version and end, where that was asked."""
    if asked:
        from importlib.metadata import version as version_of

        typer.echo(f"camrob {version_of('camrob')}")
        raise typer.Exit


def build_app() -> typer.Typer:
    """The application, with a verb for every job that is there."""
    app = typer.Typer(
        name="camrob",
        help="CAM toolpaths into verified programs for redundant robot machining cells.",
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=False,
        no_args_is_help=False,
    )

    @app.callback()
    def camrob(
        show_version: Annotated[
            bool, typer.Option("--version", callback=version, is_eager=True, help="Print the version and end.")
        ] = False,
    ) -> None:
        """CAM toolpaths into verified programs for redundant robot machining cells."""

    for verb in VERBS:
        if importlib.util.find_spec(f"camrob.jobs.{verb.__name__}") is not None:
            app.command(verb.__name__)(verb)
    return app


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command line (by default the process's own) and give its exit status. Never raises."""
    command = typer.main.get_command(build_app())
    # whichever library typer is built on, the errors of the command line share a root that can word itself
    usage_error = next(c for c in reversed(typer.BadParameter.__mro__) if hasattr(c, "format_message"))
    try:
        status = command.main(args=arguments, prog_name="camrob", standalone_mode=False)
    except usage_error as error:  # type: ignore[misc]
        context = getattr(error, "ctx", None)
        where = context.command_path if context is not None else "camrob"
        told = " ".join(error.format_message().split()).rstrip(".")  # type: ignore[attr-defined]
        typer.echo(f"{where}: {told}; see '{where} --help'", err=True)
        return 2
    except typer.Abort:
        typer.echo(f"camrob: {error_line(KeyboardInterrupt())}", err=True)
        return 130
    return status if isinstance(status, int) else 0


def main() -> NoReturn:
    """Entry point of the console script."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    sys.exit(run())


if __name__ == "__main__":
    main()
