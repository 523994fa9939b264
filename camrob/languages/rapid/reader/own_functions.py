"""A program's own functions: FUNC of values that only reckon ("Technical reference manual, RAPID kernel", functions)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from camrob.languages.rapid.reader.data import Data, Scope
from camrob.languages.rapid.reader.expressions import UnknownError, Value
from camrob.languages.rapid.reader.module import Node, Routine
from camrob.languages.rapid.reader.rapid_course import BLOCKS, parts_of, run_block
from camrob.languages.rapid.reader.tokens import Statement

__all__ = ["OwnFunctions"]

_DEEPEST = 20  # functions that call functions


class _ReturnedError(Exception):
    """RETURN, with what it gives."""

    def __init__(self, value: Value) -> None:
        super().__init__()
        self.value = value


class OwnFunctions:
    """Runs functions. Whatever may do more than reckon, or isn't said by the text, makes the value unknown.

    carry_out: a declaration or an assignment, False for another statement. counted: called for each statement.
    """

    def __init__(
        self, data: Data, carry_out: Callable[[Statement], bool], counted: Callable[[], None], file: Callable[[], int]
    ) -> None:
        self._data, self._carry_out, self._counted, self._file = data, carry_out, counted, file
        self._known: dict[tuple[int, str], tuple[int, Routine]] = {}
        self._depth = 0
        data.call = self.value

    def add(self, index: int, routine: Routine) -> None:
        """A function of a module: what stands first under a name counts."""
        self._known.setdefault((index if routine.local else -1, routine.name), (index, routine))

    def value(self, name: str, given: Sequence[Value]) -> Value | None:
        """What a function gives; None where the program has none of that name. Raises UnknownError."""
        found = self._known.get((self._file(), name)) or self._known.get((-1, name))
        if found is None:
            return None
        index, routine = found
        parameters = routine.parameters
        if parameters is None or routine.referred or len(parameters) != len(given) or self._depth >= _DEEPEST:
            raise UnknownError(f"{name}()")
        data = self._data
        kept = (data.module, data.own)
        scope: Scope = {own: (kind, value) for (kind, own), value in zip(parameters, given, strict=True)}
        data.enter(data.modules[index], scope)
        self._depth += 1
        try:
            self._run(routine.nodes)
        except _ReturnedError as returned:
            return returned.value
        finally:
            self._depth -= 1
            data.enter(*kept)
        raise UnknownError(f"{name}() without RETURN")

    def _run(self, nodes: Sequence[Node]) -> None:
        at = 0
        while at < len(nodes):
            node = nodes[at]
            self._counted()
            if not isinstance(node, Statement):
                raise UnknownError("a function that moves")
            if node.word in BLOCKS:
                parts, at = parts_of(nodes, at)
                if not parts:
                    raise UnknownError(f"{node.word} in a function")
                run_block(node, parts, self._data, self._run, self._counted)
                continue
            self._one(node)
            at += 1

    def _one(self, statement: Statement) -> None:
        own = self._data.own or {}
        texts = [token.text for token in statement.tokens]
        if statement.word == "RETURN":
            raise _ReturnedError(self._data.value(statement.tokens[1:]))
        declares = texts[0] in ("VAR", "CONST")
        if not (declares or (":=" in texts and texts[0] in own)) or not self._carry_out(statement):
            raise UnknownError(f"{' '.join(texts[:3])} in a function")
