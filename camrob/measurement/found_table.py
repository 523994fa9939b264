"""How a table that nobody described is written: separator, decimals, names, units; what its header leaves open is asked for."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.column_names import Meaning, meanings_of, unit_of
from camrob.measurement.log import AXES, COLUMNS, EXTERNAL, ORIENTATION, POSITION
from camrob.measurement.table_cells import EMPTY, decoded, is_comment, split_line
from camrob.measurement.table_facts import UNITS, Source, TableFacts

__all__ = ["found_facts"]

Array = NDArray[np.float64]

_SEPARATORS = (",", ";", "\t", "|", " ")
_SEARCHED = 100  # lines among which the names are looked for
_LOOKED_AT = 2000  # rows by which units are told
_LEAST = 3  # columns of a log that a header names
_NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?")
_TURNED = 7.0  # rad: no axis of an arm goes farther from its zero, so that larger numbers are degrees
_STEPS_S = 0.05  # s from row to row: taken for ms they would be a rate that no recorder has
_TURNING = (*AXES, *(f"c{n}" for n in AXES))
_SLIDING = (*EXTERNAL, *(f"c{n}" for n in EXTERNAL))
# what a column's unit measures; of axes both
_MAY_BE = {"t": ("time",), **dict.fromkeys((*POSITION, "d"), ("lengths",))}
_KINDS = {u: kind for kind, units in UNITS.items() for u in units}
_QUATERNION, _FANUC = ("qw", "qx", "qy", "qz"), ("w", "p", "r")
_UNCLEAR = (("rx", "ry", "rz"), ("yaw", "pitch", "roll"))
# what a clock that counts from 1970 shows at the least
_EPOCHS = (("s", 1e8), ("ms", 1e11), ("us", 1e14), ("ns", 1e17))


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where in a file the names stand (from 0), what parts its cells, and what its columns are; below: rows of units."""

    at: int
    separator: str
    names: Sequence[str]
    meanings: Sequence[Meaning]
    below: int = 0


def found_facts(path: Path, given: TableFacts | None, *, poses: bool) -> TableFacts | None:
    """The facts of a table as it is written, beside those that [table] gives; None where its header names no log.

    poses: rows are single poses, whose time nobody needs. Raises LogError, with file and line, for units and orientations
    that neither header nor [table] tells, and that change what comes out.
    """
    lines = decoded(path).splitlines()
    layout = _layout(lines, given)
    if layout is None:
        return None
    rows = [k for k in range(layout.at + 1 + layout.below, len(lines)) if lines[k].strip() and not is_comment(lines[k])]
    cells = [split_line(lines[k], layout.separator) for k in rows]
    while cells and _is_summary(cells[-1], cells[0]):
        cells.pop()
    if not cells:
        return None
    decimal = given.decimal if given is not None and "decimal" in given.told else _decimal(cells, layout.separator)
    last = rows[len(cells) - 1] + 1 if len(cells) < len(rows) else 0
    plain = TableFacts.plain() if given is None else given
    facts = replace(
        plain, separator=layout.separator, decimal=decimal, header=layout.at + 1, below=layout.below, last=last
    )
    return _with_columns(path, facts, layout, cells, poses=poses)


def _layout(lines: Sequence[str], given: TableFacts | None) -> _Layout | None:
    """The line, and the separator, by which most columns of a log are named."""
    best: _Layout | None = None
    most = _LEAST - 1
    fixed = given.told if given is not None else frozenset()
    for k, line in enumerate(lines[:_SEARCHED]):
        if given is not None and "header" in fixed and k != given.header - 1:
            continue
        text = line.lstrip("#%/ ") if is_comment(line) else line
        for separator in (given.separator,) if given is not None and "separator" in fixed else _SEPARATORS:
            names = split_line(text, separator)
            if sum(bool(_NUMBER.fullmatch(n)) for n in names) > 0:
                continue
            meanings = meanings_of(names)
            count = sum(bool(m.column) for m in meanings)
            if count > most:
                best, most = _Layout(k, separator, names, meanings), count
    return None if best is None else _with_units_below(best, lines)


def _with_units_below(layout: _Layout, lines: Sequence[str]) -> _Layout:
    """The layout with the units of a row beneath the names, where there is one."""
    if layout.at + 1 >= len(lines):
        return layout
    cells = split_line(lines[layout.at + 1], layout.separator)
    units = [unit_of(c) for c in cells]
    if any(_NUMBER.fullmatch(c) for c in cells) or not any(units) or len(cells) > len(layout.names):
        return layout
    units += [""] * (len(layout.names) - len(cells))
    told = [replace(m, unit=u or m.unit, own=m.own and not u) for m, u in zip(layout.meanings, units, strict=True)]
    return replace(layout, meanings=told, below=1)


def _is_summary(cells: Sequence[str], first: Sequence[str]) -> bool:
    """Whether a last row is none of the table: words (Mean, Max, a remark) where its rows begin with a number."""
    begins = _NUMBER.fullmatch(first[0]) or re.match(r"\d", first[0])
    return bool(begins) and re.match(r"[A-Za-z]{2}", cells[0]) is not None and cells[0].lower() not in EMPTY


def _decimal(cells: Sequence[Sequence[str]], separator: str) -> str:
    if separator == ",":
        return "."
    some = [c for row in cells[:_SEARCHED] for c in row]
    points = any("." in c and _NUMBER.fullmatch(c) for c in some)
    return "," if not points and any(re.fullmatch(r"[+-]?\d+,\d+", c) for c in some) else "."


def _with_columns(
    path: Path, facts: TableFacts, layout: _Layout, cells: Sequence[Sequence[str]], *, poses: bool
) -> TableFacts | None:
    """The facts with what each column is, and its unit."""
    line, taken = layout.at + 1, dict[str, int]()
    for k, meaning in enumerate(layout.meanings):
        if meaning.column in taken and meaning.column in COLUMNS:
            one, other = layout.names[taken[meaning.column]], layout.names[k]
            hint = f'say in [table.columns] of its .toml which it is: {meaning.column} = "{other}"'
            raise LogError(
                f"{one[:40]!r} and {other[:40]!r} may both be {meaning.column}", hint=hint, path=path, line=line
            )
        taken[meaning.column] = k
    columns: dict[str, Source] = {}
    for name in [n for n in COLUMNS if n in taken and n not in ORIENTATION]:
        k = taken[name]
        numbers = _numbers([row[k] if k < len(row) else "" for row in cells[:_LOOKED_AT]], facts.decimal)
        if name == "t" and numbers is None:
            columns[name] = Source(k + 1)  # dates or times of the day
            continue
        unit = _unit(path, facts, layout, name, k, numbers, poses=poses)
        if unit is not None:
            columns[name] = Source(k + 1, unit)
    if not any(n in columns for n in (*_TURNING, *_SLIDING)):
        return None
    if not any(n in columns for n in POSITION) and "d" not in columns:
        _check_not_reckoned(path, layout, columns)
    facts = replace(facts, columns=columns)
    return facts if facts.orientation_from else _with_orientation(path, facts, layout, taken)


def _numbers(cells: Sequence[str], decimal: str) -> Array | None:
    """Numbers of a column, those that are there; None where the first is none."""
    if cells and not _NUMBER.fullmatch(cells[0]) and cells[0].lower() not in EMPTY:
        return None
    return np.array([float(c.replace(",", ".") if decimal == "," else c) for c in cells if _NUMBER.fullmatch(c)])


def _unit(
    path: Path,
    facts: TableFacts,
    layout: _Layout,
    name: str,
    column: int,
    numbers: Array | None,
    *,
    poses: bool,
) -> str | None:
    """A column's unit, "" where [table] or the format tells it; None where the column is better left out. Raises LogError."""
    meaning = layout.meanings[column]
    kind = "angles" if name in _TURNING else "lengths" if name in (*POSITION, "d") else "time" if name == "t" else ""
    told = _KINDS.get(meaning.unit, "")
    if told and told not in _MAY_BE.get(name, ("angles", "lengths")):
        what = f"{layout.names[column][:40]!r} is {name}, and said to be in {meaning.unit}"
        hint = "correct the unit in its header or beneath it"
        raise LogError(what, hint=hint, path=path, line=layout.at + 1 + layout.below)
    if not kind or meaning.unit or kind in facts.told:
        return meaning.unit if meaning.unit in _KINDS else ""
    if meaning.own:
        return UNITS[kind][0]
    group = {"angles": _TURNING, "lengths": POSITION, "time": ("t",)}[kind]
    beside = {m.unit for m in layout.meanings if m.column in group and m.unit}
    if len(beside) == 1:
        return beside.pop()
    most = 0.0 if numbers is None or not len(numbers) else float(np.abs(numbers).max())
    if kind == "angles" and most > _TURNED:
        return "deg"
    if kind == "time":
        step = float(np.median(np.diff(numbers))) if numbers is not None and len(numbers) > 1 else 0.0
        epoch = [unit for unit, least in _EPOCHS if most > least]
        if epoch or 0.0 < step < _STEPS_S:
            return epoch[-1] if epoch else "s"
        if poses:
            return None
    shown = layout.names[column]
    units = '"mm", "m" or "inch"' if kind == "lengths" else " or ".join(f'"{u}"' for u in UNITS[kind][:2])
    hint = f"write it behind the name ({shown} [{UNITS[kind][0]}]), or [table] with {kind} = {units} into its .toml"
    raise LogError(f"{shown[:40]!r} is {name}, in a unit that isn't said", hint=hint, path=path, line=layout.at + 1)


def _check_not_reckoned(path: Path, layout: _Layout, columns: dict[str, Source]) -> None:
    """Raise LogError where the only places are those that the controller reckons, and the drives can't be told alone either."""
    reckoned = [n for n, m in zip(layout.names, layout.meanings, strict=True) if m.reckoned]
    drives = any(n in columns for n in AXES) and any(f"c{n}" in columns for n in AXES)
    if reckoned and not drives:
        what = f"holds no measured position: {reckoned[0][:40]} is what the controller reckons from its own axes"
        hint = "give an instrument's x, y, z of the same rows; where one measured these, name them x, y, z"
        raise LogError(what, hint=hint, path=path, line=layout.at + 1)


def _with_orientation(path: Path, facts: TableFacts, layout: _Layout, taken: dict[str, int]) -> TableFacts:
    """The facts with the columns of an orientation, where a header names one. Raises LogError where it doesn't say how."""
    for kind, names in (("abc", ORIENTATION), ("wxyz", _QUATERNION), ("abc", tuple(reversed(_FANUC)))):
        if all(n in taken for n in names):
            unit = layout.meanings[taken[names[0]]].unit or facts.units["angles"]
            columns = tuple(taken[n] + 1 for n in names)
            return replace(facts, orientation=kind, orientation_from=columns, units={**facts.units, "angles": unit})
    for names in _UNCLEAR:
        if all(n in taken for n in names) and any(n in facts.columns for n in POSITION):
            shown = [layout.names[taken[n]] for n in names]
            listed = ", ".join(f'"{n}"' for n in shown)
            what = f"{', '.join(shown)[:40]} may be a rotation vector, or angles about axes in one order or another"
            hint = f'say in [table] of its .toml: orientation = {{ as = "rotvec", columns = [{listed}] }} (or "xyz", "abc")'
            raise LogError(what, hint=f"{hint}, or rename them", path=path, line=layout.at + 1)
    return facts
