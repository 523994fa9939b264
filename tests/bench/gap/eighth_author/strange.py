"""Eight causes that no library names, and what is left of a machine beside all that has a name."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from gap.eighth_author.ways import DT
from gap.eighth_author.works import names
from gap.eighth_author.world import DRIVE, LINK, Acts, Cause


def _swung(force, hertz, damping):
    """(N,) of a pendulum's swing under a push (N,), by its own gain at rest of 1: two poles on the clock."""
    w = 2 * np.pi * hertz
    p = np.exp((-damping * w + 1j * w * np.sqrt(1 - damping**2)) * DT)
    a = [1, -2 * p.real, abs(p) ** 2]
    return lfilter([sum(a)], a, force - force[0]) + force[0]


def slosh(m, rng, stand):
    """A tank of resin on the forearm, half full: it swings at one hertz after every start and stop, and the third axis
    gives to it."""
    hertz, fade, k = rng.uniform(0.7, 1.3), rng.uniform(0.02, 0.06), m.first + 2
    heading = rng.uniform(0, 2 * np.pi)

    def act(run, s):
        at = m.frames(run.c[::5])[k + 1][:, :3, 3]
        push = np.gradient(np.gradient(at, 5 * DT, axis=0), 5 * DT, axis=0) @ [np.cos(heading), np.sin(heading), 0]
        push = np.interp(run.t, run.t[::5], gaussian_filter1d(push, 6))
        link = np.zeros_like(run.c)
        link[:, k] = 1e-3 * s * _swung(push, hertz, fade)
        return Acts(link=link)

    return Cause("slosh", act, names(m, [k]), LINK, ("acceleration", "time"), 0.05, 0.5)


def racking(m, rng, stand):
    """A bridge driven at both ends, whose second drive follows the first late: it stands askew while it travels, by
    where the carriage is."""
    late, mass = rng.uniform(0.7, 1), rng.uniform(0, 0.05)

    def act(run, s):
        askew = s * (late * run.v[:, 0] + mass * run.a[:, 0])
        twist = np.zeros((len(run.t), 6))
        up = m.frames(m.middle[None])[1][0, :3, :3].T @ [0, 0, 1]
        twist[:, 3:] = askew[:, None] * up
        return Acts(twists={1: twist})

    return Cause("racking", act, ["A1"], LINK, ("speed",), 0.01, 0.05)


def floating(m, rng, stand):
    """A deburring spindle that floats on air: it keeps to its middle until its own weight sideways is more than the
    air's, then sags to its stop."""
    hold, soft = rng.uniform(0.15, 0.3), rng.uniform(0.15, 0.3)

    def act(run, s):
        down = np.swapaxes(m.tip(run.c)[:, :3, :3], 1, 2) @ [0, 0, -1.0]
        side = np.linalg.norm(down[:, :2], axis=1)
        give = 1 - np.exp(-np.maximum(side - hold, 0) / soft)
        twist = np.zeros((len(run.t), 6))
        twist[:, :2] = 1e-3 * s * gaussian_filter1d(give / np.maximum(side, 1e-6), 8)[:, None] * down[:, :2]
        return Acts(twists={m.n + 1: twist})

    return Cause("floating", act, [m.names[-1]], LINK, ("load", "position"), 0.3, 5)


def lift_clamp(m, rng, stand):
    """The lift's clamp shuts when the column has stood for half a second and tips the boom; it opens when the lift moves."""
    tip, wait = np.append(rng.normal(0, 1, 3) * 0.3, rng.normal(0, 1, 3)), rng.uniform(0.2, 0.5)
    tip[4] = 1.5

    def act(run, s):
        moves = np.abs(run.v[:, 0]) > 0.05 * m.axes[0].top
        last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), 0))
        shut = (np.arange(len(moves)) - last) * DT > wait
        return Acts(twists={1: 1e-3 * s * gaussian_filter1d(shut.astype(float), 12)[:, None] * tip})

    return Cause("lift_clamp", act, ["E1"], LINK, ("speed", "time"), 0.1, 1)


def spindle_growth(m, rng, stand):
    """The spindle's shaft grows out of its bearings while it turns and draws back while it stands, within half a minute."""
    slow, period, share = rng.uniform(5, 10), rng.uniform(14, 24), rng.uniform(0.4, 0.6)
    side = rng.normal(0, 0.15, 2)

    def act(run, s):
        on = np.mod(run.t + run.facts["since"], period) < share * period
        keep = np.exp(-DT / slow)
        grown = lfilter([1 - keep], [1, -keep], on.astype(float))
        twist = np.zeros((len(run.t), 6))
        twist[:, :3] = 1e-3 * s * grown[:, None] * [*side, -1]
        return Acts(twists={m.n + 1: twist})

    return Cause("spindle_growth", act, [m.names[-1]], LINK, ("time",), 0.3, 2)


def graduated_circle(m, rng, stand):
    """The tracker's own graduated circles are read unevenly between their lines: bearing and height are off by some
    twenty waves a turn."""
    p, share = rng.uniform(0, 6, 2), rng.uniform(0.4, 1)
    waves = int(rng.integers(18, 28))  # of the interpolator, a turn

    def see(s):
        def bend(run, at):
            away = at - stand
            flat = np.hypot(away[:, 0], away[:, 1])
            bearing, height = np.arctan2(away[:, 1], away[:, 0]), np.arctan2(away[:, 2], flat)
            east = np.stack([-away[:, 1], away[:, 0], 0 * flat], 1)
            up = np.stack([-away[:, 0] * away[:, 2] / flat, -away[:, 1] * away[:, 2] / flat, flat], 1)
            return at + 1e-5 * s * (
                np.sin(waves * bearing + p[0])[:, None] * east + share * np.sin(waves * height + p[1])[:, None] * up
            )

        return bend

    return Cause("graduated_circle", lambda run, s: Acts(seen=(see(s),)), [], LINK, ("position",), 2, 60)


def tow(m, rng, stand):
    """Tows drawn off a creel that stands aside: their pull grows with the speed at which they are laid, and is gone
    where none are; the arm gives."""
    creel = m.tip(m.middle[None])[0, :3, 3] + np.array(
        [-0.6, rng.choice([-1, 1]) * rng.uniform(1.2, 2), rng.uniform(0.6, 1.4)]
    )
    still = rng.uniform(0.2, 0.4)

    def act(run, s):
        rows = np.arange(0, len(run.t), 5)
        at = m.tip(run.c[rows])[:, :3, 3]
        speed = np.linalg.norm(np.gradient(at, run.t[rows], axis=0), axis=1)
        way = creel - at
        pull = (still + speed / m.feed) * run.busy[rows]
        pull = gaussian_filter1d(pull, 8)[:, None] * way / np.linalg.norm(way, axis=1, keepdims=True)
        give = m.each("soft") * np.einsum("nki,nk->ni", m.jacobian(run.c[rows])[:, :3], pull)
        return Acts(link=s * np.stack([np.interp(run.t, run.t[rows], x) for x in give.T], 1))

    return Cause("tow", act, [], LINK, ("speed",), 200, 2500)


def foldback(m, rng, stand):
    """An amplifier that has got warm and folds its current back: from then on it can't accelerate as asked, falls
    behind, and catches up."""
    k = int(m.first + rng.integers(3))
    warm, cool = rng.uniform(0.25, 0.4), rng.uniform(2, 4)

    def act(run, s):
        torque = run.a[:, k]
        keep = np.exp(-DT / cool)
        heat = lfilter([1 - keep], [1, -keep], torque**2) / np.mean(torque**2)
        least = np.abs(torque).max() * np.interp(heat, [warm, 2 * warm], [1.0, 0.35])
        short = np.sign(torque) * np.maximum(np.abs(torque) - least, 0)
        drive = np.zeros_like(run.c)
        drive[:, k] = -s * 1e-3 * _swung(short, 1.5, 0.8)
        return Acts(drive=drive)

    return Cause("foldback", act, names(m, [k]), DRIVE, ("acceleration", "time"), 1, 400)


# with which machine and log each is met
FOREIGN = {
    slosh: ("winder", "path"),
    racking: ("portal", "path"),
    floating: ("turret", "path"),
    lift_clamp: ("boom", "path"),
    spindle_growth: ("dispenser", "path"),
    graduated_circle: ("turret", "poses"),
    tow: ("winder", "path"),
    foldback: ("ceiling", "drives"),
}


def bent_by_posture(m, rng):
    """Each link bends and twists by smooth functions of its own axis and the next: sums of waves whose lengths are drawn."""
    waves = [(rng.normal(0, 1.6, (5, 2)), rng.uniform(0, 6, 5), rng.normal(0, 1, (5, 6))) for _ in range(m.n)]
    long = np.array([1, 1, 1, 3, 3, 3])

    def act(run):
        u = (run.c - m.middle) / np.maximum(m.spread, 1e-9)
        twists = {}
        for k in range(m.first, m.n):
            w, p, by = waves[k]
            pair = u[:, [k, min(k + 1, m.n - 1)]]
            twists[k + 1] = 1e-4 * np.sin(pair @ w.T + p) @ by * long
        return Acts(twists=twists)

    return act


def slow_to_settle(m, rng):
    """Bearings, resin and rubber that come after what loads them within seconds: each axis by its own posture's slow part."""
    slow, by = rng.uniform(1.5, 10, m.n), rng.normal(0, 1, m.n)

    def act(run):
        u = np.sin(2.0 * (run.c - m.middle) / np.maximum(m.spread, 1e-9))
        link = np.zeros_like(u)
        for i in range(m.first, m.n):
            keep = np.exp(-DT / slow[i])
            late = lfilter([1 - keep], [1, -keep], u[:, i], zi=[keep * u[0, i]])[0]
            link[:, i] = 1e-4 * by[i] * (u[:, i] - late)
        return Acts(link=link)

    return act


def uneven_drives(m, rng):
    """Of drives alone: waves over an axis' place that its neighbour's speed raises."""
    w, p, by = rng.uniform(2, 6, m.n), rng.uniform(0, 6, m.n), rng.normal(0, 1, m.n)

    def act(run):
        u = (run.c - m.middle) / np.maximum(m.spread, 1e-9)
        v = np.abs(gaussian_filter1d(run.v, 60, axis=0)) / m.each("top")
        return Acts(drive=1e-4 * by * m.unit / m.unit.max() * np.sin(w * u + p) * (0.3 + np.roll(v, -1, 1)))

    return act


def leftover(m, rng, log):
    """`act(run, size)`, of a shape drawn once."""
    if log == "drives":
        parts = [(1.0, uneven_drives(m, rng))]
    elif log == "poses":
        parts = [(1.0, bent_by_posture(m, rng))]
    else:
        share = rng.uniform(0.5, 1)
        parts = [(share, bent_by_posture(m, rng)), (1.5 * (1 - share), slow_to_settle(m, rng))]

    def act(run, s):
        out = Acts()
        for share, part in parts:
            mine = part(run)
            out.drive = out.drive + s * share * mine.drive
            out.link = out.link + s * share * mine.link
            for k, twist in mine.twists.items():
                out.twists[k] = s * share * twist
        return out

    return Cause("leftover", act, [], "", ("position",), 1.0, 1e4)
