"""A gear's transmission error repeats with the axis's angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.cell.joint import Role
from camrob.gap.effects.common import shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad

__all__ = ["EFFECT"]

_CHOICES = 300  # orders that could have been picked
_TURNS = "turns"  # the unit of what repeats once and twice a turn of the axis
_RANGE = deg_to_rad(180.0)  # that an axis passes at the least: of less than half a turn any smooth course looks so
_TURN = deg_to_rad(0.01)  # its ordinary size
_HARMONICS = ((1, deg_to_rad(0.006)), (2, deg_to_rad(0.001)))  # times the order, ordinary size


def _text(order: float) -> str:
    return f"{order:.2f}".rstrip("0").rstrip(".")


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Once and twice a turn of any axis; and the orders that `state` holds, under `A3_order`, further ones `A3_order_2`."""
    most = deg_to_rad(0.3)
    units = []
    for joint in scenes[0].cell.joints:
        a = joint.name
        if joint.role is Role.ROLL or joint.prismatic or not shows(scenes, a):
            continue
        if max(float(np.ptp(s.link[:, s.index(a)])) for s in scenes) > _RANGE:
            turns = tuple(
                EffectParameter(f"{a}_{wave}{times}_deg", "deg", _TURN, -most, most)
                for times, _ in _HARMONICS
                for wave in ("cos", "sin")
            )
            units.append(Unit("gear_ripple", a, turns, _CHOICES, _TURNS))
    for key in sorted(state):
        axis, _, _which = key.partition("_order")
        parameters = tuple(
            EffectParameter(f"{axis}_{wave}{_text(times * state[key])}_deg", "deg", usual, -most, most)
            for times, usual in _HARMONICS
            for wave in ("cos", "sin")
        )
        units.append(Unit("gear_ripple", axis, parameters, choices=_CHOICES, key=key))
    return tuple(units)


def _order(unit: Unit, state: State) -> float:
    return 1.0 if unit.key == _TURNS else state[unit.key]


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    angle = _order(unit, state) * scene.link[:, scene.index(unit.axis)]
    return tuple(
        Column(tcp=scene.shift(unit.axis, np.asarray(wave(times * angle))))
        for times, _ in _HARMONICS
        for wave in (np.cos, np.sin)
    )


def _whole(scenes: Sequence[Scene], unit: Unit, state: State) -> bool:
    """True where the axis passes its turn, or two cycles of an order that was found: what comes but once may be a dent."""
    travel = max(float(np.ptp(s.link[:, s.index(unit.axis)])) for s in scenes)
    return _order(unit, state) * travel >= (1.0 if unit.key == _TURNS else 2.0) * 2.0 * np.pi


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    orders = [f"{times * _order(unit, state):.4f}" for times, _ in _HARMONICS]
    return tuple(f"{unit.axis}.{wave}{order}" for order in orders for wave in ("cos", "sin"))


EFFECT = Effect(
    name="gear_ripple",
    physics="The link runs ahead of and behind its encoder, once or more a turn of its axis or motor; not quite as a sine.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn the axis alone slowly through its range, both ways: waves at the same places of the axis both ways",
    remedy="nothing to adjust: gears are like that, and no axis stands out from its like; it is corrected in the program",
    odd_axis="have the gear of {axis} looked at, which stands out from its like",
    units=_units,
    columns=_columns,
    accuracy=0.02,
    terms=_terms,
    orders=True,
    whole=_whole,
)
