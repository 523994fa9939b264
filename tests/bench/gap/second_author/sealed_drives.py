"""The sealed family's drives and gears: smoothed set-points, loops without an integrator, Maxwell's slip, cycloids."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause


def settled(x, band, damping, dt):
    """A loop of second order stepped by half-implicit Euler's rule, as a recursion."""
    w, d = band * dt, 2 * damping * band * dt
    bottom = np.array([1.0 + d, -(2.0 + d) + w * w, 1.0])
    return lfilter([0.0, w * w], bottom / 1.0, x - x[0], axis=0) + x[0]


def slow(x, tau, dt):
    """First order."""
    keep = np.exp(-dt / tau)
    return lfilter([1 - keep], [1.0, -keep], x - x[0], axis=0) + x[0]


def _step(setting, i):
    """A size that matters: 0.01 degrees, or 0.08 mm of a sliding axis."""
    return 8e-5 if setting.robot.slides[i] else np.radians(0.01)


def servo_lag(setting, rng, s):
    """The set-points are smoothed by a moving mean, and the loop is a first order behind it; one axis is set differently."""
    tau = 0.006 * s * np.ones(len(setting.names))
    tau[rng.integers(len(tau))] *= rng.uniform(0.4, 2.0)
    part = rng.uniform(0.2, 0.7)

    def drive(run):
        out = {}
        for i, lag in enumerate(tau):
            x = run.c[:, i]
            mean = 2 * part * lag  # a mean over m seconds lags by half
            width = max(1, round(mean / run.dt))
            soft = lfilter(np.ones(width) / width, [1.0], x - x[0]) + x[0]
            out[i] = slow(soft, max(lag - (width - 1) * run.dt / 2, 1e-4), run.dt) - x
        return axis_delta(run, out)

    params = {f"{n}_s": float(t) for n, t in zip(setting.names, tau, strict=True)}
    return Cause("servo_lag", DRIVE, list(setting.names), params, ["speed"], drive=drive)


def acceleration_error(setting, rng, s):
    """Torque fed forward for another inertia than the arm has: the loop takes it back."""
    picked = setting.arm(rng, 2, setting.moving())
    part = {i: 2e-4 * s * rng.choice([-1, 1]) * rng.uniform(0.6, 1.6) for i in picked}
    band = 2 * np.pi * rng.uniform(5, 12)

    def drive(run):
        return axis_delta(run, {i: settled(-k * run.a[:, i], band, 0.8, run.dt) for i, k in part.items()})

    params = {f"{setting.names[i]}_s2": float(k) for i, k in part.items()}
    return Cause("acceleration_error", DRIVE, [setting.names[i] for i in picked], params, ["acceleration"], drive=drive)


def friction(setting, rng, s):
    """Coulomb's and Stribeck's in a loop that has no integrator: an offset by direction that stands, less at speed."""
    picked = setting.arm(rng, 2, setting.moving())
    size = {i: 0.5 * s * _step(setting, i) * rng.uniform(0.6, 1.6) for i in picked}
    more, band = rng.uniform(0.3, 1.5), 2 * np.pi * rng.uniform(3, 8)

    def drive(run):
        out = {}
        for i, offset in size.items():
            v = run.v[:, i] / (setting.robot.rows[i].speed * setting.robot.unit[i])
            out[i] = -offset * settled(np.tanh(v / 2e-4) * (1 + more * np.exp(-np.abs(v) / 0.01)), band, 0.9, run.dt)
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, x) for i, x in size.items()}
    return Cause("friction", DRIVE, [setting.names[i] for i in picked], params, ["direction", "speed"], drive=drive)


def backlash(setting, rng, s):
    """Play between teeth of which some are worn: wider here, narrower there."""
    picked = setting.arm(rng, 2, setting.moving())
    whole = {i: s * _step(setting, i) * rng.uniform(0.6, 1.6) for i in picked}
    worn, phase, turns = rng.uniform(0.1, 0.4), rng.uniform(0, 6.28), rng.integers(1, 4)

    def link(run):
        out = {}
        for i, width in whole.items():
            x = run.c[:, i]
            angle = turns * (x / 0.25 if setting.robot.slides[i] else x) + phase
            half = 0.5 * width * (1 + worn * np.sin(angle))
            y, at = np.empty_like(x), x[0]
            for k in range(len(x)):
                at = min(max(at, x[k] - half[k]), x[k] + half[k])
                y[k] = at
            out[i] = y - x
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, w) for i, w in whole.items()}
    return Cause("backlash", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def hysteresis(setting, rng, s):
    """Maxwell's slip: six springs, each with a limit of its own."""
    picked = setting.arm(rng, 2, setting.moving())
    wound = {i: 0.7 * s * _step(setting, i) for i in picked}
    reach = np.geomspace(0.2, 6.0, 6) * rng.uniform(0.7, 1.4)
    share = rng.dirichlet(np.ones(6) * 3)

    def link(run):
        out = {}
        for i in picked:
            limit = reach * setting.robot.unit[i] * (6 if setting.robot.slides[i] else 1)
            z, state = np.zeros(6), np.empty(len(run.t))
            for k, step in enumerate(np.diff(run.c[:, i], prepend=run.c[0, i])):
                z = np.clip(z + step, -limit, limit)
                state[k] = share @ (z / limit)
            out[i] = -wound[i] * state
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, w) for i, w in wound.items()}
    return Cause("hysteresis", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def gear_ripple(setting, rng, s):
    """A cycloid: its lobes and a second order of them, beating once a turn of the crank."""
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not setting.robot.slides[k]])
    lobes = float(rng.integers(24, 80))
    size, second, phase = 0.5 * s * np.radians(0.01), rng.uniform(0.1, 0.45), rng.uniform(0, 6.28, 3)

    def link(run):
        q = run.c[:, i]
        beat = 1 + 0.25 * np.cos(3 * q + phase[2])
        return axis_delta(
            run, {i: size * beat * (np.sin(lobes * q + phase[0]) + second * np.sin(2 * lobes * q + phase[1]))}
        )

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": lobes}
    return Cause("gear_ripple", BODY, [setting.names[i]], params, ["position"], link=link)


def motor_commutation(setting, rng, s):
    """Current sensors off zero and off gain: once and twice a pole pair, less the faster the motor turns."""
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not setting.robot.slides[k]])
    order = setting.robot.ratio * float(rng.choice([3, 4, 5]))
    size, twice, phase = 0.4 * s * np.radians(0.01), rng.uniform(0.2, 0.8), rng.uniform(0, 6.28, 2)
    band = 2 * np.pi * rng.uniform(4, 10)

    def drive(run):
        q = run.c[:, i]
        torque = np.sin(order * q + phase[0]) + twice * np.sin(2 * order * q + phase[1])
        return axis_delta(run, {i: size * settled(torque, band, 0.7, run.dt)})

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": order}
    return Cause("motor_commutation", DRIVE, [setting.names[i]], params, ["position"], drive=drive)


def setpoint_delay(setting, rng, s):
    """A bus hands one axis its set-points some cycles late, now and then one more."""
    (i,) = setting.arm(rng, 1, setting.moving())
    delay, jitter = 0.008 * s * rng.uniform(0.7, 1.3), rng.uniform(0.0, 0.15)
    seed = int(rng.integers(1 << 30))

    def drive(run):
        x = run.c[:, i]
        late = np.random.default_rng(seed).random(len(x)) < 0.3
        when = run.t - delay * (1 + jitter * uniform_filter1d(late.astype(float), 5))
        return axis_delta(run, {i: np.interp(when, run.t, x) - x})

    return Cause("setpoint_delay", DRIVE, [setting.names[i]], {f"{setting.names[i]}_s": delay}, ["speed"], drive=drive)


def wrist_coupling(setting, rng, s):
    """Shafts in one another: A4 carries A5 and A6, with the run-out of the inner shaft."""
    a4, a5, a6 = setting.robot.arm[-3:]
    five, six, out = s * 3e-4 * rng.choice([-1, 1]), s * 3e-4 * rng.normal(), s * 3e-5

    def link(run):
        q = run.c[:, a4]
        return axis_delta(run, {a5: five * q, a6: six * q + out * np.sin(q)})

    axes = [setting.names[a5], setting.names[a6]]
    return Cause("wrist_coupling", BODY, axes, {"A4_A5": float(five), "A4_A6": float(six)}, ["position"], link=link)


def early_reading(setting, rng, s):
    """Read after a wait of chance length, while the drives still creep in."""
    picked = setting.arm(rng, 2)
    share, tau, seed = 4e-4 * s, rng.uniform(0.2, 0.6), int(rng.integers(1 << 30))
    stage = DRIVE if rng.random() < 0.5 and setting.log["encoders"] else BODY

    def behind(run):
        wait = np.random.default_rng(seed).uniform(0.0, 0.5, len(run.t))
        return axis_delta(run, {i: -share * run.came[:, i] * np.exp(-wait / tau) for i in picked})

    hook = {"drive": behind} if stage == DRIVE else {"link": behind}
    return Cause("early_reading", stage, [setting.names[i] for i in picked], {"share": share}, ["direction"], **hook)


PATH = frozenset({"path", "setpoints"})
DRIVES = [
    Description("servo_lag", servo_lag, PATH, 8),
    Description("acceleration_error", acceleration_error, PATH, 15),
    Description("friction", friction, PATH, 20),
    Description("backlash", backlash, frozenset({"tracker"}), 15),
    Description("hysteresis", hysteresis, frozenset({"tracker"}), 15),
    Description("gear_ripple", gear_ripple, frozenset({"tracker"}), 12),
    Description("motor_commutation", motor_commutation, PATH, 12),
    Description("setpoint_delay", setpoint_delay, PATH, 10),
    Description("wrist_coupling", wrist_coupling, frozenset({"tracker", "wrist"}), 12),
    Description("early_reading", early_reading, frozenset({"tracker", "poses", "setpoints"}), 15),
]
