"""How machines are moved: postures at rest, milling paths, excitations. Those of DEV and of SEALED are not the same."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

from gap.sixth_author.chain import Machine
from gap.sixth_author.world import Run


def smoothed(c, dt, seconds=0.12):
    """Twice a moving average: the filter that controllers round corners with."""
    n = max(1, round(seconds / dt))
    pad = np.concatenate([np.repeat(c[:1], n, 0), c, np.repeat(c[-1:], n, 0)])
    for _ in range(2):
        total = np.cumsum(np.concatenate([np.zeros_like(pad[:1]), pad]), 0)
        pad = (total[n:] - total[:-n]) / n
    start = max(0, (len(pad) - len(c)) // 2)
    return pad[start : start + len(c)]


def _within(machine: Machine, unit):
    """Axis values for numbers of -1 to 1."""
    return (np.array(machine.home) + np.asarray(unit) * machine.swing) * machine.unit


def _spanned(machine, c, dt):
    """Slower where an axis would be faster than it can, by stretching time; (c, dt) with the same dt."""
    top = np.array([j.speed for j in machine.joints]) * machine.unit
    n = len(c)
    slow = max(1.0, (np.abs(np.gradient(c, dt, axis=0)) / top).max() / 0.7)
    if slow == 1.0:
        return c
    return CubicSpline(np.arange(n), c)(np.linspace(0, n - 1, int(n * slow)))


def stops(machine, name, places, dwell=0.9, **more):
    """A run that halts at each of (N, n) axis values."""
    dt, top = 0.02, 0.35 * np.array([j.speed for j in machine.joints]) * machine.unit
    c, rows, at, count = [places[:1]], [], places[0], 1
    for to in places:
        n = max(8, int(np.ceil((np.abs(to - at) / top).max() * 1.5 / dt)))
        s = np.linspace(0, 1, n + 1)[1:, None]
        c += [at + (to - at) * (10 * s**3 - 15 * s**4 + 6 * s**5), np.repeat(to[None], int(dwell / dt), 0)]
        count += n + int(dwell / dt)
        rows.append(count - 1)
        at = to
    return Run(name, machine, dt, np.concatenate(c), np.array(rows), rest=True, **more)


def cube_poses(machine, count, rng):
    """DEV: a Latin hypercube of the work, in the order of a short tour."""
    unit = 2 * qmc.LatinHypercube(len(machine.joints), rng=rng).random(count) - 1
    order, left = [0], list(range(1, count))
    while left:
        near = min(left, key=lambda k: np.abs(unit[k] - unit[order[-1]]).max())
        order.append(near)
        left.remove(near)
    return _within(machine, unit[order])


def scan_poses(machine, count, rng):
    """SEALED: rays through the work from its middle, there and back, and axes one by one."""
    n, out = len(machine.joints), []
    while len(out) < count:
        if rng.random() < 0.4:
            ray = np.eye(n)[rng.integers(n)]
        else:
            ray = rng.normal(size=n)
            ray /= np.abs(ray).max()
        middle = rng.uniform(-0.35, 0.35, n)
        steps = rng.integers(3, 6)
        go = np.linspace(-0.9, 0.9, steps)
        out += [np.clip(middle + ray * s, -1, 1) for s in (go if rng.random() < 0.5 else np.r_[go, go[::-1] + 0.03])]
    return _within(machine, np.array(out[:count]))


def _raster(rng):
    """DEV: zigzag over a face that leans, then a pocket's spiral. (N, 3) m and tool leans (N, 2)."""
    w, h, lines = rng.uniform(0.16, 0.34), rng.uniform(0.1, 0.24), rng.integers(5, 10)
    points = []
    for k in range(lines):
        x = np.array([-w, w]) / 2 * (1 if k % 2 else -1)
        points += [(a, -h / 2 + h * k / (lines - 1), 0.02 * np.sin(3 * a / w)) for a in np.linspace(*x, 14)]
    angle = np.linspace(0, 6 * np.pi, 110)
    r = np.linspace(0.02, min(w, h) / 2, 110)
    points += [(a, b, -0.02) for a, b in np.stack([r * np.cos(angle), r * np.sin(angle)], 1)]
    p = np.array(points)
    return p, 0.25 * np.stack([np.sin(5 * p[:, 0] / w), np.cos(4 * p[:, 1] / h)], 1)


def _piece(rng):
    """SEALED: diamond, circle and square one above the other as test pieces have them, then a helix with a leaning tool."""
    s, points = rng.uniform(0.1, 0.19), []
    for turn, z, scale in ((0, 0.0, 1.0), (np.pi / 4, 0.02, 0.7), (np.radians(5), 0.035, 0.85)):
        corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)]) * s * scale / np.sqrt(2)
        corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        for a, b in pairwise(corners):
            points += [(*(a + (b - a) * u), z) for u in np.linspace(0, 1, 12)]
    angle = np.linspace(0, 4 * np.pi, 90) * rng.choice([-1, 1])
    points += [(s * np.cos(u), s * np.sin(u), 0.035 + 0.08 * k / 90) for k, u in enumerate(angle)]
    p = np.array(points)
    lean = np.where(np.arange(len(p)) > len(p) - 90, 1.0, 0.0)
    at = np.arctan2(p[:, 1], p[:, 0])
    return p, 0.3 * lean[:, None] * np.stack([np.cos(at), np.sin(at)], 1)


def milled(machine, name, seconds, rate, rng, sealed, **more):
    """A run along a milling path that the arm follows while track and table ride along; None where it can't reach."""
    p, lean = (_piece if sealed else _raster)(rng)
    n, dt = len(p), 0.004
    u = np.linspace(0, 1, n)
    start = np.repeat(_within(machine, rng.uniform(-0.3, 0.3, len(machine.joints)))[None], n, 0)
    middle = machine.tip(start[:1])[0]
    for k in range(machine.foot + 1):
        way = np.sin(2 * np.pi * (u * rng.uniform(0.6, 1.6) + rng.random())) * rng.uniform(0.4, 0.9)
        reach = machine.joints[k].role == "workpiece"
        start[:, k] += way * machine.swing[k] * machine.unit[k] * (1.0 if reach else 0.12)
    plane = Rotation.from_rotvec(rng.uniform(-0.25, 0.25, 3)).as_matrix()
    poses = np.tile(middle, (n, 1, 1))
    poses[:, :3, 3] += p @ plane.T
    poses[:, :3, :3] = Rotation.from_rotvec(np.column_stack([lean, 0 * u])).as_matrix() @ middle[:3, :3]
    v, good = machine.reached(poses, start)
    if not good.all() or (np.abs(v - start)[:, machine.arm] > 1.3).any() or np.abs(np.diff(v, axis=0)).max() > 0.8:
        return None
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1) + 1e-4)])
    grid = np.linspace(0, s[-1], int(seconds / dt))
    c = np.stack([np.interp(grid, s, x) for x in v.T], 1)
    c = smoothed(_spanned(machine, smoothed(c, dt), dt), dt)
    return _logged(machine, name, c, dt, rate, **more)


def _logged(machine, name, c, dt, rate, **more):
    every = max(1, round(1 / (rate * dt)))
    return Run(name, machine, dt, c, np.arange(0, len(c), every), **more)


def fourier(machine, name, seconds, rate, rng, **more):
    """DEV: sums of sines by axis, as people identify drives with."""
    dt = 0.004
    t = np.arange(0, seconds, dt)[:, None]
    c = np.zeros((len(t), len(machine.joints)))
    base = 2 * np.pi / rng.uniform(18, 35)
    for k in range(1, 6):
        c += rng.normal(size=c.shape[1]) / k**0.7 * np.sin(k * base * t + rng.uniform(0, 6.3, c.shape[1]))
    c = _within(machine, 0.85 * c / np.abs(c).max(0))
    return _logged(machine, name, _spanned(machine, c, dt), dt, rate, **more)


def shuttle(machine, name, seconds, rate, rng, **more):
    """SEALED: from point to point at several speeds, with halts, some axes alone."""
    dt, n = 0.004, len(machine.joints)
    top = np.array([j.speed for j in machine.joints]) * machine.unit
    at = _within(machine, rng.uniform(-0.5, 0.5, n))
    c, have = [at[None]], 1
    while have * dt < seconds:
        to = _within(machine, rng.uniform(-0.9, 0.9, n))
        if n > 1 and rng.random() < 0.5:
            keep = rng.integers(n)
            to = np.where(np.arange(n) == keep, to, at)
        pace = rng.choice([0.08, 0.25, 0.6])
        m = max(30, int((np.abs(to - at) / (pace * top)).max() / dt))
        part = at + (to - at) * np.linspace(0, 1, m)[1:, None]
        rest = np.repeat(to[None], int(rng.uniform(0.1, 0.6) / dt), 0)
        c += [part, rest]
        have += len(part) + len(rest)
        at = to
    return _logged(machine, name, smoothed(np.concatenate(c)[: int(seconds / dt)], dt, 0.16), dt, rate, **more)
