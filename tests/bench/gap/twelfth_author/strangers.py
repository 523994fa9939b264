"""Causes for which no library has a name, each with the place where it truly is (see the plan)."""

from __future__ import annotations

import numpy as np

from .bodies import _moved, _steady
from .chains import overturning, tips, weights
from .drives import Change, only


def taut_dress_pack(run, axes, rng, size):
    """A pack of hoses is long enough until A4 has turned by 50 degrees; then it pulls the fork of the wrist to itself."""
    q = run.values[:, run.chain.index("A4")]
    over = np.maximum(0.0, np.abs(q) - np.radians(50))
    link = np.zeros_like(run.values)
    link[:, run.chain.index("A5")] = -size * over**1.5 * np.cos(run.values[:, run.chain.index("A5")])
    return Change(link=link)


def spring_loses_pressure(run, axes, rng, size):
    """A gas spring behind A2 leaks: what it carried weighs on the gear more and more, by the time and by the lean."""
    u = (run.t - run.t[0]) / np.ptp(run.t)
    tau = weights(run.chain, run.values)[:, axes]
    return Change(link=only(run, axes, -size * u[:, None] ** 0.8 * tau / np.abs(tau).max()))


def cracked_flange_bolt(run, axes, rng, size):
    """One of six bolts is through: the joint gapes where the tool's weight pulls on that side, and lies flat where it doesn't."""
    T = tips(run.chain, run.values)
    down = -T[:, 2, :3]  # gravity in the tool's axes
    pull = down @ np.array([0.8, -0.6, 0.0])
    gape = np.where(pull > 0.15, 0.6 + 0.4 * np.minimum(1, (pull - 0.15) / 0.5), 0.0)
    twist = np.zeros((len(pull), 6))
    twist[:, 3:] = size * gape[:, None] * np.array([0.6, 0.8, 0.0])
    return Change(twists={"A6": twist})


def belt_slips(run, axes, rng, size):
    """A toothed belt jumps now and then as the wrist is driven hard one way: what is lost stays lost."""
    a = run.accelerations[:, axes[0]]
    hard = a > 0.8 * a.max()
    jumps = np.flatnonzero(np.diff(hard.astype(int)) == 1)
    lost = np.zeros(len(a))
    for k in jumps[len(jumps) // 3 :]:
        lost[k:] += 1
    return Change(link=only(run, axes, -size * lost[:, None]))


def encoder_of_another_scale(run, axes, rng, size):
    """An encoder was replaced by one whose interpolation is told as another: the axis moves by a share more than is reported."""
    at = np.array(run.chain.home)[axes] * run.chain.unit[axes]
    return Change(link=only(run, axes, size * (run.values[:, axes] - at)))


def rocking_foot(run, axes, rng, size):
    """Two of eight anchors are loose: the plate lies on one edge or on the other, by which side the arm reaches to."""
    M = overturning(run.chain, run.values)
    side = np.tanh(M / (0.08 * np.abs(M).max()))
    twist = np.zeros((len(M), 6))
    twist[:, 3] = size * side[:, 0]
    twist[:, 2] = 0.15 * size * np.abs(side[:, 0])
    return Change(twists={"root": twist})


def encoder_loses_counts(run, axes, rng, size):
    """A scratch on the index track: counts are lost whenever the axis passes one place upwards."""
    q = run.values[:, axes[0]]
    at = np.median(q) + 0.1 * np.ptp(q)
    passed = np.concatenate([[0], np.cumsum((q[:-1] < at) & (q[1:] >= at))])
    return Change(link=only(run, axes, size * passed[:, None]))


def recorder_smooths_setpoints(run, axes, rng, size):
    """The logger holds a mean of the last set-points beside encoders as they are: commands seem to trail what was done."""
    dt = run.t[1] - run.t[0]
    total = np.vstack([np.zeros(run.values.shape[1]), np.cumsum((run.values[1:] + run.values[:-1]) / 2 * dt, axis=0)])
    since = run.t - max(size, 1e-6)
    before = np.stack([np.interp(since, run.t, total[:, i]) for i in range(total.shape[1])], axis=1)
    before += np.minimum(since - run.t[0], 0.0)[:, None] * run.values[0]
    return Change(setpoint=(total - before) / max(size, 1e-6) - run.values)


def worn_first_bearing(run, axes, rng, size):
    """The races of the crossed rollers of A1 are worn: the axis leans twice a turn, and three times."""
    q = run.values[:, axes[0]]
    twist = np.zeros((len(q), 6))
    twist[:, 3] = size * (np.cos(3 * q) + 0.6 * np.sin(5 * q + 0.3))
    twist[:, 4] = size * (np.sin(3 * q + 0.2) - 0.5 * np.cos(5 * q))
    return Change(twists={run.chain.joints[axes[0]].name: twist})


def press_next_door(run, axes, rng, size):
    """A press stamps beside the cell, 0.4 times a second: floor and tripod ring at 3.1 Hz behind each stroke."""
    since = run.t % 2.5
    ring = np.exp(-since / 0.45) * np.sin(2 * np.pi * 3.1 * since)
    return Change(seen=[_moved(lambda T, run: ring[:, None] * size * np.array([0.35, 0.2, 0.9]))])


def spindle_grows(run, axes, rng, size):
    """A long spindle heats up, stands, and heats up again: the tip comes out along the tool."""
    u = (run.t - run.t[0]) / np.ptp(run.t)
    on = np.where((u < 0.35) | (u > 0.6), 1.0, 0.0)
    warm, state = np.zeros(len(u)), 0.0
    for k in range(len(u)):
        state += (on[k] - state) * 4.0 / len(u) * 1.6
        warm[k] = state
    twist = np.zeros((len(u), 6))
    twist[:, 2] = -size * warm
    return Change(twists={"tool": twist})


def interpolation_cycle_changes(run, axes, rng, size):
    """From three sevenths on the controller interpolates in a longer cycle: all axes come later by half of it, in steps."""
    changed = run.t > run.t[0] + np.ptp(run.t) * 3 / 7
    cycle = max(size, 1e-4)
    late = np.floor(run.t / cycle) * cycle
    steps = np.stack([np.interp(late, run.t, run.values[:, i]) for i in range(run.values.shape[1])], axis=1)
    return Change(drive=np.where(changed[:, None], steps - run.values, 0.0))


def linkage_of_another_length(run, axes, rng, size):
    """A rod between A2 and A3 was remade: A3 turns as A2 does, by a share that bends."""
    q2 = run.values[:, run.chain.index("A2")]
    q2 = q2 - q2.mean()
    link = np.zeros_like(run.values)
    link[:, run.chain.index("A3")] = size * (np.sin(1.7 * q2) + 0.5 * q2**2)
    return Change(link=link)


STRANGERS = {
    f.__name__: f
    for f in (
        taut_dress_pack,
        spring_loses_pressure,
        cracked_flange_bolt,
        belt_slips,
        encoder_of_another_scale,
        rocking_foot,
        encoder_loses_counts,
        recorder_smooths_setpoints,
        worn_first_bearing,
        press_next_door,
        spindle_grows,
        interpolation_cycle_changes,
        linkage_of_another_length,
    )
}

__all__ = ["STRANGERS", "_steady"]
