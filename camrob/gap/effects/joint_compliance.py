"""Gears and links give way under gravity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.robot_size import ordinary_compliance
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_LEAST_TORQUE = 0.5  # Nm
_COMMON, _MOST, _NEGATIVE = 12.0, 100.0, 0.025  # times what is ordinary for such a robot


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    cell = scenes[0].cell
    if not cell.masses:
        return ()
    usual = ordinary_compliance(cell)
    lower, upper, common = -_NEGATIVE * usual, _MOST * usual, _COMMON * usual
    return tuple(
        Unit("joint_compliance", a, (EffectParameter(f"{a}_rad_nm", "rad/Nm", usual, lower, upper, common),))
        for a in arm_axes(cell)
        if max(float(np.abs(s.torque[:, s.index(a)]).max()) for s in scenes) > _LEAST_TORQUE
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return (Column(tcp=scene.shift(unit.axis, scene.torque[:, scene.index(unit.axis)])),)


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return (f"{unit.axis}.compliance",)


EFFECT = Effect(
    name="joint_compliance",
    physics="Gravity's torque turns each link beyond its encoder by the joint's compliance.",
    stages=("encoder_to_tcp",),
    regimes=("load", "position"),
    experiment="run the same path with another payload: compliance changes with it, zeros and geometry don't",
    remedy=(
        "nothing to adjust: every arm gives way under its weight; it is corrected in the program, and an axis far "
        "softer than its like has a gear or bearing to be looked at"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.01,
    terms=_terms,
)
