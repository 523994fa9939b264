"""What is always there and has no name: hoses that pull on axes, seats that creep under a turning load; products of speeds."""

from __future__ import annotations

import numpy as np

from gap.second_author.family import axis_delta
from gap.second_author.run import BODY, DRIVE, Cause
from gap.third_author.tools import filtered, played, small_step, twists


def leftover(setting, rng, s):
    """Hoses: each pulls two axes by the third power of how far they stand from where it hangs free, and in part by where they
    came from. Seats of hand and foot: they give to the side to which the tool's own weight points, and of that a part late.
    """
    robot = setting.robot
    n = len(robot.rows)
    mixed, middle = rng.normal(size=(n, n)) * 0.4 + np.eye(n), rng.uniform(-0.6, 0.6, n)
    size, drags = rng.normal(size=n), rng.uniform(0.05, 0.35)
    seat, foot, late = rng.normal(size=(3, 3)), rng.normal(size=(2, 2)), rng.uniform(0.1, 0.6)
    spread = np.where(robot.slides, 0.6, 0.9)
    base = np.array(robot.home) * robot.unit

    def link(run):
        u = ((run.c - base) / spread) @ mixed.T - middle
        pull = np.tanh(u) ** 3 + 0.2 * u * np.abs(u) / (1 + u * u)
        out = {}
        for i in range(n):
            side = played(u[:, i], 0.15) - u[:, i] if not run.rest else -0.15 * np.tanh(run.came[:, i] / 0.1)
            out[i] = s * size[i] * small_step(robot, i) * (pull[:, i] + drags * side / 0.15)
        return axis_delta(run, out)

    def between(run):
        down = -run.tip[:, 2, :3]
        if not run.rest:
            slow = np.stack([filtered([1.0], [20.0, 1.0], run.dt, w - w[0]) + w[0] for w in down.T], axis=1)
            down = (1 - late) * down + late * slow
        give = s * 5e-5 * (down**2 * np.sign(down)) @ seat.T
        reach = run.tip[:, :2, 3] / 2.0
        tilt = s * 2e-5 * (reach * np.abs(reach)) @ foot.T
        return {-1: twists(run, *give.T), robot.root: twists(run, rx=tilt[:, 0], ry=tilt[:, 1])}

    return Cause("leftover", BODY, [], {}, ["position", "direction"], link=link, between=between)


def drive_leftover(setting, rng, s):
    """Torques of Coriolis that nobody feeds forward, by products of two axes' speeds, through a loop that rings a little; and
    the swell of a notch filter.
    """
    robot = setting.robot
    n = len(robot.rows)
    pairs = rng.normal(size=(n, n, n)) * (rng.random((n, n, n)) < 0.4)
    w, damping = 2 * np.pi * rng.uniform(3, 7), rng.uniform(0.3, 0.6)
    notch, share = 2 * np.pi * rng.uniform(6, 12), rng.normal(size=n)

    def drive(run):
        v = run.v / (np.abs(run.v).max(0) + 1e-9)
        a = run.a / (np.abs(run.a).max(0) + 1e-9)
        out = {}
        for i in range(n):
            torque = np.einsum("jk,nj,nk->n", pairs[i], v, v)
            loop = filtered([w * w], [1.0, 2 * damping * w, w * w], run.dt, torque)
            swell = filtered([notch, 0.0], [1.0, 0.3 * notch, notch**2], run.dt, a[:, i])
            out[i] = s * 0.15 * small_step(robot, i) * (loop + share[i] * swell)
        return axis_delta(run, out)

    return Cause("leftover", DRIVE, [], {}, ["speed", "acceleration"], drive=drive)
