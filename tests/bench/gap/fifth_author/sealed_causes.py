"""SEALED's causes, each otherwise than DEV has it; sizes are those of data sheets and papers at strength 1."""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import cont2discrete, lfilter

from gap.fifth_author.machine import grown, pull, rail_axes
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["KNOWN", "catalogue_spring"]


def catalogue_spring(torque, soft, knee):
    """Wind-up of a gear whose catalogue has two stiffnesses: `soft` (Nm/rad) up to `knee` (Nm), 1.5 times that beyond."""
    small = np.clip(torque, -knee, knee)
    return small / soft + (torque - small) / (1.5 * soft)


def payload(s, rng, strength):
    """A part is picked up and put down while the load data of the empty gripper stay, or the centre that was typed in is that of
    another gripper. The gears wind up by two stiffnesses, the hand's plate bends.
    """
    robot = s.robot
    stiff = np.array(robot.stiffness) * rng.uniform(0.8, 1.25, len(robot.arm))
    knee = np.array([np.abs(np.concatenate([r.load[:, i] for r in s.runs])).max() for i in robot.arm]) * 0.5 + 1.0
    plate = strength / (3.0 * robot.stiffness[-1])
    mass, centre = (
        float(robot.rated * rng.uniform(0.25, 0.6)),
        np.array([*rng.uniform(-50, 50, 2), rng.uniform(60, 180)]),
    )
    picked, period = rng.random() < 0.5, rng.uniform(0.15, 0.35)  # the period a share of the log
    if not picked:
        shift = rng.normal(size=3)
        shift *= rng.uniform(60, 140) * (robot.rated / 20) ** 0.3 / np.linalg.norm(shift)

    def torque(run):
        if not picked:
            told = np.array(robot.bodies[-1].centre)
            return pull(run, robot.payload, told + shift) - pull(run, robot.payload, told)
        held = ((run.t / run.t[-1] / period + 0.25) % 1.0 < 0.5).astype(float)
        return pull(run, mass, centre) * held[:, None]

    def link(run):
        more = strength * torque(run)
        return axis_delta(
            run,
            {
                i: catalogue_spring(run.load[:, i] + more[:, i], stiff[k], knee[k])
                - catalogue_spring(run.load[:, i], stiff[k], knee[k])
                for k, i in enumerate(robot.arm)
            },
        )

    def between(run):
        turn = np.zeros((len(run.t), 6))
        turn[:, 5] = plate * torque(run)[:, robot.arm[-1]] * 0.5
        return {2 + robot.arm[-1]: turn}

    params = {"mass_kg": mass} if picked else {f"centre_{a}_mm": float(v) for a, v in zip("xyz", shift, strict=True)}
    return Cause("payload", BODY, [], params, ["load", "position"], link=link, between=between)


def compliance(s, rng, strength):
    """Gears wind up softly at first, then stiffly, and their output bearings tilt under what lies across them."""
    robot = s.robot
    stiff = np.array(robot.stiffness) * rng.uniform(0.75, 1.25, len(robot.arm)) / strength
    knee = np.array([np.quantile(np.abs(s.runs[0].load[:, i]), 0.6) + 0.5 for i in robot.arm])

    def link(run):
        return axis_delta(
            run, {i: catalogue_spring(run.load[:, i], stiff[k], knee[k]) for k, i in enumerate(robot.arm)}
        )

    def between(run):
        out = {}
        for k, i in enumerate(robot.arm[:3]):
            lower = 2 + i - 1 if i else 1
            out[lower] = np.zeros((len(run.t), 6))
            out[lower][:, 3:5] = run.moments[:, i, :2] / (6.0 * stiff[k])
        return out

    params = {f"{robot.names[i]}_rad_per_Nm": float(1 / stiff[k]) for k, i in enumerate(robot.arm)}
    axes = [robot.names[i] for i in robot.arm]
    return Cause("joint_compliance", BODY, axes, params, ["load", "position"], link=link, between=between)


def rail(s, rng, strength):
    """A rail whose bed has settled: long bows, and the wandering of a straight edge as a random walk; it twists.

    Racks of half a metre are butted with gaps and each has its own pitch; the pinion pushes aside of the middle, so that the
    carriage yaws with the direction in which it came.
    """
    robot = s.robot
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    along, aside, up = rail_axes(robot)
    low, high = row.low * 1e-3, row.high * 1e-3
    x = np.linspace(low - 0.05, high + 0.05, 400)
    size = strength * min(1.0, (high - low) / 3.0) ** 0.5

    def wander(rms):
        walk = np.cumsum(rng.normal(size=len(x)))
        walk -= np.polyval(np.polyfit(x, walk, 1), x)
        smooth = np.convolve(np.pad(walk, 20, mode="edge"), np.hanning(41) / 20, mode="valid")
        return rms * smooth / (smooth.std() + 1e-12)

    bow = strength * rng.choice([-1, 1], 2) * rng.uniform(6e-5, 2.2e-4, 2) * (high - low) / 4
    u = (x - (low + high) / 2) / (high - low) * 2
    lift, shift = wander(4e-5 * size) - bow[0] * u**2, wander(3e-5 * size) - bow[1] * (u**2 - 0.4 * u**3)
    pitch, yaw, roll = np.gradient(lift, x), np.gradient(shift, x), wander(5e-5 * size) + 6e-5 * size * u
    seams = np.arange(low - 0.1, high + 0.6, 0.5 if high - low > 1 else 0.12)
    pitches = rng.choice([-1, 1]) * rng.uniform(2e-5, 8e-5) + rng.normal(size=len(seams)) * 4e-5
    steps = rng.normal(size=len(seams)) * 1e-5
    error = (
        cumulative_trapezoid(pitches[np.searchsorted(seams, x) - 1], x, initial=0.0)
        + np.cumsum(steps)[np.searchsorted(seams, x) - 1]
    )
    rack, push = strength * (error - np.interp((low + high) / 2, x, error)), strength * rng.uniform(0, 2.5e-5)

    def link(run):
        return axis_delta(run, {i: np.interp(run.c[:, i], x, rack)})

    def between(run):
        at = run.c[:, i]
        p, y, r, h, w = (np.interp(at, x, f) for f in (pitch, yaw, roll, lift, shift))
        came = np.sign(run.came[:, i]) if run.rest else np.tanh(run.v[:, i] / 0.01)
        turn = np.outer(p, aside) - np.outer(y + push * came, up) + np.outer(r, along)
        return {2 + i: np.hstack([np.outer(h, up) + np.outer(w, aside), turn])}

    params = {"scale_ppm": float(np.polyfit(x, rack, 1)[0] * 1e6)}
    return Cause("track", BODY, [robot.names[i]], params, ["position"], link=link, between=between)


def thermal(s, rng, strength):
    """Two nodes an axis: a motor warms its gear, which warms the link; at the break both cool. Links grow, gears turn by
    their warmth, the pedestal follows the hall's day.
    """
    robot = s.robot
    n = len(robot.arm)
    power = rng.uniform(10, 24, n) * np.linspace(1, 0.7, n) * strength  # K that a gear would reach alone
    quick, slow = rng.uniform(8, 18, n) * 60, rng.uniform(40, 90, n) * 60
    zero = np.radians(rng.normal(size=n) * 3e-4)  # rad per K of the gear
    hall, tall = rng.uniform(2, 5) * strength, rng.uniform(0.5, 1.0)
    over = max(r.begins + r.t[-1] for r in s.runs) + 1
    clock = np.arange(0.0, over + 20, 20.0)
    works = np.ones(len(clock))
    for r in s.runs:
        pauses = np.flatnonzero(np.diff(r.t) > 1200) if r.rest else []
        for k in pauses:
            works[(clock > r.begins + r.t[k] + 60) & (clock < r.begins + r.t[k + 1])] = 0.15
    gear, link_ = np.empty((len(clock), n)), np.empty((len(clock), n))
    for k in range(n):
        one, two = np.exp(-20 / quick[k]), np.exp(-20 / slow[k])
        gear[:, k] = lfilter([0, 1 - one], [1, -one], power[k] * works)
        link_[:, k] = lfilter([0, 1 - two], [1, -two], 0.7 * gear[:, k])

    def at(run, table, k):
        return np.interp(run.clock, clock, table[:, k])

    def link(run):
        return axis_delta(run, {i: zero[k] * at(run, gear, k) for k, i in enumerate(robot.arm)})

    def between(run):
        out = {}
        for k, i in enumerate(robot.arm):
            grows = at(run, link_, k) * robot.metal
            out[2 + i] = np.hstack([np.outer(grows, grown(robot.rows[i])), np.zeros((len(run.t), 3))])
        day = hall * np.sin(np.pi * np.minimum(run.clock / 8 / 3600, 1.0))
        rise = np.zeros((len(run.t), 6))
        rise[:, 2] = day * tall * 11.5e-6
        out[0] = rise
        return out

    params = {f"{robot.names[i]}_K": float(power[k]) for k, i in enumerate(robot.arm)}
    cause = Cause("thermal_drift", BODY, [], params, ["time"], link=link, between=between)
    cause.temperature = lambda run: np.mean([at(run, gear, k) for k in range(n)], axis=0)
    return cause


def instrument_drift(s, rng, strength):
    """A camera on a mast: the sun that comes round bends the mast, and the camera's own warmth changes its scale."""
    mast = np.array([rng.uniform(-3, -2), rng.uniform(-1, 1), 2.5])
    bend, own = rng.normal(size=3) * 1.2e-5 * strength, strength * rng.choice([-1, 1]) * rng.uniform(1e-5, 4e-5)
    day = rng.uniform(3, 6) * 3600

    def measured(run, tool):
        sun, warm = np.sin(np.pi * run.clock / day), 1 - np.exp(-run.clock / 1500.0)
        far = tool[:, :3, 3] - mast
        out = tool.copy()
        out[:, :3, 3] += sun[:, None] * np.cross(bend, far) + (own * warm)[:, None] * far
        return out

    return Cause("measurement_drift", BODY, [], {}, ["time"], measured=measured)


def zeros(s, rng, strength):
    """A battery was empty: one to three axes were set again by the notch and the eye, the others stand as the maker left them."""
    many = int(rng.integers(1, 4))
    axes = sorted(int(i) for i in rng.choice(s.robot.arm, min(many, len(s.robot.arm)), replace=False))
    off = {i: np.radians(rng.choice([-1, 1]) * rng.uniform(0.03, 0.15) * strength) for i in axes}
    params = {s.key(i): s.told(i, v) for i, v in off.items()}
    return Cause(
        "joint_offset",
        BODY,
        [s.robot.names[i] for i in off],
        params,
        ["position"],
        link=lambda run: axis_delta(run, off),
    )


def geometry(s, rng, strength):
    """Level axes that are not quite parallel, a forearm of another batch, a hand with a worn centring."""
    robot = s.robot
    arm = robot.arm
    size = sum(abs(r.a) + abs(r.d) for r in robot.rows) / 3000
    rows = {arm[0]: np.array([0, 0, 0, *rng.normal(size=2) * 2.5e-4, 0])}
    second = arm[min(1, len(arm) - 1)]
    rows[second] = np.array([rng.choice([-1, 1]) * rng.uniform(2e-4, 5e-4) * size, 0, 0, 0, rng.normal() * 2e-4, 0])
    if len(arm) >= 6:
        rows[arm[3]] = np.concatenate([rng.normal(size=3) * 2.5e-4 * size, rng.normal(size=2) * 3e-4, [0]])

    def between(run):
        return {2 + i: strength * twist for i, twist in rows.items()}

    return Cause("geometry", BODY, [robot.names[i] for i in rows], {}, ["position"], between=between)


def base(s, rng, strength):
    """Shims: the foot stands higher at one side by some tenths, over the width of its plate."""
    plate = 1.2 * s.robot.size + 0.15
    shim = rng.uniform(1e-4, 4e-4) * strength
    way = rng.uniform(0, 2 * np.pi)
    twist = np.array(
        [*rng.normal(size=2) * 2e-4 * strength, shim / 2, np.cos(way) * shim / plate, np.sin(way) * shim / plate, 0]
    )
    return Cause("frame_base", BODY, [], {}, ["position"], between=lambda run: {0: twist})


def tool(s, rng, strength):
    """A spare tool that was built to the same drawing: longer, and its shank bent."""
    bend = rng.normal(size=2) * 8e-4 * strength
    length = np.linalg.norm(s.robot.tool[:3]) / 1e3
    twist = np.array([bend[1] * length / 2, -bend[0] * length / 2, rng.normal() * 3e-4 * strength, *bend, 0])
    return Cause("frame_tool", BODY, [], {}, ["position"], between=lambda run: {-1: twist})


def lag(s, rng, strength):
    """Axes behind their set-points as a second order of 12 to 30 Hz whose speed is fed forward nearly in full."""
    moving = s.moving()
    if not moving:
        raise ValueError("nothing moves")
    axes = sorted(int(i) for i in rng.choice(moving, int(rng.integers(1, len(moving) + 1)), replace=False))
    damp, fed = rng.uniform(0.6, 0.9), rng.uniform(0.6, 0.9)
    turn = {i: 2 * np.pi * rng.uniform(10, 25) for i in axes}

    def drive(run):
        out = {}
        for i, w in turn.items():
            b, a, _ = cont2discrete(([2 * damp * fed * w, w * w], [1, 2 * damp * w, w * w]), run.dt, "bilinear")
            off = lfilter(np.ravel(b), a, run.c[:, i] - run.c[0, i]) + run.c[0, i] - run.c[:, i]
            out[i] = strength * off
        return axis_delta(run, out)

    params = {f"{s.robot.names[i]}_s": float(strength * 2 * damp * (1 - fed) / w) for i, w in turn.items()}
    return Cause("servo_lag", DRIVE, [s.robot.names[i] for i in axes], params, ["speed"], drive=drive)


def friction(s, rng, strength):
    """A loop without an integrator: dry friction and the oil's, which gets thinner as the morning goes on, stand as an offset."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    axes = sorted(int(i) for i in rng.choice(moving, min(len(moving), int(rng.integers(1, 3))), replace=False))
    dry = {i: np.radians(rng.uniform(0.003, 0.009)) * strength for i in axes}
    oil, thin = rng.uniform(0.5, 1.2), rng.uniform(900, 2400)

    def drive(run):
        out, thick = {}, 0.5 + 0.5 * np.exp(-run.clock / thin)
        for i, size in dry.items():
            share = run.v[:, i] / (s.robot.rows[i].speed * s.robot.unit[i])
            out[i] = -size * (np.tanh(share / 0.004) + oil * thick * np.sign(share) * np.abs(share) ** 0.6)
        return axis_delta(run, out)

    params = {s.key(i): s.told(i, v) for i, v in dry.items()}
    return Cause("friction", DRIVE, [s.robot.names[i] for i in axes], params, ["direction"], drive=drive)


def backlash(s, rng, strength):
    """A gear of two stages, each with its play: the first is taken up by little, the second by the rest."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    axes = sorted(int(i) for i in rng.choice(moving, min(len(moving), int(rng.integers(1, 3))), replace=False))
    whole = {
        i: np.radians(rng.uniform(0.012, 0.04) * (1 if s.robot.arm.index(i) < 3 else 1.5)) * strength for i in axes
    }
    first = rng.uniform(0.2, 0.5)

    def link(run):
        out = {}
        for i, size in whole.items():
            lag_, at = np.zeros(len(run.t)), run.c[:, i]
            for share, wide in ((first, 0.3 * size / 2), (1 - first, size / 2)):
                state, seen = 0.0, np.empty(len(at))
                for k, step in enumerate(np.diff(at, prepend=at[0])):
                    state = max(-wide, min(wide, state + step))
                    seen[k] = state
                lag_ -= share * seen / wide * size / 2
            out[i] = lag_
        return axis_delta(run, out)

    params = {s.key(i): s.told(i, v) for i, v in whole.items()}
    return Cause("backlash", BODY, [s.robot.names[i] for i in axes], params, ["direction"], link=link)


def lean(s, rng, strength):
    """A frame that is weak one way: it tilts about one level line only, and is pushed aside as it tilts."""
    give, way = strength / (s.robot.foot * rng.uniform(0.4, 0.9)), rng.uniform(0, np.pi)
    line, first, high = np.array([np.cos(way), np.sin(way), 0.0]), s.robot.arm[0], rng.uniform(0.3, 0.8)

    def between(run):
        tilt = give * (run.moments[:, first, :3] @ line)
        return {s.robot.root: np.hstack([np.outer(tilt, np.cross(line, [0, 0, 1.0])) * high, np.outer(tilt, line)])}

    return Cause("lean", BODY, [], {}, ["load", "position"], between=between)


def clocks(s, rng, strength):
    """A network in between: stamps are late by a fixed time and what the cycle adds to it, from row to row."""
    late, cycle = strength * rng.uniform(0.006, 0.04), rng.choice([0.0, 0.004, 0.008])

    def delay(run):
        return late + cycle * ((run.t / 0.0137) % 1.0 - 0.5)

    return Cause("latency", BODY, [], {"latency_s": float(late)}, ["speed"], late=delay)


def turned_back(s, rng, strength):
    """A gear's steel gives a closed loop between torque and wind-up: many springs that slip one after the other."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    i = int(rng.choice(moving))
    size, reaches = np.radians(rng.uniform(0.006, 0.02)) * strength, np.radians([0.05, 0.2, 0.8, 3.0])

    def link(run):
        out, at = np.zeros(len(run.t)), run.c[:, i]
        for reach in reaches:
            state = 0.0
            for k, step in enumerate(np.diff(at, prepend=at[0]) / reach):
                state += (np.sign(step) - state) * (1 - np.exp(-abs(step)))
                out[k] -= size / len(reaches) * state
        return axis_delta(run, {i: out})

    return Cause("hysteresis", BODY, [s.robot.names[i]], {s.key(i): s.told(i, size)}, ["direction"], link=link)


def _of(name, make, *needs):
    return Description(name, make, frozenset(needs))


KNOWN = {
    d.name: d
    for d in (
        _of("payload", payload, "tracker", "wrist"), _of("joint_compliance", compliance, "tracker", "wrist"),
        _of("track", rail, "tracker", "track"), _of("thermal_drift", thermal, "tracker"),
        _of("measurement_drift", instrument_drift, "tracker", "frame_known"), _of("joint_offset", zeros, "tracker"),
        _of("geometry", geometry, "tracker"), _of("frame_base", base, "tracker", "frame_known"),
        _of("frame_tool", tool, "tracker", "target_known"), _of("servo_lag", lag, "path", "setpoints"),
        _of("friction", friction, "path", "setpoints"), _of("backlash", backlash, "tracker"), _of("lean", lean, "tracker"),
        _of("latency", clocks, "path", "tracker"), _of("hysteresis", turned_back, "tracker"),
    )
}  # fmt: skip
