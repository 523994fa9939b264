"""Reading measurement logs, strictly: CSV (compiled, about a second for a million rows) and Parquet."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.csv_numbers import BAD_COUNT, BAD_NUMBER, BLANK_LINE, parse_table
from camrob.measurement.foreign_table import read_foreign
from camrob.measurement.found_table import found_facts
from camrob.measurement.log import (
    AXES,
    COLUMNS,
    CURRENT,
    DISTANCE,
    EXTERNAL,
    FORCE,
    MOTOR,
    NORMAL,
    ORIENTATION,
    POSITION,
    TORQUE,
    MeasurementLog,
)
from camrob.measurement.log_info import LogInfo, read_info
from camrob.measurement.log_units import check_plausible
from camrob.measurement.table_facts import TableFacts, read_table_facts

__all__ = ["read_log"]

Array = NDArray[np.float64]

_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_TOGETHER = (ORIENTATION, FORCE, NORMAL)
_AXES_BESIDE = (
    "give A1.. (encoders) or cA1.. (set-points), logged beside each reading ($AXIS_ACT, CJointT, actual_q); of a pose that the "
    "controller tells, the maker's own inverse gives them, in the configuration that it was in"
)
# from the first on, as many as there are
_ROWS = (AXES, tuple(f"c{n}" for n in AXES), TORQUE, MOTOR[: len(AXES)], CURRENT[: len(AXES)])
_ALSO = re.compile(r"(?:joint|axis|j|q|a)_?(\d+)\b")  # what others call A1 ..
_PROGRAMS = (".src", ".dat", ".mod", ".cls", ".ncl", ".apt", ".nc")  # what is named in a log's place by a slip
_COMMAS = 1.5  # times the cells of the header: then commas are decimals' too
_BLANKS = ("nan", "null", "-")
# COLUMNS in short
_NAMES = (
    "t, x y z, d, nx ny nz, a b c, A1.. E1.., cA1.. cE1.., T1.. TE1.., M1.. ME1.., I1.. IE1.., temp, fx fy fz, line"
)
_TIMES = ("time", "timestamp", "seconds", "zeit")
_EPOCH = 1e8  # s: no run lasts three years, so that the clock counts from 1970 or so: from the first row then
_SLOW_CELLS = 20_000_000  # entries: 640 MB of places


def read_log(path: str | Path) -> MeasurementLog:
    """The log in a .csv or .parquet file, with the facts of the .toml of its name beside it, where there is one.

    Args:
        path: the file.

    Returns:
        The log: its columns in trade units, as they stand in the file.

    Raises:
        LogError: with file and line (the row's number from 1 in a Parquet file), a column that is missing, unknown or there
            twice, a row with other cells than the header, text that is no number, NaN, time that does not advance, an empty
            log, and values that can't be in the format's units (metres, radians).

    Example:
        >>> log = camrob.read_log(Path("out/log.csv"))
        >>> "A1" in log.columns, bool(log.t[1] > log.t[0])
        (True, True)
    """
    path = Path(path)
    parquet, beside = path.suffix.lower() == ".parquet", path.with_suffix(".toml")
    info = read_info(beside) if beside.is_file() else LogInfo()
    facts = read_table_facts(beside) if beside.is_file() else None
    first = 1 if parquet else 2
    facts, plain = _facts(path, facts, info) if not parquet else (facts, None)
    if facts is not None:
        names, table, lines = read_foreign(path, facts)
        _check_names(names, path, timed=not info.poses)
    else:
        names, table = plain or _read_parquet(path, timed=not info.poses)
        lines = np.arange(first, first + len(table))
    columns = {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}
    if "t" not in columns:
        columns = {"t": np.arange(len(table), dtype=float), **columns}
    elif facts is not None:
        again = _same_again(columns)
        columns, lines = {n: v[~again] for n, v in columns.items()}, lines[~again]
    _check_time(columns["t"], path, lines)
    if columns["t"][0] > _EPOCH:
        columns["t"] = columns["t"] - columns["t"][0]
    check_plausible(columns, path, lines)
    return MeasurementLog(columns, info, path, lines)


def _facts(
    path: Path, given: TableFacts | None, info: LogInfo
) -> tuple[TableFacts | None, tuple[list[str], Array] | None]:
    """How a text file is to be read: by what [table] says, or by what its header says; or None, and names and values (N, k) of
    one in the format itself. Raises LogError.
    """
    if given is not None:
        named = bool(given.columns) or given.beside is not None or given.header == 0
        return (given if named else found_facts(path, given, poses=info.poses) or given), None
    try:
        return None, _read_csv(path, timed=not info.poses)
    except LogError:
        found = (
            None
            if path.suffix.lower() in _PROGRAMS or not path.is_file()
            else found_facts(path, None, poses=info.poses)
        )
        if found is None or _is_the_formats(path, found):
            raise
        return found, None


def _is_the_formats(path: Path, found: TableFacts) -> bool:
    """Whether a file is one of the format's but for a mistake in it, which is to be said."""
    with path.open("rb") as file:
        first = file.readline().decode("utf-8-sig", "replace").strip()
    names = [name.strip().strip('"') for name in first.split(",")]
    stamped = "t" in found.columns and not found.columns["t"].unit  # dates, times of the day
    plain = found.separator == "," and found.header == 1 and not found.below and not found.last and not stamped
    return plain and all(n in names for n in found.columns)


def _same_again(columns: Mapping[str, Array]) -> NDArray[np.bool_]:
    """(N,) True for rows that say once more, at the same time, what the row before says: some recorders write twice."""
    again = np.zeros(len(columns["t"]), bool)
    if not (np.diff(columns["t"]) == 0.0).any():
        return again
    again[1:] = True
    for values in columns.values():
        again[1:] &= (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    return again


def _check_names(names: Sequence[str], path: Path, *, timed: bool = True) -> None:
    """The header is the format's: known names, once each, groups whole. timed: it has to have a time."""
    known = {name.lower(): name for name in COLUMNS}
    for name in names:
        if name in COLUMNS:
            continue
        shown = repr(name[:40])
        others = _ALSO.match(name.strip('"').lower())
        bare = f"a{others[1]}" if others else re.split(r"[ _\[(]", name.strip('"'))[0].lower()
        bare = "t" if bare in _TIMES else bare
        if re.fullmatch(r"[cC]?[AE]\d+", name):
            raise LogError(f"has an axis {shown}", hint="the format knows A1..A7 and E1..E6", path=path, line=1)
        if bare in known:
            raise LogError(
                f"has a column {shown}", hint=f"name it {known[bare]}, in the format's unit", path=path, line=1
            )
        raise LogError(
            f"has a column {shown}",
            hint=f"leave it out, say in [table.columns] of its .toml what it is, or name it as here: {_NAMES}",
            path=path,
            line=1,
        )
    for name in names:
        if names.count(name) > 1:
            raise LogError(f"has the column {name} twice", hint="leave one", path=path, line=1)
    if timed and "t" not in names:
        hint = "give the time in seconds; single poses need none where its .toml says poses = true"
        raise LogError("has no column t", hint=hint, path=path, line=1)
    for group in _TOGETHER:
        missing = [n for n in group if n not in names]
        if missing and len(missing) < len(group):
            here = next(n for n in group if n in names)
            hint = f"{', '.join(group)} belong together"
            raise LogError(f"has a column {here} but no column {missing[0]}", hint=hint, path=path, line=1)
    if NORMAL[0] in names and not all(n in names for n in POSITION):
        hint = f"give {', '.join(POSITION)}, of which nx, ny, nz say along what they were measured"
        raise LogError("has normals nx, ny, nz without a position", hint=hint, path=path, line=1)
    if DISTANCE in names and (also := [n for n in POSITION if n in names]):
        hint = "one log holds distances, or places; measure both in two, of the same postures (same_poses_as)"
        raise LogError(f"has a column d beside {also[0]}", hint=hint, path=path, line=1)
    _check_axes(names, path)


def _check_axes(names: Sequence[str], path: Path) -> None:
    """Axes from the first on, none left out; encoders and set-points of the same ones."""
    for row in _ROWS:
        count = max((k + 1 for k, n in enumerate(row) if n in names), default=0)
        missing = [n for n in row[:count] if n not in names]
        if missing:
            hint = f"give {row[0]} .. {row[count - 1]}, none left out"
            raise LogError(f"has a column {row[count - 1]} but no column {missing[0]}", hint=hint, path=path, line=1)
    places = (*AXES, *EXTERNAL)
    if not any(n in names or f"c{n}" in names for n in places):
        what = "has no axis values: the tool's places alone can't tell which axis is off"
        raise LogError(what, hint=_AXES_BESIDE, path=path, line=1)
    if not any(n in names for n in places):
        return
    for name in places:
        if f"c{name}" in names and name not in names:
            hint = f"give {name} beside c{name}"
            raise LogError(f"has a column c{name} but no column {name}", hint=hint, path=path, line=1)


def _read_csv(path: Path, *, timed: bool) -> tuple[list[str], Array]:
    """Names and values (N, k) of a CSV file."""
    try:
        raw = path.read_bytes()
    except OSError as e:
        raise LogError(f"can't be read ({e.strerror})", hint="check the path", path=path) from None
    begin = 3 if raw.startswith(b"\xef\xbb\xbf") else 0
    end = raw.find(b"\n", begin)
    end = len(raw) if end < 0 else end
    try:
        header = raw[begin:end].decode("utf-8").rstrip("\r")
    except UnicodeDecodeError:
        raise LogError("is not UTF-8 text", hint="save it as UTF-8", path=path, line=1) from None
    if not header.strip():
        raise LogError("is empty", hint="give a header row and samples", path=path, line=1)
    for other, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars"), (" ", "blanks")):
        if other in header.strip() and "," not in header and not header.lstrip().startswith("#"):
            if path.suffix.lower() in _PROGRAMS:
                raise LogError("is no log, but a robot's program or a CL file", hint="name the log here", path=path)
            hint = "separate columns by commas, decimals by a point, or say so in [table] of its .toml"
            raise LogError(f"separates columns by {word}", hint=hint, path=path, line=1)
    names = [name.strip().strip('"') for name in header.split(",")]
    if all(_NUMBER.fullmatch(name.encode()) for name in names):
        hint = "name its columns in the first line, or say header = 0 in [table] of its .toml, and columns by number"
        raise LogError("holds numbers where its names should be", hint=hint, path=path, line=1)
    _check_names(names, path, timed=timed)
    text = np.frombuffer(raw, np.uint8)
    table = np.empty((int(np.count_nonzero(text[end:] == 10)) + 1, len(names)))
    slow = np.empty((min(table.size, _SLOW_CELLS), 4), np.int64)
    rows, code, column, left = parse_table(text, min(end + 1, len(raw)), table, slow)
    for row, at, first, last in slow[:left].tolist():
        table[row, at] = _slow_number(raw[first:last], names[at], path, row + 2)
    if code == BAD_COUNT:
        cells = raw[end + 1 :].split(b"\n", rows + 1)[rows].count(b",") + 1
        hint = f"it has {cells}, the header names {len(names)} columns"
        if cells > _COMMAS * len(names):
            hint += "; where decimals are written with commas, write points"
        raise LogError("has more or fewer cells than the header", hint=hint, path=path, line=rows + 2)
    if code == BLANK_LINE:
        raise LogError("there is an empty line within the table", hint="remove it", path=path, line=rows + 2)
    if code == BAD_NUMBER:
        hint = "write plain decimals"
        raise LogError(f"{names[column]} is not written as a plain number", hint=hint, path=path, line=rows + 2)
    if rows == 0:
        raise LogError("holds no samples", hint="give rows behind the header", path=path, line=1)
    return names, table[:rows]


def _slow_number(cell: bytes, name: str, path: Path, line: int) -> float:
    """A cell that is no plain decimal: an exponent, many digits, or no number at all."""
    text = cell.strip()
    if _NUMBER.fullmatch(text) and np.isfinite(float(text)):
        return float(text)
    shown = repr(text[:30].decode("utf-8", "replace"))
    hint = "leave a cell empty that was not measured, else give a finite number with a decimal point"
    if shown.strip("'").lower() in _BLANKS:
        hint += "; [table] in its .toml takes NaN, null and - for empty cells"
    raise LogError(f"{name} is {shown}", hint=hint, path=path, line=line)


def _read_parquet(path: Path, *, timed: bool) -> tuple[list[str], Array]:
    """Names and values (N, k) of a Parquet file; a null is a cell that was not measured."""
    try:
        from pyarrow import parquet
    except ImportError:
        raise LogError("reading Parquet needs pyarrow", hint="pip install pyarrow, or save as CSV", path=path) from None
    try:
        data: Any = parquet.read_table(path)
    except OSError as e:
        raise LogError(f"can't be read ({e.strerror or 'no Parquet'})", hint="check the file", path=path) from None
    except Exception as e:  # pyarrow's errors share no root but Exception
        raise LogError(f"is not a Parquet file ({type(e).__name__})", hint="check the file", path=path) from None
    names = [str(n) for n in data.column_names]
    _check_names(names, path, timed=timed)
    if data.num_rows == 0:
        raise LogError("holds no samples", hint="give rows", path=path)
    table = np.empty((data.num_rows, len(names)))
    for k, name in enumerate(names):
        column = data.column(k)
        try:
            values = column.to_numpy().astype(np.float64)
        except (ValueError, TypeError):
            raise LogError(f"{name} is of type {column.type}", hint="store numbers", path=path) from None
        bad = np.isinf(values) | (np.isnan(values) & ~np.asarray(column.is_null()))
        if bad.any():
            hint = "store null where nothing was measured"
            raise LogError(f"{name} is {values[bad][0]}", hint=hint, path=path, line=int(np.argmax(bad)) + 1)
        table[:, k] = values
    return names, table


def _check_time(t: Array, path: Path, lines: NDArray[np.int64]) -> None:
    """Every row has its time, and time advances."""
    if np.isnan(t).any():
        raise LogError("t is empty", hint="give every row its time", path=path, line=int(lines[np.argmax(np.isnan(t))]))
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        what = f"t is {t[row]:g} after {t[row - 1]:g}"
        hint = "time has to advance from row to row: sort or split the log"
        if t[row] == t[row - 1]:
            hint += ", or write [table] into its .toml, which counts rows once that say the same again"
            hint += "; step_s there takes the place of stamps that are coarser than the sampling"
        raise LogError(what, hint=hint, path=path, line=int(lines[row]))
