"""The arm alone: poses of the tool seen from the robot's foot to its six axes, closed form where the geometry allows.

`Arm` hides which of three is used: the eight branches of an arm whose shoulder and wrist are a machine tool builder's
(`spherical_wrist`), those of the families of `screw_arm`, or Newton's method from many starts for any other six axes.
Angles are the chain's q.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import kernel, part
from camrob.kinematics.frames import base_T_root
from camrob.kinematics.kernels import ChainArrays, chain_arrays, forward, jacobian
from camrob.kinematics.screw_arm import OFFSET, ScrewArm, solve_screws, solve_screws_many
from camrob.kinematics.screw_families import screw_arm
from camrob.kinematics.spherical_wrist import (
    BRANCH_OK,
    SphericalArm,
    joints_apart,
    nearest_solution,
    solve_arm,
    solve_arm_many,
    spherical_arm,
)
from camrob.kinematics.subproblems import nearest_turn
from camrob.se3 import inverse

__all__ = [
    "FOLLOWED",
    "FOLLOW_JUMP",
    "FOLLOW_LIMIT",
    "FOLLOW_UNREACHED",
    "NO_SPHERE",
    "STARTS",
    "Arm",
    "by_newton",
    "nearest_branch",
    "newton_arm",
    "reach",
    "to_nearest_branch",
]

Array = NDArray[np.float64]

NO_SPHERE = SphericalArm(np.zeros((6, 3)), np.zeros((6, 3)), np.zeros(3), np.eye(4))
"""Stands where an arm has no spherical wrist."""
FOLLOWED = 0
FOLLOW_UNREACHED = 1
FOLLOW_LIMIT = 2
FOLLOW_JUMP = 3
STARTS = 96
"""Of Newton's method, for the branches of an arm without closed form."""


@dataclass(frozen=True)
class Arm:
    """A cell's arm. `closed`: the closed form of a spherical wrist, else None; `screws`: another one, where that is None and
    there is one; `chain` is the arm alone, foot to tool without roll.
    """

    cell: Cell
    closed: SphericalArm | None
    chain: ChainArrays
    lower: Array
    upper: Array
    screws: ScrewArm | None = None

    @classmethod
    def of(cls, cell: Cell) -> Arm:
        """The arm of a cell with its tool."""
        joints = tuple(j for j in cell.joints if j.role is Role.ARM)
        whole = chain_arrays(cell)
        after = whole.after[whole.arm_start : whole.arm_stop].copy()
        rolls = cell.indices(Role.ROLL)
        if rolls:  # the roll's own constant part stands before its motion, and counts as tool
            after[-1] = after[-1] @ cell.joints[rolls[0]].after
        chain = ChainArrays(joints[0].before.copy(), after, np.zeros(6, np.bool_), whole.plate, 0, 6, *whole[6:])
        part = cell.arm_slice
        closed = spherical_arm(cell)
        screws = None if closed is not None else _screws(chain)
        return cls(cell, closed, chain, cell.q_lower[part].copy(), cell.q_upper[part].copy(), screws)

    def foot_T_tool(self, base_T_tool: Array, q: Array) -> Array:
        """Poses (..., 4, 4) of the tool, roll taken off, seen from the foot, of its poses in `base` and postures (..., n).

        Only the external axes and the roll of q matter.
        """
        base_T_foot = base_T_root(self.cell, q) @ inverse(np.asarray(self.cell.foot_T_root))
        rolls = self.cell.indices(Role.ROLL)
        if rolls:
            roll = q[..., rolls[0]]
            tool_T_unrolled = np.zeros((*roll.shape, 4, 4))
            tool_T_unrolled[..., 0, 0] = tool_T_unrolled[..., 1, 1] = np.cos(roll)
            tool_T_unrolled[..., 0, 1] = np.sin(roll)
            tool_T_unrolled[..., 1, 0] = -np.sin(roll)
            tool_T_unrolled[..., 2, 2] = tool_T_unrolled[..., 3, 3] = 1.0
            base_T_tool = base_T_tool @ tool_T_unrolled  # frames: tool is unrolled
        return np.asarray(inverse(base_T_foot) @ base_T_tool)

    def branches(self, foot_T_tool: Array, near: Array) -> list[Array]:
        """All postures (6,) within limits that put the tool at one pose, each on the turn nearest to `near`.

        Empty where the pose is out of reach or every branch passes a limit (`turned` tells which).
        """
        found = self.turned(foot_T_tool, near)
        return [np.clip(q, self.lower, self.upper) for q in found if not self.passed(q)]

    def turned(self, foot_T_tool: Array, near: Array) -> list[Array]:
        """All postures (6,) that put the tool at one pose, each on the turn nearest to `near`, or on one within the limits."""
        return [_fit_turns(q, self.lower, self.upper) for q in self._solutions(foot_T_tool, near)]

    def passed(self, q: Array) -> str:
        """Which limit a posture (6,) passes, the first in the chain; "" for none."""
        beyond = np.flatnonzero((q < self.lower - 1e-9) | (q > self.upper + 1e-9))
        return f"at A{beyond[0] + 1}'s limit" if len(beyond) else ""

    def reasons(self, foot_T_tool: Array, near: Array) -> dict[str, int]:
        """Why branches of a pose are no good: reason to count."""
        met = [self.passed(q) for q in self.turned(foot_T_tool, near)] or ["out of reach"] * self.together
        return dict(Counter(filter(None, met)))

    @property
    def together(self) -> int:
        """How many postures a pose has at the most, counted together where it is out of reach."""
        return 1 if self.searched else 8

    @property
    def searched(self) -> bool:
        """Whether postures are searched for from many starts, for want of a closed form or a neighbour's."""
        return self.closed is None and self.screws is None

    @property
    def proves(self) -> bool:
        """Whether all postures of a pose are found for certain, so that none found is a proof that there is none."""
        return self.closed is not None or (self.screws is not None and self.screws.family != OFFSET)

    def _solutions(self, foot_T_tool: Array, near: Array) -> list[Array]:
        """Postures (6,) whatever the limits."""
        if self.closed is not None:
            one = np.array(foot_T_tool, float, order="C")[None]
            Q, why = solve_arm_many(self.closed, one, np.array(near, float)[None])
            return [Q[0, k] for k in range(8) if why[0, k] == BRANCH_OK]
        if self.screws is not None:
            one = np.array(foot_T_tool, float, order="C")[None]
            Q, why = solve_screws_many(self.screws, one, np.array(near, float)[None])
            return [Q[0, k] for k in range(8) if why[0, k] == BRANCH_OK]
        R, p = np.ascontiguousarray(foot_T_tool[:3, :3]), np.ascontiguousarray(foot_T_tool[:3, 3])
        starts = _low_discrepancy(STARTS, self.lower, self.upper)
        starts[0] = near
        found: list[Array] = []
        for start in starts:
            q = start.copy()
            if by_newton(self.chain, R, p, q):
                q = q + 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi))
                if all(np.max(np.abs(q - other)) > 1e-6 for other in found):
                    found.append(q)
        return found

    def kernel(self) -> tuple[SphericalArm, ChainArrays | None]:
        """What `nearest_branch` needs: the closed form and None, or an empty one and the chain."""
        if self.closed is not None:
            return self.closed, None
        return NO_SPHERE, self.chain

    def follow(self, foot_T_tool: Array, start: Array, *, step: float) -> tuple[Array, int, int]:
        """Follow poses (K, 4, 4) from posture `start` (6,) on its branch and turn: (postures (K, 6), code, number followed).

        code is FOLLOWED, or why the pose after the last one followed failed: out of reach, a limit, or a joint that would
        have to move more than `step` rad between neighbours.
        """
        poses = np.array(foot_T_tool, float, order="C")  # a copy: frozen arrays would be compiled for separately
        Q, code, count = _follow(*self.kernel(), poses, np.array(start, float), self.lower, self.upper, step)
        return Q, int(code), int(count)


def _screws(chain: ChainArrays) -> ScrewArm | None:
    """The closed form of an arm of six turning axes by its screw axes, where it has one."""
    if len(chain.after) != 6 or np.any(chain.prismatic):
        return None
    Z, P, R, p, plate = np.empty((6, 3)), np.empty((6, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    _stand(chain, np.zeros(6), Z, P, R, p, plate)
    foot_T_tool = np.eye(4)
    foot_T_tool[:3, :3], foot_T_tool[:3, 3] = R, p
    return screw_arm(Z, P, foot_T_tool)


@kernel
def _stand(chain: ChainArrays, q: Array, Z: Array, P: Array, R: Array, p: Array, plate: Array) -> None:
    """`forward`, for Python."""
    forward(chain, q, Z, P, R, p, plate)


@part
def reach(
    arm: SphericalArm,
    screws: ScrewArm | None,
    R: Array,
    p: Array,
    near: Array,
    Q: Array,
    why: NDArray[np.int64],
    only: int = -1,
) -> int:
    """All postures by the one closed form or the other: `solve_arm`, or where `screws` is not None `solve_screws`.

    `only`: the one branch that is wanted, which alone `why` is then to be asked for; -1: all.
    """
    if screws is None:
        return int(solve_arm(arm, R, p, near, Q, why, only))
    return int(solve_screws(screws, R, p, near, Q, why, only))


def _fit_turns(q: Array, lower: Array, upper: Array) -> Array:
    """Every angle moved by whole turns into its range, where one fits; else unchanged."""
    out = np.array(q)
    for i in range(len(out)):
        while out[i] < lower[i] and out[i] + 2.0 * np.pi <= upper[i]:
            out[i] += 2.0 * np.pi
        while out[i] > upper[i] and out[i] - 2.0 * np.pi >= lower[i]:
            out[i] -= 2.0 * np.pi
    return out


def _low_discrepancy(count: int, lower: Array, upper: Array) -> Array:
    """Evenly spread, always the same starts (count, 6) within limits (an additive recurrence)."""
    golden = 1.1127756842787055  # the root of x^7 = x + 1, the golden ratio's counterpart in six dimensions
    alpha = np.array([1.0 / golden ** (k + 1) for k in range(6)])
    u = (0.5 + np.arange(1, count + 1)[:, None] * alpha) % 1.0
    span = np.minimum(upper, np.pi) - np.maximum(lower, -np.pi)
    return np.asarray(np.maximum(lower, -np.pi) + u * span)


@part
def newton_arm(chain: ChainArrays, R_target: Array, p_target: Array, q: Array) -> bool:
    """Move q (6,) to the pose by damped Newton steps; True where it is met within 1e-11 m and rad."""
    Z, P = np.empty((6, 3)), np.empty((6, 3))
    R, p, plate, J = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((6, 6))
    error = np.empty(6)
    for _iteration in range(60):
        forward(chain, q, Z, P, R, p, plate)
        for r in range(3):
            error[r] = (p_target[r] - p[r]) / chain.length
        vx = vy = vz = trace = 0.0
        for c in range(3):
            vx += 0.5 * (R[1, c] * R_target[2, c] - R[2, c] * R_target[1, c])
            vy += 0.5 * (R[2, c] * R_target[0, c] - R[0, c] * R_target[2, c])
            vz += 0.5 * (R[0, c] * R_target[1, c] - R[1, c] * R_target[0, c])
            trace += R[0, c] * R_target[0, c] + R[1, c] * R_target[1, c] + R[2, c] * R_target[2, c]
        sine = np.sqrt(vx * vx + vy * vy + vz * vz)
        k = np.arctan2(sine, 0.5 * (trace - 1.0)) / sine if sine > 1e-9 else 1.0
        error[3], error[4], error[5] = k * vx, k * vy, k * vz
        worst = np.max(np.abs(error))
        if worst < 1e-11:
            return True
        jacobian(chain, Z, P, p, J)
        for i in range(6):
            for r in range(3):
                J[r, i] /= chain.length
        H = J.T @ J
        damping = min(1e-2, worst * worst) * 1e-1 + 1e-14
        for i in range(6):
            H[i, i] += damping
        step = np.linalg.solve(H, J.T @ error)
        largest = np.max(np.abs(step))
        q += step * min(1.0, 0.5 / largest) if largest > 0.0 else step
    return False


@kernel
def by_newton(chain: ChainArrays, R_target: Array, p_target: Array, q: Array) -> bool:
    """`newton_arm`, for Python."""
    return bool(newton_arm(chain, R_target, p_target, q))


@part
def nearest_branch(
    arm: SphericalArm,
    chain: ChainArrays | None,
    R: Array,
    p: Array,
    near: Array,
    Q: Array,
    why: NDArray[np.int64],
    last: NDArray[np.int64],
    apart: Array,
) -> float:
    """Move `near` (6,) to the branch and turn nearest to it that puts the tool at R (3, 3), p (3,), seen from the foot.

    By the arm's closed form, or where `chain` is not None by Newton's method: code that the arm has no use for isn't compiled.
    Returns the farthest that a joint moved, -1 where no branch exists (`near` is then left alone). Q (8, 6), why (8,) and
    apart (3,) are scratch. last (1,): the branch that was taken, -1 for none; it alone is worked out first, and is the nearest
    where every other is more than twice as far from it as `near` is.
    """
    best, nearest = last[0], np.inf
    if chain is None:
        sure = False
        while not sure:
            solve_arm(arm, R, p, near, Q, why, best, apart)
            if best >= 0:
                nearest = joints_apart(Q[best], near) if why[best] == BRANCH_OK else np.inf
                sure = 2.0 * nearest < min(apart[0], min(apart[1], apart[2]))
                best = best if sure else -1
            else:
                best, nearest = nearest_solution(Q, why, near)
                sure = True
        if best < 0:
            return -1.0
    else:
        for i in range(6):
            Q[0, i] = near[i]
        if not newton_arm(chain, R, p, Q[0]):
            return -1.0
        best = 0
        for i in range(6):
            Q[0, i] = nearest_turn(Q[0, i], near[i])
        nearest = joints_apart(Q[0], near)
    last[0] = best
    for i in range(6):
        near[i] = Q[best, i]
    return float(nearest)


@kernel
def to_nearest_branch(
    arm: SphericalArm, chain: ChainArrays | None, R: Array, p: Array, near: Array, Q: Array, why: NDArray[np.int64]
) -> float:
    """`nearest_branch`, for Python."""
    return float(nearest_branch(arm, chain, R, p, near, Q, why, np.full(1, -1), np.empty(3)))


@part
def _within(q: Array, lower: Array, upper: Array) -> bool:
    for i in range(6):
        if q[i] < lower[i] - 1e-9 or q[i] > upper[i] + 1e-9:
            return False
    return True


@kernel(nogil=True)
def _follow(
    arm: SphericalArm,
    chain: ChainArrays | None,
    poses: Array,
    start: Array,
    lower: Array,
    upper: Array,
    step: float,
) -> tuple[Array, int, int]:
    K = poses.shape[0]
    out = np.empty((K, 6))
    near = start.copy()
    Q, why = np.empty((8, 6)), np.empty(8, np.int64)
    last, apart = np.full(1, -1), np.empty(3)
    for k in range(K):
        moved = nearest_branch(arm, chain, poses[k, :3, :3], poses[k, :3, 3], near, Q, why, last, apart)
        if moved < 0.0:
            return out, FOLLOW_UNREACHED, k
        if moved > step:
            return out, FOLLOW_JUMP, k
        if not _within(near, lower, upper):
            return out, FOLLOW_LIMIT, k
        for i in range(6):
            out[k, i] = near[i]
    return out, FOLLOWED, K
