"""The body: mastering under load, a crash, surveyed feet, rails, anchors, gears with lost motion, warm motors, cuts."""

from __future__ import annotations

import numpy as np

from gap.second_author.chain import Body
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, Cause
from gap.third_author.tools import filtered, give, hanging, played, small_step, twists


def joint_offset(setting, rng, s):
    """Axes mastered with a heavy tool on, so that their gears were wound up; or one whose belt was put on a tooth off."""
    robot = setting.robot
    load = robot.moments(np.array(robot.home) * robot.unit)[0][:, 2] * robot.signs * give(robot)
    heavy = [i for i in robot.arm if abs(load[i]) > 0.15 * np.abs(load).max() > 0]
    if heavy and rng.random() < 0.5:
        off = {i: 2.5 * s * small_step(robot, i) * load[i] / np.abs(load).max() * rng.uniform(0.8, 1.2) for i in heavy}
    else:
        (i,) = setting.arm(rng)
        off = {i: 2.5 * s * small_step(robot, i) * rng.choice([-1, 1])}

    def link(run):
        return axis_delta(run, {i: np.full(len(run.t), x) for i, x in off.items()})

    params = {setting.key(i): setting.told(i, x) for i, x in off.items()}
    return Cause("joint_offset", BODY, [setting.names[i] for i in off], params, ["position"], link=link)


def crashed(robot, posture, rng):
    """Twists that a blow on the tool leaves: behind each row by the moment there, less what its own axis or the next one
    would give way to; the two rows that were bent most.
    """
    axes, ends, tip = robot.frames(posture)
    blow = rng.normal(size=3)
    blow /= np.linalg.norm(blow)
    bent = {}
    for i in robot.arm:
        at, turn = ends[i][0, :3, 3], ends[i][0, :3, :3]
        moment = turn.T @ np.cross(tip[0, :3, 3] - at, blow)
        keep = [turn.T @ axes[i][0, :3, 2], np.array([0.0, 0.0, 1.0])]
        q, r = np.linalg.qr(np.array(keep).T)
        q = q[:, np.abs(np.diag(r)) > 1e-6]
        moment = moment - q @ (q.T @ moment)
        way = turn.T @ (at - axes[i][0, :3, 3])
        bent[i] = np.concatenate([0.5 * np.cross(moment, way), moment])
    worst = sorted(bent, key=lambda i: -np.linalg.norm(bent[i][3:]))[:2]
    top = max(np.linalg.norm(bent[worst[0]][3:]), 1e-9)
    return {i: bent[i] / top for i in worst if np.linalg.norm(bent[i][3:]) > 0.1 * top}


def geometry(setting, rng, s):
    """A crash: links bent together, in proportion to the blow's moment at each."""
    robot = setting.robot
    bent = crashed(
        robot, np.array(robot.home) * robot.unit + rng.uniform(-0.3, 0.3, len(robot.rows)) * ~robot.slides, rng
    )
    made = {2 + i: s * 2.5e-4 * w[None] for i, w in bent.items()}
    params = {setting.names[k - 2]: w[0].tolist() for k, w in made.items()}
    return Cause("geometry", BODY, [], params, ["position"], between=lambda run: made)


def frame_base(setting, rng, s):
    """A foot set by its bolt circle and a spirit level: turned about the circle's middle most, tilted less, grouted too high."""
    middle = setting.robot.base[:3, 3] + rng.uniform(-0.3, 0.3, 3)
    turn = rng.normal(size=3) * np.array([0.4, 0.4, 1.2]) * 3e-4 * s
    shift = np.array([0.3, 0.3, 1.0]) * rng.normal(size=3) * 1.5e-4 * s
    twist = np.concatenate([shift - np.cross(turn, middle), turn])
    return Cause("frame_base", BODY, [], {"twist": twist.tolist()}, ["position"], between=lambda run: {0: twist[None]})


def frame_tool(setting, rng, s):
    """A tip found from four points touched: worst along the tool; and, at times, a taper that is dirty on one side."""
    tip = rng.normal(size=3) * np.array([0.6, 0.6, 1.8]) * 1.5e-4 * s
    turn = np.zeros(3)
    if rng.random() < 0.5:
        turn[:2] = rng.normal(size=2) * 6e-4 * s
        tip = tip + np.cross(turn, [0.0, 0.0, rng.uniform(0.08, 0.25)])
    twist = np.concatenate([tip, turn])
    return Cause("frame_tool", BODY, [], {"twist": twist.tolist()}, ["position"], between=lambda run: {-1: twist[None]})


def track(setting, rng, s):
    """A rail whose height and side are three waves of its length, whose slope pitches the carriage, so that height tells (Abbe);
    a rack that is warm, and out of true once a turn of its pinion.
    """
    robot = setting.robot
    i = robot.carriage[-1]
    length = (robot.rows[i].high - robot.rows[i].low) / 1e3
    size, phase = rng.normal(size=(2, 3)) * 2.5e-4 / np.arange(1, 4) * s, rng.uniform(0, 2 * np.pi, (2, 3))
    warm, teeth = s * 1e-4 * rng.choice([-1, 1]) * rng.uniform(0.4, 1.2), s * rng.uniform(0, 2.5e-5)
    wave = 2 * np.pi * np.arange(1, 4) / length

    def between(run):
        x = run.c[:, i, None] * wave
        up, side = ((np.cos(x + phase[k]) * size[k]).sum(1) for k in (0, 1))
        slope, yaw = (-(np.sin(x + phase[k]) * size[k] * wave).sum(1) for k in (0, 1))
        return {2 + i: twists(run, x=up, y=side, rx=0.5 * yaw, ry=slope)}

    def link(run):
        x = run.c[:, i]
        return axis_delta(run, {i: warm * x + teeth * np.sin(2 * np.pi * x / 0.2)})

    params = {"scale_ppm": warm * 1e6}
    return Cause("track", BODY, [setting.names[i]], params, ["position"], between=between, link=link)


def lean(setting, rng, s):
    """A foot on anchors of unequal spacing, which gives more beyond their preload, and a little more with time."""
    robot, yaw = setting.robot, rng.uniform(0, np.pi)
    first = robot.root - 1  # the row that begins in the foot's frame
    heavy = np.linalg.norm(setting.runs[0].moments[:, first, :2], axis=1).max() + 1.0
    soft = s * 2.5e-4 / heavy * rng.uniform(0.5, 1.5, 2)
    preload, more, creep, tau = (
        rng.uniform(0.4, 1.2) * heavy,
        rng.uniform(0.3, 1.0),
        rng.uniform(0, 0.15),
        rng.uniform(10, 60),
    )
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])

    def between(run):
        moment = run.moments[:, first, :2] @ turn
        beyond = np.sign(moment) * np.maximum(np.abs(moment) - preload, 0.0)
        tilt = soft * (moment + more * beyond)
        if not run.rest:
            slow = np.stack([filtered([1.0], [tau, 1.0], run.dt, w - w[0]) + w[0] for w in tilt.T], axis=1)
            tilt = (1 - creep) * tilt + creep * slow
        tilt = tilt @ turn.T
        return {robot.root: twists(run, rx=tilt[:, 0], ry=tilt[:, 1])}

    return Cause("lean", BODY, [], {"rad_Nm": soft.tolist()}, ["load", "position"], between=between)


def joint_compliance(setting, rng, s):
    """Gears with a loop of lost motion: they give in proportion to the load, and a share of it stays until the load turns."""
    picked = setting.arm(rng, 3, hanging(setting))
    soft = {i: s * 4 * small_step(setting.robot, i) / held(setting, i) * rng.uniform(0.6, 1.5) for i in picked}
    share, wide = rng.uniform(0.0, 0.3), rng.uniform(0.05, 0.3)

    def link(run):
        out = {}
        for i, c in soft.items():
            m = run.load[:, i]
            out[i] = c * ((1 - share) * m + share * played(m, 0.5 * wide * held(setting, i)))
        return axis_delta(run, out)

    params = {f"{setting.names[i]}_rad_Nm": float(c) for i, c in soft.items()}
    names = [setting.names[i] for i in picked]
    return Cause("joint_compliance", BODY, names, params, ["load", "position"], link=link)


def held(setting, i):
    """The most that weight asks of an axis in the first run, Nm."""
    return float(np.abs(setting.runs[0].load[:, i]).max()) + 1e-6


def payload(setting, rng, s):
    """What hangs on the hand was entered wrong: a clamp that was left out, and the tool's own mass elsewhere than told."""
    robot, soft = setting.robot, 3.0 * give(setting.robot)
    mass = s * 0.6 * robot.payload * rng.choice([-1, 1], p=[0.35, 0.65])
    shift = rng.normal(size=3) * np.array([60, 60, 90])
    last, at = robot.names[-1], rng.uniform(-80, 80, 3)
    bodies = (
        Body(last, mass, tuple(at)),
        Body(last, 0.5 * s * robot.payload, tuple(at + shift)),
        Body(last, -0.5 * s * robot.payload, tuple(at)),
    )

    def link(run):
        return soft * (robot.moments(run.c, bodies)[:, :, 2] - run.moments[:, :, 2]) * robot.signs

    return Cause("payload", BODY, [], {"payload_kg": mass}, ["load", "position"], link=link)


def heated(run, power, tau):
    """The rise (N,) of a mass that loses its heat with `tau`, under a power of 1 in the mean, 0 when it was switched on."""
    before = 1 - np.exp(-run.begins / tau)
    lost = np.exp(-(run.t - run.t[0]) / tau)
    own = np.full(len(run.t), 1 - lost) if power is None else filtered([1.0], [tau, 1.0], run.dt, power)
    return before * lost + own


def longer(robot, i, part):
    """Small frames by place where row i is longer by `part` (N,): d along its axis, a along the link."""
    row, zero = robot.rows[i], np.zeros_like(part)
    a, d, alpha = part * row.a / 1e3, part * row.d / 1e3, np.radians(row.alpha)
    if robot.modified:  # a stands before the joint
        return {1 + i: np.stack([a, *[zero] * 5], 1), 2 + i: np.stack([zero, zero, d, *[zero] * 3], 1)}
    return {2 + i: np.stack([a, d * np.sin(alpha), d * np.cos(alpha), *[zero] * 3], 1)}


def thermal_drift(setting, rng, s):
    """Motors heat by what they do, square of torque and speed; castings grow by it, and with the hall, which breathes."""
    robot = setting.robot
    tau = {i: float(np.exp(rng.uniform(np.log(100), np.log(1200)))) for i in robot.arm}
    grow = {i: s * 2e-4 * rng.uniform(0.1, 1.0) for i in robot.arm}
    period, hall, phase = rng.uniform(900, 4000), s * 4e-5 * rng.uniform(0.2, 1.0), rng.uniform(0, 2 * np.pi)
    bend = s * rng.normal(size=2) * 5e-5
    mixed = rng.uniform(0.2, 0.8)

    def warm(run, i):
        if run.rest:
            return heated(run, None, tau[i])
        parts = [run.load[:, i] ** 2, run.v[:, i] ** 2]
        parts = [p / p.mean() if p.mean() > 1e-12 else np.ones(len(p)) for p in parts]
        return heated(run, mixed * parts[0] + (1 - mixed) * parts[1], tau[i])

    def between(run):
        out = {}
        air = hall * (np.sin(2 * np.pi * run.clock / period + phase) - np.sin(phase))
        for i in robot.arm:
            for place, more in longer(robot, i, grow[i] * warm(run, i) + air).items():
                out[place] = out.get(place, 0.0) + more
        hot, first = warm(run, robot.arm[1]), 2 + robot.arm[0]
        out[first] = out.get(first, 0.0) + twists(run, rx=bend[0] * hot, ry=bend[1] * hot)
        return out

    params = {f"{setting.names[i]}_ppm": g * 1e6 for i, g in grow.items()}
    return Cause("thermal_drift", BODY, [], params, ["time", "position"], between=between)


def cutting_force(setting, rng, s):
    """Two links bend under the cut's moment, about both axes across them."""
    robot = setting.robot
    picked = [int(i) for i in rng.choice(robot.arm[1:], 2, replace=False)]
    soft = {i: s * 3e-6 * rng.uniform(0.4, 1.6, 2) for i in picked}

    def between(run):
        out = {}
        for i, (about_x, about_y) in soft.items():
            end = run.bones[1][i]
            moment = np.cross(run.tip[:, :3, 3] - end[:, :3, 3], run.force)
            own = np.einsum("nji,nj->ni", end[:, :3, :3], moment)
            out[2 + i] = twists(run, rx=about_x * own[:, 0], ry=about_y * own[:, 1])
        return out

    params = {f"{setting.names[i]}_rad_Nm": k.tolist() for i, k in soft.items()}
    names = [setting.names[i] for i in picked]
    return Cause("cutting_force", BODY, names, params, ["force"], between=between)


T = frozenset({"tracker"})
BODIES = [
    Description("joint_offset", joint_offset, T, 60),
    Description("geometry", geometry, T, 20),
    Description("frame_base", frame_base, T | {"frame_known"}, 20),
    Description("frame_tool", frame_tool, T | {"target_known"}, 20),
    Description("track", track, T | {"track"}, 15),
    Description("lean", lean, T, 15),
    Description("joint_compliance", joint_compliance, T, 15),
    Description("payload", payload, T, 4),
    Description("thermal_drift", thermal_drift, T, 12),
    Description("cutting_force", cutting_force, T | {"force"}, 30),
]
