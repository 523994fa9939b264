"""The instrument's registration to the cell is off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.gap.effects.common import ANGLE, LENGTH, PLACES, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.unknown_frames import left_twists

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.frames.fitted_left for s in scenes):
        return ()
    return (Unit("measurement_frame", "", place_parameters(PLACES, LENGTH, ANGLE)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    twists = left_twists(scene.nominal)
    return tuple(Column(tcp=twists[:, :, k].copy()) for k in range(6))


def _accuses(values: Mapping[str, float], alike: Sequence[str], keys: Sequence[str]) -> str:
    return "its frame is not where it was said to be"


EFFECT = Effect(
    name="measurement_frame",
    physics="What the instrument calls world (or base) is another frame: a rigid motion on the left of all that it measures.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="measure the cell's reference points (nests on the table) with the instrument, the robot standing still",
    remedy="nothing at the robot: measure the cell's reference points again and register the instrument on them",
    units=_units,
    columns=_columns,
    accuracy=0.0,
    hidden_in_world=True,
    of_instrument=_accuses,
    of_machine=False,
    side="left",
)
