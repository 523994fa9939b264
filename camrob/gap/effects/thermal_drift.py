"""The arm warms up: its links grow, its foot, its zeros and its tool drift."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.effects.common import arm_axes, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import ROOM_TEMPERATURE, Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT", "warmth"]

_TAU = 600.0  # s, where nothing says better
_KELVIN = 10.0  # the rise that growth is stated for
_LEAST = 0.03
_EXPANSION, _MOST_EXPANSION = 1.2e-4, 1e-3  # of a length in 10 kelvin: steel; aluminium warmer than the room by far


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
    # of one kind of metal, warm alike, a link grows by its length; and each by what it has of its own
    expansion = EffectParameter("expansion", "1", _EXPANSION, -0.1 * _EXPANSION, _MOST_EXPANSION)
    units = [Unit("thermal_drift", "", (expansion,), key="growth"), Unit("thermal_drift", "", links, key="links")]
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


def _lengths(scene: Scene) -> dict[str, float]:
    """How far each axis of the arm, and the plate, stand from the axis before (the first from the foot), m, by the constant
    errors along which they would grow: in that axis's own frame, the plate's in the tool's.
    """
    cell = scene.cell
    out: dict[str, float] = {}
    link_T_next = np.eye(4)
    for joint in (j for j in cell.joints if j.role is Role.ARM):
        before = link_T_next @ joint.before
        grown = before[:3, :3].T @ before[:3, 3]
        out |= {f"{joint.name}.{p}": float(grown[k]) for k, p in enumerate("xyz")}
        link_T_next = np.asarray(joint.after)
    plate = link_T_next @ cell.wrist_T_flange
    grown = (plate @ cell.flange_T_tool)[:3, :3].T @ plate[:3, 3]
    return out | {f"tool.{p}": float(grown[k]) for k, p in enumerate("xyz")}


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    warm = warmth(scene, state)[:, None]
    if unit.key == "growth":
        total = np.zeros((len(scene), 6))
        for term, length in _lengths(scene).items():
            total += length * scene.place(term)
        return (Column(tcp=total * warm),)
    return tuple(Column(tcp=scene.place(term) * warm) for term in _terms_of(scene, unit))


EFFECT = Effect(
    name="thermal_drift",
    physics="Links grow as the arm warms up, foot, zeros and tool drift with them, towards a steady state with a time constant.",
    stages=("encoder_to_tcp",),
    regimes=("time",),
    experiment="repeat the same lap every ten minutes from a cold start for an hour",
    remedy=(
        "warm the arm up before measuring and cutting, for three times the time constant, or measure a fixed point "
        "again between"
    ),
    units=_units,
    columns=_columns,
    trials=tuple({"tau_s": tau} for tau in (60.0, 120.0, 240.0, 480.0, 900.0, 1800.0, 3600.0)),
    accuracy=0.02,
)
