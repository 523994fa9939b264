"""Options of the command line that several verbs share, and their choices."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

__all__ = [
    "CellArgument",
    "CellOption",
    "CorrectedOption",
    "CycleOption",
    "Device",
    "DurationOption",
    "EngagementOption",
    "Feed",
    "ForceOption",
    "FrameOption",
    "GainOption",
    "InstrumentOption",
    "JsonOption",
    "LatencyOption",
    "ListenOption",
    "LoopMode",
    "Method",
    "ModeOption",
    "PairOption",
    "QuietOption",
    "RealtimeOption",
    "SenTypeOption",
    "SetupOption",
    "ThenCompensatedOption",
    "TrackerCellOption",
    "Units",
    "cells_to_complete",
    "known_cell",
]


class Method(StrEnum):
    """How the redundancy is resolved."""

    VJM = "vjm"
    PLANNED = "planned"


class Feed(StrEnum):
    """Where the feed comes from."""

    PROGRAM = "program"
    OPTIMAL = "optimal"


class Device(StrEnum):
    """Where a planner's batches are evaluated."""

    CPU = "cpu"
    CUDA = "cuda"


class Units(StrEnum):
    """Units of length of a CL file."""

    MM = "mm"
    INCH = "inch"


class LoopMode(StrEnum):
    """Who sums the corrections of the tracker loop: the server (absolute), or the controller (relative)."""

    ABSOLUTE = "absolute"
    RELATIVE = "relative"


def known_cell(asked: Path | None) -> Path | None:
    """The cell that was asked for: a path, or where nothing is there the shipped cell of that name.

    Raises InputError for a bare name of neither.
    """
    from camrob.shipped import cell_beside, demand_cell

    if asked is None or len(asked.parts) != 1 or asked.suffix or os.path.lexists(asked):
        return asked
    found = cell_beside(Path(), asked.name)
    demand_cell(found, asked.name)
    return found


def cells_to_complete(incomplete: str) -> list[str]:
    """Names of shipped cells that begin so, for the shell; where there is none it goes on with its own, files and folders."""
    from camrob.shipped import shipped_cells

    return [name for name in shipped_cells() if name.startswith(incomplete)]


CellOption = Annotated[
    Path,
    typer.Option(
        "--cell",
        callback=known_cell,
        autocompletion=cells_to_complete,
        help="The cell's folder (or its cell.toml), or the name of one that comes with camrob.",
        metavar="CELL",
    ),
]
CellArgument = Annotated[
    Path,
    typer.Argument(
        metavar="CELL",
        callback=known_cell,
        autocompletion=cells_to_complete,
        help="The cell's folder, or its name.",
    ),
]
TrackerCellOption = Annotated[
    Path | None,
    typer.Option(
        "--cell",
        metavar="CELL",
        callback=known_cell,
        autocompletion=cells_to_complete,
        help="A cell with a tracker.toml (or its cell.toml).",
    ),
]
SetupOption = Annotated[
    Path | None,
    typer.Option("--setup", help="Where the part lies. Default: setup.toml beside the CL file.", metavar="SETUP.toml"),
]
ForceOption = Annotated[
    Path | None, typer.Option("--force", metavar="FORCE.toml", help="What pushes on the tool while it cuts.")
]
EngagementOption = Annotated[
    Path | None,
    typer.Option(
        "--setup",
        metavar="SETUP.toml",
        help="Stock and cutter, where --force leaves its engagement open. Default: setup.toml beside the program.",
    ),
]
ThenCompensatedOption = Annotated[
    bool, typer.Option("--then-compensated", help="With --for-accuracy: plan for what camrob compensate will leave.")
]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", metavar="N", help="How long --method planned betters its plan.")
]
ProveOption = Annotated[
    float | None,
    typer.Option("--prove", metavar="N", help="Prove in N seconds how far the plan is above the best that exists."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the summary as one JSON object, and nothing else.")]
QuietOption = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]

# of `tracker --listen`; None where nothing was said, so that the cell or the job decides
ListenOption = Annotated[
    str | None, typer.Option("--listen", metavar="HOST:PORT", help="Answer a controller's RSI frames that arrive here.")
]
InstrumentOption = Annotated[
    str | None,
    typer.Option(
        "--instrument", metavar="HOST:PORT", help="Where the instrument's datagrams arrive. Default: 127.0.0.1:59153."
    ),
]
ModeOption = Annotated[LoopMode | None, typer.Option("--mode", help="RSI_ON's mode. Default: absolute.")]
GainOption = Annotated[float | None, typer.Option("--gain", metavar="K", help="Share of the error added each cycle.")]
CycleOption = Annotated[float | None, typer.Option("--cycle-ms", metavar="MS", help="RSI's cycle, 4 or 12.")]
LatencyOption = Annotated[
    float | None, typer.Option("--latency-ms", metavar="MS", help="How late a measurement arrives.")
]
FrameOption = Annotated[
    str | None,
    typer.Option("--tracker-in-base", metavar="X,Y,Z,A,B,C", help="The instrument's frame in $BASE, mm and degrees."),
]
CorrectedOption = Annotated[
    bool | None, typer.Option("--corrected/--programmed", help="Whether the controller's RSol holds the correction.")
]
SenTypeOption = Annotated[str | None, typer.Option("--sen-type", metavar="NAME", help="SENTYPE of the configuration.")]
RealtimeOption = Annotated[bool, typer.Option("--realtime", help="Ask the system for real-time priority.")]
DurationOption = Annotated[
    float | None, typer.Option("--duration", metavar="S", help="Run for this long. Default: until it is interrupted.")
]
PairOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A bound of the loop (cells/rx160_tracker/README.md)."),
]
