"""Causes that the contract has no name for, and smooth fields that no model of theirs holds."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.fourth_author.causes import compliance_of, dahl
from gap.second_author.chain import GRAVITY
from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause

__all__ = ["FOREIGN", "drive_leftover", "leftover"]


def reseated(setting, rng, strength):
    """The reflector was taken off its nest and put back, or knocked: a step at some row."""
    step, when = strength * rng.normal(0, 1e-4, 3), rng.uniform(0.2, 0.8)

    def measured(run, tool):
        out = tool.copy()
        behind = run.t > run.t[0] + when * np.ptp(run.t)
        out[behind, :3, 3] += np.einsum("nij,j->ni", tool[behind, :3, :3], step)
        return out

    return Cause("reseated reflector", BODY, [], {}, ["time"], measured=measured)


def soft_holder(setting, rng, strength):
    """A tool's holder bends like a stub of rubber: the tip goes where weight pulls it, seen from the hand."""
    soft = strength * 1e-4 * np.array([1.0, rng.uniform(0.2, 0.8), 0.1])

    def between(run):
        pull = run.tip[:, :3, :3].transpose(0, 2, 1) @ (GRAVITY / 9.81)
        return {-1: np.concatenate([pull * soft, np.zeros_like(pull)], axis=1)}

    return Cause("soft holder", BODY, ["A6"], {}, ["load", "position"], between=between)


def dress_pack(setting, rng, strength):
    """Hoses clamped at forearm and hand wind the wrist up: a spring that stiffens as A6 turns from where they hang free."""
    a5, a6 = setting.robot.arm[4:]
    k, free = strength * np.radians(0.01), rng.uniform(-0.5, 0.5)

    def link(run):
        x = run.c[:, a6] - free
        return axis_delta(run, {a6: -k * x * (1 + x * x), a5: 0.5 * k * x * x})

    return Cause("dress pack", BODY, [setting.names[a5], setting.names[a6]], {}, ["position"], link=link)


def lorry(setting, rng, strength):
    """Something heavy stands in the hall for a while: the floor under the foot dips and tilts, and comes back."""
    depth, tilt = strength * 1e-4, strength * 5e-5 * rng.normal(0, 1, 2)
    middle, wide = rng.uniform(0.3, 0.7), rng.uniform(0.08, 0.2)

    def between(run):
        bump = np.exp(-0.5 * (((run.t - run.t[0]) / np.ptp(run.t) - middle) / wide) ** 2)
        return {0: bump[:, None] * np.array([0, 0, -depth, *tilt, 0])}

    return Cause("floor that dips", BODY, [], {}, ["time"], between=between)


def ringing(setting, rng, strength):
    """The arm rings at 6 to 15 Hz, hardly damped, after each change of A1's acceleration."""
    i, hertz, damped = setting.robot.arm[0], rng.uniform(6, 15), rng.uniform(0.02, 0.06)

    def link(run):
        w, dt = 2 * np.pi * hertz, run.dt
        decay, turn = np.exp(-damped * w * dt), np.cos(w * dt * np.sqrt(1 - damped**2))
        jerk = np.gradient(run.a[:, i], dt)
        wave = lfilter([0.0, dt * np.sin(w * dt) / w], [1, -2 * decay * turn, decay**2], jerk)
        return axis_delta(run, {i: -strength * 1e-3 * wave})

    return Cause("ringing", BODY, [setting.names[i]], {}, ["acceleration"], link=link)


def notching(setting, rng, strength):
    """A brake whose disc is bent rubs once a turn of the motor's slow side: the loop falls behind where it rubs."""
    i = setting.arm(rng)[0]
    place, wide, size = rng.uniform(-0.3, 0.3), rng.uniform(0.1, 0.25), strength * np.radians(0.004)

    def drive(run):
        at = run.c[:, i] - setting.robot.home[i] * setting.robot.unit[i] - place
        return axis_delta(run, {i: -size * np.tanh(run.v[:, i] / 0.01) * np.exp(-0.5 * (at / wide) ** 2)})

    return Cause("rubbing brake", DRIVE, [setting.names[i]], {}, ["position", "direction"], drive=drive)


FOREIGN = [
    Description("reseated reflector", reseated, frozenset({"tracker"}), foreign=True, most=60.0),
    Description("soft holder", soft_holder, frozenset({"tracker"}), foreign=True, most=60.0),
    Description("dress pack", dress_pack, frozenset({"tracker"}), foreign=True, most=60.0),
    Description("floor that dips", lorry, frozenset({"tracker"}), foreign=True, most=60.0),
    Description("ringing", ringing, frozenset({"tracker", "path"}), foreign=True, most=400.0),
    Description("rubbing brake", notching, frozenset({"path", "setpoints", "drives"}), foreign=True, most=60.0),
]


def leftover(setting, rng, strength):
    """Gears that stiffen under torque, bearings that tilt, hoses that drag, and a warm side that bows: all in one, in parts."""
    robot, parts = setting.robot, rng.dirichlet(np.ones(4))
    arm, soft = robot.arm, compliance_of(robot)
    top = np.abs(setting.runs[0].load).max(axis=0) + 1.0
    roller, lag, bow = rng.uniform(0, 6.28, 2), np.radians(rng.uniform(5, 15)), rng.uniform(0, 6.28)

    def link(run):
        eased = run.load / top
        out = parts[0] * soft * top * (eased * np.abs(eased) - eased**3)
        out[:, [i for i in range(len(robot.rows)) if i not in arm[:3]]] = 0.0
        for k, i in enumerate((arm[3], arm[5])):
            out[:, i] -= parts[1] * 2e-4 * (1 + 0.5 * k) * dahl(run.c[:, i] * np.cos(run.c[:, arm[4]]), lag)
        return strength * out

    def between(run):
        m, q = run.moments[:, arm[1]], run.c[:, arm[0]]
        zero = np.zeros(len(q))
        give = parts[2] * 1e-4 * (1 + 0.6 * np.cos(2 * q + roller[0])) / (np.abs(m).max() + 1.0)
        warm = parts[3] * 1e-4 * (0.5 + 0.5 * np.sin(2 * np.pi * run.clock / 900 + bow)) * np.sin(q + roller[1])
        return {
            2 + arm[1]: strength * np.stack([zero, zero, zero, give * m[:, 0], give * m[:, 1], zero], 1),
            2 + arm[0]: strength * np.stack([zero, zero, 0.3 * warm, warm, zero, zero], 1),
        }

    return Cause("leftover", BODY, [], {}, [], link=link, between=between)


def drive_leftover(setting, rng, strength):
    """Of drives: friction that is stiffer where the grease is old, and a current loop whose gain follows posture."""
    arm, n = setting.robot.arm[:3], len(setting.names)
    phase = rng.uniform(0, 6.28, n)

    def drive(run):
        q = run.c[:, arm].sum(axis=1)
        parts = {
            i: -1e-5 * np.tanh(run.v[:, i] / 0.02) * np.sin(2 * q + phase[i])
            + 1e-5 * np.cos(q + phase[i]) * run.v[:, i]
            for i in arm
        }
        return axis_delta(run, {i: strength * x for i, x in parts.items()})

    return Cause("leftover", DRIVE, [], {}, [], drive=drive)
