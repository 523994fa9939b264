"""The arm warms up: its links grow, its foot, its zeros and its tool drift."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import arm_axes, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import ROOM_TEMPERATURE, Scene
from camrob.units import deg_to_rad, mm_to_m

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
    turn, farthest = deg_to_rad(0.004), deg_to_rad(0.1)
    arm = arm_axes(scenes[0].cell)
    links = tuple(EffectParameter(f"{a}_{p}_mm", "mm", usual, -most, most) for a in arm for p in "xyz")
    units = [Unit("thermal_drift", "", links, key="links")]
    for owner in ("root", "tool"):
        shifts = tuple(EffectParameter(f"{owner}_{p}_mm", "mm", usual, -most, most) for p in "xyz")
        turns = tuple(EffectParameter(f"{owner}_r{p}_deg", "deg", turn, -farthest, farthest) for p in "xyz")
        units.append(Unit("thermal_drift", "", shifts, key=f"{owner} shifts"))
        units.append(Unit("thermal_drift", "", turns, key=f"{owner} turns"))
    for a in arm:
        if shows(scenes, a):
            zero = (EffectParameter(f"{a}_zero_deg", "deg", turn, -farthest, farthest),)
            units.append(Unit("thermal_drift", a, zero, key="zero"))
    return tuple(units)


def _terms_of(scene: Scene, unit: Unit) -> list[str]:
    """The constant errors that grow with warmth."""
    if unit.key == "links":
        return [f"{a}.{p}" for a in arm_axes(scene.cell) for p in "xyz"]
    if unit.key == "zero":
        return [f"{unit.axis}.zero"]
    owner, kind = unit.key.split()
    return [f"{owner}.{p}" for p in (("x", "y", "z") if kind == "shifts" else ("rx", "ry", "rz"))]


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    warm = warmth(scene, state)[:, None]
    return tuple(Column(tcp=scene.place(term) * warm) for term in _terms_of(scene, unit))


EFFECT = Effect(
    name="thermal_drift",
    physics="Links grow as the arm warms up, foot, zeros and tool drift with them, towards a steady state with a time constant.",
    rungs=("encoder_to_tcp",),
    regimes=("time",),
    experiment="repeat the same lap every ten minutes from a cold start for an hour",
    units=_units,
    columns=_columns,
    trials=tuple({"tau_s": tau} for tau in (60.0, 120.0, 240.0, 480.0, 900.0, 1800.0, 3600.0)),
    accuracy=0.02,
)
