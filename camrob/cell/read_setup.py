"""Reading a setup.toml, checked key by key, edge units to SI."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.setup import Body, Clamping, Setup, ToolSetup
from camrob.cell.tool_library import read_tool_library
from camrob.errors import SetupError
from camrob.machine_tool import FEEDS, Feed, MachineTool, RotaryAxis
from camrob.se3 import frame_from_mm_deg, pose
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import INCH_MM, m_to_mm, mm_min_to_m_s, mm_to_m

__all__ = ["read_clampings", "read_machine_tool", "read_setup"]

Array = NDArray[np.float64]

FASTEST_MM_MIN = 180_000.0  # no controller's `$VEL.CP` goes beyond 3 m/s
SLOWEST_MM_MIN = 0.06  # the least that six decimals of `$VEL.CP` can print
HEAVIEST_KG = 1000.0  # no arm that mills carries more
FARTHEST_MASS_MM = 5000.0  # nor farther off its flange
LARGEST_INERTIA = 1000.0  # kg m^2: a ton, a metre off
FARTHEST_MM = 1e5  # a frame that lies farther off is a slip of units
LAST_LINE = 10**9  # no CL file has more lines
FARTHEST_AXIS_MM = 20_000.0  # no machine tool's rotary axis lies farther from the part
LONGEST_MM = 2000.0  # no tool is longer
WIDEST_MM = 2000.0  # of a holder: no spindle's is wider or longer
_ROUNDING = 1e-3  # of a ball's radius, given to a few digits
MESH_SUFFIXES = (".stl", ".ply", ".obj", ".off")
_MESH_UNITS = {"mm": mm_to_m(1.0), "inch": mm_to_m(INCH_MM), "m": 1.0}


def read_setup(path: str | Path | None, cell: Cell, clamping: str | None = None) -> Setup:
    """The set-up in a file: where the part lies, the tools, and what is to be taken where the CL file is silent.

    Args:
        path: the .toml; None for the part's frame at `base` and the cell's own tool.
        cell: the cell that it is for.
        clamping: of a part that is worked from several sides, the [[clamping]] that the set-up is asked for.

    Returns:
        The set-up, in SI.

    Raises:
        SetupError: what is wrong, by file and key.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> setup = camrob.read_setup(Path("toolpaths/engraving/setup.toml"), cell)
        >>> setup.tools[0].diameter
        0.003
    """
    own_tool = ToolSetup(None, "", cell.flange_T_tool)
    if path is None:
        if clamping is not None:
            raise SetupError(f"no set-up says what clamping {clamping!r} is", hint="name the set-up, by --setup")
        return Setup(None, np.eye(4), (own_tool,))
    path = Path(path)
    data = read_toml(path, SetupError)
    if "schema" in data and "kinematics" in data:
        raise SetupError(
            "is a cell, not a set-up", hint="name it behind --cell, and the job's setup.toml here", path=path
        )
    table = TableReader(data, path, error=SetupError)
    part_in_base = _frame(table, "part_in_base")
    clampings = _clampings(table)
    held = _held(clampings, clamping, path)
    if held is not None:
        if part_in_base is not None:
            raise table.fail("part_in_base", "stands beside [[clamping]]", "give each clamping its own, and no other")
        part_in_base = np.asarray(held.base_T_part)
    tools = _tools(table, data.get("tool"), cell)
    setup = Setup(
        path=path,
        base_T_part=np.eye(4) if part_in_base is None else part_in_base,
        tools=tools or (own_tool,),
        units=table.text("units", choices=("mm", "inch")) if "units" in table else "",
        dialect=_dialect(table),
        rapid_feed=_number(table, "rapid_feed_mm_min", 1.0, FASTEST_MM_MIN, mm_min_to_m_s),
        feed=_number(table, "feed_mm_min", SLOWEST_MM_MIN, FASTEST_MM_MIN, mm_min_to_m_s),
        spindle_rpm=_number(table, "spindle_rpm", 0.0, 1e6, float),
        clearance=_number(table, "clearance_mm", 0.0, 5000.0, mm_to_m),
        chord_tolerance=_number(table, "chord_tolerance_mm", 1e-5, 10.0, mm_to_m),
        wear="cutter_compensation" in table and table.text("cutter_compensation", choices=("wear",)) == "wear",
        decimate=_number(table, "decimate_mm", 0.0, 10.0, mm_to_m) or 0.0,
        tolerance=_number(table, "tolerance_mm", 1e-3, 10.0, mm_to_m),
        machine=_machine(table),
        part=_body(table, "part"),
        stock=_body(table, "stock"),
        clampings=clampings,
        clamping="" if held is None else held.name,
        unplaced=part_in_base is None,
        toolless=not tools,
    )
    table.finish()
    return setup


def read_clampings(path: Path | None) -> tuple[str, ...]:
    """The names of the [[clamping]]s of a set-up's file, in its order. Raises SetupError."""
    if path is None:
        return ()
    return tuple(held.name for held in _clampings(TableReader(read_toml(path, SetupError), path, error=SetupError)))


def _held(clampings: tuple[Clamping, ...], name: str | None, path: Path) -> Clamping | None:
    """The clamping that is asked for. Raises SetupError where there are some and none is named, or there is no such one."""
    known = ", ".join(held.name for held in clampings)
    if name is None:
        if clampings:
            what = f"the part is worked in {len(clampings)} clampings and none is named"
            raise SetupError(
                what, hint=f"name one of {known} where --clamping can be, or give a set-up of it alone", path=path
            )
        return None
    found = next((held for held in clampings if held.name == name), None)
    if found is None:
        raise SetupError(f"has no clamping {name[:40]!r}", hint=f"there are: {known or 'none'}", path=path)
    return found


def _clampings(parent: TableReader) -> tuple[Clamping, ...]:
    """All [[clamping]]s: their lines may not meet."""
    found: list[Clamping] = []
    for table in parent.tables("clamping"):
        name = table.text("name")
        if not re.fullmatch(r"[A-Za-z0-9]{1,8}", name):
            raise table.fail("name", f"is {name[:40]!r}", "give 1 to 8 letters and digits: it ends the program's name")
        if any(name.casefold() == other.name.casefold() for other in found):
            raise table.fail("name", f"{name!r} appears twice", "give every clamping a name of its own")
        lines = table.vector("lines", 2)
        if np.any(lines != np.round(lines)) or not 1 <= lines[0] <= lines[1] <= LAST_LINE:
            raise table.fail("lines", "are no lines of a file", "give the first and the last one: [1, 340]")
        frame = _frame(table, "part_in_base")
        if frame is None:
            raise table.fail("part_in_base", "is missing", "give [X, Y, Z, A, B, C] of the part as it lies then")
        table.finish()
        found.append(Clamping(name, frame, int(lines[0]), int(lines[1])))
    for before, after in pairwise(sorted(found, key=lambda held: held.first)):
        if after.first <= before.last:
            what = f"lines {after.first}-{min(before.last, after.last)} lie in two, {before.name} and {after.name}"
            raise parent.fail("clamping", what, "give every line to one")
    return tuple(found)


def _number(table: TableReader, key: str, lower: float, upper: float, to_si: Callable[[float], float]) -> float | None:
    """A number that may be left out."""
    return to_si(table.number(key, lower=lower, upper=upper)) if key in table else None


def _frame(table: TableReader, key: str) -> Array | None:
    """A pose (4, 4) that may be left out."""
    if key not in table:
        return None
    xyzabc_mm_deg = table.vector(key, 6)
    if np.max(np.abs(xyzabc_mm_deg[:3])) > FARTHEST_MM:
        raise table.fail(key, f"lies more than {FARTHEST_MM:g} mm off", "give X, Y, Z in mm")
    if np.max(np.abs(xyzabc_mm_deg[3:])) > 360.0:
        raise table.fail(key, "has an angle beyond 360", "give A, B, C in degrees")
    return frame_from_mm_deg(xyzabc_mm_deg)


def _dialect(table: TableReader) -> str:
    """The dialect's name; whether there is such a reader is the toolpath's business."""
    if "dialect" not in table:
        return ""
    name = table.text("dialect")
    if not re.fullmatch(r"[a-z0-9][a-z0-9_-]{0,31}", name):
        raise table.fail("dialect", f"is {name[:40]!r}", "give a name such as nx-clsf")
    return name


def _machine(table: TableReader) -> MachineTool | None:
    """The machine tool that a program is for, in a file beside the set-up; None where it names none."""
    path = _beside(table, "machine")
    return None if path is None else read_machine_tool(path)


def _beside(table: TableReader, key: str) -> Path | None:
    """The file beside the set-up that a key names; None where it names none."""
    if key not in table:
        return None
    name = table.text(key)
    if Path(name).name != name or not os.path.isfile(table.path.parent / name):
        raise table.fail(key, f"{name[:60]!r} is not a file beside this one", "put it there, name it without a path")
    return table.path.parent / name


def _tools(table: TableReader, raw: Any, cell: Cell) -> tuple[ToolSetup, ...]:
    """[tool], or all [[tool]]s over the tools of the library, () where there are none. raw: what stands behind `tool`."""
    gauge = _frame(table, "flange_to_gauge_line")
    library = _beside(table, "tool_library")
    rows = {} if library is None else read_tool_library(library)
    if gauge is None:
        for row in rows.values():
            row.table.pop("gauge_length_mm", None)
    if raw is not None and not isinstance(raw, list):
        if library is not None:
            raise table.fail("tool", "stands for all numbers, beside tool_library", "make it [[tool]], with its number")
        if isinstance(raw, dict) and "number" in raw:
            raise table.fail("tool", "stands for all numbers, and has one", "make it [[tool]], or leave number out")
        return (_tool(table.table("tool"), cell, gauge, numbered=False),)
    tools: dict[int | None, ToolSetup] = {}
    for number, row in rows.items():
        part = TableReader(row.table, library or table.path, error=SetupError, line=row.line)
        tools[number] = _tool(part, cell, gauge, numbered=True)
    seen = set()
    for part, said in zip(table.tables("tool"), raw or (), strict=True):
        under = rows.get(said.get("number")) if library is not None else None
        whole = (
            part
            if under is None
            else TableReader(under.table | said, table.path, part.key, error=SetupError, spot=part.spot)
        )
        tool = _tool(whole, cell, gauge, numbered=True)
        if tool.number in seen:
            raise part.fail("number", f"{tool.number} appears twice", "give every tool a number of its own")
        seen.add(tool.number)
        tools[tool.number] = tool
    return tuple(tools.values())


def _tool(table: TableReader, cell: Cell, gauge: Array | None, *, numbered: bool) -> ToolSetup:
    """One [tool] or [[tool]]. gauge: (4, 4), flange_T_gauge_line, None where it isn't told."""
    flange_T_tool = _frame(table, "flange_to_tool")
    out = _number(table, "gauge_length_mm", 1e-3, LONGEST_MM, mm_to_m)
    if flange_T_tool is None and out is not None:
        if gauge is None:
            raise table.fail("gauge_length_mm", "is from the gauge line, which isn't told", "give flange_to_gauge_line")
        flange_T_tool = gauge @ pose(np.eye(3), [0.0, 0.0, -out])
    mass, center, inertia = _load(table)
    tool = ToolSetup(
        number=table.integer("number", lower=1, upper=10**6) if numbered else None,
        name=table.text("name") if "name" in table else "",
        flange_T_tool=cell.flange_T_tool if flange_T_tool is None else flange_T_tool,
        diameter=_number(table, "diameter_mm", 1e-3, 1000.0, mm_to_m) or 0.0,
        length=_number(table, "length_mm", 1e-3, 2000.0, mm_to_m) or 0.0,
        corner=_number(table, "corner_radius_mm", 0.0, 500.0, mm_to_m),
        holder=_holder(table),
        runout=_number(table, "runout_mm", 0.0, 1.0, mm_to_m) or 0.0,
        mass=mass,
        center_of_mass=center,
        inertia=inertia,
    )
    table.finish()
    if tool.diameter and (tool.corner or 0.0) > 0.5 * tool.diameter * (1.0 + _ROUNDING):
        edge, width = m_to_mm(tool.corner or 0.0), m_to_mm(tool.diameter)
        what = f"is {edge:.6g}, more than half of diameter_mm = {width:.6g}"
        raise table.fail("corner_radius_mm", what, "give half the diameter for a ball, 0 for a flat end")
    return tool


def _holder(table: TableReader) -> tuple[tuple[float, float], ...]:
    """Diameters and lengths (m) of a holder's cylinders, () where there are none."""
    if "holder_mm" not in table:
        return ()
    pairs = table.vectors("holder_mm", 2)
    if not np.all((pairs > 0.0) & (pairs < WIDEST_MM)):
        raise table.fail(
            "holder_mm", f"has a number that is not between 0 and {WIDEST_MM:g}", "give [[diameter, length], ...]"
        )
    return tuple((float(d), float(h)) for d, h in mm_to_m(pairs))


def _load(table: TableReader) -> tuple[float | None, Array, Array]:
    """A tool's mass, kg, its centre (3,) in `flange`, m, and moments (3,), kg m^2; None and zeros where the file states none."""
    if "mass_kg" not in table and "center_of_mass_mm" not in table:
        if "inertia_kg_m2" in table:
            raise table.fail("inertia_kg_m2", "stands without mass_kg", "give mass_kg and center_of_mass_mm beside it")
        return None, np.zeros(3), np.zeros(3)
    mass = table.number("mass_kg", lower=1e-3, upper=HEAVIEST_KG)
    center = table.vector("center_of_mass_mm", 3)
    if np.max(np.abs(center)) > FARTHEST_MASS_MM:
        raise table.fail(
            "center_of_mass_mm", f"lies more than {FARTHEST_MASS_MM:g} mm off the flange", "give X, Y, Z in mm"
        )
    inertia = table.vector("inertia_kg_m2", 3) if "inertia_kg_m2" in table else np.zeros(3)
    if (
        not np.all((inertia >= 0.0) & (2.0 * inertia <= inertia.sum() * (1.0 + _ROUNDING)))
        or inertia.max() > LARGEST_INERTIA
    ):
        what = "are no moments of a body: none below 0, none above the other two together, in kg m^2"
        raise table.fail("inertia_kg_m2", what, "give [JX, JY, JZ] as the flange's directions see them")
    return mass, mm_to_m(center), inertia


def _body(parent: TableReader, key: str) -> Body | None:
    """[part] or [stock]: a mesh beside the file, or a box."""
    if key not in parent:
        return None
    table = parent.table(key)
    if ("mesh" in table) == ("box_mm" in table):
        raise table.fail("mesh", "and box_mm are both given or both missing", "give one of the two")
    if "box_mm" in table:
        corners = mm_to_m(table.vector("box_mm", 6))
        body = Body(None, 1.0, corners[:3], corners[3:])
        if not np.all(body.lower < body.upper):
            raise table.fail(
                "box_mm", "has no volume", "give the lower corner, then the upper one: X0, Y0, Z0, X1, Y1, Z1"
            )
    else:
        name = table.text("mesh")
        inside = not Path(name).is_absolute() and ".." not in Path(name).parts and "\\" not in name
        if not inside or not os.path.isfile(table.path.parent / name):
            raise table.fail(
                "mesh", f"{name[:60]!r} is not a file beside this one", "put the mesh there, name it without a path"
            )
        if Path(name).suffix.lower() not in MESH_SUFFIXES:
            raise table.fail("mesh", f"{name[:60]!r} is not a mesh", f"use one of {', '.join(MESH_SUFFIXES)}")
        unit = table.text("unit", choices=tuple(_MESH_UNITS)) if "unit" in table else "mm"
        body = Body(table.path.parent / name, _MESH_UNITS[unit])
    table.finish()
    return body


def read_machine_tool(path: Path) -> MachineTool:
    """The machine in a file. Raises SetupError by file and key.

    Keys, lengths in mm (docs/reference/controls.md says how to find them):

        feed = "linear"                what F counts where a block turns axes: "linear" X, Y and Z alone; "all": degrees, too
        [[table]]                      an axis that carries the part; several from the machine's bed on
        word = "A"
        direction = [-1, 0, 0]         about which a positive word turns what the axis carries, right-handedly
        point_mm = [0, 0, -120]        a point of the axis from the program's zero
        [[head]]                       likewise what carries the tool; its point from the spindle's gauge line
        lengths_mm = [[1, 120.5]]      with a head: tool number (0: any) and its length from the gauge line
    """
    table = TableReader(read_toml(path, SetupError), path, error=SetupError)
    feed: Feed = ""
    if "feed" in table:
        feed = "all" if table.text("feed", choices=FEEDS) == "all" else "linear"
    parts, heads = table.tables("table"), table.tables("head")
    lengths = _lengths(table)
    machine = MachineTool(tuple(map(_rotary_axis, parts)), tuple(map(_rotary_axis, heads)), lengths, feed)
    table.finish()
    axes = (*machine.table, *machine.head)
    if not axes:
        raise table.fail(
            "table", "is missing, and so is head", "name the machine's rotary axes as [[table]] or [[head]]"
        )
    if len(machine.words) < len(axes):
        raise table.fail("table", "and head name a word twice", "give every rotary axis the letter of its own")
    if machine.head and not lengths:
        raise table.fail(
            "lengths_mm", "is missing beside a head", "give [[tool number, length from the gauge line], ...]"
        )
    return machine


def _rotary_axis(table: TableReader) -> RotaryAxis:
    """One [[table]] or [[head]]."""
    word = table.text("word", choices=("A", "B", "C"))
    direction = table.vector("direction", 3)
    size = float(np.linalg.norm(direction))
    if not 1e-3 < size < 1e3:
        raise table.fail("direction", "has no direction", "give a vector such as [0, 0, 1]")
    point_mm = table.vector("point_mm", 3)
    if np.max(np.abs(point_mm)) > FARTHEST_AXIS_MM:
        raise table.fail("point_mm", f"lies more than {FARTHEST_AXIS_MM:g} mm off", "give X, Y, Z in mm")
    table.finish()
    return RotaryAxis(word, direction / size, mm_to_m(point_mm))


def _lengths(table: TableReader) -> dict[int, float]:
    """Tools' lengths (m) by their numbers."""
    if "lengths_mm" not in table:
        return {}
    rows = table.vectors("lengths_mm", 2)
    numbers = rows[:, 0]
    if np.any(numbers != np.floor(numbers)) or np.any(numbers < 0) or len(np.unique(numbers)) < len(numbers):
        raise table.fail("lengths_mm", "has a tool number that is not whole, or twice", "give [[number, length], ...]")
    if np.any(rows[:, 1] <= 0.0) or np.any(rows[:, 1] > LONGEST_MM):
        raise table.fail("lengths_mm", f"has a length that is not between 0 and {LONGEST_MM:g}", "give lengths in mm")
    return {int(number): float(mm_to_m(length)) for number, length in rows}
