"""Does the text say what was meant? A program read back and replayed, held to the program that was to be printed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.controller.replay import Replay
from camrob.findings import Finding, Severity
from camrob.program.language import MeantActions
from camrob.program.motion import Motion
from camrob.program.program import Program
from camrob.program.program_text import ProgramText

__all__ = ["hold_to_intended"]

Array = NDArray[np.float64]

PRINTED = 1e-6  # mm, degrees, m/s: the program's values are rounded already, so that the text says them exactly
FRAME_PRINTED = 1e-5  # mm, degrees: the last decimal of a frame
POSTURE = 0.05  # degrees that rounding of a pose can move an axis, near a straight wrist too
_CHUNK = 16_384  # motions that are looked at at once: bounds the memory

_UNCLEAR = ("not-understood",)
"""Findings of the reader after which nobody knows what the text does. (Calls are held to those of the cell's hooks, frames to
those that are meant wherever a motion needs them.)"""


def hold_to_intended(text: ProgramText, replay: Replay, program: Program, meant: MeantActions) -> list[Finding]:
    """Errors where what the text says is not the program, or it is run in other postures.

    Held are motions, numbers, speeds, frames, approximation, settings, outputs and waits, each in its place.

    A wrong Status or Turn, or an external axis with another value, may bring the tool to every point all the same: on
    another branch or turn, or with the table elsewhere. None of that was meant, nor checked for what lies in its way.
    """
    unclear = next((f for f in text.findings if f.code in _UNCLEAR), None)
    if unclear is not None:
        return [Finding("not-as-meant", f"of its text: {unclear.text}", Severity.ERROR, line=unclear.line)]
    if len(text) != len(program) or np.any(np.asarray(text.kind) != np.asarray(program.kind)):
        sentence = f"the text holds {len(text)} motions where {len(program)} were meant, or other ones"
        return [Finding("not-as-meant", sentence, Severity.ERROR)]
    other = _other_frame(text, program)
    if other is not None:
        return [other]
    by_pose = np.asarray(program.kind) != Motion.PTP_AXES
    moving = np.asarray(program.kind) >= Motion.LIN
    found = _first(
        _rounding(text),
        np.where(program.approximate, float(meant.blend), 0.0)[:, None],
        np.ones(len(program), np.bool_),
        0.0,
    )
    if found is not None:
        return [_finding("the text rounds off a point that was not meant to be, or stops at one that was", found, text)]
    astray = _acts_otherwise(text, meant)
    if astray is not None:
        return [astray]
    columns = [text.external_names.index(name) for name in program.external_names if name in text.external_names]
    if len(columns) != len(program.external_names):
        return [Finding("not-as-meant", "the text leaves out an external axis", Severity.ERROR)]
    pairs = (
        ("a pose", text.pose, program.pose, by_pose),
        ("axis values", text.axes, program.axes, ~by_pose),
        ("an external axis", np.asarray(text.external)[:, columns], program.external, np.ones(len(program), np.bool_)),
        ("a speed", np.asarray(text.speed)[:, None], np.asarray(program.speed)[:, None], moving),
    )
    for what, read, due, rows in pairs:
        found = _first(np.asarray(read), np.asarray(due), rows, PRINTED)
        if found is not None:
            return [_finding(f"the text gives {what} that was not meant", found, text)]
    real, q = np.asarray(text.kind) != Motion.CIRC_VIA, np.asarray(replay.q)
    for start in range(0, len(q), _CHUNK):
        part = slice(start, start + _CHUNK)
        axes = replay.cell.to_axis_values(q[part])[:, :6]
        found = _first(axes, np.asarray(program.axes)[part], real[part], POSTURE)
        if found is not None:
            row, axis, apart = found
            what = f"{replay.cell.axis_names[axis]} runs elsewhere than was meant"
            return [_finding(what, (start + row, axis, apart), text)]
    return []


def _other_frame(text: ProgramText, program: Program) -> Finding | None:
    """An error for the first motion that the text makes in another tool or base than was meant, or in none."""
    base = np.broadcast_to(np.asarray(program.base), (len(program), 6))
    posed = np.asarray(text.kind) != Motion.PTP_AXES
    for name, frames, used, meant in (
        ("tool", text.tools, np.asarray(text.tool), program.mounted),
        ("base", text.bases, np.asarray(text.base), base),
    ):
        read = np.stack([np.asarray(f.xyzabc) for f in frames])[used] if frames else np.full((len(program), 6), np.nan)
        found = _first(read, meant, posed, FRAME_PRINTED)
        if found is not None:
            row = found[0]
            sentence = f"the text gives a {name} that was not meant, or none"
            return Finding("not-as-meant", sentence, Severity.ERROR, line=int(text.line[row]), point=row)
    return None


def _rounding(text: ProgramText) -> Array:
    """(N, 1) how each target is rounded off; a CIRC with an angle of its own, which no program means, as -1."""
    own_angle = np.isfinite(np.asarray(text.circular_angle_deg))
    return np.where(own_angle, -1.0, np.asarray(text.blend, np.float64))[:, None]


def _acts_otherwise(text: ProgramText, wanted: MeantActions) -> Finding | None:
    """An error for the first setting, output or wait of the text that was not meant there, or that is left out."""
    read = [(a.motion, a.text) for a in text.actions]
    opening = len(wanted.opening)
    if sorted(read[:opening]) != sorted((0, line) for line in wanted.opening):
        return Finding(
            "not-as-meant", "the text opens with settings that were not meant, or without one", Severity.ERROR
        )
    meant = [(a.motion, a.text) for a in wanted.rest]
    read = read[opening:]
    first = next((k for k, pair in enumerate(zip(read, meant, strict=False)) if pair[0] != pair[1]), None)
    if first is None and len(read) == len(meant):
        return None
    first = min(len(read), len(meant)) if first is None else first
    row, what = (meant if len(meant) > first else read)[first]
    row = min(row, read[first][0]) if first < len(read) else row
    row = min(row, len(text) - 1)
    sentence = f"an output, a wait or a setting stands elsewhere than was meant, or is left out, at {what!r}"
    return Finding("not-as-meant", sentence, Severity.ERROR, line=int(text.line[row]) if row >= 0 else 0, point=row)


def _first(read: Array, meant: Array, rows: NDArray[np.bool_], tolerance: float) -> tuple[int, int, float] | None:
    """(row, column, difference) of the first difference that is too large."""
    for start in range(0, len(read), _CHUNK):
        part = slice(start, start + _CHUNK)
        apart = np.abs(read[part] - meant[part])
        off = np.argwhere(rows[part, None] & ~(apart <= tolerance))
        if len(off):
            return start + int(off[0, 0]), int(off[0, 1]), float(apart[tuple(off[0])])
    return None


def _finding(text: str, found: tuple[int, int, float], program: ProgramText) -> Finding:
    row, _, apart = found
    return Finding("not-as-meant", text, Severity.ERROR, line=int(program.line[row]), point=row, value=apart)
