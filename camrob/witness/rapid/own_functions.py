"""The program's own functions (FUNC): what they give where they do nothing but reckon with what they are handed and with data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from camrob.witness.krl.text import Line
from camrob.witness.krl.values import split_top
from camrob.witness.rapid.block_parts import parts_of
from camrob.witness.rapid.expressions import Item, NotSaidError, numbers_of
from camrob.witness.rapid.module_text import MoveRow, Procedure
from camrob.witness.rapid.own_routines import functions_called
from camrob.witness.rapid.records import Records

__all__ = ["Functions"]

_Nodes = Sequence[Line | MoveRow]
_Scope = dict[str, tuple[str, Item]]
_BLOCK = re.compile(r"(?:IF\b.*\bTHEN|(?:FOR|WHILE)\b.*\bDO|TEST\b.*)")
_FOR = re.compile(r"FOR (?P<name>\w+) FROM (?P<first>.+?) TO (?P<last>.+?)(?: STEP (?P<step>.+?))? DO")
_DATUM = re.compile(
    r"(?P<how>CONST|VAR) (?P<kind>\w+) (?P<name>\w+) ?(?:\{(?P<sizes>[^{}]*)\})? ?(?::= ?(?P<value>.*))?"
)
_SET = re.compile(r"(?P<path>(?P<name>[A-Z_]\w*)(?: ?\{[^{}]*\}| ?\. ?[A-Z_]\w*)*) ?:= ?(?P<value>.+)")
_COURSE = re.compile(rf"{_BLOCK.pattern}|ELSEIF\b.*\bTHEN|ELSE|CASE\b.*:|DEFAULT:|END(?:IF|FOR|WHILE|TEST)|RETURN .+")
_MOST = 20_000  # statements of one value
_DEEP = 20  # functions in functions


@dataclass(frozen=True, slots=True)
class _Given:
    """RETURN, and what it gives."""

    value: Item


class Functions:
    """The functions of all modules, by module ("" where all see it) and name. `here`: the module that runs, by its path."""

    def __init__(self, records: Records) -> None:
        self.records = records
        self.here = ""
        self._all: dict[tuple[str, str], tuple[str, Procedure, _Scope]] = {}
        self._taken = self._depth = 0
        records.own_function = self.value

    def add(self, path: str, function: Procedure, scope: _Scope) -> None:
        """A function of the module at `path`, whose LOCAL data are `scope`."""
        own = path if function.head.code.startswith("LOCAL ") else ""
        self._all.setdefault((own, function.name), (path, function, scope))

    def holds(self, name: str) -> bool:
        """Whether the module that runs sees a function of this name that does nothing but reckon, nor do those that it calls."""
        found = self._found(name)
        return found is not None and found[1].inputs is not None and self._reckons(found[1], set())

    def _reckons(self, function: Procedure, seen: set[str]) -> bool:
        own = {name for _, name in function.inputs or ()}
        seen.add(function.name)
        for node in function.nodes:
            code = node.code if isinstance(node, Line) else ""
            sets, datum = _SET.fullmatch(code), _DATUM.fullmatch(code)
            if datum is not None:
                own.add(datum["name"])
            elif not _COURSE.fullmatch(code) and (sets is None or sets["name"] not in own):
                return False
            for called in functions_called(f"; {code}"):
                found = self._found(called)
                if found is None or (called not in seen and not self._reckons(found[1], seen)):
                    return False
        return True

    def _found(self, name: str) -> tuple[str, Procedure, _Scope] | None:
        return self._all.get((self.here, name)) or self._all.get(("", name))

    def value(self, name: str, given: Sequence[Item]) -> Item:
        """What a function gives. Raises NotSaidError for none of the program's, and for one that does more than reckon."""
        found = self._found(name)
        if found is None or found[1].inputs is None or len(found[1].inputs) != len(given) or self._depth >= _DEEP:
            raise NotSaidError(f"{name[:40]}() isn't in the program, or takes its values otherwise")
        path, function, scope = found
        records = self.records
        kept = (self.here, records.own, records.module)
        self._taken = 0 if not self._depth else self._taken
        self._depth += 1
        named = zip(function.inputs or (), given, strict=True)
        self.here, records.module = path, scope
        records.own = {own: (kind, item) for (kind, own), item in named}
        try:
            gives = self._run(function.nodes)
        finally:
            self._depth -= 1
            self.here, records.own, records.module = kept
        if gives is None:
            raise NotSaidError(f"{name[:40]}() ends without RETURN")
        return gives.value

    def _run(self, nodes: _Nodes) -> _Given | None:
        """Statements one after another, up to RETURN."""
        at = 0
        while at < len(nodes):
            node = nodes[at]
            self._taken += 1
            if isinstance(node, MoveRow) or self._taken > _MOST:
                raise NotSaidError("a function that moves, or has no end")
            if _BLOCK.fullmatch(node.code):
                parts, end = parts_of(nodes, at)
                if not parts:
                    raise NotSaidError("a block without its end")
                gives = self._block(node.code, parts)
                at = end
            elif node.code.startswith("RETURN "):
                gives = _Given(self.records.value(node.code.removeprefix("RETURN ")))
            else:
                self._datum(node.code)
                gives = None
            if gives is not None:
                return gives
            at += 1
        return None

    def _datum(self, code: str) -> None:
        """A declaration, or a datum of the function's own that is set."""
        records = self.records
        if (found := _DATUM.fullmatch(code)) is not None:
            text, sizes = found["value"] or "", found["sizes"] or ""
            records.declare(found["kind"], found["name"], text, records.own, sizes=sizes, how=found["how"])
            return
        match = _SET.fullmatch(code)
        if match is None or match["name"] not in records.own:
            raise NotSaidError(f"{code[:40]} in a function")
        records.put(match["path"].replace(" ", ""), records.value(match["value"]))

    def _block(self, head: str, parts: Sequence[tuple[str, _Nodes]]) -> _Given | None:
        if head.startswith("IF"):
            chosen = next((inside for when, inside in parts if when == "ELSE" or self._true(_condition(when))), ())
            return self._run(chosen)
        if head.startswith("WHILE"):
            while self._true(head.removeprefix("WHILE").removesuffix("DO")):
                self._taken += 1
                if self._taken > _MOST:
                    raise NotSaidError("a function without an end")
                if (gives := self._run(parts[0][1])) is not None:
                    return gives
            return None
        return self._counted(head, parts[0][1]) if head.startswith("FOR") else self._tested(head, parts)

    def _counted(self, head: str, inside: _Nodes) -> _Given | None:
        found, records = _FOR.fullmatch(head), self.records
        if found is None:
            raise NotSaidError("it is no FOR")
        ends = numbers_of([records.value(found["first"]), records.value(found["last"])], 2)
        step = (
            numbers_of([records.value(found["step"])], 1)[0] if found["step"] else 1.0 if ends[0] <= ends[1] else -1.0
        )
        if any(value != int(value) for value in (*ends, step)) or step == 0.0:
            raise NotSaidError("it does not count in whole numbers")
        name, own = found["name"], records.own
        hidden = own.get(name)
        for value in range(int(ends[0]), int(ends[1]) + (1 if step > 0 else -1), int(step)):
            own[name] = ("NUM", float(value))
            if (gives := self._run(inside)) is not None:
                return gives
            if own.get(name) != ("NUM", float(value)):
                raise NotSaidError("its counter is set within it")
        own.pop(name, None)
        if hidden is not None:
            own[name] = hidden
        return None

    def _tested(self, head: str, parts: Sequence[tuple[str, _Nodes]]) -> _Given | None:
        tested = head.removeprefix("TEST").strip()
        for when, inside in parts[1:]:
            texts = split_top(when.removeprefix("CASE").removesuffix(":"))
            if when == "DEFAULT:" or any(self._true(f"({tested})=({text})") for text in texts):
                return self._run(inside)
        return None

    def _true(self, text: str) -> bool:
        value = self.records.value(text)
        if not isinstance(value, bool):
            raise NotSaidError("neither TRUE nor FALSE")
        return value


def _condition(head: str) -> str:
    """What stands between IF or ELSEIF and THEN."""
    return re.sub(r"^(?:ELSE)?IF\b|\bTHEN$", "", head)
