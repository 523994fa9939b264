"""The rest of the causes that the contract names: what moves with speed, warmth, work and the instrument."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from gap.eighth_author.ways import DT
from gap.eighth_author.works import chosen, mask, names
from gap.eighth_author.world import DRIVE, LINK, Acts, Cause


def inertias(m):
    """(n,) of all masses about each axis at the middle of the work: kg m2, or kg."""
    chain, out = m.frames(m.middle[None]), np.zeros(m.n)
    for name, kg, centre in m.masses:
        k = m.names.index(name) + 1
        at = (chain[k] @ np.append(np.array(centre) / 1e3, 1.0))[0, :3]
        for i in range(m.first, k):
            arm = np.linalg.norm(np.cross(chain[i][0, :3, 2], at - chain[i][0, :3, 3]))
            out[i] += kg * (1.0 if m.slides[i] else arm**2)
    return out


def acceleration_error(m, rng, stand):
    """Springs of gears that give to inertia, a fifth of it passed on to the next axis."""
    axes = chosen(m, rng, int(rng.integers(1, 3)), range(m.first, m.first + 3))
    by = mask(m, axes, rng.uniform(0.6, 1, len(axes))) * inertias(m) * m.each("soft")

    def act(run, s):
        give = -by * run.a
        return Acts(link=s * (give + 0.2 * np.roll(give, 1, 1) * (np.arange(m.n) > m.first)))

    return Cause("acceleration_error", act, names(m, axes), LINK, ("acceleration",), 1.0, 12)


def friction(m, rng, stand):
    """Stribeck's curve, higher in one sense than in the other, against a loop without a reset."""
    axes = chosen(m, rng, int(rng.integers(1, 3)))
    by = mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.unit
    stick, oil, odd = rng.uniform(0.2, 0.6), rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.3)

    def act(run, s):
        x = run.v / (0.3 * m.each("top"))
        curve = np.tanh(x / 0.01) * (1 + stick * np.exp(-((x / 0.08) ** 2))) + oil * x
        curve = curve * (1 + odd * np.sign(x))
        return Acts(drive=-s * by * gaussian_filter1d(curve, 6, axis=0, mode="nearest"))

    return Cause("friction", act, names(m, axes), DRIVE, ("direction", "speed"), 0.01, 0.08)


def wrist_coupling(m, rng, stand):
    """Bevel wheels a tooth away from what the controller reckons with; their mesh is felt, too."""
    k = rng.uniform(0.4, 1, 2) * rng.choice([-1, 1], 2)
    two = rng.random() < 0.5
    axes = [m.n - 2, m.n - 1] if two else [m.n - 1]

    def act(run, s):
        q, link = run.c - m.middle, np.zeros_like(run.c)
        link[:, -1] = k[0] * (q[:, -2] + 0.02 * np.sin(14 * q[:, -2]))
        if two:
            link[:, -2] = k[1] * (q[:, -3] + 0.02 * np.sin(14 * q[:, -3]))
        return Acts(link=s * link)

    return Cause("wrist_coupling", act, names(m, axes), LINK, ("position",), 0.001, 0.02)


def thermal_drift(m, rng, stand):
    """Axes that warm as they work and lose it again: the link behind each grows, its zero creeps by as much as its gear
    has warmed."""
    slow, grows = rng.uniform(80, 240), rng.uniform(0.4, 1, m.n)
    turns = rng.uniform(-1, 1, m.n) * 0.25
    lengths = np.array([np.hypot(a.a, a.d) + 80 for a in m.axes]) / 1e3
    dirs = np.array([[a.a, 0, a.d] for a in m.axes]) / 1e3 + [0.05, 0, 0]

    def act(run, s):
        step = DT if not run.poses else float(np.median(np.diff(run.t)))
        work = np.abs(run.v) if not run.poses else np.abs(np.diff(run.c, axis=0, prepend=run.c[:1])) / step
        work = work / m.each("top") + 0.06
        share = np.exp(-step / slow)
        begun = np.mean(work, 0) * (1 - np.exp(-run.facts["since"] / slow))
        warm = lfilter([1 - share], [1, -share], work, axis=0, zi=(share * begun)[None])[0]
        twists = {i + 1: np.zeros((len(warm), 6)) for i in range(m.first, m.n)}
        for i in range(m.first, m.n):
            twists[i + 1][:, :3] = s * 1e-3 * grows[i] * warm[:, i : i + 1] * dirs[i]
        turn = 1e-3 * turns * warm * s * lengths.mean()
        return Acts(link=turn, twists=twists, warmth=8 * warm.mean(1))

    return Cause("thermal_drift", act, [], LINK, ("time", "position"), 1.0, 2)


def track(m, rng, stand):
    """A column that isn't plumb and is bowed; a screw that is long and turns unevenly; the boom nods and rolls with the bow."""
    lead, phase, p = rng.uniform(0.02, 0.05), rng.uniform(0, 6, 3), rng.normal(0, 1, 6)

    def act(run, s):
        u = (run.c[:, 0] - m.middle[0]) / m.spread[0]
        bow, slope = u**2 + 0.4 * np.sin(2.2 * u + phase[0]), 2 * u + 0.9 * np.cos(2.2 * u + phase[0])
        up = 0.7 * p[0] * u + 0.25 * np.sin(2 * np.pi * run.c[:, 0] / lead + phase[1])
        side, front = p[1] * bow + p[2] * u, p[3] * bow + p[4] * u
        turn = np.stack([p[1] * slope, p[3] * slope, 0.5 * p[5] * u], 1) * 0.4
        return Acts(twists={1: 1e-3 * s * np.column_stack([front, side, up, turn])})

    return Cause("track", act, ["E1"], LINK, ("position",), 0.1, 2)


def measurement_scale(m, rng, stand):
    """Air that is warmer the higher: what is ranged comes out long, more so up there."""
    rise = rng.uniform(0.2, 0.6)

    def see(s):
        def bend(run, at):
            away = at - stand
            return stand + away * (1 + 1e-6 * s * (1 + rise * away[:, 2:]))

        return bend

    return Cause("measurement_scale", lambda run, s: Acts(seen=(see(s),)), [], LINK, ("position",), 100, 300)


def measurement_drift(m, rng, stand):
    """One leg of the tripod sinks into the floor and stops: the head tilts over the other two, and turns a little."""
    where, slow = rng.uniform(0, 2 * np.pi), rng.uniform(60, 400)
    axis = np.array([np.cos(where), np.sin(where), rng.normal(0, 0.5)])
    pivot = stand - [0.4 * np.sin(where), -0.4 * np.cos(where), 1.4]

    def see(s):
        def bend(run, at):
            sunk = 1e-5 * s * (1 - np.exp(-(run.t[run.pick] + run.facts["since"]) / slow))
            return at + sunk[:, None] * np.cross(axis, at - pivot)

        return bend

    return Cause("measurement_drift", lambda run, s: Acts(seen=(see(s),)), [], LINK, ("time",), 2, 60)


def latency(m, rng, stand):
    """An instrument that means over a window before it hands on: late by a half of it and by a time besides."""
    window = rng.uniform(0.2, 1.2)

    def act(run, s):
        ages = np.linspace(1 - window / 2, 1 + window / 2, 9)
        return Acts(ages=tuple((s * a, 1 / 9) for a in ages))

    return Cause("latency", act, [], LINK, ("speed",), 0.01, 0.15)


def cutting_force(m, rng, stand):
    """Thrust along the tool and a pull against the feed and across, by a power of the speed while it works; gears give to it."""
    thrust, across = rng.uniform(0.5, 1.2), rng.uniform(-0.6, 0.6)

    def act(run, s):
        rows = np.arange(0, len(run.t), 5)
        tip = m.tip(run.c[rows])
        v = np.gradient(tip[:, :3, 3], run.t[rows], axis=0)
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        way, z = v / np.maximum(speed, 1e-4), tip[:, :3, 2]
        pull = (-way + across * np.cross(z, way) + thrust * z) * np.minimum(speed / m.feed, 1.5) ** 0.7
        pull = gaussian_filter1d(pull * run.busy[rows, None], 10, axis=0)
        give = m.each("soft") * np.einsum("nki,nk->ni", m.jacobian(run.c[rows])[:, :3], pull)
        every = np.arange(len(run.t))
        spread = [np.stack([np.interp(every, rows, x) for x in a.T], 1) for a in (give, pull)]
        return Acts(link=s * spread[0], force=s * spread[1])

    return Cause("cutting_force", act, [], LINK, ("load", "position"), 100, 150 + 15 * m.payload)


def early_reading(m, rng, stand):
    """Read while the arm still swings: each axis off by a share of its last step, at a phase of its own."""
    k, beat, fade = rng.uniform(0.4, 1, m.n), rng.uniform(0, 6, m.n), rng.uniform(0.5, 1.5)
    jitter = int(rng.integers(1 << 30))
    beat[chosen(m, rng, 2)] = 0.0

    def act(run, s):
        late = 0.25 * np.random.default_rng(jitter).exponential(1.0, len(run.t))[:, None]
        step = np.diff(run.c, axis=0, prepend=run.c[:1])
        return Acts(link=-s * k * step * np.exp(-fade * late) * np.cos(beat + 1.0 * late))

    return Cause("early_reading", act, [], LINK, ("direction", "time"), 1e-3, 0.03)


WORN = {
    f.__name__: f
    for f in (
        acceleration_error, friction, wrist_coupling, thermal_drift, track, measurement_scale, measurement_drift,
        latency, cutting_force, early_reading,
    )
}  # fmt: skip
