"""Expressions of KRL, evaluated as far as their values are in the program."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camrob.errors import KrlError
from camrob.languages.krl.reader.tokens import Token, shown

__all__ = [
    "Aggregate",
    "Computed",
    "Enumerated",
    "Expression",
    "Mechanism",
    "Names",
    "Unknown",
    "Value",
    "doubtful_half",
    "place_of",
]

_DEEPEST = 40  # nested brackets: deeper than a person writes, and short of Python's own limit
_AFTER_VALUE = (",", "}", ")", "]")
_SINGLE_SHARE = 1e-5  # that some thousand sums in single precision may be off
_LARGEST_INTEGER = 2**53  # beyond it a double no longer tells neighbours apart


@dataclass(frozen=True, slots=True)
class Unknown:
    """A value that the program doesn't hold, and what it names."""

    text: str


class Computed(float):
    """A result of arithmetic: a controller's REAL has 32 bits, and may differ from it in the seventh digit."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Enumerated:
    """A value of an enumeration, such as #BASE."""

    text: str


@dataclass(frozen=True, slots=True)
class Aggregate:
    """`{TYPE: NAME value, ...}`; `type` is empty where none is written."""

    type: str
    fields: Mapping[str, Value]


@dataclass(frozen=True, slots=True)
class Mechanism:
    """`EK(root, mechanism, frame)`: a frame on a moving external kinematic."""

    frame: Aggregate | Unknown


Value = int | float | bool | str | Enumerated | Aggregate | Mechanism | Unknown


class Names(Protocol):
    """What names in an expression stand for."""

    def lookup(self, path: str) -> Value:
        """The value under a name such as `$VEL.CP` or `BASE_DATA[1]`."""

    def called(self, name: str, arguments: list[Value]) -> Value:
        """The value of a function."""

    def product(self, left: Value, right: Value) -> Value:
        """left : right, by the geometric operator."""


_LEVELS: tuple[tuple[str, ...], ...] = (
    ("==", "<>", "<", ">", "<=", ">="),  # loosest of all: "Expert Programming", priority of operators
    ("OR", "B_OR"),
    ("EXOR", "B_EXOR"),
    ("AND", "B_AND"),
    ("+", "-"),
    ("*", "/"),
    (":",),
)


_COMPARISONS: Mapping[str, Callable[[float, float], bool]] = {
    "==": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


class Expression:
    """A reader of expressions over the tokens of one statement. `at` is the place of the next token.

    Raises KrlError, without a place, for what is no expression.
    """

    def __init__(self, tokens: tuple[Token, ...], names: Names, at: int = 0) -> None:
        self.tokens = tokens
        self.at = at
        self._names = names
        self._depth = 0

    @property
    def next(self) -> Token:
        """The next token."""
        return self.tokens[self.at]

    def accept(self, text: str) -> bool:
        """Whether the next token is the name or sign `text`; it is passed then."""
        token = self.tokens[self.at]
        if token.text == text and token.kind in ("name", "sign"):
            self.at += 1
            return True
        return False

    def expect(self, text: str) -> None:
        """Passes the sign `text`. Raises KrlError where something else stands."""
        if not self.accept(text):
            raise KrlError(f"{text!r} is missing before {self.rest()!r}", hint="correct the statement")

    def rest(self) -> str:
        """What has not been read, for a message."""
        return shown(" ".join(t.text for t in self.tokens[self.at :]), 30)

    def value(self, level: int = 0) -> Value:
        """The value of the expression that begins here."""
        if level == 0 and (number := self._lone_number()) is not None:
            return number
        if level == len(_LEVELS):
            return self._single()
        left = self.value(level + 1)
        while self.next.kind in ("name", "sign") and self.next.text in _LEVELS[level]:
            operator = self.next.text
            self.at += 1
            right = self.value(level + 1)
            left = self._names.product(left, right) if operator == ":" else _combine(operator, left, right)
        return left

    def _lone_number(self) -> int | float | None:
        """The number that stands alone here, passed; None where no number or more than one stands: a short cut."""
        sign = 1 if self.next.text in ("-", "+") else 0
        token, after = self.tokens[self.at + sign], self.tokens[min(self.at + sign + 1, len(self.tokens) - 1)]
        if token.kind != "number" or (after.kind != "end" and after.text not in _AFTER_VALUE):
            return None
        negative = self.next.text == "-"
        self.at += sign + 1
        number = _literal(token.text)
        return -number if negative else number

    def path(self) -> str:
        """A variable's name with fields and indices: `$VEL.CP`, `XP[3].X`; an index that is not known becomes `?`."""
        token = self.next
        if token.kind != "name":
            raise KrlError(f"a name is missing before {self.rest()!r}", hint="correct the statement")
        self.at += 1
        text = token.text
        while True:
            if self.accept("."):
                if self.next.kind != "name":
                    raise KrlError(f"a field's name is missing before {self.rest()!r}", hint="correct the statement")
                text += "." + self.next.text
                self.at += 1
            elif self.accept("["):
                text += "[" + ",".join(self._indices()) + "]"
            else:
                return text

    def arguments(self) -> list[Value]:
        """Values between `(` and `)`; an empty argument is Unknown."""
        self.expect("(")
        values: list[Value] = []
        if self.accept(")"):
            return values
        while True:
            values.append(Unknown("") if self.next.text in (",", ")") else self.value())
            if self.accept(")"):
                return values
            self.expect(",")

    def _indices(self) -> list[str]:
        """Indices up to `]`."""
        indices: list[str] = []
        while not self.accept("]"):
            if self.accept(","):
                continue
            index = self.value()
            indices.append(str(index) if isinstance(index, int) and not isinstance(index, bool) else "?")
        return indices

    def _single(self) -> Value:
        """A literal, a variable, a call, an aggregate, a bracket, or one of these with a sign."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise KrlError("an expression is nested too deeply", hint="this is not an ordinary KRL program")
        try:
            return self._unnested()
        finally:
            self._depth -= 1

    def _unnested(self) -> Value:
        token = self.next
        if token.kind == "number":
            self.at += 1
            return _literal(token.text)
        if token.kind == "bits":
            self.at += 1
            return _whole(int(token.text[2:-1], 16 if token.text[1] == "H" else 2))
        if token.kind in ("string", "enum"):
            self.at += 1
            return token.text[1:-1] if token.kind == "string" else Enumerated(token.text)
        if self.accept("("):
            value = self.value()
            self.expect(")")
            return value
        if token.text in ("-", "+") or (token.kind == "name" and token.text in ("NOT", "B_NOT")):
            self.at += 1
            return _signed(token.text, self._single())
        if token.text == "{":
            return self.aggregate()
        if token.kind == "name" and token.text in ("TRUE", "FALSE"):
            self.at += 1
            return token.text == "TRUE"
        if token.kind != "name":
            raise KrlError(f"a value is missing before {self.rest()!r}", hint="correct the statement")
        path = self.path()
        return self._called(path) if self.next.text == "(" else self._names.lookup(path)

    def _called(self, name: str) -> Value:
        """The value of a function."""
        arguments = self.arguments()
        if name == "EK" and len(arguments) == 3:
            frame = arguments[2]
            return Mechanism(frame if isinstance(frame, (Aggregate, Unknown)) else Unknown(name))
        return self._names.called(name, arguments)

    def aggregate(self) -> Aggregate:
        """`{TYPE: NAME value, NAME value}`."""
        self.expect("{")
        kind = ""
        if self.next.kind == "name" and self.tokens[self.at + 1].text == ":":
            kind = self.next.text
            self.at += 2
        fields: dict[str, Value] = {}
        while True:
            name = self.path()
            if name in fields:
                raise KrlError(f"{shown(name)} is given twice in one aggregate", hint="leave one of them")
            fields[name] = self.value()
            if self.accept("}"):
                return Aggregate(kind, fields)
            self.expect(",")


def place_of(argument: tuple[Token, ...], names: Names) -> str:
    """The variable that stands alone as an argument, its indices worked out, `[?]` for an array; "" where a value stands."""
    if argument[0].kind != "name":
        return ""
    expression = Expression(argument, names)
    path = expression.path().replace("[]", "[?]")
    return path if expression.next.kind == "end" else ""


def _literal(text: str) -> int | float:
    """The number that a text spells: whole where it has neither point nor exponent."""
    return int(text) if text.isdigit() and len(text) < 16 else float(text)


def _signed(sign: str, value: Value) -> Value:
    """The value with a sign, or negated."""
    if isinstance(value, bool) and sign == "NOT":
        return not value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and sign in "+-":
        negative = Computed(-value) if isinstance(value, Computed) else -value
        return negative if sign == "-" else value
    return value if isinstance(value, Unknown) else Unknown(sign)


def _combine(operator: str, left: Value, right: Value) -> Value:
    """Value of a binary operation, Unknown where a side is or where the operation is not read here."""
    if isinstance(left, bool) and isinstance(right, bool):
        known = {
            "AND": left and right,
            "OR": left or right,
            "EXOR": left != right,
            "==": left == right,
            "<>": left != right,
        }
        return known.get(operator, Unknown(operator))
    if operator in ("==", "<>") and isinstance(left, (str, Enumerated)) and isinstance(right, (str, Enumerated)):
        return (left == right) == (operator == "==")
    numbers = not isinstance(left, bool) and not isinstance(right, bool)
    if numbers and isinstance(left, (int, float)) and isinstance(right, (int, float)):
        return _arithmetic(operator, left, right)
    return Unknown(f"... {operator} ...")


def _arithmetic(operator: str, left: float, right: float) -> Value:
    """Comparisons and arithmetic; two integers divide to an integer, as KRL does."""
    if operator in _COMPARISONS:
        return _compared(operator, left, right)
    whole = isinstance(left, int) and isinstance(right, int)
    if operator == "/":
        if right == 0:
            raise KrlError("a division by zero", hint="correct the statement")
        if whole:
            return int(abs(left) // abs(right)) * (1 if (left < 0) == (right < 0) else -1)
        return _computed(left / right, left, right)
    if operator.startswith("B_") and isinstance(left, int) and isinstance(right, int):
        return {"B_AND": left & right, "B_OR": left | right, "B_EXOR": left ^ right}[operator]
    values = {"+": lambda: left + right, "-": lambda: left - right, "*": lambda: left * right}
    if operator not in values:
        return Unknown(operator)
    value = values[operator]()
    return _whole(value) if isinstance(value, int) else _computed(value, left, right)


def _computed(value: float, *given: float) -> float:
    """The result as a plain number where a controller has it, and what it comes of, to the last bit."""
    numbers = np.array([value, *given])
    exact = not any(isinstance(number, Computed) for number in given)
    with np.errstate(over="ignore"):
        return value if exact and bool(np.all(np.float32(numbers) == numbers)) else Computed(value)


def _compared(operator: str, left: float, right: float) -> Value:
    """A comparison; Unknown of results of arithmetic that are so near each other that single precision decides."""
    near = abs(left - right) <= _SINGLE_SHARE * max(abs(left), abs(right))
    if near and (isinstance(left, Computed) or isinstance(right, Computed)):
        return Unknown(f"... {operator} ... of REALs that are nearly the same")
    if not (isinstance(left, int) and isinstance(right, int)):
        with np.errstate(over="ignore"):
            left, right = float(np.float32(left)), float(np.float32(right))
    return _COMPARISONS[operator](left, right)


def doubtful_half(value: float) -> bool:
    """Whether single precision decides which whole number a result of arithmetic is rounded to."""
    off = abs(value - math.floor(value) - 0.5)
    return isinstance(value, Computed) and off <= _SINGLE_SHARE * max(abs(value), 1.0)


def _whole(value: int) -> int:
    """The same number. Raises KrlError where it is larger than KRL's, so that none grows without end."""
    if abs(value) > _LARGEST_INTEGER:
        raise KrlError(f"a whole number gets larger than {_LARGEST_INTEGER}", hint="KRL's integers are smaller")
    return value
