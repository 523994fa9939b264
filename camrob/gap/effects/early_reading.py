"""A pose is logged before the robot has arrived."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

_USUAL, _MOST = 1e-3, 0.1  # of the way from the pose before
# of the longest step, below which an axis stands; of the energy of steps, that one size for all shows where they are alike
_STANDS, _EVEN = 0.01, 0.9


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if not all(s.poses for s in scenes):
        return ()
    # late too: an axis that overshoots, or a reading that trails
    units = [Unit("early_reading", "", (EffectParameter("share", "1", _USUAL, -_MOST, _MOST),))]
    for a in scenes[0].axes:
        if moved(scenes, a) and shows(scenes, a):
            units.append(
                Unit("early_reading", a, (EffectParameter(f"{a}_beyond", "1", _USUAL, -_MOST, _MOST),), key="own")
            )
    if all(s.servo_gap is not None for s in scenes):
        for a in scenes[0].axes:
            if moved(scenes, a):
                drive = (EffectParameter(f"{a}_drive", "1", _USUAL, -_MOST, _MOST),)
                units.append(Unit("early_reading", a, drive, key="drive"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    reached = scene.command if unit.key == "drive" else scene.link
    before = np.zeros_like(reached)
    before[1:] = reached[:-1] - reached[1:]
    if unit.key == "drive":
        return (Column(servo={unit.axis: before[:, scene.index(unit.axis)]}),)
    if unit.axis:
        return (Column(tcp=scene.shift(unit.axis, before[:, scene.index(unit.axis)])),)
    total = np.zeros((len(scene), 6))
    for k, axis in enumerate(scene.axes):
        if f"{axis}.zero" in scene.places:
            total += scene.shift(axis, before[:, k])
    return (Column(tcp=total),)


def _likewise(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """Where axes came to all their places by steps that are nearly alike, a share of the last one is what a play leaves."""
    even = [_evenly(np.abs(np.concatenate([np.diff(s.link[:, s.index(a)]) for s in scenes]))) for a in _moved(scenes)]
    return ("backlash",) if even and all(even) else ()


def _moved(scenes: Sequence[Scene]) -> list[str]:
    return [a for a in scenes[0].axes if moved(scenes, a)]


def _evenly(steps: Array) -> bool:
    """Whether steps (N,), but for those in which an axis stands, are nearly of one size."""
    taken = steps[steps > _STANDS * steps.max(initial=0.0)]
    return bool(taken.size) and float(taken.mean() ** 2) > _EVEN * float(np.mean(taken**2))


EFFECT = Effect(
    name="early_reading",
    physics="The reading is taken while the robot, or one axis, still has a share of its way from the pose before to go.",
    stages=("setpoint_to_encoder", "encoder_to_tcp"),
    regimes=("time", "position"),
    experiment="measure some poses twice: at once and after two seconds of rest",
    remedy="nothing at the robot: read only when it has stood for two seconds",
    units=_units,
    columns=_columns,
    accuracy=0.1,
    of_machine=False,
    likewise=_likewise,
)
