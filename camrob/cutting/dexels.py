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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.cutter import Cutter
from camrob.cutting.removal_kernel import carve, contacts, crossings_of_mesh, overlap
from camrob.errors import InputError
from camrob.progress import Share

__all__ = ["CutSurface", "Dexels", "MetByRays", "Moves", "deviation", "met_by_rays", "of_mesh"]

Array = NDArray[np.float64]

_ROOM = 4  # stretches that a ray has room for at first; it is doubled in a slab of rays one of which needs more
_SLABS = 64  # of a direction, at the least of 1000 rays: rays that cross many ridges lie close together, as ridges do
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


class MetByRays(NamedTuple):
    """Where rays of P points of a surface meet another: deviation (P,) m, point (P, 3) and at (P,), which share of the `move`
    (P,) that cut there; push: (P, 3), a shift v of that move moves the deviation by push . v. NaN where nothing is met.
    """

    deviation: Array
    point: Array
    push: Array
    at: Array
    move: NDArray[np.int64]


class Dexels:
    """Material in a box, as stretches along rays of three directions; `carve` takes away, nothing gives back.

    lower, upper: (3,) of the box, m; pitch: m between rays; count: for each direction (U, V), the stretches of each ray. Their
    ends lie in slabs of rays, each with room for what its busiest ray needs: `stretches`. Raises InputError for a box without
    volume, or of too many rays.
    """

    def __init__(self, lower: Array, upper: Array, pitch: float) -> None:
        self.lower, self.upper, self.pitch = np.asarray(lower, float), np.asarray(upper, float), float(pitch)
        # as many as lie in the box: one beside it would be material that is not there
        size = np.maximum(1, np.ceil((self.upper - self.lower) / pitch - _OFF).astype(np.int64))
        if not np.all(self.upper > self.lower) or pitch <= 0.0:
            raise InputError("the stock has no volume", hint="give a box whose corners differ, and a pitch above 0")
        if max(size[0] * size[1], size[1] * size[2], size[2] * size[0]) > _MOST_RAYS:
            raise InputError(f"{size} rays are more than fit", hint="use a wider pitch, or smaller stock")
        shapes = [(int(size[u]), int(size[v])) for u, v in map(self.others, range(3))]
        self.count = [np.ones(s, np.int32) for s in shapes]
        self._rows = [_slabs(*s) for s in shapes]
        self._edge, self._owner = self._empty(2 * _ROOM)
        for d in range(3):
            for edge in self._edge[d]:
                edge[:, :, 0], edge[:, :, 1] = self.lower[d], self.upper[d]

    def _empty(self, width: int) -> tuple[list[list[Array]], list[list[NDArray[np.int32]]]]:
        """Edges and owners by direction and slab, so wide."""
        shapes = [[(rows.stop - rows.start, self.count[d].shape[1], width) for rows in self._rows[d]] for d in range(3)]
        owner = [[np.full(s, _STOCK, np.int32) for s in of] for of in shapes]
        return [[np.zeros(s) for s in of] for of in shapes], owner

    def stretches(self, d: int) -> tuple[Array, NDArray[np.int32]]:
        """Of a direction's rays the ends of the stretches (U, V, 2 M), rising, of which `count` tells how many there are, and the
        numbers of the moves that made them (U, V, 2 M), -1: the stock's own.
        """
        width = max(edge.shape[2] for edge in self._edge[d])
        parts = zip(self._edge[d], self._owner[d], strict=True)
        wide = [(_widened(edge, width, 0.0), _widened(owner, width, _STOCK)) for edge, owner in parts]
        edges, owners = zip(*wide, strict=True)
        return np.concatenate(edges), np.concatenate(owners)

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
        return np.asarray(self.carve_by_direction(moves, progress).mean(axis=0))

    def carve_by_direction(self, moves: Moves, progress: Share | None = None) -> Array:
        """As `carve`; returns m3 (3, N) that each move takes, as the rays of each direction have it."""
        shape = moves.shape
        jobs: list[tuple[int, int, Array, Array, Array]] = []
        for d in range(3):
            order = [*self.others(d), d]
            tip, axis = (np.ascontiguousarray(x[:, :, order]) for x in (moves.tip, moves.axis))
            jobs += [(d, slab, tip, axis, np.zeros(len(shape))) for slab in range(len(self._rows[d]))]
        start = 0
        with ThreadPoolExecutor(_cores()) as pool:
            for end in np.linspace(0, len(shape), _REPORTS if progress else 2).astype(int).tolist()[1:]:
                begin = dict.fromkeys(range(len(jobs)), start)
                while begin:
                    asked = ((*jobs[k], shape[:end], at) for k, at in begin.items())
                    done = pool.map(self._carve, *zip(*asked, strict=True))
                    stuck = {k: reached for k, reached in zip(list(begin), done, strict=True) if reached < end}
                    for k in stuck:
                        self._widen(*jobs[k][:2])
                    begin = stuck
                start = end
                if progress is not None:
                    progress(end / max(len(shape), 1))
        of = np.array([d for d, *_ in jobs])
        return np.stack([sum(jobs[k][4] for k in np.flatnonzero(of == d)) for d in range(3)]) * self.pitch**2

    def _carve(self, d: int, slab: int, tip: Array, axis: Array, taken: Array, shape: Array, begin: int) -> int:
        rows = self._rows[d][slab]
        parts = self._edge[d][slab], self._owner[d][slab], self.count[d][rows]
        u, v = self.others(d)
        box = np.stack([self.lower[[u, v, d]], self.upper[[u, v, d]]])
        box[:, 0] = self.lower[u] + self.pitch * np.array([rows.start, rows.stop + 1])
        count = len(shape)
        return int(carve(*parts, box, rows.start, self.grid(d), tip[:count], axis[:count], shape, begin, taken))

    def _widen(self, d: int, slab: int) -> None:
        width = 2 * self._edge[d][slab].shape[2]
        self._edge[d][slab] = _widened(self._edge[d][slab], width, 0.0)
        self._owner[d][slab] = _widened(self._owner[d][slab], width, _STOCK)

    def ends_of(self, count: int) -> NDArray[np.int64]:
        """(3, N) how many ends of material on the rays of each direction each of `count` moves has made, and none since."""
        made = np.zeros((3, count), np.int64)
        for d in range(3):
            for rows, owner in zip(self._rows[d], self._owner[d], strict=True):
                used = np.arange(owner.shape[2]) < 2 * self.count[d][rows][:, :, None]
                made[d] += np.bincount(owner[used & (owner != _STOCK)], minlength=count)
        return made

    def volume(self, direction: int = 2) -> float:
        """m3 of material, by the rays of one direction."""
        length = 0.0
        for rows, edge in zip(self._rows[direction], self._edge[direction], strict=True):
            used = np.arange(edge.shape[2] // 2) < self.count[direction][rows][:, :, None]
            length += float(np.sum(edge[:, :, 1::2][used] - edge[:, :, ::2][used]))
        return length * self.pitch**2

    def copy(self) -> Dexels:
        """The same material, to be carved by itself."""
        new = copy(self)
        new.count = [x.copy() for x in self.count]
        new._owner = [[x.copy() for x in of] for of in self._owner]
        new._edge = [[x.copy() for x in of] for of in self._edge]
        return new

    def inside(self, triangles: Array) -> Dexels:
        """What a closed mesh (T, 3, 3), m, bounds of this box, on the same rays. Raises InputError for one that isn't closed."""
        out = copy(self)
        out._edge, out._owner, out.count = [], [], []
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
            found = np.clip(found, self.lower[d], self.upper[d])
            out._edge.append([found[rows] for rows in self._rows[d]])
            out._owner.append([np.full(edge.shape, _STOCK, np.int32) for edge in out._edge[d]])
            out.count.append((count // 2).astype(np.int32))
        return out

    def common(self, other: Dexels) -> Array:
        """(3,) m3 that are material here and in another on the same rays, as those of each direction have it."""
        length = np.zeros(3)
        for d in range(3):
            for rows, mine, its in zip(self._rows[d], self._edge[d], other._edge[d], strict=True):
                length[d] += overlap(mine, self.count[d][rows], its, other.count[d][rows])
        return length * self.pitch**2

    def surface(self, moves: Moves, *, steepest: float = 0.5) -> CutSurface:
        """The surface that moves have cut, where rays cross it at no flatter an angle than a cosine of `steepest`."""
        found = [self._surface(d, moves, steepest) for d in range(3)]
        return CutSurface(*(np.concatenate(part) for part in zip(*found, strict=True)))

    def _surface(self, d: int, moves: Moves, steepest: float) -> tuple[Array, ...]:
        parts = []
        for rows, edge, owner in zip(self._rows[d], self._edge[d], self._owner[d], strict=True):
            i, j, e = np.nonzero((np.arange(edge.shape[2]) < 2 * self.count[d][rows][:, :, None]) & (owner != _STOCK))
            parts.append((i + rows.start, j, e, edge[i, j, e], owner[i, j, e]))
        i, j, e, along, who = (np.concatenate(x) for x in zip(*parts, strict=True))
        point = np.empty((len(i), 3))
        (u, v), grid = self.others(d), self.grid(d)
        point[:, u], point[:, v], point[:, d] = grid[0] + i * grid[2], grid[1] + j * grid[2], along
        at, normal = contacts(point, who, moves.tip, moves.axis, moves.shape)
        keep = np.abs(normal[:, d]) >= steepest
        # the cutter's outward normal points into the material
        found = (point, -normal, who.astype(np.int64), at, np.full(len(i), d), i * self.count[d].shape[1] + j, e % 2)
        return tuple(np.asarray(x)[keep] for x in found)

    def ends(self) -> Array:
        """(K, 3) m where the rays of all directions enter and leave the material."""
        found = []
        for d in range(3):
            (u, v), grid = self.others(d), self.grid(d)
            for rows, edge in zip(self._rows[d], self._edge[d], strict=True):
                i, j, e = np.nonzero(np.arange(edge.shape[2]) < 2 * self.count[d][rows][:, :, None])
                point = np.empty((len(i), 3))
                point[:, u], point[:, v] = grid[0] + (i + rows.start) * grid[2], grid[1] + j * grid[2]
                point[:, d] = edge[i, j, e]
                found.append(point)
        return np.concatenate(found)

    def nearest_end(self, surface: CutSurface) -> tuple[Array, NDArray[np.int64]]:
        """Where the same rays cross this material's surface nearest to points of another's, the same way round.

        Returns the coordinate along the ray (P,), NaN where there is none, and the number of the move that cut it (P,).
        """
        value, move = np.full(len(surface.ray), np.nan), np.full(len(surface.ray), _STOCK, np.int64)
        for d in range(3):
            across = self.count[d].shape[1]
            own = np.flatnonzero(surface.direction == d)
            slab = np.searchsorted([rows.stop for rows in self._rows[d]], surface.ray[own] // across, side="right")
            for k in np.unique(slab).tolist():
                for end in range(2):
                    some = own[(slab == k) & (surface.end[own] == end)]
                    ray = surface.ray[some] - self._rows[d][k].start * across
                    found = self._nearest(d, k, end, ray, surface.point[some, d])
                    value[some], move[some] = found
        return value, move

    def _nearest(self, d: int, slab: int, end: int, ray: NDArray[np.int64], point: Array) -> tuple[Array, Array]:
        """Of rays (P,) of a slab the ends of a kind that lie nearest to points (P,) along them, and who made them."""
        width = self._edge[d][slab].shape[2]
        edge, owner = (of[d][slab].reshape(-1, width)[ray, end::2] for of in (self._edge, self._owner))
        used = np.arange(width // 2) < self.count[d][self._rows[d][slab]].reshape(-1)[ray, None]
        away = np.where(used, np.abs(edge - point[:, None]), np.inf)
        best = (np.arange(len(ray)), np.argmin(away, axis=1))
        there = np.isfinite(away[best])
        return np.where(there, edge[best], np.nan), np.where(there, owner[best], _STOCK)


def deviation(surface: CutSurface, moves: Moves, other: Dexels, *, farthest: float | Array) -> Array:
    """By how much material `other`, cut by `moves`, stands beyond a surface, along its normals: (P,) m, NaN where its rays meet
    nothing cut within `farthest` m, of all or of each (P,), or a wall that looks elsewhere.
    """
    return met_by_rays(surface, moves, other, farthest=farthest).deviation


def met_by_rays(surface: CutSurface, moves: Moves, other: Dexels, *, farthest: float | Array) -> MetByRays:
    """Where a surface's rays meet what `moves` have left of `other`; the deviation as `deviation` has it.

    What a ray says of the distance between two surfaces depends on their slopes: the mean of both is taken, which leaves an error
    of third order in the distance over the cutter's radius.
    """
    rows = np.arange(len(surface.ray))
    value, move = other.nearest_end(surface)
    way = value - surface.point[rows, surface.direction]
    met = np.flatnonzero((np.abs(way) < farthest) & (move != _STOCK))
    there = surface.point[met].copy()
    there[np.arange(len(met)), surface.direction[met]] = value[met]
    at, into = contacts(there, move[met].astype(np.int32), moves.tip, moves.axis, moves.shape)
    same = -np.sum(surface.normal[met] * into, axis=1) > _ALIKE
    met, there, at, into = met[same], there[same], at[same], into[same]
    along = np.arange(len(met)), surface.direction[met]
    slope = 0.5 * (surface.normal[met] - into)[along]
    gap, push = np.full(len(rows), np.nan), np.full(surface.point.shape, np.nan)
    point, share = push.copy(), gap.copy()
    gap[met], push[met] = way[met] * slope, (slope / into[along])[:, None] * into
    point[met], share[met] = there, at
    return MetByRays(gap, point, push, share, move.astype(np.int64))


def of_mesh(triangles: Array, pitch: float) -> Dexels:
    """The inside of a closed mesh (T, 3, 3), m. Raises InputError for one that isn't closed."""
    corners = triangles.reshape(-1, 3)
    return Dexels(corners.min(axis=0), corners.max(axis=0), pitch).inside(triangles)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _widened(field: NDArray[Any], width: int, filling: float) -> NDArray[Any]:
    """A field (U, V, M) of which each ray has room for `width`."""
    return np.pad(field, ((0, 0), (0, 0), (0, width - field.shape[2])), constant_values=filling)


def _slabs(rows: int, across: int) -> Sequence[slice]:
    """Parts of a field of rays, which threads work on, too."""
    parts = min(rows, _SLABS, max(1, rows * across // 1000))
    edges = np.linspace(0, rows, parts + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(edges) if b > a]
