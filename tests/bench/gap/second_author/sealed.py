"""The sealed family, opened once: other cells, other descriptions, leftovers of bending and bearings, other motions."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from gap.second_author import motion
from gap.second_author.family import Description, Family, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause
from gap.second_author.sealed_bodies import KNOWN, columns
from gap.second_author.sealed_cells import CELLS
from gap.second_author.sealed_drives import slow


def rail_joint(setting, rng, s):
    """Where two rails meet the carriage drops to one side, and stays so."""
    i = setting.robot.carriage[-1]
    x = setting.runs[0].c[:, i]
    at, drop = float(np.quantile(x, rng.uniform(0.3, 0.7))), s * 1e-4

    def between(run):
        w = 0.5 * (1 + np.tanh((run.c[:, i] - at) / 0.01))
        return {2 + i: columns(run, z=-drop * w, rx=0.6 * drop * w)}

    return Cause("rail_joint", BODY, [setting.names[i]], {"drop_mm": drop * 1e3}, ["position"], between=between)


def loose_gripper(setting, rng, s):
    """The tool sits loose in its seat and falls to the side on which gravity pulls."""
    give, to = s * 1e-3, rng.normal(size=3)

    def between(run):
        pull = -run.tip[:, 2, :3] @ (to / np.linalg.norm(to))
        side = np.tanh(pull / 0.15)
        return {-1: columns(run, x=0.1 * give * side, rx=0.3 * give * side, y=0.05 * give * side)}

    return Cause("loose_gripper", BODY, [], {"rad": give}, ["load", "position"], between=between)


def worn_bearing(setting, rng, s):
    """Balls of the first bearing pass a dent: it tips by an order that is no whole number."""
    first = setting.robot.arm[0]
    order, tip, phase = rng.uniform(4.3, 9.7), s * 5e-5, rng.uniform(0, 6.28)

    def between(run):
        w = order * run.c[:, first] + phase
        return {2 + first: columns(run, rx=tip * np.sin(w), ry=tip * np.cos(w))}

    return Cause("worn_bearing", BODY, [setting.names[first]], {"orders": order}, ["position"], between=between)


def encoder_glitch(setting, rng, s):
    """An encoder loses counts, at times, and always the same way."""
    (i,) = setting.arm(rng, 1, setting.moving())
    lost = s * (4e-5 if setting.robot.slides[i] else np.radians(0.008))
    times = np.sort(rng.uniform(0.1, 0.9, 3))

    def link(run):
        return axis_delta(run, {i: lost * np.searchsorted(times, run.t / run.t[-1])})

    return Cause(
        "encoder_glitch", BODY, [setting.names[i]], {setting.key(i): setting.told(i, lost)}, ["time"], link=link
    )


def limit_cycle(setting, rng, s):
    """A loop that hunts while its axis creeps."""
    (i,) = setting.arm(rng, 1, setting.moving())
    size, beat = s * (3e-5 if setting.robot.slides[i] else np.radians(0.006)), 2 * np.pi * rng.uniform(1.2, 4.0)

    def drive(run):
        v = np.abs(run.v[:, i])
        slowly = np.exp(-((v / (0.3 * v.max() + 1e-9)) ** 2))
        return axis_delta(run, {i: size * slow(slowly, 0.2, run.dt) * np.sin(beat * run.t)})

    return Cause("limit_cycle", DRIVE, [setting.names[i]], {"Hz": beat / 6.283}, ["time", "speed"], drive=drive)


def refraction(setting, rng, s):
    """Warm air in layers bends the beam: what is far and high reads too high."""
    stand, bend = rng.uniform(-4, 4, 3) * np.array([1, 1, 0.2]), s * 4e-5

    def measured(run, tool):
        tool = tool.copy()
        off, mark = tool[:, :3, 3] - stand, np.array([0, 0, 0.5]) - stand
        far, known = off[:, 0] ** 2 + off[:, 1] ** 2, mark[0] ** 2 + mark[1] ** 2
        tool[:, 2, 3] += bend * (far * (0.3 + 0.2 * off[:, 2]) - known * (0.3 + 0.2 * mark[2]))
        return tool

    return Cause("refraction", BODY, [], {"per_m": bend}, ["position"], measured=measured)


def tripod_sinking(setting, rng, s):
    """A leg of the instrument's tripod goes into the floor."""
    lean, drop = rng.normal(size=2) * 1e-5 * s, s * 5e-5

    def measured(run, tool):
        tool = tool.copy()
        w = np.sqrt(run.clock / 300.0)
        turn = np.array([lean[0], lean[1], 0.0])
        tool[:, :3, 3] += w[:, None] * (np.cross(turn, tool[:, :3, 3]) + np.array([0, 0, drop]))
        return tool

    return Cause("tripod_sinking", BODY, [], {"mm": drop * 1e3}, ["time"], measured=measured)


def preload_creep(setting, rng, s):
    """A joint that creeps for a quarter of a minute behind each change of its load."""
    robot = setting.robot
    pool = [i for i in robot.arm if not robot.slides[i] and np.ptp(setting.runs[0].load[:, i]) > 0.3]
    (i,) = setting.arm(rng, 1, pool)
    heavy = np.abs(setting.runs[0].load[:, i]).max() + 1e-6
    soft, tau = s * np.radians(0.02) / heavy, rng.uniform(5, 15)

    def link(run):
        m = run.load[:, i]
        return axis_delta(run, {i: -soft * (m - slow(m, tau, run.dt))})

    return Cause("preload_creep", BODY, [setting.names[i]], {"rad_Nm": soft}, ["time", "load"], link=link)


def crossed_feed(setting, rng, s):
    """Acceleration of one axis is fed forward to its neighbour."""
    moving = setting.moving()
    to, of = (int(x) for x in rng.choice(moving, 2, replace=False))
    part = 2e-4 * s * setting.robot.unit[to] / setting.robot.unit[of] * rng.choice([-1, 1])

    def drive(run):
        return axis_delta(run, {to: part * slow(run.a[:, of], 0.02, run.dt)})

    axes = [setting.names[to], setting.names[of]]
    return Cause("crossed_feed", DRIVE, axes, {"s2": part}, ["acceleration"], drive=drive)


def leftover(setting, rng, s):
    """Links that bend both ways under what hangs on them, bearings that run out of true once and twice a turn."""
    robot = setting.robot
    n = len(robot.rows)
    heavy = np.abs(setting.runs[0].moments).max(axis=(0, 2)) + 1e-6
    bend, wave, phase = rng.normal(size=(n, 3)), rng.normal(size=(n, 2, 2)), rng.uniform(0, 6.28, (n, 2))

    def between(run):
        out = {}
        for i in range(n):
            x = run.c[:, i] / (0.4 if robot.slides[i] else 1.0)
            turn = run.moments[:, i] / heavy[i] * bend[i]
            tilt = sum(np.outer(np.sin((k + 1) * x + phase[i, k]), wave[i, k]) for k in range(2)) * 0.6
            out[2 + i] = s * 4e-5 * columns(run, rx=turn[:, 0] + tilt[:, 0], ry=turn[:, 1] + tilt[:, 1], rz=turn[:, 2])
        return out

    return Cause("leftover", BODY, [], {}, ["position", "load"], between=between)


def drive_leftover(setting, rng, s):
    """What loops leave by wind, load and stretch: squares of speed, load times speed, a slow swing over the stroke."""
    robot = setting.robot
    part = rng.normal(size=(len(robot.rows), 3))

    def drive(run):
        top = np.abs(run.v).max(0) + 1e-9
        v, m = run.v / top, run.load / (np.abs(run.load).max(0) + 1e-9)
        x = (run.c - run.c.mean(0)) / (np.ptp(run.c, axis=0) + 1e-6)
        return s * 0.002 * robot.unit * (part[:, 0] * v * np.abs(v) + part[:, 1] * m * v + part[:, 2] * np.sin(4 * x))

    return Cause("leftover", DRIVE, [], {}, ["position", "speed"], drive=drive)


def space_curve(rng, size):
    """A smooth closed curve through points in space, the hand tilting along."""
    knots = rng.normal(size=(int(rng.integers(6, 11)), 3))
    knots = np.vstack([np.zeros(3), knots, np.zeros(3)]) * size * 0.7
    spline = CubicSpline(np.linspace(0, 1, len(knots)), knots, bc_type="clamped")
    s = np.linspace(0, 1, 140)
    return spline(s), np.column_stack([np.sin(2 * np.pi * s * k) for k in (1, 2, 3)]) * rng.uniform(0, 0.25)


def star(rng, size):
    """Strokes out and back in many directions."""
    out = [np.zeros((1, 3))]
    for to in Rotation.random(int(rng.integers(5, 10)), random_state=int(rng.integers(1 << 30))).apply([size, 0, 0]):
        stroke = 0.5 * (1 - np.cos(np.linspace(0, 2 * np.pi, 17)))[1:]
        out.append(np.outer(stroke, to))
    where = np.vstack(out)
    return where, np.zeros_like(where)


def between_points(robot, rng, seconds, dt):
    """Moves from point to point, axes together, with rests."""
    knots = motion.axiswise(robot, rng, motion.ready(robot, rng), int(rng.integers(7, 14)), 30.0)
    top = np.array([r.speed for r in robot.rows]) * robot.unit * 0.5
    pieces = []
    for a, b in pairwise(knots):
        lasts = max(0.4, 1.9 * float((np.abs(b - a) / top).max()), 0.75 * seconds / len(knots))
        x = np.arange(0, lasts, dt) / lasts
        pieces.append(a + np.outer(10 * x**3 - 15 * x**4 + 6 * x**5, b - a))
        pieces.append(np.repeat(b[None], int(rng.uniform(0.1, 0.8) / dt), 0))
    c = np.vstack(pieces)
    return np.arange(len(c)) * dt, c


def paths(robot, rng, seconds, dt):
    """Space curves, stars of strokes, and moves from point to point."""
    if len(robot.arm) < 6 or rng.random() < 0.3:
        return between_points(robot, rng, seconds, dt)
    return motion.path(robot, rng, [space_curve, star], seconds, dt, 0.22)


def postures(robot, rng, count):
    """Single poses around a handful of postures, each visited from several sides."""
    seats = motion.axiswise(robot, rng, np.array(robot.home) * robot.unit, max(4, count // 6), 45.0)
    low, high = motion.limits(robot)
    near = seats[rng.integers(len(seats), size=count)]
    scale = np.where(robot.slides, 120.0, 12.0) * robot.unit
    c = np.clip(near + scale * rng.normal(size=near.shape), low, high)
    return np.arange(count) * 6.0 + np.cumsum(rng.exponential(2.0, count)), c


T, S = frozenset({"tracker"}), frozenset({"path", "setpoints"})
FOREIGN = [
    Description("rail_joint", rail_joint, T | {"track"}, 15, True),
    Description("loose_gripper", loose_gripper, T, 10, True),
    Description("worn_bearing", worn_bearing, T, 15, True),
    Description("encoder_glitch", encoder_glitch, T, 15, True),
    Description("limit_cycle", limit_cycle, S, 15, True),
    Description("refraction", refraction, T, 15, True),
    Description("tripod_sinking", tripod_sinking, T, 15, True),
    Description("preload_creep", preload_creep, T | {"path"}, 15, True),
    Description("crossed_feed", crossed_feed, S, 15, True),
]
FAMILY = Family("sealed", CELLS, KNOWN, FOREIGN, leftover, drive_leftover, paths, postures)
