"""DEV's causes without a name, and what a body and its drives leave besides."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["FOREIGN", "drive_leftover", "leftover"]


def _pushed(run, robot, force, give):
    """What joints yield to a force (N, 3) at the tip in world."""
    torque = np.einsum("nij,ni->nj", run.jacobian[0], force)
    return axis_delta(run, {i: torque[:, i] * give[k] for k, i in enumerate(robot.arm)})


def _give(s, rng):
    return rng.uniform(0.8, 1.25, len(s.robot.arm)) / np.array(s.robot.stiffness)


def umbilical(s, rng, strength):
    """An elastic hose from a hook in the hall: it pulls once it is stretched."""
    give, tips = _give(s, rng), np.vstack([r.tip[:: max(1, len(r.t) // 200), :3, 3] for r in s.runs])
    hook = tips.mean(0) + np.array([*rng.uniform(-0.6, 0.6, 2), 1.0]) * 4 * s.robot.size
    loose = np.quantile(np.linalg.norm(tips - hook, axis=1), rng.uniform(0.3, 0.6))
    rate = strength * rng.uniform(1.0, 2.0) * s.robot.rated * 9.81 * 0.3 / s.robot.size

    def link(run):
        to = hook - run.tip[:, :3, 3]
        far = np.linalg.norm(to, axis=1, keepdims=True)
        return _pushed(run, s.robot, rate * np.maximum(far - loose, 0) * to / far, give)

    return Cause("umbilical", BODY, ["A2", "A3"], {}, ["position"], link=link)


def magnet(s, rng, strength):
    """A magnetic gripper above a steel table: it is drawn down by the square of the nearness."""
    give = _give(s, rng)
    table = min(r.tip[:, 2, 3].min() for r in s.runs) - 0.25 * s.robot.size
    reach, full = 0.5 * s.robot.size, strength * s.robot.rated * 9.81 * 0.8

    def link(run):
        force = np.zeros((len(run.t), 3))
        force[:, 2] = -full * (reach / (reach + run.tip[:, 2, 3] - table)) ** 2 * 4
        return _pushed(run, s.robot, force, give)

    return Cause("magnet", BODY, ["A2", "A3"], {}, ["position"], link=link)


def worn_disc(s, rng, strength):
    """A grinding disc gets smaller by the way it has gone, in bites: new again after each dressing, thinner each time."""
    total = sum(float(np.linalg.norm(np.diff(r.tip[:, :3, 3], axis=0), axis=1).sum()) for r in s.runs) / len(s.runs)
    bite, lean = strength * rng.uniform(2e-4, 6e-4), np.array([*rng.normal(size=2) * 0.3, -1.0])
    each = total / rng.uniform(2.2, 4.5)

    def between(run):
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(run.tip[:, :3, 3], axis=0), axis=1))])
        worn = (gone % each) / each + 0.4 * np.floor(gone / each)
        return {-1: np.hstack([np.outer(bite * worn, lean), np.zeros((len(run.t), 3))])}

    return Cause("worn_disc", BODY, [], {}, ["time"], between=between)


def jet(s, rng, strength):
    """A water jet is switched on and off by a clock of its own: its thrust pushes the tool back along itself."""
    give, thrust = _give(s, rng), strength * s.robot.rated * 9.81 * rng.uniform(0.4, 0.9)
    period, share = rng.uniform(0.13, 0.3), rng.uniform(0.35, 0.6)

    def link(run):
        on = ((run.t / run.t[-1] / period) % 1.0 < share).astype(float)
        if not run.rest:
            on = lfilter([run.dt / 0.1], [1, run.dt / 0.1 - 1], on)
        return _pushed(run, s.robot, -thrust * on[:, None] * run.tip[:, :3, 2], give)

    return Cause("jet", BODY, ["A2", "A3"], {}, ["time"], link=link)


def held_back(s, rng, strength):
    """A limit of current: asked for more speed than it can give, an axis falls behind and catches up later."""
    moving = [i for i in s.moving() if i in s.robot.arm]
    if not moving:
        raise ValueError("nothing moves")
    i = int(rng.choice(moving))
    top = 0.7 * float(np.quantile(np.abs(s.runs[-1].v[:, i]), 0.95))
    catch = rng.uniform(0.1, 0.25)

    def drive(run):
        over = np.sign(run.v[:, i]) * np.maximum(np.abs(run.v[:, i]) - top, 0)
        keep = np.exp(-run.dt / catch)
        return axis_delta(run, {i: -0.02 * strength * lfilter([1 - keep], [1, -keep], over)})

    return Cause("held_back", DRIVE, [s.robot.names[i]], {}, ["speed"], drive=drive)


FOREIGN = [
    Description("umbilical", umbilical, frozenset({"tracker", "wrist"}), 60.0, True),
    Description("magnet", magnet, frozenset({"tracker", "wrist"}), 60.0, True),
    Description("worn_disc", worn_disc, frozenset({"tracker", "target_known"}), 60.0, True),
    Description("jet", jet, frozenset({"tracker", "wrist"}), 60.0, True),
    Description("held_back", held_back, frozenset({"path", "setpoints"}), 60.0, True),
]


def leftover(s, rng, strength):
    """Joints give to their neighbours' torques, too, and each link's shape follows the posture of two axes in slow waves."""
    n, arm = len(s.robot.names), s.robot.arm
    cross = np.zeros((n, n))
    stiff = np.array(s.robot.stiffness)
    cross[np.ix_(arm, arm)] = (
        rng.normal(size=(len(arm), len(arm))) * 0.2 / np.sqrt(np.outer(stiff, stiff)) * (1 - np.eye(len(arm)))
    )
    waves = []
    for i in arm[1:]:
        for _ in range(2):
            direction = np.zeros(n)
            direction[rng.choice(arm, 2, replace=False)] = rng.uniform(0.7, 2.5, 2) * rng.choice([-1, 1], 2)
            waves.append((i, direction, rng.uniform(0, 6), rng.normal(size=6) * np.array([4e-5] * 3 + [3e-5] * 3)))

    def link(run):
        return strength * run.load @ cross.T

    def between(run):
        out = {}
        for i, direction, phase, twist in waves:
            out[2 + i] = out.get(2 + i, 0.0) + strength * np.outer(np.sin(run.c @ direction + phase), twist)
        return out

    return Cause("leftover", BODY, link=link, between=between, follows=["position"])


def drive_leftover(s, rng, strength):
    """Inertia that is fed forward as if the arm stood at home, and a torque constant that follows the rotor's warmth."""
    moving = s.moving()
    if not moving:
        raise ValueError("nothing moves")
    size, other = {i: rng.normal() * 1e-4 for i in moving}, {i: int(rng.choice(moving)) for i in moving}

    def drive(run):
        home = np.array(s.robot.home) * s.robot.unit
        return strength * axis_delta(
            run,
            {i: k * run.a[:, i] * np.sin(1.7 * (run.c[:, other[i]] - home[other[i]]) + 0.4) for i, k in size.items()},
        )

    return Cause("leftover", DRIVE, drive=drive, follows=["acceleration"])
