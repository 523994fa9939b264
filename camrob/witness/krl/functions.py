"""KRL's own functions, the geometric operator, and what all values of KRL have in common."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import frame, inverse, to_values
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["FUNCTIONS", "UnknownError", "Value", "chained"]

Value = bool | int | float | str | dict[str, "Value"]

_FRAME = "XYZABC"


class UnknownError(Exception):
    """What can't be known from the text, and why."""


def _frame(place: Value) -> NDArray[np.float64]:
    """The frame of an aggregate that gives all of X to C; raises UnknownError."""
    given = [place.get(name) for name in _FRAME] if isinstance(place, dict) else [None]
    numbers = [float(item) for item in given if isinstance(item, int | float) and not isinstance(item, bool)]
    if len(numbers) != len(_FRAME):
        raise UnknownError("a frame without all of X to C")
    return frame(np.array(numbers))


def _placed(made: NDArray[np.float64]) -> Value:
    """A FRAME of KRL's."""
    return {"": "FRAME", **dict(zip(_FRAME, (float(value) for value in to_values(made)), strict=True))}


def chained(first: Value, second: Value) -> Value:
    """first : second, the geometric operator. What becomes of the second's Status, Turn and external axes isn't said."""
    if isinstance(second, dict) and not second.keys() <= {"", *_FRAME}:
        raise UnknownError("what : makes of S, T and external axes isn't said")
    return _placed(_frame(first) @ _frame(second))


FUNCTIONS: dict[str, tuple[int, Callable[..., Value]]] = {
    "ABS": (1, abs),
    "SQRT": (1, math.sqrt),
    "SIN": (1, lambda x: math.sin(deg_to_rad(x))),
    "COS": (1, lambda x: math.cos(deg_to_rad(x))),
    "TAN": (1, lambda x: math.tan(deg_to_rad(x))),
    "ACOS": (1, lambda x: rad_to_deg(math.acos(x))),
    "ATAN2": (2, lambda y, x: rad_to_deg(math.atan2(y, x))),
    "INV_POS": (1, lambda place: _placed(inverse(_frame(place)))),
}
"""By name: how many values it takes, and what it makes of them."""
