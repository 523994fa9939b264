"""The tool's tip lies elsewhere on the flange than the program says."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import LENGTH, PLACES, TOOL_ANGLE, constant, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.frames.fitted_right for s in scenes):
        return ()
    return (Unit("frame_tool", "", place_parameters(PLACES, LENGTH, TOOL_ANGLE)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return constant(scene, [f"tool.{p}" for p in PLACES])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return tuple(f"tool.{p}" for p in PLACES)


EFFECT = Effect(
    name="frame_tool",
    physics="The tool's tip or direction is another one than the cell says, off by the same in the tool's own axes everywhere.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="turn the tool about one point through three or more orientations (the four-point method)",
    remedy=(
        "check that the tool is seated and not bent, then measure it anew (four points, then its direction) and "
        "enter it as the tool's frame"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.0,
    terms=_terms,
    side="right",
)
