"""From what a laser tracker reports to the error that the loop corrects (paper 001, eq. 1 to 3).

Eq. 1 holds as printed: the position is that of spherical coordinates with alpha counted from the tracker's own vertical axis, the
rotation is that of a unit quaternion with the real part first.

Eq. 2 is printed as T(TCP in base) = T(TCP in tracker) T(tracker in base). With the poses of eq. 1, whose translation is the
last column, the order has to be the other one: base_T_tcp = base_T_tracker tracker_T_tcp. `printed_order` gives what is printed.

Eq. 3's angles are XYZ extrinsic: R = Rz(A) Ry(B) Rx(C), yaw, pitch and roll; their differences are taken within half a turn.
"""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError, SingularError
from camrob.se3 import xyzabc_from_frame
from camrob.units import rad_to_deg

__all__ = [
    "TrackerReading",
    "base_pose",
    "components",
    "printed_order",
    "quaternion_rotation",
    "reading_of",
    "setpoint_error",
    "tracker_pose",
]

Array = NDArray[np.float64]
Value = TypeVar("Value", float, NDArray[np.float64])

_UNIT = 1e-3  # how far a quaternion's length may be from 1
_STEEP = 0.02  # cosine of pitch below which yaw and roll can't be told apart well


class TrackerReading(NamedTuple):
    """Raw measurements of one or more instants: `distance` r, m; `horizontal` theta and `vertical` alpha, rad, all (...,);
    `quaternion` (..., 4), real part first, the target's orientation seen from the tracker.
    """

    distance: Array
    horizontal: Array
    vertical: Array
    quaternion: Array


def tracker_pose(reading: TrackerReading) -> Array:
    """tracker_T_tcp (..., 4, 4) by eq. 1.

    Raises InputError for a reading that isn't finite, a distance that isn't above 0, or a quaternion that isn't of length 1.
    """
    r, theta, alpha, q = (np.asarray(part, float) for part in reading)
    if not (np.isfinite(r).all() and np.isfinite(theta).all() and np.isfinite(alpha).all() and np.isfinite(q).all()):
        raise InputError("the tracker's measurement is not a number", hint="check the beam and the target")
    if not (r > 0.0).all():
        raise InputError("the tracker's distance is not above 0", hint="check the beam and the target")
    length = np.linalg.norm(q, axis=-1)
    if (np.abs(length - 1.0) > _UNIT).any():
        raise InputError(
            f"the tracker's quaternion has length {float(np.ravel(length)[0]):.4f}, not 1",
            hint="give q_r, q_i, q_j, q_k of a rotation",
        )
    qr, qi, qj, qk = np.moveaxis(q / length[..., None], -1, 0)
    T = np.zeros((*r.shape, 4, 4))
    for i, row in enumerate(quaternion_rotation(qr, qi, qj, qk)):
        T[..., i, 0], T[..., i, 1], T[..., i, 2] = row
    level = r * np.sin(alpha)
    T[..., 0, 3], T[..., 1, 3], T[..., 2, 3] = level * np.cos(theta), level * np.sin(theta), r * np.cos(alpha)
    T[..., 3, 3] = 1.0
    return T


def quaternion_rotation(qr: Value, qi: Value, qj: Value, qk: Value) -> tuple[tuple[Value, Value, Value], ...]:
    """The rows of eq. 1's rotation, of a unit quaternion with the real part first: numbers, or arrays of many."""
    return (
        (1 - 2 * (qj * qj + qk * qk), 2 * (qi * qj - qk * qr), 2 * (qi * qk + qj * qr)),
        (2 * (qi * qj + qk * qr), 1 - 2 * (qi * qi + qk * qk), 2 * (qj * qk - qi * qr)),
        (2 * (qi * qk - qj * qr), 2 * (qi * qr + qj * qk), 1 - 2 * (qi * qi + qj * qj)),
    )


def reading_of(tracker_T_tcp: Array) -> TrackerReading:
    """The noise-free reading of poses (..., 4, 4), `tracker_pose`'s inverse. The quaternion's real part is not negative."""
    p, R = tracker_T_tcp[..., :3, 3], tracker_T_tcp[..., :3, :3]
    r = np.linalg.norm(p, axis=-1)
    diagonal = np.stack([R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]], axis=-1)
    trace = diagonal.sum(axis=-1)
    squares = np.concatenate([trace[..., None], 2.0 * diagonal - trace[..., None]], axis=-1) + 1.0  # 4 q^2 each
    skew = (R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1])
    xy, xz, yz = R[..., 0, 1] + R[..., 1, 0], R[..., 0, 2] + R[..., 2, 0], R[..., 1, 2] + R[..., 2, 1]
    products = np.empty((*r.shape, 4, 4))  # row k: 4 q_k q
    for k in range(4):
        products[..., k, k] = squares[..., k]
    for k in range(3):
        products[..., 0, k + 1] = products[..., k + 1, 0] = skew[k]
    for a, b, both in ((1, 2, xy), (1, 3, xz), (2, 3, yz)):
        products[..., a, b] = products[..., b, a] = both
    largest = np.argmax(squares, axis=-1)[..., None, None]
    q = np.take_along_axis(products, np.broadcast_to(largest, (*r.shape, 1, 4)), axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    q = np.where(q[..., :1] < 0.0, -q, q)
    vertical = np.arctan2(np.hypot(p[..., 0], p[..., 1]), p[..., 2])
    return TrackerReading(r, np.arctan2(p[..., 1], p[..., 0]), vertical, q)


def base_pose(base_T_tracker: Array, tracker_T_tcp: Array) -> Array:
    """base_T_tcp (..., 4, 4): eq. 2 in the order in which the frames cancel."""
    return np.asarray(base_T_tracker @ tracker_T_tcp)


def printed_order(base_T_tracker: Array, tracker_T_tcp: Array) -> Array:
    """Eq. 2's product as printed, T(TCP in tracker) T(tracker in base): no pose of the tool unless the frames commute."""
    first, second = tracker_T_tcp, base_T_tracker
    return np.asarray(first @ second)


def components(base_T_tcp: Array) -> Array:
    """(x, y, z, A, B, C) (..., 6), m and rad, of poses: the vector p of eq. 3.

    Raises SingularError where the pitch B is so near to a quarter turn that A and C can't be told apart.
    """
    p = xyzabc_from_frame(base_T_tcp)
    steep = np.abs(np.cos(p[..., 4])) < _STEEP
    if steep.any():
        raise SingularError(
            "the tool's pitch B is a quarter turn: yaw and roll can't be corrected apart; choose another tool frame",
            axis="B",
            value=float(rad_to_deg(np.ravel(p[..., 4])[int(np.argmax(np.ravel(steep)))])),
            unit="deg",
        )
    return p


def setpoint_error(wanted: Array, measured: Array) -> Array:
    """e = p* - p of eq. 3, (..., 6), the angles within half a turn. Raises InputError for anything that is no number."""
    e = np.asarray(wanted, float) - np.asarray(measured, float)
    if not np.isfinite(e).all():
        raise InputError("an error of the tracker loop is not a number", hint="check the measurement and the set-point")
    e[..., 3:] -= 2.0 * np.pi * np.round(e[..., 3:] / (2.0 * np.pi))
    return np.asarray(e)
