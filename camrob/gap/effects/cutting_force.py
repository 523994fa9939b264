"""The process pushes the tool away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.force is None or float(np.abs(s.force).max(initial=0.0)) < 1.0 for s in scenes):
        return ()
    arm = arm_axes(scenes[0].cell)
    parameters = tuple(EffectParameter(f"{a}_rad_nm", "rad/Nm", 4e-6, -1e-6, 5e-5) for a in arm)
    return (Unit("cutting_force", "", parameters),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    force = scene.force
    if force is None:
        return ()
    force = np.einsum("nij,nj->ni", scene.measured_R_world, force)
    columns = []
    for axis in arm_axes(scene.cell):
        arm = scene.place(f"{axis}.zero")
        torque = np.einsum("ij,ij->i", arm[:, :3], force)
        columns.append(Column(tcp=arm * torque[:, None]))
    return tuple(columns)


EFFECT = Effect(
    name="cutting_force",
    physics="The force on the tool turns every axis by its compliance times the force's torque about it.",
    rungs=("encoder_to_tcp",),
    regimes=("force",),
    experiment="run the same program in air: what force causes is gone",
    units=_units,
    columns=_columns,
    accuracy=0.03,
)
