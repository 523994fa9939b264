"""The motions of a program as RAPID statements, with what is written between them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import JobError
from camrob.languages.rapid.rapid_numbers import (
    ANGLE_DECIMALS,
    EXTERNAL_DECIMALS,
    LENGTH_DECIMALS,
    QUATERNION_DECIMALS,
    SPEED_DECIMALS,
    quaternions,
)
from camrob.languages.rapid.rapid_text import comment_text, row
from camrob.languages.rapid.writer.mounted_tools import MountedTools
from camrob.languages.rapid.writer.printable import check_program
from camrob.program.axis_turns import quarters_of, turn_of
from camrob.program.motion import Motion, Turning
from camrob.program.printed import fixed_decimals
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.units import m_to_mm

__all__ = ["INDENT", "Names", "RapidBody"]

INDENT = "    "
_FREE_AXES = "5000,1000"  # mm/s, degrees/s: external axes in ABB's own v5 to v7000: as fast as they can, with the tool
_SLOTS = 6  # eax_a .. eax_f
_ABSENT = "9E9"


class Names:
    """The data that a program declares."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.wobj, self.zone, self.joint_speed = f"w_{name}", f"z_{name}", f"j_{name}"

    def tool(self, index: int) -> str:
        """The tooldata of the tools and loads in their order."""
        return f"t_{self.name}" if index == 0 else f"t{index + 1}_{self.name}"


class RapidBody:
    """Prints any stretch of a program's motions. It checks the program once, when it is made.

    Raises ValueError for a program that can't be printed as it is, JobError for one that RAPID does not take.
    """

    def __init__(self, program: Program, controller: ControllerSettings, names: Names) -> None:
        self._program, self._controller, self._names = program, controller, names
        self._events: dict[int, list[ProgramEvent]] = {}
        for event in program.events:
            self._events.setdefault(event.motion, []).append(event)
        check_program(program, self._events)
        for event in program.events:
            if event.kind is ProgramEventKind.HOOK:
                self.hook(event.text, event.value)
        self.mounted = MountedTools(program)
        posed = program.kind != Motion.PTP_AXES
        turn = np.asarray(program.turn).copy()
        turn[program.kind >= Motion.LIN] = turn_of(Turning.QUARTERS, program.axes[program.kind >= Motion.LIN])
        status = np.asarray(program.status, np.int64)
        branch = 4 * (status & 1) + 2 * (1 - (status >> 1 & 1)) + (status >> 2 & 1)  # ABB's cfx, of the same three bits
        self._conf = np.column_stack([quarters_of(np.where(posed, turn, 0)), branch])
        self._quaternion = quaternions(program.pose[:, 3:])
        self._slot = {int(name[1:]) - 1: k for k, name in enumerate(program.external_names)}
        self._turning = fixed_decimals(controller.vel_ori_deg_s, SPEED_DECIMALS)

    def hook(self, name: str, value: float = 0.0) -> list[str]:
        """Lines of one of the cell's hooks, held to the line length."""
        lines = [INDENT * 2 + line for line in self._controller.hook_lines(name, value)]
        for line in lines:
            self.check_length(line)
        return lines

    def check_length(self, line: str, motion: int | None = None) -> None:
        """Raises JobError for a line that the controller would not take."""
        if len(line) > self._controller.max_line_length:
            most = self._controller.max_line_length
            what = f"a line of RAPID gets {len(line)} characters, the controller takes {most} (max_line_length)"
            at = 0 if motion is None else int(self._program.line[motion])
            raise JobError(f"{what}; shorten names and comments", line=at)

    def sizes(self) -> NDArray[np.int64]:
        """Bytes of each motion with what is written before it (N,); what follows the last motion counts to that."""
        total = len(self._program)
        sizes = np.zeros(total, np.int64)
        for at, line in self.lines(0, total, last=True):
            if total:
                sizes[min(at, total - 1)] += len(line) + 2
        return sizes

    def lines(self, start: int, end: int, *, last: bool) -> Iterator[tuple[int, str]]:
        """Motions `start` to `end` with the events before each, and those after the last one where `last` is set."""
        kind = self._program.kind
        for at in range(start, end + last):
            for event in self._events.get(at, ()):
                for line in self._event_lines(event):
                    self.check_length(line)
                    yield at, line
            if at < end and kind[at] != Motion.CIRC_VIA:
                line = self._motion(at)
                self.check_length(line, at)
                yield at, line

    def _motion(self, at: int) -> str:
        """The statement of a motion; a circle's has both its points."""
        p, names = self._program, self._names
        kind = p.kind[at]
        behind = f",{names.tool(self.mounted.of_motion[at])}\\WObj:={names.wobj};"
        if kind == Motion.PTP_AXES:
            target = f"[{row(p.axes[at].tolist(), ANGLE_DECIMALS)},{self._external(at)}]"
            return f"{INDENT}{INDENT}MoveAbsJ {target}\\NoEOffs,{names.joint_speed},fine{behind}"
        if kind == Motion.PTP_POSE:
            return f"{INDENT}{INDENT}MoveJ {self._robtarget(at)},{names.joint_speed},fine{behind}"
        speed = f"[{fixed_decimals(m_to_mm(float(p.speed[at])), SPEED_DECIMALS)},{self._turning},{_FREE_AXES}]"  # mm/s
        zone = names.zone if p.approximate[at] else "fine"
        if kind == Motion.LIN:
            return f"{INDENT}{INDENT}MoveL {self._robtarget(at)},{speed},{zone}{behind}"
        return f"{INDENT}{INDENT}MoveC {self._robtarget(at - 1)},{self._robtarget(at)},{speed},{zone}{behind}"

    def _robtarget(self, at: int) -> str:
        """`[[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[eax_a,...]]`."""
        place = row(self._program.pose[at, :3].tolist(), LENGTH_DECIMALS)
        turn = row(self._quaternion[at].tolist(), QUATERNION_DECIMALS)
        conf = ",".join(str(k) for k in self._conf[at].tolist())
        return f"[{place},{turn},[{conf}],{self._external(at)}]"

    def _external(self, at: int) -> str:
        """`[eax_a,..,eax_f]`, 9E9 where there is no such axis."""
        values = self._program.external[at].tolist()
        said = (
            fixed_decimals(values[self._slot[k]], EXTERNAL_DECIMALS) if k in self._slot else _ABSENT
            for k in range(_SLOTS)
        )
        return f"[{','.join(said)}]"

    def _event_lines(self, event: ProgramEvent) -> list[str]:
        """The lines of one event; tools and loads are named by the motions themselves."""
        if event.kind is ProgramEventKind.HOOK:
            lines = self.hook(event.text, event.value)
            return lines or [f"{INDENT}{INDENT}! {event.text}: the cell has no lines for it"]
        if event.kind is ProgramEventKind.DWELL:
            return [f"{INDENT}{INDENT}WaitTime\\InPos,{fixed_decimals(event.value, 3)};"]  # milliseconds
        if event.kind in (ProgramEventKind.COMMENT, ProgramEventKind.REGION) and event.text:
            mark = "! " if event.kind is ProgramEventKind.COMMENT else "! ==== "
            room = self._controller.max_line_length - len(INDENT) * 2 - len(mark)
            return [f"{INDENT}{INDENT}{mark}{comment_text(event.text, room)}"]
        return []
