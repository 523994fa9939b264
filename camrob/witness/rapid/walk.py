"""Which statements of a RAPID procedure run, and how often: branches and loops whose course the text says."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import groupby

from camrob.witness.krl.state import LostError, State
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import split_top
from camrob.witness.rapid.block_parts import parts_of
from camrob.witness.rapid.expressions import NotSaidError, numbers_of
from camrob.witness.rapid.module_text import MoveRow
from camrob.witness.rapid.rapid_motion import RapidMotions
from camrob.witness.rapid.records import Records

__all__ = ["Walk", "recovery"]

_FOR = re.compile(r"FOR (?P<name>\w+) FROM (?P<first>.+?) TO (?P<last>.+?)(?: STEP (?P<step>.+?))? DO")


_LOOKED_AT = 20  # rounds of a WHILE in which one that never ends shows
_MOST_ROUNDS = 200  # of WHILE TRUE, which nothing but a way out of the procedure ends
_ENDS_IT = re.compile(r"RAISE\b.*|EXIT")
_MOVES_NOTHING = re.compile(
    r"(?:TPWRITE|TPERASE|ERRWRITE|ERRLOG|STOP|BREAK)\b.*|(?:IF|ELSEIF)\b.*\bTHEN|ELSE|ENDIF|TEST\b.*|CASE\b.*|DEFAULT ?:|ENDTEST"
)


def recovery(nodes: Sequence[Line | MoveRow]) -> Line | None:
    """Where a procedure's ERROR begins, if the program goes on behind it: by TRYNEXT, by RETRY, by returning to its caller as it
    does where it ends. None where there is no ERROR, or one that says something and ends the program or hands the error on.
    """
    lines = [node for node in nodes if isinstance(node, Line)]
    at = next((k for k, line in enumerate(lines) if line.code == "ERROR"), None)
    if at is None:
        return None
    end = next((k for k in range(at + 1, len(lines)) if lines[k].code in ("UNDO", "BACKWARD")), len(lines))
    inside = [line.code for line in lines[at + 1 : end]]
    harmless = all(_ENDS_IT.fullmatch(code) or _MOVES_NOTHING.fullmatch(code) for code in inside)
    return None if harmless and inside and _ENDS_IT.fullmatch(inside[-1]) else lines[at]


class Walk(ABC):
    """Goes through nodes; what a statement does is `one`'s business."""

    state: State
    records: Records
    motions: RapidMotions

    @abstractmethod
    def held(self) -> str:
        """What all data hold, as a text."""

    @abstractmethod
    def one(self, line: Line) -> None:
        """One statement."""

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
        for _, some_rows in groupby(rows, key=lambda row: (row.names, row.speed[1:])):
            some = list(some_rows)
            try:
                self.state.tick(Line(some[0].number, "MOVEL", "", "MoveL .."))
                self.state.taken += len(some) - 1
                self.motions.rows(some)
            except NotSaidError as reason:
                line = Line(some[0].number, "MOVEL", "", "MoveL ..")
                self.state.gap(line, f"where it leads isn't known ({reason})", some[-1].number)

    def block(self, nodes: Sequence[Line | MoveRow], at: int, head: Line) -> int:
        """A branch or a loop, where the text says its course. The place behind it."""
        if re.fullmatch(r"IF\b(?!.*\bTHEN$).*", head.code):  # with one statement
            self.state.gap(head, "whether it is done isn't known, so it isn't judged")
            return at + 1
        parts, end = parts_of(nodes, at)
        tail = nodes[min(end, len(nodes) - 1)]
        try:
            if not parts:
                raise NotSaidError("it has no end")
            self.state.tick(head)
            if head.code.startswith("FOR"):
                self.counted(head, parts[0][1])
            elif head.code.startswith("WHILE"):
                self.rounds(head, parts[0][1])
            elif head.code.startswith("IF"):
                self.nodes(
                    next((inside for when, inside in parts if when == "ELSE" or self.true(_condition(when))), ())
                )
            else:
                self.nodes(self.chosen(head, parts))
        except NotSaidError as reason:
            self.state.gap(head, f"which way it goes isn't known ({reason}), so none is judged", tail.number)
        return end + 1

    def rounds(self, head: Line, inside: Sequence[Line | MoveRow]) -> None:
        """WHILE. One whose rounds end as the one or two before them did goes on for ever. Raises NotSaidError, LostError."""
        data: list[str] = []
        count, condition = 0, head.code.removeprefix("WHILE").removesuffix("DO").strip()
        while self.true(condition):
            self.state.tick(head)
            count += 1
            if count <= _LOOKED_AT:
                data.append(self.held())
                if data[-1] in data[-3:-1]:
                    raise LostError(f"line {head.number}: a WHILE whose rounds change nothing never ends")
            if condition == "TRUE" and count > _MOST_ROUNDS:
                raise LostError(f"line {head.number}: a WHILE TRUE of more than {_MOST_ROUNDS} rounds may never end")
            self.nodes(inside)

    def true(self, text: str) -> bool:
        """A condition. Raises NotSaidError."""
        value = self.records.value(text)
        if not isinstance(value, bool):
            raise NotSaidError("neither TRUE nor FALSE")
        return value

    def counted(self, head: Line, inside: Sequence[Line | MoveRow]) -> None:
        """FOR, whose counter is known within it alone; down by 1 where it begins above its end. Raises NotSaidError."""
        found = _FOR.fullmatch(head.code)
        if found is None:
            raise NotSaidError("it is no FOR")
        first, last = numbers_of([self.records.value(found["first"]), self.records.value(found["last"])], 2)
        step = (
            numbers_of([self.records.value(found["step"])], 1)[0] if found["step"] else 1.0 if first <= last else -1.0
        )
        if any(value != int(value) for value in (first, last, step)) or step == 0.0:
            raise NotSaidError("it does not count in whole numbers")
        own, name = self.records.own, found["name"]
        kept = own.get(name)
        for value in range(int(first), int(last) + (1 if step > 0 else -1), int(step)):
            self.state.tick(head)
            own[name] = ("NUM", float(value))
            self.motions.forget()
            self.nodes(inside)
            if self.records.own.get(name) != ("NUM", float(value)):
                raise NotSaidError("its counter is set within it")
        own.pop(name, None)
        if kept is not None:
            own[name] = kept

    def chosen(self, head: Line, parts: Sequence[tuple[str, Sequence[Line | MoveRow]]]) -> Sequence[Line | MoveRow]:
        """TEST: what is run of it. Raises NotSaidError."""
        tested = head.code.removeprefix("TEST").strip()
        for when, inside in parts[1:]:
            texts = split_top(when.removeprefix("CASE").removesuffix(":"))
            if when == "DEFAULT:" or any(self.true(f"({tested})=({text})") for text in texts):
                return inside
        return ()


def _condition(head: str) -> str:
    """What stands between IF or ELSEIF and THEN."""
    return re.sub(r"^(?:ELSE)?IF\b|\bTHEN$", "", head)
