"""Poses of a path in bundles of alike ones: what is refuted for a bundle is refuted for all of its poses, and between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.freedoms import PlanSpace
from proving.branch_and_bound import Bundles

__all__ = ["Pieces", "bundled", "pieces_of"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_STEP, _TURN = 0.004, 0.02  # m, rad of the path in a piece at most
_FAR = 20.0  # pieces away from the turning axis from where on both ends are turned each by itself
_ALIKE = 1e-9  # m and rad that ends of pieces differ by at least where a bundle falls into two
_ROUNDING = 1e-12  # m and rad, of what is worked out here


@dataclass(frozen=True, slots=True)
class Pieces:
    """What is cut, in M short pieces.

    point (M,): the path point that a piece leads to; share (M,): its middle's share of the way there. origin, axis (M, 2, 3): its
    two ends, turned about the first external axis, where that is endless, until origins lie in one half plane with it (near the
    axis: the middle between them): what that axis takes to one another is alike. sag (M, 2): rad, m that the axis and the origin
    between the ends are off their line at most.
    """

    point: Ints
    share: Array
    origin: Array
    axis: Array
    sag: Array


def pieces_of(space: PlanSpace, path: ToolPathInBase) -> Pieces:
    """The pieces of all cutting moves of a path: straight between its points, the axis by the shortest turn."""
    to = np.flatnonzero(path.cutting[1:]) + 1
    p, z = path.base_T_tip[:, :3, 3], path.base_T_tip[:, :3, 2]
    step = np.linalg.norm(p[to] - p[to - 1], axis=1)
    angle = np.arctan2(np.linalg.norm(np.cross(z[to - 1], z[to]), axis=1), np.sum(z[to - 1] * z[to], axis=1))
    count = np.maximum(np.ceil(np.maximum(step / _STEP, angle / _TURN)), 1.0).astype(np.int64)
    point = np.repeat(to, count)
    k = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
    n, whole = np.repeat(count, count), np.repeat(angle, count)
    origin, axis = np.empty((len(point), 2, 3)), np.empty((len(point), 2, 3))
    for end in range(2):
        share = (k + end) / n
        origin[:, end] = p[point - 1] + share[:, None] * (p[point] - p[point - 1])
        sine = np.where(whole > 1e-9, np.sin(whole), 1.0)  # below, the turn is straight within rounding
        a = np.where(whole > 1e-9, np.sin((1.0 - share) * whole) / sine, 1.0 - share)
        b = np.where(whole > 1e-9, np.sin(share * whole) / sine, share)
        axis[:, end] = a[:, None] * z[point - 1] + b[:, None] * z[point]
    step, angle = np.repeat(step, count) / n, whole / n
    origin, axis, sag = _unturned(space, origin, axis, step, angle)
    return Pieces(point, (k + 0.5) / n, origin, axis, sag + _ROUNDING)


def _unturned(space: PlanSpace, origin: Array, axis: Array, step: Array, angle: Array) -> tuple[Array, Array, Array]:
    """Origins and axes (M, 2, 3) turned back, and the sags (M, 2) of pieces of `step` m, `angle` rad.

    A curve is off its chord by an eighth of its second derivative at most. Of the axis that is turn^2; turned back by an azimuth
    whose rate is w at most, and which itself bends by 2 w^2 at most, it becomes turn^2 + 2 turn w + 3 w^2 across the turning
    axis. The distance from the turning axis bends by step^2 over itself at most.
    """
    sag = np.stack([angle * angle / 8.0, np.zeros(len(step))], axis=1)
    if not len(space.after) or space.prismatic[0] or not space.u_endless[0]:
        return origin, axis, sag
    R, o = space.first[:3, :3], space.first[:3, 3]
    p, z = (origin - o) @ R, axis @ R
    r = np.hypot(p[..., 0], p[..., 1])
    near = np.maximum(r.min(axis=1) - step, 0.0)
    alone = near > _FAR * step
    middle = p.mean(axis=1)
    azimuth = np.where(
        alone[:, None], np.arctan2(p[..., 1], p[..., 0]), np.arctan2(middle[:, 1], middle[:, 0])[:, None]
    )
    c, s = np.cos(azimuth), np.sin(azimuth)

    def turned(v: Array) -> Array:
        return np.stack([c * v[..., 0] + s * v[..., 1], c * v[..., 1] - s * v[..., 0], v[..., 2]], axis=-1)

    rate = np.where(alone, step / np.where(alone, near, 1.0), 0.0)
    lean = np.hypot(z[..., 0], z[..., 1]).max(axis=1) + angle
    sag[:, 0] = (angle * angle + 2.0 * angle * rate + 3.0 * lean * rate * rate) / 8.0
    sag[:, 1] = step * rate / 8.0
    return turned(p) @ R.T + o, turned(z) @ R.T, sag


def bundled(pieces: Pieces, target: Array) -> tuple[Bundles, Ints]:
    """The tree of bundles over pieces with targets (M,), parents first, and which bundle each piece (M,) is in at last."""
    parts: list[list[int]] = []
    poses: list[Array] = []
    size: list[float] = []
    lowest: list[float] = []
    own = np.empty(len(target), np.int64)
    feature = np.concatenate([pieces.origin, pieces.axis], axis=2)
    middle = feature.mean(axis=1)
    waiting = [(np.arange(len(target)), -1, 0)]
    while waiting:
        some, parent, side = waiting.pop()
        k = len(parts)
        parts.append([-1, -1])
        if parent >= 0:
            parts[parent][side] = k
        poses.append(_bundle(feature[some], pieces.sag[some]))
        lowest.append(float(target[some].min()))
        spread = middle[some].max(axis=0) - middle[some].min(axis=0)
        size.append(float(spread.max()))
        if spread.max() < _ALIKE:
            own[some] = k
            continue
        i = int(np.argmax(spread))
        low = middle[some, i] < 0.5 * (middle[some, i].max() + middle[some, i].min())
        waiting += [(some[low], k, 0), (some[~low], k, 1)]
    return Bundles(np.array(poses), np.array(parts), np.array(size), np.array(lowest)), own


def _bundle(feature: Array, sag: Array) -> Array:
    """A frame in the midst of pieces' ends (K, 2, 6), the two ways in which they differ most, and what is left (9, 3)."""
    ends = feature.reshape(-1, 6)
    center = 0.5 * (ends.max(axis=0) + ends.min(axis=0))
    z = center[3:] / max(float(np.linalg.norm(center[3:])), 1e-9)
    center[3:] = z
    off = ends - center
    _u, _s, ways = np.linalg.svd(off, full_matrices=True)
    ways = ways[:2].copy()
    along = off @ ways.T
    middle = 0.5 * (along.max(axis=0) + along.min(axis=0))
    half = 0.5 * (along.max(axis=0) - along.min(axis=0))
    center[:3] += (middle @ ways)[:3]
    ways *= half[:, None]
    share = np.clip((along - middle) / np.maximum(half, 1e-300), -1.0, 1.0)
    left = ends - center - share @ ways
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    off_z, off_p = np.linalg.norm(left[:, 3:], axis=1).max(), np.linalg.norm(left[:, :3], axis=1).max()
    worst = (off_z + sag[:, 0].max(), off_p + sag[:, 1].max(), 0.0)
    return np.array([x, np.cross(z, x), z, center[:3], ways[0, 3:], ways[0, :3], ways[1, 3:], ways[1, :3], worst])
