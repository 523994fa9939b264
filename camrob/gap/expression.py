"""Formulas in a cell's own effects: arithmetic on named signals, read and evaluated without ever being executed."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.units import deg_to_rad

__all__ = ["FUNCTIONS", "Expression", "parse_expression"]

Array = NDArray[np.float64]
Value = Array | float

_LONGEST, _MOST_NODES, _DEEPEST = 400, 120, 24  # characters, parts, parts in parts: longer is no formula of physics
_MOST_POWER = 8.0  # higher ones overflow on ordinary values

_BINARY: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
_PLAIN: dict[str, tuple[int, Callable[..., Value]]] = {
    "sin": (1, lambda x: np.sin(deg_to_rad(x))),
    "cos": (1, lambda x: np.cos(deg_to_rad(x))),
    "exp": (1, lambda x: np.exp(np.minimum(x, 50.0))),
    "abs": (1, np.abs),
    "sign": (1, np.sign),
    "sqrt": (1, lambda x: np.sqrt(np.maximum(x, 0.0))),
    "tanh": (1, np.tanh),
    "min": (2, np.minimum),
    "max": (2, np.maximum),
}
_OF_TIME = {"play": 2, "lag": 2}
FUNCTIONS = {**{name: count for name, (count, _) in _PLAIN.items()}, **_OF_TIME}
"""Functions and how many arguments they take: sin, cos of degrees; play(signal, width), lag(signal, seconds) have a memory."""


@dataclass(frozen=True, slots=True)
class Expression:
    """A formula. names: the signals and values that it asks for. Make it with `parse_expression`."""

    text: str
    names: frozenset[str]
    tree: ast.expr

    def value(
        self, signals: Mapping[str, Value], of_time: Mapping[str, Callable[[Array, float], Array]], count: int
    ) -> Array:
        """(count,) values. signals: by name; of_time: `play` and `lag`. What is not finite (1/0) is left as it comes."""
        with np.errstate(all="ignore"):
            found = _value(self.tree, signals, of_time, count)
        return np.broadcast_to(np.asarray(found, float), (count,)).copy()


def parse_expression(text: str, known: Collection[str]) -> Expression:
    """Read a formula. Raises ValueError, in one line, for anything but arithmetic on known names."""
    if len(text) > _LONGEST:
        raise ValueError(f"holds {len(text)} characters, {_LONGEST} are enough")
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError("is not a formula") from None
    if sum(1 for _ in ast.walk(tree)) > _MOST_NODES:
        raise ValueError("is too long a formula")
    names: set[str] = set()
    _check(tree, known, names, 0)
    return Expression(text, frozenset(names), tree)


def _check(node: ast.expr, known: Collection[str], names: set[str], depth: int) -> None:
    """Refuse every node that is no arithmetic; collect names."""
    if depth > _DEEPEST:
        raise ValueError("is nested too deeply")
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, int | float) or not _bearable(node.value):
            raise ValueError("holds something that is not an ordinary number")
    elif isinstance(node, ast.Name):
        if node.id not in known:
            raise ValueError(f"names {node.id[:30]!r}, which is not a signal; use {', '.join(sorted(known)[:60])}")
        names.add(node.id)
    elif isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        if isinstance(node.op, ast.Pow):
            power = node.right
            if not (
                isinstance(power, ast.Constant)
                and isinstance(power.value, int | float)
                and abs(power.value) <= _MOST_POWER
            ):
                raise ValueError(f"has a power that is not a number up to {_MOST_POWER:g}")
        _check(node.left, known, names, depth + 1)
        _check(node.right, known, names, depth + 1)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        _check(node.operand, known, names, depth + 1)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        count = FUNCTIONS.get(node.func.id)
        if count is None:
            raise ValueError(f"calls {node.func.id[:30]!r}; use {', '.join(sorted(FUNCTIONS))}")
        if len(node.args) != count:
            raise ValueError(f"gives {node.func.id} {len(node.args)} values, it takes {count}")
        for argument in node.args:
            _check(argument, known, names, depth + 1)
    else:
        raise ValueError("holds something beside numbers, signals, + - * / ** and functions")


def _bearable(value: float) -> bool:
    try:
        return math.isfinite(value) and abs(value) < 1e12
    except OverflowError:  # an integer without end
        return False


def _value(
    node: ast.expr, signals: Mapping[str, Value], of_time: Mapping[str, Callable[[Array, float], Array]], count: int
) -> Value:
    """The value of a node that `_check` has passed."""
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return signals[node.id]
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, signals, of_time, count)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        left, right = (_value(side, signals, of_time, count) for side in (node.left, node.right))
        return _BINARY[type(node.op)](left, right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        given = [_value(a, signals, of_time, count) for a in node.args]
        if node.func.id in _OF_TIME:
            signal = np.broadcast_to(np.asarray(given[0], float), (count,)).copy()
            return of_time[node.func.id](signal, float(np.ravel(given[1])[0]))
        return _PLAIN[node.func.id][1](*given)
    raise ValueError("no node of a formula")
