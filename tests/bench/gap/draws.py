"""What may be wrong with a cell of the gap benchmark: every effect of the library in richer physics, and some that it lacks.

Play runs on a 4 ms grid, the lag steps once a cycle, link errors are Denavit-Hartenberg tolerances, ripple has a second
harmonic, friction is Stribeck's. Two in five draws follow another engineer's physics of the same effect: a lag of each axis's
own, friction without Stribeck's peak, a foot that drifts with the warmth, lean by reach, a track that sags about its middle, an
eccentric encoder, a spring at the tip. Nothing here comes from camrob.
"""

from __future__ import annotations

import numpy as np

from gap.generator import AXES, DEG, NOMINAL, STEP, play, rigid, smooth

PATHS = (
    "frame_base",
    "frame_tool",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "joint_compliance",
    "payload",
    "backlash",
    "servo_lag",
    "acceleration_error",
    "friction",
    "gear_ripple",
    "wrist_coupling",
    "thermal_drift",
    "latency",
    "cutting_force",
)
POSES = (
    "frame_base",
    "frame_tool",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "joint_compliance",
    "payload",
    "wrist_coupling",
    "early_reading",
)
ON_TABLE = ("frame_table", "measurement_frame")
OUTSIDE = ("bent_axis", "rack_pitch", "slip", "hose", "vibration", "wrist_curve", "loose_tool", "creep")
POSES_OUTSIDE = ("bent_axis", "rack_pitch", "slip", "hose", "wrist_curve", "loose_tool")
MARKERS = {"setpoint_to_encoder": ("servo_lag", "friction")}  # effects of one rung; all others lie behind the encoders


FOOT = NOMINAL.foot[:3, 3]
_OTHER = 0.4  # share of draws that follow another engineer's physics


def shift(world, axes, value):
    """Links beyond their encoders."""
    world.link[:, axes] = world.link[:, axes] + value


def reach_of(world):
    """(M, 3) the tool from the robot's foot, which travels along the track."""
    reach = world.context["tcp"] - FOOT
    reach[:, 1] -= world.command[:, 6]
    return reach


def draw(name, rng, world):
    """(facts, apply(world, size)) of an effect, drawn once and applied to any path of the cell; size 1 is an ordinary amount."""
    return _DRAWS[name](rng, world.command, rng.permutation(6))


def _frame(attribute, left):
    def drawn(rng, command, arm):
        v = np.r_[rng.normal(0, 4e-4, 3), rng.normal(0, 3.5e-4, 3)]
        if attribute == "table":
            v[[2, 5]] = 0.0

        def apply(w, s):
            old = getattr(w, attribute)
            setattr(w, attribute, rigid(s * v) @ old if left else old @ rigid(s * v))

        return {}, apply

    return drawn


def _joint_offset(rng, command, arm):
    axes = arm[: rng.integers(1, 3)]
    value = rng.choice([-1, 1], len(axes)) * rng.uniform(0.5, 1.5, len(axes)) * 0.04 * DEG
    return {"axes": [AXES[a] for a in axes]}, lambda w, s: shift(w, axes, s * value)


def _geometry(rng, command, arm):
    d = rng.normal(0, 1, (6, 3)) * np.array([1.5e-4, 2e-4, 2e-4])

    def apply(w, s):
        for i in range(6):
            for k in range(3):
                w.rows[i][k] += s * d[i, k]

    return {}, apply


def _track(rng, command, arm):
    scale, bow, other = rng.normal(0, 2e-4), rng.normal(0, 2.5e-4, 2), rng.random() < _OTHER

    def apply(w, s):
        e = w.command[:, 6]
        if other:
            w.after[:, [0, 2]] += s * (np.cos(np.pi * e / 0.8) - 1.0)[:, None] * bow
            return
        w.after[:, 1] += s * scale * e
        for k, axis in enumerate((0, 2)):
            w.after[:, axis] += s * bow[k] * (e / 0.5) ** 2

    return {}, apply


def _lean(rng, command, arm):
    c = rng.uniform(0.5, 2) * 1.5e-7 * np.array([1, rng.uniform(0.7, 1.4), 0])
    other = rng.random() < _OTHER

    def apply(w, s):
        reach = reach_of(w)
        moved = 1.5e3 * np.stack([-reach[:, 1], reach[:, 0], 0 * reach[:, 0]], 1) if other else w.context["moment"]
        w.lean = (0 if w.lean is None else w.lean) + s * c * moved

    return {}, apply


def _joint_compliance(rng, command, arm):
    c = np.exp(rng.normal(0, 0.4, 6)) * 3e-6 * (rng.random(6) < 0.6)
    c[rng.integers(1, 3)] = 3e-6
    axes = [AXES[k] for k in range(6) if c[k] > 0]
    return {"among": axes}, lambda w, s: shift(w, slice(0, 6), s * c * w.context["torque"])


def _payload(rng, command, arm):
    c = np.exp(rng.normal(0, 0.4, 6)) * 3e-6 * rng.choice([-1, 1]) * 5.0
    return {}, lambda w, s: shift(w, slice(0, 6), s * c * w.context["payload"])


def _backlash(rng, command, arm):
    axes = [a for a in arm if np.ptp(command[:, a]) > 3 * DEG][: rng.integers(1, 3)]
    width = rng.uniform(0.5, 1.5, len(axes)) * 0.03 * DEG

    def apply(w, s):
        for a, b in zip(axes, width, strict=True):
            shift(w, a, play(w.command[:, a] + w.drive[:, a], s * b))

    return {"axes": [AXES[a] for a in axes]}, apply


def _servo_lag(rng, command, arm):
    tau = rng.uniform(0.02, 0.05) * np.ones(8)
    if rng.random() < _OTHER:
        tau *= np.r_[rng.uniform(0.7, 1.3, 6), 0, 0]

    def apply(w, s):
        u, share = w.command, STEP / (STEP + s * tau)
        y = u[0] - s * tau * (u[1] - u[0]) / STEP
        for i in range(len(u)):
            y = y + share * (u[i] - y)
            w.drive[i] += y - u[i]

    return {}, apply


def _acceleration_error(rng, command, arm):
    each = rng.uniform(0.3, 2.0, 6) if rng.random() < _OTHER else np.ones(6)

    def apply(w, s):
        a = smooth(np.gradient(np.gradient(w.command, STEP, axis=0), STEP, axis=0), 9)
        shift(w, slice(0, 6), -s * 3e-4 * each * a[:, :6])

    return {}, apply


def _friction(rng, command, arm):
    axes = arm[: rng.integers(2, 5)]
    f = rng.uniform(0.5, 1.5, len(axes)) * 0.006 * DEG
    speed = np.abs(np.gradient(command, STEP, axis=0))
    usual, most, other = speed.mean(axis=0), speed.max(axis=0), rng.random() < _OTHER

    def apply(w, s):
        v = np.gradient(w.command, STEP, axis=0)
        for a, b in zip(axes, f, strict=True):
            if other:
                w.drive[:, a] -= s * b * np.tanh(v[:, a] / (0.1 * usual[a] + 1e-9))
                continue
            stribeck = 1 + 0.3 * np.exp(-np.abs(v[:, a]) / (0.1 * most[a] + 1e-9))
            w.drive[:, a] -= s * b * np.tanh(v[:, a] / (0.02 * usual[a] + 1e-9)) * stribeck

    return {"axes": [AXES[a] for a in axes]}, apply


def _gear_ripple(rng, command, arm):
    axis = next((a for a in arm if np.ptp(command[:, a]) > 12 * DEG), 0)
    span = np.ptp(command[:, axis])
    order, ph = rng.uniform(2.2 * 2 * np.pi / span, 8 * 2 * np.pi / span), rng.uniform(0, 6.28, 2)
    once = int(rng.integers(1, 3)) if rng.random() < 0.5 * _OTHER else 0

    def apply(w, s):
        x = w.command[:, axis]
        if once:  # an eccentric encoder
            shift(w, axis, s * 0.03 * DEG * np.sin(once * x + ph[0]))
            return
        shift(w, axis, s * 0.01 * DEG * (np.sin(order * x + ph[0]) + 0.1 * np.sin(2 * order * x + ph[1])))

    return {"axes": [AXES[axis]]}, apply


def _wrist_coupling(rng, command, arm):
    k = rng.normal(0, 1e-3, 3)

    def apply(w, s):
        shift(w, 4, s * k[0] * w.command[:, 3])
        shift(w, 5, s * (k[1] * w.command[:, 3] + k[2] * w.command[:, 4]))

    return {}, apply


def _thermal_drift(rng, command, arm):
    growth, other = 1.5e-5 * rng.uniform(0.6, 1.4, 6), rng.random() < _OTHER
    v = rng.normal(0, 2e-5, 3)

    def apply(w, s):
        if other:  # what the robot stands on moves
            w.after += s * w.context["warm"][:, None] * v
            return
        for i in range(6):
            w.after += s * growth[i] * w.context["warm"][:, None] * w.context["growth"][i]

    return {}, apply


def _latency(rng, command, arm):
    return {}, lambda w, s: setattr(w, "delay", w.delay + s * 0.01)


def _cutting_force(rng, command, arm):
    c = np.exp(rng.normal(0, 0.4, 6)) * 4e-6
    spring = np.exp(rng.normal(0, 0.4, 3)) * 1e-6 if rng.random() < _OTHER else None

    def apply(w, s):
        if spring is None:
            shift(w, slice(0, 6), s * c * w.context["force"])
        else:
            w.after += s * spring * w.context["pushed"]

    return {}, apply


def _early_reading(rng, command, arm):
    share, uneven = 2e-4, rng.uniform(0.9, 1.1, 8)

    def apply(w, s):
        before = np.zeros_like(w.command)
        before[1:] = w.command[:-1] - w.command[1:]
        shift(w, slice(0, 8), s * share * uneven * before)

    return {}, apply


def _bent_axis(rng, command, arm):
    i, j = rng.choice(3, 2, replace=False)
    low, width, cubic = command[:, j].min(), np.ptp(command[:, j]), rng.random() < 0.5

    def apply(w, s):
        x = np.clip(2 * (w.command[:, j] - low) / width - 1, -1.5, 1.5)
        shift(w, i, s * 0.01 * DEG * (x**2 * np.sign(x) if cubic else np.exp(-8 * x**2)))

    return {"axes": [AXES[i]]}, apply


def _rack_pitch(rng, command, arm):
    pitch = np.ptp(command[:, 6]) / rng.uniform(3, 7)

    def apply(w, s):
        w.after[:, 1] += s * 1e-4 * np.sin(2 * np.pi * w.command[:, 6] / pitch)

    return {"axes": ["E1"]}, apply


def _slip(rng, command, arm):
    at, v = rng.uniform(0.3, 0.7), rng.normal(0, 1e-4, 3)
    return {}, lambda w, s: setattr(w, "after", w.after + s * v * (w.t > at * w.t[-1])[:, None])


def _hose(rng, command, arm):
    taut = np.quantile(command[:, 3] + 0.5 * command[:, 5], 0.55)

    def apply(w, s):
        pull = np.maximum(0, w.command[:, 3] + 0.5 * w.command[:, 5] - taut)
        shift(w, [3, 4], s * 1e-3 * np.outer(pull, [1, 0.6]))

    return {"axes": ["A4", "A5"]}, apply


def _vibration(rng, command, arm):
    f, v = rng.uniform(0.4, 1.2), rng.normal(0, 1e-4, 3)
    return {}, lambda w, s: setattr(w, "after", w.after + s * v * np.sin(2 * np.pi * f * w.t)[:, None])


def _wrist_curve(rng, command, arm):
    middle = np.median(command[:, 4])
    return {"axes": ["A6"]}, lambda w, s: shift(w, 5, s * 1e-3 * (w.command[:, 4] - middle) ** 2)


def _loose_tool(rng, command, arm):
    """The tool tips over in its seat as the flange turns past a posture."""
    past, v = np.median(command[:, 5]), rng.normal(0, 1e-4, 3)
    return {}, lambda w, s: setattr(w, "after", w.after + s * v * np.tanh((w.command[:, 5] - past) / 0.02)[:, None])


def _creep(rng, command, arm):
    """An axis settles slowly into each posture, as belts and rubber do."""
    axis, tau = int(rng.integers(0, 3)), rng.uniform(2.0, 6.0)

    def apply(w, s):
        u, y = w.command[:, axis], np.empty(len(w.command))
        y[0] = u[0]
        for k in range(1, len(u)):
            y[k] = y[k - 1] + STEP / tau * (u[k] - y[k - 1])
        shift(w, axis, 1e-2 * s * (y - u))

    return {"axes": [AXES[axis]]}, apply


_DRAWS = {
    "frame_base": _frame("base", True),
    "frame_tool": _frame("tool", False),
    "frame_table": _frame("table", True),
    "measurement_frame": _frame("instrument", True),
    "joint_offset": _joint_offset,
    "geometry": _geometry,
    "track": _track,
    "lean": _lean,
    "joint_compliance": _joint_compliance,
    "payload": _payload,
    "backlash": _backlash,
    "servo_lag": _servo_lag,
    "acceleration_error": _acceleration_error,
    "friction": _friction,
    "gear_ripple": _gear_ripple,
    "wrist_coupling": _wrist_coupling,
    "thermal_drift": _thermal_drift,
    "latency": _latency,
    "cutting_force": _cutting_force,
    "early_reading": _early_reading,
    "bent_axis": _bent_axis,
    "rack_pitch": _rack_pitch,
    "slip": _slip,
    "hose": _hose,
    "vibration": _vibration,
    "wrist_curve": _wrist_curve,
    "loose_tool": _loose_tool,
    "creep": _creep,
}
