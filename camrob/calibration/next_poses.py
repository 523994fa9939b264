"""Which poses to measure next, for the accuracy on the path that matters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import parameter_of
from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many

__all__ = ["PoseChoice", "candidate_postures", "select_poses"]

Array = NDArray[np.float64]

_PRIOR = 3.0  # ordinary sizes that a parameter is believed to have before anything was measured
_MOST_ON_PATH = 200
_CONDITION = 0.1  # 1/k_F: poses to measure at stay away from singular ones
_INSIDE = 0.9  # of the axes' ranges


@dataclass(frozen=True, slots=True)
class PoseChoice:
    """chosen: (k,) indices of the candidates, the most telling first. expected: (k + 1,) rms error that the
    calibrated robot is expected to have on the path, m: before, and after each chosen pose.
    """

    chosen: NDArray[np.int64]
    expected: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "chosen", locked(self.chosen, shape=(None,), dtype=np.int64, name="chosen"))
        object.__setattr__(self, "expected", locked(self.expected, shape=(len(self.chosen) + 1,), name="expected"))


def candidate_postures(cell: Cell, count: int) -> Array:
    """Postures (K, n), K <= count, spread over the inner part of the axes' ranges, away from singular ones.

    Always the same ones for a cell: an additive recurrence of the golden ratio's counterpart. Endless axes turn once.
    """
    n = len(cell)
    golden = 1.5
    for _ in range(60):
        golden = (1.0 + golden) ** (1.0 / (n + 1))  # the root of x^(n+1) = x + 1
    u = (0.5 + np.arange(1, 2 * count + 1)[:, None] * golden ** -np.arange(1.0, n + 1)) % 1.0
    lower = np.where(cell.endless, -np.pi, cell.q_lower)
    upper = np.where(cell.endless, np.pi, cell.q_upper)
    arm = np.arange(n) >= cell.arm_slice.start
    # wrist axes of several turns need not turn more than once
    middle, half = 0.5 * (lower + upper), 0.5 * _INSIDE * (upper - lower)
    half = np.where(arm, np.minimum(half, np.pi), half)
    q = middle + (2.0 * u - 1.0) * half
    q = cell.to_q(cell.to_axis_values(q))  # the virtual roll at 0
    return np.asarray(q[inverse_kf_many(chain_arrays(cell), q) > _CONDITION][:count])


def select_poses(
    cell: Cell,
    names: Sequence[str],
    candidates: Array,
    path: Array,
    count: int,
    *,
    measured: Array | None = None,
    sigma_position: float = 5e-5,
    sigma_angle: float | None = None,
    in_base: bool = False,
) -> PoseChoice:
    """Choose `count` of the candidates (K, n) that leave the least expected error of position on the path (M, n).

    The criterion is the error at test poses (Wu, Klimchik and others): the trace of J C J^T over the path, C the
    covariance that the parameters have after measuring, with their ordinary sizes as what was known before; so
    parameters that no pose tells apart do no harm. measured (N, n): postures measured already. sigma_angle: None
    where only positions are measured. Greedy, one pose after the other, each the best with those before. Raises
    ValueError for fewer candidates than wanted.
    """
    if count > len(candidates):
        raise ValueError(f"{count} poses are wanted of {len(candidates)} candidates")
    model = ErrorModel.of(cell, names, in_base=in_base)
    zero = np.zeros(len(names))
    scales = np.array([parameter_of(cell, n).scale for n in names])
    rows = 3 if sigma_angle is None else 6
    sigma = np.repeat((sigma_position, sigma_angle or 1.0), 3)[:rows, None]

    def sensitivity(q: Array) -> Array:
        return np.asarray(model.poses_and_jacobian(zero, q)[1][:, :rows] * scales / sigma)

    information = np.eye(len(names)) / _PRIOR**2
    if measured is not None and len(measured):
        J = sensitivity(measured).reshape(-1, len(names))
        information += J.T @ J
    C = np.linalg.inv(information)
    every = path[np.unique(np.linspace(0, len(path) - 1, min(len(path), _MOST_ON_PATH)).astype(np.int64))]
    on_path = model.poses_and_jacobian(zero, every)[1][:, :3] * scales
    M = np.einsum("kip,kiq->pq", on_path, on_path) / len(every)
    J = sensitivity(candidates)
    chosen: list[int] = []
    expected = [np.sqrt(np.sum(C * M))]
    for _ in range(count):
        G = J @ C
        S = np.linalg.inv(G @ np.swapaxes(J, 1, 2) + np.eye(rows))
        gain = np.einsum("kij,kip,pq,kjq->k", S, G, M, G, optimize=True)
        gain[chosen] = -1.0
        best = int(np.argmax(gain))
        chosen.append(best)
        C = C - G[best].T @ S[best] @ G[best]
        expected.append(np.sqrt(max(float(np.sum(C * M)), 0.0)))
    return PoseChoice(np.array(chosen, np.int64), np.array(expected))
