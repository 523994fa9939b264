"""The cells of a table that another recorder wrote, text or Parquet: split, rows chosen, a second table's beside them."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.log import COLUMNS
from camrob.measurement.table_facts import TableFacts

__all__ = ["EMPTY", "TableCells", "decoded", "is_comment", "read_cells", "split_line"]

EMPTY = ("", "nan", "none", "null", "n/a", "-")
"""What programs write where nothing was measured, in small letters."""

_COMMENT = ("#", "%", "//")
_SHOWN = 8  # names or values in a hint


@dataclass(frozen=True, slots=True)
class TableCells:
    """Of the rows that are taken, in the file's order: what their cells hold, the lines that they stand on, and which rows of
    all they are, from 0 (both (N,)).
    """

    path: Path
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]
    lines: NDArray[np.int64]
    numbers: NDArray[np.int64]

    def column(self, column: str | int, name: str) -> list[Any]:
        """The cells of a column, by its name in the header or its number from 1. name: what it is taken for. Raises LogError."""
        place = self._place(column)
        for k, row in enumerate(self.rows):
            if place >= len(row):
                hint = f"its cell {place + 1} is missing; separator and decimal stand in [table] of its .toml"
                raise LogError(f"has no {name} in this row", hint=hint, path=self.path, line=int(self.lines[k]))
        return [row[place] for row in self.rows]

    def _place(self, column: str | int) -> int:
        header, path = self.header, self.path
        if isinstance(column, int):
            count = len(self.rows[0])
            if column > count:
                raise LogError(f"has no column {column}", hint=f"its first row has {count} cells", path=path)
            return column - 1
        if column not in header:
            near = difflib.get_close_matches(column, header, n=3, cutoff=0.4) or header[:_SHOWN]
            hint = f"its header has {', '.join(near)}" if header else "give columns by number, as there is no header"
            raise LogError(f"has no column {column[:40]!r}", hint=hint, path=path, line=1 if header else 0)
        place = header.index(column)
        if header.count(column) > 1:
            also = header.index(column, place + 1)
            hint = f"give it by number: {place + 1} or {also + 1}"
            raise LogError(f"has the column {column[:40]!r} twice", hint=hint, path=path, line=1)
        return place


def read_cells(path: Path, facts: TableFacts) -> TableCells:
    """The cells of a table, and of the one beside it, of the rows that facts name. Raises LogError."""
    if path.suffix.lower() == ".parquet":
        cells = _parquet(path, facts)
    else:
        cells = _text(path, facts.separator, facts.header, facts.below, facts.last)
    if facts.beside is not None:
        other = _text(path.parent / facts.beside.file, facts.beside.separator, facts.beside.header)
        cells = _side_by_side(cells, other)
    return cells if facts.rows is None else _chosen(cells, *facts.rows)


def _text(path: Path, separator: str, header: int, below: int = 0, last: int = 0) -> TableCells:
    lines = decoded(path).splitlines()[: last or None]
    named = lines[header - 1] if 0 < header <= len(lines) else ""
    names = split_line(named.lstrip("#%/ ") if is_comment(named) else named, separator) if named else []
    where = [k for k in range(header + below, len(lines)) if lines[k].strip() and not is_comment(lines[k])]
    if not where:
        raise LogError("holds no samples", hint="give rows behind the header", path=path)
    rows = [split_line(lines[k], separator) for k in where]
    return TableCells(path, names, rows, np.array(where, np.int64) + 1, np.arange(len(rows)))


def is_comment(line: str) -> bool:
    """Whether a line is a remark, not of the table."""
    return line.startswith(_COMMENT)


def decoded(path: Path) -> str:
    """A file's text: UTF-8, UTF-16 as Windows writes it, or the code page of an older Windows. Raises LogError."""
    try:
        raw = path.read_bytes()
    except OSError as e:
        raise LogError(f"can't be read ({e.strerror})", hint="check the path", path=path) from None
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", "replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")  # numbers are the same in both


def split_line(line: str, separator: str) -> list[str]:
    """Cells of a line; a separator between quotes is none."""
    if separator == " ":
        cells = line.split()
    elif '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    else:
        cells = line.split(separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def _parquet(path: Path, facts: TableFacts) -> TableCells:
    """Of a Parquet file, the columns that facts name (others may be pictures)."""
    try:
        from pyarrow import parquet
    except ImportError:
        raise LogError("reading Parquet needs pyarrow", hint="pip install pyarrow, or save as CSV", path=path) from None
    try:
        data: Any = parquet.ParquetFile(path)
        names = [str(n) for n in data.schema_arrow.names]
        asked = [source.column for source in facts.columns.values() if source.column] or [
            n for n in names if n in COLUMNS
        ]
        asked += [*facts.orientation_from, *(() if facts.rows is None else (facts.rows[0],))]
        used = {names[c - 1] if isinstance(c, int) and c <= len(names) else c for c in asked}
        table = data.read(columns=[n for n in names if n in used])
    except OSError as e:
        raise LogError(f"can't be read ({e.strerror or 'no Parquet'})", hint="check the file", path=path) from None
    except Exception as e:  # pyarrow's errors share no root but Exception
        raise LogError(f"is not a Parquet file ({type(e).__name__})", hint="check the file", path=path) from None
    if table.num_rows == 0:
        raise LogError("holds no samples", hint="give rows", path=path)
    nothing = [None] * table.num_rows
    columns = [table.column(n).to_pylist() if n in table.column_names else nothing for n in names]
    rows = np.arange(table.num_rows)
    return TableCells(path, names, list(zip(*columns, strict=True)), rows + 1, rows)


def _side_by_side(cells: TableCells, other: TableCells) -> TableCells:
    """Row by row the cells of both; the second's columns are counted on from the first's."""
    if len(cells.rows) != len(other.rows):
        what = f"has {len(cells.rows)} rows, {other.path.name} beside it {len(other.rows)}"
        raise LogError(what, hint="their rows belong together one by one: leave none out", path=cells.path)
    wide = len(cells.rows[0])
    for row, line in zip(cells.rows, cells.lines, strict=True):
        if len(row) != wide:
            hint = "cells of the table beside it are counted on from there; separator stands in [table] of its .toml"
            raise LogError(f"has {len(row)} cells, its first row {wide}", hint=hint, path=cells.path, line=int(line))
    names = [*(cells.header or [""] * wide), *(other.header or [""] * len(other.rows[0]))]
    if not any(names):
        names = []
    rows = [[*a, *b] for a, b in zip(cells.rows, other.rows, strict=True)]
    return TableCells(cells.path, names, rows, cells.lines, cells.numbers)


def _chosen(cells: TableCells, column: str | int, values: Sequence[str]) -> TableCells:
    """The rows whose cell in a column is one of values, as a text or as a number."""
    found = cells.column(column, str(column))
    wanted = {_same(v) for v in values}
    keep = [k for k, cell in enumerate(found) if _same(cell) in wanted]
    if not keep:
        there = list(dict.fromkeys(str(cell)[:20] for cell in found))
        hint = f"it holds {', '.join(there[:_SHOWN])}{', ..' if len(there) > _SHOWN else ''}"
        raise LogError(f"has no row whose {column} is {' or '.join(values)[:40]}", hint=hint, path=cells.path)
    at = np.array(keep, np.int64)
    return TableCells(cells.path, cells.header, [cells.rows[k] for k in keep], cells.lines[at], cells.numbers[at])


def _same(cell: Any) -> str | float:
    """What two cells are compared by: 3, 3.0 and "3" are the same."""
    try:
        return float(cell)
    except (TypeError, ValueError):
        return str(cell)
