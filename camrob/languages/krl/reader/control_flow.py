"""Control structures of KRL whose course the program itself says."""

from __future__ import annotations

import re
from collections.abc import Callable

from camrob.errors import KrlError
from camrob.languages.krl.reader.expressions import Enumerated, Expression, Unknown, Value
from camrob.languages.krl.reader.module import Block, Module
from camrob.languages.krl.reader.tokens import Token, shown, tokens_of
from camrob.languages.krl.reader.variables import Variables

__all__ = ["Flow", "leave_loop"]

_LEAVES = re.compile(r"(?:EXIT|RETURN|GOTO|HALT)\b", re.I)
_LOOPS = ("FOR", "WHILE", "REPEAT", "LOOP")


class _ExitError(Exception):
    """EXIT: out of the loop round it."""


def leave_loop(module: Module, line: int) -> None:
    """EXIT. Raises KrlError where no loop is round it."""
    loops = (b for b in module.blocks.values() if module.statements[b.start].split()[0].upper() in _LOOPS)
    if not any(block.start < line < block.end for block in loops):
        raise KrlError("EXIT outside of a loop", hint="correct the program")
    raise _ExitError


class Flow:
    """IF, SWITCH and loops, by what their conditions are worth. run: runs lines of a module, False where a RETURN was met;
    passed: counts a pass.
    """

    def __init__(
        self, variables: Variables, run: Callable[[Module, int, int], bool], passed: Callable[[], None]
    ) -> None:
        self._variables, self._run, self._passed = variables, run, passed

    def block(self, module: Module, block: Block, word: str, tokens: tuple[Token, ...]) -> bool | None:
        """Whether to go on behind the block: False where a RETURN was met; None, with nothing run, where its course is not known.

        Raises KrlError where it becomes unknown on the way.
        """
        if word not in _LOOPS:
            return self._branch(module, block, tokens) if word == "IF" else self._switch(module, block, tokens)
        try:
            return self._for(module, block, tokens) if word == "FOR" else self._loop(module, block, word, tokens)
        except _ExitError:
            return True

    def _value(self, tokens: tuple[Token, ...]) -> Value:
        """What stands behind the first word of a statement."""
        return Expression(tokens, self._variables, 1).value()

    def _branch(self, module: Module, block: Block, tokens: tuple[Token, ...]) -> bool | None:
        condition = self._value(tokens)
        if not isinstance(condition, bool):
            return None
        split = block.middle if block.middle >= 0 else block.end
        first, last = (block.start + 1, split) if condition else (split + 1, block.end)
        return first >= last or self._run(module, first, last)

    def _switch(self, module: Module, block: Block, tokens: tuple[Token, ...]) -> bool | None:
        value = self._value(tokens)
        if isinstance(value, bool) or not isinstance(value, (int, str, Enumerated)):
            return None
        heads = [k for k in _own_lines(module, block) if re.match(r"(?:CASE|DEFAULT)\b", module.statements[k], re.I)]
        if not heads:
            return None
        for head, end in zip(heads, [*heads[1:], block.end], strict=True):
            case = tokens_of(module.statements[head].rstrip(": "))
            values: list[Value] = [value] if case[0].text == "DEFAULT" else []
            if not values:
                expression = Expression(case, self._variables, 1)
                values.append(expression.value())
                while expression.accept(","):
                    values.append(expression.value())
            if any(isinstance(v, Unknown) for v in values):
                return None
            if value in values:
                return head + 1 >= end or self._run(module, head + 1, end)
        return True

    def _for(self, module: Module, block: Block, tokens: tuple[Token, ...]) -> bool | None:
        """`FOR I = a TO b STEP c`."""
        expression = Expression(tokens, self._variables, 1)
        name = expression.path()
        expression.expect("=")
        first = expression.value()
        expression.expect("TO")
        last = expression.value()
        step: Value = expression.value() if expression.accept("STEP") else 1
        if not (isinstance(first, int) and isinstance(last, int) and isinstance(step, int)) or step == 0:
            return None
        for value in range(first, last + (1 if step > 0 else -1), step):
            self._passed()
            self._variables.assign(name, value)
            if not self._run(module, block.start + 1, block.end):
                return False
            if self._variables.lookup(name) != value:
                raise KrlError(f"FOR whose counter {name} is set within it", hint="use WHILE")
        self._variables.assign(name, Unknown(name))  # the last value or the one behind it
        return True

    def _loop(self, module: Module, block: Block, word: str, tokens: tuple[Token, ...]) -> bool | None:
        """WHILE, REPEAT and LOOP."""
        until = tokens_of(module.statements[block.end]) if word == "REPEAT" else ()
        inside = (module.statements.get(k, "") for k in range(block.start + 1, block.end))
        if word == "LOOP" and not any(_LEAVES.match(text) for text in inside):
            raise KrlError("LOOP without EXIT, which never ends", hint="name the program that it calls")
        passes = 0
        while True:
            ends = self._value(tokens) if word == "WHILE" else True
            if not isinstance(ends, bool):
                if not passes:
                    return None
                raise KrlError(
                    f"WHILE whose course is not known any more{_why(ends)}", hint="post the program as a plain sequence"
                )
            if not ends:
                return True
            passes += 1
            self._passed()
            if not self._run(module, block.start + 1, block.end):
                return False
            if until:
                done = self._value(until)
                if not isinstance(done, bool):
                    raise KrlError(
                        f"UNTIL a condition that is not known{_why(done)}", hint="post the program as a plain sequence"
                    )
                if done:
                    return True


def _why(value: Value) -> str:
    """What of a condition isn't known, for a message."""
    return f" ({shown(value.text)})" if isinstance(value, Unknown) and value.text else ""


def _own_lines(module: Module, block: Block) -> list[int]:
    """Lines with statements in the block, and in no block within it."""
    out, at = list[int](), block.start + 1
    while at < block.end:
        if at in module.blocks:
            at = module.blocks[at].end
        elif at in module.statements:
            out.append(at)
        at += 1
    return out
