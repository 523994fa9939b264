"""The controller cuts corners (approximate positioning)."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """None: it lies between program and set-point, before the gap begins, and is judged there (see `gap.rungs`)."""
    return ()


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return ()


EFFECT = Effect(
    name="corner_rounding",
    physics="With C_DIS or C_VEL the controller leaves the programmed path before each corner and joins it again behind.",
    rungs=("program_to_setpoint",),
    regimes=("position",),
    experiment="run the program with $APO.CDIS = 0, or with exact stops at the corners",
    units=_units,
    columns=_columns,
    accuracy=0.1,
    compensable=True,
)
