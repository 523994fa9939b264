"""How the instrument's poses come in: one line of plain ASCII a datagram.

    t_s x_mm y_mm z_mm q0 q1 q2 q3

`t_s` is when the pose was true, in seconds, by the instrument's own clock or by the system clock of the machine that camrob runs
on (`stamps`); it has to grow from datagram to datagram. x, y, z are the tool centre point in the instrument's frame, in mm; q0
(real), q1, q2, q3 the tool frame's orientation in it, a unit quaternion as in paper 001, eq. 1. Numbers are apart by single
spaces; a line feed may end the line. A datagram with anything else, NaN and infinity included, is refused and counted. Distance
and angles become this by eq. 1: x = r sin(alpha) cos(theta), and so on.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.frozen import locked
from camrob.loop.tracker_error import quaternion_rotation
from camrob.units import mm_to_m

__all__ = ["InstrumentPose", "read_instrument"]

Array = NDArray[np.float64]

_LONGEST = 512  # bytes of a datagram: four numbers take a tenth of it
_NUMBER = rb"[+-]?(?:[0-9]{1,20}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,3})?"
_LINE = re.compile(rb"(?:" + _NUMBER + rb" ){7}" + _NUMBER + rb"\r?\n?")
_FARTHEST_MM = 1e6  # a kilometre: no instrument sees as far
_LATEST_S = 1e12  # thirty thousand years: any clock's zero fits
_UNIT = 1e-3  # how far the quaternion's length may be from 1
_HINT = "send 't_s x_mm y_mm z_mm q0 q1 q2 q3'"


class InstrumentPose(NamedTuple):
    """One measurement: the instrument's time, s, and the pose of the tool in the instrument's frame, (4, 4)."""

    t_s: float
    tracker_T_tcp: Array


def read_instrument(data: bytes) -> InstrumentPose:
    """One datagram of the instrument. Raises InputError, with one of a few fixed texts, for anything that isn't such a line."""
    if len(data) > _LONGEST or _LINE.fullmatch(data) is None:
        raise InputError("a measurement isn't eight finite numbers", hint=_HINT)
    t_s, x, y, z, q0, q1, q2, q3 = (float(part) for part in data.split())
    if not abs(t_s) <= _LATEST_S or not max(abs(x), abs(y), abs(z)) <= _FARTHEST_MM:
        raise InputError("a measurement's time or place is beyond any instrument's range", hint=_HINT)
    length = math.hypot(q0, q1, q2, q3)
    if not abs(length - 1.0) <= _UNIT:
        raise InputError("a measurement's quaternion isn't of length 1", hint=_HINT)
    rows = quaternion_rotation(q0 / length, q1 / length, q2 / length, q3 / length)
    T = [*((*row, mm_to_m(place)) for row, place in zip(rows, (x, y, z), strict=True)), (0.0, 0.0, 0.0, 1.0)]
    return InstrumentPose(t_s, locked(T, shape=(4, 4), name="pose"))
