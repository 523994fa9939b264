"""The arm warms up, and its links grow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import arm_axes
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import ROOM_TEMPERATURE, Scene
from camrob.units import mm_to_m

__all__ = ["EFFECT", "warmth"]

_TAU = 600.0  # s, where nothing says better
_KELVIN = 10.0  # the rise that growth is told for
_LEAST = 0.03


def warmth(scene: Scene, state: State) -> NDArray[np.float64]:
    """(N,) what growth follows: the measured rise above the room in tens of kelvin, else warming up from the log's start with
    the time constant `tau_s`.
    """
    measured = scene.temperature
    if measured is not None:
        return (measured - ROOM_TEMPERATURE) / _KELVIN
    return np.asarray(1.0 - np.exp(-scene.t / state.get("tau_s", _TAU)))


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses and s.temperature is None for s in scenes):
        return ()
    if max(float(np.abs(warmth(s, state)).max()) for s in scenes) < _LEAST:
        return ()
    usual, most = mm_to_m(0.06), mm_to_m(1.0)
    parameters = tuple(
        EffectParameter(f"{a}_{p}_mm", "mm", usual, -most, most) for a in arm_axes(scenes[0].cell) for p in "xyz"
    )
    return (Unit("thermal_drift", "", parameters),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    warm = warmth(scene, state)[:, None]
    return tuple(Column(tcp=scene.place(f"{a}.{p}") * warm) for a in arm_axes(scene.cell) for p in "xyz")


EFFECT = Effect(
    name="thermal_drift",
    physics="Every link grows as the arm warms up, in lengths and offsets, towards a steady state with a time constant.",
    rungs=("encoder_to_tcp",),
    regimes=("time",),
    experiment="repeat the same lap every ten minutes from a cold start for an hour",
    units=_units,
    columns=_columns,
    trials=tuple({"tau_s": tau} for tau in (60.0, 120.0, 240.0, 480.0, 900.0, 1800.0, 3600.0)),
    accuracy=0.02,
)
