"""Shapes of a cell's bodies for collision checks and pictures."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["Shape", "ShapeKind"]


class ShapeKind(StrEnum):
    """The kinds of shapes; `size` in metres means, in turn:"""

    BOX = "box"  # full lengths along x, y, z
    CYLINDER = "cylinder"  # radius, full length along z
    CAPSULE = "capsule"  # radius, length between the two centres along z
    SPHERE = "sphere"  # radius
    MESH = "mesh"  # scale; `file` in the cell's folder


@dataclass(frozen=True, slots=True)
class Shape:
    """A body fixed in a frame of the cell.

    `frame` is "world", "base", "root", "flange", "tool", or a joint's name: the frame that this joint's
    Denavit-Hartenberg row ends in. frame_T_shape: (4, 4), the shape's centre and axes. Bodies that carry one `group`
    are one piece; `ignore` names groups that it may touch: neighbours, mountings, "part" and "stock" (a job's bodies).
    """

    name: str
    group: str
    frame: str
    kind: ShapeKind
    size: NDArray[np.float64]
    frame_T_shape: NDArray[np.float64]
    file: str = ""
    ignore: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", locked(self.size, shape=(None,), name="size"))
        object.__setattr__(self, "frame_T_shape", locked(self.frame_T_shape, shape=(4, 4), name="frame_T_shape"))
