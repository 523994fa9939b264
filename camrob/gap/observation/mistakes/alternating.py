"""Readings of which every second one lies beside those between: two targets, faces or stations that were read in turn."""

from __future__ import annotations

import numpy as np

from camrob.cell.cell import Cell
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.units import m_to_mm

__all__ = ["alternating"]

_LEAST, _MANY = 100, 5000  # rows that are asked
_SURE = 8.0  # times what noise alone makes of it
_LARGE = 0.5  # of the noise: less than that is lost in it


def alternating(log: MeasurementLog, cell: Cell) -> str:
    """In words, by how much every second reading of a run lies beside its neighbours; "" where it is no more than noise."""
    if log.info.poses or not log.has_position or not log.has_axes(cell.axis_names):
        return ""
    part = log.select(slice(_MANY))
    if part.complete(part.place_names).sum() < _LEAST:
        return ""
    gap = make_scene(part, cell).tcp_gap[:, :3]
    beside = gap[1:-1] - 0.5 * (gap[:-2] + gap[2:])
    turns = np.where(np.arange(len(beside)) % 2 == 0, -1.0, 1.0)[:, None]
    apart = np.mean(turns * beside, axis=0)
    noise = float(np.sqrt(np.median(np.sum((beside - turns * apart) ** 2, axis=1)) / 1.5))
    size = float(np.linalg.norm(apart))
    if size < max(_SURE * 2.0 * noise / np.sqrt(len(beside)), _LARGE * noise):
        return ""
    by = ", ".join(f"{m_to_mm(abs(v)):.3f}" for v in apart)
    name = log.name
    return f"every second reading of {name} lies ({by}) mm beside those between: give what was read in turn as two logs"
