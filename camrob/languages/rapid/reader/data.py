"""RAPID data: records by their components, what ABB predefines, and expressions that are known from the text alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.tokens import Token, joined
from camrob.se3 import quaternion_to_rotation

__all__ = ["FIELDS", "Data", "Scope", "UnknownError", "Value", "numbers"]

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

# predefined data, of the same manual
_SPEEDS = "5 10 20 30 40 50 60 80 100 150 200 300 400 500 600 800 1000 1500 2000 2500 3000 4000 5000 6000 7000".split()
_ZONES: dict[str, tuple[float, float, float]] = {  # pzone_tcp, pzone_ori and pzone_eax, zone_ori and zone_reax
    "0": (0.3, 0.3, 0.03),
    "1": (1, 1, 0.1),
    "5": (5, 8, 0.8),
    "10": (10, 15, 1.5),
    "15": (15, 23, 2.3),
    "20": (20, 30, 3),
    "30": (30, 45, 4.5),
    "40": (40, 60, 6),
    "50": (50, 75, 7.5),
    "60": (60, 90, 9),
    "80": (80, 120, 12),
    "100": (100, 150, 15),
    "150": (150, 225, 23),
    "200": (200, 300, 30),
}


_DEEPEST = 40  # brackets in brackets and signs before signs: no record has more than four
_UNIT = 0.02  # what the square of a printed quaternion may be off 1


Scope = dict[str, tuple[str, "Value | None"]]


class UnknownError(Exception):
    """A value that the text does not say."""


def _predefined() -> dict[str, tuple[str, Value]]:
    unit: Value = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    load: Value = [0.001, [0.0, 0.0, 0.001], [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0]
    out: dict[str, tuple[str, Value]] = {
        "TOOL0": ("TOOLDATA", [True, unit, load]),
        "WOBJ0": ("WOBJDATA", [False, True, "", unit, unit]),
        "LOAD0": ("LOADDATA", load),
        "FINE": ("ZONEDATA", [True, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    }
    out |= {f"V{v}": ("SPEEDDATA", [float(v), 500.0, 5000.0, 1000.0]) for v in _SPEEDS}
    for name, (tcp, other, turn) in _ZONES.items():
        out[f"Z{name}"] = ("ZONEDATA", [False, tcp, other, other, turn, other, turn])
    return out


def _new_number(text: str) -> float:
    return float(int(text, 16)) if text[:2].lower() == "0x" else float(text)


@dataclass(slots=True)
class Data:
    """What is declared, by upper-case name: type and value, None where the text does not say it.

    known: to all modules; module: by LOCAL, to the one that runs; own: to the procedure that runs, None outside of any. The
    nearest hides the others.
    """

    known: Scope = field(default_factory=lambda: dict(_predefined()))
    module: Scope = field(default_factory=dict)
    own: Scope | None = None
    changes: int = 0

    def enter(self, module: Scope, own: Scope | None) -> None:
        """Another module or procedure runs from here on."""
        self.module, self.own = module, own
        self.changes += 1

    def declare(self, kind: str, name: str, value: Value | None, *, local: bool = False) -> None:
        """A declaration; local: by LOCAL."""
        scope = self.own if self.own is not None else self.module if local else self.known
        scope[name] = (kind, value)
        self.changes += 1

    def _scope(self, name: str) -> Scope:
        """Where a name is declared, as the procedure that runs sees it."""
        return next((scope for scope in (self.own or {}, self.module) if name in scope), self.known)

    def find(self, name: str) -> tuple[str, Value | None]:
        """Type and value under a name; neither where it isn't declared."""
        return self._scope(name).get(name, ("", None))

    def assign(self, path: Sequence[str], value: Value | None) -> None:
        """`a.b.c := value`; what is not declared in the text is left alone."""
        kind, whole = self.find(path[0])
        self.changes += 1
        if not kind:
            return
        self._scope(path[0])[path[0]] = (kind, _replaced(kind, whole, path[1:], value))

    def value(self, tokens: Sequence[Token]) -> Value:
        """The value of an expression. Raises UnknownError where the text does not say it."""
        reader = _Expression(self, tuple(tokens))
        out = reader.sum()
        if reader.at != len(tokens):
            raise UnknownError(joined(tuple(tokens))[:60])
        return out


def _replaced(kind: str, whole: Value | None, path: Sequence[str], value: Value | None) -> Value | None:
    """A record with a component replaced; unknown where the rest of it is."""
    if not path:
        return value
    names = [name for name, _ in FIELDS.get(kind, ())]
    if path[0] not in names or not isinstance(whole, list) or len(whole) != len(names):
        return None
    at = names.index(path[0])
    return [*whole[:at], _replaced(FIELDS[kind][at][1], whole[at], path[1:], value), *whole[at + 1 :]]


@dataclass(slots=True)
class _Expression:
    """Reads an expression of numbers, names, records, + - * / and brackets."""

    data: Data
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

    def sum(self) -> Value:
        out = self.product()
        while self.peek() in ("+", "-"):
            sign, other = self.take().text, self.product()
            out = _plus(out, other, 1.0 if sign == "+" else -1.0)
        return out

    def product(self) -> Value:
        out = self.factor()
        while self.peek() in ("*", "/"):
            sign, a, b = self.take().text, _number(out), _number(self.factor())
            if sign == "/" and b == 0.0:
                raise UnknownError("a division by 0")
            out = a * b if sign == "*" else a / b
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
            return -_number(self.factor())
        if token.text == "+":
            return _number(self.factor())
        if token.text == "(":
            out = self.sum()
            self.close(")")
            return out
        if token.text == "[":
            items: list[Value | None] = [self.sum()]
            while self.peek() == ",":
                self.take()
                items.append(self.sum())
            self.close("]")
            return items
        if token.kind != "name":
            raise UnknownError(token.text)
        return self.named(token.text)

    def close(self, bracket: str) -> None:
        if self.take().text != bracket:
            raise UnknownError(f"no {bracket}")

    def named(self, name: str) -> Value:
        """A name, with the components asked for behind it; TRUE and FALSE; Offs and RelTool of a robtarget."""
        if name in ("TRUE", "FALSE"):
            return name == "TRUE"
        if name in ("OFFS", "RELTOOL") and self.peek() == "(":
            return self.moved(name)
        kind, value = self.data.find(name)
        while self.peek() == ".":
            self.take()
            part = self.take().text
            names = [n for n, _ in FIELDS.get(kind, ())]
            if part not in names or not isinstance(value, list) or len(value) != len(names):
                raise UnknownError(f"{name}.{part}")
            kind, value = FIELDS[kind][names.index(part)][1], value[names.index(part)]
        if value is None:
            raise UnknownError(name)
        return value

    def moved(self, name: str) -> Value:
        """Offs(p, x, y, z): p displaced in its work object; RelTool(p, x, y, z): along the tool's axes there."""
        self.take()
        items = [self.sum()]
        while self.peek() == ",":
            self.take()
            items.append(self.sum())
        self.close(")")
        target = items[0]
        if len(items) != 4 or not isinstance(target, list) or len(target) != 4:
            raise UnknownError(name)
        start = target[0]
        if not isinstance(start, list) or len(start) != len("XYZ"):
            raise UnknownError(name)
        step = [_number(value) for value in items[1:]]
        if name == "RELTOOL":
            step = _turned(step, target[1])
        place: list[Value | None] = [_number(a) + b for a, b in zip(start, step, strict=True)]
        return [place, *target[1:]]


def _turned(v: list[float], quaternion: Value | None) -> list[float]:
    """A vector (3,) by a quaternion of unit length, as a program prints it."""
    if not isinstance(quaternion, list) or len(quaternion) != 4:
        raise UnknownError("RelTool of a target that isn't turned")
    q = np.array([_number(value) for value in quaternion])
    if not abs(float(q @ q) - 1.0) < _UNIT:
        raise UnknownError("a quaternion whose length is not 1")
    return [float(c) for c in quaternion_to_rotation(q) @ v]


def _number(value: Value | None) -> float:
    if value is None or isinstance(value, bool) or not isinstance(value, int | float):
        raise UnknownError(str(value)[:40])
    return float(value)


def _plus(a: Value | None, b: Value | None, sign: float) -> Value:
    """Numbers, or records of numbers component by component (pos + pos)."""
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [_plus(x, y, sign) for x, y in zip(a, b, strict=True)]
    return _number(a) + sign * _number(b)


def numbers(value: Value | None, count: int, what: str) -> list[float]:
    """A record of `count` plain numbers. Raises ProgramError where it is none."""
    if not isinstance(value, list) or len(value) != count:
        raise ProgramError(f"{what} has not {count} numbers", hint="is the file damaged?")
    try:
        return [_number(v) for v in value]
    except UnknownError:
        raise ProgramError(f"{what} has not {count} numbers", hint="is the file damaged?") from None
