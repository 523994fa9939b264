"""What accelerates the axes makes them give way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from camrob.gap.effects.common import arm_axes, moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

_AHEAD = -3e-5  # s2: no spring runs ahead of what pushes it; an instrument that smooths what it tells looks as if
_FEW, _MOST = 0.1, 0.99  # share of the samples that may be unknown, and the doubt of all where there are more
_SMALL = 0.5  # of the usual acceleration: below, it is not held against itself but against this


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Behind the encoders, at the tool's tip and at the drives: one for all axes, and how each axis differs from it."""
    if any(s.poses for s in scenes):
        return ()
    units = [Unit("acceleration_error", "", (EffectParameter("arm_s2", "s2", 3e-4, _AHEAD, 0.02),), key="arm")]
    units.append(Unit("acceleration_error", "", (EffectParameter("tip_s2", "s2", 3e-4, _AHEAD, 0.02),), key="tip"))
    split = all(s.servo_gap is not None for s in scenes)
    if split:
        servo = EffectParameter("servo_s2", "s2", 1e-3, -0.02, 0.1)
        units.append(Unit("acceleration_error", "", (servo,), key="servo"))
    for a in scenes[0].axes:
        if moved(scenes, a) and shows(scenes, a):
            own = EffectParameter(f"{a}_arm_beyond_s2", "s2", 3e-4, -0.02, 0.02)
            units.append(Unit("acceleration_error", a, (own,), key="arm"))
        if moved(scenes, a) and split:
            own = EffectParameter(f"{a}_servo_beyond_s2", "s2", 1e-3, -0.1, 0.1)
            units.append(Unit("acceleration_error", a, (own,), key="servo"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    if unit.key == "tip":
        place = scene.nominal[:, :3, 3]
        total = np.zeros((len(scene), 6))
        total[:, :3] = -scene.velocity(place, 2)
        return (Column(tcp=total, doubt=_doubt(scene, place, total[:, :3])),)
    values = scene.command if unit.key == "servo" else scene.link
    if unit.key == "servo":
        axes = (unit.axis,) if unit.axis else scene.axes
    else:
        axes = (unit.axis,) if unit.axis else arm_axes(scene.cell)
    own = values[:, [scene.index(a) for a in axes]]
    acceleration = scene.velocity(own, 2)
    doubt = _doubt(scene, own, acceleration)
    if unit.key == "servo":
        return (Column(servo={a: -acceleration[:, k] for k, a in enumerate(axes)}, doubt=doubt),)
    total = np.zeros((len(scene), 6))
    for k, axis in enumerate(axes):
        total -= scene.shift(axis, acceleration[:, k])
    return (Column(tcp=total, doubt=doubt),)


def _doubt(scene: Scene, values: Array, second: Array) -> Array:
    """(N,) share by which second derivatives (N, k) of values (N, k) may be wrong, as samples lie too far apart for them.

    Held against those through every other sample, which are about as wrong as these may be at their worst. Where that is many
    samples, none counts as unknown: a description that fails throughout must answer for it.
    """
    coarse = np.zeros_like(second)
    for run in scene.pieces:
        t, u = scene.t[run], values[run]
        if len(t) < 8:
            continue
        even, odd = (CubicSpline(t[k::2], u[k::2], axis=0) for k in (0, 1))
        # a spline tells of the samples that it does not go through
        coarse[run][0::2], coarse[run][1::2] = odd(t[0::2], 2), even(t[1::2], 2)
        coarse[run][:1], coarse[run][-1:] = second[run][:1], second[run][-1:]
    size = np.linalg.norm(second, axis=1)
    floor = _SMALL * float(np.sqrt(np.mean(size**2)))
    out = np.linalg.norm(coarse - second, axis=1) / np.maximum(size, max(floor, 1e-12))
    return np.asarray(out if np.mean(out >= 1.0) <= _FEW else np.minimum(out, _MOST))


EFFECT = Effect(
    name="acceleration_error",
    physics="Drives and gears give way in proportion to the acceleration of their axis, the whole in proportion to the tip's.",
    stages=("setpoint_to_encoder", "encoder_to_tcp"),
    regimes=("acceleration",),
    experiment="run the path at half speed: what acceleration causes falls to a quarter, what speed causes to a half",
    remedy=(
        "check the load data (mass, centre, inertia of tool and part), from which the controller reckons its feed-forward, then "
        "gains and feed-forward of these drives; lower the acceleration on the moves that matter"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.05,
)
