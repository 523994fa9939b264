"""The development family: what a helper may look at. It shares no cell but the KR15 and no description with the sealed one."""

from __future__ import annotations

import numpy as np

from gap.second_author import motion
from gap.second_author.dev_bodies import KNOWN
from gap.second_author.dev_cells import CELLS
from gap.second_author.dev_drives import filtered
from gap.second_author.family import Description, Family, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause


def bolt_slip(setting, rng, s):
    """A clamped joint slips once, when it is loaded most."""
    (i,) = setting.arm(rng)
    step = s * np.radians(0.015) * rng.choice([-1, 1])
    first = setting.runs[-1]
    when = float(first.t[int(len(first.t) * rng.uniform(0.3, 0.7))])

    def link(run):
        return axis_delta(run, {i: step * (run.t >= min(when, 0.7 * run.t[-1]))})

    return Cause(
        "bolt_slip", BODY, [setting.names[i]], {setting.key(i): setting.told(i, step)}, ["time", "load"], link=link
    )


def cable_drag(setting, rng, s):
    """A dress pack winds up behind the forearm and pulls the third axis."""
    a3, far = setting.robot.arm[2], setting.robot.arm[-1]
    mid, width, pull = rng.uniform(-0.2, 0.2), rng.uniform(0.1, 0.4), s * np.radians(0.01)

    def link(run):
        q = run.c[:, far] - run.c[:, far].mean() - mid
        return axis_delta(run, {a3: pull * np.tanh(q / width)})

    return Cause(
        "cable_drag",
        BODY,
        [setting.names[a3], setting.names[far]],
        {"A3_deg": float(np.degrees(pull))},
        ["position"],
        link=link,
    )


def belt_stretch(setting, rng, s):
    """A belt of rubber: it follows at once in part, and creeps after for seconds."""
    (i,) = setting.arm(rng, 1, setting.moving())
    part, slow = s * 8e-4, rng.uniform(2, 6)

    def link(run):
        return axis_delta(run, {i: -part * filtered([slow, 0.0], [slow, 1.0], run.dt, run.c[:, i])})

    return Cause(
        "belt_stretch", BODY, [setting.names[i]], {"part": part}, ["direction", "speed", "position"], link=link
    )


def hall_step(setting, rng, s):
    """A door is opened: the floor's plate bends within a minute."""
    tilt, when, slow = rng.normal(size=2) * 3e-5 * s, rng.uniform(0.3, 0.6), rng.uniform(5, 20)

    def between(run):
        since = np.maximum(run.t - when * run.t[-1], 0.0)
        w, zero = 1 - np.exp(-since / slow), np.zeros(len(run.t))
        return {setting.robot.root: np.column_stack([zero, zero, w * 2e-5 * s, tilt[0] * w, tilt[1] * w, zero])}

    return Cause("hall_step", BODY, [], {"rad": tilt.tolist()}, ["time"], between=between)


def counterbalance_leak(setting, rng, s):
    """The balancer of the second axis loses pressure: it sags more the longer it runs."""
    a2 = setting.robot.arm[1]
    soft, slow = s * np.radians(0.02), rng.uniform(50, 150)

    def link(run):
        share = run.load[:, a2] / (np.abs(run.load[:, a2]).max() + 1e-9)
        return axis_delta(run, {a2: soft * share * (1 - np.exp(-run.clock / slow))})

    return Cause(
        "counterbalance_leak",
        BODY,
        [setting.names[a2]],
        {"A2_deg": float(np.degrees(soft))},
        ["time", "load"],
        link=link,
    )


def tooth_missing(setting, rng, s):
    """A chipped tooth: once a turn of its pinion the axis jumps by a bit."""
    robot = setting.robot
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not robot.slides[k]])
    pitch, wide, size = np.radians(rng.uniform(4, 12)), np.radians(rng.uniform(0.3, 1.0)), s * np.radians(0.02)

    def link(run):
        off = (run.c[:, i] + pitch / 3) % pitch - pitch / 2
        return axis_delta(run, {i: size * np.exp(-0.5 * (off / wide) ** 2)})

    return Cause(
        "tooth_missing", BODY, [setting.names[i]], {setting.key(i): setting.told(i, size)}, ["position"], link=link
    )


def encoder_eccentric(setting, rng, s):
    """The encoder's disc sits off its shaft: once and twice a turn of the axis."""
    robot = setting.robot
    (i,) = setting.arm(rng, 1, [k for k in setting.moving() if not robot.slides[k]])
    one, two, phase = s * np.radians(0.02), s * np.radians(0.006), rng.uniform(0, 6.28, 2)

    def link(run):
        q = run.c[:, i]
        return axis_delta(run, {i: one * np.sin(q + phase[0]) + two * np.sin(2 * q + phase[1])})

    return Cause(
        "encoder_eccentric", BODY, [setting.names[i]], {setting.key(i): setting.told(i, one)}, ["position"], link=link
    )


def interpolation_bug(setting, rng, s):
    """Every few seconds the controller holds a set-point back: drives run behind, and catch up."""
    every, lasts, late = rng.uniform(1.5, 4.0), rng.uniform(0.1, 0.3), 0.02 * s

    def drive(run):
        inside = (run.t % every) < lasts
        share = np.convolve(inside.astype(float), np.ones(6) / 6, mode="same")
        return -late * share[:, None] * run.v

    return Cause("interpolation_bug", DRIVE, [], {"s": late}, ["time", "speed"], drive=drive)


def brake_drag(setting, rng, s):
    """A brake that doesn't open fully: it drags more as it heats."""
    (i,) = setting.arm(rng, 1, setting.moving())
    drag, slow = s * 0.01 * setting.robot.unit[i], rng.uniform(20, 60)

    def drive(run):
        way = np.tanh(run.v[:, i] / (0.02 * setting.robot.rows[i].speed * setting.robot.unit[i]))
        return axis_delta(run, {i: -drag * way * (run.t / slow) ** 2 / (1 + (run.t / slow) ** 2)})

    return Cause(
        "brake_drag",
        DRIVE,
        [setting.names[i]],
        {setting.key(i): setting.told(i, drag)},
        ["time", "direction"],
        drive=drive,
    )


def leftover(setting, rng, s):
    """A network of bumps over posture that moves the tool."""
    robot = setting.robot
    low, high = motion.limits(robot)
    centres = (
        np.array(robot.home) + rng.uniform(-45, 45, (24, len(robot.rows))) * np.where(robot.slides, 8, 1)
    ) * robot.unit
    wide, heights = (high - low) * rng.uniform(0.18, 0.4), rng.normal(size=(24, 3)) * 1e-4 * s

    def between(run):
        far = (((run.c[:, None, :] - centres) / wide) ** 2).sum(2)
        bump = np.exp(-0.5 * far)
        return {0: np.column_stack([bump @ heights, np.zeros((len(run.t), 3))])}

    return Cause("leftover", BODY, [], {}, ["position"], between=between)


def drive_leftover(setting, rng, s):
    """Following errors of a smooth form: bumps over an axis's place and speed."""
    robot = setting.robot
    n = len(robot.rows)
    centres, heights = rng.uniform(-1.5, 1.5, (n, 8, 2)), rng.normal(size=(n, 8)) * s * 0.002

    def drive(run):
        out = {}
        for i in range(n):
            x = (run.c[:, i] - run.c[:, i].mean()) / (np.ptp(run.c[:, i]) / 2 + 1e-6)
            v = run.v[:, i] / (np.abs(run.v[:, i]).max() + 1e-9)
            far = (np.column_stack([x, v])[:, None] - centres[i]) ** 2
            out[i] = np.exp(-far.sum(2)) @ heights[i] * robot.unit[i]
        return axis_delta(run, out)

    return Cause("leftover", DRIVE, [], {}, ["position", "speed"], drive=drive)


def paths(robot, rng, seconds, dt):
    """Meanders, circles, and axes that wander."""
    return motion.path(robot, rng, [motion.raster, motion.circles, None], seconds, dt)


T, S = frozenset({"tracker"}), frozenset({"path", "setpoints"})
FOREIGN = [
    Description("bolt_slip", bolt_slip, T, 10, True),
    Description("cable_drag", cable_drag, T | {"wrist"}, 10, True),
    Description("belt_stretch", belt_stretch, T | {"path"}, 10, True),
    Description("hall_step", hall_step, T, 10, True),
    Description("counterbalance_leak", counterbalance_leak, T | {"wrist"}, 10, True),
    Description("tooth_missing", tooth_missing, T, 10, True),
    Description("encoder_eccentric", encoder_eccentric, T, 10, True),
    Description("interpolation_bug", interpolation_bug, S, 10, True),
    Description("brake_drag", brake_drag, S, 10, True),
]
FAMILY = Family("dev", CELLS, KNOWN, FOREIGN, leftover, drive_leftover, paths, motion.poses)
