"""Which file a cell is read from."""

from __future__ import annotations

import os
import re
from pathlib import Path

from camrob.errors import CellError

__all__ = ["CELL_FILE", "cell_file", "toml_cure"]

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
    """What to do about a line that is no TOML: two slips of whoever comes from Windows, or from a country of decimal commas."""
    rows = path.read_bytes().decode("utf-8-sig").splitlines()
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    if re.search(r'"[^"]*\\', row):
        return "write paths with /, or between single quotes"
    if re.search(r"=\s*-?\d+,\d+\s*(#.*)?$", row):
        return "write a decimal point for the comma"
    return "correct that place"
