"""Compiled kinematics of a chain of revolute and prismatic joints, one posture a call, float64.

Every kernel has a plain NumPy twin in the tests. Jacobians are geometric: rows (v, w) of the tool in `base`, velocity of
the tool's origin first. Out-parameters are overwritten; nothing is allocated in the inner loop of a solver. So its functions
are compiled without reference counts (`_nrt=False`): counting those of some forty arrays a call took most of a step's time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import bare, inlined, kernel, part
from camrob.kinematics.spherical_inverse import closed_inverse_kf, sine_cosine, wrist_distance

__all__ = [
    "ChainArrays",
    "chain_arrays",
    "forward",
    "forward_many",
    "gram_factor",
    "inverse_kf",
    "inverse_kf_many",
    "jacobian",
]

Array = NDArray[np.float64]


class ChainArrays(NamedTuple):
    """A cell's chain as arrays, in the order base to tool.

    first (4, 4); after (n, 4, 4) constant transforms behind each joint's motion; prismatic (n,); plate: where the mounting
    plate's origin lies in the frame of the arm's last joint, after its motion; arm: indices [arm_start, arm_stop);
    length: the characteristic length, m. spherical: whether the arm's last three axes meet, wrist: how far along the fifth
    from its origin, m; then the arm's Jacobian has an inverse in closed form.
    """

    first: Array
    after: Array
    prismatic: NDArray[np.bool_]
    plate: Array
    arm_start: int
    arm_stop: int
    length: float
    spherical: bool
    wrist: float


def chain_arrays(cell: Cell) -> ChainArrays:
    """The cell's chain, tool included, with all constant transforms merged."""
    joints = cell.joints
    n = len(joints)
    first = cell.base_T_first @ joints[0].before
    after = np.empty((n, 4, 4))
    arm = cell.indices(Role.ARM)
    for i, joint in enumerate(joints):
        after[i] = joint.after
        if i == arm[-1]:
            after[i] = after[i] @ cell.wrist_T_flange @ cell.flange_T_tool
        if i + 1 < n:
            after[i] = after[i] @ joints[i + 1].before
    plate = (joints[arm[-1]].after @ cell.wrist_T_flange)[:3, 3].copy()
    wrist = wrist_distance(after[arm[3]], after[arm[4]]) if len(arm) == 6 else float("nan")
    return ChainArrays(
        np.ascontiguousarray(first),
        after,
        np.array([j.prismatic for j in joints]),
        plate,
        int(arm[0]),
        int(arm[-1]) + 1,
        float(cell.condition_length),
        bool(np.isfinite(wrist)) and not any(joints[i].prismatic for i in arm),
        wrist,
    )


@bare
def forward(chain: ChainArrays, q: Array, Z: Array, P: Array, R: Array, p: Array, plate: Array) -> None:
    """Forward kinematics of posture q (n,).

    Fills Z (n, 3) and P (n, 3), the joints' axes and points on them in `base`, before their motion; R (3, 3) and p (3,),
    the tool in `base`; plate (3,), the mounting plate's origin in `base`.
    """
    first, last = chain.first, chain.arm_stop - 1
    ax, bx, cx, px = first[0, 0], first[0, 1], first[0, 2], first[0, 3]  # the axes' components stay in registers
    ay, by, cy, py = first[1, 0], first[1, 1], first[1, 2], first[1, 3]
    az, bz, cz, pz = first[2, 0], first[2, 1], first[2, 2], first[2, 3]
    for i in range(q.shape[0]):
        Z[i, 0], Z[i, 1], Z[i, 2] = cx, cy, cz
        P[i, 0], P[i, 1], P[i, 2] = px, py, pz
        if chain.prismatic[i]:
            px, py, pz = px + cx * q[i], py + cy * q[i], pz + cz * q[i]
        else:
            si, co = sine_cosine(q[i])
            ax, bx = ax * co + bx * si, bx * co - ax * si
            ay, by = ay * co + by * si, by * co - ay * si
            az, bz = az * co + bz * si, bz * co - az * si
        if i == last:
            u, v, w = chain.plate[0], chain.plate[1], chain.plate[2]
            plate[0] = px + ax * u + bx * v + cx * w
            plate[1] = py + ay * u + by * v + cy * w
            plate[2] = pz + az * u + bz * v + cz * w
        u, v, w = chain.after[i, 0, 3], chain.after[i, 1, 3], chain.after[i, 2, 3]
        px, py, pz = px + ax * u + bx * v + cx * w, py + ay * u + by * v + cy * w, pz + az * u + bz * v + cz * w
        u0, u1, u2 = chain.after[i, 0, 0], chain.after[i, 0, 1], chain.after[i, 0, 2]
        v0, v1, v2 = chain.after[i, 1, 0], chain.after[i, 1, 1], chain.after[i, 1, 2]
        w0, w1, w2 = chain.after[i, 2, 0], chain.after[i, 2, 1], chain.after[i, 2, 2]
        ax, bx, cx = ax * u0 + bx * v0 + cx * w0, ax * u1 + bx * v1 + cx * w1, ax * u2 + bx * v2 + cx * w2
        ay, by, cy = ay * u0 + by * v0 + cy * w0, ay * u1 + by * v1 + cy * w1, ay * u2 + by * v2 + cy * w2
        az, bz, cz = az * u0 + bz * v0 + cz * w0, az * u1 + bz * v1 + cz * w1, az * u2 + bz * v2 + cz * w2
    R[0, 0], R[0, 1], R[0, 2], p[0] = ax, bx, cx, px
    R[1, 0], R[1, 1], R[1, 2], p[1] = ay, by, cy, py
    R[2, 0], R[2, 1], R[2, 2], p[2] = az, bz, cz, pz


@bare
def jacobian(chain: ChainArrays, Z: Array, P: Array, point: Array, J: Array) -> None:
    """Geometric Jacobian J (6, n), rows (v, w), of a point (3,) of the tool, from the axes that `forward` filled."""
    for i in range(Z.shape[0]):
        if chain.prismatic[i]:
            for r in range(3):
                J[r, i] = Z[i, r]
                J[3 + r, i] = 0.0
        else:
            dx, dy, dz = point[0] - P[i, 0], point[1] - P[i, 1], point[2] - P[i, 2]
            J[0, i] = Z[i, 1] * dz - Z[i, 2] * dy
            J[1, i] = Z[i, 2] * dx - Z[i, 0] * dz
            J[2, i] = Z[i, 0] * dy - Z[i, 1] * dx
            for r in range(3):
                J[3 + r, i] = Z[i, r]


@bare
def gram_factor(H: Array, L: Array, m: int) -> float:
    """Lower half of L (6, 6) <- the Cholesky factor of H H^T, H (6, m).

    Returns the trace of H H^T, inf where that is singular.
    """
    trace = 0.0
    for r in range(6):
        for c in range(r + 1):
            s = 0.0
            for k in range(m):
                s += H[r, k] * H[c, k]
            if r == c:
                trace += s
            for k in range(c):
                s -= L[r, k] * L[c, k]
            if r == c:
                if s <= 1e-15:
                    return np.inf
                L[r, r] = np.sqrt(s)
            else:
                L[r, c] = s / L[c, c]
    return trace


@part
def _inverse_kf_by_cholesky(chain: ChainArrays, Z: Array, P: Array, plate: Array) -> float:
    """`inverse_kf` of any arm, by the inverse's trace from a Cholesky factor."""
    m = chain.arm_stop - chain.arm_start
    H = np.empty((6, m))
    scale = 1.0 / chain.length
    for k in range(m):
        i = chain.arm_start + k
        dx, dy, dz = plate[0] - P[i, 0], plate[1] - P[i, 1], plate[2] - P[i, 2]
        H[0, k] = (Z[i, 1] * dz - Z[i, 2] * dy) * scale
        H[1, k] = (Z[i, 2] * dx - Z[i, 0] * dz) * scale
        H[2, k] = (Z[i, 0] * dy - Z[i, 1] * dx) * scale
        H[3, k] = Z[i, 0]
        H[4, k] = Z[i, 1]
        H[5, k] = Z[i, 2]
    # Cholesky factor of H H^T, then the trace of the inverse from the inverse factor
    L = np.zeros((6, 6))
    trace = gram_factor(H, L, m)
    if trace == np.inf:
        return 0.0
    trace_inverse = 0.0
    for c in range(6):  # column c of the inverse of L
        x0 = np.zeros(6)
        x0[c] = 1.0 / L[c, c]
        trace_inverse += x0[c] * x0[c]
        for r in range(c + 1, 6):
            s = 0.0
            for k in range(c, r):
                s -= L[r, k] * x0[k]
            x0[r] = s / L[r, r]
            trace_inverse += x0[r] * x0[r]
    return float(6.0 / np.sqrt(trace * trace_inverse))


@inlined
def inverse_kf(chain: ChainArrays, Z: Array, P: Array, plate: Array) -> float:
    """1/k_F of the bare arm's homogeneous Jacobian at the mounting plate, 0 where it is singular.

    k_F = sqrt(tr(H H^T) tr((H H^T)^-1)) / 6 (eq. 16), the rows of length divided by the characteristic length. The
    frame of the twist doesn't matter, so the arm's columns of the whole chain are used.
    """
    if chain.spherical:
        return float(closed_inverse_kf(Z, P, plate, chain.arm_start, chain.wrist, chain.length))
    return float(_inverse_kf_by_cholesky(chain, Z, P, plate))


@kernel(nogil=True)
def forward_many(chain: ChainArrays, q: Array) -> Array:
    """Tool poses (N, 4, 4) in `base` of postures q (N, n)."""
    n = q.shape[1]
    Z, P = np.empty((n, 3)), np.empty((n, 3))
    R, p, plate = np.empty((3, 3)), np.empty(3), np.empty(3)
    out = np.zeros((q.shape[0], 4, 4))
    for k in range(q.shape[0]):
        forward(chain, q[k], Z, P, R, p, plate)
        for r in range(3):
            out[k, r, 0], out[k, r, 1], out[k, r, 2], out[k, r, 3] = R[r, 0], R[r, 1], R[r, 2], p[r]
        out[k, 3, 3] = 1.0
    return out


@kernel(nogil=True)
def inverse_kf_many(chain: ChainArrays, q: Array) -> Array:
    """1/k_F (N,) of the bare arm in postures q (N, n)."""
    n = q.shape[1]
    Z, P = np.empty((n, 3)), np.empty((n, 3))
    R, p, plate = np.empty((3, 3)), np.empty(3), np.empty(3)
    out = np.empty(q.shape[0])
    for k in range(q.shape[0]):
        forward(chain, q[k], Z, P, R, p, plate)
        out[k] = inverse_kf(chain, Z, P, plate)
    return out
