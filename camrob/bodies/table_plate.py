"""The plate of a cell's table: what a part has to lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.bodies import JOB_GROUPS
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.shape import Shape, ShapeKind
from camrob.frozen import locked

__all__ = ["TablePlate", "table_plate"]

Array = NDArray[np.float64]

_UPRIGHT = 1e-6  # of the plate's axis across `base`'s z


@dataclass(frozen=True, slots=True)
class TablePlate:
    """A level plate, fixed in `base`: `top` (m) is its upper face's height, base_T_plate (4, 4) its middle.

    half: (2,) half its sides along its own x and y, m, or (1,) its radius.
    """

    name: str
    top: float
    base_T_plate: Array
    half: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_plate", locked(self.base_T_plate, shape=(4, 4), name="base_T_plate"))
        object.__setattr__(self, "half", locked(self.half, shape=(None,), name="half"))

    def beyond(self, points: Array) -> float:
        """How far the farthest of points (K, 3) in `base` lies outside the plate's edge, seen from above, m; below 0 inside."""
        local = (points[:, :2] - self.base_T_plate[:2, 3]) @ self.base_T_plate[:2, :2]
        if len(self.half) == 1:
            return float(np.hypot(local[:, 0], local[:, 1]).max() - self.half[0])
        return float((np.abs(local) - self.half).max())


def table_plate(cell: Cell) -> TablePlate | None:
    """The highest of the cell's upright boxes and cylinders in `base` that the part or stock may touch; None: it has none.

    Of a cell without a table that moves `world` is `base`.
    """
    frames = ("base",) if cell.indices(Role.WORKPIECE) else ("base", "world")
    plates = [_plate(s) for s in cell.shapes if s.frame in frames and _carries(s)]
    return max(plates, key=lambda plate: plate.top, default=None)


def _carries(shape: Shape) -> bool:
    solid = shape.kind in (ShapeKind.BOX, ShapeKind.CYLINDER)
    level = abs(shape.frame_T_shape[2, 2]) > 1.0 - _UPRIGHT
    return solid and level and any(group in shape.ignore for group in JOB_GROUPS)


def _plate(shape: Shape) -> TablePlate:
    size = np.asarray(shape.size)
    box = shape.kind is ShapeKind.BOX
    height = float(size[2] if box else size[1])
    top = float(shape.frame_T_shape[2, 3]) + 0.5 * height
    return TablePlate(shape.name, top, shape.frame_T_shape, 0.5 * size[:2] if box else size[:1])
