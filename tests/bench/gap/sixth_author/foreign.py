"""Causes without a name, and what a real machine leaves beside all of them. DEV's and SEALED's share nothing."""

from __future__ import annotations

import numpy as np

from gap.sixth_author.known import DEG, _follow, _names, _only, _some
from gap.sixth_author.world import Cause


def _tip_lever(machine):
    return max(0.3, 0.35 * machine.reach)


def _distal(rng, machine):
    return machine.turning[int(rng.integers(max(0, len(machine.turning) - 3), len(machine.turning)))]


# DEV


def loose_bolt(machine, rng):
    """A flange's bolts slip when the tool's weight turns it harder than they hold, and stay where they slipped to."""
    k = machine.arm[-1]
    limit, width = rng.uniform(0.3, 0.55), 1.2e-3

    def shape(run, m, g):
        z = machine.frames(machine.still(run.c))[2]
        pull = np.einsum("ni,i->n", z[:, :3, 0], [0, 0, 1.0])  # of the weight about the plate's axis
        pull = pull - pull.mean() * 0.5
        top, at, out = limit * np.abs(pull).max(), 0.0, np.zeros(len(pull))
        for i, x in enumerate((pull / top).tolist()):
            if abs(x - at) > 1:
                at = x - np.sign(x - at)
            out[i] = at
        turn = np.zeros((len(run.rows), 6))
        turn[:, 5], turn[:, 3] = width * out[run.rows], 0.5 * width * out[run.rows]
        return {k: g * turn}, {}

    return Cause("loose_bolt", _names(machine, [k]), follows=("load", "direction", "position"), shape=shape)


def cable_pull(machine, rng):
    """A cable pack that goes taut from some posture on winds up the axis that it runs along."""
    k = _distal(rng, machine)
    slack, sense = rng.uniform(-0.2, 0.3), rng.choice([-1, 1])

    def link(run, m, g):
        x = (m[:, k] / machine.unit[k] - machine.home[k]) / machine.swing[k] * sense - slack
        pull = np.logaddexp(0, 8 * x) / 8
        return _only(run, {k: -g * sense * 0.03 * DEG * pull**1.5})

    return Cause("cable_pull", _names(machine, [k]), follows=("position",), link=link)


def floor_tilt(machine, rng):
    """A slab under the machine gives towards where the arm's weight is, and comes back slowly."""
    k, soft, tau = machine.foot, rng.uniform(0.5, 1, 2), rng.uniform(15, 60)

    def shape(run, m, g):
        moment = machine.foot_moment(run.c[run.rows])[:, :2]
        if "E1" in machine.names:
            i = machine.index("E1")
            s = (run.c[run.rows, i] / machine.unit[i] - machine.home[i]) / machine.swing[i]
            moment = moment * (0.6 + s[:, None] ** 2)
        late, t = np.array(moment), run.clock
        for i in range(1, len(late)):
            p = np.exp(-(t[i] - t[i - 1]) / tau)
            late[i] = p * late[i - 1] + (1 - p) * moment[i]
        scale = np.abs(moment).max() + 1e-9
        out = np.zeros((len(late), 6))
        out[:, 3:5] = 2e-4 * late * soft / scale
        out[:, 2] = 1e-4 * late[:, 0] / scale
        return {k: g * out}, {}

    return Cause("floor_tilt", follows=("load", "position", "time"), shape=shape)


def limit_cycle(machine, rng):
    """A drive whose gain is too high swings by a few counts while its axis is nearly at rest."""
    (k,) = _some(rng, machine, 1, 1)
    hertz, size = rng.uniform(2.2, 5), 0.01 * DEG

    def drive(run, m, g):
        slow = 0.25 * np.abs(run.v[:, k]).max() + 1e-9
        on, at = np.zeros(len(m)), 0.0
        for i, x in enumerate((np.abs(run.v[:, k]) < slow).tolist()):
            at += (x - at) * run.dt / 0.25
            on[i] = at
        return _only(run, {k: g * size * on * np.clip(1.6 * np.sin(2 * np.pi * hertz * run.t), -1, 1)})

    return Cause("limit_cycle", _names(machine, [k]), "setpoint_to_encoder", ("speed", "time"), drive=drive)


def flat_spot(machine, rng):
    """A bearing with a dent: each ball that passes lets the link drop by a little, wherever the cage is."""
    (k,) = _some(rng, machine, 1, 1)
    balls, wide, phase = int(rng.integers(17, 41)) * 0.43, rng.uniform(0.04, 0.09), rng.random()

    def shape(run, m, g):
        x = (m[run.rows, k] / (2 * np.pi) * balls + phase) % 1.0
        drop = np.exp(-(((x - 0.5) / wide) ** 2))
        out = np.zeros((len(run.rows), 6))
        out[:, 4], out[:, 2] = 2.5e-4 * drop, 6e-5 * drop
        return {k: g * out}, {}

    return Cause("flat_spot", _names(machine, [k]), follows=("position",), shape=shape)


def bent_link(machine, rng):
    """A collision within the first log: from then on a link is bent."""
    k = machine.arm[min(len(machine.arm) - 1, int(rng.integers(0, 4)))]
    way = np.r_[1e-4 * rng.normal(size=3), 4e-4 * rng.normal(size=3)]
    when = rng.uniform(0.3, 0.7)

    def shape(run, m, g):
        after = np.ones(len(run.rows)) if run.name == "withheld" else np.zeros(len(run.rows))
        if run.number == 0:
            after = (run.clock > when * run.clock[-1]).astype(float)
        elif run.number > 0 and run.name != "withheld":
            after = np.ones(len(run.rows))
        return {k: g * after[:, None] * way}, {}

    return Cause("bent_link", _names(machine, [k]), follows=("time",), shape=shape)


# SEALED


def passing_load(machine, rng):
    """A crane or a truck goes by: the hall's floor dips for half a minute, and a little of it stays."""
    way = np.r_[1e-4 * rng.normal(size=3), 1.5e-4 * rng.normal(size=2), 0]
    when, wide = rng.uniform(0.2, 0.8, 8), rng.uniform(0.04, 0.1)

    def shape(run, m, g):
        x = (run.clock / run.clock[-1] - when[run.number % 8]) / wide
        return {"world": g * (np.exp(-(x**2)) + 0.25 / (1 + np.exp(-3 * x)))[:, None] * way}, {}

    return Cause("passing_load", follows=("time",), shape=shape)


def brake_drag(machine, rng):
    """A brake that lets go late: after each halt the link creeps on to where the motor is."""
    (k,) = _some(rng, machine, 1, 1)
    tau = rng.uniform(1.2, 3.0)

    def link(run, m, g):
        back, out = 0.0, np.zeros(len(m))
        still = np.abs(run.v[:, k]) < 1e-4
        for i, step in enumerate(np.diff(m[:, k], prepend=m[0, k]).tolist()):
            if still[i]:
                back *= np.exp(-run.dt / tau)
            else:
                back += np.sign(step) * min(abs(step), 2e-3) * 0.1 - back * 0.1 * run.dt
                back = min(1.0, max(-1.0, back / 2e-2)) * 2e-2
            out[i] = -back
        return _only(run, {k: g * 0.02 * out})

    return Cause("brake_drag", _names(machine, [k]), follows=("direction", "time", "speed"), link=link)


def tired_balancer(machine, rng):
    """A gas spring beside the second axis loses pressure, faster while it works: the gear takes what it no longer carries."""
    k = machine.turning[min(1, len(machine.turning) - 1)]
    leak, bend = rng.uniform(1500, 5000), rng.uniform(0.2, 0.5)

    def link(run, m, g):
        lost = 0.6 + 0.4 * (1 - np.exp(-(run.begins + run.t) / leak))
        x = m[:, k]
        return _only(run, {k: g * 0.03 * DEG * lost * np.sin(x + bend) / np.sqrt(1 + 0.5 * np.cos(x))})

    return Cause("tired_balancer", _names(machine, [k]), follows=("position", "load", "time"), link=link)


def lost_counts(machine, rng):
    """An encoder that drops counts when its axis is fast: the arm is further each time than it is told to be."""
    (k,) = _some(rng, machine, 1, 1)

    def link(run, m, g):
        fast = 0.45 * np.abs(run.v[:, k]).max()
        lost = np.cumsum(np.maximum(0, run.v[:, k] - fast)) * run.dt
        before = 0.0 if run.number == 0 else 0.5 * run.number
        return _only(run, {k: g * 0.004 * DEG * (lost / (lost[-1] + 1e-9) + before) * 6})

    return Cause("lost_counts", _names(machine, [k]), follows=("time", "speed"), link=link)


def filling_hose(machine, rng):
    """A hose along the forearm fills with coolant as the program runs and drains where the arm points down."""
    axes = [k for k in machine.turning][1:3] or machine.turning
    fill = rng.uniform(15, 40)

    def link(run, m, g):
        z = machine.tip(run.c[:: max(1, len(run.c) // 800)])[:, :3, 2][:, 2]
        down = np.interp(np.linspace(0, 1, len(run.c)), np.linspace(0, 1, len(z)), z)
        level, out = 0.0, np.zeros(len(run.c))
        for i, d in enumerate(down.tolist()):
            level += run.dt * ((1 - level) / fill - 0.05 * max(0.0, d) * level)
            out[i] = level
        weight = {k: out * run.load[:, k] / (np.abs(run.load[:, k]).max() + 1e-9) for k in axes}
        return _only(run, {k: g * 0.02 * DEG * x for k, x in weight.items()})

    return Cause("filling_hose", _names(machine, axes), follows=("time", "load"), link=link)


def sunlit_column(machine, rng):
    """One side of what the arm stands on is warmed and shaded by clouds."""
    way = np.r_[5e-5 * rng.normal(size=3), 1.2e-4 * rng.normal(size=2), 0]
    slow, fast, phase = rng.uniform(1500, 4000), rng.uniform(25, 90), rng.uniform(0, 6.3)

    def shape(run, m, g):
        t = run.begins + run.clock
        bend = np.sin(2 * np.pi * t / slow) + 0.35 * np.tanh(3 * np.sin(2 * np.pi * t / fast / 8 + phase))
        return {machine.foot: g * bend[:, None] * way}, {}

    return Cause("sunlit_column", follows=("time",), shape=shape)


def worn_seat(machine, rng):
    """A tool's taper sits in one of two places and changes over when its weight pulls it far enough to the other side."""
    way = np.r_[1.5e-4 * rng.normal(size=2), 0, 4e-4 * rng.normal(size=2), 0]
    limit = rng.uniform(0.05, 0.2)

    def shape(run, m, g):
        side = run.nominal[:, 2, 0] - np.median(run.nominal[:, 2, 0])
        side = side / (np.abs(side).max() + 1e-9)
        at, out = (1.0 if side[0] > 0 else -1.0), np.zeros(len(side))
        for i, x in enumerate(side.tolist()):
            if x * at < -limit:
                at = -at
            out[i] = at
        return {"tip": g * out[:, None] * way}, {}

    return Cause(
        "worn_seat", _names(machine, [machine.arm[-1]]), follows=("position", "load", "direction"), shape=shape
    )


def tooth_jump(machine, rng):
    """A belt before an axis's gear jumps a tooth where torque is highest, and back where it is lowest."""
    (k,) = _some(rng, machine, 1, 1)
    high, low = rng.uniform(0.75, 0.9), rng.uniform(0.1, 0.25)

    def link(run, m, g):
        x = run.needed[:, k]
        top, foot = np.quantile(x, [high, low])
        at, out = 0.0, np.zeros(len(x))
        for i, now in enumerate(x.tolist()):
            at = 1.0 if now > top else 0.0 if now < foot else at
            out[i] = at
        return _only(run, {k: g * 0.03 * DEG * out})

    return Cause("tooth_jump", _names(machine, [k]), follows=("load", "direction", "position"), link=link)


def slipping_target(machine, rng):
    """A reflector's magnet slides by a little at a moment of each log."""
    way, when = 3e-4 * rng.normal(size=(8, 3)), rng.uniform(0.25, 0.75, 8)

    def shape(run, m, g):
        n = run.number % 8
        late = way[:n].sum(0) + (run.clock > when[n] * run.clock[-1])[:, None] * way[n]
        return {"tip": g * np.concatenate([late, np.zeros_like(late)], 1)}, {}

    return Cause("slipping_target", stage="instrument", follows=("time",), shape=shape)


def spindle_runout(machine, rng):
    """A collet that holds the tool off its axis, while the spindle creeps round."""
    hertz, phase = rng.uniform(0.15, 1.6), rng.uniform(0, 6.3)

    def shape(run, m, g):
        turn = 2 * np.pi * hertz * (run.begins + run.clock) + phase
        off = 1e-4 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
        return {"tip": g * np.concatenate([off, np.zeros_like(off)], 1)}, {}

    return Cause("spindle_runout", follows=("time",), shape=shape)


def starved_bus(machine, rng):
    """A bus that is short of voltage holds all drives back when many of them are fast at once."""
    limit = rng.uniform(0.35, 0.6)

    def drive(run, m, g):
        power = np.abs(run.needed * run.v).sum(1)
        short = np.maximum(0, power - limit * power.max()) / (power.max() + 1e-9)
        level, out = 0.0, np.zeros(len(m))
        for i, x in enumerate(short.tolist()):
            level += (x - level) * run.dt / 0.08
            out[i] = level
        return -g * 0.02 * out[:, None] * run.v

    return Cause("starved_bus", tuple(machine.names), "setpoint_to_encoder", ("speed", "load"), drive=drive)


DEV = {
    "loose_bolt": (loose_bolt, ("path", "poses")),
    "cable_pull": (cable_pull, ("path", "poses")),
    "floor_tilt": (floor_tilt, ("path", "poses")),
    "limit_cycle": (limit_cycle, ("path", "drives")),
    "flat_spot": (flat_spot, ("path", "poses")),
    "bent_link": (bent_link, ("path", "poses")),
}
SEALED = {
    "passing_load": (passing_load, ("path", "poses")),
    "brake_drag": (brake_drag, ("path",)),
    "tired_balancer": (tired_balancer, ("path", "poses")),
    "lost_counts": (lost_counts, ("path",)),
    "filling_hose": (filling_hose, ("path",)),
    "sunlit_column": (sunlit_column, ("path", "poses")),
    "worn_seat": (worn_seat, ("path", "poses")),
    "tooth_jump": (tooth_jump, ("path",)),
    "slipping_target": (slipping_target, ("path", "poses")),
    "spindle_runout": (spindle_runout, ("path",)),
    "starved_bus": (starved_bus, ("path", "drives")),
}


# what is left beside


def fourier_twists(machine, rng):
    """DEV: behind each axis a small twist of its own, periodic in it and in its neighbour, some of it by direction."""
    lever, arm = _tip_lever(machine), machine.arm
    size = {k: 1e-4 * rng.normal(size=(3, 6)) * np.r_[np.ones(3), np.ones(3) / lever] for k in arm}
    order, phase = {k: rng.uniform(0.7, 3.2, 3) for k in arm}, {k: rng.uniform(0, 6.3, 3) for k in arm}
    cross = {k: rng.normal(size=3) * 0.7 for k in arm}
    memory = rng.random() < 0.5

    def wave(m, k, i):
        x, y = m[:, k], m[:, max(0, k - 1)]
        if machine.joints[k].slides:
            x = 3 * x
        return np.sin(order[k][i] * x + cross[k][i] * y + phase[k][i])

    def shape(run, m, g):
        out = {}
        for k in arm:
            here = m[run.rows]
            twist = sum(wave(here, k, i)[:, None] * size[k][i] for i in range(3))
            if memory:
                twist = twist + 0.5 * _follow(run.c[:, k], 6 * DEG)[run.rows][:, None] * size[k][0]
            out[k] = g * twist
        return out, {}

    return Cause("leftover", params={"of": "twists by Fourier series"}, shape=shape)


def elastic_rest(machine, rng):
    """SEALED: links bend by products of loads, and ring for a while at 4 to 9 Hz behind what excites them."""
    lever, arm, n = _tip_lever(machine), machine.arm, len(machine.joints)
    pairs = {k: rng.normal(size=(n, n)) for k in arm}
    lines = {k: rng.normal(size=n) * 0.5 for k in arm}
    ways = {k: 1e-4 * rng.normal(size=6) * np.r_[np.ones(3), np.ones(3) / lever] for k in arm}
    omega, ring = 2 * np.pi * rng.uniform(4, 9), rng.uniform(0.0, 0.6)
    tilt = rng.uniform(0.0, 0.8)

    def shape(run, m, g):
        bound = np.abs(machine.load(m[::50])).max(0) + 1e-6
        load = machine.load(m[run.rows]) / bound
        load = np.where(bound > 0.3, load, np.cos(2 * m[run.rows]))
        pull, x, v = np.abs(run.a).max() + 1e-9, 0.0, 0.0
        swing = np.zeros(len(run.c))
        if not run.rest:
            for i, a in enumerate((run.a[:, arm[0]] / pull).tolist()):
                v += run.dt * (-omega * omega * x - 0.12 * omega * v - omega * omega * a)
                x += run.dt * v
                swing[i] = x
        out = {}
        for k in arm:
            bend = np.einsum("ni,ij,nj->n", load, pairs[k], load) / n + np.tanh(2 * (load @ lines[k]))
            bend = bend + ring * swing[run.rows] + tilt * _follow(run.c[:, k], 2 * DEG)[run.rows]
            out[k] = g * bend[:, None] * ways[k]
        return out, {}

    return Cause("leftover", params={"of": "bending and ringing"}, shape=shape)


def drives_rest(machine, rng, second):
    """Of drives: an error by place and speed (DEV), or what neighbours' accelerations push through a soft loop (SEALED)."""
    n = len(machine.joints)
    size, order, phase = 3e-5 * rng.normal(size=n), rng.uniform(2, 6, n), rng.uniform(0, 6.3, n)
    push = 2e-5 * rng.normal(size=(n, n))

    def drive(run, m, g):
        if second:
            return g * np.tanh(run.a / (np.abs(run.a).max(0) + 1e-9)) @ push
        fast = run.v / (np.abs(run.v).max(0) + 1e-9)
        return g * size * np.sin(order * m + phase) * (0.5 + fast**2)

    return Cause("leftover", stage="setpoint_to_encoder", params={"of": "drives"}, drive=drive)
