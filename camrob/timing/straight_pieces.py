"""The straight pieces of a path as the controller sees them: what each metre asks of tool and axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import kernel, part
from camrob.kinematics.kernels import ChainArrays, chain_arrays, forward
from camrob.redundancy.path import ToolPathInBase
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["PathRates", "path_rates"]

Array = NDArray[np.float64]

_ARM = 0.1  # m of path that a radian counts as where the tip stands still and only the tool or an axis turns
_STILL = 1e-7  # m: a shorter step of the tip is no translation


class PathRates(NamedTuple):
    """M pieces between neighbouring points that differ, and what limits them.

    end: (M,) index of the point that the piece ends at. length: (M,) m. rate: (M, 6 + n) per metre of path: the tip's
    direction, the tool's rotation vector (both in `base`), the joints. translates: (M,) False where the tip stands
    still. limits: speed, acceleration and jerk (n,) of the joints; the rest are the controller's for tool and rotation.
    """

    end: NDArray[np.int64]
    length: Array
    rate: Array
    translates: NDArray[np.bool_]
    speed: Array
    acceleration: Array
    jerk: Array
    tool_acceleration: float
    rotation_speed: float
    rotation_acceleration: float
    blend: float


def path_rates(cell: Cell, path: ToolPathInBase, q: Array) -> PathRates:
    """Rates of a path with postures q (N, n). The tool is that of the real axes, the virtual roll at 0, as printed.

    Raises ValueError where q does not fit the path or is not finite. Cost: about a microsecond a point.
    """
    q = np.ascontiguousarray(q, dtype=np.float64)
    if q.shape != (len(path), len(cell)):
        raise ValueError(f"q has shape {q.shape}, expected {(len(path), len(cell))}")
    if not np.all(np.isfinite(q)):
        raise ValueError("q holds a value that is not a finite number")
    real = q
    if cell.indices(Role.ROLL):
        real = q.copy()
        real[:, list(cell.indices(Role.ROLL))] = 0.0
    length, rate, translates = _rates(np.ascontiguousarray(path.base_T_tip[:, :3, 3]), chain_arrays(cell), real)
    moving = np.flatnonzero(length > 0.0)
    settings = cell.controller
    return PathRates(
        moving + 1,
        length[moving],
        rate[moving],
        translates[moving],
        cell.limits_of("speed"),
        cell.limits_of("acceleration"),
        cell.limits_of("jerk"),
        settings.acc_cp,
        deg_to_rad(settings.vel_ori_deg_s),
        deg_to_rad(settings.acc_ori_deg_s2),
        mm_to_m(settings.apo_cdis_mm),
    )


@part
def _turn(A: Array, B: Array, out: Array) -> float:
    """Rotation vector out (3,) that takes the axes of A to those of B, both (3, 3), in the frame they are seen in; its angle."""
    out[:] = 0.0
    trace = 0.0
    for k in range(3):
        out[0] += 0.5 * (A[1, k] * B[2, k] - A[2, k] * B[1, k])
        out[1] += 0.5 * (A[2, k] * B[0, k] - A[0, k] * B[2, k])
        out[2] += 0.5 * (A[0, k] * B[1, k] - A[1, k] * B[0, k])
        for r in range(3):
            trace += A[r, k] * B[r, k]
    sine = np.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    angle = np.arctan2(sine, 0.5 * (trace - 1.0))
    if sine > 1e-9:
        for r in range(3):
            out[r] *= angle / sine
    elif angle > 1.0:  # half a turn: any axis will do, for only its size counts
        out[0] = angle
    return float(angle)


@kernel(nogil=True)
def _rates(tip: Array, chain: ChainArrays, q: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Length (N - 1,) of every piece, 0 where nothing moves; rates (N - 1, 6 + n); whether the tip moves (N - 1,)."""
    count, n = max(tip.shape[0] - 1, 0), q.shape[1]
    length, rate, translates = np.zeros(count), np.zeros((count, 6 + n)), np.zeros(count, np.bool_)
    turn, Z, P, p, plate = np.empty(3), np.empty((n, 3)), np.empty((n, 3)), np.empty(3), np.empty(3)
    A, B = np.empty((3, 3)), np.empty((3, 3))
    if count:
        forward(chain, q[0], Z, P, B, p, plate)
    for i in range(count):
        A, B = B, A
        forward(chain, q[i + 1], Z, P, B, p, plate)
        dx, dy, dz = tip[i + 1, 0] - tip[i, 0], tip[i + 1, 1] - tip[i, 1], tip[i + 1, 2] - tip[i, 2]
        step = np.sqrt(dx * dx + dy * dy + dz * dz)
        angle = _turn(A, B, turn)
        translates[i] = step > _STILL
        if not translates[i]:
            widest = angle
            for k in range(n):
                widest = max(widest, abs(q[i + 1, k] - q[i, k]))
            if widest < 1e-9:
                continue
            step = _ARM * widest
            dx = dy = dz = 0.0
        length[i] = step
        rate[i, 0], rate[i, 1], rate[i, 2] = dx / step, dy / step, dz / step
        for k in range(3):
            rate[i, 3 + k] = turn[k] / step
        for k in range(n):
            rate[i, 6 + k] = (q[i + 1, k] - q[i, k]) / step
    return length, rate, translates
