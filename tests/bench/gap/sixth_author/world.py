"""A run in time: set-points, drives with states, gears, links, floor, instrument. Causes act on the stage that is theirs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from gap.sixth_author.chain import Machine, small


@dataclass
class Run:
    """What a controller was told, on a grid of its own, and at which rows somebody looked."""

    name: str
    machine: Machine
    dt: float
    c: np.ndarray  # (N, n) axis values, SI
    rows: np.ndarray  # of the grid
    rest: bool = False
    begins: float = 0.0  # s since the machine was switched on
    force: np.ndarray | None = None  # (rows, 3) N on the tool in world
    tied: bool = False  # measured on the table
    number: int = 0
    cooled: float = 0.0  # s of work that a break has undone
    pace: float = 0.0  # s that a pose takes to be measured; 0: as moved

    @cached_property
    def t(self):
        """Of the grid, s."""
        return self.dt * np.arange(len(self.c))

    @cached_property
    def at(self):
        """Of the rows, s."""
        return self.t[self.rows]

    @cached_property
    def clock(self):
        """Of the rows as logged, s since the log's start."""
        return self.pace * np.arange(1, len(self.rows) + 1) if self.pace else self.at

    @cached_property
    def v(self):
        """Speeds of the set-points on the grid."""
        return np.gradient(self.c, self.dt, axis=0)

    @cached_property
    def a(self):
        """Accelerations of the set-points on the grid, as a drive's filter leaves them."""
        raw = np.gradient(self.v, self.dt, axis=0)
        n = max(1, round(0.02 / self.dt))
        return np.apply_along_axis(lambda x: np.convolve(x, np.ones(n) / n, "same"), 0, raw)

    @cached_property
    def _coarse(self):
        step = max(1, round(0.04 / self.dt))
        return np.unique(np.append(np.arange(0, len(self.c), step), len(self.c) - 1))

    def spread(self, values):
        """Values at the coarse grid, on the fine one."""
        return np.stack([np.interp(self.t, self.t[self._coarse], x) for x in np.asarray(values).T], 1)

    @cached_property
    def load(self):
        """Gravity on each axis, on the grid."""
        return self.spread(self.machine.load(self.c[self._coarse]))

    def load_of(self, bodies):
        """Gravity of other bodies."""
        return self.spread(self.machine.load(self.c[self._coarse], bodies))

    @cached_property
    def needed(self):
        """Torque that the motion needs on each axis (point masses, rotors by the gears), on the grid."""
        k, machine = self._coarse, self.machine
        t = self.t[k]
        pulls = []
        for body, p in zip(machine.bodies, machine.centres(self.c[k]), strict=True):
            acc = np.gradient(np.gradient(p, t, axis=0), t, axis=0)
            pulls.append(body.mass * (acc + np.array([0, 0, 9.81])))
        torque = self.spread(machine.load(self.c[k], pull=pulls))
        rotor = np.array([0.004 * s / 1e5 for s in machine.stiff]) * 12
        return torque + self.a * rotor

    @cached_property
    def nominal(self):
        """The tip at the rows by the set-points."""
        return self.tip(self.c[self.rows])

    def tip(self, values, twists=None, rows=None):
        """The tip in the frame of measurement."""
        machine, twists = self.machine, dict(twists or {})
        table = twists.pop("table", None)
        out = machine.frames(machine.still(values), twists, rows)[2]
        if self.tied:
            q = machine.joints[0].sign * values[:, 0]  # how far the part turned back
            turn = np.tile(np.eye(4), (len(values), 1, 1))
            turn[:, 0, 0] = turn[:, 1, 1] = np.cos(q)
            turn[:, 0, 1], turn[:, 1, 0] = np.sin(q), -np.sin(q)  # world_T_base turns by -q
            if table is not None:
                turn = small(table) @ turn
            out = np.linalg.solve(turn, out)
        return out

    @cached_property
    def heat(self):
        """Two nodes of warmth at the rows (0 cold, 1 as warm as work makes them): motors in 9 minutes, castings in 55."""
        t = np.maximum(self.begins - self.cooled, 0) + self.clock
        return np.stack([1 - np.exp(-t / 540), 1 - np.exp(-t / 3300) * (1 + 0.2 * t / 3300)], 1)


Hook = Callable[[Run, np.ndarray, float], object]


@dataclass
class Cause:
    """Something that is wrong: what it does on each stage, as a function of the run, the motor's way and its own size."""

    name: str
    axes: tuple[str, ...] = ()
    stage: str = "encoder_to_tcp"
    follows: tuple[str, ...] = ()
    params: dict = field(default_factory=dict)
    gain: float = 1.0
    drive: Hook | None = None  # more on the motors' way (N, n)
    link: Hook | None = None  # more behind the motors (N, n)
    shape: Hook | None = None  # ({place: twists}, {(joint, name): more}) at the rows
    seen: Hook | None = None  # more on what is read (rows, 3), of a run and what would be read
    late: Hook | None = None  # s by which the instrument looks later, at the rows
    torque: Hook | None = None  # more on the logged torques (N, n)

    def of(self, gain):
        """The same, larger or smaller."""
        return replace(self, gain=gain)


@dataclass
class Played:
    """What happened: the motors' way on the grid, and the tip as the instrument would see it without noise."""

    motor: np.ndarray
    tip: np.ndarray
    torque: np.ndarray


def played(run: Run, causes) -> Played:
    """A run with causes at work, without noise."""
    machine, motor = run.machine, run.c
    for cause in causes:
        if cause.drive:
            motor = motor + cause.drive(run, motor, cause.gain)
    link, twists, more, shift, torque = motor, {}, {}, 0.0, run.needed.copy()
    for cause in causes:
        if cause.link:
            link = link + cause.link(run, motor, cause.gain)
        if cause.shape:
            a, b = cause.shape(run, motor, cause.gain)
            for k, x in a.items():
                twists[k] = twists.get(k, 0.0) + np.broadcast_to(x, (len(run.rows), 6))
            for k, x in b.items():
                more[k] = more.get(k, 0.0) + np.broadcast_to(x, len(run.rows))
        if cause.late:
            shift = shift + cause.late(run, motor, cause.gain)
        if cause.torque:
            torque = torque + cause.torque(run, motor, cause.gain)
    when = np.clip(run.at + shift, 0, run.t[-1])
    values = np.stack([np.interp(when, run.t, x) for x in link.T], 1)
    if np.ndim(shift) == 0 and shift == 0:
        values = link[run.rows]
    tip = run.tip(values, twists, more)
    for cause in causes:
        if cause.seen:
            tip = tip.copy()
            tip[:, :3, 3] += cause.seen(run, tip, cause.gain)
    assert tip.shape[0] == len(run.rows) and machine is run.machine
    return Played(motor, tip, torque)


def off_by(run: Run, causes, drives: bool) -> np.ndarray:
    """(rows, 3) mm by which causes alone move what is measured (with no tracker: what encoders say, at the tip)."""
    if not causes:
        return np.zeros((len(run.rows), 3))
    got = played(run, causes)
    tip = run.tip(got.motor[run.rows]) if drives else got.tip
    return (tip - run.nominal)[:, :3, 3] * 1e3


def free_of(off, run: Run, log) -> np.ndarray:
    """What stays when a frame and a target that the log leaves unknown are fitted to it."""
    columns = loose(run, log)
    if not columns:
        return off
    a = np.array(columns).T
    return (off.ravel() - a @ np.linalg.lstsq(a, off.ravel(), rcond=None)[0]).reshape(-1, 3)


def loose(run: Run, log) -> list[np.ndarray]:
    """Columns of an unknown frame and target."""
    at, out = run.nominal, []
    p = at[:, :3, 3] - at[:, :3, 3].mean(0)
    if log["frame"] == "unknown":
        out += [np.tile(e, len(p)) for e in np.eye(3)] + [np.cross(e, p).ravel() for e in np.eye(3)]
    if log["target"] == "unknown":
        out += [at[:, :3, k].ravel() for k in range(3)]
    return out


def rms(off) -> float:
    """In three dimensions."""
    return float(np.sqrt((np.asarray(off) ** 2).sum(1).mean()))
