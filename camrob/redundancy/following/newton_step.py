"""One Newton step of the follower in its pieces: the criterion, the factored task, multipliers, the step in the null space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare
from camrob.kinematics.conditioning_slope import kf_and_slope
from camrob.kinematics.kernels import ChainArrays, forward
from camrob.redundancy.following.chain_work import FollowerWork, curvature, put
from camrob.redundancy.following.closed_step import split_multipliers, split_self_motion, split_share, split_task
from camrob.redundancy.following.linear_algebra import (
    apply_q,
    apply_q_transposed,
    qr_six,
    solve_positive,
    solve_r,
    solve_r_transposed,
)
from camrob.redundancy.fuzzy.surfaces import WeightSurface, weights_and_slopes

__all__ = [
    "FollowState",
    "FollowerSettings",
    "criterion",
    "gradient_and_multipliers",
    "inwards",
    "self_motion",
    "self_share",
    "task_step",
]

Array = NDArray[np.float64]

_RANK = 1e-7  # ratio of R's diagonal below which the chain is singular
_BESIDE = 1e-6  # rad between the postures whose slopes of k_F are compared: its curvature to some 1e-6 of itself


class FollowerSettings(NamedTuple):
    """What the follower needs beside the chain: q limits (n,), endless (n,), both weight surfaces, threshold on 1/k_F.

    locked (n,): joints that stand where the reference posture has them, exactly, and take no part in following. gradient: h_cond
    leads down the gradient of k_F, not back to the posture recorded at the threshold.
    """

    lower: Array
    upper: Array
    endless: NDArray[np.bool_]
    joint_weights: WeightSurface
    condition_weights: WeightSurface
    threshold: float
    locked: NDArray[np.bool_]
    gradient: bool = False


class FollowState(NamedTuple):
    """What a path leaves to the next one: posture q (n,), the posture recorded at the threshold, the joints at a limit.

    flags (2,): [0] 1 while the condition term acts; side (n,): -1, 0, 1 for a joint at its lower limit, free, at its
    upper.
    """

    q: Array
    q_threshold: Array
    side: NDArray[np.int64]
    flags: NDArray[np.int64]


@bare
def _from(q: float, reference: float, endless: bool) -> float:
    """q - reference, to the nearest turn where the joint is endless."""
    d = q - reference
    if endless:
        d -= 2.0 * np.pi * np.floor(d * (0.5 / np.pi) + 0.5)
    return float(d)


@bare
def criterion(
    settings: FollowerSettings, q: Array, q_reference: Array, state: FollowState, chain: ChainArrays, w: FollowerWork
) -> None:
    """w.g <- -h (eq. 18, 20); w.weight, w.slope <- the diagonal and the columns of its derivative by W."""
    n = q.shape[0]
    weights_and_slopes(settings.joint_weights, q, w.weight, w.slope)
    for i in range(n):
        d = _from(q[i], q_reference[i], settings.endless[i])
        w.g[i] = w.weight[i] * d
        for a in range(3):
            w.slope[a, i] *= d
    if state.flags[0] == 1:
        kf = min(kf_and_slope(chain, w.Z, w.P, w.plate, w.kf_slope, w.C, w.H, w.L), 1e6)
        weights_and_slopes(settings.condition_weights, q, w.weight_cond, w.slope_cond)
        if settings.gradient:
            _down_the_gradient(settings, q, kf, chain, w)
            return
        for i in range(n):
            d = _from(q[i], state.q_threshold[i], settings.endless[i])
            w.weight[i] += kf * w.weight_cond[i]
            w.g[i] += kf * w.weight_cond[i] * d
            w.kf_part[i] = w.weight_cond[i] * d
            for a in range(3):
                w.slope_cond[a, i] *= kf * d


@bare
def _down_the_gradient(settings: FollowerSettings, q: Array, kf: float, chain: ChainArrays, w: FollowerWork) -> None:
    """Add h_cond in its gradient form to w.g, with its derivative in w.kf_bend and w.slope_cond.

    Eq. 14 with p = (k_F - k_T)^2 / 2 above k_T, the threshold's, each joint by its weight: h_cond = -W (k_F - k_T) grad k_F. It
    begins at nothing where the threshold is crossed, so that the posture does not jump there. The curvature of k_F comes from its
    slopes at postures beside this one, joint by joint of the arm: no other joint has a part in it.
    """
    n = q.shape[0]
    excess = max(0.0, kf - 1.0 / settings.threshold)
    for i in range(n):
        pull = excess * w.kf_slope[i]
        w.kf_part[i] = 0.0
        w.g[i] += w.weight_cond[i] * pull
        for a in range(3):
            w.slope_cond[a, i] *= pull
        for k in range(n):
            w.kf_bend[i, k] = 0.0
    if excess == 0.0:
        return
    near = w.near
    put(q, near.q)
    for k in range(chain.arm_start, chain.arm_stop):
        near.q[k] = q[k] + _BESIDE
        forward(chain, near.q, near.Z, near.P, near.R, near.p, near.plate)
        beside = kf_and_slope(chain, near.Z, near.P, near.plate, near.slope, w.C, w.H, w.L)
        near.q[k] = q[k]
        for i in range(chain.arm_start, chain.arm_stop):
            bend = (near.slope[i] - w.kf_slope[i]) / _BESIDE if beside < np.inf else 0.0
            w.kf_bend[i, k] = w.weight_cond[i] * (w.kf_slope[i] * w.kf_slope[k] + excess * bend)


@bare
def _add_slopes(axis: NDArray[np.int64], m: int, slope: Array, w: FollowerWork) -> None:
    """Add the derivative of the weights to w.C, in the columns of the axes that they depend on."""
    for b in range(m):
        for k in range(3):
            if w.free[b] == axis[k]:
                for a in range(m):
                    w.C[a, b] += slope[k, w.free[a]]


@bare
def _add_condition(settings: FollowerSettings, m: int, exact: bool, w: FollowerWork) -> None:
    """Add the derivative of h_cond to w.C, but for its weights' part of the diagonal."""
    _add_slopes(settings.condition_weights.axis, m, w.slope_cond, w)
    if settings.gradient:
        for a in range(m):
            for b in range(m):
                w.C[a, b] += w.kf_bend[w.free[a], w.free[b]]
    elif exact:
        for a in range(m):
            for b in range(m):
                w.C[a, b] += w.kf_part[w.free[a]] * w.kf_slope[w.free[b]]


@bare
def _self_step(settings: FollowerSettings, m: int, acting: bool, shift: float, exact: bool, w: FollowerWork) -> float:
    """w.s[:m] <- Newton step of the reduced criterion in the null space, the task's step (w.x) taken into account.

    w.N[6:m] holds the null-space basis as rows, w.C the curvature. Returns the shift that was needed.
    """
    r = m - 6
    for a in range(m):
        for b in range(m):
            w.C[a, b] = -w.C[a, b]
        w.C[a, a] += w.weight[w.free[a]]
    _add_slopes(settings.joint_weights.axis, m, w.slope, w)
    if acting:
        _add_condition(settings, m, exact, w)
    for a in range(r):
        w.reduced[a] = 0.0
    for k in range(m):
        total = w.g[w.free[k]]
        for c in range(m):
            total += w.C[k, c] * w.x[c]
        for a in range(r):
            w.reduced[a] -= w.N[6 + a, k] * total
    for b in range(r):
        for a in range(r):
            w.H[a, b] = 0.0
        for k in range(m):
            hn = 0.0
            for c in range(m):
                hn += w.C[k, c] * w.N[6 + b, c]
            for a in range(r):
                w.H[a, b] += w.N[6 + a, k] * hn
    shift = solve_positive(w.H, r, shift, w.L, w.reduced)
    for k in range(m):
        w.s[k] = 0.0
        for a in range(r):
            w.s[k] += w.N[6 + a, k] * w.reduced[a]
    return shift


@bare
def task_step(chain: ChainArrays, n: int, side: NDArray[np.int64], locked: NDArray[np.bool_], w: FollowerWork) -> int:
    """w.x <- pseudoinverse step to w.error, by the arm's closed inverse or a factorisation of the free joints' J^T.

    Returns the free joints' number, -1 if the chain is singular.
    """
    m = split_task(chain, n, side, locked, w)
    w.split[0] = m > 0
    if m > 0:
        return int(m)
    scale = 1.0 / chain.length
    for i in range(n):
        if side[i] == 0 and not locked[i]:
            w.free[m] = i
            for r in range(3):
                w.A[m, r] = w.J[r, i] * scale
                w.A[m, 3 + r] = w.J[3 + r, i]
            m += 1
    if m < 6:
        return int(m)
    if qr_six(w.A, m, w.tau) < _RANK:
        return -1
    for r in range(3):
        w.x[r] = w.error[r] * scale
        w.x[3 + r] = w.error[3 + r]
    solve_r_transposed(w.A, w.x)
    for k in range(6, m):
        w.x[k] = 0.0
    apply_q(w.A, m, w.tau, w.x)
    return int(m)


@bare
def inwards(i: int, side: int, multipliers: Array, scale: float, w: FollowerWork) -> bool:
    """Whether the optimum draws joint i, at a limit on that side, inwards."""
    pull = w.g[i]
    for r in range(3):
        pull -= (w.J[r, i] * scale) * multipliers[r] + w.J[3 + r, i] * multipliers[3 + r]
    return bool(pull * side > 0.0)


@bare
def gradient_and_multipliers(
    settings: FollowerSettings,
    q: Array,
    q_reference: Array,
    state: FollowState,
    chain: ChainArrays,
    m: int,
    multipliers: Array,
    w: FollowerWork,
) -> None:
    """w.g <- -h, multipliers (6,) <- those with which the task's rows meet it best, from the factored free joints."""
    criterion(settings, q, q_reference, state, chain, w)
    if w.split[0]:
        split_multipliers(chain, w.g.shape[0], multipliers, w)
        return
    gradient_free = w.N[0]
    for k in range(m):
        gradient_free[k] = w.g[w.free[k]]
    apply_q_transposed(w.A, m, w.tau, gradient_free)
    for r in range(6):
        multipliers[r] = gradient_free[r]
    solve_r(w.A, multipliers)


@bare
def self_motion(
    chain: ChainArrays,
    settings: FollowerSettings,
    m: int,
    acting: bool,
    shift: float,
    multipliers: Array,
    exact: bool,
    w: FollowerWork,
) -> float:
    """w.s[:m] <- the step in the null space. Returns the shift that it needed."""
    if w.split[0]:
        axes = settings.joint_weights.axis, settings.condition_weights.axis
        n = w.g.shape[0]
        return float(split_self_motion(chain, *axes, n, m, acting, settings.gradient, shift, multipliers, exact, w))
    for b in range(6, m):
        for k in range(m):
            w.N[b, k] = 1.0 if k == b else 0.0
        apply_q(w.A, m, w.tau, w.N[b])
    curvature(chain, m, 1.0 / chain.length, multipliers, w)
    return float(_self_step(settings, m, acting, shift, exact, w))


@bare
def self_share(m: int, q: Array, q_before: Array, w: FollowerWork) -> None:
    """w.s[:m] <- the part of the motion from q_before to q that is self-motion, by the last step's null space."""
    if w.split[0]:
        split_share(m, q, q_before, w)
        return
    for k in range(m):
        w.s[k] = 0.0
    for a in range(6, m):
        along = 0.0
        for k in range(m):
            along += w.N[a, k] * (q[w.free[k]] - q_before[w.free[k]])
        for k in range(m):
            w.s[k] += along * w.N[a, k]
