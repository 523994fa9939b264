"""Causes that the library has a name for: what each is, as a function of a run and a size, and the most that it can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from .motions import TICK
from .shift import Shift

ARC = np.pi / 180


@dataclass
class Cause:
    """`make(run, size)` gives a Shift; `first`: a size to begin with, `most`: the largest that there is."""

    name: str
    make: Any
    first: float
    most: float
    axes: tuple = ()
    stage: str = "encoder_to_tcp"
    follows: str = ""


def axes_of(m, rng, low=1, high=2, among=None):
    """Some axes that turn."""
    among = [k for k in (among if among is not None else range(m.n)) if m.kinds[k] == "R"]
    return sorted(rng.choice(among, int(rng.integers(low, min(high, len(among)) + 1)), replace=False).tolist())


def shifted(field, value):
    """A make whose Shift is `size * value(run)` in one field."""

    def make(run, size):
        out = Shift.none(run)
        getattr(out, field)[...] = size * value(run)
        return out

    return make


def _said(m, ks):
    return tuple(m.names[k] for k in ks)


def _on(m, ks, weights=None):
    out = np.zeros(m.n)
    out[ks] = 1.0 if weights is None else weights
    return out


def joint_offset(m, rng):
    ks = axes_of(m, rng, 1, 3)
    d = _on(m, ks, rng.choice([-1, 1], len(ks)) * rng.uniform(0.5, 1.5, len(ks)))
    return Cause("joint_offset", shifted("true", lambda run: d), 1e-4, 0.3 * ARC, _said(m, ks))


def geometry(m, rng):
    """Two castings of another lot: their rows' lengths and the squareness of their axes."""
    at = rng.choice(np.arange(2, m.n - 1), 2, replace=False)
    d = np.zeros((m.n + 2, 6))
    d[at] = rng.normal(size=(2, 6)) * np.array([1, 0, 1, 3e-1, 3e-1, 0])
    return Cause("geometry", shifted("twist", lambda run: d), 1e-4, 1e-3)


def frame_tool(m, rng):
    d = np.zeros((m.n + 2, 6))
    d[-1] = rng.normal(size=6) * np.array([1, 1, 0.6, 0.3, 0.3, 0])
    return Cause("frame_tool", shifted("twist", lambda run: d), 1e-4, 2e-3)


def frame_base(m, rng):
    """A foot that was levelled on three wedges: height and two tilts, and where it was set down."""
    d = np.zeros((m.n + 2, 6))
    d[0] = rng.normal(size=6) * np.array([1, 1, 0.5, 0.4, 0.4, 0.2])
    return Cause("frame_base", shifted("twist", lambda run: d), 1e-4, 3e-3)


def joint_compliance(m, rng):
    """Gears that give by a power of the torque a little below one."""
    ks = axes_of(m, rng, 2, 3, [k for k in range(m.n) if m.kinds[k] == "R"][1:5])
    soft = _on(m, ks, rng.uniform(0.6, 1.6, len(ks))) * np.array(m.soft)
    return Cause(
        "joint_compliance",
        shifted("true", lambda run: soft * np.sign(run.load) * np.abs(run.load) ** 0.92),
        1.0,
        6.0,
        _said(m, ks),
    )


def payload(m, rng):
    """A spindle with its cables and clamps weighs more than was told and sits askew: all gears give."""
    centre = (*rng.uniform(-120, 120, 2), rng.uniform(0, 250))
    more = m.masses[-1][1] * rng.choice([-0.5, 1.0])

    def value(run):
        return np.array(m.soft) * m.load(run.c, ((m.n, more, centre),))

    return Cause("payload", shifted("true", value), 1.0, 4.0)


def lean(m, rng):
    """A foot on which a moment about one direction tilts about another, too."""
    c = np.eye(3) + 0.5 * rng.normal(size=(3, 3))

    def make(run, size):
        out = Shift.none(run)
        tilt = size * 1e-8 * run.machine.moment(run.c) @ c.T
        foot = run.frames[0][0, :3, 3]
        out.twist[:, 0, 3:], out.twist[:, 0, :3] = tilt, -np.cross(tilt, foot)
        return out

    return Cause("lean", make, 1.0, 60.0)


def _play(x, half):
    """Where what is driven through a play of `half` to either side stands."""
    out, here = np.empty_like(x), x[0]
    for i, to in enumerate(x):
        here = min(max(here, to - half), to + half)
        out[i] = here
    return out


def backlash(m, rng):
    """A worn spline whose ends are soft: the last of the play is crossed under a growing force."""
    ks = axes_of(m, rng)

    def make(run, size):
        out = Shift.none(run)
        for k in ks:
            behind = _play(run.q[:, k], size / 2) - run.q[:, k]
            out.true[:, k] = run.at(size / 2 * np.tanh(2.2 * behind / (size / 2)))
        return out

    return Cause("backlash", make, 1e-4, 0.08 * ARC, _said(m, ks))


def hysteresis(m, rng):
    """Preisach's: relays whose thresholds are strewn about zero, over the swing of the axis."""
    ks = axes_of(m, rng)
    mid, wide = rng.normal(0, 0.35, 40), rng.gamma(2.0, 0.12, 40)

    def make(run, size):
        out = Shift.none(run)
        for k in ks:
            x = (run.q[:, k] - m.middle[k]) / (0.5 * m.swing[k] * m.units[k])
            state = np.where(mid < x[0], 1.0, -1.0)
            loop = np.empty(len(x))
            for i, at in enumerate(x):
                state = np.where(at > mid + wide, 1.0, np.where(at < mid - wide, -1.0, state))
                # less what relays of no width would do: that follows posture alone
                loop[i] = (state - np.sign(at - mid)).mean()
            out.true[:, k] = size * run.at(loop)
        return out

    return Cause("hysteresis", make, 1e-4, 0.03 * ARC, _said(m, ks))


def gear_ripple(m, rng):
    """The mesh of a gear's last stage, louder and softer once a turn of its planet."""
    ks = axes_of(m, rng, 1, 1)
    per, phase, beat = rng.integers(20, 60), rng.uniform(0, 6, 2), rng.uniform(0.2, 0.6)

    def value(run):
        return _on(m, ks) * np.sin(per * run.c + phase[0]) * (1 + beat * np.sin(run.c * per / 9 + phase[1]))

    return Cause("gear_ripple", shifted("true", value), 1e-4, 0.02 * ARC, _said(m, ks))


def wrist_coupling(m, rng):
    """The hand's shafts run one in the other: A4 turns A5 and A6, A5 turns A6."""
    k = m.n - 3
    f = rng.choice([-1, 1], 3) * rng.uniform(0.4, 1.2, 3)

    def value(run):
        out = np.zeros_like(run.c)
        q4, q5 = run.c[:, k] - m.middle[k], run.c[:, k + 1] - m.middle[k + 1]
        out[:, k + 1], out[:, k + 2] = f[0] * q4, f[1] * q4 + f[2] * q5
        return out

    return Cause("wrist_coupling", shifted("true", value), 1e-4, 6e-3, _said(m, [k + 1, k + 2]))


def thermal_drift(m, rng):
    """Castings that lengthen by a stretched exponential, each in its time, and motors that turn their flanges."""
    tau, share, turn = rng.uniform(600, 3000, m.n), rng.uniform(0.3, 1.2, m.n), rng.normal(0, 2e-5, m.n)
    length = np.array([[r[1], r[3]] for r in m.rows]) / 1e3

    def make(run, size):
        out = Shift.none(run)
        warm = size * share * (1 - np.exp(-((run.late[:, None] / tau) ** 0.7)))
        out.twist[:, 1:-1, 0] = 12e-6 * warm * length[:, 0]
        up = np.array(
            [[np.sin(np.radians(r[0])), np.cos(np.radians(r[0]))] for r in m.rows]
        )  # d lies along the row's own z
        out.twist[:, 1:-1, 1:3] = 12e-6 * (warm * length[:, 1])[..., None] * up
        out.true = turn * warm
        return out

    return Cause("thermal_drift", make, 3.0, 25.0)


def track(m, rng):
    """A rail that hangs between its jacks, pitches as it does, and a rack that is too long."""
    gap, phase, side, scale = rng.uniform(0.5, 0.9), rng.uniform(0, 6), rng.uniform(-0.6, 0.6), rng.uniform(-1.5, 1.5)

    def value(run):
        s = 2 * np.pi * run.c[:, 0] / gap + phase
        out = np.zeros((len(s), m.n + 2, 6))
        high, climb = np.cos(s) - 0.3 * np.cos(2 * s), np.radians(20)
        along = scale * run.c[:, 0]  # behind the rail's row x is across, y level and against it, z up
        out[:, 1, 0] = side * np.sin(s)
        out[:, 1, 1] = high * np.sin(climb) - along * np.cos(climb)
        out[:, 1, 2] = high * np.cos(climb) + along * np.sin(climb)
        out[:, 1, 3] = 0.3 * np.pi / gap * np.sin(s)
        return out

    return Cause("track", shifted("twist", value), 1e-4, 6e-4)


def servo_lag(m, rng):
    """A third-order filter in front of the position loop, the same of all axes but one."""
    odd, ratio = int(rng.integers(m.n)), rng.uniform(0.5, 1.8)

    def make(run, size):
        out = Shift.none(run)
        for k in range(m.n):
            tau = size / 3 * (ratio if k == odd else 1.0)
            x, p = run.q[:, k] - run.q[0, k], np.exp(-TICK / tau)
            for _ in range(3):
                x = lfilter([1 - p], [1, -p], x)
            out.enc[:, k] = run.at(x + run.q[0, k] - run.q[:, k])
        return out

    return Cause("servo_lag", make, 0.01, 0.12, m.names, "setpoint_to_encoder")


def friction(m, rng):
    """Presliding that saturates within an arc after turning back, and grease that thins with speed."""
    ks = axes_of(m, rng, 1, 3)
    arc, grease = rng.uniform(0.1, 0.5) * ARC, rng.uniform(0.1, 0.4)

    def make(run, size):
        out = Shift.none(run)
        for k in ks:
            slip, z = np.empty(len(run.q)), 0.0
            for i, dx in enumerate(np.diff(run.q[:, k], prepend=run.q[0, k])):
                z += (np.sign(dx) - z) * (1 - np.exp(-abs(dx) / arc))
                slip[i] = z
            v = run.v[:, k]
            out.enc[:, k] = -size * run.at(slip + grease * np.sign(v) * np.abs(v) ** 0.6)
        return out

    return Cause("friction", make, 1e-4, 0.04 * ARC, _said(m, ks), "setpoint_to_encoder")


def setpoint_delay(m, rng):
    """One drive's set-points come through another gateway, late by a time that breathes."""
    k, beat = axes_of(m, rng, 1, 1)[0], rng.uniform(3, 9)

    def make(run, size):
        out = Shift.none(run)
        late = size * (1 + 0.25 * np.sin(2 * np.pi * run.t / beat))
        out.enc[:, k] = run.at(np.interp(run.t - late, run.t, run.q[:, k]) - run.q[:, k])
        return out

    return Cause("setpoint_delay", make, 0.004, 0.06, _said(m, [k]), "setpoint_to_encoder")


def acceleration_error(m, rng):
    """A loop without feed-forward of torque gives by inertia times acceleration, as posture has it."""
    ks = axes_of(m, rng, 2, 3)
    stiff = rng.uniform(0.5, 1.5, m.n)

    def value(run):
        return -_on(m, ks) * stiff * m.inertia(run.c) / m.inertia(m.middle) * run.at(run.a)

    return Cause("acceleration_error", shifted("enc", value), 1e-5, 2e-3, _said(m, ks), "setpoint_to_encoder")


def motor_commutation(m, rng):
    """Six times a pole pair, from dead times of the inverter, and once."""
    ks = axes_of(m, rng, 1, 2)
    per = np.array(m.ratios) * rng.choice([3, 4, 5])
    phase, six = rng.uniform(0, 6, m.n), rng.uniform(0.2, 0.7)

    def value(run):
        return _on(m, ks) * (np.sin(per * run.c + phase) + six * np.sin(6 * per * run.c + 2 * phase))

    return Cause("motor_commutation", shifted("enc", value), 1e-5, 0.01 * ARC, _said(m, ks), "setpoint_to_encoder")


def latency(m, rng):
    """Stamps that a bus hands over in packets of 8 ms, late by a constant."""

    def make(run, size):
        out = Shift.none(run)
        when = np.floor((run.t[run.pick] - size) / 0.008 + 0.5) * 0.008
        out.true = np.stack([np.interp(when, run.t, x) for x in run.q.T], 1) - run.c
        return out

    return Cause("latency", make, 0.03, 0.3)


def early_reading(m, rng):
    """Poses are read while the axes still creep in, exponentially, the big ones longer."""
    share = np.linspace(1.0, 0.3, m.n)

    def value(run):
        return -share * np.diff(run.c, axis=0, prepend=m.middle[None])

    return Cause("early_reading", shifted("true", value), 1e-4, 6e-3)


def cutting_force(m, rng):
    """Spindle and last gears give under the cut, across the tool more than along."""
    across, along = rng.uniform(0.7, 1.4, 2) * np.array([1.0, 0.25])

    def value(run):
        z = run.frames[-1][:, :3, 2]
        push = np.einsum("ni,ni->n", run.force, z)[:, None] * z
        j = run.machine.jacobian(run.c)[:, :3]
        gears = np.einsum("nij,j,nkj,nk->ni", j, np.array(m.soft), j, run.force)
        return 1e-7 * (across * (run.force - push) + along * push) + 0.5 * gears

    return Cause("cutting_force", shifted("off", value), 1.0, 6.0)


def measurement_scale(m, rng):
    """A tracker whose distances are long by a share and by a constant."""
    station = m.tip(m.middle)[0, :3, 3] + np.append(rng.choice([-1, 1], 2) * rng.uniform(1.5, 3, 2), 0.4)

    def value(run):
        ray = run.points - station
        return ray + 0.3 * ray / np.linalg.norm(ray, axis=1, keepdims=True)

    return Cause("measurement_scale", shifted("off", value), 1e-5, 4e-4)


def measurement_drift(m, rng):
    """A stand that wanders as Brown has it, smoothed, and turns with it; it goes on from log to log."""
    step = rng.normal(size=(6, 600))
    step = np.stack([np.convolve(x, np.ones(40) / 40, "same") for x in np.cumsum(step, 1)]) / 20

    def make(run, size):
        out = Shift.none(run)
        at = np.stack([np.interp(run.late / 12, np.arange(600), x) for x in step], 1) * size
        out.turn = 0.3 * at[:, 3:]
        out.off = at[:, :3] + np.cross(out.turn, run.points)
        return out

    return Cause("measurement_drift", make, 1e-4, 1e-3)


PATH, POSES, DRIVES = "path", "poses", "drives"
# by name: its draw, logs that show it, what it asks of them
NAMED = {
    "joint_offset": (joint_offset, {PATH, POSES}, ()),
    "geometry": (geometry, {PATH, POSES}, ()),
    "frame_tool": (frame_tool, {PATH, POSES}, ("target",)),
    "frame_base": (frame_base, {PATH, POSES}, ("frame",)),
    "joint_compliance": (joint_compliance, {PATH, POSES}, ("masses",)),
    "payload": (payload, {PATH, POSES}, ("masses",)),
    "lean": (lean, {PATH, POSES}, ("masses",)),
    "backlash": (backlash, {PATH, POSES}, ()),
    "hysteresis": (hysteresis, {PATH, POSES}, ()),
    "gear_ripple": (gear_ripple, {PATH, POSES}, ()),
    "wrist_coupling": (wrist_coupling, {PATH, POSES}, ("wrist",)),
    "thermal_drift": (thermal_drift, {PATH, POSES}, ()),
    "track": (track, {PATH, POSES}, ("rail",)),
    "servo_lag": (servo_lag, {PATH, DRIVES}, ("setpoints",)),
    "friction": (friction, {PATH, DRIVES}, ("setpoints",)),
    "setpoint_delay": (setpoint_delay, {PATH, DRIVES}, ("setpoints",)),
    "acceleration_error": (acceleration_error, {PATH, DRIVES}, ("setpoints",)),
    "motor_commutation": (motor_commutation, {PATH, DRIVES}, ("setpoints",)),
    "latency": (latency, {PATH}, ()),
    "early_reading": (early_reading, {POSES}, ()),
    "cutting_force": (cutting_force, {PATH}, ("force",)),
    "measurement_scale": (measurement_scale, {PATH, POSES}, ()),
    "measurement_drift": (measurement_drift, {PATH, POSES}, ()),
}
