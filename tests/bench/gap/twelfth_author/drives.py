"""What lies between a set-point and an encoder, and between an encoder and its link: one function a cause.

Each takes the run, the axes, a generator of draws and a size in its own unit, and gives a Change.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from .chains import jacobian, weights


@dataclass
class Change:
    """What a cause adds: to encoders (N, n), behind them (N, n), small motions of parts, and how a reading is changed."""

    drive: np.ndarray | float = 0.0
    link: np.ndarray | float = 0.0
    twists: dict = field(default_factory=dict)
    seen: list = field(default_factory=list)
    setpoint: np.ndarray | float = 0.0  # what the record of set-points is off by


def only(run, axes, columns):
    """(N, n) that holds `columns` at `axes`."""
    out = np.zeros_like(run.values)
    out[:, axes] = columns
    return out


def _trailing(x, dt, tau):
    """First order, exact for inputs that run straight from row to row."""
    a = np.exp(-dt / tau)
    held = tau / dt * (1 - a)
    y, _ = lfilter([1 - held, held - a], [1, -a], x, axis=0, zi=held * x[:1])
    return y


def servo_lag(run, axes, rng, size, *, integral=0.0):
    """A loop of first order (size: s), whose feed-forward is not set; with `integral` a slow one closes the rest."""
    dt = run.t[1] - run.t[0]
    x = run.values[:, axes]
    lag = _trailing(x, dt, max(size, 1e-6)) - x
    if integral:
        lag = lag - _trailing(lag, dt, integral)
    return Change(drive=only(run, axes, lag))


def setpoint_delay(run, axes, rng, size):
    """Set-points that come late (size: s)."""
    late = np.stack([np.interp(run.t - size, run.t, run.values[:, i]) for i in axes], axis=1)
    return Change(drive=only(run, axes, late - run.values[:, axes]))


def acceleration_error(run, axes, rng, size):
    """No inertia fed forward: an axis hangs back by acceleration (size: s2), through a loop of 12 ms."""
    dt = run.t[1] - run.t[0]
    return Change(drive=only(run, axes, -size * _trailing(run.accelerations[:, axes], dt, 0.012)))


def _rubbing(run, axes, stribeck=0.6):
    v = run.speeds[:, axes]
    scale = 0.02 * np.array([run.chain.joints[i].speed for i in axes]) * run.chain.unit[axes]
    return np.tanh(v / scale) * (1 + stribeck * np.exp(-((v / (4 * scale)) ** 2)))


def friction(run, axes, rng, size, *, integral=0.6, viscous=0.15):
    """Dry friction with Stribeck's hump against a loop whose integral (s) takes it off in time (size: rad or m of stiction)."""
    dt = run.t[1] - run.t[0]
    v = run.speeds[:, axes] / (np.array([run.chain.joints[i].speed for i in axes]) * run.chain.unit[axes])
    push = _rubbing(run, axes) + viscous * v
    left = push - _trailing(push, dt, integral)
    return Change(drive=only(run, axes, -size * _trailing(0.75 * left + 0.25 * push, dt, 0.02)))


def motor_commutation(run, axes, rng, size, *, waves=70.0):
    """Cogs of a motor: waves by its own turn, weaker as it turns quicker than the loop can't."""
    q, v = run.values[:, axes], run.speeds[:, axes]
    fade = 1 / np.sqrt(1 + (waves * v / (2 * np.pi * 6)) ** 2)
    return Change(drive=only(run, axes, size * fade * (np.sin(waves * q + 0.7) + 0.3 * np.sin(2 * waves * q))))


def joint_offset(run, axes, rng, size):
    """Zeros lost (size: rad or m of the first; others by draws of like size)."""
    share = np.concatenate([[1.0], rng.uniform(0.5, 1.1, len(axes) - 1) * rng.choice([-1, 1], len(axes) - 1)])
    return Change(link=only(run, axes, size * share))


def joint_compliance(run, axes, rng, size, *, hard=0.0):
    """Axes that give way to weight (size: rad/Nm of the first; later ones softer); `hard` lets a gear stiffen with load."""
    tau = weights(run.chain, run.values)[:, axes]
    soft = size * (1.0 + 0.7 * np.arange(len(axes)))
    yields = tau / (1 + hard * np.abs(tau) / (np.abs(tau).max() + 1e-9))
    return Change(link=only(run, axes, -soft * yields))


def payload(run, axes, rng, size, *, soft=2e-6):
    """More mass at the plate than was told (size: kg), on axes whose softness the maker takes off for what was told."""
    more = run.chain.loaded(run.chain.payload + max(size, 1e-6))
    tau = (weights(more, run.values) - weights(run.chain, run.values))[:, axes]
    return Change(link=only(run, axes, -soft * (1.0 + 0.7 * np.arange(len(axes))) * tau))


def _arrivals(run):
    """Values (2N or N, n) in the order in which they are passed, and where the rows are."""
    if run.before is None:
        return run.values, np.arange(len(run.values))
    both = np.empty((2 * len(run.values), run.values.shape[1]))
    both[0::2], both[1::2] = run.before, run.values
    return both, np.arange(1, len(both), 2)


def backlash(run, axes, rng, size):
    """Play (size: the whole, rad or m): the link trails its encoder by half."""
    passed, rows = _arrivals(run)
    out = np.zeros((len(rows), len(axes)))
    for k, i in enumerate(axes):
        q, link, held = passed[:, i], np.empty(len(passed)), passed[0, i]
        for j, value in enumerate(q):
            held = min(max(held, value - size / 2), value + size / 2)
            link[j] = held
        out[:, k] = (link - q)[rows]
    return Change(link=only(run, axes, out))


def hysteresis(run, axes, rng, size, *, slips=(0.004, 0.03)):
    """Slipping blocks beside a spring (size: rad or m): after a reversal the lag comes back over two lengths."""
    passed, rows = _arrivals(run)
    out = np.zeros((len(rows), len(axes)))
    for k, i in enumerate(axes):
        for slip in slips:
            at, z = passed[0, i], np.zeros(len(passed))
            for j, value in enumerate(passed[:, i]):
                at = min(max(at, value - slip), value + slip)
                z[j] = (at - value) / slip
            out[:, k] += size * z[rows] / len(slips)
    return Change(link=only(run, axes, out))


def gear_ripple(run, axes, rng, size, *, waves=36.0):
    """Teeth, worms, wheels of belts: two waves of the axis's own place."""
    q = run.values[:, axes]
    return Change(link=only(run, axes, size * (np.sin(waves * q + 1.1) + 0.25 * np.sin(2 * waves * q + 0.4))))


def wrist_coupling(run, axes, rng, size):
    """Ratios of a wrist of another make: A5 by A4, A6 by A4 and A5 (size: of A5 by A4)."""
    a4, a5, a6 = (run.chain.index(n) for n in ("A4", "A5", "A6"))
    out = np.zeros_like(run.values)
    out[:, a5] = size * run.values[:, a4]
    out[:, a6] = 0.8 * size * run.values[:, a4] + 1.2 * size * run.values[:, a5]
    return Change(link=out)


def thermal_drift(run, axes, rng, size, *, minutes=22.0):
    """Castings grow and axes creep as the arm warms (size: m of the upper arm, at the end of the record's warmth)."""
    warm = (run.temp - run.temp[0]) / max(np.ptp(run.temp), 1e-9)
    twists = {}
    for k, i in enumerate(axes):
        twist = np.zeros((len(run.t), 6))
        twist[:, 0] = size * warm * (0.8 if k else 1.0)
        twist[:, 2] = 0.3 * size * warm
        twists[run.chain.joints[i].name] = twist
    return Change(link=only(run, axes, 0.5 * size * warm[:, None]), twists=twists)


def cutting_force(run, axes, rng, size):
    """Axes give way to the force at the tool (size: rad/Nm)."""
    J = jacobian(run.chain, run.values)[:, :3]
    tau = np.einsum("nij,ni->nj", J, run.force)[:, axes]
    return Change(link=only(run, axes, size * (1.0 + 0.4 * np.arange(len(axes))) * tau))
