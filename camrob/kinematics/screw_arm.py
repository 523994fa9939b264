"""Closed-form inverses of six-axis arms beyond `spherical_wrist`: all postures, from the arm's screw axes alone.

Three families, each also read from the tool back to the foot (the screws in reverse order, their senses turned round):

    wrist       the last three axes meet in a point, whatever the first three are: the point's place gives the first three (a
                quadratic in cosine and sine of the third angle, Pieper 1968; where the first two axes meet or are parallel it
                falls apart into cones), the rotation left over the last three. Read backwards: an arm whose first three meet.
    parallel    axes 2, 3 and 4 are parallel (Universal Robots): what they can't change, the component along them of a point of
                the sixth axis and of its direction, gives the first and the fifth, then the sixth, then a planar arm of three.
    offset      axes 4 and 5 meet, and the sixth lies anywhere: one equation in the sixth angle, searched (`offset_wrist`).

Rows are branches: each posture stands where it stood a little before along a path. The two angles of a cone keep their order;
the four of a quartic are told apart by `lasting_angles`, provably but for which of two of one kind is which, where an arm is
cuspidal (Wenger 2007: it goes from one posture of a pose to another without passing a singular one).

Elias and Wen (IK-Geo, 2022) and Ostermeier and others (EAIK, 2025) decompose arms alike. Each posture is mended by Newton's
method on the screws and has to meet the pose; up to eight, sixteen rows are kept for arms that are searched.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.kinematics.offset_wrist import by_offset
from camrob.kinematics.screw_motion import polish, put_back
from camrob.kinematics.spherical_wrist import BRANCH_OK, BRANCH_OUT_OF_REACH
from camrob.kinematics.subproblems import cone, dot, nearest_turn, rotate, triple, turn_between
from camrob.kinematics.three_axes import closest, first_three
from camrob.kinematics.trig_quartic import lasting_angles, square_onto

__all__ = ["OFFSET", "PARALLEL", "WRIST", "ScrewArm", "solve_screws", "solve_screws_many"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

WRIST, PARALLEL, OFFSET = 1, 2, 3  # families, by a number that compiled code can compare
_NONE = 1e-9  # of the lengths that it is a product of, within which a determinant is none
_SINGULAR = 1e-9  # sine below which two axes are one
_SAME = 1e-7  # rad within which two postures are one
_FAR = 0.3  # rad that keep two apart which Newton's method has yet to mend


class ScrewArm(NamedTuple):
    """An arm's screw axes at q = 0 in its foot: h (6, 3), o (6, 3), in the order that the family wants (`mirrored`: from the tool
    back, senses turned round). tool_T_foot: the inverse of the tool's pose at q = 0. true_h, true_o: the axes that a posture has
    to meet the pose with, where they are not quite h and o (a calibrated arm, whose postures continue those of the nominal one).
    """

    family: int
    mirrored: bool
    h: Array
    o: Array
    true_h: Array
    true_o: Array
    tool_T_foot: Array


@part
def _place(h: Array, o: Array, i: int, angle: float, x: Array) -> None:
    """Turn the point x about axis i."""
    for r in range(3):
        x[r] -= o[i, r]
    rotate(h[i], np.cos(angle), np.sin(angle), x, x)
    for r in range(3):
        x[r] += o[i, r]


@part
def _last_three(h: Array, W: Array, near: Array, out: Array) -> int:
    """out (2, 3) <- the angles about axes 4 to 6 that turn by W (3, 3); how many there are."""
    w, d, y, bend = np.empty(3), np.empty(3), np.empty(3), np.empty(2)
    for r in range(3):
        w[r] = W[r, 0] * h[5, 0] + W[r, 1] * h[5, 1] + W[r, 2] * h[5, 2]
    base = dot(h[4], h[5]) * dot(h[3], h[4])
    along = dot(h[3], w)
    if not cone(dot(h[3], h[5]) - base, triple(h[3], h[4], h[5]), along - base, bend):
        return 0
    for i in range(2):
        rotate(h[4], np.cos(bend[i]), np.sin(bend[i]), h[5], d)
        q4 = near[3] if 1.0 - along * along < _SINGULAR * _SINGULAR else turn_between(h[3], d, w)
        for r in range(3):
            y[r] = W[r, 0] * h[4, 0] + W[r, 1] * h[4, 1] + W[r, 2] * h[4, 2]
        rotate(h[3], np.cos(q4), -np.sin(q4), y, y)
        rotate(h[4], np.cos(bend[i]), -np.sin(bend[i]), y, y)
        out[i, 0], out[i, 1], out[i, 2] = q4, bend[i], turn_between(h[5], h[4], y)
    return 2


@part
def _by_wrist(h: Array, o: Array, M: Array, p: Array, near: Array, Q: Array, there: Ints) -> None:
    """Rows of Q (8, 6) <- postures of an arm whose last three axes meet, that displace by M, p; there (8,): 1 at those."""
    wrist, target = np.empty(3), np.empty(3)
    closest(h, o, 4, 5, wrist)
    for r in range(3):
        target[r] = p[r] + M[r, 0] * wrist[0] + M[r, 1] * wrist[1] + M[r, 2] * wrist[2]
    three, W, column, last = np.empty((4, 3)), np.empty((3, 3)), np.empty(3), np.empty((2, 3))
    some = np.empty(4, np.int64)
    first_three(h, o, wrist, target, three, some)
    for k in range(4):
        if not some[k]:
            continue
        for c in range(3):
            for r in range(3):
                column[r] = M[r, c]
            for i in range(3):
                rotate(h[i], np.cos(three[k, i]), -np.sin(three[k, i]), column, column)
            for r in range(3):
                W[r, c] = column[r]
        for i in range(_last_three(h, W, near, last)):
            there[2 * k + i] = 1
            for j in range(3):
                Q[2 * k + i, j], Q[2 * k + i, 3 + j] = three[k, j], last[i, j]


@part
def _first_and_fifth(h: Array, o: Array, M: Array, p: Array, out: Array, there: Ints) -> None:
    """out (4, 2) <- angles of axes 1 and 5 of an arm whose axes 2 to 4 are parallel; there (4,): 1 at the rows that are any."""
    x6, n = np.empty(3), h[1]
    closest(h, o, 5, 4, x6)
    y, u = np.empty(3), np.empty(3)  # the point of the sixth axis, and its direction, where they are to come to
    for r in range(3):
        y[r] = p[r] + M[r, 0] * x6[0] + M[r, 1] * x6[1] + M[r, 2] * x6[2] - o[0, r]
        u[r] = M[r, 0] * h[5, 0] + M[r, 1] * h[5, 1] + M[r, 2] * h[5, 2]
    a, arm = np.empty(3), np.empty(3)
    for r in range(3):
        a[r] = o[0, r]
        arm[r] = x6[r] - o[4, r]
    n1, n5 = dot(n, h[0]), dot(n, h[4])
    # n . R1^T y = y_0 + y_c cos + y_s sin, alike u; n . R5 arm, n . R5 h6 of the fifth angle
    y0, u0 = dot(h[0], y) * n1, dot(h[0], u) * n1
    yc, uc, ys, us = dot(n, y) - y0, dot(n, u) - u0, -triple(n, h[0], y), -triple(n, h[0], u)
    m0, d0 = dot(h[4], arm) * n5, dot(h[4], h[5]) * n5
    mc, dc, ms, ds = dot(n, arm) - m0, dot(n, h[5]) - d0, triple(n, h[4], arm), triple(n, h[4], h[5])
    rest = (
        dot(n, a) - dot(n, o[4]) - m0
    )  # y_0 + rest + y_c cos + .. = m_c cos + m_s sin, and u_0 - d_0 + .. = d_c cos + ..
    first, pair = np.zeros(4), np.empty(2)
    size = np.sqrt(mc * mc + ms * ms)
    for k in range(4):
        there[k] = 0
    determinant = mc * ds - ms * dc
    long = max(np.sqrt(dot(arm, arm)), _NONE)
    if abs(determinant) > _NONE * long:
        f = np.zeros(6)
        square_onto(f, 1.0, (ds * (y0 + rest) - ms * (u0 - d0)) / determinant,
                    (ds * yc - ms * uc) / determinant, (ds * ys - ms * us) / determinant)  # fmt: skip
        square_onto(f, 1.0, (mc * (u0 - d0) - dc * (y0 + rest)) / determinant,
                    (mc * uc - dc * yc) / determinant, (mc * us - dc * ys) / determinant)  # fmt: skip
        f[0] -= 1.0
        lasting_angles(f, np.arctan2(ys, yc), first, there)  # of the sides of the shoulder, stretched
        for k in range(4):
            c, s = np.cos(first[k]), np.sin(first[k])
            left, right = y0 + rest + yc * c + ys * s, u0 - d0 + uc * c + us * s
            out[k, 0] = first[k]
            out[k, 1] = np.arctan2((mc * right - dc * left) / determinant, (ds * left - ms * right) / determinant)
        return
    if size > _NONE * long and np.sqrt(dc * dc + ds * ds) > _NONE:
        return  # both rows say the same of the fifth angle, and it takes more than these two to tell
    if not cone(yc, ys, -(y0 + rest), first):
        return
    for k in range(2):
        if cone(dc, ds, u0 - d0 + uc * np.cos(first[k]) + us * np.sin(first[k]), pair):
            for i in range(2):
                out[2 * k + i, 0], out[2 * k + i, 1], there[2 * k + i] = first[k], pair[i], 1


@part
def _across(h: Array, o: Array, r: int) -> float:
    """Component r of a direction across the parallel axes: the fore arm's."""
    along = 0.0
    for k in range(3):
        along += h[1, k] * (o[3, k] - o[2, k])
    return float(o[3, r] - o[2, r] - along * h[1, r])


@part
def _by_parallels(h: Array, o: Array, M: Array, p: Array, near: Array, Q: Array, there: Ints) -> None:
    """Rows of Q (8, 6) <- postures of an arm whose axes 2, 3 and 4 are parallel; there (8,): 1 at those."""
    ends, n = np.empty((4, 2)), h[1]
    a, b, x, v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    upper, fore, elbow, y = np.empty(3), np.empty(3), np.empty(2), np.empty(3)
    side3, side4 = (1.0 if dot(h[2], n) > 0.0 else -1.0), (1.0 if dot(h[3], n) > 0.0 else -1.0)
    some = np.empty(4, np.int64)
    _first_and_fifth(h, o, M, p, ends, some)
    for k in range(4):
        if not some[k]:
            continue
        q1, q5 = ends[k, 0], ends[k, 1]
        rotate(h[0], np.cos(q1), np.sin(q1), n, x)
        for r in range(3):
            a[r] = M[0, r] * x[0] + M[1, r] * x[1] + M[2, r] * x[2]
        rotate(h[4], np.cos(q5), -np.sin(q5), n, b)
        along = dot(h[5], b)
        q6 = near[5] if 1.0 - along * along < _SINGULAR * _SINGULAR else turn_between(h[5], a, b)
        # what is left to the three: where they take a point of the fourth axis, and a direction across them
        for r in range(3):
            x[r], v[r] = o[3, r], _across(h, o, r)
        _place(h, o, 4, -q5, x)
        _place(h, o, 5, -q6, x)
        rotate(h[4], np.cos(q5), -np.sin(q5), v, v)
        rotate(h[5], np.cos(q6), -np.sin(q6), v, v)
        for r in range(3):
            a[r] = p[r] + M[r, 0] * x[0] + M[r, 1] * x[1] + M[r, 2] * x[2]
            b[r] = M[r, 0] * v[0] + M[r, 1] * v[1] + M[r, 2] * v[2]
        _place(h, o, 0, -q1, a)
        rotate(h[0], np.cos(q1), -np.sin(q1), b, b)
        for r in range(3):
            a[r] -= o[1, r]
            upper[r], fore[r], v[r] = o[2, r] - o[1, r], o[3, r] - o[2, r], _across(h, o, r)
        total = turn_between(n, v, b)
        up, on, to = dot(n, upper), dot(n, fore), dot(n, a)
        square = dot(a, a) - to * to - (dot(upper, upper) - up * up) - (dot(fore, fore) - on * on)
        if not cone(dot(upper, fore) - up * on, triple(upper, n, fore), 0.5 * square, elbow):
            continue
        for i in range(2):
            rotate(n, np.cos(elbow[i]), np.sin(elbow[i]), fore, y)
            for r in range(3):
                y[r] += upper[r]
            q2, row = turn_between(n, y, a), 2 * k + i
            there[row] = 1
            Q[row, 0], Q[row, 1], Q[row, 2] = q1, q2, side3 * elbow[i]
            Q[row, 3], Q[row, 4], Q[row, 5] = side4 * (total - q2 - elbow[i]), q5, q6


@part
def _far(one: Array, other: Array) -> bool:
    """Whether two postures (6,) lie so far apart that Newton's method makes no one of them."""
    for i in range(6):
        d = one[i] - other[i]
        if abs(d - 2.0 * np.pi * np.round(d / (2.0 * np.pi))) > _FAR:
            return True
    return False


@part
def solve_screws(arm: ScrewArm, R: Array, p: Array, near: Array, Q: Array, why: Ints, only: int = -1) -> int:
    """All postures of the arm whose tool stands at rotation R (3, 3) and position p (3,) in its foot.

    Fills Q (K, 6), K at least 8, each angle on the turn nearest to `near` (6,), and why (K,): BRANCH_OK or BRANCH_OUT_OF_REACH.
    Where two axes are one the angle of the first of them stays at `near`'s. Returns how many there are. A row is a branch that a
    path can be followed on. only: the one row that is wanted, whatever the others then say; -1: all.
    """
    M, d = np.empty((3, 3)), np.empty(3)
    for r in range(3):
        d[r] = p[r]
        for c in range(3):
            d[r] += R[r, c] * arm.tool_T_foot[c, 3]
            M[r, c] = (
                R[r, 0] * arm.tool_T_foot[0, c] + R[r, 1] * arm.tool_T_foot[1, c] + R[r, 2] * arm.tool_T_foot[2, c]
            )
    if arm.mirrored:
        put_back(M, d)
    close, rows, there = np.empty(6), np.empty((8, 6)), np.zeros(8, np.int64)
    for i in range(6):
        close[i] = near[5 - i] if arm.mirrored else near[i]
    if arm.family == WRIST:
        _by_wrist(arm.h, arm.o, M, d, close, rows, there)
    elif arm.family == OFFSET:
        by_offset(arm.h, arm.o, M, d, close, rows, there, only)
    else:
        _by_parallels(arm.h, arm.o, M, d, close, rows, there)
    for k in range(why.shape[0]):
        why[k] = BRANCH_OUT_OF_REACH
    count = 0
    for k in range(8):
        if only >= 0 and (k > only or (k < only and there[k] and _far(rows[k], rows[only]))):
            continue
        if not there[k] or not polish(arm.true_h, arm.true_o, M, d, rows[k]):
            continue
        for i in range(6):
            j = 5 - i if arm.mirrored else i
            Q[k, i] = nearest_turn(rows[k, j], near[i])
        fresh = True
        for other in range(k):
            if why[other] == BRANCH_OK:
                apart = 0.0
                for i in range(6):
                    apart = max(apart, abs(Q[k, i] - Q[other, i]))
                fresh = fresh and apart > _SAME
        if fresh:
            why[k] = BRANCH_OK
            count += 1
    return count


@kernel(nogil=True)
def solve_screws_many(arm: ScrewArm, foot_T_tool: Array, near: Array) -> tuple[Array, Ints]:
    """`solve_screws` for poses (N, 4, 4) and postures `near` (N, 6): branches (N, 8, 6) and their states (N, 8)."""
    N = foot_T_tool.shape[0]
    Q, why = np.zeros((N, 8, 6)), np.empty((N, 8), np.int64)
    R, p = np.empty((3, 3)), np.empty(3)
    for k in range(N):
        for r in range(3):
            p[r] = foot_T_tool[k, r, 3]
            for c in range(3):
                R[r, c] = foot_T_tool[k, r, c]
        solve_screws(arm, R, p, near[k], Q[k], why[k])
    return Q, why
