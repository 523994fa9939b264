"""RAPID's expressions: numbers, truths, texts, records and arrays of them, as far as the text states what they are made of.

Which operator binds how is ABB's ("Technical reference manual, RAPID kernel", priority of operators); a num has 32 bits.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Sequence
from typing import Protocol, cast

import numpy as np

from camrob.witness.krl.functions import Inexact, UnknownError, compared, reckoned
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["PARTS", "Item", "NotSaidError", "Scopes", "component", "element", "evaluate", "numbers_of"]

Item = float | bool | str | list["Item"] | None
"""None: the text does not say it."""

PARTS: dict[str, tuple[tuple[str, str], ...]] = {
    "POS": tuple((name, "NUM") for name in "XYZ"),
    "ORIENT": tuple((f"Q{k}", "NUM") for k in (1, 2, 3, 4)),
    "POSE": (("TRANS", "POS"), ("ROT", "ORIENT")),
    "CONFDATA": (("CF1", "NUM"), ("CF4", "NUM"), ("CF6", "NUM"), ("CFX", "NUM")),
    "ROBJOINT": tuple((f"RAX_{k}", "NUM") for k in (1, 2, 3, 4, 5, 6)),
    "EXTJOINT": tuple((f"EAX_{name}", "NUM") for name in "ABCDEF"),
    "ROBTARGET": (("TRANS", "POS"), ("ROT", "ORIENT"), ("ROBCONF", "CONFDATA"), ("EXTAX", "EXTJOINT")),
    "JOINTTARGET": (("ROBAX", "ROBJOINT"), ("EXTAX", "EXTJOINT")),
    "SPEEDDATA": (("V_TCP", "NUM"), ("V_ORI", "NUM"), ("V_LEAX", "NUM"), ("V_REAX", "NUM")),
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
"""By type of a record: its components, and their types."""

_PIECE = re.compile(
    r'\s*(?:(\d+\.?\d*(?:E[-+]?\d+)?|\.\d+(?:E[-+]?\d+)?)|("(?:[^"]|"")*")|([A-Z_]\w*)|(<=|>=|<>|[-+*/=<>(),.\[\]{}])|(\S))'
)
_COMPARED = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}
_UNIT_LENGTH = 1e-3  # what a quaternion's length may be off 1
_DEEP = 40  # brackets in brackets
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "ABS": (1, abs),
    "SQRT": (1, math.sqrt),
    "SIN": (1, lambda x: math.sin(deg_to_rad(x))),
    "COS": (1, lambda x: math.cos(deg_to_rad(x))),
    "TAN": (1, lambda x: math.tan(deg_to_rad(x))),
    "ATAN2": (2, lambda y, x: rad_to_deg(math.atan2(y, x))),
}
_SHIFTED = ("OFFS", "RELTOOL")
_TURNS = ("RX", "RY", "RZ")  # about the tool's x, then about the new y, then about the new z


class NotSaidError(Exception):
    """A value that the text does not say, or that is no such value."""


class Scopes(Protocol):
    """What names stand for, and what the program's own functions give."""

    own_function: Callable[[str, Sequence[Item]], Item] | None

    def find(self, name: str) -> tuple[str, Item]:
        """Type and value of a name; neither of one that isn't declared. An array's type has its dimensions behind it: NUM{2}."""


def evaluate(text: str, scopes: Scopes) -> Item:
    """The value of an expression. Raises NotSaidError."""
    reader = _Reader(text, scopes)
    try:
        value = reader.level(0)
    except UnknownError as reason:
        raise NotSaidError(f"{text.strip()[:50]}: {reason}") from None
    if reader.at != len(reader.pieces):
        raise NotSaidError(f"{text.strip()[:50]} is more than a value")
    return value


def element(kind: str, whole: Item, at: tuple[int, ...]) -> tuple[str, Item]:
    """The type and the value of an array's element, counted from 1. Raises NotSaidError."""
    bare, mark, sizes = kind.partition("{")
    if sizes == "?}":
        raise NotSaidError("how large the array is isn't in the program")
    wanted = [int(size) for size in sizes.rstrip("}").split(",")] if mark else []
    if len(at) != len(wanted) or any(not 1 <= k <= size for k, size in zip(at, wanted, strict=True)):
        raise NotSaidError(f"it has no element {','.join(map(str, at))}")
    for k, size in zip(at, wanted, strict=True):
        if not isinstance(whole, list) or len(whole) != size:
            raise NotSaidError("the array's values are not in the program")
        whole = whole[k - 1]
    return bare, whole


def component(kind: str, whole: Item, name: str) -> tuple[str, Item]:
    """The type and the value of a record's component. Raises NotSaidError."""
    parts = PARTS.get(kind, ())
    at = next((k for k, (own, _) in enumerate(parts) if own == name), -1)
    if at < 0 or not isinstance(whole, list) or len(whole) != len(parts):
        raise NotSaidError(f".{name[:20]} is no component that the program holds")
    return parts[at][1], whole[at]


def numbers_of(item: Item, count: int) -> list[float]:
    """A record of plain numbers. Raises NotSaidError."""
    if not isinstance(item, list) or len(item) != count:
        raise NotSaidError(f"{count} numbers are wanted")
    return [_number(value) for value in item]


def _number(value: Item) -> float:
    if value is None or isinstance(value, bool | str | list) or not math.isfinite(value):
        raise NotSaidError("a number is wanted")
    return value


def _truth(value: Item) -> bool:
    if not isinstance(value, bool):
        raise NotSaidError("neither TRUE nor FALSE")
    return value


class _Reader:
    """Recursive descent; `at` is the next piece."""

    def __init__(self, text: str, scopes: Scopes) -> None:
        self.pieces = [match.group(1, 2, 3, 4, 5) for match in _PIECE.finditer(text) if match[0].strip()]
        self.scopes, self.at, self.depth = scopes, 0, 0

    def sign(self) -> str:
        """The next piece where it is a sign or a word, "" else."""
        piece = self.pieces[self.at] if self.at < len(self.pieces) else (None,) * 5
        return piece[3] or piece[2] or ""

    def take(self, wanted: str) -> None:
        if self.at >= len(self.pieces) or self.pieces[self.at][3] != wanted:
            raise NotSaidError(f"{wanted} is missing")
        self.at += 1

    def level(self, which: int) -> Item:
        """OR and XOR bind loosest, then AND, comparisons, sums, products."""
        if which == 0:
            return self.either()
        if which == 1:
            return self.both()
        if which == 2:
            return self.comparison()
        left = self.level(which + 1) if which < 4 else self.single()
        signs = ("+", "-") if which == 3 else ("*", "/", "DIV", "MOD")
        while self.sign() in signs:
            sign = self.sign()
            self.at += 1
            left = _worked(sign, left, self.level(which + 1) if which < 4 else self.single())
        return left

    def either(self) -> Item:
        left = self.level(1)
        while self.sign() in ("OR", "XOR"):
            sign = self.sign()
            self.at += 1
            right = _truth(self.level(1))
            left = (_truth(left) or right) if sign == "OR" else _truth(left) != right
        return left

    def both(self) -> Item:
        if self.sign() == "NOT":  # binds no tighter than OR: what an AND behind it belongs to isn't taken for granted
            self.at += 1
            value = not _truth(self.level(2))
            if self.sign() == "AND":
                raise NotSaidError("NOT beside AND without brackets")
            return value
        left = self.level(2)
        while self.sign() == "AND":
            self.at += 1
            right = _truth(self.level(2))
            left = _truth(left) and right
        return left

    def comparison(self) -> Item:
        left = self.level(3)
        while self.sign() in _COMPARED:
            sign = self.sign()
            self.at += 1
            right = self.level(3)
            if sign in ("=", "<>") and isinstance(left, bool | str) and type(left) is type(right):
                left = (left == right) == (sign == "=")
            else:
                left = bool(compared(_COMPARED[sign], _number(left), _number(right)))
        return left

    def single(self) -> Item:
        self.depth += 1
        if self.at >= len(self.pieces) or self.depth > _DEEP:
            raise NotSaidError("a value is missing")
        number, text, name, sign, odd = self.pieces[self.at]
        self.at += 1
        value: Item
        if number is not None:
            value = float(number)
        elif text is not None:
            value = text[1:-1].replace('""', '"')
        elif name is not None:
            value = self.named(name)
        elif sign in ("-", "+"):
            given = _number(self.single())
            value = given if sign == "+" else Inexact(-given) if isinstance(given, Inexact) else -given
        elif sign == "(":
            value = self.level(0)
            self.take(")")
        elif sign == "[":
            value = self.listed("]")
        else:
            raise NotSaidError(f"{sign or odd} where a value has to be")
        self.depth -= 1
        return value

    def listed(self, close: str) -> list[Item]:
        """Values between commas, the opening sign behind us."""
        out = [self.level(0)]
        while self.sign() == ",":
            self.at += 1
            out.append(self.level(0))
        self.take(close)
        return out

    def named(self, name: str) -> Item:
        if name in ("TRUE", "FALSE"):
            return name == "TRUE"
        if self.sign() == "(":
            self.at += 1
            if name in _SHIFTED:
                return self.shifted(name)
            return self.given(name)
        kind, value = self.scopes.find(name)
        while self.sign() in ("{", "."):
            if self.sign() == "{":
                self.at += 1
                kind, value = element(kind, value, tuple(map(_whole, self.listed("}"))))
            else:
                self.at += 1
                part = self.sign()
                self.at += 1
                kind, value = component(kind, value, part)
        if value is None:
            raise NotSaidError(f"{name[:40]} isn't in the program")
        return value

    def given(self, name: str) -> Item:
        """What a function gives, the opening bracket behind us: one of ABB's, else the program's own."""
        values: list[Item] = []
        if self.sign() != ")":
            values = self.listed(")")
        else:
            self.at += 1
        own = self.scopes.own_function
        return _called(name, values) if name in _FUNCTIONS or own is None else own(name, values)

    def shifted(self, name: str) -> Item:
        """Offs or RelTool, the opening bracket behind us: a comma may stand before an optional argument, too."""
        given, turns = [self.level(0)], dict[str, float]()
        while self.sign() == "," or self.option(turns):
            if self.sign() == ",":
                self.at += 1
                if not self.option(turns):
                    given.append(self.level(0))
        self.take(")")
        if turns and name != "RELTOOL":
            raise NotSaidError(f"{name} turns nothing")
        return _shifted(given, [turns.get(axis, 0.0) for axis in _TURNS], by_tool=name == "RELTOOL")

    def option(self, turns: dict[str, float]) -> bool:
        r"""Takes `\Rx:=degrees` and its kin where they stand next."""
        mark, axis, colon, equals = (*self.pieces[self.at : self.at + 4], *[(None,) * 5] * 4)[:4]
        if mark[4] != "\\" or axis[2] not in _TURNS or axis[2] in turns or (colon[4], equals[3]) != (":", "="):
            return False
        self.at += 4
        turns[axis[2]] = _number(self.level(0))
        return True


def _whole(value: Item) -> int:
    number = _number(value)
    if isinstance(number, Inexact) or number != int(number):
        raise NotSaidError("an index is a whole number")
    return int(number)


def _called(name: str, given: list[Item]) -> Item:
    count, act = _FUNCTIONS.get(name, (-1, abs))
    if count != len(given):
        raise NotSaidError(f"{name[:40]}() isn't in the program")
    numbers = [_number(value) for value in given]
    try:
        value = act(*numbers)
    except ValueError as failure:
        raise NotSaidError(f"{name}() of such a number") from failure
    return cast("float", reckoned(value, *numbers)) if name in ("ABS", "SQRT") else Inexact(value)


def _worked(sign: str, left: Item, right: Item) -> Item:
    """left sign right, records and arrays of numbers component by component where they are added (pos + pos)."""
    if isinstance(left, list) and isinstance(right, list) and sign in ("+", "-") and len(left) == len(right):
        return [_worked(sign, a, b) for a, b in zip(left, right, strict=True)]
    if isinstance(left, str) and isinstance(right, str) and sign == "+":
        return left + right
    a, b = _number(left), _number(right)
    if sign in ("/", "DIV", "MOD") and b == 0.0:
        raise NotSaidError("a division by 0")
    if sign in ("DIV", "MOD"):
        if any(isinstance(x, Inexact) or x != int(x) or x < 0.0 for x in (a, b)):
            raise NotSaidError(f"{sign} of such numbers")
        return float(int(a) // int(b)) if sign == "DIV" else float(int(a) % int(b))
    value = {"+": a + b, "-": a - b, "*": a * b}[sign] if sign != "/" else a / b
    return cast("float", reckoned(value, a, b))


def _shifted(values: list[Item], turns: list[float], *, by_tool: bool) -> Item:
    """Offs and RelTool: a robtarget moved along the work object's axes, or along the tool's as the target turns it, and turned by
    so many degrees ("Technical reference manual, RAPID instructions, functions and data types"). Raises NotSaidError.
    """
    point, *by = values
    if not isinstance(point, list) or len(point) != 4:
        raise NotSaidError("a robtarget is wanted")
    step, place, turn = np.array(numbers_of(by, 3)), np.array(numbers_of(point[0], 3)), numbers_of(point[1], 4)
    if by_tool:
        w, about = turn[0], np.array(turn[1:])
        if abs(float(np.linalg.norm(turn)) - 1.0) > _UNIT_LENGTH:
            raise NotSaidError("a quaternion is not of length 1")
        step = step + 2.0 * (w * np.cross(about, step) + np.cross(about, np.cross(about, step))) / float(
            np.dot(turn, turn)
        )
    rest = point[1:]
    if any(turns):
        rest = [[Inexact(value) for value in _turned(turn, turns)], *point[2:]]
    return [[Inexact(value) for value in place + step], *rest]


def _turned(quaternion: list[float], degrees: list[float]) -> list[float]:
    """A quaternion turned on about its own x, y and z in turn."""
    w, v = quaternion[0], np.array(quaternion[1:])
    for axis, angle in zip(np.eye(3), degrees, strict=True):
        half = deg_to_rad(angle) / 2.0
        c, s = math.cos(half), math.sin(half) * axis
        w, v = w * c - float(v @ s), w * s + c * v + np.cross(v, s)
    return [w, *v.tolist()]
