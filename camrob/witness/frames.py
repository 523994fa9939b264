"""Frames and rotations, written out for the witness alone.

Frames are (..., 4, 4), rotations (..., 3, 3), lengths in metres. KUKA's X, Y, Z, A, B, C are mm and degrees, with
R = Rz(A) Ry(B) Rx(C).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.witness.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = [
    "angle_of",
    "euler",
    "frame",
    "inverse",
    "joined",
    "rotation",
    "rotation_vector",
    "rotations_about",
    "to_values",
]

Array = NDArray[np.float64]


def euler(abc_deg: Array) -> Array:
    """Rz(A) Ry(B) Rx(C) of A, B, C in degrees: (..., 3) to (..., 3, 3)."""
    sines, cosines = np.sin(deg_to_rad(abc_deg)), np.cos(deg_to_rad(abc_deg))
    sa, sb, sc = sines[..., 0], sines[..., 1], sines[..., 2]
    ca, cb, cc = cosines[..., 0], cosines[..., 1], cosines[..., 2]
    out = np.empty((*abc_deg.shape[:-1], 3, 3))
    out[..., 0, 0], out[..., 0, 1], out[..., 0, 2] = ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc
    out[..., 1, 0], out[..., 1, 1], out[..., 1, 2] = sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc
    out[..., 2, 0], out[..., 2, 1], out[..., 2, 2] = -sb, cb * sc, cb * cc
    return out


def joined(turn: Array, place: Array) -> Array:
    """Frames (..., 4, 4) of rotations (..., 3, 3) and places (..., 3) in metres."""
    lead = np.broadcast_shapes(turn.shape[:-2], place.shape[:-1])
    out = np.zeros((*lead, 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = turn, place, 1.0
    return out


def frame(values: Array) -> Array:
    """Frames (..., 4, 4) of X, Y, Z, A, B, C (..., 6) in mm and degrees."""
    return joined(euler(values[..., 3:]), mm_to_m(values[..., :3]))


def to_values(pose: Array) -> Array:
    """X, Y, Z, A, B, C (6,) in mm and degrees of one frame (4, 4); at B = +-90 degrees C is 0."""
    turn = pose[:3, :3]
    b = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if np.hypot(turn[0, 0], turn[1, 0]) > 1e-9:
        a, c = np.arctan2(turn[1, 0], turn[0, 0]), np.arctan2(turn[2, 1], turn[2, 2])
    else:
        a, c = np.arctan2(-turn[0, 1], turn[1, 1]), np.float64(0.0)
    return np.concatenate([m_to_mm(pose[:3, 3]), rad_to_deg(np.array([a, b, c]))])


def inverse(pose: Array) -> Array:
    """The inverse of frames (..., 4, 4)."""
    turn = np.swapaxes(pose[..., :3, :3], -1, -2)
    return joined(turn, -(turn @ pose[..., :3, 3, None])[..., 0])


def rotation(axis: int, angle: Array) -> Array:
    """Rotations (M, 3, 3) by `angle` (M,) rad about x (0), y (1) or z (2)."""
    out = np.zeros((len(angle), 3, 3))
    out[:, axis, axis] = 1.0
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[:, i, i] = out[:, j, j] = np.cos(angle)
    out[:, j, i] = np.sin(angle)
    out[:, i, j] = -out[:, j, i]
    return out


def rotations_about(vector: Array) -> Array:
    """Rotations (M, 3, 3) by |vector| rad about vector (M, 3): Rodrigues' formula."""
    angle = np.linalg.norm(vector, axis=-1)
    x, y, z = (vector / np.where(angle > 0.0, angle, 1.0)[:, None]).T
    s, c = np.sin(angle), np.cos(angle)
    v = 1.0 - c
    rows = [x * x * v + c, x * y * v - z * s, x * z * v + y * s]
    rows += [x * y * v + z * s, y * y * v + c, y * z * v - x * s]
    rows += [x * z * v - y * s, y * z * v + x * s, z * z * v + c]
    return np.stack(rows, axis=-1).reshape(-1, 3, 3)


def angle_of(turn: Array) -> Array:
    """Angles (M,) rad, 0 to pi, of rotations (M, 3, 3)."""
    twice = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]])
    return np.asarray(np.arctan2(np.linalg.norm(twice, axis=0), np.trace(turn, axis1=1, axis2=2) - 1.0))


def rotation_vector(turn: Array) -> Array:
    """Axis times angle (M, 3) of rotations (M, 3, 3); of half a turn one of the two axes."""
    angle = angle_of(turn)
    twice = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], -1)
    size = np.linalg.norm(twice, axis=-1)
    plain = twice * (angle / np.where(size > 0.0, size, 1.0))[:, None]
    # near half a turn the skew part fades: the symmetric part less cos(angle) is (1 - cos(angle)) a a'
    square = 0.5 * (turn + np.swapaxes(turn, 1, 2)) - np.cos(angle)[:, None, None] * np.eye(3)
    longest = np.argmax(np.linalg.norm(square, axis=1), axis=1)
    column = np.take_along_axis(square, longest[:, None, None], axis=2)[:, :, 0]
    column = column * (angle / np.maximum(np.linalg.norm(column, axis=-1), 1e-300))[:, None]
    column = np.where(np.sum(column * twice, axis=-1, keepdims=True) < 0.0, -column, column)
    return np.where((angle > 3.0)[:, None], column, plain)
