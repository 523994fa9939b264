"""Text tables that aren't the log format's, taken as [table] of LOG.toml says: out come the format's names and units."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.log import AXES, COLUMNS, EXTERNAL, MOTOR, ORIENTATION, POSITION
from camrob.measurement.table_facts import UNITS, Source, TableFacts
from camrob.se3 import abc_to_rotation, quaternion_to_rotation, rotation_exp, rotation_to_abc
from camrob.units import INCH_MM, deg_to_rad, m_to_mm, ms_to_s, rad_to_deg

__all__ = ["read_foreign"]

Array = NDArray[np.float64]

_TURNING = (*AXES, *(f"c{n}" for n in AXES), *MOTOR[: len(AXES)])
_ANY_KIND = (*EXTERNAL, *(f"c{n}" for n in EXTERNAL), *MOTOR[len(AXES) :])
_EMPTY = ("", "nan", "none", "null", "n/a", "-")  # as programs write what was not measured
_COMMENT = ("#", "%")
_NO_TURN = 1e-12  # length of a quaternion that says nothing


def read_foreign(path: Path, facts: TableFacts) -> tuple[list[str], Array, NDArray[np.int64]]:
    """Names (K,) and values (N, K) in the format's units, and the line that each row stands on. Raises LogError."""
    if facts.separator == facts.decimal:
        raise LogError("has the same sign between cells and decimals", hint="correct [table] in its .toml", path=path)
    lines = _text(path).splitlines()
    header = _cells(lines[facts.header - 1], facts) if 0 < facts.header <= len(lines) else []
    where = [k for k in range(facts.header, len(lines)) if lines[k].strip() and not lines[k].startswith(_COMMENT)]
    if not where:
        raise LogError("holds no samples", hint="give rows behind the header", path=path)
    rows = [_cells(lines[k], facts) for k in where]
    own = {n: Source(n) for n in header if n in COLUMNS and n not in ORIENTATION}
    sources = facts.columns or own
    found = {}
    for name, source in sources.items():
        values = _values(path, rows, where, _place(path, source.column, header, len(rows[0])), name, facts)
        found[name] = _in_format(path, name, values, source.unit, facts)
    if facts.orientation_from or (not facts.columns and all(n in header for n in ORIENTATION)):
        columns = facts.orientation_from or ORIENTATION
        each = [_values(path, rows, where, _place(path, c, header, len(rows[0])), str(c), facts) for c in columns]
        found |= dict(zip(ORIENTATION, _abc(np.stack(each, axis=1), facts).T, strict=True))
    for axis, other in facts.add.items():
        for kind in ("", "c"):
            if f"{kind}{axis}" in found and f"{kind}{other}" in found:
                found[f"{kind}{axis}"] = found[f"{kind}{axis}"] + found[f"{kind}{other}"]
    names = [n for n in COLUMNS if n in found]
    return names, np.stack([found[n] for n in names], axis=1), np.array(where, np.int64) + 1


def _text(path: Path) -> str:
    try:
        raw = path.read_bytes()
    except OSError as e:
        raise LogError(f"can't be read ({e.strerror})", hint="check the path", path=path) from None
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")  # of an older Windows; numbers are the same in both


def _cells(line: str, facts: TableFacts) -> list[str]:
    cells = line.split() if facts.separator == " " else line.split(facts.separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def _place(path: Path, column: str | int, header: Sequence[str], count: int) -> int:
    """Which cell of a row a column is."""
    if isinstance(column, int):
        if column > count:
            raise LogError(f"has no column {column}", hint=f"its first row has {count} cells", path=path)
        return column - 1
    if column not in header:
        near = difflib.get_close_matches(column, header, n=3, cutoff=0.4) or header[:8]
        hint = f"its header has {', '.join(near)}" if header else "give columns by number, as there is no header"
        raise LogError(f"has no column {column[:40]!r}", hint=hint, path=path, line=1 if header else 0)
    return header.index(column)


def _values(
    path: Path, rows: Sequence[Sequence[str]], where: Sequence[int], place: int, name: str, facts: TableFacts
) -> Array:
    """(N,) numbers of a column, NaN where nothing was measured."""
    out = np.empty(len(rows))
    for k, row in enumerate(rows):
        if place >= len(row):
            hint = f"its cell {place + 1} is missing; separator and decimal stand in [table] of its .toml"
            raise LogError(f"has no {name} in this row", hint=hint, path=path, line=where[k] + 1)
        cell = row[place]
        if cell.lower() in _EMPTY:
            out[k] = np.nan
            continue
        try:
            out[k] = float(cell.replace(",", ".") if facts.decimal == "," else cell)
        except ValueError:
            out[k] = np.inf
        if np.isinf(out[k]):
            hint = "give numbers; separator and decimal stand in [table] of its .toml"
            raise LogError(f"{name} is {cell[:30]!r}", hint=hint, path=path, line=where[k] + 1)
    return out


def _in_format(path: Path, name: str, values: Array, unit: str, facts: TableFacts) -> Array:
    """A column in the format's unit."""
    if not unit and name in _ANY_KIND and any(facts.units[k] != UNITS[k][0] for k in ("angles", "lengths")):
        what = f"{name}: whether it turns or slides is not said"
        raise LogError(what, hint=f'write {name} = {{ column = "..", unit = "m" }}, or "rad", "mm", "deg"', path=path)
    if not unit and name == "t":
        unit = facts.units["time"]
    elif not unit and name in POSITION:
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


def _abc(values: Array, facts: TableFacts) -> Array:
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
