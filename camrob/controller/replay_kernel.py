"""Compiled replay of continuous-path motions: interpolate as the controller does, invert the arm, watch what it does.

The arm is inverted in closed form along the interpolated path, so nothing of the solver (Newton steps on the whole chain)
is used again.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from camrob.controller.pose_kernel import circle, foot, rotation_vector, turned
from camrob.kinematics.kernels import ChainArrays, forward, inverse_kf
from camrob.kinematics.spherical_wrist import BRANCH_OK, SphericalArm, solve_arm

__all__ = ["CODES", "ReplayRun", "replay_run"]

Array = NDArray[np.float64]

CODES = ("followed", "out of reach", "jump")
_FOLLOWED, _OUT_OF_REACH, _JUMP = 0, 1, 2


class ReplayRun(NamedTuple):
    """What `replay_run` fills, a row a motion: q (N, n) at its end, lower_margin and upper_margin (N, n) least distance of
    q to its limits on the way (negative: beyond), inv_kf (N,) least 1/k_F on the way, bend (N,) the least bend of the
    wrist |sin|, jump (N,) the farthest that a joint of the arm moved between two samples, less what the path explains."""

    q: Array
    lower_margin: Array
    upper_margin: Array
    inv_kf: Array
    bend: Array
    jump: Array


@numba.njit(cache=True, nogil=True)
def replay_run(
    chain: ChainArrays, fixed: Array, arm: SphericalArm, lower: Array, upper: Array, start_q: Array, start_R: Array, start_p: Array,
    R: Array, p: Array, external: Array, kind: NDArray[np.int8], via_kind: int, end_kind: int, steps: Array, jump_limit: float,
    out: ReplayRun,
) -> tuple[int, int, int]:  # fmt: skip
    """Replay N motions (LIN, or CIRC over two rows) from posture start_q (n,), whose tool is at start_R, start_p.

    fixed (arm_start + 1, 4, 4): the constant transforms before, between and behind the joints that carry the arm's foot.
    R (N, 3, 3), p (N, 3): the rows' poses in `base`; external (N, arm_start): q of the joints before the arm. steps: m,
    rad between samples, and the least number of samples a motion. Returns (code, row it stopped at, samples).
    """
    N, n = p.shape[0], start_q.shape[0]
    q = start_q.copy()
    near = start_q[chain.arm_start : chain.arm_stop].copy()
    R0, p0 = start_R.copy(), start_p.copy()
    e0 = start_q[: chain.arm_start].copy()
    w, Rs, ps, Rf, pf = np.empty(3), np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty(3)
    Ra, pa = np.empty((3, 3)), np.empty(3)
    center, u, v = np.empty(3), np.empty(3), np.empty(3)
    Q, why = np.empty((8, 6)), np.empty(8, np.int64)
    Z, P, Rt, pt, plate = np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    samples = 0
    k = 0
    while k < N:
        last = k
        angle = 0.0
        if kind[k] == via_kind and k + 1 < N and kind[k + 1] == end_kind:
            last = k + 1
            angle = circle(p0, p[k], p[last], center, u, v)
            via_at = 0.0
            if angle > 0.0:
                d = p[k] - center
                via_at = np.arctan2(np.sum(d * v), np.sum(d * u))
                via_at = via_at / angle if via_at > 0.0 else (via_at + 2.0 * np.pi) / angle
        rotation_vector(R0, R[last], w)
        turn = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        length = np.sqrt(np.sum((p[last] - p0) ** 2)) if angle == 0.0 else angle * np.sqrt(np.sum(u * u))
        count = max(int(steps[2]), int(np.ceil(length / steps[0])), int(np.ceil(turn / steps[1])))
        for i in range(chain.arm_start):
            span = abs(external[last, i] - e0[i])
            count = max(count, int(np.ceil(span / (steps[0] if chain.prismatic[i] else steps[1]))))
        out.inv_kf[last], out.bend[last], out.jump[last] = np.inf, np.inf, 0.0
        for i in range(n):
            out.lower_margin[last, i] = out.upper_margin[last, i] = np.inf
        for j in range(1, count + 1):
            s = j / count
            if angle > 0.0:
                co, si = np.cos(s * angle), np.sin(s * angle)
                for r in range(3):
                    ps[r] = center[r] + co * u[r] + si * v[r]
            else:
                for r in range(3):
                    ps[r] = p0[r] + s * (p[last, r] - p0[r])
            turned(R0, w, s, Rs)
            for i in range(chain.arm_start):
                q[i] = e0[i] + s * (external[last, i] - e0[i])
            foot(chain, fixed, q, Rf, pf)
            for r in range(3):
                pa[r] = 0.0
                for m in range(3):
                    pa[r] += Rf[m, r] * (ps[m] - pf[m])
                for c in range(3):
                    Ra[r, c] = Rf[0, r] * Rs[0, c] + Rf[1, r] * Rs[1, c] + Rf[2, r] * Rs[2, c]
            samples += 1
            if solve_arm(arm, Ra, pa, near, Q, why) == 0:
                return _OUT_OF_REACH, last, samples
            best, nearest = -1, np.inf
            for b in range(8):
                if why[b] == BRANCH_OK:
                    far = 0.0
                    for i in range(6):
                        far = max(far, abs(Q[b, i] - near[i]))
                    if far < nearest:
                        best, nearest = b, far
            out.jump[last] = max(out.jump[last], nearest)
            if nearest > jump_limit:
                return _JUMP, last, samples
            for i in range(6):
                near[i] = Q[best, i]
                q[chain.arm_start + i] = near[i]
            forward(chain, q, Z, P, Rt, pt, plate)
            out.inv_kf[last] = min(out.inv_kf[last], inverse_kf(chain, Z, P, plate))
            a4, a6 = Z[chain.arm_start + 3], Z[chain.arm_start + 5]
            cross = np.cross(a4, a6)
            out.bend[last] = min(out.bend[last], np.sqrt(np.sum(cross * cross)))
            for i in range(n):
                out.lower_margin[last, i] = min(out.lower_margin[last, i], q[i] - lower[i])
                out.upper_margin[last, i] = min(out.upper_margin[last, i], upper[i] - q[i])
            if last > k and j == max(1, min(count - 1, int(np.round(via_at * count)))):
                out.q[k] = q
        out.q[last] = q
        if last > k:
            out.inv_kf[k], out.bend[k], out.jump[k] = out.inv_kf[last], out.bend[last], out.jump[last]
            out.lower_margin[k], out.upper_margin[k] = out.lower_margin[last], out.upper_margin[last]
        R0[:], p0[:] = R[last], p[last]
        for i in range(chain.arm_start):
            e0[i] = external[last, i]
        k = last + 1
    return _FOLLOWED, N, samples
