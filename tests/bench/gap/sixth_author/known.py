"""Causes with a name, each by a physics of either family: `second` chooses the one that SEALED has."""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter, lfilter_zi
from scipy.spatial.transform import Rotation

from gap.sixth_author.chain import Body
from gap.sixth_author.world import Cause

DEG = np.pi / 180


def _some(rng, machine, least=1, most=2, among=None):
    among = machine.turning if among is None else among
    count = min(len(among), int(rng.integers(least, most + 1)))
    return sorted(rng.choice(among, count, replace=False).tolist())


def _names(machine, axes):
    return tuple(machine.names[k] for k in axes)


def _only(run, columns):
    """(N, n) with some columns filled."""
    out = np.zeros_like(run.c)
    for k, x in columns.items():
        out[:, k] = x
    return out


def _lag(tau, dt):
    """A first order's filter that is exact for straight pieces, however short its time is."""
    p = np.exp(-dt / tau)
    hold = (1 - p) * tau / dt
    return np.array([1 - hold, hold - p]), np.array([1, -p])


def _spread(rng, count):
    return rng.uniform(0.5, 1.0, count) * rng.choice([-1, 1], count)


def frame_base(machine, rng, second):
    """A foot set by a drawing (shift and turn), or shims under it (tilt, little shift)."""
    size = np.r_[
        1e-3 * rng.normal(size=3) * (0.2 if second else 1), 6e-4 * rng.normal(size=3) * ([1, 1, 0.1] if second else 1)
    ]
    return Cause("frame_base", params={"twist": size}, shape=lambda run, m, g: ({"world": g * size}, {}))


def frame_tool(machine, rng, second):
    """A tool measured by a needle (three numbers), or a bent one (a turn about a point before the plate)."""
    if second:
        lean = 2e-3 * np.r_[rng.normal(size=2), 0]
        arm = np.array([0, 0, rng.uniform(0.1, 0.25)])
        size = np.r_[np.cross(lean, arm), lean]
    else:
        size = np.r_[6e-4 * rng.normal(size=3), 0, 0, 0]
    return Cause("frame_tool", params={"twist": size}, shape=lambda run, m, g: ({"tip": g * size}, {}))


def frame_table(machine, rng, second):
    """The table's axis stands elsewhere and leans."""
    size = np.r_[5e-4 * rng.normal(size=3), 4e-4 * rng.normal(size=2), 0]
    return Cause("frame_table", ("E2",), params={"twist": size}, shape=lambda run, m, g: ({"table": g * size}, {}))


def joint_offset(machine, rng, second):
    """One to three zeros off; a crash moves two neighbours."""
    axes = _some(rng, machine, 1, 3)
    if second and len(machine.turning) > 1:
        k = int(rng.integers(len(machine.turning) - 1))
        axes = machine.turning[k : k + 2]
    size = _spread(rng, len(axes)) * 0.05 * DEG
    return Cause(
        "joint_offset",
        _names(machine, axes),
        params={"rad": size},
        link=lambda run, m, g: _only(run, {k: g * x for k, x in zip(axes, size, strict=True)}),
    )


def geometry(machine, rng, second):
    """Every row by its tolerance, or axes of the arm's middle that are not parallel and one link of another length."""
    rows = {}
    for k in machine.arm:
        if not second or rng.random() < 0.4:
            rows |= {
                (k, "a"): 2e-4 * rng.normal(),
                (k, "alpha"): 1.2e-4 * rng.normal(),
                (k, "beta"): 8e-5 * rng.normal(),
            }
        if not second or rng.random() < 0.3:
            rows[k, "d"] = 2e-4 * rng.normal()
    if not rows:
        rows = {(machine.arm[-1], "a"): 3e-4}
    told = {f"{machine.names[k]} {n}": x for (k, n), x in rows.items()}
    return Cause("geometry", params=told, shape=lambda run, m, g: ({}, {k: g * x for k, x in rows.items()}))


def _rail(machine):
    """The carriage's joint, and world's axes along, aside, up as seen in its end frame."""
    k = machine.index("E1")
    zero = np.zeros((1, len(machine.joints)))
    before, after, _ = machine.frames(machine.still(zero + np.array(machine.home) * machine.unit))
    along = before[k][0, :3, 2] * machine.joints[k].sign
    up = np.array([0, 0, 1.0]) if abs(along[2]) < 0.9 else np.array([1.0, 0, 0])
    aside = np.cross(up, along)
    return k, after[k][0, :3, :3].T @ np.stack([along, aside, up], 1)


def track(machine, rng, second):
    """A rail that bows (carriage follows its slope) with a scale, or one on supports, twisted, its rack butted of pieces."""
    k, axes = _rail(machine)
    j = machine.joints[k]
    half, middle = machine.swing[k] * j.unit, machine.home[k] * j.unit
    scale, (bow, twist) = 2e-4 * rng.normal(), rng.normal(size=(2, 3))
    phase, pieces = rng.uniform(0, 6, 3), np.cumsum(1.2e-4 * rng.normal(size=60))
    apart, part = rng.uniform(0.35, 0.8) * min(1, half / 0.7), rng.uniform(0.25, 0.5) * min(1, half / 0.7)

    def shape(run, m, g):
        s = (m[run.rows, k] - middle) / half
        move, turn = np.zeros((len(s), 3)), np.zeros((len(s), 3))
        if second:
            x = (m[run.rows, k] - middle) / apart * np.pi
            move[:, 0] = pieces[np.clip(30 + np.floor((m[run.rows, k] - middle) / part), 0, 59).astype(int)]
            move[:, 2] = -3e-4 * np.sin(x + phase[0]) ** 2
            move[:, 1] = 1e-4 * bow[1] * np.sin(0.37 * x + phase[1])
            turn[:, 0] = 1.5e-4 * twist[0] * s + 6e-5 * twist[1] * np.sin(x + phase[2])
        else:
            move[:, 0] = scale * half * s
            for i in (1, 2):
                move[:, i] = 2.5e-4 * (bow[i] * (s**2 - 0.3) + 0.7 * twist[i] * (s**3 - 0.6 * s))
                slope = 2.5e-4 / half * (bow[i] * 2 * s + 0.7 * twist[i] * (3 * s**2 - 0.6))
                turn[:, 3 - i] = (1 if i == 1 else -1) * slope
        return {k: g * np.concatenate([move @ axes.T, turn @ axes.T], 1)}, {}

    return Cause("track", ("E1",), params={"scale": scale}, shape=shape)


def turntable(machine, rng, second):
    """A bearing that wobbles and runs out once a turn, or twice, with an eccentric encoder and a lag by direction."""
    w, e, f, enc = 1.5e-4 * rng.normal(size=2), 2e-4 * rng.normal(size=2), rng.uniform(0, 6.3, 3), 1.5e-4 * rng.normal()
    order = 2 if second else 1

    def shape(run, m, g):
        q = m[run.rows, 0]
        out = np.zeros((len(q), 6))
        out[:, 0], out[:, 1] = e[0] * np.cos(order * q + f[0]), e[0] * np.sin(order * q + f[0])
        out[:, 3], out[:, 4] = w[0] * np.cos(q + f[1]), w[1] * np.sin(q + f[1])
        if second:
            out[:, 2] = e[1] * np.sin(2 * q + f[2])
            out[:, 5] = enc * np.sin(q + f[0]) + 4e-5 * _follow(run.c[:, 0], 0.03)[run.rows]
        return {"table": g * out}, {}

    return Cause("turntable", ("E2",), params={"wobble_rad": w, "runout_m": e[0]}, shape=shape)


def _follow(x, width):
    """-1 to 1: what lags behind x by a path of `width`."""
    out, z, last = np.zeros(len(x)), 0.0, float(x[0])
    for i, now in enumerate(x.tolist()):
        step, last = (now - last) / width, now
        z = min(1.0, max(-1.0, z + step))
        out[i] = z
    return out


def joint_compliance(machine, rng, second):
    """Gears as springs under gravity; or softer at small loads, as cycloids are."""
    loaded = [
        k for k in machine.turning if abs(machine.load((np.array(machine.home) * machine.unit)[None])[0, k]) > 0.5
    ]
    axes = _some(rng, machine, 1, 3, loaded or machine.turning)
    soft = {k: rng.uniform(0.3, 1.2) / machine.stiff[k] for k in axes}

    def link(run, m, g):
        out = {}
        for k, c in soft.items():
            load = run.load[:, k]
            knee = 0.3 * np.abs(load).max() + 1e-9
            out[k] = g * c * (load + (0.6 * knee * np.tanh(load / knee) if second else 0.0))
        return _only(run, out)

    return Cause("joint_compliance", _names(machine, axes), params={"rad_per_Nm": list(soft.values())}, link=link)


def payload(machine, rng, second):
    """The tool is heavier or lighter than told; or as heavy, with its centre elsewhere. The arm's own springs give."""
    last = machine.names[machine.arm[-1]]
    tool = machine.bodies[-1].centre
    if second:
        far = np.array(tool) + machine.reach * rng.normal(size=3) * [40, 40, 60]
        extra = (Body(last, machine.payload, tuple(far)), Body(last, -machine.payload, tool))
    else:
        extra = (Body(last, 0.4 * machine.payload * rng.choice([1, 1, -0.7]), tool),)
    told = {"kg": [b.mass for b in extra], "mm": [list(b.centre) for b in extra]}

    def link(run, m, g):
        return g * run.load_of(extra) / np.array(machine.stiff) * (np.array([j.role == "arm" for j in machine.joints]))

    return Cause("payload", params=told, link=link, torque=lambda run, m, g: -g * run.load_of(extra))


def lean(machine, rng, second):
    """A pedestal that gives alike to all sides, or a frame that is weak one way."""
    k = machine.foot
    give = (
        (np.array([1, 0.1, 0.02]) if second else np.array([1, 0.8, 0.05]))
        * 0.1
        / max(machine.stiff[i] for i in machine.turning)
    )
    if second and rng.random() < 0.5:
        give = give[[1, 0, 2]]

    def shape(run, m, g):
        moment = machine.foot_moment(run.c[run.rows])
        return {k: g * np.concatenate([np.zeros_like(moment), moment * give], 1)}, {}

    return Cause("lean", params={"rad_per_Nm": give}, shape=shape)


def backlash(machine, rng, second):
    """Play that the motor crosses on turning back; or a link that its load leans on one flank until the load turns."""
    axes = _some(rng, machine, 1, 2)
    width = {k: machine.play * DEG * rng.uniform(0.7, 2) for k in axes}

    def link(run, m, g):
        out = {}
        for k, w in width.items():
            half = g * w / 2
            x = -half * _follow(m[:, k], half + 1e-12)
            if second:
                drag = 0.25 * np.abs(run.load[:, k]).max() + 1e-9
                hold = np.clip(np.abs(run.load[:, k]) / drag - 0.5, 0, 1)
                x = (1 - hold) * x + hold * half * np.sign(run.load[:, k])
            out[k] = x
        return _only(run, out)

    return Cause(
        "backlash", _names(machine, axes), follows=("direction",), params={"rad": list(width.values())}, link=link
    )


def hysteresis(machine, rng, second):
    """Dahl's friction within the gear, or five springs that slip one after the other."""
    axes = _some(rng, machine, 1, 2)
    size = machine.play * DEG * rng.uniform(0.6, 1.5)
    reach = rng.uniform(1, 4) * DEG

    def link(run, m, g):
        out = {}
        for k in axes:
            if second:
                x = sum(_follow(m[:, k], reach * f) for f in (0.1, 0.3, 0.7, 1.4, 2.5)) / 5
            else:
                x, z = np.zeros(len(m)), 0.0
                for i, step in enumerate(np.diff(m[:, k], prepend=m[0, k]).tolist()):
                    z += step / reach * (1 - z * (1 if step > 0 else -1)) if step else 0.0
                    x[i] = z
            out[k] = -g * size * x
        return _only(run, out)

    return Cause("hysteresis", _names(machine, axes), follows=("direction",), params={"rad": size}, link=link)


def servo_lag(machine, rng, second):
    """First order by axis; or second order with part of the speed fed forward."""
    tau = 0.012 * rng.uniform(0.85, 1.15, len(machine.joints))
    omega, ahead = 2 * np.pi * rng.uniform(9, 20), rng.uniform(0.4, 0.8)

    def drive(run, m, g):
        out = np.zeros_like(m)
        for k in range(m.shape[1]):
            if second:
                w = omega / max(g, 1e-3)
                b, a = bilinear([1.4 * w * ahead, w * w], [1, 1.4 * w, w * w], 1 / run.dt)
            else:
                b, a = _lag(g * tau[k], run.dt)
            zi = lfilter_zi(b, a) * m[0, k]
            out[:, k] = lfilter(b, a, m[:, k], zi=zi)[0] - m[:, k]
        return out

    told = {"rad_per_s": omega, "fed_forward": ahead} if second else {"s": tau}
    return Cause("servo_lag", tuple(machine.names), "setpoint_to_encoder", ("speed",), told, drive=drive)


def friction(machine, rng, second):
    """LuGre's bristles with Stribeck's peak before a loop that integrates; or dry and oil's by load, with a spike on turning."""
    axes = _some(rng, machine, 1, 2)
    size, ti = 0.012 * DEG * rng.uniform(0.6, 2), rng.uniform(0.1, 0.5)

    def way(run, m, k):
        v = np.gradient(m[:, k], run.dt)
        slow = 0.02 * (np.abs(v).max() + 1e-12) + 0.002
        z, kept, out = 0.0, 0.0, np.zeros(len(v))
        load = 0.5 + 0.5 * np.abs(run.load[:, k]) / (np.abs(run.load[:, k]).max() + 1e-9)
        for i, x in enumerate(v.tolist()):
            if second:
                force = load[i] * (np.tanh(x / slow) + 0.15 * x / (np.abs(v[i]) + 0.3))
            else:
                top = 1 + 0.5 * np.exp(-((x / (6 * slow)) ** 2))
                z += run.dt * (x - abs(x) * z / top) / (3e-4)
                z = min(top, max(-top, z))
                force = z
            kept += (force - kept) * run.dt / ti
            out[i] = force - 0.8 * kept
        return out

    def drive(run, m, g):
        return _only(run, {k: -g * size * way(run, m, k) for k in axes})

    def torque(run, m, g):
        return _only(run, {k: 0.1 * g * np.abs(run.needed[:, k]).max() * np.tanh(run.v[:, k] / 0.01) for k in axes})

    told = {"rad": size, "s": ti}
    return Cause(
        "friction",
        _names(machine, axes),
        "setpoint_to_encoder",
        ("direction", "speed"),
        told,
        drive=drive,
        torque=torque,
    )


def setpoint_delay(machine, rng, second):
    """One or two axes get their set-points late; or late by whole cycles of a bus that beats with the drive's."""
    axes = _some(rng, machine, 1, 2, list(range(len(machine.joints))))
    late, beat = rng.uniform(0.006, 0.016), rng.uniform(5, 20)

    def drive(run, m, g):
        wait = g * late
        if second:
            wait = wait * (1 + 0.3 * np.sign(np.sin(2 * np.pi * run.t / beat)))
        return _only(run, {k: np.interp(run.t - wait, run.t, m[:, k]) - m[:, k] for k in axes})

    return Cause("setpoint_delay", _names(machine, axes), "setpoint_to_encoder", ("speed",), {"s": late}, drive=drive)


def motor_commutation(machine, rng, second):
    """An angle of the windings that is off: a ripple at the poles' pitch; at speed the loop no longer holds it."""
    turning = [k for k in machine.turning if machine.gears[k] > 20]
    axes = _some(rng, machine, 1, 1, turning)
    (k,) = axes
    order, size, phase = 0.2 * machine.gears[k], 0.006 * DEG * rng.uniform(1, 2), rng.uniform(0, 6.3)

    def drive(run, m, g):
        x = np.sin(order * m[:, k] + phase) + 0.3 * np.sin(2 * order * m[:, k] + 2 * phase)
        if second:
            p = np.exp(-run.dt / 0.12)
            x = lfilter([p, -p], [1, -p], x) + 0.25 * x
        return _only(run, {k: g * size * x})

    told = {"rad": size, "a_turn": order}
    return Cause("motor_commutation", _names(machine, axes), "setpoint_to_encoder", ("position",), told, drive=drive)


def acceleration_error(machine, rng, second):
    """Gears wound up by what they accelerate; or a link on its spring that rings behind the motor."""
    size = np.array([3.0e-4 if j.role == "arm" else 0.0 for j in machine.joints]) * rng.uniform(
        0.4, 1.2, len(machine.joints)
    )

    def link(run, m, g):
        out = np.zeros_like(m)
        for k in np.flatnonzero(size):
            if second:
                w = 1 / np.sqrt(g * size[k])
                b, a = bilinear([0.16 * w, w * w], [1, 0.16 * w, w * w], 1 / run.dt)
                out[:, k] = lfilter(b, a, m[:, k] - m[0, k]) - (m[:, k] - m[0, k])
            else:
                out[:, k] = -g * size[k] * run.a[:, k]
        return out

    return Cause("acceleration_error", follows=("acceleration",), params={"s2": size}, link=link)


def gear_ripple(machine, rng, second):
    """A strain wave or cycloid: twice and four times a motor's turn; or an encoder eccentric behind the gear."""
    axes = _some(rng, machine, 1, 2)
    size, phase = machine.play * DEG * rng.uniform(0.5, 1.3), rng.uniform(0, 6.3, 2)
    order = {k: (1.0 if second else round(machine.gears[k] / 8) if machine.gears[k] > 20 else 6.0) for k in axes}

    def link(run, m, g):
        out = {}
        for k in axes:
            x = order[k] * m[:, k]
            out[k] = g * size * (np.sin(x + phase[0]) + 0.35 * np.sin(2 * x + phase[1])) * (4 if second else 1)
        return _only(run, out)

    told = {"rad": size, "a_turn": list(order.values())}
    return Cause("gear_ripple", _names(machine, axes), follows=("position",), params=told, link=link)


def wrist_coupling(machine, rng, second):
    """The wrist's axes turn each other through their bevels; or a little by the square as well."""
    a, b, c = machine.turning[-3:]
    one, two = 8e-4 * _spread(rng, 2)

    def link(run, m, g):
        x = {c: g * one * m[:, b], b: g * two * m[:, a]}
        if second:
            x = {c: g * one * (m[:, b] + 0.4 * m[:, b] ** 2)}
        return _only(run, x)

    axes = (c,) if second else (b, c)
    return Cause(
        "wrist_coupling", _names(machine, axes), follows=("position",), params={"ratio": [one, two]}, link=link
    )


def thermal_drift(machine, rng, second):
    """Links grow with the castings' warmth, each by its share; or gears turn by the motors', links later."""
    share, turn = rng.uniform(0.4, 1.0, len(machine.joints)), 1.5e-4 * rng.normal(size=len(machine.joints))
    grow = 2.4e-4

    def shape(run, m, g):
        motor, casting = run.heat.T
        out = {}
        for k in machine.arm:
            j = machine.joints[k]
            warm = casting if second else 0.6 * casting + 0.4 * motor
            for n, x in (("a", j.a), ("d", j.d)):
                if x and not (j.slides and n == "d"):
                    out[k, n] = g * grow * share[k] * x / 1e3 * warm
            if second and not j.slides:
                out[k, "theta"] = g * turn[k] * motor
        return {}, out

    return Cause("thermal_drift", follows=("time",), params={"a_kelvin_times_kelvin": grow}, shape=shape)


def cutting_force(machine, rng, second):
    """The cut pushes: joints give by the arm's springs; or spindle and holder do."""
    axes = [k for k in machine.turning]
    soft, tip = 0.6 / np.array(machine.stiff), rng.uniform(0.6, 1.5, 3) * 5e-7 * [1, 1, 0.15]

    def shape(run, m, g):
        force = np.zeros((len(run.rows), 3)) if run.force is None else run.force
        if second:
            local = np.einsum("nji,nj->ni", run.nominal[:, :3, :3], force)
            return {"tip": g * np.concatenate([local * tip, np.zeros_like(local)], 1)}, {}
        torque = np.einsum("nik,ni->nk", machine.jacobian(run.c[run.rows])[:, :3], force)
        return {}, {(k, "theta"): g * soft[k] * torque[:, k] * machine.joints[k].sign for k in axes}

    return Cause("cutting_force", follows=("load",), params={"by": "spindle" if second else "joints"}, shape=shape)


def latency(machine, rng, second):
    """The instrument's stamps are late or early; or also drift against the controller's clock."""
    late, ppm = 0.012 * rng.choice([-1, 1]), 6e-5 * rng.normal()
    return Cause(
        "latency",
        follows=("speed",),
        params={"s": late, "a_second": ppm if second else 0.0},
        late=lambda run, m, g: g * (late + (ppm * run.at if second else 0.0)),
    )


def early_reading(machine, rng, second):
    """All poses are read before the arm has come; or one axis creeps in late."""
    if second:
        (k,) = _some(rng, machine, 1, 1)
        tau = rng.uniform(0.35, 0.6)

        def link(run, m, g):
            b, a = _lag(tau * min(g, 3.0), run.dt)
            return _only(run, {k: lfilter(b, a, m[:, k], zi=lfilter_zi(b, a) * m[0, k])[0] - m[:, k]})

        return Cause("early_reading", _names(machine, [k]), follows=("direction",), params={"s": tau}, link=link)
    return Cause(
        "early_reading", follows=("direction",), params={"s": 0.06}, late=lambda run, m, g: -(0.9 + min(0.06 * g, 0.6))
    )


def measurement_scale(machine, rng, second):
    """Lengths read too long, from where the instrument stands."""
    stand, ppm = np.array([-3.5, 2.0, 1.2]) + rng.normal(size=3), 2e-4 * rng.choice([-1, 1])

    def seen(run, tip, g):
        return g * ppm * (tip[:, :3, 3] - stand)

    return Cause("measurement_scale", stage="instrument", follows=("position",), params={"ratio": ppm}, seen=seen)


def measurement_drift(machine, rng, second):
    """The stand creeps as a logarithm; or a mast bends with the hall's warmth and turns the beam."""
    way, turn, stand = (
        2e-4 * rng.normal(size=3),
        5e-5 * rng.normal(size=3),
        np.array([-4.0, 2.5, 1.4]) + rng.normal(size=3),
    )

    def seen(run, tip, g):
        t = run.begins + run.clock
        if second:
            angle = g * turn * np.sin(2 * np.pi * t / 9000.0)[:, None]
            p = tip[:, :3, 3] - stand
            return Rotation.from_rotvec(angle).apply(p) - p
        return g * way * np.log1p(t / 300.0)[:, None]

    return Cause("measurement_drift", stage="instrument", follows=("time",), params={"m": way, "rad": turn}, seen=seen)


MAKERS = {
    f.__name__: f
    for f in (
        frame_base,
        frame_tool,
        frame_table,
        joint_offset,
        geometry,
        track,
        turntable,
        joint_compliance,
        payload,
        lean,
        backlash,
        hysteresis,
        servo_lag,
        friction,
        setpoint_delay,
        motor_commutation,
        acceleration_error,
        gear_ripple,
        wrist_coupling,
        thermal_drift,
        cutting_force,
        latency,
        early_reading,
        measurement_scale,
        measurement_drift,
    )
}
# how many times the sizes above a cause may be: beyond that no machine would have passed its acceptance
MOST = {
    "frame_base": 8, "frame_tool": 8, "frame_table": 6, "joint_offset": 12, "geometry": 5, "track": 4, "turntable": 5,
    "joint_compliance": 3, "payload": 2, "lean": 8, "backlash": 5, "hysteresis": 6, "servo_lag": 4, "friction": 5,
    "setpoint_delay": 4, "motor_commutation": 5, "acceleration_error": 4, "gear_ripple": 3, "wrist_coupling": 4,
    "thermal_drift": 1.6, "cutting_force": 5, "latency": 5, "early_reading": 8, "measurement_scale": 4, "measurement_drift": 5,
}  # fmt: skip
