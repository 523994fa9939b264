"""The circle of a G2 or G3 block, in the frame of the program's points: its centre by I, J, K or by R; and rounded corners."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bend", "Wanted", "bend", "bent", "centre_by_offsets", "centre_by_radius", "normal_of", "twofold"]

Array = NDArray[np.float64]
_PLANES = {"17": "XYZ", "18": "ZXY", "19": "YZX"}
_LITTLE = 1e-9  # m
_ALIKE = 2e-4  # m: as far as two radii of one arc may be rounded apart, and more
_OUT = 1e-6  # of a length: rounding out of the plane
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


def twofold(start: Array, end: Array, offset: Array, normal: Array) -> bool:
    """Whether two circles go from start to end: with I, J, K from the start, and from the frame's zero, as NUM counts them."""
    flat = 1.0 - np.abs(normal)
    if np.linalg.norm(start * flat) < _LITTLE:
        return False
    radii = [float(np.linalg.norm((point - offset) * flat)) for point in (start, end)]
    return abs(radii[0] - radii[1]) < _ALIKE


class Wanted(NamedTuple):
    """A corner that is asked for: radius, or a chamfer along the contour (`side`) or across it (`across`), m; feed in m/s."""

    radius: float = 0.0
    side: float = 0.0
    across: float = 0.0
    feed: float | None = None


class Bend(NamedTuple):
    """From `first` to `last`, round `center` about `normal`, or straight where that is None."""

    first: Array
    last: Array
    center: Array | None
    normal: Array


def bend(a: Array, b: Array, c: Array, plane: Array, want: Wanted) -> Bend | None:
    """The corner at b of the way from a over b to c. plane: unit normal. None where there is none, or it doesn't fit."""
    ab, bc = b - a, c - b
    if min(np.linalg.norm(ab), np.linalg.norm(bc)) < _LITTLE:
        return None
    d, e = ab / np.linalg.norm(ab), bc / np.linalg.norm(bc)
    if abs(d @ plane) > _OUT or abs(e @ plane) > _OUT:
        return None
    turn = math.atan2(float(np.cross(d, e) @ plane), float(d @ e))  # to the left: positive
    if not 1e-6 < abs(turn) < math.pi - 1e-6:
        return None
    side = want.side or want.radius * math.tan(0.5 * abs(turn)) or 0.5 * want.across / math.cos(0.5 * turn)
    if side > min(np.linalg.norm(ab), np.linalg.norm(bc)) + _LITTLE:
        return None
    first, last = b - side * d, b + side * e
    if not want.radius:
        return Bend(first, last, None, plane)
    left = math.copysign(1.0, turn) * plane
    return Bend(first, last, first + want.radius * np.cross(left, d), left)


def bent(a: Array, b: Array, c: Array) -> bool:
    """Whether the way from a over b to c is none that goes straight on."""
    d, e = b - a, c - b
    sizes = float(np.linalg.norm(d)) * float(np.linalg.norm(e))
    return not (sizes > 0.0 and float(d @ e) > 0.0 and float(np.linalg.norm(np.cross(d, e))) < 1e-6 * sizes)
