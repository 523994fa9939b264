"""LinuxCNC's O words, parameters and expressions (LinuxCNC user manual, "G-code overview" and "O codes")."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import Control
from camrob.toolpath.gcode.language.called_files import Wanted, calls
from camrob.toolpath.gcode.language.computed import words_of
from camrob.toolpath.gcode.language.flow import DEEPEST, Line, StepCount, prepared, unset
from camrob.toolpath.gcode.language.formulas import (
    ARITHMETIC,
    COMPARISONS,
    FUNCTIONS,
    LOGIC,
    NOTHING,
    Grammar,
    Reader,
    Value,
    whole,
)
from camrob.toolpath.gcode.lexer import Block, assemble

__all__ = ["LINUXCNC"]

_WORDS = "SUB|ENDSUB|CALL|RETURN|IF|ELSEIF|ELSE|ENDIF|WHILE|ENDWHILE|DO|REPEAT|ENDREPEAT|BREAK|CONTINUE"
O_WORDS = re.compile(
    rf"(?:\bO[ \t]*(?:[0-9]+|<[^>]*>|\[[^\]]*\])[ \t]*(?:{_WORDS})\b|#[ \t]*<|\*\*|EXISTS[ \t]*\[)", re.I
)
"""What only LinuxCNC's programs have."""

_NOT_ITS = re.compile(
    r"\b(?:IF|WHILE|GOTO)[ \t]*[\[#0-9]|\bG6[56](?![0-9.])|\bM9[789](?![0-9])|^[ \t]*[$?~!]|^[ \t]*O[0-9]+[ \t]*(?:[(;]|\r?$)",
    re.I | re.M,
)
_O = re.compile(rf"O([0-9]+|<[^>]*>|\[.*?\]|#.*?)({_WORDS})(.*)")
_DEFINED = re.compile(r"^[ \t]*O[ \t]*(<[^>]*>|[0-9]+)[ \t]*SUB\b")
_CALLED = re.compile(r"^[ \t]*O[ \t]*(<[^>]*>|[0-9]+)[ \t]*CALL\b")
_NEVER = re.compile(r"(?!)")  # a file names no program of its own: its o word does
_OPENS = {"ENDWHILE": "WHILE", "ENDREPEAT": "REPEAT", "ENDIF": "IF", "ENDSUB": "SUB"}
_OWN = range(1, 31)  # of each subroutine
_FREE = (range(31, 5000),)
_GRAMMAR = Grammar(
    levels=(
        LOGIC,
        COMPARISONS,
        {k: ARITHMETIC[k] for k in "+-"},
        {k: ARITHMETIC[k] for k in ("*", "/", "MOD")},
        {"**": ARITHMETIC["**"]},
    ),
    functions={
        **{k: v for k, v in FUNCTIONS.items() if k != "ATAN"},
        "ATAN": lambda x: _alone(x),
        "FIX": lambda x: float(math.floor(x)),
        "FUP": lambda x: float(math.ceil(x)),
    },
)


def _alone(x: float) -> float:
    raise ToolpathError("ATAN of one number", hint="LinuxCNC has ATAN[a]/[b]")


@dataclass(slots=True)
class _Call:
    """A subroutine that is being run: its end, where it goes back to, and its own parameters."""

    label: str
    back: int
    numbered: dict[int, float]
    named: dict[str, float] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)  # repeats that are left, by the line of their REPEAT


def _run_o_words(lines: list[str], path: Path) -> Iterator[Block]:
    """The blocks that the program gives when it is run. Raises ToolpathError with its line for what only a machine knows."""
    yield from _Program(lines, path).run()


class _Program:
    """One file that is being run."""

    def __init__(self, lines: list[str], path: Path) -> None:
        self._path = path
        self._lines: list[Line] = []
        self._count = StepCount()
        self._globals: dict[str, float] = {}
        self._numbered: dict[int, float] = {}
        self._stack = [_Call("", -1, {})]
        self._at = 0
        self._subs: dict[str, tuple[int, int]] = {}
        self._ends: dict[int, int] = {}  # of each opening statement, the line of its end
        self._begins: dict[int, int] = {}  # the other way round
        self._branches: dict[int, list[int]] = {}  # IF and its ELSEIFs and ELSE, by the line of the IF
        self._of_branch: dict[int, int] = {}
        for index, raw in enumerate(lines):
            try:
                self._lines.append(prepared(raw, index + 1))
            except ToolpathError as error:
                raise error.at(path, index + 1) from None
        self._structure()

    def _structure(self) -> None:
        """Find each statement's partner."""
        opened: list[tuple[str, str, int]] = []
        for index, line in enumerate(self._lines):
            match = _O.fullmatch(line.text) if line.text.startswith("O") else None
            if match is None:
                continue
            label, word = match[1], match[2]
            try:
                self._partner(opened, label, word, index)
            except ToolpathError as error:
                raise error.at(self._path, index + 1) from None
        if opened:
            label, word, index = opened[-1]
            raise ToolpathError(f"O{label} {word} without its end", hint="close it", path=self._path, line=index + 1)

    def _partner(self, opened: list[tuple[str, str, int]], label: str, word: str, index: int) -> None:
        if label[0] in "[#" and word != "CALL":
            raise ToolpathError("a computed O word", hint="write its number")
        top = opened[-1] if opened else ("", "", -1)
        if word == "WHILE" and top[:2] == (label, "DO"):
            self._pair(opened.pop()[2], index)
        elif word in ("SUB", "IF", "WHILE", "DO", "REPEAT"):
            opened.append((label, word, index))
            if word == "IF":
                self._branches[index] = []
        elif word in _OPENS:
            if top[:2] != (label, _OPENS[word]):
                raise ToolpathError(f"O{label} {word} without its {_OPENS[word]}", hint="check the O words' numbers")
            self._pair(opened.pop()[2], index)
            if word == "ENDSUB":
                if label in self._subs:
                    raise ToolpathError(f"O{label} is defined twice", hint="keep one of them")
                self._subs[label] = (self._begins[index], index)
        elif word in ("ELSEIF", "ELSE"):
            if top[:2] != (label, "IF"):
                raise ToolpathError(f"O{label} {word} without its IF", hint="check the O words' numbers")
            self._branches[top[2]].append(index)
            self._of_branch[index] = top[2]
        elif word in ("BREAK", "CONTINUE"):
            around = [o for o in opened if o[0] == label and o[1] in ("WHILE", "DO", "REPEAT")]
            if not around:
                raise ToolpathError(f"O{label} {word} outside of its loop", hint="check the O words' numbers")
            self._of_branch[index] = around[-1][2]

    def _pair(self, begin: int, end: int) -> None:
        self._ends[begin], self._begins[end] = end, begin

    # -- running -----------------------------------------------------------------------------------------------

    def run(self) -> Iterator[Block]:
        """The blocks, one after the other."""
        while self._at < len(self._lines):
            index = self._at
            line = self._lines[index]
            self._at += 1
            if not (line.text or line.comment):
                continue
            try:
                self._count.one(line.number)
                match = _O.fullmatch(line.text) if line.text.startswith("O") else None
                if match is not None:
                    self._o_word(match[1], match[2], match[3], index)
                else:
                    yield from self._words(line)
            except ToolpathError as error:
                raise error.at(self._path, line.number) from None

    def _words(self, line: Line) -> Iterator[Block]:
        """A block: parameters are set behind it, as LinuxCNC does it."""
        if line.text.startswith("%"):
            yield Block(line.number, {}, percent=True)
            return
        reader = Reader(line.text, _GRAMMAR, self._variable)
        found, settings = [], []
        while reader.rest:
            if reader.rest[0] == "#":
                settings.append(self._setting(reader))
            else:
                found += words_of(reader, stops="#")
        for name, value in settings:
            self._store(name, value)
        if found or line.comment:
            yield assemble(found, line.number, line.comment, line.optional)

    def _setting(self, reader: Reader) -> tuple[int | str, float]:
        """#5=, #<name>=: which parameter, and its value."""
        reader.at += 1
        name = self._name(reader)
        if not reader.take("="):
            raise reader.fail()
        value = reader.operand() if reader.rest[:1] not in ("+", "-") else reader.expression(len(_GRAMMAR.levels))
        if value is NOTHING or value is None:
            raise reader.fail()
        return name, value

    def _o_word(self, label: str, word: str, rest: str, index: int) -> None:
        here = self._stack[-1]
        if word == "SUB":
            self._at = self._ends[index] + 1
        elif word in ("RETURN", "ENDSUB"):
            self._return(rest)
        elif word == "CALL":
            self._call(label, rest)
        elif word == "IF":
            self._if(index, rest)
        elif word in ("ELSEIF", "ELSE"):
            self._at = self._ends[self._of_branch[index]] + 1
        elif word == "WHILE" and index in self._begins:  # of a DO
            if self._true(rest):
                self._at = self._begins[index] + 1
        elif word == "WHILE":
            if not self._true(rest):
                self._at = self._ends[index] + 1
        elif word == "ENDWHILE":
            self._at = self._begins[index]
        elif word == "REPEAT":
            here.counts[index] = max(0, whole(self._values(rest)[0], "REPEAT"))
            self._repeat(index)
        elif word == "ENDREPEAT":
            self._repeat(self._begins[index])
        elif word == "BREAK":
            self._at = self._ends[self._of_branch[index]] + 1
        elif word == "CONTINUE":
            end = self._ends[self._of_branch[index]]
            self._at = end

    def _repeat(self, begin: int) -> None:
        counts = self._stack[-1].counts
        if counts[begin] > 0:
            counts[begin] -= 1
            self._at = begin + 1
        else:
            self._at = self._ends[begin] + 1

    def _if(self, index: int, rest: str) -> None:
        if self._true(rest):
            return
        for branch in self._branches[index]:
            match = _O.fullmatch(self._lines[branch].text)
            if match is not None and (match[2] == "ELSE" or self._true(match[3])):
                self._at = branch + 1
                return
        self._at = self._ends[index] + 1

    def _call(self, label: str, rest: str) -> None:
        if label[0] in "[#":
            raise ToolpathError("a computed O word", hint="write its number")
        place = self._subs.get(label)
        if place is None:
            raise ToolpathError(
                f"O{label} is called, and it is not in this file: it is the machine's own",
                hint="put it into the file, or have the path written out as plain blocks",
            )
        if len(self._stack) > DEEPEST:
            raise ToolpathError(f"subroutines nested more than {DEEPEST} deep", hint="check for one that calls itself")
        arguments = self._values(rest) if rest else []
        if len(arguments) > len(_OWN):
            raise ToolpathError("a call with more than 30 arguments", hint="check the call")
        own = {number: 0.0 for number in _OWN} | dict(enumerate(arguments, 1))
        self._stack.append(_Call(label, self._at, own))
        self._at = place[0] + 1

    def _return(self, rest: str) -> None:
        if len(self._stack) == 1:
            raise ToolpathError("RETURN outside of a subroutine", hint="check the O words")
        if rest:
            value = self._values(rest)[0]
            self._globals["_VALUE"], self._globals["_VALUE_RETURNED"] = value, 1.0
        else:
            self._globals["_VALUE"], self._globals["_VALUE_RETURNED"] = 0.0, 0.0
        self._at = self._stack.pop().back

    # -- values ------------------------------------------------------------------------------------------------

    def _values(self, text: str) -> list[float]:
        """Expressions in brackets, one behind the other."""
        reader, found = Reader(text, _GRAMMAR, self._variable), []
        while reader.rest:
            value = reader.operand()
            if value is NOTHING or value is None:
                raise reader.fail()
            found.append(value)
        if not found:
            raise ToolpathError("an O word without its expression", hint="put it into brackets")
        return found

    def _true(self, text: str) -> bool:
        return bool(self._values(text)[0])

    def _name(self, reader: Reader) -> int | str:
        """Which parameter a # that has been read names."""
        match = re.match(r"<([^>]*)>", reader.rest)
        if match:
            reader.at += match.end()
            return match[1]
        number = reader.number()
        if number is not None:
            return whole(number, "parameter #")
        value = reader.operand() if reader.rest.startswith("#") else reader.bracketed()
        if value is NOTHING or value is None:
            raise reader.fail("a parameter without its number")
        return whole(value, "parameter #")

    def _store(self, name: int | str, value: float) -> None:
        if isinstance(name, str):
            (self._globals if name.startswith("_") else self._stack[-1].named)[name] = value
        elif name in _OWN:
            self._stack[-1].numbered[name] = value
        elif any(name in free for free in _FREE):
            self._numbered[name] = value
        else:
            raise ToolpathError(
                f"#{name} is set, a parameter of the machine's: it may move an origin or an offset",
                hint="take the assignment out where it means nothing for the path",
            )

    def _variable(self, reader: Reader) -> Value:
        match = re.match(r"EXISTS\[#<([^>]*)>\]", reader.rest)
        if match:
            reader.at += match.end()
            held = self._globals if match[1].startswith("_") else self._stack[-1].named
            return float(match[1] in held)
        if not reader.take("#"):
            return NOTHING
        name = self._name(reader)
        if isinstance(name, str):
            held = self._globals if name.startswith("_") else self._stack[-1].named
            if name not in held:
                raise unset(f"#<{name.lower()}>")
            return held[name]
        numbered = self._stack[-1].numbered if name in _OWN else self._numbered
        if name not in numbered:
            raise unset(f"#{name}")
        return numbered[name]


def _wanted(lines: list[str]) -> list[Wanted]:
    """The subroutines that are called and that the text doesn't define: o<name> call runs name.ngc (manual, "Calling files")."""
    own = set(calls(_DEFINED, lines))
    return [
        Wanted(f"O{label}", frozenset((label.strip("<>").lower(),)), frozenset((".ngc",)), "", _NEVER)
        for label in calls(_CALLED, lines)
        if label not in own
    ]


def _recognise(text: str) -> int:
    """More than ISO where the text has what only LinuxCNC has; less than a suffix is worth where it has what it hasn't."""
    return 3 if O_WORDS.search(text) else -1 if _NOT_ITS.search(text) else 0


LINUXCNC = Control(
    "linuxcnc",
    "LinuxCNC",
    _recognise,
    lambda lines, path, state: _run_o_words(lines, path),
    plain=True,
    zero_edge=False,  # D0 may mean the tool in the spindle
    rereads=True,
    suffixes=frozenset({".ngc"}),
    wanted=_wanted,
)
