"""Values that a program computes: Siemens' R parameters and declared names, Heidenhain's Q parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.units import deg_to_rad

__all__ = ["Values"]

_TOKEN = re.compile(r"\d+\.?\d*|\.\d+|[A-Z_]\w*|[-+*/()]")
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda degrees: math.sin(deg_to_rad(degrees)),
    "COS": lambda degrees: math.cos(deg_to_rad(degrees)),
    "TAN": lambda degrees: math.tan(deg_to_rad(degrees)),
    "SQRT": math.sqrt,
    "ABS": abs,
    "POT": lambda value: value * value,
    "SQ": lambda value: value * value,
    "INT": lambda value: _whole(value),
    "FRAC": lambda value: value - _whole(value),
    "NEG": lambda value: -value,
}


def _whole(value: float) -> float:
    """Without its decimals. Raises ValueError where rounding alone says which number that is."""
    if 0.0 < abs(value - round(value)) < 1e-9:
        raise ValueError
    return float(int(value))


class Values:
    """What each name holds. Sums, products, signs, brackets and ten functions (angles in degrees) are worked out."""

    def __init__(self) -> None:
        self._held: dict[str, float] = {}

    def __contains__(self, name: str) -> bool:
        return name in self._held

    def keep(self, name: str, text: str) -> None:
        """The name holds what the text comes to. Raises UnreadError where nobody knows."""
        self._held[name] = self.of(text)

    def put(self, name: str, value: float) -> None:
        """The name holds a value."""
        self._held[name] = value

    def forget(self, name: str) -> None:
        """Nobody knows what the name holds."""
        self._held.pop(name, None)

    def enter(self) -> dict[str, float]:
        """Names of a subprogram's own, but for R parameters; what the names held outside of it."""
        before = self._own()
        for name in before:
            del self._held[name]
        return before

    def leave(self, before: dict[str, float]) -> None:
        """The names that stood outside of a subprogram hold their values again, and its own are gone."""
        self.enter()
        self._held |= before

    def _own(self) -> dict[str, float]:
        return {name: value for name, value in self._held.items() if not re.fullmatch(r"R\d+", name)}

    def of(self, text: str) -> float:
        """What a text comes to. Raises UnreadError for names without a value and for other signs."""
        compact = "".join(text.split())
        tokens = _TOKEN.findall(compact)
        if "".join(tokens) != compact or not tokens:
            raise UnreadError(f"{text[:20]}, computed")
        tokens.reverse()
        try:
            value = self._sum(tokens)
        except (IndexError, ZeroDivisionError, ValueError, RecursionError):
            raise UnreadError(f"{text[:20]}, computed") from None
        if tokens or not math.isfinite(value):
            raise UnreadError(f"{text[:20]}, computed")
        return value

    def _sum(self, rest: list[str]) -> float:
        value = self._product(rest)
        while rest and rest[-1] in "+-":
            value = value + self._product(rest) if rest.pop() == "+" else value - self._product(rest)
        return value

    def _product(self, rest: list[str]) -> float:
        value = self._single(rest)
        while rest and rest[-1] in "*/":
            value = value * self._single(rest) if rest.pop() == "*" else value / self._single(rest)
        return value

    def _single(self, rest: list[str]) -> float:
        token = rest.pop()
        if token in "+-":
            return self._single(rest) if token == "+" else -self._single(rest)
        if token == "(":
            value = self._sum(rest)
            if rest.pop() != ")":
                raise ValueError
            return value
        if token[0].isdigit() or token[0] == ".":
            return float(token)
        if token in _FUNCTIONS and rest and rest[-1] == "(":
            return _FUNCTIONS[token](self._single(rest))
        if token not in self._held:
            raise UnreadError(f"{token}, whose value isn't known")
        return self._held[token]
