"""The plain program that runs a solved path: a PTP to its first point, then one LIN a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.jobs.files.cell_for import language_of
from camrob.jobs.files.solved_path import is_solution, read_solution, stem_of
from camrob.kinematics.frames import base_T_tool, seen_by_program
from camrob.program.builder import build_program
from camrob.program.motion import Motion
from camrob.units import mm_min_to_m_s

__all__ = ["check_feed", "program_of_solution"]

_FASTEST_MM_MIN = 120_000.0  # 2 m/s


def check_feed(path: Path, feed: float | None) -> None:
    """Raise InputError unless a solution has a feed, and a program, which writes its own, has none."""
    if not is_solution(path):
        if feed is not None:
            raise InputError("writes its own speeds", hint="leave --feed out", path=path)
        return
    if feed is None:
        raise InputError("holds no speeds", hint="give --feed in mm/min, or the program itself", path=path)
    if not 0.0 < feed <= _FASTEST_MM_MIN:
        raise InputError(f"a feed of {feed:g} mm/min can't be run", hint=f"give 0 to {_FASTEST_MM_MIN:g}", path=path)


def program_of_solution(path: Path, cell: Cell, feed: float | None, folder: Path) -> Path:
    """Write the program of a solution at a feed (mm/min) into a folder: its main file. Raises InputError."""
    language = language_of(cell)
    rounding = language.round
    q, line = read_solution(path, cell)
    values = cell.to_axis_values(q)
    q = cell.to_q(np.concatenate([rounding.axes(values[:, :6]), values[:, 6:]], axis=1))
    count = len(q)
    frames = seen_by_program(cell, q, base_T_tool(cell, q))
    kind = np.full(count, Motion.LIN, np.int8)
    kind[0] = Motion.PTP_AXES
    approximate = np.ones(count, np.bool_)
    approximate[[0, -1]] = False
    name = language.program_name(stem_of(path))
    program = build_program(
        name,
        cell,
        rounding,
        kind=kind,
        axis_values=values,
        frames=frames,
        speed=mm_min_to_m_s(feed or 0.0),
        approximate=approximate,
        line=line,
        safe=False,
        comment=("made from a solved path: it begins at the path's first point, not at HOME",),
    )
    for file, content in language.write(program, cell.controller, max_lines=None):
        (folder / file).write_bytes(content)
    return folder / f"{name}{language.suffixes[0]}"
