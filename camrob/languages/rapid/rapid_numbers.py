"""What the decimals that a RAPID program prints leave of numbers, and the quaternions that stand for A, B, C: as a whole, the
language's `Rounding`.

RAPID keeps numbers in single precision (seven digits), which is no less than these decimals for a robot's lengths and angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.program.printed import rounded
from camrob.se3 import quaternion_to_rotation, rotation_to_abc
from camrob.units import deg_to_rad, rad_to_deg

__all__ = [
    "ANGLE_DECIMALS",
    "EXTERNAL_DECIMALS",
    "FRAME_DECIMALS",
    "LENGTH_DECIMALS",
    "LOAD_DECIMALS",
    "QUATERNION_DECIMALS",
    "SPEED_DECIMALS",
    "axes",
    "external",
    "frame",
    "load",
    "pose",
    "quaternions",
    "speed",
]

LENGTH_DECIMALS = 3
"""X, Y, Z in mm: half a micrometre."""
FRAME_DECIMALS = 5
"""X, Y, Z of tools and work objects in mm."""
QUATERNION_DECIMALS = 8
"""q1 .. q4: 0.02 micrometres at 1 m."""
ANGLE_DECIMALS = 4
"""Axes 1 to 6 in degrees."""
EXTERNAL_DECIMALS = 4
"""eax_a .. eax_f in mm or degrees."""
LOAD_DECIMALS = 3
"""Mass in kg, its centre in mm."""
SPEED_DECIMALS = 3
"""v_tcp in mm/s: 0.06 mm/min."""
_UNIT = 10.0**QUATERNION_DECIMALS  # steps of the last decimal in one
_ROUNDS = 20  # of rounding to unit length and back: a rotation is at rest after two or three

Array = NDArray[np.float64]


def axes(axes: ArrayLike) -> Array:
    """A1..A6 (..., 6), degrees, as printed."""
    return rounded(axes, ANGLE_DECIMALS)


def external(external: ArrayLike) -> Array:
    """E1.. (..., E), mm or degrees, as printed."""
    return rounded(external, EXTERNAL_DECIMALS)


def frame(xyzabc: ArrayLike) -> Array:
    """X, Y, Z, A, B, C (..., 6), mm and degrees, of a tool or a base, as its place and quaternion say them."""
    values = np.asarray(xyzabc, np.float64)
    return np.concatenate([rounded(values[..., :3], FRAME_DECIMALS), _angles(quaternions(values[..., 3:]))], axis=-1)


def load(load: ArrayLike) -> Array:
    """Mass in kg, its centre in mm and its moments in kg m^2 (..., 7), as printed."""
    return rounded(load, LOAD_DECIMALS)


def pose(pose: ArrayLike, external: ArrayLike) -> tuple[Array, Array]:
    """Poses (N, 6), mm and degrees, and external axes (N, E), as a robtarget says them."""
    values = np.asarray(pose, np.float64)
    if values.ndim != 2 or values.shape[1] != 6:
        raise ValueError(f"pose has shape {values.shape}, expected (N, 6)")
    out = np.concatenate([rounded(values[:, :3], LENGTH_DECIMALS), _angles(quaternions(values[:, 3:]))], axis=1)
    return out, rounded(external, EXTERNAL_DECIMALS)


def speed(speed: ArrayLike) -> Array:
    """Speeds in m/s, as v_tcp in mm/s prints them."""
    return rounded(speed, SPEED_DECIMALS + 3)


def quaternions(abc_deg: ArrayLike) -> Array:
    """q1 .. q4 (..., 4), scalar part first and not negative, of A, B, C (..., 3) in degrees: with the decimals that are printed.

    Rounding takes a quaternion off unit length, to which a controller brings it back: the ones returned stay as they are when
    that is done again, so that the printed number and the rotation belong to each other.
    """
    half = 0.5 * deg_to_rad(np.asarray(abc_deg, np.float64))
    (ca, cb, cc), (sa, sb, sc) = np.moveaxis(np.cos(half), -1, 0), np.moveaxis(np.sin(half), -1, 0)
    q = np.stack(
        [
            ca * cb * cc + sa * sb * sc,
            ca * cb * sc - sa * sb * cc,
            ca * sb * cc + sa * cb * sc,
            sa * cb * cc - ca * sb * sc,
        ],
        axis=-1,
    )
    whole = np.rint(q * _UNIT)
    for _ in range(_ROUNDS):
        again = np.rint(whole / np.linalg.norm(whole, axis=-1, keepdims=True) * _UNIT)
        if np.array_equal(again, whole, equal_nan=True):
            break
        whole = again
    first = np.argmax(whole != 0.0, axis=-1)[..., None]
    sign = np.where(np.take_along_axis(whole, first, axis=-1) < 0.0, -1.0, 1.0)
    return np.asarray(sign * whole / _UNIT + 0.0)


def _angles(q: Array) -> Array:
    """A, B, C (..., 3) in degrees of quaternions (..., 4)."""
    return np.asarray(rad_to_deg(rotation_to_abc(quaternion_to_rotation(q))) + 0.0)
