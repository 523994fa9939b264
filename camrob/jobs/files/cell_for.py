"""The cell that a verb works on, with the sections of its cell.toml that the verb needs, and the language of its controller."""

from __future__ import annotations

import tomllib
from pathlib import Path

from camrob.cell.cell import Cell
from camrob.cell.cell_file import cell_file
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.cell.read_controller import controller_key
from camrob.errors import CellError
from camrob.languages import LANGUAGES, language_named
from camrob.program.language import Language
from camrob.toml.key_line import key_line

__all__ = ["cell_for", "check_controller", "language_for", "language_of"]

_CONTROLLER = frozenset({"post", "verify", "simulate", "compensate"})
_RESOLVE = frozenset({"post", "place"})


def cell_for(verb: str, path: str | Path) -> Cell:
    """The cell in a folder. Raises CellError for a cell that can't be read, or lacks a section that the verb needs."""
    cell = read_cell(path).checked_for(f"camrob {verb}", controller=verb in _CONTROLLER, resolve=verb in _RESOLVE)
    check_controller(cell, Path(path))
    return cell


def check_controller(cell: Cell, path: Path) -> None:
    """Raise CellError for settings of a cell's controller, where it has any, that its language doesn't take."""
    if cell.controller_section is None:
        return
    follows = cell.base_follows_table
    if follows and not cell.indices(Role.WORKPIECE):
        what = "kinematics.base_follows_table is true, and the cell has no table: no joint's role is workpiece"
        hint = "set it to false, and take base_template, act_ex_ax or mechanical_unit away"
        file = cell_file(path)
        raise CellError(what, hint=hint, path=file, line=key_line(file, ("kinematics", "base_follows_table")))
    try:
        home = cell.to_axis_values(cell.q_home).tolist()
        language_named(cell.controller.language).settings(cell.controller, follows_table=follows, home=home)
    except CellError as e:
        file = cell_file(path)
        line = key_line(file, ("controller", *controller_key(e.what)))
        raise CellError(f"controller: {e.what}", hint=e.hint, path=file, line=line) from None


def language_of(cell: Cell) -> Language:
    """The language of a cell's controller. Raises CellError for a cell without that section."""
    return language_named(cell.controller.language)


def language_for(path: Path | None) -> Language:
    """The language of a cell that has not been read yet; the usual one where nobody can tell, which `cell_for` will say."""
    try:
        file = Path(path or "")
        text = (file if file.suffix == ".toml" and not file.is_dir() else file / "cell.toml").read_bytes()
        name = tomllib.loads(text.decode("utf-8-sig"))["controller"]["language"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        name = ""
    return language_named(name if name in LANGUAGES else "")
