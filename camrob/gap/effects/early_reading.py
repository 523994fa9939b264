"""A pose is logged before the robot has arrived."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if not all(s.poses for s in scenes):
        return ()
    return (Unit("early_reading", "", (EffectParameter("share", "1", 1e-3, -1e-4, 0.1),)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    before = np.zeros_like(scene.link)
    before[1:] = scene.link[:-1] - scene.link[1:]
    total = np.zeros((len(scene), 6))
    for k, axis in enumerate(scene.axes):
        if f"{axis}.zero" in scene.places:
            total += scene.shift(axis, before[:, k])
    return (Column(tcp=total),)


EFFECT = Effect(
    name="early_reading",
    physics="The reading is taken while the robot still has a share of its way from the pose before to go.",
    rungs=("encoder_to_tcp",),
    regimes=("time", "position"),
    experiment="measure some poses twice: at once and after two seconds of rest",
    units=_units,
    columns=_columns,
    accuracy=0.1,
)
