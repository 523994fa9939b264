"""Arms by their rows, and what becomes of their tip when constants are off: numpy alone, SI. Nothing of camrob's diagnosis."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

# alpha degrees, a mm, theta degrees, d mm: of the size of an R-2000, a KR 16 and a UR10
ARMS = {
    "large": (
        [(-90, 312, 0, 670), (0, 1075, -90, 0), (-90, 225, 0, 0), (90, 0, 0, 1280), (-90, 0, 0, 0), (0, 0, 0, 215)],
        190.0,
    ),
    "middle": (
        [(-90, 260, 0, 675), (0, 680, -90, 0), (-90, 35, 0, 0), (90, 0, 0, 670), (-90, 0, 0, 0), (0, 0, 0, 158)],
        60.0,
    ),
    "light": (
        [(90, 0, 0, 127), (0, -612, 0, 0), (0, -572, 0, 0), (90, 0, 0, 164), (-90, 0, 0, 116), (0, 0, 0, 92)],
        12.0,
    ),
}
HOME = {"large": (0, 0, 10, 0, -50, 0), "middle": (0, 0, 10, 0, -50, 0), "light": (0, -70, 100, -60, 70, 0)}
TOOL = (40.0, 60.0, 250.0, 0.0, 20.0, 0.0)


def placed(x, y, z, a=0.0, b=0.0, c=0.0):
    """(4, 4) of mm and Rz(a) Ry(b) Rx(c), degrees."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    T[:3, 3] = np.array([x, y, z]) / 1000
    return T


def moved(twist):
    """(4, 4) of a shift (m) and a rotation vector (rad)."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(twist[3:]).as_matrix()
    T[:3, 3] = twist[:3]
    return T


@dataclass
class Faults:
    """What is off: zeros and play (6,) rad, give (6,) rad/Nm, links (6,) m, left and right (6,) of foot and tool, lag (6,) s."""

    zero: np.ndarray = field(default_factory=lambda: np.zeros(6))
    play: np.ndarray = field(default_factory=lambda: np.zeros(6))
    give: np.ndarray = field(default_factory=lambda: np.zeros(6))
    links: np.ndarray = field(default_factory=lambda: np.zeros(6))
    left: np.ndarray = field(default_factory=lambda: np.zeros(6))
    right: np.ndarray = field(default_factory=lambda: np.zeros(6))
    lag: np.ndarray = field(default_factory=lambda: np.zeros(6))

    def plus(self, other):
        return Faults(**{k: getattr(self, k) + getattr(other, k) for k in self.__dataclass_fields__})


def tip(arm, q, links=None):
    """(N, 4, 4) tips, and (N, 6, 4, 4) the frames about whose z the axes turn."""
    T, at = np.tile(np.eye(4), (len(q), 1, 1)), []
    for i, (alpha, a, theta, d) in enumerate(ARMS[arm][0]):
        at.append(T)
        turn = np.tile(np.eye(4), (len(q), 1, 1))
        turn[:, :3, :3] = Rotation.from_rotvec(np.outer(np.radians(theta) + q[:, i], [0, 0, 1])).as_matrix()
        more = 0.0 if links is None else links[i]
        row = placed(0, 0, d) @ placed(a, 0, 0) @ placed(0, 0, 0, 0, 0, alpha)
        row[:3, 3] += np.array([more, 0, 0])
        T = T @ turn @ row
    return T @ placed(*TOOL), np.stack(at, axis=1)


def weights(arm, q):
    """(N, 6) Nm of gravity on the axes: a third of the mass at the elbow, a third at the wrist, a third at the tip."""
    end, at = tip(arm, q)
    points = [at[:, 2, :3, 3], at[:, 4, :3, 3], end[:, :3, 3]]
    out = np.zeros((len(q), 6))
    for first, p in zip((2, 4, 6), points, strict=True):
        for i in range(first):
            lever = np.cross(at[:, i, :3, 2], p - at[:, i, :3, 3])
            out[:, i] += lever[:, 2] * -9.81 * ARMS[arm][1] / 3
    return out


def sides(q, poses):
    """(N, 6) -1 to 1: from where each axis came last."""
    step = np.sign(np.round(np.diff(q, axis=0, prepend=q[:1]), 9))
    out, last = np.zeros_like(q), np.zeros(q.shape[1])
    for k, row in enumerate(step):
        last = np.where(row != 0, row, last)
        out[k] = last
    return out


def followed(q, t, lag):
    """(N, 6) where drives of first order stand that follow q at t."""
    out, dt = q.copy(), t[1] - t[0]
    for i in range(6):
        if lag[i] > 0:
            w = 1 - np.exp(-dt / lag[i])
            for k in range(1, len(q)):
                out[k, i] = out[k - 1, i] + w * (0.5 * (q[k, i] + q[k - 1, i]) - out[k - 1, i])
    return out


def real(arm, q, faults, poses):
    """(N, 4, 4) where the tip really is, with encoders at q."""
    angles = q + faults.zero - 0.5 * faults.play * sides(q, poses) + faults.give * weights(arm, q)
    return moved(faults.left) @ tip(arm, angles, faults.links)[0] @ moved(faults.right)


def cell_text(arm, name):
    """cell.toml of an arm."""
    rows = ",\n  ".join(str(list(r)) for r in ARMS[arm][0])
    third = ARMS[arm][1] / 3
    masses = "".join(
        f'\n[[mass]]\nname = "third_{after}"\nafter = "{after}"\nmass_kg = {third}\ncenter_mm = {center}\n'
        for after, center in (("A2", [0, 0, 0]), ("A4", [0, 0, 0]), ("A6", list(TOOL[:3])))
    )
    return (
        f'schema = 1\nname = "{name}"\nstanding = "measured"\n\n[kinematics]\nbase_follows_table = false\n'
        "characteristic_length_mm = 400\nbase_to_first = [0, 0, 0, 0, 0, 0]\nfoot_to_root = [0, 0, 0, 0, 0, 0]\n"
        f'wrist_to_flange = [0, 0, 0, 0, 0, 0]\n\n[arm]\nconvention = "standard"\ndh = [\n  {rows},\n]\n\n'
        f"[tool]\nflange_to_tool = {list(TOOL)}\n\n[load]\npayload_kg = {third:.3f}\n{masses}"
    )
