"""An axis's zero is wrong (mastering)."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import arm_axes, constant
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    most = deg_to_rad(0.5)
    return tuple(
        Unit("joint_offset", a, (EffectParameter(f"{a}_deg", "deg", deg_to_rad(0.05), -most, most),))
        for a in arm_axes(scenes[0].cell)
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return constant(scene, [f"{unit.axis}.zero"])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return (f"{unit.axis}.zero",)


EFFECT = Effect(
    name="joint_offset",
    physics="The real axis value is the reported one and a constant.",
    rungs=("encoder_to_tcp",),
    regimes=("position",),
    experiment="master the axis anew with the electronic gauge, or measure ten postures that turn the other axes widely",
    units=_units,
    columns=_columns,
    accuracy=0.0,
    terms=_terms,
)
