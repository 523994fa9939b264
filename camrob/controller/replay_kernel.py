"""Compiled replay of continuous-path motions: interpolate as the controller does, invert the arm, watch what it does.

The arm is inverted in closed form along the interpolated path, so nothing of the solver (Newton steps on the whole chain)
is used again.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

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


@numba.njit(cache=True)
def _rotation_vector(A: Array, B: Array, out: Array) -> None:
    """out <- rotation vector of A^T B, in A's axes."""
    m = np.empty((3, 3))
    for r in range(3):
        for c in range(3):
            m[r, c] = A[0, r] * B[0, c] + A[1, r] * B[1, c] + A[2, r] * B[2, c]
    v0, v1, v2 = 0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1])
    sine = np.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    if sine > 1e-7:
        out[0], out[1], out[2] = v0 * angle / sine, v1 * angle / sine, v2 * angle / sine
    elif cosine > 0.0:
        out[0], out[1], out[2] = v0, v1, v2
    else:  # half a turn: the controller may take either way; the axis with the largest share decides
        i = int(np.argmax(np.array([m[0, 0], m[1, 1], m[2, 2]])))
        norm = np.sqrt(max(1e-12, 0.5 * (1.0 + m[i, i])))
        for r in range(3):
            out[r] = np.pi * (norm if r == i else 0.5 * m[r, i] / norm)


@numba.njit(cache=True)
def _turned(A: Array, w: Array, s: float, out: Array) -> None:
    """out <- A exp(s w)."""
    angle = s * np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-12:
        out[:] = A
        return
    k = s / angle
    x, y, z = w[0] * k, w[1] * k, w[2] * k
    c, si = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    e = np.array(
        [
            [c + x * x * t, x * y * t - z * si, x * z * t + y * si],
            [y * x * t + z * si, c + y * y * t, y * z * t - x * si],
            [z * x * t - y * si, z * y * t + x * si, c + z * z * t],
        ]
    )
    for r in range(3):
        for col in range(3):
            out[r, col] = A[r, 0] * e[0, col] + A[r, 1] * e[1, col] + A[r, 2] * e[2, col]


@numba.njit(cache=True)
def _circle(a: Array, via: Array, b: Array, center: Array, u: Array, v: Array) -> float:
    """Centre, and axes u, v so that the arc from a over via to b is centre + cos u + sin v; returns its angle, 0 if flat."""
    ab, ac = via - a, b - a
    normal = np.cross(ab, ac)
    n2 = np.sum(normal * normal)
    if n2 < 1e-20:
        return 0.0
    center[:] = a + (np.sum(ab * ab) * np.cross(ac, normal) + np.sum(ac * ac) * np.cross(normal, ab)) / (2.0 * n2)
    normal = normal / np.sqrt(n2)
    u[:] = a - center
    v[:] = np.cross(normal, u)
    d = b - center
    angle = np.arctan2(np.sum(d * v), np.sum(d * u))
    return float(angle if angle > 0.0 else angle + 2.0 * np.pi)


@numba.njit(cache=True)
def _foot(chain: ChainArrays, fixed: Array, q: Array, R: Array, p: Array) -> None:
    """Pose of the arm's foot in `base`: the joints before the arm, with `fixed` (arm_start + 1, 4, 4) around them."""
    for r in range(3):
        p[r] = fixed[0, r, 3]
        for c in range(3):
            R[r, c] = fixed[0, r, c]
    for i in range(chain.arm_start):
        if chain.prismatic[i]:
            for r in range(3):
                p[r] += R[r, 2] * q[i]
        else:
            co, si = np.cos(q[i]), np.sin(q[i])
            for r in range(3):
                a, b = R[r, 0], R[r, 1]
                R[r, 0], R[r, 1] = a * co + b * si, b * co - a * si
        F = fixed[i + 1]
        for r in range(3):
            a, b, c3 = R[r, 0], R[r, 1], R[r, 2]
            p[r] += a * F[0, 3] + b * F[1, 3] + c3 * F[2, 3]
            for c in range(3):
                R[r, c] = a * F[0, c] + b * F[1, c] + c3 * F[2, c]


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
            angle = _circle(p0, p[k], p[last], center, u, v)
            via_at = 0.0
            if angle > 0.0:
                d = p[k] - center
                via_at = np.arctan2(np.sum(d * v), np.sum(d * u))
                via_at = via_at / angle if via_at > 0.0 else (via_at + 2.0 * np.pi) / angle
        _rotation_vector(R0, R[last], w)
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
            _turned(R0, w, s, Rs)
            for i in range(chain.arm_start):
                q[i] = e0[i] + s * (external[last, i] - e0[i])
            _foot(chain, fixed, q, Rf, pf)
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
