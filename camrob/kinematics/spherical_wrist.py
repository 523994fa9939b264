"""Closed-form inverse of a six-axis arm with a spherical wrist and parallel second and third axes.

The arm is described by its screw axes at q = 0, so that any Denavit-Hartenberg habit fits, and solved by geometry
(the subproblems of Paden and Kahan): the first axis from the component along the second that axes 2 and 3 can't change,
the third from the wrist's distance to the second, then the second, then the three of the wrist. Eight branches.
The paper's eq. 4 to 9 are one of these branches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.arm_axes import arm_axes
from camrob.cell.cell import Cell
from camrob.compiled import inlined, kernel
from camrob.kinematics.subproblems import cone, dot, nearest_turn, rotate, triple, turn_between
from camrob.se3 import inverse

__all__ = [
    "BRANCH_OK",
    "BRANCH_OUT_OF_REACH",
    "SphericalArm",
    "joints_apart",
    "nearest_solution",
    "solve_arm",
    "solve_arm_many",
    "spherical_arm",
]

Array = NDArray[np.float64]

BRANCH_OK = 0
BRANCH_OUT_OF_REACH = 1  # the wrist's centre is too far, too near, or too close to the first axis
_WRIST_SINGULAR = 1e-9  # sine of the fifth axis's bend below which axes 4 and 6 are one


class SphericalArm(NamedTuple):
    """Screw axes of an arm at q = 0, seen from the frame that its first joint turns in (`foot`).

    h (6, 3) unit axes, o (6, 3) points on them, wrist (3,) where axes 4 to 6 meet; tool_T_foot: the inverse of the tool's
    pose at q = 0, so that the arm's displacement is foot_T_tool @ tool_T_foot.
    """

    h: Array
    o: Array
    wrist: Array
    tool_T_foot: Array


def spherical_arm(cell: Cell) -> SphericalArm | None:
    """The arm of a cell, tool included, or None where its geometry has no closed form (then a numeric arm is used).

    Closed form needs: axes 2 and 3 parallel, axes 4, 5 and 6 through one point, within 1e-9 m and rad.
    """
    axes = arm_axes(cell)
    if axes is None:
        return None
    tool_T_foot = inverse(np.asarray(axes.foot_T_tool))
    return SphericalArm(axes.h.copy(), axes.o.copy(), axes.wrist.copy(), np.ascontiguousarray(tool_T_foot))


@inlined
def _first_axis(arm: SphericalArm, target: Array, out: Array) -> bool:
    """The two angles of the first axis into out: the wrist's component along axes 2 and 3, which they can't change."""
    h, o = arm.h, arm.o
    h2 = h[1]
    along = dot(h[0], target)
    upper, foot = h2[0] * (arm.wrist[0] - o[1, 0]), h2[0] * (o[1, 0] - o[0, 0])
    for r in range(1, 3):
        upper += h2[r] * (arm.wrist[r] - o[1, r])
        foot += h2[r] * (o[1, r] - o[0, r])
    c = upper + foot - along * dot(h[0], h2)
    return bool(cone(dot(h2, target) - along * dot(h[0], h2), -triple(h2, h[0], target), c, out))


@inlined
def _elbow(h3: Array, a: Array, b: Array, v: Array, out: Array) -> bool:
    """The two angles of the third axis into out: the wrist's distance from the second axis's point. a, b: fore and upper arm."""
    a_h, b_h = dot(h3, a), dot(h3, b)
    c = 0.5 * (dot(v, v) - dot(a, a) - dot(b, b)) - a_h * b_h
    return bool(cone(dot(b, a) - a_h * b_h, triple(b, h3, a), c, out))


@inlined
def _wrist_rotation(h: Array, M: Array, c1: float, s1: float, q23: float, w: Array, W: Array) -> None:
    """W <- the rotation that is left to the wrist, (R1 R2 R3)^T M; w (3,) is scratch."""
    c23, s23 = np.cos(q23), np.sin(q23)
    for col in range(3):
        for r in range(3):
            w[r] = M[r, col]
        rotate(h[0], c1, -s1, w, w)
        rotate(h[1], c23, -s23, w, w)
        for r in range(3):
            W[r, col] = w[r]


@inlined
def _wrist(h: Array, W: Array, near: Array, scratch: Array, Q: Array, k: int, only: int) -> int:
    """Rows k and k + 1 of Q, columns 3 to 5 <- the wrist's two ways to turn by W; how many there are. scratch: (4, 3), its last
    row <- the two bends. only: the branch that is wanted, -1 for all.
    """
    w, d, y, bend = scratch[0], scratch[1], scratch[2], scratch[3]
    for r in range(3):
        w[r] = W[r, 0] * h[5, 0] + W[r, 1] * h[5, 1] + W[r, 2] * h[5, 2]
    along5 = dot(h[4], h[5]) * dot(h[3], h[4])
    along4 = dot(h[3], w)
    c = min(1.0, max(-1.0, along4)) - along5
    if not cone(dot(h[3], h[5]) - along5, triple(h[3], h[4], h[5]), c, bend):
        return 0
    for i in range(2):
        if only >= 0 and only != k + i:
            continue
        c5, s5 = np.cos(bend[i]), np.sin(bend[i])
        rotate(h[4], c5, s5, h[5], d)
        if 1.0 - along4 * along4 < _WRIST_SINGULAR * _WRIST_SINGULAR:
            q4 = near[3]
        else:
            q4 = turn_between(h[3], d, w)
        # sixth: what takes a vector across it to where W asks for it
        for r in range(3):
            y[r] = W[r, 0] * h[4, 0] + W[r, 1] * h[4, 1] + W[r, 2] * h[4, 2]
        rotate(h[3], np.cos(q4), -np.sin(q4), y, y)
        rotate(h[4], c5, -s5, y, y)
        Q[k + i, 3] = nearest_turn(q4, near[3])
        Q[k + i, 4] = nearest_turn(bend[i], near[4])
        Q[k + i, 5] = nearest_turn(turn_between(h[5], h[4], y), near[5])
    return 2


@inlined
def _between(two: Array) -> float:
    """How far two angles are apart, the shorter way round."""
    return float(abs(nearest_turn(two[0] - two[1], 0.0)))


@inlined
def solve_arm(
    arm: SphericalArm,
    R: Array,
    p: Array,
    near: Array,
    Q: Array,
    why: NDArray[np.int64],
    only: int = -1,
    apart: Array | None = None,
) -> int:
    """All branches of the arm whose tool stands at rotation R (3, 3) and position p (3,) in `foot`.

    Fills Q (8, 6), every angle on the turn nearest to `near` (6,), and why (8,): BRANCH_OK or BRANCH_OUT_OF_REACH. Branch
    index = 4 * (first axis) + 2 * (elbow) + (wrist). Where the wrist is singular the fourth angle stays at `near`'s.
    `only`: the one branch that is wanted, the others' rows of Q are then left alone; -1: all. apart (3,) <- how far first, third
    and fifth axis, by one of which every other branch differs from that one, are apart, rad. Returns the number of branches
    that exist where all are wanted.
    """
    h, o, room = arm.h, arm.o, np.empty((17, 3))  # one allocation: a dozen would take longer than the arithmetic
    M, W, scratch = room[0:3], room[3:6], room[6:10]
    target, a, b, v, y, first, elbow = room[10], room[11], room[12], room[13], room[14], room[15], room[16]
    for r in range(3):
        for c in range(3):
            M[r, c] = (
                R[r, 0] * arm.tool_T_foot[0, c] + R[r, 1] * arm.tool_T_foot[1, c] + R[r, 2] * arm.tool_T_foot[2, c]
            )
    for r in range(3):
        target[r], a[r], b[r] = p[r] - o[0, r], arm.wrist[r] - o[2, r], o[2, r] - o[1, r]
        for c in range(3):
            target[r] += R[r, c] * arm.tool_T_foot[c, 3] + M[r, c] * arm.wrist[c]
    why[:] = BRANCH_OUT_OF_REACH
    if not _first_axis(arm, target, first):
        return 0
    if apart is not None:
        apart[0] = _between(first)
    count = 0
    side = 1.0 if dot(h[2], h[1]) > 0.0 else -1.0
    for i1 in range(2):
        if only >= 0 and only // 4 != i1:
            continue
        c1, s1 = np.cos(first[i1]), np.sin(first[i1])
        rotate(h[0], c1, -s1, target, v)
        for r in range(3):
            v[r] += o[0, r] - o[1, r]
        if not _elbow(h[2], a, b, v, elbow):
            continue
        if apart is not None:
            apart[1] = _between(elbow)
        for i3 in range(2):
            if only >= 0 and only // 2 != 2 * i1 + i3:
                continue
            rotate(h[2], np.cos(elbow[i3]), np.sin(elbow[i3]), a, y)
            for r in range(3):
                y[r] += b[r]
            q2 = turn_between(h[1], y, v)
            _wrist_rotation(h, M, c1, s1, q2 + side * elbow[i3], scratch[0], W)
            k = 4 * i1 + 2 * i3
            found = _wrist(h, W, near, scratch, Q, k, only)
            if apart is not None:
                apart[2] = _between(scratch[3])
            for j in range(k, k + found):
                Q[j, 0] = nearest_turn(first[i1], near[0])
                Q[j, 1] = nearest_turn(q2, near[1])
                Q[j, 2] = nearest_turn(elbow[i3], near[2])
                why[j] = BRANCH_OK
            count += found
    return count


@inlined
def joints_apart(q: Array, near: Array) -> float:
    """How far the joint lies that is the farthest from where it is in `near` (6,)."""
    far = 0.0
    for i in range(6):
        far = max(far, abs(q[i] - near[i]))
    return far


@inlined
def nearest_solution(Q: Array, why: NDArray[np.int64], near: Array) -> tuple[int, float]:
    """Which of `solve_arm`'s branches moves its farthest joint least from `near` (6,), and by how much; -1, inf where none is."""
    best, nearest = -1, np.inf
    for b in range(8):
        if why[b] == BRANCH_OK:
            far = joints_apart(Q[b], near)
            if far < nearest:
                best, nearest = b, far
    return best, nearest


@kernel(nogil=True)
def solve_arm_many(arm: SphericalArm, foot_T_tool: Array, near: Array) -> tuple[Array, NDArray[np.int64]]:
    """`solve_arm` for poses (N, 4, 4) and postures `near` (N, 6): branches (N, 8, 6) and their states (N, 8)."""
    N = foot_T_tool.shape[0]
    Q = np.zeros((N, 8, 6))
    why = np.empty((N, 8), np.int64)
    for k in range(N):
        solve_arm(arm, foot_T_tool[k, :3, :3], foot_T_tool[k, :3, 3], near[k], Q[k], why[k])
    return Q, why
