"""KRL's own functions, the geometric operator, and what all values of KRL have in common."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import frame, inverse, to_values
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["FUNCTIONS", "Inexact", "UnknownError", "Value", "chained", "compared", "reckoned", "rounded"]

Value = bool | int | float | str | dict[str, "Value"]

_FRAME = "XYZABC"
_TOLD_APART = 1e-5  # share: what some thousand operations in single precision may be off
_EXACT = 2**24  # whole numbers up to it are REALs exactly


class Inexact(float):
    """A REAL that was worked out, and that the controller's single precision (REAL has 32 bits) may have a little otherwise."""

    __slots__ = ()


class UnknownError(Exception):
    """What can't be known from the text, and why."""


def _single(value: float) -> float:
    """The REAL nearest to a number."""
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def _exact(value: Value) -> bool:
    """True of a number that the controller has to the last bit."""
    if isinstance(value, Inexact) or not isinstance(value, int | float):
        return False
    return abs(value) <= _EXACT if isinstance(value, int) else _single(value) == value


def reckoned(value: Value, *operands: Value) -> Value:
    """What an operation or a function has made of its operands, marked where single precision may make it otherwise."""
    if not isinstance(value, float) or (_exact(value) and all(map(_exact, operands))):
        return value
    return Inexact(value)


def compared(act: Callable[..., bool], left: float, right: float) -> bool:
    """A comparison of numbers as the controller makes it; raises UnknownError where its REALs are too near each other to say."""
    if isinstance(left, Inexact) or isinstance(right, Inexact):
        if abs(left - right) <= _TOLD_APART * max(abs(left), abs(right)):
            raise UnknownError("REALs that single precision may not tell apart")
    elif isinstance(left, float) or isinstance(right, float):
        left, right = _single(left), _single(right)
    return act(left, right)


def rounded(value: float) -> int | None:
    """The INT that takes a REAL: half away from zero; None where single precision may say otherwise."""
    if isinstance(value, Inexact) and abs(value % 1.0 - 0.5) <= _TOLD_APART * max(abs(value), 1.0):
        return None
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def _frame(place: Value) -> NDArray[np.float64]:
    """The frame of an aggregate that gives all of X to C; raises UnknownError."""
    given = [place.get(name) for name in _FRAME] if isinstance(place, dict) else [None]
    numbers = [float(item) for item in given if isinstance(item, int | float) and not isinstance(item, bool)]
    if len(numbers) != len(_FRAME):
        raise UnknownError("a frame without all of X to C")
    return frame(np.array(numbers))


def _placed(made: NDArray[np.float64]) -> Value:
    """A FRAME of KRL's."""
    return {"": "FRAME", **dict(zip(_FRAME, (Inexact(value) for value in to_values(made)), strict=True))}


def chained(first: Value, second: Value) -> Value:
    """first : second, the geometric operator. What becomes of the second's Status, Turn and external axes isn't said."""
    if isinstance(second, dict) and not second.keys() <= {"", *_FRAME}:
        raise UnknownError("what : makes of S, T and external axes isn't said")
    return _placed(_frame(first) @ _frame(second))


FUNCTIONS: dict[str, tuple[int, Callable[..., Value]]] = {
    "ABS": (1, lambda x: Inexact(abs(x)) if isinstance(x, Inexact) else abs(x)),
    "SQRT": (1, lambda x: reckoned(math.sqrt(x), x)),
    "SIN": (1, lambda x: Inexact(math.sin(deg_to_rad(x)))),
    "COS": (1, lambda x: Inexact(math.cos(deg_to_rad(x)))),
    "TAN": (1, lambda x: Inexact(math.tan(deg_to_rad(x)))),
    "ACOS": (1, lambda x: Inexact(rad_to_deg(math.acos(x)))),
    "ATAN2": (2, lambda y, x: Inexact(rad_to_deg(math.atan2(y, x)))),
    "INV_POS": (1, lambda place: _placed(inverse(_frame(place)))),
}
"""By name: how many values it takes, and what it makes of them."""
