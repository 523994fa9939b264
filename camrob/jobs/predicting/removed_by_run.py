"""How much the cutters of a program take away of a set-up's stock along a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cutting.dexels import Dexels
from camrob.cutting.engagement import removed_area
from camrob.jobs.predicting.program_tools import ProgramTools, by_tool, mounted_in
from camrob.jobs.predicting.removal import setup_for, stock_of
from camrob.kinematics.frames import base_T_tool
from camrob.measurement.log import MeasurementLog
from camrob.prediction.surface import way_of
from camrob.program.program_text import ProgramText
from camrob.se3 import inverse

__all__ = ["Removal", "removal_of", "removed"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Removal = Callable[[MeasurementLog, Ints], Array]
"""(N,) m2 that a run cuts across the way to each row, by the numbers (N,) of the program's tools."""

_OF_DIAMETER = 0.05  # of the smallest cutter, between rays: a groove of a ball is then known within some hundredths


def removal_of(program: Path, text: ProgramText, setup: Path | None, machine: Cell) -> Removal:
    """What runs of a program cut of the set-up's stock. Raises InputError and SetupError where that is not said."""
    held = setup_for(program, setup, machine)
    tools = mounted_in(text, machine, held)[0]
    stock = stock_of(held, 2.0 * _OF_DIAMETER * min(cutter.radius for cutter in tools.cutters))
    return lambda run, number: removed(run, number, tools, stock, np.asarray(held.base_T_part))


def removed(run: MeasurementLog, number: Ints, tools: ProgramTools, stock: Dexels, base_T_part: Array) -> Array:
    """(N,) m2 that is cut across the way to each row of a run, if the machine goes as it should; number: (N,) of its tool."""
    part_T_base, poses = inverse(base_T_part), []
    for k, _rows, log in by_tool(run, number):
        cell = tools.cells[k]
        poses.append(part_T_base @ base_T_tool(cell, cell.to_q(log.setpoints(cell.axis_names))))
    way = way_of(np.concatenate(poses), tools.cutters, number)
    return np.append(0.0, np.repeat(removed_area(stock, way.moves), np.diff(way.kept)))
