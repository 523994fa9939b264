"""The job as setup.toml alone describes it: where the part lies, the tools, feeds, bodies. Lengths in m, speeds in m/s."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import SetupError
from camrob.witness.fields import Fields, read_toml
from camrob.witness.frames import frame
from camrob.witness.machine_tool import MachineTool, beside, named_by
from camrob.witness.tool_library import read_rows
from camrob.witness.units import INCH_MM, mm_min_to_m_s, mm_to_m

__all__ = ["Body", "Job", "Tool", "no_job", "read_job"]

Array = NDArray[np.float64]

_METRES = {"mm": mm_to_m(1.0), "inch": mm_to_m(INCH_MM), "m": 1.0}
_FILES = ("machine", "tool_library", "flange_to_gauge_line")  # and what a library's lengths count from
_WORDS = ("units", "dialect", "cutter_compensation")
_TON, _FAR = 1000.0, 1e4  # kg, mm
_MEASURES = ("feed_mm_min", "rapid_feed_mm_min")
_LENGTHS = ("chord_tolerance_mm", "decimate_mm", "clearance_mm")
_OF_OTHERS = ("tolerance_mm",)  # what no rule of the witness asks for: it may only slow cuts


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """A tool of the set-up; `flange_T_tool` is None where the cell's own holds, diameter and length where not given."""

    name: str = ""
    flange_T_tool: Array | None = None
    diameter: float | None = None
    length: float | None = None
    load: tuple[float, ...] | None = None  # kg, the centre X, Y, Z on the flange, m, and moments about X, Y, Z, kg m^2


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The part or the stock as the set-up gives it: a mesh's file, or a box."""

    file: Path | None
    scale: float  # of the mesh, to metres
    box: Array | None  # (2, 3) least and greatest corner, m, in the CL data's frame


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """A set-up. `tools` by number, 0 the one tool that stands for all numbers; bodies by "part" and "stock"."""

    base_T_part: Array = field(default_factory=lambda: np.eye(4))
    tools: Mapping[int, Tool] = field(default_factory=dict)
    bodies: Mapping[str, Body] = field(default_factory=dict)
    feed: float | None = None
    rapid_feed: float | None = None
    spindle_rpm: float | None = None
    chord_tolerance: float | None = None
    decimate: float | None = None
    clearance: float | None = None
    units: str | None = None
    dialect: str | None = None
    machine: MachineTool | None = None  # whose own axes a G-code program names
    wear: bool = False  # compensated paths are the tool centre's
    lines: Mapping[str, tuple[int, int]] = field(default_factory=dict)  # of the CL file, first and last, by clamping
    given: bool = True  # False: there is no set-up, and all of this is assumed

    def tool(self, number: int) -> Tool | None:
        """The tool of this number, else the one that stands for all; None where the set-up names none such."""
        return self.tools.get(number, self.tools.get(0))

    @property
    def loads(self) -> dict[int, tuple[float, ...]]:
        """Number to mass, centre and moments, of tools whose mass is stated."""
        return {number: tool.load for number, tool in self.tools.items() if tool.load is not None}

    @property
    def numbers(self) -> dict[str, int]:
        """The tools' numbers by their names, in lower case; a name that two tools have names none."""
        names = [tool.name.strip().casefold() for number, tool in self.tools.items() if number]
        return {
            tool.name.strip().casefold(): number
            for number, tool in self.tools.items()
            if number and tool.name and names.count(tool.name.strip().casefold()) == 1
        }

    def corners(self, name: str) -> Array | None:
        """Corner points (K, 3) m of a body in `base`: all of them lie in it, and its hull is theirs. None where not given.

        Raises SetupError where its mesh can't be read.
        """
        body = self.bodies.get(name)
        if body is None:
            return None
        if body.file is not None:
            part_p_corners = _vertices(body.file) * body.scale
        else:
            grid = np.array(np.meshgrid(*np.asarray(body.box).T, indexing="ij"))
            part_p_corners = grid.reshape(3, -1).T
        return np.asarray(part_p_corners @ self.base_T_part[:3, :3].T + self.base_T_part[:3, 3])


def no_job() -> Job:
    """Where no set-up is given: the part's frame is `base`, the tool the cell's own."""
    return Job(given=False)


def _facets(file: Path) -> Array | None:
    """The corners (K, 3) of a binary STL file: 84 bytes, then 50 of each facet, its normal and three corners as 32-bit numbers.

    None where the number of facets and the size of the file don't fit: another kind, or a damaged one.
    """
    content = np.fromfile(file, np.uint8)
    if file.suffix.lower() != ".stl" or len(content) < 84 or (len(content) - 84) % 50:
        return None
    facets = content[84:].reshape(-1, 50)
    if int(content[80:84].view("<u4")[0]) != len(facets):
        return None
    numbers = np.ascontiguousarray(facets[:, 12:48]).view("<f4")
    return np.unique(numbers.reshape(-1, 3), axis=0).astype(np.float64)


def _vertices(file: Path) -> Array:
    """The vertices (K, 3) of a mesh, in its own unit."""
    try:
        points = _facets(file)
        if points is None:
            import trimesh  # takes long to import

            mesh = trimesh.load(str(file), force="mesh")
            points = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    except (OSError, ValueError, IndexError, KeyError, TypeError, AttributeError) as failure:
        raise SetupError(f"the mesh can't be read ({failure})", hint="give an STL file", path=file) from failure
    if not len(points) or not np.isfinite(points).all():
        raise SetupError("the mesh has no points, or some that are not numbers", hint="give an STL file", path=file)
    return points


def _tool(fields: Fields, gauge: Array | None) -> Tool:
    """One [tool]. gauge: flange_T_gauge_line, None where it isn't told."""
    fields.none_but(
        "number",
        "name",
        "flange_to_tool",
        "diameter_mm",
        "length_mm",
        "corner_radius_mm",
        "holder_mm",
        "runout_mm",
        "mass_kg",
        "center_of_mass_mm",
        "inertia_kg_m2",
        "gauge_length_mm",
    )
    diameter, length = fields.maybe("diameter_mm"), fields.maybe("length_mm")
    for key, value in (("diameter_mm", diameter), ("length_mm", length)):
        if value is not None and value <= 0.0:
            raise fields.wrong(key, f"is {value:g}, and has to be above 0")
    load = None
    if "mass_kg" in fields or "center_of_mass_mm" in fields:
        mass, center = fields.number("mass_kg"), fields.numbers("center_of_mass_mm", 3)
        if not 0.0 < mass <= _TON:
            raise fields.wrong("mass_kg", f"is {mass:g}, and has to be above 0 and no more than {_TON:g}")
        if np.linalg.norm(center) > _FAR:
            raise fields.wrong("center_of_mass_mm", "lies farther off the flange than any tool is long", "write mm")
        x, y, z = mm_to_m(center).tolist()
        moments = fields.numbers("inertia_kg_m2", 3, [0, 0, 0]).tolist()
        if min(moments) < 0.0 or 2.0 * max(moments) > sum(moments) * (1.0 + 1e-9):
            raise fields.wrong("inertia_kg_m2", "are no body's: one is below 0, or above the other two together")
        load = (mass, x, y, z, *moments)
    held = frame(fields.numbers("flange_to_tool", 6)) if "flange_to_tool" in fields else None
    if held is None and gauge is not None and "gauge_length_mm" in fields:
        held = gauge.copy()  # the tip lies that far out of it, against its z
        held[:3, 3] -= mm_to_m(fields.number("gauge_length_mm")) * gauge[:3, 2]
    return Tool(
        name=fields.text("name", ""),
        flange_T_tool=held,
        diameter=None if diameter is None else mm_to_m(diameter),
        length=None if length is None else mm_to_m(length),
        load=load,
    )


def _tools(top: Fields) -> dict[int, Tool]:
    """[tool] or [[tool]]: by number, 0 for one without a number; under them the library's, of which they may change some."""
    gauge = frame(top.numbers("flange_to_gauge_line", 6)) if "flange_to_gauge_line" in top else None
    path = beside(top, "tool_library")
    rows = {} if path is None else read_rows(path)
    tools: dict[int, Tool] = {}
    for fields in top.subs("tool"):
        fields.table = {**rows.get(int(fields.number("number", 0.0)), {}), **fields.table}
        number = fields.number("number", 0.0)
        if number != int(number) or number < 0 or ("number" in fields and number == 0):
            raise fields.wrong("number", f"is {number:g}, which is not a tool's number", "write 1, 2, ...")
        if int(number) in tools:
            raise fields.wrong("number", "is given twice" if number else "is missing: more tools than one need numbers")
        tools[int(number)] = _tool(fields, gauge)
    for other, row in rows.items():
        if other not in tools:
            tools[other] = _tool(Fields(row, path or top.path, SetupError, f"tool {other}: "), gauge)
    if 0 in tools and len(tools) > 1:
        raise top.wrong("tool", "has tools with a number and one without")
    return tools


def _body(fields: Fields) -> Body:
    """[part] or [stock]."""
    fields.none_but("mesh", "box_mm", "unit")
    if ("mesh" in fields) == ("box_mm" in fields):
        raise fields.wrong("mesh", "and box_mm: one of the two is needed, not both")
    if "box_mm" in fields:
        box = mm_to_m(fields.numbers("box_mm", 6)).reshape(2, 3)
        if np.any(box[0] >= box[1]):
            raise fields.wrong("box_mm", "does not rise from [X0, Y0, Z0] to [X1, Y1, Z1]")
        return Body(None, 1.0, box)
    unit = fields.text("unit", "mm")
    if unit not in _METRES:
        raise fields.wrong("unit", f"is {unit!r}", "write mm, inch or m")
    return Body(fields.path.parent / fields.text("mesh"), _METRES[unit], None)


def _clampings(top: Fields) -> dict[str, tuple[int, int, Array]]:
    """[[clamping]]: first line, last line, and where the part lies, by name."""
    found: dict[str, tuple[int, int, Array]] = {}
    for fields in top.subs("clamping"):
        fields.none_but("name", "lines", "part_in_base")
        first, last = fields.numbers("lines", 2).tolist()
        if first != int(first) or last != int(last) or not 0 < first <= last:
            raise fields.wrong("lines", "are not the first and the last of a file's lines")
        if fields.text("name") in found:
            raise fields.wrong("name", "is given twice")
        found[fields.text("name")] = (int(first), int(last), frame(fields.numbers("part_in_base", 6)))
    return found


def _placed(top: Fields, clamping: str | None) -> tuple[Array, dict[str, tuple[int, int]]]:
    """base_T_part as it is in a clamping, and the lines of all. Raises SetupError where the one named is none."""
    found = _clampings(top)
    if not found and clamping is None:
        return frame(top.numbers("part_in_base", 6, [0, 0, 0, 0, 0, 0])), {}
    if clamping not in found:
        raise top.wrong("clamping", f"{clamping or ''!r} is none of: {', '.join(found)}", "name the program's own")
    if "part_in_base" in top:
        raise top.wrong("part_in_base", "stands beside clampings that have their own")
    return found[clamping][2], {name: (first, last) for name, (first, last, _) in found.items()}


def read_job(path: Path, clamping: str | None = None) -> Job:
    """The set-up of a setup.toml, as it is in one of its clampings where it has some. Raises SetupError, naming file and key."""
    top = read_toml(path, SetupError)
    base_T_part, lines = _placed(top, clamping)
    known = ("part_in_base", "clamping", "tool", "part", "stock", "spindle_rpm")
    top.none_but(*known, *_FILES, *_MEASURES, *_LENGTHS, *_OF_OTHERS, *_WORDS)
    if "cutter_compensation" in top and top.text("cutter_compensation") != "wear":
        raise top.wrong("cutter_compensation", "is not 'wear'", 'write "wear", or leave it out')
    speeds = {key: top.maybe(key) for key in (*_MEASURES, "spindle_rpm")}
    lengths = {key: top.maybe(key) for key in _LENGTHS}
    for key, value in (speeds | lengths).items():
        if value is not None and (value < 0.0 or (key in speeds and value == 0.0)):
            raise top.wrong(key, f"is {value:g}, and has to be above 0")
    feed, rapid = (None if (value := speeds[key]) is None else mm_min_to_m_s(value) for key in _MEASURES)
    chord, decimate, clearance = (None if value is None else mm_to_m(value) for value in lengths.values())
    return Job(
        base_T_part=base_T_part,
        lines=lines,
        tools=_tools(top),
        bodies={name: _body(top.sub(name)) for name in ("part", "stock") if name in top},
        feed=feed,
        rapid_feed=rapid,
        spindle_rpm=speeds["spindle_rpm"],
        chord_tolerance=chord,
        decimate=decimate,
        clearance=clearance,
        units=top.text("units") if "units" in top else None,
        dialect=top.text("dialect") if "dialect" in top else None,
        machine=named_by(top),
        wear="cutter_compensation" in top,
    )
