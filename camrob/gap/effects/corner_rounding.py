"""The controller cuts corners (approximate positioning)."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import mm_to_m

__all__ = ["DISTANCE", "EFFECT"]

DISTANCE = EffectParameter("cdis_mm", "mm", mm_to_m(1.0), -mm_to_m(0.001), mm_to_m(50.0))
"""How far from a corner the tool leaves the path: the programmed distance, or half of the shorter motion where that is less."""


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """None: it lies between program and set-point, before the gap begins, and is judged there (see `gap.corners`)."""
    return ()


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return ()


EFFECT = Effect(
    name="corner_rounding",
    physics="Where it may, the controller leaves the programmed path before each corner and joins it again behind.",
    stages=("program_to_setpoint",),
    regimes=("position",),
    experiment="run the program with a rounding distance of 0, or with exact stops at the corners",
    remedy=(
        "nothing at the robot: give corners that matter a smaller rounding distance in the program, or an exact stop"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.1,
)
