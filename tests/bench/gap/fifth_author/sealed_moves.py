"""SEALED's procedures: a hypercube, home between loops of work, legs of a carriage, axes one by one; straight rails, swings."""

from __future__ import annotations

import numpy as np

from gap.fifth_author.paths import STEP, clipped, corners, hopped, led, moved_off, near
from gap.second_author.motion import limits

__all__ = ["PATHS", "POSES", "homing", "hypercube", "legs", "one_by_one", "rides", "straights", "swings"]


def hypercube(robot, rng, count):
    """Each axis once in each of `count` slices of its range about home."""
    low, high = limits(robot)
    home = np.array(robot.home) * robot.unit
    half = np.where(robot.slides, 0.42 * (high - low), np.radians(42))
    slices = np.stack([rng.permutation(count) for _ in home], axis=1)
    c = clipped(robot, home + half * (2 * (slices + rng.random(slices.shape)) / count - 1))
    return 15.0 * np.arange(count) + np.cumsum(rng.exponential(2.0, count)), c


def homing(robot, rng, count):
    """A shift: loops of work through one of six postures, and home measured between them; a break in the middle."""
    work, home = near(robot, rng, 34, count=6), near(robot, rng, 3, slide=0.01)[0]
    order = rng.integers(0, 6, count // 2)
    c = np.stack([np.repeat(home[None], count // 2, 0), work[order]], axis=1).reshape(-1, len(home))
    t = np.arange(len(c)) * rng.uniform(3.0, 5.0) * 3600 / len(c)
    t[len(t) // 2 :] += 45 * 60
    return t, c


def legs(robot, rng, count):
    """A carriage goes to places by the golden section, with one posture of the arm after the other."""
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    c = np.repeat(near(robot, rng, 35, count=5), -(-count // 5), axis=0)[:count]
    along = (np.arange(count) * 0.6180339887 + rng.random()) % 1.0
    c[:, i] = (row.low + (0.04 + 0.92 * along) * (row.high - row.low)) * 1e-3
    return 10.0 * np.arange(count) + np.cumsum(rng.uniform(0, 4, count)), c


def one_by_one(robot, rng, count):
    """Axes by themselves, as each is mastered: the others stand, it goes up and down in even steps."""
    per = max(6, count // len(robot.rows))
    start, out = near(robot, rng, 15, slide=0.2)[0], []
    low, high = limits(robot)
    for i in range(len(robot.rows)):
        reach = min(0.35 * (high[i] - low[i]), 9.0 if robot.slides[i] else np.radians(50))
        leg = np.repeat(start[None], per, 0)
        leg[:, i] += reach * np.concatenate([np.linspace(-1, 1, per - per // 2), np.linspace(1, -1, per // 2)])
        out.append(leg)
    c = clipped(robot, np.vstack(out))
    return 5.0 * np.arange(len(c)) + np.cumsum(rng.uniform(0, 1, len(c))), c


def straights(robot, rng, speed):
    """Straight rails through one point, there and back at a quarter, a half and the whole of the feed."""
    out = []
    start = near(robot, rng, 12)[0]
    if len(robot.arm) < 6:
        return swings(robot, rng, speed)
    while len(out) < 9:
        way = rng.normal(size=3)
        way *= robot.size * 1.3 / np.linalg.norm(way)
        knots = np.linspace(-1, 1, 31)
        first = moved_off(robot, start, corners(robot.pose(start)[0], -way[None] * np.linspace(0.1, 1, 10)[:, None]))
        values = (
            None if first is None else moved_off(robot, first[-1], corners(robot.pose(start)[0], np.outer(knots, way)))
        )
        if values is None:
            start = near(robot, rng, 12)[0]
            continue
        for share in (0.25, 0.5, 1.0):
            there = led(robot, values, 2 * float(np.linalg.norm(way)), speed * share, 2.5)
            joint = [hopped(robot, np.array([out[-1][-1], there[0]]), 0.3, 0.3)] if out else []
            out.append(np.vstack([*joint, there, np.repeat(there[-1:], 60, 0), there[::-1]]))
    c = np.vstack(out)
    return np.arange(len(c)) * STEP, c


def swings(robot, rng, speed):
    """Every axis swings for itself, wider and slower, then narrower and faster, the others at rest."""
    start, out = near(robot, rng, 15)[0], []
    low, high = limits(robot)
    for i in range(len(robot.rows)):
        for share in (1.0, 0.5):
            wide = min(0.2 * (high[i] - low[i]), 0.5 if robot.slides[i] else np.radians(24)) * share
            top = robot.rows[i].speed * robot.unit[i] * min(0.7, 3 * speed) / share**0.5
            period = max(2 * np.pi * wide / top, 1.6)
            x = 2 * np.pi * np.arange(0.0, 2 * period, STEP) / period
            leg = np.repeat(start[None], len(x), 0)
            leg[:, i] += wide * np.sin(x) * np.minimum(1.0, np.minimum(x, x[-1] - x) / np.pi) ** 2
            out.append(leg)
    c = clipped(robot, np.vstack(out))
    return np.arange(len(c)) * STEP, c


def rides(robot, rng, speed):
    """The carriage goes end to end at three speeds, the arm held; then once more with the arm held otherwise."""
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    ends = (row.low + np.array([0.05, 0.95]) * (row.high - row.low)) * 1e-3
    out = []
    for posture in near(robot, rng, 25, count=2):
        for share in (0.15, 0.3, 0.6):
            there = np.repeat(posture[None], 3, 0)
            there[:, i] = ends[[0, 1, 0]]
            join = [] if not out else [hopped(robot, np.array([out[-1][-1], there[0]]), 0.3, 0.3)]
            out += [*join, hopped(robot, there, min(0.7, share * (1 + 4 * speed)), 0.5)]
    c = np.vstack(out)
    return np.arange(len(c)) * STEP, c


POSES = {"hypercube": hypercube, "homing": homing, "legs": legs, "one_by_one": one_by_one}
PATHS = {"straights": straights, "swings": swings, "rides": rides}
