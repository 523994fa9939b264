"""Solved paths as files, and the plain program that runs one: a PTP to its first point, then one LIN a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.jobs.files.cell_for import language_of
from camrob.jobs.files.npz import read_arrays
from camrob.kinematics.frames import base_T_tool, seen_by_program
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.program.builder import build_program
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.units import m_to_mm, mm_min_to_m_s

__all__ = ["check_feed", "is_solution", "program_of_solution", "read_solution", "save_solution", "stem_of"]

Array = NDArray[np.float64]

_SUFFIX = ".path.npz"
_FASTEST_MM_MIN = 120_000.0  # 2 m/s


def is_solution(path: Path) -> bool:
    """True for NAME.path.npz."""
    return path.name.lower().endswith(_SUFFIX)


def stem_of(path: Path) -> str:
    """NAME of a solution, NAME.path.npz, or of a program."""
    return path.name[: -len(_SUFFIX)] if is_solution(path) else path.stem


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


def read_solution(path: Path, cell: Cell) -> tuple[Array, NDArray[np.int64]]:
    """Postures (N, n) and lines (N,) of a NAME.path.npz. Raises InputError."""
    q, line, axes = read_arrays(path, "q", "line", "axes", hint="give the NAME.path.npz that camrob post wrote")
    alike = q.dtype.kind == "f" and line.dtype.kind == "i" and axes.dtype.kind == "U" and axes.ndim == 1
    alike = alike and q.ndim == 2 and q.shape[1] == len(cell) and line.shape == (len(q),)
    alike = alike and tuple(axes.tolist()) == tuple(cell.names)
    if not alike or not np.all(np.isfinite(q)):
        raise InputError("holds postures of another cell", hint=f"post it for {cell.name}", path=path)
    if len(q) < 2:
        raise InputError("holds fewer than 2 postures", hint="give a longer path", path=path)
    return np.asarray(q, float), np.asarray(line, np.int64)


def save_solution(path: Path, cell: Cell, q: Array, text: ProgramText) -> None:
    """Postures (N, n) of a program's motions as a NAME.path.npz, with the fields that `camrob post` writes."""
    places = base_T_tool(cell, q)[:, :3, 3]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    np.savez(
        path,
        q=q,
        axes=np.array(cell.names),
        axis_values=cell.to_axis_values(q),
        axis_names=np.array(cell.axis_names),
        line=np.asarray(text.line),
        region=np.zeros(len(q), np.int32),
        inv_kf=inverse_kf_many(chain_arrays(cell), np.array(q)),
        s=m_to_mm(length),
    )


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
