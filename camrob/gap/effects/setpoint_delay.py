"""An axis gets its set-points later than the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed, derivative

__all__ = ["EFFECT"]

_START, _LEAST = 0.004, 1e-4  # s: a cycle of a bus; less is as good as none
_CHOICES = 4
# s that an axis is later than the others: where these are not late, and at the most, where drives lag as they differ; and share
_APART, _LAGGING, _SHARE = 5e-5, 0.001, 0.3
_CLEAR = 100.0  # times the scatter of what stays, that being later than the others explains
_MUCH, _MOST = 0.1, 0.5  # s: already a lot; a bridge between networks may take as long
_CYCLES = (0.008, 0.012, 0.016, 0.024)  # s of a slower bus


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Of each axis: late by a time, or held from cycle to cycle of a slower bus."""
    if any(s.poses or s.servo_gap is None for s in scenes) or len(scenes[0].axes) < 2:
        return ()
    late = {a: _behind(scenes, a) for a in scenes[0].axes if moved(scenes, a)}
    usual_delay = float(np.median([seconds for seconds, _ in late.values()])) if late else 0.0
    apart = max(_APART, min(abs(usual_delay), _LAGGING), _SHARE * abs(usual_delay))
    return tuple(
        Unit("setpoint_delay", a, (EffectParameter(f"{a}_{name}", unit, usual, -most, most, much),), _CHOICES, name)
        for a, (seconds, weight) in late.items()
        # what all axes have alike is the drives' lag
        if abs(seconds - usual_delay) > apart and (seconds - usual_delay) ** 2 * weight > _CLEAR
        for name, unit, usual, much, most in (("delay_s", "s", 0.008, _MUCH, _MOST), ("held", "1", 1.0, 3.0, 3.0))
    )


def _behind(scenes: Sequence[Scene], axis: str) -> tuple[float, float]:
    """s by which an axis trails its set-points, by its speed; and what a square of that explains, a scatter of what stays."""
    upper = lower = left = count = 0.0
    for s in scenes:
        k = s.index(axis)
        v = s.velocity(s.command[:, [k]])[:, 0]
        gap = np.zeros(len(s)) if s.servo_gap is None else s.servo_gap[:, k]
        upper -= float(v @ gap)
        lower += float(v @ v)
        left += float(gap @ gap)
        count += len(s)
    seconds = upper / max(lower, 1e-30)
    return seconds, lower * count / max(left - seconds * upper, 1e-30)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    own = scene.command[:, [scene.index(unit.axis)]]
    if unit.key == "held":
        since = np.mod(scene.t, state.get("cycle_s", _CYCLES[0]))
        return (Column(servo={unit.axis: -derivative(own, scene.t, scene.pieces)[:, 0] * since}),)
    delay = state.get(unit.parameters[0].name, _START)
    behind = delayed(own, scene.t, scene.pieces, delay) - own
    return (Column(servo={unit.axis: behind[:, 0] / delay}),)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    return {**state, **{n: v for n, v in values.items() if n.endswith("_delay_s") and abs(v) > _LEAST}}


EFFECT = Effect(
    name="setpoint_delay",
    physics="One axis gets its set-points some cycles later or earlier than the others, or less often.",
    stages=("setpoint_to_encoder",),
    regimes=("speed",),
    experiment="move all axes to and fro together, with hard reversals: the late one turns round after the others",
    remedy="have the bus cycle, the filters and the interpolation of these axes set like those of the others",
    units=_units,
    columns=_columns,
    refine=_refine,
    trials=tuple({"cycle_s": c} for c in _CYCLES),
    accuracy=0.01,
)
