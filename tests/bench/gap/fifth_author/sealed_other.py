"""SEALED's causes without a name, and what a body and its drives leave besides."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.signal import lfilter

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["FOREIGN", "drive_leftover", "leftover"]


def _slow(run, target, seconds):
    """A first order behind `target`, by the log's own stamps."""
    out, now = np.empty(len(target)), float(target[0])
    steps = np.diff(run.t, prepend=run.t[0])
    for k, (goal, dt) in enumerate(zip(target, steps, strict=True)):
        now += (goal - now) * (1 - np.exp(-dt / seconds))
        out[k] = now
    return out


def spindle(s, rng, strength):
    """A wheel that turns fast resists each turn of its axle aside: the wrist yields across it (gyroscopic moment)."""
    give = 1.0 / np.array(s.robot.stiffness)
    spin = strength * s.robot.rated * 0.02 * rng.uniform(0.5, 1.0)  # Nms

    def link(run):
        turn = np.einsum("nij,nj->ni", run.jacobian[1], run.v)
        torque = np.einsum("nij,ni->nj", run.jacobian[1], -spin * np.cross(turn, run.tip[:, :3, 2]))
        return axis_delta(run, {i: torque[:, i] * give[k] for k, i in enumerate(s.robot.arm)})

    return Cause("spindle", BODY, [s.robot.names[i] for i in s.robot.arm[3:5]], {}, ["speed"], link=link)


def furnace(s, rng, strength):
    """At one side of the cell it is hot: the tool warms while it is there, cools elsewhere, and gets longer and skew by it."""
    tips = np.vstack([r.tip[:: max(1, len(r.t) // 200), :3, 3] for r in s.runs])
    way = rng.normal(size=3) * np.array([1, 1, 0.3])
    way /= np.linalg.norm(way)
    door, deep = np.quantile(tips @ way, rng.uniform(0.45, 0.65)), 0.3 * float(np.std(tips @ way)) + 1e-3
    length = np.linalg.norm(s.robot.tool[:3]) / 1e3
    hot = strength * rng.uniform(30, 70) * 11.5e-6 * length
    aside, share = rng.normal(size=2) * 0.6, rng.uniform(0.03, 0.1)

    def between(run):
        near = 1 / (1 + np.exp(-(run.tip[:, :3, 3] @ way - door) / deep))
        warm = _slow(run, near, share * run.t[-1]) * hot
        return {-1: np.hstack([np.outer(warm, [*aside, 1.0]), np.zeros((len(run.t), 3))])}

    return Cause("furnace", BODY, [], {}, ["position", "time"], between=between)


def stop_met(s, rng, strength):
    """The piston of a counterweight meets its end: beyond an angle the shoulder is pushed by a stiff gas spring."""
    i = s.robot.arm[1]
    seen = np.concatenate([r.c[:, i] for r in s.runs])
    at, side = np.quantile(seen, rng.uniform(0.35, 0.65)), rng.choice([-1, 1])
    size = strength * 4e-4 / (float(np.ptp(seen)) + 1e-9)

    def link(run):
        return axis_delta(run, {i: -side * size * np.maximum(side * (run.c[:, i] - at), 0.0) ** 1.3})

    return Cause("stop_met", BODY, [s.robot.names[i]], {}, ["position"], link=link)


def creeping_rack(s, rng, strength):
    """A carriage is clamped after it has arrived; what its drive had wound up runs out of the rack in the seconds after."""
    i = s.robot.carriage[-1]
    size, tau = strength * rng.uniform(5e-5, 2e-4), rng.uniform(3, 12)

    def link(run):
        if run.rest:
            went = np.diff(run.c[:, i], prepend=run.c[0, i])
            wound = np.zeros(len(went))
            for k in range(1, len(went)):
                wound[k] = (
                    np.sign(went[k]) if abs(went[k]) > 1e-3 else wound[k - 1] * np.exp(-(run.t[k] - run.t[k - 1]) / tau)
                )
            return axis_delta(run, {i: -size * wound})
        pushes = np.tanh(run.v[:, i] / 0.02) + 0.3 * np.tanh(run.a[:, i] / 0.5)
        return axis_delta(run, {i: -size * _slow(run, pushes, tau / 5)})

    return Cause("creeping_rack", BODY, [s.robot.names[i]], {}, ["direction", "time"], link=link)


def two_wells(s, rng, strength):
    """A wrist that was put together with a sprung washer: it stands in one of two seats, and changes when its load's sign has."""
    i = s.robot.arm[-2]
    size, loads = strength * np.radians(0.02), np.concatenate([r.load[:, i] for r in s.runs])
    middle, wide = np.median(loads), 0.25 * float(np.std(loads)) + 1e-9

    def link(run):
        seat, out = 1.0, np.empty(len(run.t))
        for k, load in enumerate(run.load[:, i]):
            seat = 1.0 if load > middle + wide else -1.0 if load < middle - wide else seat
            out[k] = seat
        return axis_delta(run, {i: size * out})

    return Cause("two_wells", BODY, [s.robot.names[i]], {}, ["load", "direction"], link=link)


def weak_brakes(s, rng, strength):
    """Rectifiers that can't feed back: an axis that slows down runs on, one that speeds up does not lag."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    i = int(rng.choice(moving))
    tau = rng.uniform(0.05, 0.15)

    def drive(run):
        slows = np.maximum(-run.a[:, i] * np.sign(run.v[:, i]), 0.0) * np.sign(run.v[:, i])
        keep = np.exp(-run.dt / tau)
        return axis_delta(run, {i: 2e-4 * strength * lfilter([1 - keep], [1, -keep], slows)})

    return Cause("weak_brakes", DRIVE, [s.robot.names[i]], {}, ["acceleration", "direction"], drive=drive)


FOREIGN = [
    Description("spindle", spindle, frozenset({"tracker", "wrist", "path"}), 60.0, True),
    Description("furnace", furnace, frozenset({"tracker", "target_known"}), 60.0, True),
    Description("stop_met", stop_met, frozenset({"tracker", "wrist"}), 60.0, True),
    Description("creeping_rack", creeping_rack, frozenset({"tracker", "track"}), 60.0, True),
    Description("two_wells", two_wells, frozenset({"tracker", "wrist"}), 60.0, True),
    Description("weak_brakes", weak_brakes, frozenset({"path", "setpoints"}), 60.0, True),
]


def leftover(s, rng, strength):
    """Castings bend by the square of what they carry, cables pull by how far two axes are twisted together, and zeros wander
    slowly in time as seals warm and settle.
    """
    arm, n = s.robot.arm, len(s.robot.names)
    bent = {
        i: (np.radians(rng.normal() * 0.004), np.abs(s.runs[0].load[:, i]).max() + 1e-6)
        for i in arm[: min(3, len(arm))]
    }
    pairs = [(int(a), int(b), np.radians(rng.normal() * 0.003), rng.uniform(0.5, 1.5)) for a, b in pairwise(arm)]
    knots = rng.normal(size=(60, n)) * np.radians(0.0012)
    seats = {i: rng.normal(size=(3, 6)) * np.array([3e-5] * 3 + [2e-5] * 3) for i in arm[1:]}

    def link(run):
        out = np.zeros_like(run.c)
        for i, (size, most) in bent.items():
            out[:, i] += size * (run.load[:, i] / most) * np.abs(run.load[:, i] / most)
        for a, b, size, rate in pairs:
            twisted = run.c[:, a] + run.c[:, b]
            out[:, b] += size * np.tanh(rate * (twisted - twisted.mean()))
        when = run.clock / max(r.begins + r.t[-1] for r in s.runs) * 50
        for i in arm:
            out[:, i] += np.interp(when, np.arange(60), knots[:, i])
        return strength * out

    def between(run):
        out = {}
        for i, twists in seats.items():
            q = run.c[:, i]
            shapes = np.stack([np.cos(q), np.sin(2 * q), np.cos(3 * q + 0.5)], axis=1)
            out[2 + i] = strength * shapes @ twists
        return out

    return Cause("leftover", BODY, link=link, between=between, follows=["position"])


def drive_leftover(s, rng, strength):
    """Inverters' dead time: an error of the torque's sign, soft about zero; and the product of two axes' speeds."""
    moving = s.moving()
    if not moving:
        raise ValueError("nothing moves")
    size, pair = (
        {i: rng.normal(size=2) * np.radians(0.001) for i in moving},
        {i: int(rng.choice(moving)) for i in moving},
    )

    def drive(run):
        out = {}
        for i, (dead, coupled) in size.items():
            load = run.load[:, i] / (np.abs(run.load[:, i]).max() + 1e-6) + 0.4 * run.a[:, i]
            fast = np.abs(run.v[:, pair[i]]).max() + 1e-9
            out[i] = (
                dead * np.tanh(3 * load) * np.abs(np.tanh(run.v[:, i] * 20))
                + coupled * run.v[:, pair[i]] * run.v[:, i] / fast
            )
        return strength * axis_delta(run, out)

    return Cause("leftover", DRIVE, drive=drive, follows=["load", "speed"])
