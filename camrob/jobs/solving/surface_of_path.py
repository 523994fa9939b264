"""The surface that a path leaves, for plans that make the part's error small: only what lies along its normals counts there.

The path is carved from a block as the simulated cut is (`cutting`), once, before any posture is known: how much of the surface
each move leaves, and where that looks. What a later pass cuts away does not count. How the machine errs has no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.meshes import body_triangles
from camrob.cell.setup import Setup
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, of_mesh
from camrob.cutting.engagement import carved_area
from camrob.cutting.way import Way
from camrob.frozen import digest
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.files.mounting import cutter_of
from camrob.redundancy.accuracy.posture_errors import LeftSurface
from camrob.se3 import inverse

__all__ = ["SurfaceOfPath", "surface_of_path"]

Array = NDArray[np.float64]

_FINE, _COARSE = 0.2e-3, 1e-3  # m between rays, at least and at most where the block is small
_OF_RADIUS = 0.25  # of the cutter's radius: rays as close see each of its grooves
_RAYS = 4e5  # of one direction: some seconds
_STRAIGHT = 1e-2  # of the pitch, by which moves may be off those that are carved
_SLOT = 4.0  # radii: a block about a path that is a line still has both walls
_STEEPEST = 0.5  # cosine to a ray at which it still tells of a surface


@dataclass(frozen=True)
class SurfaceOfPath:
    """What paths of a cutter leave of a stock; of: what that is, in words. base_T_part: (4, 4)."""

    cutter: Cutter
    base_T_part: Array
    setup: Setup
    of: str
    _known: dict[str, LeftSurface | None] = field(default_factory=dict)

    @property
    def of_stock(self) -> bool:
        """Whether the set-up says what is cut; a block about the path tells normals, but not how deep they lie."""
        return self.setup.stock is not None or self.setup.part is not None

    def left(self, base_T_tip: Array, cutting: NDArray[np.bool_]) -> LeftSurface | None:
        """See `CutNormals`."""
        key = digest(base_T_tip, cutting)
        if key not in self._known:
            self._known[key] = self._carved(base_T_tip, cutting)
        return self._known[key]

    def _carved(self, base_T_tip: Array, cutting: NDArray[np.bool_]) -> LeftSurface | None:
        if not np.any(cutting[1:]):
            return None
        part_T_tip = inverse(self.base_T_part) @ base_T_tip
        tip, axis = part_T_tip[:, :3, 3].copy(), part_T_tip[:, :3, 2].copy()
        stock = self._stock(tip[cutting], axis[cutting])
        way = Way.of(tip, axis, self.cutter, tolerance=_STRAIGHT * stock.pitch, label=cutting.astype(np.int64))
        idle = ~cutting[way.kept[1:]]
        moves = replace(way.moves, cutter=np.where(idle, -1, way.moves.cutter))
        taken = carved_area(stock, moves)
        surface = stock.surface(moves, steepest=_STEEPEST)
        if not len(surface.move):
            return None
        row, at = way.rows(surface.move, surface.at)
        # rays of each direction meet a slanting surface the more seldom, and those that it is too flat for not at all
        met = np.abs(surface.normal)
        area = stock.pitch**2 / np.sum(np.where(met >= _STEEPEST, met, 0.0), axis=1)
        reached = np.append(0.0, np.repeat(taken, np.diff(way.kept)))
        return LeftSurface(row + 1, at, surface.normal @ self.base_T_part[:3, :3].T, area, reached)

    def _stock(self, tips: Array, axes: Array) -> Dexels:
        """The block that is carved; tips, axes: (N, 3) where the cutter cuts, in `part`."""
        body = self.setup.stock or self.setup.part
        triangles = None if body is None else body_triangles(body)
        if triangles is None:
            lower, upper = _about(tips, axes, self.cutter.radius)
        else:
            lower, upper = triangles.reshape(-1, 3).min(axis=0), triangles.reshape(-1, 3).max(axis=0)
        size = np.sort(upper - lower)
        pitch = float(np.clip(_OF_RADIUS * self.cutter.radius, _FINE, _COARSE))
        pitch = max(pitch, float(np.sqrt(size[1] * size[2] / _RAYS)))
        if body is not None and body is self.setup.stock and body.mesh is not None and triangles is not None:
            return of_mesh(triangles, pitch)
        return Dexels(lower, upper, pitch)


def _about(tips: Array, axes: Array, radius: float) -> tuple[Array, Array]:
    """Corners of a block about a path: a radius higher and lower than that along the tool, and not narrower than a slot."""
    depth = radius * np.abs(axes.mean(axis=0))
    lower, upper = tips.min(axis=0) - depth, tips.max(axis=0) + depth
    more = 0.5 * np.maximum(_SLOT * radius - (upper - lower), 0.0)
    return lower - more, upper + more


def surface_of_path(inputs: JobInputs) -> SurfaceOfPath | None:
    """The surface that a job's path leaves; None where the set-up does not say the cutter's shape."""
    setup = inputs.setup
    cutter = cutter_of(inputs.tool, setup)
    if cutter is None:
        return None
    of = "the stock" if setup.stock else "a block as large as the part" if setup.part else "a block about the path"
    return SurfaceOfPath(cutter, np.asarray(setup.base_T_part), setup, of)
