"""CYCLE800's plane, and the programmable frame of TRANS, ROT, MIRROR and SCALE.

840D sl, "Job planning", CYCLE800; "Fundamentals", frames.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import Plane
from camrob.toolpath.gcode.program_frame import PLAIN, ProgramFrame, euler, mirrored, turned
from camrob.units import deg_to_rad

__all__ = ["PART", "Frame", "swivel"]

PART: Plane = ((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
"""The plane that is the part's own."""


_ROT = re.compile(r"(?:(?:Z|RPL)=?([^ ,]+))?")  # about the tool's axis
_PLAIN = 57  # A about X, B about the new Y, C about the new Z
_AXES = 0b00111111  # of MODE: three axes, two bits each (1: X, 2: Y, 3: Z), the first turn in the lowest
_KIND = 0b11000000  # of MODE: 0: axis by axis


class Frame:
    """The programmable frame: TRANS, ROT about the tool's axis, MIRROR and SCALE begin anew, ATRANS and so on go on within it."""

    def __init__(self) -> None:
        self._frame = PLAIN

    @property
    def plain(self) -> bool:
        """Whether there is none."""
        return self._frame.plain

    def by_angle(
        self,
        kind: str,
        rest: str,
        plane: float | None,
        numbers: Callable[[str], list[float | None]],
    ) -> ProgramFrame:
        """ROT or AROT with what stands behind it. Raises ToolpathError for a turn about another axis than the tool's."""
        turn = _ROT.fullmatch(rest)
        if turn is None:
            raise ToolpathError(
                f"a turned frame ({kind} about X or Y) is not read",
                hint="have the CAM system turn the path, or use CYCLE800",
            )
        (angle,) = numbers(turn[1]) if turn[1] else [0.0]
        if plane != 17.0:
            raise ToolpathError("ROT in another plane than G17", hint="have the CAM system turn the path")
        return self.turned(angle or 0.0, adds=kind.startswith("A"))

    def by_axes(self, kind: str, found: Mapping[str, float]) -> ProgramFrame:
        """TRANS, MIRROR, SCALE or what adds to them. Raises ToolpathError for an axis that turns."""
        if set(found) - set("XYZ"):
            raise ToolpathError(f"{kind} of another axis than X, Y, Z", hint="put it into the work offset")
        adds = kind.startswith("A")
        if kind.endswith("TRANS"):
            return self.moved(found, adds=adds)
        if kind.endswith("MIRROR"):
            return self.mirrored("".join(found), adds=adds)
        return self.scaled(found, adds=adds)

    def moved(self, by: Mapping[str, float], *, adds: bool) -> ProgramFrame:
        """By lengths in the program's unit, along the axes as they are."""
        return self._set(np.eye(3), np.array([by.get(letter, 0.0) for letter in "XYZ"]), adds)

    def turned(self, angle: float, *, adds: bool) -> ProgramFrame:
        """About Z, degrees."""
        return self._set(turned(deg_to_rad(angle)), np.zeros(3), adds)

    def mirrored(self, letters: str, *, adds: bool) -> ProgramFrame:
        """These axes change sign; none of them: only what was before ends. Raises ToolpathError for Z."""
        return self._set(mirrored(letters) if letters else np.eye(3), np.zeros(3), adds)

    def scaled(self, by: Mapping[str, float], *, adds: bool) -> ProgramFrame:
        """Raises ToolpathError where X and Y are scaled by two factors, or one is not above zero."""
        factors = [by.get(letter, 1.0) for letter in "XYZ"]
        if factors[0] != factors[1] or not min(factors) > 0.0:
            raise ToolpathError(
                "SCALE of X and Y by two factors, or by none above zero", hint="let the CAM system scale"
            )
        return self._set(np.diag(factors), np.zeros(3), adds)

    def _set(self, matrix: NDArray[np.float64], place: NDArray[np.float64], adds: bool) -> ProgramFrame:
        self._frame = (self._frame if adds else PLAIN).then(matrix, place)
        return self._frame


def swivel(arguments: list[float]) -> Plane:
    """The plane that CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, ...) sets; without any, the part's own again.

    Raises ToolpathError for the kinds that need the machine's own data.
    """
    if not arguments:
        return None
    values = [*arguments, *[0.0] * 13]
    _, _, state, mode = values[:4]
    first, angles, second = np.array(values[4:7]), values[7:10], np.array(values[10:13])
    if int(state) % 10 == 1:
        raise ToolpathError("CYCLE800 that adds to the plane before it", hint="post with new planes (ST 0)")
    if int(mode) & _KIND and any(angles):
        raise ToolpathError(
            f"CYCLE800 with MODE {int(mode)}: space angles, projected angles or rotary axes",
            hint="post with MODE 57, 39 or 27",
        )
    bits = int(mode) & _AXES or _PLAIN
    order = "".join(str(bits >> shift & 3) for shift in (0, 2, 4))
    if "0" in order:
        raise ToolpathError(f"CYCLE800 with MODE {int(mode)}: no order of axes", hint="post with MODE 57, 39 or 27")
    a, b, c = (deg_to_rad(angle) for angle in angles)
    rotation = euler(order, (a, b, c))
    origin = first + rotation @ second
    return tuple(rotation.ravel().tolist()), tuple(origin.tolist())
