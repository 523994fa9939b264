"""DEV's procedures: the cube of ISO 9283, a grid, a morning's warm-up, stations of a track; ball-bar circles, shuttles, steps."""

from __future__ import annotations

import numpy as np

from gap.fifth_author.paths import STEP, corners, hopped, led, moved_off, near

__all__ = ["PATHS", "POSES", "ballbar", "cube", "grid", "shuttle", "stations", "warm_up"]


def cube(robot, rng, count):
    """The five poses of ISO 9283 in the plane that cuts a cube aslant, in cycles, in two or three cubes."""
    per, out = max(4, count // 15), []
    corner = np.array([(0, 0, 0), (-1, -1, 1), (1, -1, 1), (1, 1, -1), (-1, 1, -1)]) * 0.8
    while len(out) < 3:
        start = near(robot, rng, 14)[0]
        tilts = rng.normal(size=(5, 3)) * 0.12
        values = moved_off(
            robot, start, corners(robot.pose(start)[0], corner * robot.size * rng.uniform(0.7, 1.1), tilts)
        )
        out += [] if values is None else [np.tile(values[::-1], (per, 1))]
    c = np.vstack(out)
    return 6.0 * np.arange(len(c)) + 2.0 * rng.uniform(0, 1, len(c)), c


def grid(robot, rng, count):
    """Points of a grid in a box, each with its own lean of the tool: what calibrations are made from."""
    out = []
    start = near(robot, rng, 8)[0]
    while len(out) < count:
        spot = rng.integers(-2, 3, 3) / 2.0 * robot.size * 1.1
        frame = corners(robot.pose(start)[0], spot[None], rng.normal(size=(1, 3)) * 0.3)
        values = moved_off(robot, start, frame)
        out += [] if values is None else [values[0]]
    return 12.0 * np.arange(count) + np.cumsum(rng.uniform(0, 3, count)), np.array(out)


def warm_up(robot, rng, count):
    """A cold machine works from the morning on; every few minutes it goes through the same eight poses."""
    eight = near(robot, rng, 30, count=8)
    rounds = max(5, count // 8)
    every = rng.uniform(2.0, 3.2) * 3600 / rounds
    t = (np.arange(rounds)[:, None] * every + np.arange(8) * 7.0).ravel()
    return t, np.tile(eight, (rounds, 1))


def stations(robot, rng, count):
    """A carriage goes to stations and back, and takes the same few postures at each."""
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    places = np.linspace(row.low, row.high, int(rng.integers(11, 17)))[1:-1] * 1e-3 * rng.uniform(0.85, 1.0)
    places = np.concatenate([places, places[::-1]])
    postures = near(robot, rng, 28, count=max(2, count // len(places)))
    c = np.repeat(places, len(postures))[:, None] * np.eye(len(robot.rows))[i] + np.tile(
        np.where(np.arange(len(robot.rows)) == i, 0.0, postures), (len(places), 1)
    )
    return 8.0 * np.arange(len(c)) + 20.0 * (np.arange(len(c)) // len(postures)), c


def ballbar(robot, rng, speed):
    """Circles of one radius about one point in three planes, each both ways, with a swing in and out."""
    turn = np.linspace(0, 2 * np.pi, 49)
    while True:
        start = near(robot, rng, 12)[0]
        radius, out = robot.size * rng.uniform(0.55, 0.9), []
        for plane in ((0, 1), (1, 2), (0, 2)):
            where = np.zeros((len(turn), 3))
            where[:, plane[0]], where[:, plane[1]] = np.cos(turn), np.sin(turn)
            values = moved_off(robot, start, corners(robot.pose(start)[0], where * radius))
            if values is None:
                break
            ring = led(robot, values, 2 * np.pi * radius, speed)
            out += [ring, ring[::-1]]
        if len(out) == 6:
            stops = [out[0]]
            for k in out[1:]:
                stops += [hopped(robot, np.array([stops[-1][-1], k[0]]), 0.25, 0.6), k]
            c = np.vstack(stops)
            return np.arange(len(c)) * STEP, c


def shuttle(robot, rng, speed):
    """The carriage runs its way there and back without a stop between while the arm changes its posture slowly."""
    i, row = robot.carriage[-1], robot.rows[robot.carriage[-1]]
    ends = np.array([row.low, row.high]) * 0.92e-3
    postures = near(robot, rng, 16, count=5)
    postures[:, i] = ends[np.arange(5) % 2]
    c = hopped(robot, postures, min(0.5, 4 * speed), 1.0)
    return np.arange(len(c)) * STEP, c


def raster_steps(robot, rng, speed):
    """All axes from posture to posture at a share of their speeds, with stops."""
    c = hopped(robot, near(robot, rng, 22, slide=0.1, count=11), min(0.6, 3.5 * speed), 0.5)
    return np.arange(len(c)) * STEP, c


POSES = {"cube": cube, "grid": grid, "warm_up": warm_up, "stations": stations}
PATHS = {"ballbar": ballbar, "shuttle": shuttle, "steps": raster_steps}
