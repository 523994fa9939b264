"""How workshops move a machine to measure it: poses at rest, and runs that are recorded as they go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from .arms import placed, solved, tip


@dataclass(eq=False)
class Run:
    """Set-points `v` (N, n) at `t`; of poses `came`, where the machine stood or turned before."""

    m: object
    t: np.ndarray
    v: np.ndarray
    came: np.ndarray | None = None
    name: str = ""
    temp: np.ndarray | None = None
    force: np.ndarray | None = None
    goals: np.ndarray | None = None  # (N, 3) of a ball that seats in a nest
    dock: np.ndarray | None = None  # number of the tool's docking, row by row
    target: np.ndarray | None = None  # (4, 4) from the tip to what the instrument sees

    @property
    def rests(self):
        return self.came is not None

    @property
    def speed(self):
        return np.gradient(self.v, self.t, axis=0)

    @property
    def jerkless(self):
        """Acceleration (N, n)."""
        return np.gradient(self.speed, self.t, axis=0)

    @property
    def part(self):
        """0 to 1 over the record."""
        return (self.t - self.t[0]) / np.ptp(self.t)


def postures(m, rng, n, share=1.0):
    """Drawn postures (n, axes) that a person would choose: within ranges and above the floor."""
    lo, hi = m.limits.T
    middle, half = (lo + hi) / 2, share * (hi - lo) / 2
    kept = []
    while len(kept) < n:
        v = middle + half * rng.uniform(-1, 1, len(lo))
        p = tip(m, v[None])[0, :3, 3]
        if m.floor is None or p[2] > m.floor:
            kept.append(v)
    return np.array(kept)


def _stands(m, v, came=None, pause=25.0):
    came = np.vstack([m.at_home, v[:-1]]) if came is None else came
    return Run(m, pause * np.arange(len(v)), v, came)


def tracker_poses(m, rng, n=50):
    """Poses all over the room, one after another."""
    return _stands(m, postures(m, rng, n))


def both_sides(m, rng, n=18, turn=4.0, slide=25.0):
    """Each pose come to from above and from below in all axes."""
    v = np.repeat(postures(m, rng, n, 0.85), 2, axis=0)
    step = np.where(m.slides, slide * 1e-3, np.radians(turn)) * rng.uniform(0.7, 1.3, v.shape)
    step[1::2] *= -1
    return _stands(m, v, v + step)


def check_days(m, rng, n=9, days=12):
    """The same few check poses at every shift's begin."""
    v = postures(m, np.random.default_rng(int(rng.integers(1 << 30))), n, 0.8)
    run = _stands(m, np.tile(v, (days, 1)), np.tile(np.vstack([m.at_home, v[:-1]]), (days, 1)))
    day = np.repeat(np.arange(days), n)
    run.t = 86400.0 * day + 30.0 * np.tile(np.arange(n), days) + 600.0 * rng.uniform(0, 1, days)[day]
    run.dock = day
    return run


def nests(m, rng, k=4, each=12, tilt=32.0, spread=0.4):
    """A ball at the tool seats in a few nests on the bench, again and again under other postures."""
    home = tip(m, m.at_home[None])[0]
    free = (0,) if m.first else ()
    goals = []
    for j in range(k):
        at = home[:3, 3] + spread * rng.uniform(-1, 1, 3) * np.array([0.6, 1.0, 0.35])
        for _ in range(each):
            T = home @ placed(a=rng.uniform(-110, 110)) @ placed(b=rng.uniform(-tilt, tilt), c=rng.uniform(-tilt, tilt))
            T[:3, 3] = at
            goals.append((j, T))
    v = []
    for _, T in goals:
        try:
            v.append(solved(m, T[None], m.at_home, free)[0])
        except ValueError:
            v.append(None)
    lo, hi = m.limits.T
    kept = [k for k, row in enumerate(v) if row is not None and np.all((row > lo - 0.5) & (row < hi + 0.5))]
    run = _stands(m, np.array([v[k] for k in kept]))
    run.goals = np.array([goals[k][1][:3, 3] for k in kept])
    return run


def stations(m, rng, along=8, each=7):
    """The first axis stops at marks; at each a few poses of the arm."""
    lo, hi = m.limits[0]
    at = np.linspace(lo + 0.06 * (hi - lo), hi - 0.06 * (hi - lo), along)
    v = postures(m, rng, along * each, 0.85)
    v[:, 0] = np.repeat(at, each) + 0.01 * (hi - lo) * rng.uniform(-1, 1, along * each)
    return _stands(m, v)


def single_turns(m, rng, axes=(0,), n=37, legs=2):
    """One axis at a time through its range in even steps, there and back, the others at rest."""
    rows, came = [], []
    for leg in range(legs):
        for i in axes:
            lo, hi = m.limits[i]
            steps = np.linspace(lo, hi, n) + rng.uniform(-0.3, 0.3) * (hi - lo) / n
            order = np.concatenate([steps, steps[::-1]])
            v = np.tile(m.at_home, (2 * n, 1))
            if leg:
                v += 0.25 * (postures(m, rng, 1)[0] - m.at_home) * (np.arange(len(m.axes)) > max(axes))
            v[:, i] = order
            rows.append(v)
            came.append(np.vstack([v[0] - (steps[1] - steps[0]) * (np.arange(v.shape[1]) == i), v[:-1]]))
    return _stands(m, np.vstack(rows), np.vstack(came), 8.0)


def grid(m, rng, n=(5, 4, 3)):
    """Marks in a plane or a box of three axes, come to alternately from either side."""
    lo, hi = (m.limits[:3] + 0.08 * np.ptp(m.limits[:3], axis=1)[:, None] * np.array([1, -1])).T
    nodes = [np.linspace(a, b, k) for a, b, k in zip(lo, hi, n, strict=True)]
    v = np.tile(m.at_home, (int(np.prod(n)), 1))
    v[:, :3] = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    v = v + np.where(m.slides, 6e-3, 0.03) * rng.uniform(-1, 1, v.shape)
    if len(m.axes) > 3:
        v[:, 3:] += np.radians(60) * rng.uniform(-1, 1, v[:, 3:].shape)
    v = np.repeat(v, 2, axis=0)
    step = np.where(m.slides, 0.03, 0.08) * np.where(np.arange(len(v)) % 2, 1, -1)[:, None]
    return _stands(m, v, v + step * rng.uniform(0.8, 1.2, v.shape), 6.0)


def tour(m, rng, seconds=50.0, hz=40.0, share=0.8, brisk=1.0):
    """From posture to posture without rest, all axes at once."""
    v, t = [m.at_home], [0.0]
    while t[-1] < seconds:
        new = postures(m, rng, 1, share)[0]
        t.append(t[-1] + max(1.2, 1.9 * np.max(np.abs(new - v[-1]) / m.tops) / brisk))
        v.append(new)
    at = np.arange(0, t[-1], 1 / hz)
    return Run(m, at, CubicSpline(t, np.array(v), bc_type="clamped")(at))


def _followed(m, points, feed, hz, rng):
    """A closed way of the tip (K, 3) at a steady feed with soft begin and end, its orientation that of home."""
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    length, ramp = way[-1], 0.5
    seconds = length / feed + ramp
    t = np.arange(0, seconds, 1 / hz)
    rise = np.clip(t / ramp, 0, 1)
    fall = np.clip((seconds - t) / ramp, 0, 1)
    s = np.cumsum(feed * np.minimum(rise**2 * (3 - 2 * rise), fall**2 * (3 - 2 * fall)))
    s *= length / s[-1]
    goals = np.tile(tip(m, m.at_home[None])[0], (len(t), 1, 1))
    for k in range(3):
        goals[:, k, 3] = np.interp(s, way, points[:, k])
    free = [0] if m.first else []
    free += [
        i for i in range(m.first, len(m.axes)) if len(m.axes) - m.first < 5 and not m.slides[i] and i == len(m.axes) - 1
    ]
    turns = len(m.axes) - m.first >= 6
    return Run(m, t, solved(m, goals, m.at_home, free, turns=turns))


def ball_bar(m, rng, radius=0.15, feed=0.12, hz=50.0, laps=2, upright=False):
    """Circles in one sense and in the other, as a ball bar is run; level and, with `upright`, standing."""
    u = np.linspace(0, 2 * np.pi * laps, 300 * laps)
    angle = np.concatenate([u, u[-1] - u[1:]])
    centre = tip(m, m.at_home[None])[0, :3, 3] - np.array([radius, 0, 0]) + 0.03 * rng.uniform(-1, 1, 3)
    rings = [np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)]
    if upright:
        rings.append(np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1))
    return _followed(m, centre + radius * np.vstack(rings), feed, hz, rng)


def test_part(m, rng, size=0.26, feed=0.15, hz=50.0, laps=3):
    """Rounded squares and a diagonal both ways: the test part of a cell."""
    u = np.linspace(0, 2 * np.pi, 400)
    p = 8.0
    r = (np.abs(np.cos(u)) ** p + np.abs(np.sin(u)) ** p) ** (-1 / p)
    square = size / 2 * np.stack([r * np.cos(u), r * np.sin(u), 0.12 * np.sin(2 * u)], axis=1)
    lanes = [square if k % 2 == 0 else square[::-1] for k in range(laps)]
    centre = tip(m, m.at_home[None])[0, :3, 3] - np.array([size / 2, 0, 0]) + 0.04 * rng.uniform(-1, 1, 3)
    return _followed(m, centre + np.vstack(lanes), feed, hz, rng)


def warm_up(m, rng, hz=50.0, reach=0.55, seconds=9.0):
    """Each axis in turn, there and back slowly and then quicker, and all of them together at the end."""
    lo, hi = m.limits.T
    n = len(m.axes)
    t = np.arange(0, seconds * (n + 1), 1 / hz)
    v = np.tile(m.at_home, (len(t), 1))
    for i in range(n + 1):
        u = np.clip((t - i * seconds) / seconds, 0, 1)
        swing = np.where(u < 0.6, np.sin(np.pi * u / 0.6) ** 2, np.sin(np.pi * (u - 0.6) / 0.2) ** 2)
        for k in [i] if i < n else range(n):
            room = reach * rng.uniform(0.8, 1.0) * min(hi[k] - m.at_home[k], m.at_home[k] - lo[k])
            most = m.tops[k] * seconds * 0.2 / np.pi
            v[:, k] += np.sign(rng.uniform(-1, 1)) * min(room, most) * swing
    return Run(m, t, v)


def slow_sweeps(m, rng, axes=(0,), span=24.0, hz=50.0, seconds=26.0):
    """One axis at a time slowly to and fro (`span` degrees or 8 mm by degree), as one looks for waves of a gear."""
    rows, t0 = [], 0.0
    for i in axes:
        t = np.arange(0, seconds, 1 / hz)
        half = span * (8.0 if m.slides[i] else 1.0) * m.unit[i] / 2
        v = np.tile(m.at_home, (len(t), 1))
        v[:, i] += half * np.sin(2 * np.pi * t / seconds + rng.uniform(0, 0.4))
        if len(rows):
            v[:, i] += half * 0.1
        rows.append((t + t0, v))
        t0 += seconds
    return Run(m, np.concatenate([t for t, _ in rows]), np.vstack([v for _, v in rows]))


def rail_run(m, rng, hz=40.0, seconds=40.0):
    """The carriage end to end and back, twice, the arm nearly still, other on the second way."""
    lo, hi = m.limits[0] + 0.04 * np.ptp(m.limits[0]) * np.array([1, -1])
    t = np.arange(0, seconds, 1 / hz)
    u = (1 - np.cos(4 * np.pi * t / seconds)) / 2
    a, b = postures(m, rng, 2, 0.4)
    w = np.clip((t / seconds - 0.4) / 0.2, 0, 1)
    w = (w**2 * (3 - 2 * w))[:, None]
    v = m.at_home + 0.35 * ((1 - w) * (a - m.at_home) + w * (b - m.at_home)) + 0.03 * np.sin(0.9 * t)[:, None]
    v[:, 0] = lo + (hi - lo) * u
    return Run(m, t, v)


def deburring(m, rng, **how):
    """The test part under a grinding wheel that presses."""
    run = test_part(m, rng, **how)
    t = run.t
    on = np.clip(4 * np.sin(2 * np.pi * t / 5.3 + 0.4) + 1, 0, 1)
    push = np.stack([14 * np.sin(0.7 * t), 11 * np.cos(0.5 * t + 1), 24 + 7 * np.sin(1.3 * t)], axis=1)
    run.force = on[:, None] * push
    return run


MOVES = {
    f.__name__: f
    for f in (
        tracker_poses,
        both_sides,
        check_days,
        nests,
        stations,
        single_turns,
        grid,
        tour,
        ball_bar,
        test_part,
        warm_up,
        slow_sweeps,
        rail_run,
        deburring,
    )
}
