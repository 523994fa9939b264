"""The tools that a program mounts, as its set-up knows them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.setup import Setup, ToolSetup
from camrob.controller.replay import program_cells
from camrob.cutting.cutter import Cutter
from camrob.errors import ProgramError
from camrob.findings import Finding
from camrob.jobs.files.mounting import tool_for
from camrob.jobs.predicting.removal import cutter_for, setup_for
from camrob.measurement.log import MeasurementLog
from camrob.prediction.force_model import CuttingForce, CuttingForces
from camrob.program.program_text import ProgramText
from camrob.runs import runs_of

__all__ = ["ProgramTools", "by_tool", "mounted_in", "pushed_in"]


@dataclass(frozen=True, slots=True)
class ProgramTools:
    """cells: the cell with each tool of a program; tools, cutters: what the set-up says of them; mounted: (M,) which of them each
    motion is made with.
    """

    cells: tuple[Cell, ...]
    tools: tuple[ToolSetup, ...]
    cutters: tuple[Cutter, ...]
    mounted: NDArray[np.int64]


def mounted_in(program: ProgramText, machine: Cell, setup: Setup) -> tuple[ProgramTools, list[Finding]]:
    """The tools of a program, and what there is to say of them.

    Raises ProgramError where the program has several and the set-up one, SetupError where it doesn't tell which they are.
    """
    cells, mounted, findings = program_cells(program, machine)
    if len(cells) > 1 and len(setup.tools) == 1:
        hint = "give --setup one with a [[tool]] for each, its flange_to_tool and shape"
        raise ProgramError(
            "sets more than one tool frame, and the set-up has one tool", hint=hint, path=program.files[0]
        )
    tools = tuple(tool_for(cell, setup) for cell in cells)
    cutters = tuple(cutter_for(tool, setup) for tool in tools)
    return ProgramTools(cells, tools, cutters, np.asarray(mounted, np.int64)), findings


def by_tool(run: MeasurementLog, number: NDArray[np.int64]) -> Iterator[tuple[int, slice, MeasurementLog]]:
    """The stretches of a run between two changes of tools: the tool, by the number that rows (N,) have, which rows, and these."""
    for rows in runs_of(number):
        columns = {name: np.asarray(values)[rows] for name, values in run.columns.items()}
        yield int(number[rows.start]), rows, MeasurementLog(columns, run.info)


def pushed_in(
    forces: CuttingForces, program: Path, text: ProgramText, machine: Cell, setup: Path | None
) -> tuple[CuttingForce, ...]:
    """What pushes on each of a program's tools. Raises InputError where forces or set-up don't tell that."""
    cells = program_cells(text, machine)[0]
    numbers: list[int | None] = [None] * len(cells)
    if forces.names_tools:
        held = setup_for(program, setup, machine)
        numbers = [tool_for(cell, held).number for cell in cells]
    return forces.on(numbers, program.name)
