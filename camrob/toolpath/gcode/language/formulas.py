"""Expressions of part programs: numbers, variables, functions and brackets, with the operators' ranks of each control."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from camrob.errors import ToolpathError
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["COMPARISONS", "FUNCTIONS", "LOGIC", "NOTHING", "Grammar", "Operator", "Reader", "Value", "fup", "whole"]

Value = float | None  # None: a variable of Fanuc's that has no value
Operator = Callable[[float, float], float]

NOTHING = math.nan
"""What a reader gives (this object itself) where no value stands."""
_NUMBER = re.compile(r"[0-9]+\.?[0-9]*|\.[0-9]+")
_NAME = re.compile(r"[A-Z_]+")
_DEEPEST = 60  # brackets, functions and variables in one another: real macros have a handful
_EVEN = 1e-9  # two numbers that differ by less are one, as with a control's own digits


def whole(value: float, what: str) -> int:
    """A value that has to be a whole number. Raises ToolpathError for another one."""
    if not math.isfinite(value) or abs(value - round(value)) > _EVEN * max(1.0, abs(value)):
        raise ToolpathError(f"{what} {value:g} is not a whole number", hint="check the expression")
    return round(value)


def fup(value: float) -> float:
    """The next whole number away from zero (Fanuc's FUP)."""
    return math.copysign(math.ceil(abs(value)), value) if value else 0.0


def _over(a: float, b: float) -> float:
    if b == 0.0:
        raise ToolpathError("a division by zero", hint="check the expression")
    return a / b


def _mod(a: float, b: float) -> float:
    """The remainder with the sign of the divisor, as LinuxCNC has it; for numbers above zero all controls agree."""
    if b == 0.0:
        raise ToolpathError("a division by zero (MOD)", hint="check the expression")
    if a < 0.0 or b < 0.0:
        raise ToolpathError("MOD of a number below zero: controls differ in its sign", hint="use numbers above zero")
    return math.fmod(a, b)


def _power(a: float, b: float) -> float:
    try:
        return float(a**b)
    except (OverflowError, ZeroDivisionError, TypeError):
        raise ToolpathError(f"{a:g} to the power of {b:g} has no value", hint="check the expression") from None


def _bits(name: str, combine: Callable[[int, int], int]) -> Operator:
    def of(a: float, b: float) -> float:
        return float(combine(whole(a, name), whole(b, name)))

    return of


def _root(x: float) -> float:
    if x < 0.0:
        raise ToolpathError(f"the square root of {x:g}", hint="check the expression")
    return math.sqrt(x)


def _arc(name: str, function: Callable[[float], float]) -> Callable[[float], float]:
    def of(x: float) -> float:
        if abs(x) > 1.0 + _EVEN:
            raise ToolpathError(f"{name} of {x:g}", hint="check the expression")
        return rad_to_deg(function(max(-1.0, min(1.0, x))))

    return of


def _tan(x: float) -> float:
    if abs(math.cos(deg_to_rad(x))) < 1e-12:  # the tangent of a right angle: controls give an alarm
        raise ToolpathError(f"TAN of {x:g} degrees", hint="check the expression")
    return math.tan(deg_to_rad(x))


def _log(x: float) -> float:
    if x <= 0.0:
        raise ToolpathError(f"the logarithm of {x:g}", hint="check the expression")
    return math.log(x)


def _exp(x: float) -> float:
    return _power(math.e, x)


def _half_up(x: float) -> float:
    """The nearest whole number, halves away from zero."""
    return math.copysign(math.floor(abs(x) + 0.5), x)


FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda x: math.sin(deg_to_rad(x)),
    "COS": lambda x: math.cos(deg_to_rad(x)),
    "TAN": _tan,
    "ASIN": _arc("ASIN", math.asin),
    "ACOS": _arc("ACOS", math.acos),
    "ATAN": lambda x: rad_to_deg(math.atan(x)),
    "SQRT": _root,
    "ABS": abs,
    "ROUND": _half_up,
    "EXP": _exp,
    "LN": _log,
}
"""What all controls have under these names; angles in degrees."""

COMPARISONS: dict[str, Operator] = {
    "EQ": lambda a, b: float(abs(a - b) <= _EVEN),
    "NE": lambda a, b: float(abs(a - b) > _EVEN),
    "GT": lambda a, b: float(a - b > _EVEN),
    "GE": lambda a, b: float(a - b >= -_EVEN),
    "LT": lambda a, b: float(b - a > _EVEN),
    "LE": lambda a, b: float(b - a >= -_EVEN),
}
LOGIC: dict[str, Operator] = {
    "AND": lambda a, b: float(bool(a) and bool(b)),
    "OR": lambda a, b: float(bool(a) or bool(b)),
    "XOR": lambda a, b: float(bool(a) != bool(b)),
}
BITS: dict[str, Operator] = {
    "AND": _bits("AND", lambda a, b: a & b),
    "OR": _bits("OR", lambda a, b: a | b),
    "XOR": _bits("XOR", lambda a, b: a ^ b),
}
ARITHMETIC: dict[str, Operator] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": _over,
    "MOD": _mod,
    "**": _power,
    "^": _power,
}


class Grammar(NamedTuple):
    """How one control writes expressions. `levels`: binary operators, the loosest first, each level from left to right.

    `opens`, `closes`: its brackets. `bare`: a function's argument needs none. `atan`: the arc tangent of two numbers, by what
    stands between them ("/[", ","), in degrees. `compares`: the operators that may meet a variable without a value.
    """

    levels: tuple[Mapping[str, Operator], ...]
    functions: Mapping[str, Callable[[float], float]]
    opens: str = "["
    closes: str = "]"
    bare: bool = False
    atan: Callable[[float, float], float] = lambda y, x: rad_to_deg(math.atan2(y, x))
    compares: Callable[[str, Value, Value], float | None] = lambda name, a, b: None


class Reader:
    """Reads expressions out of `text` (upper case, without blanks) from `at` on; `variable` reads one where it stands.

    `variable` gets the reader, and moves `at` behind the variable; it returns NOTHING where none stands there.
    """

    def __init__(self, text: str, grammar: Grammar, variable: Callable[[Reader], Value]) -> None:
        self.text = text
        self.at = 0
        self.grammar = grammar
        self._variable = variable
        self._deep = 0

    @property
    def rest(self) -> str:
        """What has not been read."""
        return self.text[self.at :]

    def take(self, piece: str) -> bool:
        """Whether that stands here; moves behind it."""
        if not self.text.startswith(piece, self.at):
            return False
        self.at += len(piece)
        return True

    def fail(self, what: str = "") -> ToolpathError:
        """That nothing can be read here, as an error to be raised."""
        found = what or f"{self.rest[:16] or 'the end of the line'!r} where a value should be"
        return ToolpathError(f"an expression that can't be read: {found}", hint="check its brackets and operators")

    def number(self) -> float | None:
        """A plain number, or None where none stands here."""
        match = _NUMBER.match(self.text, self.at)
        if match is None:
            return None
        self.at = match.end()
        return float(match[0])

    def expression(self, level: int = 0) -> Value:
        """A whole expression. Raises ToolpathError where there is none, or where it has no value."""
        levels = self.grammar.levels
        if level == len(levels):
            return self._signed()
        left = self.expression(level + 1)
        while (name := self._operator(levels[level])) is not None:
            right = self.expression(level + 1)
            decided = self.grammar.compares(name, left, right)
            left = levels[level][name](left or 0.0, right or 0.0) if decided is None else decided
        return left

    def bracketed(self) -> Value:
        """An expression in brackets, or NOTHING where no bracket opens here."""
        if not self.take(self.grammar.opens):
            return NOTHING
        value = self.expression()
        if not self.take(self.grammar.closes):
            raise self.fail(f"no {self.grammar.closes!r} before {self.rest[:16] or 'the end of the line'!r}")
        return value

    def operand(self) -> Value:
        """A number, a variable, a function or an expression in brackets; NOTHING where none stands here."""
        number = self.number()
        if number is not None:
            return number
        self._deep += 1
        if self._deep > _DEEPEST:
            raise self.fail(f"more than {_DEEPEST} values in one another")
        value = self.bracketed()
        if value is NOTHING:
            value = self._variable(self)
        if value is NOTHING:
            value = self._function()
        self._deep -= 1
        return value

    def _signed(self) -> Value:
        """An operand with a sign in front, or without."""
        negative = False
        while self.text[self.at : self.at + 1] in ("+", "-"):
            negative ^= self.text[self.at] == "-"
            self.at += 1
        value = self.operand()
        if value is NOTHING:
            raise self.fail()
        return -(value or 0.0) if negative else value

    def _operator(self, level: Mapping[str, Operator]) -> str | None:
        """The operator of that level that stands here; moves behind it."""
        for name in sorted(level, key=len, reverse=True):
            if name == "*" and self.text.startswith("**", self.at):
                continue
            if self.take(name):
                return name
        return None

    def _function(self) -> Value:
        """A function of an expression in brackets."""
        match = _NAME.match(self.text, self.at)
        name = match[0] if match else ""
        if self.grammar.bare and name:  # SIN30, COSQ1: the longest name that begins here
            name = max((f for f in self.grammar.functions if name.startswith(f)), key=len, default="")
        function = self.grammar.functions.get(name)
        if function is None:
            return NOTHING
        self.at += len(name)
        value = self._signed() if self.grammar.bare else self.bracketed()
        if value is NOTHING:
            raise self.fail()
        if name == "ATAN" and not self.grammar.bare and self.take("/" + self.grammar.opens):
            self.at -= 1
            other = self.bracketed()
            return self.grammar.atan(value or 0.0, other or 0.0)
        return function(value or 0.0)
