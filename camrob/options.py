"""Options of the command line that several verbs share, and their choices."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

__all__ = ["CellOption", "Feed", "JsonOption", "Method", "QuietOption", "SetupOption", "Units"]


class Method(StrEnum):
    """How the redundancy is resolved."""

    VJM = "vjm"
    PLANNED = "planned"


class Feed(StrEnum):
    """Where the feed comes from."""

    PROGRAM = "program"
    OPTIMAL = "optimal"


class Units(StrEnum):
    """Units of length of a CL file."""

    MM = "mm"
    INCH = "inch"


CellOption = Annotated[Path, typer.Option("--cell", help="The cell's folder (or its cell.toml).", metavar="CELL")]
SetupOption = Annotated[
    Path | None,
    typer.Option("--setup", help="Where the part lies. Default: setup.toml beside the CL file.", metavar="SETUP.toml"),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the summary as one JSON object, and nothing else.")]
QuietOption = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
