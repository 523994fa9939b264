"""Waypoints: the few places of a path at which postures are planned."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel
from camrob.frozen import locked
from camrob.redundancy.accuracy.part_error import PUSH, SHARE
from camrob.redundancy.free_frames import refine, rotation_minimising
from camrob.redundancy.path import ToolPathInBase
from camrob.se3 import pose

__all__ = ["ARM_LENGTH", "Waypoints", "waypoints"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ARM_LENGTH = 0.6  # m of travel that count like a radian of the tool axis's turn
AIR_SPEED = 0.2  # m/s taken for the tool in air


@dataclass(frozen=True, slots=True)
class Waypoints:
    """W places of a path, in the order of travel.

    base_T_tip: (W, 4, 4), x rotation-minimising. s: (W,) place along the path: m of the tip's travel or ARM_LENGTH m a radian of
    the axis's turn, whichever is more, summed. point: (W,) the path point, or the one that the move leads to. on_point: (W,)
    True at a path point. cut: (W,) m of cutting that the waypoint stands for. cutting: (W,) the move to it cuts. time: (W,)
    seconds of the move to it. safe, region: (W,) of the path point (safe False between points). place: (N,) s of each path point.
    push: (W, PUSH), what `part_error` needs to know of each; none where nobody looks at the part's error.
    """

    base_T_tip: Array
    s: Array
    point: Ints
    on_point: NDArray[np.bool_]
    cut: Array
    cutting: NDArray[np.bool_]
    time: Array
    safe: NDArray[np.bool_]
    region: Ints
    place: Array
    push: Array = field(default_factory=lambda: np.zeros((0, PUSH)))

    def __post_init__(self) -> None:
        for name in ("base_T_tip", "s", "cut", "time", "place", "push"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))
        for name, dtype in (
            ("point", np.int64),
            ("region", np.int64),
            ("on_point", np.bool_),
            ("cutting", np.bool_),
            ("safe", np.bool_),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), dtype=dtype, name=name))

    def __len__(self) -> int:
        return len(self.s)

    def take(self, index: Ints) -> Waypoints:
        """Some of the waypoints (indices, increasing), each standing for the cutting and time since the one before."""
        cut = np.concatenate([[0.0], np.cumsum(self.cut)])
        time = np.concatenate([[0.0], np.cumsum(self.time)])
        middle = np.concatenate([[0], (index[1:] + index[:-1] + 1) // 2, [len(self)]])
        cuts = np.concatenate([[0], np.cumsum(self.cutting.astype(np.int64))])
        return Waypoints(
            self.base_T_tip[index],
            self.s[index],
            self.point[index],
            self.on_point[index],
            np.diff(cut[middle]),
            np.diff(cuts[np.concatenate([[0], index + 1])]) > 0,
            np.diff(time[np.concatenate([[0], index + 1])]),
            self.safe[index],
            self.region[index],
            self.place,
            self._pushes_about(index, middle),
        )

    def _pushes_about(self, index: Ints, middle: Ints) -> Array:
        """(K, PUSH) of some waypoints, with the surface of all that each stands for: from middle[k] (K + 1,) on."""
        out = self.pushes(index)
        if not len(out):
            return out
        # a share of the surface at a waypoint counts as often as the waypoint's cut
        left = np.array(self.cut * self.push[:, SHARE])
        total = np.add.reduceat(left, middle[:-1])
        squares = np.add.reduceat(left[:, None] * self.push[:, 3:SHARE], middle[:-1])
        cut = np.add.reduceat(np.array(self.cut), middle[:-1])
        some = (total > 0.0) & (cut > 0.0)
        out[some, 3:SHARE] = squares[some] / total[some, None]
        out[some, SHARE] = total[some] / cut[some]
        return out

    def pushes(self, index: Ints) -> Array:
        """(K, PUSH) of some waypoints, none where there are none at all."""
        return np.array(self.push[index] if len(self.push) else self.push)


def waypoints(path: ToolPathInBase, spacing: float) -> Waypoints:
    """Waypoints of a path no further apart than `spacing` (m of s), linear in its length.

    Every place at which something changes is one: the path's ends, safe points, where regions, cutting and air meet; points
    that lie closer together than `spacing` are passed over, and longer moves get waypoints between.
    """
    tip, axis = path.base_T_tip[:, :3, 3], path.base_T_tip[:, :3, 2]
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    turn = np.arctan2(np.linalg.norm(np.cross(axis[1:], axis[:-1]), axis=1), np.sum(axis[1:] * axis[:-1], axis=1))
    metric = np.maximum(step, ARM_LENGTH * turn)
    place = np.concatenate([[0.0], np.cumsum(metric)])
    keep = _thin(place, _corners(path), spacing)
    wide = np.ascontiguousarray(tip[keep]), np.ascontiguousarray(axis[keep])
    points, axes, where = refine(*wide, spacing, spacing / ARM_LENGTH)
    R = rotation_minimising(axes, np.ascontiguousarray(path.base_T_tip[0, :3, 0]))
    counts = np.diff(where, prepend=-1)
    leads = np.repeat(keep, counts)
    share = np.concatenate([[1.0], *[np.arange(1, c + 1) / c for c in counts[1:]]]) if len(keep) > 1 else np.ones(1)
    before = np.repeat(np.concatenate([[keep[0]], keep[:-1]]), counts)
    s = place[before] + share * (place[leads] - place[before])
    on_point = np.zeros(len(s), np.bool_)
    on_point[where] = True
    cutting = path.cutting[leads]
    length = np.concatenate([[0.0], np.cumsum(step * path.cutting[1:])])
    cut_at = length[before] + share * (length[leads] - length[before])
    speed = np.where(np.isfinite(path.feed[1:]) & (path.feed[1:] > 0.0), path.feed[1:], AIR_SPEED)
    clock = np.concatenate([[0.0], np.cumsum(np.maximum(step / speed, turn))])
    at = clock[before] + share * (clock[leads] - clock[before])
    edge = np.concatenate([[cut_at[0]], 0.5 * (cut_at[1:] + cut_at[:-1]), [cut_at[-1]]])
    frames = pose(R, points)
    frames[where] = path.base_T_tip[keep]
    between = ~on_point
    frames[between] = _carried(frames, between)
    return Waypoints(
        frames,
        s,
        leads,
        on_point,
        np.diff(edge),
        cutting,
        np.diff(at, prepend=at[0]),
        path.safe[leads] & on_point,
        path.region[leads].astype(np.int64),
        place,
    )


def _corners(path: ToolPathInBase) -> NDArray[np.bool_]:
    """(N,) True at points that have to be waypoints."""
    n = len(path)
    must = np.array(path.safe)
    must[[0, n - 1]] = True
    change = (np.diff(path.region) != 0) | (np.diff(path.cutting.astype(np.int8)) != 0)
    must[:-1] |= change
    must[1:] |= np.diff(path.region) != 0
    return must


@kernel
def _thin(place: Array, must: NDArray[np.bool_], spacing: float) -> Ints:
    """Indices of the points to keep: all that must be, and others about `spacing` apart."""
    keep = np.empty(place.shape[0], np.int64)
    count, last = 0, -np.inf
    for k in range(place.shape[0]):
        ahead = place[k + 1] if k + 1 < place.shape[0] else np.inf
        if must[k] or ahead - last > spacing * 1.0001:
            keep[count] = k
            count += 1
            last = place[k]
    return keep[:count].copy()


def _carried(frames: Array, between: NDArray[np.bool_]) -> Array:
    """The frames between path points, x carried from the path point before by the least rotation."""
    source = np.maximum.accumulate(np.where(between, 0, np.arange(len(between))))[between]
    z, old = frames[between, :3, 2], frames[source][:, :3, :]
    v = np.cross(old[:, :, 2], z)
    c = np.sum(old[:, :, 2] * z, axis=1)
    x = old[:, :, 0]
    cross = np.cross(v, x)
    x = x + cross + np.cross(v, cross) / np.maximum(1.0 + c, 1e-9)[:, None]
    x = x - np.sum(x * z, axis=1, keepdims=True) * z
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    out = frames[between].copy()
    out[:, :3, 0], out[:, :3, 1] = x, np.cross(z, x)
    return np.asarray(out)
