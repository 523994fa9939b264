"""RAPID's data as the text states them: numbers, truth values, texts, and records of these."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import frame, to_values
from camrob.witness.krl.values import split_top
from camrob.witness.rapid.expressions import PARTS, Item, NotSaidError, component, element, evaluate, numbers_of
from camrob.witness.units import rad_to_deg

__all__ = ["Records", "angles", "pose_values", "product"]

Array = NDArray[np.float64]

_LOCKED = 1e-9  # of the cosine of B: below it A and C turn about one line
_UNIT_LENGTH = 1e-3  # what a quaternion's length may be off 1; four decimals leave 1e-4
# a VAR without a value
_FIRST: dict[str, Item] = {"NUM": 0.0, "DNUM": 0.0, "BOOL": False, "STRING": "", "POS": [0.0, 0.0, 0.0]}
_LARGEST_ARRAY = 100_000  # elements
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
    60: (60, 90),
    80: (80, 120),
    100: (100, 150),
    150: (150, 225),
    200: (200, 300),
}


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
        turn = 23.0 if zone == 150 else 0.1 * float(other)  # ABB rounds there
        out[f"Z{zone}"] = ("ZONEDATA", [False, float(tip), float(other), float(other), turn, float(other), turn])
    return out


@dataclass(slots=True)
class Records:
    """What is declared, by name, type and value: of the procedure that runs (`own`), of its module by LOCAL, of all. The nearest
    hides the others. `kept`: what CONST and PERS declare, by scope and name.
    """

    known: _Scope = field(default_factory=_standard)
    module: _Scope = field(default_factory=dict)
    own: _Scope = field(default_factory=dict)
    kept: set[tuple[int, str]] = field(default_factory=set)
    own_function: Callable[[str, Sequence[Item]], Item] | None = None

    def declare(
        self, kind: str, name: str, text: str, scope: _Scope | None = None, *, sizes: str = "", how: str = "VAR"
    ) -> None:
        """A declaration; a value that can't be read is not said. sizes: of an array; how: CONST, VAR or PERS."""
        scope = self.known if scope is None else scope
        if how != "VAR":
            self.kept.add((id(scope), name))
        try:
            dims = [numbers_of([self.value(size)], 1)[0] for size in split_top(sizes)] if sizes else []
            if any(size != int(size) for size in dims) or np.prod(dims, initial=1.0) > _LARGEST_ARRAY:
                raise NotSaidError("no array")
            kind += "{" + ",".join(f"{size:.0f}" for size in dims) + "}" if dims else ""
            first = _FIRST.get(kind.partition("{")[0]) if how == "VAR" and not text else None
            for size in reversed(dims):
                first = [first] * int(size)
            scope[name] = (kind, self.value(text) if text else first)
        except NotSaidError:
            scope[name] = (kind if not sizes else f"{kind}{{?}}", None)

    def scope_of(self, name: str) -> _Scope | None:
        """Where a name is declared, as the procedure that runs sees it."""
        return next((scope for scope in (self.own, self.module, self.known) if name in scope), None)

    def find(self, name: str) -> tuple[str, Item]:
        """Type and value of a name; neither of one that isn't declared."""
        scope = self.scope_of(name)
        return ("", None) if scope is None else scope[name]

    def value(self, text: str) -> Item:
        """The value of an expression. Raises NotSaidError."""
        return evaluate(text, self)

    def put(self, path: str, value: Item) -> None:
        """Sets NAME, an element or a component of it; all of it is not said where the rest isn't known."""
        name, *steps = re.findall(r"[A-Z_]\w*|\{[^{}]*\}", path)
        scope, (kind, whole) = self.scope_of(name) or self.known, self.find(name)
        try:
            scope[name] = (kind, self._replaced(kind, whole, steps, value))
        except NotSaidError:
            scope[name] = (kind, None)

    def _replaced(self, kind: str, whole: Item, steps: list[str], value: Item) -> Item:
        """A record or an array with a part of it set. Raises NotSaidError."""
        if not steps:
            return value
        if steps[0].startswith("{"):
            places = [numbers_of([self.value(text)], 1)[0] for text in split_top(steps[0][1:-1])]
            if any(place != int(place) for place in places):
                raise NotSaidError("an index is a whole number")
            at = tuple(int(place) for place in places)
            inner, old = element(kind, whole, at)
            return _set_at(whole, [k - 1 for k in at], self._replaced(inner, old, steps[1:], value))
        inner, old = component(kind, whole, steps[0])
        at_part = [name for name, _ in PARTS[kind]].index(steps[0])
        return _set_at(whole, [at_part], self._replaced(inner, old, steps[1:], value))

    def record(self, name: str, kind: str) -> list[Item]:
        """The components of what is declared under a name. Raises NotSaidError."""
        own, value = self.find(name)
        if own != kind or not isinstance(value, list) or len(value) != len(PARTS[kind]):
            raise NotSaidError(f"{name[:40]} is no {kind.lower()} of the program")
        return value


def _set_at(whole: Item, at: list[int], value: Item) -> Item:
    """A list of lists with one element replaced; the old one stays as it is."""
    if not at:
        return value
    if not isinstance(whole, list):
        raise NotSaidError("no array")
    return [*whole[: at[0]], _set_at(whole[at[0]], at[1:], value), *whole[at[0] + 1 :]]


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
