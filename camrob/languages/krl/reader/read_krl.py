"""The reader of KRL, by any post. It shares nothing with the writer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import KrlError
from camrob.findings import Severity, collapse
from camrob.frozen import sealed
from camrob.languages.krl.reader.control_flow import Flow, leave_loop
from camrob.languages.krl.reader.expressions import Expression, Unknown, Value, place_of
from camrob.languages.krl.reader.known import MESSAGES
from camrob.languages.krl.reader.machine import KrlMachine
from camrob.languages.krl.reader.module import Block, Module, Routine, load_module, no_program_of_its_own
from camrob.languages.krl.reader.settings import run_settings
from camrob.languages.krl.reader.splines import SPLINES, begin_block, only_begins, spline_motion
from camrob.languages.krl.reader.tokens import Token, handed, mark_of, shown, tokens_of
from camrob.languages.krl.reader.variables import declare, is_declaration, load_data
from camrob.languages.krl.reader.with_words import with_words
from camrob.program.motion import Turning
from camrob.program.program_text import ProgramFrame, ProgramText

__all__ = ["read_krl"]

_DEEPEST_CALL = 20  # nested calls: beyond any real program's, short of Python's own limit
_MOST_PASSES = 200_000  # of loops and calls: beyond it a loop that never ends is the likelier reading
_BULK_STEPS = 2  # statements that take as long as a run of usual lines of a kind, each
_PER_LINE = 10  # a long program may call more: the time to read it stays in proportion to its text
_MOST_REPEATED = {"statements": 5_000, "motions": 1_000_000}  # by loops and calls: 0.3 s, 0.5 GB
_MOTIONS = frozenset(("PTP", "LIN", "CIRC", "PTP_REL", "LIN_REL"))
_MOST_JUMPS = 500  # GOTOs: programs that jump do it a few times
_UNREAD = frozenset("""CIRC_REL SCIRC_REL SPL_REL PTP_SPLINE ASYPTP CASE DEFAULT LIN_SPLINE""".split())
_HARMLESS = frozenset(
    """EXT EXTFCT IMPORT SIGNAL STRUC ENUM CHANNEL INTERRUPT TRIGGER PULSE HALT CONTINUE BRAKE RESUME ANIN ANOUT DIGIN
    CWRITE CREAD COPEN CCLOSE SREAD SWRITE ASYSTOP ASYCONT ASYCANCEL ERR_RAISE CONFIRM ON_ERROR_PROCEED""".split()
)
_DECLARED = frozenset(("EXT", "EXTFCT", "IMPORT", "SIGNAL", "STRUC", "ENUM", "CHANNEL"))
_IN_COLUMNS = ("$VEL.CP", "$TOOL", "$BASE")
_LATER = frozenset(("ELSE", "ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "UNTIL", "ENDSWITCH", "ENDSPLINE"))
_STRUCTURE = frozenset(("WAIT", "IF", "FOR", "WHILE", "LOOP", "REPEAT", "SWITCH", "CASE", "DEFAULT"))
_STATE = ("$VEL", "$ACC", "$APO", "$BASE", "$TOOL", "$IPO_MODE", "FDAT_ACT", "LDAT_ACT", "$ACT_BASE", "$ACT_TOOL")

_NOTHING: Mapping[str, Value] = MappingProxyType({})


def read_krl(path: Path, known: Mapping[str, Value] = _NOTHING) -> ProgramText:
    """Reads a .src file with its .dat, $config.dat, and the parts that it calls, all of its folder, in the order of running.

    known: what the controller holds, by its name. Raises KrlError, with file and line, for what can't be read honestly: a
    motion whose target is not in the program, a kind of motion that is not read here, a loop or a branch that moves and whose
    course is not known, damage. What may have an effect that is not known here becomes a finding. Cost: about a microsecond a
    usual LIN, 100 for any other statement.
    """
    return _Reader(Path(path), known).program()


class _JumpError(Exception):
    """GOTO: the line to go on with."""

    def __init__(self, line: int) -> None:
        super().__init__(line)
        self.line = line


class _Reader:
    """Runs a program: routines, control structures, calls."""

    def __init__(self, path: Path, known: Mapping[str, Value]) -> None:
        self._path = path
        self._machine = KrlMachine()
        self._machine.variables.shared.update(known)
        self._modules: list[Module] = []
        self._data: dict[int, dict[str, Value]] = {}
        self._by_name: dict[str, Module | None] = {}
        self._beside: dict[str, Path] | None = None
        self._depth = self._passes = self._jumps = 0
        self._calling: Module | None = None  # whose routine runs
        self._returned: Value | None = None  # by the function that has just ended
        self._flow = Flow(self._machine.variables, self._run, self._passed)
        self._machine.variables.own_function = self._function
        self._room = dict(_MOST_REPEATED)

    def program(self) -> ProgramText:
        """Reads and runs everything."""
        self._configure()
        main = self._load(self._path)
        self._by_name[self._path.stem.upper()] = main
        if main.main.name != self._path.stem.upper():
            text = f"the first routine is {shown(main.main.name)}, not {shown(self._path.stem)}"
            self._machine.find("name", text, main.main.start, Severity.INFO)
        with no_program_of_its_own(main.main):
            self._call(main, main.main, [])
        columns = (machine := self._machine).rows.columns()
        used = [k for k, values in enumerate(columns["external"].T) if k < 6 and (values == values).any()]
        columns["external"] = sealed(columns["external"][:, used])
        tools, bases = (_used(machine.frames[name], columns, name) for name in ("tool", "base"))
        return ProgramText(
            name=main.main.name,
            files=tuple(m.path.name for m in self._modules),
            external_names=tuple(f"E{k + 1}" for k in used),
            final_wait=machine.rows.modal.wait,
            actions=tuple(machine.actions),
            tools=tools,
            bases=bases,
            statements=machine.statements,
            settings=run_settings(machine.variables.shared),
            findings=tuple(collapse(machine.said((*tools, *bases)))),
            language="krl",
            turning=Turning.SIGNS,
            **columns,
        )

    def _configure(self) -> None:
        """What a $config.dat beside the program declares; the controller's own has words of options that are not read here."""
        if config := self._siblings().get("$config.dat"):
            variables = self._machine.variables
            try:
                variables.shared.update(load_data(config, variables))
            except KrlError as error:
                self._machine.find("config-unread", f"$config.dat is left out: {error}", 0)

    def _load(self, path: Path) -> Module:
        """A file and its data list."""
        module = load_module(path, len(self._modules))
        self._modules.append(module)
        self._room["statements"] += _PER_LINE * (1 + len(module.scan.general))
        self._room["motions"] += len(module.scan.lin_line) + len(module.scan.speed_line)
        data = self._siblings().get(path.stem.lower() + ".dat")
        self._data[module.index] = {} if data is None else load_data(data, self._machine.variables)
        return module

    def _siblings(self) -> dict[str, Path]:
        """Files of the program's folder by lower-case name; links that lead out of it are left out."""
        if self._beside is None:
            folder = self._path.resolve().parent
            files = (p for p in folder.iterdir() if p.suffix.lower() in (".src", ".dat") and p.is_file())
            self._beside = {p.name.lower(): p for p in files if p.resolve().parent == folder}
        return self._beside

    def _call(self, module: Module, routine: Routine, arguments: list[Value]) -> dict[str, Value]:
        """Runs a routine; the values of its parameters afterwards."""
        self._depth += 1
        self._pass()
        if self._depth > _DEEPEST_CALL:
            raise KrlError(f"calls are nested more than {_DEEPEST_CALL} deep", hint="does a routine call itself?")
        variables = self._machine.variables
        outside = variables.scopes
        local = {
            name: arguments[k] if k < len(arguments) else Unknown(name) for k, name in enumerate(routine.parameters)
        }
        caller, self._calling = self._calling, module
        variables.scopes = (local, self._data[module.index])
        self._run(module, routine.start, routine.end)
        variables.scopes, self._calling = outside, caller
        self._depth -= 1
        return local

    def _pass(self) -> None:
        """Counts calls and passes of loops, so that reading ends."""
        self._passes += 1
        if self._passes > _MOST_PASSES:
            raise KrlError(f"more than {_MOST_PASSES} calls and passes of loops", hint="a loop runs away")

    def _passed(self) -> None:
        """Counts a pass of a loop."""
        self._pass()
        self._spend("statements", 1)

    def _spend(self, what: str, count: int) -> None:
        """Counts what is carried out against what is written, so that reading ends soon and fits into memory."""
        self._room[what] -= count
        if self._room[what] < 0:
            more = f"calls and passes of loops carry out many more {what} than are written"
            raise KrlError(more, hint="if no loop runs away, post the program as a plain sequence")

    def _bulk(self, module: Module, start: int, end: int) -> None:
        """The usual lines among `start` to `end` (exclusive)."""
        scan = module.scan
        for lines in (scan.lin_line, scan.speed_line):
            first, last = lines.searchsorted([start, end])
            self._spend("motions", int(last - first))
            if first < last:
                self._spend("statements", _BULK_STEPS)
        self._machine.bulk(module, start, end)

    def _run(self, module: Module, start: int, end: int) -> bool:
        """Runs lines `start` to `end` (exclusive); False where a RETURN was met."""
        general = module.scan.general
        at, k = start, int(general.searchsorted(start))
        try:
            while k < len(general) and (line := int(general[k])) < end:
                if line > at:
                    self._bulk(module, at, line)
                at = line + 1
                text = module.statements.get(line)
                if text is not None:
                    try:
                        at = self._statement(module, line, text)
                    except _JumpError as jump:
                        if not start <= jump.line <= end:
                            raise
                        at = jump.line
                    if at < 0:
                        return False
                k = k + 1 if at == line + 1 else int(general.searchsorted(at))
            line = at
            if at < end:
                self._bulk(module, at, end)
        except KrlError as error:
            raise error.at(module.path, line + 1) from None
        return True

    def _statement(self, module: Module, line: int, text: str) -> int:
        """Runs one statement; the line to go on with, -1 for RETURN."""
        self._spend("statements", 1)
        tokens = tokens_of(text)
        word = tokens[0].text if tokens[0].kind == "name" else ""
        machine = self._machine
        if word in SPLINES and tokens[1].text not in ("=", "[", ".", "("):
            spline_motion(machine, tokens, module.index, line + 1)
        elif word in _MOTIONS:
            machine.motion(tokens, module.index, line + 1)
        elif word == "GOTO":
            self._jump(module, line, tokens[1].text)
        elif len(tokens) == 3 and tokens[1].text == ":":
            machine.statements["mark"] += 1
        elif line in module.blocks and tokens[1].text != "=":
            return self._block(module, module.blocks[line], word, tokens)
        elif word in _UNREAD:
            raise KrlError(f"{word} is not read here", hint="post the program without it")
        elif word == "RETURN":
            machine.statements[word] += 1
            self._returned = None if tokens[1].kind == "end" else Expression(tokens, machine.variables, 1).value()
            return -1
        elif word == "EXIT":
            leave_loop(module, line)
        elif word == "WAIT":
            machine.act(text)
            machine.wait(tokens, line + 1)
        elif word == "BAS" and tokens[1].text == "(":
            machine.act(text)
            machine.bas(tokens, line + 1)
        elif word in _HARMLESS or (word == "GLOBAL" and tokens[1].text == "INTERRUPT"):
            machine.statements[tokens[1].text if word == "GLOBAL" else word] += 1
            if word == "STRUC":
                machine.variables.structure(tokens)
            if word not in _DECLARED:
                machine.act(text)
        elif word in _LATER:
            raise KrlError(f"{word} without its beginning", hint="the file is damaged")
        elif word and is_declaration(tokens):
            machine.statements["DECL"] += 1
            declare(tokens, machine.variables, machine.variables.scopes[0])
        else:
            self._other(module, line, text, tokens)
        return line + 1

    def _jump(self, module: Module, line: int, name: str) -> None:
        """Goes to a mark of the same routine, in no block but the GOTO's own or one round it."""
        routine = next(r for r in module.routines.values() if r.start <= line < r.end)
        marks = [at for at in range(routine.start, routine.end) if mark_of(module.statements.get(at, "")) == name]
        outside = len(marks) == 1 and any(
            block.start < marks[0] < block.end and not block.start < line < block.end
            for block in module.blocks.values()
        )
        if len(marks) != 1 or outside:
            raise KrlError(f"GOTO {shown(name)} leads to no mark that it may reach", hint="post a plain sequence")
        self._jumps += 1
        if self._jumps > _MOST_JUMPS:
            raise KrlError(f"more than {_MOST_JUMPS} GOTOs are carried out", hint="the program may never end")
        raise _JumpError(marks[0] + 1)

    def _other(self, module: Module, line: int, text: str, tokens: tuple[Token, ...]) -> None:
        """An assignment or a call; anything else is noted."""
        machine = self._machine
        expression = Expression(tokens, machine.variables)
        path = expression.path() if tokens[0].kind == "name" else ""
        if path and expression.accept("="):
            if path.startswith("$") and path not in _IN_COLUMNS:
                machine.act(text)
            machine.assign(expression, path, line + 1)
        elif self._shows_message(module, tokens):
            machine.statements["call"] += 1
            machine.act(text)
        elif path and expression.next.text == "(" and "." not in path and "[" not in path:
            self._routine_call(module, line, text, path, tokens, expression)
        else:
            machine.find("not-understood", f"{shown(text)!r} is not understood", line + 1)

    def _routine_call(
        self, module: Module, line: int, text: str, name: str, tokens: tuple[Token, ...], expression: Expression
    ) -> None:
        """Runs a routine of this file, or of the file of its name beside it."""
        machine = self._machine
        machine.statements["call"] += 1
        names = [place_of(argument, machine.variables) for argument in handed(tokens, expression.at)]
        arguments = expression.arguments()
        found = (module, module.routines[name]) if name in module.routines else self._external(name)
        if found is None:
            what = f"{shown(name)}(...) is not in the folder: what it does, and whether it moves, is not known"
            machine.find("call-unknown", what, line + 1)
            machine.act(text)
            return
        after, routine = self._call(*found, arguments), found[1]
        for k, parameter in enumerate(routine.parameters[: len(arguments)]):
            unsaid = parameter in routine.unsaid and (after[parameter] != arguments[k] or "?" in names[k])
            if names[k] and parameter in routine.outputs and "?" not in names[k]:
                machine.variables.assign(names[k], after[parameter])
            elif names[k] and (unsaid or parameter in routine.outputs):  # handed back perhaps, or nobody knows where
                machine.variables.assign(names[k], Unknown(names[k]))

    def _function(self, name: str, arguments: list[Value]) -> Value | None:
        """The value of a DEFFCT that the program brings, which must not move; None where it brings none."""
        module = self._calling
        found = (module, module.routines[name]) if module and name in module.routines else self._external(name)
        if found is None:
            return None
        before, self._returned = self._machine.rows.count, None
        self._call(*found, arguments)
        if self._machine.rows.count != before:
            raise KrlError(f"{name}(...) moves, and is a value", hint="call it by itself")
        returned, self._returned = self._returned, None
        return Unknown(f"{name}(...)") if returned is None else returned

    def _external(self, name: str) -> tuple[Module, Routine] | None:
        """The routine that the file of this name begins with, None where there is no such file."""
        if name not in self._by_name:
            path = self._siblings().get(name.lower() + ".src")
            self._by_name[name] = None if path is None else self._load(path)
        module = self._by_name[name]
        return None if module is None else (module, module.main)

    def _block(self, module: Module, block: Block, word: str, tokens: tuple[Token, ...]) -> int:
        """Runs a control structure whose course is known; the line to go on with, -1 for RETURN."""
        self._machine.statements[word] += 1
        if word == "PTP_SPLINE":
            raise KrlError("PTP_SPLINE is not read here", hint="write its motions as PTP")
        if word == "SPLINE":
            with with_words(self._machine):
                begin_block(self._machine, module, block, tokens)
                ended = self._run(module, block.start + 1, block.end)
            return block.end + 1 if ended else -1
        if word == "IF" and only_begins(module, block, tokens):
            return block.end + 1 if self._run(module, block.start + 1, block.end) else -1
        goes_on = self._flow.block(module, block, word, tokens)
        if goes_on is None:
            self._skip(module, block, word)
        return -1 if goes_on is False else block.end + 1

    def _skip(self, module: Module, block: Block, word: str) -> None:
        """Passes over a control structure whose course is not known. Raises KrlError where that could hide a motion."""
        scan = module.scan
        lin, speed = (lines.searchsorted([block.start, block.end]) for lines in (scan.lin_line, scan.speed_line))
        moving = lin[0] < lin[1] or speed[0] < speed[1]
        inside = scan.general[slice(*scan.general.searchsorted([block.start + 1, block.end]))].tolist()
        for line in inside:
            text = module.statements.get(line)
            if text is not None and not moving:
                moving = self._matters(module, tokens_of(text), self._machine.variables.assign)
        if moving:
            what = f"{word} whose course is not known, with motions or calls inside"
            raise KrlError(what, hint="post the program as a plain sequence")
        text = f"{word} ... is passed over: it doesn't move, and its course is not known"
        self._machine.find("block-skipped", text, block.start + 1, Severity.INFO)

    def _shows_message(self, module: Module, tokens: tuple[Token, ...]) -> bool:
        """Whether a statement calls a routine of the controller's that shows a message; what it answers becomes unknown."""
        name = tokens[0].text
        if name not in MESSAGES or tokens[1].text != "(" or name in module.routines or self._external(name):
            return False
        for token in tokens[2:-1]:
            if token.kind == "name":
                self._machine.variables.assign(token.text, Unknown(token.text))
        return True

    def _matters(self, module: Module, tokens: tuple[Token, ...], assign: Callable[[str, Value], None]) -> bool:
        """Whether a statement that may not run could change a motion; a variable that it sets becomes unknown."""
        word = tokens[0].text
        if word in _MOTIONS or word in _UNREAD - {"CASE", "DEFAULT"} or word in ("BAS", "EXIT", "RETURN"):
            return True
        if word in _HARMLESS | _LATER | _STRUCTURE or self._shows_message(module, tokens):
            return False
        expression = Expression(tokens, self._machine.variables)
        path = expression.path() if tokens[0].kind == "name" else ""
        if path and expression.accept("="):
            assign(path, Unknown(path))
            return path.startswith(_STATE)
        return True


def _used(frames: list[ProgramFrame], columns: dict[str, NDArray[Any]], name: str) -> tuple[ProgramFrame, ...]:
    """The frames that a motion uses; the column `name` is changed to count them."""
    used, columns[name] = np.unique(columns[name], return_inverse=True)
    return tuple(frames[k] for k in used)
