"""The arm warms up and grows, about its foot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import ROOM_TEMPERATURE, Scene
from camrob.units import mm_to_m

__all__ = ["EFFECT", "warmth"]

_TAU = 600.0  # s, where nothing says better
_KELVIN = 10.0  # the rise that growth is told for
_LEAST = 0.03


def warmth(scene: Scene, state: State) -> tuple[NDArray[np.float64], ...]:
    """(N,) each: what growth follows. The measured rise above the room in tens of kelvin, and its square, as links lead or
    trail the place of the sensor; else warming up from the log's start with the time constant `tau_s`.
    """
    measured = scene.temperature
    if measured is not None:
        rise = (measured - ROOM_TEMPERATURE) / _KELVIN
        return rise, rise * np.abs(rise)
    return (1.0 - np.exp(-scene.t / state.get("tau_s", _TAU)),)


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    known = all(s.temperature is not None for s in scenes)
    shapes = [warmth(s, state) for s in scenes]
    if max(float(np.abs(w).max()) for shape in shapes for w in shape) < _LEAST:
        return ()
    growth = [EffectParameter("growth", "1", 2e-4, -1e-3, 2e-3)]
    if known:
        growth.append(EffectParameter("growth_bend", "1", 5e-5, -1e-3, 1e-3))
    foot = tuple(EffectParameter(f"foot_{p}_mm", "mm", mm_to_m(0.1), -1e-3, 1e-3) for p in "xyz")
    return (Unit("thermal_drift", "", tuple(growth), key="arm"), Unit("thermal_drift", "", foot, key="foot"))


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    shapes = warmth(scene, state)
    if unit.key == "foot":
        return tuple(Column(tcp=scene.place(f"root.{p}") * shapes[0][:, None]) for p in "xyz")
    reach = np.concatenate([scene.reach(), np.zeros((len(scene), 3))], axis=1)
    return tuple(Column(tcp=reach * w[:, None]) for w in shapes[: len(unit.parameters)])


EFFECT = Effect(
    name="thermal_drift",
    physics="The arm grows away from its foot as it warms up, towards a steady state with a time constant.",
    rungs=("encoder_to_tcp",),
    regimes=("time",),
    experiment="repeat the same lap every ten minutes from a cold start for an hour",
    units=_units,
    columns=_columns,
    trials=tuple({"tau_s": tau} for tau in (60.0, 120.0, 240.0, 480.0, 900.0, 1800.0, 3600.0)),
    accuracy=0.02,
    compensable=True,
)
