"""RAPID's expressions, as far as they are known from the text alone."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from camrob.languages.rapid.reader.tokens import Token, joined
from camrob.se3 import quaternion_to_rotation
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["FIELDS", "Computed", "Names", "UnknownError", "Value", "element", "indices_of", "number", "value_of"]

Value = float | bool | str | list["Value | None"]
"""A number, a truth value, a text, or a record's components in their order, None what the text does not say."""

_AXES = "abcdef"
FIELDS: dict[str, tuple[tuple[str, str], ...]] = {
    "POS": tuple((c, "NUM") for c in "XYZ"),
    "ORIENT": tuple((f"Q{k}", "NUM") for k in range(1, 5)),
    "POSE": (("TRANS", "POS"), ("ROT", "ORIENT")),
    "CONFDATA": tuple((c, "NUM") for c in ("CF1", "CF4", "CF6", "CFX")),
    "ROBJOINT": tuple((f"RAX_{k}", "NUM") for k in range(1, 7)),
    "EXTJOINT": tuple((f"EAX_{c.upper()}", "NUM") for c in _AXES),
    "ROBTARGET": (("TRANS", "POS"), ("ROT", "ORIENT"), ("ROBCONF", "CONFDATA"), ("EXTAX", "EXTJOINT")),
    "JOINTTARGET": (("ROBAX", "ROBJOINT"), ("EXTAX", "EXTJOINT")),
    "SPEEDDATA": tuple((c, "NUM") for c in ("V_TCP", "V_ORI", "V_LEAX", "V_REAX")),
    "ZONEDATA": (
        ("FINEP", "BOOL"),
        *((c, "NUM") for c in ("PZONE_TCP", "PZONE_ORI", "PZONE_EAX", "ZONE_ORI", "ZONE_LEAX", "ZONE_REAX")),
    ),
    "LOADDATA": (("MASS", "NUM"), ("COG", "POS"), ("AOM", "ORIENT"), ("IX", "NUM"), ("IY", "NUM"), ("IZ", "NUM")),
    "TOOLDATA": (("ROBHOLD", "BOOL"), ("TFRAME", "POSE"), ("TLOAD", "LOADDATA")),
    "WOBJDATA": (
        ("ROBHOLD", "BOOL"),
        ("UFPROG", "BOOL"),
        ("UFMEC", "STRING"),
        ("UFRAME", "POSE"),
        ("OFRAME", "POSE"),
    ),
}
"""The components of RAPID's records (ABB's technical reference manual, data types)."""

_DEEPEST = 40  # brackets in brackets and signs before signs: no record has more than four
_NEARLY = 1e-5  # share that some thousand sums in single precision may be off
_TURNS = ("RX", "RY", "RZ")
_UNIT = 0.02  # what the square of a printed quaternion may be off 1


class UnknownError(Exception):
    """A value that the text does not say."""


class Computed(float):
    """A result of arithmetic: a controller's num has 32 bits, and may differ from it in the seventh digit."""

    __slots__ = ()


class Names(Protocol):
    """What is declared; call: the program's own functions, None of a name that it has none of."""

    call: Callable[[str, Sequence[Value]], Value | None] | None

    def find(self, name: str) -> tuple[str, Value | None]:
        """Type and value under a name; neither where it isn't declared."""


def _new_number(text: str) -> float:
    return float(int(text, 16)) if text[:2].lower() == "0x" else float(text)


def element(kind: str, whole: Value | None, at: tuple[int, ...]) -> tuple[str, Value | None]:
    """An element's type and value, counted from 1. Raises UnknownError."""
    for k in at:
        if not kind.endswith("{}") or not isinstance(whole, list) or not 1 <= k <= len(whole):
            raise UnknownError(f"{{{k}}}")
        kind, whole = kind.removesuffix("{}"), whole[k - 1]
    if kind.endswith("{}"):
        raise UnknownError("an array's part")
    return kind, whole


def _index(value: Value) -> int:
    given = number(value)
    if isinstance(given, Computed) or given != int(given):
        raise UnknownError(f"index {given:g}")
    return int(given)


def value_of(tokens: Sequence[Token], names: Names) -> Value:
    """The value of an expression. Raises UnknownError where the text does not say it."""
    reader = _Expression(names, tuple(tokens))
    out = reader.either()
    if reader.at != len(tokens):
        raise UnknownError(joined(tuple(tokens))[:60])
    return out


def indices_of(tokens: Sequence[Token], names: Names) -> tuple[int, ...]:
    """Whole numbers between commas. Raises UnknownError."""
    reader = _Expression(names, tuple(tokens))
    out = [_index(reader.either())]
    while reader.peek() == ",":
        reader.take()
        out.append(_index(reader.either()))
    if reader.at != len(tokens):
        raise UnknownError(joined(tuple(tokens))[:60])
    return tuple(out)


@dataclass(slots=True)
class _Expression:
    """Reads an expression of numbers, truths, names, records, operators and brackets."""

    data: Names
    tokens: tuple[Token, ...]
    at: int = 0
    depth: int = 0

    def peek(self) -> str:
        return self.tokens[self.at].text if self.at < len(self.tokens) else ""

    def take(self) -> Token:
        if self.at >= len(self.tokens):
            raise UnknownError("nothing")
        self.at += 1
        return self.tokens[self.at - 1]

    def either(self) -> Value:
        """OR, XOR and NOT bind loosest, then AND, then comparisons ("RAPID kernel", priority of operators)."""
        out = self.both()
        while self.peek() in ("OR", "XOR"):
            word, other = self.take().text, _truth(self.both())
            out = (_truth(out) or other) if word == "OR" else _truth(out) != other
        return out

    def both(self) -> Value:
        if self.peek() == "NOT":
            self.take()
            out: Value = not _truth(self.comparison())
            if self.peek() == "AND":
                raise UnknownError("NOT and AND without brackets")
            return out
        out = self.comparison()
        while self.peek() == "AND":
            self.take()
            other = _truth(self.comparison())
            out = _truth(out) and other
        return out

    def comparison(self) -> Value:
        out = self.sum()
        while self.peek() in _COMPARISONS:
            sign, other = self.take().text, self.sum()
            out = _compared(sign, out, other)
        return out

    def sum(self) -> Value:
        out = self.product()
        while self.peek() in ("+", "-"):
            sign, other = self.take().text, self.product()
            out = _plus(out, other, 1.0 if sign == "+" else -1.0)
        return out

    def product(self) -> Value:
        out = self.factor()
        while self.peek() in ("*", "/", "DIV", "MOD"):
            sign, a, b = self.take().text, number(out), number(self.factor())
            if sign != "*" and b == 0.0:
                raise UnknownError("a division by 0")
            if sign in ("DIV", "MOD"):
                if min(a, b) < 0.0 or any(isinstance(v, Computed) or v != int(v) for v in (a, b)):
                    raise UnknownError(f"{sign} of such numbers")
                out = float(a // b) if sign == "DIV" else float(a % b)
            else:
                out = _computed(a * b if sign == "*" else a / b, a, b)
        return out

    def factor(self) -> Value:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise UnknownError("brackets without end")
        out = self.single()
        self.depth -= 1
        return out

    def single(self) -> Value:
        token = self.take()
        if token.kind == "number":
            return _new_number(token.text)
        if token.kind == "string":
            return token.text[1:-1].replace('""', '"')
        if token.text == "-":
            value = number(self.factor())
            return Computed(-value) if isinstance(value, Computed) else -value
        if token.text == "+":
            return number(self.factor())
        if token.text == "(":
            out = self.either()
            self.close(")")
            return out
        if token.text == "[":
            return list(self.listed("]"))
        if token.kind != "name":
            raise UnknownError(token.text)
        return self.named(token.text)

    def listed(self, bracket: str) -> list[Value]:
        """Values between commas, up to a closing bracket."""
        items = [self.either()]
        while self.peek() == ",":
            self.take()
            items.append(self.either())
        self.close(bracket)
        return items

    def close(self, bracket: str) -> None:
        if self.take().text != bracket:
            raise UnknownError(f"no {bracket}")

    def named(self, name: str) -> Value:
        """A name, with the components asked for behind it; TRUE and FALSE; Offs and RelTool of a robtarget."""
        if name in ("TRUE", "FALSE"):
            return name == "TRUE"
        if name in ("OFFS", "RELTOOL") and self.peek() == "(":
            return self.moved(name)
        if self.peek() == "(":
            return self.given(name)
        kind, value = self.data.find(name)
        while self.peek() in (".", "{"):
            if self.take().text == "{":
                kind, value = element(kind, value, tuple(map(_index, self.listed("}"))))
                continue
            part = self.take().text
            names = [n for n, _ in FIELDS.get(kind, ())]
            if part not in names or not isinstance(value, list) or len(value) != len(names):
                raise UnknownError(f"{name}.{part}")
            kind, value = FIELDS[kind][names.index(part)][1], value[names.index(part)]
        if value is None:
            raise UnknownError(name)
        return value

    def given(self, name: str) -> Value:
        """What a function gives: the program's own, or one of RAPID's."""
        self.take()
        values = [] if self.peek() == ")" else self.listed(")")
        if not values:
            self.close(")")
        own = self.data.call(name, values) if self.data.call is not None else None
        return _function(name, values) if own is None else own

    def moved(self, name: str) -> Value:
        r"""Offs(p, x, y, z): p displaced in its work object; RelTool(p, x, y, z): along the tool's axes there, and turned about
        them by \Rx, then \Ry, then \Rz degrees.
        """
        self.take()
        items, turns = self.arguments()
        target = items[0]
        if len(items) != 4 or not isinstance(target, list) or len(target) != 4:
            raise UnknownError(name)
        start = target[0]
        if not isinstance(start, list) or len(start) != len("XYZ"):
            raise UnknownError(name)
        step = [number(value) for value in items[1:]]
        if name == "RELTOOL":
            step = _turned(step, target[1])
        place: list[Value | None] = [Computed(number(a) + b) for a, b in zip(start, step, strict=True)]
        if not turns:
            return [place, *target[1:]]
        if name != "RELTOOL" or not isinstance(target[1], list):
            raise UnknownError(f"{name} with a turn")
        q = np.array([number(value) for value in target[1]])
        about = [turns.get(axis, 0.0) for axis in _TURNS]
        return [place, [Computed(c) for c in _turned_on(q, about)], *target[2:]]

    def arguments(self) -> tuple[list[Value], dict[str, float]]:
        """Values between commas up to a closing bracket, and the turns among them: a comma may stand before these, too."""
        items, turns = [self.either()], dict[str, float]()
        while self.peek() in (",", "\\"):
            if self.take().text == "," and self.peek() != "\\":
                items.append(self.either())
                continue
            if self.tokens[self.at - 1].text == ",":
                self.take()
            axis = self.take().text
            if axis not in _TURNS or axis in turns or self.take().text != ":=":
                raise UnknownError(f"\\{axis[:20]}")
            turns[axis] = number(self.either())
        self.close(")")
        return items, turns


def _turned(v: list[float], quaternion: Value | None) -> list[float]:
    """A vector (3,) by a quaternion of unit length, as a program prints it."""
    if not isinstance(quaternion, list) or len(quaternion) != 4:
        raise UnknownError("RelTool of a target that isn't turned")
    q = np.array([number(value) for value in quaternion])
    if not abs(float(q @ q) - 1.0) < _UNIT:
        raise UnknownError("a quaternion whose length is not 1")
    return [float(c) for c in quaternion_to_rotation(q) @ v]


def _turned_on(q: NDArray[np.float64], degrees: Sequence[float]) -> list[float]:
    """A quaternion (4,) turned about its own x, then about the new y, then about the new z."""
    for axis, angle in enumerate(degrees):
        half = deg_to_rad(angle) / 2.0
        other = np.zeros(4)
        other[0], other[1 + axis] = math.cos(half), math.sin(half)
        vector = q[0] * other[1:] + other[0] * q[1:] + np.cross(q[1:], other[1:])
        q = np.array([q[0] * other[0] - q[1:] @ other[1:], *vector])
    return [float(c) for c in q]


def number(value: Value | None) -> float:
    """The number that a value is. Raises UnknownError."""
    if value is None or isinstance(value, bool) or not isinstance(value, int | float):
        raise UnknownError(str(value)[:40])
    return value if isinstance(value, float) else float(value)


def _truth(value: Value | None) -> bool:
    if not isinstance(value, bool):
        raise UnknownError(f"{str(value)[:40]} is neither TRUE nor FALSE")
    return value


def _plus(a: Value | None, b: Value | None, sign: float) -> Value:
    """Numbers, or records of numbers component by component (pos + pos); texts one behind the other."""
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [_plus(x, y, sign) for x, y in zip(a, b, strict=True)]
    if isinstance(a, str) and isinstance(b, str) and sign > 0.0:
        return a + b
    left, right = number(a), number(b)
    return _computed(left + sign * right, left, right)


def _computed(value: float, *given: float) -> float:
    """The result, plain where a controller has it, and what it comes of, to the last bit."""
    numbers = np.array([value, *given])
    exact = not any(isinstance(one, Computed) for one in given)
    with np.errstate(over="ignore"):
        return value if exact and bool(np.all(np.float32(numbers) == numbers)) else Computed(value)


_COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def _compared(sign: str, left: Value, right: Value) -> bool:
    """A comparison. Raises UnknownError where single precision decides it."""
    if sign in ("=", "<>") and isinstance(left, bool | str) and type(left) is type(right):
        return (left == right) == (sign == "=")
    a, b = number(left), number(right)
    if (isinstance(a, Computed) or isinstance(b, Computed)) and abs(a - b) <= _NEARLY * max(abs(a), abs(b)):
        raise UnknownError("numbers that are nearly the same")
    with np.errstate(over="ignore"):
        return _COMPARISONS[sign](float(np.float32(a)), float(np.float32(b)))


_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "ABS": (1, abs),
    "SQRT": (1, math.sqrt),
    "SIN": (1, lambda x: math.sin(deg_to_rad(x))),
    "COS": (1, lambda x: math.cos(deg_to_rad(x))),
    "TAN": (1, lambda x: math.tan(deg_to_rad(x))),
    "ATAN2": (2, lambda y, x: rad_to_deg(math.atan2(y, x))),
}


def _function(name: str, given: list[Value]) -> Value:
    """One of RAPID's own functions. Raises UnknownError for others."""
    count, act = _FUNCTIONS.get(name, (-1, abs))
    if len(given) != count:
        raise UnknownError(f"{name}(...)")
    numbers = [number(value) for value in given]
    try:
        value = act(*numbers)
    except ValueError:
        raise UnknownError(f"{name}(...) of such a number") from None
    return _computed(value, *numbers) if name in ("ABS", "SQRT") else Computed(value)
