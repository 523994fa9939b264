"""Small KRL programs, written row by row without camrob's writer, for the tests of replay and gate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from follower_twins import CELL

from camrob.cell.status_turn import StatusTurn
from camrob.kinematics.frames import base_T_tool
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.program.program_text import ProgramText
from camrob.se3 import xyzabc_from_frame

__all__ = ["HOME", "circ", "e6axis", "e6pos", "lin", "ptp_pose", "read_rows"]

HEAD = (
    "DEF test ( )\n$TOOL = {X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}\n"
    "$BASE = EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})\n$VEL.CP = 0.05\n"
)
HOME = "PTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}"


def e6pos(pose: np.ndarray, e1: float, e2: float, more: str = "") -> str:
    """A pose (4, 4) in `base` with external axes, mm and degrees."""
    x, y, z, a, b, c = xyzabc_from_frame(pose) * np.array([1e3] * 3 + [180.0 / np.pi] * 3)
    return f"{{E6POS: X {x:.9f},Y {y:.9f},Z {z:.9f},A {a:.9f},B {b:.9f},C {c:.9f}{more},E1 {e1:.9f},E2 {e2:.9f}}}"


def of(q: np.ndarray, more: str = "") -> str:
    unrolled = np.array(q)
    unrolled[-1] = 0.0
    axes = CELL.to_axis_values(q)
    return e6pos(base_T_tool(CELL, unrolled), axes[6], axes[7], more)


def lin(q: np.ndarray) -> str:
    return f"LIN {of(q)}"


def circ(via: np.ndarray, end: np.ndarray) -> str:
    return f"CIRC {of(via)},{of(end)}"


def ptp_pose(q: np.ndarray, status: int | None = None, turn: int | None = None) -> str:
    """A PTP to a posture's pose with its own S and T, or with others."""
    st = StatusTurn.of(CELL)
    axes = CELL.to_axis_values(q)[None, :6]
    s = int(st.status(axes)[0]) if status is None else status
    t = int(st.turn(axes)[0]) if turn is None else turn
    return f"PTP {of(q, f',S {s},T {t}')}"


def e6axis(q: np.ndarray) -> str:
    values = CELL.to_axis_values(q)
    return "PTP {E6AXIS: " + ",".join(f"{n} {v:.9f}" for n, v in zip(CELL.axis_names, values, strict=True)) + "}"


def read_rows(folder: Path, *rows: str, head: str = HEAD) -> ProgramText:
    file = folder / "test.src"
    file.write_text(head + "\n".join(rows) + "\nEND\n")
    return read_krl(file)
