"""The circle of a G2 or G3 block, in the frame of the program's points: its centre by I, J, K or by R."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["centre_by_offsets", "centre_by_radius", "normal_of"]

Array = NDArray[np.float64]
_PLANES = {"17": "XYZ", "18": "ZXY", "19": "YZX"}
_SLACK = 2e-5  # of R: what the half way to the end may be longer by


def normal_of(plane: str, clockwise: bool) -> Array:
    """The unit vector about which the arc turns right-handedly; plane "17", "18" or "19"."""
    return np.array([float(letter == _PLANES[plane][2]) for letter in "XYZ"]) * (-1.0 if clockwise else 1.0)


def centre_by_radius(start: Array, end: Array, normal: Array, radius: float) -> Array | None:
    """Of an arc less than half round, or, with a negative radius, more; None where it doesn't reach its end, or has no length."""
    chord = (end - start) * (1.0 - np.abs(normal))
    length = float(np.linalg.norm(chord))
    height = radius * radius - length * length / 4.0
    if not length > 0.0 or height < -_SLACK * abs(radius):
        return None
    side = math.copysign(math.sqrt(max(height, 0.0)), radius)
    return np.asarray(start + chord / 2.0 + np.cross(normal, chord / length) * side)


def centre_by_offsets(start: Array, offset: Array, normal: Array, zero: Array | None) -> Array:
    """offset: I, J, K (m), from the start, or where G90.1 says so, from `zero`, the frame's own, else None."""
    flat = 1.0 - np.abs(normal)
    return start + offset * flat if zero is None else (zero + offset) * flat + start * (1.0 - flat)
