"""What is run: poses, returns, ISO 9283's corners, stations, positions of one axis; tours, sweeps, circles, rectangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from .chains import frame, reached, tips


@dataclass(eq=False)
class Run:
    """Set-points of a run. Poses at rest have `before`, where each axis came from."""

    chain: object
    t: np.ndarray
    values: np.ndarray
    poses: bool
    before: np.ndarray | None = None
    temp: np.ndarray | None = None
    force: np.ndarray | None = None
    name: str = "run"
    told: dict = field(default_factory=dict)

    @property
    def speeds(self):
        return np.gradient(self.values, self.t, axis=0)

    @property
    def accelerations(self):
        return np.gradient(self.speeds, self.t, axis=0)


def bounds(chain, share=1.0):
    low = np.array([j.low for j in chain.joints]) * chain.unit
    high = np.array([j.high for j in chain.joints]) * chain.unit
    middle, half = (low + high) / 2, (high - low) / 2
    return middle - share * half, middle + share * half


def _home(chain):
    return np.array(chain.home) * chain.unit


def drawn(chain, rng, n, share=0.9, still=()):
    """(n, axes) postures over the ranges, the tool above its least height."""
    low, high = bounds(chain, share)
    out = []
    while len(out) < n:
        rows = low + rng.random((4 * n, len(low))) * (high - low)
        rows[:, list(still)] = _home(chain)[list(still)]
        if chain.above is not None:
            rows = rows[tips(chain, rows)[:, 2, 3] > chain.above]
        out.extend(rows)
    return np.array(out[:n])


def _at_rest(chain, values, seconds, start=None):
    before = np.vstack([_home(chain) if start is None else start, values[:-1]])
    return Run(chain, seconds * np.arange(1.0, len(values) + 1), values, True, before)


def poses(chain, rng, n=60, seconds=11.0, share=0.9, still=()):
    """Postures over the workspace, one after the other."""
    return _at_rest(chain, drawn(chain, rng, n, share, still), seconds)


def returns(chain, rng, n=14, seconds=9.0, share=0.75):
    """Each place four times, come to from above and from below in all axes: rows are the places alone."""
    places = drawn(chain, rng, n, share)
    swing = 0.12 * (bounds(chain)[1] - bounds(chain)[0]) * np.ones(places.shape[1])
    values, before = [], []
    for k, place in enumerate(np.repeat(places, 4, axis=0)):
        side = rng.choice([-1.0, 1.0], size=len(place)) if k % 4 > 1 else np.full(len(place), -1.0 if k % 4 else 1.0)
        values.append(place)
        before.append(place - side * swing)
    return Run(chain, seconds * np.arange(1.0, len(values) + 1), np.array(values), True, np.array(before))


def iso_corners(chain, rng, cycles=20, edge=0.5, seconds=4.0):
    """ISO 9283's five poses P1 to P5 in the slanted plane of a cube about HOME, cycle by cycle."""
    start = _home(chain)
    centre = tips(chain, start[None])[0]
    goals = np.tile(centre, (5, 1, 1))
    for k, (x, y, z) in enumerate([(0, 0, 0), (1, 1, 1), (-1, 1, 1), (-1, -1, -1), (1, -1, -1)]):
        goals[k, :3, 3] += 0.4 * edge * np.array([x, y, z])
    corners = reached(chain, goals, start, free=_carriages(chain))
    return _at_rest(chain, np.tile(corners, (cycles, 1)), seconds, corners[-1])


def stations(chain, rng, along=9, each=8, seconds=15.0):
    """A carriage or table stops at stations, up and down again; a few postures at each."""
    e = _carriages(chain)[0]
    low, high = bounds(chain, 0.95)
    places = np.linspace(low[e], high[e], along)
    values = drawn(chain, rng, along * each, 0.7)
    order = np.concatenate([places[::2], places[1::2][::-1]])
    values[:, e] = np.repeat(order, each)
    return _at_rest(chain, values, seconds)


def there_and_back(chain, rng, n=31, runs=3, axis=0, seconds=5.0):
    """ISO 230-2: positions of one axis, up and down, `runs` times; others stand at HOME."""
    low, high = bounds(chain, 0.95)
    up = np.linspace(low[axis], high[axis], n) + 0.004 * (high[axis] - low[axis]) * rng.standard_normal(n)
    path = np.tile(np.concatenate([up, up[::-1]]), runs)
    values = np.tile(_home(chain), (len(path), 1))
    values[:, axis] = path
    before = values.copy()
    before[:, axis] -= np.tile(np.concatenate([np.ones(n), -np.ones(n)]), runs) * 0.02 * (high[axis] - low[axis])
    return Run(chain, seconds * np.arange(1.0, len(path) + 1), values, True, before)


def lattice(chain, rng, nx=8, ny=7, seconds=6.0, turns=True):
    """A plane's lattice by axes that suffice for it (SCARA, cross slide): drawn in axis values, walked to and fro."""
    low, high = bounds(chain, 0.9)
    values = np.tile(_home(chain), (nx * ny, 1))
    first, second = np.meshgrid(np.linspace(low[0], high[0], nx), np.linspace(low[1], high[1], ny), indexing="ij")
    second[1::2] = second[1::2, ::-1]
    values[:, 0], values[:, 1] = first.ravel(), second.ravel()
    if values.shape[1] > 2 and turns:
        values[:, 2:] = low[2:] + rng.random((len(values), values.shape[1] - 2)) * (high[2:] - low[2:])
    return _at_rest(chain, values, seconds)


def _carriages(chain):
    return [i for i, j in enumerate(chain.joints) if j.role != "arm"]


def _smooth(u):
    return 10 * u**3 - 15 * u**4 + 6 * u**5


def through(chain, places, hz, slow=1.0, dwell=0.2):
    """Point to point by quintics, halted at each place."""
    rows, speed = [], np.array([j.speed for j in chain.joints]) * chain.unit / slow
    for a, b in pairwise(places):
        seconds = max(0.3, 1.9 * np.max(np.abs(b - a) / speed))
        u = np.arange(0, seconds, 1 / hz) / seconds
        rows += [a + _smooth(u)[:, None] * (b - a), np.tile(b, (max(1, int(dwell * hz)), 1))]
    values = np.vstack(rows)
    return Run(chain, np.arange(len(values)) / hz, values, False)


def tour(chain, rng, places=8, hz=50.0, slow=1.0, share=0.6, still=()):
    """Dense: through drawn postures."""
    return through(chain, drawn(chain, rng, places, share, still), hz, slow)


def sweeps(chain, rng, axes=(0,), hz=100.0, slow=3.0, times=2, share=0.5):
    """Dense: each of `axes` to and fro by itself at even speed, smooth at its ends."""
    low, high = bounds(chain, share)
    rows = []
    for i in axes:
        i = i if i >= 0 else len(chain.joints) + i
        start = drawn(chain, rng, 1, 0.4)[0] if chain.above is not None else _home(chain)
        period = 2.2 * (high[i] - low[i]) / (chain.joints[i].speed * chain.unit[i] / slow)
        u = np.arange(0, times, 1 / (hz * period))
        wave = 0.5 - 0.5 * np.cos(np.pi * np.abs((2 * u) % 2 - 1 + 0 * u) ** 1.0)
        block = np.tile(start, (len(u), 1))
        block[:, i] = high[i] + (low[i] - high[i]) * wave
        if rows:
            rows.append(through(chain, [rows[-1][-1], block[0]], hz, 1.5).values)
        rows.append(block)
    values = np.vstack(rows)
    return Run(chain, np.arange(len(values)) / hz, values, False)


def circles(chain, rng, radius=0.15, feed=0.15, hz=100.0, turns=1, tilt=0.0):
    """Dense: a circle about HOME's tip in both senses, an over-run before and behind each."""
    start = _home(chain)
    centre = tips(chain, start[None])[0]
    seconds = 2 * np.pi * radius * turns / feed
    u = np.arange(0, seconds + 2.0, 1 / hz)
    way = np.interp(u, [0, 1, seconds + 1, seconds + 2], [0, 0.5, seconds + 0.5, seconds + 1]) * feed / radius
    ramp = np.minimum(1, np.minimum(u, u[-1] - u))
    way = np.cumsum(_smooth(ramp)) / hz * feed / radius
    angle = np.concatenate([way, way[-1] - way])
    goals = np.tile(centre, (len(angle), 1, 1))
    goals[:, :3, 3] += radius * np.stack([np.cos(angle) - 1, np.sin(angle), tilt * np.sin(angle)], axis=1)
    values = reached(chain, goals, start, free=_carriages(chain))
    return Run(chain, np.arange(len(values)) / hz, values, False)


def rectangle(chain, rng, a=0.4, b=0.3, hz=60.0, feed=0.25, levels=2):
    """Dense: rectangles at several heights, quintic along each side, halted in the corners."""
    start = _home(chain)
    centre = tips(chain, start[None])[0]
    corners = [(0, 0), (a, 0), (a, b), (0, b), (0, 0)]
    points = [np.array([x - a / 2, y - b / 2, 0.08 * k]) for k in range(levels) for x, y in corners]
    way = []
    for p, r in pairwise(points):
        seconds = max(0.4, 1.9 * np.linalg.norm(r - p) / feed)
        way.append(p + _smooth(np.arange(0, seconds, 1 / hz) / seconds)[:, None] * (r - p))
        way.append(np.tile(r, (int(0.15 * hz), 1)))
    way = np.vstack(way)
    goals = np.tile(centre, (len(way), 1, 1))
    goals[:, :3, 3] += way
    values = reached(chain, goals, start, free=_carriages(chain))
    return Run(chain, np.arange(len(values)) / hz, values, False)


def milled(chain, rng, hz=40.0, feed=0.08, passes=3):
    """Dense: a pocket's passes at one height, the force of the cut beside them, air between."""
    start = _home(chain)
    centre = tips(chain, start[None])[0]
    way, force = [], []
    for k in range(passes):
        y = 0.05 * k
        for x0, x1, y1, cuts in ((-0.12, 0.12, y, True), (0.12, 0.12, y + 0.05, False), (0.12, -0.12, y + 0.05, True)):
            p, r = np.array([x0, y, 0.0]), np.array([x1, y1, 0.0])
            if not cuts or x1 < x0:
                p[1] = y if not cuts else y + 0.05
            seconds = 1.9 * np.linalg.norm(r - p) / feed
            leg = p + _smooth(np.arange(0, seconds, 1 / hz) / seconds)[:, None] * (r - p)
            along = (r - p) / np.linalg.norm(r - p)
            push = (120 + 90 * np.sin(1.7 * k)) * (1 if cuts else 0) * np.hypot(0.6, 0.8)
            way.append(leg)
            force.append(
                np.tile(-0.5 * push * along + push * np.array([0.6 * along[1], -0.6 * along[0], 0.35]), (len(leg), 1))
            )
    way, force = np.vstack(way), np.vstack(force)
    goals = np.tile(centre, (len(way), 1, 1))
    goals[:, :3, 3] += way
    values = reached(chain, goals, start, free=_carriages(chain))
    ramp = np.ones(7) / 7
    force = np.stack([np.convolve(force[:, i], ramp, "same") for i in range(3)], axis=1)
    return Run(chain, np.arange(len(values)) / hz, values, False, force=force)


def turned(chain, rng, hz=40.0, spread=0.5):
    """Dense: the positioner turns to and fro under an arm that goes through a few postures."""
    run = tour(chain, rng, 5, hz, 2.0, spread)
    e = _carriages(chain)[0]
    low, high = bounds(chain, 0.9)
    run.values[:, e] = (low[e] + high[e]) / 2 + (high[e] - low[e]) / 2 * np.sin(2 * np.pi * run.t / run.t[-1] * 1.5)
    return run


MOVES = {
    f.__name__: f
    for f in (
        poses,
        returns,
        iso_corners,
        stations,
        there_and_back,
        lattice,
        tour,
        sweeps,
        circles,
        rectangle,
        milled,
        turned,
    )
}

__all__ = ["MOVES", "Run", "bounds", "drawn", "frame"]
