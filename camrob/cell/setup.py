"""How a job is set up on a cell: where the part lies, which tools are mounted, what the CL file leaves open."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import SetupError
from camrob.frozen import digest, locked
from camrob.machine_tool import MachineTool

__all__ = ["Body", "Clamping", "Setup", "ToolSetup"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ToolSetup:
    """A tool as it is mounted. `number` is None for one that stands for whatever number the CL file names.

    flange_T_tool: (4, 4), `$TOOL`. corner: m, the radius of the edge's rounding (of a ball half the diameter), None where not
    given. diameter, length (from the tip to where the holder begins): m, 0.0 where not given. holder: diameters and lengths of
    its cylinders, from there on up, m, () where not given. runout: m, as a dial gauge reads it in a turn of the spindle.
    mass: kg of all that hangs on the flange with this tool, None where not given; center_of_mass: (3,) its centre in `flange`, m.
    inertia: (3,) kg m^2, its moments about the flange's directions through that centre, zeros where not given.
    """

    number: int | None
    name: str
    flange_T_tool: Array
    diameter: float = 0.0
    length: float = 0.0
    corner: float | None = None
    holder: tuple[tuple[float, float], ...] = ()
    runout: float = 0.0
    mass: float | None = None
    center_of_mass: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "flange_T_tool", locked(self.flange_T_tool, shape=(4, 4), name="flange_T_tool"))
        object.__setattr__(self, "center_of_mass", locked(self.center_of_mass, shape=(3,), name="center_of_mass"))
        object.__setattr__(self, "inertia", locked(self.inertia, shape=(3,), name="inertia"))


@dataclass(frozen=True, slots=True)
class Body:
    """The part or the stock, for collision checks, in the frame `part`: a mesh file, or else a box.

    scale: metres per unit of the mesh. lower, upper: (3,) corners of the box, m (zeros for a mesh).
    """

    mesh: Path | None
    scale: float = 1.0
    lower: Array = field(default_factory=lambda: np.zeros(3))
    upper: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for name in ("lower", "upper"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(3,), name=name))


@dataclass(frozen=True, slots=True)
class Clamping:
    """One of the ways in which a part lies while it is worked from several sides.

    base_T_part: (4, 4), as it lies then. first, last: of the CL file's lines, what is done in it.
    """

    name: str
    base_T_part: Array
    first: int
    last: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_part", locked(self.base_T_part, shape=(4, 4), name="base_T_part"))


@dataclass(frozen=True, slots=True)
class Setup:
    """What setup.toml says, in SI; a value that it leaves out is None or empty, and then the job's own default holds.

    path: the file, None where there is none. base_T_part: (4, 4), the CL data's frame in `base`. tools: one or more,
    the cell's own where the file names none. units: "mm" or "inch", overrules the CL file; dialect: likewise.
    rapid_feed, feed: m/s, the latter where the CL file is silent. spindle_rpm: rev/min, where the CL file starts no spindle
    before its first cut, or without a speed (0: none). clearance: m, how far void motions lift the tool along its axis.
    chord_tolerance: m, for arcs and curves that become points. wear: paths with cutter radius compensation are the tool centre's.
    decimate: m, points nearer than this to their neighbours' chord are left out (0: none). tolerance: m, that the machine's
    speed may carry the tool off across its way. machine: whose own axes a G-code program names. part, stock: bodies for
    collision checks. clampings: of a part that is worked from several sides, by the CL file's lines; clamping: the name of that
    which `base_T_part` is of. unplaced, toolless: the file says nothing of where the part lies, of any tool.

    Keys of the file (none is needed), lengths in mm and angles in degrees:

        part_in_base = [X, Y, Z, A, B, C]
        units = "mm"                   dialect = "nx-clsf"
        rapid_feed_mm_min = 6000       feed_mm_min = 900        spindle_rpm = 12000
        clearance_mm = 50              chord_tolerance_mm = 0.01        decimate_mm = 0
        tolerance_mm = 0.05            with a diagnosis of the machine: the feed is lowered where its speed does more
        cutter_compensation = "wear"   G41, G42, RL, RR, CUTCOM: the path is the tool centre's, offsets hold wear only
        machine = "mill.toml"          G-code in a machine's own axes: the file beside this one that describes them
        [tool]                         one tool for all numbers; or [[tool]] for each, with number = 1
        name = "ball 6"
        flange_to_tool = [X, Y, Z, A, B, C]      the cell's `$TOOL` where it is left out
        diameter_mm = 6                length_mm = 45           corner_radius_mm = 3      for `camrob predict`: 0 of a flat one
        holder_mm = [[40, 30], [63, 60]]         likewise: diameter and length of its cylinders, from the cutter up
        runout_mm = 0.02               likewise: what a dial gauge at the cutter reads in a turn of the spindle
        mass_kg = 38.5                 of spindle, holder and tool together: the program then sets the controller's load data
        center_of_mass_mm = [X, Y, Z]            its centre in the flange's frame; both or neither, for every tool or for none
        inertia_kg_m2 = [JX, JY, JZ]             its moments through that centre about the flange's directions; a point without it
        gauge_length_mm = 153.2        from the spindle's gauge line to the tip, in place of flange_to_tool
        tool_library = "tools.csv"     above all tables: a CAM system's tools, a file beside this one
        flange_to_gauge_line = [X, Y, Z, A, B, C]      likewise: the spindle's gauge line, z from the tip to the spindle
        [part]                         likewise [stock]: in the CL data's frame
        mesh = "part.stl"              a file beside setup.toml, with unit = "mm" (the default), "inch" or "m"
        box_mm = [X0, Y0, Z0, X1, Y1, Z1]        or a box by its two corners
        [[clamping]]                   instead of part_in_base, for each side from which the part is worked: a program each
        name = "top"                   lines = [1, 340]         part_in_base = [X, Y, Z, A, B, C]
    """

    path: Path | None
    base_T_part: Array
    tools: tuple[ToolSetup, ...]
    units: str = ""
    dialect: str = ""
    rapid_feed: float | None = None
    feed: float | None = None
    spindle_rpm: float | None = None
    clearance: float | None = None
    chord_tolerance: float | None = None
    decimate: float = 0.0
    tolerance: float | None = None
    wear: bool = False
    machine: MachineTool | None = None
    part: Body | None = None
    stock: Body | None = None
    clampings: tuple[Clamping, ...] = ()
    clamping: str = ""
    unplaced: bool = False
    toolless: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_part", locked(self.base_T_part, shape=(4, 4), name="base_T_part"))

    def tool(self, number: int = 0) -> ToolSetup:
        """The tool that is mounted for a number of the CL file (0: it names none).

        Raises SetupError where tools are numbered and this one is not among them.
        """
        for tool in self.tools:
            if tool.number is None or tool.number == number or (number == 0 and len(self.tools) == 1):
                return tool
        known = ", ".join(str(t.number) for t in self.tools)
        what = f"tool {number} is not set up" if number else "the CL file names no tool and several are set up"
        raise SetupError(what, hint=f"add it as [[tool]]; there are: {known}", path=self.path)

    @property
    def spans(self) -> dict[str, tuple[int, int]]:
        """First and last of the CL file's lines by the clamping in which they are done."""
        return {clamping.name: (clamping.first, clamping.last) for clamping in self.clampings}

    @property
    def numbers(self) -> dict[str, int]:
        """Numbers of tools by their names in lower case, of names that one tool has alone."""
        named = [(tool.name.strip().casefold(), tool.number) for tool in self.tools if tool.name and tool.number]
        return {name: number for name, number in named if sum(other == name for other, _ in named) == 1}

    @property
    def digest(self) -> str:
        """What the placement, tools and choices are; meshes by their names."""
        tools = [(t.number, t.flange_T_tool, t.diameter, t.length) for t in self.tools]
        cut = [(t.number, t.corner, t.holder, t.runout) for t in self.tools if t.holder or t.runout]
        loads = [
            (t.number, t.mass, t.center_of_mass, *((t.inertia,) if t.inertia.any() else ()))
            for t in self.tools
            if t.mass is not None
        ]
        bodies = [(str(b.mesh), b.scale, b.lower, b.upper) for b in (self.part, self.stock) if b is not None]
        choices = (self.units, self.dialect, self.rapid_feed, self.feed, self.spindle_rpm, self.clearance)
        kept = (
            *((self.wear,) if self.wear else ()),
            *(() if self.machine is None else ("machine", *self.machine.key)),
            *(() if self.tolerance is None else ("tolerance", self.tolerance)),
            *(word for pair in sorted(self.numbers.items()) for word in pair),
        )
        nested = (x for group in (*tools, *cut, *loads, *bodies) for x in group)
        return digest(self.base_T_part, *choices, self.chord_tolerance, self.decimate, *kept, *nested)
