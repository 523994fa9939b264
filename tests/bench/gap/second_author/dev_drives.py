"""The development family's drives and gears: loops, a bristle, play with inertia, strain waves, Dahl's hysteresis."""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause


def filtered(top, bottom, dt, x):
    """A transfer function of s on columns of x, from rest at their first values."""
    b, a = bilinear(top, bottom, fs=1.0 / dt)
    return lfilter(b, a, x - x[0], axis=0)


def servo_lag(setting, rng, s):
    """Cascade: position loop over a velocity loop of second order, speed fed forward in part."""
    share = rng.uniform(0.7, 1.3, len(setting.names))
    lag = 0.006 * s * share
    band, damping = 2 * np.pi * rng.uniform(14, 24), rng.uniform(0.6, 0.9)

    def drive(run):
        out = {}
        for i, tau in enumerate(lag):
            gain = min(18.0, 0.9 / tau)
            ahead = 1.0 - gain * tau
            top = np.array([ahead, gain]) * band**2
            bottom = [1.0, 2 * damping * band, band**2 * (1.0), gain * band**2]
            x = run.c[:, i]
            out[i] = filtered(top, bottom, run.dt, x) + x[0] - x
        return axis_delta(run, out)

    params = {f"{n}_s": float(t) for n, t in zip(setting.names, lag, strict=True)}
    return Cause("servo_lag", DRIVE, list(setting.names), params, ["speed"], drive=drive)


def acceleration_error(setting, rng, s):
    """A spring and a mass behind the encoder, damped against it."""
    picked = setting.arm(rng, 3, [i for i in setting.moving() if i in setting.robot.arm] or setting.robot.arm)
    give = {i: 3e-4 * s * rng.uniform(0.5, 1.5) for i in picked}

    def link(run):
        out = {}
        for i, k in give.items():
            w = 1.0 / np.sqrt(k)
            x = run.c[:, i]
            out[i] = filtered([0.5 * w, w * w], [1.0, 0.5 * w, w * w], run.dt, x) + x[0] - x
        return axis_delta(run, out)

    names = [setting.names[i] for i in picked]
    return Cause(
        "acceleration_error",
        BODY,
        names,
        {f"{setting.names[i]}_s2": k for i, k in give.items()},
        ["acceleration"],
        link=link,
    )


def friction(setting, rng, s):
    """A bristle's force with Stribeck's fall, against a position and a speed loop with an integrator."""
    picked = setting.arm(rng, 3, setting.moving())
    peak = {
        i: s * 0.01 * rng.uniform(0.5, 1.5) * setting.robot.unit[i] * (8 if setting.robot.slides[i] else 1)
        for i in picked
    }
    reach, over, speed = rng.uniform(2e-5, 2e-4), rng.uniform(0.1, 0.8), np.radians(rng.uniform(0.5, 3))
    settle, quick = rng.uniform(0.08, 0.35), rng.uniform(0.01, 0.03)

    def drive(run):
        z, force = np.zeros(len(picked)), np.zeros((len(run.t), len(picked)))
        for k, v in enumerate(run.v[:, picked]):
            level = 1.0 + over * np.exp(-((v / speed) ** 2))
            z = (z + run.dt * v / reach) / (1.0 + run.dt * np.abs(v) / reach / level)
            force[k] = z
        behind = filtered([settle, 0.0], [settle * quick, settle + quick, 1.0], run.dt, force)
        return axis_delta(run, {i: -peak[i] * behind[:, j] for j, i in enumerate(picked)})

    params = {setting.key(i): setting.told(i, p) for i, p in peak.items()} | {"settles_s": settle}
    return Cause("friction", DRIVE, [setting.names[i] for i in picked], params, ["direction", "speed"], drive=drive)


def carried(x, half):
    """Where a body is that a pin in a slot of half width `half` pushes."""
    out, w = np.empty_like(x), x[0]
    for k, at in enumerate(x):
        w = min(max(w, at - half), at + half)
        out[k] = w
    return out


def backlash(setting, rng, s):
    """Play: the link stays where it is until the gap is crossed, and takes its time to cross."""
    picked = setting.arm(rng, 2, setting.moving())
    whole = {
        i: s * (0.01 * np.pi / 180 if not setting.robot.slides[i] else 5e-5) * rng.uniform(0.6, 1.5) for i in picked
    }
    slow = rng.uniform(0.01, 0.04)

    def link(run):
        out = {}
        for i, width in whole.items():
            lost = carried(run.c[:, i], width / 2) - run.c[:, i]
            out[i] = lost if run.rest else filtered([1.0], [slow, 1.0], run.dt, lost) + lost[0]
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, w) for i, w in whole.items()}
    return Cause("backlash", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def hysteresis(setting, rng, s):
    """Dahl's friction behind the encoder: the link is wound up against it."""
    picked = setting.arm(rng, 2, setting.moving())
    wound = {i: s * 0.006 * setting.robot.unit[i] * (8 if setting.robot.slides[i] else 1) for i in picked}
    reach = {i: rng.uniform(0.5, 5.0) * setting.robot.unit[i] * (6 if setting.robot.slides[i] else 1) for i in picked}

    def link(run):
        out = {}
        for i in picked:
            f, state = 0.0, np.empty(len(run.t))
            for k, step in enumerate(np.diff(run.c[:, i], prepend=run.c[0, i]) / reach[i]):
                f = (f + step) / (1.0 + abs(step))
                state[k] = f
            out[i] = -wound[i] * state
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, w) for i, w in wound.items()}
    return Cause("hysteresis", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def gear_ripple(setting, rng, s):
    """A strain wave gear: two waves a turn of its generator, stronger under load and once a turn of the joint."""
    robot = setting.robot
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not robot.slides[k]])
    order = 2 * robot.ratio if rng.random() < 0.5 else float(rng.integers(20, 60))
    size, phase, under, turn = s * np.radians(0.004), rng.uniform(0, 6.28), rng.uniform(0, 0.5), rng.uniform(0, 0.4)

    def link(run):
        q, load = run.c[:, i], run.load[:, i]
        strong = 1 + under * load / (np.abs(load).max() + 1e-9) + turn * np.sin(q + phase)
        return axis_delta(run, {i: size * strong * np.sin(order * q + phase)})

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": order}
    return Cause("gear_ripple", BODY, [setting.names[i]], params, ["position"], link=link)


def motor_commutation(setting, rng, s):
    """The motor's torque ripples once a pole pair; the loop lets slow ripple through."""
    robot = setting.robot
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not robot.slides[k]])
    order, size, phase = robot.ratio * float(rng.integers(3, 6)), s * np.radians(0.003), rng.uniform(0, 6.28)
    soft = rng.uniform(0.01, 0.03)

    def drive(run):
        wave = np.sin(order * run.c[:, i] + phase)
        return axis_delta(run, {i: size * filtered([1.0], [soft, 1.0], run.dt, wave)})

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": order}
    return Cause("motor_commutation", DRIVE, [setting.names[i]], params, ["position"], drive=drive)


def setpoint_delay(setting, rng, s):
    """One axis gets its set-points late."""
    (i,) = setting.arm(rng, 1, setting.moving())
    delay = 0.008 * s

    def drive(run):
        x = run.c[:, i]
        return axis_delta(run, {i: np.interp(run.t - delay, run.t, x) - x})

    return Cause("setpoint_delay", DRIVE, [setting.names[i]], {f"{setting.names[i]}_s": delay}, ["speed"], drive=drive)


def wrist_coupling(setting, rng, s):
    """Bevel gears in the hand: A6 is carried along by A5, not quite in proportion."""
    a5, a6 = setting.robot.arm[4], setting.robot.arm[5]
    share, bent = s * 4e-4 * rng.choice([-1, 1]), s * 1e-4 * rng.normal()

    def link(run):
        q = run.c[:, a5]
        return axis_delta(run, {a6: share * q + bent * q * q})

    return Cause("wrist_coupling", BODY, ["A6"], {"A5_A6": float(share)}, ["position"], link=link)


def early_reading(setting, rng, s):
    """Read before the arm has come to rest: it is still behind where it came from."""
    picked = setting.arm(rng, 2)
    behind, reach = s * np.radians(0.006), np.radians(rng.uniform(2, 15))

    def link(run):
        return axis_delta(run, {i: -behind * np.tanh(run.came[:, i] / reach) for i in picked})

    params = {setting.key(i): setting.told(i, behind) for i in picked}
    return Cause("early_reading", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


PATH, MOVES = frozenset({"path", "setpoints"}), frozenset({"turns"})
DRIVES = [
    Description("servo_lag", servo_lag, PATH, 8),
    Description("acceleration_error", acceleration_error, frozenset({"path", "tracker"}), 12),
    Description("friction", friction, PATH, 15),
    Description("backlash", backlash, frozenset({"tracker"}), 15),
    Description("hysteresis", hysteresis, frozenset({"tracker"}), 15),
    Description("gear_ripple", gear_ripple, frozenset({"tracker"}), 12),
    Description("motor_commutation", motor_commutation, PATH, 12),
    Description("setpoint_delay", setpoint_delay, PATH, 10),
    Description("wrist_coupling", wrist_coupling, frozenset({"tracker", "wrist"}), 12),
    Description("early_reading", early_reading, frozenset({"tracker", "poses"}), 15),
]
