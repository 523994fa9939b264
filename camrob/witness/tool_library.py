"""The tools of a CAM system's library, a CSV beside the set-up, as far as the witness asks for them. Lengths in mm.

Titles are Autodesk's (`Diameter (tool_diameter)`), ISO 13399's or plain words; the unit of a measure is what stands behind
it, the row's (a column Unit), or the title's (`diameter_mm`).
"""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

from camrob.errors import SetupError
from camrob.witness.units import INCH_MM

__all__ = ["Row", "read_rows"]

Row = dict[str, float | str]
"""A tool by the keys of [[tool]]: number, name, diameter_mm, length_mm, gauge_length_mm."""

_TITLES = {
    "number": "number toolnumber toolno tno tnr t",
    "name": "name toolname description tooldescription",
    "diameter_mm": "diameter tooldiameter cuttingdiameter dia d dc",
    "length_mm": "bodylength toolbodylength stickout stickoutlength lengthoutsideholder lb",
    "gauge_length_mm": "gaugelength assemblygaugelength toolassemblygaugelength",
    "unit": "unit units toolunit",
}
_FACTORS = {"mm": 1.0, "mil": 1.0, "met": 1.0, "in": INCH_MM, "inc": INCH_MM, "imp": INCH_MM, '"': INCH_MM}
_MEASURES = ("diameter_mm", "length_mm", "gauge_length_mm")


def read_rows(path: Path) -> dict[int, Row]:
    """The tools by their numbers. Raises SetupError, naming file and line."""
    try:
        content = path.read_bytes()
    except OSError as failure:
        raise SetupError("can't be read", hint="put it beside the set-up", path=path) from failure
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    kept = [row if not row.startswith("#") else "" for row in text.splitlines()]
    first = next((row for row in kept if row.strip()), "")
    mark = max((first.count(c), -k, c) for k, c in enumerate(",;\t"))[2]
    table = csv.reader(io.StringIO("\n".join(kept)), delimiter=mark, skipinitialspace=True)
    titles: dict[str, tuple[int, float | None]] = {}
    tools: dict[int, Row] = {}
    for fields in table:
        if not any(field.strip() for field in fields):
            continue
        if not titles:
            titles = _titles(fields)
            if "number" not in titles:
                raise SetupError(
                    "has no column of the tools' numbers", hint="call it number", path=path, line=table.line_num
                )
            continue
        row = _row(fields, titles, mark != ",", path, table.line_num)
        if row is None:
            continue
        number = int(float(row["number"]))
        if tools.setdefault(number, row) != row:
            raise SetupError(f"tool {number} is there twice, and differs", path=path, line=table.line_num)
    return tools


def _titles(fields: list[str]) -> dict[str, tuple[int, float | None]]:
    """Column and unit, mm, of each key; of several titles for one key the one that its list names first."""
    known: dict[str, tuple[int, float | None]] = {}
    for column, field in enumerate(fields):
        title, inner = field.strip().lower(), re.search(r"\(((?:tool|holder)_\w+)\)", field.lower())
        unit = re.search(r"[ _(\[]+(mm|in|inch|inches)[)\]]*$", title)
        title = inner[1] if inner else title[: unit.start()] if unit else title
        title = "".join(filter(str.isalnum, title))
        if title == "length" and unit:  # else that of all of the tool
            title = "bodylength"
        known.setdefault(title, (column, _FACTORS[unit[1][:3]] if unit else None))
    found = {}
    for key, names in _TITLES.items():
        for name in names.split():
            if name in known:
                found[key] = known[name]
                break
    return found


def _row(
    fields: list[str], titles: dict[str, tuple[int, float | None]], commas: bool, path: Path, line: int
) -> Row | None:
    """One tool; None without a number. commas: decimals may have one."""
    said = {key: fields[column].strip() for key, (column, _) in titles.items() if column < len(fields)}

    def value(key: str) -> tuple[float, str]:
        text = said[key].replace(",", ".") if commas else said[key]
        found = re.fullmatch(r"([-+]?[\d.]+(?:e[-+]?\d+)?) *([a-z\"]*)", text.lower())
        try:
            return (float(found[1]), found[2]) if found else (float(text), "")
        except ValueError:
            raise SetupError(f"{key} is {text[:40]!r}, no number", path=path, line=line) from None

    number = value("number")[0] if said.get("number") else 0.0
    if number == 0.0:
        return None
    if number != int(number) or number < 0.0:
        raise SetupError(f"{number:g} is no tool's number", path=path, line=line)
    row: Row = {"number": number, "name": said.get("name", "")}
    for key in _MEASURES:
        if not said.get(key):
            continue
        size, behind = value(key)
        unit = behind or said.get("unit", "").lower()
        factor = _FACTORS.get(unit[:3]) if unit else titles[key][1]
        if size and factor is None:
            raise SetupError(f"{key[:-3]} has no unit that is known", hint="write mm or inch", path=path, line=line)
        if size:
            row[key] = round(size * (factor or 0.0), 9)
    return row
