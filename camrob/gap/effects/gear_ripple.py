"""A gear's transmission error repeats with the axis's angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene
from camrob.units import deg_to_rad

__all__ = ["EFFECT"]

_CHOICES = 300  # orders that could have been picked


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Units of the orders that `state` holds, under `A3_order` and, for further ones, `A3_order_2`."""
    most = deg_to_rad(0.1)
    units = []
    for key in sorted(state):
        axis, _, _which = key.partition("_order")
        order = f"{state[key]:.2f}".rstrip("0").rstrip(".")
        usual = deg_to_rad(0.006)
        names = (f"{axis}_cos{order}_deg", f"{axis}_sin{order}_deg")
        parameters = tuple(EffectParameter(n, "deg", usual, -most, most) for n in names)
        units.append(Unit("gear_ripple", axis, parameters, choices=_CHOICES, key=key))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    angle = state[unit.key] * scene.link[:, scene.index(unit.axis)]
    return tuple(Column(tcp=scene.shift(unit.axis, np.asarray(wave(angle)))) for wave in (np.cos, np.sin))


EFFECT = Effect(
    name="gear_ripple",
    physics="The link runs ahead of and behind its encoder once or several times a turn of the axis, or of its motor.",
    rungs=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn the axis alone slowly through its range, both ways",
    units=_units,
    columns=_columns,
    accuracy=0.02,
    compensable=True,
)
