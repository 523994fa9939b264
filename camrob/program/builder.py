"""The one place where a `Program` is made: rows of motions in the decimals that a language prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.cell import Cell
from camrob.program.language import Rounding
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent
from camrob.se3 import mm_deg_from_frame

__all__ = ["build_program", "printed_frames"]

Array = NDArray[np.float64]

_CHUNK = 50_000  # poses read off at once: bounds the memory


def printed_frames(frames: Array) -> Array:
    """X, Y, Z, A, B, C (..., 6), mm and degrees, of poses (..., 4, 4)."""
    values = np.empty((*frames.shape[:-2], 6))
    flat, rows = frames.reshape(-1, 4, 4), values.reshape(-1, 6)
    for start in range(0, len(flat), _CHUNK):
        rows[start : start + _CHUNK] = mm_deg_from_frame(flat[start : start + _CHUNK])
    return values


def build_program(
    name: str,
    cell: Cell,
    rounding: Rounding,
    *,
    kind: ArrayLike,
    axis_values: Array,
    frames: Array | None = None,
    speed: ArrayLike = 0.0,
    approximate: ArrayLike = False,
    line: ArrayLike = 0,
    region: ArrayLike = -1,
    safe: ArrayLike = True,
    status: ArrayLike = 0,
    turn: ArrayLike = 0,
    tools: Array | None = None,
    loads: Array | None = None,
    events: Sequence[ProgramEvent] = (),
    comment: Sequence[str] = (),
) -> Program:
    """A program of N motions on a cell, with its tool and base in force from the start, every number rounded.

    kind: (N,) `Motion`. axis_values: (N, axes) degrees and mm at the motions' ends. frames: (N, 4, 4) the tool there in the frame
    that the program's base stands for, where a motion goes to a pose. speed: (N,) m/s of LIN and CIRC, left aside for PTP. tools:
    (T, 6) further tools, and loads: (L, 7), rounded already, which events mount. Others: see `Program`; one value holds for all.
    """
    base = None if cell.controller_section is None else cell.controller_section.base_frame
    kinds = np.asarray(kind, np.int8)
    count = len(kinds)
    axes = rounding.axes(axis_values[:, :6])
    external = axis_values[:, 6:]
    pose, external = (
        (np.zeros((count, 6)), rounding.external(external))
        if frames is None
        else rounding.pose(printed_frames(frames), external)
    )

    def each(values: ArrayLike, dtype: type[np.generic]) -> NDArray[Any]:
        return np.broadcast_to(np.asarray(values, dtype), (count,))

    return Program(
        name=name,
        kind=kinds,
        pose=pose,
        axes=axes,
        external=external,
        external_names=cell.external_names,
        status=each(status, np.int16),
        turn=each(turn, np.int16),
        speed=rounding.speed(np.where(kinds >= Motion.LIN, each(speed, np.float64), 0.0)),
        approximate=each(approximate, np.bool_),
        line=each(line, np.int64),
        region=each(region, np.int32),
        safe=each(safe, np.bool_),
        tool=rounding.frame(printed_frames(np.asarray(cell.flange_T_tool))),
        base=rounding.frame(np.zeros(6) if base is None else np.array(base)),
        comment=tuple(comment),
        events=tuple(events),
        tools=np.zeros((0, 6)) if tools is None else tools,
        loads=np.zeros((0, 7)) if loads is None else loads,
    )
