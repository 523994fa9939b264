"""The reader of RAPID, by any post. It shares nothing with the writer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from camrob.errors import ProgramError
from camrob.findings import Severity, collapse
from camrob.languages.rapid.reader.arguments import arguments_of
from camrob.languages.rapid.reader.expressions import UnknownError, Value
from camrob.languages.rapid.reader.machine import KNOWN, LEAVING, MOVES, RapidMachine
from camrob.languages.rapid.reader.module import Module, Node, Routine, load_module, modules_beside
from camrob.languages.rapid.reader.own_functions import OwnFunctions
from camrob.languages.rapid.reader.rapid_course import BLOCKS, parts_of, run_block
from camrob.languages.rapid.reader.tokens import Row, Statement, joined, shown
from camrob.program.motion import Turning
from camrob.program.program_text import ProgramFrame, ProgramText

__all__ = ["read_rapid"]

_DEEPEST_CALL = 20  # nested calls: beyond any real program's, short of Python's own limit
_MOST_REPEATED = 100_000  # statements that calls may repeat beyond what is written, ten times over
_AGAIN = 10
_OTHER_MOVES = ("MOVE", "TRIGG", "SEARCH", "ARC", "INDA", "INDR", "INDC", "SYNCMOVE", "STARTMOVE", "STOREPATH", "EGM")
_FRAMES = ("PDISP", "EOFFS", "GRIPLOAD", "DEACTUNIT", "CORR", "SOFTACT", "WORLDACCLIM", "SPEEDREFRESH", "PATHRESOL")


def read_rapid(path: Path) -> ProgramText:
    """Reads NAME.mod, and the modules that NAME.pgf beside it lists, in the order of running: from PROC main, else the first.

    Raises ProgramError, with file and line, for what can't be read honestly: a target that is not in the program, a kind of
    motion that is not read here, a branch or loop that moves and whose course the text doesn't say, damage. What may have an
    effect that is not known here becomes a finding. Cost: about 15 microseconds a MoveL that camrob wrote, 200 for any other
    statement.
    """
    return _Reader(Path(path)).program()


class _LeftError(Exception):
    """RETURN."""


class _EndedError(Exception):
    """EXIT."""


class _Reader:
    """Runs a program: procedures and calls."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._machine = RapidMachine()
        self._modules: list[Module] = []
        self._routines: dict[tuple[int, str], tuple[int, Routine]] = {}  # LOCAL ones by their module, else -1
        self._depth = self._taken = 0
        machine = self._machine
        self._functions = OwnFunctions(machine.data, _carried_out(machine), self._take, lambda: machine.file)

    def program(self) -> ProgramText:
        """Reads and runs everything."""
        for file in (self._path, *modules_beside(self._path)):
            self._load(file)
        main = self._modules[0]
        if not main.routines:
            raise ProgramError("holds no procedure", hint="give the main module", path=self._path)
        first = next(iter(main.routines))
        with suppress(_EndedError):
            self._call(0, main.routines["MAIN" if "MAIN" in main.routines else first], [])
        machine = self._machine
        try:
            columns = machine.rows.columns()
        except ProgramError as error:
            raise error.at(self._path) from None
        used = [k for k in range(6) if not np.isnan(columns["external"][:, k]).all()]
        columns["external"] = columns["external"][:, used]
        tools, bases = (_used(frames, columns, name) for name, frames in _frames(machine).items())
        return ProgramText(
            name=main.name,
            files=tuple(m.path.name for m in self._modules),
            external_names=tuple(f"E{k + 1}" for k in used),
            final_wait=machine.rows.wait,
            actions=tuple(machine.actions),
            tools=tools,
            bases=bases,
            statements=machine.statements,
            settings=machine.settings,
            findings=tuple(collapse(machine.findings)),
            language="rapid",
            turning=Turning.QUARTERS,
            **columns,
        )

    def _load(self, path: Path) -> None:
        """A module: its data and its procedures."""
        module = load_module(path)
        self._modules.append(module)
        data = self._machine.data
        data.modules.append({})
        data.enter(data.modules[-1], None)
        for statement in module.declarations:
            if not self._machine.declare(statement):
                self._unknown(statement)
        for function in module.functions.values():
            self._functions.add(len(self._modules) - 1, function)
            if function.name in ("OFFS", "RELTOOL"):
                self._machine.find("not-understood", f"FUNC {function.name} hides the controller's own", function.line)
        for name, routine in module.routines.items():
            key = (len(self._modules) - 1 if routine.local else -1, name)
            if key in self._routines:
                raise ProgramError(
                    f"has a second procedure {shown(name)}", hint="give it another name", path=path, line=routine.line
                )
            if name in KNOWN:
                self._machine.find("not-understood", f"PROC {name} hides the controller's own", routine.line)
            self._routines[key] = (len(self._modules) - 1, routine)

    def _routine(self, name: str) -> tuple[int, Routine] | None:
        """A procedure of the program as its module sees it: its own LOCAL one first."""
        return self._routines.get((self._machine.file, name)) or self._routines.get((-1, name))

    def _call(self, index: int, routine: Routine, given: Sequence[Value | None]) -> None:
        """Runs a procedure with what it is handed by value."""
        self._depth += 1
        if self._depth > _DEEPEST_CALL:
            raise ProgramError(f"calls are nested more than {_DEEPEST_CALL} deep", hint="does a procedure call itself?")
        module, data = self._modules[index], self._machine.data
        kept = (self._machine.file, data.module, data.own)
        self._machine.file = index
        named = zip(routine.parameters or (), given, strict=True)
        data.enter(data.modules[index], {name: (kind, value) for (kind, name), value in named})
        try:
            with suppress(_LeftError):
                self._nodes(routine.nodes)
        except ProgramError as error:
            raise error.at(module.path) from None
        self._machine.file = kept[0]
        data.enter(*kept[1:])
        self._depth -= 1

    def _nodes(self, nodes: Sequence[Node]) -> None:
        """Statements one after another."""
        at = 0
        while at < len(nodes):
            node = nodes[at]
            self._take()
            if isinstance(node, Row):
                self._machine.row(node)
                at += 1
            elif node.word in BLOCKS:
                at = self._block(nodes, at, node)
            else:
                self._statement(node)
                at += 1

    def _take(self) -> None:
        """Counts statements and passes of loops, so that reading ends."""
        self._taken += 1
        if self._taken > _MOST_REPEATED + _AGAIN * sum(m.count for m in self._modules):
            raise ProgramError("takes more statements than any program", hint="does a loop or a call run away?")

    def _block(self, nodes: Sequence[Node], at: int, head: Statement) -> int:
        """A branch or a loop: the place behind it. Raises ProgramError for one that may move and whose course is not known."""
        parts, end = parts_of(nodes, at)
        why = ""
        if parts and [t.text for t in head.tokens] == ["WHILE", "TRUE", "DO"] and not self._left(nodes[at:end]):
            raise ProgramError("WHILE TRUE never ends", hint="post what one round of it does", line=head.line)
        try:
            if parts:
                run_block(head, parts, self._machine.data, self._nodes, self._take)
                return end
        except UnknownError as unknown:
            why = f" ({shown(str(unknown))})" if str(unknown) else ""
        endless = not parts and end != at + 1
        if endless or any(self._moves(node) for node in nodes[at:end]):
            raise ProgramError(
                f"{head.word} that moves, or has no end: its course is not known{why}",
                hint="write its motions out one by one",
                line=head.line,
            )
        for node in nodes[at:end]:  # what it may set is known no more
            if isinstance(node, Statement):
                self._machine.lose(node)
        self._unknown(head)
        return end

    def _left(self, nodes: Sequence[Node]) -> bool:
        """Whether a loop holds a way out of it: itself, or EXIT anywhere that it may call."""
        called = (node for module in self._modules for routine in module.routines.values() for node in routine.nodes)
        words = [node.word for node in nodes if isinstance(node, Statement)]
        ends = any(isinstance(node, Statement) and "EXIT" in (t.text for t in node.tokens) for node in called)
        return ends or bool({"RETURN", "RAISE", "GOTO", "IF", "EXITCYCLE"} & set(words))

    def _moves(self, node: Node) -> bool:
        """Whether a statement that may not run could move."""
        return isinstance(node, Row) or any(t.text in MOVES or self._routine(t.text) is not None for t in node.tokens)

    def _statement(self, statement: Statement) -> None:
        """One statement."""
        machine, word = self._machine, statement.word
        machine.statements[word or "?"] += 1
        if word in MOVES:
            machine.move(statement)
        elif word == "RETURN":
            raise _LeftError
        elif word == "EXIT":
            raise _EndedError
        elif machine.declare(statement) or machine.assign(statement) or machine.simple(statement):
            return
        elif word.startswith(_OTHER_MOVES):
            together = word.startswith("SYNCMOVE")
            what = "which moves several robots at once, is not read" if together else "is not read here"
            cure = "give each robot a program without it" if together else "write MoveL"
            raise ProgramError(f"{shown(word)}{', ' if together else ' '}{what}", hint=cure, line=statement.line)
        elif (
            word.startswith(_FRAMES)
            or not word
            or ":" in (statement.tokens[-1].text, *(t.text for t in statement.tokens[1:2]))
        ):
            self._unknown(statement)
            machine.act(statement)
        else:
            self._called(statement)

    def _called(self, statement: Statement) -> None:
        """A procedure of the program, or one that is not at hand."""
        found = self._routine(statement.word)
        if found is not None and found[1].parameters is not None and not (found[1].referred and _sets(found[1])):
            arguments = arguments_of(statement)
            if not arguments.options and len(arguments.places) == len(found[1].parameters):
                self._call(*found, [self._machine.known(tokens) for tokens in arguments.places])
                return
        why = "which is not at hand" if found is None else "which takes something otherwise than by value"
        text = f"calls {shown(statement.word)}, {why}"
        self._machine.find("call-unknown", text, statement.line)
        self._machine.act(statement)

    def _unknown(self, statement: Statement) -> None:
        text = f"{shown(joined(statement.tokens[:12]))} is not understood"
        self._machine.find("not-understood", text, statement.line, Severity.WARNING)


def _carried_out(machine: RapidMachine) -> Callable[[Statement], bool]:
    """What a function may do: declare and assign."""
    return lambda statement: machine.declare(statement) or machine.assign(statement, noted=False)


def _sets(routine: Routine) -> bool:
    """Whether a procedure may give a datum another value: then what it takes by reference isn't what it is handed."""

    def leaves(statement: Statement) -> bool:
        texts = [t.text for t in statement.tokens]
        branch = statement.word in BLOCKS or statement.word in ("ELSE", "ELSEIF", "CASE", "DEFAULT", *BLOCKS.values())
        sets = ":=" in texts and statement.word not in MOVES
        return not sets and (statement.word in LEAVING or (branch and texts[-1] in ("THEN", "DO", ":", statement.word)))

    return not all(isinstance(node, Row) or leaves(node) for node in routine.nodes)


def _frames(machine: RapidMachine) -> dict[str, list[ProgramFrame]]:
    return {"tool": machine.frames.tools, "base": machine.frames.bases}


def _used(frames: list[ProgramFrame], columns: dict[str, Any], name: str) -> tuple[ProgramFrame, ...]:
    """The frames that motions are made with, and the column's indices among them."""
    index = np.asarray(columns[name], np.int64)
    used = np.unique(index)
    columns[name] = np.searchsorted(used, index)
    return tuple(frames[k] for k in used.tolist())
