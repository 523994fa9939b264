"""APT's COPY and TRACUT: the stretch behind an INDEX again, and points that are transformed; as Autodesk's arcs, by their angle.

COPY/n,kind,...,m makes m copies beside the stretch itself, each transformed once more than the one before (the CL editor of
APT-IV). kind: SAME; TRANSL,x,y,z; XYROT,degrees, left-handed for negative ones; MODIFY,three rows of four.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.source import Statement, number
from camrob.witness.frames import rotation
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["copies_of", "matrix_of", "turns_right"]

Array = NDArray[np.float64]
Frame = tuple[Array, Array]

# words behind each kind of copy, its count of repetitions among them
_SIZES = {"SAME": 1, "TRANSL": 4, "XYROT": 2, "MODIFY": 13}
_NEAR = 0.5  # degrees: between the angle that is named and the arc's


def matrix_of(values: list[float], scale: float) -> Frame | None:
    """Three rows of four as a rotation, or one with a mirror, and a shift (m), None where it is none."""
    rows = np.array(values).reshape(3, 4) if len(values) == 12 else np.zeros((3, 4))
    turn = rows[:, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3:
        return None
    return turn, rows[:, 3] * scale


def copies_of(s: Statement, scale: float, base: Frame) -> tuple[int, list[Frame]] | None:
    """The number of the INDEX, and the frame of the points in the part for each copy; None where it isn't understood."""
    fields = s.fields
    kind = fields[1] if len(fields) > 1 else ""
    values = [v for v in map(number, fields[2:]) if v is not None]
    index = number(fields[0]) if fields else None
    if index is None or len(values) != len(fields) - 2 or len(values) != _SIZES.get(kind, -1):
        return None
    one: Frame | None = np.eye(3), np.zeros(3)
    if kind == "TRANSL":
        one = np.eye(3), np.array(values[:3]) * scale
    elif kind == "XYROT":
        one = rotation(2, np.array([deg_to_rad(values[0])]))[0], np.zeros(3)
    elif kind == "MODIFY":
        one = matrix_of(values[:12], scale)
    if one is None or not 1 <= values[-1] <= 1000 or values[-1] % 1:
        return None
    frames: list[Frame] = []
    turn, shift = base
    for _ in range(int(values[-1])):
        turn, shift = turn @ one[0], turn @ one[1] + shift
        frames.append((turn, shift))
    return int(index), frames


def turns_right(start: Array, end: Array, center: Array, normal: Array, angle: float, *, signed: bool) -> bool | None:
    """Whether an arc of `angle` degrees goes right-handedly about the unit normal, None where that isn't known.

    signed: the file is of an edition whose normal says it; else the angle has to, which a half circle's does not.
    """
    a, b = start - center, end - center
    a, b = a - (a @ normal) * normal, b - (b @ normal) * normal
    swept = rad_to_deg(math.atan2(float(normal @ np.cross(a, b)), float(a @ b))) % 360.0
    closed = float(np.linalg.norm(a - b)) < 1e-6
    right = closed or abs(math.remainder(swept - angle, 360.0)) < _NEAR
    left = not closed and abs(math.remainder(360.0 - swept - angle, 360.0)) < _NEAR
    if signed:
        return True if right else None
    return None if right == left else right
