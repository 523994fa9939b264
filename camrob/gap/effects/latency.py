"""Instrument and controller don't share a clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed

__all__ = ["EFFECT"]

_START, _RATE = 0.005, 2e-5  # s; of a quartz
_MOST = 50.0  # times it, that a clock runs fast or slow at all
_FEWEST = 4  # rows of a run that a spline goes through
_LONG = 30.0  # s of a log from which a clock's rate may show

Array = NDArray[np.float64]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses for s in scenes):
        return ()
    units = [Unit("latency", "", (EffectParameter("delay_s", "s", 0.02, -0.5, 0.5),))]
    if max(float(np.ptp(s.t)) for s in scenes) >= _LONG:
        units.append(
            Unit(
                "latency",
                "",
                (EffectParameter("rate", "1", _RATE, -_MOST * _RATE, _MOST * _RATE, 5 * _RATE),),
                key="rate",
            )
        )
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    delay = state.get("delay_s", _START)
    then = scene.beyond(delayed(scene.link, scene.t, scene.pieces, delay))
    if unit.key != "rate":
        return (Column(tcp=then / delay),)
    rate = state.get("rate", _RATE)
    since = scene.t - 0.5 * (scene.t[0] + scene.t[-1])
    return (Column(tcp=(scene.beyond(_then(scene, delay + rate * since)) - then) / rate),)


def _then(scene: Scene, before: Array) -> Array:
    """(N, k) axis values as they were (N,) seconds before, by a spline through each run, straight beyond its ends."""
    out = scene.link.copy()
    for run in scene.pieces:
        own = scene.t[run]
        if len(own) >= _FEWEST:
            at = own - before[run]
            inside = np.clip(at, own[0], own[-1])
            spline = CubicSpline(own, scene.link[run], axis=0)
            out[run] = spline(inside) + spline(inside, 1) * (at - inside)[:, None]
    return out


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    found = dict(state)
    for name, least in (("delay_s", 1e-4), ("rate", 1e-7)):
        if abs(values.get(name, 0.0)) > least:
            found[name] = values[name]
    return found


EFFECT = Effect(
    name="latency",
    physics="A row's measured pose is where the tool was some time before its axis values, a fixed one or one that grows.",
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
