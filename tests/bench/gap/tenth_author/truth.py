"""The real machine: what each stage does to what was asked, and what the instrument then sees. mm, rad, s, N, Nm, kg."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from .chain import Machine, inverse, small
from .motions import Run

__all__ = ["Cause", "Field", "Truth", "seen"]


@dataclass
class Truth:
    """A run as it really went, filled in by the causes at work."""

    machine: Machine
    run: Run
    q: np.ndarray = None  # what the encoders report (N, n)
    motor: np.ndarray | None = None  # what the motors' own encoders report, where they are logged
    link: np.ndarray = None  # what the links are off it
    rows: dict = field(default_factory=dict)
    foot: np.ndarray = None  # the arm's foot, in its own frame
    world: np.ndarray = None  # the whole arm in world, multiplied on the left
    tool: np.ndarray = None  # at the tip, multiplied on the right
    part: list[Callable] = field(default_factory=list)  # world_T_base, changed
    shift: np.ndarray = None  # of the tip in world
    late: float = 0.0  # s that the instrument's stamps are late
    reads: list[Callable] = field(default_factory=list)  # (t, T) to T: what the instrument makes of it
    torque: np.ndarray = None  # of the drives, beyond what moves the masses

    def __post_init__(self):
        n, m = self.run.q.shape
        self.q, self.link, self.torque = self.run.q.copy(), np.zeros((n, m)), np.zeros((n, m))
        eye = np.broadcast_to(np.eye(4), (n, 4, 4))
        self.foot, self.world, self.tool, self.shift = eye, eye, eye, np.zeros((n, 3))

    def at(self, name: str) -> int:
        return self.machine.at(name)

    @property
    def v(self) -> np.ndarray:
        """Speeds of the set-points; of poses none."""
        return np.gradient(self.run.q, self.run.t, axis=0) if not self.run.poses else 0.0 * self.run.q

    @property
    def a(self) -> np.ndarray:
        return np.gradient(self.v, self.run.t, axis=0) if not self.run.poses else 0.0 * self.run.q

    def sense(self, k: int) -> np.ndarray:
        """Which way axis k moved last (N,), -1 to 1."""
        if self.run.poses:
            return self.run.last[:, k]
        speed = self.v[:, k]
        out, now = np.zeros(len(speed)), 1.0
        top = np.max(np.abs(speed)) + 1e-12
        for i, s in enumerate(speed):
            now = np.sign(s) if abs(s) > 1e-3 * top else now
            out[i] = now
        return out


@dataclass(frozen=True)
class Cause:
    """Something that is wrong: what it does, and how it is told afterwards."""

    name: str
    stage: str  # program_to_setpoint, setpoint_to_encoder, encoder_to_tcp
    axes: tuple[str, ...]
    follows: tuple[str, ...]
    act: Callable[[Truth], None]
    step: str  # the right first step at the machine
    wrong: str  # what would be wrong
    alike: tuple[str, ...] = ()
    foreign: bool = False


class Field:
    """What a real arm leaves beside all that has a name: a smooth shift over posture."""

    def __init__(self, machine: Machine, mm: float, rng):
        self.scale = np.array([1.0 if j.kind == "R" else 600.0 for j in machine.joints])
        used = np.array([0.0 if j.role == "workpiece" else 1.0 for j in machine.joints])
        self.k = rng.normal(0, 0.55, (9, len(self.scale))) * used
        self.phase = rng.uniform(0, 2 * np.pi, 9)
        self.into = rng.normal(size=(9, 3))
        self.mm = mm

    def __call__(self, q: np.ndarray) -> np.ndarray:
        return self.mm * np.sqrt(2 / 27.0) * np.sin((q / self.scale) @ self.k.T + self.phase) @ self.into


def seen(machine: Machine, run: Run, causes, left: Field | None, setup) -> tuple[Truth, np.ndarray, np.ndarray]:
    """The run as it went, and the poses of the target that the instrument sees (N, 4, 4), in the frame of the log, without noise.

    `setup` has `frame` ("world", "base", "unknown"), `stand` (the instrument's frame), `target` (of the reflector, or None).
    """
    truth = Truth(machine, run)
    for stage in ("program_to_setpoint", "setpoint_to_encoder", "encoder_to_tcp"):
        for cause in causes:
            if cause.stage == stage:
                cause.act(truth)
    q = truth.q + truth.link
    tool = machine.tool if setup["target"] is None else setup["target"]
    _, _, tip = machine.frames(q, truth.rows, truth.foot, tool @ truth.tool)
    T = truth.world @ tip
    T[:, :3, 3] += truth.shift + (left(q) if left is not None else 0.0)
    if setup["frame"] == "base":
        part = machine.part(q)
        for change in truth.part:
            part = change(truth, part)
        T = inverse(part) @ T
    elif setup["frame"] == "unknown":
        T = inverse(setup["stand"]) @ T
    if truth.late:
        T = _late(run.t, T, truth.late)
    for read in truth.reads:
        T = read(truth, T)
    nominal = machine.frames(run.q, tool=tool)[2]
    if setup["frame"] == "base":
        nominal = inverse(machine.part(run.q)) @ nominal
    elif setup["frame"] == "unknown":
        nominal = inverse(setup["stand"]) @ nominal
    return truth, T, nominal


def _late(t, T, late):
    """Poses as of `late` seconds ago."""
    out = T.copy()
    for i in range(3):
        out[:, i, 3] = np.interp(t - late, t, T[:, i, 3])
    step = Rotation.from_matrix(np.swapaxes(T[:-1, :3, :3], 1, 2) @ T[1:, :3, :3]).as_rotvec()
    share = -late / np.diff(t)
    out[1:, :3, :3] = T[1:, :3, :3] @ small(np.zeros(3), step * share[:, None])[:, :3, :3]
    return out
