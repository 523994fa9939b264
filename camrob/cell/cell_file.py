"""Which file a cell is read from."""

from __future__ import annotations

import os
from pathlib import Path

from camrob.errors import CellError, InputError
from camrob.toml.table_reader import TableReader

__all__ = ["CELL_FILE", "cell_file", "without_schema"]

CELL_FILE = "cell.toml"


def cell_file(path: Path) -> Path:
    """The cell.toml of a cell's folder, or the file itself. Raises CellError for what is neither."""
    if path.suffix == ".toml" and not os.path.isdir(path):
        return path
    file, hint = path / CELL_FILE, f"give the folder that holds the cell's {CELL_FILE}"
    if os.path.isfile(path):
        raise CellError("is no cell", hint=hint, path=path)
    if os.path.isdir(path) and not os.path.lexists(file):
        raise CellError(f"there is no {CELL_FILE} in this folder", hint=hint, path=path)
    return file


def without_schema(table: TableReader, schema: int) -> InputError:
    """The error to raise for a file that doesn't say in which form it is."""
    if "part_in_base" in table or ("tool" in table and "kinematics" not in table):
        return CellError(
            "is a job's set-up, not a cell", hint="name it behind --setup, and the cell's folder here", path=table.path
        )
    what = "is missing" if table.keys() else "is missing, for the file is empty"
    return table.fail("schema", what, f"write schema = {schema} above all else, as the cells that come with camrob")
