"""The command line: thin verbs that parse, hand over to a job, and print what it returns.

A job, `camrob/jobs/<verb>.py`, is imported when its verb runs, so that the command line itself starts at once.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from camrob.cli.console import error_line, exit_status, job_of, perform, renderer
from camrob.cli.options import (
    CellOption,
    Device,
    Feed,
    ForceOption,
    JsonOption,
    Method,
    ProveOption,
    QuietOption,
    SecondsOption,
    SetupOption,
    ThenCompensatedOption,
    Units,
)
from camrob.cli.real import calibrate, close_loop, compensate, diagnose, predict, simulate, tracker
from camrob.cli.slips import plainly, slip_of
from camrob.cli.start import cell_app, samples
from camrob.cli.study import has_become, study
from camrob.cli.tuning import tune_engines
from camrob.errors import CamrobError
from camrob.progress import Progress

__all__ = [
    "batch",
    "build_app",
    "calibrate",
    "close_loop",
    "compensate",
    "diagnose",
    "feed",
    "main",
    "place",
    "post",
    "predict",
    "regress",
    "run",
    "samples",
    "simulate",
    "tracker",
    "tune_engines",
    "verify",
    "version",
]

# new objects before Python looks for rings among them: by its own 700 it looks 350 times in a small post, and finds nothing
_COLLECTED = (200_000, 10, 10)
# matrices here have some hundred rows: see `camrob.gap.diagnose`
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


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
    device: Annotated[Device, typer.Option("--device", help="Where planned postures are scored.")] = Device.CPU,
    for_accuracy: Annotated[
        bool, typer.Option("--for-accuracy", help="Plan postures that make the part's expected error small.")
    ] = False,
    then_compensated: ThenCompensatedOption = False,
    calibration: Annotated[
        Path | None,
        typer.Option("--calibration", metavar="FITTED.toml", help="The machine's constants, for --for-accuracy."),
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option("--diagnosis", metavar="DIR", help="The diagnosis that wrote FITTED.toml: play, friction, doubt."),
    ] = None,
    force: ForceOption = None,
    seconds: SecondsOption = None,
    prove: ProveOption = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Leave NAME.html out.")] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Turn a CL file into a verified robot program."""

    def job(progress: Progress) -> Any:
        return job_of("post")(
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
            device=device.value,
            for_accuracy=for_accuracy,
            then_compensated=then_compensated,
            calibration=calibration,
            diagnosis=diagnosis,
            force=force,
            seconds=seconds,
            prove=prove,
            report=not no_report,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_post)


def verify(
    program: Annotated[
        Path, typer.Argument(metavar="PROGRAM", help="A robot program in KRL (.src) or RAPID (.mod), of any post.")
    ],
    cell: CellOption,
    against: Annotated[
        Path | None, typer.Option("--against", metavar="CLFILE", help="The CL file that the program should follow.")
    ] = None,
    setup: SetupOption = None,
    begin: Annotated[
        int,
        typer.Option("--begin", metavar="LINE", help="The CL line from which on: of a program for the rest of a job."),
    ] = 0,
    clamping: Annotated[
        str | None,
        typer.Option("--clamping", metavar="NAME", help="The set-up's [[clamping]] that the program is for."),
    ] = None,
    no_collisions: Annotated[bool, typer.Option("--no-collisions", help="Leave collisions out.")] = False,
    no_manifest: Annotated[
        bool,
        typer.Option("--no-manifest", help="Take the files as they are, whatever the NAME.json beside them names."),
    ] = False,
    allow_unjudged: Annotated[
        bool, typer.Option("--allow-unjudged", help="Status 0 although something could not be judged.")
    ] = False,
    original: Annotated[
        Path | None,
        typer.Option("--original", metavar="PROGRAM", help="Of a compensated program, the one that it was made of."),
    ] = None,
    calibration: Annotated[
        Path | None, typer.Option("--calibration", metavar="CALIBRATION.toml", help="What it was corrected for.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="The folder that receives verify.json and verify.html.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Judge a robot program: what it does, and whether that is what the CL file asks for."""

    def job(progress: Progress) -> Any:
        return job_of("verify")(
            program,
            cell=cell,
            against=against,
            setup=setup,
            begin=begin,
            clamping=clamping,
            collisions=not no_collisions,
            manifest=not no_manifest,
            original=original,
            calibration=calibration,
            out=out,
            progress=progress,
        )

    def holds(result: Any) -> bool:
        return bool(result.ok) or (allow_unjudged and result.ok is None)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_verify, holds=holds)


def regress(
    toolpaths: Annotated[Path, typer.Argument(metavar="TOOLPATHS", help="The folder of samples.")],
    cell: CellOption,
    update: Annotated[bool, typer.Option("--update", help="Make what comes out now the golden files.")] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Post every sample and compare programs and summaries with the golden files."""

    def job(progress: Progress) -> Any:
        return job_of("regress")(toolpaths, cell=cell, update=update, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_regress, holds=lambda result: bool(result.ok))


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

    def job(progress: Progress) -> Any:
        return job_of("place")(clfile, cell=cell, out=out, setup=setup, x_mm=x, y_mm=y, z_mm=z, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_place)


def feed(
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the report.")],
    solution: Annotated[
        Path | None,
        typer.Option("--solution", metavar="FILE", help="A solved path or a program, to analyse its derivatives."),
    ] = None,
    compensated: Annotated[
        Path | None, typer.Option("--compensated", metavar="FILE", help="Compensated coordinates beside it.")
    ] = None,
    calibration: Annotated[
        Path | None, typer.Option("--calibration", metavar="CALIBRATION.toml", help="Or compensate with this.")
    ] = None,
    axis: Annotated[str | None, typer.Option("--axis", help="The axis that is drawn, or all. Default: A1.")] = None,
    rate: Annotated[float, typer.Option("--rate", help="Rate along the axes' displacement, rad/s.")] = 1.0,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Speed, acceleration and jerk of the machine's coordinates along a program or a solved path."""

    def job(progress: Progress) -> Any:
        return job_of("feed")(
            solution,
            cell=cell,
            out=out,
            compensated=compensated,
            calibration=calibration,
            axis=axis,
            rate=rate,
            progress=progress,
        )

    status = perform(job, as_json=as_json, quiet=quiet, render=_render_feed)
    own = solution is None and calibration is None
    return has_become(status, quiet, "weld", "line") if own else status


def batch(
    jobs: Annotated[Path, typer.Argument(metavar="JOBS.toml", help="The jobs: [defaults], and a [[job]] for each.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="What `out` is relative to. Default: JOBS.toml's folder."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            "--report", metavar="DIR", help="The folder for a page of all jobs that leads to their own reports."
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, metavar="N", help="Processes. Default: one per core.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Use this Dask cluster: tcp://host:port.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Run many jobs side by side; the exit status is that of the worst one."""

    def job(progress: Progress) -> Any:
        return job_of("batch")(jobs, out=out, report=report, workers=workers, scheduler=scheduler, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_batch, status=lambda result: int(result.status))


VERBS: tuple[Callable[..., int], ...] = (
    post,
    place,
    verify,
    simulate,
    regress,
    calibrate,
    compensate,
    predict,
    feed,
    diagnose,
    close_loop,
    tracker,
    tune_engines,
    batch,
)


_render_post = renderer("terminal.summaries", "render_post")
_render_verify = renderer("terminal.verify_text", "render_verify")
_render_regress = renderer("terminal.regress_text", "render_regress")
_render_feed = renderer("feed.terminal_text", "render_feed")
_render_batch = renderer("terminal.batch_text", "render_batch")
_render_place = renderer("place.terminal_text", "render_place")


def version(asked: bool) -> None:
    """Print camrob's version and end, where that was asked."""
    if asked:
        from importlib.metadata import version as version_of

        typer.echo(f"camrob {version_of('camrob')}")
        raise typer.Exit


def build_app() -> typer.Typer:
    """The application with all its verbs."""
    app = typer.Typer(
        name="camrob",
        help="CAM toolpaths into verified programs for redundant robot machining cells.",
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        no_args_is_help=False,
    )

    @app.callback()
    def camrob(
        show_version: Annotated[
            bool, typer.Option("--version", callback=version, is_eager=True, help="Print the version and end.")
        ] = False,
    ) -> None:
        """CAM toolpaths into verified programs for redundant robot machining cells."""

    verbs: tuple[Callable[..., int], ...] = (*VERBS, study, samples)
    for verb in verbs:
        said = (verb.__doc__ or "").partition("\n")[0]  # whole: the list of commands cuts it off otherwise
        app.command(verb.__name__.replace("_", "-"), short_help=said)(verb)
    app.add_typer(cell_app(), name="cell")
    return app


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command line (by default the process's own) and give its exit status. Never raises."""
    command = typer.main.get_command(build_app())
    # whichever library typer is built on, the errors of the command line share a root that can word itself
    usage_error = next(c for c in reversed(typer.BadParameter.__mro__) if hasattr(c, "format_message"))
    slip = slip_of(sys.argv[1:] if arguments is None else arguments, command)
    if slip:
        typer.echo(slip, err=True)
        return 2
    try:
        status = command.main(args=arguments, prog_name="camrob", standalone_mode=False)
    except usage_error as error:  # type: ignore[misc]
        context = getattr(error, "ctx", None)
        where = context.command_path if context is not None else "camrob"
        what = plainly(error.format_message())  # type: ignore[attr-defined]
        typer.echo(f"{where}: {what}; see '{where} --help'", err=True)
        return 2
    except CamrobError as error:  # an option's value, before there is a job
        typer.echo(f"camrob: {error_line(error)}", err=True)
        return exit_status(error)
    except typer.Abort:
        typer.echo(f"camrob: {error_line(KeyboardInterrupt())}", err=True)
        return 130
    return status if isinstance(status, int) else 0


def main() -> NoReturn:
    """Entry point of the console script."""
    gc.set_threshold(*_COLLECTED)
    for library in _ONE_THREAD:
        os.environ.setdefault(library, "1")
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started this
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    sys.exit(run())
