"""Compiled replay of continuous-path motions: interpolate as the controller does, invert the arm, watch what it does.

The arm is inverted in closed form along the interpolated path, so nothing of the solver (Newton steps on the whole chain)
is used again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined, kernel
from camrob.controller.pose_kernel import circle, foot, rotation_vector, turned
from camrob.kinematics.arm import nearest_branch
from camrob.kinematics.kernels import ChainArrays, forward, inverse_kf
from camrob.kinematics.spherical_wrist import SphericalArm
from camrob.triples import between, cross, dot, gap2

__all__ = ["CODES", "ReplayArm", "ReplayRun", "replay_run"]

Array = NDArray[np.float64]

CODES = ("followed", "out of reach", "jump")
_FOLLOWED, _OUT_OF_REACH, _JUMP = 0, 1, 2


class ReplayRun(NamedTuple):
    """What `replay_run` fills, a row a motion.

    q (N, n) at its end; lower_margin and upper_margin (N, n), least distance of q to its limits on the way (negative:
    beyond); inv_kf (N,) least 1/k_F and bend (N,) least |sin| of the wrist's bend on the way; jump (N,) the farthest that
    a joint of the arm moved between two samples.
    """

    q: Array
    lower_margin: Array
    upper_margin: Array
    inv_kf: Array
    bend: Array
    jump: Array


class ReplayArm(NamedTuple):
    """The cell in the replay's terms: the whole chain, what carries the arm's foot, and the arm's inverse."""

    chain: ChainArrays
    fixed: Array  # (arm_start + 1, 4, 4) before, between and behind the joints that carry the foot
    closed: SphericalArm
    arm_chain: ChainArrays | None  # where there is no closed form
    lower: Array
    upper: Array


class _Motion(NamedTuple):
    """Scratch: the motion's start and course, the sample on it, and the inverse's."""

    R0: Array
    p0: Array
    e0: Array
    w: Array
    center: Array
    u: Array
    v: Array
    R: Array
    p: Array
    R_foot: Array
    p_foot: Array
    R_arm: Array
    p_arm: Array
    near: Array
    q: Array
    Q: Array
    why: NDArray[np.int64]
    last: NDArray[np.int64]
    apart: Array
    Z: Array
    P: Array
    R_tool: Array
    p_tool: Array
    plate: Array


@inlined
def _put(source: Array, out: Array) -> None:
    for i in range(out.shape[0]):
        out[i] = source[i]


@inlined
def _motion(start_q: Array, start_R: Array, start_p: Array, arm_start: int) -> _Motion:
    n = start_q.shape[0]
    return _Motion(
        start_R.copy(),
        start_p.copy(),
        start_q[:arm_start].copy(),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty((3, 3)),
        np.empty(3),
        np.empty((3, 3)),
        np.empty(3),
        np.empty((3, 3)),
        np.empty(3),
        start_q[arm_start : arm_start + 6].copy(),
        start_q.copy(),
        np.empty((8, 6)),
        np.empty(8, np.int64),
        np.full(1, -1),
        np.empty(3),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(3),
    )


@inlined
def _sample(arm: ReplayArm, m: _Motion, s: float, angle: float, p_end: Array, external: Array) -> None:
    """Put the sample at the share s of the motion: tool pose, external axes, and the tool seen from the foot."""
    if angle > 0.0:
        co, si = np.cos(s * angle), np.sin(s * angle)
        for r in range(3):
            m.p[r] = m.center[r] + co * m.u[r] + si * m.v[r]
    else:
        for r in range(3):
            m.p[r] = m.p0[r] + s * (p_end[r] - m.p0[r])
    turned(m.R0, m.w, s, m.R)
    for i in range(arm.chain.arm_start):
        m.q[i] = m.e0[i] + s * (external[i] - m.e0[i])
    foot(arm.chain, arm.fixed, m.q, m.R_foot, m.p_foot)
    for r in range(3):
        m.p_arm[r] = 0.0
        for k in range(3):
            m.p_arm[r] += m.R_foot[k, r] * (m.p[k] - m.p_foot[k])
        for c in range(3):
            m.R_arm[r, c] = m.R_foot[0, r] * m.R[0, c] + m.R_foot[1, r] * m.R[1, c] + m.R_foot[2, r] * m.R[2, c]


@inlined
def _watch(arm: ReplayArm, m: _Motion, row: int, out: ReplayRun) -> None:
    """Take the sample's posture into the row's least margins, 1/k_F and bend."""
    chain = arm.chain
    forward(chain, m.q, m.Z, m.P, m.R_tool, m.p_tool, m.plate)
    out.inv_kf[row] = min(out.inv_kf[row], inverse_kf(chain, m.Z, m.P, m.plate))
    a4, a6 = m.Z[chain.arm_start + 3], m.Z[chain.arm_start + 5]
    across = cross(a4, a6)
    out.bend[row] = min(out.bend[row], np.sqrt(dot(across, across)))
    for i in range(m.q.shape[0]):
        out.lower_margin[row, i] = min(out.lower_margin[row, i], m.q[i] - arm.lower[i])
        out.upper_margin[row, i] = min(out.upper_margin[row, i], arm.upper[i] - m.q[i])


@inlined
def _samples(
    arm: ReplayArm, m: _Motion, angle: float, R_end: Array, p_end: Array, external: Array, steps: Array
) -> int:
    """How many samples a motion takes; m.w becomes its rotation."""
    rotation_vector(m.R0, R_end, m.w)
    turn = np.sqrt(m.w[0] * m.w[0] + m.w[1] * m.w[1] + m.w[2] * m.w[2])
    length = np.sqrt(gap2(m.p0, p_end)) if angle == 0.0 else angle * np.sqrt(dot(m.u, m.u))
    count = max(int(steps[2]), int(np.ceil(length / steps[0])), int(np.ceil(turn / steps[1])))
    for i in range(arm.chain.arm_start):
        span = abs(external[i] - m.e0[i])
        count = max(count, int(np.ceil(span / (steps[0] if arm.chain.prismatic[i] else steps[1]))))
    return count


@kernel(nogil=True)
def replay_run(
    arm: ReplayArm,
    start_q: Array,
    start_R: Array,
    start_p: Array,
    R: Array,
    p: Array,
    external: Array,
    via: NDArray[np.bool_],
    steps: Array,
    jump_limit: float,
    out: ReplayRun,
) -> tuple[int, int, int]:
    """Replay N motions (LIN, or CIRC over two rows) from posture start_q (n,), whose tool is at start_R, start_p.

    R (N, 3, 3), p (N, 3): the rows' poses in `base`; external (N, arm_start): q of the joints before the arm. via (N,): rows
    that are a CIRC's auxiliary point. steps: m, rad between samples, and the least number of samples a motion. Returns
    (code, row it stopped at, samples).
    """
    m = _motion(start_q, start_R, start_p, arm.chain.arm_start)
    samples, k = 0, 0
    while k < p.shape[0]:
        last = k + 1 if via[k] and k + 1 < p.shape[0] else k
        angle, via_at = 0.0, 0.0
        if last > k:
            angle = circle(m.p0, p[k], p[last], m.center, m.u, m.v)
            if angle > 0.0:
                d = between(m.center, p[k])
                at = np.arctan2(dot(d, m.v), dot(d, m.u))
                via_at = (at if at > 0.0 else at + 2.0 * np.pi) / angle
        count = _samples(arm, m, angle, R[last], p[last], external[last], steps)
        via_sample = max(1, min(count - 1, int(np.round(via_at * count))))
        out.inv_kf[last], out.bend[last], out.jump[last] = np.inf, np.inf, 0.0
        for i in range(m.q.shape[0]):
            out.lower_margin[last, i], out.upper_margin[last, i] = np.inf, np.inf
        for j in range(1, count + 1):
            samples += 1
            _sample(arm, m, j / count, angle, p[last], external[last])
            moved = nearest_branch(arm.closed, arm.arm_chain, m.R_arm, m.p_arm, m.near, m.Q, m.why, m.last, m.apart)
            if moved < 0.0:
                return _OUT_OF_REACH, last, samples
            out.jump[last] = max(out.jump[last], moved)
            if moved > jump_limit:
                return _JUMP, last, samples
            for i in range(6):
                m.q[arm.chain.arm_start + i] = m.near[i]
            _watch(arm, m, last, out)
            if last > k and j == via_sample:
                _put(m.q, out.q[k])
        _put(m.q, out.q[last])
        if last > k:
            out.inv_kf[k], out.bend[k], out.jump[k] = out.inv_kf[last], out.bend[last], out.jump[last]
            _put(out.lower_margin[last], out.lower_margin[k])
            _put(out.upper_margin[last], out.upper_margin[k])
        for r in range(3):
            _put(R[last, r], m.R0[r])
        _put(p[last], m.p0)
        _put(external[last], m.e0)
        k = last + 1
    return _FOLLOWED, p.shape[0], samples
