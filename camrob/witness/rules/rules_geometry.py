"""What the rules know of places: motions in plain numbers and in columns, and what is clear of the part.

All in `base`, metres and radians. A `Track` leaves out motions that lead nowhere (a point repeated in the file is one point; a
program may turn table and track beneath a tool that stands still): `rows` says which motions of the story are left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Path
from camrob.witness.units import deg_to_rad

__all__ = [
    "AXIS",
    "POSITION",
    "Clear",
    "Motion",
    "Track",
    "Vec",
    "along_ray",
    "distance",
    "lengths_to",
    "sampled",
    "squares",
    "track",
]

Array = NDArray[np.float64]
Vec = tuple[float, float, float]

POSITION = 1e-5  # m: the tip's tolerance
AXIS = deg_to_rad(0.01)  # the axis's
_SAME = 1e-9  # m: two texts of one point
_SAME_TURN = deg_to_rad(1e-3)  # what four decimals of A, B, C leave of an axis that is kept
_LEVER = 0.05  # m: how far up the tool a turn of its axis counts as a way
_CHUNK = 64
_ASKED = 2000  # axes along which all points are gone through: finding the hull takes about as long, or longer
_ABOVE, _BESIDE = 1e-3, 1e-2  # m: from what is solid, along the axis and all round


def distance(a: Vec, b: Vec) -> float:
    """Between two points, or between the ends of two unit vectors: nearly their angle where it is small."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _mixed(a: Vec, s: float, b: Vec, t: float) -> Vec:
    return (s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2])


def along_ray(p: Vec, start: Vec, axis: Vec) -> tuple[float, float]:
    """How far up a ray a point lies, and how far beside it."""
    arm = _mixed(p, 1.0, start, -1.0)
    up = _dot(arm, axis)
    return up, math.sqrt(max(0.0, _dot(arm, arm) - up * up))


@dataclass(slots=True)
class Motion:
    """One motion from `start` to `end`; `angle` is 0 for a straight one, else it runs about `normal` through `center`."""

    start: Vec
    end: Vec
    axis_start: Vec
    axis_end: Vec
    center: Vec
    normal: Vec
    angle: float
    curved: bool = False  # a piece of a curve, given in small steps
    across: tuple[Vec, Vec] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # of an arc: unit, where it starts, and a quarter on
    radii: tuple[float, float] = (0.0, 0.0)
    heights: tuple[float, float] = (0.0, 0.0)  # along the normal, from the centre

    def __post_init__(self) -> None:
        if self.angle:
            n = self.normal
            arms = [_mixed(p, 1.0, self.center, -1.0) for p in (self.start, self.end)]
            self.heights = (_dot(arms[0], n), _dot(arms[1], n))
            flat = [_mixed(arm, 1.0, n, -h) for arm, h in zip(arms, self.heights, strict=True)]
            self.radii = (math.hypot(*flat[0]), math.hypot(*flat[1]))
            size = self.radii[0] or 1.0
            u = (flat[0][0] / size, flat[0][1] / size, flat[0][2] / size)
            self.across = (u, (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]))

    @property
    def length(self) -> float:
        """Of the tip's way."""
        if not self.angle:
            return distance(self.start, self.end)
        return math.hypot(0.5 * (self.radii[0] + self.radii[1]) * self.angle, self.heights[1] - self.heights[0])

    def point(self, f: float) -> Vec:
        """Where the tip is at the fraction `f` of the way."""
        if not self.angle:
            return _mixed(self.start, 1.0 - f, self.end, f)
        r, h = (a + f * (b - a) for a, b in (self.radii, self.heights))
        u, v = self.across
        flat = _mixed(u, r * math.cos(f * self.angle), v, r * math.sin(f * self.angle))
        return _mixed(_mixed(self.center, 1.0, self.normal, h), 1.0, flat, 1.0)

    def axis(self, f: float) -> Vec:
        """The tool's axis there, along the great arc."""
        turn = 2.0 * math.asin(min(1.0, 0.5 * distance(self.axis_start, self.axis_end)))
        if turn < 1e-9:
            return self.axis_end
        s = math.sin(turn)
        if s < 1e-9:  # half a turn: no great arc is the one
            return self.axis_start if f < 0.5 else self.axis_end
        return _mixed(self.axis_start, math.sin((1.0 - f) * turn) / s, self.axis_end, math.sin(f * turn) / s)

    def nearest(self, p: Vec, axis: Vec, f: float = 0.0) -> tuple[float, float]:
        """The fraction from `f` on at which the tool is most nearly at tip p and axis, and the tip's distance there.

        By the tip, on an arc in its first turn from f; by the axis where a straight motion turns it much and moves little,
        as long as the tip is there, too: axes that turn evenly leave the motion's own great arc.
        """
        if self.angle:
            arm = _mixed(p, 1.0, self.center, -1.0)
            now = math.atan2(_dot(arm, self.across[1]), _dot(arm, self.across[0]))
            slack = min(0.5, 2.0 * POSITION / max(self.radii[0], POSITION))
            on = (now - f * self.angle + slack) % (2.0 * math.pi) - slack
            w = f + max(0.0, on) / self.angle
            return self._at(p, w, f)
        if (turn := distance(self.axis_start, self.axis_end)) * _LEVER > distance(self.start, self.end):
            arm, way = _mixed(axis, 1.0, self.axis_start, -1.0), _mixed(self.axis_end, 1.0, self.axis_start, -1.0)
            chord = 2.0 * math.asin(min(1.0, 0.5 * math.sqrt(_dot(arm, arm))))
            by_axis = self._at(p, math.copysign(chord, _dot(arm, way)) / (2.0 * math.asin(min(1.0, 0.5 * turn))), f)
            if by_axis[1] <= POSITION:
                return by_axis
        way = _mixed(self.end, 1.0, self.start, -1.0)
        size = _dot(way, way)
        return self._at(p, _dot(_mixed(p, 1.0, self.start, -1.0), way) / size if size > 0.0 else 1.0, f)

    def _at(self, p: Vec, w: float, f: float) -> tuple[float, float]:
        """The fraction w kept between f and the end, and how far tip p lies from there."""
        w = min(1.0, max(f, w))
        return w, distance(p, self.point(w))

    def sagitta(self, f: float, g: float) -> float:
        """How far the chord from fraction f to g leaves the arc; 0 of a straight motion, inf of more than half a turn."""
        turn = abs(g - f) * self.angle
        return max(self.radii) * (1.0 - math.cos(0.5 * turn)) if turn <= math.pi else math.inf


@dataclass(slots=True)
class Track:
    """Motions column by column: `start` to `tip`, axes, arcs (`angle` 0: straight); `rows` index the story, or the
    run; known: places and axes at both ends are numbers; curved: pieces of a curve.
    """

    start: Array
    tip: Array
    axis_start: Array
    axis: Array
    center: Array
    normal: Array
    angle: Array
    rows: NDArray[np.int64]
    known: NDArray[np.bool_]
    curved: NDArray[np.bool_]
    _chunks: dict[int, list[Motion]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.tip)

    def motion(self, k: int) -> Motion:
        """Motion k in plain numbers."""
        number, at = divmod(k, _CHUNK)
        if number not in self._chunks:
            if len(self._chunks) > 64:
                self._chunks.clear()
            part = slice(number * _CHUNK, (number + 1) * _CHUNK)
            names = ("start", "tip", "axis_start", "axis", "center", "normal")
            columns = [map(tuple, getattr(self, name)[part].tolist()) for name in names]
            lists = self.angle[part].tolist(), self.curved[part].tolist()
            self._chunks[number] = [Motion(*row) for row in zip(*columns, *lists, strict=True)]
        return self._chunks[number][at]

    def statement(self, k: int, begins: NDArray[np.int64]) -> Motion | None:
        """The straight motion that motion k is a piece of; None where it is no piece. begins: where statements begin."""
        found = int(np.searchsorted(begins, k, side="right"))
        first, last = int(begins[found - 1]), (int(begins[found]) if found < len(begins) else len(self)) - 1
        if first == last or self.angle[first : last + 1].any():
            return None
        begin, end = self.motion(first), self.motion(last)
        return replace(begin, end=end.end, axis_end=end.axis_end)


def track(path: Path, frame: Array | None, keep: NDArray[np.bool_]) -> Track:
    """The motions of a path, seen from `base` (frame: base_T_part, None where they are already), without those that lead
    nowhere and aren't in `keep`.
    """

    def placed(vectors: Array, place: bool = False) -> Array:
        if frame is None:
            return vectors
        return vectors @ frame[:3, :3].T + (frame[:3, 3] if place else 0.0)

    tip, axis = placed(path.tip, True), placed(path.axis)
    straight = np.isnan(path.angle)
    moved = np.zeros(len(path), dtype=bool)
    for vectors, same in ((tip, _SAME), (axis, _SAME_TURN)):
        moved[1:] |= ~(squares(vectors[1:] - vectors[:-1]) <= same * same)  # what is not known has moved
    kept = moved | ~straight | keep
    kept[:1] = True
    none = np.broadcast_to(0.0, tip.shape)
    center, normal = (none, none) if straight.all() else (placed(path.center, True), placed(path.normal))
    whole = bool(kept.all())
    sound = np.isfinite(np.einsum("ij->i", tip) + np.einsum("ij->i", axis))
    known = sound & np.concatenate([sound[:1], sound[:-1]])

    def rows(column: Array) -> Array:
        return column if whole else column[kept]

    return Track(
        start=rows(np.concatenate([tip[:1], tip[:-1]])),
        tip=rows(tip),
        axis_start=rows(np.concatenate([axis[:1], axis[:-1]])),
        axis=rows(axis),
        center=rows(center),
        normal=rows(normal),
        angle=rows(np.where(straight, 0.0, path.angle)),
        rows=np.flatnonzero(kept),
        known=known if whole else known[kept],
        curved=rows(path.angle) == 0.0,
    )


def sampled(some: Track, rows: NDArray[np.int64], f: float) -> Array:
    """Where the tip is at the fraction f of motions on arcs: (n, 3)."""
    n, arm = some.normal[rows], some.start[rows] - some.center[rows]
    end = some.tip[rows] - some.center[rows]
    heights = np.sum(arm * n, axis=1), np.sum(end * n, axis=1)
    flat = arm - heights[0][:, None] * n
    radii = np.linalg.norm(flat, axis=1), np.linalg.norm(end - heights[1][:, None] * n, axis=1)
    u = flat / np.maximum(radii[0], 1e-300)[:, None]
    turn, r = f * some.angle[rows], (1.0 - f) * radii[0] + f * radii[1]
    out: Array = some.center[rows] + ((1.0 - f) * heights[0] + f * heights[1])[:, None] * n
    out += (r * np.cos(turn))[:, None] * u + (r * np.sin(turn))[:, None] * np.cross(n, u)
    return out


class Clear:
    """Where the tool is clear of the part.

    Seen along its own axis its tip is no lower than any point of the file, and 1 mm above all that is cut and the corners of
    part and stock; or else all of it, from the tip up, is 10 mm outside the sphere round all of them.
    """

    def __init__(self, free: Array, solid: Array) -> None:
        """free: (K, 3) points that the file goes through by RAPID; solid: (L, 3) points that it cuts, corners of bodies."""
        self._free, self._solid = free, solid
        some = [points for points in (free, solid) if len(points)]
        low, high = (pick([pick(points, axis=0) for points in some], axis=0) for pick in (np.min, np.max))
        middle = 0.5 * (low + high)
        self._radius = max(math.sqrt(squares(points - middle).max()) for points in some) + _BESIDE
        self._middle: Vec = (float(middle[0]), float(middle[1]), float(middle[2]))
        self._tops: dict[Vec, float] = {}

    def above(self, p: Vec, axis: Vec) -> bool:
        """Whether everything lies below p along the axis."""
        key = (round(axis[0], 5), round(axis[1], 5), round(axis[2], 5))
        if key not in self._tops:
            if len(self._tops) == _ASKED:
                self._free, self._solid = _hull(self._free), _hull(self._solid)
            free, solid = ((some @ np.array(axis)).max(initial=-np.inf) for some in (self._free, self._solid))
            self._tops[key] = float(max(free, solid + _ABOVE))
        return _dot(p, axis) >= self._tops[key] - POSITION

    def holds(self, p: Vec, axis: Vec) -> bool:
        """Whether a tool with its tip at p is clear."""
        if self.above(p, axis):
            return True
        up, aside = along_ray(self._middle, p, axis)
        return aside >= self._radius or (up <= 0.0 and distance(p, self._middle) >= self._radius)

    def all_along(self, motion: Motion, f: float = 0.0) -> bool:
        """Whether a motion is clear from the fraction f to its end."""
        low, high = motion.axis(f), motion.axis_end
        if not motion.angle and distance(low, high) < AXIS:
            if self.above(motion.point(f), high) and self.above(motion.end, high):
                return True
        size = motion.length * (1.0 - f) / max(self._radius, 0.1)
        count = 4 + math.ceil(32 * min(8.0, size + distance(low, high)))
        steps = (f + (1.0 - f) * k / count for k in range(count + 1))
        return all(self.holds(motion.point(g), motion.axis(g)) for g in steps)

    @staticmethod
    def around(file: Track, rapid: NDArray[np.bool_], joined: NDArray[np.bool_], corners: Array) -> Clear:
        """Of a placed file, some of whose motions are `rapid` (N,), and the corners (K, 3) of part and stock.

        joined: (N,) where a motion goes on from the one before it. Rapids before the stretch of the first cut lead to none, so
        that nothing has to pass above them.
        """
        stretch = np.cumsum(~joined)
        asked = rapid if rapid.all() else rapid & (stretch >= stretch[np.argmin(rapid)])
        arcs = np.flatnonzero(file.angle)
        bulges = [sampled(file, arcs, k / 32) for k in range(1, 32)] if len(arcs) else []
        return Clear(file.tip[asked], np.vstack([file.tip[~rapid], corners.reshape(-1, 3), *bulges]))


def _hull(points: Array) -> Array:
    """The corners of the points' hull, or all of them where they are few, or lie in a plane."""
    if len(points) <= 500:
        return points
    from scipy.spatial import ConvexHull, QhullError  # takes long to import: only where there is much

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return points


def squares(vectors: Array) -> Array:
    """The squared lengths (n,) of vectors (n, 3)."""
    return np.asarray(np.einsum("ij,ij->i", vectors, vectors))


def lengths_to(file: Track) -> Array:
    """(N + 1,) how far the file has gone before each of its motions; turning the axis by a radian counts as 50 mm."""
    way, turn = (np.sqrt(squares(b - a)) for a, b in ((file.start, file.tip), (file.axis_start, file.axis)))
    way += _LEVER * turn
    arcs = np.flatnonzero(file.angle)
    way[arcs] += file.angle[arcs] * np.linalg.norm(file.start[arcs] - file.center[arcs], axis=1)
    return np.concatenate([[0.0], np.cumsum(way)])
