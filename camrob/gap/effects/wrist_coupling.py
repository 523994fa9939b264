"""The wrist's gears turn each other, and the controller's coupling ratios are off."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import arm_axes, moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_PAIRS = ((4, 3), (5, 3), (5, 4))  # which axis of the arm turns with which
_SQUARED, _CHOICES = " squared", 4
_BENT, _MOST_BENT = 2e-4, 0.01  # 1/rad, of a ratio that changes with the angle


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    arm = arm_axes(scenes[0].cell)
    pairs = [(arm[i], arm[j]) for i, j in _PAIRS if len(arm) == 6 and moved(scenes, arm[j])]
    units = [
        Unit("wrist_coupling", a, (EffectParameter(f"{a}_by_{by}", "1", 5e-4, -0.03, 0.03),), key=by) for a, by in pairs
    ]
    for a, by in pairs:
        bent = EffectParameter(f"{a}_by_{by}_squared_1_rad", "1/rad", _BENT, -_MOST_BENT, _MOST_BENT)
        units.append(Unit("wrist_coupling", a, (bent,), _CHOICES, f"{by}{_SQUARED}"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    by = scene.link[:, scene.index(unit.key.removesuffix(_SQUARED))]
    return (Column(tcp=scene.shift(unit.axis, by**2 if unit.key.endswith(_SQUARED) else by)),)


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    """The quadratic part is no term of the one error model."""
    return () if unit.key.endswith(_SQUARED) else (f"{unit.axis}.by.{unit.key}",)


EFFECT = Effect(
    name="wrist_coupling",
    physics="A4 turns A5 and A6, and A5 turns A6, by a share (and its square) that the controller doesn't take back.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn A4 alone through half a turn and watch the tool's axis, then A5",
    remedy="enter the coupling factors of the wrist on the controller, or correct it in the program",
    units=_units,
    columns=_columns,
    accuracy=0.01,
    terms=_terms,
)
