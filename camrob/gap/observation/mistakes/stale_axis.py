"""An axis that stands still in a log and moved while it was recorded: its value was not logged, or was filled in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene, make_scene
from camrob.units import deg_to_rad, m_to_mm

__all__ = ["stale_axis"]

Array = NDArray[np.float64]

_STILL = 1e-9  # rad: the same to the last digit
_SOME = 200  # rows that tell it
# of the gap that is left where the axis is let go in each row, at the most: one of three numbers takes a fifth
_LEFT = 0.1
_GRID = tuple(deg_to_rad(v) for v in (5.0, 0.5, 0.05))  # steps in which each row's value is sought, ever finer
_FAR = deg_to_rad(180.0)
_AROUND = 12  # steps to either side of the last


def stale_axis(scene: Scene) -> str:
    """In words, the one turning axis that stays the same in all rows and, let go row by row, explains nearly all of a log's
    gap; "" without one.
    """
    if scene.share < 1.0:
        return ""  # one number a row fits to a coordinate a row, whatever moved
    turning = [k for k, a in enumerate(scene.axes) if not scene.cell.joints[scene.cell.index(a)].prismatic]
    still = [k for k in turning if np.ptp(scene.link[:, k]) < _STILL]
    rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
    part = make_scene(scene.log.select(rows), scene.cell, laid=scene.frames, least=1) if still else scene
    whole = float(np.median(np.linalg.norm(part.tcp_gap[:, :3], axis=1)))
    found = [(_left(part, k), part.axes[k]) for k in still]
    if not found or min(found)[0] > _LEFT * whole:
        return ""
    left, axis = min(found)
    words = f"its {axis} stays the same to the last digit, and the readings say that it moved (was it logged?)"
    return f"{words}: let go in each row, the measured TCP lies {m_to_mm(left):.2g} mm (median) from where the axis values put it"


def _left(scene: Scene, axis: int) -> float:
    """m: the median gap, an axis wherever it fits each row best."""
    gap, best = scene.tcp_gap[:, :3], np.zeros(len(scene))
    least = np.full(len(scene), np.inf)
    reach = int(np.ceil(_FAR / _GRID[0]))
    for step in _GRID:
        start = best.copy()
        for n in range(-reach, reach + 1):
            there = np.array(scene.link)
            there[:, axis] += start + n * step
            left = np.linalg.norm(gap - scene.beyond(there)[:, :3], axis=1)
            better = left < least
            least[better], best[better] = left[better], (start + n * step)[better]
        reach = _AROUND
    return float(np.median(least))
