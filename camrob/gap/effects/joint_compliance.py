"""Gears and links give way under gravity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.dynamics.gravity import GRAVITY
from camrob.gap.effects.common import (
    arm_axes,
    found_once,
    under_even_kilogram,
    under_flange_kilogram,
)
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.robot_size import ordinary_compliance, ordinary_sag, reach_of
from camrob.gap.effects.told_load import beyond_told, most_beyond, told_key, under_told_load
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

_LEAST_TORQUE = 0.5  # Nm
_COMMON, _MOST, _NEGATIVE = 12.0, 100.0, 0.025  # times what is ordinary for such a robot
_SAG = "sag"  # the unit of an axis of an arm whose masses nobody knows
_LEAST_SAG = 0.02  # of what an axis gives under the arm stretched out: what shows nothing


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    cell = scenes[0].cell
    if not cell.masses:
        return _by_length(scenes)
    usual = ordinary_compliance(cell)
    lower, upper, common = -_NEGATIVE * usual, _MOST * usual, _COMMON * usual
    loaded = told_key(scenes)
    return tuple(
        Unit(
            "joint_compliance", a, (EffectParameter(f"{a}_rad_nm", "rad/Nm", usual, lower, upper, common),), key=loaded
        )
        for a in arm_axes(cell)
        if max(float(np.abs(s.torque[:, s.index(a)]).max()) for s in scenes) > _LEAST_TORQUE
    )


def _by_length(scenes: Sequence[Scene]) -> tuple[Unit, ...]:
    """Of an arm whose masses nobody knows: how far each axis gives, stretched out, under links that weigh by their lengths, and
    under what the plate carries. Both together say any share of the one; what they weigh, and so a compliance, nobody can say.
    Where logs tell several payloads: also under the most that one of them carries beyond the others.
    """
    usual, loaded = ordinary_sag(), told_key(scenes)
    most, common = _MOST * usual, _COMMON * usual
    parts = ("links", "plate", "load") if loaded else ("links", "plate")
    return tuple(
        Unit(
            "joint_compliance",
            axis,
            tuple(EffectParameter(f"{axis}_{by}_deg", "deg", usual, -most, most, common) for by in parts),
            key=f"{_SAG}{loaded}",
        )
        for k, axis in enumerate(arm_axes(scenes[0].cell))
        if max(_share(s, axis, pull[k]) for s in scenes for pull in _pulls(s)) > _LEAST_SAG
    )


def _pulls(scene: Scene) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """(N, 6) each: how the tool moves where an arm axis gives by a radian stretched out, under even links and under the plate."""

    def search() -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        most = GRAVITY * reach_of(scene.cell)
        loads = (under_even_kilogram(scene), under_flange_kilogram(scene))
        even, plate = (tuple(c.tcp / most for c in columns if c.tcp is not None) for columns in loads)
        return even, plate

    return found_once([scene], (_SAG,), search)


def _share(scene: Scene, axis: str, pull: Array) -> float:
    """Of the most that an axis can give: what it gives on a log (rms)."""
    return float(np.linalg.norm(pull) / max(float(np.linalg.norm(scene.place(f"{axis}.zero"))), 1e-12))


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    beyond, most = beyond_told(scene, unit.key), most_beyond(unit.key)
    k = arm_axes(scene.cell).index(unit.axis)
    if unit.key.startswith(_SAG):
        pulls = [pull[k] for pull in _pulls(scene)]
        return tuple(Column(tcp=pull) for pull in [*pulls, *([pulls[1] * (beyond / most)] if most else [])])
    sag = scene.shift(unit.axis, scene.torque[:, scene.index(unit.axis)])
    more = under_told_load(scene, unit.key)[k].tcp if beyond else None
    return (Column(tcp=sag if more is None else sag + more),)


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    # the one error model weighs the cell's own masses alone
    return () if unit.key else (f"{unit.axis}.compliance",)


def _likewise(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """Where nobody knows what the links weigh, nobody can tell what gives way under them from a load
    that nobody counted, and an axis that gives by the arm's moment from a foot that does.
    """
    return () if scenes[0].cell.masses else ("lean", "payload")


EFFECT = Effect(
    name="joint_compliance",
    physics="Gravity's torque turns each link beyond its encoder by the joint's compliance.",
    stages=("encoder_to_tcp",),
    regimes=("load", "position"),
    experiment="run the same path with another payload: compliance changes with it, zeros and geometry don't",
    remedy="nothing to adjust: every arm gives way under its weight, and it is corrected in the program",
    odd_axis=(
        "weigh the tool and check the load data, and the bolts of plate, tool changer and tool; only if they are right is the "
        "gear or bearing of {axis} to be looked at, as it is far softer than its like"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.01,
    terms=_terms,
    likewise=_likewise,
)
