"""What a job reads before it starts: cell, set-up and toolpath, placed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.meshes import body_triangles
from camrob.cell.cell import Cell
from camrob.cell.read_setup import read_setup
from camrob.cell.setup import Setup, ToolSetup
from camrob.errors import InputError
from camrob.findings import Finding
from camrob.jobs.files.granted import assumed_limits, taken_for_granted
from camrob.jobs.files.mounting import MountedTool, change_poses, mounted_tools
from camrob.kinematics.frames import base_T_root
from camrob.program.builder import printed_frames
from camrob.program.language import Language
from camrob.program.process import tool_changes
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.stretches import change_values, started_from
from camrob.redundancy.transfers import build_path
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.rest import in_clamping, rest_from
from camrob.toolpath.toolpath import Toolpath
from camrob.units import mm_min_to_m_s, mm_to_m

__all__ = [
    "CL_SUFFIXES",
    "JobBodies",
    "JobInputs",
    "inputs_of",
    "program_comment",
    "program_name",
    "read_inputs",
    "setup_of",
]

Array = NDArray[np.float64]
CL_SUFFIXES = (".cls", ".apt", ".aptsource", ".ncl", ".nc", ".ngc", ".clt")
"""By which CL files and G code are told from what else lies in a folder of samples."""

_SHOWN = 60  # characters of a name that is refused

# of a set-up that names none: a milling robot's void moves of 100 mm/s, and a clamp's height above the part
RAPID_SPEED = mm_min_to_m_s(6000.0)
CLEARANCE = mm_to_m(50.0)


class JobBodies(TypedDict):
    """Part and stock: triangles (T, 3, 3), m, in the part's frame, None for none, and where that lies, (4, 4)."""

    part_mesh: Array | None
    stock_mesh: Array | None
    base_T_part: Array


@dataclass(frozen=True, slots=True)
class JobInputs:
    """A cell with the job's tool mounted, the set-up, the toolpath, and the whole path in `base`.

    mounted: the tool of each stretch of the path with the cell that holds it; `cell` and `tool` are those of the first.
    urgent: findings to be read before all others. to_change: after this path the tool is changed (`of_stretch`).
    """

    cell: Cell
    setup: Setup
    tool: ToolSetup
    toolpath: Toolpath
    path: ToolPathInBase
    rapid_speed: float
    part: Array | None
    stock: Array | None
    findings: tuple[Finding, ...]
    mounted: tuple[MountedTool, ...]
    urgent: tuple[Finding, ...] = ()
    to_change: bool = False

    @property
    def bodies(self) -> JobBodies:
        """What the job puts among its cell's bodies beside a tool, as `check_collisions` and `nearest_bodies` take it."""
        return JobBodies(part_mesh=self.part, stock_mesh=self.stock, base_T_part=np.asarray(self.setup.base_T_part))

    def of_stretch(self, index: int, last: Array | None) -> JobInputs:
        """The job of one stretch of the path; `last`: axis values (axes,) at the end of the one before it."""
        stretches = self.path.stretches
        if len(stretches) == 1:
            return self
        held = self.mounted[index]
        cell = held.cell if last is None else started_from(held.cell, change_values(held.cell, last))
        path = self.path.part(stretches[index])
        to_change = index + 1 < len(stretches)
        return replace(self, cell=cell, tool=held.tool, path=path, mounted=(held,), to_change=to_change)

    def by_stretch(self) -> list[tuple[Cell, ToolPathInBase]]:
        """Of each stretch between two changes of tools the cell that holds its tool, and its path."""
        return [(held.cell, self.path.part(rows)) for held, rows in zip(self.mounted, self.path.stretches, strict=True)]


def program_comment(inputs: JobInputs, method: str) -> tuple[str, ...]:
    """What stands at a program's head."""
    toolpath = inputs.toolpath
    return (
        f"made by camrob from {toolpath.source} ({toolpath.dialect})",
        f"sha256 {toolpath.sha256}",
        f"cell {inputs.cell.name}, method {method}, {toolpath.points} points",
        *_clamped(inputs.setup),
        *_based(inputs.cell),
    )


def _based(cell: Cell) -> tuple[str, ...]:
    """Which frame of the controller has to agree with which of the cell; nothing of a base on a table that says nothing else."""
    section = cell.controller_section
    if section is None:
        return ()
    if section.own.get("base_measured"):
        return (
            f"base: BASE_DATA[{section.own.get('base_number')}] of the controller, which has to be the cell's base",
        )
    if cell.base_follows_table:
        return () if section.base_frame is None else ("base: the cell's, as it lies in the plate that turns",)
    if section.base_frame is None:
        return ("base: zeros, so the controller's world has to be the cell's",)
    zero = cell.to_q(np.zeros(len(cell.axis_names)))
    root = printed_frames(cell.controller_T_base @ base_T_root(cell, zero))
    shown = " ".join(f"{c} {v + 0.0:.3f}" for c, v in zip("XYZABC", root.round(3).tolist(), strict=True))
    return ("base: the cell's world, as it lies in the controller's world", f"the robot's root there: {shown} (E at 0)")


def _clamped(setup: Setup) -> tuple[str, ...]:
    """What the operator has to know of a program that is one of several."""
    if not setup.clamping:
        return ()
    first, last = setup.spans[setup.clamping]
    return (f"clamping {setup.clamping}, lines {first} to {last}",)


def program_name(clfile: Path, name: str | None, language: Language) -> str:
    """The program's name: given, or made of the CL file's. Raises InputError for one that the language can't carry."""
    if name is None:
        return language.program_name(clfile.name.split(".")[0])
    plain = language.program_name(name)
    if plain != name:
        shown = name if len(name) <= _SHOWN else f"{name[:_SHOWN]}..."
        what = f"--name {shown!r} can't be a {language.title} module"
        if name[:1].isalpha() and language.program_name(f"P_{name}") == f"P_{name}":
            what += f": {language.title} uses that word itself"
        raise InputError(what, hint=f"use {language.naming}, such as {plain}")
    return name


def read_inputs(
    clfile: Path,
    machine: Cell,
    setup: Path | None,
    *,
    dialect: str | None = None,
    units: str | None = None,
    begin: int = 0,
    clamping: str | None = None,
    progress: Share | None = None,
) -> JobInputs:
    """Read all that a job needs beside its cell, `machine`; `begin`: the CL line of the operation from which on, 0: all;
    `clamping`: which one's part of the file, where the set-up has several.

    Raises InputError and its kin, naming file, line and hint.
    """
    job = read_setup(setup_of(clfile, setup), machine, clamping)
    tolerance = {} if job.chord_tolerance is None else {"chord_tolerance": job.chord_tolerance}
    toolpath = read_toolpath(
        clfile,
        dialect=dialect or job.dialect or None,
        units=units or job.units or None,
        feed=job.feed,
        spindle_rpm=job.spindle_rpm,
        diameters={tool.number or 0: tool.diameter for tool in job.tools if tool.diameter},
        wear=job.wear,
        numbers=job.numbers,
        machine_tool=job.machine,
        progress=progress,
        **tolerance,
    )
    if job.clamping:
        try:
            toolpath = in_clamping(toolpath, job.spans, job.clamping)
        except InputError as error:
            raise error.at(clfile) from None
    return inputs_of(rest_from(toolpath, begin) if begin else toolpath, machine, job)


def setup_of(clfile: Path, setup: Path | None) -> Path | None:
    """The set-up: the one named, else setup.toml beside the CL file, else none."""
    beside = clfile.parent / "setup.toml"
    return beside if setup is None and beside.is_file() else setup


def inputs_of(toolpath: Toolpath, machine: Cell, job: Setup) -> JobInputs:
    """A job's inputs from what was read: tools mounted, the path laid into `base`. Raises InputError and its kin."""
    changes = tool_changes(toolpath.regions)
    mounted, remarks = mounted_tools(toolpath.regions, changes, job, machine)
    machine = mounted[0].cell
    base_T_part = np.asarray(job.base_T_part)
    part, stock = (None if body is None else body_triangles(body) for body in (job.part, job.stock))
    bounds = [body.reshape(-1, 3) for body in (part, stock) if body is not None]
    corners = np.concatenate(bounds) @ base_T_part[:3, :3].T + base_T_part[:3, 3] if bounds else None
    clearance = CLEARANCE if job.clearance is None else job.clearance
    path = build_path(
        machine, toolpath, base_T_part, clearance=clearance, bounds=corners, changes=change_poses(mounted, changes)
    )
    rapid_speed = RAPID_SPEED if job.rapid_feed is None else job.rapid_feed
    findings, urgent = (*assumed_limits(machine), *remarks), taken_for_granted(machine, job, toolpath, stock, part)
    return JobInputs(machine, job, mounted[0].tool, toolpath, path, rapid_speed, part, stock, findings, mounted, urgent)
