"""What machines are asked to do: poses to be measured, handling, axes to and fro, circles. Axis values in rad and mm."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import uniform_filter1d

from .chain import Machine

__all__ = ["Run", "alone", "circles", "poses", "stations", "sweeps"]


@dataclass
class Run:
    """What was asked, and what the shop was like then."""

    t: np.ndarray
    q: np.ndarray  # set-points (N, n)
    poses: bool = False
    last: np.ndarray | None = None  # of poses: the sign of each axis' last move (N, n)
    temp: np.ndarray | None = None  # degrees Celsius (N,)
    held: float = 0.0  # kg that the flange really holds
    told: float | None = None  # kg that the log's file says
    speed: float = 1.0
    extra: dict = field(default_factory=dict)

    def __post_init__(self):
        if self.temp is None:
            self.temp = np.full(len(self.t), 22.0)


def _draw(machine: Machine, rng, n: int, share=1.0, still=()) -> np.ndarray:
    """Postures within the ranges, the tool at a height that the machine keeps to; `share` of each range about its middle."""
    low = np.array([j.low for j in machine.joints])
    high = np.array([j.high for j in machine.joints])
    mid, half = (low + high) / 2, (high - low) / 2 * share
    found = np.zeros((0, len(low)))
    while len(found) < n:
        q = mid + half * rng.uniform(-1, 1, (4 * n + 8, len(low)))
        for name in still:
            q[:, machine.at(name)] = mid[machine.at(name)]
        z = machine.frames(q)[2][:, 2, 3]
        found = np.vstack([found, q[(z > machine.keep[0]) & (z < machine.keep[1])]])
    return found[:n]


def poses(
    machine: Machine, rng, n: int, every=25.0, share=1.0, still=(), again=0.0, held=0.0, told=None, temp=(22.0, 22.0)
) -> Run:
    """Single poses, `every` seconds; a share `again` of them are places that were measured before."""
    q = _draw(machine, rng, n, share, still)
    for k in range(n):
        if k > 4 and rng.uniform() < again:
            q[k] = q[rng.integers(0, k - 2)]
    came = np.vstack([_draw(machine, rng, 1, share, still), q[:-1]])
    t = np.cumsum(every * rng.uniform(0.7, 1.4, n)) - every / 2
    warm = temp[0] + (temp[1] - temp[0]) * (1 - np.exp(-t / max(t[-1] / 2.2, 1.0)))
    return Run(t, q, True, np.sign(q - came), warm, held, told, extra={"moves": q - came})


def _filled(way: list[np.ndarray], machine: Machine, dt: float, speed: float, rest: float) -> np.ndarray:
    """From place to place, all axes together, each leg as long as its slowest axis wants; rounded by two filters."""
    top = speed * np.array([j.speed for j in machine.joints])
    rows = [np.repeat(way[0][None], int(0.5 / dt) + 1, 0)]
    for a, b in itertools.pairwise(way):
        n = max(int(np.ceil(np.max(np.abs(b - a) / top) / dt)), 2)
        rows.append(a + (b - a) * np.linspace(0, 1, n + 1)[1:, None])
        rows.append(np.repeat(b[None], max(int(rest / dt), 1), 0))
    rows.append(np.repeat(way[-1][None], int(0.5 / dt) + 1, 0))
    q = np.vstack(rows)
    for length in (0.16, 0.08):
        q = uniform_filter1d(q, max(round(length / dt), 1), axis=0, mode="nearest")
    return q


def _run(q, dt, speed, temp, held, told) -> Run:
    t = np.arange(len(q)) * dt
    warm = temp[0] + (temp[1] - temp[0]) * t / max(t[-1], 1e-9)
    return Run(t, q, temp=warm, held=held, told=told, speed=speed)


def stations(
    machine, rng, n, dt=0.02, speed=0.8, rest=0.3, share=0.8, still=(), temp=(22.0, 22.0), held=0.0, told=None
) -> Run:
    """From station to station: handling."""
    way = list(_draw(machine, rng, n, share, still))
    return _run(_filled(way, machine, dt, speed, rest), dt, speed, temp, held, told)


def alone(
    machine,
    rng,
    names,
    dt=0.012,
    speeds=(0.3, 0.9),
    turns=2,
    share=0.7,
    rest=0.25,
    temp=(22.0, 22.0),
    held=0.0,
    told=None,
) -> Run:
    """Each axis of `names` by itself to and fro at each speed, from a posture that is drawn."""
    start, parts = _draw(machine, rng, 1, 0.3)[0], []
    for speed in speeds:
        way = [start]
        for name in names:
            k = machine.at(name)
            half = share * (machine.joints[k].high - machine.joints[k].low) / 2
            mid = (machine.joints[k].high + machine.joints[k].low) / 2
            for turn in range(turns):
                for side in (1, -1):
                    there = start.copy()
                    there[k] = mid + side * half * (1 - 0.25 * turn)
                    way.append(there)
            way.append(start)
        parts.append(_filled(way, machine, dt, speed, rest))
    return _run(np.vstack(parts), dt, max(speeds), temp, held, told)


def sweeps(
    machine, rng, seconds, dt=0.03, share=0.6, slow=0.35, still=(), temp=(22.0, 22.0), held=0.0, told=None
) -> Run:
    """All axes at once on sums of sines, as those excite who identify dynamics."""
    t = np.arange(int(seconds / dt)) * dt
    q = np.zeros((len(t), len(machine.joints)))
    for k, j in enumerate(machine.joints):
        mid, half = (j.low + j.high) / 2, (j.high - j.low) / 2 * share
        wave = np.zeros(len(t))
        for number in (1, 2, 3):
            f = rng.uniform(0.6, 1.0) * number * slow / 6
            wave += np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28)) / number
        wave *= 1 / 1.84
        fastest = np.max(np.abs(np.gradient(wave * half, dt)))
        q[:, k] = mid + half * wave * min(1.0, 0.9 * j.speed / fastest) if j.name not in still else mid
    return _run(q, dt, 1.0, temp, held, told)


def circles(
    machine, rng, radius=120.0, dt=0.02, feeds=(60.0, 180.0), places=2, held=0.0, told=None, temp=(22.0, 22.0), still=()
) -> Run:
    """Circles about places, both ways, the tool's direction kept, by the arm alone; the ball-bar's figure."""
    arm = [k for k, j in enumerate(machine.joints) if j.role == "arm"]
    parts = []
    for _ in range(places):
        for _ in range(400):
            start = _draw(machine, rng, 1, 0.35, still)[0]
            u, v = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
            legs = []
            for feed in feeds:
                for way in (1, -1):
                    n = int(2 * np.pi * radius / feed / dt)
                    phi = way * 2 * np.pi * (np.arange(n + 1) / n)
                    legs.append(radius * ((np.cos(phi) - 1)[:, None] * u + np.sin(phi)[:, None] * v))
                    legs.append(np.repeat(legs[-1][-1:], int(0.4 / dt), 0))
            shift = uniform_filter1d(np.vstack(legs), max(int(0.1 / dt), 1), axis=0, mode="nearest")
            every = max(len(shift) // 80, 1)
            if _followed(machine, start, shift[::every], arm, every * dt) is None:
                continue
            q = _followed(machine, start, shift, arm, dt)
            if q is not None:
                parts.append(q)
                break
        else:
            raise RuntimeError("no place for a circle")
    move = [parts[0]]
    for a, b in itertools.pairwise(parts):
        move += [_filled([a[-1], b[0]], machine, dt, 0.5, 0.2), b]
    return _run(np.vstack(move), dt, max(feeds), temp, held, told)


def _followed(machine, start, shift, arm, dt):
    """Postures that put the tool `shift` (N, 3; world) from where it is at `start`, turned as there; None where out of range."""
    q = np.repeat(start[None], len(shift), 0)
    aim = machine.frames(q[:1])[2][0]
    for _ in range(25):
        tip = machine.frames(q)[2]
        off = np.hstack([(aim[:3, 3] + shift - tip[:, :3, 3]) / 300.0, _turn(tip, aim)])
        if np.max(np.abs(off)) < 1e-9:
            break
        J = np.zeros((len(q), 6, len(arm)))
        for c, k in enumerate(arm):
            e = 1e-6 if machine.joints[k].kind == "R" else 1e-3
            moved = q.copy()
            moved[:, k] += e
            T = machine.frames(moved)[2]
            J[:, :3, c] = (T[:, :3, 3] - tip[:, :3, 3]) / 300.0 / e
            J[:, 3:, c] = -_turn(T, tip) / e
        JT = np.swapaxes(J, 1, 2)
        step = np.einsum("nij,nj->ni", JT @ np.linalg.inv(J @ JT + 1e-8 * np.eye(6)), off)
        q[:, arm] += np.clip(step, -0.15, 0.15)
    low, high = (np.array([getattr(j, x) for j in machine.joints]) for x in ("low", "high"))
    wide = 0.3 * (high - low)
    top = np.array([j.speed for j in machine.joints]) * 2.0 * dt
    good = (
        np.max(np.abs(off)) < 1e-7
        and np.all(q > low - wide)
        and np.all(q < high + wide)
        and np.all(np.abs(np.diff(q, axis=0)) < top)
    )
    return q if good else None


def _turn(a, b):
    """Small rotation vectors, in world, that turn a to b."""
    R = b[..., :3, :3] @ np.swapaxes(a[..., :3, :3], -1, -2)
    return 0.5 * np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], -1)
