"""Compensation: axis values with which the calibrated robot meets poses that the nominal one would have met."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.errors import SingularError
from camrob.frozen import locked
from camrob.progress import Share
from camrob.se3 import rotation_log

__all__ = ["Compensated", "compensate_postures", "difference_sizes", "pose_difference"]

Array = NDArray[np.float64]

_CHUNK = 20_000  # postures at once: Jacobians of all would not fit a small memory
_ITERATIONS = 15  # of Newton's step, which doubles its digits each time where it converges
_TOLERANCE = 1e-11  # m and rad
_LARGEST = 0.2  # rad of one step
_FARTHEST = 0.2  # rad in all: a correction that moves an axis farther is none, the arm is singular there


@dataclass(frozen=True, slots=True)
class Compensated:
    """q (N, n): postures, external axes as planned. iterations (N,). before, after (N, 2): errors of the calibrated
    robot without and with compensation: distance, m, and angle, rad.
    """

    q: Array
    iterations: NDArray[np.int64]
    before: Array
    after: Array

    def __post_init__(self) -> None:
        count = len(self.q)
        object.__setattr__(self, "q", locked(self.q, shape=(count, None), name="q"))
        iterations = locked(self.iterations, shape=(count,), dtype=np.int64, name="iterations")
        object.__setattr__(self, "iterations", iterations)
        for name in ("before", "after"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count, 2), name=name))


def pose_difference(wanted: Array, poses: Array) -> Array:
    """Twists (N, 6) from poses to wanted ones (N, 4, 4): distance and rotation vector in the axes of their frame."""
    turn = rotation_log(wanted[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2))
    return np.concatenate([wanted[:, :3, 3] - poses[:, :3, 3], turn], axis=1)


def difference_sizes(difference: Array) -> Array:
    """Distance, m, and angle, rad, (N, 2) of twists (N, 6)."""
    return np.stack([np.linalg.norm(difference[:, :3], axis=1), np.linalg.norm(difference[:, 3:], axis=1)], axis=1)


def compensate_postures(
    model: ErrorModel,
    values: Array,
    q: Array,
    targets: Array,
    *,
    farthest: float = _FARTHEST,
    progress: Share | None = None,
) -> Compensated:
    """Newton's method with the analytic Jacobian of the calibrated chain (eq. 5 to 9 of the KR500 paper, in SI).

    q (N, n): postures that the nominal robot meets `targets` (N, 4, 4) with, in the frame that the model's poses are
    in. The arm is corrected, other axes stay as they are. Rows that have converged (1e-11 m and rad) rest; two to three
    iterations are usual, 20 microseconds a posture. farthest: rad that an axis may be moved. Raises SingularError,
    with `value` the row, where a posture does not converge. Limits are the caller's to check.
    """
    q = np.array(q, float)
    iterations = np.zeros(len(q), np.int64)
    before, after = np.empty((len(q), 2)), np.empty((len(q), 2))
    for start in range(0, len(q), _CHUNK):
        part = slice(start, min(start + _CHUNK, len(q)))
        planned = q[part].copy()
        _newton(model, values, q[part], targets[part], iterations[part], before[part], after[part], start)
        moved = np.max(np.abs(q[part] - planned), axis=1)
        if np.max(moved) > farthest:
            raise _singular(start + int(np.argmax(moved)))
        if progress is not None:
            progress(part.stop / len(q))
    return Compensated(q, iterations, before, after)


def _newton(
    model: ErrorModel,
    values: Array,
    q: Array,
    targets: Array,
    iterations: NDArray[np.int64],
    before: Array,
    after: Array,
    offset: int,
) -> None:
    """One chunk, in place."""
    arm = model.cell.arm_slice
    open_rows = np.arange(len(q))
    slope = model.arm_slope(values, q)  # changes by a millionth while a posture is corrected
    for iteration in range(_ITERATIONS + 1):
        poses, J = model.poses_and_arm_jacobian(values, q[open_rows], slope=slope[open_rows])
        e = pose_difference(targets[open_rows], poses)
        sizes = difference_sizes(e)
        after[open_rows] = sizes
        if iteration == 0:
            before[:] = sizes
        going = np.max(sizes, axis=1) > _TOLERANCE
        iterations[open_rows[~going]] = iteration
        open_rows, e, J = open_rows[going], e[going], J[going]
        if len(open_rows) == 0:
            return
        if iteration == _ITERATIONS:
            break
        length = model.cell.condition_length
        J[:, :3] /= length
        e[:, :3] /= length
        # a breath of damping keeps singular rows finite; regular ones lose nothing that the next round doesn't mend
        normal = np.swapaxes(J, 1, 2) @ J + 1e-12 * np.eye(6)
        step = np.linalg.solve(normal, np.swapaxes(J, 1, 2) @ e[:, :, None])[..., 0]
        length_of = np.max(np.abs(step), axis=1, keepdims=True)
        q[open_rows, arm] += step * np.minimum(1.0, _LARGEST / np.maximum(length_of, 1e-300))
    raise _singular(offset + int(open_rows[0]))


def _singular(row: int) -> SingularError:
    return SingularError(
        f"point {row + 1} can't be compensated: the arm is singular there; lead the path past that posture",
        value=float(row),
    )
