"""What drives do: the encoders are not where the set-points are. Each function gives a `Shift` for a key and a size.

A key says which axis, and how; the size is linear or nearly so. Units: s of servo_lag and setpoint_delay in s, of
acceleration_error in s^2, of the rest in rad (m where the axis slides).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.ninth_author.paths import DT, Run
from gap.ninth_author.shift import Shift

__all__ = [
    "acceleration_error",
    "early_reading",
    "follower",
    "friction",
    "late_brake",
    "lugre",
    "motor_commutation",
    "servo_lag",
    "setpoint_delay",
    "stribeck",
]


def _only(run: Run, i, e) -> Shift:
    out = np.zeros_like(run.q)
    out[:, i] = e
    return Shift(drive=out)


def first_order(x, tau):
    """x behind a first-order lag, exact for values held over a step."""
    if tau <= 0:
        return x
    a = np.exp(-DT / tau)
    return lfilter([1 - a], [1, -a], x - x[0], axis=0) + x[0]


def follower(c, tau, fed=0.0):
    """Position less set-point of x' = (c - x) / tau + fed c': a follower whose speed is fed forward in part."""
    v = np.gradient(c, DT, axis=0)
    a = np.exp(-DT / tau)
    return -(1 - fed) * lfilter([tau * (1 - a)], [1, -a], v, axis=0)


def servo_lag(run: Run, key, s) -> Shift:
    """A follower of first order on all axes, one of which is set otherwise; or a feed-forward that itself comes late."""
    way, factors = key
    out = np.zeros_like(run.q)
    for i, f in enumerate(factors):
        if f and way == "follower":
            out[:, i] = follower(run.q[:, i], max(s * f, 1e-5))
        elif f:  # 90 % fed forward, behind a filter of 15 ms: what is left lags by s
            v = np.gradient(run.q[:, i], DT)
            out[:, i] = -s * f * first_order(v, 0.02) - 0.3 * s * f * (v - first_order(v, 0.015))
    return Shift(drive=out)


def acceleration_error(run: Run, key, s) -> Shift:
    """An inertia that nobody feeds forward winds up a position loop of 9 Hz."""
    i, w = key[0], 2 * np.pi * 9
    a = run.rate(2)[:, i]
    return _only(run, i, -s * first_order(first_order(a, 1 / w), 0.6 / w))


def lugre(v, bristle, fall=0.5, slow=0.02):
    """Friction over Coulomb's (N,) of a bristle model: z' = v - |v| z / g(v), Stribeck's fall in g."""
    z, out = 0.0, np.zeros(len(v))
    g = bristle * (1 + fall * np.exp(-((v / slow) ** 2)))
    for k in range(len(v)):
        z = (z + DT * v[k]) / (1 + DT * abs(v[k]) / g[k])
        out[k] = z / bristle
    return out


def stribeck(v, slow=0.02, fast=0.5):
    """Friction over Coulomb's (N,) by speed alone: a rounded sign, more when slow, more again when fast."""
    return np.tanh(v / 0.004) * (1 + 0.6 * np.exp(-np.abs(v) / slow)) + 0.3 * v / fast


def friction(run: Run, key, s) -> Shift:
    """Friction on one axis: a bristle's before a loop with an integrator, or a curve by speed before a stiff one."""
    i, way, bristle, calm = key
    v = run.rate()[:, i]
    if way == "lugre":
        f = lugre(v, bristle)
        f = first_order(f, 0.02)
        return _only(run, i, -s * (f - first_order(f, calm)))  # the integrator takes it off within `calm` s
    return _only(run, i, -s * first_order(stribeck(v, fast=run.arm.speed), 0.015))


def setpoint_delay(run: Run, key, s) -> Shift:
    """One axis gets its set-points late, now and then by another tick."""
    i, beat = key
    late = s * (1 + 0.15 * np.sin(2 * np.pi * run.t / beat))
    return _only(run, i, np.interp(run.t - late, run.t, run.q[:, i]) - run.q[:, i])


def motor_commutation(run: Run, key, s) -> Shift:
    """A motor's torque ripples by its poles; the faster it goes, the less the loop holds it, until the rotor's inertia does."""
    i, per_turn, phase = key
    v = np.abs(run.rate()[:, i]) * per_turn / (2 * np.pi * 12)
    gain = (0.3 + v) / (1 + v**2)
    return _only(run, i, s * gain * np.sin(per_turn * run.q[:, i] + phase))


def early_reading(run: Run, key, s) -> Shift:
    """Poses are read while an axis still creeps in: what is left of its last move after a wait of its own length."""
    i, settle = key
    return _only(run, i, -s * run.moves[:, i] * np.exp(-run.waits / settle))


def late_brake(run: Run, key, s) -> Shift:
    """Foreign: a brake opens s seconds after the axis should start, which it then makes up for."""
    i = key[0]
    c, out = run.q[:, i], np.zeros(len(run.q))
    still, since, held = 0.0, -1.0, c[0]
    moving = np.abs(run.rate()[:, i]) > 2e-3
    for k in range(1, len(c)):
        if not moving[k]:
            still += DT
            since = -1.0
        else:
            if still > 0.12:
                since, held = 0.0, c[k - 1]
            still = 0.0
            since = since + DT if since >= 0 else since
        if 0 <= since < s:
            out[k] = held - c[k]
        else:
            out[k] = out[k - 1] * np.exp(-DT / 0.05)
    return _only(run, i, out)
