"""Does the text say what was meant? A program read back and replayed, held to the program that was to be printed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.controller import ControllerSettings
from camrob.controller.replay import Replay
from camrob.issues import Finding, Severity
from camrob.post.krl_lexer import canonical, statement_of
from camrob.post.krl_program import KrlApproximation, KrlFrame, KrlFrameKind, KrlMotion, KrlProgram
from camrob.post.program import Program, ProgramEvent, ProgramEventKind

__all__ = ["hold_to_intended"]

Array = NDArray[np.float64]

PRINTED = 1e-6  # mm, degrees, m/s: the program's values are rounded already, so that the text says them exactly
FRAME_PRINTED = 1e-5  # mm, degrees: the last decimal of a frame
POSTURE = 0.05  # degrees that rounding of a pose can move an axis, near a straight wrist too

_UNCLEAR = ("not-understood", "tool-unknown", "base-unknown")
"""Findings of the reader after which nobody knows what the text does. (Calls are held to those of the cell's hooks.)"""


def hold_to_intended(
    text: KrlProgram, replay: Replay, program: Program, controller: ControllerSettings
) -> list[Finding]:
    """Errors where what the text says is not the program, or it is run in other postures.

    Held are motions, numbers, speeds, frames, approximation, settings, outputs and waits, each in its place.

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
    found = _first(_rounding(text), np.where(program.approximate, float(KrlApproximation.C_DIS), 0.0)[:, None],
                   np.ones(len(program), np.bool_), 0.0)  # fmt: skip
    if found is not None:
        return [_finding("the text rounds off a point that was not meant to be, or stops at one that was", found, text)]
    astray = _acts_otherwise(text, program, controller)
    if astray is not None:
        return [astray]
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


def _rounding(text: KrlProgram) -> Array:
    """(N, 1) how each target is rounded off; a CIRC with an angle of its own, which no program means, as -1."""
    own_angle = np.isfinite(np.asarray(text.circular_angle_deg))
    return np.where(own_angle, -1.0, np.asarray(text.approximation, np.float64))[:, None]


def _acts_otherwise(text: KrlProgram, program: Program, controller: ControllerSettings) -> Finding | None:
    """An error for the first setting, output or wait of the text that was not meant there, or that is left out."""
    meant = [(0, canonical(line)) for line in _settings(controller)]
    read = [(a.motion, a.text) for a in text.actions]
    opening = len(meant)
    if sorted(read[:opening]) != sorted(meant):
        return Finding(
            "not-as-meant", "the text opens with settings that were not meant, or without one", Severity.ERROR
        )
    meant = [(0, line) for line in _statements(controller.hook_lines("header"))]
    for event in program.events:
        meant += [(event.motion, line) for line in _event_statements(event, controller)]
    meant += [(len(program), line) for line in _statements(controller.hook_lines("footer"))]
    read = read[opening:]
    first = next((k for k, pair in enumerate(zip(read, meant, strict=False)) if pair[0] != pair[1]), None)
    if first is None and len(read) == len(meant):
        return None
    first = min(len(read), len(meant)) if first is None else first
    row, what = (meant if len(meant) > first else read)[first]
    row = min(row, read[first][0]) if first < len(read) else row
    row = min(row, len(text) - 1)
    told = f"an output, a wait or a setting stands elsewhere than was meant, or is left out, at {what!r}"
    return Finding("not-as-meant", told, Severity.ERROR, line=int(text.line[row]) if row >= 0 else 0, point=row)


def _settings(controller: ControllerSettings) -> list[str]:
    """The statements that a program opens with, in the controller's own words."""
    said = [
        "BAS (#INITMOV, 0)", f"BAS (#VEL_PTP, {controller.ptp_velocity_percent:.0f})",
        f"$ADVANCE = {controller.advance}", f"$ACC.CP = {controller.acc_cp:.4f}",
        f"$VEL.ORI1 = {controller.vel_ori_deg_s:.3f}", f"$VEL.ORI2 = {controller.vel_ori_deg_s:.3f}",
        f"$ACC.ORI1 = {controller.acc_ori_deg_s2:.3f}", f"$ACC.ORI2 = {controller.acc_ori_deg_s2:.3f}",
        f"$ORI_TYPE = {controller.ori_type}", f"$CIRC_TYPE = {controller.circ_type}",
        f"$APO.CDIS = {controller.apo_cdis_mm:.3f}",
    ]  # fmt: skip
    if controller.act_ex_ax:
        said.append(f"$ACT_EX_AX = {controller.act_ex_ax}")
    for table, number in (("TOOL", controller.tool_number), ("BASE", controller.base_number)):
        if number is not None:
            said.append(f"BAS (#{table}, {number})")
    return said


def _event_statements(event: ProgramEvent, controller: ControllerSettings) -> list[str]:
    """What an event does, as statements; folds and comments do nothing."""
    if event.kind is ProgramEventKind.HOOK:
        return _statements(controller.hook_lines(event.text, event.value))
    if event.kind is ProgramEventKind.DWELL:
        return [canonical(f"WAIT SEC {event.value:.3f}")]
    return []


def _statements(lines: Sequence[str]) -> list[str]:
    """The statements of lines of KRL, comments left out; frames and `$VEL.CP` are held by the motions that they rule."""
    said = [canonical(statement_of(line)) for line in lines if statement_of(line)]
    return [s for s in said if not s.startswith(("$TOOL =", "$BASE =", "$VEL . CP ="))]


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
