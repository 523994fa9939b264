"""What gears, links, floor, table, tool and weather do behind the encoders. Keys as in `drive_causes`."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from gap.ninth_author.drive_causes import first_order
from gap.ninth_author.paths import DT, Run
from gap.ninth_author.shift import Shift

__all__ = [
    "air_balancer",
    "backlash",
    "cutting_force",
    "float_head",
    "frame_base",
    "frame_table",
    "frame_tool",
    "gear_ripple",
    "geometry",
    "hysteresis",
    "joint_compliance",
    "joint_offset",
    "lean",
    "payload",
    "table_clamp",
    "thermal_drift",
    "track",
    "turntable",
    "wrist_coupling",
]


def _only(run: Run, i, e) -> Shift:
    out = np.zeros_like(run.q)
    out[:, i] = e
    return Shift(link=out)


def play(x, width):
    """The link's place in a slot of a width (N,), over half of it: +1 at one flank, -1 at the other; begins in the middle."""
    u, out = 0.0, np.zeros(len(x))
    for k in range(1, len(x)):
        u = min(1.0, max(-1.0, u + 2 * (x[k] - x[k - 1]) / width))
        out[k] = u
    return out


def backlash(run: Run, key, s) -> Shift:
    """Play of s whose flanks are soft: crossed in thrice its width, stiffer towards the end."""
    i = key[0]
    u = np.sign(run.moves[:, i]) if run.kind == "poses" else play(run.q[:, i], 3 * s + 1e-7)
    return _only(run, i, -0.5 * s * np.tanh(1.6 * u) / np.tanh(1.6))


def loop(x, reach, power=1.5):
    """A loop of hysteresis in -1..1 (N,): dh/dx = (1 - h sign(dx))^power / reach, stepped by its own closed form."""
    h, out = 0.0, np.zeros(len(x))
    for k in range(1, len(x)):
        d = x[k] - x[k - 1]
        g = 1 - h if d > 0 else 1 + h  # dg/d|x| = -g^p / reach
        g = (g ** (1 - power) + (power - 1) * abs(d) / reach) ** (1 / (1 - power)) if g > 1e-12 else 0.0
        h = 1 - g if d > 0 else g - 1
        out[k] = h
    return out


def hysteresis(run: Run, key, s) -> Shift:
    """A gear that gives way in loops, s to either side, which saturate over some degrees."""
    i, reach = key
    if run.kind == "poses":
        g = (1 + 0.5 * np.abs(run.moves[:, i]) / reach) ** -2.0
        return _only(run, i, -s * np.sign(run.moves[:, i]) * (1 - g))
    return _only(run, i, -s * loop(run.q[:, i], reach))


def gear_ripple(run: Run, key, s) -> Shift:
    """Teeth that are not alike: a wave in the axis's angle and its double, more under load."""
    i, n, phase = key
    q = run.q[:, i]
    load = np.abs(run.loads[:, i]) / (np.abs(run.loads[:, i]).max() + 1.0)
    return _only(run, i, s * (1 + 0.3 * load) * (np.sin(n * q + phase) + 0.3 * np.sin(2 * n * q + 2.1 * phase)))


def wrist_coupling(run: Run, key, s) -> Shift:
    """Bevel wheels in the hand: of an axis a share goes into another, besides what the controller takes off."""
    j, i = key
    return _only(run, i, s * (run.q[:, j] - run.arm.middle[j]))


def joint_compliance(run: Run, key, s) -> Shift:
    """Gears that give under weight, less so the harder they are loaded; of a parallelogram each motor holds its own link."""
    factors, hard = key
    load = run.loads * np.array(factors)
    if hard:
        most = np.abs(run.loads).mean(0) + 1.0
        load = load / (1 + hard * np.abs(load) / most)
    return Shift(link=s * run.arm.sag(load))


def payload(run: Run, key, s) -> Shift:
    """A load that nobody told of, s kg at a place (m) in the tool's frame: all gears give under it."""
    place = tuple(key)
    more = run.slow(lambda q: run.arm.loads(q, masses=(), extra=((1.0, place),)))
    return Shift(link=s * run.arm.sag(more))


def cutting_force(run: Run, key, s) -> Shift:
    """The cut pushes: gears give, stiffer at large loads, and the spindle's bearing does, unlike in two directions."""
    joints, spindle, hard = key
    load = run.work / (1 + hard * np.abs(run.work) / (np.abs(run.work).max(0) + 1e-9))
    out = Shift(link=s * joints * run.arm.sag(load))
    if spindle:
        tip = run.slow(lambda q: run.arm.tips(q)[:, :3, :3].reshape(len(q), 9)).reshape(-1, 3, 3)
        w = np.zeros((len(run.t), 6))
        w[:, :3] = s * spindle * np.einsum("nji,nj->ni", tip, run.force) * [1.0, 1.5, 0.3]
        out.twists["tool"] = w
    return out


def lean(run: Run, key, s) -> Shift:
    """The foot tips under the overturning moment, weak about one direction, stiffer as its anchors are drawn."""
    weak, hard = key
    m = run.moment[:, :2]
    d = np.array([np.cos(weak), np.sin(weak)])
    m = m + 0.8 * (m @ d)[:, None] * d
    m = m / (1 + hard * np.linalg.norm(m, axis=1, keepdims=True) / (np.linalg.norm(m, axis=1).mean() + 1.0))
    w = np.zeros((len(run.t), 6))
    w[:, 3:5] = s * m
    return Shift(twists={"foot": w})


def joint_offset(run: Run, key, s) -> Shift:
    """Axes whose zeros are off."""
    return Shift(link=np.repeat(s * np.array(key)[None], len(run.t), 0))


def geometry(run: Run, key, s) -> Shift:
    """Rows off their drawing: lengths along x and z, angles about x and y (mrad to the mm), row by row."""
    return Shift(twists={i: s * np.array(w) for i, w in key})


def frame_base(run: Run, key, s) -> Shift:
    """The foot is not where it is said to stand, nor level."""
    return Shift(twists={"world": s * np.array(key)})


def frame_tool(run: Run, key, s) -> Shift:
    """The tip is not where it is said to be."""
    return Shift(twists={"tool": s * np.array(key)})


def frame_table(run: Run, key, s) -> Shift:
    """The table's axis is off its place and not upright."""
    return Shift(axis=s * np.array(key))


def turntable(run: Run, key, s) -> Shift:
    """A table that wobbles once a turn, runs out of true, and counts unevenly twice a turn."""
    f = run.q[:, 0]
    wave = np.stack([np.cos(f), np.sin(f), np.cos(2 * f), np.sin(2 * f)], 1)
    return Shift(wobble=s * wave @ np.array(key))


def track(run: Run, key, s) -> Shift:
    """A rail that is not straight (cubic splines between its supports, height and side) and a scale that is too long."""
    height, side, ppm = key
    i = run.arm.names.index("E1")
    x = run.q[:, i] / 0.6
    knots = np.linspace(-2.2, 2.2, len(height) + 4)
    w = np.zeros((len(x), 6))
    for k, values in ((2, height), (0, side)):
        bend = BSpline(knots, np.array(values), 3)
        w[:, k] = s * bend(x)
        if k == 2:
            w[:, 3] = s * bend.derivative()(x) / 0.6  # a carriage that follows the slope pitches
    w[:, 1] = s * ppm * run.q[:, i]
    return Shift(twists={"foot": w})


def lagged(run: Run, tau):
    """The warmth of what warms behind the sensor by tau s."""
    if run.kind != "poses":
        return run.temp
    out, now = np.zeros(len(run.t)), run.temp[0]
    for k in range(1, len(run.t)):
        now += (run.temp[k] - now) * (1 - np.exp(-(run.t[k] - run.t[k - 1]) / tau))
        out[k] = now
    out[0] = run.temp[0]
    return out


def thermal_drift(run: Run, key, s) -> Shift:
    """Links grow by their lengths, each behind the sensor in its own time, and one bows towards its cold side."""
    taus, bowed, bow = key
    out = {}
    for i, (alpha, a, _, d) in enumerate(run.arm.rows):
        if not taus[i]:
            continue
        warm = 11.7e-6 * lagged(run, taus[i])
        w = np.zeros((len(run.t), 6))
        w[:, 0] = a * warm
        w[:, 1], w[:, 2] = d * np.sin(alpha) * warm, d * np.cos(alpha) * warm
        if i == bowed:
            w[:, 4] = bow * warm
        out[i] = s * w
    return Shift(twists=out)


def air_balancer(run: Run, key, s) -> Shift:
    """Foreign: a balancer on air, whose pressure falls until the compressor starts: A2 sinks and is lifted, by its lever."""
    i, period, begins = key
    u = ((run.t + begins) / period) % 1.0
    saw = np.where(u < 0.8, 0.5 - u / 0.8, -0.5 + (u - 0.8) / 0.2)
    lever = np.cos(run.q[:, i] - run.arm.middle[i] + 0.5)
    return _only(run, i, -s * saw * lever)


def table_clamp(run: Run, key, s) -> Shift:
    """Foreign: the table's clamp closes where it stands and turns and tips the plate as it does."""
    slow, tip = key
    shut = first_order((np.abs(run.rate()[:, 0]) < slow).astype(float), 0.08)
    w = np.zeros((len(run.t), 6))
    w[:, 5], w[:, 3], w[:, 2] = s * shut, tip * s * shut, 0.05 * s * shut
    return Shift(wobble=w)


def float_head(run: Run, key, s) -> Shift:
    """Foreign: a head that floats on air gives way across its axis, but only beyond its preload, and up to a stop."""
    share, stop = key
    tip = run.slow(lambda q: run.arm.tips(q)[:, :3, :3].reshape(len(q), 9)).reshape(-1, 3, 3)
    f = np.einsum("nji,nj->ni", tip, run.force)[:, :2]
    size = np.linalg.norm(f, axis=1)
    most = np.quantile(size, 0.98) + 1e-9
    give = np.clip((size / most - share) / (1 - share), 0, stop)
    w = np.zeros((len(run.t), 6))
    w[:, :2] = s * (give / (size + 1e-9))[:, None] * f
    for k in (0, 1):
        w[:, k] = first_order(w[:, k], 5 * DT)
    return Shift(twists={"tool": w})
