"""A cell's chain as links joined by joints, for programs that want it so (URDF, pytorch-kinematics), and where in `world` its
part that stands on the floor begins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.frozen import locked
from camrob.se3 import inverse, rotation_exp

__all__ = ["Segment", "segments", "world_T_floor"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Segment:
    """A link and the joint that carries it; the joint moves along or about its own z.

    `joint` is None where the link is fixed. parent_T_joint: (4, 4), the joint's frame at q = 0 seen from the parent
    link, which is the link of the segment before (`base` for the first).
    """

    link: str
    joint: Joint | None
    parent_T_joint: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "parent_T_joint", locked(self.parent_T_joint, shape=(4, 4), name="parent_T_joint"))


def segments(cell: Cell) -> tuple[Segment, ...]:
    """The chain base -> tool: a link `NAME_link` behind every joint, and the fixed links `root`, `flange` and `tool`.

    A joint's link frame stands behind the joint's motion and before the constant rest of its Denavit-Hartenberg row.
    """
    out: list[Segment] = []
    arm = cell.indices(Role.ARM)
    link_T_next = np.asarray(cell.base_T_first)
    for i, joint in enumerate(cell.joints):
        if i == arm[0]:
            out.append(Segment("root", None, link_T_next @ cell.foot_T_root))
            link_T_next = inverse(cell.foot_T_root)
        out.append(Segment(f"{joint.name}_link", joint, link_T_next @ joint.before))
        link_T_next = joint.after
        if i == arm[-1]:
            out.append(Segment("flange", None, link_T_next @ cell.wrist_T_flange))
            link_T_next = cell.flange_T_tool
    out.append(Segment("tool", None, link_T_next))
    return tuple(out)


def world_T_floor(cell: Cell) -> NDArray[np.float64]:
    """The frame (4, 4) that the last workpiece joint ends in, seen from `world`, which is `base` with these axes at
    0.
    """
    world_T_next = np.asarray(cell.base_T_first)  # frames: world is base
    for i in cell.indices(Role.WORKPIECE):
        joint = cell.joints[i]
        q = float(joint.q_value(np.zeros(())))
        M = np.eye(4)
        if joint.prismatic:
            M[2, 3] = q
        else:
            M[:3, :3] = rotation_exp([0.0, 0.0, q])
        world_T_next = world_T_next @ joint.before @ M @ joint.after
    return np.asarray(world_T_next)
