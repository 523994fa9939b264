"""Verbs of the command line that deal with the real cell: simulate, calibrate, compensate, diagnose, tracker."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from camrob.cli.console import job_of, perform, renderer
from camrob.cli.options import (
    CellOption,
    CorrectedOption,
    CycleOption,
    DurationOption,
    EngagementOption,
    ForceOption,
    FrameOption,
    GainOption,
    InstrumentOption,
    JsonOption,
    LatencyOption,
    ListenOption,
    ModeOption,
    PairOption,
    QuietOption,
    RealtimeOption,
    SenTypeOption,
    TrackerCellOption,
)
from camrob.cli.study import has_become
from camrob.errors import InputError
from camrob.progress import Progress

__all__ = ["calibrate", "close_loop", "compensate", "diagnose", "predict", "simulate", "tracker"]

_WithheldOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--withheld",
        metavar="LOG.csv",
        help="A run that takes no part in choosing or fitting (may be repeated). Default: stretches of the logs in turn.",
    ),
]
_WithoutOption = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        metavar="EFFECT",
        help="Leave an effect out of the library, to see what is said without it (may be repeated).",
    ),
]
_LapsOption = Annotated[
    int | None, typer.Option("--laps", min=0, max=20, metavar="N", help="Laps the study learns from. Default: 3.")
]

_render_diagnosis = renderer("diagnosis.terminal_text", "render_diagnosis")
_render_calibration = renderer("calibration.terminal_text", "render_calibration")
_render_compensation = renderer("calibration.terminal_text", "render_compensation")
_render_tracker = renderer("loop.terminal_text", "render_tracker")
_render_ledger = renderer("closing.terminal_text", "render_ledger")
_render_prediction = renderer("predict.terminal_text", "render_prediction")
_render_plain = renderer("terminal.summaries", "render_summary")
_render_simulation = renderer("simulate.terminal_text", "render_simulation")


def simulate(
    program: Annotated[
        Path, typer.Argument(metavar="PROGRAM", help="A robot program in KRL (.src) or RAPID (.mod), of any post.")
    ],
    cell: CellOption,
    out: Annotated[
        Path, typer.Option("--out", metavar="LOG.csv", help="The log (.csv or .parquet); LOG.toml beside it.")
    ],
    cycle_ms: Annotated[
        float, typer.Option("--cycle-ms", metavar="MS", help="Milliseconds per row, such as 12 or 4.")
    ] = 12.0,
    report: Annotated[
        Path | None,
        typer.Option("--report", metavar="PAGE.html", help="A page: the run to look at, what holds it back."),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Run a robot program on the ideal controller and write what it does as a log."""

    def job(progress: Progress) -> Any:
        return job_of("simulate")(program, cell=cell, out=out, cycle_ms=cycle_ms, report=report, progress=progress)

    return perform(job, as_json=as_json, quiet=quiet, render=_render_simulation)


def calibrate(
    cell: CellOption,
    out: Annotated[
        Path, typer.Option("--out", metavar="CALIBRATION.toml", help="The file to write; a report .html beside it.")
    ],
    measured: Annotated[
        list[Path] | None, typer.Argument(metavar="MEASURED.csv...", help="Logs of axis values and measured poses.")
    ] = None,
    withheld: Annotated[
        list[Path] | None,
        typer.Option("--withheld", metavar="LOG.csv", help="A log that takes no part, to judge by (may be repeated)."),
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
        typer.Option("--next", min=0, max=500, metavar="N", help="Choose N poses to measure next, as a program."),
    ] = 0,
    path: Annotated[
        Path | None, typer.Option("--for", metavar="PROGRAM", help="The program that these poses are meant for.")
    ] = None,
    published: Annotated[
        Path | None,
        typer.Option("--published", metavar="CASE.toml", help="Repeat a published case on a simulated robot instead."),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Fit a cell's error parameters to measured poses."""

    def job(progress: Progress) -> Any:
        if published is not None:
            _alone(published, measured or withheld or parameter or harmonics or poses or path)
            return job_of("published_case")(published, cell=cell, out=out, progress=progress)
        if not measured:
            hint = "give MEASURED.csv, or --published CASE.toml"
            raise InputError("there is nothing to calibrate from", hint=hint)
        return job_of("calibrate")(
            measured[0],
            more=measured[1:],
            cell=cell,
            out=out,
            withheld=withheld or (),
            parameters=parameter or (),
            harmonics=harmonics,
            share=share,
            poses=poses,
            path=path,
            progress=progress,
        )

    status = perform(job, as_json=as_json, quiet=quiet, render=_render_calibration)
    return has_become(status, quiet, "calibration") if published is not None else status


def _alone(case: Path, others: object) -> None:
    """Raise InputError where a published case is asked for along with what it says itself."""
    if others:
        what = "says itself what is measured and fitted"
        raise InputError(what, hint="leave logs and other options out", path=case)


def compensate(
    program: Annotated[
        Path, typer.Argument(metavar="PROGRAM", help="A robot program, or a solved path, NAME.path.npz.")
    ],
    cell: CellOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the program.")],
    calibration: Annotated[
        Path | None,
        typer.Option(
            "--calibration",
            metavar="CALIBRATION.toml",
            help="What `calibrate` or `diagnose --calibration` wrote for the cell.",
        ),
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option(
            "--diagnosis",
            metavar="DIR",
            help="The diagnosis that wrote it: play, friction and ripple are corrected too.",
        ),
    ] = None,
    force: ForceOption = None,
    setup: EngagementOption = None,
    feed: Annotated[
        float | None, typer.Option("--feed", metavar="MM_MIN", help="The feed, where a solved path is given.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Rewrite a program so that the calibrated robot meets its poses."""

    def job(progress: Progress) -> Any:
        return job_of("compensate")(
            program,
            cell=cell,
            calibration=calibration,
            diagnosis=diagnosis,
            force=force,
            setup=setup,
            out=out,
            feed=feed,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_compensation)


def diagnose(
    cell: CellOption,
    log: Annotated[
        list[Path],
        typer.Option(
            "--log",
            metavar="LOG.csv",
            help="A measured run (may be repeated); LOG.toml beside it gives its frame and program.",
        ),
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="The folder that receives diagnosis.json and .html.")
    ],
    withheld: _WithheldOption = None,
    program: Annotated[
        Path | None,
        typer.Option(
            "--program",
            metavar="PROGRAM",
            help="The program that was run. Default: what each LOG.toml names, if it lies beside it.",
        ),
    ] = None,
    without: _WithoutOption = None,
    experiment: Annotated[
        Path | None,
        typer.Option("--write-experiment", metavar="FILE", help="Write the next experiment as a checked program."),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            "--calibration", metavar="OUT.toml", help="Write the fitted effects that `camrob compensate` can correct."
        ),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Say where the gap between simulation and measurement lies, what causes it, and how far it shrinks without that."""

    def job(progress: Progress) -> Any:
        return job_of("diagnose")(
            cell=cell,
            log=log,
            withheld=withheld or [],
            program=program,
            without=without or [],
            out=out,
            experiment=experiment,
            calibration=calibration,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_diagnosis)


def predict(
    program: Annotated[
        Path, typer.Argument(metavar="PROGRAM", help="A robot program in KRL (.src) or RAPID (.mod), of any post.")
    ],
    cell: CellOption,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="The folder that receives predict.json, .html and surface.npz.")
    ],
    calibration: Annotated[
        Path | None,
        typer.Option(
            "--calibration", metavar="FITTED.toml", help="What `calibrate` or `diagnose --calibration` wrote."
        ),
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option("--diagnosis", metavar="DIR", help="The diagnosis that wrote FITTED.toml: play, lag, doubt too."),
    ] = None,
    setup: Annotated[
        Path | None,
        typer.Option("--setup", metavar="SETUP.toml", help="Stock and cutter. Default: setup.toml beside the program."),
    ] = None,
    force: ForceOption = None,
    meant: Annotated[
        Path | None,
        typer.Option("--meant", metavar="PROGRAM", help="The program that a compensated one was made from."),
    ] = None,
    pitch_mm: Annotated[
        float, typer.Option("--pitch-mm", min=0.01, max=10.0, metavar="MM", help="Between rays of material.")
    ] = 0.2,
    cycle_ms: Annotated[
        float,
        typer.Option("--cycle-ms", min=1.0, max=100.0, metavar="MS", help="Milliseconds per row of the simulated run."),
    ] = 4.0,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Show the part as the machine as diagnosed would cut it: deviation, how sure, the worst places and why."""

    def job(progress: Progress) -> Any:
        return job_of("predict")(
            program,
            cell=cell,
            calibration=calibration,
            out=out,
            diagnosis=diagnosis,
            setup=setup,
            force=force,
            meant=meant,
            pitch_mm=pitch_mm,
            cycle_ms=cycle_ms,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_prediction)


def close_loop(
    job: Annotated[
        Path, typer.Argument(metavar="JOB.toml", help="The toolpath, the cell, the tolerance; the docs list the keys.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="The folder of the loop; each turn has a folder in it.")
    ],
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Program, run, diagnosis, correction, over and over, until the path is in tolerance or nothing helps; can be resumed."""

    def job_(progress: Progress) -> Any:
        return job_of("close_loop")(job, out=out, progress=progress)

    return perform(
        job_, as_json=as_json, quiet=quiet, render=_render_ledger, holds=lambda result: bool(result.summary.kept)
    )


def tracker(
    cell: TrackerCellOption = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="The folder that receives the files.")
    ] = None,
    listen: ListenOption = None,
    instrument: InstrumentOption = None,
    mode: ModeOption = None,
    gain: GainOption = None,
    cycle_ms: CycleOption = None,
    latency_ms: LatencyOption = None,
    tracker_in_base: FrameOption = None,
    corrected: CorrectedOption = None,
    sen_type: SenTypeOption = None,
    bounds: PairOption = None,
    realtime: RealtimeOption = False,
    duration: DurationOption = None,
    laps: _LapsOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """With --listen, be the tracker's loop: serve a controller that speaks RSI. Else the study of a cell's loop."""
    said = {
        "mode": None if mode is None else mode.value,
        "gain": gain,
        "cycle_ms": cycle_ms,
        "latency_ms": latency_ms,
        "tracker_in_base": tracker_in_base,
        "corrected": corrected,
        "sen_type": sen_type,
    }

    def job(progress: Progress) -> Any:
        if listen is None:
            own = {"instrument": instrument, "set": bounds, "realtime": realtime or None, "duration": duration}
            live = [name for name, value in {**said, **own}.items() if value is not None and name != "gain"]
            if live:
                option = live[0].replace("_", "-")
                raise InputError(f"--{option} has no meaning here", hint="give --listen HOST:PORT with it")
            return job_of("tracker")(cell=cell, out=out, gain=gain, laps=3 if laps is None else laps, progress=progress)
        if laps is not None:
            raise InputError("--laps has no meaning with --listen", hint="leave one of them out")
        return job_of("track_live")(
            listen=listen,
            instrument=instrument or "127.0.0.1:59153",
            cell=cell,
            said={**{k: v for k, v in said.items() if v is not None}, "bounds": bounds or ()},
            duration_s=duration,
            realtime=realtime,
            out=out,
            progress=progress,
        )

    render = _render_tracker if listen is None else _render_plain
    status = perform(job, as_json=as_json, quiet=quiet, render=render, status=lambda result: int(result.status))
    return has_become(status, quiet, "tracker") if listen is None else status
