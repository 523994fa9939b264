"""Instrument and controller don't share a clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed

__all__ = ["EFFECT"]

_START = 0.005  # s


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses for s in scenes):
        return ()
    return (Unit("latency", "", (EffectParameter("delay_s", "s", 0.02, -0.5, 0.5),)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    delay = state.get("delay_s", _START)
    then = delayed(scene.link, scene.t, scene.pieces, delay)
    return (Column(tcp=scene.beyond(then) / delay),)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    delay = values.get("delay_s", 0.0)
    return {"delay_s": delay} if abs(delay) > 1e-4 else dict(state)


EFFECT = Effect(
    name="latency",
    physics="A row's measured pose is where the tool was a fixed time before its axis values.",
    stages=("encoder_to_tcp",),
    regimes=("speed",),
    experiment="stop dead a few times: a delay of the clocks shifts the stop in time, a lag of the drives rounds it",
    remedy="nothing at the robot: give controller and instrument one clock or one trigger",
    units=_units,
    columns=_columns,
    refine=_refine,
    accuracy=0.01,
    of_machine=False,
)
