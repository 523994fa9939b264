"""Pedestal, column or carriage lean under the arm's weight."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.dynamics.gravity import GRAVITY
from camrob.gap.effects.common import reach_moments
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.robot_size import ordinary_compliance
from camrob.gap.effects.told_load import beyond_told, told_key
from camrob.gap.observation.scene import Scene
from camrob.units import mm_to_m

__all__ = ["EFFECT"]

# of an axis's ordinary compliance: what is ordinary of a foot, the most, and the wrong way
_USUAL, _MOST, _NEGATIVE = 0.05, 5.0, 0.0025
_COMMON = 25.0  # times what is ordinary
_HEIGHT, _DEEPEST = mm_to_m(700.0), mm_to_m(3000.0)  # of the foot above what it leans about
_BY_REACH, _MOST_BY_REACH = 1e-4, 2e-3  # rad/m
_SHARES = ("tool", "arm")  # whose moment the masses of the model may give too small or too large


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if not scenes[0].cell.masses:
        return ()
    axis = ordinary_compliance(scenes[0].cell)
    usual, most, lower, common = _USUAL * axis, _MOST * axis, -_NEGATIVE * axis, _COMMON * _USUAL * axis
    parameters = tuple(EffectParameter(f"about_{p}_rad_nm", "rad/Nm", usual, lower, most, common) for p in "xy")
    load = told_key(scenes)
    units = [Unit("lean", "", parameters, key=f"moment{load}")]
    for share in _SHARES:
        own = tuple(EffectParameter(f"about_{p}_{share}_rad_nm", "rad/Nm", usual, -most, most) for p in "xy")
        units.append(Unit("lean", "", own, key=f"{share}{load}"))
    reach = tuple(
        EffectParameter(f"about_{p}_rad_m", "rad/m", _BY_REACH, -_MOST_BY_REACH, _MOST_BY_REACH) for p in "xy"
    )
    units.append(Unit("lean", "", reach, key="reach"))
    deep = _DEEPEST * most
    foot = tuple(EffectParameter(f"foot_{p}_m_nm", "m/Nm", _HEIGHT * usual, -deep, deep) for p in "xy")
    return (*units, Unit("lean", "", foot, key=f"foot{load}"))


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    masses, kind = scene.cell.masses, unit.key.partition(" ")[0]
    carried = GRAVITY * beyond_told(scene, unit.key) * reach_moments(scene)
    if kind in _SHARES:
        end = masses[-1] if kind == "tool" else masses[0]
        moment = scene.moments[[m.after == end.after for m in masses]].sum(axis=0)
        moment = moment + carried if kind == "tool" else moment
    elif kind == "reach":
        moment = reach_moments(scene)
    else:
        moment = scene.moments.sum(axis=0) + carried
    if kind == "foot":
        # what leans about a place below the foot carries the foot along
        return (Column(tcp=scene.place("root.x") * moment[:, 1:]), Column(tcp=scene.place("root.y") * -moment[:, :1]))
    return tuple(Column(tcp=scene.place(f"root.r{p}") * moment[:, k : k + 1]) for k, p in enumerate("xy"))


EFFECT = Effect(
    name="lean",
    physics="What carries the robot turns about its foot, or a place below, with gravity's moment, so with load and reach.",
    stages=("encoder_to_tcp",),
    regimes=("load", "position"),
    experiment=(
        "turn A1 through half a turn with the arm stretched, then with another payload: what leans sinks towards the arm's side, "
        "and more with more load"
    ),
    remedy=(
        "check the bolts of foot, pedestal or carriage and the floor under them, with a dial gauge at the foot "
        "while A1 turns with the arm stretched"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.02,
)
