"""Machines that tilt and turn the tool: the axis by the rotary axes, and the way that it takes where they turn evenly."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.units import deg_to_rad

__all__ = ["on_the_way", "tool_axis"]

Array = NDArray[np.float64]
_OFF = 2e-5  # rad: less than this off the great arc is on it


def tool_axis(a: float, b: float, c: float, by_b: bool) -> Array:
    """The tool's axis of a table that tilts about A (or B) and turns about C, degrees: LinuxCNC's XYZAC and XYZBC."""
    tilt, turn = deg_to_rad(b if by_b else a), deg_to_rad(c)
    if by_b:
        return np.array([-math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)])
    return np.array([math.sin(tilt) * math.sin(turn), math.sin(tilt) * math.cos(turn), math.cos(tilt)])


def on_the_way(start: Array, end: Array, by_b: bool) -> list[tuple[Array, Array]]:
    """Tip and axis a degree of a rotary axis apart, between the ends X, Y, Z, A, B, C (6,) of a block.

    None where the axis keeps to the great arc between its ends, or where the start is not known (NaN).
    """
    way = end - start
    size = float(np.abs(way[3:]).max())
    if not math.isfinite(float(way.sum())) or size == 0.0:
        return []

    def axis(f: float) -> Array:
        a, b, c = start[3:] + f * way[3:]
        return tool_axis(float(a), float(b), float(c), by_b)

    if max(_off_arc(axis(0.0), axis(f), axis(1.0), f) for f in (0.31, 0.5)) < _OFF:
        return []
    return [(start[:3] + f * way[:3], axis(f)) for f in np.arange(1.0, size) / size]


def _off_arc(start: Array, axis: Array, end: Array, f: float) -> float:
    """How far an axis lies off the great arc from start to end, at its fraction f."""
    turn = math.acos(min(1.0, max(-1.0, float(start @ end))))
    if turn < 1e-7:
        return float(np.linalg.norm(axis - start))
    arc = (math.sin((1.0 - f) * turn) * start + math.sin(f * turn) * end) / max(math.sin(turn), 1e-9)
    return float(np.linalg.norm(axis - arc))
