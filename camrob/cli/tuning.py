"""The verb that fits a cell's fuzzy engines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from camrob.cli.console import job_of, perform, renderer
from camrob.cli.options import CellArgument, JsonOption, QuietOption
from camrob.progress import Progress

__all__ = ["tune_engines"]

_render_tune = renderer("terminal.tune_text", "render_tune")


def tune_engines(
    cell: CellArgument,
    on: Annotated[list[Path], typer.Option("--on", metavar="SAMPLES", help="CL files, or folders of them, to fit to.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder that receives the .fis files.")],
    withhold: Annotated[
        list[Path] | None, typer.Option("--withhold", metavar="SAMPLES", help="Samples to judge on, not to fit to.")
    ] = None,
    engine: Annotated[str, typer.Option("--engine", help="joint (h_jnt's weights) or condition (h_cond's).")] = "joint",
    budget: Annotated[int, typer.Option("--budget", metavar="N", help="Candidates that each fit may try.")] = 150,
    seeds: Annotated[int, typer.Option("--seeds", metavar="N", help="Fits of either kind.")] = 3,
    points: Annotated[int, typer.Option("--points", metavar="N", help="Cutting points a sample is thinned to.")] = 400,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Fit a fuzzy engine's rules to samples, and the best constant weights beside them."""

    def job(progress: Progress) -> Any:
        return job_of("tune_engines")(
            cell,
            on=on,
            out=out,
            withheld=withhold or [],
            engine=engine,
            budget=budget,
            seeds=seeds,
            points=points,
            progress=progress,
        )

    return perform(job, as_json=as_json, quiet=quiet, render=_render_tune)
