"""An axis winds up before it slides: its link follows its encoder along loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.compiled import kernel
from camrob.gap.effects.common import moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import play
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT", "dahl"]

Array = NDArray[np.float64]

_USUAL, _MOST = deg_to_rad(0.01), deg_to_rad(0.3)  # of wind-up, to either side
_FARTHER = 2.0  # times as far a sliding axis may wind up: belts and long racks do
_REACH = deg_to_rad(1.0)  # of travel after which it slides, where nothing says better
# where the elements of a Maxwell chain slip, one after the other: whatever springs and sliders there are, from 0.05 to 4 degrees,
# three show 96 % and more of what they do, as well as three whose places are searched for
_SLIPS = tuple(deg_to_rad(v) for v in (0.07, 0.4, 2.2))
_TRIED = tuple(deg_to_rad(v) for v in (0.7, 1.0, 2.0, 4.0))  # what slides sooner is play, as far as a log can tell
_LENGTH = mm_to_m(5.0) / deg_to_rad(1.0)  # m of a sliding axis to what is a rad of a turning one
_CHOICES = 6


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Of each axis, Dahl's friction, or a chain of Maxwell's slipping elements."""
    if any(s.poses for s in scenes):
        return ()
    units = []
    for joint in scenes[0].cell.joints:
        a = joint.name
        if joint.role is Role.ROLL or not moved(scenes, a) or not shows(scenes, a):
            continue
        scale, unit = (_LENGTH, "mm") if joint.prismatic else (1.0, "deg")

        def parameter(name: str, scale: float = scale, unit: str = unit) -> EffectParameter:
            most = scale * _MOST * (_FARTHER if unit == "mm" else 1.0)
            return EffectParameter(f"{name}_{unit}", unit, scale * _USUAL, -most, most, scale * _MOST)

        units.append(Unit("hysteresis", a, (parameter(f"{a}_dahl"),), _CHOICES, "dahl"))
        slips = tuple(parameter(f"{a}_slip{k + 1}") for k in range(len(_SLIPS)))
        units.append(Unit("hysteresis", a, slips, _CHOICES, "maxwell"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    u = scene.link[:, scene.index(unit.axis)]
    scale = _LENGTH if scene.cell.joints[scene.cell.index(unit.axis)].prismatic else 1.0
    if unit.key == "dahl":
        return (Column(tcp=scene.shift(unit.axis, -dahl(u, scene.pieces, state.get("reach", _REACH) * scale))),)
    key = "maxwell", unit.axis
    if key not in scene.found:
        scene.found[key] = [play(u, scene.t, scene.pieces, 2.0 * slip * scale) for slip in _SLIPS]
    return tuple(Column(tcp=scene.shift(unit.axis, -part)) for part in scene.found[key])


def dahl(values: Array, pieces: Sequence[slice], reach: float) -> Array:
    """State (N,) in [-1, 1] of Dahl's friction: dz = (1 - z sign(du)) du / reach; each run starts at 0."""
    out = np.zeros(len(values))
    for run in pieces:
        out[run] = _dahl(np.ascontiguousarray(values[run]), reach)
    return out


@kernel
def _dahl(u: Array, reach: float) -> Array:
    out = np.zeros(len(u))
    z = 0.0
    for i in range(1, len(u)):
        # exact over a straight step
        way = (u[i] - u[i - 1]) / reach
        if way > 0.0:
            z = 1.0 - (1.0 - z) * np.exp(-way)
        elif way < 0.0:
            z = -1.0 + (1.0 + z) * np.exp(way)
        out[i] = z
    return out


EFFECT = Effect(
    name="hysteresis",
    physics="The link winds up against friction behind its encoder, and slides only after some travel, so it runs in loops.",
    stages=("encoder_to_tcp",),
    regimes=("direction",),
    experiment="move the axis alone to and fro by 0.1, 1 and 10 degrees: loops grow with the travel, play's steps don't",
    remedy=(
        "have the preload of gear and bearings of these axes looked at; until then come to what matters from one side"
    ),
    units=_units,
    columns=_columns,
    trials=tuple({"reach": r} for r in _TRIED),
    accuracy=0.05,
)
