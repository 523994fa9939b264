"""KRL's own functions, the geometric operator, and what a declared type makes of a value."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from camrob.errors import KrlError
from camrob.languages.krl.reader.expressions import Aggregate, Computed, Unknown, Value, doubtful_half
from camrob.se3 import frame_from_xyzabc, inverse, xyzabc_from_frame
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["built_in", "frame_product", "typed"]

_FRAME = "XYZABC"
_NUMBERS: dict[str, tuple[int, Callable[..., float]]] = {
    "ABS": (1, abs),
    "SQRT": (1, math.sqrt),
    "SIN": (1, lambda x: math.sin(deg_to_rad(x))),
    "COS": (1, lambda x: math.cos(deg_to_rad(x))),
    "TAN": (1, lambda x: math.tan(deg_to_rad(x))),
    "ACOS": (1, lambda x: rad_to_deg(math.acos(x))),
    "ATAN2": (2, lambda y, x: rad_to_deg(math.atan2(y, x))),
}


def typed(kind: str, value: Value) -> Value:
    """What a variable of this type holds once it is given the value: an INT takes a REAL rounded, a REAL an INT as it is.

    Half of one below zero is Unknown: which way it goes is not said ("Expert Programming", data types).
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if kind == "REAL":
        return value if isinstance(value, float) else float(value)
    if kind == "INT" and isinstance(value, float):
        if not math.isfinite(value) or (value < 0.0 and value % 1.0 == 0.5) or doubtful_half(value):
            return Unknown(f"{value:g} as a whole number")
        return math.floor(value + 0.5)
    return value


def built_in(name: str, arguments: list[Value]) -> Value | None:
    """The value of a function of the language, None where there is none of this name. Raises KrlError outside of its range."""
    if name == "INV_POS" and len(arguments) == 1:
        frame = _frame(arguments[0])
        return Unknown("INV_POS(...)") if frame is None else _aggregate(inverse(frame))
    if name not in _NUMBERS or len(arguments) != _NUMBERS[name][0]:
        return None
    numbers = [v for v in arguments if isinstance(v, (int, float)) and not isinstance(v, bool)]
    if len(numbers) < len(arguments):
        return Unknown(f"{name}(...)")
    try:
        value = _NUMBERS[name][1](*numbers)
        plain = name == "ABS" and not isinstance(numbers[0], Computed)
        return value if plain else Computed(value)
    except ValueError:
        raise KrlError(f"{name} of a number outside of its range", hint="correct the statement") from None


def frame_product(left: Value, right: Value) -> Value:
    """left : right, the frame right that is named in left. Unknown where one of the two is no whole frame, and where the right
    one names external axes, S or T, of which the operator makes nothing that is certain.
    """
    frames = _frame(left), _frame(right)
    plain = isinstance(right, Aggregate) and set(right.fields) == set(_FRAME)
    return (
        Unknown("... : ...")
        if frames[0] is None or frames[1] is None or not plain
        else _aggregate(frames[0] @ frames[1])
    )


def _frame(value: Value) -> np.ndarray | None:
    """The frame of an aggregate (4, 4), mm; None where it doesn't name all of it."""
    fields = value.fields if isinstance(value, Aggregate) else {}
    numbers = [v for k in _FRAME if isinstance(v := fields.get(k), (int, float)) and not isinstance(v, bool)]
    if len(numbers) < len(_FRAME):
        return None
    return frame_from_xyzabc(np.array([*numbers[:3], *deg_to_rad(np.array(numbers[3:], dtype=float))]))


def _aggregate(frame: np.ndarray) -> Aggregate:
    values = xyzabc_from_frame(frame)
    return Aggregate(
        "FRAME", dict(zip(_FRAME, map(Computed, [*values[:3].tolist(), *rad_to_deg(values[3:]).tolist()]), strict=True))
    )
