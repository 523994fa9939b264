"""Set-points for both families: a tool led along frames at a feed, axis values at stations, single poses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.spatial.transform import Rotation

from gap.second_author.motion import followed, limits

__all__ = ["STEP", "clipped", "corners", "hopped", "led", "moved_off", "near", "ramped"]

STEP = 0.004  # s, the interpolator's cycle


def clipped(robot, values, margin=0.03):
    """Axis values kept off their ends."""
    low, high = limits(robot)
    return np.clip(values, low + margin * (high - low), high - margin * (high - low))


def near(robot, rng, spread, slide=0.25, count=1):
    """Postures (count, n) around home: `spread` degrees, of a slide that share of its way."""
    low, high = limits(robot)
    scale = np.where(robot.slides, slide * (high - low), np.radians(spread))
    home = np.array(robot.home) * robot.unit
    return clipped(robot, home + scale * rng.uniform(-1, 1, (count, len(home))))


def corners(start, where, tilts=None):
    """Frames at offsets (K, 3) in m from a frame, turned by rotation vectors (K, 3)."""
    out = np.repeat(start[None], len(where), axis=0)
    out[:, :3, 3] += where
    if tilts is not None:
        out[:, :3, :3] = Rotation.from_rotvec(tilts).as_matrix() @ start[:3, :3]
    return out


def moved_off(robot, start, frames):
    """Axis values for frames, the carriage standing; None where they are out of reach."""
    return followed(robot, start, frames, np.where(robot.slides, 0.0, 1.0))


def ramped(length, speed, acceleration):
    """Seconds, and the way at a time of a move that starts and ends at rest."""
    speed = min(speed, np.sqrt(length * acceleration))
    rise, total = speed / acceleration, length / speed + speed / acceleration

    def way(t):
        t = np.clip(t, 0.0, total)
        up, down = np.minimum(t, rise), np.clip(t - total + rise, 0.0, rise)
        return acceleration * up**2 / 2 + speed * np.maximum(t - rise, 0) - acceleration * down**2 / 2

    return total, way


def led(robot, values, length, speed, acceleration=1.5):
    """Set-points of one move through axis values (K, n) at even lengths of the tool's way (m, m/s); slower where an axis must."""
    s = np.linspace(0.0, length, len(values))
    curve = CubicSpline(s, values)
    top = np.array([r.speed for r in robot.rows]) * robot.unit * 0.7
    speed = speed / max(1.0, float((np.abs(curve(s, 1)) * speed / top).max()))
    total, way = ramped(length, speed, acceleration)
    return curve(way(np.arange(0.0, total, STEP)))


def hopped(robot, stations, share=0.3, pause=0.4, rate=2.0):
    """Set-points from station to station (K, n), all axes in step, at a share of their speeds; a pause at each."""
    top = np.array([r.speed for r in robot.rows]) * robot.unit * share
    out = [np.repeat(stations[:1], int(pause / STEP) + 1, 0)]
    for a, b in pairwise(stations):
        least = float((np.abs(b - a) / top).max()) + 1e-6
        total, way = ramped(least, 1.0, rate)
        out.append(a + np.outer(way(np.arange(0.0, total, STEP)) / least, b - a))
        out.append(np.repeat(b[None], int(pause / STEP), 0))
    steps = np.vstack(out)
    t = np.arange(len(steps)) * STEP
    keep = slice(None, None, 10)
    return PchipInterpolator(t[keep], steps[keep])(np.minimum(t, t[keep][-1]))  # a drive's jerk filter
