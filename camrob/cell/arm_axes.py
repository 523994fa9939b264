"""An arm with a spherical wrist as six screw axes at q = 0, whatever habit its Denavit-Hartenberg rows follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked

__all__ = ["ArmAxes", "arm_axes"]

Array = NDArray[np.float64]

_SAME = 1e-9  # m and rad within which axes meet or are parallel


@dataclass(frozen=True, slots=True)
class ArmAxes:
    """Screw axes of an arm at q = 0, seen from the frame that its first joint's row begins in (`foot`).

    h (6, 3) unit axes, o (6, 3) points on them, wrist (3,) where axes 4 to 6 meet; foot_T_tool (4, 4) at q = 0.
    """

    h: Array
    o: Array
    wrist: Array
    foot_T_tool: Array

    def __post_init__(self) -> None:
        for name, shape in (("h", (6, 3)), ("o", (6, 3)), ("wrist", (3,)), ("foot_T_tool", (4, 4))):
            object.__setattr__(self, name, locked(getattr(self, name), shape=shape, name=name))


def arm_axes(cell: Cell) -> ArmAxes | None:
    """The axes of a cell's arm, or None unless axes 2 and 3 are parallel and axes 4, 5 and 6 meet at right angles."""
    arm = cell.joints[cell.arm_slice]
    if len(arm) != 6:
        return None
    h, o = np.empty((6, 3)), np.empty((6, 3))
    foot_T_next = np.eye(4)
    for i, joint in enumerate(arm):
        axis = foot_T_next @ joint.before
        h[i], o[i] = axis[:3, 2], axis[:3, 3]
        foot_T_next = axis @ joint.after
    if np.linalg.norm(np.cross(h[1], h[2])) > _SAME:
        return None
    # the point nearest to axes 4, 5 and 6 in the least-squares sense; they must pass through it
    A, b = np.zeros((3, 3)), np.zeros(3)
    for i in (3, 4, 5):
        across = np.eye(3) - np.outer(h[i], h[i])
        A += across
        b += across @ o[i]
    if np.linalg.cond(A) > 1e12:
        return None
    wrist = np.linalg.solve(A, b)
    off = max(float(np.linalg.norm(np.cross(h[i], wrist - o[i]))) for i in (3, 4, 5))
    wrist_regular = abs(float(h[3] @ h[4])) < _SAME and abs(float(h[4] @ h[5])) < _SAME
    if off > _SAME or not wrist_regular or np.linalg.norm(np.cross(h[0], h[1])) < 1e-3:
        return None
    return ArmAxes(h, o, np.asarray(wrist), foot_T_next @ cell.wrist_T_flange @ cell.flange_T_tool)
