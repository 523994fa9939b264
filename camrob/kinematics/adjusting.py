"""Following a curve of points with an arm whose orientation is free: increments of the generalised vector, adjusted.

Three task rows and six joints: of all joint motions that move the tip as wanted, the pseudoinverse takes the one of least
norm. The posture q(s) is the curve that these motions add up to, so its derivatives along s are known in closed form:
with y solving J J^T y = x', q' = J^T y, and q'' and q''' follow by the product rule. In one line for the second,

    q'' = J+ (x'' - J' q') + (I - J+ J) J'^T (J J^T)^-1 x'

Duong and others (2020) print eq. 9, 10, 15 and 16 without the last term, which is zero for square Jacobians only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.errors import SingularError
from camrob.kinematics.frames import base_T_joint_axes, base_T_tool
from camrob.kinematics.kernels import ChainArrays, chain_arrays, forward, jacobian

__all__ = ["CurveInJoints", "follow_points", "joint_derivatives", "point_jacobians", "printed_derivatives"]

Array = NDArray[np.float64]

_TOLERANCE = 1e-12  # m
_ADJUSTMENTS = 50
_SINGULAR = 1e-6  # least singular value of J, m


class CurveInJoints(NamedTuple):
    """Postures q (N, n) along a curve, with first, second and third derivatives over the curve's parameter."""

    q: Array
    d1: Array
    d2: Array
    d3: Array


def point_jacobians(cell: Cell, q: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
    """Jacobian (N, 3, n) of the tip in `base`, with its first and second derivative along q with q' and q'', all (N, n).

    Exact: axes and points on them are carried through the chain with their first two derivatives.
    """
    axes = base_T_joint_axes(cell, q)
    tip = base_T_tool(cell, q)[..., :3, 3]
    count, n = q.shape
    z, p = axes[..., :3, 2], axes[..., :3, 3]
    z1, z2, p1, p2 = (np.zeros((n + 1, count, 3)) for _ in range(4))
    points = np.concatenate([p, tip[None]])
    omega, alpha = np.zeros((count, 3)), np.zeros((count, 3))
    for i, joint in enumerate(cell.joints):
        z1[i] = np.cross(omega, z[i])
        z2[i] = np.cross(alpha, z[i]) + np.cross(omega, z1[i])
        step = points[i + 1] - points[i]
        u, a = rate[:, i, None], second[:, i, None]
        slide1, slide2 = np.zeros((count, 3)), np.zeros((count, 3))
        if joint.prismatic:
            slide1, slide2 = u * z[i], a * z[i] + 2.0 * u * z1[i]
        else:
            omega, alpha = omega + u * z[i], alpha + a * z[i] + u * z1[i]
        turned = np.cross(omega, step)
        p1[i + 1] = p1[i] + turned + slide1
        p2[i + 1] = p2[i] + np.cross(alpha, step) + np.cross(omega, turned) + slide2
    J, J1, J2 = (np.empty((count, 3, n)) for _ in range(3))
    for i, joint in enumerate(cell.joints):
        if joint.prismatic:
            J[:, :, i], J1[:, :, i], J2[:, :, i] = z[i], z1[i], z2[i]
            continue
        r, r1, r2 = tip - p[i], p1[n] - p1[i], p2[n] - p2[i]
        J[:, :, i] = np.cross(z[i], r)
        J1[:, :, i] = np.cross(z1[i], r) + np.cross(z[i], r1)
        J2[:, :, i] = np.cross(z2[i], r) + 2.0 * np.cross(z1[i], r1) + np.cross(z[i], r2)
    return J, J1, J2


def joint_derivatives(cell: Cell, q: Array, x1: Array, x2: Array, x3: Array) -> CurveInJoints:
    """True derivatives of q along a curve of the tip with derivatives x1, x2, x3 (N, 3), at postures q (N, n) on it.

    Raises SingularError where the Jacobian has lost a direction.
    """
    zero = np.zeros_like(q)
    J = point_jacobians(cell, q, zero, zero)[0]
    least = np.linalg.svd(J, compute_uv=False)[:, -1]
    if np.any(least < _SINGULAR):
        k = int(np.argmin(least))
        raise SingularError(
            f"the arm can't move its tip in every direction at point {k}", value=float(least[k]), unit="m"
        )
    M = J @ np.swapaxes(J, 1, 2)
    y = _solve(M, x1)
    d1 = _times(J, y)
    J1 = point_jacobians(cell, q, d1, zero)[1]
    M1 = J1 @ np.swapaxes(J, 1, 2)
    M1 = M1 + np.swapaxes(M1, 1, 2)
    y1 = _solve(M, x2 - np.einsum("nij,nj->ni", M1, y))
    d2 = _times(J1, y) + _times(J, y1)
    J2 = point_jacobians(cell, q, d1, d2)[2]
    half = J2 @ np.swapaxes(J, 1, 2)
    M2 = half + np.swapaxes(half, 1, 2) + 2.0 * J1 @ np.swapaxes(J1, 1, 2)
    right = x3 - np.einsum("nij,nj->ni", M2, y) - 2.0 * np.einsum("nij,nj->ni", M1, y1)
    d3 = _times(J2, y) + 2.0 * _times(J1, y1) + _times(J, _solve(M, right))
    return CurveInJoints(q, d1, d2, d3)


def printed_derivatives(cell: Cell, q: Array, x1: Array, x2: Array, x3: Array) -> CurveInJoints:
    """Derivatives as eq. 7, 9 and 10 print them: q'' = J+ (x'' - J' q'), q''' = J+ (x''' - 2 J' q'' - J'' q')."""
    zero = np.zeros_like(q)
    J = point_jacobians(cell, q, zero, zero)[0]
    plus = np.swapaxes(J, 1, 2) @ np.linalg.inv(J @ np.swapaxes(J, 1, 2))
    d1 = np.einsum("nij,nj->ni", plus, x1)
    J1 = point_jacobians(cell, q, d1, zero)[1]
    d2 = np.einsum("nij,nj->ni", plus, x2 - np.einsum("nij,nj->ni", J1, d1))
    J2 = point_jacobians(cell, q, d1, d2)[2]
    rest = x3 - 2.0 * np.einsum("nij,nj->ni", J1, d2) - np.einsum("nij,nj->ni", J2, d1)
    return CurveInJoints(q, d1, d2, np.einsum("nij,nj->ni", plus, rest))


def _solve(M: Array, x: Array) -> Array:
    return np.asarray(np.linalg.solve(M, x[..., None])[..., 0])


def _times(J: Array, y: Array) -> Array:
    """J^T y."""
    return np.asarray(np.einsum("nij,ni->nj", J, y))


def follow_points(cell: Cell, start: Array, points: Array, *, parts: int = 1) -> tuple[Array, Array]:
    """Postures (N, n) whose tips lie at points (N, 3), each from the one before, and the errors (N,), m, that remain.

    The increment to the next point is J+ times the step, taken at the middle of the step, then adjusted by J+ times what
    is missing until nothing is (Khang and others 2010). `parts`: straight parts that each step is cut into; the first
    posture is adjusted from `start` (n,). Raises SingularError where the adjustment does not settle.
    """
    chain, q = chain_arrays(cell), np.array(start, float)
    out, errors = np.empty((len(points), len(q))), np.empty(len(points))
    at = None
    for k, point in enumerate(points):
        ways = [point] if at is None else [at + (point - at) * (p + 1) / parts for p in range(parts)]
        for target in ways:
            q, errors[k] = _adjusted(chain, q, target, first=at is None)
        at = point
        out[k] = q
    return out, errors


def _adjusted(chain: ChainArrays, q: Array, target: Array, *, first: bool) -> tuple[Array, float]:
    """One step of `follow_points`."""
    tip, J = _tip_and_jacobian(chain, q)
    if not first:
        missing = target - tip
        _, halfway = _tip_and_jacobian(chain, q + 0.5 * _increment(J, missing))
        q = q + _increment(halfway, missing)
        tip, J = _tip_and_jacobian(chain, q)
    for _ in range(_ADJUSTMENTS):
        error = float(np.linalg.norm(target - tip))
        if error < _TOLERANCE:
            return q, error
        q = q + _increment(J, target - tip)
        tip, J = _tip_and_jacobian(chain, q)
    raise SingularError(
        "the increments of the joints do not settle on the point", value=error, limit=_TOLERANCE, unit="m"
    )


def _increment(J: Array, missing: Array) -> Array:
    try:
        return np.asarray(J.T @ np.linalg.solve(J @ J.T, missing))
    except np.linalg.LinAlgError:
        raise SingularError("the arm can't move its tip in every direction on its way to the point") from None


@kernel
def _tip_and_jacobian(chain: ChainArrays, q: Array) -> tuple[Array, Array]:
    """The tip (3,) in `base` of posture q (n,), and its Jacobian (3, n)."""
    n = q.shape[0]
    Z, P = np.empty((n, 3)), np.empty((n, 3))
    R, p, plate, J = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((6, n))
    forward(chain, q, Z, P, R, p, plate)
    jacobian(chain, Z, P, p, J)
    return p, J[:3].copy()
