"""From set-points to what an instrument says: drives, links, floor, table, reading; and what a real machine leaves beside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .moves import Run
from .robots import Robot, inverse

__all__ = ["Cause", "Leftover", "Seen", "Truth", "look"]


@dataclass
class Cause:
    """Something wrong. `act` makes it so in a truth, `size` times its unit."""

    name: str
    axes: tuple[str, ...]
    stage: str
    follows: tuple[str, ...]
    act: Callable[[Truth, float], None]
    unit: float  # a natural size to begin with
    mm: float  # how large it is to be at the tool
    told: str  # what it is, in a technician's words
    step: str = ""
    wrong_step: str = ""
    alike: tuple[str, ...] = ()
    foreign: bool = False
    order: int = 1  # drives 0, bodies 1
    size: float = 0.0


class Truth:
    """A run as it went, in fine steps. rad, mm, N, Nm."""

    def __init__(self, robot: Robot, run: Run, setup: dict):
        self.robot, self.run, self.setup = robot, run, setup
        self.t, self.n = run.t, len(run.t)
        self.enc = run.q.copy()
        self.motor: np.ndarray | None = None
        self.link = np.zeros(run.q.shape)  # of the links behind their encoders
        self.warp: dict[int, np.ndarray] = {}
        self.foot = np.eye(4)
        self.plate = np.eye(4)[None]  # the table's plate off its place
        self.tool = robot.tool
        self.shift = np.zeros((self.n, 3))
        self.torque = np.zeros(run.q.shape)
        self.late = 0.0
        self.reading: list[Callable] = []

    def bend(self, joint: int, T: np.ndarray) -> None:
        """A small frame more before a joint."""
        self.warp[joint] = self.warp[joint] @ T if joint in self.warp else T

    @property
    def load(self) -> np.ndarray:
        """What gravity makes in the axes."""
        return self.robot.load(self.run.q, self.run.held)


@dataclass
class Seen:
    """At the times that are written down."""

    t: np.ndarray
    set: np.ndarray
    enc: np.ndarray
    motor: np.ndarray | None
    torque: np.ndarray
    pose: np.ndarray  # measured, in world or base
    nominal: np.ndarray  # of set-points or encoders, likewise
    rows: np.ndarray  # which fine steps


class Leftover:
    """Bumps over postures: each moves the tool its own way, and drives theirs. Scaled once to its size."""

    def __init__(self, robot: Robot, rng, bumps: int = 14):
        self.robot, self.scale = robot, 1.0
        low, high = np.array([j.low for j in robot.joints]), np.array([j.high for j in robot.joints])
        unit = np.array([700.0 if j.slides else 0.9 for j in robot.joints])
        half = np.minimum(0.5 * (high - low), 1.3 * unit)
        self.at = np.array(robot.ready) + rng.uniform(-1, 1, (bumps, len(unit))) * half
        self.unit = unit * np.where(np.arange(len(unit)) >= len(unit) - 2, 2.5, 1.0)
        self.move = rng.normal(0, 1, (bumps, 3))
        self.push = rng.normal(0, 1, (2, bumps, len(unit)))

    def _heights(self, q):
        d = (q[:, None, :] - self.at[None]) / self.unit
        return np.exp(-0.5 * np.sum(d**2, axis=2) / max(1.0, q.shape[1] / 3))

    def shift(self, q):
        """mm at the tool."""
        return self.scale * self._heights(q) @ self.move

    def drives(self, q, v):
        """rad and mm of the axes, other in one direction than in the other."""
        h = self._heights(q)
        way = np.tanh(v / (0.03 * self.robot.speeds))
        big = np.array([j.big for j in self.robot.joints])
        return self.scale * (h @ self.push[0] + 0.4 * way * (h @ self.push[1])) / big


def _at(x, rows, run: Run, late: float):
    """Fine steps at the rows, `late` seconds before."""
    if run.poses or not late:
        return x[rows] if len(x) > 1 else x
    if len(x) == 1:
        return x
    at = np.clip(run.t[rows] - late, run.t[0], run.t[-1])
    k = np.clip(np.searchsorted(run.t, at) - 1, 0, len(run.t) - 2)
    w = ((at - run.t[k]) / (run.t[k + 1] - run.t[k])).reshape(-1, *[1] * (x.ndim - 1))
    return (1 - w) * x[k] + w * x[k + 1]


def look(robot: Robot, run: Run, causes: list[Cause], left: Leftover | None, setup: dict) -> Seen:
    """A run as it is seen, without noise."""
    truth = Truth(robot, run, setup)
    for cause in sorted(causes, key=lambda c: c.order):
        if cause.order == 0:
            cause.act(truth, cause.size)
    if left is not None and not setup["see"]:
        truth.enc = truth.enc + left.drives(run.q, run.speed)
    for cause in causes:
        if cause.order:
            cause.act(truth, cause.size)
    rows = np.arange(0, len(run.t), run.step)
    late = truth.late
    links = robot.with_rods(_at(truth.enc + truth.link, rows, run, late))
    warp = {i: _at(w, rows, run, late) for i, w in truth.warp.items()}
    T = (truth.foot @ robot.tip(links, warp, truth.tool)).copy()
    T[:, :3, 3] += _at(truth.shift, rows, run, late)
    if left is not None and setup["see"]:
        T[:, :3, 3] += left.shift(_at(run.q, rows, run, late))
    logged = robot.with_rods(truth.enc[rows])
    nominal = robot.tip(run.q[rows] if setup["set"] else logged)
    if setup["frame"] == "base":
        T = inverse(robot.plate(links) @ _at(truth.plate, rows, run, late)) @ T
        nominal = inverse(robot.plate(run.q[rows] if setup["set"] else logged)) @ nominal
    for read in truth.reading:
        T = read(T, run.t[rows], setup)
    motor = None if truth.motor is None else truth.motor[rows]
    return Seen(run.t[rows], run.q[rows], logged, motor, truth.torque[rows], T, nominal, rows)
