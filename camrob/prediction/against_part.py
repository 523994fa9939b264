"""The surface that a machine cuts, held to the part's own mesh: gouges, and material that is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.dexels import Dexels
from camrob.cutting.way import Way

__all__ = ["PartError", "against_part"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PartError:
    """P points of the surface that was cut, in `part`, m. deviation: (P,) by which material stands beyond the mesh, along the cut
    surface's normal (below 0: a gouge); row: (P,) of the run that cut there. elsewhere: cut points whose rays meet no wall of the
    part within `farthest`. gouged, left: m3 that the part lacks, and that stand beyond it. beyond: m by which the mesh
    reaches out of the stock.
    """

    point: Array
    deviation: Array
    row: NDArray[np.int64]
    elsewhere: int
    gouged: float
    left: float
    beyond: float


def against_part(stock: Dexels, way: Way, triangles: Array, *, farthest: float) -> PartError:
    """Hold what a way has left of a stock to a closed mesh (T, 3, 3), m.

    farthest: m along a ray within which the part's wall is looked for; what stands farther off counts in `left` alone.
    Raises InputError for a mesh that isn't closed.
    """
    part = stock.inside(triangles)
    surface = stock.surface(way.moves)
    value, _ = part.nearest_end(surface)
    rows = np.arange(len(value))
    off = surface.point[rows, surface.direction] - value
    met = np.abs(off) < farthest
    along = surface.normal[rows, surface.direction]
    row, _ = way.rows(surface.move, surface.at)
    together = stock.common(part)
    corners = triangles.reshape(-1, 3)
    outside = np.maximum(stock.lower - corners.min(axis=0), corners.max(axis=0) - stock.upper)
    return PartError(
        point=surface.point[met],
        deviation=(off * along)[met],
        row=row[met],
        elsewhere=int(np.count_nonzero(~met)),
        gouged=part.common(part) - together,
        left=stock.common(stock) - together,
        beyond=max(0.0, float(outside.max())),
    )
