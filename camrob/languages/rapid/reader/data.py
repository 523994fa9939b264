"""RAPID data: what is declared and what ABB predefines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.expressions import FIELDS, UnknownError, Value, element, number, value_of
from camrob.languages.rapid.reader.tokens import Token

__all__ = ["Data", "Scope", "array_of", "numbers"]

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


_MOST_ELEMENTS = 100_000  # of an array


Scope = dict[str, tuple[str, "Value | None"]]


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


@dataclass(slots=True)
class Data:
    """What is declared, by upper-case name: type and value, None where the text does not say it.

    known: to all modules; modules: by LOCAL, to each of them; module: to the one that runs; own: to the procedure that runs, None
    outside of any. The nearest hides the others.
    """

    known: Scope = field(default_factory=lambda: dict(_predefined()))
    modules: list[Scope] = field(default_factory=list)
    module: Scope = field(default_factory=dict)
    own: Scope | None = None
    changes: int = 0
    call: Callable[[str, Sequence[Value]], Value | None] | None = (
        None  # the program's own functions, None of another name
    )

    def enter(self, module: Scope, own: Scope | None) -> None:
        """Another module or procedure runs from here on."""
        self.module, self.own = module, own
        self.changes += 1

    def declare(self, kind: str, name: str, value: Value | None, *, local: bool = False) -> None:
        """A declaration; local: by LOCAL. An array's type has a pair of braces a dimension behind it."""
        scope = self.own if self.own is not None else self.module if local else self.known
        scope[name] = (kind, value)
        self.changes += 1

    def _scope(self, name: str) -> Scope:
        """Where a name is declared, as the procedure that runs sees it."""
        return next((scope for scope in (self.own or {}, self.module) if name in scope), self.known)

    def find(self, name: str) -> tuple[str, Value | None]:
        """Type and value under a name; neither where it isn't declared."""
        return self._scope(name).get(name, ("", None))

    def assign(self, path: Sequence[str | tuple[int, ...]], value: Value | None) -> None:
        """`a.b{3}.c := value`, an index counted from 1; what is not declared in the text is left alone."""
        name = str(path[0])
        kind, whole = self.find(name)
        self.changes += 1
        if not kind:
            return
        self._scope(name)[name] = (kind, _replaced(kind, whole, path[1:], value))

    def shown(self) -> str:
        """All values, as a text: the same where nothing has changed."""
        return repr((self.known, self.modules, self.own))

    def value(self, tokens: Sequence[Token]) -> Value:
        """The value of an expression. Raises UnknownError where the text does not say it."""
        return value_of(tokens, self)


def array_of(sizes: Sequence[int], value: Value | None) -> Value | None:
    """An array all of whose elements are the same. Raises UnknownError for one that no program has."""
    if any(size < 1 for size in sizes) or math.prod(sizes) > _MOST_ELEMENTS:
        raise UnknownError("an array of such a size")
    for size in reversed(sizes):
        value = [value] * size
    return value


def _replaced(
    kind: str, whole: Value | None, path: Sequence[str | tuple[int, ...]], value: Value | None
) -> Value | None:
    """A record or an array with a part of it replaced; unknown where the rest of it is."""
    if not path:
        return value
    if isinstance(path[0], tuple):
        try:
            inner, old = element(kind, whole, path[0])
        except UnknownError:
            return None
        return _with(whole, path[0], _replaced(inner, old, path[1:], value))
    names = [name for name, _ in FIELDS.get(kind, ())]
    if path[0] not in names or not isinstance(whole, list) or len(whole) != len(names):
        return None
    at = names.index(path[0])
    return [*whole[:at], _replaced(FIELDS[kind][at][1], whole[at], path[1:], value), *whole[at + 1 :]]


def _with(whole: Value | None, at: tuple[int, ...], value: Value | None) -> Value | None:
    """A list of lists with one element replaced."""
    if not at:
        return value
    if not isinstance(whole, list):
        return None
    return [*whole[: at[0] - 1], _with(whole[at[0] - 1], at[1:], value), *whole[at[0] :]]


def numbers(value: Value | None, count: int, what: str) -> list[float]:
    """A record of `count` plain numbers. Raises ProgramError where it is none."""
    if not isinstance(value, list) or len(value) != count:
        raise ProgramError(f"{what} has not {count} numbers", hint="is the file damaged?")
    try:
        return [number(v) for v in value]
    except UnknownError:
        raise ProgramError(f"{what} has not {count} numbers", hint="is the file damaged?") from None
