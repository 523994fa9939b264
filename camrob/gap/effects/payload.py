"""The load at the tool is another one than the controller or the model believes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import arm_axes, tool_mass, under_kilogram
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.robot_size import ordinary_compliance, rated_payload, reach_of
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_STIFFER = 0.75  # of the ordinary compliance: what an axis is taken to have where nobody measured it
# of the rated payload: what is ordinary, of an axis's own, unusual, and more than an arm holds
_USUAL, _OWN, _COMMON, _MOST = 0.33, 0.17, 1.0, 2.0
_LEVER, _FARTHEST = 0.05, 0.7  # of the reach: by how much a load's place is off, and at the most


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if not scenes[0].cell.masses:
        return ()
    cell = scenes[0].cell
    rated = rated_payload(cell)
    most, common = _MOST * rated, _COMMON * rated
    spread = tuple(EffectParameter(f"{a}_share_kg", "kg", _OWN * rated, -most, most) for a in arm_axes(cell)[1:])
    lever, farthest = _LEVER * reach_of(cell) * rated, _FARTHEST * reach_of(cell) * rated
    place = tuple(EffectParameter(f"moment_{p}_kg_m", "kg m", lever, -farthest, farthest) for p in "xyz")
    return (
        Unit(
            "payload", "", (EffectParameter("mass_kg", "kg", _USUAL * rated, -most, most, common), *spread), key="mass"
        ),
        Unit("payload", "", place, key="place"),
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    compliance = _STIFFER * ordinary_compliance(scene.cell)
    center = np.asarray(tool_mass(scene.cell).center)

    def sag(at: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """How each axis gives way to a kilogram at a place of the tool."""
        return [compliance * c.tcp for c in under_kilogram(scene, at) if c.tcp is not None]

    parts = sag(center)
    if unit.key == "place":
        return tuple(Column(tcp=np.sum(sag(center + e), axis=0) - np.sum(parts, axis=0)) for e in np.eye(3))
    # all axes as compliant as usual, and each one's own departure from that
    return tuple(Column(tcp=part) for part in (np.sum(parts, axis=0), *parts[1:]))


EFFECT = Effect(
    name="payload",
    physics="A mass at the tool that nobody counted makes every axis sag in proportion to its own torque about it.",
    stages=("encoder_to_tcp",),
    regimes=("load", "position"),
    experiment=(
        "weigh the tool with all that hangs on it and look at its bolts, then run the path with and without the tool's mass, or "
        "read the axis torques at rest in three postures"
    ),
    remedy=(
        "weigh the tool with its cables and hoses and enter mass and centre of mass as load data, on the "
        "controller and in the cell"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.05,
)
