"""The process pushes the tool away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes, pushed_along, under_force
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import mm_to_m

__all__ = ["EFFECT"]

_PUSH = mm_to_m(1e-3)  # m/N
_FRAMES = ("world", "tool")  # in whose axes the tip gives way


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.force is None or float(np.abs(s.force).max(initial=0.0)) < 1.0 for s in scenes):
        return ()
    arm = arm_axes(scenes[0].cell)
    parameters = tuple(EffectParameter(f"{a}_rad_nm", "rad/Nm", 4e-6, -1e-6, 5e-5) for a in arm)
    units = [Unit("cutting_force", "", parameters, key="axes")]
    for frame in _FRAMES:
        along = tuple(EffectParameter(f"{frame}_{p}_m_n", "m/N", _PUSH, -0.1 * _PUSH, 20.0 * _PUSH) for p in "xyz")
        units.append(Unit("cutting_force", "", along, key=frame))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    if scene.force is None:
        return tuple(Column() for _ in unit.parameters)
    if unit.key == "tool":
        return pushed_along(scene.nominal[:, :3, :3], np.einsum("nij,nj->ni", scene.measured_R_world, scene.force))
    axes, tip = under_force(scene)
    return tip if unit.key == "world" else axes


EFFECT = Effect(
    name="cutting_force",
    physics="The force on the tool turns every axis by its compliance times the force's torque about it, or the tip as a spring.",
    stages=("encoder_to_tcp",),
    regimes=("force",),
    experiment="run the same program in air: what force causes is gone",
    remedy=(
        "take less off a pass, or post with postures that are stiff under this force (camrob post --method planned "
        "--for-accuracy)"
    ),
    odd_axis=(
        "look at the spindle's mount and bearing, as it gives way far more than its like; if they are sound, take less off a pass"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.03,
)
