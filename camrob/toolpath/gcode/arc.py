"""The circle of a G2 or G3 block: centre, right-handed normal and turns from I, J, K or R in one of three planes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.units import m_to_mm

__all__ = ["circle", "refuse_second_circle"]

_PLANES = {170: (0, 1, 2), 180: (2, 0, 1), 190: (1, 2, 0)}  # first and second coordinate, normal: right-handed
_OFFSETS = "IJK"
_ROUNDING = 20e-6  # m: what start and end radius may differ by
_SLACK = 1e-3  # and in proportion to the radius
_MOST_SLACK = 100e-6  # m: that at most, whatever the radius: beyond it a word is wrong


def circle(
    words: dict[str, float],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    *,
    plane: int,
    clockwise: bool,
    absolute_center: bool,
    scale: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Centre (3,) m, unit normal (3,) about which the motion turns right-handedly, further full turns.

    All in the program's frame; `start` and `end` (3,) m, `scale` is m per programmed unit, `plane` is 170, 180 or
    190. G2 runs clockwise seen from the plane's positive normal. Raises ToolpathError where no circle fits.
    """
    first, second, normal_index = _PLANES[plane]
    normal = np.zeros(3)
    normal[normal_index] = 1.0
    if "R" in words:
        if any(letter in words for letter in _OFFSETS):
            raise ToolpathError("an arc with both R and a centre (I, J, K)", hint="keep one of them")
        center = _center_of_radius(words["R"] * scale, start, end, first, second, normal, clockwise)
    else:
        if not any(_OFFSETS[i] in words for i in (first, second)):
            raise ToolpathError("an arc without centre (I, J, K) or radius (R) in its plane", hint="check the plane")
        center = start.copy()
        for i in (first, second):
            value = words.get(_OFFSETS[i])
            if absolute_center:
                if value is None:
                    raise ToolpathError(f"G90.1 asks for {_OFFSETS[i]} in every arc", hint="name both centre words")
                center[i] = value * scale
            elif value is not None:
                center[i] += value * scale
    radii = [math.hypot(p[first] - center[first], p[second] - center[second]) for p in (start, end)]
    if min(radii) < 1e-9 or abs(radii[0] - radii[1]) > _ROUNDING + min(_SLACK * max(radii), _MOST_SLACK):
        raise ToolpathError(
            f"an arc's start and end lie {m_to_mm(abs(radii[0] - radii[1])):.4f} mm apart in radius about its centre",
            hint="check whether I, J, K are incremental (G91.1) or absolute (G90.1), and the arc's plane",
        )
    return center, -normal if clockwise else normal, _turns(words)


def refuse_second_circle(
    words: dict[str, float],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    center: NDArray[np.float64],
    plane: int,
    scale: float,
) -> None:
    """Raises ToolpathError where I, J, K counted from the program's zero make a circle, too, another than about `center`."""
    first, second, _ = _PLANES[plane]
    other = [words.get(_OFFSETS[i], 0.0) * scale for i in (first, second)]
    radii = [math.hypot(p[first] - other[0], p[second] - other[1]) for p in (start, end)]
    apart = math.hypot(center[first] - other[0], center[second] - other[1])
    if apart > _ROUNDING and min(radii) > _ROUNDING and abs(radii[0] - radii[1]) < _ROUNDING + _MOST_SLACK:
        raise ToolpathError(
            "an arc that I, J, K make from its start and, as NUM's controls count them, from the program's zero: two circles,"
            " and the file begins with % and a number, as NUM's and Siemens' older ones do",
            hint="give it by R, in two parts where it is closed, or begin the file with % alone where it is not NUM's",
        )


def _center_of_radius(
    radius: float,
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    first: int,
    second: int,
    normal: NDArray[np.float64],
    clockwise: bool,
) -> NDArray[np.float64]:
    """Centre of an arc given by its radius (negative: the longer way round)."""
    du, dv = end[first] - start[first], end[second] - start[second]
    chord = math.hypot(du, dv)
    if chord < 1e-9:
        raise ToolpathError("a full circle can't be given by R", hint="give its centre by I, J, K")
    square = radius * radius - 0.25 * chord * chord
    if square < -(_ROUNDING + _SLACK * abs(radius)) * chord:
        raise ToolpathError("an arc's radius is smaller than half the way to its end", hint="check R")
    height = math.sqrt(max(square, 0.0))
    if (radius > 0.0) == clockwise:
        height = -height
    center = 0.5 * (start + end)
    center[first] += -dv / chord * height
    center[second] += du / chord * height
    center += normal * float((start - center) @ normal)
    return center


def _turns(words: dict[str, float]) -> int:
    """Further full turns: P counts all of them, the broken one included."""
    count = words.get("P", 1.0)
    if count != int(count) or not 1 <= count <= 100_000:
        raise ToolpathError(f"P{count:g} in an arc is not a number of turns", hint="a whole number from 1")
    return int(count) - 1
