"""Runs a KRL program as the controller would: statement by statement, from the first to the last, into a `Run`."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from camrob.witness.happenings import Gap, Objection, Run
from camrob.witness.krl.acts import ACTS, STANDARD
from camrob.witness.krl.again import alike, left_over
from camrob.witness.krl.blocks import begins, curved, idle, in_spline, leaves
from camrob.witness.krl.columns import Motions
from camrob.witness.krl.functions import FUNCTIONS
from camrob.witness.krl.handing import hand_back, hand_over
from camrob.witness.krl.hooks import Hooks, canonical
from camrob.witness.krl.motion import add_rows
from camrob.witness.krl.program import Block, Module, Node, Routine, beside, data_lines, read_module
from camrob.witness.krl.replay import replay
from camrob.witness.krl.scope import Scope
from camrob.witness.krl.state import EndlessError, LostError, State
from camrob.witness.krl.statements import statement
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import UnknownError, Value, split_top
from camrob.witness.krl.with_part import FORM_FUNCTIONS, with_words
from camrob.witness.machine import Machine

__all__ = ["run_program"]

_MOST_TURNS = 20_000  # of all loops together; lists of points that a loop runs through hold some ten thousand
_MOST_JUMPS = 500  # by GOTO
_LIBRARY = ("BAS", "IR_STOPM")  # KUKA's, whose effects are known
_OTHERS = ("CELL", "SPS", "P00", *STANDARD)  # modules and variables that every controller has
_OWN_NAMES = (*_LIBRARY, *FUNCTIONS, *FORM_FUNCTIONS, *_OTHERS)  # that no program may give to a routine of its own
_CALLS_DEEP = 25  # routines that call routines; KUKA's own limit is lower
_FOR = re.compile(r"FOR (?P<name>[A-Z_]\w*) ?= ?(?P<first>.+?) TO (?P<last>.+?)(?: STEP (?P<step>.+))?")
_IF = re.compile(r"IF ?(?P<when>.+?) ?THEN")


class _LeftError(Exception):
    """RETURN."""


class _LoopLeftError(Exception):
    """EXIT."""


class _JumpError(Exception):
    """GOTO, with the mark's name."""


@dataclass(slots=True)
class _Runner:
    """Walks through the nodes of routines; what they do is in `acts` and `motion`."""

    state: State
    folder: Path
    modules: dict[str, Module | None] = field(default_factory=dict)
    data: dict[str, Scope] = field(default_factory=dict)  # by the module's file
    later: dict[str, dict[str, Value]] = field(default_factory=dict)  # what a run before this one left in them
    module: Module | None = None
    depth: int = 0
    returned: Value | None = None  # by the function that has just ended
    turns: int = 0  # of loops

    def load(self, path: Path) -> Module:
        """Reads a module and its data list."""
        module = read_module(path)
        self.modules[path.stem.upper()] = module
        self.state.files.append(str(path))
        self.state.written += module.source.count
        place = self.data[str(path)] = Scope()
        common = self.state.variables.common
        known = set(common)
        if module.data_path is not None:
            self.take(module.data_path, module.data, place)
        place.update(self.later.get(str(path), {}))
        common.update(
            {name: value for name, value in self.later.get("", {}).items() if name in common and name not in known}
        )
        for name in _OWN_NAMES:
            if name in module.routines or (name in _LIBRARY and beside(self.folder, f"{name}.src")):
                text = f"the program brings a {name} of its own, in place of the controller's"
                self.state.object("library-replaced", text, 1)
        self.state.object_longer(*module.source.longest)
        if module.source.odd:
            text = "a control character, at which one system ends a line and another doesn't: what is run isn't certain"
            self.state.unsure(module.source.odd, text)
        return module

    def configure(self) -> None:
        """Takes over what the cell says that the controller holds, and what a `$config.dat` beside the program declares."""
        self.state.variables.common.update(self.state.machine.held())
        path = beside(self.folder, "$config.dat")
        if path is not None:
            self.take(path, data_lines(path), self.state.variables.common)
        self.state.variables.common.update(self.later.get("", {}))

    def take(self, path: Path, lines: list[Line], place: Scope) -> None:
        """Runs a data list, its values into `place`."""
        state = self.state
        kept = (state.file, state.variables.own, state.variables.module)
        state.file, state.variables.own, state.variables.module = len(state.files), place, place
        state.files.append(str(path))
        head = next((line for line in lines if line.code.startswith("DEFDAT")), None)
        named = "" if head is None else head.code.split()[1:2]
        if named != [path.stem.upper()] or lines[-1].code != "ENDDAT":
            what = (
                f"the file is {path.name} and holds no DEFDAT {path.stem.upper()} to ENDDAT: no controller loads that"
            )
            state.object("module-name", what, 1)
        for line in lines:
            if re.match(r"\$(?!.*\bDECL\b)", line.code) and path.name.lower() != "$config.dat":
                state.gap(line, "a data list declares: what a statement does there isn't judged")
            if not re.match(r"(?:DEFDAT|ENDDAT)\b", line.code):
                self.one(line)
        state.file, state.variables.own, state.variables.module = kept

    def one(self, line: Line) -> None:
        """One statement that is no block."""
        state = self.state
        state.tick(line)
        found = statement(line.code)
        if found is None:
            state.unknown(line, "the statement isn't on the list of what is understood")
            state.early = None
            return
        row, match = found
        if row.stops:
            state.waits(line)
        if row.act == "leave":
            self.returned = None
            if match["value"]:
                with suppress(UnknownError):
                    self.returned = state.variables.value(match["value"])
            raise _LeftError
        if row.act == "leave_loop":
            raise _LoopLeftError
        if row.act == "jump":
            raise _JumpError(match["name"])
        if row.act == "call":
            self.call(match, line)
        else:
            ACTS[row.act](state, match, line)
        if row.act != "continue":
            state.early = None

    def find(self, name: str) -> tuple[Module, Routine] | None:
        """A routine of this file, or the main routine of a file beside it."""
        if self.module is not None and name in self.module.routines:
            return self.module, self.module.routines[name]
        if name not in self.modules:
            path = beside(self.folder, f"{name}.src")
            self.modules[name] = None if path is None else self.load(path)
        module = self.modules[name]
        return None if module is None or name not in module.routines else (module, module.routines[name])

    def call(self, match: re.Match[str], line: Line) -> None:
        """Runs a routine that is at hand; else it is a hook's, or a gap."""
        state = self.state
        found = self.find(match["name"])
        hooked = state.hooks.concerns(canonical(line.code))
        if found is None or hooked:
            at_hand = "it is one of several lines of a hook, of which others are missing"
            state.unknown(line, at_hand if found else "it calls what is not at hand, so what it does isn't judged")
        if found is None:
            return
        texts = split_top(match["inputs"]) if match["inputs"].strip() else []
        state.quiet += hooked
        kept = self.returned
        self.enter(*found, texts, line)
        self.returned = kept
        state.quiet -= hooked

    def function(self, name: str, texts: list[str]) -> Value:
        """What a DEFFCT returns; one that does more is a gap. Raises UnknownError."""
        found, state = self.find(name), self.state
        if found is None or not found[1].kind:
            raise UnknownError(f"{name}() is not at hand")
        line, scope = Line(state.line, name, "", f"{name} ( )"), Scope()
        kept, self.returned = self.returned, None
        before = self.done()
        self.enter(*found, texts, line, valued=True)
        value, self.returned = self.returned, kept
        if self.done() != before:
            state.gap(line, "the function does more than return a value, and that isn't judged")
        if value is None:
            raise UnknownError(f"what {name}() returns isn't known")
        scope.kinds[""] = found[1].kind
        scope.put("", value)
        return scope[""]

    def done(self) -> str:
        """What a function that only returns a value leaves as it is."""
        state = self.state
        frames = (state.base, state.tool, state.speed, state.constant, state.rounds, state.conduct.values)
        return repr((state.count, len(state.steps), state.variables.changes, len(state.interrupts), frames))

    def enter(
        self, module: Module, routine: Routine, texts: list[str], line: Line | None, *, valued: bool = False
    ) -> None:
        """Runs one routine with what it is handed, and puts back what it hands back. valued: within an expression."""
        state = self.state
        if self.depth >= _CALLS_DEEP:
            raise LostError("routines call each other too deep")
        own, given = hand_over(state.variables, routine.inputs, texts)
        kept = (self.module, state.file, state.variables.own, state.variables.module)
        self.module, self.depth = module, self.depth + 1
        state.file = state.files.index(str(module.source.path))
        state.variables.own, state.variables.module = own, self.data[str(module.source.path)]
        try:
            self.nodes(routine.nodes)
        except (_LeftError, _LoopLeftError):
            state.early = None
        except _JumpError as jump:
            raise LostError(f"GOTO {jump} leads to no mark that it may reach") from None
        finally:
            self.module, state.file, state.variables.own, state.variables.module = kept
            self.depth -= 1
        for text in hand_back(state.variables, given, own, counted=valued):
            state.gap(line or routine.head, f"{routine.name} may change {text}, and that isn't judged")

    def nodes(self, nodes: list[Node]) -> None:
        """A sequence of statements, rows and blocks; a GOTO within leads to a mark that stands in it."""
        at = 0
        while at < len(nodes):
            node = nodes[at]
            at += 1
            try:
                if isinstance(node, Block):
                    self.block(node)
                elif isinstance(node, Line):
                    self.one(node)
                elif self.module is not None:
                    add_rows(self.state, self.module.source, node.first, node.last)
            except _JumpError as jump:
                mark = f"{jump}:"
                found = [k for k, to in enumerate(nodes) if isinstance(to, Line) and to.code.replace(" ", "") == mark]
                if len(found) != 1:
                    raise
                at = found[0]
                self.count_turn(_MOST_TURNS // _MOST_JUMPS)

    def block(self, block: Block) -> None:
        """IF, SWITCH, loops, splines. A condition that can't be known is a gap, unless neither way does anything."""
        self.state.tick(block.head)
        try:
            if block.kind == "IF":
                self.branch(block)
            elif block.kind == "SWITCH":
                self.switch(block)
            elif block.kind == "SPLINE":
                self.spline(block)
            else:
                self.loop(block)
        except UnknownError as reason:
            if block.kind in ("WHILE", "REPEAT") or not all(idle(nodes) for _, nodes in block.parts):
                self.state.gap(
                    block.head, f"which way it goes isn't known ({reason}), so none is judged", block.tail.number
                )
        except _LoopLeftError:
            if block.kind in ("IF", "SWITCH", "SPLINE"):
                raise

    def spline(self, block: Block) -> None:
        """SPLINE ... ENDSPLINE: straight lines and circles keep to their ways, and meet at their points."""
        state, inside = self.state, block.parts[0][1]
        state.needs_splines(block.head)
        if any(curved(node) for node in inside) or block.tail.code != "ENDSPLINE":
            state.gap(block.head, "how a spline joins its motions isn't judged", block.tail.number)
        opened, _, said = block.head.code.partition(" WITH ")
        if opened != "SPLINE":
            state.gap(block.head, "how the block is opened isn't understood")
        for node in inside:
            if not in_spline(node, self.module):
                where = node if isinstance(node, Line) else block.head
                state.object(
                    "spline-block", "within SPLINE stand SLIN, SCIRC, SPL and TRIGGER alone, and none is rounded", where
                )
        with with_words(state, said, block.head):
            self.nodes(inside)

    def branch(self, block: Block) -> None:
        if self.state.machine.controller.own.get("on_path") is True and not self.state.count and begins(block):
            self.state.early = None  # CONTINUE before it: it looks at $ON_PATH without waiting
            self.nodes(block.parts[0][1])
            return
        match = _IF.fullmatch(block.head.code)
        if match is None:
            raise UnknownError("the condition can't be read")
        taken = self.state.variables.truth(match["when"])
        chosen = block.parts[0] if taken else block.parts[-1]
        if taken or len(block.parts) > 1:
            self.nodes(chosen[1])

    def switch(self, block: Block) -> None:
        value = self.state.variables.value(block.head.code.removeprefix("SWITCH").strip())
        for head, nodes in block.parts[1:]:
            cases = head.code.removeprefix("CASE").strip(": ")
            if cases == "DEFAULT" or value in [self.state.variables.value(text) for text in split_top(cases)]:
                self.nodes(nodes)
                return

    def loop(self, block: Block) -> None:
        """FOR, WHILE, REPEAT and LOOP."""
        variables, body = self.state.variables, block.parts[0][1]
        if block.kind == "FOR":
            match = _FOR.fullmatch(block.head.code)
            if match is None:
                raise UnknownError("it can't be read")
            value, last = variables.number(match["first"]), variables.number(match["last"])
            step = variables.number(match["step"] or "1")
            if step == 0.0:
                raise UnknownError("its step is 0")
            while value <= last if step > 0 else value >= last:
                self.turn(block)
                variables.put(match["name"], int(value) if value == int(value) else value)
                self.nodes(body)
                if variables.number(match["name"]) != value:
                    raise UnknownError("its counter is set within it")
                value += step
            variables.forget(match["name"])  # the last value or the one behind it
            return
        if block.kind == "LOOP" and not leaves(body):
            raise LostError(f"line {block.head.number}: a LOOP without EXIT never ends")
        when = block.head.code.removeprefix("WHILE").strip() if block.kind == "WHILE" else "TRUE"
        while variables.truth(when):
            self.turn(block)
            self.nodes(body)
            if block.kind == "REPEAT" and variables.truth(block.tail.code.removeprefix("UNTIL").strip()):
                return

    def turn(self, block: Block) -> None:
        """A turn of a loop."""
        self.state.tick(block.head)
        self.count_turn()

    def count_turn(self, weight: int = 1) -> None:
        """Counts a way back, or a GOTO; raises LostError for more of them than any honest program has."""
        self.turns += weight
        if self.turns > _MOST_TURNS:
            raise EndlessError(f"more than {_MOST_TURNS} turns of loops: the program may never end")


def _once(main: Path, machine: Machine, later: dict[str, dict[str, Value]]) -> tuple[_Runner, Motions]:
    """One run of a program, on what an earlier one left in its data lists."""
    state = State(machine, Hooks(machine.controller.hooks))
    runner, lost = _Runner(state, main.parent, later=later), None
    state.variables.function = runner.function
    try:
        module = runner.load(main)
        runner.configure()
        for line in module.outside:
            state.object(
                "outside-def", f"{line.raw.strip()[:40]}: it stands outside any DEF: no controller takes that", line
            )
        first = next(iter(module.routines))
        if first != main.stem.upper():
            state.object("module-name", f"the file is {main.name} and its program {first}: no controller loads that", 1)
        runner.enter(module, module.routines.get(main.stem.upper(), module.routines[first]), [], None)
    except LostError as reason:
        lost = reason
    return runner, state.ended(lost)


def _judge_again(main: Path, machine: Machine, first: _Runner, motions: Motions) -> None:
    """Data lists outlive a run: where the program changes them, the next run has to do the same as this one."""
    left = left_over(first.state.variables, first.data, {})
    if not left:
        return
    names = ", ".join(sorted(name for values in left.values() for name in values))[:80]
    second, again = _once(main, machine, left)
    state = first.state
    if not alike(state, motions, second.state, again):
        text = f"it changes {names} in its data list, which the controller keeps: its next run is not the same"
        state.ruled.append(Objection("not-repeatable", text))
    elif left_over(second.state.variables, second.data, left) != left:
        state.unsure(0, f"it changes {names} in its data list with every run: later runs than the second aren't judged")


def run_program(main: Path, machine: Machine) -> Run:
    """Runs a main program with what it calls: routines of its file, files beside it, data lists.

    Raises KrlError where a file can't be read or its blocks don't close. What can't be followed is a gap of the run.
    """
    runner, motions = _once(main, machine, {})
    state = runner.state
    for row, line, file in state.vague:
        if row < len(motions) and not motions.exact[row]:
            text = "how far C_PTP, C_VEL, C_ORI or a spline's kin round it isn't stated by the cell, and so not judged"
            state.unsettled.append(Gap(row, line, line, text, file))
            break
    _judge_again(main, machine, runner, motions)
    return replay(state, motions)
