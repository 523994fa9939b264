"""KUKA's Status and Turn, which tell a PTP to a pose which branch and turn to take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.arm_axes import arm_axes
from camrob.cell.cell import Cell
from camrob.errors import CellError
from camrob.se3 import rotation_exp, skew
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["StatusTurn"]

Array = NDArray[np.float64]

_CHUNK = 16_384  # postures that are worked on at once: bounds the memory


@dataclass(frozen=True)
class StatusTurn:
    """Status and Turn of a cell's arm (KUKA's system-software manual).

    S bit 0: the wrist's centre is in the overhead area, behind axis 1 as seen along x of the system that turns with A1 and is
    $ROBROOT at A1 = 0. Bit 1: A3 is past `stretch_deg`, the axis value at which the arm is stretched. Bit 2: A5 lies in
    [-180, 0) or from 180 on. T: one bit an axis, set where its value is negative.
    """

    stretch_deg: float
    _forward: Array
    _h: Array
    _from_shoulder: Array
    _from_elbow: Array
    _shoulder: Array
    _signs: Array
    _offsets: Array

    @classmethod
    def of(cls, cell: Cell) -> StatusTurn:
        """For a cell's arm. Raises CellError where the arm has no spherical wrist, for which KUKA defines no status."""
        arm = arm_axes(cell)
        if arm is None:
            raise CellError(
                f"cell {cell.name}: Status and Turn need an arm with a spherical wrist", hint="use PTP by axes"
            )
        joints = cell.joints[cell.arm_slice]
        h, o = arm.h, arm.o
        # ahead is $ROBROOT's x where A1 shows 0; the chain's own zero lies elsewhere
        turned = rotation_exp(-joints[0].q_value(np.zeros(())) * h[0])
        forward = turned @ np.asarray(cell.foot_T_root)[:3, 0]
        along = np.eye(3) - np.outer(h[2], h[2])
        upper, fore = along @ (o[2] - o[1]), along @ (arm.wrist - o[2])
        stretched = float(np.arctan2(h[2] @ np.cross(fore, upper), fore @ upper))
        value = rad_to_deg(float(joints[2].axis_value(np.asarray(stretched))))
        return cls(
            (value + 180.0) % 360.0 - 180.0,
            forward,
            h,
            o[2] - o[1],
            arm.wrist - o[2],
            o[1] - o[0],
            np.array([j.sign for j in joints]),
            np.array([j.offset for j in joints]),
        )

    def status(self, axes_deg: Array) -> NDArray[np.int16]:
        """S (N,) of axis values (N, 6), degrees."""
        out = np.empty(len(axes_deg), np.int16)
        for start in range(0, len(axes_deg), _CHUNK):
            out[start : start + _CHUNK] = self._status(axes_deg[start : start + _CHUNK])
        return out

    def _status(self, axes_deg: Array) -> NDArray[np.int16]:
        q = self._signs * (deg_to_rad(axes_deg) - self._offsets)
        reach = self._from_shoulder + _turned(self._from_elbow, self._h[2], q[:, 2])
        wrist = self._shoulder + _turned(reach, self._h[1], q[:, 1])
        overhead = wrist @ self._forward < 0.0
        a5 = axes_deg[:, 4]
        flipped = ((a5 >= -180.0) & (a5 < 0.0)) | (a5 >= 180.0)
        return np.asarray(overhead * 1 + (axes_deg[:, 2] >= self.stretch_deg) * 2 + flipped * 4, np.int16)

    @staticmethod
    def turn(axes_deg: Array) -> NDArray[np.int16]:
        """T (N,) of axis values (N, 6), degrees."""
        return np.asarray((axes_deg < 0.0) @ (1 << np.arange(np.shape(axes_deg)[-1])), np.int16)


def _turned(p: Array, h: Array, angle: Array) -> Array:
    """Points p, (3,) or (N, 3), turned about the unit vector h through the origin by angles (N,), rad (Rodrigues' formula)."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.multiply.outer(p @ h, h)
    return np.asarray(along + cosine * (p - along) + sine * (p @ skew(h).T))
