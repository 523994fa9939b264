"""The stock and the cutter of a set-up, and how much of the one the other takes away on a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.meshes import body_triangles
from camrob.cell.cell import Cell
from camrob.cell.read_setup import read_setup
from camrob.cell.setup import Setup, ToolSetup
from camrob.controller.replay import program_cell
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, of_mesh
from camrob.cutting.engagement import removed_area
from camrob.errors import InputError, SetupError
from camrob.jobs.files.mounting import cutter_of, tool_for
from camrob.kinematics.frames import base_T_tool
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.prediction.surface import way_of
from camrob.se3 import inverse

__all__ = ["Removal", "beside_program", "cutter_for", "removal_of", "removed", "setup_for", "stock_of"]

Array = NDArray[np.float64]
Removal = Callable[[MeasurementLog, Cell], Array]
"""(N,) m2 that a run in a cell, with the tool of its program, cuts across the way to each row."""

_OF_DIAMETER = 0.05  # of the cutter, between rays: a groove of a ball is then known within some hundredths


def removal_of(program: Path, setup: Path | None, machine: Cell) -> Removal:
    """What runs of a program with one tool cut of the set-up's stock. Raises InputError and SetupError where that is not said."""
    held = setup_for(program, setup, machine)
    tooled = machine
    if len(held.tools) > 1:  # which of them it is only the program tells
        text = language_of_file(program).read(program, machine.controller_section)
        tooled = program_cell(text, machine)[0]
    cutter = cutter_for(tool_for(tooled, held), held)
    stock = stock_of(held, 2.0 * _OF_DIAMETER * cutter.radius)
    return lambda run, cell: removed(run, cell, stock, cutter, np.asarray(held.base_T_part))


def beside_program(program: Path) -> Path:
    """The set-up that counts where none is given."""
    return Path(program).parent / "setup.toml"


def setup_for(program: Path, setup: Path | None, machine: Cell) -> Setup:
    """The set-up that is given, or lies beside the program. Raises InputError where none does."""
    beside = beside_program(program)
    if setup is None and not beside.is_file():
        raise InputError("nothing says what is cut, and by which cutter", hint="give --setup SETUP.toml", path=program)
    return read_setup(setup or beside, machine)


def cutter_for(tool: ToolSetup, setup: Setup) -> Cutter:
    """The cutter of one of a set-up's tools. Raises SetupError where it does not say what its shape is."""
    cutter = cutter_of(tool, setup)
    if cutter is None:
        what = (
            f"does not say the shape of cutter {tool.name or tool.number}"
            if len(setup.tools) > 1
            else "does not say the cutter's shape"
        )
        raise SetupError(what, hint="give [tool] diameter_mm, corner_radius_mm and length_mm", path=setup.path)
    return cutter


def stock_of(setup: Setup, pitch: float) -> Dexels:
    """The set-up's stock, or a block as large as its part."""
    body = setup.stock or setup.part
    if body is None:
        raise SetupError("names neither stock nor part", hint="add [stock] with box_mm or mesh", path=setup.path)
    if setup.stock is None:
        corners = body_triangles(body).reshape(-1, 3)
        return Dexels(corners.min(axis=0), corners.max(axis=0), pitch)
    if body.mesh is None:
        return Dexels(body.lower, body.upper, pitch)
    try:
        return of_mesh(body_triangles(body), pitch)
    except InputError as error:
        raise error.at(body.mesh) from None


def removed(run: MeasurementLog, cell: Cell, stock: Dexels, cutter: Cutter, base_T_part: Array) -> Array:
    """(N,) m2 that is cut across the way to each row of a run, if the machine goes as it should."""
    part_T_tool = inverse(base_T_part) @ base_T_tool(cell, cell.to_q(run.setpoints(cell.axis_names)))
    way = way_of(part_T_tool, (cutter,))
    return np.append(0.0, np.repeat(removed_area(stock, way.moves), np.diff(way.kept)))
