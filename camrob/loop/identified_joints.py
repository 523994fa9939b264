"""What a run without correction tells about the joints: how late each one is, and how much motion it loses where it reverses.

The errors seen at the tool are taken to the joints by the nominal Jacobian. Joint i's part is then fitted by how far a
first-order lag, after the known delay and latency, leaves it behind its set-points, by its state of friction along the path
(half of the lost motion, rad), and by a constant and the joints' positions, which stand for the link errors. From the first two
come set-points ahead of the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.frozen import locked
from camrob.kinematics.frames import tool_jacobians
from camrob.loop.case import TrackerCase
from camrob.loop.loop import LoopLog
from camrob.loop.paths import TestPath
from camrob.loop.robot import friction_state

__all__ = ["JointLags", "ahead_of", "identify_lags", "joint_errors"]

Array = NDArray[np.float64]

_MOVES = 1e-4  # rad/s: a joint slower than this on the whole path tells nothing about itself
_CONDITION = 1e8  # of the regression
_FIRST, _NUDGE = 0.05, 1e-4  # s: where the search for a lag begins, and its step for slopes


@dataclass(frozen=True, slots=True)
class JointLags:
    """Per joint (6,): `late`, s, from set-point to measured pose; its standard error `late_std`; `lost`, rad, half of the motion
    lost at a reversal; `lost_std`. NaN-free: a joint that didn't move has `moved` false and zeros.
    """

    late: Array
    late_std: Array
    lost: Array
    lost_std: Array
    moved: NDArray[np.bool_]

    def __post_init__(self) -> None:
        for name in ("late", "late_std", "lost", "lost_std"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(6,), name=name))
        object.__setattr__(self, "moved", locked(self.moved, shape=(6,), dtype=np.bool_, name="moved"))

    def lag(self, case: TrackerCase) -> Array:
        """Time constants (6,) of the joints, s: what is late beyond the known delay and latency, half a cycle for the steps."""
        cycle = case.law.cycle_s
        return np.asarray(np.maximum(self.late - (case.robot.delay + case.latency + 0.5) * cycle, 0.0))


def _turns(wanted: Array) -> Array:
    """Matrices (N, 3, 3) from changes of A, B, C to turns about the base's axes, at set-points (N, 6)."""
    a, b = wanted[:, 3], wanted[:, 4]
    out = np.zeros((len(wanted), 3, 3))
    out[:, 2, 0] = 1.0
    out[:, 0, 1], out[:, 1, 1] = -np.sin(a), np.cos(a)
    out[:, 0, 2], out[:, 1, 2], out[:, 2, 2] = np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), -np.sin(b)
    return out


def joint_errors(cell: Cell, path: TestPath, error: Array) -> Array:
    """The joints' parts (N, 6), rad, of errors (N, 6) in x, y, z, A, B, C, m and rad: what the joints would have to move."""
    twist = np.array(error)
    twist[:, 3:] = np.einsum("nij,nj->ni", _turns(np.asarray(path.wanted)), error[:, 3:])
    return np.asarray(np.linalg.solve(tool_jacobians(cell, np.asarray(path.q)), twist[..., None])[..., 0])


def identify_lags(cell: Cell, case: TrackerCase, logs: Sequence[LoopLog]) -> JointLags:
    """From runs without correction (`seen` alone is used). Raises JobError where they don't tell lag and friction apart."""
    cycle, late_cycles = case.law.cycle_s, case.robot.delay + case.latency
    error = np.vstack([joint_errors(cell, log.run.path, np.asarray(log.seen)) for log in logs])
    paths = [np.asarray(log.run.path.q) for log in logs]
    q = np.vstack(paths)
    moved = np.array([np.abs(np.diff(p, axis=0)).max(axis=0) for p in paths]).max(axis=0) > _MOVES * cycle
    place = np.hstack([np.ones((len(q), 1)), (q - q.mean(axis=0))[:, moved]])
    place = place[:, _independent(place)]
    lag, lag_std, lost, lost_std = np.where(moved, _FIRST, 0.0), *(np.zeros(6) for _ in range(3))
    for _pass in range(2):  # the second with the state of friction as late as the joints were found to be
        state = np.vstack([friction_state(_followed(p, lag, cycle, late_cycles), case.robot.sliding) for p in paths])
        for i in np.flatnonzero(moved).tolist():
            lag[i], lag_std[i], lost[i], lost_std[i] = _fitted(
                [p[:, i] for p in paths],
                error[:, i],
                np.column_stack([state[:, i], place]),
                lag[i],
                cycle,
                late_cycles,
                i,
            )
    late = np.where(moved, lag + (late_cycles + 0.5) * cycle, 0.0)
    return JointLags(late, lag_std, lost, lost_std, moved)


def _followed(q: Array, lag: Array | float, cycle: float, late_cycles: int) -> Array:
    """Joints (N,) or (N, 6) that follow set-points q by first-order lags and whole cycles, as the tracker would see them."""
    columns = q.reshape(len(q), -1)
    share = -np.expm1(-cycle / np.maximum(np.broadcast_to(lag, columns.shape[1]), 1e-4))
    top = np.zeros(late_cycles + 2)
    out = np.empty_like(columns)
    for k, a in enumerate(share):
        top[-1] = a
        out[:, k] = columns[0, k] + lfilter(top, [1.0, a - 1.0], columns[:, k] - columns[0, k])
    return out.reshape(q.shape)


def _fitted(
    paths: list[Array], error: Array, others: Array, lag: float, cycle: float, late_cycles: int, joint: int
) -> tuple[float, float, float, float]:
    """One joint's lag and lost motion, each with its standard error, by Gauss and Newton from `lag`."""

    def behind(by: float) -> Array:
        return np.concatenate([p - _followed(p, by, cycle, late_cycles) for p in paths])

    values, spread = np.zeros(0), np.zeros(0)
    for _step in range(4):
        now = behind(lag)
        A = np.column_stack([(behind(lag + _NUDGE) - now) / _NUDGE, others])
        scale = np.linalg.norm(A, axis=0)
        U, s, Vt = np.linalg.svd(A / scale, full_matrices=False)
        if s[0] > _CONDITION * s[-1]:
            raise JobError("the runs don't tell a joint's lag from its friction", axis=f"A{joint + 1}")
        values = Vt.T @ ((U.T @ (error - now)) / s) / scale
        left = error - now - A @ values
        sigma = np.sqrt(np.sum(left**2) / (len(left) - A.shape[1]))
        spread = sigma * np.sqrt(np.sum((Vt.T / s) ** 2, axis=1)) / scale
        lag = max(lag + float(values[0]), 0.0)
    return lag, float(spread[0]), float(values[1]), float(spread[1])


def _independent(columns: Array) -> list[int]:
    """Columns that aren't sums of the ones before them (a joint that mirrors another adds nothing)."""
    kept: list[int] = []
    for k in range(columns.shape[1]):
        trial = columns[:, [*kept, k]]
        s = np.linalg.svd(trial / np.linalg.norm(trial, axis=0), compute_uv=False)
        if s[-1] > 1e-6 * s[0]:
            kept.append(k)
    return kept


def ahead_of(case: TrackerCase, path: TestPath, lags: JointLags) -> Array:
    """What to add to the joints' commands (N, 6), rad, so that late joints that lose motion follow the set-points.

    With a = 1 - exp(-T / lag), the command c(k) = w(k+d) + (w(k+d+1) - w(k+d)) / a makes the joint stand at w; w is the set-point
    plus what friction will take away.
    """
    q = np.asarray(path.q)
    lag = lags.lag(case)
    share = np.where(lag > 0.0, -np.expm1(-case.law.cycle_s / np.maximum(lag, 1e-9)), 1.0)
    wanted = q + lags.lost * friction_state(q, case.robot.sliding)
    d = case.robot.delay
    held = np.concatenate([wanted, np.repeat(wanted[-1:], d + 1, axis=0)])
    now, following = held[d : d + len(q)], held[d + 1 : d + 1 + len(q)]
    return np.where(lags.moved, now + (following - now) / share - q, 0.0)
