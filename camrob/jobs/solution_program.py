"""Solved paths as files, and the plain program that runs one: a PTP to its first point, then one LIN a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.jobs.npz import read_arrays
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.post.krl_program import KrlProgram
from camrob.post.krl_round import round_axes, round_frame, round_pose, round_speed
from camrob.post.krl_text import krl_name
from camrob.post.krl_writer import write_krl
from camrob.post.program import Motion, Program
from camrob.se3 import xyzabc_from_frame
from camrob.units import m_to_mm, mm_min_to_m_s, rad_to_deg

__all__ = ["check_feed", "is_solution", "program_of_solution", "read_solution", "save_solution"]

Array = NDArray[np.float64]

_SUFFIX = ".path.npz"
_FASTEST_MM_MIN = 120_000.0  # $VEL.CP of 2 m/s


def is_solution(path: Path) -> bool:
    """True for NAME.path.npz."""
    return path.name.lower().endswith(_SUFFIX)


def check_feed(path: Path, feed: float | None) -> None:
    """Raise InputError unless a solution has a feed, and a program, which writes its own, has none."""
    if not is_solution(path):
        if feed is not None:
            raise InputError("writes its own speeds", cure="leave --feed out", path=path)
        return
    if feed is None:
        raise InputError("holds no speeds", cure="give --feed in mm/min, or the program itself", path=path)
    if not 0.0 < feed <= _FASTEST_MM_MIN:
        raise InputError(f"a feed of {feed:g} mm/min can't be run", cure=f"give 0 to {_FASTEST_MM_MIN:g}", path=path)


def read_solution(path: Path, cell: Cell) -> tuple[Array, NDArray[np.int64]]:
    """Postures (N, n) and lines (N,) of a NAME.path.npz. Raises InputError."""
    q, line, axes = read_arrays(path, "q", "line", "axes", cure="give the NAME.path.npz that camrob post wrote")
    alike = q.dtype.kind == "f" and line.dtype.kind == "i" and axes.dtype.kind == "U" and axes.ndim == 1
    alike = alike and q.ndim == 2 and q.shape[1] == len(cell) and line.shape == (len(q),)
    alike = alike and tuple(axes.tolist()) == tuple(cell.names)
    if not alike or not np.all(np.isfinite(q)):
        raise InputError("holds postures of another cell", cure=f"post it for {cell.name}", path=path)
    if len(q) < 2:
        raise InputError("holds fewer than 2 postures", cure="give a longer path", path=path)
    return np.asarray(q, float), np.asarray(line, np.int64)


def save_solution(path: Path, cell: Cell, q: Array, text: KrlProgram) -> None:
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
        inv_kf=inverse_kf_many(chain_arrays(cell), q),
        s=m_to_mm(length),
    )


def program_of_solution(path: Path, cell: Cell, feed: float | None, folder: Path) -> Path:
    """Write the program of a solution at a feed (mm/min) into a folder: its .src. Raises InputError."""
    q, line = read_solution(path, cell)
    values = cell.to_axis_values(q)
    q = cell.to_q(np.concatenate([round_axes(values[:, :6]), values[:, 6:]], axis=1))
    count = len(q)
    frames = base_T_tool(cell, q)
    if not cell.base_follows_table:  # $BASE stands in the hall, where `base` is when the table is at 0
        frames = world_T_base(cell, q) @ frames
    numbers = xyzabc_from_frame(frames)
    pose, external = round_pose(
        np.concatenate([m_to_mm(numbers[:, :3]), rad_to_deg(numbers[:, 3:])], axis=1), values[:, 6:]
    )
    kind = np.full(count, Motion.LIN, np.int8)
    kind[0] = Motion.PTP_AXES
    speed = np.full(count, float(round_speed(mm_min_to_m_s(feed or 0.0))))
    speed[0] = 0.0
    approximate = np.ones(count, np.bool_)
    approximate[[0, -1]] = False
    tool = xyzabc_from_frame(np.asarray(cell.flange_T_tool))
    name = krl_name(path.name[: -len(_SUFFIX)])
    program = Program(
        name=name,
        kind=kind,
        pose=pose,
        axes=round_axes(values[:, :6]),
        external=external,
        external_names=cell.external_names,
        status=np.zeros(count, np.int16),
        turn=np.zeros(count, np.int16),
        speed=speed,
        approximate=approximate,
        line=line,
        region=np.full(count, -1, np.int32),
        safe=np.zeros(count, np.bool_),
        tool=round_frame(np.concatenate([m_to_mm(tool[:3]), rad_to_deg(tool[3:])])),
        base=np.zeros(6),
        comment=("made from a solved path: it begins at the path's first point, not at HOME",),
    )
    for file, content in write_krl(program, cell.controller, max_lines=None).items():
        (folder / file).write_bytes(content)
    return folder / f"{name}.src"
