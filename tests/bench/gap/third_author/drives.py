"""Drives: a sampled loop with a late cycle, inertia that changes with posture, slip elements, current sensors, a slower bus."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause
from gap.third_author.tools import disturbed, filtered, inertia, small_step, turning


def servo_lag(setting, rng, s):
    """A sampled loop with proportional and damping terms, each a cycle late. Speed is fed forward in part: a lag by the rest;
    acceleration in full up to where the amplifier's current ends.
    """
    lag = 0.006 * s * rng.uniform(0.8, 1.25, len(setting.names))
    band, damping, limit = 2 * np.pi * rng.uniform(5, 8), rng.uniform(0.7, 1.0), rng.uniform(0.5, 0.95)

    def drive(run):
        out = {}
        for i, tau in enumerate(lag):
            w = min(band, 1.96 * damping / tau)
            ahead, T = 1.0 - tau * w / (2 * damping), run.dt
            p, d = (w * T) ** 2, 2 * damping * w * T
            den, x = [1.0, -2.0, 1.0 + d, p - d], run.c[:, i] - run.c[0, i]
            most = limit * np.abs(run.a[:, i]).max()
            pushed = lfilter([0, 0, 0, T * T], den, np.clip(run.a[:, i], -most, most))
            out[i] = lfilter([0, 0, ahead * d, p - ahead * d], den, x) + pushed - x
        return axis_delta(run, out)

    params = {f"{n}_s": float(t) for n, t in zip(setting.names, lag, strict=True)}
    return Cause("servo_lag", DRIVE, list(setting.names), params, ["speed"], drive=drive)


def _inertia_error(setting, rng, s):
    picked = setting.arm(rng, 2, setting.moving())
    part = {i: 2.5e-4 * s * rng.choice([-1, 1]) * rng.uniform(0.5, 1.5) for i in picked}
    return picked, part, {f"{setting.names[i]}_s2": float(k) for i, k in part.items()}


def inertia_fed_forward(setting, rng, s):
    """Torque fed forward for one inertia, whatever the posture: too little where the arm is stretched."""
    picked, part, params = _inertia_error(setting, rng, s)
    share, w, damping = rng.uniform(0.3, 0.8), 2 * np.pi * rng.uniform(4, 9), rng.uniform(0.6, 1.0)

    def drive(run):
        out = {}
        for i, k in part.items():
            J = inertia(run, i)
            lacks = (J / J.mean() - share) / (1.0 - share)
            out[i] = filtered([w * w], [1.0, 2 * damping * w, w * w], run.dt, -k * lacks * run.a[:, i])
        return axis_delta(run, out)

    names = [setting.names[i] for i in picked]
    return Cause("acceleration_error", DRIVE, names, params, ["acceleration"], drive=drive)


def inertia_behind(setting, rng, s):
    """A gear between encoder and link gives under the torque that the link's inertia takes, more where it is stretched."""
    picked, part, params = _inertia_error(setting, rng, s)

    def link(run):
        out = {}
        for i, k in part.items():
            J = inertia(run, i)
            out[i] = -abs(k) * J / J.mean() * run.a[:, i]
        return axis_delta(run, out)

    names = [setting.names[i] for i in picked]
    return Cause("acceleration_error", BODY, names, params, ["acceleration"], link=link)


def slip_force(v, dt, limits, stiff, creep, level):
    """Generalised Maxwell slip: elements that stick like springs up to limits times `level`, and creep towards it behind."""
    forces, slipping, out = [0.0] * len(limits), [False] * len(limits), []
    for speed, now in zip(v.tolist(), level.tolist(), strict=True):
        total, side = 0.0, 1.0 if speed >= 0 else -1.0
        for j, limit in enumerate(limits):
            f = forces[j]
            if slipping[j] and f * side >= 0 and speed != 0:
                f += dt * creep * limit * (side - f / (limit * now))
            else:
                f, slipping[j] = f + stiff[j] * speed * dt, False
                if abs(f) >= limit * now:
                    f, slipping[j] = (limit * now if f > 0 else -limit * now), True
            forces[j] = f
            total += f
        out.append(total)
    return np.array(out)


def friction(setting, rng, s):
    """Generalised Maxwell slip with limits by a power law, Stribeck's fall, against a loop with an integrator that is slow."""
    picked = setting.arm(rng, 2, setting.moving())
    peak = {i: 1.2 * s * small_step(setting.robot, i) * rng.uniform(0.6, 1.5) for i in picked}
    limits = np.arange(1, 6) ** -rng.uniform(0.4, 1.6)
    limits /= limits.sum()
    reach, over, knee, creep = (
        rng.uniform(0.5, 4.0),
        rng.uniform(0.1, 0.7),
        rng.uniform(0.005, 0.03),
        rng.uniform(3, 20),
    )
    band, damping, gain = 2 * np.pi * rng.uniform(2, 6), rng.uniform(0.5, 0.9), rng.uniform(3, 12)

    def drive(run):
        out = {}
        for i, size in peak.items():
            v, top = run.v[:, i], setting.robot.rows[i].speed * setting.robot.unit[i]
            level = 1.0 + over * np.exp(-((v / (knee * top)) ** 2))
            stiff = limits / (reach * small_step(setting.robot, i) * np.linspace(0.4, 2.5, 5))
            force = slip_force(v, run.dt, limits.tolist(), stiff.tolist(), creep, level)
            out[i] = -size * disturbed(band, damping, gain, run.dt, force)
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, x) for i, x in peak.items()} | {"gain_per_s": gain}
    return Cause("friction", DRIVE, [setting.names[i] for i in picked], params, ["direction", "speed"], drive=drive)


def motor_commutation(setting, rng, s):
    """Two current sensors, one off zero and one off gain: torque once a pole pair always, twice a pole pair with the current."""
    (i,) = setting.arm(rng, 1, turning(setting))
    pairs = float(rng.choice([2, 3, 4]))
    order, size = setting.robot.ratio * pairs, 1.5 * s * small_step(setting.robot, i)
    off, phase = rng.uniform(0.3, 1.0), rng.uniform(0, 2 * np.pi, 2)
    band, damping, gain = 2 * np.pi * rng.uniform(5, 12), rng.uniform(0.5, 0.9), rng.uniform(8, 20)

    def drive(run):
        q = run.c[:, i]
        torque = np.abs(run.load[:, i] - inertia(run, i) * run.a[:, i])
        current = torque / (torque.max() + 1e-9)
        ripple = off * np.sin(order * q + phase[0]) + (1 - off) * current * np.sin(2 * order * q + phase[1])
        return axis_delta(run, {i: size * disturbed(band, damping, gain, run.dt, ripple)})

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": order}
    return Cause("motor_commutation", DRIVE, [setting.names[i]], params, ["position", "load"], drive=drive)


def setpoint_delay(setting, rng, s):
    """One axis hangs on a slower bus: it holds each set-point for a cycle, gets it late, and smooths what it holds."""
    (i,) = setting.arm(rng, 1, setting.moving())
    delay = 0.008 * s * rng.uniform(0.75, 1.25)
    cycle = min(float(rng.choice([0.008, 0.012, 0.016])), delay)
    shift = rng.uniform(0, cycle)

    def drive(run):
        x = run.c[:, i]
        asked = np.floor((run.t - shift) / cycle) * cycle + shift  # when what is held was sampled
        width = max(1, round(cycle / run.dt))
        own = float((run.t - asked).mean()) + 0.5 * (width - 1) * run.dt  # what holding and smoothing take of the delay
        fine = np.interp(asked - (delay - own), run.t, x)
        soft = lfilter(np.ones(width) / width, [1.0], fine - x[0]) + x[0]
        return axis_delta(run, {i: soft - x})

    return Cause("setpoint_delay", DRIVE, [setting.names[i]], {f"{setting.names[i]}_s": delay}, ["speed"], drive=drive)


PATH = frozenset({"path", "setpoints"})
DRIVES = [
    Description("servo_lag", servo_lag, PATH, 10),
    Description("acceleration_error", inertia_fed_forward, PATH, 20),
    Description("acceleration_error", inertia_behind, frozenset({"path", "tracker"}), 20),
    Description("friction", friction, PATH, 20),
    Description("motor_commutation", motor_commutation, PATH, 20),
    Description("setpoint_delay", setpoint_delay, PATH, 12),
]
