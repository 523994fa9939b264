"""Faults without a usual name, each with the place where it truly is (see the orders)."""

from __future__ import annotations

import numpy as np

from .arms import chain, moment_at, tip, weight
from .wear import Change, put, smooth


def counterbalance_leaks(run, axes, rng, size):
    """The balancer behind A2 has lost gas: its gear holds what the spring held, by the sine of the arm's lean."""
    axis = run.m.axes[axes[0]]
    lean = axis.sign * (run.v[:, axes] - np.radians(axis.zero))
    return Change(link=put(run, axes, axis.sign * size * np.sin(lean)))


def flange_creeps(run, axes, rng, size, *, stuck=0.35):
    """Bolts at a tenth of their torque: once its weight pulls hard enough the tool turns as far as the holes let it."""
    T = tip(run.m, run.v)
    side = np.array(run.m.tool[:2]) if any(run.m.tool[:2]) else np.array([30.0, 20.0])
    side = side / np.linalg.norm(side)
    _, ends, _ = chain(run.m, run.v)
    down = -ends[-1][:, 2, :3]
    pull = side[0] * down[:, 1] - side[1] * down[:, 0]
    state, held = np.zeros(len(T)), 0.0
    for k, p in enumerate(pull):
        held = held if abs(p) < stuck else np.sign(p)
        state[k] = held
    w = np.zeros((len(T), 6))
    w[:, 5], w[:, 3], w[:, 0] = size * state, 0.4 * size * state, 0.02 * size * state
    return Change(far={"flange": w})


def bearing_clears(run, axes, rng, size):
    """A bearing without preload: what it carries tips within its clearance to the side to which its weight pulls."""
    i = axes[0]
    M = moment_at(run.m, run.v, i)[:, :2]
    much = np.linalg.norm(M, axis=1, keepdims=True)
    w = np.zeros((len(M), 6))
    w[:, 3:5] = size * M / (much + 0.1 * much.max())
    return Change(near={run.m.axes[i].name: w})


def current_limit(run, axes, rng, size, *, share=0.45):
    """A limit of current left from setting up: beyond it an axis doesn't keep up, and comes back when it may."""
    a = run.jerkless[:, axes]
    limit = share * np.abs(a).max(axis=0)
    return Change(drive=put(run, axes, -size * smooth(np.sign(a) * np.maximum(0, np.abs(a) - limit), run, 0.25, 2)))


def motor_rattles(run, axes, rng, size, *, hertz=6.3):
    """A motor on loose screws: the arm trembles as long as that axis turns, the quicker the more."""
    v = np.abs(run.speed[:, axes])
    return Change(link=put(run, axes, size * v / v.max() * np.sin(2 * np.pi * hertz * run.t)[:, None]))


def docks_anew(run, axes, rng, size):
    """Chips between tool and changer: at every docking the tool sits otherwise."""
    at = rng.standard_normal((int(run.dock.max()) + 1, 6)) * np.array([1, 1, 1, 3, 3, 3])
    return Change(far={"tool": size * at[run.dock]})


def cartridge_empties(run, axes, rng, size):
    """What hangs at the plate is used up: gears come up again by what is gone, by the lever it has."""
    gone = weight(run.m.carrying(run.m.load + 1), run.v) - weight(run.m, run.v)
    return Change(link=put(run, axes, size * run.part[:, None] * gone[:, axes]))


def bridge_racks(run, axes, rng, size):
    """One side of a bridge hangs back at every reversal: it stands askew, more so at the far end of the beam."""
    i = axes[0]
    way = (
        np.sign(run.v[:, i] - run.came[:, i])
        if run.rests
        else np.sign(smooth(run.speed[:, i : i + 1], run, 0.05)[:, 0])
    )
    w = np.zeros((len(way), 6))
    w[:, 3] = size * way  # about the upright of that axis's frame
    return Change(near={run.m.axes[i + 1].name: w})


def cables_couple(run, axes, rng, size):
    """A screen that is not earthed: one axis's resolver hears another one's inverter while that one turns."""
    heard, by = axes
    v = np.abs(run.speed[:, by]) / run.m.tops[by]
    return Change(drive=put(run, [heard], (size * np.minimum(1, 3 * v) * rng.standard_normal(len(v)))[:, None]))


def clamp_touches(run, axes, rng, size, *, beyond=35.0):
    """A hose clamp set too low: beyond an angle it presses on the casting and holds the arm back."""
    q = run.v[:, axes]
    return Change(link=put(run, axes, -size * np.maximum(0.0, q - np.radians(beyond)) ** 0.8))


def plate_tips_over(run, axes, rng, size):
    """A part off the middle on a worm with play: its weight turns the plate to one flank, past the top to the other."""
    q = run.v[:, axes]
    return Change(link=put(run, axes, size * np.tanh(np.sin(q + 0.5) / 0.15)))


ODD = {
    f.__name__: f
    for f in (
        counterbalance_leaks,
        flange_creeps,
        bearing_clears,
        current_limit,
        motor_rattles,
        docks_anew,
        cartridge_empties,
        bridge_racks,
        cables_couple,
        clamp_touches,
        plate_tips_over,
    )
}
