"""A gear's transmission error repeats with the axis's angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene
from camrob.units import deg_to_rad

__all__ = ["EFFECT"]

_CHOICES = 300  # orders that could have been picked
_HARMONICS = ((1, deg_to_rad(0.006)), (2, deg_to_rad(0.001)))  # times the order, ordinary size


def _text(order: float) -> str:
    return f"{order:.2f}".rstrip("0").rstrip(".")


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Units of the orders that `state` holds, under `A3_order` and, for further ones, `A3_order_2`."""
    most = deg_to_rad(0.1)
    units = []
    for key in sorted(state):
        axis, _, _which = key.partition("_order")
        parameters = tuple(
            EffectParameter(f"{axis}_{wave}{_text(times * state[key])}_deg", "deg", usual, -most, most)
            for times, usual in _HARMONICS
            for wave in ("cos", "sin")
        )
        units.append(Unit("gear_ripple", axis, parameters, choices=_CHOICES, key=key))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    angle = state[unit.key] * scene.link[:, scene.index(unit.axis)]
    return tuple(
        Column(tcp=scene.shift(unit.axis, np.asarray(wave(times * angle))))
        for times, _ in _HARMONICS
        for wave in (np.cos, np.sin)
    )


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    orders = [f"{times * state[unit.key]:.4f}" for times, _ in _HARMONICS]
    return tuple(f"{unit.axis}.{wave}{order}" for order in orders for wave in ("cos", "sin"))


EFFECT = Effect(
    name="gear_ripple",
    physics="The link runs ahead of and behind its encoder, once or more a turn of its axis or motor; not quite as a sine.",
    rungs=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn the axis alone slowly through its range, both ways",
    units=_units,
    columns=_columns,
    accuracy=0.02,
    terms=_terms,
)
