"""Conversions between SI and the units of the trade: the only module that multiplies by 1000 or pi/180."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "INCH_MM",
    "deg_to_rad",
    "m3_to_mm3",
    "m_s_to_mm_min",
    "m_to_mm",
    "m_to_um",
    "mm_min_to_m_s",
    "mm_to_m",
    "ms_to_s",
    "rad_to_deg",
    "s_to_ms",
    "um_to_m",
]

Value = TypeVar("Value", float, NDArray[np.float64])

INCH_MM = 25.4  # by definition, since 1959
_RAD_PER_DEG = math.pi / 180.0


def mm_to_m(length_mm: Value) -> Value:
    """Millimetres to metres."""
    return length_mm / 1000.0


def m_to_mm(length: Value) -> Value:
    """Metres to millimetres."""
    return length * 1000.0


def m_to_um(length: Value) -> Value:
    """Metres to micrometres."""
    return length * 1e6


def m3_to_mm3(volume: Value) -> Value:
    """Cubic metres to cubic millimetres."""
    return volume * 1e9


def um_to_m(length_um: Value) -> Value:
    """Micrometres to metres."""
    return length_um / 1e6


def deg_to_rad(angle_deg: Value) -> Value:
    """Degrees to radians."""
    return angle_deg * _RAD_PER_DEG


def rad_to_deg(angle: Value) -> Value:
    """Radians to degrees."""
    return angle / _RAD_PER_DEG


def mm_min_to_m_s(feed_mm_min: Value) -> Value:
    """Millimetres a minute (cutting feed) to metres a second."""
    return feed_mm_min / 60000.0


def m_s_to_mm_min(speed: Value) -> Value:
    """Metres a second to millimetres a minute."""
    return speed * 60000.0


def ms_to_s(time_ms: Value) -> Value:
    """Milliseconds to seconds."""
    return time_ms / 1000.0


def s_to_ms(time: Value) -> Value:
    """Seconds to milliseconds."""
    return time * 1000.0
