"""Pedestal, column or carriage lean under the arm's weight."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene

__all__ = ["EFFECT"]

_USUAL, _MOST = 2e-7, 5e-6  # rad/Nm


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if not scenes[0].cell.masses:
        return ()
    parameters = tuple(EffectParameter(f"about_{p}_rad_nm", "rad/Nm", _USUAL, -1e-8, _MOST) for p in "xy")
    return (Unit("lean", "", parameters),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    moment = scene.moment()
    return tuple(Column(tcp=scene.place(f"root.r{p}") * moment[:, k : k + 1]) for k, p in enumerate("xy"))


EFFECT = Effect(
    name="lean",
    physics="What carries the robot turns about its foot with gravity's moment there, so with load and reach.",
    rungs=("encoder_to_tcp",),
    regimes=("load", "position"),
    experiment="turn A1 through half a turn with the arm stretched, then with another payload",
    units=_units,
    columns=_columns,
    accuracy=0.02,
)
