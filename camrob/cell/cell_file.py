"""Which file a cell is read from."""

from __future__ import annotations

import os
import re
from pathlib import Path

from camrob.cell.toml_table import TableReader
from camrob.errors import CellError, InputError

__all__ = ["CELL_FILE", "cell_file", "toml_cure", "without_schema"]

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


def toml_cure(path: Path, line: int) -> str:
    """What to do about a line that is no TOML: slips of whoever comes from Windows, a country of decimal commas, or a text
    processor, or who gives a key again.
    """
    rows = path.read_bytes().decode("utf-8-sig").splitlines()
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    if re.search(r'"[^"]*\\', row):
        return "write paths with /, or between single quotes"
    if re.search(r"=\s*-?\d+,\d+\s*(#.*)?$", row):
        return "write a decimal point for the comma"
    if re.search("[\u2018-\u201f]", row):
        return "write straight quotes, not a text processor's"
    key = row.partition("=")[0].strip()
    if key and sum(other.partition("=")[0].strip() == key for other in rows[:line]) > 1:
        return f"leave one of its lines that say {key[:40]}"
    return "correct that place"


def without_schema(table: TableReader, schema: int) -> InputError:
    """The error to raise for a file that doesn't say in which form it is."""
    if "part_in_base" in table or ("tool" in table and "kinematics" not in table):
        return CellError(
            "is a job's set-up, not a cell", hint="name it behind --setup, and the cell's folder here", path=table.path
        )
    what = "is missing" if table.keys() else "is missing, for the file is empty"
    return table.fail("schema", what, f"write schema = {schema} above all else, as the cells that come with camrob")
