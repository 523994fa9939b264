"""Which of the set-up's tools the cell holds on each stretch of a path between two changes of tools."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.setup import Setup, ToolSetup
from camrob.cutting.cutter import Cutter
from camrob.errors import SetupError
from camrob.findings import Finding
from camrob.kinematics.frames import base_T_tool
from camrob.program.process import ToolChange
from camrob.redundancy.stretches import change_values
from camrob.toolpath.region import EventKind, Region
from camrob.units import m_to_mm

__all__ = ["MountedTool", "change_poses", "cutter_of", "mounted_loads", "mounted_tools", "one_frame", "tool_for"]

Array = NDArray[np.float64]

SAME_FRAME = 1e-9  # m, and elements of the rotation
_AS_PRINTED = 2e-6  # likewise, of a frame that a program has printed to 3 decimals of a mm and 4 of a degree


@dataclass(frozen=True, slots=True)
class MountedTool:
    """A tool as it is mounted on a stretch of the path, and the cell with it. label: what the CL file calls it."""

    label: str
    tool: ToolSetup
    cell: Cell


def mounted_tools(
    regions: Sequence[Region], changes: Sequence[ToolChange], setup: Setup, machine: Cell
) -> tuple[tuple[MountedTool, ...], tuple[Finding, ...]]:
    """The tool of each stretch between `changes`, and a warning where one tool of the set-up stands for several of the file's.

    Raises SetupError for a tool that the set-up lacks.
    """
    worked = [r for r in regions if len(r)]
    first = next((e for e in worked[0].events if e.kind is EventKind.TOOL_CHANGE), None) if worked else None
    wanted = [(worked[0].tool if worked else 0, "" if first is None else first.text)]
    wanted += [(c.number, c.name) for c in changes if c.region < len(worked)]
    mounted = []
    for number, name in wanted:
        tool = setup.tool(number)
        label = f"tool {number}" if number else name or "tool"
        mounted.append(MountedTool(label, tool, machine.with_tool(np.asarray(tool.flange_T_tool))))
    line = next((c.line for c in changes), 0)
    findings = list(_masses_stated(mounted, setup, line))
    first_T = np.asarray(mounted[0].tool.flange_T_tool)
    alike = [m for m in mounted if np.allclose(m.tool.flange_T_tool, first_T, atol=SAME_FRAME)]
    labels = list(dict.fromkeys(m.label for m in alike))
    if len(labels) < 2:
        return tuple(mounted), tuple(findings)
    text = (
        f"the set-up gives one tool frame for {', '.join(labels)}: measure each of them and give it as [[tool]], "
        "with its number and flange_to_tool"
    )
    return tuple(mounted), (Finding("one-tool-for-several", text, line=line), *findings)


def _masses_stated(mounted: Sequence[MountedTool], setup: Setup, line: int) -> Iterator[Finding]:
    """A warning where several tools are mounted and none states its mass; raises SetupError where some do and others don't."""
    silent = [m.label for m in mounted if m.tool.mass is None]
    stated = [m.label for m in mounted if m.tool.mass is not None]
    if silent and stated:
        what = f"the set-up states a mass for {stated[0]} and none for {silent[0]}, which would run with the load of the other"
        hint = "give mass_kg and center_of_mass_mm for every [[tool]] of the job, or for none"
        raise SetupError(what, hint=hint, path=setup.path)
    if _load_of_controller(mounted) and len({m.label for m in mounted}) > 1:
        text = (
            "load_measured leaves the load of all tools to one row of the controller's LOAD_DATA, that of tool_number"
        )
        yield Finding("load-not-switched", f"{text}: leave it out if their masses differ", line=line)
    elif silent and len({m.label for m in mounted}) > 1:
        text = (
            "the set-up states no mass of the tools: the controller's load data stay those that were set before, for each of "
            f"{', '.join(dict.fromkeys(silent))}; give mass_kg and center_of_mass_mm of every [[tool]] if their masses differ"
        )
        yield Finding("load-not-switched", text, line=line)


def mounted_loads(mounted: Sequence[MountedTool]) -> Array | None:
    """(stretches, 7) kg, X, Y, Z in `flange` in mm, and kg m^2 about X, Y, Z, of each stretch's tool; None where the set-up
    states none, and where the cell leaves the load to the controller.
    """
    if any(m.tool.mass is None for m in mounted) or _load_of_controller(mounted):
        return None
    return np.array(
        [[m.tool.mass, *m_to_mm(np.asarray(m.tool.center_of_mass)), *m.tool.inertia] for m in mounted], np.float64
    )


def _load_of_controller(mounted: Sequence[MountedTool]) -> bool:
    """Whether the controller's own load data hold, which it measured."""
    section = mounted[0].cell.controller_section
    return section is not None and section.own.get("load_measured") is True


def change_poses(mounted: Sequence[MountedTool], changes: Sequence[ToolChange]) -> dict[int, Array]:
    """base_T_tool (4, 4) of each stretch's tool where it is mounted, by the region that the stretch begins with."""
    poses = {}
    for change, after in zip(changes, mounted[1:], strict=False):
        cell = after.cell
        values = change_values(cell, cell.to_axis_values(cell.q_home))
        poses[change.region] = np.asarray(base_T_tool(cell, cell.to_q(values)))
    return poses


def one_frame(mounted: Sequence[MountedTool], setup: Setup, what: str) -> None:
    """Raise SetupError, saying what can't be done, where the stretches' tools have different frames."""
    first = mounted[0]
    for other in mounted[1:]:
        if not np.allclose(other.tool.flange_T_tool, first.tool.flange_T_tool, atol=SAME_FRAME):
            raise SetupError(
                f"{first.label} and {other.label} have different frames, and {what}",
                hint="give the operations of each tool by themselves",
                path=setup.path,
            )


def tool_for(cell: Cell, setup: Setup) -> ToolSetup:
    """The set-up's tool that a program has mounted in a cell, known by its frame; the only one is not asked for its frame.

    Raises SetupError where none of several has that frame, or tools that have it cut differently.
    """
    if len(setup.tools) == 1:
        return setup.tools[0]
    frame = np.asarray(cell.flange_T_tool)
    alike = [t for t in setup.tools if np.allclose(t.flange_T_tool, frame, rtol=0.0, atol=_AS_PRINTED)]
    x, y, z = m_to_mm(frame[:3, 3]).tolist()
    if not alike:
        what = f"none of its tools has the program's frame with X {x:.3f}, Y {y:.3f}, Z {z:.3f}"
        raise SetupError(what, hint="give the set-up that the program was posted with", path=setup.path)
    if len({(t.diameter, t.corner, t.length, t.holder, t.runout) for t in alike}) > 1:
        named = ", ".join(t.name or str(t.number) for t in alike)
        what = f"{named} have one frame, and nothing else in a program tells them apart"
        raise SetupError(what, hint="measure each of them: flange_to_tool of its own", path=setup.path)
    return alike[0]


def cutter_of(tool: ToolSetup, setup: Setup) -> Cutter | None:
    """The cutter that a tool of a set-up is; None where that does not say its shape. Raises SetupError for a shape of none."""
    if not tool.diameter or tool.corner is None or not tool.length:
        return None
    try:
        return Cutter(0.5 * tool.diameter, tool.corner, tool.length)
    except ValueError:
        what = "has a corner_radius_mm that no cutter has"
        raise SetupError(what, hint="give half the diameter at most", path=setup.path) from None
