"""A solution: the posture at every point of a path, which can be re-checked without the solver."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import StaleInputError
from camrob.findings import Finding
from camrob.frozen import locked
from camrob.kinematics.frames import tool_poses
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import PlanReport
from camrob.se3 import inverse, rotation_log

__all__ = ["ALL_TOUCH", "Lead", "Revision", "Solution"]

Array = NDArray[np.float64]

ALL_TOUCH = "all-postures-touch"
"""The code of the finding that at a point every posture that was looked at touches something; `count` of them."""
_CHUNK = 16_384  # postures that are worked on at once: bounds the memory


@dataclass(frozen=True, slots=True)
class Revision:
    """A posture revision before a region, made at the safe path point `point` with the cutter's pose held.

    q: (K, n) postures to move through: the one that the point is reached in, then one a move (table first, then track);
    the last one is the solution's own at the point. (0, n) where the revision was not kept. inv_kf_before and _after: 1/k_F at
    the region's first point without and with it (equal where it was not kept); `reason` says why it was not. `by_axes`: the
    moves are PTP by axis values (another branch or turn), and the pose is held at their ends only.
    """

    region: int
    point: int
    q: Array
    kept: bool
    inv_kf_before: float
    inv_kf_after: float
    reason: str = ""
    by_axes: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", locked(self.q, shape=(None, None), name="q"))


@dataclass(frozen=True, slots=True)
class Lead:
    """Postures (K, n) by which PTP goes from HOME, or from where tools are changed, to a stretch's first point (`into`), and from
    its last one there (`out`); none where it goes straight.
    """

    into: Array
    out: Array

    def __post_init__(self) -> None:
        for name in ("into", "out"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(None, None), name=name))

    @classmethod
    def straight(cls, axes: int) -> Lead:
        """Straight both ways, of a cell of so many axes."""
        none = np.zeros((0, axes))
        return cls(none, none)


@dataclass(frozen=True, slots=True)
class Solution:
    """Postures q (N, n), SI in the chain's order, of a path of N points, with 1/k_F (N,) of the bare arm.

    `cell_digest` and `path_digest` name what it was made from. `method` is "vjm" or "planned". `plan` says how a planned one was
    chosen; `path` is the path that it belongs to where the planner had to put retracts into the one that it was given. `leads`:
    one a stretch, or none where all go straight.
    """

    method: str
    q: Array
    inv_kf: Array
    cell_digest: str
    path_digest: str
    revisions: tuple[Revision, ...] = ()
    findings: tuple[Finding, ...] = field(default=())
    plan: PlanReport | None = None
    path: ToolPathInBase | None = None
    leads: tuple[Lead, ...] = ()

    def __post_init__(self) -> None:
        q = locked(self.q, shape=(None, None), name="q")
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "inv_kf", locked(self.inv_kf, shape=(len(q),), name="inv_kf"))

    def __len__(self) -> int:
        return len(self.q)

    def residual(self, cell: Cell, path: ToolPathInBase) -> tuple[Array, Array]:
        """Position errors (N,), m, and tool-axis errors (N,), rad, by forward kinematics in plain NumPy alone.

        Raises StaleInputError where cell or path are not those that the solution was made from.
        """
        if self.cell_digest != cell.digest or self.path_digest != path.digest:
            raise StaleInputError("the solution was made from another cell or path; resolve it again")
        position, axis = np.empty(len(self)), np.empty(len(self))
        for start in range(0, len(self), _CHUNK):
            part = slice(start, start + _CHUNK)
            base_T_tool = tool_poses(cell, self.q[part])
            tip_T_tool = inverse(np.asarray(path.base_T_tip[part])) @ base_T_tool
            position[part] = np.linalg.norm(tip_T_tool[:, :3, 3], axis=1)
            axis[part] = np.linalg.norm(rotation_log(tip_T_tool[:, :3, :3]), axis=1)
        return position, axis
