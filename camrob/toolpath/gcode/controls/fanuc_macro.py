"""Fanuc's custom macro B, as Haas and Mitsubishi have it, too: variables, IF, WHILE, GOTO, M98, M97, M99 and G65 within one file.

Fanuc B-63944EN/03, chapter 15 (custom macro) and 13.3 (subprograms); Haas mill manual, "Macros".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import State
from camrob.toolpath.gcode.controls.fanuc_formulas import FANUC
from camrob.toolpath.gcode.controls.fanuc_programs import PROGRAM, REPEATS, spelled, split_programs
from camrob.toolpath.gcode.language.computed import words_of
from camrob.toolpath.gcode.language.flow import DEEPEST, Line, StepCount, prepared, unset
from camrob.toolpath.gcode.language.formulas import NOTHING, Reader, Value, whole
from camrob.toolpath.gcode.lexer import Block, Word, assemble, without_corner

__all__ = ["INCREMENT", "SUBPROGRAMS", "run_macro"]

SUBPROGRAMS = re.compile(
    r"M[ \t]*0*9[789](?![0-9.])|G[ \t]*0*6[567](?![0-9.])|#|\[|\b(?:IF|WHILE|GOTO|END[0-9]+|DO[0-9]+)\b", re.I
)
"""What a file holds that has to be run, not only read."""

_WHILE = re.compile(r"WHILE(\[.*\])DO([0-9]+)$")
_THEN = re.compile(r"IF(\[.*\])THEN(.+)$")
_JUMP = re.compile(r"IF(\[.*\])GOTO(.+)$")
_SET = re.compile(r"#(?:[0-9]+|\[.*?\]|#.*?)=")
_LOCALS = range(1, 34)
_COMMONS = (range(100, 200), range(500, 1000))
# modal information, and where the tool stands in the program's coordinates, as `Interpreter.state` calls it
_MODAL = {
    4001: "motion",
    4002: "plane",
    4003: "distance",
    4005: "feed mode",
    4006: "units",
    4010: "return",
    4109: "F",
    4119: "S",
    **{number + i: letter for number in (5001, 5041) for i, letter in enumerate("XYZ")},
}
_HARMLESS = (range(3001, 3006), range(3100, 3200))  # timers, single block and feed hold, what a screen shows
_ALARM, _STOP = 3000, 3006
_OF_LINUXCNC = range(34, 5001)  # the program's own there ("Parameters"), as far as Fanuc's macros have other variables
# G65's letters by Fanuc's first list; those that are no length count as they are written, the others need their point
_ARGUMENTS = dict(zip("ABCDEFHIJKMQRSTUVWXYZ", (1, 2, 3, 7, 8, 9, 11, 4, 5, 6, 13, *range(17, 27)), strict=True))
_COUNTS = frozenset("DHMST")
_MOST_REPEATS = 9_999  # L has four digits
INCREMENT = 1e-3
"""mm or degrees: the least increment of Fanuc's system IS-B, in which it counts numbers without a point."""


@dataclass(slots=True)
class _Run:
    """A program that is being run: its lines from `first` to before `end`, where it goes on, and its own variables."""

    first: int
    end: int
    at: int
    variables: dict[int, Value]
    name: str
    repeats: int = 0
    back: int = 0  # where a repeat begins
    loops: list[tuple[int, int]] = field(default_factory=list)  # numbers of the DOs that are open, and where


def run_macro(lines: list[str], path: Path, state: State) -> Iterator[Block]:
    """The blocks that the program gives when it is run. Raises ToolpathError with its line for what only a machine knows."""
    yield from _Macro(lines, path, state).run()


class _Macro:
    """One file that is being run."""

    def __init__(self, lines: list[str], path: Path, state: State) -> None:
        self._raw, self._path, self._state = lines, path, state
        self._lines: dict[int, Line] = {}
        self._count = StepCount()
        self._commons: dict[int, Value] = {}
        self._programs, main = split_programs(lines, self._line, path)
        self._stack = [_Run(*main, at=main[0], variables={}, name="the program")]

    def _line(self, index: int) -> Line:
        line = self._lines.get(index)
        if line is None:
            try:
                line = prepared(self._raw[index], index + 1)
                line = self._lines[index] = line._replace(text=spelled(line.text))
            except ToolpathError as error:
                raise error.at(self._path, index + 1) from None
        return line

    # -- running -----------------------------------------------------------------------------------------------

    def run(self) -> Iterator[Block]:
        """The blocks, one after the other."""
        while self._stack:
            running = self._stack[-1]
            if running.at >= running.end:
                if len(self._stack) == 1:
                    return
                raise ToolpathError(
                    f"{running.name} ends without M99", hint="end it with M99", path=self._path, line=running.end
                )
            line = self._line(running.at)
            running.at += 1
            if not (line.text or line.comment):
                continue
            try:
                self._count.one(line.number)
                if line.optional:
                    yield Block(line.number, {}, optional=True)
                yield from self._one(line)
            except ToolpathError as error:
                raise error.at(self._path, line.number) from None

    def _one(self, line: Line) -> Iterator[Block]:
        """One line."""
        text = line.text
        if text.startswith("%"):
            yield Block(line.number, {}, percent=True)
        elif PROGRAM.fullmatch(text):
            if line.comment:
                yield Block(line.number, {}, comment=line.comment)
        elif match := _JUMP.match(text):
            if self._true(match[1]):
                self._go_to(self._number(match[2], "GOTO"))
        elif match := _THEN.match(text):
            if self._true(match[1]):
                yield from self._one(line._replace(text=match[2], comment=""))
        elif match := _WHILE.match(text):
            self._while(match[1], int(match[2]))
        elif re.fullmatch(r"DO[0-9]+", text):
            self._open(int(text[2:]))
        elif re.fullmatch(r"END[0-9]+", text):
            self._close(int(text[3:]))
        elif text.startswith("GOTO"):
            self._go_to(self._number(text[4:], "GOTO"))
        elif text.startswith(("IF", "WHILE", "ELSE", "ENDIF", "SETVN", "POPEN", "DPRNT", "BPRNT", "PCLOS")):
            if not text.startswith(("POPEN", "DPRNT", "BPRNT", "PCLOS")):  # these only write to a printer
                raise ToolpathError(
                    f"a statement that can't be read: {text[:24]}",
                    hint="IF [...] GOTO, IF [...] THEN or WHILE [...] DO",
                )
        elif _SET.match(text):
            yield from self._set(line)
        else:
            yield from self._words(line)

    def _set(self, line: Line) -> Iterator[Block]:
        """An assignment."""
        reader = self._reader(line.text)
        reader.at = 1
        number = self._index(reader)
        if not reader.take("="):
            raise reader.fail()
        value = reader.expression()
        if reader.rest:
            raise reader.fail(f"{reader.rest[:16]!r} behind an assignment")
        if number == _ALARM:
            raise ToolpathError(
                f"the program stops itself with an alarm (#3000 {line.comment})".replace(" )", ")"),
                hint="the condition before it has failed: check the macro's arguments",
            )
        if number == _STOP:
            yield Block(line.number, {}, m=(0,), comment=line.comment)
            return
        if number in _LOCALS:
            self._stack[-1].variables[number] = value
        elif any(number in common for common in _COMMONS):
            self._commons[number] = value
        elif not any(number in harmless for harmless in _HARMLESS):
            raise ToolpathError(
                f"#{number} is set, {_whose(number)}: it may move an origin or an offset of the machine",
                hint="take the assignment out where it means nothing for the path",
            )
        if line.comment:
            yield Block(line.number, {}, comment=line.comment)

    def _words(self, line: Line) -> Iterator[Block]:
        """A block of words, with or without a call."""
        text, corner = without_corner(line.text)
        found = words_of(self._reader(text))
        letters = {letter for letter, _, _ in found}
        codes = {(letter, round(value * 10.0)) for letter, value, _ in found if letter in "GM" and abs(value) < 1e5}
        calls = codes & {("M", 970), ("M", 980), ("M", 990), ("G", 650), ("G", 660), ("G", 661)}
        if not calls:
            yield assemble(found, line.number, line.comment)._replace(corner=corner)
            return
        if len(calls) > 1 or corner is not None:
            raise ToolpathError("two calls, or a call and a corner, in one block", hint="split the block")
        (call,) = calls
        if call == ("G", 650):
            self._call_macro(found, letters)
            return
        if call[0] == "G":
            raise ToolpathError("a modal macro call (G66)", hint="have the CAM system write plain blocks")
        kept = [w for w in found if w[0] not in "PL" and not (w[0] == "M" and abs(w[1] * 10.0 - call[1]) <= 0.5)]
        if kept:
            yield assemble(kept, line.number, line.comment)
        value = {letter: value for letter, value, _ in found if letter in "PL"}
        if call[1] == 990:
            yield from self._return(value, line)
        else:
            self._call(call[1] == 970, value)

    # -- jumps and loops ---------------------------------------------------------------------------------------

    def _go_to(self, label: int) -> None:
        """To the block with that N word: the next one, or the first of the program where none follows."""
        running = self._stack[-1]
        for index in (*range(running.at, running.end), *range(running.first, running.at)):
            raw = self._raw[index].lstrip(" \t/0123456789")
            if raw[:1] in "Nn" and self._line(index).label == label:
                running.at = index
                return
        raise ToolpathError(f"N{label} is jumped to, and {running.name} has no such block", hint="check the GOTO")

    def _while(self, condition: str, number: int) -> None:
        running = self._stack[-1]
        begin = running.at - 1
        if self._true(condition):
            self._open(number)
            return
        running.loops = [loop for loop in running.loops if loop != (number, begin)]
        for index in range(running.at, running.end):
            if self._line(index).text == f"END{number}":
                running.at = index + 1
                return
        raise ToolpathError(f"DO{number} without its END{number}", hint="close the loop")

    def _open(self, number: int) -> None:
        running = self._stack[-1]
        begin = (number, running.at - 1)
        while begin in running.loops or any(loop[0] == number for loop in running.loops):
            running.loops.pop()
        running.loops.append(begin)

    def _close(self, number: int) -> None:
        running = self._stack[-1]
        while running.loops and running.loops[-1][0] != number:
            running.loops.pop()  # left by a GOTO
        if not running.loops:
            raise ToolpathError(f"END{number} without its DO{number}", hint="don't jump into a loop")
        running.at = running.loops[-1][1]

    # -- calls -------------------------------------------------------------------------------------------------

    def _call(self, local: bool, value: dict[str, float]) -> None:
        """M98 P, or Haas's M97 P to a block of the same program."""
        if "P" not in value:
            raise ToolpathError("a subprogram call without P", hint="name its number by P")
        number, times = whole(value["P"], "P"), whole(value.get("L", 1.0), "L")
        caller = self._stack[-1]
        if local:
            self._push(_Run(caller.first, caller.end, caller.at, caller.variables, f"the part at N{number}"), times)
            self._go_to(number)
            self._stack[-1].back = self._stack[-1].at
            return
        if number not in self._programs and number >= REPEATS and "L" not in value:
            times, number = divmod(number, REPEATS)
        first, end = self._program(number)
        self._push(_Run(first, end, first, caller.variables, f"O{number}", back=first), times)

    def _call_macro(self, found: list[Word], letters: set[str]) -> None:
        """G65 P with arguments."""
        value = {letter: value for letter, value, _ in found}
        if "P" not in value:
            raise ToolpathError("G65 without P", hint="name the macro's number by P")
        rest = [w for w in found if w[0] not in "GPLN"]
        strange = [letter for letter, _, _ in rest if letter not in _ARGUMENTS]
        if (
            strange
            or len(found) - len(rest) > len({letter for letter, _, _ in found} & set("GPLN"))
            or len({letter for letter, _, _ in rest}) != len(rest)
        ):
            raise ToolpathError(
                "G65 with a letter twice, or with one that carries no argument",
                hint="use A to Z once each, but G, L, N, O, P",
            )
        arguments: dict[int, Value] = {}
        for letter, number, is_whole in rest:
            if is_whole and number and letter not in _COUNTS:
                raise ToolpathError(
                    f"G65 with {letter}{number:g} without a decimal point: what it is worth depends on the control",
                    hint=f"write {letter}{number:g}. or {letter}{number * INCREMENT:g}",
                )
            arguments[_ARGUMENTS[letter]] = number
        number = whole(value["P"], "P")
        first, end = self._program(number)
        self._push(_Run(first, end, first, arguments, f"O{number}", back=first), whole(value.get("L", 1.0), "L"))

    def _program(self, number: int) -> tuple[int, int]:
        place = self._programs.get(number)
        if place is None:
            raise ToolpathError(
                f"O{number} is called, and it is not in this file: it is the machine's own",
                hint="append it to the file, or have the path written out as plain blocks",
            )
        return place

    def _push(self, run: _Run, times: int) -> None:
        if not 0 <= times <= _MOST_REPEATS:
            raise ToolpathError(f"{times} repeats of a subprogram", hint=f"a whole number up to {_MOST_REPEATS}")
        if len(self._stack) > DEEPEST:
            raise ToolpathError(f"subprograms nested more than {DEEPEST} deep", hint="check for one that calls itself")
        if times:
            run.repeats = times - 1
            self._stack.append(run)

    def _return(self, value: dict[str, float], line: Line) -> Iterator[Block]:
        """M99: back to the caller, or to the block P of it; in the main program, back to its beginning."""
        running = self._stack[-1]
        if len(self._stack) == 1:
            if "P" in value:
                self._go_to(whole(value["P"], "P"))
                return
            yield Block(line.number, {}, m=(300,), again=True)
            running.at = running.end
            return
        if running.repeats and "P" not in value:
            running.repeats -= 1
            running.at = running.back
            running.loops.clear()
            return
        self._stack.pop()
        if "P" in value:
            self._go_to(whole(value["P"], "P"))

    # -- values ------------------------------------------------------------------------------------------------

    def _reader(self, text: str) -> Reader:
        return Reader(text, FANUC, self._variable)

    def _true(self, condition: str) -> bool:
        reader = self._reader(condition)
        value = reader.expression()
        if reader.rest:
            raise reader.fail()
        return bool(value)

    def _number(self, text: str, what: str) -> int:
        reader = self._reader(text)
        value = reader.operand()
        if value is NOTHING or value is None or reader.rest:
            raise reader.fail()
        return whole(value, what)

    def _index(self, reader: Reader) -> int:
        """The number of a variable whose # has been read: #5, ##5, #[#5+1]."""
        digits = re.match(r"[0-9]+", reader.rest)
        if digits:
            reader.at += len(digits[0])
            return int(digits[0])
        value = reader.operand() if reader.rest.startswith("#") else reader.bracketed()
        if value is NOTHING or value is None:
            raise reader.fail("a variable without its number")
        return whole(value, "variable #")

    def _variable(self, reader: Reader) -> Value:
        if not reader.take("#"):
            return NOTHING
        number = self._index(reader)
        running = self._stack[-1]
        if number == 0:
            return None
        if number in _LOCALS:
            if number in running.variables:
                return running.variables[number]
            if len(self._stack) == 1 or running.variables is self._stack[0].variables:
                raise unset(f"#{number}", given="G65 gives this macro")
            return None
        if any(number in common for common in _COMMONS):
            if number not in self._commons:
                raise unset(f"#{number}")
            return self._commons[number]
        known = self._state(_MODAL[number]) if number in _MODAL else None
        if known is None:
            raise ToolpathError(
                f"#{number} is read, {_whose(number)}: what it holds is the machine's state",
                hint="have the path written out as plain blocks",
            )
        return known


def _whose(number: int) -> str:
    """What a variable is that is none of the program's own; LinuxCNC's programs are known by their O words alone."""
    if number not in _OF_LINUXCNC:
        return "a system variable"
    return "a system variable of Fanuc's macros (a program of LinuxCNC's, where it is free, is known by its O words)"
