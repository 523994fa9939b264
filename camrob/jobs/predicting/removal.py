"""The stock and the cutter of a set-up."""

from __future__ import annotations

from pathlib import Path

from camrob.bodies.meshes import body_triangles
from camrob.cell.cell import Cell
from camrob.cell.read_setup import read_setup
from camrob.cell.setup import Setup, ToolSetup
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, of_mesh
from camrob.errors import InputError, SetupError
from camrob.jobs.files.mounting import cutter_of

__all__ = ["beside_program", "cutter_for", "setup_for", "stock_of"]


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
