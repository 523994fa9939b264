"""Runs a RAPID program as the controller would: statement by statement, from PROC main to its end, into a `Run`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from camrob.errors import ProgramError
from camrob.witness.happenings import Objection, Run
from camrob.witness.krl.again import alike
from camrob.witness.krl.columns import Motions
from camrob.witness.krl.conduct import PTP
from camrob.witness.krl.hooks import Hooks
from camrob.witness.krl.replay import replay
from camrob.witness.krl.state import Here, LostError, State
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import split_top
from camrob.witness.machine import Machine
from camrob.witness.rapid.expressions import Item, NotSaidError
from camrob.witness.rapid.module_text import Procedure, RapidModule, listed_modules, read_rapid_module
from camrob.witness.rapid.own_functions import Functions
from camrob.witness.rapid.own_routines import functions_called, hiding
from camrob.witness.rapid.rapid_motion import RapidMotions
from camrob.witness.rapid.rapid_statements import STATEMENTS
from camrob.witness.rapid.records import Records
from camrob.witness.rapid.walk import Walk, recovery

__all__ = ["run_program"]

_DECLARED = re.compile(
    r"(?:(?:LOCAL|TASK) )?(?P<how>CONST|VAR|PERS) (?P<kind>\w+) (?P<name>\w+) ?(?:\{(?P<sizes>[^{}]*)\})? ?(?::= ?(?P<value>.*))?"
)
_CALLS_DEEP = 25  # procedures that call procedures
_WORDS = {  # what RAPID has for KUKA's settings, for messages
    "$APO.CDIS": "the zone's distance",
    "$ACC.CP": "PathAccLim",
    "$VEL.ORI1": "v_ori",
    "$VEL.ORI2": "v_ori",
    PTP: "the speed of MoveAbsJ and MoveJ",
}
_UNSAID = ("$ACC.ORI1", "$ACC.ORI2")  # RAPID has no word for how fast turning speeds up: the controller's own holds
_SWITCH = r"^(?:SETDO|SETAO|SETGO|SET|RESET|PULSEDO|INVERTDO)(?![A-Z_]*\()"


class _LeftError(Exception):
    """RETURN."""


class _EndedError(Exception):
    """EXIT."""


_Left = dict[tuple[str, str], tuple[str, Item]]  # by module ("" where all see it) and name


class _Runner(Walk):
    """Walks through procedures."""

    def __init__(self, main: Path, machine: Machine, left: _Left) -> None:
        self.state = State(machine, Hooks(machine.controller.hooks, _SWITCH), quarters=True)
        self.records = Records()
        self.motions = RapidMotions(self.state, self.records)
        # by module (LOCAL; "" else) and name
        self.procedures: dict[tuple[str, str], tuple[RapidModule, Procedure]] = {}
        self.locals: dict[Path, dict[str, tuple[str, Item]]] = {}  # by module, what LOCAL keeps to it
        self.functions = Functions(self.records)
        self.depth = 0
        conduct = self.state.conduct
        conduct.begun, conduct.words = True, _WORDS
        for name in _UNSAID:
            if name in machine.controller.settings:
                conduct.set(name, machine.controller.settings[name])
        self.state.unlike_arc = "CirPathMode\\PathFrame, the default"
        self.main = self.load(main)
        for file in listed_modules(main):
            self.load(file)
        self.first = {key: scope[key[1]] for key, scope in self.places()}
        for key, scope in self.places():
            scope[key[1]] = left.get(key, scope[key[1]])
        self.motions.forget()

    def places(self) -> list[tuple[tuple[str, str], dict[str, tuple[str, Item]]]]:
        """All that modules declare: where it stands."""
        scopes = [("", self.records.known), *((str(path), scope) for path, scope in self.locals.items())]
        return [((path, name), scope) for path, scope in scopes for name in scope]

    def held(self) -> str:
        """What all data hold, as a text."""
        return repr((self.records.known, self.locals, self.records.own))

    def left(self) -> _Left:
        """What the run leaves in the modules' data other than they were declared with."""
        return {key: scope[key[1]] for key, scope in self.places() if scope[key[1]] != self.first.get(key)}

    def load(self, path: Path) -> RapidModule:
        """Reads a module: data and procedures become known."""
        module, state = read_rapid_module(path), self.state
        state.file = len(state.files)
        state.files.append(str(path))
        state.written += module.count
        state.object_longer(*module.longest)
        for line in module.outside:
            state.gap(line, "it stands outside of any procedure")
        self.records.module = self.locals[path] = {}
        for line in module.data:
            self.declare(line, self.records.module if line.code.startswith("LOCAL ") else self.records.known)
        heads = {name: routine.head for name, routine in {**module.functions, **module.procedures}.items()}
        for name in hiding(heads):
            text = f"{name} is a routine of the program's own, and hides the controller's: what it does isn't what ABB says"
            state.object("library-replaced", text, heads[name])
        for function in module.functions.values():
            self.functions.add(str(path), function, self.locals[path])
        for name, procedure in module.procedures.items():
            key = (str(path) if procedure.head.code.startswith("LOCAL ") else "", name)
            if key in self.procedures:
                raise ProgramError(
                    f"has a procedure {name} that another module has", path=path, line=procedure.head.number
                )
            self.procedures[key] = (module, procedure)
        return module

    def declare(self, line: Line, scope: dict[str, tuple[str, Item]]) -> bool:
        """CONST, VAR, PERS, into a scope."""
        found = _DECLARED.fullmatch(line.code)
        if found is None:
            return False
        value, sizes = found["value"] or "", found["sizes"] or ""
        self.records.declare(found["kind"], found["name"], value, scope, sizes=sizes, how=found["how"])
        self.motions.forget()
        return True

    def enter(self, module: RapidModule, procedure: Procedure, given: Sequence[tuple[str, Item]] = ()) -> None:
        """Runs a procedure with what it is handed by value, its type with it."""
        if self.depth >= _CALLS_DEEP:
            raise LostError("procedures call each other too deep")
        records = self.records
        kept = (self.state.file, records.own, records.module)
        self.state.file = self.state.files.index(str(module.path))
        self.functions.here = str(module.path)
        own = {name: value for (_, name), value in zip(procedure.inputs or (), given, strict=True)}
        records.own, records.module = own, self.locals[module.path]
        handler = recovery(procedure.nodes)
        if handler is not None:
            text = f"{procedure.name}: what is left out or done again where a statement fails (ERROR) isn't judged"
            self.state.unsure(handler.number, text)
        self.motions.forget()
        self.depth += 1
        try:
            self.nodes(procedure.nodes)
        except _LeftError:
            self.state.early = None
        finally:
            self.state.file, records.own, records.module = kept
            self.functions.here = self.state.files[self.state.file]
            self.motions.forget()
            self.depth -= 1

    def one(self, line: Line) -> None:
        """One statement."""
        state = self.state
        state.tick(line)
        if self.declare(line, self.records.own):
            return
        found = next(((row, m) for row in STATEMENTS if (m := row.pattern.fullmatch(line.code)) is not None), None)
        if found is None:
            state.unknown(line, "the statement isn't on the list of what is understood")
            return
        row, match = found
        called = () if row.act in ("move", "unread_move") else functions_called(line.code)
        function = next((name for name in called if not self.functions.holds(name)), "")
        if function:
            why = f"it calls {function[:40]}(), and what that does isn't judged"
            if row.act != "assign":
                state.unknown(line, why)
                return
            state.gap(line, why)
        acts = {
            "leave": self.leave,
            "move": self.move,
            "unread_move": self.unread_move,
            "wait": self.wait,
            "output": self.output,
            "halt": self.halt,
            "wait_for": self.wait_for,
            "acceleration": self.acceleration,
            "ramps": self.ramps,
            "override": self.override,
            "configuration": self.configuration,
            "singular": self.singular,
            "circle": self.circle,
            "unit": self.unit,
            "assign": self.assign,
            "count": self.count,
            "add": self.add,
            "end": self.end,
            "call": self.call,
        }
        if row.act == "nothing":
            state.step(line, "other")
        else:
            acts[row.act](match, line)

    def leave(self, match: re.Match[str], line: Line) -> None:
        """RETURN."""
        raise _LeftError

    def move(self, match: re.Match[str], line: Line) -> None:
        """A motion that is understood."""
        try:
            self.motions.move(match["word"], match["rest"], line)
        except NotSaidError as reason:
            self.lost(line, f"where it leads isn't known ({reason})")

    def unread_move(self, match: re.Match[str], line: Line) -> None:
        """A motion that isn't."""
        self.lost(line, "this kind of motion isn't judged")

    def lost(self, line: Line, why: str) -> None:
        """The robot goes nobody knows where."""
        self.state.close_steps()
        self.state.gap(line, why)
        self.state.here = Here()

    def still(self, line: Line) -> None:
        """What happens here happens where the robot has stopped; behind a rounded corner that isn't so."""
        if self.motions.rounded and self.state.count:
            self.state.gap(line, "it stands behind a rounded corner, and when it happens isn't judged")
        else:
            self.state.waits(line)

    def wait(self, match: re.Match[str], line: Line) -> None:
        """WaitTime."""
        if match["still"]:
            self.motions.rounded = False
        self.still(line)
        self.state.step(line, "wait", value=float(match["value"]))

    def output(self, match: re.Match[str], line: Line) -> None:
        """An output."""
        self.still(line)
        self.state.step(line, "output")

    def halt(self, match: re.Match[str], line: Line) -> None:
        """Stop."""
        self.still(line)
        self.state.step(line, "halt")

    def wait_for(self, match: re.Match[str], line: Line) -> None:
        """How long depends on what isn't in the program, unless it is a hook's."""
        self.still(line)
        self.state.unknown(line, "it stands still until something outside the program happens")

    def acceleration(self, match: re.Match[str], line: Line) -> None:
        """PathAccLim."""
        limits = re.findall(r"\\(?:ACC|DECEL)MAX ?:= ?(\d+\.?\d*(?:E[-+]?\d+)?)(?![\w.])", match["rest"])
        known = match["on"] == "TRUE" and len(limits) == 2 and len({float(v) for v in limits}) == 1  # up and down
        self.state.conduct.set("$ACC.CP", float(limits[0]) if known else float("nan"))
        self.state.step(line, "other")

    def ramps(self, match: re.Match[str], line: Line) -> None:
        """AccSet."""
        if (float(match["a"]), float(match["b"])) != (100.0, 100.0):
            self.state.unsure(line.number, f"{line.raw[:60]}: slower ramps than the controller's default aren't judged")
        self.state.step(line, "other")

    def override(self, match: re.Match[str], line: Line) -> None:
        """VelSet."""
        if float(match["a"]) != 100.0:
            self.state.gap(line, "it makes all speeds others than the text says, and those aren't judged")
        self.motions.top = float(match["b"])
        self.state.step(line, "other")

    def configuration(self, match: re.Match[str], line: Line) -> None:
        """ConfJ."""
        self.motions.by_configuration = match["on"] == "ON"

    def singular(self, match: re.Match[str], line: Line) -> None:
        """SingArea."""
        self.state.unlike_line = "" if match["on"] == "OFF" else f"SingArea\\{match['on']}"

    def circle(self, match: re.Match[str], line: Line) -> None:
        """CirPathMode."""
        self.state.unlike_arc = "" if match["how"] == "OBJECTFRAME" else f"CirPathMode\\{match['how']}"

    def unit(self, match: re.Match[str], line: Line) -> None:
        """ActUnit."""
        self.motions.idle.discard(match["unit"])

    def assign(self, match: re.Match[str], line: Line) -> None:
        """A datum is set. What CONST and PERS declare the controller keeps, and the next run begins with it."""
        state, records = self.state, self.records
        path = match["path"].replace(" ", "")
        name = re.split(r"[.{]", path)[0]
        scope = records.scope_of(name)
        if scope is None:
            state.unknown(line, "the name isn't declared here, and what it is isn't known")
            return
        kind = records.find(name)[0]
        kept = (id(scope), name) in records.kept or kind in ("TOOLDATA", "WOBJDATA")
        if kept and (kind, path) != ("TOOLDATA", f"{name}.TLOAD"):
            state.gap(line, "it changes what the controller keeps for its next run, and that isn't judged")
        self.put(path, match["value"], line)

    def put(self, path: str, text: str, line: Line) -> None:
        """Sets a datum to the value of a text, to nothing that is known where the text doesn't say it."""
        try:
            value = self.records.value(text)
        except NotSaidError:
            value = None
        self.records.put(path, value)
        self.motions.forget()
        self.state.step(line, "other")

    def count(self, match: re.Match[str], line: Line) -> None:
        """Incr, Decr, Clear."""
        path = match["path"]
        more = {"INCR": f"{path}+1", "DECR": f"{path}-1", "CLEAR": "0"}[match["how"]]
        self._changed(path, more, line)

    def add(self, match: re.Match[str], line: Line) -> None:
        """Add."""
        self._changed(match["path"], f"{match['path']}+({match['value']})", line)

    def _changed(self, path: str, text: str, line: Line) -> None:
        scope = self.records.scope_of(path)
        if scope is None or (id(scope), path) in self.records.kept:
            self.state.gap(line, "what it changes is the controller's, or not declared here")
        if scope is not None:
            self.put(path, text, line)

    def end(self, match: re.Match[str], line: Line) -> None:
        """EXIT."""
        raise _EndedError

    def call(self, match: re.Match[str], line: Line) -> None:
        """A procedure at hand; else it is a hook's, or a gap."""
        here = self.state.files[self.state.file]
        found = self.procedures.get((here, match["name"])) or self.procedures.get(("", match["name"]))
        texts = split_top(match["inputs"]) if match["inputs"] else []
        if found is not None and found[1].inputs is not None and len(texts) == len(found[1].inputs):
            self.enter(
                *found, [self.handed(kind, text) for (kind, _), text in zip(found[1].inputs, texts, strict=True)]
            )
            return
        self.still(line)
        why = "what is not at hand" if found is None else "a procedure that takes something otherwise than by value"
        self.state.unknown(line, f"it calls {why}, so what it does isn't judged")

    def handed(self, kind: str, text: str) -> tuple[str, Item]:
        """What a parameter holds."""
        try:
            return kind, self.records.value(text)
        except NotSaidError:
            return kind, None


def _once(main: Path, machine: Machine, left: _Left) -> tuple[_Runner, Motions]:
    """One run, on what an earlier one left in the modules' data."""
    runner = _Runner(main, machine, left)
    lost = None
    try:
        procedures = runner.main.procedures
        if not procedures:
            raise LostError("the module has no procedure")
        with suppress(_EndedError):
            runner.enter(runner.main, procedures.get("MAIN", next(iter(procedures.values()))))
    except LostError as reason:
        lost = reason
    return runner, runner.state.ended(lost)


def run_program(main: Path, machine: Machine) -> Run:
    """Runs a main module with those that its .pgf lists, from PROC main, else from its first procedure.

    Raises ProgramError where a file can't be read or does not close. What can't be followed is a gap of the run.
    """
    runner, motions = _once(main, machine, {})
    left = runner.left()
    if left:
        second, again = _once(main, machine, left)
        if not alike(runner.state, motions, second.state, again):
            names = ", ".join(sorted(name for _, name in left))[:80]
            text = f"it changes {names}, which hold until the program is begun anew: its next cycle is not the same"
            runner.state.ruled.append(Objection("not-repeatable", text))
        elif second.left() != left:
            runner.state.unsure(
                0, "it changes its modules' data with every cycle: later ones than the second aren't judged"
            )
    return replay(runner.state, motions)
