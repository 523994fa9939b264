"""What nobody has explained and follows posture, for the planner's kernels: how far it may be off, what is expected of it, and
how much less it would be beside larger constants.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.world import world_T_floor
from camrob.compiled import part
from camrob.dynamics.gravity import GravityArrays
from camrob.frame_steps import compose, move_joint
from camrob.redundancy.accuracy.posture_errors import ARM_AXES, UnexplainedRest

__all__ = ["ALIKE", "RestNumbers", "rest_numbers", "smooth_rest"]

Array = NDArray[np.float64]


class RestNumbers(NamedTuple):
    """`UnexplainedRest` for the kernels: with k (M,) a posture's covariances with those that are known, g = far + k^T G k, and
    sum_j k_j W_j (3, 1 + K) the shift expected there and by how much less it is in each direction of what was fitted, in the
    floor's frame, or in `base`'s where in_base is 1.
    """

    postures: Array
    per: Array
    turns: NDArray[np.bool_]
    length: float
    variance: float
    same: float
    far: float
    G: Array
    W: Array
    in_base: int


# nothing known of any posture, and nothing unknown
ALIKE = RestNumbers(
    np.zeros((0, ARM_AXES)),
    np.zeros(ARM_AXES),
    np.zeros(ARM_AXES, np.bool_),
    1.0,
    0.0,
    0.0,
    0.0,
    np.zeros((0, 0)),
    np.zeros((0, 3, 1)),
    0,
)


def rest_numbers(cell: Cell, rest: UnexplainedRest | None) -> RestNumbers:
    """The smooth rest, with what is expected of it."""
    if rest is None:
        return ALIKE
    inverse = np.linalg.inv(rest.own)
    shifts = np.concatenate([rest.values[:, :, None], rest.by_root], axis=2)
    frame = np.asarray(cell.base_T_first) if rest.in_base else world_T_floor(cell)
    W = np.einsum("ml,dr,ldk->mrk", inverse, frame[:3, :3], shifts, optimize=True)
    plain = (rest.postures, rest.per, inverse @ rest.cov @ inverse - inverse, W)
    postures, per, G, W = (np.ascontiguousarray(x, np.float64) for x in plain)
    turns, variance, same = np.ascontiguousarray(rest.turns, np.bool_), float(rest.variance), float(rest.same)
    return RestNumbers(
        postures, per, turns, float(rest.length), variance, same, variance + same, G, W, int(rest.in_base)
    )


@part
def smooth_rest(rest: RestNumbers, gravity: GravityArrays, u: Array, q: Array, E: int, beside: Array) -> float:
    """m2, g of a posture u (F,), q (6,) with E external axes; beside (3, 1 + K) <- sum_j k_j W_j in the floor's frame."""
    n, axes = rest.postures.shape[0], E + 6
    k, total = np.empty(n), rest.far
    for j in range(n):
        first, second, count, turned = 0.0, 0.0, 0.0, 1.0
        for i in range(axes):
            if rest.per[i] > 0.0:
                x = (u[i] if i < E else q[i - E]) - rest.postures[j, i]
                d = x * rest.per[i] / rest.length
                longest = np.exp(-0.5 * d * d)
                half = longest**4  # of half the length
                one = (longest + half + half**4) / 3.0
                first += one
                second += one * one
                count += 1.0
                if rest.turns[i]:
                    turned *= 0.5 * (1.0 + np.cos(x))
        pairs = 0.5 * (first * first - second)
        k[j] = rest.same + rest.variance * turned * (first + pairs) / (count + 0.5 * count * (count - 1.0))
    for i in range(n):
        own = 0.0
        for j in range(n):
            own += rest.G[i, j] * k[j]
        total += own * k[i]
        for r in range(3):
            for c in range(beside.shape[1]):
                beside[r, c] += k[i] * rest.W[i, r, c]
    if n > 0 and rest.in_base == 1:
        _from_base(gravity, u, beside)
    return max(total, 0.0)


@part
def _from_base(g: GravityArrays, u: Array, shifts: Array) -> None:
    """shifts (3, C), seen from `base`, turned into the floor's frame."""
    R, p, own = np.eye(3), np.zeros(3), np.empty(3)
    for i in range(g.first):
        compose(R, p, g.before[i])
        move_joint(R, p, g.prismatic[i], u[i])
        compose(R, p, g.after[i])
    for c in range(shifts.shape[1]):
        for r in range(3):
            own[r] = R[0, r] * shifts[0, c] + R[1, r] * shifts[1, c] + R[2, r] * shifts[2, c]
        for r in range(3):
            shifts[r, c] = own[r]
