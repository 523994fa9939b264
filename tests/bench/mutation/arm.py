"""The KR15 cell once more, from its published table: forward kinematics, the eight postures, limits. Nothing of camrob.

Millimetres and degrees throughout. `world` is the table's frame at E2 = 0, `base` turns with the table.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMES = ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
LOWER = np.array([-185.0, -145.0, -120.0, -350.0, -135.0, -350.0, -1500.0, -np.inf])
UPPER = np.array([185.0, 25.0, 160.0, 350.0, 135.0, 350.0, 1500.0, np.inf])
SPEED = np.array([152.0, 152.0, 152.0, 284.0, 293.0, 604.0, 1000.0, 60.0])  # degrees/s, mm/s
HOME = np.array([0.0, -90.0, 90.0, 0.0, 90.0, 0.0, 0.0, 0.0])
TOOL = (0.0, -41.763657, 415.577926, 0.0, 0.0, -159.579784)
UPPER_ARM, FOREARM, FOREARM_RISE, PLATE = 650.0, 600.0, 155.0, 140.0
STRETCHED = float(np.degrees(np.arctan2(FOREARM_RISE, FOREARM)))


def rx(deg: Array | float) -> Array:
    """Rotation (..., 4, 4) about x."""
    return _turn(deg, 1, 2)


def ry(deg: Array | float) -> Array:
    """Rotation (..., 4, 4) about y."""
    return _turn(deg, 2, 0)


def rz(deg: Array | float) -> Array:
    """Rotation (..., 4, 4) about z."""
    return _turn(deg, 0, 1)


def _turn(deg: Array | float, i: int, j: int) -> Array:
    angle = np.radians(np.asarray(deg, float))
    out = np.broadcast_to(np.eye(4), (*angle.shape, 4, 4)).copy()
    out[..., i, i] = out[..., j, j] = np.cos(angle)
    out[..., j, i] = np.sin(angle)
    out[..., i, j] = -out[..., j, i]
    return out


def shift(x: Array | float, y: Array | float, z: Array | float) -> Array:
    """Translation (..., 4, 4)."""
    x, y, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float), np.asarray(z, float))
    out = np.broadcast_to(np.eye(4), (*x.shape, 4, 4)).copy()
    out[..., :3, 3] = np.stack([x, y, z], axis=-1)
    return out


def frame(xyzabc: Array | tuple[float, ...]) -> Array:
    """Pose (..., 4, 4) of KUKA's X, Y, Z, A, B, C: R = Rz(A) Ry(B) Rx(C)."""
    v = np.asarray(xyzabc, float)
    return shift(v[..., 0], v[..., 1], v[..., 2]) @ rz(v[..., 3]) @ ry(v[..., 4]) @ rx(v[..., 5])


def inverse(pose: Array) -> Array:
    """Inverse (..., 4, 4) of a pose."""
    out = np.broadcast_to(np.eye(4), pose.shape).copy()
    turned = np.swapaxes(pose[..., :3, :3], -1, -2)
    out[..., :3, :3] = turned
    out[..., :3, 3] = -(turned @ pose[..., :3, 3, None])[..., 0]
    return out


def row(alpha: float, a: float, theta: Array | float, d: Array | float) -> Array:
    """A standard Denavit-Hartenberg row: Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    return rz(theta) @ shift(0.0, 0.0, d) @ shift(a, 0.0, 0.0) @ rx(alpha)


def base_T_root(e1: Array | float, e2: Array | float) -> Array:
    """The robot's foot in `base` (in `world` where e2 is 0)."""
    return row(90.0, 803.0, np.asarray(e2, float) + 180.0, -305.0) @ row(90.0, 0.0, 0.0, e1) @ ry(180.0)


def links(axes: Array) -> list[Array]:
    """Frames (N, 4, 4) in `base` behind E2, E1, A1 .. A6 (the row's own end), of axes (N, 8) as NAMES has them."""
    a = np.asarray(axes, float)
    rows = (
        row(90.0, 803.0, a[:, 7] + 180.0, -305.0),
        row(90.0, 0.0, 0.0, a[:, 6]),
        row(90.0, 300.0, a[:, 0] + 180.0, -675.0),
        row(0.0, UPPER_ARM, a[:, 1], 0.0),
        row(90.0, FOREARM_RISE, a[:, 2] - 90.0, 0.0),
        row(90.0, 0.0, a[:, 3], -FOREARM),
        row(90.0, 0.0, 180.0 - a[:, 4], 0.0),
        row(0.0, 0.0, a[:, 5], -PLATE),
    )
    out = [rows[0]]
    for one in rows[1:]:
        out.append(out[-1] @ one)
    return out


def base_T_flange(axes: Array) -> Array:
    """The mounting plate (N, 4, 4) in `base`."""
    return links(axes)[-1] @ rx(180.0)


def postures(root_T_flange: Array, status: int) -> Array:
    """A1 .. A6 (N, 6) of flange poses (N, 4, 4) in the arm that S names; NaN where it does not reach. A4, A6 in -180..180."""
    wrist = root_T_flange[:, :3, 3] - PLATE * root_T_flange[:, :3, 2]
    front = 0.0 if status & 1 else 1.0
    a1 = -np.degrees(np.arctan2(wrist[:, 1], wrist[:, 0])) + (0.0 if front else 180.0)
    a1 = _half_turn(a1)
    reach = np.hypot(wrist[:, 0], wrist[:, 1]) * (1.0 if front else -1.0) - 300.0
    height = wrist[:, 2] - 675.0
    fore = np.hypot(FOREARM, FOREARM_RISE)
    cosine = (reach**2 + height**2 - UPPER_ARM**2 - fore**2) / (2.0 * UPPER_ARM * fore)
    with np.errstate(invalid="ignore"):
        bend = np.arccos(cosine) * (1.0 if status & 2 else -1.0)
    a2 = np.degrees(np.arctan2(-height, reach) - np.arctan2(fore * np.sin(bend), UPPER_ARM + fore * np.cos(bend)))
    a2 = _half_turn(a2 + 60.0) - 60.0
    a3 = np.degrees(bend) + STRETCHED
    before = np.zeros((len(wrist), 8))
    before[:, :3] = np.stack([a1, a2, a3], axis=1)
    wrist_frame = links(before)[4]
    root = base_T_root(np.zeros(len(wrist)), np.zeros(len(wrist)))
    turn = np.swapaxes(wrist_frame[:, :3, :3], 1, 2) @ (root @ root_T_flange @ rx(180.0))[:, :3, :3]
    side = -1.0 if status & 4 else 1.0
    t5 = np.degrees(np.arccos(np.clip(-turn[:, 2, 2], -1.0, 1.0))) * side
    t4 = np.degrees(np.arctan2(side * turn[:, 1, 2], side * turn[:, 0, 2]))
    t6 = np.degrees(np.arctan2(-side * turn[:, 2, 1], side * turn[:, 2, 0]))
    return np.stack([a1, a2, a3, t4, _half_turn(180.0 - t5), t6], axis=1)


def _half_turn(deg: Array) -> Array:
    """Into -180 .. 180."""
    return np.asarray(deg - 360.0 * np.round(deg / 360.0))


def status_of(axes: Array) -> int:
    """S of one posture A1 .. A6: overhead, elbow, wrist."""
    a = np.asarray(axes, float)
    fore = a[1] + a[2]
    x = 300.0 + UPPER_ARM * np.cos(np.radians(a[1])) + FOREARM * np.cos(np.radians(fore))
    x += FOREARM_RISE * np.sin(np.radians(fore))
    return int(x < 0.0) | int(a[2] > STRETCHED) << 1 | int(a[4] < 0.0) << 2


def on_turn(axes: Array, turn: int) -> Array | None:
    """A1 .. A6 on the turns that T names (bit k: axis k + 1 is negative), None where one has no such turn in its range."""
    out = np.array(axes, float)
    for k in range(6):
        candidates = out[k] + np.array([0.0, -360.0, 360.0])
        fit = [
            c for c in candidates if LOWER[k] <= c <= UPPER[k] and (abs(c) < 1e-3 or (c < 0.0) == bool(turn >> k & 1))
        ]
        if not fit:
            return None
        out[k] = min(fit, key=abs)
    return out
