"""What people measure with: poses for a tracker, a cube's faces, a pose from several sides, sweeps, circles, a raster."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

__all__ = ["POSES", "circle", "cube", "raster", "scattered", "several_sides", "sweeps"]

FINE = 0.004  # s, the set-points' clock
JERK_S = 0.06  # s, over which a controller rounds an acceleration


def _limits(robot):
    return tuple(np.array([getattr(r, k) for r in robot.rows]) * robot.unit for k in ("low", "high"))


def _inside(robot, values):
    low, high = _limits(robot)
    return np.all((values > low) & (values < high), axis=-1)


def _home(robot):
    return np.array(robot.home) * robot.unit


def _reached(robot, start, goals, rounds=40):
    """Axis values (K, n) for frames (K, 4, 4) by damped Newton steps from `start`, and which were reached; slides stand."""
    values = np.repeat(start[None], len(goals), 0)
    free = np.where(robot.slides, 0.0, 1.0)
    for _ in range(rounds):
        tip = robot.pose(values)
        turn = Rotation.from_matrix(goals[:, :3, :3] @ tip[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
        error = np.concatenate([goals[:, :3, 3] - tip[:, :3, 3], turn], axis=1)
        J = np.concatenate(robot.jacobian(values), axis=1) * free
        step = np.linalg.solve(J @ J.transpose(0, 2, 1) + 1e-5 * np.eye(6), error[:, :, None])
        values = values + np.clip((J.transpose(0, 2, 1) @ step)[:, :, 0], -0.3, 0.3)
    return values, (np.abs(error).max(axis=1) < 1e-6) & _inside(robot, values)


def _stations(rng, count):
    """When poses were measured: the move, the wait, the tracker's mean."""
    return np.cumsum(rng.uniform(8, 13, count))


def scattered(robot, rng, count):
    """Poses all over the work space, as for a calibration: each axis for itself, the tool above the floor and not in the foot."""
    spread = np.where(robot.slides, 0.8, np.radians(60.0))
    wide = _home(robot) + spread * rng.uniform(-1, 1, (12 * count, len(spread)))
    tip = robot.pose(wide)[:, :3, 3] - robot.base[:3, 3]
    keep = _inside(robot, wide) & (tip[:, 2] > 0.15 * np.linalg.norm(tip, axis=1) - 0.4)
    return _stations(rng, count), wide[keep][:count]


def _tilted(start, where, turn):
    out = np.repeat(start[None], len(where), 0)
    out[:, :3, 3] += where
    out[:, :3, :3] = Rotation.from_rotvec(turn).as_matrix() @ start[:3, :3]
    return out


def cube(robot, rng, count):
    """A grid on two faces of a cube, row by row, at one tilt of the hand a face."""
    side, each = rng.uniform(0.3, 0.6), int(np.ceil(np.sqrt(count / 2)))
    start = robot.pose(_home(robot))[0]
    out = []
    for face in range(2):
        u, w = (x.ravel() for x in np.meshgrid(np.linspace(-0.5, 0.5, each), np.linspace(-0.5, 0.5, each)))
        flat = [u, w, np.full_like(u, -0.5)] if face == 0 else [np.full_like(u, 0.5), u, w]
        turn = np.tile(rng.uniform(-0.25, 0.25, 3), (len(u), 1))
        values, good = _reached(robot, _home(robot), _tilted(start, side * np.stack(flat, 1), turn))
        out.append(values[good])
    c = np.vstack(out)
    c[:, robot.slides] += rng.choice([-0.6, 0.0, 0.6], (len(c), 1)) * np.ones((1, int(robot.slides.sum())))
    return _stations(rng, len(c)), c


def several_sides(robot, rng, count):
    """A few poses, each gone to from six sides; where one comes from is measured, too."""
    goals = scattered(robot, rng, max(4, count // 14))[1]
    rows = []
    for goal in goals:
        for side in range(6):
            sign = rng.choice([-1.0, 1.0], len(goal)) if side > 1 else np.full(len(goal), 1.0 - 2.0 * side)
            away = np.where(robot.slides, 0.1, np.radians(8.0)) * sign * rng.uniform(0.5, 1.0, len(goal))
            rows += [goal - away, goal]
    c = np.clip(np.array(rows), *_limits(robot))
    return _stations(rng, len(c)), c


POSES = {"scattered": scattered, "cube": cube, "several sides": several_sides}


def _stretch(length, speed, acceleration):
    """Way along one stretch at the clock's step: from rest to rest, with rounded accelerations."""
    top = min(speed, np.sqrt(length * acceleration))
    ramp = top / acceleration
    seconds = length / top + ramp
    t = np.arange(0.0, seconds + FINE, FINE)
    v = np.clip(np.minimum(t, seconds - t) / ramp, 0.0, 1.0) * top
    wide = np.pad(v, int(JERK_S / FINE))
    s = np.cumsum(uniform_filter1d(wide, int(JERK_S / FINE))) * FINE
    return s * length / s[-1]


def _driven(robot, where, turn, speed, acceleration):
    """Axis values on the clock along pieces [(K, 3)] with rests of 0.2 s between; None where the arm can't follow."""
    start, out = robot.pose(_home(robot))[0], []
    for piece in where:
        values, good = _reached(robot, _home(robot), _tilted(start, piece, np.tile(turn, (len(piece), 1))))
        if not good.all():
            return None
        place = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(piece, axis=0), axis=1))])
        s = _stretch(place[-1], speed, acceleration)
        out += [CubicSpline(place, values)(s), np.repeat(values[-1:], 50, 0)]
    return np.vstack(out)


def _tried(robot, rng, shape, speed, acceleration):
    """A shape in some plane near home; smaller, until the arm can follow."""
    for k in range(12):
        plane = Rotation.from_rotvec(rng.uniform(-0.3, 0.3, 3)).as_matrix()
        pieces = [p @ plane.T * 0.85**k for p in shape]
        c = _driven(robot, pieces, rng.uniform(-0.15, 0.15, 3), speed, acceleration)
        if c is not None:
            return np.arange(len(c)) * FINE, c
    raise ValueError("no room for this shape")


def circle(robot, rng, speed):
    """Circles to the left and to the right, as in ISO 230-4."""
    angle, radius = np.linspace(0, 2 * np.pi, 61), rng.uniform(0.1, 0.25)
    ring = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    back = np.stack([ring[:, 0], -ring[:, 1], ring[:, 2]], 1)
    return _tried(robot, rng, [ring, ring, back, back], speed, 1.0)


def raster(robot, rng, speed):
    """Lines to and fro with steps between, each cut from rest to rest."""
    long, step, lines = rng.uniform(0.2, 0.35), rng.uniform(0.015, 0.04), int(rng.integers(5, 8))
    share, pieces = np.linspace(-0.5, 0.5, 15), []
    for k in range(lines):
        way = share * long * (1 if k % 2 == 0 else -1)
        across = (k - lines / 2) * step
        pieces.append(np.stack([way, np.full_like(way, across), 0 * way], 1))
        edge = np.linspace(0, step, 5)
        pieces.append(np.stack([np.full_like(edge, way[-1]), across + edge, 0 * edge], 1))
    return _tried(robot, rng, pieces[:-1], speed, 1.5)


def sweeps(robot, rng, speed):
    """One axis after another to and fro, slowly; `speed` in m/s at a metre's reach."""
    start, out = _home(robot) + np.where(robot.slides, 0.0, rng.uniform(-0.15, 0.15, len(robot.rows))), []
    for i in range(len(robot.rows)):
        reach = rng.uniform(0.4, 0.8) if robot.slides[i] else np.radians(rng.uniform(12, 30))
        fast = 4 * speed if robot.slides[i] else speed if i in robot.arm[:3] else 2 * speed
        s = _stretch(reach, fast, 4 * fast)
        for way in (s, reach - s):
            block = np.repeat(start[None], len(s), 0)
            block[:, i] += way - reach / 2
            out.append(block)
        out.append(np.linspace(out[-1][-1], start, 75))  # back to the middle before the next one
        out.insert(-3, np.linspace(start, out[-3][0], 75))
    return np.arange(sum(map(len, out))) * FINE, np.vstack(out)
