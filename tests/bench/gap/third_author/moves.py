"""How the machines move: Fourier series for calibration, doors of a palletiser, tilted rectangles, spirals on a cone, steps of
one axis at a time; single poses along Halton's sequence, or stations to and fro.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

from gap.second_author.motion import limits


def inside(robot, values, margin=0.06):
    """Axis values kept off their limits."""
    low, high = limits(robot)
    return np.clip(values, low + margin * (high - low), high - margin * (high - low))


def begin(robot, rng):
    """A posture somewhat off home, the hand level where rods hold it so."""
    off = rng.normal(size=len(robot.rows)) * np.where(robot.slides, 60.0, 9.0)
    return inside(robot, levelled(robot, (np.array(robot.home) + off) * robot.unit))


def levelled(robot, values):
    """The axis values with the hand as rods hold it: the last axis of the sum follows the others."""
    weights = np.array(getattr(robot, "level", ()) or np.zeros(len(robot.rows)))
    if not weights.any():
        return values
    last, values = int(np.flatnonzero(weights)[-1]), np.array(values, float)
    total = (weights * np.array(robot.home) * robot.unit).sum()
    values[..., last] += (total - values @ weights) / weights[last]
    return values


def reached(robot, start, places, turns=None):
    """Axis values (K, n) at which the tip is at places (K, 3), m, and, of arms of six axes and more, turned as given (K, 3, 3);
    None where that can't be done.
    """
    out, values = [], start.copy()
    low, high = limits(robot)
    share = np.where(robot.slides, 0.6, 1.0)
    for k, place in enumerate(places):
        for _ in range(12):
            values = levelled(robot, values)
            axes, _, tips = robot.frames(values)
            tip, z = tips[0], np.array([f[0, :3, 2] for f in axes]) * robot.signs[:, None]
            arms = tip[:3, 3] - np.array([f[0, :3, 3] for f in axes])
            error, J = place - tip[:3, 3], np.where(robot.slides, z.T, np.cross(z, arms).T)
            if turns is not None:
                error = np.concatenate([error, 0.3 * Rotation.from_matrix(turns[k] @ tip[:3, :3].T).as_rotvec()])
                J = np.vstack([J, 0.3 * np.where(robot.slides, 0.0, z.T)])
            if np.linalg.norm(error) < 2e-6:
                break
            weights = np.array(getattr(robot, "level", ()) or np.zeros(len(robot.rows)))
            if weights.any():  # what turns with the others to keep the hand level
                J = J - np.outer(J[:, int(np.flatnonzero(weights)[-1])], weights)
                J[:, int(np.flatnonzero(weights)[-1])] = 0.0
            J = J * share
            values = values + share * (J.T @ np.linalg.solve(J @ J.T + 1e-7 * np.eye(len(J)), error))
        values = levelled(robot, values)
        if np.linalg.norm(error) > 5e-4 or np.any(values < low) or np.any(values > high):
            return None
        out.append(values.copy())
    return np.array(out)


def ramped(lasts, dt, rise=0.25):
    """The share of the way (N,) at constant speed between ramps of constant acceleration."""
    x = np.arange(0.0, lasts, dt) / lasts
    up, top = np.minimum(x, rise), 1.0 / (1.0 - rise)
    down = np.maximum(x - (1 - rise), 0.0)
    return top * (0.5 * up * up / rise + np.maximum(x - rise, 0.0) * (x <= 1) - 0.5 * down * down / rise)


def along(robot, knots, lasts, dt, rise, rest):
    """Set-points through dense knots (K, n) with a rest behind; slower where an axis would pass 0.7 of its speed."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0) / robot.unit, axis=1) + 1e-9)])
    top = np.array([r.speed for r in robot.rows]) * robot.unit * 0.7
    curve = PchipInterpolator(length, knots)
    for _ in range(2):
        c = curve(np.minimum(ramped(lasts, dt, rise), 1.0) * length[-1])
        fast = float((np.abs(np.gradient(c, dt, axis=0)) / top).max())
        if fast <= 1.0:
            break
        lasts *= fast
    width = 21  # what smooths the knots' corners: a filter of 84 ms of set-points
    c = np.vstack([np.repeat(c[:1], width, 0), c, np.repeat(c[-1:], width + int(rest / dt), 0)])
    kernel = np.hanning(width + 2)[1:-1]
    soft = np.stack([np.convolve(k, kernel / kernel.sum(), mode="same") for k in c.T], axis=1)
    soft[: width // 2 + 1], soft[-(width // 2 + 1) :] = c[0], c[-1]
    return soft


def joined(pieces, dt):
    """(t, c) of pieces that follow one another."""
    c = np.vstack(pieces)
    return np.arange(len(c)) * dt, c


def fourier(robot, rng, seconds, dt):
    """Five harmonics of a slow base frequency on each axis (Swevers), which begin and end gently."""
    t = np.arange(0.0, seconds, dt)
    base, n = 1.0 / rng.uniform(8.0, 20.0), len(robot.rows)
    middle, k = begin(robot, rng), np.arange(1, 6)
    a, phase = rng.normal(size=(n, 5)) / k ** rng.uniform(0.6, 1.5), rng.uniform(0, 2 * np.pi, (n, 5))
    waves = np.sin(2 * np.pi * base * t[:, None, None] * k + phase) - np.sin(phase)
    raw = (waves * a).sum(2)
    raw /= np.abs(raw).max(0) + 1e-9
    raw *= np.where(robot.slides, rng.uniform(60, 400), rng.uniform(8, 35)) * robot.unit
    gentle = np.clip(t / 1.5, 0, 1) ** 2 * (3 - 2 * np.clip(t / 1.5, 0, 1))
    c = inside(robot, levelled(robot, middle + raw * gentle[:, None]))
    top = np.array([r.speed for r in robot.rows]) * robot.unit * 0.7
    fast = max(1.0, float((np.abs(np.gradient(c, dt, axis=0)) / top).max()))
    slow = np.arange(0.0, seconds, dt) / fast
    return t, np.stack([np.interp(slow, t, x) for x in c.T], axis=1)


def steps(robot, rng, seconds, dt):
    """One axis after another to some stations and back, the others still, as machines' axes are tested."""
    c, pieces = begin(robot, rng), []
    while sum(map(len, pieces)) * dt < seconds:
        for i in rng.permutation(len(robot.rows)):
            span = (
                (rng.uniform(80, 500) if robot.slides[i] else rng.uniform(6, 40)) * robot.unit[i] * rng.choice([-1, 1])
            )
            stations = [
                *np.linspace(0, span, int(rng.integers(3, 6)))[1:],
                *np.linspace(span, 0, int(rng.integers(2, 5)))[1:],
            ]
            start = c.copy()
            for station in stations:
                to = start.copy()
                to[i] += station
                to = inside(robot, levelled(robot, to))
                pieces.append(
                    along(robot, np.linspace(c, to, 12), rng.uniform(0.4, 1.2), dt, 0.3, rng.uniform(0.1, 0.5))
                )
                c = to
    return joined(pieces, dt)


def doors(rng, size):
    """A palletiser's door: up, across, down, and the same way back to other places."""
    out, at = [], np.zeros(3)
    for _ in range(int(rng.integers(4, 9))):
        to = np.append(rng.uniform(-1, 1, 2) * size, rng.uniform(-0.2, 0.3) * size)
        over = max(at[2], to[2]) + rng.uniform(0.2, 0.6) * size
        corners = np.array([at, [at[0], at[1], over], [to[0], to[1], over], to])
        out.append(("door", corners))
        at = to
    return out


def rectangles(rng, size):
    """Rectangles in a tilted plane, each round twice, one way and the other, the corners sharp."""
    turn = Rotation.random(random_state=int(rng.integers(1 << 30)))
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 0.7, 0], [0, 0.7, 0], [0, 0, 0]]) * size
    out = []
    for k in range(int(rng.integers(2, 5))):
        here = turn.apply(corners * rng.uniform(0.5, 1.0))[:: 1 if k % 2 else -1]
        out += [("edge", pair) for pair in pairwise(here)]
    return out


def spiral(rng, size):
    """Out along a spiral on a cone, and in again."""
    angle = np.linspace(0, 2 * np.pi * rng.uniform(2, 5), 160)
    r = angle / angle[-1] * size * 0.8
    flat = np.stack([r * np.cos(angle), r * np.sin(angle), r * rng.uniform(-0.6, 0.6)], 1)
    flat = Rotation.random(random_state=int(rng.integers(1 << 30))).apply(flat)
    return [("out", flat), ("in", flat[::-1])]


def cartesian(robot, rng, seconds, dt, kind):
    """(t, c) of a path of the tip, repeated until the time is filled; None where the arm doesn't reach."""
    start = begin(robot, rng)
    tip = robot.pose(start)[0]
    whole = len(robot.arm) >= 6
    size = (0.2 if len(robot.arm) == 4 else 0.35) * rng.uniform(0.5, 1.1)
    swing = rng.normal(size=3) * rng.choice([0.0, 0.25])
    pieces, values, rise, rest = [], start, rng.uniform(0.15, 0.4), float(rng.choice([0.0, 0.05, 0.3]))
    speed = rng.uniform(0.05, 0.4)
    for _, corners in kind(rng, size):
        corners = np.asarray(corners) * (np.array([1, 1, 0.35]) if len(robot.arm) == 4 else 1.0)
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        dense = np.linspace(0, way[-1], max(12, int(way[-1] / 0.015)))
        places = tip[:3, 3] + np.stack([np.interp(dense, way, x) for x in corners.T], axis=1)
        lean = np.outer((places - tip[:3, 3]) @ np.array([0.6, 0.6, 0.5]) / size, swing)
        turns = Rotation.from_rotvec(lean).as_matrix() @ tip[:3, :3] if whole else None
        if np.linalg.norm(robot.pose(values)[0][:3, 3] - places[0]) > 1e-3:  # to the first place, from where it stands
            first = reached(robot, values, places[:1], None if turns is None else turns[:1])
            if first is None:
                return None
            pieces.append(along(robot, np.linspace(values, first[0], 15), 1.5, dt, rise, 0.1))
            values = first[0]
        knots = reached(robot, values, places, turns)
        if knots is None:
            return None
        knots[0] = values  # where it stands, to some micrometres
        pieces.append(along(robot, knots, max(0.5, way[-1] / speed), dt, rise, rest))
        values = knots[-1]
    turn = [p[::-1] for p in reversed(pieces)]
    t, c = joined(pieces, dt)
    while t[-1] < seconds:
        t, c = joined([c, *turn, *pieces], dt)
    return t, c


def paths(robot, rng, seconds, dt):
    """One of the five motions."""
    for _ in range(8):
        draw = rng.random()
        if draw < 0.25:
            return fourier(robot, rng, seconds, dt)
        if draw < 0.45:
            return steps(robot, rng, seconds, dt)
        kind = doors if draw < 0.65 else rectangles if draw < 0.85 else spiral
        found = cartesian(robot, rng, seconds, dt, kind)
        if found is not None:
            return found
    return fourier(robot, rng, seconds, dt)


def postures(robot, rng, count):
    """(t, c) of single poses: Halton's sequence over the axes, or stations that are visited in turn, to and fro."""
    n = len(robot.rows)
    if rng.random() < 0.25 and count >= 24:
        stations = max(8, count // 4)
        spread = 2 * qmc.Halton(n, seed=int(rng.integers(1 << 30))).random(stations) - 1
        order = np.concatenate([np.arange(stations), np.arange(stations - 1)[::-1]])
        order = np.resize(np.concatenate([order, order[1:-1]]), count)
        spread = spread[order]
    else:
        spread = 2 * qmc.Halton(n, seed=int(rng.integers(1 << 30))).random(count) - 1
    wide = np.where(robot.slides, rng.uniform(80, 500), rng.uniform(18, 45)) * robot.unit
    c = inside(robot, levelled(robot, np.array(robot.home) * robot.unit + spread * wide))
    return np.cumsum(rng.uniform(5, 14, count)), c
