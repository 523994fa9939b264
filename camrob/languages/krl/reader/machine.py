"""What single KRL statements do: motions, assignments, BAS calls, waits."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from camrob.errors import KrlError
from camrob.findings import Finding, Severity
from camrob.languages.krl.reader.expressions import Aggregate, Enumerated, Expression, Mechanism, Unknown, Value
from camrob.languages.krl.reader.module import Module
from camrob.languages.krl.reader.rows import KrlRows
from camrob.languages.krl.reader.settings import USUAL
from camrob.languages.krl.reader.targets import Target, merged, standing, stepped, target_of
from camrob.languages.krl.reader.tokens import Token, canonical, shown
from camrob.languages.krl.reader.variables import Variables
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import FrameKind, ProgramAction, ProgramFrame

__all__ = ["KrlMachine"]

_HERE = frozenset(("$POS_ACT", "$AXIS_ACT", "$POS_FOR", "$AXIS_FOR", "$POS_ACT_MES", "$AXIS_ACT_MES", "$AXIS_ACT_MEAS"))
_HOMES = ("HOME", "XHOME")
_FRAME = "XYZABC"
_BLENDS = {"C_PTP": Blend.AXES, "C_DIS": Blend.DISTANCE, "C_VEL": Blend.SPEED, "C_ORI": Blend.TURN}
_SPLINE_BLENDS = {"C_SPL": Blend.DISTANCE, "C_DIS": Blend.DISTANCE}  # the spline planner rounds off by distance alone
_MODAL = {"$VEL.CP": "speed", "$ACC.CP": "acceleration", "$APO.CDIS": "blend_mm"}


class KrlMachine:
    """The state of a program that is being read: variables, what is modal, rows, frames, findings, counts.

    All methods raise KrlError, without a place, for what can't be read. `file`, `line` (from 1): where a statement is.
    """

    def __init__(self) -> None:
        self.variables = Variables()
        self.rows = KrlRows()
        self.statements: Counter[str] = Counter()
        self.findings: list[Finding] = []
        self.actions: list[ProgramAction] = []
        self._unsaid: list[tuple[ProgramFrame, Finding]] = []
        self.frames: dict[str, list[ProgramFrame]] = {"tool": [], "base": []}
        self._places: dict[tuple[str, FrameKind, bytes, str], int] = {}
        for name in self.frames:
            self.set_frame(name, Unknown("never set"))
        for name, axes in (("$POS_ACT", False), ("$AXIS_ACT", True)):
            self.variables.asked[name] = partial(self._where, name, axes)

    def said(self, used: Sequence[ProgramFrame]) -> list[Finding]:
        """All findings; a frame that isn't known is one where a motion uses it, not where the program sets another before."""
        unsaid = [finding for frame, finding in self._unsaid if any(frame is one for one in used)]
        return [*self.findings, *unsaid]

    def find(self, code: str, text: str, line: int, severity: Severity = Severity.WARNING) -> None:
        """Notes a finding."""
        self.findings.append(Finding(code, text, severity, line))

    def act(self, statement: str) -> None:
        """Notes what a statement does beside moving."""
        self.actions.append(ProgramAction(self.rows.count, canonical(statement)))

    def bulk(self, module: Module, start: int, end: int) -> None:
        """The usual LIN and `$VEL.CP` lines among lines `start` to `end` (exclusive)."""
        scan, modal = module.scan, self.rows.modal
        first, last = scan.lin_line.searchsorted([start, end])
        slow, fast = scan.speed_line.searchsorted([start, end])
        if first == last and slow == fast:
            return
        speeds = np.concatenate(([modal.speed], scan.speed_value[slow:fast]))
        if not np.all(speeds[1:] > 0.0):
            wrong = slow + int(np.argmin(speeds[1:] > 0.0))
            line = int(scan.speed_line[wrong]) + 1
            raise KrlError(f"$VEL.CP = {scan.speed_value[wrong]}", hint="a speed is positive", line=line)
        if first < last:
            lines = scan.lin_line[first:last]
            speed = speeds[scan.speed_line[slow:fast].searchsorted(lines)]
            self._want_speed(float(speed[0]), int(lines[0]) + 1)
            self._see_turning(("$ORI_TYPE",), int(lines[0]) + 1)
            values, approximation = scan.lin_values[first:last], scan.lin_approximation[first:last]
            self.rows.add_lins(values, approximation, speed, module.index, lines + 1)
            self.statements["LIN"] += int(last - first)
        if slow < fast:
            modal.speed = float(speeds[-1])
            self.statements["$VEL"] += int(fast - slow)
            self.variables.assign("$VEL.CP", modal.speed)

    def motion(self, tokens: tuple[Token, ...], file: int, line: int, *, plain: str = "") -> None:
        """PTP, LIN, CIRC, PTP_REL or LIN_REL; plain: the one of these that a motion of the spline kind is run as."""
        self.statements[tokens[0].text] += 1
        word, _, relative = (plain or tokens[0].text).partition("_")
        expression = Expression(tokens, self.variables, 1)
        targets = [self._target(expression, word, line)]
        if word == "CIRC":
            expression.expect(",")
            targets.append(self._target(expression, word, line))
        angle = float("nan")
        while expression.accept(","):
            if word != "CIRC" or not expression.accept("CA"):
                raise KrlError(f"{expression.rest()!r} behind a target", hint="correct the statement")
            angle = _number(expression.value(), "CA")
        blends = _SPLINE_BLENDS if plain and word != "PTP" else _BLENDS
        approximation, by_tool = _approximation(expression, blends, relative=bool(relative))
        if relative:
            targets = [None if t is None else stepped(self.rows, t, word, by_tool=by_tool) for t in targets]
        if word != "PTP":
            self._want_speed(self.rows.modal.speed, line)
            self._see_turning(("$ORI_TYPE",) if word == "LIN" else tuple(USUAL), line)
        elsewhere = self.rows.framed != (self.rows.modal.tool, self.rows.modal.base)
        kinds = {"LIN": [Motion.LIN], "CIRC": [Motion.CIRC_VIA, Motion.CIRC_END], "PTP": [Motion.PTP_POSE]}[word]
        start = self.rows.pose, self.rows.external
        for kind, target in zip(kinds, targets, strict=True):
            if target is None:
                continue
            if kind is Motion.CIRC_END:  # what it leaves out is as before the arc, whatever the auxiliary point is
                self.rows.pose, self.rows.external = start
            merged(self.rows, target, word, elsewhere=elsewhere, needed="XYZ" if kind is Motion.CIRC_VIA else "XYZABC")
            if word == "PTP" and target.axes is not None:
                kind = Motion.PTP_AXES
            self.rows.add(
                kind,
                status=target.status,
                turn=target.turn,
                angle=angle if kind is Motion.CIRC_END else float("nan"),
                approximation=0 if kind is Motion.CIRC_VIA else approximation,
                file=file,
                line=line,
            )
        if not math.isnan(angle):  # the arc ends elsewhere than at its target
            self.rows.framed = None

    def assign(self, expression: Expression, path: str, line: int) -> None:
        """`path = value`, the value next in `expression`."""
        root = path.split(".", 1)[0].split("[", 1)[0]
        self.statements[root] += 1
        start = expression.at
        value = expression.value()
        if expression.next.kind != "end":
            raise KrlError(f"{expression.rest()!r} behind an assignment", hint="correct the statement")
        if path == "$IPO_MODE" and value == Enumerated("#TCP"):
            raise KrlError("$IPO_MODE=#TCP: a tool that stands by itself is not read", hint="post with #BASE")
        self.variables.assign(path, value)
        if path in ("$TOOL", "$BASE") or path.startswith(("$TOOL.", "$BASE.")):
            text = " ".join(t.text for t in expression.tokens[start:-1])
            whole = value if "." not in path else self.variables.lookup(root)
            self.set_frame(root[1:].lower(), whole, text, line)
        elif root in ("$VEL", "$ACC", "$APO"):
            self.set_modal(root, path, value, line)

    def bas(self, tokens: tuple[Token, ...], line: int) -> None:
        """`BAS (#COMMAND, value)`, as far as it changes what is modal."""
        self.statements["BAS"] += 1
        arguments = Expression(tokens, self.variables, 1).arguments()
        command = arguments[0].text if arguments and isinstance(arguments[0], Enumerated) else "?"
        value = arguments[1] if len(arguments) > 1 else Unknown("")
        if command in ("#TOOL", "#BASE"):
            self.activate(command[1:].lower(), value, line)
        elif command == "#VEL_CP":
            self.set_modal("$VEL", "$VEL.CP", value, line)
        elif command in ("#CP_PARAMS", "#CP_DAT"):
            self._inline_path(value if command == "#CP_PARAMS" else Unknown(""), line)
        elif command in ("#PTP_PARAMS", "#PTP_DAT"):
            self._inline_axes()
        elif command == "#INITMOV":
            self.variables.shared.update({name: Enumerated(usual) for name, usual in USUAL.items()})
        elif command == "?":
            self.find("bas-unknown", "BAS with a command that is not known here", line)
        if command in ("#CP_PARAMS", "#PTP_PARAMS", "#FRAMES"):
            if self.variables.lookup("FDAT_ACT.IPO_FRAME") == Enumerated("#TCP"):
                raise KrlError("IPO_FRAME #TCP: a tool that stands by itself is not read", hint="post with #BASE")
            for name in ("tool", "base"):
                number = self.variables.lookup(f"FDAT_ACT.{name.upper()}_NO")
                if not isinstance(number, Unknown):
                    self.activate(name, number, line)

    def wait(self, tokens: tuple[Token, ...], line: int) -> None:
        """`WAIT SEC t` or `WAIT FOR condition`."""
        self.statements["WAIT"] += 1
        expression = Expression(tokens, self.variables, 1)
        if expression.accept("SEC"):
            value = expression.value()
            if isinstance(value, Unknown):
                self.find("wait-unknown", "WAIT SEC with a time that is not in the program", line)
            else:
                self.rows.modal.wait += max(_number(value, "WAIT SEC"), 0.0)
        elif expression.accept("FOR"):
            self.find("wait-for", "WAIT FOR a condition: how long is not known", line, Severity.INFO)
        else:
            raise KrlError("WAIT without SEC or FOR", hint="correct the statement")

    def _target(self, expression: Expression, word: str, line: int) -> Target | None:
        """The target that stands next; None for a null motion and for a home point that the program doesn't hold."""
        start = expression.at
        value = expression.value()
        name = expression.tokens[start].text
        alone = expression.at == start + 1
        if alone and name in _HERE:
            self.find("null-motion", f"{word} {name} moves to where the robot is", line, Severity.INFO)
            return None
        if isinstance(value, Aggregate):
            return target_of(value, word, self.rows)
        if alone and word == "PTP" and name.lstrip("X").rstrip("0123456789") in _HOMES[:1]:
            self.find(
                "home-unknown", f"PTP {shown(name)}: the point is not in the program, the motion is left out", line
            )
            self.rows.pose = self.rows.axes = None
            return None
        if isinstance(value, Unknown) and value.text in _HERE:
            raise KrlError(
                f"{word} from where the robot stands ({value.text}), which is not in the program: behind another kind of target, "
                "or in another base or tool",
                hint="give the target itself",
            )
        what = shown(value.text) if isinstance(value, Unknown) else expression.tokens[start].text
        if any(token.text == ":" for token in expression.tokens[start:]):
            raise KrlError(
                f"{word} {shown(what)}: the geometric operator (:) is read of whole frames alone, which the program holds",
                hint="bring the .dat file along, or write it as one frame",
            )
        raise KrlError(
            f"{word} {shown(what)}: the target's value is not in the program", hint="bring its .dat file along"
        )

    def _where(self, name: str, axes: bool) -> Value:
        """Where the robot stands, which a program that asks for it waits to reach."""
        place = standing(self.rows, axes=axes)
        if place is None:
            return Unknown(name)
        self.rows.end_exactly()
        return place

    def _want_speed(self, speed: float, line: int) -> None:
        """Notes a CP motion whose speed was never set."""
        if math.isnan(speed):
            self.find("speed-unknown", "a CP motion before any $VEL.CP", line)

    def set_modal(self, root: str, path: str, value: Value, line: int) -> None:
        """Takes over `$VEL.CP`, `$ACC.CP` or `$APO.CDIS`, alone or in an aggregate."""
        parts = {f"{root}.{k}": v for k, v in value.fields.items()} if isinstance(value, Aggregate) else {path: value}
        for name, part in parts.items():
            if name not in _MODAL:
                continue
            number = float("nan")
            if isinstance(part, Unknown):
                self.find("value-unknown", f"{name} gets a value that is not in the program", line)
            else:
                number = _number(part, name)
                if number < 0.0 or (number == 0.0 and name != "$APO.CDIS"):
                    raise KrlError(f"{name} = {number:g}", hint="write a positive value")
            setattr(self.rows.modal, _MODAL[name], number)

    def _inline_path(self, value: Value, line: int) -> None:
        """BAS(#CP_PARAMS, v): v in m/s, and what LDAT_ACT says; BAS(#CP_DAT): all by LDAT_ACT. A post that leaves v at 0 means
        LDAT_ACT's speed. What LDAT_ACT leaves out of turning is the usual (BAS.SRC).
        """
        given = value if isinstance(value, (int, float)) and value > 0 else self.variables.lookup("LDAT_ACT.VEL")
        if isinstance(given, (int, float)) and given > 0:
            self.set_modal("$VEL", "$VEL.CP", given, line)
        else:
            self.set_modal("$VEL", "$VEL.CP", Unknown("LDAT_ACT.VEL"), line)
        distance = self.variables.lookup("LDAT_ACT.APO_DIST")
        if isinstance(distance, (int, float)):
            self.set_modal("$APO", "$APO.CDIS", distance, line)
        for name, part in (("$ORI_TYPE", "ORI_TYP"), ("$CIRC_TYPE", "CIRC_TYP")):
            turning = self.variables.lookup(f"LDAT_ACT.{part}")
            self.variables.shared[name] = turning if isinstance(turning, Enumerated) else Enumerated(USUAL[name])

    def _inline_axes(self) -> None:
        """What PDAT_ACT says of rounding that paths take over: by distance where it says #CDIS (BAS.SRC)."""
        distance = self.variables.lookup("PDAT_ACT.APO_DIST")
        if self.variables.lookup("PDAT_ACT.APO_MODE") == Enumerated("#CDIS") and isinstance(distance, (int, float)):
            self.rows.modal.blend_mm = float(distance)

    def _see_turning(self, names: tuple[str, ...], line: int) -> None:
        """Notes that the tool turns otherwise along a path than it is read."""
        for name in names:
            value = self.variables.shared.get(name)
            if value is not None and value != Enumerated(USUAL[name]):
                said = value.text if isinstance(value, (Enumerated, Unknown)) else str(value)
                text = f"{name} = {shown(said)} is read as {USUAL[name]}: where the tool turns to isn't what the program says"
                self.find("rotation-type", text, line)

    def activate(self, name: str, number: Value, line: int) -> None:
        """Makes an entry of TOOL_DATA or BASE_DATA active; 0 is the null frame."""
        if number == 0 and not isinstance(number, bool):
            self.set_frame(name, self.variables.lookup("$NULLFRAME"), "$NULLFRAME", line)
            return
        entry = f"{name.upper()}_DATA[{number if isinstance(number, int) else '?'}]"
        self.set_frame(name, self.variables.lookup(entry), entry, line)

    def set_frame(self, name: str, value: Value, text: str = "", line: int = 0) -> None:
        """Makes a frame the current tool or base."""
        mechanism = isinstance(value, Mechanism)
        unsaid = ""
        inner: Value = value.frame if isinstance(value, Mechanism) else value
        fields = inner.fields if isinstance(inner, Aggregate) else {}
        numbers = [fields.get(c, Unknown(c)) for c in _FRAME]
        if all(isinstance(v, (int, float)) and math.isfinite(v) for v in numbers):
            xyzabc = np.array([float(v) for v in numbers if isinstance(v, (int, float))])
            frame = ProgramFrame(FrameKind.MECHANISM if mechanism else FrameKind.LITERAL, xyzabc, shown(text, 200))
        else:
            what = text or (inner.text if isinstance(inner, Unknown) else "")
            frame = ProgramFrame(FrameKind.UNKNOWN, np.full(6, np.nan), shown(what, 200))
            unsaid = f"${name.upper()} is set to {shown(what)}, which is not in the program" if line else ""
        known = self.frames[name]
        same = "" if frame.kind is FrameKind.LITERAL else frame.text
        key = (name, frame.kind, (frame.xyzabc + 0.0).tobytes(), same)  # -0.0 is 0.0
        index = self._places.setdefault(key, len(known))
        if index == len(known):
            known.append(frame)
        if unsaid:
            self._unsaid.append((known[index], Finding(f"{name}-unknown", unsaid, line=line)))
        setattr(self.rows.modal, name, index)


def _number(value: Value, what: str) -> float:
    """The value as a finite number. Raises KrlError for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise KrlError(f"{what} has no number that is in the program", hint="write a number")
    return float(value)


def _approximation(expression: Expression, blends: Mapping[str, Blend], *, relative: bool) -> tuple[int, bool]:
    """The approximation behind a target, of two (`C_PTP C_DIS`) the first, and whether a step is along the tool's axes.

    Raises KrlError for anything else.
    """
    found = [0]
    while expression.next.kind == "name" and expression.next.text in blends:
        found.append(int(blends[expression.next.text]))
        expression.at += 1
    by_tool = relative and expression.next.text == "#TOOL"
    if by_tool or (relative and expression.next.text == "#BASE"):
        expression.at += 1
    if expression.next.kind != "end":
        raise KrlError(f"{expression.rest()!r} behind a motion", hint="correct the statement")
    return int(found[1] if len(found) > 1 else 0), by_tool
