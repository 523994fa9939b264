"""What accelerates the axes makes them give way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes, moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Behind the encoders, at the tool's tip and at the drives: one for all axes, and how each axis differs from it."""
    if any(s.poses for s in scenes):
        return ()
    units = [Unit("acceleration_error", "", (EffectParameter("arm_s2", "s2", 3e-4, -0.005, 0.02),), key="arm")]
    units.append(Unit("acceleration_error", "", (EffectParameter("tip_s2", "s2", 3e-4, -0.005, 0.02),), key="tip"))
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
        total = np.zeros((len(scene), 6))
        total[:, :3] = -scene.velocity(scene.nominal[:, :3, 3], 2)
        return (Column(tcp=total),)
    values = scene.command if unit.key == "servo" else scene.link
    acceleration = scene.velocity(values, 2)
    if unit.key == "servo":
        axes = (unit.axis,) if unit.axis else scene.axes
        return (Column(servo={a: -acceleration[:, scene.index(a)] for a in axes}),)
    total = np.zeros((len(scene), 6))
    for axis in (unit.axis,) if unit.axis else arm_axes(scene.cell):
        total -= scene.shift(axis, acceleration[:, scene.index(axis)])
    return (Column(tcp=total),)


EFFECT = Effect(
    name="acceleration_error",
    physics="Drives and gears give way in proportion to the acceleration of their axis, the whole in proportion to the tip's.",
    rungs=("setpoint_to_encoder", "encoder_to_tcp"),
    regimes=("acceleration",),
    experiment="run the path at half speed: what acceleration causes falls to a quarter, what speed causes to a half",
    units=_units,
    columns=_columns,
    accuracy=0.05,
)
