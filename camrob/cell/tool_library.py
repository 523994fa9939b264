"""A tool library beside the set-up: a CSV as CAM systems export it, row by row as the [[tool]]s of setup.toml.

Column names of Autodesk's export (Fusion, HSM: `Diameter (tool_diameter)`), of ISO 13399 (DC, RE, LB), of setup.toml's own keys,
and what people write. A row without a number is no tool that a program can call.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from camrob.errors import SetupError
from camrob.text import bytes_of
from camrob.units import INCH_MM

__all__ = ["LibraryTool", "read_tool_library"]

# keys of [[tool]] by what a column is called, letters and digits alone; of several names the first that the file has
_NAMES = {
    "number": ("number", "toolnumber", "toolno", "toolnr", "tno", "tnr", "t"),
    "name": ("name", "toolname", "description", "tooldescription"),
    "diameter_mm": ("diameter", "tooldiameter", "cuttingdiameter", "dia", "d", "dc"),
    "corner_radius_mm": ("cornerradius", "toolcornerradius", "re", "r2"),
    "length_mm": ("length", "bodylength", "toolbodylength", "stickout", "stickoutlength", "lengthoutsideholder", "lb"),
    "gauge_length_mm": ("gaugelength", "assemblygaugelength", "toolassemblygaugelength"),
    "holder_mm": ("holder", "holdersegments"),
    "type": ("type", "tooltype", "shape"),
    "unit": ("unit", "units", "toolunit"),
}
_WITH_UNIT = {"length", "holder"}  # alone, the length of all of the tool, and its holder's name
_MM = dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres", "metric"), 1.0)
_INCHES = dict.fromkeys(("in", "inch", "inches", '"', "imperial"), INCH_MM)
_UNITS = _MM | _INCHES
_HEADER_UNIT = re.compile(r"""[\s_\[(]+(mm|in|inch|inches)[\])]*\s*$""", re.I)
_NUMBER = re.compile(r"""([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z"]*)""", re.I)
_MOST_BYTES = 2**24  # 16 MB: libraries of thousands of tools are a tenth of it


class LibraryTool(NamedTuple):
    """A row: its line, and what it says by the keys of [[tool]]."""

    line: int
    table: dict[str, Any]


class _Column(NamedTuple):
    at: int
    title: str
    unit: float | None  # mm, where the title says so


def read_tool_library(path: Path) -> dict[int, LibraryTool]:
    """The tools of a CSV by their numbers. Raises SetupError by file and line."""
    try:
        data = bytes_of(path, _MOST_BYTES)
    except OSError as failure:
        hint = "put it beside the set-up"
        raise SetupError(f"can't be read: {failure.strerror}", hint=hint, path=path) from failure
    if len(data) > _MOST_BYTES:
        raise SetupError("is too large for a tool library", hint="export the job's tools alone", path=path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    rows = _rows(text, path)
    line, head, separator = next(rows, (1, [], ","))
    columns = _columns(head, path, line)
    tools: dict[int, LibraryTool] = {}
    for line, fields, _ in rows:
        try:
            table = _table(fields, columns, separator)
        except ValueError as wrong:
            raise SetupError(str(wrong), hint="mend the row, or leave it out", path=path, line=line) from None
        if table is None:
            continue
        number = int(table["number"])
        before = tools.setdefault(number, LibraryTool(line, table))
        if before.table != table:
            what = f"tool {number} is another one than in line {before.line}"
            raise SetupError(what, hint="give every tool a number of its own", path=path, line=line)
    return tools


def _rows(text: str, path: Path) -> Iterator[tuple[int, list[str], str]]:
    """Line, fields and separator of each row that is no comment; the separator is what the first one holds most of."""
    lines = text.splitlines()
    first = next((row for row in lines if row.strip() and not row.startswith("#")), "")
    separator = max(",;\t", key=first.count)
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    try:
        for fields in reader:
            if any(field.strip() for field in fields) and not fields[0].startswith("#"):
                yield reader.line_num, [field.strip() for field in fields], separator
    except csv.Error as failure:
        raise SetupError(f"is no CSV: {failure}", hint="export it again", path=path, line=reader.line_num) from failure


def _columns(head: list[str], path: Path, line: int) -> dict[str, _Column]:
    """Where the columns of each key stand."""
    found: dict[str, _Column] = {}
    titles: dict[str, _Column] = {}
    for at, title in enumerate(head):
        unit = _HEADER_UNIT.search(title)
        inner = re.search(r"\((?:tool|holder)_\w+\)", title)
        words = re.sub(r"[^a-z0-9]", "", (inner[0] if inner else title[: unit.start() if unit else None]).lower())
        if words in _WITH_UNIT and unit is None:
            continue
        titles.setdefault(words, _Column(at, title, _UNITS[unit[1].lower()] if unit else None))
    for key, names in _NAMES.items():
        name = next((name for name in names if name in titles), None)
        if name is not None:
            found[key] = titles[name]
    if "number" not in found:
        known = ", ".join(title for title in head if title)[:80]
        raise SetupError(
            f"has no column of the tools' numbers among: {known}", hint="call it number", path=path, line=line
        )
    return found


def _table(fields: list[str], columns: dict[str, _Column], separator: str) -> dict[str, Any] | None:
    """What a row says, None where it has no number. Raises ValueError with what is wrong."""
    said = {key: fields[column.at] for key, column in columns.items() if column.at < len(fields) and fields[column.at]}
    number, _ = _number(said.get("number", "0"), "number", separator)
    if number == 0.0:
        return None
    if number != int(number) or number < 0.0:
        raise ValueError(f"number is {said['number'][:40]}, which is no tool's")
    unit = said.get("unit", "").lower()
    if unit and unit not in _UNITS:
        raise ValueError(f"unit is {unit[:40]!r}, neither mm nor inch")
    table: dict[str, Any] = {"number": int(number)}
    if "name" in said:
        table["name"] = said["name"]
    for key in ("diameter_mm", "corner_radius_mm", "length_mm", "gauge_length_mm", "holder_mm"):
        if key not in said:
            continue
        column = columns[key]
        whole = _UNITS[unit] if unit else column.unit
        if key == "holder_mm":
            table[key] = [
                [_mm(d, "", whole, column), _mm(h, "", whole, column)] for d, h in _holder(said[key], separator)
            ]
            continue
        value, own = _number(said[key], column.title, separator)
        if value or key == "corner_radius_mm":  # a measure of 0 is none
            table[key] = _mm(value, own, whole, column)
    kind = said.get("type", "").lower()
    if "ball" in kind and "diameter_mm" in table and not table.get("corner_radius_mm"):
        table["corner_radius_mm"] = 0.5 * table["diameter_mm"]
    return table


def _mm(value: float, own: str, whole: float | None, column: _Column) -> float:
    """A measure in mm, by the unit behind it, or the row's or the column's."""
    unit = _UNITS.get(own.lower()) if own else whole
    if unit is None:
        said = f"is in {own!r}" if own else "names no unit"
        raise ValueError(f"{column.title[:40]} {said}: give a column unit (mm or inch), or {column.title[:20]}_mm")
    return round(value * unit, 9)


def _number(text: str, what: str, separator: str) -> tuple[float, str]:
    """A number and the unit behind it."""
    found = _NUMBER.fullmatch(text if separator == "," else text.replace(",", "."))
    if found is None:
        raise ValueError(f"{what[:40]} is {text[:40]!r}, no number")
    return float(found[1]), found[2]


def _holder(text: str, separator: str) -> list[tuple[float, float]]:
    """Diameters and lengths from the cutter up: `40x30 63x60`, or Autodesk's segments, of which the wider end counts."""
    if text.startswith("["):
        try:
            return [(max(_ends(s)), float(s["height"])) for s in json.loads(text)]
        except (ValueError, TypeError, KeyError, AttributeError):
            raise ValueError(f"holder is {text[:40]!r}, no list of segments") from None
    pairs = [re.fullmatch(r"([\d.,]+)x([\d.,]+)", pair.lower()) for pair in re.sub(r"\s*x\s*", "x", text).split()]
    if None in pairs or not pairs:
        raise ValueError(f"holder is {text[:40]!r}; write diameter x length of each cylinder: 40x30 63x60")
    return [(_number(p[1], "holder", separator)[0], _number(p[2], "holder", separator)[0]) for p in pairs if p]


def _ends(segment: dict[str, float]) -> tuple[float, float]:
    """Both diameters of a segment of Autodesk's."""
    lower, upper = (segment.get(end, segment.get(f"{end}-diameter", 0.0)) for end in ("lower", "upper"))
    return float(lower), float(upper)
