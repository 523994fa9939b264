"""What LOG.toml says in [table] of a table that isn't the format's: separators, names, units, orientations, axes that add up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camrob.errors import LogError
from camrob.measurement.log import AXES, COLUMNS, ORIENTATION
from camrob.measurement.log_info import wrong_key
from camrob.toml.read_toml import read_toml

__all__ = ["ORIENTATIONS", "UNITS", "Source", "TableFacts", "read_table_facts"]

UNITS = {
    "angles": ("deg", "rad"),
    "lengths": ("mm", "m", "cm", "inch"),
    "time": ("s", "ms", "us", "ns"),
}
"""Units that a table may be in, by what they measure, the format's own first."""

ORIENTATIONS = {"abc": 3, "xyz": 3, "rotvec": 3, "wxyz": 4, "xyzw": 4}
"""Ways to write an orientation, and of how many numbers: R = Rz(a) Ry(b) Rx(c) (KUKA's A, B, C; Fanuc's R, P, W), Rx Ry Rz
(Staubli), a rotation vector (UR), quaternions with their real part first (ABB) and last (ROS)."""

_KEYS = ("separator", "decimal", "header", "angles", "lengths", "time", "orientation", "columns", "add")


@dataclass(frozen=True, slots=True)
class Source:
    """Where a column of the format stands: its name in the header, or its number from 1; and its unit, "" for the table's."""

    column: str | int
    unit: str = ""


@dataclass(frozen=True, slots=True)
class TableFacts:
    """separator: " " for any blanks; header: the line of the names, 0 for none; units: by `UNITS`; orientation: one of
    `ORIENTATIONS`, and orientation_from its columns, () for none; columns: by the format's names, empty where the table's names
    are the format's; add: axis to the axis whose value is added to its own.
    """

    separator: str
    decimal: str
    header: int
    units: Mapping[str, str]
    orientation: str
    orientation_from: tuple[str | int, ...]
    columns: Mapping[str, Source]
    add: Mapping[str, str]


def read_table_facts(path: Path) -> TableFacts | None:
    """[table] of a LOG.toml, None where it has none. Raises LogError naming file, line, key, and hint."""
    table = read_toml(path, LogError).get("table")
    if table is None:
        return None
    if not isinstance(table, dict):
        raise wrong_key(path, "table", "is no table", "write [table], and the keys below it")
    for key in table:
        if key not in _KEYS:
            raise wrong_key(path, str(key)[:40], "is not a key of [table]", f"use {', '.join(_KEYS)}")
    orientation, source = _orientation(path, table.get("orientation"))
    return TableFacts(
        separator=_one_of(path, table, "separator", (",", ";", "\t", " ")),
        decimal=_one_of(path, table, "decimal", (".", ",")),
        header=_header(path, table.get("header", 1)),
        units={kind: _one_of(path, table, kind, names) for kind, names in UNITS.items()},
        orientation=orientation,
        orientation_from=source,
        columns=_columns(path, table.get("columns", {})),
        add=_added(path, table.get("add", {})),
    )


def _one_of(path: Path, table: Mapping[str, Any], key: str, choices: tuple[str, ...]) -> str:
    value = table.get(key, choices[0])
    if value not in choices:
        raise wrong_key(path, key, f"is {str(value)[:40]!r}", f"use one of {', '.join(map(repr, choices))}")
    return str(value)


def _header(path: Path, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 1000:
        raise wrong_key(path, "header", f"is {str(value)[:40]}", "give the line of the names, 0 where there is none")
    return value


def _column(path: Path, key: str, value: Any) -> str | int:
    if isinstance(value, bool) or not isinstance(value, str | int) or (isinstance(value, int) and value < 1):
        raise wrong_key(path, key, f"is {str(value)[:40]}", "give a name of the header in quotes, or a number from 1")
    return value


def _columns(path: Path, given: Any) -> dict[str, Source]:
    if not isinstance(given, dict):
        raise wrong_key(path, "columns", "is no table", 'write [table.columns], and below it A1 = "joint_1"')
    found = {}
    for name, value in given.items():
        if name not in COLUMNS or name in ORIENTATION:
            hint = f"use {', '.join(n for n in COLUMNS if n not in ORIENTATION)}; orientation stands in [table]"
            raise wrong_key(path, str(name)[:40], "is not a column of a log", hint)
        unit = ""
        if isinstance(value, dict):
            unit = str(value.get("unit", ""))
            if set(value) - {"column", "unit"} or unit not in ("", *(u for kind in UNITS.values() for u in kind)):
                raise wrong_key(path, name, "is not understood", '{ column = "torso", unit = "m" } says name and unit')
            value = value.get("column")
        found[name] = Source(_column(path, name, value), unit)
    return found


def _orientation(path: Path, given: Any) -> tuple[str, tuple[str | int, ...]]:
    if given is None:
        return "abc", ()
    hint = 'write orientation = { as = "wxyz", columns = ["qw", "qx", "qy", "qz"] }'
    if not isinstance(given, dict) or set(given) != {"as", "columns"} or given["as"] not in ORIENTATIONS:
        raise wrong_key(path, "orientation", "is not understood", f"{hint}, as one of {', '.join(ORIENTATIONS)}")
    columns = given["columns"]
    if not isinstance(columns, list) or len(columns) != ORIENTATIONS[given["as"]]:
        count = ORIENTATIONS[given["as"]]
        raise wrong_key(path, "orientation", f"{given['as']} has {count} columns", hint)
    return given["as"], tuple(_column(path, "orientation", c) for c in columns)


def _added(path: Path, given: Any) -> dict[str, str]:
    if not isinstance(given, dict):
        raise wrong_key(path, "add", "is no table", 'write add = { A3 = "A2" }')
    for axis, other in given.items():
        if axis not in AXES or other not in AXES or axis == other:
            raise wrong_key(
                path, "add", f"{str(axis)[:10]} = {str(other)[:10]!r}", 'name two axes, as in { A3 = "A2" }'
            )
    return dict(given)
