"""Text tables that aren't the log format's, taken as [table] of LOG.toml says: out come the format's names and units."""

from __future__ import annotations

import re
from datetime import UTC, datetime, time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.log import AXES, COLUMNS, DISTANCE, EXTERNAL, MOTOR, ORIENTATION, POSITION
from camrob.measurement.table_cells import EMPTY, TableCells, read_cells
from camrob.measurement.table_facts import UNITS, Source, TableFacts
from camrob.se3 import abc_to_rotation, quaternion_to_rotation, rotation_exp, rotation_to_abc
from camrob.units import INCH_MM, deg_to_rad, m_to_mm, ms_to_s, rad_to_deg

__all__ = ["read_foreign"]

Array = NDArray[np.float64]

_TURNING = (*AXES, *(f"c{n}" for n in AXES), *MOTOR[: len(AXES)])
_ANY_KIND = (*EXTERNAL, *(f"c{n}" for n in EXTERNAL), *MOTOR[len(AXES) :])
_NO_TURN = 1e-12  # length of a quaternion that says nothing
_ROUGH = 0.02  # by which a printed rotation matrix may miss R R^T = 1
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_DATE = re.compile(r"(\d{1,2})[./](\d{1,2})[./](\d{4})[ T,]*")
_HALF_DAY = re.compile(r"\s*\b([AaPp])\.?[Mm]\.?$")
_MONTHS = 12  # a number above is a day
_NO_ITEM = object()
_HINT = "give numbers; separator and decimal stand in [table] of its .toml"


def read_foreign(path: Path, facts: TableFacts) -> tuple[list[str], Array, NDArray[np.int64]]:
    """Names (K,) and values (N, K) in the format's units, and the line that each row stands on. Raises LogError."""
    if facts.separator == facts.decimal:
        raise LogError("has the same sign between cells and decimals", hint="correct [table] in its .toml", path=path)
    cells = read_cells(path, facts)
    sources = facts.columns or {n: Source(n) for n in cells.header if n in COLUMNS and n not in ORIENTATION}
    found: dict[str, Array] = {}
    for name, source in sources.items():
        stamps = _stamps(cells, source) if name == "t" and source.column else None
        if stamps is None:
            values = source.scale * _values(cells, source, name, facts) + source.offset
            found[name] = _in_format(path, name, values, source.unit, facts)
        else:
            found[name] = stamps
    if facts.step > 0.0:
        found["t"] = facts.step * cells.numbers.astype(np.float64)
    if facts.orientation_from or (not facts.columns and all(n in cells.header for n in ORIENTATION)):
        columns = facts.orientation_from or ORIENTATION
        each = np.stack([_values(cells, Source(c), str(c), facts) for c in columns], axis=1)
        found |= dict(zip(ORIENTATION, _abc(cells, each, facts).T, strict=True))
    for axis, other in facts.add.items():
        for kind in ("", "c"):
            if f"{kind}{axis}" in found and f"{kind}{other}" in found:
                found[f"{kind}{axis}"] = found[f"{kind}{axis}"] + found[f"{kind}{other}"]
    names = [n for n in COLUMNS if n in found]
    if not names:
        raise LogError("no column of it is named", hint="say in [table.columns] of its .toml what is what", path=path)
    return names, np.stack([found[n] for n in names], axis=1), cells.lines


def _values(cells: TableCells, source: Source, name: str, facts: TableFacts) -> Array:
    """(N,) numbers of a column, NaN where nothing was measured."""
    if source.column == 0:
        return np.zeros(len(cells.rows))
    column = cells.column(source.column, name)
    out = np.empty(len(column))
    for k, whole in enumerate(column):
        cell = _item(whole, source.item)
        if cell is _NO_ITEM:
            what, hint = f"has no item {source.item} of {name} in this row", f"the cell is {str(whole)[:40]}"
            raise LogError(what, hint=hint, path=cells.path, line=int(cells.lines[k]))
        out[k] = _number(cell, facts.decimal)
        if np.isinf(out[k]):
            raise LogError(f"{name} is {str(cell)[:30]!r}", hint=_HINT, path=cells.path, line=int(cells.lines[k]))
    return out


def _item(cell: Any, item: int) -> Any:
    """A cell, or one of its list's items from 1, `_NO_ITEM` where the list is too short."""
    if item:
        items = list(cell) if isinstance(cell, list | tuple) else re.split(r"[,;\s]+", str(cell).strip("[]() "))
        return items[item - 1] if item <= len(items) else _NO_ITEM
    return cell


def _number(cell: Any, decimal: str) -> float:
    """A cell's number, NaN where nothing was measured, infinite where it is none."""
    text = str(cell)
    if text.lower() in EMPTY:
        return float("nan")
    try:
        return float(text.replace(",", ".") if decimal == "," else text)
    except ValueError:
        return float("inf")


def _stamps(cells: TableCells, source: Source) -> Array | None:
    """(N,) seconds of dates with times, or of times of the day, as ISO 8601 writes them; None where the first is a number."""
    column = [_item(cell, source.item) for cell in cells.column(source.column, "t")]
    if not np.isinf(_number(column[0], ",")):
        return None
    out = np.empty(len(column))
    for k, cell in enumerate(column):
        out[k] = _seconds(cell)
        if np.isnan(out[k]):
            hint = "give seconds, or dates and times as 2026-11-27 14:05:03.25"
            raise LogError(f"t is {str(cell)[:30]!r}", hint=hint, path=cells.path, line=int(cells.lines[k]))
    return out


def _seconds(cell: Any) -> float:
    """Since 1970, or since midnight where there is no date; NaN where it is no time."""
    if isinstance(cell, datetime):
        return _since_1970(cell)
    text = str(cell).strip()
    afternoon = _HALF_DAY.search(text)
    if (written := _DATE.match(text)) is not None:
        # day and month change places from land to land; within one run the time of the day tells
        first, second, year = (int(n) for n in written.groups())
        day, month = (second, first) if second > _MONTHS else (first, second)
        text = f"{year:04d}-{month:02d}-{day:02d} {text[written.end() :].strip()}"
    if afternoon is not None:
        text = _HALF_DAY.sub("", text).strip()
        text = re.sub(r"(?<![\d-])(\d):", r"0\1:", text)
    later = 0.0 if afternoon is None else 12.0 * 3600.0 * (afternoon[1].lower() == "p")
    try:
        found = _since_1970(datetime.fromisoformat(text))
    except ValueError:
        try:
            day_time = time.fromisoformat(text)
        except ValueError:
            return float("nan")
        found = 3600.0 * day_time.hour + 60.0 * day_time.minute + day_time.second + 1e-6 * day_time.microsecond
    noon = afternoon is not None and 12.0 * 3600.0 <= found % 86400.0
    return found + later - 12.0 * 3600.0 * noon


def _since_1970(moment: datetime) -> float:
    return ((moment if moment.tzinfo else moment.replace(tzinfo=UTC)) - _EPOCH).total_seconds()


def _in_format(path: Path, name: str, values: Array, unit: str, facts: TableFacts) -> Array:
    """A column in the format's unit."""
    if not unit and name in _ANY_KIND and any(facts.units[k] != UNITS[k][0] for k in ("angles", "lengths")):
        what = f"{name}: whether it turns or slides is not said"
        raise LogError(what, hint=f'write {name} = {{ column = "..", unit = "m" }}, or "rad", "mm", "deg"', path=path)
    if not unit and name == "t":
        unit = facts.units["time"]
    elif not unit and name in (*POSITION, DISTANCE):
        unit = facts.units["lengths"]
    elif not unit and name in _TURNING:
        unit = facts.units["angles"]
    if unit == "rad":
        return rad_to_deg(values)
    if unit in ("m", "cm"):
        return m_to_mm(values) if unit == "m" else 10.0 * values
    if unit == "inch":
        return INCH_MM * values
    for _ in range(("s", "ms", "us", "ns").index(unit) if unit in UNITS["time"] else 0):
        values = ms_to_s(values)
    return values


def _abc(cells: TableCells, values: Array, facts: TableFacts) -> Array:
    """(N, 3) A, B, C in degrees of orientations (N, k); NaN where one of their numbers is missing."""
    out = np.full((len(values), 3), np.nan)
    kind = facts.orientation
    good = ~np.isnan(values).any(axis=1)
    if kind in ("wxyz", "xyzw"):
        good &= np.linalg.norm(values, axis=1) > _NO_TURN
    v = values[good]
    if kind == "wxyz":
        R = quaternion_to_rotation(v)
    elif kind == "xyzw":
        R = quaternion_to_rotation(v[:, [3, 0, 1, 2]])
    elif kind == "rotvec":
        R = rotation_exp(v)
    elif kind == "matrix":
        R = _rotations(cells, v, np.flatnonzero(good))
    else:
        angles = v if facts.units["angles"] == "rad" else deg_to_rad(v)
        each = angles[:, :, None] * np.eye(3)
        R = (
            abc_to_rotation(angles)
            if kind == "abc"
            else rotation_exp(each[:, 0]) @ rotation_exp(each[:, 1]) @ rotation_exp(each[:, 2])
        )
    out[good] = rad_to_deg(rotation_to_abc(R))
    return out


def _rotations(cells: TableCells, values: Array, rows: NDArray[np.int64]) -> Array:
    """(N, 3, 3) the rotations that printed matrices (N, 9), row by row, are nearest to. rows: (N,) where they stand."""
    M = values.reshape(-1, 3, 3)
    off = np.abs(M @ M.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    bad = (off > _ROUGH) | (np.linalg.det(M) < 0.0)
    if bad.any():
        hint = "name its nine cells row by row; columns of a 4 by 4 matrix hold a place beside them"
        raise LogError("is no rotation", hint=hint, path=cells.path, line=int(cells.lines[rows[np.argmax(bad)]]))
    U, _, Vt = np.linalg.svd(M)
    return np.asarray(U @ Vt)
