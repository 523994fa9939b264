"""What G-code's T, S and M words do to tool, spindle and coolant, as events in the file's order; which of a tool's lengths is
in force: Fanuc's H and those alike, and the edge, D, of Siemens.

How far two lengths of one tool lie apart stands in the machine's table. A robot has one tool centre point a tool, so that a
program that cuts with two of them, or with one and then without any (H0, D0), makes another part than the file says.
"""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.gcode.coordinates import ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.state import Modal
from camrob.toolpath.region import EventKind

__all__ = ["Process", "name_height", "refuse_other_length", "take_length"]

_SPINDLE = {30: "CLW", 40: "CCLW", 130: "CLW", 140: "CCLW"}  # M13 and M14 bring the coolant along
_COOLANT = {70: "MIST", 80: "FLOOD", 130: "FLOOD", 140: "FLOOD"}
# M96 to M99 and M198: calls and their ends; M21 to M23: mirror images of older controls
_SUBPROGRAM = frozenset((960, 970, 980, 990, 1980))
_MIRROR = frozenset((210, 220, 230))
_RESTORED = frozenset((720, 730))  # LinuxCNC
_TCP_ON, _TCP_OFF = (1280, 4280), (1290, 4290)  # M128 and M428, M129 and M429, in tenths
_LENGTHS = frozenset((430, 434, 435, 2340))  # G43, G43.4, G43.5, G234
_OTHER_H = frozenset((100, 150, 160))  # G10, and Okuma's G15 and G16, whose H are other things
_KNOWN = frozenset((*_SPINDLE, *_COOLANT, *_TCP_ON, *_TCP_OFF, 0, 10, 20, 50, 60, 90, 190, 290, 300, 600))


def take_length(block: Block, modal: Modal) -> None:
    """Take note of the length that a block names; a change of tools brings Siemens' D1 along.

    Behind another length than before, the height as the program counts it is not known until it is named anew.
    """
    before = modal.length
    if modal.edges and (60 in block.m or (modal.tool_by_t and "T" in block.words)):
        modal.length = 1.0
    letter = "D" if modal.edges else "H"
    if letter in block.words and _OTHER_H.isdisjoint(block.g):
        modal.length = block.words[letter]
    first = not modal.sized and not _LENGTHS.isdisjoint(block.g)
    modal.sized = (modal.sized or first) and 60 not in block.m
    if not modal.edges and (first or modal.length != before):
        modal.heightless = True


def name_height(block: Block, motion: int, modal: Modal, tool: int, *, known: bool) -> None:
    """Before a motion (code in tenths). known: where the tool is, as far as axes have been named.

    Raises ToolpathError for a cut at a height that a length has changed, but straight down.
    """
    named = "Z" in block.words and not modal.incremental
    if modal.heightless and motion != 0 and known:
        down = motion == 10 and named and {"X", "Y"}.isdisjoint(block.words)
        if not down and (motion in (10, 20, 30) or modal.incremental):
            refuse_other_length(modal, tool)
            raise ToolpathError(
                "a cut behind a tool's length (G43) since which Z has not been named: the machine counts its height anew there",
                hint="name Z in a rapid move behind the length",
            )
    if named and motion in (0, 10, 20, 30):
        modal.heightless = False


def refuse_other_length(modal: Modal, tool: int) -> None:
    """Before a cut. Raises ToolpathError where the tool has cut with another length before, or with none."""
    if modal.length is None and (modal.edges or modal.measured):  # which one it is the machine knows
        return
    first = modal.lengths.setdefault(tool, modal.length)
    if first != modal.length:
        letter = "D" if modal.edges else "H"
        raise ToolpathError(
            f"a cut with {letter}{modal.length:g} behind cuts of the same tool "
            + ("without any length" if first is None else f"with {letter}{first:g}")
            + ": how its lengths lie to each other only the machine's table says",
            hint="give what belongs to each a tool, or a program, of its own",
        )


class Process:
    """Tool, spindle and coolant of one program; `ended` is true after M2 or M30."""

    def __init__(self, path: PathGrower, frame: ToolFrame, modal: Modal, defaults: Defaults) -> None:
        self.path = path
        self.frame = frame
        self.modal = modal
        self.defaults = defaults
        self.ended = False
        self.given_speed = 0.0  # rev/min at which the set-up has the spindle started, where the program starts none
        self.speed_of_file = False  # at the program's own S
        self._speed_given = False
        self._never_turned = True  # no M3 or M4 yet with a speed above 0
        self._started = False
        self._nameless = 0  # line of an M3 or M4 that no speed has followed yet

    # -- tools -------------------------------------------------------------------------------------------------

    def tool_word(self, value: float, line: int) -> None:
        """A T word: the next tool, or the change itself in a program without M6."""
        if value != int(value) or not 0 <= value < 1e8:
            raise ToolpathError(f"T{value:g} is not a tool number", hint="a whole number")
        self.modal.next_tool = int(value)
        if self.modal.tool_by_t:
            self._change(int(value), line)

    def _change(self, number: int, line: int) -> None:
        """A change to that tool, unless it is in the spindle; T0 puts the tool away.

        It stops the machine's spindle. Out of a cut the machine takes the tool up first: how high is not known.
        """
        path, modal = self.path, self.modal
        if number == path.tool:
            return
        modal.stopped, modal.oriented = not self._speed_given, 0
        if path.cutting:
            path.lose()
            self.frame.forget("Z" if self.frame.plane is None and not self.frame.turned else "XYZ")
        modal.unloaded = 0 if number else line
        if number:
            path.change_tool(number, line)
            if self._speed_given:
                path.event(EventKind.SPINDLE_ON, self.rpm(), modal.spindle)
        else:
            path.put_tool_away()
            path.note("tool-unloaded", "T0 puts the tool away: that is left to the operator", line, Severity.INFO)

    def dwell(self, block: Block) -> None:
        """G4: the time is P (seconds, or a large whole number of milliseconds), X, U or F."""
        words = block.words
        if "P" in words:
            seconds = self.modal.seconds(block, self.path)
        else:
            seconds = next((words[k] for k in "XUF" if k in words), -1.0)
        if seconds < 0.0 and "S" in words:
            raise ToolpathError(
                "a dwell by S (G4 S): seconds on printers' controls, turns of the spindle on others",
                hint="name it by P",
            )
        if seconds < 0.0:
            raise ToolpathError("a dwell (G4) without its time", hint="name it by P")
        if seconds > 0.0:  # G4 P0 only keeps the control from rounding a corner
            self.path.event(EventKind.DWELL, seconds, "", block.line)

    # -- words of a block --------------------------------------------------------------------------------------

    def before(self, block: Block) -> None:
        """What acts before the motion: tool change, spindle and coolant on, S."""
        modal, path, line = self.modal, self.path, block.line
        self._refuse(block)
        if 60 in block.m:
            if modal.next_tool is None:
                raise ToolpathError("M6 without a T word before it", hint="name the tool, for example T1 M6")
            if modal.next_tool != path.tool:
                self._off_first(block)
            self._change(modal.next_tool, line)
        turning = [code for code in block.m if code in _SPINDLE]
        if "S" in block.words and 190 not in block.m:  # M19's S is an angle
            self._speed(block.words["S"], line, alone=not turning)
        for code in turning:
            self._turn(_SPINDLE[code], line)
        for code in block.m:
            if code in _COOLANT:
                modal.coolant = True
                path.event(EventKind.COOLANT_ON, 0.0, _COOLANT[code], line)
            elif code in _TCP_ON:
                self.frame.switch_tcp(True, by_m=True)

    def after(self, block: Block) -> None:
        """What acts after the motion: spindle and coolant off, TCP off, stop, end."""
        for code in block.m:
            if code in (50, 190):
                self._spindle_off(block.line)
                self.modal.oriented = block.line if code == 190 else 0
            elif code == 90:
                self._coolant_off(block.line)
            elif code in (0, 10, 600):
                self.path.event(EventKind.STOP, 0.0, f"M{code // 10}", block.line)
            elif code in _TCP_OFF:
                self.frame.switch_tcp(False, by_m=True)
            elif code in (20, 300):
                self._spindle_off(block.line)
                self._coolant_off(block.line)
                self.ended = True
            elif code not in _KNOWN:
                self.path.note("unknown-m-code", f"M{code / 10:g} has no meaning here and is left out", block.line)

    def _refuse(self, block: Block) -> None:
        """Refuse M codes that would make another part, and two senses at once."""
        for code in block.m:
            if code in _SUBPROGRAM:
                raise ToolpathError(
                    f"M{code / 10:g} calls or ends a subprogram, which is not read",
                    hint="have the CAM system write one program without subprograms",
                )
            if code == 4300:
                raise ToolpathError("M430 selects a kinematics of the user's own", hint="use M428 with XYZAC or XYZBC")
            if code in _MIRROR:
                raise ToolpathError(
                    f"M{code / 10:g} mirrors the part on some controls, which is not done",
                    hint="let the CAM system mirror, or take it out where it means something else on the machine",
                )
            if code in _RESTORED:
                raise ToolpathError(
                    f"M{code // 10} brings modes back that M70 or M73 has kept (LinuxCNC), which is not done",
                    hint="write the modes that hold out as G codes, or take it out where it means something else on the machine",
                )
            if code == 610:
                raise ToolpathError("M61 names the tool without a change", hint="change it by T and M6")
        if len({_SPINDLE[code] for code in block.m if code in _SPINDLE}) > 1:
            raise ToolpathError("M3 and M4 in one block", hint="keep one sense")

    def _off_first(self, block: Block) -> None:
        """M5 and M9 in the block of a tool change come before it."""
        if 50 in block.m:
            self._spindle_off(block.line)
        if 90 in block.m:
            self._coolant_off(block.line)

    # -- spindle -----------------------------------------------------------------------------------------------

    @property
    def turning(self) -> bool:
        """Whether the spindle turns: switched on, and no tool change has stopped it."""
        return bool(self.modal.spindle) and not self.modal.stopped

    def _speed(self, speed: float, line: int, *, alone: bool) -> None:
        """An S word: the speed, from here on where the spindle turns (`alone`: no M3 or M4 beside it)."""
        if speed < 0.0:
            raise ToolpathError("a negative spindle speed", hint="use M4 for the other direction")
        modal = self.modal
        changed = speed != modal.speed
        modal.speed = speed
        if changed and alone and self.turning:
            self._run(line)

    def _turn(self, sense: str, line: int) -> None:
        """M3 or M4."""
        self.modal.spindle, self.modal.stopped, self.modal.oriented = sense, False, 0
        self._started, self._speed_given = True, False
        self._run(line)

    def _run(self, line: int) -> None:
        """The spindle turns in the modal sense at the modal speed; S0 lets it stand, and without any S it waits for one."""
        modal = self.modal
        self._nameless = 0
        if modal.speed is None:
            self._nameless = line
        elif modal.speed > 0.0:
            self._never_turned = False
            self.path.event(EventKind.SPINDLE_ON, modal.speed, modal.spindle, line)
        else:
            self.path.event(EventKind.SPINDLE_OFF, 0.0, "", line)
            self.path.note("spindle-zero", "S0: the spindle stands", line)

    def settle(self) -> None:
        """Before a motion: a spindle without a speed takes the set-up's, or is refused."""
        if not self._nameless:
            return
        rpm = self.defaults.spindle_rpm
        if not rpm:
            raise ToolpathError(
                "the spindle is switched on, and no S names its speed",
                hint="program S before it, or put spindle_rpm into setup.toml",
                line=self._nameless,
            )
        text = f"the spindle is switched on without S: spindle_rpm of the set-up is used, {rpm:g} rev/min"
        self.path.note("spindle-speed-from-setup", text, self._nameless)
        self.modal.speed = rpm
        self._run(self._nameless)

    def settle_cut(self) -> None:
        """Before a cut: a tool must be there; a spindle that the program has not started turns at the set-up's speed."""
        modal = self.modal
        if modal.unloaded:
            raise ToolpathError(
                f"a cut without a tool: T0 put it away in line {modal.unloaded}", hint="load a tool before it"
            )
        if self._never_turned and modal.spindle and modal.speed == 0.0 and self.defaults.spindle_rpm:
            raise ToolpathError(
                "a cut with the spindle switched on at S0, which lets it stand, where the set-up has it turn (spindle_rpm)",
                hint="program its speed, or take spindle_rpm out where the spindle is to stand",
            )
        if not self._started and self.defaults.spindle_rpm:
            self.given_speed = modal.speed or self.defaults.spindle_rpm
            self.speed_of_file = bool(modal.speed)
            modal.speed, modal.spindle, modal.stopped = self.given_speed, "CLW", False
            self._started = self._speed_given = True

    def rpm(self) -> float:
        """The speed that is stated, or else the set-up's; 0.0 where there is neither."""
        return self.modal.speed if self.modal.speed is not None else self.defaults.spindle_rpm or 0.0

    def _spindle_off(self, line: int) -> None:
        self._nameless, self._speed_given = 0, False
        if self.modal.spindle:
            self.path.event(EventKind.SPINDLE_OFF, 0.0, "", line)
        self.modal.spindle = ""

    def _coolant_off(self, line: int) -> None:
        if self.modal.coolant:
            self.path.event(EventKind.COOLANT_OFF, 0.0, "", line)
        self.modal.coolant = False
