"""The sealed family's structure and instruments: bearings that tilt, rails in pieces, motors that warm, beams that bend."""

from __future__ import annotations

import numpy as np

from gap.second_author.chain import Body
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, Cause
from gap.second_author.sealed_drives import DRIVES


def softness(robot):
    """rad/Nm: the load at which an axis gives a ten-thousandth, from what hangs on it at home."""
    held = np.abs(robot.moments(np.array(robot.home) * robot.unit)[0]).max(axis=1) + 3.0
    return np.where(robot.slides, 0.0, 2e-4 / held)


def columns(run, **parts):
    """Twists (N, 6) by x, y, z, rx, ry, rz."""
    zero = np.zeros(len(run.t))
    return np.column_stack([parts.get(k, zero) + zero for k in ("x", "y", "z", "rx", "ry", "rz")])


def joint_offset(setting, rng, s):
    """One axis mastered on the wrong mark, or all of them by a gauge that reads wrong."""
    picked = setting.arm(rng) if rng.random() < 0.6 else setting.robot.arm
    off = {i: s * np.radians(0.02) * rng.normal() for i in picked}

    def link(run):
        return axis_delta(run, {i: np.full(len(run.t), x) for i, x in off.items()})

    params = {setting.key(i): setting.told(i, x) for i, x in off.items()}
    return Cause("joint_offset", BODY, [setting.names[i] for i in picked], params, ["position"], link=link)


def geometry(setting, rng, s):
    """Links as they were made: length, shift and twist of two rows off the drawing."""
    picked = setting.arm(rng, 2)
    made = {i: (1.2e-4 * rng.normal() * s, 1.2e-4 * rng.normal() * s, 2e-4 * rng.normal() * s) for i in picked}

    def between(run):
        return {2 + i: columns(run, x=a, y=d, rx=twist) for i, (a, d, twist) in made.items()}

    params = {setting.names[i]: [float(x) for x in w] for i, w in made.items()}
    return Cause("geometry", BODY, [], params, ["position"], between=between)


def frame_base(setting, rng, s):
    """Shims: the foot stands tilted about an edge, and was surveyed from another mark."""
    tilt, off = rng.normal(size=3) * 2e-4 * s, rng.normal(size=3) * 2e-4 * s
    twist = np.concatenate([off, tilt * np.array([1, 1, 0.5])])
    return Cause("frame_base", BODY, [], {"twist": twist.tolist()}, ["position"], between=lambda run: {0: twist[None]})


def frame_tool(setting, rng, s):
    """A tool bent in a crash, about its seat at the flange."""
    turn = rng.normal(size=3) * 1.5e-3 * s
    reach = np.array([0.0, 0.0, max(0.05, np.linalg.norm(setting.robot.tip[:3, 3]) * 0.7)])
    twist = np.concatenate([np.cross(turn, reach), turn])
    return Cause("frame_tool", BODY, [], {"twist": twist.tolist()}, ["position"], between=lambda run: {-1: twist[None]})


def track(setting, rng, s):
    """A rail in pieces of a metre, each laid with its own slope; the rack's pitch off."""
    i = setting.robot.carriage[-1]
    ends = np.arange(-3.2, 3.3, 1.0) + rng.uniform(0, 1)
    heights = rng.normal(size=(len(ends), 2)) * 1.5e-4 * s
    pitch = s * 1e-4 * rng.choice([-1, 1])

    def between(run):
        x, half = run.c[:, i], 0.35  # the carriage stands on two shoes
        side, up = (0.5 * (np.interp(x - half, ends, h) + np.interp(x + half, ends, h)) for h in heights.T)
        slope = (np.interp(x + half, ends, heights[:, 1]) - np.interp(x - half, ends, heights[:, 1])) / (2 * half)
        return {2 + i: columns(run, x=side, z=up, ry=slope)}

    def link(run):
        return axis_delta(run, {i: pitch * run.c[:, i]})

    return Cause(
        "track", BODY, [setting.names[i]], {"scale_ppm": pitch * 1e6}, ["position"], between=between, link=link
    )


def lean(setting, rng, s):
    """One anchor works: the foot tips towards it, by what overturns it that way, and sinks."""
    robot, toward = setting.robot, rng.uniform(0, 6.28)
    first = robot.arm[0]
    heavy = np.abs(setting.runs[0].moments[:, first]).max() + 1.0
    k = s * 2e-4 / heavy

    def between(run):
        over = np.cos(toward) * run.moments[:, first, 0] + np.sin(toward) * run.moments[:, first, 1]
        give = k * over * (1 + 0.15 * np.tanh(over / heavy))
        return {robot.root: columns(run, rx=np.cos(toward) * give, ry=np.sin(toward) * give)}

    return Cause("lean", BODY, [], {"rad_Nm": k}, ["load", "position"], between=between)


def joint_compliance(setting, rng, s):
    """Gears that are softer near no load, and bearings that tilt besides."""
    robot, base = setting.robot, softness(setting.robot)
    pool = [i for i in robot.arm if not robot.slides[i] and np.ptp(setting.runs[0].load[:, i]) > 0.3]
    picked = setting.arm(rng, 3, pool)
    soft = {i: s * base[i] * rng.uniform(0.6, 1.6) for i in picked}
    tilt, lost = rng.uniform(0, 0.25), rng.uniform(0.0, 0.3)

    def link(run):
        out = {}
        for i, c in soft.items():
            m = run.load[:, i]
            knee = 0.3 * np.abs(m).max() + 1e-6
            out[i] = c * (m + lost * knee * np.tanh(m / knee))
        return axis_delta(run, out)

    def between(run):
        return {2 + i: columns(run, rx=tilt * c * run.moments[:, i, 0]) for i, c in soft.items()}

    params = {f"{setting.names[i]}_rad_Nm": float(c) for i, c in soft.items()}
    return Cause(
        "joint_compliance",
        BODY,
        [setting.names[i] for i in picked],
        params,
        ["load", "position"],
        link=link,
        between=between,
    )


def payload(setting, rng, s):
    """A heavier or a lighter tool, its centre elsewhere: joints sag, and the hand bends."""
    robot, soft = setting.robot, softness(setting.robot)
    mass = s * 0.5 * robot.payload * rng.choice([-1, 1], p=[0.3, 0.7])
    extra = Body(robot.names[-1], mass, (rng.normal() * 50, rng.normal() * 50, rng.normal() * 100))

    def more(run):
        return robot.moments(run.c, (extra,)) - run.moments

    def link(run):
        return soft * more(run)[:, :, 2] * robot.signs

    def between(run):
        last = len(robot.rows) - 1
        return {1 + last: columns(run, ry=0.2 * soft[last] * more(run)[:, last, 1])}

    return Cause("payload", BODY, [], {"payload_kg": mass}, ["load", "position"], link=link, between=between)


def thermal_drift(setting, rng, s):
    """Each motor warms its own casting in its own time; the column bends away from the warm side."""
    robot = setting.robot
    slow = {i: float(np.exp(rng.uniform(np.log(80), np.log(1500)))) for i in robot.arm}
    grow = {i: s * 1.1e-5 * rng.uniform(2, 14) for i in robot.arm}
    bow = s * 2.5e-5 * rng.normal()

    def between(run):
        out, first = {}, robot.arm[0]
        for i in robot.arm:
            w = 1 - np.exp(-run.clock / slow[i])
            row = robot.rows[i]
            out[2 + i] = columns(run, x=grow[i] * w * row.a / 1e3, z=grow[i] * w * row.d / 1e3)
        out[2 + first] = out[2 + first] + columns(run, ry=bow * (1 - np.exp(-run.clock / slow[first])))
        return out

    params = {f"{setting.names[i]}_ppm": g * 1e6 for i, g in grow.items()}
    return Cause("thermal_drift", BODY, [], params, ["time", "position"], between=between)


def latency(setting, rng, s):
    """The instrument's clock is off, and runs a little fast."""
    delay, rate = 0.008 * s * rng.choice([-1, 1]), rng.normal() * 2e-5
    return Cause("latency", BODY, [], {"s": delay}, ["speed"], late=lambda run: delay + rate * (run.t - run.t.mean()))


def cutting_force(setting, rng, s):
    """The drives' springs give under the cut."""
    soft = s * 0.7 * softness(setting.robot)

    def link(run):
        return soft * np.einsum("nij,ni->nj", run.jacobian[0], run.force)

    params = {f"{n}_rad_Nm": float(c) for n, c in zip(setting.names, soft, strict=True)}
    return Cause("cutting_force", BODY, list(setting.names), params, ["force"], link=link)


def measurement_scale(setting, rng, s):
    """Air of another temperature than entered: every length off, about the marks that gave the frame."""
    ppm, stand = s * 60e-6 * rng.choice([-1, 1]), rng.uniform(-1, 1, 3) * np.array([1, 1, 0.4])

    def measured(run, tool):
        tool = tool.copy()
        off = tool[:, :3, 3] - stand
        tool[:, :3, 3] += ppm * off * (1 + 0.03 * np.linalg.norm(off, axis=1, keepdims=True))
        return tool

    return Cause("measurement_scale", BODY, [], {"ppm": ppm * 1e6}, ["position"], measured=measured)


def measurement_drift(setting, rng, s):
    """The instrument turns on its stand by the hour, and swings with the air."""
    stand, turn = rng.uniform(-4, 4, 3) * np.array([1, 1, 0.2]), rng.normal(size=3) * 3e-5 * s
    period = rng.uniform(200, 900)

    def measured(run, tool):
        tool = tool.copy()
        w = run.clock / 300.0 + 0.15 * np.sin(2 * np.pi * run.clock / period)
        tool[:, :3, 3] += w[:, None] * np.cross(turn, tool[:, :3, 3] - stand)
        return tool

    return Cause("measurement_drift", BODY, [], {"rad_300s": turn.tolist()}, ["time"], measured=measured)


def turntable(setting, rng, s):
    """A bearing of two lobes: it wobbles, runs out, and stays behind by direction."""
    lobes, behind, out, phase = s * 8e-5, s * 5e-5, s * 4e-5, rng.uniform(0, 6.28, 2)

    def on_table(run, tool):
        tool = tool.copy()
        e = run.table
        side = np.sign(np.gradient(e))
        turn = np.column_stack([lobes * np.cos(e + phase[0]), 0.7 * lobes * np.sin(e + phase[0]), behind * side])
        tool[:, :3, 3] += np.cross(turn, tool[:, :3, 3]) + out * np.column_stack(
            [np.cos(e + phase[1]), np.sin(e + phase[1]), 0 * e]
        )
        return tool

    return Cause("turntable", BODY, ["E2"], {"wobble_rad": lobes}, ["position", "direction"], on_table=on_table)


T = frozenset({"tracker"})
KNOWN = [
    *DRIVES,
    Description("joint_offset", joint_offset, T, 60),
    Description("geometry", geometry, T, 15),
    Description("frame_base", frame_base, T | {"frame_known"}, 20),
    Description("frame_tool", frame_tool, T | {"target_known"}, 20),
    Description("track", track, T | {"track"}, 10),
    Description("lean", lean, T, 10),
    Description("joint_compliance", joint_compliance, T, 10),
    Description("payload", payload, T, 3),
    Description("thermal_drift", thermal_drift, T, 8),
    Description("latency", latency, T | {"path", "frame_known"}, 10),
    Description("cutting_force", cutting_force, T | {"force"}, 10),
    Description("measurement_scale", measurement_scale, T, 8),
    Description("measurement_drift", measurement_drift, T, 8),
    Description("turntable", turntable, T | {"table"}, 10),
]
