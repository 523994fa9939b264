"""How the machines move: work with a tool, poses at rest, drives alone; as set-points on a clock of 4 ms."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

DT = 0.004


@dataclass
class Run:
    """Set-points `c` (N, n) in the chain's q over `t`; `pick` are the rows that are logged; `busy` where the tool works."""

    machine: object
    kind: str
    t: np.ndarray
    c: np.ndarray
    pick: np.ndarray
    busy: np.ndarray
    poses: bool = False
    facts: dict = field(default_factory=dict)

    def rate(self, x):
        return np.zeros_like(x) if self.poses else np.gradient(x, self.t, axis=0)

    @property
    def v(self):
        return self.rate(self.c)

    @property
    def a(self):
        return self.rate(self.v)


def reached(machine, want, turn, start, spun):
    """q (K, n) whose tips are at `want` (K, 3) turned like `turn` (K, 3, 3), and their misses (K,) in m; the spin about the tool
    is free unless `spun`. All set out from `start` and are led to their ends on straight ways, so that neighbours stay
    neighbours."""
    q = np.repeat(start[None], len(want), 0)
    here, keep, m = machine.tip(q), 3 if spun else 2, machine.first
    aside = Rotation.from_matrix(np.swapaxes(here[:, :3, :3], 1, 2) @ turn).as_rotvec()
    for share in (*np.linspace(0.125, 1, 8).repeat(2), *np.ones(4)):
        tip = machine.tip(q)
        back = np.swapaxes(tip[:, :3, :3], 1, 2)
        now = here[:, :3, :3] @ Rotation.from_rotvec(share * aside).as_matrix()
        off = Rotation.from_matrix(back @ now).as_rotvec()
        jac = machine.jacobian(q)[:, :, m:]
        rows = np.concatenate([jac[:, :3], 0.4 * (back @ jac[:, 3:])[:, :keep]], 1)
        miss = here[:, :3, 3] + share * (want - here[:, :3, 3]) - tip[:, :3, 3]
        error = np.concatenate([miss, 0.4 * off[:, :keep]], 1)
        pseudo = np.swapaxes(rows, 1, 2) @ np.linalg.inv(rows @ np.swapaxes(rows, 1, 2) + 1e-6 * np.eye(rows.shape[1]))
        pull = 0.1 * (start[m:] - q[:, m:])
        q[:, m:] += (pseudo @ error[..., None])[..., 0] + pull - (pseudo @ (rows @ pull[..., None]))[..., 0]
    return q, np.abs(machine.tip(q)[:, :3, 3] - want).max(1)


def _paced(length, feed, ramp, shape):
    """Way over time of one leg from rest to rest, on the clock: a speed that rises and falls by `ramp` (m/s2), times
    `shape` (share of the way)."""
    u = np.linspace(0, 1, 1500)
    s = length * u
    v = feed * shape(u)
    v = np.minimum(v, np.sqrt(2 * ramp * (s + 1e-6)))
    v = np.minimum(v, np.sqrt(2 * ramp * (length - s + 1e-6)))
    t = np.concatenate([[0], np.cumsum(np.diff(s) * 2 / (v[1:] + v[:-1]))])
    return np.interp(np.arange(0, t[-1] + DT, DT), t, s)


def _even(u):
    return np.ones_like(u)


# A leg: points (K, 3) in the work's own frame of half sides 1, tilts (K, 2) in rad, spin (K,), feed share, works, rest
# behind it in s, shape of the speed.
def _line(a, b, tilt, spin, feed, busy, rest=0.0, count=9, shape=_even):
    u = np.linspace(0, 1, count)[:, None]
    a, b = np.array(a, float), np.array(b, float)
    two = np.array(tilt, float).reshape(-1, 2)
    return a + (b - a) * u, two[0] + (two[-1] - two[0]) * u, np.full(count, float(spin)), feed, busy, rest, shape


def facing(rng):
    """A face in strokes with step-overs, at two or three heights, lifted and carried back between them."""
    legs, lean = [], rng.uniform(-0.25, 0.25, 2)
    heights = np.linspace(0.6, -0.7, int(rng.integers(2, 4)))
    strokes, along = int(rng.integers(4, 6)), int(rng.integers(2))
    for z in heights:
        lane = np.linspace(-0.85, 0.85, strokes)
        if rng.random() < 0.5:
            lane = lane[::-1]
        for i, y in enumerate(lane):
            ends = [[-0.95, y, z], [0.95, y, z]][:: 1 if i % 2 == 0 else -1]
            ends = [[p[along], p[1 - along], p[2]] for p in ends]
            lean = -lean
            legs.append(_line(*ends, [-lean, lean], 0.3 * (y + 0.2), 1.0, True))
            if i + 1 < strokes:
                over = list(ends[1])
                over[1 - along] = lane[i + 1]
                legs.append(_line(ends[1], over, lean, 0.3 * (y + 0.2), 0.6, True, count=4))
        legs.append(_line(legs[-1][0][-1], [*legs[-1][0][-1][:2], 0.95], lean, 0.0, 1.6, False, 0.3, 4))
    return legs


def drilling(rng):
    """Holes on a grid or a ring of bolts: over the hole fast, down with two pecks, a dwell at the bottom, out."""
    count = int(rng.integers(8, 12))
    if rng.random() < 0.5:
        turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
        holes = np.stack([0.9 * np.cos(turn), 0.9 * np.sin(turn)], 1)
    else:
        holes = np.array([[x, y] for y in (-0.8, 0, 0.8) for x in (-0.9, -0.3, 0.3, 0.9)])[:count]
    legs, last, deep = [], None, rng.uniform(-0.8, -0.4)
    for x, y in holes:
        lean = 0.3 * np.array([y, -x]) * rng.uniform(0.3, 1)
        over = [x, y, 0.1 + 0.6 * rng.random()]
        if last is not None:
            legs.append(_line(last, over, lean, 0.3 * x, 2.0, False, 0.2))
        peck = [x, y, 0.4 * over[2] + 0.6 * deep]
        legs += [
            _line(over, peck, lean, 0.3 * x, 0.4, True, count=4),
            _line(peck, [x, y, 0.7 * over[2] + 0.3 * deep], lean, 0.3 * x, 1.0, False, count=4),
            _line([x, y, 0.7 * over[2] + 0.3 * deep], [x, y, deep], lean, 0.3 * x, 0.5, True, 0.5, 4),
            _line([x, y, deep], over, lean, 0.3 * x, 1.6, False, count=4),
        ]
        last = over
    return legs


def ballbar(rng):
    """Circles about one centre at three radii in planes that lean, each there and at once back, with a run in and a rest."""
    legs = []
    for radius in rng.permutation([0.4, 0.65, 0.95]):
        plane = Rotation.from_euler("xy", rng.uniform(-1.2, 1.2, 2)).as_matrix()
        for sense in (1, -1):
            u = np.linspace(0, 1, 49)
            turn = 2 * np.pi * 1.1 * sense * u + rng.uniform(0, 6)
            ring = (plane @ (radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn]))).T
            tilt = 0.2 * np.stack([np.sin(turn), np.cos(turn)], 1)
            legs.append((ring, tilt, 0.4 * np.cos(turn), float(rng.choice([0.7, 1.2, 1.8])), True, 0.6, _even))
    return legs


def wall(rng):
    """A thin wall's contour that climbs as it goes round, a rounded outline, its feed ramped up and down all the way."""
    rounds = int(rng.integers(3, 5))
    u = np.linspace(0, 1, 70 * rounds)
    turn, power = 2 * np.pi * rounds * u, rng.uniform(0.45, 0.7)
    out = np.stack([np.cos(turn), np.sin(turn)], 1)
    out = 0.92 * np.sign(out) * np.abs(out) ** power * [1, rng.uniform(0.5, 0.9)]
    points = np.column_stack([out, -0.8 + 1.6 * u])
    tilt = rng.uniform(0.1, 0.3) * np.stack([-np.sin(turn), np.cos(turn)], 1)
    beats = rng.uniform(3, 7)
    return [
        (points, tilt, 0.35 * np.sin(turn + 1), 1.5, True, 0.0, lambda s: 0.35 + 0.65 * np.sin(np.pi * beats * s) ** 2)
    ]


def _joined(legs):
    """With ways between legs whose ends lie apart; where only the turn differs, it fades along the next one."""
    out = []
    for leg in legs:
        points, tilt, spin, *rest = leg
        if out:
            before, fade = out[-1], np.linspace(1, 0, len(points)) ** 2
            if np.abs(before[0][-1] - points[0]).max() > 1e-9:
                way = _line(before[0][-1], points[0], [before[1][-1], tilt[0]], 0.0, 1.5, False, 0.2)
                out.append((*way[:2], np.linspace(before[2][-1], spin[0], len(way[0])), *way[3:]))
            else:
                tilt = tilt + fade[:, None] * (before[1][-1] - tilt[0])
                spin = spin + fade * (before[2][-1] - spin[0])
        out.append((points, tilt, spin, *rest))
    return out


PATHS = {"facing": facing, "drilling": drilling, "ballbar": ballbar, "wall": wall}


def worked(machine, rng, name, rows):
    """A run of a path about a place of the machine's own, thinned to about so many rows; places that it can't work at
    are drawn anew."""
    while True:
        run = _tried(machine, rng, _joined(PATHS[name](rng)), rows)
        if run is not None:
            run.kind = name
            return run


def _tried(machine, rng, legs, rows):
    start = machine.middle + 0.45 * rng.uniform(-1, 1, machine.n) * machine.spread
    here = machine.tip(start[None])[0]
    yaw = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi))
    want = here[:3, 3] + yaw.apply(np.concatenate([leg[0] for leg in legs]) * machine.room)
    lean = Rotation.from_euler("xyz", np.concatenate([np.column_stack(leg[1:3]) for leg in legs])).as_matrix()
    nodes, miss = reached(machine, want, here[:3, :3] @ lean, start, machine.n >= 6 + machine.first)
    if miss.max() > 1e-5:
        return None
    q, busy, first = [], [], 0
    for points, _, _, feed, works, rest, shape in legs:
        mine = slice(first, first + len(points))
        first += len(points)
        way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(want[mine], axis=0), axis=1))])
        s = _paced(way[-1], feed * machine.feed, 4 * machine.feed, shape)
        q.append(CubicSpline(way, nodes[mine])(s))
        q.append(np.repeat(q[-1][-1:], int(rest / DT), 0))
        busy += [np.full(len(s), works), np.zeros(len(q[-1]), bool)]
    q, busy = np.concatenate(q), np.concatenate(busy)
    if machine.table:
        s, wheel = np.linspace(0, 1, len(q)), rng.uniform(0.4, 1.0) * machine.spread[0] * rng.choice([-1, 1])
        q[:, 0] = machine.middle[0] + wheel * np.sin(2 * np.pi * (1.3 * s + rng.random())) + 0.5 * wheel * s
    q = _soft(q, (25, 15))
    hurry = (np.abs(np.gradient(q, DT, axis=0)) / machine.each("top")).max()
    if hurry > 3 or np.ptp(q, axis=0)[~machine.slides].max() > 2.8:
        return None
    if hurry > 0.8:  # the slowest axis sets the pace
        thin = np.arange(0, len(q) - 1, 0.8 / hurry)
        q, busy = CubicSpline(np.arange(len(q)), q)(thin), busy[thin.astype(int)]
        q = _soft(q, (15,))
    every = max(3, round(len(q) / rows))
    return Run(machine, "", np.arange(len(q)) * DT, q, np.arange(int(rng.integers(every)), len(q), every), busy)


def _soft(q, widths):
    """Means over so many cycles: what a controller's filter of set-points does."""
    for width in widths:
        q = uniform_filter1d(q, width, axis=0, mode="nearest")
    return q


def _posed(machine, rng, name, pace, count, draw, wide, about):
    """So many poses of `draw(K)` -> places (K, 3) in half sides and turns, about a place of the machine's own; those that it
    can't come to are left out."""
    q = np.zeros((0, machine.n))
    while len(q) < count:
        at, turn = draw(3 * count)
        start = machine.middle + wide * rng.uniform(-1, 1, machine.n) * machine.spread
        here = machine.tip(start[None])[0]
        yaw = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi))
        want = here[:3, 3] + about * machine.room * yaw.apply(at)
        q, miss = reached(machine, want, here[:3, :3] @ turn.as_matrix(), start, machine.n >= 6 + machine.first)
        q = q[(miss < 1e-5) & (np.abs(q - start)[:, ~machine.slides].max(1) < 1.4)]
    q = q[:count] + 0.2 * rng.uniform(-1, 1, (count, machine.n)) * machine.spread
    if machine.table:
        q[:, 0] = machine.middle[0] + machine.spread[0] * rng.uniform(-1, 1, len(q))
    t = np.cumsum(pace * rng.uniform(0.8, 1.3, len(q)))
    return Run(machine, name, t, q, np.arange(len(q)), np.zeros(len(q), bool), poses=True)


def diagonal(machine, rng, count):
    """Five points on a cube's diagonal plane, visited again and again in cycles, each time in another order, size and leaning."""
    corners = 0.9 * np.array([[0, 0, 0], [-1, -1, 1], [1, -1, 1], [1, 1, -1], [-1, 1, -1]])

    def draw(count):
        order = np.concatenate([rng.permutation(5) for _ in range(count // 5 + 1)])[:count]
        at = corners[order] * rng.choice([1.0, 0.6], (count, 1)) + rng.uniform(-0.05, 0.05, (count, 3))
        lean = np.column_stack([rng.choice([-0.35, 0.0, 0.35], (count, 2)), rng.choice([-0.6, 0.0, 0.6], count)])
        return at, Rotation.from_euler("xyz", lean)

    return _posed(machine, rng, "diagonal", 12, count, draw, 0.3, 1.4)


def cone(machine, rng, count):
    """Places at random in the room, the tool at random inside a cone of 35 degrees."""

    def draw(count):
        aside, about = np.radians(35) * np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
        lean = Rotation.from_rotvec(np.stack([aside * np.cos(about), aside * np.sin(about), 0 * aside], 1))
        spin = Rotation.from_rotvec(np.stack([0 * aside, 0 * aside, rng.uniform(-1, 1, count)], 1))
        return rng.uniform(-1, 1, (count, 3)), lean * spin

    return _posed(machine, rng, "cone", 20, count, draw, 0.2, 1.6)


POSES = {"diagonal": diagonal, "cone": cone}


def binary(machine, rng, rows):
    """Every axis to and fro by a sequence of maximal length, its own shift and step; speeds that are filtered."""
    count = rows * 4
    bits = np.ones(7, int)
    chain = []
    for _ in range(127):
        chain.append(bits[-1])
        bits = np.concatenate([[bits[-1] ^ bits[-2]], bits[:-1]])
    chain = 2 * np.array(chain) - 1
    v = np.zeros((count, machine.n))
    for i in range(machine.n):
        hold = rng.uniform(0.12, 0.5)
        k = (np.arange(count) * DT / hold).astype(int) + int(rng.integers(127))
        v[:, i] = chain[k % 127] * machine.axes[i].top * rng.uniform(0.15, 0.45)
    v = _soft(v, (31, 31, 13))
    v -= v.mean(0)
    q = np.cumsum(v, 0) * DT
    q *= np.minimum(1, machine.spread / np.abs(q - q.mean(0)).max(0))
    return _alone(machine, rng, "binary", machine.middle + q - q.mean(0), 4)


def stairs(machine, rng, rows):
    """Axes step after one another up a stair whose treads grow, halt on each, and come down at once."""
    count, t = rows * 4, np.arange(rows * 4) * DT
    q = np.repeat(machine.middle[None], count, 0)
    for i in range(machine.n):
        treads = int(rng.integers(4, 7))
        period = t[-1] * rng.uniform(0.45, 0.6)
        phase = np.mod(t / period + i / machine.n, 1.0)
        up = np.cumsum(np.arange(1, treads + 1))
        level = np.interp(np.floor(phase * (treads + 1)), np.arange(treads + 1), [0, *(up / up[-1])])
        q[:, i] += 0.7 * machine.spread[i] * (level - 0.5) * rng.choice([-1, 1])
    q = _soft(q, (int(rng.integers(100, 160)), 61, 25))
    fast = (np.abs(np.gradient(q, DT, axis=0)) / machine.each("top")).max(0)
    q = machine.middle + (q - machine.middle) * np.minimum(1, 0.8 / np.maximum(fast, 1e-9))
    return _alone(machine, rng, "stairs", q, 4)


def _alone(machine, rng, name, q, every):
    t = np.arange(len(q)) * DT
    return Run(machine, name, t, q, np.arange(int(rng.integers(every)), len(q), every), np.ones(len(q), bool))


DRIVES = {"binary": binary, "stairs": stairs}
