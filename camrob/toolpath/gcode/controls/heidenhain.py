"""Heidenhain's plain language: L, LN, CC, C, CR, CP, TOOL CALL, M128, FUNCTION TCPM, PLANE, cycles 7 and 200, Q, LBL.

Heidenhain, "TNC 640 User's Manual, Klartext Programming" (34059x-10): 6.4 contours, 10.3 Q parameters, 12.2 PLANE, 12.5 LN.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import Control, State
from camrob.toolpath.gcode.controls.heidenhain_moves import HeidenhainMoves
from camrob.toolpath.gcode.language.called_files import Wanted, calls
from camrob.toolpath.gcode.language.flow import DEEPEST, StepCount, unset
from camrob.toolpath.gcode.language.formulas import (
    ARITHMETIC,
    COMPARISONS,
    FUNCTIONS,
    NOTHING,
    Grammar,
    Reader,
    Value,
    whole,
)
from camrob.toolpath.gcode.lexer import Block
from camrob.units import rad_to_deg

__all__ = ["HEIDENHAIN"]

_BEGIN = re.compile(r"^[ \t]*(?:N?[0-9]+[ \t]+)?BEGIN[ \t]+PGM[ \t]", re.M)
_GRAMMAR = Grammar(
    levels=({k: ARITHMETIC[k] for k in "+-"}, {k: ARITHMETIC[k] for k in "*/"}, {"^": ARITHMETIC["^"]}),
    functions={
        **{k: FUNCTIONS[k] for k in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "ABS", "LN", "EXP")},
        "INT": lambda x: _cut_off(x),
        "FRAC": lambda x: x - _cut_off(x),
        "NEG": lambda x: -x,
        "SQ": lambda x: x * x,
    },
    opens="(",
    closes=")",
    bare=True,
)
_CALLED = re.compile(r'\bCALL[ \t]+PGM[ \t]*("[^"]*"|[^\s";]+)', re.I)
_BESIDE = "BEGIN CALLED "  # before the text of a program from a file beside
_NEVER = re.compile(r"(?!)")  # its name is the file's
_FN = {"0": None, "1": "+", "2": "-", "3": "*", "4": "/", "5": "SQRT", "6": "SIN", "7": "COS", "8": "LEN", "13": "ANG"}
_BETWEEN = {
    "1": r" ?\+ (?=[-+Q0-9])",
    "2": r" ?- (?=[-+Q0-9])",
    "3": r" ?\* ?",
    "4": r" ?DIV ?",
    "8": " ?LEN ?",
    "13": " ?ANG ?",
}
_OF_TWO: dict[str, Callable[[float, float], float]] = {
    **{sign: ARITHMETIC[sign] for sign in "+-*/"},
    "LEN": math.hypot,
    "ANG": lambda a, b: rad_to_deg(math.atan2(a, b)) % 360.0,  # the side across from the angle, and the one beside it
}
_IF = {"9": "EQ", "10": "NE", "11": "GT", "12": "LT"}
_JUMP = re.compile(r"FN ?(9|10|11|12) ?: ?IF ?(.+?) (?:EQU|NE|GT|LT) ?(.+?) GOTO LBL ?(.+)$")
_ASSIGN = re.compile(r"FN ?([0-8]|13) ?: ?(Q[LR]?[0-9]+) ?= ?(.+)$")
_DECIMAL = re.compile(r"(?<=[0-9]),(?=[0-9])")  # a comma for the point, as the control can be set to write it
_SPACED = re.compile(
    r"(?:L|LN|C|CR|CP|LP|CC|TOOL|TRANS|PLANE|CYCL CALL|CYCL DEF [1-9][0-9]?\.)"
)  # X + 90 is X+90 there
_SIGN = re.compile(r"(?<=[A-Z]) ?([-+]) ?(?=[.0-9Q])|(?<=DR) (?=[-+])")
_LABEL = re.compile(r'LBL ("[^"]*"|[0-9]+)$')
_CALL = re.compile(r'CALL LBL ("[^"]*"|[0-9]+)(?: REP ?([0-9]+|Q[LR]?[0-9]+)(?: ?/ ?(?:[0-9]+|Q[LR]?[0-9]+))?)?$')
_BARE_CYCLE = re.compile(r"CYCL DEF [2-4][0-9][0-9](?![.0-9])(?!.*Q[0-9]+ ?=).*")  # its parameters stand behind it
_REMARK = re.compile(r"\s*(?:\d+\s+)?;")
_TAKES_NO_BRACKETS = re.compile(r"/?[ \t]*(?:N?[0-9]+[ \t]+)?/?[ \t]*(?:L|LN|CC?|C[RPT]|LP|M[0-9]+|RND|CHF)\b", re.I)
# no control's: editors and teaching simulators let one stand behind a block
_REMARK_WITHIN = re.compile(r"\([^()]*\)?")
_PARAMETER = re.compile(r"Q[2-4][0-9][0-9] ?= ?[^ ]+")
_TOOL = re.compile(r'TOOL CALL ("[^"]*"|[0-9]+)')
_FREE = range(2000)  # from Q1600 on they are the user's, as Q0 to Q99 are
_OF_THE_CONTROL = range(100, 200)  # Q100 to Q199 the control fills in
_CYCLES_OWN = 200  # from here on they are those of cycles, too
_FEWER = range(500)  # QL and QR


def _cut_off(x: float) -> float:
    """The value without its decimals. Raises ToolpathError where rounding alone decides which whole number is left."""
    if 0.0 < abs(x - round(x)) < 1e-9:
        raise ToolpathError(f"INT or FRAC of {x!r}, which rounding decides", hint="write the number itself")
    return float(math.trunc(x))


class _Program:
    """One file that is being run, with those that it calls behind it."""

    def __init__(self, lines: list[str], path: Path, state: State) -> None:
        self._path = path
        self._count = StepCount()
        self._q: dict[str, float] = {}
        self._moves = HeidenhainMoves(self.value, lambda name: state(f"tool {name}"), self._keep)
        self._texts = _joined(lines)
        self._optional = {number for number, raw in enumerate(lines, 1) if raw.lstrip().startswith("/")}
        self._labels: dict[tuple[str, str], int] = {}  # by program and label
        self._programs: dict[str, int] = {}
        self._now = name = ""
        for index, (number, text) in enumerate(self._texts):
            if text.startswith(_BESIDE):
                name = text.removeprefix(_BESIDE)
                self._programs[name] = index + 1
            match = _LABEL.match(text)
            if match and match[1] != "0":
                if (name, match[1]) in self._labels:
                    raise ToolpathError(f"LBL {match[1]} appears twice", hint="keep one", path=path, line=number)
                self._labels[name, match[1]] = index
        called = {match[1] for _, text in self._texts if (match := _TOOL.match(text))}
        self._moves.one_name = len(called) == 1
        self._units = ""
        self._stack: list[int | tuple[int, str, dict[str, float]]] = []  # where to go on: of labels, and of programs
        self._repeats: dict[int, int] = {}
        self._at = 0

    def run(self) -> Iterator[Block]:
        """The blocks, one after the other."""
        while self._at < len(self._texts):
            number, text = self._texts[self._at]
            self._at += 1
            if text.startswith(_BESIDE):
                return
            try:
                self._count.one(number)
                if number in self._optional:
                    yield Block(number, {}, optional=True)
                if not self._flow(text):
                    self._moves.corner_ahead(self._texts[self._at][1] if self._at < len(self._texts) else "")
                    yield from self._moves.blocks(text, number)
            except ToolpathError as error:
                raise error.at(self._path, number) from None

    def _flow(self, text: str) -> bool:
        """Whether the text is one of labels, jumps and parameters, which is carried out."""
        if match := _LABEL.match(text):
            if match[1] == "0" and self._stack and isinstance(back := self._stack[-1], int):
                self._at = back
                self._stack.pop()
            return True
        if match := _CALL.match(text):
            self._call(match[1], match[2])
            return True
        if match := _JUMP.match(text):
            if COMPARISONS[_IF[match[1]]](self.value(match[2]), self.value(match[3])):
                self._at = self._label(match[4].strip())
            return True
        if match := _ASSIGN.match(text):
            self._store(match[2], self._function(match[1], match[3]))
            return True
        if match := re.match(r"(Q[LR]?[0-9]+) ?= ?(.+)$", text):
            self._store(match[1], self.value(match[2]))
            return True
        if text.startswith(("BEGIN PGM", "END PGM", "CALL PGM", "SEL PGM", "CALL SEL")) or self._now:
            return self._of_programs(text)
        return self._of_the_machine(text)

    def _of_programs(self, text: str) -> bool:
        """Where another program begins and ends, with labels and QL of its own, and the Q of the one that calls it."""
        if match := _CALLED.fullmatch(text):
            name = _called_name(match[1])
            if name not in self._programs or len(self._stack) > DEEPEST:
                raise ToolpathError(
                    f"{text[:32]}: another program is called, which is neither in this file nor beside it, or calls itself",
                    hint="put its file beside this one, or its motions here",
                )
            own = {k: self._q.pop(k) for k in [k for k in self._q if k.startswith("QL")]}
            self._stack.append((self._at, self._now, own))
            self._at, self._now = self._programs[name], name
            return True
        if text.startswith(("CALL PGM", "SEL PGM", "CALL SEL")):
            raise ToolpathError(f"{text[:32]}: a program by a selection or a table", hint="put its motions here")
        if text.startswith("BEGIN PGM") and self._now:
            if text.split()[-1] != self._units:
                raise ToolpathError(
                    "a program in another unit than the one that calls it", hint="write both in one unit"
                )
            return True
        if text.startswith("BEGIN PGM"):
            self._units = text.split()[-1]
        elif self._now and re.search(r"\bM(?:2|30|02)\b", text):
            raise ToolpathError("M2 or M30 in a program that is called", hint="take it out: the control stops there")
        elif text.startswith("END PGM") and self._now:
            back = self._stack.pop()
            while isinstance(back, int):  # of labels of its own
                back = self._stack.pop()
            for name in [k for k in self._q if k.startswith("QL")]:
                del self._q[name]
            self._at, self._now = back[0], back[1]
            self._q |= back[2]
            return True
        return self._of_the_machine(text)

    def _of_the_machine(self, text: str) -> bool:
        """Refuse what only a machine knows, and what isn't read."""
        if re.match(r"FN ?(?:1[78]|2[0-9])\b", text):
            raise ToolpathError(
                f"{text[:24]!r} asks for what the control holds: positions, tables, states",
                hint="put the values into the program, or have the CAM system write the motions out",
            )
        if text.startswith("ERROR"):
            raise ToolpathError(
                f"{text[:32]!r}: a block that the control could not read",
                hint="correct it at the control, and export it again",
            )
        if text.startswith(("FN", "QS", "CALL", "SEL")):
            raise ToolpathError(f"{text[:24]!r} is not read", hint="have the CAM system write the motions out")
        return False

    def _call(self, label: str, repeats: str | None) -> None:
        here = self._at - 1
        target = self._label(label)
        if repeats is None:
            if len(self._stack) > DEEPEST:
                raise ToolpathError(f"CALL LBL nested more than {DEEPEST} deep", hint="check for one that calls itself")
            self._stack.append(self._at)
            self._at = target
            return
        left = self._repeats.get(here, -1)
        left = whole(self.value(repeats), "REP") if left < 0 else left
        self._repeats[here] = left - 1
        if left > 0:
            self._at = target
        else:
            del self._repeats[here]

    def _label(self, name: str) -> int:
        if (self._now, name) not in self._labels:
            raise ToolpathError(f"LBL {name} is not there", hint="check the label")
        return self._labels[self._now, name] + 1

    # -- values ------------------------------------------------------------------------------------------------

    def _function(self, number: str, text: str) -> float:
        name = _FN[number]
        if name is None:
            return self.value(text)
        if number in "567":
            return FUNCTIONS[name](self.value(text.removeprefix(name)))
        parts = re.split(_BETWEEN[number], text.strip(), maxsplit=1)
        if len(parts) != 2:
            raise ToolpathError(f"FN {number} with {text[:24]!r} can't be read", hint="two values")
        return _OF_TWO[name](self.value(parts[0]), self.value(parts[1]))

    def _store(self, name: str, value: float) -> None:
        number = int(name.lstrip("QLR"))
        if name[1] in "LR":
            if number not in _FEWER:
                raise ToolpathError(f"{name} is set, which no control has", hint="use QL0 to QL499, QR0 to QR499")
        elif number in _OF_THE_CONTROL or number not in _FREE:
            raise ToolpathError(
                f"{name} is set, a parameter of the control's own", hint="use Q0 to Q99, or Q1600 to Q1999"
            )
        self._q[f"{name.rstrip('0123456789')}{number}"] = value
        if name[1] not in "LR" and number >= _CYCLES_OWN:
            self._moves.cycle.given(number, value)

    def _keep(self, number: int, value: float | None) -> None:
        """What a cycle gives a Q parameter, None where that is no number."""
        self._q.pop(f"Q{number}", None)
        if value is not None:
            self._q[f"Q{number}"] = value

    def value(self, text: str) -> float:
        """The value of a whole formula."""
        reader = Reader("".join(text.split()), _GRAMMAR, self._variable)
        value = reader.expression()
        if reader.rest or value is None:
            raise reader.fail()
        return value

    def _variable(self, reader: Reader) -> Value:
        match = re.match(r"(Q[LR]?)0*([0-9]+)", reader.rest)
        if match is None:
            if reader.take("PI"):
                return 3.141592653589793  # as the control has it
            return NOTHING
        name = match[1] + match[2]
        if name not in self._q:
            raise unset(name)
        reader.at += match.end()
        return self._q[name]


def _joined(lines: list[str]) -> list[tuple[int, str]]:
    """The program's statements with their lines: block numbers off, comments off, lines joined that end in ~, or that hold
    the parameters of a cycle that names none itself.
    """
    out: list[tuple[int, str]] = []
    goes_on = listed = remark = False
    for number, raw in enumerate(lines, 1):
        remark, before = bool(_REMARK.match(raw)) or remark, remark
        if remark and (before or raw.rstrip().endswith("~")):  # a comment that goes on in the next line
            remark = raw.rstrip().endswith("~")
            continue
        remark = False
        text = re.sub(r";.*", "", raw).strip()
        text = re.sub(r"\s+", " ", _REMARK_WITHIN.sub("", text) if _TAKES_NO_BRACKETS.match(text) else text).strip()
        ends = raw.rstrip().endswith("~")
        text = text.rstrip("~ ").strip()
        parts = re.split(r'("[^"]*")', text)
        text = "".join(part if i % 2 else _DECIMAL.sub(".", part.upper()) for i, part in enumerate(parts))
        listed = listed and _PARAMETER.fullmatch(text) is not None
        if (goes_on or listed) and out:
            out[-1] = (out[-1][0], f"{out[-1][1]} {text}")
        else:
            text = re.sub(r"^/? ?(?:N?[0-9]+(?: |$))?/? ?", "", text)
            text = _SIGN.sub(r"\1", text) if _SPACED.match(text) else text
            if text:
                out.append((number, text))
                listed = _BARE_CYCLE.fullmatch(text) is not None
        goes_on = ends
    begin = next((i for i, (_, text) in enumerate(out) if text.startswith("BEGIN PGM")), 0)
    return [row for i, row in enumerate(out) if i >= begin or not row[1].startswith("(")]  # a set-up sheet before it


def _called_name(text: str) -> str:
    """A program's name without its folder and suffix, as files are found by it."""
    return re.split(r"[\\/:]", text.strip('"').upper())[-1].partition(".")[0]


def _wanted(lines: list[str]) -> list[Wanted]:
    """The programs that CALL PGM names: PLAN.H of any folder lies in plan.h."""
    return [
        Wanted(name, frozenset((name.lower(),)), frozenset((".h", ".nc", ".txt", "")), f"{_BESIDE}{name}", _NEVER)
        for name in dict.fromkeys(_called_name(text) for text in calls(_CALLED, lines))
    ]


def _blocks(lines: list[str], path: Path, state: State) -> Iterator[Block]:
    return _Program(lines, path, state).run()


HEIDENHAIN = Control(
    "heidenhain",
    "Heidenhain",
    lambda text: 9 if _BEGIN.search(text) else 0,
    _blocks,
    "gcode-heidenhain",
    wanted=_wanted,
)
