"""Causes that the contract has names for, of the sizes that papers and data sheets give; each in the unit of its axis.

A description is `make(setting, rng, strength) -> Cause`; sizes are drawn, and `strength` multiplies them (1 in the family).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.fourth_author.machines import STIFFNESS
from gap.second_author.chain import Body, small
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["KNOWN", "compliance_of", "dahl", "play"]


def compliance_of(robot):
    """rad/Nm by axis (n,), none of slides."""
    kind = {"arm_6": "light", "arm_20": "middle", "arm_60": "strong", "arm_200": "heavy"}.get(robot.name, "kr15")
    out = np.zeros(len(robot.rows))
    out[robot.arm] = 1.0 / np.array(STIFFNESS[kind])
    return out


def _per(setting, axes, sizes, what=""):
    return {setting.key(i, what): setting.told(i, s) for i, s in zip(axes, sizes, strict=True)}


def _names(setting, axes):
    return [setting.names[i] for i in axes]


def joint_offset(setting, rng, strength):
    """Mastering with a gauge repeats to some hundredths of a degree, worse at the wrist."""
    axes = setting.robot.arm[1:]
    sizes = strength * np.radians(rng.normal(0, 0.03, len(axes)) * np.where(np.arange(len(axes)) < 2, 1.0, 1.6))
    add = dict(zip(axes, sizes, strict=True))
    return Cause("joint_offset", BODY, _names(setting, axes), _per(setting, axes, sizes), ["position"],
                 link=lambda run: axis_delta(run, {i: np.full(len(run.t), s) for i, s in add.items()}))  # fmt: skip


def geometry(setting, rng, strength):
    """Castings are machined to some tenths of a mm, axes are square to a hundredth of a degree."""
    twists = {}
    for i in setting.robot.arm[:5]:
        turn = np.radians(rng.normal(0, 0.008, 2))
        twists[2 + i] = strength * np.array([*rng.normal(0, 1.5e-4, 3), *turn, 0.0])
    return Cause("geometry", BODY, _names(setting, setting.robot.arm[:5]), {}, ["position"], between=lambda run: twists)


def joint_compliance(setting, rng, strength):
    """Gears wind up in proportion to gravity's torque; the controller knows nothing of it."""
    soft = strength * compliance_of(setting.robot) * rng.uniform(0.7, 1.4, len(setting.names))
    axes = setting.robot.arm
    told = {f"{setting.names[i]}_rad_per_Nm": float(soft[i]) for i in axes}
    return Cause("joint_compliance", BODY, _names(setting, axes), told, ["load"], link=lambda run: run.load * soft)


def payload(setting, rng, strength):
    """A controller that takes sag off for the mass that it was told; the true one is another, so that the rest stays."""
    robot = setting.robot
    wrong = strength * robot.payload * rng.uniform(0.3, 0.8) * rng.choice([-1.0, 1.0])
    extra, soft = Body("A6", wrong, (*rng.uniform(-30, 30, 2), rng.uniform(50, 150))), compliance_of(robot)

    def link(run):
        return (robot.moments(run.c, (extra,))[:, :, 2] * robot.signs - run.load) * soft

    return Cause("payload", BODY, _names(setting, robot.arm), {"payload_kg": float(wrong)}, ["load"], link=link)


def play(c, half):
    """Where a link is that is carried along by a fork of half-width `half` (N,)."""
    out = np.empty_like(c)
    now = c[0]
    for k, x in enumerate(c):
        now = min(max(now, x - half), x + half)
        out[k] = now
    return out


def backlash(setting, rng, strength):
    """Worn teeth of axes that carry no weight: the link stays half the play behind."""
    robot = setting.robot
    axes = setting.arm(rng, 2, [robot.arm[k] for k in (0, 3, 4, 5)])
    sizes = strength * np.radians(rng.uniform(0.006, 0.03, len(axes)))

    def link(run):
        return axis_delta(run, {i: play(run.c[:, i], s / 2) - run.c[:, i] for i, s in zip(axes, sizes, strict=True)})

    return Cause(
        "backlash", BODY, _names(setting, axes), _per(setting, axes, sizes), ["direction", "position"], link=link
    )


def dahl(c, reach):
    """Dahl's state, -1 to 1: a bristle that yields gently over `reach`."""
    state, out = 0.0, np.empty_like(c)
    for k, step in enumerate(np.diff(c, prepend=c[0]) / reach):
        way = np.sign(step)
        state = way + (state - way) * np.exp(-abs(step))  # d(state) = (way - state) |dx|: exact within a step
        out[k] = state
    return out


def hysteresis(setting, rng, strength):
    """A strain-wave gear's loop of lost motion: about an arc minute, turned over within some degrees."""
    axes = setting.arm(rng, 2)
    sizes = strength * np.radians(rng.uniform(0.006, 0.018, len(axes)))
    reach = np.radians(rng.uniform(1.0, 4.0))

    def link(run):
        return axis_delta(run, {i: -s * dahl(run.c[:, i], reach) for i, s in zip(axes, sizes, strict=True)})

    return Cause("hysteresis", BODY, _names(setting, axes), _per(setting, axes, sizes), ["direction"], link=link)


def gear_ripple(setting, rng, strength):
    """Strain waves err twice a turn of the wave generator, and a third as much once."""
    axes, ratio = setting.arm(rng, 2), int(rng.choice([50, 80, 100, 120]))
    sizes, phase = strength * np.radians(rng.uniform(0.003, 0.009, len(axes))), rng.uniform(0, 6.28, 2)

    def link(run):
        waves = {}
        for i, s in zip(axes, sizes, strict=True):
            turn = ratio * run.c[:, i]
            waves[i] = s * (np.sin(2 * turn + phase[0]) + 0.33 * np.sin(turn + phase[1]))
        return axis_delta(run, waves)

    return Cause("gear_ripple", BODY, _names(setting, axes), _per(setting, axes, sizes), ["position"], link=link)


def motor_commutation(setting, rng, strength):
    """Torque that wavers with the motor's electric angle; what the loop leaves of it, at the encoder."""
    axes, order = setting.arm(rng, 2), int(rng.choice([3, 4, 5])) * int(rng.choice([80, 100, 120]))
    sizes, phase = strength * np.radians(rng.uniform(0.0008, 0.003, len(axes))), rng.uniform(0, 6.28)

    def drive(run):
        parts = {}
        for i, s in zip(axes, sizes, strict=True):
            fast = order * np.abs(run.v[:, i])
            parts[i] = s * np.sin(order * run.c[:, i] + phase) * (fast > 0) / np.hypot(1.0, fast / 250.0)
        return axis_delta(run, parts)

    return Cause(
        "motor_commutation", DRIVE, _names(setting, axes), _per(setting, axes, sizes), ["position"], drive=drive
    )


def friction(setting, rng, strength):
    """Coulomb's and viscous torque against a slow integrator: an offset by direction that fades in 0.1 to 1 s."""
    axes = setting.arm(rng, 3)
    sizes = strength * np.radians(rng.uniform(0.001, 0.006, len(axes)))
    tau = rng.uniform(0.1, 1.0)

    def drive(run):
        parts, keep = {}, np.exp(-run.dt / tau)
        for i, s in zip(axes, sizes, strict=True):
            torque = np.tanh(run.v[:, i] / 0.002) + 0.3 * run.v[:, i]
            parts[i] = -s * lfilter([1.0, -1.0], [1.0, -keep], torque)
        return axis_delta(run, parts)

    return Cause(
        "friction", DRIVE, _names(setting, axes), _per(setting, axes, sizes), ["direction", "speed"], drive=drive
    )


def servo_lag(setting, rng, strength):
    """A position loop of 20 to 60 a second with most of the speed fed forward: a first-order lag of some ms."""
    n = len(setting.names)
    tau = strength * np.full(n, rng.uniform(0.002, 0.012)) * (1 + rng.choice([0.0, 0.25]) * rng.uniform(-1, 1, n))

    def drive(run):
        out = np.empty_like(run.c)
        for i in range(n):
            keep = tau[i] / (tau[i] + run.dt)  # behind a ramp by tau, whatever the step
            out[:, i] = lfilter([1 - keep], [1, -keep], run.c[:, i] - run.c[0, i]) + run.c[0, i] - run.c[:, i]
        return out

    told = {f"{name}_s": float(x) for name, x in zip(setting.names, tau, strict=True)}
    return Cause("servo_lag", DRIVE, list(setting.names), told, ["speed"], drive=drive)


def setpoint_delay(setting, rng, strength):
    """One axis on a slower bus gets its set-points one to five cycles of 4 ms late."""
    (i,), late = setting.arm(rng), strength * 0.004 * int(rng.integers(1, 6))

    def drive(run):
        return axis_delta(run, {i: np.interp(run.t - late, run.t, run.c[:, i]) - run.c[:, i]})

    return Cause("setpoint_delay", DRIVE, _names(setting, [i]), {f"{setting.names[i]}_s": late}, ["speed"], drive=drive)


def acceleration_error(setting, rng, strength):
    """The gear's wind-up by the inertia of what it carries: mass times reach squared over stiffness."""
    robot, axes = setting.robot, setting.robot.arm[:3]
    mass, reach = (
        sum(b.mass for b in robot.bodies),
        float(np.linalg.norm(setting.runs[0].tip[0, :3, 3] - robot.base[:3, 3])),
    )
    sizes = strength * rng.uniform(0.6, 1.4) * 0.4 * mass * min(reach, 2.5) ** 2 * compliance_of(robot)[axes]
    told = {f"{setting.names[i]}_s2": float(s) for i, s in zip(axes, sizes, strict=True)}

    def link(run):
        return axis_delta(run, {i: -s * run.a[:, i] for i, s in zip(axes, sizes, strict=True)})

    return Cause("acceleration_error", BODY, _names(setting, axes), told, ["acceleration"], link=link)


def cutting_force(setting, rng, strength):
    """The cut's force winds the gears up."""
    soft = strength * compliance_of(setting.robot) * rng.uniform(0.8, 1.5)

    def link(run):
        return np.einsum("nij,ni->nj", run.jacobian[0], run.force) * soft

    return Cause("cutting_force", BODY, _names(setting, setting.robot.arm), {}, ["load"], link=link)


def _frame(name, where, length, angle, needs):
    """A small frame at a place: `length` m and `angle` degrees, each of a direction."""

    def make(setting, rng, strength):
        twist = strength * np.array([*rng.normal(0, length, 3), *np.radians(rng.normal(0, angle, 3))])
        return Cause(name, BODY, [], {}, ["position"], between=lambda run: {where: twist})

    return Description(name, make, frozenset(needs))


def wrist_coupling(setting, rng, strength):
    """A coupling entered a little wrong: A5 and A6 turn along with the axes before them."""
    a4, a5, a6 = setting.robot.arm[3:]
    k = strength * rng.uniform(2e-4, 1e-3, 2) * rng.choice([-1.0, 1.0], 2)

    def link(run):
        return axis_delta(run, {a5: k[0] * run.c[:, a4], a6: k[1] * run.c[:, a5]})

    return Cause("wrist_coupling", BODY, _names(setting, [a5, a6]), {}, ["position"], link=link)


def early_reading(setting, rng, strength):
    """Read 0.3 s after the stop while the loop still creeps in: a share of the last move is left."""
    share = strength * rng.uniform(1e-4, 6e-4)

    def drive(run):
        return -share * run.came

    return Cause("early_reading", DRIVE, list(setting.names), {}, ["direction"], drive=drive)


def thermal_drift(setting, rng, strength):
    """Steel and iron links grow with their warmth: 11.5 ppm/K of up to 20 K, more near the motors."""
    robot, tau = setting.robot, rng.uniform(600, 2400)
    grow = {}
    for i in robot.arm[:4]:
        row, kelvin, turn = robot.rows[i], rng.uniform(5, 20), np.radians(robot.rows[i].alpha)
        link = np.array([row.a, row.d * np.sin(turn), row.d * np.cos(turn), 0, 0, 0]) / 1e3  # in the frame at its end
        grow[2 + i] = strength * 11.5e-6 * kelvin * link

    def between(run):
        warm = 1 - np.exp(-run.clock / tau)
        return {where: warm[:, None] * twist for where, twist in grow.items()}

    return Cause("thermal_drift", BODY, _names(setting, robot.arm[:4]), {"tau_s": tau}, ["time"], between=between)


def lean(setting, rng, strength):
    """Foot and anchors give: some microradians for each Nm that the arm hangs over."""
    robot = setting.robot
    soft = strength * 0.35 * compliance_of(robot)[robot.arm[1]] * rng.uniform(0.5, 1.2, 2)

    def between(run):
        m = run.moments[:, robot.arm[0]]
        zero = np.zeros(len(m))
        return {robot.root: np.stack([zero, zero, zero, soft[0] * m[:, 0], soft[1] * m[:, 1], zero], 1)}

    return Cause("lean", BODY, [], {}, ["load", "position"], between=between)


def track(setting, rng, strength):
    """A rail's straightness of a tenth of a mm in waves of a metre or two, and a rack that is long by parts in 1e4."""
    robot = setting.robot
    i = robot.carriage[-1]
    wave, long = strength * rng.uniform(5e-5, 2e-4, 2), strength * rng.uniform(5e-5, 2e-4) * rng.choice([-1, 1])
    period, phase = rng.uniform(0.9, 2.2, 2), rng.uniform(0, 6.28, 2)

    def between(run):
        s, zero = run.c[:, i], np.zeros(len(run.t))
        side = [w * np.sin(6.2832 * s / p + f) for w, p, f in zip(wave, period, phase, strict=True)]
        # behind the row's quarter turn the rail runs along y of the foot
        return {2 + i: np.stack([side[0], long * s, side[1], zero, zero, zero], 1)}

    return Cause("track", BODY, [setting.names[i]], {}, ["position"], between=between)


def frame_table(setting, rng, strength):
    """The table's axis was found from a few points: off by tenths of a mm and hundredths of a degree."""
    wrong = small(strength * np.array([*rng.normal(0, 3e-4, 2), 0, *np.radians(rng.normal(0, 0.03, 2)), 0]))[0]

    def on_table(run, tool):
        turn = _turns(run)
        return turn @ wrong @ turn.transpose(0, 2, 1) @ tool

    return Cause("frame_table", BODY, [setting.robot.table], {}, ["position"], on_table=on_table)


def _turns(run):
    cos, sin = np.cos(run.table), np.sin(run.table)
    out = np.zeros((len(cos), 4, 4))
    out[:, 0, 0], out[:, 0, 1], out[:, 1, 0], out[:, 1, 1] = cos, -sin, sin, cos
    out[:, 2, 2] = out[:, 3, 3] = 1.0
    return out


def turntable(setting, rng, strength):
    """A plate that runs out and wobbles once a turn."""
    out, tilt, phase = (
        strength * rng.uniform(2e-5, 1e-4),
        strength * np.radians(rng.uniform(0.004, 0.02)),
        rng.uniform(0, 6.28),
    )

    def on_table(run, tool):
        cos, sin, zero = np.cos(run.table + phase), np.sin(run.table + phase), np.zeros(len(tool))
        return small(np.stack([out * cos, out * sin, zero, tilt * sin, -tilt * cos, zero], 1)) @ tool

    return Cause("turntable", BODY, [setting.robot.table], {}, ["position"], on_table=on_table)


def measurement_scale(setting, rng, strength):
    """A tracker told the wrong air (a ppm for each K), or a scale bar that was not: 15 to 120 ppm of the way to it."""
    ppm = strength * rng.uniform(15, 120) * rng.choice([-1.0, 1.0])
    stand = np.array([*(rng.uniform(2.5, 4.0, 2) * rng.choice([-1, 1], 2)), 1.2])

    def measured(run, tool):
        out = tool.copy()
        out[:, :3, 3] = stand + (1 + ppm * 1e-6) * (tool[:, :3, 3] - stand)
        return out

    return Cause("measurement_scale", BODY, [], {"scale_ppm": ppm}, ["position"], measured=measured)


def measurement_drift(setting, rng, strength):
    """A tripod that settles while the session goes on: a tenth of a mm, fast at first."""
    way, tau = strength * rng.normal(0, 5e-5, 3), rng.uniform(300, 1500)

    def measured(run, tool):
        out = tool.copy()
        out[:, :3, 3] += np.outer(1 - np.exp(-run.clock / tau), way)
        return out

    return Cause("measurement_drift", BODY, [], {}, ["time"], measured=measured)


def latency(setting, rng, strength):
    """Two clocks started by hand or by a trigger: the instrument's runs some ms behind."""
    late = strength * rng.uniform(0.004, 0.06)
    return Cause("latency", BODY, [], {"latency_s": late}, ["speed"], late=lambda run: np.full(len(run.t), late))


def _known(make, *needs):
    return Description(make.__name__, make, frozenset(needs))


KNOWN = {
    d.name: d
    for d in (
        *(
            _known(make, "tracker")
            for make in (joint_offset, geometry, joint_compliance, payload, backlash, hysteresis)
        ),
        *(_known(make, "tracker") for make in (gear_ripple, wrist_coupling, thermal_drift, lean)),
        *(_known(make, "tracker") for make in (measurement_scale, measurement_drift)),
        *(_known(make, "path", "setpoints") for make in (servo_lag, friction, setpoint_delay, motor_commutation)),
        *(_known(make, "path", "tracker") for make in (acceleration_error, latency)),
        _known(cutting_force, "tracker", "force"),
        _known(early_reading, "poses", "setpoints"),
        _known(track, "tracker", "track"),
        _known(frame_table, "tracker", "table"),
        _known(turntable, "tracker", "table"),
        _frame("frame_base", 0, 8e-4, 0.03, ("tracker", "frame_known")),
        _frame("frame_tool", -1, 4e-4, 0.05, ("tracker", "target_known")),
    )
}
