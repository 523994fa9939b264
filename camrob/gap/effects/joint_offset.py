"""An axis's zero is wrong (mastering)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes, constant, found_once
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.unknown_frames import left_twists, right_twists
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

_USUAL, _COMMON, _MOST = deg_to_rad(0.05), deg_to_rad(3.0), deg_to_rad(10.0)  # 2 degrees are ordinary after a crash
_USUAL_SLID, _COMMON_SLID, _MOST_SLID = mm_to_m(0.5), mm_to_m(10.0), mm_to_m(50.0)
_FAR = deg_to_rad(0.2)  # from here on the way is exact, no longer a straight line: that is wrong by 0.01 mm on 1.6 m
_SHOWN = 1e-4  # of what it moves: less of a zero beside open frames is none
_SOME, _RANK = 200, 1e-9  # rows that tell it; of the largest singular value


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    return tuple(
        Unit("joint_offset", a, (_zero(scenes[0], a),))
        for a in arm_axes(scenes[0].cell)
        if not found_once(scenes, ("zero in frames", a), lambda a=a: all(_in_frames(s, a) for s in scenes))  # type: ignore[misc]
    )


def _zero(scene: Scene, axis: str) -> EffectParameter:
    """A zero's own unit: degrees, or mm of an axis that slides."""
    if scene.cell.joints[scene.cell.index(axis)].prismatic:
        return EffectParameter(f"{axis}_mm", "mm", _USUAL_SLID, -_MOST_SLID, _MOST_SLID, _COMMON_SLID)
    return EffectParameter(f"{axis}_deg", "deg", _USUAL, -_MOST, _MOST, _COMMON)


def _in_frames(scene: Scene, axis: str) -> bool:
    """Whether frames that nobody reported hold all that an axis's zero shows: A1's, for an instrument anywhere."""
    rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
    sides = ((left_twists, scene.frames.fitted_left), (right_twists, scene.frames.fitted_right))
    free = [scene.told(twists(scene.nominal))[rows] for twists, fitted in sides if fitted]
    if not free or f"{axis}.zero" not in scene.places:
        return False
    seen = scene.seen[rows].ravel()
    X, y = np.concatenate(free, axis=2).reshape(seen.size, -1)[seen], scene.place(f"{axis}.zero")[rows].ravel()[seen]
    left = y - X @ np.linalg.lstsq(X, y, rcond=_RANK)[0]
    return float(left @ left) < _SHOWN**2 * float(y @ y)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    far = state.get(unit.parameters[0].name, 0.0)
    if abs(far) < _FAR:
        return constant(scene, [f"{unit.axis}.zero"])
    there = np.array(scene.link)
    there[:, scene.index(unit.axis)] += far
    return (Column(tcp=scene.beyond(there) / far),)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    """Axes that are off so far that the arm's other posture counts."""
    far = {n: v for n, v in values.items() if abs(v) >= _FAR and n.endswith("_deg")}
    return {name: float(np.clip(v, -_MOST, _MOST)) for name, v in far.items()}


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return (f"{unit.axis}.zero",)


EFFECT = Effect(
    name="joint_offset",
    physics="The real axis value is the reported one and a constant.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="measure ten postures that turn the other axes widely, or hold the gauge to the marks and enter nothing yet",
    remedy=(
        "master these axes again (the gauge, not the eye), or enter the offset where the controller takes one, and "
        "check the marks after any crash"
    ),
    units=_units,
    columns=_columns,
    refine=_refine,
    accuracy=0.0,
    terms=_terms,
    zeros=True,
)
