"""Frames that a program sets for its own points: shifted, turned about Z, mirrored in X or Y, scaled, one within another.

Each is a matrix (4, 4) that takes what the program writes, in metres, to the frame outside it. Siemens, "Fundamentals" (frames):
TRANS, ROT, MIRROR, SCALE each end all that was before, ATRANS and so on stand within it. Fanuc B-63944EN: G68 turns about the
point that it names, G51.1 mirrors at X = .. and Y = .., G51 scales about a point. Heidenhain, "Machining Cycles": 8 mirrors, 10
turns, about the datum that 7 has shifted.
"""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import rotation
from camrob.witness.units import deg_to_rad

__all__ = ["at_place", "in_plane", "mirror", "scaling", "shifting", "spin", "stands_still", "stretch", "turning"]

Array = NDArray[np.float64]
_SAME = 1e-12  # of a matrix: what rounding leaves


def _frame(linear: Array, origin: Array) -> Array:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = linear, origin
    return whole


def shifting(by: list[float]) -> Array:
    """By X, Y, Z, m."""
    return _frame(np.eye(3), np.array(by))


def turning(degrees: float) -> Array:
    """About Z."""
    return _frame(rotation(2, np.array([deg_to_rad(degrees)]))[0], np.zeros(3))


def mirror(letters: str) -> Array | None:
    """These axes the other way; None for Z, which is the tool's."""
    signs = [1.0 - 2.0 * (letter in letters) for letter in "XYZ"]
    return None if "Z" in letters else _frame(np.diag(signs), np.zeros(3))


def scaling(x: float, y: float, z: float) -> Array | None:
    """None where circles in the XY plane become ovals, or a factor is none."""
    return _frame(np.diag([x, y, z]), np.zeros(3)) if x == y and min(x, z) > 0.0 else None


def at_place(place: Array, frame: Array) -> Array:
    """The frame about another point (3,) m than the origin."""
    return np.asarray(_frame(np.eye(3), place) @ frame @ _frame(np.eye(3), -place))


def in_plane(frame: Array) -> bool:
    """Whether it only shifts."""
    return bool(np.abs(frame[:3, :3] - np.eye(3)).max() < _SAME)


def stretch(frame: Array) -> tuple[float, float]:
    """By how much it scales X and Y, and Z."""
    across = math.sqrt(abs(float(np.linalg.det(frame[:2, :2]))))
    return across, float(frame[2, 2])


def spin(frame: Array, normal: Array) -> Array:
    """About what an arc turns right-handedly outside that turns about `normal`, one of the axes, inside."""
    i = int(np.argmax(np.abs(normal)))
    first, second = frame[:3, (i + 1) % 3], frame[:3, (i + 2) % 3]
    turned = np.cross(first, second) * normal[i]
    return np.asarray(turned / np.linalg.norm(turned))


def stands_still(rest: str, shift: dict[str, float], scale: float) -> bool:
    """Whether the words of a datum shift, in units of `scale` m, say what holds already (m)."""
    found = re.findall(r"(I?)([XYZ])\s?([-+]?(?:\d+\.?\d*|\.\d+))", rest)
    return not any(float(v) - (0.0 if more else shift[axis] / scale) for more, axis, v in found)
