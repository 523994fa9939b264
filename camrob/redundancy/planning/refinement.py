"""Continuous refinement of a plan: Newton's method on all waypoints at once, the coupling of neighbours block-tridiagonal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.redundancy.accuracy.part_error import PUSH
from camrob.redundancy.planning.freedoms import PlanSpace, PlanWork, conditioning, plan_work, posture
from camrob.redundancy.planning.objective import (
    BEYOND,
    MotionPrice,
    Objective,
    blocked_price,
    error_price,
    posture_price,
)
from camrob.small_matrices import made_positive, solved

__all__ = ["Course", "arm_along", "refine_course"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ITERATIONS = 30  # an end for a course that still creeps
_H = 1e-3  # rad or m of the differences
_SOFT = 1e-3  # rad or m below which the travel's |d| is rounded off
_SHIFT = 1e-3  # of the mean weight, added to the blocks at first
_CLIP = 0.15  # rad or m that a freedom moves in one iteration at most


class Course(NamedTuple):
    """What surrounds the waypoints: frames (W, 4, 4), branch (W,), weight (W,) m that each stands for; motion: price of the
    move to each; joined (W,) False where the posture jumps before it; push (W, PUSH): what `part_error` needs to know of each
    waypoint, (0, PUSH) where nobody looks at the part's error; blocked (W, K): which of the objective's forbidden postures
    hold at each waypoint.
    """

    frames: Array
    branch: Ints
    weight: Array
    motion: MotionPrice
    joined: NDArray[np.bool_]
    push: Array
    blocked: NDArray[np.bool_]


@kernel(nogil=True)
def arm_along(
    space: PlanSpace, frames: Array, branch: Ints, joined: NDArray[np.bool_], u: Array, start: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The arm's postures (W, 6) along freedoms u (W, F), and where (W,) they exist; frames, branch, joined as of a `Course`.

    start (W, 6): the posture whose turns are taken where a stretch begins (joined False); turns are carried on from there.
    """
    W = u.shape[0]
    q, good = np.empty((W, 6)), np.zeros(W, np.bool_)
    work = plan_work()
    near = start[0].copy()
    for k in range(W):
        if not joined[k]:
            near[:] = start[k]
        good[k] = posture(space, frames[k], u[k], branch[k], near, q[k], work)
        if good[k]:
            near[:] = q[k]
        else:
            q[k] = near
    return q, good


@part
def _local(
    space: PlanSpace,
    objective: Objective,
    frame: Array,
    u: Array,
    branch: int,
    near: Array,
    push: Array,
    blocked: NDArray[np.bool_],
    q: Array,
    work: PlanWork,
) -> float:
    """Price of a metre in the posture of u; q (6,) is filled."""
    if not posture(space, frame, u, branch, near, q, work):
        q[:] = near
        return BEYOND
    a, b = posture_price(space, objective, u, q, conditioning(space, q, work))
    if objective.errors.weight > 0.0:
        b += error_price(objective, u, q, push)
    b += blocked_price(objective, q, blocked)
    return float(a + b)


@part
def _push(course: Course, k: int, nothing: Array) -> Array:
    """What pushes at waypoint k."""
    return course.push[k] if course.push.shape[0] > 0 else nothing


@part
def _moved(price: MotionPrice, k: int, c: int, d: float) -> float:
    """Price of coordinate c's going by d on the way to waypoint k, its |d| rounded off about 0."""
    total = price.square[k, c] * d * d
    if price.rate[k, c] > 0.0:
        total += price.rate[k, c] * (np.sqrt(d * d + _SOFT * _SOFT) - _SOFT)
    if abs(d) > price.top[k, c]:
        over = abs(d) / price.top[k, c] - 1.0
        total += price.haste[k] * over * over
    return float(total)


@part
def _slope_bend(price: MotionPrice, k: int, c: int, d: float) -> tuple[float, float]:
    """The slope of `_moved` over d, and a bend that is nowhere too small."""
    bend = 2.0 * price.square[k, c]
    if price.rate[k, c] > 0.0:
        bend += price.rate[k, c] / np.sqrt(d * d + _SOFT * _SOFT)
    slope = bend * d
    if abs(d) > price.top[k, c]:
        haste = 2.0 * price.haste[k] / price.top[k, c]
        slope += haste * (abs(d) / price.top[k, c] - 1.0) * np.sign(d)
        bend += haste / price.top[k, c]
    return slope, bend


@part
def _total(
    space: PlanSpace, objective: Objective, course: Course, u: Array, near: Array, q: Array, work: PlanWork
) -> float:
    """The price of a course; q (W, 6) is filled."""
    total, nothing = 0.0, np.zeros(PUSH)
    for k in range(u.shape[0]):
        push = _push(course, k, nothing)
        total += course.weight[k] * _local(
            space, objective, course.frames[k], u[k], course.branch[k], near[k], push, course.blocked[k], q[k], work
        )
        if k > 0 and course.joined[k]:
            F = u.shape[1]
            for i in range(F):
                total += _moved(course.motion, k, i, u[k, i] - u[k - 1, i])
            for i in range(6):
                total += _moved(course.motion, k, F + i, q[k, i] - q[k - 1, i])
    return total


@part
def _differences(
    space: PlanSpace,
    objective: Objective,
    frame: Array,
    u: Array,
    branch: int,
    near: Array,
    push: Array,
    blocked: NDArray[np.bool_],
    weight: float,
    g: Array,
    H: Array,
    J: Array,
    work: PlanWork,
) -> None:
    """Gradient g (F,), Hessian H (F, F), made positive, of a waypoint's own price, and J (6, F) = dq/du."""
    F = u.shape[0]
    q, q_up, q_down, v = np.empty(6), np.empty(6), np.empty(6), u.copy()
    here = _local(space, objective, frame, u, branch, near, push, blocked, q, work)
    up, down = np.empty(F), np.empty(F)
    for i in range(F):
        v[i] = u[i] + _H
        up[i] = _local(space, objective, frame, v, branch, near, push, blocked, q_up, work)
        v[i] = u[i] - _H
        down[i] = _local(space, objective, frame, v, branch, near, push, blocked, q_down, work)
        v[i] = u[i]
        g[i] = weight * (up[i] - down[i]) / (2.0 * _H)
        H[i, i] = weight * (up[i] + down[i] - 2.0 * here) / (_H * _H)
        for r in range(6):
            J[r, i] = (q_up[r] - q_down[r]) / (2.0 * _H)
    for i in range(F):
        for j in range(i):
            v[i], v[j] = u[i] + _H, u[j] + _H
            both = _local(space, objective, frame, v, branch, near, push, blocked, q_up, work)
            v[i], v[j] = u[i], u[j]
            H[i, j] = weight * (both - up[i] - up[j] + here) / (_H * _H)
            H[j, i] = H[i, j]
    rough = here >= BEYOND
    for i in range(F):
        rough = rough or up[i] >= BEYOND or down[i] >= BEYOND
    if rough:  # at the edge of reach differences say nothing; neighbours draw it back
        g[:] = 0.0
        H[:] = 0.0
        return
    made_positive(H)


@part
def _assemble(
    space: PlanSpace,
    objective: Objective,
    course: Course,
    u: Array,
    q: Array,
    g: Array,
    D: Array,
    B: Array,
    work: PlanWork,
) -> None:
    """Gradient g (W, F), diagonal blocks D (W, F, F) and blocks B (W, F, F) that couple each waypoint with the one before."""
    W, F = u.shape
    J, J_before, nothing = np.zeros((6, F)), np.zeros((6, F)), np.zeros(PUSH)
    for k in range(W):
        J_before[:] = J
        push = _push(course, k, nothing)
        frame, branch, weight, blocked = course.frames[k], course.branch[k], course.weight[k], course.blocked[k]
        _differences(space, objective, frame, u[k], branch, q[k], push, blocked, weight, g[k], D[k], J, work)
        B[k] = 0.0
        if k == 0 or not course.joined[k]:
            continue
        for i in range(F):
            slope, bend = _slope_bend(course.motion, k, i, u[k, i] - u[k - 1, i])
            g[k, i] += slope
            g[k - 1, i] -= slope
            D[k, i, i] += bend
            D[k - 1, i, i] += bend
            B[k, i, i] -= bend
        _couple_arm(course.motion, k, q, J, J_before, g, D, B)


@part
def _couple_arm(price: MotionPrice, k: int, q: Array, J: Array, J_before: Array, g: Array, D: Array, B: Array) -> None:
    """Add what the arm's moves on the way to waypoint k bring to gradient and blocks; J, J_before (6, F): dq/du there and
    before.
    """
    F = J.shape[1]
    for r in range(6):
        slope, bend = _slope_bend(price, k, F + r, q[k, r] - q[k - 1, r])
        for i in range(F):
            g[k, i] += slope * J[r, i]
            g[k - 1, i] -= slope * J_before[r, i]
            for j in range(F):
                D[k, i, j] += bend * J[r, i] * J[r, j]
                D[k - 1, i, j] += bend * J_before[r, i] * J_before[r, j]
                B[k, i, j] -= bend * J[r, i] * J_before[r, j]


@part
def _solve_blocks(g: Array, D: Array, B: Array, shift: float, held: NDArray[np.bool_], step: Array) -> None:
    """step (W, F) <- -(H + shift I)^-1 g of the block-tridiagonal H, freedoms that are `held` (F,) left alone."""
    W, F = g.shape
    S, rhs = np.empty((W, F, F)), np.empty((W, F))
    A, M, x = np.empty((F, F)), np.empty((F, F)), np.empty((F, 1))
    for k in range(W):
        S[k] = D[k]
        rhs[k] = -g[k]
        for i in range(F):
            S[k, i, i] += shift
            if held[i]:
                S[k, i, :] = 0.0
                S[k, :, i] = 0.0
                S[k, i, i] = 1.0
                rhs[k, i] = 0.0
                B[k, i, :] = 0.0
                B[k, :, i] = 0.0
        if k > 0:
            for i in range(F):
                for j in range(F):
                    M[i, j] = B[k, j, i]
                    A[i, j] = S[k - 1, i, j]
            solved(A, M)  # S^-1 B^T
            for i in range(F):
                for r in range(F):
                    rhs[k, i] -= M[r, i] * rhs[k - 1, r]
                    for j in range(F):
                        S[k, i, j] -= B[k, i, r] * M[r, j]
    for k in range(W - 1, -1, -1):
        if k + 1 < W:
            for i in range(F):
                for r in range(F):
                    rhs[k, i] -= B[k + 1, r, i] * step[k + 1, r]
        for i in range(F):
            x[i, 0] = rhs[k, i]
        solved(S[k], x)
        for i in range(F):
            step[k, i] = x[i, 0]


@kernel(nogil=True)
def refine_course(
    space: PlanSpace, objective: Objective, course: Course, u: Array, q: Array, held: NDArray[np.bool_], iterations: int
) -> float:
    """Bring u (W, F) and q (W, 6) to the nearest optimum of the objective; returns its price. `held` (F,) freedoms stay."""
    W, F = u.shape
    g, D, B, step = np.empty((W, F)), np.empty((W, F, F)), np.empty((W, F, F)), np.empty((W, F))
    trial, q_trial = np.empty((W, F)), np.empty((W, 6))
    work = plan_work()
    price = _total(space, objective, course, u, q.copy(), q, work)
    mean = np.mean(course.weight)
    shift = _SHIFT * mean
    fresh = True
    for _iteration in range(iterations):
        if fresh:
            _assemble(space, objective, course, u, q, g, D, B, work)
        _solve_blocks(g, D, B, shift, held, step)
        for k in range(W):
            for i in range(F):
                value = u[k, i] + min(_CLIP, max(-_CLIP, step[k, i]))
                trial[k, i] = min(space.u_upper[i], max(space.u_lower[i], value))
        new = _total(space, objective, course, trial, q, q_trial, work)
        if new < price:
            small = price - new < 1e-4 * abs(price)
            price = new
            u[:] = trial
            q[:] = q_trial
            shift = max(0.2 * shift, 1e-4 * mean)
            fresh = True
            if small:
                break
        else:
            shift *= 6.0
            fresh = False
            if shift > 1e6 * mean:
                break
    return float(price)
