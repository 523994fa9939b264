"""Which file a cell is read from."""

from __future__ import annotations

import os
from pathlib import Path

from camrob.errors import CellError

__all__ = ["CELL_FILE", "cell_file"]

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
