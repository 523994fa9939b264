"""The wrist's gears turn each other, and the controller's coupling ratios are off."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import arm_axes, moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_PAIRS = ((4, 3), (5, 3), (5, 4))  # which axis of the arm turns with which


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    arm = arm_axes(scenes[0].cell)
    return tuple(
        Unit("wrist_coupling", arm[i], (EffectParameter(f"{arm[i]}_by_{arm[j]}", "1", 5e-4, -0.03, 0.03),), key=arm[j])
        for i, j in _PAIRS
        if len(arm) == 6 and moved(scenes, arm[j])
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return (Column(tcp=scene.shift(unit.axis, scene.link[:, scene.index(unit.key)])),)


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return (f"{unit.axis}.by.{unit.key}",)


EFFECT = Effect(
    name="wrist_coupling",
    physics="A4 turns A5 and A6, and A5 turns A6, by a share that the controller doesn't take back.",
    rungs=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn A4 alone through half a turn and watch the tool's axis, then A5",
    units=_units,
    columns=_columns,
    accuracy=0.01,
    terms=_terms,
)
