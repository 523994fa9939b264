"""What a structure, a carriage, a table or an instrument does: one function a cause, of the size that it is given."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from .chains import motion, overturning
from .drives import Change


def _steady(run, twist):
    return np.tile(np.asarray(twist, float), (len(run.t), 1))


def geometry(run, axes, rng, size):
    """Links of other lengths and leans (size: m; mrad beside it), no zeros of turning axes among it."""
    twists = {}
    for i in axes:
        joint = run.chain.joints[i]
        way = rng.standard_normal(6)
        way[2 if joint.kind == "P" else 5] = 0.0
        way[:3] *= 1.0 / np.linalg.norm(way[:3])
        way[3:] *= 0.8 / np.linalg.norm(way[3:])
        twists[joint.name] = _steady(run, size * way)
    return Change(twists=twists)


def frame_base(run, axes, rng, size):
    """The foot stands elsewhere (size: m and, of the lean, rad by 1 m)."""
    return Change(twists={"root": _steady(run, size * np.array([0.7, -0.5, 0.3, 0.35, -0.5, 0.6]))})


def frame_tool(run, axes, rng, size):
    """A tip that was knocked."""
    return Change(twists={"tool": _steady(run, size * np.array([0.8, -0.4, 0.45, 1.1, 0.6, 0.0]))})


def frame_table(run, axes, rng, size):
    """A table's axis that leans and stands aside."""
    return Change(
        twists={run.chain.joints[axes[0]].name: _steady(run, size * np.array([0.7, -0.6, 0.4, 0.9, -0.7, 0.0]))}
    )


def track(run, axes, rng, size, *, waves=1.3):
    """Rails that bow to the side and in height, turn what they carry, and a rack whose pitch is off."""
    i = axes[0]
    low, high = run.chain.joints[i].low * 1e-3, run.chain.joints[i].high * 1e-3
    u = (run.values[:, i] - low) / (high - low)
    twist = np.zeros((len(u), 6))
    twist[:, 0] = size * np.sin(np.pi * waves * u + 0.5)
    twist[:, 1] = 0.8 * size * np.cos(np.pi * waves * u)
    twist[:, 2] = 0.9 * size * u
    twist[:, 4] = 0.25 * size * np.sin(np.pi * waves * u)
    return Change(twists={run.chain.joints[i].name: twist})


def lean(run, axes, rng, size):
    """What carries the arm leans by the moment of all weights (size: rad by the largest); higher up on a lift by more."""
    M = overturning(run.chain, run.values)
    share = np.ones(len(M))
    if axes and run.chain.joints[axes[0]].role == "carriage":
        share = 0.4 + 0.6 * run.values[:, axes[0]] / (run.chain.joints[axes[0]].high * 1e-3)
    twist = np.zeros((len(M), 6))
    twist[:, 3:5] = size * share[:, None] * M / np.abs(M).max()
    return Change(twists={"root": twist})


def turntable(run, axes, rng, size):
    """A plate that wobbles and runs out by its own angle, and hangs back a little behind each reversal."""
    i = axes[0]
    q = run.values[:, i]
    twist = np.zeros((len(q), 6))
    twist[:, 0], twist[:, 1] = size * np.cos(q + 0.6), size * np.sin(q + 0.6)
    twist[:, 3], twist[:, 4] = 0.9 * size * np.cos(q - 0.3), 0.9 * size * np.sin(q - 0.3)
    return Change(twists={run.chain.joints[i].name: twist})


def _moved(shift):
    def look(T, run):
        out = T.copy()
        out[:, :3, 3] += shift(T, run)
        return out

    return look


def measurement_frame(run, axes, rng, size):
    """An instrument whose own frame is told wrongly."""
    turn = motion(size * np.array([0.6, 0.7, -0.3, 0.35, 0.4, -0.55]))
    return Change(seen=[lambda T, run: turn @ T])


def measurement_scale(run, axes, rng, size):
    """A yardstick that is off (size: of one), from the instrument on."""
    stand = np.array([2.5, -1.5, 1.1])
    return Change(seen=[_moved(lambda T, run: size * (T[:, :3, 3] - stand))])


def measurement_drift(run, axes, rng, size):
    """A stand that settles and turns (size: m at the end)."""

    def shift(T, run):
        u = (run.t - run.t[0]) / np.ptp(run.t)
        late = (1 - np.exp(-2.2 * u)) / (1 - np.exp(-2.2))
        turn = Rotation.from_rotvec(np.outer(late, size * np.array([0.1, 0.15, 0.35]))).apply(T[:, :3, 3]) - T[:, :3, 3]
        return late[:, None] * size * np.array([0.5, -0.4, 0.75]) + turn

    return Change(seen=[_moved(shift)])


def latency(run, axes, rng, size):
    """Readings that come late (size: s)."""

    def look(T, run):
        out = T.copy()
        for k in range(3):
            out[:, k, 3] = np.interp(run.t - size, run.t, T[:, k, 3])
        return out

    return Change(seen=[look])


def early_reading(run, axes, rng, size):
    """Poses read while a share of the last move is left, more of it in axes that came far."""
    return Change(link=size * (run.before - run.values))
