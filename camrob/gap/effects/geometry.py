"""The arm's axes stand elsewhere in their links: lengths, offsets and twists, joint zeros left out."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import arm_axes, constant, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

_PARTS = ("x", "y", "rx", "ry")


_FLANGE = (*_PARTS[:2], "z", *_PARTS[2:])


def _names(scene: Scene) -> list[str]:
    return [f"{a}.{p}" for a in arm_axes(scene.cell) for p in _PARTS]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    length, angle = mm_to_m(0.3), deg_to_rad(0.02)
    names = [n.replace(".", "_") for n in _names(scenes[0])]
    # the last row ends at the flange: what is off there looks like a small error of the tool
    last = place_parameters([f"flange_{p}" for p in _FLANGE], length, angle)
    return (Unit("geometry", "", (*place_parameters(names, length, angle), *last)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return constant(scene, [*_names(scene), *(f"tool.{p}" for p in _FLANGE)])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    """The flange's row is a displacement of what it carries."""
    places = [p.name.rpartition("_")[0] for p in unit.parameters]
    return tuple(p.replace("flange_", "tool.") if p.startswith("flange_") else p.replace("_", ".") for p in places)


EFFECT = Effect(
    name="geometry",
    physics="Each axis of the arm is displaced and tilted against the one before by the tolerances of castings and bearings.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="calibrate the arm on 50 or more postures spread over its whole range (camrob calibrate)",
    remedy="nothing to adjust: arms are built so, unless this one has hit something; it is corrected in the program",
    odd_axis=(
        "look at what has hit the arm: first the mastering marks of all axes, as a zero that is lost hides in these values, then "
        "a bent or exchanged link; then calibrate it"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.002,
    terms=_terms,
)
