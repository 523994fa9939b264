"""Moves through air between regions, and the whole path in `base`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import ToolpathError
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.clear_air import ClearAir
from camrob.redundancy.free_frames import rotation_minimising
from camrob.redundancy.path import REPEATED, TRANSIT, ToolPathInBase
from camrob.se3 import pose
from camrob.toolpath.region import Move, Region, goes_on
from camrob.toolpath.toolpath import Toolpath

__all__ = ["build_path"]

Array = NDArray[np.float64]

SAME_AXIS = 0.0087  # rad (half a degree): below it two regions count as worked from one side
_ARC_STEP = 0.1  # rad between points of a move around the part


@dataclass(frozen=True, slots=True)
class _End:
    """Where a region begins or ends: tip (3,), unit axis (3,), and whether the CL file has the tool in the air there."""

    tip: Array
    axis: Array
    in_air: bool
    operation: str


@dataclass(frozen=True, slots=True)
class _Piece:
    """Points of the path in their order: columns of `ToolPathInBase`, but for the frames, which are tips and axes here."""

    tip: Array
    axis: Array
    move: NDArray[np.int8]
    feed: Array
    line: NDArray[np.int64]
    region: NDArray[np.int64]
    source: NDArray[np.int64]
    safe: NDArray[np.bool_]
    stretch: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.tip)

    def kept(self, keep: NDArray[np.bool_]) -> _Piece:
        """Some of the points."""
        if keep.all():
            return self
        return _Piece(*(np.asarray(getattr(self, f.name))[keep] for f in fields(self)))


def build_path(
    cell: Cell,
    toolpath: Toolpath,
    base_T_part: Array,
    *,
    clearance: float,
    bounds: Array | None = None,
    changes: Mapping[int, Array] | None = None,
) -> ToolPathInBase:
    """The toolpath placed in `base`, with moves through air before, between and after its regions.

    clearance: m above all that the file mentions (and `bounds` (K, 3), points of the stock in `base`). Regions worked from
    one side are linked above the highest point; regions worked from different sides around a sphere about the part, along
    which the tool axis turns. Nothing is put between regions of one operation where the file itself goes through the air
    from the one to the other or stays where it is, nor where a region goes on with the cut in which the one before it ends.
    A link's points are safe places for revisions and file borders.
    changes: regions, counted without empty ones, before which the tool is changed, with base_T_tool (4, 4) of the next tool
    at the pose for changes. There a stretch of the path ends above the one region, and the next begins above the other.
    A point that repeats the one before it (`REPEATED`) is left out: no motion leads to it. Raises ToolpathError for a
    toolpath without points.
    """
    regions = [r for r in toolpath.regions if len(r)]
    if not regions:
        raise ToolpathError("holds no motion", hint="give a file with GOTO points", path=toolpath.source)
    changes = changes or {}
    stretch_of = np.cumsum([k in changes for k in range(len(regions))])
    worked = [_worked(r, k, base_T_part, int(stretch_of[k])) for k, r in enumerate(regions)]
    tips = [piece.tip for piece in worked]
    everything = np.concatenate([*tips, bounds]) if bounds is not None else np.concatenate(tips)
    pieces: list[_Piece] = []
    leave: _End | None = None
    for k, (region, piece) in enumerate(zip(regions, worked, strict=True)):
        come = _End(piece.tip[0], piece.axis[0], piece.move[0] == Move.RAPID, region.operation)
        if k in changes:
            pieces.append(_air(_link(leave, None, everything, clearance), int(stretch_of[k]) - 1))
            leave = None
        if leave is not None and goes_on(regions[k - 1], region):
            points = []
        else:
            points = _link(leave, come, everything, clearance, detached=region.detached)
        pieces += [_air(points, int(stretch_of[k])), piece]
        leave = _End(piece.tip[-1], piece.axis[-1], piece.move[-1] == Move.RAPID, region.operation)
    pieces.append(_air(_link(leave, None, everything, clearance), int(stretch_of[-1])))
    whole = _Piece(*(np.concatenate([getattr(p, f.name) for p in pieces]) for f in fields(_Piece)))
    begins = np.cumsum([len(p) for p in pieces])[:-1]
    suspects = np.concatenate([begins, np.flatnonzero(whole.source < 0)])
    whole = _without_repeats(whole, suspects[(suspects > 0) & (suspects < len(whole))])
    home = base_T_tool(cell, cell.q_home)
    starts = [home, *(changes[k] for k in sorted(changes))]
    frames = np.concatenate([_frames(whole.kept(whole.stretch == n), start) for n, start in enumerate(starts)])
    path = ToolPathInBase(
        base_T_tip=frames,
        **{f.name: getattr(whole, f.name) for f in fields(whole) if f.name not in ("tip", "axis")},
    )
    clear = np.array(path.safe)
    clear[clear] = ClearAir.of(path, [] if bounds is None else [bounds]).holds(frames[clear])
    return replace(path, clear=clear)


def _frames(piece: _Piece, start: Array) -> Array:
    """Frames (N, 4, 4) of a stretch: x begins at the roll that the tool has at `start` (4, 4) and is carried on from there."""
    axis = piece.axis / np.linalg.norm(piece.axis, axis=1, keepdims=True)
    rotations = rotation_minimising(np.concatenate([start[None, :3, 2], axis]), np.ascontiguousarray(start[:3, 0]))[1:]
    return pose(rotations, piece.tip)


def _worked(region: Region, index: int, base_T_part: Array, stretch: int) -> _Piece:
    """A region's own points, each once."""
    n = len(region)
    piece = _Piece(
        region.position @ base_T_part[:3, :3].T + base_T_part[:3, 3],
        region.axis @ base_T_part[:3, :3].T,
        region.move,
        region.feed,
        region.line,
        np.full(n, index),
        np.arange(n),
        np.ones(n, np.bool_),
        np.full(n, stretch),
    )
    piece = _without_repeats(piece, np.arange(1, n))
    return replace(piece, safe=_air_points(piece.move))


def _air_points(move: NDArray[np.int8]) -> NDArray[np.bool_]:
    """(N,) True where the tool came in rapid and leaves in rapid: it is clear of the part there."""
    rapid = move == Move.RAPID
    return np.asarray(rapid & np.append(rapid[1:], True))


def _air(points: Sequence[tuple[Array, Array]], stretch: int) -> _Piece:
    """camrob's own points through air."""
    n = len(points)
    return _Piece(
        np.array([t for t, _ in points]).reshape(n, 3),
        np.array([a for _, a in points]).reshape(n, 3),
        np.full(n, int(Move.LINK), np.int8),
        np.full(n, np.nan),
        np.zeros(n, np.int64),
        np.full(n, TRANSIT),
        np.full(n, -1),
        np.ones(n, np.bool_),
        np.full(n, stretch),
    )


def _without_repeats(piece: _Piece, suspects: NDArray[np.int64]) -> _Piece:
    """The points without those of `suspects` that repeat the one before: of the file's own and camrob's the file's stays."""
    for column in (piece.tip, piece.axis):
        for k in range(3):
            suspects = suspects[np.abs(column[suspects, k] - column[suspects - 1, k]) <= REPEATED]
    suspects = np.unique(suspects[piece.stretch[suspects] == piece.stretch[suspects - 1]])
    keep = np.ones(len(piece), np.bool_)
    safe = piece.safe.copy()
    last, seen = -1, -2
    for i in suspects.tolist():
        if seen != i - 1:
            last = i - 1
        seen = i
        off = max(np.abs(column[i] - column[last]).max() for column in (piece.tip, piece.axis))
        if off > REPEATED:
            last = i
        elif piece.source[last] < 0 <= piece.source[i]:
            keep[last], last = False, i
        else:
            keep[i] = False
            safe[last] &= safe[i] | (piece.source[i] < 0)
    return replace(piece, safe=safe).kept(keep)


def _link(
    leave: _End | None, come: _End | None, everything: Array, clearance: float, *, detached: bool = False
) -> list[tuple[Array, Array]]:
    """Points (tip, axis) through air from the end of one region to the begin of the next (None: from or to HOME).

    detached: the file does not say where the tool comes from, so that the way between is camrob's own in any case.
    """
    if leave is not None and come is not None:
        if float(np.arccos(np.clip(leave.axis @ come.axis, -1.0, 1.0))) > SAME_AXIS:
            return _around(leave, come, everything, clearance)
        stays = float(np.abs(leave.tip - come.tip).max()) <= REPEATED
        if leave.in_air and come.in_air and (stays or leave.operation == come.operation) and not detached:
            return []
    return [_lifted(end, everything, clearance) for end in (leave, come) if end is not None]


def _lifted(end: _End, everything: Array, clearance: float) -> tuple[Array, Array]:
    """The end drawn back along its axis above everything."""
    height = float(np.max(everything @ end.axis)) + clearance
    return end.tip + max(height - float(end.tip @ end.axis), clearance) * end.axis, end.axis


def _around(leave: _End, come: _End, everything: Array, clearance: float) -> list[tuple[Array, Array]]:
    """Out along the one axis, around the part on a sphere while the axis turns, in along the other."""
    center = 0.5 * (everything.min(axis=0) + everything.max(axis=0))
    radius = float(np.max(np.linalg.norm(everything - center, axis=1))) + clearance
    out, back = (_on_sphere(e, center, radius) for e in (leave, come))
    far = max(_angle(out - center, back - center), _angle(leave.axis, come.axis))
    count = max(2, int(np.ceil(far / _ARC_STEP)))
    points = []
    for s in np.linspace(0.0, 1.0, count + 1):
        direction = _between(out - center, back - center, float(s))
        points.append((center + radius * direction, _between(leave.axis, come.axis, float(s))))
    return points


def _on_sphere(end: _End, center: Array, radius: float) -> Array:
    """Where the ray from the tip along the axis leaves the sphere."""
    d = end.tip - center
    b = float(d @ end.axis)
    return np.asarray(end.tip + (-b + np.sqrt(b * b - float(d @ d) + radius * radius)) * end.axis)


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _between(a: Array, b: Array, s: float) -> Array:
    """Unit vector at the share s of the great arc from a to b; of the many arcs between opposites, one over +z or +x."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    v = np.cross(a, b)
    sine = float(np.linalg.norm(v))
    if sine < 1e-9:
        if a @ b > 0.0:
            return np.asarray(a)
        over = np.array([0.0, 0.0, 1.0]) if abs(a[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
        side = over - (over @ a) * a
        side = side / np.linalg.norm(side)
        return np.asarray(np.cos(s * np.pi) * a + np.sin(s * np.pi) * side)
    turn = np.arctan2(sine, a @ b)
    side = np.cross(v / sine, a)
    return np.asarray(np.cos(s * turn) * a + np.sin(s * turn) * side)
