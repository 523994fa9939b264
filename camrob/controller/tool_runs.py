"""A program that changes its tool, as programs of one tool each; between two of them the robot stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.controller.replay import Replay
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import ProgramText
from camrob.runs import runs_of

__all__ = ["ToolRun", "tool_runs"]

ToolRun = tuple[ProgramText, Cell, NDArray[np.int64]]
"""A program, the cell with its tool, and (N,) the whole program's row for each of its own."""

_COLUMNS = (
    "kind",
    "pose",
    "axes",
    "external",
    "status",
    "turn",
    "circular_angle_deg",
    "speed",
    "acceleration",
    "blend_mm",
    "blend",
    "wait",
    "file",
    "line",
    "tool",
    "base",
)


def tool_runs(program: ProgramText, replayed: Replay) -> list[ToolRun]:
    """The program between its changes of tools; itself alone where there is none.

    Each begins where the one before it ended, by its axes: the last row of that one, with the tool of its own. What is waited
    before a change counts with what follows it, and how long the change itself takes no program says. Where one begins counts as
    the row behind the change.
    """
    mounted = np.asarray(replayed.mounted)
    if not replayed.others:
        return [(program, replayed.cell, np.arange(len(program)))]
    runs = []
    for run in runs_of(mounted):
        begin, stop = run.start, run.stop
        cell = replayed.cells[int(mounted[begin])]
        rows = np.arange(max(begin - 1, 0), stop)
        own: dict[str, Any] = {name: np.array(getattr(program, name)[rows]) for name in _COLUMNS}
        if begin:
            _stands(own, program, replayed, begin)
        last = stop == len(program)
        text = replace(program, **own, actions=(), findings=(), final_wait=program.final_wait if last else 0.0)
        runs.append((text, cell, np.maximum(rows, begin)))
    return runs


def _stands(own: dict[str, Any], program: ProgramText, replayed: Replay, begin: int) -> None:
    """Make the first row the posture that the motion before `begin` ended in, reached by axes, with the tool behind it."""
    cell = replayed.cell
    values = dict(zip(cell.axis_names, cell.to_axis_values(np.asarray(replayed.q)[begin - 1]), strict=True))
    own["kind"][0], own["blend"][0], own["wait"][0] = Motion.PTP_AXES, Blend.EXACT, 0.0
    own["pose"][0], own["circular_angle_deg"][0] = np.nan, np.nan
    own["axes"][0] = [values[cell.names[i]] for i in range(cell.arm_slice.start, cell.arm_slice.stop)]
    own["external"][0] = [values.get(name, np.nan) for name in program.external_names]
    own["status"][0] = own["turn"][0] = -1
    own["speed"][0] = 0.0
    for name in ("tool", "file", "line"):
        own[name][0] = getattr(program, name)[begin]
