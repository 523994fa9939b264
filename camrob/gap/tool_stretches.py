"""A log of a program that changes its tool, as logs of one tool each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camrob.cell.cell import Cell
from camrob.controller.replay import program_cells, replay
from camrob.controller.tool_runs import tool_runs
from camrob.errors import LogError
from camrob.gap.observation.program_track import motions_of_lines
from camrob.gap.observation.scene import LEAST
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame, Target
from camrob.program.program_text import ProgramText

__all__ = ["ToolStretch", "tool_stretches"]


class ToolStretch(NamedTuple):
    """What was logged between two changes of tools, the cell with the tool of that, and what was run; None: nobody says."""

    log: MeasurementLog
    cell: Cell
    program: ProgramText | None


def tool_stretches(
    logs: Sequence[MeasurementLog], programs: Sequence[ProgramText | None], cell: Cell
) -> list[ToolStretch]:
    """Logs with their programs, those of programs with several tools taken apart. A log's first stretch keeps its name, so that
    other logs can name it; of an instrument that nobody has placed all have that one's frame, and of a reflector that nobody has
    placed those with the same tool have one place.

    What is logged at a line without a motion, as while a tool is changed, is left out, and a stretch of fewer than 12 rows.
    Raises LogError for a log of several tools that does not say its lines.
    """
    out = []
    for log, program in zip(logs, programs, strict=True):
        if program is None:
            out.append(ToolStretch(log, cell, None))
            continue
        cells = program_cells(program, cell)[0]
        if len(cells) == 1:
            out.append(ToolStretch(log, cells[0], program))
        else:
            out += _taken_apart(log, program, cell)
    return out


def _taken_apart(log: MeasurementLog, program: ProgramText, cell: Cell) -> list[ToolStretch]:
    if not log.has("line"):
        what = f"does not say which line of {program.name} ran, and the program changes its tool"
        raise LogError(what, hint="log the line, or post the operations of each tool by themselves", path=log.path)
    runs = tool_runs(program, replay(program, cell))
    told = np.isin(log.line, np.asarray(program.line))
    motion = motions_of_lines(program, log.line)
    number = np.searchsorted([rows[0] for _text, _cell, rows in runs], motion, side="right") - 1
    name = log.name
    out: list[ToolStretch] = []
    first_with: dict[str, str] = {}
    for k, (text, tooled, _rows) in enumerate(runs):
        rows = np.flatnonzero(told & (number == k))
        if len(rows) < LEAST:
            continue
        own = name if not out else f"{name} from line {int(log.line[rows[0]])}"
        info = _shared(log.info, own, name, first_with.setdefault(tooled.digest, own))
        some = replace(
            log.select(rows), info=info, path=None if log.path is None else log.path.with_name(Path(own).name)
        )
        out.append(ToolStretch(some, tooled, text))
    if not out:
        what = f"holds fewer than {LEAST} rows at motions of {program.name}"
        raise LogError(what, hint="give the log of that program's run", path=log.path)
    return out


def _shared(info: LogInfo, own: str, first: str, with_tool: str) -> LogInfo:
    """What is said of a stretch: whose frame and whose reflector it has."""
    if own != first and info.measured_frame is MeasuredFrame.UNKNOWN:
        info = replace(info, same_frame_as=info.same_frame_as or first)
    if own != with_tool and info.target is Target.UNKNOWN:
        info = replace(info, same_target_as=info.same_target_as or with_tool)
    return info
