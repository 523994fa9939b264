"""What the machines were asked to do: poses, stations, returns, steps; point to point, sweeps, circles, rasters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from .robots import Robot

__all__ = ["Maker", "Run", "circles", "grid", "poses", "ptp", "raster", "returns", "stations", "sweeps"]


@dataclass
class Run:
    """Set-points in fine steps; every `step`th is written down. Of poses: one row each, and how it was come to."""

    t: np.ndarray
    q: np.ndarray
    step: int = 1
    poses: bool = False
    way: np.ndarray | None = None  # the last move's steps to each pose
    held: float = 0.0  # kg beyond what the cell's file knows
    told: float | None = None  # kg that the log's file tells
    push: np.ndarray | None = None  # N at the tip, as logged
    warm: np.ndarray | None = None  # degrees C, as logged

    @property
    def speed(self) -> np.ndarray:
        """Of the set-points; 0 where poses are at rest."""
        return np.zeros(self.q.shape) if self.poses else np.gradient(self.q, self.t, axis=0)


Maker = Callable[[Robot, np.random.Generator], Run]


def _somewhere(robot: Robot, rng, n: int, spread: float) -> np.ndarray:
    """Postures about the ready one, inside the limits, the tool not below the floor."""
    low, high = np.array([j.low for j in robot.joints]), np.array([j.high for j in robot.joints])
    ready = np.array(robot.ready)
    half = 0.5 * spread * (high - low)
    half = np.minimum(half, np.where([j.slides for j in robot.joints], half, 1.1))
    out: list[np.ndarray] = []
    while len(out) < n:
        q = np.clip(ready + rng.uniform(-1, 1, len(ready)) * half, low, high)
        out.append(robot.with_rods(q))
    return np.array(out)


def _still(robot, rng, q, pause, held, told) -> Run:
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(*pause, len(q) - 1))])
    start = np.array(robot.ready)
    return Run(t, q, poses=True, way=np.diff(np.vstack([start, q]), axis=0), held=held, told=told)


def poses(
    n: int, spread: float = 0.7, pause=(12.0, 45.0), held: float = 0.0, told: float | None = None, only=None
) -> Maker:
    """Single postures at rest; `only`: axes that move."""

    def make(robot, rng):
        q = _somewhere(robot, rng, n, spread)
        for i, name in enumerate(robot.names):
            if only and name not in only:
                q[:, i] = robot.ready[i]
        return _still(robot, rng, q, pause, held, told)

    return make


def returns(places: int, rounds: int, spread: float = 0.7, pause=(8.0, 15.0)) -> Maker:
    """Some places again and again, each time come to from another side."""

    def make(robot, rng):
        at = _somewhere(robot, rng, places, spread)
        rows = np.concatenate([at[rng.permutation(places)] for _ in range(rounds)])
        return _still(robot, rng, rows, pause, 0.0, None)

    return make


def stations(axis: str, low: float, high: float, n: int, each: int, spread: float = 0.5, pause=(10.0, 30.0)) -> Maker:
    """Some places of one axis (rad or mm), some postures of the others at each."""

    def make(robot, rng):
        q = _somewhere(robot, rng, n * each, spread)
        q[:, robot.index(axis)] = np.repeat(np.linspace(low, high, n), each)
        return _still(robot, rng, q, pause, 0.0, None)

    return make


def grid(counts, pause=(6.0, 10.0), turn: bool = True) -> Maker:
    """A lattice over the first axes, in serpentines; the others turn where they please."""

    def make(robot, rng):
        marks = []
        for j, n in zip(robot.joints, counts, strict=False):
            span = j.high - j.low
            marks.append(np.linspace(j.low + 0.08 * span, j.high - 0.08 * span, n))
        mesh = np.stack([m.reshape(-1) for m in np.meshgrid(*marks, indexing="ij")], 1)
        q = _somewhere(robot, rng, len(mesh), 0.5 if turn else 0.0)
        q[:, : len(counts)] = mesh
        return _still(robot, rng, q, pause, 0.0, None)

    return make


def _quintic(u: np.ndarray) -> np.ndarray:
    return u**3 * (10 - 15 * u + 6 * u**2)


def _through(robot: Robot, stops: np.ndarray, speed: float, rest: float, dt: float):
    """From stop to stop with smooth starts and ends, the slowest axis setting the time."""
    rows, cap = [stops[0][None]], robot.speeds * speed
    for a, b in pairwise(stops):
        seconds = max(float(np.max(1.875 * np.abs(b - a) / cap)), 12 * dt)
        u = np.arange(1, int(np.ceil(seconds / dt)) + 1)[:, None] * dt / seconds
        rows.append(a + (b - a) * _quintic(np.minimum(u, 1.0)))
        rows.append(np.repeat(b[None], int(rest / dt), axis=0))
    q = np.concatenate(rows)
    return np.arange(len(q)) * dt, q


def ptp(
    n: int,
    speed: float = 0.3,
    rest: float = 0.3,
    spread: float = 0.6,
    dt: float = 0.004,
    step: int = 10,
    held: float = 0.0,
    told=None,
    only=None,
) -> Maker:
    """Random postures in turn, all axes at once."""

    def make(robot, rng):
        stops = _somewhere(robot, rng, n, spread)
        for i, name in enumerate(robot.names):
            if only and name not in only:
                stops[:, i] = robot.ready[i]
        t, q = _through(robot, stops, speed, rest, dt)
        return Run(t, q, step, held=held, told=told)

    return make


def sweeps(
    axes, rounds: int = 2, part: float = 0.5, speed: float = 0.3, rest: float = 0.4, dt: float = 0.004, step: int = 10
) -> Maker:
    """One axis after the other, there and back."""

    def make(robot, rng):
        ready = np.array(robot.ready)
        stops = [ready]
        for name in axes:
            i, j = robot.index(name), robot.joints[robot.index(name)]
            half = 0.5 * part * (j.high - j.low) if j.slides else min(0.5 * part * (j.high - j.low), 1.4)
            for _ in range(rounds):
                for way in (1.0, -1.0):
                    to = ready.copy()
                    to[i] = np.clip(ready[i] + way * half * rng.uniform(0.8, 1.0), j.low, j.high)
                    stops.append(to)
            stops.append(ready)
        t, q = _through(robot, np.array(stops), speed, rest, dt)
        return Run(t, q, step)

    return make


def _solve(robot: Robot, points: np.ndarray, turn: bool) -> np.ndarray:
    """Postures along points by damped steps from the ready one, tables and carriages held; with `turn` the orientation too."""
    q = np.array(robot.ready)[None].copy()
    free = np.array([j.role == "arm" for j in robot.joints])
    want = robot.tip(q)[0, :3, :3]
    out = []
    for p in points:
        for _ in range(12):
            T = robot.tip(q)[0]
            e = np.concatenate([p - T[:3, 3], np.zeros(3)])
            R = want @ T[:3, :3].T
            e[3:] = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
            rows = 6 if turn else 3
            if np.linalg.norm(e[:3]) < 1e-7:
                break
            weight = np.r_[np.ones(3), 300 * np.ones(3)][:rows]
            J = robot.jacobian(q)[0][:rows][:, free] * weight[:, None]
            q[0, free] += np.linalg.solve(J.T @ J + 1e-6 * np.eye(free.sum()), J.T @ (weight * e[:rows]))
        out.append(q[0].copy())
    return np.array(out)


def _along(robot, points, feed, rest, turn, dt, step) -> Run:
    """Through points at a feed (mm/s), ramped at both ends."""
    q = _solve(robot, points, turn)
    s = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    ramp = 0.25
    total = s[-1] / feed + ramp
    t = np.arange(int((total + 2 * rest) / dt)) * dt
    u = np.clip(t - rest, 0, total)
    way = np.where(u < ramp, 0.5 * feed * u**2 / ramp, feed * (u - 0.5 * ramp))
    way = np.where(u > total - ramp, s[-1] - 0.5 * feed * (total - u) ** 2 / ramp, way)
    return Run(t, CubicSpline(s, q)(np.clip(way, 0, s[-1])), step)


def circles(
    radius: float,
    feed: float,
    turns: int = 2,
    plane: str = "xy",
    both: bool = True,
    turn: bool = True,
    dt: float = 0.004,
    step: int = 5,
    rest: float = 0.5,
) -> Maker:
    """Circles about a place 40 mm off the ready one's way, counter-clockwise and back."""

    def make(robot, rng):
        centre = robot.tip(np.array([robot.ready]))[0, :3, 3]
        n = 90 * turns
        phi = np.linspace(0, 2 * np.pi * turns, n + 1)
        phi = np.r_[phi, phi[::-1][1:]] if both else phi
        a, b = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}[plane]
        points = np.repeat(centre[None], len(phi), axis=0)
        points[:, a] += radius * (np.cos(phi) - 1)
        points[:, b] += radius * np.sin(phi)
        return _along(robot, points, feed, rest, turn, dt, step)

    return make


def raster(
    width: float,
    height: float,
    lines: int,
    feed: float,
    plane: str = "xy",
    turn: bool = True,
    dt: float = 0.004,
    step: int = 10,
    rise: float = 0.0,
) -> Maker:
    """Lines to and fro with rounded ends; `rise`: how far the third direction swings."""

    def make(robot, rng):
        centre = robot.tip(np.array([robot.ready]))[0, :3, 3]
        a, b = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}[plane]
        u = np.linspace(0, 1, 24 * lines + 1)
        fast = np.sin(np.pi * lines * u - np.pi / 2)
        points = np.repeat(centre[None], len(u), axis=0)
        points[:, a] += 0.5 * width * fast
        points[:, b] += height * (u - 0.5)
        points[:, 3 - a - b] += rise * np.sin(2 * np.pi * 1.5 * u)
        return _along(robot, points, feed, 0.5, turn, dt, step)

    return make
