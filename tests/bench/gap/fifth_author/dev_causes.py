"""DEV's causes, each as one text has it; sizes are those of data sheets and papers at strength 1."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from gap.fifth_author.machine import grown, pull, rail_axes
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["KNOWN", "played_through"]

ARCSEC = np.pi / 180 / 3600


def payload(s, rng, strength):
    """A controller takes the sag of what it was told off; what hangs there is heavier or lighter, or further out.

    In a third of the cases the log before it was made with what was told, and a tool was changed since.
    """
    robot = s.robot
    share = float(rng.choice([-1, 1]) * rng.uniform(0.25, 0.7) * strength)
    mass = share * robot.payload if share < 0 else share * max(robot.payload, 0.5 * robot.rated)
    centre = np.array([*rng.uniform(-40, 40, 2), rng.uniform(40, 160)]) * (robot.rated / 20) ** 0.3
    give = 1.0 / np.array(robot.stiffness) * rng.uniform(0.8, 1.25, len(robot.arm))
    mass, changed = max(mass, -0.9 * robot.payload), len(s.runs) > 2 and rng.random() < 0.5
    first = s.runs[0]

    def link(run):
        if changed and run is first:
            return np.zeros_like(run.c)
        more = pull(run, mass, centre)
        return axis_delta(run, {i: more[:, i] * give[k] for k, i in enumerate(robot.arm)})

    params = {"mass_kg": float(mass), **{f"centre_{a}_mm": float(v) for a, v in zip("xyz", centre, strict=True)}}
    return Cause("payload", BODY, [], params, ["load", "position"], link=link)


def compliance(s, rng, strength):
    """Torsion springs at the joints under links and payload."""
    robot = s.robot
    give = strength / np.array(robot.stiffness) * rng.uniform(0.75, 1.3, len(robot.arm))

    def link(run):
        return axis_delta(run, {i: run.load[:, i] * give[k] for k, i in enumerate(robot.arm)})

    params = {f"{robot.names[i]}_rad_per_Nm": float(give[k]) for k, i in enumerate(robot.arm)}
    axes = [robot.names[i] for i in robot.arm]
    return Cause("joint_compliance", BODY, axes, params, ["load", "position"], link=link)


def rail(s, rng, strength):
    """A rail sags between its supports and was aligned by points; the carriage stands on two pairs of bogies.

    Its height is the bogies' mean, its pitch and yaw their difference over the wheelbase; the rack was cut a little long and its
    pinion runs out.
    """
    robot = s.robot
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    _, aside, up = rail_axes(robot)
    span, wheels = rng.uniform(0.8, 1.2), rng.uniform(0.5, 0.9)
    knots = np.arange(row.low * 1e-3 - 1.5, row.high * 1e-3 + 1.5, span)
    height, side = (CubicSpline(knots, rng.normal(size=len(knots)) * rms * strength) for rms in (8e-5, 6e-5))
    sag = strength * rng.uniform(1e-5, 5e-5)
    scale, pinion = rng.choice([-1, 1]) * rng.uniform(4e-5, 1.5e-4) * strength, strength * rng.uniform(8e-6, 3e-5)
    lead, phase = rng.uniform(0.2, 0.4), rng.uniform(0, 6)

    def way(x):
        return height(x) - sag * (1 - np.cos(2 * np.pi * (x - knots[0]) / span))

    def link(run):
        x = run.c[:, i]
        return axis_delta(run, {i: scale * x + pinion * (np.sin(2 * np.pi * x / lead + phase) - np.sin(phase))})

    def between(run):
        front, back = run.c[:, i] + wheels / 2, run.c[:, i] - wheels / 2
        slope, yaw = (way(front) - way(back)) / wheels, (side(front) - side(back)) / wheels
        lift, shift = (way(front) + way(back)) / 2, (side(front) + side(back)) / 2
        turn = np.outer(slope, aside) - np.outer(yaw, up)
        return {2 + i: np.hstack([np.outer(lift, up) + np.outer(shift, aside), turn])}

    return Cause(
        "track", BODY, [robot.names[i]], {"scale_ppm": float(scale * 1e6)}, ["position"], link=link, between=between
    )


def thermal(s, rng, strength):
    """A morning from cold: each link takes its motor's heat in a time of its own and grows; the shoulder's warm side leans it."""
    robot = s.robot
    hot = rng.uniform(8, 20, len(robot.arm)) * np.linspace(1.0, 0.6, len(robot.arm)) * strength
    slow = rng.uniform(25, 60, len(robot.arm)) * 60.0
    lean = rng.uniform(2e-6, 6e-6, 2) * rng.choice([-1, 1], 2)

    def warmth(run, k):
        return hot[k] * (1 - np.exp(-run.clock / slow[k]))

    def between(run):
        out = {}
        for k, i in enumerate(robot.arm):
            out[2 + i] = np.hstack(
                [np.outer(warmth(run, k) * robot.metal, grown(robot.rows[i])), np.zeros((len(run.t), 3))]
            )
        out[2 + robot.arm[0]][:, 3:5] += np.outer(warmth(run, 1), lean)
        return out

    params = {f"{robot.names[i]}_K": float(hot[k]) for k, i in enumerate(robot.arm)}
    cause = Cause("thermal_drift", BODY, [], params, ["time"], between=between)
    cause.temperature = lambda run: np.mean([warmth(run, k) for k in range(len(robot.arm))], axis=0)
    return cause


def instrument_drift(s, rng, strength):
    """A tracker's stand settles as the logarithm of time and leans; seen from it, the whole room turns a little."""
    stand = np.array([*rng.choice([-1, 1], 2) * rng.uniform(2, 4, 2), 1.2])
    lean, sink = rng.normal(size=3) * 8e-6 * strength, np.array([0, 0, -1.0]) * rng.uniform(1e-5, 4e-5) * strength

    def measured(run, tool):
        share = np.log1p(run.clock / 600.0)
        out = tool.copy()
        out[:, :3, 3] += share[:, None] * (np.cross(lean, tool[:, :3, 3] - stand) - sink)
        return out

    return Cause("measurement_drift", BODY, [], {}, ["time"], measured=measured)


def zeros(s, rng, strength):
    """Mastered with a dial gauge: a few hundredths of a degree at each axis."""
    off = {i: np.radians(rng.normal() * (0.02 if k < 3 else 0.04) * strength) for k, i in enumerate(s.robot.arm)}
    params = {s.key(i): s.told(i, v) for i, v in off.items()}
    axes = [s.robot.names[i] for i in off]
    return Cause("joint_offset", BODY, axes, params, ["position"], link=lambda run: axis_delta(run, off))


def geometry(s, rng, strength):
    """Castings machined to tolerance: each row's link is longer, each bearing's seat leans."""
    size = sum(abs(r.a) + abs(r.d) for r in s.robot.rows) / 3000
    rows = {
        i: np.concatenate([rng.normal(size=3) * 1.2e-4 * size, rng.normal(size=2) * 1.2e-4, [0.0]]) for i in s.robot.arm
    }

    def between(run):
        return {2 + i: strength * twist for i, twist in rows.items()}

    return Cause("geometry", BODY, [s.robot.names[i] for i in rows], {}, ["position"], between=between)


def base(s, rng, strength):
    """The cell's drawing says where the foot stands, a surveyor found it half a millimetre away."""
    twist = np.concatenate([rng.normal(size=3) * 4e-4, rng.normal(size=3) * 4e-4]) * strength
    return Cause("frame_base", BODY, [], {}, ["position"], between=lambda run: {0: twist})


def tool(s, rng, strength):
    """A tip found by touching a needle four times."""
    twist = np.concatenate([rng.normal(size=3) * 3e-4, rng.normal(size=3) * 5e-4]) * strength
    return Cause("frame_tool", BODY, [], {}, ["position"], between=lambda run: {-1: twist})


def lag(s, rng, strength):
    """A position loop of gain Kv whose speed is fed forward in part: what is left is a first order behind the set-points."""
    moving = s.moving()
    if not moving:
        raise ValueError("nothing moves")
    axes = moving if rng.random() < 0.6 else [int(rng.choice(moving))]
    kv, fed = rng.uniform(25, 70), rng.uniform(0.7, 0.92)
    gone = {i: strength * (1 - fed) / kv * rng.uniform(0.85, 1.2) * (1 if len(axes) > 1 else 1.6) for i in axes}

    def drive(run):
        out = {}
        for i, tau in gone.items():
            keep = np.exp(-run.dt / tau)
            start = run.c[0, i]
            out[i] = start + lfilter([1 - keep], [1, -keep], run.c[:, i] - start) - run.c[:, i]
        return axis_delta(run, out)

    params = {f"{s.robot.names[i]}_s": float(v) for i, v in gone.items()}
    return Cause("servo_lag", DRIVE, [s.robot.names[i] for i in axes], params, ["speed"], drive=drive)


def friction(s, rng, strength):
    """Coulomb's, more under load as gears have it; the loop's integrator takes the offset off in its own time."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    axes = sorted(int(i) for i in rng.choice(moving, min(len(moving), int(rng.integers(1, 4))), replace=False))
    offset = {i: np.radians(rng.uniform(0.004, 0.014)) * strength for i in axes}
    more, tau = rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.6)

    def drive(run):
        out, keep = {}, np.exp(-run.dt / tau)
        for i in axes:
            heavy = np.abs(run.load[:, i]) / (np.abs(s.runs[0].load[:, i]).max() + 1e-9)
            push = np.tanh(run.v[:, i] / (0.002 * s.robot.rows[i].speed * s.robot.unit[i])) * (1 + more * heavy)
            out[i] = -offset[i] * lfilter([keep, -keep], [1, -keep], push)
        return axis_delta(run, out)

    params = {f"{s.robot.names[i]}_deg": s.told(i, v) for i, v in offset.items()}
    return Cause("friction", DRIVE, [s.robot.names[i] for i in axes], params, ["direction"], drive=drive)


def played_through(x, half):
    """Where a fork of half width `half` stands that a pin at x drags: it starts in the middle."""
    out, now = np.empty_like(x), x[0]
    half = np.broadcast_to(half, x.shape)
    for k, (at, h) in enumerate(zip(x, half, strict=True)):
        now = min(max(now, at - h), at + h)
        out[k] = now
    return out


def backlash(s, rng, strength):
    """A fork that a pin drags, wider on one side of the axis's range, where it worked most."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    axes = sorted(int(i) for i in rng.choice(moving, min(len(moving), int(rng.integers(1, 3))), replace=False))
    whole = {
        i: np.radians(rng.uniform(0.012, 0.035) * (1 if s.robot.arm.index(i) < 3 else 1.6)) * strength for i in axes
    }
    worn = rng.uniform(0, 0.3)

    def link(run):
        out = {}
        for i in axes:
            wide = whole[i] / 2 * (1 + worn * np.tanh((run.c[:, i] - run.c[:, i].mean()) / 0.3))
            out[i] = played_through(run.c[:, i], wide) - run.c[:, i]
        return axis_delta(run, out)

    params = {s.key(i): s.told(i, v) for i, v in whole.items()}
    return Cause("backlash", BODY, [s.robot.names[i] for i in axes], params, ["direction"], link=link)


def lean(s, rng, strength):
    """What the foot is bolted to tilts by gravity's moment over its stiffness, alike to all sides."""
    give = strength / (s.robot.foot * rng.uniform(0.7, 1.4))
    first = s.robot.arm[0]

    def between(run):
        turn = np.zeros((len(run.t), 6))
        turn[:, 3:5] = run.moments[:, first, :2] * give
        return {s.robot.root: turn}

    return Cause("lean", BODY, [], {"rad_per_Nm": float(give)}, ["load", "position"], between=between)


def clocks(s, rng, strength):
    """The tracker's stamps are late by a few of its cycles."""
    late = strength * rng.uniform(0.004, 0.03)
    return Cause("latency", BODY, [], {"latency_s": float(late)}, ["speed"], late=lambda run: np.full(len(run.t), late))


def ripple(s, rng, strength):
    """Twice a turn of the input, as gears' catalogues bound it."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    i = int(rng.choice(moving))
    size, phase = strength * rng.uniform(10, 30) * ARCSEC, rng.uniform(0, 6)

    def link(run):
        return axis_delta(run, {i: size * np.sin(2 * s.robot.ratio * run.c[:, i] + phase)})

    params = {f"{s.robot.names[i]}_order": 2.0 * s.robot.ratio, s.key(i): s.told(i, size)}
    return Cause("gear_ripple", BODY, [s.robot.names[i]], params, ["position"], link=link)


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
        _of("latency", clocks, "path", "tracker"), _of("gear_ripple", ripple, "path", "tracker"),
    )
}  # fmt: skip
