"""The robot's foot stands elsewhere than the cell says."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import ANGLE, LENGTH, PLACES, constant, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.frames.fitted_left for s in scenes):
        return ()
    return (Unit("frame_base", "", place_parameters(PLACES, LENGTH, ANGLE)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return constant(scene, [f"base.{p}" for p in PLACES])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return tuple(f"base.{p}" for p in PLACES)


EFFECT = Effect(
    name="frame_base",
    physics="The robot's foot stands elsewhere than the cell says, shifted and turned by the same for every posture.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment=(
        "measure three or more far corners of the work space with external axes at rest and the tool's orientation kept: "
        "one shift and one turn bring all of them back if it is the foot, and don't if it is the arm"
    ),
    remedy=(
        "check that the foot is bolted fast where it was measured, then measure the robot's place anew and enter "
        "it in the cell and on the controller"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.0,
    terms=_terms,
    twin_in_world="measurement_frame",
    side="left",
)
