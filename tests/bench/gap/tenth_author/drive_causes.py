"""What goes wrong between a set-point and an encoder, and between two encoders of one axis. Each from its mechanics."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .truth import Cause, Truth

__all__ = [
    "brake_in_patches",
    "bus_sag",
    "commutation",
    "heavy_inertia",
    "late_setpoints",
    "loses_counts",
    "play_between",
    "resonance",
    "slow_loop",
    "sticking",
]

D = np.pi / 180.0
_STAGE = "setpoint_to_encoder"


def _slow(x, tau, dt):
    """A first-order element, exact where its input goes straight from row to row."""
    keep = np.exp(-dt / tau)
    part = tau / dt * (1 - keep)
    return lfilter([1 - part, part - keep], [1, -keep], x, zi=[x[0] * part])[0]


def slow_loop(taus: dict[str, float], forward=0.0) -> Cause:
    """Position loops that were detuned: a follower of first order, `forward` of the speed fed ahead."""

    def act(truth: Truth) -> None:
        dt = truth.run.t[1] - truth.run.t[0]
        for name, tau in taus.items():
            k = truth.at(name)
            want = truth.run.q[:, k] + forward * tau * truth.v[:, k]
            truth.q[:, k] += _slow(want, tau, dt) - truth.run.q[:, k]

    return Cause(
        "servo_lag",
        _STAGE,
        tuple(taus),
        ("speed",),
        act,
        "compare the position loop's gain (and feed-forward) of the axis with the other axes' and "
        "the maker's parameters; put the right set back",
        "calibrating the arm, opening a gear",
        ("setpoint_delay",),
    )


def late_setpoints(name: str, seconds: float) -> Cause:
    """One axis' set-points arrive late over the bus."""

    def act(truth: Truth) -> None:
        k, t = truth.at(name), truth.run.t
        truth.q[:, k] += np.interp(t - seconds, t, truth.run.q[:, k]) - truth.run.q[:, k]

    return Cause(
        "setpoint_delay",
        _STAGE,
        (name,),
        ("speed",),
        act,
        "look at the bus cycle and the interpolation set-up of that axis' drive: its set-points "
        "come later than the others'",
        "raising gains, opening a gear",
        ("servo_lag",),
    )


def heavy_inertia(shares: dict[str, float]) -> Cause:
    """Inertia that the feed-forward doesn't know of: the axis is behind by what its loop gives under it (rad per rad/s2)."""

    def act(truth: Truth) -> None:
        dt = truth.run.t[1] - truth.run.t[0]
        for name, share in shares.items():
            k = truth.at(name)
            truth.q[:, k] -= _slow(share * truth.a[:, k], 0.025, dt)

    return Cause(
        "acceleration_error",
        _STAGE,
        tuple(shares),
        ("acceleration",),
        act,
        "check the load data (mass, centre, inertia) that the controller was told for the tool, "
        "and enter the right ones",
        "calibrating the arm, new gears",
        (),
    )


def sticking(sizes: dict[str, float], fade=0.22, creep=0.15) -> Cause:
    """Dry friction at which an integrator works: a push at each turn that fades, something of it (creep) stays while it moves."""

    def act(truth: Truth) -> None:
        dt = truth.run.t[1] - truth.run.t[0]
        for name, size in sizes.items():
            k = truth.at(name)
            v = truth.v[:, k]
            knee = 0.02 * np.max(np.abs(v)) + 1e-12
            drag = np.tanh(v / knee) * (1 + 0.5 * np.exp(-np.abs(v) / (4 * knee)))
            fading = drag - _slow(drag, fade, dt)
            truth.q[:, k] -= size * (fading + creep * drag)
            truth.torque[:, k] += truth.run.extra.get("stick_nm", 12.0) * drag

    return Cause(
        "friction",
        _STAGE,
        tuple(sizes),
        ("direction", "speed"),
        act,
        "let the axis run slowly to and fro by itself and compare its current both ways with an "
        "earlier record; then grease, seals and brake of that axis",
        "calibrating the arm, changing the frame",
        ("backlash",),
    )


def commutation(name: str, waves: float, size: float, corner: float) -> Cause:
    """A motor whose current sensors differ: `waves` a turn of the axis (rad: per 2 pi), which the loop holds when slow."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        rate = np.abs(waves * truth.v[:, k])
        gain = (rate / corner) / (1 + (rate / corner) ** 2) * 2
        truth.q[:, k] += size * gain * np.sin(waves * truth.q[:, k] + 0.7)

    return Cause(
        "motor_commutation",
        _STAGE,
        (name,),
        ("position", "speed"),
        act,
        "have the drive's current offsets and the resolver's (commutation) angle of that motor adjusted",
        "opening the gear, calibrating the arm",
        ("gear_ripple",),
    )


def play_between(name: str, width: float) -> Cause:
    """Play of a gear between the motor's encoder and the one on the output: the output is dragged along within `width`."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        truth.motor = truth.q.copy() if truth.motor is None else truth.motor
        x, out = truth.q[:, k], np.zeros(len(truth.q))
        now = x[0] - width / 2
        for i, m in enumerate(x):
            now = min(max(now, m - width / 2), m + width / 2)
            out[i] = now
        truth.q[:, k] = out

    return Cause(
        "backlash",
        _STAGE,
        (name,),
        ("direction",),
        act,
        "block the motor, push the output to and fro with a dial gauge on it; then adjust or change that gear",
        "tuning the loop, calibrating",
        ("hysteresis",),
    )


def bus_sag(name: str, size: float) -> Cause:
    """Foreign: the rectifier is weak; one drive falls behind while all others together draw power."""

    def act(truth: Truth) -> None:
        k, dt = truth.at(name), truth.run.t[1] - truth.run.t[0]
        top = np.array([j.speed for j in truth.machine.joints])
        power = np.sum(np.abs(truth.v / top), axis=1) - np.abs(truth.v[:, k] / top[k])
        sag = _slow(np.clip(power - 1.2, 0, None), 0.12, dt)
        truth.q[:, k] -= size * sag * np.tanh(truth.v[:, k] / (0.1 * top[k]))

    return Cause(
        "bus_sag",
        _STAGE,
        (name,),
        ("speed",),
        act,
        "look at that axis' drive and its supply: log the DC bus while all axes move, then the axis by itself",
        "calibrating, opening a gear",
        (),
        True,
    )


def loses_counts(name: str, size: float, mark: float, steps: int) -> Cause:
    """Foreign: a scratched encoder disc loses counts each time the axis passes a place; what it reports creeps off."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        x = truth.run.q[:, k]
        crossed = np.concatenate([[0], np.cumsum(np.abs(np.diff(np.sign(x - mark))) > 0)])
        truth.link[:, k] += size * np.minimum(crossed, steps)

    return Cause(
        "loses_counts",
        "encoder_to_tcp",
        (name,),
        ("time",),
        act,
        "drive the axis to its reference mark before and after the run: it is off by more each "
        "time; encoder and cable of that axis",
        "calibrating once for all, changing the frame",
        (),
        True,
    )


def resonance(name: str, size: float, at: float, width: float, hertz: float) -> Cause:
    """Foreign: a belt that sings at one speed."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        near = np.exp(-(((np.abs(truth.v[:, k]) - at) / width) ** 2))
        truth.q[:, k] += size * near * np.sin(2 * np.pi * hertz * truth.run.t)

    return Cause(
        "belt_resonance",
        _STAGE,
        (name,),
        ("speed",),
        act,
        "drive that axis by itself at several speeds and listen: it shakes at one speed; belt "
        "tension and the drive's notch filter",
        "calibrating, changing frames",
        (),
        True,
    )


def brake_in_patches(name: str, size: float, low: float, high: float) -> Cause:
    """Foreign: a brake disc rubs over a part of the range, whichever way the axis goes: it falls behind there alone."""

    def act(truth: Truth) -> None:
        k, dt = truth.at(name), truth.run.t[1] - truth.run.t[0]
        x, v = truth.run.q[:, k], truth.v[:, k]
        soft = 0.04 * (high - low)
        there = 0.5 * (np.tanh((x - low) / soft) - np.tanh((x - high) / soft))
        top = np.max(np.abs(v)) + 1e-12
        truth.q[:, k] -= _slow(size * there * np.tanh(v / (0.03 * top)), 0.05, dt)
        truth.torque[:, k] += 25.0 * there * np.tanh(v / (0.03 * top))

    return Cause(
        "brake_rubs",
        _STAGE,
        (name,),
        ("position", "direction"),
        act,
        "drive that axis by itself slowly through its range and watch its current: it rises over a "
        "part of the range; brake or seal there",
        "calibrating, changing frames",
        ("friction",),
        True,
    )
