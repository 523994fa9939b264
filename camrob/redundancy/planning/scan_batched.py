"""The certificate's scan in two halves: postures compiled, their conditioning scored in one batch, on a GPU for one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel
from camrob.kinematics.arm import reach
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.redundancy.planning.freedoms import PlanSpace, plan_work, pose_in_foot

__all__ = ["Score", "scan_batched"]

Array = NDArray[np.float64]
Score = Callable[[Array], Array]
"""1/k_F (K,) of the bare arm's postures (K, 6), rad, in one batch: `BatchedKinematics.arm_inverse_kf`."""


@kernel(nogil=True)
def _postures(space: PlanSpace, base_T_tip: Array, grid: Array, rolls: int) -> tuple[Array, NDArray[np.bool_]]:
    """Arm postures (M, rolls, 4, 6) of every external posture, roll and pair of wrist branches, and which of both (..., 4, 2)
    lie within the limits; a pair's two branches share 1/k_F, so that one posture stands for both.
    """
    M, E = grid.shape
    F = space.free.shape[0]
    Q = np.zeros((M, rolls, 4, 6))
    good = np.zeros((M, rolls, 4, 2), np.bool_)
    work = plan_work()
    u = np.zeros(F)
    count = rolls if space.roll == 1 else 1
    for m in range(M):
        u[:E] = grid[m]
        for k in range(count):
            if space.roll == 1:
                u[F - 1] = -np.pi + 2.0 * np.pi * k / rolls
            pose_in_foot(space, base_T_tip, u, work)
            if reach(space.arm, space.screws, work.Rt, work.pt, space.center, work.Q, work.why) == 0:
                continue
            for pair in range(4):
                for side in range(1, -1, -1):  # the first side last: it stands for both where both are good
                    if work.why[2 * pair + side] != BRANCH_OK:
                        continue
                    inside = True
                    for i in range(6):
                        inside = inside and space.lower[i] <= work.Q[2 * pair + side, i] <= space.upper[i]
                    if inside:
                        good[m, k, pair, side] = True
                        Q[m, k, pair] = work.Q[2 * pair + side]
    return Q, good


def scan_batched(space: PlanSpace, base_T_tip: Array, grid: Array, rolls: int, score: Score) -> NDArray[np.float32]:
    """What `certificate.scan` gives, 1/k_F (M, rolls, 8) with 0 for none, scored by `score`.

    The two agree within float32, so that a plan differs at the most where two basins are equally good to that.
    """
    Q, good = _postures(space, np.ascontiguousarray(base_T_tip), grid, rolls)
    some = good.any(axis=-1)
    value = np.zeros(some.shape, np.float32)
    value[some] = score(Q[some])
    return np.asarray(np.where(good, value[..., None], np.float32(0.0)).reshape(*some.shape[:2], 8))
