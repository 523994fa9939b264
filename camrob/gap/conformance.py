"""What every effect promises, built in or brought by a cell, checked on a log: its words, units, columns and ranges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State
from camrob.gap.locate.by_stage import STAGES
from camrob.gap.observation.scene import Scene

__all__ = ["effect_faults"]

_MOST_ACCURACY = 0.2  # a description that is wrong by more describes nothing


def effect_faults(effect: Effect, scenes: Sequence[Scene], state: State | None = None) -> list[str]:
    """What an effect breaks, in words; [] where it keeps all. state: its nonlinear values, those it starts with by default."""
    faults = []
    if not effect.physics.endswith(".") or not effect.experiment.strip():
        faults.append("says no physics (one sentence) or no experiment")
    if effect.remedy.endswith("."):
        faults.append("ends its remedy with a full stop: it stands within a sentence")
    if not effect.stages or not set(effect.stages) <= set(STAGES):
        faults.append("names a stage that does not exist")
    if not 0.0 <= effect.accuracy <= _MOST_ACCURACY:
        faults.append(f"is accurate to {effect.accuracy:g}, which is not within 0 and {_MOST_ACCURACY:g}")
    now = dict(effect.start) if state is None else state
    for unit in effect.units(scenes, now):
        if unit.effect != effect.name:
            faults.append(f"gives a unit of {unit.effect[:40]}")
        if unit.axis and unit.axis not in scenes[0].axes:
            faults.append(f"names the axis {unit.axis[:40]}")
        for parameter in unit.parameters:
            faults += _parameter_faults(parameter)
        for scene in scenes:
            columns = effect.columns(scene, unit, now)
            if len(columns) != len(unit.parameters):
                faults.append(f"gives {len(columns)} columns for {len(unit.parameters)} parameters")
            for column in columns:
                faults += _column_faults(column, effect, scene)
    return faults


def _parameter_faults(p: EffectParameter) -> list[str]:
    if p.lower < 0.0 < p.upper and p.usual > 0.0 and np.isfinite(p.at_edge(p.usual)):
        return []
    return [
        f"has a parameter {p.name[:40]} whose plausible range does not hold 0, or whose ordinary size is not above it"
    ]


def _column_faults(column: Column, effect: Effect, scene: Scene) -> list[str]:
    faults = []
    if column.tcp is not None:
        if column.tcp.shape != (len(scene), 6) or not np.isfinite(column.tcp).all():
            faults.append("gives numbers at the TCP that are not finite, or not one twist a sample")
        if "encoder_to_tcp" not in effect.stages:
            faults.append("moves the TCP behind the encoders without naming that stage")
    for axis, signal in column.servo.items():
        if axis not in scene.axes or signal.shape != (len(scene),) or not np.isfinite(signal).all():
            faults.append("gives numbers at the drives that are not finite, or not one a sample")
        if "setpoint_to_encoder" not in effect.stages:
            faults.append("moves the drives without naming that stage")
    return faults
