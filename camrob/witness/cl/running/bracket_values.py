"""What an expression in square brackets comes to, as custom macros have it (Fanuc B-63014) and as LinuxCNC's RS274/NGC has it.

A program that may be either's is read by both, and where the two differ nothing is read. Nor is it where rounding alone decides:
two values that are all but equal, compared; a value all but whole, cut off.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from enum import Enum

from camrob.witness.cl.running.unread import UnreadError
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["Formulas", "Style", "whole"]

Value = float | bool | None  # None: a variable of Fanuc's without a value; bool: what a comparison of Fanuc's comes to


class Style(Enum):
    """Whose rules."""

    MACRO = "custom macros"
    O_WORDS = "LinuxCNC"


_NUMBER = re.compile(r"\d+\.?\d*|\.\d+")
_NAME = re.compile(r"<[A-Z0-9_.-]+>")
_OPERATOR = re.compile(r"\*\*|[-+*/]|MOD|AND|XOR|OR|EQ|NE|GT|GE|LT|LE")
_FUNCTION = re.compile(r"(SIN|COS|TAN|ASIN|ACOS|ATAN|SQRT|SQR|ABS|ROUND|RND|FIX|FUP|LN|EXP)(?=\[)")
_COMPARED = frozenset("EQ NE GT GE LT LE".split())
_LOGIC = frozenset("AND OR XOR".split())
_ORDER = dict.fromkeys(_COMPARED, 2)
# which binds closer: Fanuc B-63014, 15.2; LinuxCNC, "G-code overview", binary operators
_LEVELS = {
    Style.MACRO: {**_ORDER, **dict.fromkeys(("+", "-", "OR", "XOR"), 3), **dict.fromkeys(("*", "/", "MOD", "AND"), 4)},
    Style.O_WORDS: {
        **dict.fromkeys(_LOGIC, 1),
        **_ORDER,
        **dict.fromkeys("+-", 3),
        **dict.fromkeys(("*", "/", "MOD"), 4),
        "**": 5,
    },
}
_DEEPEST = 20  # brackets in one another: controls take five to ten
_SAME = {Style.MACRO: 1e-7, Style.O_WORDS: 1e-12}  # of a value: about eight digits are Fanuc's, doubles LinuxCNC's
_EQUAL = 2e-4  # LinuxCNC takes values nearer than 0.0001 to each other as equal
_WHOLE = 1e-6  # from a whole number: nearer than this, rounding decides what is cut off
_MOST = 1e12  # no value of a program is as large
_BITS = 2**31  # of Fanuc's AND, OR, XOR


def whole(value: Value, what: str) -> int:
    """The whole number that a value is. Raises UnreadError for another."""
    if value is None or isinstance(value, bool) or value != round(value):
        raise UnreadError(f"{what}: a number that isn't whole")
    return round(value)


class Formulas:
    """held: what a variable holds, by its number or <name>; where: whether a <name> has been set. Both may raise UnreadError."""

    def __init__(
        self, styles: tuple[Style, ...], held: Callable[[str], float | None], has: Callable[[str], bool]
    ) -> None:
        self.styles = styles
        self._held, self._has = held, has

    def value(self, text: str) -> float | None:
        """What a whole text comes to. Raises UnreadError where nobody knows."""
        value, end = self.part(text, 0)
        if end != len(text) or isinstance(value, bool):
            raise UnreadError(f"{text[:20]}, computed")
        return value

    def part(self, text: str, at: int, *, single: bool = False) -> tuple[Value, int]:
        """What the expression from a place on comes to, and where it ends; single: up to its first operator."""
        found: list[tuple[Value, int]] = []
        for style in self.styles:
            cursor = _Cursor(text, at, style, self._held, self._has)
            try:
                found.append((cursor.operand() if single else cursor.expression(), cursor.at))
            except (OverflowError, ValueError, ZeroDivisionError):
                raise UnreadError(f"{text[at : at + 20]}, computed") from None
        if any(one != found[0] for one in found):
            raise UnreadError(f"{text[at : at + 20]}, which controls compute differently")
        value = found[0][0]
        if value is not None and not abs(value) < _MOST:
            raise UnreadError(f"{text[at : at + 20]}, out of all bounds")
        return found[0]

    def truth(self, text: str) -> bool:
        """Whether a condition, with its brackets, holds."""
        value, end = self.part(text, 0, single=True)
        if end != len(text) or value is None or (self.styles != (Style.O_WORDS,) and not isinstance(value, bool)):
            raise UnreadError(f"{text[:20]}, a condition")
        return bool(value)


class _Cursor:
    """Reads one expression of one style."""

    def __init__(
        self, text: str, at: int, style: Style, held: Callable[[str], float | None], has: Callable[[str], bool]
    ) -> None:
        self.text, self.at, self.style = text, at, style
        self._held, self._has, self._deep = held, has, 0
        self._levels = _LEVELS[style]

    def _no(self, why: str = "computed") -> UnreadError:
        return UnreadError(f"{self.text[:24]}, {why}")

    def expression(self, least: int = 1) -> Value:
        """Operators of a level and above, from the left."""
        left = self.operand()
        compared = False
        while found := _OPERATOR.match(self.text, self.at):
            level = self._levels.get(found[0])
            if level is None:
                raise self._no()
            if level < least:
                return left
            self.at = found.end()
            right = self.expression(level + 1)
            if compared and found[0] in _COMPARED:
                raise self._no("compared twice")
            compared = compared or found[0] in _COMPARED
            left = self._applied(found[0], left, right)
        return left

    def operand(self) -> Value:
        """A number, a variable, brackets or a function, with or without a sign."""
        if self.text[self.at : self.at + 1] in ("-", "+"):
            sign = self.text[self.at]
            self.at += 1
            if self.text[self.at : self.at + 1] in ("-", "+"):
                raise self._no("two signs")
            value = self._number(self._bare())
            if self.text.startswith("**", self.at):
                raise self._no("the power of a sign")
            return -value if sign == "-" else value
        return self._bare()

    def _bare(self) -> Value:
        if found := _NUMBER.match(self.text, self.at):
            self.at = found.end()
            return float(found[0])
        if self.text.startswith("#", self.at):
            return self._variable()
        if self.text.startswith("[", self.at):
            return self._bracket()
        if found := _FUNCTION.match(self.text, self.at):
            self.at = found.end()
            return self._function(found[1])
        if self.style is Style.O_WORDS and self.text.startswith("EXISTS[#<", self.at):
            self.at += len("EXISTS[#")
            name = _NAME.match(self.text, self.at)
            if name is None or not self.text.startswith("]", name.end()):
                raise self._no()
            self.at = name.end() + 1
            return float(self._has(name[0]))
        raise self._no()

    def _variable(self) -> Value:
        """#5, #<name>, #[...], ##5."""
        self._deep += 1
        if self._deep > _DEEPEST:
            raise self._no("too deep")
        self.at += 1
        if name := _NAME.match(self.text, self.at):
            if self.style is Style.MACRO:
                raise self._no()
            self.at = name.end()
            value = self._held(name[0])
        else:
            value = self._held(str(whole(self._bare(), self.text[:24])))
        self._deep -= 1
        if value is None and self.style is Style.O_WORDS:
            raise self._no("a variable without a value")
        return value

    def _bracket(self) -> Value:
        self._deep += 1
        if self._deep > _DEEPEST:
            raise self._no("too deep")
        self.at += 1
        value = self.expression()
        if not self.text.startswith("]", self.at):
            raise self._no()
        self.at += 1
        self._deep -= 1
        if value is None:
            raise self._no("brackets round a variable without a value")
        return value

    def _number(self, value: Value) -> float:
        if value is None or isinstance(value, bool):
            raise self._no("a variable without a value, or a condition in a sum")
        return value

    def _function(self, name: str) -> float:
        value = self._number(self._bracket())
        if name == "ATAN":
            return self._angle(value)
        if name in ("SIN", "COS", "TAN"):
            return {"SIN": math.sin, "COS": math.cos, "TAN": math.tan}[name](deg_to_rad(value))
        if name in ("ASIN", "ACOS"):
            if name == "ASIN" and value < 0.0 and self.style is Style.MACRO:
                raise self._no("an angle that a setting of the control decides")
            return rad_to_deg(math.asin(value) if name == "ASIN" else math.acos(value))
        if name in ("SQRT", "SQR"):
            return math.sqrt(value)
        if name in ("FIX", "FUP", "ROUND", "RND"):
            return self._cut(name, value)
        if name == "ABS":
            return abs(value)
        return math.log(value) if name == "LN" else math.exp(value)

    def _cut(self, name: str, value: float) -> float:
        """Fanuc's FIX and FUP by the amount, LinuxCNC's downwards and upwards; ROUND of a half away from zero."""
        edge = value * 2.0 if name in ("ROUND", "RND") else value
        if 0.0 < abs(edge - round(edge)) < _WHOLE:
            raise self._no("cut off where rounding decides")
        if name in ("ROUND", "RND"):
            return math.copysign(math.floor(abs(value) + 0.5), value)
        upwards = name == "FUP"
        if self.style is Style.MACRO and value < 0.0:
            upwards = not upwards
        return float(math.ceil(value) if upwards else math.floor(value))

    def _angle(self, value: float) -> float:
        """ATAN[a]/[b]. Below 180 degrees controls agree; LinuxCNC goes on to -180, Fanuc's to 360 or -180 by a setting."""
        if not self.text.startswith("/[", self.at):
            raise self._no("ATAN of one value")
        self.at += 1
        angle = rad_to_deg(math.atan2(value, self._number(self._bracket())))
        if self.style is Style.MACRO and angle < 0.0:
            raise self._no("an angle that a setting of the control decides")
        return angle

    def _applied(self, name: str, a: Value, b: Value) -> Value:
        if name in _COMPARED:
            return self._compared(name, a, b)
        if name in _LOGIC and self.style is Style.O_WORDS:
            p, q = bool(self._number(a)), bool(self._number(b))
            return float({"AND": p and q, "OR": p or q, "XOR": p != q}[name])
        if name in _LOGIC:
            return self._joined(name, a, b)
        # Fanuc: a variable without a value counts as 0 in sums and products
        x, y = (self._number(0.0 if value is None else value) for value in (a, b))
        if name == "MOD":
            if x < 0.0 or y <= 0.0 or x % 1.0 or y % 1.0:
                raise self._no("MOD of other than whole numbers above zero")
            return x % y
        if name == "**":
            if x <= 0.0 and (y % 1.0 or y <= 0.0):
                raise self._no("a power")
            return float(x**y)
        return {"+": x + y, "-": x - y, "*": x * y}[name] if name != "/" else x / y

    def _joined(self, name: str, a: Value, b: Value) -> Value:
        """Fanuc's: conditions in brackets, or whole numbers bit by bit."""
        if isinstance(a, bool) and isinstance(b, bool):
            return {"AND": a and b, "OR": a or b, "XOR": a != b}[name]
        x, y = (whole(self._number(value), self.text[:24]) for value in (a, b))
        if not (0 <= x < _BITS and 0 <= y < _BITS):
            raise self._no("bits of a number that is no whole one above zero")
        return float({"AND": x & y, "OR": x | y, "XOR": x ^ y}[name])

    def _compared(self, name: str, a: Value, b: Value) -> Value:
        if name in ("EQ", "NE") and (a is None or b is None):  # Fanuc: no value is equal to no value alone
            return (a is None and b is None) == (name == "EQ")
        x, y = (self._number(0.0 if value is None else value) for value in (a, b))
        off = abs(x - y)
        near = _SAME[self.style] * max(1.0, abs(x), abs(y))
        if self.style is Style.O_WORDS and name in ("EQ", "NE"):
            near = _EQUAL
        if 0.0 < off <= near:
            raise self._no("a comparison that rounding decides")
        held = {"EQ": x == y, "NE": x != y, "GT": x > y, "GE": x >= y, "LT": x < y, "LE": x <= y}[name]
        return held if self.style is Style.MACRO else float(held)
