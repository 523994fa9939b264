"""Motion statements of RAPID: where they lead, with which tool, in which work object, how fast and how round."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from camrob.witness.happenings import Objection
from camrob.witness.krl.columns import AXES, CIRC, LIN, POSE
from camrob.witness.krl.conduct import PTP
from camrob.witness.krl.state import Base, Here, State
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import split_top
from camrob.witness.rapid.expressions import Item, NotSaidError, numbers_of
from camrob.witness.rapid.module_text import MoveRow
from camrob.witness.rapid.records import Records, angles, pose_values, product
from camrob.witness.units import mm_to_m

__all__ = ["RapidMotions"]

_NAN = float("nan")
_NO_AXIS = 8e9  # an external axis of more is 9E9: there is none
_TURNING = ("$VEL.ORI1", "$VEL.ORI2")
_EXTERNAL = (5000.0, 1000.0)  # mm/s, degrees/s of external axes in ABB's v5 to v7000: they never brake the tool
_WOBJ = re.compile(r"(?P<tool>.+?)(?: ?\\WOBJ ?:= ?(?P<wobj>\w+))?")
_HOW = {"MOVEABSJ": AXES, "MOVEJ": POSE, "MOVEL": LIN, "MOVEC": CIRC}


class RapidMotions:
    """Adds motions to a run; keeps what they named last."""

    def __init__(self, state: State, records: Records) -> None:
        self.state, self.records = state, records
        self.by_configuration = True  # ConfJ\\On
        self.load: tuple[float, ...] | None = None
        self.rounded = False  # the last motion's corner
        self.top = float("inf")  # VelSet's second number: no tip goes faster, mm/s
        self.names: tuple[str, str] = ("", "")  # tool and work object in force
        own = state.machine.controller.own
        speed = own.get("ptp_speed")
        self.joint_speed = [float(v) for v in speed] if isinstance(speed, list) and len(speed) == 4 else None
        self.unit = str(own.get("mechanical_unit", "")).upper()
        units = own.get("active_units")
        self.idle = (
            {str(unit).upper() for unit in units} if isinstance(units, list) else set[str]()
        )  # not activated yet

    def forget(self) -> None:
        """Data have changed: frames are looked up again."""
        self.names = ("", "")

    def move(self, word: str, text: str, line: Line) -> None:
        """MoveAbsJ, MoveJ, MoveL, MoveC. Raises NotSaidError."""
        if self.idle:
            names = " and ".join(sorted(self.idle))
            self.state.object("unit-not-active", f"{names} isn't activated (ActUnit), as the cell has it", line)
            self.idle.clear()
        how = _HOW[word]
        parts = split_top(re.sub(r", ?\\", r"\\", text))  # a comma may stand before an optional argument
        count = 2 if how == CIRC else 1
        if len(parts) != count + 3:  # targets; speed, zone, tool
            raise NotSaidError("it has not the arguments of its kind")
        found = _WOBJ.fullmatch(parts[-1].strip())
        if found is None or "\\" in found["tool"] or any("\\" in part for part in parts[1:-1]):
            raise NotSaidError("it has arguments that are not on the list of what is understood")
        behind = max(parts[0].rfind(bracket) for bracket in ")]}") + 1  # a function's own options stand within it
        own, option, rest = parts[0][behind:].partition("\\")
        target = parts[0][:behind] + own
        if option and (how != AXES or rest.strip() != "NOEOFFS"):
            raise NotSaidError(f"\\{rest.strip()[:30]} is not on the list of what is understood")
        values = [self.records.value(target), *(self.records.value(part) for part in parts[1:count])]
        speed = numbers_of(self.records.value(parts[count]), 4)
        rounds = self._settle(how < LIN, speed, parts[count + 1].strip(), line)
        self._frames(found["tool"].strip(), found["wobj"] or "WOBJ0", line)
        if how == AXES:
            self._joints(values[0], rounds, line)
            return
        poses = [self._pose(value) for value in values]
        pose, conf, external = poses[-1]
        middle = poses[0][0][:3] if how == CIRC else [_NAN] * 3
        status, turn = self._configuration(conf) if how == POSE and self.by_configuration else (-1, -1)
        self._check(line, arc=how == CIRC)
        axes = [_NAN] * 6 + self._external(external, line)
        self._add(how, pose, middle, axes, status, turn, rounds, mm_to_m(min(speed[0], self.top)), line)

    def rows(self, rows: Sequence[MoveRow]) -> None:
        """MoveLs that differ in their numbers alone: names and turning speed are the first one's."""
        state, first = self.state, rows[0]
        line = Line(first.number, "MOVEL", "", "MoveL ..")
        zone, tool, wobj = first.names
        rounds = self._settle(False, first.speed, zone, line)
        self._frames(tool, wobj, line)
        count = len(rows)
        state.room(count)
        state.close_steps()
        self._check(line, arc=False)
        lines = np.array([row.number for row in rows], dtype=np.int64)
        pose = np.concatenate(
            [np.array([row.place for row in rows]), angles(np.array([row.turn for row in rows]))], axis=1
        )
        wrong = np.flatnonzero(np.isnan(pose).any(axis=1))
        if len(wrong):
            state.gap(Line(int(lines[wrong[0]]), "", "", "MoveL .."), "its quaternion is not of length 1")
        axes = np.full((count, len(state.machine.axis_names)), np.nan)
        for i, row in enumerate(rows):
            axes[i, 6:] = self._external(list(row.external), int(lines[i]))
            state.external = [float(v) for v in axes[i, 6:]]
        state.moves(first.number, False, rounds)
        speed = mm_to_m(np.minimum([row.speed[0] for row in rows], self.top))
        for k in np.flatnonzero(speed <= 0.0)[:1].tolist():
            state.object("speed", "v_tcp is 0 mm/s, and has to be above 0", int(lines[k]))
        state.add_lines(pose, axes, speed, np.full(count, not rounds), lines)
        self.rounded = rounds

    def _settle(self, ptp: bool, speed: Sequence[float], zone_name: str, line: Line) -> bool:
        """Speeds and zone of a motion, held to the cell's; whether it rounds its corner. Raises NotSaidError."""
        put = self.state.conduct.set
        zone = self.records.value(zone_name)
        if not isinstance(zone, list) or len(zone) != 7 or not isinstance(zone[0], bool):
            raise NotSaidError(f"{zone_name[:40]} is no zone of the program")
        distances = numbers_of(zone[1:], 6)
        if min(speed) <= 0.0:
            raise NotSaidError("its speed is not above 0")
        if ptp:
            percent = self.state.machine.controller.ptp_percent
            if self.joint_speed is not None and percent is not None:
                put(PTP, percent * max(given / own for given, own in zip(speed, self.joint_speed, strict=True)))
        else:
            for name in _TURNING:
                put(name, speed[1])
            if tuple(speed[2:]) != _EXTERNAL:
                text = f"external axes at {speed[2]:g} mm/s, {speed[3]:g} degrees/s: whether they brake the tool isn't judged"
                self.state.unsure(line.number, text)
        if not zone[0]:
            put("$APO.CDIS", max(distances[:3]))  # of tip, turning, external axes: the widest
        return not zone[0]

    def _frames(self, tool: str, wobj: str, line: Line) -> None:
        """Tool, load and work object of a motion become those in force."""
        if (tool, wobj) == self.names:
            return
        self.names = (tool, wobj)
        state = self.state
        state.set_base(self._base(wobj, line))
        try:
            held, frame_, load = self.records.record(tool, "TOOLDATA")
            state.set_tool(pose_values(frame_) if held is True else None)
        except NotSaidError:
            load = None
            state.set_tool(None)
        known = _load(load)
        if known != self.load:
            self.load = known
            state.set_load(line.number, known)

    def _base(self, wobj: str, line: Line) -> Base:
        """A work object as a base: in the world, or on the unit that turns the part."""
        state = self.state
        try:
            held, fixed, unit, user, own = self.records.record(wobj, "WOBJDATA")
            if held is not False or not isinstance(unit, str):
                raise NotSaidError("the robot holds the part")
            table = state.machine.follows and any(joint.role == "workpiece" for joint in state.machine.joints)
            if fixed is True:
                values = product(pose_values(user), pose_values(own))
                text = f"{wobj[:40]} stands in the world, so it does not turn with the table as the cell says it does"
                fault = Objection("base-stands-still", text, line=line.number, file=state.file) if table else None
                return Base(values, False, fault)
            text = f"{wobj[:40]} hangs on {unit[:40]!r}, where the cell's part is on {self.unit!r}"
            other = unit.upper() != self.unit
            fault = Objection("base-other-mechanism", text, line=line.number, file=state.file) if other else None
            return Base(pose_values(own), True, fault)
        except NotSaidError:
            return Base(None, False)

    def _pose(self, value: Item) -> tuple[list[float], list[float], list[float]]:
        """X..C, configuration and external axes of a robtarget. Raises NotSaidError."""
        if not isinstance(value, list) or len(value) != 4:
            raise NotSaidError("a robtarget is wanted")
        return list(pose_values(value[:2])), numbers_of(value[2], 4), numbers_of(value[3], 6)

    @staticmethod
    def _configuration(conf: list[float]) -> tuple[int, int]:
        """Status and packed quarters of cf1, cf4, cf6, cfx. Raises NotSaidError."""
        if (
            any(value != round(value) for value in conf)
            or not 0 <= conf[3] <= 7
            or any(abs(v + 0.5) > 8 for v in conf[:3])
        ):
            raise NotSaidError("its configuration is none")  # cfx is of three bits, a quarter of four
        branch = int(conf[3])
        behind, folded_back, negative = branch // 4, branch // 2 % 2, branch % 2  # ABB's table of cfx
        status = behind + (0 if folded_back else 2) + 4 * negative  # KUKA's bits
        return status, sum((int(value) + 8) << shift for value, shift in zip(conf[:3], (8, 4, 0), strict=True))

    def _external(self, values: list[float], line: Line | int) -> list[float]:
        """The external axes after a motion; 9E9 keeps a value. Warns of one that the text gives and the cell lacks."""
        out, own = list(self.state.external), {int(name[1:]) - 1 for name in self.state.machine.axis_names[6:]}
        lacking = next((k for k, value in enumerate(values) if value < _NO_AXIS and k not in own), None)
        if lacking is not None:
            text = f"eax_{'abcdef'[lacking]}, which the cell lacks, has a value, and no 9E9"
            self.state.object_once("axis-absent", text, line, "warning")
        for k, name in enumerate(self.state.machine.axis_names[6:]):
            given = values[int(name[1:]) - 1]
            out[k] = given if given < _NO_AXIS else out[k]
        return out

    def _joints(self, value: Item, rounds: bool, line: Line) -> None:
        if not isinstance(value, list) or len(value) != 2:
            raise NotSaidError("a jointtarget is wanted")
        arm, external = numbers_of(value[0], 6), numbers_of(value[1], 6)
        axes = [*arm, *self._external(external, line)]
        self._add(AXES, [_NAN] * 6, [_NAN] * 3, axes, -1, -1, rounds, _NAN, line)

    def _check(self, line: Line, arc: bool) -> None:
        """What stands against reading a pose here, or leaves a motion's way unjudged."""
        state = self.state
        base = state.bases[state.base]
        if base.fault is not None and base.fault not in state.objections:
            state.objections.append(base.fault)
        if base.values is None or state.tools[state.tool] is None:
            name = "work object" if base.values is None else "tool"
            state.gap(line, f"the text doesn't say where its {name} is, so where the tool goes isn't judged")
        unlike = state.unlike_line or (state.unlike_arc if arc else "")
        if unlike:
            state.gap(line, f"how the tool turns on its way isn't judged ({unlike})")

    def _add(
        self,
        how: int,
        pose: list[float],
        middle: list[float],
        axes: list[float],
        status: int,
        turn: int,
        rounds: bool,
        speed: float,
        line: Line,
    ) -> None:
        """One more motion."""
        state = self.state
        state.room(1)
        state.close_steps()
        state.moves(line.number, how < LIN, rounds)
        single = (how, pose, middle, _NAN, axes, status, turn, state.base, state.tool, False)
        state.columns.add((*single, speed if how >= LIN else _NAN, not rounds, line.number, state.file))
        state.external = axes[6:]
        state.here = Here(None if how == AXES else pose, axes if how == AXES else None, state.base, state.tool)
        state.arrived()
        self.rounded = rounds


def _load(item: Item) -> tuple[float, ...] | None:
    """Mass, centre, its axes' angles and inertia of a loaddata; None where the text doesn't say."""
    try:
        if not isinstance(item, list) or len(item) != 6:
            return None
        mass, x, y, z = numbers_of([item[0]], 1) + numbers_of(item[1], 3)
        turned = pose_values([[x, y, z], item[2]])[3:]
        return (mass, x, y, z, *turned, *numbers_of(item[3:], 3))
    except NotSaidError:
        return None
