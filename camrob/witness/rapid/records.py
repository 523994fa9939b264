"""RAPID's data as the text states them: numbers, truth values, texts, and records of these."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import frame, to_values
from camrob.witness.units import rad_to_deg

__all__ = ["Item", "NotSaidError", "Records", "angles", "numbers_of", "pose_values", "product"]

Array = NDArray[np.float64]
Item = float | bool | str | list["Item"] | None
"""None: the text does not say it."""

_PIECE = re.compile(r'\s*(?:([-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d+)?)|("[^"]*")|([A-Z_]\w*)|(.))')
_SHIFTED = ("OFFS", "RELTOOL")
_DEEP = 10  # records in records: RAPID's own have four
_UNIT_LENGTH = 0.01  # what a quaternion's length may be off 1
_LOCKED = 1e-9  # of the cosine of B: below it A and C turn about one line
_PARTS = {
    "TOOLDATA": ("ROBHOLD", "TFRAME", "TLOAD"),
    "WOBJDATA": ("ROBHOLD", "UFPROG", "UFMEC", "UFRAME", "OFRAME"),
}
# of every controller: v5 .. v7000 by their number, z0 .. z200 by pzone_tcp, pzone_ori
_SPEEDS = (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000)  # fmt: skip  # noqa: E501
_ZONES = {
    0: (0.3, 0.3),
    1: (1, 1),
    5: (5, 8),
    10: (10, 15),
    15: (15, 23),
    20: (20, 30),
    30: (30, 45),
    40: (40, 60),
    50: (50, 75),
}


class NotSaidError(Exception):
    """A value that the text does not say, or that is no such value."""


_Scope = dict[str, tuple[str, Item]]


def _standard() -> _Scope:
    here: Item = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    out: _Scope = {
        "TOOL0": ("TOOLDATA", [True, here, None]),
        "WOBJ0": ("WOBJDATA", [False, True, "", here, here]),
        "FINE": ("ZONEDATA", [True, *[0.0] * 6]),
    }
    for speed in _SPEEDS:
        out[f"V{speed}"] = ("SPEEDDATA", [float(speed), 500.0, 5000.0, 1000.0])
    for zone, (tip, other) in _ZONES.items():
        turn = 0.1 * float(other)
        out[f"Z{zone}"] = ("ZONEDATA", [False, float(tip), float(other), float(other), turn, float(other), turn])
    return out


@dataclass(slots=True)
class Records:
    """What is declared, by name, type and value: of the procedure that runs (`own`), of its module by LOCAL, of all. The nearest
    hides the others.
    """

    known: _Scope = field(default_factory=_standard)
    module: _Scope = field(default_factory=dict)
    own: _Scope = field(default_factory=dict)

    def declare(self, kind: str, name: str, text: str, scope: _Scope | None = None) -> None:
        """A declaration; a value that can't be read is not said."""
        scope = self.known if scope is None else scope
        try:
            scope[name] = (kind, self.value(text) if text else None)
        except NotSaidError:
            scope[name] = (kind, None)

    def scope_of(self, name: str) -> _Scope | None:
        """Where a name is declared, as the procedure that runs sees it."""
        return next((scope for scope in (self.own, self.module, self.known) if name in scope), None)

    def find(self, name: str) -> tuple[str, Item]:
        """Type and value of a name; neither of one that isn't declared."""
        scope = self.scope_of(name)
        return ("", None) if scope is None else scope[name]

    def value(self, text: str) -> Item:
        """The value of a literal, a record of them, or a name. Raises NotSaidError."""
        pieces = [match.group(1, 2, 3, 4) for match in _PIECE.finditer(text) if match[0].strip()]
        value, at = self._one(pieces, 0, 0)
        if at != len(pieces):
            raise NotSaidError(f"{text.strip()[:50]} is more than a value")
        return value

    def _one(self, pieces: Sequence[tuple[str | None, ...]], at: int, depth: int) -> tuple[Item, int]:
        if at >= len(pieces) or depth > _DEEP:
            raise NotSaidError("a value is missing")
        number, text, name, sign = pieces[at]
        if number is not None:
            return float(number), at + 1
        if text is not None:
            return text[1:-1], at + 1
        if name in ("TRUE", "FALSE"):
            return name == "TRUE", at + 1
        if name in _SHIFTED and pieces[at + 1 : at + 2] == [(None, None, None, "(")]:
            values, at = self._row(pieces, at + 1, depth, ")")
            return _shifted(values, by_tool=name == "RELTOOL"), at
        if name is not None:
            value = self.find(name)[1]
            if value is None:
                raise NotSaidError(f"{name[:40]} isn't in the program")
            return value, at + 1
        if sign != "[":
            raise NotSaidError(f"{sign} where a value has to be")
        return self._row(pieces, at, depth, "]")

    def _row(self, pieces: Sequence[tuple[str | None, ...]], at: int, depth: int, close: str) -> tuple[list[Item], int]:
        """Values between commas, from an opening sign to its closing one."""
        out: list[Item] = []
        while True:
            item, at = self._one(pieces, at + 1, depth + 1)
            out.append(item)
            end = pieces[at][3] if at < len(pieces) else None  # the sign behind it
            if end == close:
                return out, at + 1
            if end != ",":
                raise NotSaidError("a record or call is not closed")

    def put(self, name: str, part: str, value: Item) -> bool:
        """Sets a tool's or a work object's component, or all of it; False where that is not known here."""
        scope, (kind, whole) = self.scope_of(name) or self.known, self.find(name)
        if not part:
            scope[name] = (kind, value)
            return bool(kind)
        parts = _PARTS.get(kind, ())
        if part not in parts or not isinstance(whole, list) or len(whole) != len(parts):
            scope[name] = (kind, None)
            return False
        scope[name] = (kind, [value if own == part else old for own, old in zip(parts, whole, strict=True)])
        return True

    def record(self, name: str, kind: str) -> list[Item]:
        """The components of what is declared under a name. Raises NotSaidError."""
        own, value = self.find(name)
        if own != kind or not isinstance(value, list) or len(value) != len(_PARTS[kind]):
            raise NotSaidError(f"{name[:40]} is no {kind.lower()} of the program")
        return value


def _shifted(values: list[Item], by_tool: bool) -> Item:
    """Offs and RelTool: a robtarget moved along the work object's axes, or along the tool's as the target turns it ("Technical
    reference manual, RAPID instructions, functions and data types"). Raises NotSaidError.
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
    return [(place + step).tolist(), *point[1:]]


def numbers_of(item: Item, count: int) -> list[float]:
    """A record of plain numbers. Raises NotSaidError."""
    if not isinstance(item, list) or len(item) != count:
        raise NotSaidError(f"{count} numbers are wanted")
    out = []
    for value in item:
        if value is None or isinstance(value, bool | str | list) or not np.isfinite(value):
            raise NotSaidError("a number is wanted")
        out.append(float(value))
    return out


def angles(turn: Array) -> Array:
    """A, B, C (M, 3) in degrees of quaternions (M, 4), NaN where one is none."""
    size = np.sqrt(np.sum(turn * turn, axis=1, keepdims=True))
    w, x, y, z = (turn / np.where(size > 0.0, size, np.nan)).T
    first = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)])  # the x axis
    flat = np.hypot(first[0], first[1])
    locked = flat < _LOCKED
    second = np.stack([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)])  # the y axis's first two
    a = np.where(locked, np.arctan2(-second[0], second[1]), np.arctan2(first[1], first[0]))
    c = np.where(locked, 0.0, np.arctan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)))
    out = np.stack([a, np.arctan2(-first[2], flat), c], axis=1)
    wrong = ~(np.abs(size[:, 0] - 1.0) <= _UNIT_LENGTH)
    return np.asarray(np.where(wrong[:, None], np.nan, rad_to_deg(out)))


def pose_values(item: Item) -> tuple[float, ...]:
    """X..C in mm and degrees of a pose. Raises NotSaidError."""
    if not isinstance(item, list) or len(item) != 2:
        raise NotSaidError("a pose is wanted")
    place, turn = numbers_of(item[0], 3), numbers_of(item[1], 4)
    abc = angles(np.array([turn]))[0]
    if np.isnan(abc).any():
        raise NotSaidError("a quaternion is not of length 1")
    return (*place, *(float(value) for value in abc))


def product(first: tuple[float, ...], second: tuple[float, ...]) -> tuple[float, ...]:
    """X..C of one frame in another."""
    return tuple(float(value) for value in to_values(frame(np.array(first)) @ frame(np.array(second))))
