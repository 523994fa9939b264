"""The table's axis stands elsewhere, or leans."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.cell.joint import Role
from camrob.gap.effects.common import ANGLE, LENGTH, constant, moved, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_PARTS = ("x", "y", "rx", "ry")


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    cell = scenes[0].cell
    tables = [j.name for j in cell.joints if j.role is Role.WORKPIECE and not j.prismatic]
    return tuple(
        Unit("frame_table", axis, place_parameters(_PARTS, LENGTH, ANGLE))
        for axis in tables
        if all(f"{axis}.x" in s.places for s in scenes) and moved(scenes, axis)
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    return constant(scene, [f"{unit.axis}.{p}" for p in _PARTS])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    return tuple(f"{unit.axis}.{p}" for p in _PARTS)


EFFECT = Effect(
    name="frame_table",
    physics="The table turns about an axis that is offset and tilted; measured from the world this never shows.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment='measure in the turning base (measured_frame = "base") the same point at four table angles',
    remedy="measure the table's axis anew and enter it as the table's root point on the controller and in the cell",
    units=_units,
    columns=_columns,
    accuracy=0.0,
    terms=_terms,
)
