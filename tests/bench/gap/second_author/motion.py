"""Set-points: paths of the tool by inverse kinematics, axis-wise moves, and single poses."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation


def limits(robot):
    """Lowest and highest axis values, SI."""
    return tuple(np.array([getattr(r, k) for r in robot.rows]) * robot.unit for k in ("low", "high"))


def ready(robot, rng, spread=18.0):
    """A posture near home, axis by axis, within limits."""
    scale = np.where(robot.slides, 200.0, spread)
    low, high = limits(robot)
    values = (np.array(robot.home) + scale * rng.uniform(-1, 1, len(scale))) * robot.unit
    return np.clip(values, low * 0.9 + high * 0.1, high * 0.9 + low * 0.1)


def followed(robot, start, frames, weights=None):
    """Axis values (K, n) that reach frames (K, 4, 4), one from the other, damped; None where the path can't be followed."""
    values, out = start.copy(), []
    low, high = limits(robot)
    scale = np.array([1.0, 1.0, 1.0, 0.4, 0.4, 0.4])
    share = np.where(robot.slides, 0.5, 1.0) if weights is None else weights
    for goal in frames:
        for _ in range(6):
            tip = robot.pose(values)[0]
            turn = Rotation.from_matrix(goal[:3, :3] @ tip[:3, :3].T).as_rotvec()
            error = np.concatenate([goal[:3, 3] - tip[:3, 3], turn]) * scale
            if np.linalg.norm(error) < 1e-6:
                break
            lin, ang = robot.jacobian(values)
            J = np.vstack([lin[0], ang[0]]) * scale[:, None] * share
            values = values + share * (J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(6), error))
        if np.linalg.norm(error) > 1e-3 or np.any(values < low) or np.any(values > high):
            return None
        out.append(values.copy())
    return np.array(out)


def timed(robot, knots, seconds, dt, share=0.6):
    """Set-points through knots (K, n) by a clamped spline, slower where an axis would pass `share` of its speed."""
    knots = np.asarray(knots)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0) / robot.unit, axis=1) + 1e-9)])
    place = length / length[-1] * seconds
    spline = CubicSpline(place, knots, bc_type="clamped")
    top = np.array([r.speed for r in robot.rows]) * robot.unit * share
    fastest = (np.abs(spline(np.linspace(0, seconds, 2000), 1)) / top).max()
    t = np.arange(0.0, seconds * max(1.0, fastest), dt)
    return t, spline(t / max(1.0, fastest))


def _looking(start, where, tilt):
    out = np.repeat(start[None], len(where), axis=0)
    out[:, :3, 3] = start[:3, 3] + where
    out[:, :3, :3] = Rotation.from_rotvec(tilt).as_matrix() @ start[:3, :3]
    return out


def raster(rng, size):
    """A meander in a tilted plane: offsets (K, 3) and rotation vectors (K, 3)."""
    lines = int(rng.integers(4, 9))
    s = np.linspace(-1, 1, 25)
    flat = [
        np.stack([s * (1 if k % 2 == 0 else -1), np.full_like(s, -1 + 2 * k / (lines - 1))], 1) for k in range(lines)
    ]
    flat = np.vstack(flat) * size * np.array([1.0, rng.uniform(0.4, 1.0)])
    where = (
        np.column_stack([flat, 0.08 * np.abs(flat[:, 0])])
        @ Rotation.random(random_state=rng.integers(1 << 30)).as_matrix()
    )
    return where, np.outer(flat[:, 0] / size, rng.normal(size=3)) * rng.choice([0.0, 0.1, 0.2])


def circles(rng, size):
    """Circles both ways in three planes."""
    phase = np.linspace(0, 2 * np.pi, 41)
    where = []
    for k in range(int(rng.integers(2, 5))):
        turn = phase if k % 2 == 0 else -phase
        ring = np.stack([np.cos(turn) - 1, np.sin(turn), 0 * turn], 1) * size * rng.uniform(0.5, 1)
        where.append(ring @ Rotation.random(random_state=rng.integers(1 << 30)).as_matrix())
    where = np.vstack(where)
    return where, np.cumsum(rng.normal(size=where.shape), 0) * 0.0


def axiswise(robot, rng, start, knots, spread=25.0):
    """Axes wander each for itself: knots (K, n)."""
    low, high = limits(robot)
    scale = np.where(robot.slides, 300.0, spread) * robot.unit
    steps = start + scale * rng.uniform(-1, 1, (knots, len(scale)))
    return np.clip(steps, low * 0.95 + high * 0.05, high * 0.95 + low * 0.05)


def path(robot, rng, kinds, seconds, dt, size=0.18):
    """(t, c) of a path of one of `kinds`, which are functions of (rng, size), or None for axes that wander."""
    for _ in range(12):
        start = ready(robot, rng)
        kind = kinds[rng.integers(len(kinds))]
        if kind is None or len(robot.arm) < 6:
            return timed(robot, axiswise(robot, rng, start, int(rng.integers(8, 16))), seconds, dt)
        where, tilt = kind(rng, size * rng.uniform(0.5, 1.3))
        values = followed(robot, start, _looking(robot.pose(start)[0], where, tilt))
        if values is not None:
            return timed(robot, values, seconds, dt)
    return timed(robot, axiswise(robot, rng, ready(robot, rng), 12), seconds, dt)


def poses(robot, rng, count, spread=35.0, pause=9.0):
    """(t, c) of single poses in the order in which they were measured."""
    start = np.array(robot.home) * robot.unit
    c = axiswise(robot, rng, start, count, spread)
    return np.arange(count) * pause + np.cumsum(rng.uniform(0, 3, count)), c
