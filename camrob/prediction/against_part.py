"""The surface that a machine cuts, held to the part's own mesh: gouges, and material that is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from camrob.cutting.dexels import Dexels
from camrob.cutting.way import Way

__all__ = ["PartError", "against_part"]

Array = NDArray[np.float64]

_NEAR = 2.0  # pitches: nearer to the mesh the way along a normal is right, and where rays cross it lies too far aside


@dataclass(frozen=True)
class PartError:
    """P points of the surface that was cut, in `part`, m. deviation: (P,) by which material stands beyond the mesh (below 0: a
    gouge), along the cut surface's normal, and where another side of the mesh is nearer, the way to that; row: (P,) of the run
    that cut there. elsewhere: cut points whose rays meet no wall of the part within `farthest`. gouged, left: m3 that the part
    lacks, and that stand beyond it. beyond: m by which the mesh reaches out of the stock.
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
    deviation = (off * along)[met]
    _no_farther_than_the_wall(deviation, surface.point[met], part, farthest)
    # thin layers lie along the cut surface: rays across it tell how thick they are, rays along it little
    looks = np.bincount(surface.direction, minlength=3)
    share = looks / max(int(looks.sum()), 1)
    together = stock.common(part)
    corners = triangles.reshape(-1, 3)
    outside = np.maximum(stock.lower - corners.min(axis=0), corners.max(axis=0) - stock.upper)
    return PartError(
        point=surface.point[met],
        deviation=deviation,
        row=row[met],
        elsewhere=int(np.count_nonzero(~met)),
        gouged=float(share @ (part.common(part) - together)),
        left=float(share @ (stock.common(stock) - together)),
        beyond=max(0.0, float(outside.max())),
    )


def _no_farther_than_the_wall(deviation: Array, point: Array, part: Dexels, farthest: float) -> None:
    """Make deviations (P,) of points (P, 3) no larger than the way to the nearest place of the part's surface: a ray that passes
    by an edge meets a wall that lies farther off.
    """
    far = np.flatnonzero(np.abs(deviation) > _NEAR * part.pitch)
    if len(far):
        tree = cKDTree(part.ends(), compact_nodes=False, balanced_tree=False)
        nearest, _ = tree.query(point[far], distance_upper_bound=farthest)
        deviation[far] = np.sign(deviation[far]) * np.minimum(np.abs(deviation[far]), nearest)
