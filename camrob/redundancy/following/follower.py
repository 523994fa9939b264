"""The follower: follows a path of poses with the virtual-joint-augmented chain, compiled.

At every point it goes straight to where the published loop (eq. 11, 12 and Algorithm 1) creeps: the posture that holds
the pose and in which the null-space vector h = h_cond + h_jnt (eq. 15 to 20) has no part left that self-motion could
follow,

    f(q) = target   and   N(q)^T h(q) = 0,   h = -W_jnt(q) (q - q_ref) - k_F(q) W_cond(q) (q - q_Ts),

by Newton's method on both at once: a QR factorisation of J^T gives the pseudoinverse step, the null-space basis and the
multipliers; the chain's second derivatives and the slopes of the fuzzy surfaces give the derivative of the reduced
criterion. A shift on it, raised where a step does not pay, turns the step into the published flow, so that only its
stable postures are found. h_cond has a second form, down the gradient of k_F (`FollowerSettings.gradient`). Joint limits
are an active set: a joint at its limit leaves the problem and comes back when the criterion draws it inwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare, kernel
from camrob.kinematics.conditioning_slope import inverse_kf_within
from camrob.kinematics.kernels import ChainArrays, forward, jacobian
from camrob.redundancy.following.chain_work import FollowerWork, clear, follower_work, largest, pose_error, put
from camrob.redundancy.following.newton_step import (
    FollowerSettings,
    FollowState,
    gradient_and_multipliers,
    inwards,
    self_motion,
    task_step,
)
from camrob.redundancy.following.quick import History, history, predict, quick_point, remember

__all__ = [
    "FAILED_LIMIT",
    "FAILED_NOT_REACHED",
    "FAILED_SINGULAR",
    "FOLLOWED",
    "FollowState",
    "FollowerSettings",
    "follow_path",
]

Array = NDArray[np.float64]

FOLLOWED = 0
FAILED_NOT_REACHED = 1  # Newton's method ends away from the pose: out of reach
FAILED_LIMIT = 2  # too many joints at their limits to follow
FAILED_SINGULAR = 3  # the chain has lost a direction

_TASK_TOLERANCE = 1e-11  # m and rad; the promise is 1e-9
_SELF_TOLERANCE = 1e-9  # rad and m of self-motion left at a point
_NEAR = 1e-5  # m and rad from the pose, from where on a step without self-motion ends it
_ITERATIONS = 60
_STEP = 0.3  # rad or m that a joint moves in one iteration at most


@bare
def _bounded(m: int, w: FollowerWork, limit: Array) -> float:
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


@bare
def _release(n: int, side: NDArray[np.int64], multipliers: Array, scale: float, w: FollowerWork) -> bool:
    """Free the joints at a limit that the optimum draws inwards; returns whether there were any."""
    freed = False
    for i in range(n):
        if side[i] != 0 and inwards(i, side[i], multipliers, scale, w):
            side[i] = 0
            freed = True
    return freed


@bare
def _advance(settings: FollowerSettings, m: int, q: Array, side: NDArray[np.int64], w: FollowerWork) -> None:
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


@bare
def _solve_point(
    chain: ChainArrays,
    settings: FollowerSettings,
    R_target: Array,
    p_target: Array,
    q: Array,
    q_reference: Array,
    state: FollowState,
    limit: Array,
    w: FollowerWork,
) -> int:
    """Move q to the constrained optimum at one target. Returns FOLLOWED or why not."""
    n = q.shape[0]
    acting, side = state.flags[0] == 1, state.side
    clear(w.moved)
    released, settled = False, False
    shift, last_self = 0.0, np.inf
    multipliers = w.multipliers
    for iteration in range(_ITERATIONS):
        forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
        pose_error(w.R, w.p, R_target, p_target, w.error)
        task = largest(w.error)
        if task <= _TASK_TOLERANCE and settled:
            return FOLLOWED
        jacobian(chain, w.Z, w.P, w.p, w.J)
        m = task_step(chain, n, side, settings.locked, w)
        if m < 6:
            return FAILED_SINGULAR if m < 0 else FAILED_LIMIT
        clear(w.s)
        if not settled:
            gradient_and_multipliers(settings, q, q_reference, state, chain, m, multipliers, w)
            if not released:
                released = True
                if _release(n, side, multipliers, 1.0 / chain.length, w):
                    continue
            step = 0.0
            if m > 6:
                shift = self_motion(chain, settings, m, acting, shift, multipliers, False, w)
                step = _bounded(m, w, limit)
                shift = max(4.0 * shift, 1e-3) if step > 0.7 * last_self else 0.25 * shift
            last_self = step
            # far from the pose a step of nothing only says that there was nothing to do yet; and in the loop's second
            # half the pose comes first: the self-motion goes on at the next point
            settled = (step <= _SELF_TOLERANCE and task <= _NEAR) or iteration > _ITERATIONS // 2
        _advance(settings, m, q, side, w)
    return FAILED_NOT_REACHED


@kernel(nogil=True, error_model="numpy", _nrt=False)
def _follow(
    chain: ChainArrays,
    settings: FollowerSettings,
    targets: Array,
    q_reference: Array,
    state: FollowState,
    limits: Array,
    out: Array,
    inv_kf: Array,
    q_before: Array,
    w: FollowerWork,
    h: History,
) -> tuple[int, int]:
    """`follow_path`, with all the scratch that it needs: nothing is allocated here, and no references are counted."""
    N, n = out.shape
    q = state.q
    t = 0.0
    forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
    value = inverse_kf_within(chain, w.Z, w.P, w.plate, w.C, w.H, w.L)
    for k in range(N):
        if value >= settings.threshold or value <= 0.0:
            state.flags[0] = 0
        elif state.flags[0] == 0:
            state.flags[0] = 1
            put(q, state.q_threshold)
        reference = q_reference[k] if q_reference.shape[0] > 1 else q_reference[0]
        for i in range(n):
            if settings.locked[i]:
                q[i], state.side[i] = reference[i], 0
        put(q, q_before)
        done = False
        if k > 0:
            t = predict(h, targets[k - 1], targets[k], chain.length, q)
            for i in range(n):
                if settings.locked[i]:
                    q[i] = reference[i]
                elif state.side[i] != 0:
                    q[i] = q_before[i]
            done = quick_point(chain, settings, targets[k], q, q_before, reference, state, limits[k], w)
        if not done:
            put(q_before, q)
            code = _solve_point(
                chain, settings, targets[k, :3, :3], targets[k, :3, 3], q, reference, state, limits[k], w
            )
            if code != FOLLOWED:
                return code, k
        remember(h, t, q)
        value = inverse_kf_within(chain, w.Z, w.P, w.plate, w.C, w.H, w.L)
        put(q, out[k])
        inv_kf[k] = value
    return FOLLOWED, N


def follow_path(
    chain: ChainArrays,
    settings: FollowerSettings,
    targets: Array,
    q_reference: Array,
    state: FollowState,
    limits: Array,
    out: Array,
    inv_kf: Array,
) -> tuple[int, int]:
    """Follow targets (N, 4, 4), base_T_target, from `state`, which is brought to the path's end.

    q_reference: (N, n) reference postures (one row for all points: shape (1, n)). limits: (N, n) how far self-motion
    may take each joint at a point. Fills out (N, n) and inv_kf (N,). Returns (FOLLOWED, N), or why and at which point it
    failed; `state` is then the posture that was reached there.
    """
    n = out.shape[1]
    code, reached = _follow(
        chain, settings, targets, q_reference, state, limits, out, inv_kf, np.empty(n), follower_work(n), history(n)
    )
    return int(code), int(reached)
