"""The freedoms of a pose, compiled: from external axes, roll and branch to the arm's posture and its conditioning.

A posture at a given pose of the tool is named by u (F,), the values of the joints that are not the arm's (workpiece and
carriage axes, then the virtual roll, in the chain's order), by one of the arm's eight branches, and by whole turns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import kernel, part
from camrob.errors import CellError
from camrob.frame_steps import compose, move_joint
from camrob.kinematics.arm import NO_SPHERE, Arm, reach
from camrob.kinematics.kernels import ChainArrays, forward, inverse_kf
from camrob.kinematics.screw_arm import ScrewArm
from camrob.kinematics.spherical_wrist import BRANCH_OK, SphericalArm

__all__ = ["PlanSpace", "PlanWork", "conditioning", "plan_space", "plan_work", "pose_in_foot", "posture"]

Array = NDArray[np.float64]


class PlanSpace(NamedTuple):
    """The cell as the planner's kernels need it.

    first (4, 4), after (E, 4, 4), prismatic (E,): the chain to the arm's foot. roll: 1 where the last of u is the roll.
    alike: how many neighbouring branches share 1/k_F (the two of a spherical wrist). arm, screws, chain: the arm alone, its
    closed form (one of the two) and its chain. lower, upper, center (6,): its limits. u_lower, u_upper (F,);
    u_endless (F,). free (F,): where u stands in the chain's q.
    """

    first: Array
    after: Array
    prismatic: NDArray[np.bool_]
    roll: int
    alike: int
    arm: SphericalArm
    screws: ScrewArm | None
    chain: ChainArrays
    lower: Array
    upper: Array
    center: Array
    u_lower: Array
    u_upper: Array
    u_endless: NDArray[np.bool_]
    free: NDArray[np.int64]


class PlanWork(NamedTuple):
    """Arrays of the inner loops."""

    R: Array
    p: Array
    Rt: Array
    pt: Array
    Q: Array
    why: NDArray[np.int64]
    Z: Array
    P: Array
    plate: Array


def plan_space(cell: Cell) -> PlanSpace:
    """The planner's view of a cell. Raises CellError where the arm has no closed form."""
    arm = Arm.of(cell)
    if arm.searched:
        what = f"cell {cell.name}: a plan needs all postures of a pose, and this arm's geometry has no closed form for them"
        raise CellError(what, hint="use --method vjm")
    joints = cell.joints
    start = cell.indices(Role.ARM)[0]
    first = np.array(cell.base_T_first)
    after = np.empty((start, 4, 4))
    for i in range(start):
        if i == 0:
            first = first @ joints[0].before
        after[i] = joints[i].after if i + 1 == start else joints[i].after @ joints[i + 1].before
    free = np.array([i for i, j in enumerate(joints) if j.role is not Role.ARM], np.int64)
    lower, upper = arm.lower, arm.upper
    center = np.where(np.isfinite(lower) & np.isfinite(upper), 0.5 * (lower + upper), 0.0)
    return PlanSpace(
        np.ascontiguousarray(first),
        after,
        np.array([j.prismatic for j in joints[:start]], np.bool_),
        len(cell.indices(Role.ROLL)),
        1 if arm.closed is None else 2,
        NO_SPHERE if arm.closed is None else arm.closed,
        arm.screws,
        arm.chain,
        lower,
        upper,
        center,
        cell.q_lower[free],
        cell.q_upper[free],
        cell.endless[free],
        free,
    )


@kernel
def plan_work() -> PlanWork:
    """Arrays for one thread."""
    return PlanWork(
        np.empty((3, 3)),
        np.empty(3),
        np.empty((3, 3)),
        np.empty(3),
        np.zeros((8, 6)),
        np.empty(8, np.int64),
        np.empty((6, 3)),
        np.empty((6, 3)),
        np.empty(3),
    )


@part
def _place_foot(space: PlanSpace, u: Array, R: Array, p: Array) -> None:
    """R, p <- pose of the arm's foot in `base`."""
    for r in range(3):
        p[r] = space.first[r, 3]
        for c in range(3):
            R[r, c] = space.first[r, c]
    for i in range(space.after.shape[0]):
        move_joint(R, p, space.prismatic[i], u[i])
        compose(R, p, space.after[i])


@part
def pose_in_foot(space: PlanSpace, base_T_tip: Array, u: Array, work: PlanWork) -> None:
    """work.Rt, work.pt <- the tool, roll taken off, seen from the foot."""
    _place_foot(space, u, work.R, work.p)
    co, si = 1.0, 0.0
    if space.roll == 1:
        co, si = np.cos(u[u.shape[0] - 1]), np.sin(u[u.shape[0] - 1])
    for r in range(3):
        x = y = z = d = 0.0
        for k in range(3):
            f = work.R[k, r]
            x += f * base_T_tip[k, 0]
            y += f * base_T_tip[k, 1]
            z += f * base_T_tip[k, 2]
            d += f * (base_T_tip[k, 3] - work.p[k])
        work.Rt[r, 0] = x * co - y * si
        work.Rt[r, 1] = x * si + y * co
        work.Rt[r, 2] = z
        work.pt[r] = d


@part
def posture(space: PlanSpace, base_T_tip: Array, u: Array, branch: int, near: Array, q: Array, work: PlanWork) -> bool:
    """q (6,) <- the arm's posture at a pose (4, 4) with freedoms u on a branch, turns nearest to `near`; False out of reach."""
    pose_in_foot(space, base_T_tip, u, work)
    reach(space.arm, space.screws, work.Rt, work.pt, near, work.Q, work.why, branch)
    if work.why[branch] != BRANCH_OK:
        return False
    for i in range(6):
        q[i] = work.Q[branch, i]
    return True


@kernel
def conditioning(space: PlanSpace, q: Array, work: PlanWork) -> float:
    """1/k_F of the arm in posture q (6,)."""
    forward(space.chain, q, work.Z, work.P, work.R, work.p, work.plate)
    return float(inverse_kf(space.chain, work.Z, work.P, work.plate))
