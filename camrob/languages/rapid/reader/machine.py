"""What single RAPID statements do: motions, data, settings, waits, outputs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from camrob.errors import ProgramError
from camrob.findings import Finding, Severity
from camrob.languages.rapid.reader.arguments import arguments_of
from camrob.languages.rapid.reader.collected_rows import CollectedRows, Modal, Target
from camrob.languages.rapid.reader.data import Data, array_of, numbers
from camrob.languages.rapid.reader.expressions import UnknownError, Value, indices_of
from camrob.languages.rapid.reader.frames_in_force import FramesInForce
from camrob.languages.rapid.reader.tokens import Row, Statement, Token, joined, shown
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import ProgramAction, Setting
from camrob.units import mm_to_m

__all__ = ["KNOWN", "LEAVING", "MOVES", "RapidMachine"]

MOVES = ("MOVEABSJ", "MOVEJ", "MOVEL", "MOVEC")
_SWITCHES = ("NOEOFFS", "WOBJ")  # of motions, that are read
_SETTINGS = frozenset("CONFJ CONFL SINGAREA CIRPATHMODE ACCSET VELSET PATHACCLIM PDISPOFF EOFFSOFF ACTUNIT".split())
_ACTS = frozenset(
    """SETDO SETAO SETGO SET RESET PULSEDO INVERTDO STOP BREAK TPWRITE TPERASE TPREADFK WAITDI WAITDO WAITUNTIL WAITROB
    WAITAI WAITGI CLKRESET CLKSTART CLKSTOP UIMSGBOX OPEN CLOSE WRITE ERRWRITE SPYSTART SPYSTOP""".split()
)
_COUNTS = ("INCR", "DECR", "CLEAR", "ADD")
KNOWN = _SETTINGS | _ACTS | {*MOVES, *_COUNTS, "WAITTIME"}
"""The controller's own procedures that are read; one of a program's own hides the controller's."""
LEAVING = KNOWN - {*_COUNTS, "TPREADFK"}
"""Those that give no datum another value."""
# what a VAR without a value holds
_FIRST: dict[str, Value] = {"NUM": 0.0, "DNUM": 0.0, "BOOL": False, "STRING": "", "POS": [0.0, 0.0, 0.0]}
_NAN = float("nan")
_SPEED_FACTS = ("v_ori", "v_leax", "v_reax")


class RapidMachine:
    """The state of a program that is being read: data, what is in force, rows, findings, counts.

    All methods raise ProgramError, with the line, for what can't be read.
    """

    def __init__(self) -> None:
        self.data = Data()
        self.frames = FramesInForce(self.data)
        self.rows = CollectedRows()
        self.statements: Counter[str] = Counter()
        self.findings: list[Finding] = []
        self.actions: list[ProgramAction] = []
        self.settings: dict[str, Setting] = {}
        self.file = 0
        self.acceleration = _NAN
        self.top = math.inf  # m/s: VelSet's most for the tip
        self.by_configuration = True  # ConfJ\On, the default
        self.circle = "PathFrame"  # the default: the tool turns with the circle
        self._slowest = math.inf  # v_ori so far, degrees/s
        self._said: dict[str, str] = {}

    def find(self, code: str, text: str, line: int, severity: Severity = Severity.WARNING) -> None:
        """Notes a finding."""
        self.findings.append(Finding(code, text, severity, line))

    def act(self, statement: Statement) -> None:
        """Notes what a statement does beside moving."""
        self.actions.append(ProgramAction(self.rows.count, joined(statement.tokens)))

    def declare(self, statement: Statement) -> bool:
        """CONST, VAR or PERS; False for another statement."""
        tokens = list(statement.tokens)
        local = bool(tokens) and tokens[0].text == "LOCAL"
        while tokens and tokens[0].text in ("LOCAL", "TASK"):
            tokens.pop(0)
        if len(tokens) < 3 or tokens[0].text not in ("CONST", "VAR", "PERS") or tokens[2].kind != "name":
            return False
        kind, name = tokens[1].text, tokens[2].text
        first = _FIRST.get(kind) if tokens[0].text == "VAR" else None
        value: Value | None = None
        at, sizes = _braced(tokens, 3)
        try:
            counts = indices_of(sizes, self.data) if sizes else ()
            value = array_of(counts, first)
            if tokens[at : at + 1] and tokens[at].text == ":=":
                value = self.data.value(tokens[at + 1 :])
                _hold(value, counts)
        except UnknownError:
            value = None
        self.data.declare(
            kind + "{}" * (1 + sum(t.text == "," for t in sizes) if sizes else 0), name, value, local=local
        )
        return True

    def assign(self, statement: Statement, *, noted: bool = True) -> bool:
        """`a.b{3}.c := value`; False for another statement. noted: among what the program does beside moving."""
        tokens = statement.tokens
        texts = [t.text for t in tokens]
        if len(texts) < 3 or tokens[0].kind != "name" or ":=" not in texts:
            return False
        at, path = 1, list[str | tuple[int, ...]]([tokens[0].text])
        known = True
        while at < len(tokens) and texts[at] in (".", "{"):
            if texts[at] == "{":
                at, inside = _braced(tokens, at)
                try:
                    path.append(indices_of(inside, self.data))
                except UnknownError:
                    known = False
            else:
                path.append(texts[at + 1] if at + 1 < len(texts) else "")
                at += 2
        if at >= len(tokens) or texts[at] != ":=":
            return False
        self._put(path if known else path[:1], tokens[at + 1 :] if known else ())
        if noted:
            self.act(statement)
        return True

    def known(self, tokens: Sequence[Token]) -> Value | None:
        """What an expression is worth, None where the text does not say it."""
        try:
            return self.data.value(tokens)
        except UnknownError:
            return None

    def lose(self, statement: Statement) -> None:
        """A statement that may have run: what it sets is known no more."""
        texts = [t.text for t in statement.tokens]
        if ":=" in texts or statement.word in _COUNTS:
            before = len(texts) if statement.word in ("IF", *_COUNTS) else texts.index(":=")
            for token in statement.tokens[:before]:
                self.data.assign([token.text], None)

    def _put(self, path: Sequence[str | tuple[int, ...]], tokens: Sequence[Token]) -> None:
        """Sets a datum to what an expression is worth; to nothing that is known where the text doesn't say it."""
        self.data.assign(path, self.known(tokens))

    def _count(self, statement: Statement) -> None:
        """Incr, Decr, Clear and Add."""
        word, tokens = statement.word, statement.tokens[1:]
        plus, minus, one, zero = (Token("sign", "+"), Token("sign", "-"), Token("number", "1"), Token("number", "0"))
        name = tokens[:1]
        if word == "ADD" and len(tokens) > 2 and tokens[1].text == ",":
            made = (*name, plus, Token("sign", "("), *tokens[2:], Token("sign", ")"))
        elif word != "ADD" and len(tokens) == 1:
            made = {"INCR": (*name, plus, one), "DECR": (*name, minus, one), "CLEAR": (zero,)}[word]
        else:
            made = ()
        self._put([name[0].text if name else ""], made)

    def simple(self, statement: Statement) -> bool:
        """A setting, a wait, an output; False for a statement that is none of these."""
        word = statement.word
        if word == "WAITTIME":
            self._wait(statement)
        elif word in _SETTINGS:
            self._set(statement)
        elif word in _COUNTS:
            self._count(statement)
        elif word not in _ACTS:
            return False
        self.act(statement)
        return True

    def _wait(self, statement: Statement) -> None:
        arguments = arguments_of(statement)
        try:
            if len(arguments.places) != 1 or set(arguments.options) - {"INPOS"}:
                raise UnknownError
            seconds = self.data.value(arguments.places[0])
        except UnknownError:
            self.find("wait-unknown", "WaitTime with a time that is not in the program", statement.line)
            return
        if isinstance(seconds, bool | str | list) or not 0.0 <= seconds < math.inf:
            raise ProgramError(f"WaitTime of {seconds}"[:60], hint="a time is positive", line=statement.line)
        self.rows.wait += float(seconds)

    def _set(self, statement: Statement) -> None:
        """How the robot moves from here on."""
        word, texts, line = statement.word, [t.text for t in statement.tokens], statement.line
        if word == "CONFJ":
            self.by_configuration = texts[-1] == "ON"
        elif word == "CIRPATHMODE":
            self.circle = {"OBJECTFRAME": "ObjectFrame", "PATHFRAME": "PathFrame"}.get(texts[-1], texts[-1])
        elif word == "SINGAREA" and texts[-1] != "OFF":
            self.find("not-understood", "SingArea: the tool may turn otherwise than programmed", line)
        elif word == "VELSET":
            self._override(statement)
        elif word == "PATHACCLIM":
            arguments = arguments_of(statement)
            limits = [self._number(arguments.options[n]) for n in ("ACCMAX", "DECELMAX") if n in arguments.options]
            self.acceleration = min(limits) if limits else _NAN

    def _override(self, statement: Statement) -> None:
        """VelSet: speeds in percent, and the tip's most, mm/s."""
        shares = [self._number(tokens) for tokens in arguments_of(statement).places]
        if len(shares) != 2 or shares[0] != 100.0 or not shares[1] > 0.0:
            self.find("not-understood", "VelSet: speeds are others than programmed", statement.line)
        else:
            self.top = mm_to_m(shares[1])

    def _number(self, tokens: Sequence[object]) -> float:
        try:
            value = self.data.value(tokens)  # type: ignore[arg-type]
        except UnknownError:
            return _NAN
        return _NAN if isinstance(value, bool | str | list) else float(value)

    def row(self, row: Row) -> None:
        """A MoveL that was read at one go."""
        zone, tool, wobj = row.names
        v = row.numbers
        speed = (
            float(row.speed + "e-3") if "E" not in row.speed else mm_to_m(v[11])
        )  # mm/s, behind 11 numbers of the target
        target = Target(v[0:3], v[3:7], (), row.external)
        self.statements["MOVEL"] += 1
        self._moved(Motion.LIN, [target], speed, v[11:15], self._named(zone, row.line), tool, wobj, row.line)

    def move(self, statement: Statement) -> None:
        """MoveAbsJ, MoveJ, MoveL or MoveC."""
        word, line = statement.word, statement.line
        arguments = arguments_of(statement)
        strange = sorted(set(arguments.options) - set(_SWITCHES))
        if strange:
            self.find("not-understood", f"{word} with \\{strange[0]}"[:80], line)
        count = 2 if word == "MOVEC" else 1
        if len(arguments.places) != count + 3:  # targets, speed, zone, tool
            raise ProgramError(
                f"{shown(joined(statement.tokens))} has not all its arguments",
                hint="a motion has a target (MoveC two), speed, zone, tool",
                line=line,
            )
        by_axes = word == "MOVEABSJ"
        targets = [self._target(tokens, by_axes, word == "MOVEJ", line) for tokens in arguments.places[:count]]
        speed = numbers(self._value(arguments.places[count], line), 4, "the speed")  # speeddata
        tool = joined(arguments.places[count + 2])
        wobj = joined(arguments.options["WOBJ"]) if "WOBJ" in arguments.options else "WOBJ0"
        kind = {"MOVEABSJ": Motion.PTP_AXES, "MOVEJ": Motion.PTP_POSE, "MOVEL": Motion.LIN, "MOVEC": Motion.CIRC_END}[
            word
        ]
        metres = float(f"{speed[0]!r}e-3") if "e" not in repr(speed[0]) else mm_to_m(speed[0])  # of mm/s
        zone = self._value(arguments.places[count + 1], line)
        self._moved(kind, targets, metres, speed, zone, tool, wobj, line)

    def _target(self, tokens: Sequence[object], by_axes: bool, turned: bool, line: int) -> Target:
        """A robtarget or a jointtarget."""
        value = self._value(tokens, line)
        if not isinstance(value, list) or len(value) != (2 if by_axes else 4):
            raise ProgramError("the motion's target is none", hint="give literal targets", line=line)
        if by_axes:
            return Target(None, (), numbers(value[0], 6, "the target"), numbers(value[1], 6, "the target"))
        place, rotation = numbers(value[0], 3, "the target"), numbers(value[1], 4, "the target")
        conf, external = numbers(value[2], 4, "the configuration"), numbers(value[3], 6, "the target")
        if not turned or not self.by_configuration:
            return Target(place, rotation, (), external)
        return Target(place, rotation, (), external, *_branch(conf, line))

    def _value(self, tokens: Sequence[object], line: int) -> Value:
        try:
            return self.data.value(tokens)  # type: ignore[arg-type]
        except UnknownError as unknown:
            what = f"needs {str(unknown)[:60]}, which is not in the program"
            raise ProgramError(what, hint="give a program with literal targets", line=line) from None

    def _named(self, name: str, line: int) -> Value:
        kind, value = self.data.find(name)
        if value is None or kind != "ZONEDATA":
            raise ProgramError(
                f"needs {name[:40]}, which is not in the program",
                hint="declare it in a module of the program",
                line=line,
            )
        return value

    def _moved(
        self,
        kind: Motion,
        targets: Sequence[Target],
        speed: float,
        speeddata: Sequence[float],
        zone: Value,
        tool: str,
        wobj: str,
        line: int,
    ) -> None:
        """One motion, with what is said of it now and was not before."""
        if not isinstance(zone, list) or len(zone) != 7 or not isinstance(zone[0], bool):
            raise ProgramError("the motion's zone is none", hint="give fine, z0 to z200, or a zonedata", line=line)
        if not all(0.0 < v < math.inf for v in speeddata):
            raise ProgramError("a speed that is not positive", hint="a speed is positive", line=line)
        ptp = kind < Motion.LIN
        rest = ", ".join(f"{v!r}" for v in (speeddata if ptp else speeddata[1:]))
        self._say("speed of joint motions" if ptp else " ".join(_SPEED_FACTS), rest)
        if not zone[0]:
            self._say("zone", ", ".join(repr(v) for v in zone[1:]))
        load = self.frames.load_text(tool)
        if load:
            self._say("load", load)
        if not ptp:
            self._turns(float(speeddata[1]))
        if kind == Motion.CIRC_END:
            self.settings["arc_turning"] = Setting("CirPathMode", self.circle, "ObjectFrame")
        blend = Blend.EXACT if zone[0] else Blend.DISTANCE
        distance = _NAN if zone[0] else numbers(zone[1:], 6, "the zone")[0]
        at = Modal(
            0.0 if ptp else min(speed, self.top),
            self.acceleration,
            blend,
            distance,
            self.frames.tool(tool),
            self.frames.base(wobj),
            self.file,
            line,
        )
        if kind == Motion.CIRC_END:
            via = Modal(at.speed, at.acceleration, Blend.EXACT, at.blend_mm, at.tool, at.base, at.file, line)
            self.rows.add(Motion.CIRC_VIA, targets[0], via)
        self.rows.add(kind, targets[-1], at)

    def _turns(self, v_ori: float) -> None:
        """How fast the tool turns: the slowest that is said."""
        self._slowest = min(self._slowest, v_ori)
        if self._slowest == v_ori:
            self.settings |= {name: Setting("v_ori", v_ori) for name in ("turn_speed", "roll_speed")}

    def _say(self, what: str, text: str) -> None:
        """Notes, where a motion names it, what the motion before did not."""
        if self._said.get(what) != text:
            self._said[what] = text
            self.actions.append(ProgramAction(self.rows.count, f"{what} {text}"))


def _braced(tokens: Sequence[Token], at: int) -> tuple[int, Sequence[Token]]:
    """The place behind `{...}`, and what stands in it; nothing where none begins at `at`."""
    if at >= len(tokens) or tokens[at].text != "{":
        return at, ()
    end = next((k for k in range(at, len(tokens)) if tokens[k].text == "}"), len(tokens))
    return end + 1, tokens[at + 1 : end]


def _hold(value: Value | None, counts: Sequence[int]) -> None:
    """Raises UnknownError for an array of another size than it is declared with."""
    if not counts:
        return
    if not isinstance(value, list) or len(value) != counts[0]:
        raise UnknownError("an array of another size")
    for one in value:
        _hold(one, counts[1:])


def _branch(conf: Sequence[float], line: int) -> tuple[int, int]:
    """Status and turn of a confdata: cfx says the branch, cf1, cf4, cf6 the quarters, packed as `Turning.QUARTERS` has them."""
    if (
        any(v != int(v) for v in conf) or not 0 <= conf[3] <= 7 or any(not -8 <= v <= 7 for v in conf[:3])
    ):  # three, four bits
        raise ProgramError(f"a configuration of {[f'{v:g}' for v in conf]}", hint="cf1, cf4, cf6, cfx", line=line)
    cfx = int(conf[3])
    status = (cfx >> 2 & 1) + 2 * (1 - (cfx >> 1 & 1)) + 4 * (cfx & 1)
    packed = np.dot(np.array([int(v) + 8 for v in conf[:3]]), np.array([256, 16, 1]))  # four bits each, from -8
    return status, int(packed)
