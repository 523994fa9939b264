"""An axis gets its set-points later than the others, or all get them late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.following import beyond_bounds, following
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
    """Of all axes, where logs part it from a lag: late by a time. Of each: later than the others, or held from cycle to cycle of
    a slower bus.
    """
    if any(s.poses or s.servo_gap is None for s in scenes):
        return ()
    axes = scenes[0].axes if len(scenes[0].axes) > 1 else ()
    late = {a: _behind(scenes, a) for a in axes if moved(scenes, a)}
    usual_delay = float(np.median([seconds for seconds, _ in late.values()])) if late else 0.0
    apart = max(_APART, min(abs(usual_delay), _LAGGING), _SHARE * abs(usual_delay))
    found = following(scenes)
    shared: tuple[Unit, ...] = ()
    if found.common_delay > 0.0:
        shared = (Unit("setpoint_delay", "", (EffectParameter("delay_s", "s", 0.008, -_LEAST, _MOST, _MUCH),)),)
    bounds = {a: beyond_bounds(scenes, a, _MOST) for a in late}
    return shared + tuple(
        Unit("setpoint_delay", a, (EffectParameter(f"{a}_{name}", unit, usual, lower, upper, much),), _CHOICES, name)
        for a, (seconds, weight) in late.items()
        # what all axes have alike is the drives' lag, or a delay of all
        if abs(seconds - usual_delay) > apart
        and (seconds - usual_delay) ** 2 * weight > _CLEAR
        and not found.as_others(a)
        for name, unit, usual, much, (lower, upper) in (
            ("delay_s", "s", 0.008, _MUCH, bounds[a]),
            ("held", "1", 1.0, 3.0, (-3.0, 3.0)),
        )
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


def _begin(scenes: Sequence[Scene]) -> State:
    """What logs with both ends of the drives say, of all axes and of those that are later still."""
    found = following(scenes)
    common = found.common_delay
    own = {f"{a}_delay_s": d - common for a, d in found.delay.items() if d > 0.0 and abs(d - common) > _LEAST}
    return {**({"delay_s": common} if common else {}), **own}


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    common = state.get("delay_s", 0.0)
    if not unit.axis:
        late = delayed(scene.command, scene.t, scene.pieces, common or _START) - scene.command
        return (Column(servo=dict(zip(scene.axes, late.T / (common or _START), strict=True))),)
    own = scene.command[:, [scene.index(unit.axis)]]
    if unit.key == "held":
        since = np.mod(scene.t, state.get("cycle_s", _CYCLES[0]))
        return (Column(servo={unit.axis: -derivative(own, scene.t, scene.pieces)[:, 0] * since}),)
    delay = state.get(unit.parameters[0].name, _START)
    before = delayed(own, scene.t, scene.pieces, common) if common else own
    behind = delayed(own, scene.t, scene.pieces, common + delay) - before
    return (Column(servo={unit.axis: behind[:, 0] / delay}),)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    return {**state, **{n: v for n, v in values.items() if n.endswith("delay_s") and abs(v) > _LEAST}}


def _likewise(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """All set-points late beside a lag bend an axis's course where it speeds up as a lag and an error by acceleration do."""
    found = following(scenes)
    late = {a for a, d in found.delay.items() if d > 0.0}
    return ("acceleration_error",) if found.common_delay > 0.0 and 2 * len(late & found.bent) > len(late) else ()


EFFECT = Effect(
    name="setpoint_delay",
    physics="One axis gets its set-points some cycles later or earlier than the others, or less often; or all get them late.",
    stages=("setpoint_to_encoder",),
    regimes=("speed",),
    experiment="move all axes to and fro together, with hard reversals: the late one turns round after the others",
    remedy=(
        "where all axes are late alike nothing is broken: lower the feed where it counts; else have the bus cycle, the filters "
        "and the interpolation of these axes set like those of the others"
    ),
    odd_axis="have bus cycle, interpolation and filters of {axis} set like those of the other axes, then its gains",
    units=_units,
    columns=_columns,
    begin=_begin,
    refine=_refine,
    trials=tuple({"cycle_s": c} for c in _CYCLES),
    accuracy=0.01,
    likewise=_likewise,
)
