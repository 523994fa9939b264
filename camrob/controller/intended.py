"""Does the text say what was meant? A program read back and replayed, held to the program that was to be printed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.controller.replay import Replay
from camrob.issues import Finding, Severity
from camrob.post.krl_program import KrlFrame, KrlFrameKind, KrlMotion, KrlProgram
from camrob.post.program import Program

__all__ = ["hold_to_intended"]

Array = NDArray[np.float64]

PRINTED = 1e-6  # mm, degrees, m/s: the program's values are rounded already, so that the text says them exactly
FRAME_PRINTED = 1e-5  # mm, degrees: the last decimal of a frame
POSTURE = 0.05  # degrees that rounding of a pose can move an axis, near a straight wrist too

_UNCLEAR = ("call-unknown", "not-understood", "tool-unknown", "base-unknown")
"""Findings of the reader after which nobody knows what the text does."""


def hold_to_intended(text: KrlProgram, replay: Replay, program: Program) -> list[Finding]:
    """Errors where motions, numbers or speeds of the text are not the program's, or it is run in other postures.

    A wrong Status or Turn, or an external axis with another value, may bring the tool to every point all the same: on
    another branch or turn, or with the table elsewhere. None of that was meant, nor checked for what lies in its way.
    """
    unclear = next((f for f in text.findings if f.code in _UNCLEAR), None)
    if unclear is not None:
        return [Finding("not-as-meant", f"of its text: {unclear.text}", Severity.ERROR, line=unclear.line)]
    for name, frames, used, meant_frame in (
        ("$TOOL", text.tools, np.asarray(text.tool), program.tool), ("$BASE", text.bases, np.asarray(text.base), program.base)
    ):  # fmt: skip
        rows = used[np.asarray(text.kind) != KrlMotion.PTP_AXES]
        if not all(k >= 0 and _is_frame(frames[k], np.asarray(meant_frame)) for k in set(rows.tolist())):
            return [Finding("not-as-meant", f"the text gives a {name} that was not meant, or none", Severity.ERROR)]
    if len(text) != len(program) or np.any(np.asarray(text.kind) != np.asarray(program.kind)):
        told = f"the text holds {len(text)} motions where {len(program)} were meant, or other ones"
        return [Finding("not-as-meant", told, Severity.ERROR)]
    by_pose = np.asarray(program.kind) != KrlMotion.PTP_AXES
    moving = np.asarray(program.kind) >= KrlMotion.LIN
    columns = [text.external_names.index(name) for name in program.external_names if name in text.external_names]
    if len(columns) != len(program.external_names):
        return [Finding("not-as-meant", "the text leaves out an external axis", Severity.ERROR)]
    pairs = (
        ("a pose", text.pose, program.pose, by_pose),
        ("axis values", text.axes, program.axes, ~by_pose),
        ("an external axis", np.asarray(text.external)[:, columns], program.external, np.ones(len(program), np.bool_)),
        ("$VEL.CP", np.asarray(text.speed)[:, None], np.asarray(program.speed)[:, None], moving),
    )
    for what, read, meant, rows in pairs:
        found = _first(np.asarray(read), np.asarray(meant), rows, PRINTED)
        if found is not None:
            return [_finding(f"the text gives {what} that was not meant", found, text)]
    axes = replay.cell.to_axis_values(np.asarray(replay.q))[:, :6]
    real = np.asarray(text.kind) != KrlMotion.CIRC_VIA
    found = _first(axes, np.asarray(program.axes), real, POSTURE)
    if found is not None:
        return [_finding(f"{replay.cell.axis_names[found[1]]} runs elsewhere than was meant", found, text)]
    return []


def _is_frame(frame: KrlFrame, meant: Array) -> bool:
    """Whether a frame of the text is X, Y, Z, A, B, C (6,) as printed."""
    return frame.kind is not KrlFrameKind.UNKNOWN and bool(
        np.all(np.abs(np.asarray(frame.xyzabc) - meant) <= FRAME_PRINTED)
    )


def _first(read: Array, meant: Array, rows: NDArray[np.bool_], tolerance: float) -> tuple[int, int, float] | None:
    """(row, column, difference) of the first difference that is too large."""
    apart = np.abs(read - meant)
    off = np.argwhere(rows[:, None] & ~(apart <= tolerance))
    return None if not len(off) else (int(off[0, 0]), int(off[0, 1]), float(apart[tuple(off[0])]))


def _finding(text: str, found: tuple[int, int, float], program: KrlProgram) -> Finding:
    row, _, apart = found
    return Finding("not-as-meant", text, Severity.ERROR, line=int(program.line[row]), point=row, value=apart)
