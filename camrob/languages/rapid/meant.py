"""What a RAPID program has to do beside moving: settings, hooks, waits, and what its motions name; no reader, no writer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages.rapid.rapid_settings import rapid_settings
from camrob.languages.rapid.rapid_text import rapid_name
from camrob.languages.rapid.reader.tokens import canonical
from camrob.program.language import MeantActions
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.program.program_text import ProgramAction

__all__ = ["meant_actions"]


def meant_actions(program: Program, controller: ControllerSettings) -> MeantActions:
    """The settings that a program opens with, then what header, events and motions say, each before its motion."""
    said = _Said(program, controller)
    rest = [(0, line) for line in _statements(controller.hook_lines("header"))]
    events: dict[int, list[ProgramEvent]] = {}
    for event in program.events:
        events.setdefault(event.motion, []).append(event)
    tool: float = -1.0
    load: float = -1.0
    pairs: list[tuple[float, float]] = []
    for motion in range(len(program) + 1):
        for event in events.get(motion, ()):
            rest += [(motion, line) for line in _event_statements(event, controller)]
            tool = event.value if event.kind is ProgramEventKind.TOOL else tool
            load = event.value if event.kind is ProgramEventKind.LOAD else load
        if motion < len(program) and program.kind[motion] != Motion.CIRC_VIA:
            begun = motion - (program.kind[motion] == Motion.CIRC_END)  # a circle is one statement: at its first row
            rest += [(int(begun), line) for line in said.at(motion, load)]
            pairs += [(tool, load)] if (tool, load) not in pairs else []
    rest += [(len(program), line) for line in _statements(controller.hook_lines("footer"))]
    opening = _settings(controller, pairs, rapid_name(program.name))
    return MeantActions(tuple(opening), tuple(ProgramAction(motion, line) for motion, line in rest))


class _Said:
    """What the motions name that is neither a target, a frame nor the tip's speed, where it changes."""

    def __init__(self, program: Program, controller: ControllerSettings) -> None:
        self._program = program
        own = rapid_settings(controller)
        mm = float(f"{controller.apo_cdis_mm:.3f}")
        turn = float(f"{0.1 * controller.apo_cdis_mm:.4f}")  # degrees: a tenth of the distance
        self._joint = ", ".join(repr(float(f"{v:.3f}")) for v in own.ptp_speed)
        self._path = (
            f"{float(f'{controller.vel_ori_deg_s:.3f}')!r}, 5000.0, 1000.0"  # mm/s, degrees/s: free external axes
        )
        self._zone = ", ".join(repr(v) for v in (mm, mm, mm, turn, mm, turn))
        self._last: dict[str, str] = {}

    def at(self, motion: int, load: float) -> list[str]:
        """What motion `motion` names and none before it did."""
        p = self._program
        ptp = p.kind[motion] < Motion.LIN
        now = {"speed of joint motions": self._joint} if ptp else {"v_ori v_leax v_reax": self._path}
        if p.approximate[motion]:
            now["zone"] = self._zone
        if load >= 0:
            mass, x, y, z, *moments = (repr(float(v)) for v in (np.asarray(p.loads[int(load)]) + 0.0).tolist())
            now["load"] = f"{mass}, {x}, {y}, {z}, 1.0, 0.0, 0.0, 0.0, {', '.join(moments)}"
        new = [f"{what} {text}" for what, text in now.items() if self._last.get(what) != text]
        self._last |= now
        return new


def _settings(controller: ControllerSettings, pairs: Sequence[tuple[float, float]], name: str) -> list[str]:
    """The statements that a program opens with."""
    own = rapid_settings(controller)
    said = [f"ActUnit {unit};" for unit in own.active_units]
    said += ["PDispOff;", "EOffsOff;", "ConfJ\\On;", "ConfL\\Off;", "SingArea\\Off;", "CirPathMode\\ObjectFrame;"]
    said += ["AccSet 100,100;", "VelSet 100,5000;"]
    said.append(f"PathAccLim TRUE\\AccMax:={controller.acc_cp:.4f},TRUE\\DecelMax:={controller.acc_cp:.4f};")
    for k, (_, load) in enumerate(pairs):
        if load < 0:
            said.append(f"t{k + 1 if k else ''}_{name}.tload:={own.tool_data}.tload;")
    return [canonical(line) for line in said]


def _event_statements(event: ProgramEvent, controller: ControllerSettings) -> list[str]:
    """What an event does, as statements; titles and comments do nothing, and motions name their tools."""
    if event.kind is ProgramEventKind.HOOK:
        return _statements(controller.hook_lines(event.text, event.value))
    if event.kind is ProgramEventKind.DWELL:
        return [canonical(f"WaitTime\\InPos,{event.value:.3f};")]
    return []


def _statements(lines: Sequence[str]) -> list[str]:
    return [canonical(line) for line in lines]
