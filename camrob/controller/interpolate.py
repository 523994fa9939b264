"""Compiled interpolation of motions: a place on the path in, pose and posture out.

A motion runs over `size` (m of path, see `pieces`): LIN straight, CIRC on its circle, PTP straight in the axes; rotation along
the great arc and external axes in proportion. Where motion A is rounded off into B within `d` of the corner, the rest of A
and the beginning of B are superposed: at tau in [-d, d] the tool is at A's end less (d - tau)^2 / 4d, carried on by
(d + tau)^2 / 4d of B. Position, rotation and external axes then change direction evenly (a parabola), and leave and meet the
motions with their own rates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.controller.pose_kernel import circle, foot, rotation_vector, turned
from camrob.kinematics.kernels import ChainArrays, forward
from camrob.kinematics.spherical_wrist import SphericalArm, nearest_solution, solve_arm

__all__ = [
    "ARC",
    "LINE",
    "PTP",
    "REACHED",
    "Machine",
    "Motions",
    "Pieces",
    "lay_motions",
    "nearest_to_corner",
    "postures",
    "to_world",
    "trace",
]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PTP, LINE, ARC = 0, 1, 2
REACHED, OUT_OF_REACH, JUMP = 0, 1, 2


class Machine(NamedTuple):
    """A cell for the kernels: k joints carry the arm's foot.

    fixed: (k + 1, 4, 4) constant transforms around them. held: (k,) values that stand in for the joints where the frame
    of the poses does not move with them, NaN where the joint's own value counts.
    """

    chain: ChainArrays
    fixed: Array
    arm: SphericalArm
    held: Array


class Motions(NamedTuple):
    """M motions, each from row i to row i + 1 of R (M + 1, 3, 3), p (M + 1, 3), e (M + 1, k) and q (M + 1, n).

    kind: (M,) PTP, LINE or ARC. w: (M, 3) rotation vector in the axes of the start. center, u, v (M, 3) and angle (M,)
    of arcs. size: (M,) of its path parameter. e and q are the chain's; q counts for PTP only.
    """

    kind: NDArray[np.int8]
    R: Array
    p: Array
    e: Array
    q: Array
    w: Array
    center: Array
    u: Array
    v: Array
    angle: Array
    size: Array


class Pieces(NamedTuple):
    """The path in P pieces, smooth within each.

    motion: (P,) that it belongs to (of a rounding: the one before the corner). blend: (P,) how far a rounding reaches to
    both sides of its corner, 0 where the piece is part of one motion. start: (P,) where in that motion it begins; length:
    (P,); steps: (P,) equal steps that it is divided in; first: (P,) its first node, `steps` nodes before the next piece's.
    """

    motion: Indices
    blend: Array
    start: Array
    length: Array
    steps: Indices
    first: Indices


@kernel(nogil=True)
def lay_motions(motions: Motions, via: Array, sweep: Array, length: Array, turn: Array) -> None:
    """Fill w, center, u, v, angle of motions and their length and turn (M,), m and rad, from their ends.

    via: (M, 3) of arcs. sweep: (M,) rad, CA, NaN where the arc ends at its target; else its end is put where CA says.
    An arc over three points on a line becomes a line.
    """
    for m in range(motions.kind.shape[0]):
        p0, p1 = motions.p[m], motions.p[m + 1]
        rotation_vector(motions.R[m], motions.R[m + 1], motions.w[m])
        turn[m] = np.sqrt(np.sum(motions.w[m] ** 2))
        if motions.kind[m] == ARC:
            angle = circle(p0, via[m], p1, motions.center[m], motions.u[m], motions.v[m])
            if angle == 0.0:
                motions.kind[m] = LINE
            elif not np.isnan(sweep[m]):
                angle = sweep[m]
                for r in range(3):
                    p1[r] = motions.center[m, r] + np.cos(angle) * motions.u[m, r] + np.sin(angle) * motions.v[m, r]
            motions.angle[m] = angle
        if motions.kind[m] == ARC:
            length[m] = abs(motions.angle[m]) * np.sqrt(np.sum(motions.u[m] ** 2))
        else:
            length[m] = np.sqrt(np.sum((p1 - p0) ** 2))


@part
def _point(motions: Motions, m: int, share: float, p: Array) -> None:
    """Position of the tool at a share of motion m."""
    if motions.kind[m] == ARC:
        angle = share * motions.angle[m]
        co, si = np.cos(angle), np.sin(angle)
        for r in range(3):
            p[r] = motions.center[m, r] + co * motions.u[m, r] + si * motions.v[m, r]
    else:
        for r in range(3):
            p[r] = motions.p[m, r] + share * (motions.p[m + 1, r] - motions.p[m, r])


@part
def _on_motion(motions: Motions, m: int, s: float, p: Array, R: Array, e: Array) -> None:
    """Pose and external axes at s of motion m, which is no PTP."""
    share = s / motions.size[m]
    _point(motions, m, share, p)
    turned(motions.R[m], motions.w[m], share, R)
    for i in range(e.shape[0]):
        e[i] = motions.e[m, i] + share * (motions.e[m + 1, i] - motions.e[m, i])


@part
def _in_blend(motions: Motions, m: int, d: float, tau: float, p: Array, R: Array, e: Array) -> None:
    """Pose and external axes at tau of the rounding, reaching d to both sides, of the corner behind motion m."""
    p1, R1, e1, turn = np.empty(3), np.empty((3, 3)), np.empty(e.shape[0]), np.empty((3, 3))
    _on_motion(motions, m, motions.size[m] - (d - tau) ** 2 / (4.0 * d), p, R, e)
    _on_motion(motions, m + 1, (d + tau) ** 2 / (4.0 * d), p1, R1, e1)
    corner = motions.R[m + 1]
    for r in range(3):
        p[r] += p1[r] - motions.p[m + 1, r]
        for c in range(3):
            turn[r, c] = corner[0, r] * R1[0, c] + corner[1, r] * R1[1, c] + corner[2, r] * R1[2, c]
    for r in range(3):
        a, b, c3 = R[r, 0], R[r, 1], R[r, 2]
        for c in range(3):
            R[r, c] = a * turn[0, c] + b * turn[1, c] + c3 * turn[2, c]
    for i in range(e.shape[0]):
        e[i] += e1[i] - motions.e[m + 1, i]


@part
def _ptp(motions: Motions, m: int, d: float, s: float, q: Array) -> None:
    """Posture at s of PTP m, or at s from the beginning of the rounding between it and the next."""
    before = motions.size[m] - (2.0 * d - s) ** 2 / (4.0 * d) if d > 0.0 else s
    share = before / motions.size[m]
    after = s * s / (4.0 * d) / motions.size[m + 1] if d > 0.0 else 0.0
    for i in range(q.shape[0]):
        q[i] = motions.q[m, i] + share * (motions.q[m + 1, i] - motions.q[m, i])
        if d > 0.0:
            q[i] += after * (motions.q[m + 2, i] - motions.q[m + 1, i])


@part
def _place(
    machine: Machine, motions: Motions, pieces: Pieces, k: int, s: float, near: Array, q: Array, p: Array, R: Array
) -> float:
    """Posture q (n,) and tool p, R at s from the beginning of piece k, on the branch nearest to `near` (6,).

    Returns how far an axis of the arm is from `near`, inf where the pose is out of reach. Of a PTP the tool is in `base`.
    """
    chain = machine.chain
    m, d = pieces.motion[k], pieces.blend[k]
    if motions.kind[m] == PTP:
        n = q.shape[0]
        _ptp(motions, m, d, s if d > 0.0 else pieces.start[k] + s, q)
        Z, P, plate = np.empty((n, 3)), np.empty((n, 3)), np.empty(3)
        forward(chain, q, Z, P, R, p, plate)
        return 0.0
    e = q[: chain.arm_start]
    if d > 0.0:
        _in_blend(motions, m, d, s - d, p, R, e)
    else:
        _on_motion(motions, m, pieces.start[k] + s, p, R, e)
    at, Rf, pf, Ra, pa = e.copy(), np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty(3)
    for i in range(chain.arm_start):
        if not np.isnan(machine.held[i]):
            at[i] = machine.held[i]
    foot(chain, machine.fixed, at, Rf, pf)
    for r in range(3):
        pa[r] = Rf[0, r] * (p[0] - pf[0]) + Rf[1, r] * (p[1] - pf[1]) + Rf[2, r] * (p[2] - pf[2])
        for c in range(3):
            Ra[r, c] = Rf[0, r] * R[0, c] + Rf[1, r] * R[1, c] + Rf[2, r] * R[2, c]
    Q, why = np.empty((8, 6)), np.empty(8, np.int64)
    if solve_arm(machine.arm, Ra, pa, near, Q, why) == 0:
        return np.inf
    best, nearest = nearest_solution(Q, why, near)
    for i in range(6):
        q[chain.arm_start + i] = Q[best, i]
    return float(nearest)


@kernel(nogil=True)
def trace(
    machine: Machine, motions: Motions, pieces: Pieces, start_q: Array, jump: float, q: Array, p: Array
) -> tuple[int, int]:
    """Postures q (K, n) and tool positions p (K, 3) at all nodes, followed from posture start_q (n,).

    Returns (REACHED, OUT_OF_REACH or JUMP, the piece where it ended); a JUMP is an axis of the arm that would have to move
    more than `jump` rad between nodes.
    """
    R, near, here = np.empty((3, 3)), np.empty(6), start_q.copy()
    arm = machine.chain.arm_start
    q[0] = start_q
    for k in range(pieces.motion.shape[0]):
        count, first = pieces.steps[k], pieces.first[k]
        step = pieces.length[k] / count
        leaves_ptp = k > 0 and motions.kind[pieces.motion[k]] != PTP and motions.kind[pieces.motion[k - 1]] == PTP
        for j in range(0 if k == 0 or leaves_ptp else 1, count + 1):
            for i in range(6):
                near[i] = here[arm + i]
            far = _place(machine, motions, pieces, k, j * step, near, here, p[first + j], R)
            if far > jump:
                return (OUT_OF_REACH if np.isinf(far) else JUMP), k
            q[first + j] = here
    return REACHED, pieces.motion.shape[0]


@kernel(nogil=True)
def postures(
    machine: Machine,
    motions: Motions,
    pieces: Pieces,
    piece: Indices,
    at: Array,
    near: Array,
    q: Array,
    p: Array,
    R: Array,
) -> int:
    """Postures q (N, n) and tool p (N, 3), R (N, 3, 3) at `at` (N,) from the beginnings of pieces (N,).

    near: (N, n) postures close by. Returns N, or the first row that is out of reach.
    """
    arm = machine.chain.arm_start
    for i in range(piece.shape[0]):
        if np.isinf(_place(machine, motions, pieces, piece[i], at[i], near[i, arm : arm + 6], q[i], p[i], R[i])):
            return i
    return int(piece.shape[0])


@kernel(nogil=True)
def nearest_to_corner(motions: Motions, blend: Array) -> Array:
    """How far (M,) the rounding behind each motion, reaching blend (M,) to both sides, keeps from its corner, m."""
    out = np.zeros(blend.shape[0])
    before, behind = np.empty(3), np.empty(3)
    for m in range(blend.shape[0]):
        d = blend[m]
        if d > 0.0 and motions.kind[m] != PTP:
            least = np.inf
            for j in range(-4, 5):
                tau = 0.125 * j * d
                _point(motions, m, 1.0 - (d - tau) ** 2 / (4.0 * d) / motions.size[m], before)
                _point(motions, m + 1, (d + tau) ** 2 / (4.0 * d) / motions.size[m + 1], behind)
                way = 0.0
                for r in range(3):
                    way += (before[r] + behind[r] - 2.0 * motions.p[m + 1, r]) ** 2
                least = min(least, way)
            out[m] = np.sqrt(least)
    return out


@kernel(nogil=True)
def to_world(
    carrier: ChainArrays, fixed: Array, zero: Array, q: Array, turning: NDArray[np.bool_], p: Array, R: Array
) -> None:
    """Tool p (N, 3), R (N, 3, 3) from `base` into `world`, in place, in the rows that `turning` (N,) names.

    carrier: a chain whose first joints, up to `arm_start`, carry the workpiece, `fixed` (arm_start + 1, 4, 4) around them;
    zero, q (N, n): postures in which `base` is `world`, and of the rows.
    """
    R0, p0, R1, p1 = np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty(3)
    at, a = np.empty(3), np.empty((3, 3))
    foot(carrier, fixed, zero, R0, p0)
    for i in range(q.shape[0]):
        if not turning[i]:
            continue
        foot(carrier, fixed, q[i], R1, p1)
        for r in range(3):
            at[r] = R1[0, r] * (p[i, 0] - p1[0]) + R1[1, r] * (p[i, 1] - p1[1]) + R1[2, r] * (p[i, 2] - p1[2])
            for c in range(3):
                a[r, c] = R1[0, r] * R[i, 0, c] + R1[1, r] * R[i, 1, c] + R1[2, r] * R[i, 2, c]
        for r in range(3):
            p[i, r] = p0[r] + R0[r, 0] * at[0] + R0[r, 1] * at[1] + R0[r, 2] * at[2]
            for c in range(3):
                R[i, r, c] = R0[r, 0] * a[0, c] + R0[r, 1] * a[1, c] + R0[r, 2] * a[2, c]
