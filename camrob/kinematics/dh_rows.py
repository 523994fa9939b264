"""Standard Denavit-Hartenberg rows of a chain whose frames lie otherwise, such as a URDF's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Joint

__all__ = ["DhChain", "DhRow", "dh_chain"]

Array = NDArray[np.float64]

_SQUARE = 2e-5  # sine or cosine below which axes count as parallel or square: files round pi / 2 to 1.5708
_MEET = 1e-9  # m between lines that count as meeting


class DhRow(NamedTuple):
    """Rz(theta) Tz(d) Tx(a) Rx(alpha), m and rad; the joint's q adds to theta or d."""

    alpha: float
    a: float
    theta: float
    d: float


class DhChain(NamedTuple):
    """rows: one a joint. base_T_frames: (n + 1, 4, 4) the frame before the first row and those in which each ends, all q 0.

    base_T_ends: (n, 4, 4) where the chain's own joints end then.
    """

    rows: tuple[DhRow, ...]
    base_T_frames: Array
    base_T_ends: Array


def dh_chain(joints: Sequence[Joint]) -> DhChain:
    """The rows of joints by the common normals of their axes (Denavit and Hartenberg 1955; distal frames).

    Axes that are parallel or square but for a file's rounding are made so, and poses differ by as much.
    """
    place, axes, ends = np.eye(4), [], []
    for joint in joints:
        at = place @ joint.before
        axes.append((at[:3, 3].copy(), at[:3, 2].copy()))
        place = at @ joint.after
        ends.append(place)
    origin, z = axes[0]
    frames = [_frame(origin, _across(z), z)]
    rows = []
    for k in range(len(joints)):
        before = frames[-1]
        z = before[:3, 2]
        if k + 1 == len(joints):
            after = before.copy()
        else:
            after = _next(before, *axes[k + 1], slides=joints[k].prismatic)
        frames.append(after)
        x, x_next, step = before[:3, 0], after[:3, 0], after[:3, 3] - before[:3, 3]
        rows.append(
            DhRow(
                alpha=_angle(z, after[:3, 2], x_next),
                a=float(step @ x_next),
                theta=_angle(x, x_next, z),
                d=float(step @ z),
            )
        )
    return DhChain(tuple(rows), np.stack(frames), np.stack(ends))


def _next(before: Array, point: Array, axis: Array, *, slides: bool) -> Array:
    """The frame with its z along the next axis and its x along the common normal from this one's."""
    origin, z = before[:3, 3], before[:3, 2]
    axis = _straight(axis, z)
    across, gap = np.cross(z, axis), point - origin
    size = float(np.linalg.norm(across))
    if size == 0.0:
        gap = gap - (gap @ z) * z
        far = float(np.linalg.norm(gap))
        # the row's d is free where the axes are parallel, and none; a joint that slides keeps its place
        return _frame(origin + gap if not slides else point, gap / far if far > _MEET else before[:3, 0], axis)
    x = across / size
    foot = point + axis * float(np.cross(gap, z) @ across) / size**2  # on the next axis, nearest to this one
    offset = float((foot - origin) @ x)
    return _frame(foot, x * np.sign(offset) if abs(offset) > _MEET else x, axis)


def _straight(axis: Array, z: Array) -> Array:
    """The axis, parallel or square to z where it is nearly so."""
    along = float(axis @ z)
    if np.linalg.norm(np.cross(z, axis)) < _SQUARE:
        return np.asarray(z * np.sign(along))
    if abs(along) < _SQUARE:
        axis = axis - along * z
    return np.asarray(axis / np.linalg.norm(axis))


def _frame(origin: Array, x: Array, z: Array) -> Array:
    T = np.eye(4)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, np.cross(z, x), z, origin
    return T


def _across(z: Array) -> Array:
    """A direction square to z: along x of the base, unless z is."""
    return np.asarray(np.eye(3)[0 if abs(z[0]) < 0.9 else 1])


def _angle(one: Array, other: Array, about: Array) -> float:
    """rad from one to the other about an axis that both are square to."""
    return float(np.arctan2(np.cross(one, other) @ about, one @ other))
