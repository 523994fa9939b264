"""What a KRL program does before it moves: settings and frames, in the manner of the shop."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages.krl.krl_settings import KrlSettings, krl_settings
from camrob.languages.krl.krl_text import comment_text, frame_aggregate
from camrob.languages.krl.rounding import ANGLE_DECIMALS, EXTERNAL_DECIMALS, FRAME_DECIMALS, LENGTH_DECIMALS
from camrob.program.printed import fixed_decimals
from camrob.program.program import Program

__all__ = ["opening_lines", "tool_lines"]


class _Lines(Protocol):
    """What prints the rest of the program."""

    def hook(self, name: str, value: float = 0.0) -> list[str]:
        """Lines of one of the cell's hooks."""

    def check_length(self, line: str, motion: int | None = None) -> None:
        """Raises JobError for a line that the controller would not take."""


def opening_lines(program: Program, controller: ControllerSettings, body: _Lines) -> list[str]:
    """What the main program does before it moves."""
    own, longest = krl_settings(controller), controller.max_line_length
    lines = [
        f"; Made by camrob, rounded to {LENGTH_DECIMALS} decimals (X Y Z, mm), "
        f"{ANGLE_DECIMALS} (angles, deg), {EXTERNAL_DECIMALS} (E)"
    ]
    lines += ["; " + comment_text(text, longest - 2) for text in program.comment]
    folds = own.customs.folds
    lines += [";FOLD INI"] * folds
    lines += [*_begin(own), f"BAS (#VEL_PTP,{fixed_decimals(controller.ptp_velocity_percent, 0)} )"]
    lines += _numbers(own)
    lines += _settings(own, controller)
    base = frame_aggregate(tuple(program.base), FRAME_DECIMALS)
    lines += _base_lines(own, base) + tool_lines(own, frame_aggregate(tuple(program.tool), FRAME_DECIMALS))
    lines += [";ENDFOLD (INI)"] * folds
    lines += body.hook("header")
    for line in lines:
        body.check_length(line)
    return lines


def _begin(own: KrlSettings) -> list[str]:
    """The initialisation; in the form that a program is entered again by, it is passed over on the path."""
    lines = ["BAS (#INITMOV,0 )"]
    if own.stop_message:  # as in KUKA's own template of a program
        lines = ["GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )", "INTERRUPT ON 3", *lines]
    return ["CONTINUE", "IF NOT $ON_PATH THEN", *lines, "ENDIF"] if own.customs.on_path else lines


def _numbers(own: KrlSettings) -> Iterable[str]:
    """The rows of the controller's tables that come into force."""
    for word, number in (("TOOL", own.tool_number), ("BASE", own.base_number)):
        if number is not None:
            yield f"BAS (#{word},{number} )" if own.customs.numbering == "bas" else f"$ACT_{word} = {number}"


def _settings(own: KrlSettings, controller: ControllerSettings) -> list[str]:
    """How it moves."""
    customs = own.customs
    lines = [
        f"$ADVANCE = {controller.advance}",
        f"$ACC.CP = {fixed_decimals(controller.acc_cp, 4)}",
        f"$VEL.ORI1 = {fixed_decimals(controller.vel_ori_deg_s, 3)}",
        f"$VEL.ORI2 = {fixed_decimals(controller.vel_ori_deg_s, 3)}",
        f"$ACC.ORI1 = {fixed_decimals(controller.acc_ori_deg_s2, 3)}",
        f"$ACC.ORI2 = {fixed_decimals(controller.acc_ori_deg_s2, 3)}",
        f"$ORI_TYPE = {own.ori_type}",
        f"$CIRC_TYPE = {own.circ_type}",
        f"$APO.CDIS = {fixed_decimals(controller.apo_cdis_mm, 3)}",
    ]
    if customs.apo_cvel_percent is not None:
        lines.append(f"$APO.CVEL = {fixed_decimals(customs.apo_cvel_percent, 3)}")
    if customs.apo_cori_deg is not None:
        lines.append(f"$APO.CORI = {fixed_decimals(customs.apo_cori_deg, 3)}")
    return lines + ([f"$ACT_EX_AX = {own.act_ex_ax}"] if own.act_ex_ax else [])


def _base_lines(own: KrlSettings, frame: str) -> list[str]:
    """`$BASE` becomes a frame, by way of its row of BASE_DATA where that is the custom, or the row as the controller has it."""
    template = own.base_template or "{base}"
    row = f"BASE_DATA[{own.base_number}]"
    by_row = "$BASE = " + template.replace("{base}", row)
    if own.base_measured:
        return [by_row]
    if own.customs.numbering != "tables":
        return ["$BASE = " + template.replace("{base}", frame)]
    return [f"{row} = {frame}", by_row]


def tool_lines(own: KrlSettings, frame: str) -> list[str]:
    """`$TOOL` becomes a frame, by way of its row of TOOL_DATA where that is the custom."""
    if own.customs.numbering != "tables":
        return ["$TOOL = " + frame]
    row = f"TOOL_DATA[{own.tool_number}]"
    return [f"{row} = {frame}", f"$TOOL = {row}"]
