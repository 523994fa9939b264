"""How they move: milling paths, poses at rest, drives alone; a run on a fine clock, of which some rows are logged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.stats import qmc

from .machines import Machine

TICK = 0.004


@dataclass(frozen=True)
class Run:
    """`t`, `q` on the fine clock; `pick`: rows that are logged; `begun`: seconds since the machine was switched on."""

    machine: Machine
    kind: str
    t: np.ndarray
    q: np.ndarray
    pick: np.ndarray
    cut: np.ndarray  # whether the tool cuts, fine
    begun: float

    def at(self, fine):
        return fine[self.pick]

    @cached_property
    def c(self):
        return self.q[self.pick]

    @cached_property
    def v(self):
        """Speeds on the fine clock; at rest there are none."""
        return np.zeros_like(self.q) if self.kind == "poses" else np.gradient(self.q, TICK, axis=0)

    @cached_property
    def a(self):
        return np.gradient(self.v, TICK, axis=0)

    @cached_property
    def came(self):
        """The sense in which each axis moved last, at logged rows."""
        step = np.sign(np.round(np.diff(self.q, axis=0, prepend=self.q[:1]), 9))
        last = np.maximum.accumulate(np.where(step != 0, np.arange(len(step))[:, None], 0), 0)
        return np.take_along_axis(step, last, 0)[self.pick]

    @cached_property
    def load(self):
        return self.machine.load(self.c)

    @cached_property
    def frames(self):
        return self.machine.chain(self.c)

    @cached_property
    def points(self):
        return self.frames[-1][:, :3, 3]

    @cached_property
    def late(self):
        """Seconds since switched on, logged rows."""
        return self.begun + self.t[self.pick]

    @cached_property
    def force(self):
        """On the tool in N, world, logged: against the feed and across it, while it cuts."""
        way = np.einsum("nij,nj->ni", self.machine.jacobian(self.c)[:, :3], self.at(self.v))
        way /= np.linalg.norm(way, axis=1, keepdims=True) + 1e-6
        z = self.frames[-1][:, :3, 2]
        return (-140 * way + 95 * np.cross(z, way) + 40 * z) * self.at(self.cut)[:, None]


def reached(machine, points, z, weight=0.25):
    """Axis values whose tips are at `points`, the tool along `z` as far as it can; all from home, so that they are continuous."""
    q = np.tile(machine.middle, (len(points), 1))
    for _ in range(40):
        tip, j = machine.tip(q), machine.jacobian(q)
        miss = np.concatenate([points - tip[:, :3, 3], weight * np.cross(tip[:, :3, 2], z)], 1)
        j = np.concatenate([j[:, :3], weight * j[:, 3:]], 1)
        core = np.einsum("nij,nkj->nik", j, j) + 1e-5 * np.eye(6)
        q = q + 0.6 * np.einsum("nji,nj->ni", j, np.linalg.solve(core, miss[:, :, None])[:, :, 0])
    return q


def _slot(size, rng):
    """Trochoids along a slot, there and, a little deeper, back."""
    s = np.linspace(0, 1, 900)
    forth = 1 - np.abs(1 - 2 * s)
    turn = 2 * np.pi * 14 * s
    p = np.stack(
        [size * (forth - 0.5) + 0.12 * size * np.cos(turn), 0.12 * size * np.sin(turn), -0.1 * size * (s > 0.5) * 1.0],
        1,
    )
    p[:, 2] = np.convolve(np.pad(p[:, 2], 10, "edge"), np.ones(21) / 21, "valid")
    return p, np.zeros((900, 2)), np.ones(900)


def _blade(size, rng):
    """Profiles of a blade, one above the other, twisted, milled one way with the tool leaning outward."""
    turn = np.linspace(0, 2 * np.pi, 150)
    out = []
    for level in range(6):
        x, y = 0.5 * np.cos(turn), 0.14 * np.sin(turn) * (1 - 0.55 * np.cos(turn)) + 0.1 * np.cos(turn) ** 2
        w = 0.14 * level
        out.append(
            np.stack([x * np.cos(w) - y * np.sin(w), x * np.sin(w) + y * np.cos(w), np.full(150, 0.09 * level)], 1)
        )
    p = size * np.concatenate(out)
    lean = 0.25 * np.concatenate([np.stack([np.cos(turn), np.sin(turn)], 1)] * 6)
    return p, lean, np.ones(900)


def _dome(size, rng):
    """A dome in one-way passes along its meridians, lifted back each time."""
    p, cut = [], []
    for a in np.linspace(0, np.pi, 9)[:-1]:
        u = np.linspace(-0.5, 0.5, 90)
        back = np.linspace(0.5, -0.5, 23)[1:-1]
        way = np.stack([np.cos(a) * u, np.sin(a) * u, -0.7 * u**2], 1)
        lift = np.stack([np.cos(a) * back, np.sin(a) * back, -0.7 * back**2 + 0.25 * np.cos(np.pi * back)], 1)
        p += [way, lift]
        cut += [np.ones(90), np.zeros(21)]
    p = size * np.concatenate(p)
    return p, 0.5 * p[:, :2] / size, np.concatenate(cut)


PATHS = (_slot, _blade, _dome)


def path(machine, rng, rate, seconds, begun):
    """One of the milling paths, somewhere in the work, at a feed that slows where it is crooked; logged at `rate` Hz."""
    shape = PATHS[rng.integers(len(PATHS))]
    size = machine.reach * rng.uniform(0.16, 0.26)
    p, lean, cut = shape(size, rng)
    spin = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(spin), -np.sin(spin), 0], [np.sin(spin), np.cos(spin), 0], [0, 0, 1.0]])
    home = machine.tip(machine.middle)[0]
    centre = home[:3, 3] + rng.uniform(-0.08, 0.08, 3) * machine.reach
    z = home[:3, 2] + np.einsum("nj,ij->ni", np.c_[lean, np.zeros(len(lean))], turn)
    q = reached(machine, centre + p @ turn.T, z / np.linalg.norm(z, axis=1, keepdims=True))
    if machine.n == 7:  # the carriage follows part of the way by itself
        q[:, 0] += 0.15 * np.sin(np.linspace(0, 2 * np.pi, len(q)))
    step = np.linalg.norm(np.diff(p, axis=0), axis=1) + 0.02 * size / len(p)
    d = np.diff(p[:, :2], axis=0)
    bend = np.abs(np.diff(np.unwrap(np.arctan2(d[:, 1], d[:, 0])), prepend=0.0))
    when = np.r_[0, np.cumsum(step * (1 + 2 * np.minimum(bend, 1.0)))]
    when *= (seconds - 4) / when[-1]
    t = np.arange(int(seconds / TICK)) * TICK
    clock = np.clip(t - 2, 0, when[-1])
    fine = CubicSpline(when, q)(clock)
    soft = np.hanning(121) / np.hanning(121).sum()  # the controller's smoothing of steps in jerk
    fine = np.stack([np.convolve(np.pad(x, 60, "edge"), soft, "valid") for x in fine.T], 1)
    busy = np.interp(clock, when, cut) * ((t > 2) & (t < seconds - 2))
    return Run(machine, "path", t, fine, np.arange(0, len(t), round(1 / rate / TICK)), busy, begun)


def _visit(machine, q, rng, begun):
    """Poses gone to one after the other: 24 steps of the fine clock each, the last of which is read."""
    home = machine.middle
    ease = (1 - np.cos(np.pi * np.arange(1, 25) / 24)) / 2
    fine = np.concatenate([a + ease[:, None] * (b - a) for a, b in zip(np.r_[home[None], q[:-1]], q, strict=True)])
    t = np.repeat(np.cumsum(rng.uniform(7, 16, len(q))), 24) + np.tile(np.arange(24) * 0.01 - 0.23, len(q))
    return Run(machine, "poses", t, fine, np.arange(23, len(fine), 24), np.zeros(len(fine)), begun)


def poses(machine, rng, count, begun):
    """Sobol's points of the axes, or those of 300 that tell the chain's constants best (greedy, by the determinant)."""
    swing = np.array(machine.swing) * machine.units
    unit = qmc.Sobol(machine.n, seed=rng).random(512)[: 300 if rng.random() < 0.5 else count]
    q = machine.middle + (2 * unit - 1) * swing
    if len(q) > count:
        frames = machine.chain(q)
        j = np.concatenate([machine.jacobian(q)[:, :3], *(f[:, :3, :3] for f in frames[:-1])], 2)
        inverse, chosen = np.eye(j.shape[2]) * 100, []
        for _ in range(count):
            gain = np.linalg.slogdet(np.eye(3) + j @ inverse @ np.swapaxes(j, 1, 2))[1]
            gain[chosen] = -1
            k = int(np.argmax(gain))
            chosen.append(k)
            inverse = inverse - inverse @ j[k].T @ np.linalg.solve(np.eye(3) + j[k] @ inverse @ j[k].T, j[k] @ inverse)
        q = q[chosen]
    return _visit(machine, q, rng, begun)


def drives(machine, rng, rate, seconds, begun):
    """Sweeps, a third of all axes at a time, over a slow wander; then trapezes to random places."""
    t = np.arange(int(seconds / TICK)) * TICK
    swing = np.array(machine.swing) * machine.units
    half = seconds / 2
    q = np.zeros((len(t), machine.n))
    for k in range(machine.n):
        low, high = 0.05, rng.uniform(0.4, 1.1)
        u = np.clip(t / half, 0, 1)
        phase = 2 * np.pi * half * (low * u + (high - low) * u**2 / 2) + rng.uniform(0, 2 * np.pi)
        mine = np.clip(np.cos(2 * np.pi * (u * 1.5 - k / 3)) + 0.3, 0, 1)
        q[:, k] = 0.25 * np.sin(phase) * mine * (1 - u**8)
        to = np.r_[0, rng.uniform(-0.8, 0.8, 5), 0]
        when = half + np.linspace(0.5, half - 2.5, 7) + rng.uniform(0, 0.3)
        for a, b, at in zip(to[:-1], to[1:], when[:-1], strict=True):
            s = np.clip((t - at) / rng.uniform(0.9, 1.7), 0, 1)
            q[:, k] += (b - a) * np.clip((s**2 * (3 - 2 * s) + s) / 2, 0, 1)
    soft = np.hanning(61) / np.hanning(61).sum()
    q = np.stack([np.convolve(np.pad(x, 30, "edge"), soft, "valid") for x in q.T], 1)
    q = machine.middle + q * swing
    return Run(machine, "drives", t, q, np.arange(0, len(t), round(1 / rate / TICK)), np.zeros(len(t)), begun)
