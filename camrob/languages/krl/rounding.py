"""Rounding of poses and axis values to the decimals that a KRL program prints: as a whole, the language's `Rounding`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.program.printed import rounded

__all__ = [
    "ANGLE_DECIMALS",
    "EXTERNAL_DECIMALS",
    "FRAME_DECIMALS",
    "LENGTH_DECIMALS",
    "LOAD_DECIMALS",
    "SPEED_DECIMALS",
    "axes",
    "external",
    "frame",
    "load",
    "pose",
    "speed",
]

LENGTH_DECIMALS = 3
"""X, Y, Z in mm: half a micrometre."""
ANGLE_DECIMALS = 4
"""A, B, C and A1..A6 in degrees: 0.9 micrometres at 1 m."""
EXTERNAL_DECIMALS = 4
"""E1.. in mm or degrees."""
FRAME_DECIMALS = 5
"""`$TOOL` and `$BASE`."""
LOAD_DECIMALS = 3
"""`$LOAD`, in kg and mm."""
SPEED_DECIMALS = 6
"""`$VEL.CP` in m/s: 0.06 mm/min, so that 1 mm/min (1.7e-5 m/s) stays apart."""

Array = NDArray[np.float64]


def axes(axes: ArrayLike) -> Array:
    """A1..A6 (..., 6), degrees, as printed."""
    return rounded(axes, ANGLE_DECIMALS)


def external(external: ArrayLike) -> Array:
    """E1.. (..., E), mm or degrees, as printed."""
    return rounded(external, EXTERNAL_DECIMALS)


def frame(xyzabc: ArrayLike) -> Array:
    """X, Y, Z, A, B, C (..., 6), mm and degrees, of a tool or a base, as printed."""
    return rounded(xyzabc, FRAME_DECIMALS)


def load(load: ArrayLike) -> Array:
    """Mass in kg, its centre in mm and its moments in kg m^2 (..., 7), as `$LOAD` prints them."""
    return rounded(load, LOAD_DECIMALS)


def speed(speed: ArrayLike) -> Array:
    """`$VEL.CP`, m/s, as printed."""
    return rounded(speed, SPEED_DECIMALS)


def pose(pose: ArrayLike, external: ArrayLike) -> tuple[Array, Array]:
    """Poses (N, 6), mm and degrees, and external axes (N, E), rounded to what is printed.

    A and C are brought into -180..180, the range that the pendant shows. Where one is 180 exactly (180 and -180 name
    the same rotation) it takes the sign of the point before, so that a resting angle doesn't flicker; where a path
    turns on through 180 the printed value goes over to -180, which the controller, that interpolates rotations, runs as
    the small rotation that it is. External axes are only rounded: a table that turns without end keeps counting.
    """
    values = np.array(pose, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != 6:
        raise ValueError(f"pose has shape {values.shape}, expected (N, 6)")
    out = np.empty_like(values)
    out[:, :3] = rounded(values[:, :3], LENGTH_DECIMALS)
    angles = values[:, 3:].copy()
    angles[:, (0, 2)] -= 360.0 * np.round(angles[:, (0, 2)] / 360.0)
    out[:, 3:] = rounded(angles, ANGLE_DECIMALS)
    for column in (3, 5):
        out[:, column] = _steady_half_turn(out[:, column])
    return out, rounded(external, EXTERNAL_DECIMALS)


def _steady_half_turn(angle: Array) -> Array:
    """The same angles, a half turn with the sign of the last angle before it that has one (at the start: after)."""
    half = np.abs(angle) == 180.0
    signed = ~half & (angle != 0.0)
    if not half.any():
        return angle
    last = np.maximum.accumulate(np.where(signed, np.arange(len(angle)), -1))
    first = int(np.argmax(signed)) if signed.any() else -1
    source = np.where(last >= 0, last, first)
    sign = np.where(source >= 0, np.sign(angle[source]), 1.0)
    return np.where(half, 180.0 * sign, angle)
