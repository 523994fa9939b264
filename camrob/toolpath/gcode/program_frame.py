"""A frame that a program sets within the part's or a tilted plane's: shifted, turned about the tool, mirrored, scaled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError

__all__ = ["PLAIN", "ProgramFrame", "about", "euler", "mirrored", "turned"]

_EVEN = 1e-12  # of a matrix: two entries that differ by less are one
Array = NDArray[np.float64]


class ProgramFrame(NamedTuple):
    """Where a point of the program's lies in the frame around it: `outer_M_program` (3, 3), `outer_p_program` (3,), m.

    The matrix turns about Z, mirrors X or Y, and scales X and Y alike, Z by a factor of its own.
    """

    outer_M_program: Array
    outer_p_program: Array

    @property
    def plain(self) -> bool:
        """Whether there is none."""
        return self.shifts_only and not self.outer_p_program.any()

    @property
    def shifts_only(self) -> bool:
        """Whether its axes are those of the frame around it."""
        return bool(np.abs(self.outer_M_program - np.eye(3)).max() < _EVEN)

    @property
    def even(self) -> bool:
        """Whether circles of every plane stay circles."""
        m = self.outer_M_program
        return bool(abs(math.hypot(m[0, 0], m[1, 0]) - m[2, 2]) < _EVEN)

    def out(self, point: Array) -> Array:
        """A point (3,) of the program's in the frame around it; X and Y, or Z, may be NaN."""
        m, p = self.outer_M_program, self.outer_p_program
        return np.array([*(m[:2, :2] @ point[:2] + p[:2]).tolist(), m[2, 2] * point[2] + p[2]])

    def into(self, point: Array) -> Array:
        """A point (3,) of the frame around it as the program names it."""
        m, p = self.outer_M_program, self.outer_p_program
        return np.array([*np.linalg.solve(m[:2, :2], point[:2] - p[:2]).tolist(), (point[2] - p[2]) / m[2, 2]])

    def normal(self, axis: Array) -> Array:
        """The unit vector about which an arc turns right-handedly that the program has turn about `axis`."""
        m = self.outer_M_program
        across = np.linalg.det(m) * np.linalg.solve(m.T, axis)
        return np.asarray(across / np.linalg.norm(across))

    def then(self, matrix: Array, place: Array) -> ProgramFrame:
        """With another one inside it, given in its own axes."""
        m, p = self.outer_M_program, self.outer_p_program
        return ProgramFrame(m @ matrix, p + m @ place)


# the part as it is: nothing turned, nothing shifted
PLAIN = ProgramFrame(np.eye(3), np.zeros(3))


def about(center: Array, matrix: Array) -> ProgramFrame:
    """The frame that keeps `center` (3,) where it is."""
    return ProgramFrame(matrix, center - matrix @ center)


def turned(angle: float) -> Array:
    """(3, 3): about Z, rad."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def mirrored(letters: str) -> Array:
    """(3, 3): the axes named change sign. Raises ToolpathError for other ones than X and Y, and for none."""
    if not letters or not set(letters) <= set("XY"):
        raise ToolpathError("mirroring of another axis than X and Y", hint="let the CAM system do it")
    return np.diag([-1.0 if letter in letters else 1.0 for letter in "XYZ"])


def euler(order: str, angles: tuple[float, ...]) -> NDArray[np.float64]:
    """Rotation matrix of three turns (rad) about the turned axes named by `order` ("313": Z, then X', then Z'')."""
    result = np.eye(3)
    for axis, angle in zip(order, angles, strict=True):
        i = int(axis) - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        turn = np.eye(3)
        turn[j, j] = turn[k, k] = math.cos(angle)
        turn[k, j] = math.sin(angle)
        turn[j, k] = -turn[k, j]
        result = result @ turn
    return result
