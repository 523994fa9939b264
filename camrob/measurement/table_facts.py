"""What LOG.toml says in [table] of a table that isn't the format's: separators, names, units, orientations, axes that add up."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camrob.errors import LogError
from camrob.measurement.log import AXES, COLUMNS, ORIENTATION
from camrob.measurement.log_info import wrong_key
from camrob.toml.read_toml import read_toml

__all__ = ["ORIENTATIONS", "UNITS", "Beside", "Source", "TableFacts", "read_table_facts"]

UNITS = {
    "angles": ("deg", "rad"),
    "lengths": ("mm", "m", "cm", "inch"),
    "time": ("s", "ms", "us", "ns"),
}
"""Units that a table may be in, by what they measure, the format's own first."""

ORIENTATIONS = {"abc": 3, "xyz": 3, "rotvec": 3, "wxyz": 4, "xyzw": 4, "matrix": 9}
"""Ways to write an orientation, and of how many numbers: R = Rz(a) Ry(b) Rx(c) (KUKA's A, B, C; Fanuc's R, P, W), Rx Ry Rz
(Staubli), a rotation vector (UR), quaternions with their real part first (ABB) and last (ROS), and the matrix row by row."""

_SEPARATORS = (",", ";", "\t", " ", "|")
_UNITS = ("", *(u for kind in UNITS.values() for u in kind))
_KEYS = ("separator", "decimal", "header", *UNITS, "orientation", "columns", "add", "step_s", "rows", "beside")
_OF_A_COLUMN = ("column", "unit", "scale", "offset", "item")
_ALIKE = ("value", "unit")


@dataclass(frozen=True, slots=True)
class Source:
    """Where a column of the format stands: its name in the header, or its number from 1; its unit, "" for the table's, once
    the number is multiplied by scale and offset is added; item: which of a cell's list, from 1, 0 where it holds one number.
    column 0: all rows hold the offset.
    """

    column: str | int
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0
    item: int = 0


@dataclass(frozen=True, slots=True)
class Beside:
    """A second table whose rows belong to the first's one by one: its name in the same folder, separator, line of the names."""

    file: str
    separator: str
    header: int


@dataclass(frozen=True, slots=True)
class TableFacts:
    """separator: " " for any blanks; header: the line of the names, 0 for none; units: by `UNITS`; orientation: one of
    `ORIENTATIONS`, and orientation_from its columns, () for none; columns: by the format's names, empty where the table's names
    are the format's; add: axis to the axis whose value is added to its own; step: s from row to row where no column tells the
    time, else 0; rows: a column, and what stands there in the rows that are taken; beside: the second table. told: keys that the
    file gives. below: lines beneath the names that hold no samples (units); last: the line of the last sample, 0 for all.
    """

    separator: str
    decimal: str
    header: int
    units: Mapping[str, str]
    orientation: str
    orientation_from: tuple[str | int, ...]
    columns: Mapping[str, Source]
    add: Mapping[str, str]
    step: float
    rows: tuple[str | int, tuple[str, ...]] | None
    beside: Beside | None
    told: frozenset[str] = frozenset()
    below: int = 0
    last: int = 0

    @staticmethod
    def plain() -> TableFacts:
        """Those of a table of which nothing is told."""
        units = {kind: names[0] for kind, names in UNITS.items()}
        return TableFacts(_SEPARATORS[0], ".", 1, units, "abc", (), {}, {}, 0.0, None, None)


def read_table_facts(path: Path) -> TableFacts | None:
    """[table] of a LOG.toml, None where it has none. Raises LogError naming file, line, key, and hint."""
    table = read_toml(path, LogError).get("table")
    if table is None:
        return None
    if not isinstance(table, dict):
        raise wrong_key(path, "table", "is no table", "write [table], and the keys below it")
    for key in table:
        if key not in _KEYS:
            raise _wrong(path, str(key)[:40], "is not a key of [table]", f"use {', '.join(_KEYS)}")
    orientation, source = _orientation(path, table.get("orientation"))
    columns = _columns(path, table.get("columns", {}))
    separator, header = _one_of(path, table, "separator", _SEPARATORS), _header(path, table.get("header", 1))
    return TableFacts(
        separator=separator,
        decimal=_one_of(path, table, "decimal", (".", ",")),
        header=header,
        units={kind: _one_of(path, table, kind, names) for kind, names in UNITS.items()},
        orientation=orientation,
        orientation_from=source,
        columns=columns,
        add=_added(path, table.get("add", {})),
        step=_step(path, table.get("step_s"), timed="t" in columns),
        rows=_rows(path, table.get("rows")),
        beside=_beside(path, table.get("beside"), separator, header),
        told=frozenset(table),
    )


def _wrong(path: Path, key: str, what: str, hint: str) -> LogError:
    """What is wrong with a key of [table], or with a column's."""
    return wrong_key(path, key, what, hint, below=("table", "columns") if key in COLUMNS else ("table",))


def _one_of(path: Path, table: Mapping[str, Any], key: str, choices: tuple[str, ...]) -> str:
    value = table.get(key, choices[0])
    if value not in choices:
        raise _wrong(path, key, f"is {str(value)[:40]!r}", f"use one of {', '.join(map(repr, choices))}")
    return str(value)


def _header(path: Path, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 1000:
        raise _wrong(path, "header", f"is {str(value)[:40]}", "give the line of the names, 0 where there is none")
    return value


def _column(path: Path, key: str, value: Any) -> str | int:
    if isinstance(value, bool) or not isinstance(value, str | int) or (isinstance(value, int) and value < 1):
        raise _wrong(path, key, f"is {str(value)[:40]}", "give a name of the header in quotes, or a number from 1")
    return value


def _columns(path: Path, given: Any) -> dict[str, Source]:
    if not isinstance(given, dict):
        raise _wrong(path, "columns", "is no table", 'write [table.columns], and below it A1 = "joint_1"')
    found = {}
    for name, value in given.items():
        if name not in COLUMNS or name in ORIENTATION:
            hint = f"use {', '.join(n for n in COLUMNS if n not in ORIENTATION)}; orientation stands in [table]"
            raise wrong_key(path, str(name)[:40], "is not a column of a log", hint, below=("table", "columns"))
        found[name] = _source(path, name, value if isinstance(value, dict) else {"column": value})
    return found


def _source(path: Path, name: str, given: Mapping[str, Any]) -> Source:
    if "value" in given:
        if set(given) - set(_ALIKE) or given.get("unit", "") not in _UNITS or not _is_number(given["value"]):
            hint = "{ value = 0 } is of an axis that stood still, or of a direction that the instrument doesn't see"
            raise _wrong(path, name, "is not understood", hint)
        return Source(0, given.get("unit", ""), offset=float(given["value"]))
    unit, numbers = given.get("unit", ""), [given.get("scale", 1.0), given.get("offset", 0.0)]
    if set(given) - set(_OF_A_COLUMN) or unit not in _UNITS or not all(map(_is_number, numbers)) or not numbers[0]:
        hint = (
            '{ column = "torso", unit = "m" } says name and unit, scale = -0.001, offset = 5 that it is to be converted'
        )
        raise _wrong(path, name, "is not understood", hint)
    item = given.get("item", 0)
    if isinstance(item, bool) or not isinstance(item, int) or item < 0:
        raise _wrong(path, name, f"item is {str(item)[:40]}", "give which of the cell's list it is, from 1")
    return Source(_column(path, name, given.get("column")), unit, float(numbers[0]), float(numbers[1]), item)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _step(path: Path, given: Any, *, timed: bool) -> float:
    if given is None:
        return 0.0
    if not _is_number(given) or given <= 0.0:
        raise _wrong(path, "step_s", f"is {str(given)[:40]}", "give the seconds from row to row, as in step_s = 0.1")
    if timed:
        raise _wrong(path, "step_s", "stands beside a column t", "leave one of both")
    return float(given)


def _rows(path: Path, given: Any) -> tuple[str | int, tuple[str, ...]] | None:
    if given is None:
        return None
    values = given.get("is") if isinstance(given, dict) else None
    values = values if isinstance(values, list) else [values]
    good = all(isinstance(v, str | int | float) and not isinstance(v, bool) for v in values)
    if not isinstance(given, dict) or set(given) != {"column", "is"} or not values or not good:
        raise _wrong(path, "rows", "is not understood", 'write rows = { column = "run", is = 3 }, or is = ["a", "b"]')
    return _column(path, "rows", given["column"]), tuple(map(str, values))


def _beside(path: Path, given: Any, separator: str, header: int) -> Beside | None:
    """separator and header: the first table's, which hold where the second says none."""
    if given is None:
        return None
    table = {"file": given} if isinstance(given, str) else given
    name = table.get("file") if isinstance(table, dict) else None
    if not isinstance(name, str) or set(table) - {"file", "separator", "header"} or Path(name).name != name:
        hint = (
            'write beside = "poses.txt", a file of this folder, or { file = "poses.txt", separator = " ", header = 0 }'
        )
        raise _wrong(path, "beside", "is not understood", hint)
    own = {"separator": separator, **table}
    return Beside(name, _one_of(path, own, "separator", _SEPARATORS), _header(path, table.get("header", header)))


def _orientation(path: Path, given: Any) -> tuple[str, tuple[str | int, ...]]:
    if given is None:
        return "abc", ()
    hint = 'write orientation = { as = "wxyz", columns = ["qw", "qx", "qy", "qz"] }'
    if not isinstance(given, dict) or set(given) != {"as", "columns"} or given["as"] not in list(ORIENTATIONS):
        raise _wrong(path, "orientation", "is not understood", f"{hint}, as one of {', '.join(ORIENTATIONS)}")
    columns = given["columns"]
    if not isinstance(columns, list) or len(columns) != ORIENTATIONS[given["as"]]:
        count = ORIENTATIONS[given["as"]]
        raise _wrong(path, "orientation", f"{given['as']} has {count} columns", hint)
    return given["as"], tuple(_column(path, "orientation", c) for c in columns)


def _added(path: Path, given: Any) -> dict[str, str]:
    if not isinstance(given, dict):
        raise _wrong(path, "add", "is no table", 'write add = { A3 = "A2" }')
    for axis, other in given.items():
        if axis not in AXES or other not in AXES or axis == other:
            raise _wrong(path, "add", f"{str(axis)[:10]} = {str(other)[:10]!r}", 'name two axes, as in { A3 = "A2" }')
    return dict(given)
