"""What a KRL program has to do beside moving: its settings, the cell's hooks and waits, told apart from reader and writer."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages.krl.krl_settings import krl_settings
from camrob.languages.krl.reader.tokens import canonical, statement_of
from camrob.program.language import MeantActions
from camrob.program.motion import Blend
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.program.program_text import ProgramAction

__all__ = ["meant_actions"]

_BLENDS = {"C_DIS": Blend.DISTANCE, "C_SPL": Blend.DISTANCE, "C_VEL": Blend.SPEED, "C_ORI": Blend.TURN}


def meant_actions(program: Program, controller: ControllerSettings) -> MeantActions:
    """The settings that a program opens with, then what header, events and footer do, each before its motion."""
    rest = [(0, line) for line in _statements(controller.hook_lines("header"))]
    for event in program.events:
        rest += [(event.motion, line) for line in _event_statements(event, program, controller)]
    rest += [(len(program), line) for line in _statements(controller.hook_lines("footer"))]
    opening = tuple(canonical(line) for line in _settings(controller))
    blend = _BLENDS[krl_settings(controller).customs.blend_word]
    return MeantActions(opening, tuple(ProgramAction(motion, line) for motion, line in rest), blend)


def _settings(controller: ControllerSettings) -> list[str]:
    """The statements that a program opens with, in the controller's own words."""
    own = krl_settings(controller)
    customs = own.customs
    said = ["CONTINUE"] * customs.on_path
    said += [
        "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS == TRUE DO IR_STOPM ( )",
        "INTERRUPT ON 3",
    ] * own.stop_message
    said += [
        "BAS (#INITMOV, 0)",
        f"BAS (#VEL_PTP, {controller.ptp_velocity_percent:.0f})",
        f"$ADVANCE = {controller.advance}",
        f"$ACC.CP = {controller.acc_cp:.4f}",
        f"$VEL.ORI1 = {controller.vel_ori_deg_s:.3f}",
        f"$VEL.ORI2 = {controller.vel_ori_deg_s:.3f}",
        f"$ACC.ORI1 = {controller.acc_ori_deg_s2:.3f}",
        f"$ACC.ORI2 = {controller.acc_ori_deg_s2:.3f}",
        f"$ORI_TYPE = {own.ori_type}",
        f"$CIRC_TYPE = {own.circ_type}",
        f"$APO.CDIS = {controller.apo_cdis_mm:.3f}",
    ]
    if customs.apo_cvel_percent is not None:
        said.append(f"$APO.CVEL = {customs.apo_cvel_percent:.3f}")
    if customs.apo_cori_deg is not None:
        said.append(f"$APO.CORI = {customs.apo_cori_deg:.3f}")
    if own.act_ex_ax:
        said.append(f"$ACT_EX_AX = {own.act_ex_ax}")
    for table, number in (("TOOL", own.tool_number), ("BASE", own.base_number)):
        if number is not None:
            by_bas = customs.numbering == "bas"
            said.append(f"BAS (#{table}, {number})" if by_bas else f"$ACT_{table} = {number}")
    return said


def _event_statements(event: ProgramEvent, program: Program, controller: ControllerSettings) -> list[str]:
    """What an event does, as statements; folds and comments do nothing."""
    if event.kind is ProgramEventKind.HOOK:
        return _statements(controller.hook_lines(event.text, event.value))
    if event.kind is ProgramEventKind.DWELL:
        return [canonical(f"WAIT SEC {event.value:.3f}")]
    if event.kind is ProgramEventKind.LOAD:
        mass, *rest = (program.loads[int(event.value)] + 0.0).tolist()
        where = ",".join(f"{c} {v:.3f}" for c, v in zip("XYZ", rest[:3], strict=True)) + ",A 0.0,B 0.0,C 0.0"
        heavy = ",".join(f"{c} {v:.3f}" if any(rest[3:]) else f"{c} 0.0" for c, v in zip("XYZ", rest[3:], strict=True))
        return [canonical(f"$LOAD = {{M {mass:.3f},CM {{{where}}},J {{{heavy}}}}}")]
    return []


def _statements(lines: Sequence[str]) -> list[str]:
    """The statements of lines of KRL, comments left out; frames and `$VEL.CP` are held by the motions that they rule."""
    said = [canonical(statement_of(line)) for line in lines if statement_of(line)]
    return [s for s in said if not s.startswith(("$TOOL =", "$BASE =", "$VEL . CP ="))]
