"""Rigid motions as 4x4 matrices, vectorised over leading dimensions.

`a_T_b` is the pose of frame b in frame a; a twist is (v, w): linear first, then angular. A, B, C are KUKA's angles,
R = Rz(A) Ry(B) Rx(C), in radians but for `frame_from_mm_deg` and `mm_deg_from_frame`, which files are read and written by.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = [
    "abc_to_rotation",
    "angle_between",
    "exp",
    "frame_from_mm_deg",
    "frame_from_xyzabc",
    "inverse",
    "left_jacobian",
    "log",
    "mm_deg_from_frame",
    "pose",
    "quaternion_to_rotation",
    "rotation_exp",
    "rotation_log",
    "rotation_to_abc",
    "skew",
    "slerp",
    "xyzabc_from_frame",
]

Array = NDArray[np.float64]


def pose(R: ArrayLike, p: ArrayLike) -> Array:
    """Homogeneous matrices (..., 4, 4) from rotations (..., 3, 3) and positions (..., 3)."""
    R_, p_ = np.asarray(R, float), np.asarray(p, float)
    lead = np.broadcast_shapes(R_.shape[:-2], p_.shape[:-1])
    T = np.zeros((*lead, 4, 4))
    T[..., :3, :3] = R_
    T[..., :3, 3] = p_
    T[..., 3, 3] = 1.0
    return T


def inverse(T: Array) -> Array:
    """Inverse of rigid motions (..., 4, 4): b_T_a from a_T_b."""
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    return pose(Rt, -(Rt @ T[..., :3, 3:])[..., 0])


def skew(w: ArrayLike) -> Array:
    """Cross-product matrices (..., 3, 3) of vectors (..., 3)."""
    w_ = np.asarray(w, float)
    S = np.zeros((*w_.shape, 3))
    S[..., 0, 1], S[..., 0, 2], S[..., 1, 2] = -w_[..., 2], w_[..., 1], -w_[..., 0]
    S[..., 1, 0], S[..., 2, 0], S[..., 2, 1] = w_[..., 2], -w_[..., 1], w_[..., 0]
    return S


def rotation_exp(w: ArrayLike) -> Array:
    """Rotations (..., 3, 3) from rotation vectors (..., 3), rad (Rodrigues' formula)."""
    w_ = np.asarray(w, float)
    angle2 = np.sum(w_ * w_, axis=-1)[..., None, None]
    angle = np.sqrt(angle2)
    small = angle2 < 1e-8
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle2 / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    S = skew(w_)
    return np.asarray(np.eye(3) + a * S + b * (S @ S))


def rotation_log(R: ArrayLike) -> Array:
    """Rotation vectors (..., 3), rad, of rotations (..., 3, 3); exact up to and at a half turn."""
    R_ = np.asarray(R, float)
    v = 0.5 * np.stack(
        [R_[..., 2, 1] - R_[..., 1, 2], R_[..., 0, 2] - R_[..., 2, 0], R_[..., 1, 0] - R_[..., 0, 1]], axis=-1
    )
    s = np.linalg.norm(v, axis=-1)
    c = 0.5 * (np.trace(R_, axis1=-2, axis2=-1) - 1.0)
    angle = np.arctan2(s, c)
    scale = np.where(s > 1e-7, angle / np.where(s > 1e-7, s, 1.0), 1.0 + s * s / 6.0)
    out = np.asarray(v * scale[..., None])
    near = c < -0.99  # close to a half turn: the axis comes from the symmetric part
    if np.any(near):
        sym = 0.5 * (R_ + np.swapaxes(R_, -1, -2))
        sym_near = sym[near] if near.ndim else sym[None]
        v_near = v[near] if near.ndim else v[None]
        angle_near = angle[near] if near.ndim else angle[None]
        cos_near = np.cos(angle_near)
        outer = (sym_near - cos_near[..., None, None] * np.eye(3)) / (1.0 - cos_near)[..., None, None]
        pick = np.argmax(np.einsum("...ii->...i", outer), axis=-1)
        axis = np.take_along_axis(outer, pick[..., None, None], axis=-1)[..., 0]
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
        flip = np.where(np.sum(axis * v_near, axis=-1) < 0.0, -1.0, 1.0)
        half = axis * (flip * angle_near)[..., None]
        if near.ndim:
            out[near] = half
        else:
            out = half[0]
    return out


def left_jacobian(w: Array) -> Array:
    """The left Jacobian (..., 3, 3) of `rotation_exp` at rotation vectors w (..., 3)."""
    angle2 = np.sum(w * w, axis=-1)[..., None, None]
    small = angle2 < 1e-8
    angle = np.sqrt(np.where(small, 1.0, angle2))
    b = np.where(small, 0.5 - angle2 / 24.0, (1.0 - np.cos(angle)) / angle**2)
    c = np.where(small, 1.0 / 6.0 - angle2 / 120.0, (angle - np.sin(angle)) / angle**3)
    S = skew(w)
    return np.asarray(np.eye(3) + b * S + c * (S @ S))


def exp(xi: ArrayLike) -> Array:
    """Rigid motions (..., 4, 4) from twists (..., 6) = (v, w)."""
    xi_ = np.asarray(xi, float)
    v, w = xi_[..., :3], xi_[..., 3:]
    return pose(rotation_exp(w), (left_jacobian(w) @ v[..., None])[..., 0])


def log(T: Array) -> Array:
    """Twists (..., 6) = (v, w) of rigid motions (..., 4, 4)."""
    w = rotation_log(T[..., :3, :3])
    angle2 = np.sum(w * w, axis=-1)[..., None, None]
    small = angle2 < 1e-8
    angle = np.sqrt(np.where(small, 1.0, angle2))
    # the inverse of V in exp(): I - S/2 + d S^2
    d = np.where(small, 1.0 / 12.0 + angle2 / 720.0, (1.0 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2)
    S = skew(w)
    V_inverse = np.eye(3) - 0.5 * S + d * (S @ S)
    v = (V_inverse @ T[..., :3, 3:])[..., 0]
    return np.concatenate([v, w], axis=-1)


def slerp(R0: Array, R1: Array, s: ArrayLike) -> Array:
    """Rotations along the great arc from R0 (s = 0) to R1 (s = 1); `s` broadcasts over leading dimensions."""
    w = rotation_log(np.swapaxes(R0, -1, -2) @ R1)
    s_ = np.asarray(s, float)
    return R0 @ rotation_exp(w * s_[..., None])


def angle_between(R0: Array, R1: Array) -> Array:
    """Angle, rad, of the rotation from R0 to R1 (..., 3, 3)."""
    return np.asarray(np.linalg.norm(rotation_log(np.swapaxes(R0, -1, -2) @ R1), axis=-1))


def abc_to_rotation(abc: ArrayLike) -> Array:
    """Rotations (..., 3, 3) = Rz(A) Ry(B) Rx(C) from angles (..., 3), rad."""
    abc_ = np.asarray(abc, float)
    (ca, cb, cc), (sa, sb, sc) = np.moveaxis(np.cos(abc_), -1, 0), np.moveaxis(np.sin(abc_), -1, 0)
    R = np.empty((*abc_.shape[:-1], 3, 3))
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = -sb, cb * sc, cb * cc
    return R


def rotation_to_abc(R: ArrayLike) -> Array:
    """Angles (..., 3), rad: A and C in (-pi, pi], B in [-pi/2, pi/2]; at B = +-pi/2, C is 0."""
    R_ = np.asarray(R, float)
    cb = np.hypot(R_[..., 0, 0], R_[..., 1, 0])
    locked_ = cb < 1e-9
    a = np.where(locked_, np.arctan2(-R_[..., 0, 1], R_[..., 1, 1]), np.arctan2(R_[..., 1, 0], R_[..., 0, 0]))
    c = np.where(locked_, 0.0, np.arctan2(R_[..., 2, 1], R_[..., 2, 2]))
    return np.stack([a, np.arctan2(-R_[..., 2, 0], cb), c], axis=-1)


def quaternion_to_rotation(q: ArrayLike) -> Array:
    """Rotations (..., 3, 3) of quaternions (..., 4), scalar part first, of any length but 0."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    size = np.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / size, x / size, y / size, z / size
    R = np.empty((*np.shape(w), 3, 3))
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = 2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z
    return R


def frame_from_xyzabc(xyzabc: ArrayLike) -> Array:
    """Pose (..., 4, 4) from (X, Y, Z, A, B, C) in metres and radians (..., 6)."""
    values = np.asarray(xyzabc, float)
    return pose(abc_to_rotation(values[..., 3:]), values[..., :3])


def xyzabc_from_frame(T: Array) -> Array:
    """(X, Y, Z, A, B, C) in metres and radians (..., 6) of poses (..., 4, 4)."""
    return np.concatenate([T[..., :3, 3], rotation_to_abc(T[..., :3, :3])], axis=-1)


def frame_from_mm_deg(xyzabc_mm_deg: ArrayLike) -> Array:
    """Pose (..., 4, 4) from (X, Y, Z, A, B, C) in mm and degrees (..., 6), as files have it."""
    values = np.asarray(xyzabc_mm_deg, float)
    return frame_from_xyzabc(np.concatenate([mm_to_m(values[..., :3]), deg_to_rad(values[..., 3:])], axis=-1))


def mm_deg_from_frame(T: Array) -> Array:
    """(X, Y, Z, A, B, C) in mm and degrees (..., 6) of poses (..., 4, 4)."""
    values = xyzabc_from_frame(T)
    return np.concatenate([m_to_mm(values[..., :3]), rad_to_deg(values[..., 3:])], axis=-1)
