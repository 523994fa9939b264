"""How the machines move: machining and handling on a controller's clock of 4 ms, and single poses before a tracker.

A run has set-points q (N, n) on a clock, the rows that are logged (`pick`), what pushes on the tool, and how warm it is.
Work is drawn as points that a tool visits at a feed; the controller rounds its corners by a filter of two moving means, as
interpolators do, and slows down there. Of single poses a row is a pose, and `moves` the last move to it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from gap.ninth_author.arms import Arm, twist

__all__ = ["DT", "Run", "drives", "handle", "poses", "work"]

DT = 0.004


@dataclass
class Run:
    """A motion: clock t (N,), set-points q (N, n), logged rows, force on the tool in world (N, 3) N, warmth (N,) in K."""

    arm: Arm
    kind: str
    t: np.ndarray
    q: np.ndarray
    pick: np.ndarray
    temp: np.ndarray
    force: np.ndarray
    moves: np.ndarray | None = None
    waits: np.ndarray | None = None
    blocks: np.ndarray | None = None  # the set-point at each block's end (N, n)
    kept: dict = field(default_factory=dict)

    @property
    def dt(self) -> float:
        """The clock's step, s."""
        return DT

    def rate(self, order=1):
        """Speeds (N, n), or accelerations; zeros of single poses."""
        if self.kind == "poses":
            return np.zeros_like(self.q)
        out = self.q
        for _ in range(order):
            out = np.gradient(out, DT, axis=0)
        return out

    def hold(self, name, make):
        """Something that is reckoned once."""
        if name not in self.kept:
            self.kept[name] = make()
        return self.kept[name]

    @property
    def loads(self):
        """Gravity's loads (N, n), Nm; reckoned at every fifth step and drawn through."""
        return self.hold("loads", lambda: self.slow(self.arm.loads))

    @property
    def moment(self):
        """Overturning moments about the foot (N, 3)."""
        return self.hold("moment", lambda: self.slow(self.arm.moment))

    def slow(self, what):
        """what(q) where it changes slowly: reckoned at every fifth step, lines between."""
        if self.kind == "poses":
            return what(self.q)
        at = np.unique(np.append(np.arange(0, len(self.q), 5), len(self.q) - 1))
        return lines(self.t, self.t[at], what(self.q[at]))

    @property
    def work(self):
        """What the force on the tool asks of each axis (N, n), Nm: J^T f."""
        return self.hold("work", self._work)

    def _work(self):
        if not self.force.any():
            return np.zeros_like(self.q)
        if self.kind == "poses":
            J = self.arm.jacobian(self.q)[:, :3]
        else:
            J = self.slow(lambda q: self.arm.jacobian(q)[:, :3].reshape(len(q), -1)).reshape(-1, 3, self.arm.n)
        return np.einsum("nij,ni->nj", J, self.force)


def lines(at, t, v):
    """v (M, k) at other times, by lines between."""
    i = np.clip(np.searchsorted(t, at) - 1, 0, len(t) - 2)
    u = ((at - t[i]) / (t[i + 1] - t[i])).reshape(-1, *[1] * (v.ndim - 1))
    return v[i] * (1 - u) + v[i + 1] * u


def _pocket(rng, size):
    """Points (K, 3), cutting or not (K,): rectangles one in another, at two depths, left through the air."""
    a, b = size * rng.uniform(0.8, 1.2), size * rng.uniform(0.5, 0.8)
    p, cut = [[0, 0, 0.3 * size]], [False]
    for depth in (0.0, -0.08 * size):
        for k in range(3):
            u, v = a * (1 - 0.3 * k), b * (1 - 0.3 * k)
            ring = [[u, v, depth], [-u, v, depth], [-u, -v, depth], [u, -v, depth], [u, v, depth]]
            p += ring
            cut += [k > 0 or depth < 0, *[True] * 4]
        p += [[p[-1][0], p[-1][1], 0.25 * size], [0, 0, 0.3 * size]]
        cut += [False, False]
    return np.array(p), np.array(cut)


def _trim(rng, size):
    """The edge of a shell, like a saddle, twice around: in and out through the air."""
    n = 72
    f = np.linspace(0, 4 * np.pi, n) + rng.uniform(0, 6)
    e = rng.uniform(0.55, 0.75)
    r = (np.abs(np.cos(f)) ** 3 + np.abs(np.sin(f)) ** 3) ** (-1 / 3)
    p = size * np.stack([r * np.cos(f), e * r * np.sin(f), rng.uniform(0.15, 0.3) * np.cos(2 * f)], 1)
    p = np.concatenate([[[0, 0, 0.35 * size]], p, [[0, 0, 0.35 * size]]])
    return p, np.r_[False, False, np.ones(n - 1, bool), False]


def _polish(rng, size):
    """Weaving along a bow, there and back at another height."""
    n = 90
    s = np.linspace(-1, 1, n)
    bow = np.stack([size * s, 0.22 * size * np.sin(9 * np.pi * s) + 0.3 * size * s**2, 0.2 * size * (1 - s**2)], 1)
    back = bow[::-1] + np.array([0, 0.25 * size, rng.uniform(0.05, 0.12) * size])
    p = np.concatenate([[[-size, 0, 0.4 * size]], bow, back, [[-size, 0, 0.4 * size]]])
    return p, np.r_[False, False, np.ones(2 * n - 1, bool), False]


SHAPES = {"pocket": _pocket, "trim": _trim, "polish": _polish}


def _timed(p, feed, rapid, cut):
    """Times of points: each block at its feed, corners slower."""
    step = np.linalg.norm(np.diff(p, axis=0), axis=1)
    speed = np.where(cut[1:], feed, rapid)
    u = np.diff(p, axis=0) / np.maximum(step, 1e-9)[:, None]
    turn = np.ones(len(step))
    turn[1:] = 0.4 + 0.6 * (1 + np.einsum("ij,ij->i", u[1:], u[:-1])) / 2
    return np.concatenate([[0.0], np.cumsum(step / speed / turn + 0.02)])


def work(arm: Arm, rng, shape, rows, ticks, warm=(4.0, 9.0), pushed=True) -> Run:
    """A tool at work along a shape; `ticks` of 12 ms a logged row."""
    reach = np.linalg.norm(arm.jacobian(arm.middle[None])[0, :3, arm.first + (arm.slides[arm.first])])
    size = reach * rng.uniform(0.13, 0.18)
    p, cut = SHAPES[shape](rng, size)
    turn = twist(np.r_[0, 0, 0, 0.15 * rng.normal(size=2), rng.uniform(-0.6, 0.6)])[:3, :3]
    p = p @ turn.T + rng.uniform(-0.25, 0.25, 3) * size
    whole = rows * ticks * 0.012
    at = _timed(p, 1.0, 2.5, cut)
    at *= (whole - 0.8) / at[-1]
    t = np.arange(round(whole / DT)) * DT
    way = np.stack([np.interp(t - 0.4, at, c) for c in p.T], 1)
    wide = round(rng.uniform(0.1, 0.2) / DT)
    for _ in range(2):
        way = uniform_filter1d(way, wide, axis=0, mode="nearest")
    q = _posed(arm, rng, t, way)
    engaged = uniform_filter1d(np.interp(t - 0.4, at, cut.astype(float), left=0) > 0.5, 25, output=float)
    force = _force(rng, t, way, engaged, reach) if pushed else np.zeros((len(t), 3))
    temp = warm[0] + (warm[1] - warm[0]) * t / t[-1]
    which = np.clip(np.searchsorted(at, t - 0.4), 0, len(at) - 1)
    ends = np.array([np.argmin(np.abs(t - 0.4 - x)) for x in at])
    pick = np.arange(rows) * round(ticks * 0.012 / DT)
    return Run(arm, "path", t, q, pick, temp, force, blocks=q[ends[which]])


def _posed(arm, rng, t, way):
    """Set-points: the tool's tip along the way about the machine's middle, leaning a little as it goes."""
    knots = np.unique(np.append(np.arange(0, len(t), 8), len(t) - 1))
    home = arm.tips(arm.middle[None])[0]
    lean = 0.1 * rng.normal(size=(2, 2))
    phase = np.linspace(0, 2 * np.pi, len(knots)) * rng.uniform(1, 3)
    w = np.zeros((len(knots), 6))
    w[:, 3:5] = np.stack([np.sin(phase), np.cos(phase) - 1], 1) @ lean
    targets = twist(w) @ home
    targets[:, :3, 3] = home[:3, 3] + way[knots]
    q = np.repeat(arm.middle[None], len(knots), 0)
    fixed = []
    for i, name in enumerate(arm.names):
        if name.startswith("E"):
            f = rng.uniform(0.7, 2.3) * np.linspace(0, 2 * np.pi, len(knots))
            q[:, i] += arm.spread[i] * rng.uniform(0.7, 1.0) * np.sin(f + rng.uniform(0, 6))
            fixed.append(i)
    if "E1" in arm.names:  # the work goes a part of the way with the carriage
        i = arm.names.index("E1")
        targets[:, 1, 3] += 0.75 * (q[:, i] - arm.middle[i])
    q = arm.inverse(targets, q, fixed)
    fine = CubicSpline(t[knots], q)(t)
    return uniform_filter1d(fine, 9, axis=0, mode="nearest")


def _force(rng, t, way, engaged, reach):
    """N: a pull against the feed, a push aside and an axial thrust, each tooth's hammering averaged by the sensor."""
    v = np.gradient(way, DT, axis=0)
    u = v / (np.linalg.norm(v, axis=1, keepdims=True) + 0.01)
    side = np.cross(u, [0.0, 0.0, 1.0])
    mean = rng.uniform(120, 260) * min(1.0, (reach / 1.3) ** 2)
    swell = 1 + 0.35 * np.sin(2 * np.pi * t / rng.uniform(2, 6)) * np.sin(2 * np.pi * t / rng.uniform(9, 14) + 1)
    swell += 0.1 * uniform_filter1d(rng.normal(size=len(t)), 5) * np.sqrt(5)
    load = (mean * engaged * swell)[:, None]
    return load * (
        -rng.uniform(0.5, 1) * u + rng.uniform(-0.9, 0.9) * side + rng.uniform(0.1, 0.5) * np.array([0, 0, 1.0])
    )


def _soft_steps(t, at, values):
    """Moves from value to value (K, n) at times (K,), each by a curve of seventh order that ends before the next begins."""
    out = np.repeat(values[:1], len(t), 0)
    for k in range(1, len(at)):
        long = 0.75 * (at[k] - at[k - 1])
        u = np.clip((t - at[k - 1]) / long, 0, 1)[:, None]
        s = u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)
        out += s * (values[k] - values[k - 1])
    return out


def handle(arm: Arm, rng, rows, ticks, warm=(5.0, 8.0), stations=6) -> Run:
    """Handling: from station to station through places above them, a rest at each."""
    whole = rows * ticks * 0.012
    t = np.arange(round(whole / DT)) * DT
    spots = arm.middle + rng.uniform(-1, 1, (stations, arm.n)) * arm.spread
    order = rng.integers(0, stations, 400)
    order = order[np.r_[True, np.diff(order) != 0]]
    values, at, now = [arm.middle], [0.2], 0.2
    for k in order:
        aim = spots[k] + 0.02 * rng.normal(size=arm.n) * arm.spread
        long = np.max(np.abs(aim - values[-1]) / (1.1 * arm.speed)) * 2.2 / 0.75 + 0.3
        now += max(long, 0.5)
        if now > whole - 0.3:
            break
        values.append(aim)
        at.append(now)
    q = _soft_steps(t, np.array(at), np.array(values))
    pick = np.arange(rows) * round(ticks * 0.012 / DT)
    temp = warm[0] + (warm[1] - warm[0]) * t / t[-1]
    return Run(arm, "path", t, q, pick, temp, np.zeros((len(t), 3)))


def drives(arm: Arm, rng, rows, ticks) -> Run:
    """Each axis alone there and back at three speeds, then all together: as drives are tuned; no instrument."""
    whole = rows * ticks * 0.012
    t = np.arange(round(whole / DT)) * DT
    q, now = np.repeat(arm.middle[None], len(t), 0), 0.3
    part = 0.8 * whole / arm.n
    for i in range(arm.n):
        shares = np.array([0.5, 0.3, 0.2])
        for share, speed in zip(shares, (0.25, 0.6, 1.0), strict=True):
            half = 0.5 * share * part
            far = min(0.7 * speed * arm.speed * half, 1.2 * arm.spread[i]) * rng.uniform(0.85, 1.0)
            u = np.interp(t, [now, now + 0.85 * half, now + half, now + 1.85 * half], [0, far, far, 0])
            q[:, i] += u
            now += 2 * half
    mixed = np.clip((t - now) / (whole - now), 0, 1)
    for i in range(arm.n):
        q[:, i] += 0.25 * arm.spread[i] * np.sin(2 * np.pi * mixed * rng.integers(1, 4)) * np.sin(np.pi * mixed) ** 2
    for _ in range(2):
        q = uniform_filter1d(q, 17, axis=0, mode="nearest")
    pick = np.arange(rows) * round(ticks * 0.012 / DT)
    return Run(arm, "drives", t, q, pick, np.full(len(t), 6.0), np.zeros((len(t), 3)))


def poses(arm: Arm, rng, count, warm=(0.0, 9.0), start=0.0) -> Run:
    """Single poses before a tracker: places all over the room, come to again from wherever the last one was."""
    n, spots = arm.n, max(8, count // 3)
    base = (np.arange(spots)[:, None] + rng.uniform(0, 1, (spots, n))) / spots  # each axis in even steps, mixed
    base = np.stack([rng.permutation(c) for c in base.T], 1) * 2 - 1
    where = np.r_[np.arange(spots), rng.integers(0, spots, count - spots)]
    rng.shuffle(where)
    q = arm.middle + 1.1 * arm.spread * base[where]
    q = q + 1e-4 * rng.normal(size=q.shape)
    if arm.table:
        q[:, 0] = arm.middle[0]
    moves = np.diff(q, axis=0, prepend=arm.middle[None])  # straight from the last pose to the next
    pause = rng.uniform(14, 40, count)
    t = start + np.cumsum(pause)
    temp = warm[0] + (warm[1] - warm[0]) * (1 - np.exp(-(t - start) / 900.0)) / (1 - np.exp(-(t[-1] - start) / 900.0))
    return Run(
        arm,
        "poses",
        t,
        q,
        np.arange(count),
        temp,
        np.zeros((count, 3)),
        moves=moves,
        waits=rng.uniform(0.5, 0.9, count),
    )
