"""The library as it shows on some logs whose axes have an encoder on either side of their gear: what a gear does lies between
set-point and link's encoder there, and what a drive does on no axis whose motor follows its set-points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.two_encoders import as_by_motors, between_encoders, motors_follow

__all__ = ["at_their_stage"]

_DRIVE, _LINK = "setpoint_to_encoder", "encoder_to_tcp"


def at_their_stage(effects: Sequence[Effect], scenes: Sequence[Scene]) -> tuple[Effect, ...]:
    """The effects, those of gears and drives as these logs would show them."""
    axes = frozenset(a for a in scenes[0].axes if moved(scenes, a))
    both = frozenset(a for a in axes if all(between_encoders(s, a) for s in scenes))
    if not both:
        return tuple(effects)
    follow = motors_follow(scenes)
    stages = (_DRIVE,) if axes == both else (_DRIVE, _LINK)
    out = []
    for e in effects:
        if e.in_gears:
            units, columns = partial(_units_of_gears, e, both), partial(_columns_of_gears, e, both)
            out.append(replace(e, stages=stages, units=units, columns=columns))
        elif e.stages == (_DRIVE,):
            out.append(replace(e, units=partial(_units_of_drives, e, follow)))
        else:
            out.append(e)
    return tuple(out)


def _units_of_drives(effect: Effect, follow: frozenset[str], scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    return tuple(u for u in effect.units(scenes, state) if u.axis not in follow)


def _units_of_gears(effect: Effect, both: frozenset[str], scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    tracked = all(s.tracked for s in scenes)
    units = effect.units([as_by_motors(s) for s in scenes], state)
    return tuple(u for u in units if u.axis in both or tracked)


def _columns_of_gears(
    effect: Effect, both: frozenset[str], scene: Scene, unit: Unit, state: State
) -> tuple[Column, ...]:
    columns = effect.columns(as_by_motors(scene), unit, state)
    if unit.axis not in both:
        return columns
    arm = scene.place(f"{unit.axis}.zero")
    lever = np.maximum(np.sum(arm**2, axis=1), 1e-300)
    return tuple(
        Column(servo={unit.axis: np.sum(arm * c.tcp, axis=1) / lever}, doubt=c.doubt)
        for c in columns
        if c.tcp is not None
    )
