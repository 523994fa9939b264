"""Stock as stretches of material along rays in three directions (tri-dexels), and what moves of cutters leave of it.

Van Hook (Computer Graphics 20, 1986, 15) carves rays of one direction, Benouamer and Michelucci (Solid Modeling 1997, 324) three,
so that walls of any slope are crossed by rays that are not along them. The ends of the stretches are exact, not on a grid: a
surface is known to well below the pitch wherever a ray crosses it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.cutter import Cutter
from camrob.cutting.removal_kernel import carve, contacts, crossings_of_mesh, overlap
from camrob.errors import InputError
from camrob.progress import Share

__all__ = ["CutSurface", "Dexels", "Moves", "deviation", "of_mesh"]

Array = NDArray[np.float64]

_ROOM = 4  # stretches that a ray has room for at first; it is doubled where a part needs more
_MOST_RAYS = 40_000_000  # of one direction: some 4 GB
# of the pitch from the block's face to the first ray: no ray lies in a face or on an edge of the CAD's, nor, as no two are
# alike, on the diagonal of a square face
_OFF = 0.5 + np.array([1.2345e-4, 2.3571e-4, 3.1113e-4])
_STOCK = -1
# cosine between normals of two surfaces that are one; others are another wall, or the other side of a ridge
_ALIKE = 0.8
_REPORTS = 26  # ends of the parts that moves are carved in where somebody wants to see how far it is
_LEAKS = 1e-3  # of the rays: as many meet a closed mesh in a seam


@dataclass(frozen=True, slots=True)
class Moves:
    """N straight moves of cutters. tip: (N, 2, 3) m; axis: (N, 2, 3) unit vectors from the tip to the holder; cutter: (N,) number
    of the cutter, -1 for none; cutters: what they are.
    """

    tip: Array
    axis: Array
    cutter: NDArray[np.int64]
    cutters: tuple[Cutter, ...]

    @classmethod
    def along(cls, tip: Array, axis: Array, cutter: Cutter) -> Moves:
        """The moves of one cutter along places (K, 3), with axes (K, 3)."""
        pairs = [np.stack([x[:-1], x[1:]], axis=1) for x in (tip, axis)]
        return cls(pairs[0], pairs[1], np.zeros(len(tip) - 1, np.int64), (cutter,))

    @property
    def shape(self) -> Array:
        """(N, 3) radius, corner and length, zeros where nothing cuts."""
        table = np.array([[c.radius, c.corner, c.length] for c in self.cutters] + [[0.0, 0.0, 0.0]])
        return table[self.cutter]


@dataclass(frozen=True, slots=True)
class CutSurface:
    """Points (P, 3) of a cut surface, m; normal (P, 3) out of the material; move (P,) that cut it, at (P,) which share of it;
    ray (P,) and end (P,): which ray (of all directions) crosses there, and whether material begins (0) or ends (1).
    """

    point: Array
    normal: Array
    move: NDArray[np.int64]
    at: Array
    direction: NDArray[np.int64]
    ray: NDArray[np.int64]
    end: NDArray[np.int64]


class Dexels:
    """Material in a box, as stretches along rays of three directions; `carve` takes away, nothing gives back.

    lower, upper: (3,) of the box, m; pitch: m between rays. For each direction: edge (U, V, 2 M) ends of the stretches,
    rising, owner (U, V, 2 M) numbers of the moves that made them (-1: the stock's own), count (U, V). Raises InputError for a box
    without volume, or of too many rays.
    """

    def __init__(self, lower: Array, upper: Array, pitch: float) -> None:
        self.lower, self.upper, self.pitch = np.asarray(lower, float), np.asarray(upper, float), float(pitch)
        size = np.maximum(1, np.ceil((self.upper - self.lower) / pitch).astype(np.int64))
        if not np.all(self.upper > self.lower) or pitch <= 0.0:
            raise InputError("the stock has no volume", hint="give a box whose corners differ, and a pitch above 0")
        if max(size[0] * size[1], size[1] * size[2], size[2] * size[0]) > _MOST_RAYS:
            raise InputError(f"{size} rays are more than fit", hint="use a wider pitch, or smaller stock")
        shapes = [(int(size[u]), int(size[v])) for u, v in map(self.others, range(3))]
        self.count = [np.ones(s, np.int32) for s in shapes]
        self.owner = [np.full((*s, 2 * _ROOM), _STOCK, np.int32) for s in shapes]
        self.edge = [np.zeros((*s, 2 * _ROOM)) for s in shapes]
        for d in range(3):
            self.edge[d][:, :, 0], self.edge[d][:, :, 1] = self.lower[d], self.upper[d]

    @staticmethod
    def others(direction: int) -> tuple[int, int]:
        """The coordinates across a direction, in cyclic order."""
        return (direction + 1) % 3, (direction + 2) % 3

    def grid(self, direction: int) -> Array:
        """First ray's two coordinates, and the pitch."""
        u, v = self.others(direction)
        first = self.lower + _OFF * self.pitch
        return np.array([first[u], first[v], self.pitch])

    def carve(self, moves: Moves, progress: Share | None = None) -> Array:
        """Take away what moves sweep, in place. Returns m3 that each takes (N,), the mean of what the three directions say.

        progress: called with the share of the moves that is carved.

        Cost: about 50 ns a ray and step of a fifth of the radius.
        """
        shape = moves.shape
        jobs: list[tuple[int, slice, Array, Array, Array]] = []
        for d in range(3):
            order = [*self.others(d), d]
            tip, axis = (np.ascontiguousarray(x[:, :, order]) for x in (moves.tip, moves.axis))
            slabs = _slabs(len(self.count[d]), self.count[d].size)
            self._room(d)
            jobs += [(d, slab, tip, axis, np.zeros(len(shape))) for slab in slabs]
        start = 0
        with ThreadPoolExecutor(_cores()) as pool:
            for end in np.linspace(0, len(shape), _REPORTS if progress else 2).astype(int).tolist()[1:]:
                begin = dict.fromkeys(range(len(jobs)), start)
                while begin:
                    asked = ((*jobs[k], shape[:end], at) for k, at in begin.items())
                    done = pool.map(self._carve, *zip(*asked, strict=True))
                    stuck = {k: reached for k, reached in zip(list(begin), done, strict=True) if reached < end}
                    for d in {jobs[k][0] for k in stuck}:
                        self._widen(d)
                    begin = stuck
                start = end
                if progress is not None:
                    progress(end / max(len(shape), 1))
        return np.asarray(sum(taken for *_, taken in jobs) * self.pitch**2 / 3.0)

    def _carve(self, d: int, slab: slice, tip: Array, axis: Array, taken: Array, shape: Array, begin: int) -> int:
        parts = self.edge[d][slab], self.owner[d][slab], self.count[d][slab]
        u, v = self.others(d)
        box = np.stack([self.lower[[u, v, d]], self.upper[[u, v, d]]])
        box[:, 0] = self.lower[u] + self.pitch * np.array([slab.start, slab.stop + 1])
        count = len(shape)
        return int(carve(*parts, box, slab.start, self.grid(d), tip[:count], axis[:count], shape, begin, taken))

    def _room(self, d: int) -> None:
        """See to it that every ray has room for at least one more stretch."""
        if 2 * int(self.count[d].max()) + 2 > self.edge[d].shape[2]:
            self._widen(d)

    def _widen(self, d: int) -> None:
        self.edge[d] = np.concatenate([self.edge[d], np.zeros_like(self.edge[d])], axis=2)
        self.owner[d] = np.concatenate([self.owner[d], np.full_like(self.owner[d], _STOCK)], axis=2)

    def volume(self, direction: int = 2) -> float:
        """m3 of material, by the rays of one direction."""
        edge, count = self.edge[direction], self.count[direction]
        used = np.arange(edge.shape[2] // 2) < count[:, :, None]
        return float(np.sum(edge[:, :, 1::2][used] - edge[:, :, ::2][used])) * self.pitch**2

    def copy(self) -> Dexels:
        """The same material, to be carved by itself."""
        new = object.__new__(Dexels)
        new.lower, new.upper, new.pitch = self.lower, self.upper, self.pitch
        new.count, new.owner = [x.copy() for x in self.count], [x.copy() for x in self.owner]
        new.edge = [x.copy() for x in self.edge]
        return new

    def inside(self, triangles: Array) -> Dexels:
        """What a closed mesh (T, 3, 3), m, bounds of this box, on the same rays. Raises InputError for one that isn't closed."""
        out = copy(self)
        out.edge, out.owner, out.count = [], [], []
        for d in range(3):
            order = [*self.others(d), d]
            turned, room = np.ascontiguousarray(triangles[:, :, order]), 2 * _ROOM
            U, V = self.count[d].shape
            found, count = crossings_of_mesh(turned, self.grid(d), U, V, room)
            while count.max() > room:
                room *= 2
                found, count = crossings_of_mesh(turned, self.grid(d), U, V, room)
            odd = int(np.count_nonzero(count % 2))
            if odd > _LEAKS * max(int(np.count_nonzero(count)), 1):
                raise InputError(
                    f"{odd} rays end inside the mesh", hint="close its holes: the mesh has to bound a body"
                )
            count[count % 2 == 1] = 0  # a ray through a seam
            out.edge.append(np.clip(found, self.lower[d], self.upper[d]))
            out.count.append((count // 2).astype(np.int32))
            out.owner.append(np.full(found.shape, _STOCK, np.int32))
        return out

    def common(self, other: Dexels) -> float:
        """m3 that are material here and in another on the same rays, the mean of what the three directions say."""
        parts = (overlap(self.edge[d], self.count[d], other.edge[d], other.count[d]) for d in range(3))
        return float(sum(parts)) * self.pitch**2 / 3.0

    def surface(self, moves: Moves, *, steepest: float = 0.5) -> CutSurface:
        """The surface that moves have cut, where rays cross it at no flatter an angle than a cosine of `steepest`."""
        found = [self._surface(d, moves, steepest) for d in range(3)]
        return CutSurface(*(np.concatenate(part) for part in zip(*found, strict=True)))

    def _surface(self, d: int, moves: Moves, steepest: float) -> tuple[Array, ...]:
        edge, owner = self.edge[d], self.owner[d]
        used = (np.arange(edge.shape[2]) < 2 * self.count[d][:, :, None]) & (owner != _STOCK)
        i, j, e = np.nonzero(used)
        who = owner[i, j, e]
        point = np.empty((len(i), 3))
        (u, v), grid = self.others(d), self.grid(d)
        point[:, u], point[:, v], point[:, d] = grid[0] + i * grid[2], grid[1] + j * grid[2], edge[i, j, e]
        at, normal = contacts(point, who, moves.tip, moves.axis, moves.shape)
        keep = np.abs(normal[:, d]) >= steepest
        # the cutter's outward normal points into the material
        parts = (point, -normal, who.astype(np.int64), at, np.full(len(i), d), i * self.count[d].shape[1] + j, e % 2)
        return tuple(np.asarray(x)[keep] for x in parts)

    def nearest_end(self, surface: CutSurface) -> tuple[Array, NDArray[np.int64]]:
        """Where the same rays cross this material's surface nearest to points of another's, the same way round.

        Returns the coordinate along the ray (P,), NaN where there is none, and the number of the move that cut it (P,).
        """
        value, move = np.full(len(surface.ray), np.nan), np.full(len(surface.ray), _STOCK, np.int64)
        for d in range(3):
            for end in range(2):
                rows = np.flatnonzero((surface.direction == d) & (surface.end == end))
                width = self.edge[d].shape[2]
                edge = self.edge[d].reshape(-1, width)[surface.ray[rows]][:, end::2]
                owner = self.owner[d].reshape(-1, width)[surface.ray[rows]][:, end::2]
                used = np.arange(width // 2) < self.count[d].reshape(-1)[surface.ray[rows], None]
                away = np.where(used, np.abs(edge - surface.point[rows, d, None]), np.inf)
                best = np.argmin(away, axis=1)
                there = np.isfinite(away[np.arange(len(rows)), best])
                value[rows] = np.where(there, edge[np.arange(len(rows)), best], np.nan)
                move[rows] = np.where(there, owner[np.arange(len(rows)), best], _STOCK)
        return value, move


def deviation(surface: CutSurface, moves: Moves, other: Dexels, *, farthest: float) -> Array:
    """By how much material `other`, cut by `moves`, stands beyond a surface, along its normals: (P,) m, NaN where its rays meet
    nothing cut within `farthest` m, or a wall that looks elsewhere.

    What a ray says of the distance between two surfaces depends on their slopes: the mean of both is taken, which leaves an error
    of third order in the distance over the cutter's radius.
    """
    rows = np.arange(len(surface.ray))
    value, move = other.nearest_end(surface)
    way = value - surface.point[rows, surface.direction]
    met = np.flatnonzero((np.abs(way) < farthest) & (move != _STOCK))
    there = surface.point[met].copy()
    there[np.arange(len(met)), surface.direction[met]] = value[met]
    _, into = contacts(there, move[met].astype(np.int32), moves.tip, moves.axis, moves.shape)
    slopes = surface.normal[met] - into
    same = -np.sum(surface.normal[met] * into, axis=1) > _ALIKE
    out = np.full(len(rows), np.nan)
    out[met[same]] = (way[met] * 0.5 * slopes[np.arange(len(met)), surface.direction[met]])[same]
    return out


def of_mesh(triangles: Array, pitch: float) -> Dexels:
    """The inside of a closed mesh (T, 3, 3), m. Raises InputError for one that isn't closed."""
    corners = triangles.reshape(-1, 3)
    return Dexels(corners.min(axis=0), corners.max(axis=0), pitch).inside(triangles)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _slabs(rows: int, rays: int) -> Sequence[slice]:
    """Parts of a field of rays, for threads to work on: several a core, as they are not equally busy."""
    parts = min(rows, 4 * _cores(), max(1, rays // 1000))
    edges = np.linspace(0, rows, parts + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(edges) if b > a]
