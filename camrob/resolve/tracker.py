"""The tracker: follows a path of poses with the virtual-joint-augmented chain, compiled.

At every point it goes straight to where the published loop (eq. 11, 12 and Algorithm 1) creeps: the posture that holds
the pose and in which the null-space vector h = h_cond + h_jnt (eq. 15 to 20) has no part left that self-motion could
follow,

    f(q) = target   and   N(q)^T h(q) = 0,   h = -W_jnt(q) (q - q_ref) - k_F(q) W_cond(q) (q - q_Ts),

by Newton's method on both at once: a QR factorisation of J^T gives the pseudoinverse step, the null-space basis and the
multipliers; the chain's second derivatives and the slopes of the fuzzy surfaces give the derivative of the reduced
criterion. A shift on it, raised where a step does not pay, turns the step into the published flow, so that only its
stable postures are found. Joint limits are an active set: a joint at its limit leaves the problem and comes back when
the criterion draws it inwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from camrob.kinematics.kernels import ChainArrays, forward, inverse_kf, jacobian
from camrob.resolve.linear_algebra import (
    apply_q,
    apply_q_transposed,
    qr_six,
    solve_positive,
    solve_r,
    solve_r_transposed,
)
from camrob.resolve.surfaces import WeightSurface, weights_and_slopes
from camrob.resolve.tracker_work import TrackerWork, curvature, pose_error, tracker_work

__all__ = [
    "FAILED_LIMIT",
    "FAILED_NOT_REACHED",
    "FAILED_SINGULAR",
    "TRACKED",
    "TrackState",
    "TrackerSettings",
    "track",
]

Array = NDArray[np.float64]

TRACKED = 0
FAILED_NOT_REACHED = 1  # Newton's method ends away from the pose: out of reach
FAILED_LIMIT = 2  # too many joints at their limits to follow
FAILED_SINGULAR = 3  # the chain has lost a direction

_TASK_TOLERANCE = 1e-11  # m and rad; the promise is 1e-9
_SELF_TOLERANCE = 1e-9  # rad and m of self-motion left at a point
_NEAR = 1e-5  # m and rad from the pose, from where on a step without self-motion ends it
_ITERATIONS = 60
_STEP = 0.3  # rad or m that a joint moves in one iteration at most
_RANK = 1e-7  # ratio of R's diagonal below which the chain is singular


class TrackerSettings(NamedTuple):
    """What the tracker needs beside the chain: q limits (n,), endless (n,), both weight surfaces, threshold on 1/k_F.

    locked (n,): joints that stand where the reference posture has them, exactly, and take no part in following.
    """

    lower: Array
    upper: Array
    endless: NDArray[np.bool_]
    joint_weights: WeightSurface
    condition_weights: WeightSurface
    threshold: float
    locked: NDArray[np.bool_]


class TrackState(NamedTuple):
    """What a path leaves to the next one: posture q (n,), the posture recorded at the threshold, the joints at a limit.

    flags (2,): [0] 1 while the condition term acts; side (n,): -1, 0, 1 for a joint at its lower limit, free, at its
    upper.
    """

    q: Array
    q_threshold: Array
    side: NDArray[np.int64]
    flags: NDArray[np.int64]


@numba.njit(cache=True, forceinline=True)
def _from(q: float, reference: float, endless: bool) -> float:
    """q - reference, to the nearest turn where the joint is endless."""
    d = q - reference
    return float(d - 2.0 * np.pi * np.round(d / (2.0 * np.pi)) if endless else d)


@numba.njit(cache=True, forceinline=True)
def _criterion(
    settings: TrackerSettings, q: Array, q_reference: Array, state: TrackState, chain: ChainArrays, w: TrackerWork
) -> None:
    """w.g <- -h (eq. 18, 20); w.weight, w.slope0, w.slope1 <- the diagonal and the two columns of its derivative by W."""
    n = q.shape[0]
    weights_and_slopes(settings.joint_weights, q, w.weight, w.slope0, w.slope1)
    for i in range(n):
        d = _from(q[i], q_reference[i], settings.endless[i])
        w.g[i] = w.weight[i] * d
        w.slope0[i] *= d
        w.slope1[i] *= d
    if state.flags[0] == 1:
        value = inverse_kf(chain, w.Z, w.P, w.plate)
        kf = 1.0 / max(value, 1e-6)
        surface = settings.condition_weights
        weights_and_slopes(surface, q, w.weight_cond, w.slope_cond0, w.slope_cond1)
        for i in range(n):
            d = _from(q[i], state.q_threshold[i], settings.endless[i])
            w.weight[i] += kf * w.weight_cond[i]
            w.g[i] += kf * w.weight_cond[i] * d
            w.slope_cond0[i] *= kf * d
            w.slope_cond1[i] *= kf * d


@numba.njit(cache=True, forceinline=True)
def _add_slopes(axis: NDArray[np.int64], m: int, slope0: Array, slope1: Array, w: TrackerWork) -> None:
    """Add the derivative of the weights to w.C, in the columns of the axes that they depend on."""
    for b in range(m):
        if w.free[b] == axis[0]:
            for a in range(m):
                w.C[a, b] += slope0[w.free[a]]
        if w.free[b] == axis[1]:
            for a in range(m):
                w.C[a, b] += slope1[w.free[a]]


@numba.njit(cache=True, forceinline=True)
def _self_step(settings: TrackerSettings, m: int, acting: bool, shift: float, w: TrackerWork) -> float:
    """w.s[:m] <- Newton step of the reduced criterion in the null space, the task's step (w.x) taken into account.

    w.N[6:m] holds the null-space basis as rows, w.C the curvature. Returns the shift that was needed.
    """
    r = m - 6
    for a in range(m):
        for b in range(m):
            w.C[a, b] = -w.C[a, b]
        w.C[a, a] += w.weight[w.free[a]]
    _add_slopes(settings.joint_weights.axis, m, w.slope0, w.slope1, w)
    if acting:
        _add_slopes(settings.condition_weights.axis, m, w.slope_cond0, w.slope_cond1, w)
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


@numba.njit(cache=True, forceinline=True)
def _task_step(scale: float, n: int, side: NDArray[np.int64], locked: NDArray[np.bool_], w: TrackerWork) -> int:
    """Factor the free joints' J^T; w.x <- pseudoinverse step to w.error. Returns the free joints' number, -1 if singular."""
    m = 0
    for i in range(n):
        if side[i] == 0 and not locked[i]:
            w.free[m] = i
            for r in range(3):
                w.A[m, r] = w.J[r, i] * scale
                w.A[m, 3 + r] = w.J[3 + r, i]
            m += 1
    if m < 6:
        return m
    if qr_six(w.A, m, w.tau) < _RANK:
        return -1
    for r in range(3):
        w.x[r] = w.error[r] * scale
        w.x[3 + r] = w.error[3 + r]
    solve_r_transposed(w.A, w.x)
    for k in range(6, m):
        w.x[k] = 0.0
    apply_q(w.A, m, w.tau, w.x)
    return m


@numba.njit(cache=True, forceinline=True)
def _bounded(m: int, w: TrackerWork, limit: Array) -> float:
    """Shrink the self-motion w.s so that no joint's sum of it passes `limit` (n,); returns its largest component."""
    share = 1.0
    for k in range(m):
        i = w.free[k]
        if w.s[k] != 0.0:
            room = limit[i] - w.moved[i] if w.s[k] > 0.0 else limit[i] + w.moved[i]
            share = min(share, max(0.0, room) / abs(w.s[k]))
            share = min(share, _STEP / abs(w.s[k]))
    largest = 0.0
    for k in range(m):
        w.s[k] *= share
        w.moved[w.free[k]] += w.s[k]
        largest = max(largest, abs(w.s[k]))
    return largest


@numba.njit(cache=True, forceinline=True)
def _release(n: int, side: NDArray[np.int64], multipliers: Array, scale: float, w: TrackerWork) -> None:
    """Free the joints at a limit that the optimum draws inwards."""
    for i in range(n):
        if side[i] != 0:
            pull = w.g[i]
            for r in range(3):
                pull -= (w.J[r, i] * scale) * multipliers[r] + w.J[3 + r, i] * multipliers[3 + r]
            if pull * side[i] > 0.0:
                side[i] = 0


@numba.njit(cache=True, forceinline=True)
def _gradient_and_multipliers(
    settings: TrackerSettings, q: Array, q_reference: Array, state: TrackState, chain: ChainArrays, m: int,
    multipliers: Array, w: TrackerWork,
) -> None:  # fmt: skip
    """w.g <- -h, multipliers (6,) <- those with which the task's rows meet it best, from the factored free joints."""
    _criterion(settings, q, q_reference, state, chain, w)
    gradient_free = w.N[0]
    for k in range(m):
        gradient_free[k] = w.g[w.free[k]]
    apply_q_transposed(w.A, m, w.tau, gradient_free)
    for r in range(6):
        multipliers[r] = gradient_free[r]
    solve_r(w.A, multipliers)


@numba.njit(cache=True, forceinline=True)
def _self_motion(
    chain: ChainArrays, settings: TrackerSettings, m: int, acting: bool, shift: float, multipliers: Array,
    limit: Array, w: TrackerWork,
) -> tuple[float, float]:  # fmt: skip
    """w.s[:m] <- the bounded step in the null space. Returns its largest component and the shift that it needed."""
    for b in range(6, m):
        for k in range(m):
            w.N[b, k] = 1.0 if k == b else 0.0
        apply_q(w.A, m, w.tau, w.N[b])
    curvature(chain, m, 1.0 / chain.length, multipliers, w)
    shift = _self_step(settings, m, acting, shift, w)
    return _bounded(m, w, limit), shift


@numba.njit(cache=True, forceinline=True)
def _advance(settings: TrackerSettings, m: int, q: Array, side: NDArray[np.int64], w: TrackerWork) -> None:
    """Take the steps w.x (bounded) and w.s; a joint that would pass its limit stays there and leaves the problem."""
    step = 0.0
    for k in range(m):
        step = max(step, abs(w.x[k]))
    share = min(1.0, _STEP / step) if step > 0.0 else 1.0
    for k in range(m):
        i = w.free[k]
        q[i] += share * w.x[k] + w.s[k]
        if q[i] < settings.lower[i]:
            q[i], side[i] = settings.lower[i], -1
        elif q[i] > settings.upper[i]:
            q[i], side[i] = settings.upper[i], 1


@numba.njit(cache=True, forceinline=True)
def _solve_point(
    chain: ChainArrays, settings: TrackerSettings, R_target: Array, p_target: Array, q: Array, q_reference: Array,
    state: TrackState, limit: Array, w: TrackerWork,
) -> int:  # fmt: skip
    """Move q to the constrained optimum at one target. Returns TRACKED or why not."""
    n = q.shape[0]
    acting, side = state.flags[0] == 1, state.side
    w.moved[:] = 0.0
    released, settled = False, False
    shift, last_self = 0.0, np.inf
    multipliers = np.zeros(6)
    for iteration in range(_ITERATIONS):
        forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
        pose_error(w.R, w.p, R_target, p_target, w.error)
        task = np.max(np.abs(w.error))
        if task <= _TASK_TOLERANCE and settled:
            return TRACKED
        jacobian(chain, w.Z, w.P, w.p, w.J)
        m = _task_step(1.0 / chain.length, n, side, settings.locked, w)
        if m < 6:
            return FAILED_SINGULAR if m < 0 else FAILED_LIMIT
        w.s[:] = 0.0
        if not settled:
            _gradient_and_multipliers(settings, q, q_reference, state, chain, m, multipliers, w)
            if not released:
                released = True
                before = m
                _release(n, side, multipliers, 1.0 / chain.length, w)
                m = _task_step(1.0 / chain.length, n, side, settings.locked, w)
                if m != before:
                    continue
            largest = 0.0
            if m > 6:
                largest, shift = _self_motion(chain, settings, m, acting, shift, multipliers, limit, w)
                shift = max(4.0 * shift, 1e-3) if largest > 0.7 * last_self else 0.25 * shift
            last_self = largest
            # far from the pose a step of nothing only says that there was nothing to do yet; and in the loop's second
            # half the pose comes first: the self-motion goes on at the next point
            settled = (largest <= _SELF_TOLERANCE and task <= _NEAR) or iteration > _ITERATIONS // 2
        _advance(settings, m, q, side, w)
    return FAILED_NOT_REACHED


@numba.njit(cache=True, nogil=True)
def track(
    chain: ChainArrays, settings: TrackerSettings, targets: Array, q_reference: Array, state: TrackState, limits: Array,
    out: Array, inv_kf: Array,
) -> tuple[int, int]:  # fmt: skip
    """Follow targets (N, 4, 4), base_T_target, from `state`, which is brought to the path's end.

    q_reference: (N, n) reference postures (one row serves all points: shape (1, n)). limits: (N, n) how far self-motion
    may take each joint at a point. Fills out (N, n) and inv_kf (N,). Returns (TRACKED, N), or why and at which point it
    failed; `state` is then the posture that was reached there.
    """
    N, n = out.shape
    w = tracker_work(n)
    q = state.q
    forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
    value = inverse_kf(chain, w.Z, w.P, w.plate)
    for k in range(N):
        if value >= settings.threshold or value <= 0.0:
            state.flags[0] = 0
        elif state.flags[0] == 0:
            state.flags[0] = 1
            state.q_threshold[:] = q
        reference = q_reference[k] if q_reference.shape[0] > 1 else q_reference[0]
        for i in range(n):
            if settings.locked[i]:
                q[i], state.side[i] = reference[i], 0
        code = _solve_point(chain, settings, targets[k, :3, :3], targets[k, :3, 3], q, reference, state, limits[k], w)
        if code != TRACKED:
            return code, k
        value = inverse_kf(chain, w.Z, w.P, w.plate)
        out[k] = q
        inv_kf[k] = value
    return TRACKED, N
