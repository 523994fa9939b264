"""The tracker loop in simulation: measured, compared, corrected and sent on every cycle; many runs side by side.

A cycle k, in this order: the robot stands at y(k); the tracker's sample of y(k - latency) is there; the error e is taken against
the set-point of now (as published) or of the measured instant (`aligned`); the law adds to the correction u(k); the nominal
inverse kinematics of set-point plus correction goes to the robot, which moves by y(k + 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import CellError, JobError, UnreachableError
from camrob.frozen import locked
from camrob.kinematics.arm import Arm, to_nearest_branch
from camrob.kinematics.kernels import ChainArrays
from camrob.kinematics.spherical_wrist import BRANCH_OK, solve_arm_many
from camrob.loop.case import RobotErrors, TrackerCase, TrackerNoise
from camrob.loop.law import CorrectionLaw, accumulate
from camrob.loop.paths import TestPath, start_posture
from camrob.loop.robot import RobotBatch, actual_chain
from camrob.loop.tracker_error import (
    TrackerReading,
    base_pose,
    components,
    reading_of,
    setpoint_error,
    tracker_pose,
)
from camrob.se3 import frame_from_xyzabc, inverse, rotation_exp

__all__ = ["LoopLog", "LoopRun", "check_arm_alone", "measured_noise", "simulate"]

Array = NDArray[np.float64]

_RAMP = 1.0  # s in which a learned correction is let in at a run's start


@dataclass(frozen=True, slots=True)
class LoopRun:
    """What one run is. `law` None: no correction; it begins at cycle `begin`. `learned` (N, 6): added to the set-points,
    m and rad; `ahead` (N, 6): added to the joints' commands, rad. `averaged`: the mean of all samples of a cycle is taken, not
    the newest alone. `noise_seed`: runs of one seed see the same noise.
    """

    path: TestPath
    robot: RobotErrors
    noise: TrackerNoise
    latency: int
    law: CorrectionLaw | None = None
    begin: int = 0
    aligned: bool = False
    averaged: bool = False
    learned: Array | None = None
    ahead: Array | None = None
    noise_seed: int = 1


@dataclass(frozen=True, slots=True)
class LoopLog:
    """What happened, one row a cycle, x, y, z, A, B, C in m and rad: `error` (N, 6) set-point minus where the tool really was;
    `seen` (N, 6) the error as the loop took it, with noise and latency; `correction` (N, 6); `saturated` (N,) where the
    increment or the sum was cut.
    """

    run: LoopRun
    error: Array
    seen: Array
    correction: Array
    saturated: NDArray[np.bool_]

    def __post_init__(self) -> None:
        for name in ("error", "seen", "correction"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))
        object.__setattr__(self, "saturated", locked(self.saturated, dtype=np.bool_, name="saturated"))


def check_arm_alone(cell: Cell) -> None:
    """Raises CellError for a cell whose arm stands on a track or whose part turns: the loop corrects six axes in the base."""
    if cell.indices(Role.WORKPIECE) or cell.indices(Role.CARRIAGE) or cell.indices(Role.ROLL):
        raise CellError(
            "the tracker loop is for an arm alone, and this cell has other joints",
            hint="give a cell of six arm joints, such as cells/rx160_tracker",
            path=cell.folder,
        )


def measured_noise(case: TrackerCase, path: TestPath, noise: TrackerNoise, seed: int) -> Array:
    """What the tracker's noise adds to x, y, z, A, B, C (N, 6), m and rad.

    Noise is drawn on distance, beam angles and orientation at each set-point, and goes through eq. 1 to 3; the robot is
    within millimetres of the set-point, which changes noise by a thousandth.
    """
    rng = np.random.default_rng(seed)
    tracker_T_tcp = inverse(case.base_T_tracker) @ frame_from_xyzabc(path.wanted)
    drawn = rng.standard_normal((len(path), 6))
    true = reading_of(tracker_T_tcp)
    angle = noise.position * drawn[:, 1:3] / true.distance[:, None]
    turned = np.array(tracker_T_tcp)
    turned[:, :3, :3] = turned[:, :3, :3] @ rotation_exp(noise.angle * drawn[:, 3:])
    reading = TrackerReading(
        true.distance + noise.position * drawn[:, 0],
        true.horizontal + angle[:, 0] / np.maximum(np.sin(true.vertical), 1e-3),
        true.vertical + angle[:, 1],
        reading_of(turned).quaternion,
    )
    seen = components(base_pose(case.base_T_tracker, tracker_pose(reading)))
    return -setpoint_error(path.wanted, seen)


def simulate(cell: Cell, case: TrackerCase, runs: Sequence[LoopRun]) -> list[LoopLog]:
    """Run them all, cycle by cycle; about 0.15 ms a cycle and a few runs.

    Raises JobError where a loop runs away, UnreachableError where a corrected set-point is out of reach.
    """
    check_arm_alone(cell)
    batch = _Batch(cell, case, runs)
    for k in range(batch.cycles):
        batch.cycle(k)
    return batch.logs()


class _Batch:
    """The state of runs side by side; shorter paths stay at their end."""

    def __init__(self, cell: Cell, case: TrackerCase, runs: Sequence[LoopRun]) -> None:
        self.runs, self.arm = tuple(runs), Arm.of(cell)
        self.cycles = max(len(r.path) for r in runs)
        self.wanted = np.stack([self._filled(r.path.wanted) for r in runs], axis=1)
        q = np.stack([r.path.q[0] for r in runs])
        self.near = q.copy()
        self.ahead = None
        if any(r.ahead is not None for r in runs):
            self.ahead = np.stack([self._added(r, r.ahead) for r in runs], axis=1)
        self.learned = None
        if any(r.learned is not None for r in runs):
            ramp = np.minimum(case.law.cycle_s * np.arange(self.cycles) / _RAMP, 1.0)[:, None]
            self.learned = np.stack([ramp * self._added(r, r.learned) for r in runs], axis=1)
        drawn: dict[tuple[str, TrackerNoise, int], Array] = {}
        for r in runs:
            key = (r.path.name, r.noise, r.noise_seed)
            if key not in drawn:
                drawn[key] = self._filled(measured_noise(case, r.path, r.noise, r.noise_seed))
        samples = np.array([_samples(r, case.law.cycle_s) if r.averaged else 1 for r in runs])
        self.noise = (
            np.stack([drawn[r.path.name, r.noise, r.noise_seed] for r in runs], axis=1) / np.sqrt(samples)[:, None]
        )
        self.older = (0.5 * (samples - 1.0) / samples)[:, None]  # how much of the mean is of the cycle before
        self.robots = RobotBatch(_chains(cell, case, runs), [r.robot for r in runs], q, case.law.cycle_s)
        self.latency = np.array([r.latency for r in runs])
        self.back = np.array([r.latency if r.aligned else 0 for r in runs])
        self.aligned = np.array([int(r.aligned) for r in runs])
        self.rows = np.arange(len(runs))
        self.foot_T_base = self.arm.foot_T_tool(np.eye(4), cell.q_home)  # frames: tool is base
        laws = {r.law for r in runs if r.law is not None}
        self.laws = [(law, np.array([r.law == law for r in runs]), np.array([r.begin for r in runs])) for law in laws]
        shape = (self.cycles, len(runs), 6)
        self.true, self.seen, self.correction = np.empty(shape), np.empty(shape), np.zeros(shape)
        self.cut = np.zeros(shape[:2], bool)
        self.total = np.zeros(shape[1:])

    def _filled(self, values: Array) -> Array:
        return np.concatenate([values, np.repeat(values[-1:], self.cycles - len(values), axis=0)])

    def _added(self, run: LoopRun, values: Array | None) -> Array:
        return self._filled(np.zeros((len(run.path), 6)) if values is None else np.asarray(values, float))

    def cycle(self, k: int) -> None:
        """One cycle of all runs."""
        self.true[k] = components(self.robots.poses())
        e = self._error(k, 0)
        if self.older.any():
            e = e + self.older * (self._error(k, 1) - e)
        e -= self.noise[np.maximum(k - self.latency, 0), self.rows]
        self.seen[k] = e
        for law, mine, begin in self.laws:
            on = mine & (k >= begin)
            if on.any():
                total, change = accumulate(law, self.total[on], e[on])
                self.cut[k, on] = (np.abs(change - law.gain * e[on]) > 1e-12).any(axis=1)
                self.total[on] = total
        self.correction[k] = self.total
        setpoint = self.wanted[k] + self.total
        if self.learned is not None:
            setpoint = setpoint + self.learned[k]
        q = self._postures(setpoint, k)
        self.robots.move(q if self.ahead is None else q + self.ahead[k])

    def _error(self, k: int, earlier: int) -> Array:
        """Set-point minus pose (B, 6) at the measured instant, or cycles earlier; noise left aside."""
        past = np.maximum(k - self.latency - earlier, 0)
        against = np.maximum(k - self.back - earlier * self.aligned, 0)
        return setpoint_error(self.wanted[against, self.rows], self.true[past, self.rows])

    def _postures(self, setpoint: Array, k: int) -> Array:
        """The nominal inverse kinematics (B, 6) nearest to the last postures."""
        foot_T_tool = self.foot_T_base @ frame_from_xyzabc(setpoint)
        near = self.near
        if self.arm.closed is not None:
            Q, why = solve_arm_many(self.arm.closed, foot_T_tool, near)
            far = np.abs(Q - near[:, None]).max(axis=2)
            far[why != BRANCH_OK] = np.inf
            best = np.argmin(far, axis=1)
            lost = ~np.isfinite(far[self.rows, best])
            self.near = np.where(lost[:, None], near, Q[self.rows, best])
        else:
            Q1, why1 = np.zeros((8, 6)), np.empty(8, np.int64)
            lost = np.zeros(len(near), bool)
            for b in self.rows:
                R, p = np.ascontiguousarray(foot_T_tool[b, :3, :3]), foot_T_tool[b, :3, 3].copy()
                lost[b] = to_nearest_branch(*self.arm.kernel(), R, p, near[b], Q1, why1) < 0.0
        if lost.any():
            name = self.runs[int(np.argmax(lost))].path.name
            raise UnreachableError(f"a corrected set-point of the {name} is out of reach in cycle {k}")
        return self.near

    def logs(self) -> list[LoopLog]:
        """The runs' logs, each as long as its path. Raises JobError for a run away."""
        out = []
        for b, run in enumerate(self.runs):
            n = len(run.path)
            error = setpoint_error(self.wanted[:n, b], self.true[:n, b])
            if run.law is not None:
                _check_bounded(run, self.correction[:n, b])
            out.append(LoopLog(run, error, self.seen[:n, b], self.correction[:n, b], self.cut[:n, b]))
        return out


def _samples(run: LoopRun, cycle: float) -> int:
    """The tracker's samples in a cycle, at least 1."""
    return max(round(run.noise.rate * cycle), 1)


def _chains(cell: Cell, case: TrackerCase, runs: Sequence[LoopRun]) -> list[ChainArrays]:
    """Each run's real chain, with the static error at the square's first corner; runs of one chain share it."""
    wanted = np.concatenate([case.corner, np.zeros(3)])
    q = start_posture(cell, wanted, "square")
    made: dict[bytes, ChainArrays] = {}
    out = []
    for r in runs:
        e = r.robot
        key = np.concatenate([[e.seed, e.link, e.link_angle], e.static]).tobytes()
        if key not in made:
            made[key] = actual_chain(cell, e, q, wanted)
        out.append(made[key])
    return out


def _check_bounded(run: LoopRun, correction: Array) -> None:
    """Raises JobError where the sum stood at its bound: the loop runs away, or the robot's errors are beyond it."""
    law = run.law
    if law is None:
        return
    at = np.abs(correction) >= law.limit - 1e-12
    if at.any():
        first = int(np.argmax(at.any(axis=1)))
        name = "xyzABC"[int(np.argmax(at[first]))]
        raise JobError(
            f"the correction in {name} reached its bound on the {run.path.name}, {run.path.time[first]:.2f} s after the start: "
            f"the loop runs away with gain {law.gain:g}, or the robot's errors are larger than the bound"
        )
