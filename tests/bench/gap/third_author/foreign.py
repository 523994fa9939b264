"""Causes that the contract has no name for: linkages, swinging loads, floors, amplifiers, counters, optics, slides, mounts."""

from __future__ import annotations

import numpy as np

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause
from gap.third_author.tools import filtered, give, small_step, turning, twists


def four_bar(setting, rng, s):
    """Rods that drive the third axis are no parallelogram: it is off by how the second and it stand to each other."""
    two, three = setting.robot.arm[1:3]
    off, phase = 1.5 * s * small_step(setting.robot, 0), rng.uniform(0, 2 * np.pi)

    def link(run):
        return axis_delta(run, {three: off * (np.sin(run.c[:, three] - run.c[:, two] + phase) - np.sin(phase))})

    axes = [setting.names[three], setting.names[two]]
    return Cause("four_bar", BODY, axes, {"A3_deg": float(np.degrees(off))}, ["position"], link=link)


def swinging_load(setting, rng, s):
    """What hangs on the hand swings, and draws the arm after it: a pendulum of a second or two, hardly damped."""
    w, damping, draw = 2 * np.pi / rng.uniform(0.7, 2.0), rng.uniform(0.01, 0.08), s * 4e-5

    def between(run):
        a = np.gradient(np.gradient(run.tip[:, :3, 3], run.dt, axis=0), run.dt, axis=0)
        angle = [filtered([-1.0], [1.0, 2 * damping * w, w * w], run.dt, a[:, k]) for k in (0, 1)]
        return {0: twists(run, x=draw * angle[0] * 9.81, y=draw * angle[1] * 9.81)}

    return Cause("swinging_load", BODY, [], {"Hz": w / 6.283}, ["acceleration", "time"], between=between)


def press_next_door(setting, rng, s):
    """A press strikes every few seconds, and the floor rings behind each stroke."""
    every, first, w = rng.uniform(1.0, 4.0), rng.uniform(0, 1), 2 * np.pi * rng.uniform(1.5, 5.0)
    damping, way = rng.uniform(0.03, 0.15), rng.normal(size=3) * np.array([0.6, 0.6, 1.0]) * 2e-4 * s
    tilt = rng.normal(size=2) * 5e-5 * s

    def between(run):
        since = (run.clock + first) % every
        ring = np.exp(-damping * w * since) * np.sin(w * since)
        return {0: twists(run, way[0] * ring, way[1] * ring, way[2] * ring, tilt[0] * ring, tilt[1] * ring)}

    return Cause("press_next_door", BODY, [], {"every_s": every}, ["time"], between=between)


def passing_crane(setting, rng, s):
    """A crane goes by: the floor dips towards it, and comes back."""
    tilt, lasts = rng.normal(size=2) * 8e-5 * s, rng.uniform(4, 15)
    when = [float(rng.uniform(0.2, 0.8)) for _ in setting.runs]
    begins = [run.begins for run in setting.runs]

    def between(run):
        k = int(np.argmin(np.abs(np.array(begins) - run.begins)))
        dip = 1 / (1 + ((run.t - when[k] * run.t[-1]) / lasts) ** 2) ** 2
        return {0: twists(run, z=-1e-4 * s * dip, rx=tilt[0] * dip, ry=tilt[1] * dip)}

    return Cause("passing_crane", BODY, [], {"rad": tilt.tolist()}, ["time"], between=between)


def bus_sag(setting, rng, s):
    """The amplifiers share a rail that sags while the arm takes power to speed up: all axes fall behind together."""
    robot, late, wait = setting.robot, 0.015 * s, rng.uniform(0.03, 0.15)
    mass = np.where(robot.slides, 30.0, np.linspace(1.0, 0.05, len(robot.rows)))

    def drive(run):
        takes = np.maximum((mass * run.a * run.v).sum(1), 0.0)
        sag = filtered([1.0], [wait, 1.0], run.dt, takes / (takes.max() + 1e-12))
        return -late * sag[:, None] * run.v

    return Cause("bus_sag", DRIVE, [], {"s": late}, ["acceleration", "speed"], drive=drive)


def coarse_counts(setting, rng, s):
    """A counter of too few digits: the drive is sent to whole counts only."""
    (i,) = setting.arm(rng, 1, setting.moving())
    count = 5 * s * small_step(setting.robot, i)

    def drive(run):
        x = run.c[:, i]
        held = np.floor(x / count + 0.5) * count
        return axis_delta(run, {i: filtered([1.0], [0.01, 1.0], run.dt, held - x)})

    return Cause(
        "coarse_counts", DRIVE, [setting.names[i]], {setting.key(i): setting.told(i, count)}, ["position"], drive=drive
    )


def drooping_loop(setting, rng, s):
    """A loop whose integrator is off: it stands below its set-point by what it has to hold."""
    robot = setting.robot
    pool = [i for i in robot.arm if np.ptp(setting.runs[0].load[:, i]) > 0.3]
    (i,) = setting.arm(rng, 1, pool)
    soft = 3 * s * small_step(robot, i) / (np.abs(setting.runs[0].load[:, i]).max() + 1e-6)

    def drive(run):
        return axis_delta(run, {i: soft * run.load[:, i]})

    return Cause("drooping_loop", DRIVE, [setting.names[i]], {"per_Nm": soft}, ["load"], drive=drive)


def idling_spindle(setting, rng, s):
    """The spindle creeps round while the arm is measured, and its holder does not run true."""
    w, out, phase = 2 * np.pi * rng.uniform(0.05, 0.9), s * 1.2e-4, rng.uniform(0, 2 * np.pi)

    def between(run):
        return {-1: twists(run, x=out * np.cos(w * run.clock + phase), y=out * np.sin(w * run.clock + phase))}

    return Cause("idling_spindle", BODY, [], {"Hz": w / 6.283}, ["time"], between=between)


def mirror_off_centre(setting, rng, s):
    """The reflector's corner is not in its ball's middle: the more it looks aside, the farther it reads."""
    stand = rng.uniform(2, 4) * np.array([np.cos(w := rng.uniform(0, 6.28)), np.sin(w), 0.3])
    look, deep = rng.normal(size=3), s * 4e-4

    def measured(run, tool):
        tool = tool.copy()
        away = tool[:, :3, 3] - stand
        along = away / np.linalg.norm(away, axis=1, keepdims=True)
        facing = tool[:, :3, :3] @ (look / np.linalg.norm(look))
        tool[:, :3, 3] += deep * ((facing * along).sum(1) ** 2)[:, None] * along
        return tool

    return Cause("mirror_off_centre", BODY, [], {"mm": deep * 1e3}, ["position"], measured=measured)


def azimuth_eccentric(setting, rng, s):
    """The tracker's angle disc is off its pivot: bearings are off once and twice a turn."""
    stand = rng.uniform(1.0, 2.5) * np.array([np.cos(w := rng.uniform(0, 6.28)), np.sin(w), 0.2])
    one, phase = s * 2e-4, rng.uniform(0, 2 * np.pi, 2)

    def measured(run, tool):
        tool = tool.copy()
        away = tool[:, :3, 3] - stand
        bearing = np.arctan2(away[:, 1], away[:, 0])
        off = one * (np.sin(2 * bearing + phase[0]) + 0.5 * np.sin(3 * bearing + phase[1]))
        tool[:, :2, 3] += off[:, None] * np.stack([-away[:, 1], away[:, 0]], 1)
        return tool

    return Cause("azimuth_eccentric", BODY, [], {"rad": one}, ["position"], measured=measured)


def floating_way(setting, rng, s):
    """A slide whose oil lifts the carriage while it moves, and lets it down in a while."""
    i = setting.robot.carriage[-1]
    lift, sinks = s * 1.2e-4, rng.uniform(0.2, 1.5)

    def between(run):
        fast = np.sqrt(np.abs(run.v[:, i]))
        film = filtered([1.0], [sinks, 1.0], run.dt, fast / (fast.max() + 1e-9))
        return {2 + i: twists(run, x=lift * film, ry=0.4 * lift * film)}

    return Cause("floating_way", BODY, [setting.names[i]], {"mm": lift * 1e3}, ["speed"], between=between)


def centrifugal(setting, rng, s):
    """What turns is thrown outward, and the drives give: by the square of speed, which no one compensates."""
    robot = setting.robot
    soft = give(robot) * 40 * s * robot.payload

    def link(run):
        v = np.gradient(run.tip[:, :3, 3], run.dt, axis=0)
        turn = np.einsum("nij,nj->ni", run.jacobian[1], run.v)
        thrown = -np.cross(turn, v)
        return soft * np.einsum("nij,ni->nj", run.jacobian[0], thrown)

    return Cause("centrifugal", BODY, [], {"kg": 40 * s * robot.payload}, ["speed"], link=link)


def breakaway_mount(setting, rng, s):
    """A mount that is held by springs against crashes: beyond some acceleration it opens."""
    open_, lasts, way = rng.uniform(0.25, 0.6), rng.uniform(0.03, 0.15), rng.normal(size=3)
    size = s * 3e-4

    def between(run):
        a = np.gradient(np.gradient(run.tip[:, :3, 3], run.dt, axis=0), run.dt, axis=0)
        own = np.einsum("nji,nj->ni", run.tip[:, :3, :3], a) @ (way / np.linalg.norm(way))
        top = np.abs(own).max() + 1e-12
        gives = np.sign(own) * np.maximum(np.abs(own) / top - open_, 0.0) / (1 - open_)
        gives = -size * filtered([1.0], [lasts, 1.0], run.dt, gives)
        x, y, z = (gives * w for w in way / np.linalg.norm(way))
        return {-1: twists(run, x, y, z)}

    return Cause("breakaway_mount", BODY, [], {"mm": size * 1e3}, ["acceleration"], between=between)


def racking(setting, rng, s):
    """A bridge driven at both ends: where the carriage stands aside, speeding up turns the bridge."""
    one, two = setting.robot.carriage[:2]
    soft = s * 4e-4

    def between(run):
        aside = run.c[:, two] - 0.3
        return {2 + one: twists(run, rx=soft * run.a[:, one] * aside)}

    return Cause(
        "racking", BODY, [setting.names[one], setting.names[two]], {"rad": soft}, ["acceleration"], between=between
    )


def loose_key(setting, rng, s):
    """A key in its groove rolls over under the torque of speeding up and stays there until it is pushed back."""
    (i,) = setting.arm(rng, 1, turning(setting))
    wide, push = 1.5 * s * small_step(setting.robot, i), rng.uniform(0.4, 1.0)

    def link(run):
        hard = np.abs(run.a[:, i])
        a = run.a[:, i] / (np.quantile(hard[hard > 0.01 * hard.max()], 0.8) + 1e-12)
        at, out = 1.0, []
        for now in a.tolist():
            if abs(now) > push:
                at = -1.0 if now > 0 else 1.0
            out.append(at)
        return axis_delta(run, {i: wide * filtered([1.0], [0.02, 1.0], run.dt, np.array(out) - 1.0)})

    axes = [setting.names[i]]
    return Cause(
        "loose_key", BODY, axes, {setting.key(i): setting.told(i, wide)}, ["acceleration", "direction"], link=link
    )


T, S = frozenset({"tracker"}), frozenset({"path", "setpoints"})
MOVES = T | {"path"}
FOREIGN = [
    Description("four_bar", four_bar, T | {"elbow"}, 20, True),
    Description("swinging_load", swinging_load, MOVES, 30, True),
    Description("press_next_door", press_next_door, MOVES, 20, True),
    Description("passing_crane", passing_crane, MOVES, 20, True),
    Description("bus_sag", bus_sag, S, 20, True),
    Description("coarse_counts", coarse_counts, S, 30, True),
    Description("drooping_loop", drooping_loop, S, 20, True),
    Description("idling_spindle", idling_spindle, T, 20, True),
    Description("mirror_off_centre", mirror_off_centre, T, 20, True),
    Description("azimuth_eccentric", azimuth_eccentric, T, 20, True),
    Description("floating_way", floating_way, MOVES | {"track"}, 20, True),
    Description("centrifugal", centrifugal, MOVES, 40, True),
    Description("breakaway_mount", breakaway_mount, MOVES, 20, True),
    Description("racking", racking, MOVES | {"bridge"}, 40, True),
    Description("loose_key", loose_key, MOVES, 20, True),
]
