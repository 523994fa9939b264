"""Runs a RAPID program as the controller would: statement by statement, from PROC main to its end, into a `Run`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from camrob.errors import ProgramError
from camrob.witness.happenings import Run
from camrob.witness.krl.conduct import PTP
from camrob.witness.krl.hooks import Hooks
from camrob.witness.krl.replay import replay
from camrob.witness.krl.state import Here, LostError, State
from camrob.witness.krl.text import Line
from camrob.witness.machine import Machine
from camrob.witness.rapid.module_text import MoveRow, Procedure, RapidModule, listed_modules, read_rapid_module
from camrob.witness.rapid.rapid_motion import RapidMotions
from camrob.witness.rapid.rapid_statements import STATEMENTS
from camrob.witness.rapid.records import Item, NotSaidError, Records

__all__ = ["run_program"]

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


class _Runner:
    """Walks through procedures."""

    def __init__(self, main: Path, machine: Machine) -> None:
        self.state = State(machine, Hooks(machine.controller.hooks, _SWITCH), quarters=True)
        self.records = Records()
        self.motions = RapidMotions(self.state, self.records)
        self.procedures: dict[str, tuple[RapidModule, Procedure]] = {}
        self.locals: dict[Path, dict[str, tuple[str, Item]]] = {}  # by module, what LOCAL keeps to it
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
        for name, procedure in module.procedures.items():
            if name in self.procedures:
                raise ProgramError(
                    f"has a procedure {name} that another module has", path=path, line=procedure.head.number
                )
            self.procedures[name] = (module, procedure)
        return module

    def declare(self, line: Line, scope: dict[str, tuple[str, Item]]) -> bool:
        """CONST, VAR, PERS, into a scope."""
        found = re.fullmatch(r"(?:(?:LOCAL|TASK) )?(?:CONST|VAR|PERS) (\w+) (\w+)(\{.*\})? ?(?::= ?(.*))?", line.code)
        if found is None:
            return False
        self.records.declare(found[1], found[2], "" if found[3] else found[4] or "", scope)
        self.motions.forget()
        return True

    def enter(self, module: RapidModule, procedure: Procedure) -> None:
        """Runs a procedure."""
        if self.depth >= _CALLS_DEEP:
            raise LostError("procedures call each other too deep")
        records = self.records
        kept = (self.state.file, records.own, records.module)
        self.state.file = self.state.files.index(str(module.path))
        records.own, records.module = {}, self.locals[module.path]
        self.motions.forget()
        self.depth += 1
        try:
            self.nodes(procedure.nodes)
        except _LeftError:
            self.state.early = None
        finally:
            self.state.file, records.own, records.module = kept
            self.motions.forget()
            self.depth -= 1

    def nodes(self, nodes: Sequence[Line | MoveRow]) -> None:
        """Statements one after another; rows that name the same together; branches and loops are gaps."""
        at = 0
        while at < len(nodes):
            node = nodes[at]
            if isinstance(node, MoveRow):
                last = at
                while last < len(nodes) and isinstance(nodes[last], MoveRow):
                    last += 1
                self.rows([row for row in nodes[at:last] if isinstance(row, MoveRow)])
                at = last
            elif re.match(r"(?:IF|FOR|WHILE|TEST)\b(?!.*:=.*;)", node.code) and not node.code.startswith("FORM"):
                at = self.block(nodes, at, node)
            elif node.code in ("ERROR", "UNDO", "BACKWARD"):
                return  # run when something fails, or backwards
            else:
                self.one(node)
                at += 1

    def rows(self, rows: list[MoveRow]) -> None:
        """MoveLs of plain numbers."""
        for _, alike in groupby(rows, key=lambda row: (row.names, row.speed[1:])):
            some = list(alike)
            try:
                self.state.tick(Line(some[0].number, "MOVEL", "", "MoveL .."))
                self.state.taken += len(some) - 1
                self.motions.rows(some)
            except NotSaidError as reason:
                line = Line(some[0].number, "MOVEL", "", "MoveL ..")
                self.state.gap(line, f"where it leads isn't known ({reason})", some[-1].number)

    def block(self, nodes: Sequence[Line | MoveRow], at: int, head: Line) -> int:
        """A branch or a loop: not judged. The place behind it."""
        depth, end = 0, at
        if re.fullmatch(r"IF\b(?!.*\bTHEN$).*", head.code):  # with one statement
            self.state.gap(head, "whether it is done isn't known, so it isn't judged")
            return at + 1
        while end < len(nodes):
            node = nodes[end]
            code = node.code if isinstance(node, Line) else ""
            depth += re.match(r"(?:IF\b.*\bTHEN|FOR\b|WHILE\b|TEST\b)", code) is not None
            depth -= code in ("ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST")
            if depth == 0:
                break
            end += 1
        tail = nodes[min(end, len(nodes) - 1)]
        self.state.gap(head, "which way it goes isn't known, so none is judged", tail.number)
        return end + 1

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
            "assign": self.assign,
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

    def assign(self, match: re.Match[str], line: Line) -> None:
        """A datum is set; a tool's frame or a work object's is kept by the controller, and the next run begins with it."""
        state, records = self.state, self.records
        try:
            value = records.value(match["value"])
        except NotSaidError:
            value = None
        known = records.scope_of(match["name"]) is not None
        if known and match["part"] != "TLOAD":
            state.gap(line, "it changes what the controller keeps for its next run, and that isn't judged")
        if known:
            records.put(match["name"], match["part"] or "", value)
            self.motions.forget()
            state.step(line, "other")
        else:
            state.unknown(line, "the name isn't declared here, and what it is isn't known")

    def call(self, match: re.Match[str], line: Line) -> None:
        """A procedure at hand; else it is a hook's, or a gap."""
        found = self.procedures.get(match["name"])
        if found is not None and found[1].plain and not match["inputs"]:
            self.enter(*found)
            return
        self.still(line)
        self.state.unknown(line, "it calls what is not at hand, so what it does isn't judged")


def run_program(main: Path, machine: Machine) -> Run:
    """Runs a main module with those that its .pgf lists, from PROC main, else from its first procedure.

    Raises ProgramError where a file can't be read or does not close. What can't be followed is a gap of the run.
    """
    runner = _Runner(main, machine)
    lost = None
    try:
        procedures = runner.main.procedures
        if not procedures:
            raise LostError("the module has no procedure")
        runner.enter(runner.main, procedures.get("MAIN", next(iter(procedures.values()))))
    except LostError as reason:
        lost = reason
    return replay(runner.state, runner.state.ended(lost))
