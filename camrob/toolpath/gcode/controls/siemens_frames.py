"""CYCLE800's plane, and the programmable frame of TRANS and ROT (840D sl, "Job planning", CYCLE800; "Fundamentals", frames)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.coordinates import euler
from camrob.toolpath.gcode.lexer import Block, Plane
from camrob.units import deg_to_rad

__all__ = ["Frame", "swivel"]

_PLAIN = 57  # A about X, B about the new Y, C about the new Z
_AXES = 0b00111111  # of MODE: three axes, two bits each (1: X, 2: Y, 3: Z), the first turn in the lowest
_KIND = 0b11000000  # of MODE: 0: axis by axis


class Frame:
    """TRANS, ATRANS, ROT and AROT about the tool's axis Z: a place in the program's unit, and an angle in degrees."""

    def __init__(self) -> None:
        self.place = np.zeros(3)
        self.angle = 0.0

    @property
    def plain(self) -> bool:
        """Whether there is none."""
        return not (self.angle or self.place.any())

    def moved(self, by: Mapping[str, float], *, adds: bool) -> None:
        """TRANS begins anew, which ends a turn, too; ATRANS goes along the axes as they are turned."""
        step = np.array([by.get(letter, 0.0) for letter in "XYZ"])
        if adds:
            self.place = self.place + self._turn() @ step
        else:
            self.place, self.angle = step, 0.0

    def turned(self, angle: float, *, adds: bool) -> None:
        """ROT begins anew, which ends a shift, too; AROT turns on."""
        self.angle = self.angle + angle if adds else angle
        self.place = self.place if adds else np.zeros(3)

    def blocks(self, line: int) -> Iterator[Block]:
        """The frame as G52, or as a plane where it is turned."""
        if self.angle:
            yield Block(line, dict.fromkeys("XYZ", 0.0), (520,))
            yield Block(line, {}, plane=(tuple(self._turn().ravel().tolist()), tuple(self.place.tolist())))
        else:
            yield Block(line, {}, plane=None)
            yield Block(line, dict(zip("XYZ", self.place.tolist(), strict=True)), (520,))

    def _turn(self) -> NDArray[np.float64]:
        return euler("3", (deg_to_rad(self.angle),))


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
