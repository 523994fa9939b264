"""Causes that no name is there for, and what an arm leaves anyway."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from .named import ARC, Cause, axes_of, shifted
from .shift import Shift


def brush_hood(m, rng):
    """A suction hood whose bristles press on each job's plate: below a height they push the tool up, the more the lower."""
    part = rng.uniform(0.4, 0.7)

    def value(run):
        z = run.points[:, 2]
        floor = np.quantile(z, part)
        up = np.zeros((len(z), 3))
        up[:, 2] = np.maximum(floor - z, 0) ** 1.5
        return up

    return Cause("brush_hood", shifted("off", value), 1e-3, np.inf, follows="position")


def draught(m, rng):
    """Gusts through a gate push the arm to one side, now and then."""
    step = rng.normal(size=20000)
    way = np.append(rng.normal(size=2), 0.1)

    def value(run):
        gust = lfilter([1.0], [1, -1.85, 0.86], step)
        blow = np.maximum(np.interp(run.t[run.pick] + run.begun, np.arange(20000) * 0.25, gust / gust.std()) - 0.4, 0)
        return blow[:, None] * way

    return Cause("draught", shifted("off", value), 1e-4, np.inf, follows="time")


def breakaway(m, rng):
    """A collision guard behind the tool opens where the tool is accelerated beyond its preload."""

    preload = rng.uniform(0.02, 0.05)  # as an acceleration, m/s2

    def make(run, size):
        out = Shift.none(run)
        speed = np.einsum("nij,nj->ni", m.jacobian(run.c)[:, :3], run.at(run.v))
        t = run.t[run.pick]
        push = -np.einsum("nji,nj->ni", run.frames[-1][:, :3, :3], np.gradient(speed, t, axis=0))[:, :2]
        much = np.linalg.norm(push, axis=1)
        over = np.maximum(much - preload, 0) / preload
        lean = size * np.minimum(over, 3.0)[:, None] * push / (much[:, None] + 1e-9)
        out.twist[:, -1, 0], out.twist[:, -1, 1] = lean[:, 0], lean[:, 1]
        return out

    return Cause("breakaway", make, 1e-4, np.inf, follows="acceleration")


def table_sector(m, rng):
    """The controller's table of corrections has a wrong entry: within a sector of one axis it is off."""
    k = axes_of(m, rng, 1, 1, range(4))[0]
    low, high = np.sort(rng.uniform(-0.5, 0.5, 2) + np.array([-0.25, 0.25]))

    def value(run):
        x = (run.c[:, k] - m.middle[k]) / (2 * m.swing[k] * m.units[k])
        edge = 0.03
        return np.eye(m.n)[k] * (np.clip((x - low) / edge, 0, 1) * np.clip((high - x) / edge, 0, 1))[:, None]

    return Cause("table_sector", shifted("true", value), 1e-4, np.inf, (m.names[k],), follows="position")


def seal_drag(m, rng):
    """A seal between two axes carries one along as fast as the other turns: it lags by the other's speed."""
    i, k = rng.permutation(axes_of(m, rng, 2, 2))

    def value(run):
        v = run.at(run.v)[:, i]
        return np.eye(m.n)[k] * np.tanh(v / 0.3)[:, None]

    return Cause("seal_drag", shifted("enc", value), 1e-4, np.inf, (m.names[k],), "setpoint_to_encoder", "speed")


def thermostat(m, rng):
    """The spindle's cooler goes on and off: its nose grows and shrinks as two exponentials that meet."""
    on, off, tau = rng.uniform(14, 25), rng.uniform(20, 40), rng.uniform(10, 25)

    def value(run):
        u = np.mod(run.late, on + off)
        top = (1 - np.exp(-on / tau)) / (1 - np.exp(-(on + off) / tau))
        low = top * np.exp(-off / tau)
        long = np.where(u < on, 1 - (1 - low) * np.exp(-u / tau), top * np.exp(-(u - on) / tau))
        out = np.zeros((len(u), m.n + 2, 6))
        out[:, -1, 2] = long
        out[:, -1, 0] = 0.4 * long
        return out

    return Cause("thermostat", shifted("twist", value), 1e-4, np.inf, follows="time")


def levelling(m, rng):
    """Feet on air: they give to a moment at once, and a valve takes it back within seconds."""
    tau = rng.uniform(4, 12)

    def make(run, size):
        out = Shift.none(run)
        t = np.arange(0, run.t[-1] + 0.1, 0.1)
        moment = np.stack([np.interp(t, run.t[run.pick], x) for x in m.moment(run.c).T], 1)
        p = np.exp(-0.1 / tau)
        slow = lfilter([1 - p], [1, -p], moment, axis=0, zi=p * moment[:1])[0]
        tilt = (
            np.stack([np.interp(run.t[run.pick], t, x) for x in (moment - slow).T], 1)
            * np.array([1, 1, 0])
            * size
            * 1e-8
        )
        foot = run.frames[0][0, :3, 3]
        out.twist[:, 0, 3:], out.twist[:, 0, :3] = tilt, -np.cross(tilt, foot)
        return out

    return Cause("levelling", make, 1.0, np.inf, follows="load")


def plume(m, rng):
    """Warm air over a motor bends the tracker's beam where it passes: a bump in space, as an eddy's slope has it."""
    at = m.tip(m.middle)[0, :3, 3] + rng.uniform(-0.25, 0.25, 3) * m.reach
    way = np.cross(rng.normal(size=3), [0, 0, 1.0])

    def value(run):
        u = (run.points - at) / (0.2 * m.reach)
        bump = np.exp(-(u**2).sum(1) / 2)
        return (bump * (1 + u[:, 2]))[:, None] * way / np.linalg.norm(way)

    return Cause("plume", shifted("off", value), 1e-4, np.inf, follows="position")


# by name: its draw, and the log that shows it
FOREIGN = {
    "brush_hood": (brush_hood, "path"),
    "draught": (draught, "path"),
    "breakaway": (breakaway, "path"),
    "table_sector": (table_sector, "poses"),
    "seal_drag": (seal_drag, "drives"),
    "thermostat": (thermostat, "path"),
    "levelling": (levelling, "path"),
    "plume": (plume, "poses"),
}


def leftover(m, rng, kind):
    """Each axis' own error by spline knots some degrees apart; foot and elbow twisted by all torques, up to a stop.
    Of drives: loops that stand off by a table of place, less so when fast."""
    reach = 3.2 * np.array(m.swing) * m.units
    table = []
    for k in range(m.n):
        knots = np.linspace(-reach[k], reach[k], max(6, int(2 * reach[k] / (14 * ARC))) if m.kinds[k] == "R" else 9)
        table.append(CubicSpline(knots, rng.normal(size=len(knots)) * rng.uniform(0.3, 1.0)))
    mix = rng.normal(size=(2, 6, m.n))
    at = (1, int(rng.integers(3, m.n)))
    heft = np.abs(m.load(np.stack([m.middle, m.middle + 0.3]))).max(0) + 1e-6

    def make(run, size):
        out = Shift.none(run)
        place = np.clip(run.c - m.middle, -reach, reach)
        own = np.stack([f(x) for f, x in zip(table, place.T, strict=True)], 1)
        own = own / (np.abs(m.jacobian(m.middle)[0, :3]).max(0) + 0.2)
        if kind == "drives":
            v = np.abs(run.at(run.v))
            out.enc = size * own / (1 + v / 0.2)
            return out
        out.true = 0.5 * size * own
        strain = np.tanh(run.load / heft) - np.tanh(m.load(m.middle) / heft)
        for a, w in zip(at, mix, strict=True):
            out.twist[:, a] = 0.5 * size * strain @ w.T
        return out

    return Cause("leftover", make, 1e-4, np.inf)
