"""What the logs' `payload_kg` says beyond the cell's own masses: arm, foot and carriage give way under it, too."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes, tool_mass, under_kilogram
from camrob.gap.effects.effect import Column
from camrob.gap.observation.scene import Scene

__all__ = ["beyond_told", "most_beyond", "told_key", "under_told_load"]

_TOOL = 0.5  # of the payload that is told, from which what the cell knows behind the last axis is a tool
_LEAST_LOAD = 0.05  # kg by which a payload has to be beyond what the cell knows of
# in a unit's key, before kg: what is known of, the most beyond that, and that of a run that tells none
_LOADED = " beyond "


def told_key(scenes: Sequence[Scene]) -> str:
    """For a unit's key: what the logs carry beyond what is known of; "" where that is nothing, or one doesn't say.

    Known is what the cell's masses hold behind the arm's last axis, none of it where that is too little to be a tool: then it is
    the axis's own flange, which no payload counts. Or the least payload of the logs where that is less, or the cell has no
    masses: then what all of them carry is part of what always weighs.
    """
    told = [s.log.info.payload for s in scenes]
    if not np.isfinite(told).all():
        return ""
    cell, least, most = scenes[0].cell, min(told), max(told)
    if cell.masses:
        last = arm_axes(cell)[-1:]
        known = sum(m.mass for m in cell.masses if m.after in last)
        least = min(least, known if known >= _TOOL * most else 0.0)
    if most - least < _LEAST_LOAD:
        return ""
    return f"{_LOADED}{least:.6g} {most - least:.6g} {min(told) - least:.6g}"


def beyond_told(scene: Scene, key: str) -> float:
    """kg that a log carries beyond what is known of; of one that tells no payload, the least that the diagnosed ones did."""
    if _LOADED not in key:
        return 0.0
    least, _, usual = _numbers(key)
    return scene.log.info.payload - least if np.isfinite(scene.log.info.payload) else usual


def under_told_load(scene: Scene, key: str) -> tuple[Column, ...]:
    """How each arm axis gives way, by 1 rad/Nm, to what a log carries beyond what is known of: where the cell's tool has its
    centre, or half-way from the plate to the tip where that tool is a lighter thing.
    """
    cell, carried = scene.cell, beyond_told(scene, key)
    tool, plate = tool_mass(cell), np.asarray(cell.wrist_T_flange)
    tip = plate @ np.asarray(cell.flange_T_tool)
    at = np.asarray(tool.center) if tool.mass >= most_beyond(key) else 0.5 * (plate[:3, 3] + tip[:3, 3])
    return tuple(Column(tcp=carried * c.tcp) for c in under_kilogram(scene, at) if c.tcp is not None)


def most_beyond(key: str) -> float:
    """kg, the most that a diagnosed log carries beyond what is known of."""
    return _numbers(key)[1] if _LOADED in key else 0.0


def _numbers(key: str) -> tuple[float, float, float]:
    least, most, usual = map(float, key.partition(_LOADED)[2].split())
    return least, most, usual
