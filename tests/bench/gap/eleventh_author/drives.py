"""What drives do wrong between set-point and encoder, and what a second encoder sees of a gear."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .stages import Cause, Truth

__all__ = [
    "late_setpoints",
    "magnets",
    "no_inertia_term",
    "proportional_loop",
    "sticking",
    "wound_gear_two_encoders",
]

DRIVE = "setpoint_to_encoder"
TUNE = "tune the drive's loops or feedforward of this axis (gain, velocity and acceleration share); nothing at the mechanics"


def _dt(truth: Truth) -> float:
    return float(truth.t[1] - truth.t[0])


def _low(x, tau, dt):
    """First order, at rest at the start."""
    if tau < 1e-7:
        return x
    keep = np.exp(-dt / tau)
    part = (1 - keep) * tau / dt  # exact for set-points that run straight from cycle to cycle
    return lfilter([1 - part, part - keep], [1, -keep], x - x[0]) + x[0]


def proportional_loop(shares: dict[str, float], mm: float, alike=(), unit: float = 0.02) -> Cause:
    """A position loop of gain kv about a velocity loop that has a lag of its own: shares of 1/kv by axis."""

    def act(truth: Truth, s: float) -> None:
        for name, share in shares.items():
            i = truth.robot.index(name)
            tau = s * share
            inner = 0.35 * tau
            truth.enc[:, i] = _low(_low(truth.enc[:, i], inner, _dt(truth)), tau - inner, _dt(truth))

    return Cause(
        "servo_lag",
        tuple(shares),
        DRIVE,
        ("speed",),
        act,
        unit,
        mm,
        "position gain too low, no velocity feedforward",
        TUNE,
        "opening gears, mastering, calibrating the arm",
        alike,
        order=0,
    )


def no_inertia_term(shares: dict[str, float], mm: float, alike=()) -> Cause:
    """The torque for the acceleration comes from the error alone: behind while it speeds up, ahead while it slows."""

    def act(truth: Truth, s: float) -> None:
        dt = _dt(truth)
        for name, share in shares.items():
            i = truth.robot.index(name)
            acc = np.gradient(np.gradient(truth.enc[:, i], dt), dt)
            w, z = 2 * np.pi * 7.0, 0.5  # the loop's own answer
            a = [1 / dt**2 + 2 * z * w / dt + w**2, -2 / dt**2 - 2 * z * w / dt, 1 / dt**2]
            truth.enc[:, i] -= s * share * lfilter([w**2], a, acc)

    return Cause(
        "acceleration_error",
        tuple(shares),
        DRIVE,
        ("acceleration",),
        act,
        1e-3,
        mm,
        "no acceleration feedforward",
        TUNE,
        "opening gears, mastering",
        alike,
        order=0,
    )


def sticking(shares: dict[str, float], mm: float, settle: float = 0.45, alike=()) -> Cause:
    """Bristles (Dahl, with a Stribeck rise) before a loop with an integral: a peak after each start and turn, that decays."""

    def act(truth: Truth, s: float) -> None:
        dt = _dt(truth)
        for name, share in shares.items():
            i = truth.robot.index(name)
            v = np.gradient(truth.run.q[:, i], dt)
            top = truth.robot.speeds[i]
            reach = 0.0015 * (1.0 if not truth.robot.joints[i].slides else 300.0)
            z, f = 0.0, np.zeros(len(v))
            level = 1 + 0.6 * np.exp(-((v / (0.02 * top)) ** 2)) + 0.25 * np.abs(v) / top
            for k in range(len(v)):
                z = np.clip(z + dt * v[k] * (1 - z * np.sign(v[k])) / reach, -1.0, 1.0)
                f[k] = z * level[k]
            keep = np.exp(-dt / settle)
            high = lfilter([1, -1], [1, -keep], f - f[0])
            truth.enc[:, i] -= s * share * _low(high, 0.012, dt)
            truth.torque[:, i] += 12.0 * share * f

    return Cause(
        "friction",
        tuple(shares),
        DRIVE,
        ("direction", "speed"),
        act,
        2e-3,
        mm,
        "stiff grease or a dragging seal",
        "look at grease, seals and brake of this axis, and its friction compensation",
        "mastering, calibrating the arm",
        alike,
        order=0,
    )


def magnets(name: str, per_unit: float, mm: float, alike=()) -> Cause:
    """The motor cogs: so many periods in a radian (mm) of the axis, weaker the faster it turns."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        v = np.abs(np.gradient(truth.run.q[:, i], _dt(truth))) * per_unit / (2 * np.pi)  # Hz
        phase = per_unit * truth.run.q[:, i]
        wave = np.sin(phase + 0.7) + 0.35 * np.sin(2 * phase + 2.1)
        truth.enc[:, i] += s * wave / np.sqrt(1 + (v / 25.0) ** 2)

    return Cause(
        "motor_commutation",
        (name,),
        DRIVE,
        ("position",),
        act,
        1e-4,
        mm,
        "commutation offset of a motor wrong after its exchange",
        "set the commutation offset of this motor anew, look at its resolver and its phases",
        "opening the gear, mastering",
        alike,
        order=0,
    )


def late_setpoints(delays: dict[str, float], mm: float, alike=()) -> Cause:
    """An axis gets its set-points cycles after the others: bus cycles by axis."""

    def act(truth: Truth, s: float) -> None:
        for name, share in delays.items():
            i = truth.robot.index(name)
            truth.enc[:, i] = np.interp(truth.t - s * share, truth.t, truth.enc[:, i])

    return Cause(
        "setpoint_delay",
        tuple(delays),
        DRIVE,
        ("speed",),
        act,
        0.012,
        mm,
        "this axis sits on another bus, a few cycles behind",
        "look at the bus cycles and the synchronisation of this axis",
        "opening gears, tuning gains",
        alike,
        order=0,
    )


def _play(x, half):
    out, now = np.empty(len(x)), x[0]
    for k in range(len(x)):
        now = min(max(now, x[k] - half), x[k] + half)
        out[k] = now
    return out


def wound_gear_two_encoders(name: str, mm: float) -> Cause:
    """A gear that gives and slips inside: many plays of growing width, the widest of a degree's tenth."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        truth.motor = truth.enc.copy() if truth.motor is None else truth.motor
        x = truth.enc[:, i].copy()
        for width, part in zip((0.05, 0.12, 0.25, 0.45), (0.4, 0.3, 0.2, 0.1), strict=True):
            truth.enc[:, i] += s * part * (_play(x, width) - x) / width

    return Cause(
        "hysteresis",
        (name,),
        DRIVE,
        ("direction",),
        act,
        1e-3,
        mm,
        "a gear that gives and slips inside",
        "measure the gear's loop of torque and angle, look at its grease and preload",
        "mastering",
        ("backlash",),
        order=0,
    )
