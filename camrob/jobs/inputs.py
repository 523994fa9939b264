"""What a job reads before it starts: cell, set-up and toolpath, placed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.cell.setup import Setup, ToolSetup
from camrob.check.meshes import body_triangles
from camrob.errors import InputError, SetupError
from camrob.issues import Finding, Severity
from camrob.post.krl_text import krl_name
from camrob.resolve.links import build_path
from camrob.resolve.path import ToolPathInBase
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.toolpath import Toolpath
from camrob.units import mm_min_to_m_s, mm_to_m

__all__ = ["JobInputs", "program_name", "read_inputs"]

Array = NDArray[np.float64]

RAPID_SPEED = mm_min_to_m_s(6000.0)
CLEARANCE = mm_to_m(50.0)


@dataclass(frozen=True, slots=True)
class JobInputs:
    """A cell with the job's tool mounted, the set-up, the toolpath, and the whole path in `base`."""

    cell: Cell
    setup: Setup
    tool: ToolSetup
    toolpath: Toolpath
    path: ToolPathInBase
    rapid_speed: float
    part: Array | None
    stock: Array | None
    findings: tuple[Finding, ...]


def program_name(clfile: Path, name: str | None) -> str:
    """The program's name: given, or made of the CL file's. Raises InputError for a given name that KRL can't carry."""
    if name is None:
        return krl_name(clfile.name.split(".")[0])
    if krl_name(name) != name:
        what = f"--name {name!r} can't be a KRL module"
        raise InputError(what, cure=f"use letters, digits and _, 24 at most, such as {krl_name(name)}")
    return name


def read_inputs(
    clfile: Path,
    cell: Path,
    setup: Path | None,
    *,
    dialect: str | None = None,
    units: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> JobInputs:
    """Read all that a job needs. Raises InputError and its kin, naming file, line and cure."""
    machine = read_cell(cell)
    if setup is None and (clfile.parent / "setup.toml").is_file():
        setup = clfile.parent / "setup.toml"
    job = read_setup(setup, machine)
    tolerance = {} if job.chord_tolerance is None else {"chord_tolerance": job.chord_tolerance}
    toolpath = read_toolpath(
        clfile,
        dialect=dialect or job.dialect or None,
        units=units or job.units or None,
        progress=progress,
        **tolerance,
    )
    tool = _one_tool(toolpath, job)
    machine = machine.with_tool(np.asarray(tool.flange_T_tool))
    base_T_part = np.asarray(job.base_T_part)
    part, stock = (None if body is None else body_triangles(body) for body in (job.part, job.stock))
    bounds = [body.reshape(-1, 3) for body in (part, stock) if body is not None]
    corners = np.concatenate(bounds) @ base_T_part[:3, :3].T + base_T_part[:3, 3] if bounds else None
    clearance = CLEARANCE if job.clearance is None else job.clearance
    path = build_path(machine, toolpath, base_T_part, clearance=clearance, bounds=corners)
    rapid_speed = RAPID_SPEED if job.rapid_feed is None else job.rapid_feed
    return JobInputs(machine, job, tool, toolpath, path, rapid_speed, part, stock, _assumed(machine))


def _one_tool(toolpath: Toolpath, setup: Setup) -> ToolSetup:
    """The tool of the whole toolpath. Raises SetupError where its operations need tools of different lengths."""
    numbers = list(dict.fromkeys(r.tool for r in toolpath.regions if len(r)))
    tools = [setup.tool(number) for number in numbers] or [setup.tool(0)]
    first = tools[0]
    for number, tool in zip(numbers, tools, strict=False):
        if not np.allclose(tool.flange_T_tool, first.flange_T_tool, atol=1e-9):
            raise SetupError(
                f"tools {numbers[0]} and {number} have different frames, and a program has one $TOOL",
                cure="post the operations of each tool by themselves",
                path=setup.path,
            )
    return first


def _assumed(cell: Cell) -> tuple[Finding, ...]:
    """One warning that names the limits that are only assumed."""
    assumed = [re.fullmatch(r"joint\[(\w+)\]\.limits\..*", key) for key, s in cell.provenance.items() if s == "assumed"]
    names = sorted({match[1] for match in assumed if match})
    if not names:
        return ()
    text = f"limits of {', '.join(names)} are assumed, not taken from the machine: check them against its data sheets"
    return (Finding("assumed-limits", text, Severity.WARNING),)
