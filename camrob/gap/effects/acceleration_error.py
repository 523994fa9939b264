"""What accelerates the axes makes them give way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses for s in scenes):
        return ()
    units = [Unit("acceleration_error", "", (EffectParameter("arm_s2", "s2", 3e-4, -1e-5, 0.02),), key="arm")]
    if all(s.servo_gap is not None for s in scenes):
        units.append(
            Unit("acceleration_error", "", (EffectParameter("servo_s2", "s2", 1e-3, -1e-5, 0.1),), key="servo")
        )
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    values = scene.command if unit.key == "servo" else scene.link
    acceleration = scene.velocity(values, 2)
    if unit.key == "servo":
        return (Column(servo={a: -acceleration[:, k] for k, a in enumerate(scene.axes)}),)
    total = np.zeros((len(scene), 6))
    for axis in arm_axes(scene.cell):
        total -= scene.shift(axis, acceleration[:, scene.index(axis)])
    return (Column(tcp=total),)


EFFECT = Effect(
    name="acceleration_error",
    physics="Drives and gears give way in proportion to the acceleration of their axis.",
    rungs=("setpoint_to_encoder", "encoder_to_tcp"),
    regimes=("acceleration",),
    experiment="run the path at half speed: what acceleration causes falls to a quarter, what speed causes to a half",
    units=_units,
    columns=_columns,
    accuracy=0.05,
)
