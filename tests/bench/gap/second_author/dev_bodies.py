"""The development family's structure and instruments, its foreign causes, its leftovers, its motions."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from gap.second_author.chain import Body
from gap.second_author.dev_drives import DRIVES
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, Cause


def give(robot):
    """What a joint of this size gives, rad/Nm: stiffer the heavier the arm."""
    heavy = sum(b.mass for b in robot.bodies)
    near, far = (1.5e-6, 8e-6) if heavy > 100 else (3e-5, 1e-4)
    return np.array([0.0 if s else (near if k < len(robot.rows) - 3 else far) for k, s in enumerate(robot.slides)])


def joint_offset(setting, rng, s):
    picked = setting.arm(rng, 3)
    off = {i: s * np.radians(0.02) * rng.choice([-1, 1]) * rng.uniform(0.5, 1.5) for i in picked}
    params = {setting.key(i): setting.told(i, x) for i, x in off.items()}
    axes = [setting.names[i] for i in picked]
    return Cause(
        "joint_offset",
        BODY,
        axes,
        params,
        ["position"],
        link=lambda run: axis_delta(run, {i: np.full(len(run.t), x) for i, x in off.items()}),
    )


def _constant(name, where, size_mm, size_deg):
    def make(setting, rng, s):
        at = where(setting, rng)
        twists = {
            k: np.concatenate([rng.normal(size=3) * size_mm / 1e3, rng.normal(size=3) * np.radians(size_deg)]) * s
            for k in at
        }
        params = {f"{k}": [float(x) for x in w] for k, w in twists.items()}
        return Cause(name, BODY, [], params, ["position"], between=lambda run: twists)

    return make


def track(setting, rng, s):
    """A rail that is not straight, and a rack that is not as long as told."""
    robot = setting.robot
    i = robot.carriage[-1]
    knots = np.linspace(robot.rows[i].low, robot.rows[i].high, 9) / 1e3
    scale = s * 8e-5 * rng.choice([-1, 1])
    profile = CubicSpline(knots, np.cumsum(rng.normal(size=(9, 2)), 0) * s * 1e-4)
    rock = CubicSpline(knots, rng.normal(size=9) * s * 4e-5)

    def between(run):
        x = run.c[:, i]
        zero = np.zeros_like(x)
        return {2 + i: np.column_stack([profile(x), zero, rock(x), zero, zero])}

    def link(run):
        return axis_delta(run, {i: scale * run.c[:, i]})

    return Cause("track", BODY, ["E1"], {"scale_ppm": scale * 1e6}, ["position"], between=between, link=link)


def lean(setting, rng, s):
    """A pedestal that gives unequally under the overturning moment."""
    robot = setting.robot
    heavy = np.abs(setting.runs[0].moments[:, robot.arm[0]]).max() + 1.0
    k = s * 1.5e-4 / heavy * rng.uniform(0.4, 1.6, 2)

    def between(run):
        m = run.moments[:, robot.arm[0]]
        zero = np.zeros(len(run.t))
        return {robot.root: np.column_stack([zero, zero, zero, k[0] * m[:, 0], k[1] * m[:, 1], zero])}

    return Cause("lean", BODY, [], {"rad_Nm": [float(x) for x in k]}, ["load", "position"], between=between)


def joint_compliance(setting, rng, s):
    """Joints that stiffen under load."""
    robot = setting.robot
    picked = setting.arm(
        rng, 3, [i for i in robot.arm if not robot.slides[i] and np.ptp(setting.runs[0].load[:, i]) > 0.5]
    )
    base = give(robot)
    soft = {i: s * base[i] * rng.uniform(0.5, 1.5) for i in picked}
    knee = {i: (np.abs(setting.runs[0].load[:, i]).max() + 1) * rng.uniform(1.5, 4) for i in picked}

    def link(run):
        return axis_delta(
            run, {i: c * run.load[:, i] / (1 + np.abs(run.load[:, i]) / knee[i]) for i, c in soft.items()}
        )

    params = {f"{setting.names[i]}_rad_Nm": float(c) for i, c in soft.items()}
    return Cause("joint_compliance", BODY, [setting.names[i] for i in picked], params, ["load", "position"], link=link)


def payload(setting, rng, s):
    """Another load than the controller was told; the arm sags as it does."""
    robot, soft = setting.robot, give(setting.robot)
    mass = s * 0.3 * robot.payload * rng.choice([-1, 1])
    extra = Body(
        robot.names[-1], mass, (*tuple(rng.uniform(-60, 60, 2)), rng.uniform(0, 200) * (-1 if robot.copied else 1))
    )

    def link(run):
        return soft * (robot.moments(run.c, (extra,))[:, :, 2] - run.moments[:, :, 2]) * robot.signs

    return Cause("payload", BODY, [], {"payload_kg": mass}, ["load", "position"], link=link)


def thermal_drift(setting, rng, s):
    """Links grow with their lengths, by two time constants; the column bends a little."""
    robot = setting.robot
    rate = s * 1.2e-5 * 8.0
    slow, share = (rng.uniform(60, 200), rng.uniform(400, 2000)), rng.uniform(0.3, 0.8)
    parts = {i: rng.uniform(0.5, 1.3) for i in robot.arm}
    bend = rng.normal(size=2) * 2e-5 * s

    def warm(run):
        return share * (1 - np.exp(-run.clock / slow[0])) + (1 - share) * (1 - np.exp(-run.clock / slow[1]))

    def between(run):
        w, out = warm(run), {}
        zero = np.zeros_like(w)
        for i, part in parts.items():
            row = robot.rows[i]
            grow = rate * part * w / 1e3
            out[2 + i] = np.column_stack([grow * row.a, zero, grow * row.d, zero, zero, zero])
        out[robot.root] = np.column_stack([zero, zero, zero, bend[0] * w, bend[1] * w, zero])
        return out

    params = {"growth_ppm": rate * 1e6, "seconds": [float(x) for x in slow]}
    return Cause("thermal_drift", BODY, [], params, ["time", "position"], between=between)


def latency(setting, rng, s):
    delay = 0.008 * s * rng.choice([-1, 1])
    return Cause("latency", BODY, [], {"s": delay}, ["speed"], late=lambda run: np.full(len(run.t), delay))


def cutting_force(setting, rng, s):
    """The tool's shank bends."""
    soft = s * 4e-7 * rng.uniform(0.5, 1.5, 3) * np.array([1, 1, 0.2])

    def between(run):
        local = np.einsum("nji,nj->ni", run.tip[:, :3, :3], run.force) * soft
        return {-1: np.column_stack([local, np.zeros((len(run.t), 3))])}

    return Cause("cutting_force", BODY, [], {"um_N": [float(x * 1e6) for x in soft]}, ["force"], between=between)


def measurement_scale(setting, rng, s):
    """The tracker's wavelength, about the marks by which its frame was told: there it was registered."""
    ppm, stand = s * 60e-6 * rng.choice([-1, 1]), np.array([0.8, 0.8, 0.4]) * rng.uniform(-1, 1, 3)

    def measured(run, tool):
        tool = tool.copy()
        tool[:, :3, 3] += ppm * (tool[:, :3, 3] - stand)
        return tool

    return Cause("measurement_scale", BODY, [], {"ppm": ppm * 1e6}, ["position"], measured=measured)


def measurement_drift(setting, rng, s):
    """The instrument's stand settles."""
    to, slow = rng.normal(size=3) * 1e-4 * s, rng.uniform(40, 300)

    def measured(run, tool):
        tool = tool.copy()
        tool[:, :3, 3] += np.outer(1 - np.exp(-run.clock / slow), to)
        return tool

    return Cause("measurement_drift", BODY, [], {"mm": [float(x * 1e3) for x in to]}, ["time"], measured=measured)


def turntable(setting, rng, s):
    """The table wobbles and runs out once a turn."""
    wobble, out, phase = s * 1e-4, s * 5e-5, rng.uniform(0, 6.28)

    def on_table(run, tool):
        tool = tool.copy()
        e = run.table + phase
        turn = np.column_stack([wobble * np.cos(e), wobble * np.sin(e), 0 * e])
        tool[:, :3, 3] += np.cross(turn, tool[:, :3, 3]) + out * np.column_stack([np.cos(e), -np.sin(e), 0 * e])
        return tool

    return Cause(
        "turntable", BODY, ["E2"], {"wobble_rad": wobble, "out_mm": out * 1e3}, ["position"], on_table=on_table
    )


def frame_table(setting, rng, s):
    """The table's axis stands elsewhere and not upright."""
    tilt, off = np.append(rng.normal(size=2) * 1e-4, 0.0) * s, np.append(rng.normal(size=2) * 1e-4, 0.0) * s

    def on_table(run, tool):
        tool = tool.copy()
        turn = np.zeros((len(run.t), 3, 3))
        turn[:, 0, 0] = turn[:, 1, 1] = np.cos(run.table)
        turn[:, 0, 1], turn[:, 1, 0] = -np.sin(run.table), np.sin(run.table)
        turn[:, 2, 2] = 1.0
        world = np.einsum("nji,nj->ni", turn, tool[:, :3, 3])
        tool[:, :3, 3] += np.einsum("nij,nj->ni", turn, np.cross(tilt, world) + off)
        return tool

    return Cause(
        "frame_table",
        BODY,
        [],
        {"tilt_rad": tilt.tolist(), "off_mm": (off * 1e3).tolist()},
        ["position"],
        on_table=on_table,
    )


T = frozenset({"tracker"})
KNOWN = [
    *DRIVES,
    Description("joint_offset", joint_offset, T, 40),
    Description("geometry", _constant("geometry", lambda c, rng: [2 + i for i in c.arm(rng, 3)], 0.1, 0.01), T, 15),
    Description("frame_base", _constant("frame_base", lambda c, rng: [0], 0.3, 0.01), T | {"frame_known"}, 20),
    Description("frame_tool", _constant("frame_tool", lambda c, rng: [-1], 0.2, 0.02), T | {"target_known"}, 20),
    Description("track", track, T | {"track"}, 10),
    Description("lean", lean, T, 8),
    Description("joint_compliance", joint_compliance, T, 8),
    Description("payload", payload, T, 4),
    Description("thermal_drift", thermal_drift, T, 8),
    Description("latency", latency, T | {"path", "frame_known"}, 10),
    Description("cutting_force", cutting_force, T | {"force"}, 10),
    Description("measurement_scale", measurement_scale, T, 8),
    Description("measurement_drift", measurement_drift, T, 8),
    Description("turntable", turntable, T | {"table"}, 10),
    Description("frame_table", frame_table, T | {"table"}, 10),
]
