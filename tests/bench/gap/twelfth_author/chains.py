"""Chains with a small motion let in behind every joint, weights, and an inverse for whole paths at once. SI."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

GRAVITY = 9.80665


def frame(x=0.0, y=0.0, z=0.0, a=0.0, b=0.0, c=0.0):
    """(4, 4) of mm and KUKA's A, B, C in degrees, in m."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    T[:3, 3] = np.array([x, y, z]) / 1000
    return T


def motion(twist):
    """(..., 4, 4) of small motions (..., 6): translation, then rotation vector."""
    twist = np.asarray(twist, float)
    flat = twist.reshape(-1, 6)
    T = np.tile(np.eye(4), (len(flat), 1, 1))
    T[:, :3, :3] = Rotation.from_rotvec(flat[:, 3:]).as_matrix()
    T[:, :3, 3] = flat[:, :3]
    return T.reshape(*twist.shape[:-1], 4, 4)


@dataclass(frozen=True)
class Joint:
    """pre . joint(value) . small motion . post; value = sign * q + offset, rad or m."""

    name: str
    dh: tuple  # alpha_deg, a_mm, theta_deg, d_mm
    kind: str = "R"
    role: str = "arm"
    sign: int = 1
    offset: float = 0.0  # degrees or mm
    low: float = -120.0
    high: float = 120.0
    speed: float = 90.0  # degrees/s or mm/s, as it is run here


@dataclass(frozen=True)
class Chain:
    name: str
    joints: tuple
    convention: str = "standard"
    base: tuple = (0, 0, 0, 0, 0, 0)  # base_to_first
    tool: tuple = (0, 0, 0, 0, 0, 0)  # flange_to_tool
    masses: tuple = ()  # (joint's name, kg, (x, y, z) mm in the frame in which its row ends)
    payload: float = 0.0  # kg at the tool's half way
    home: tuple = ()
    above: float | None = None  # least height of the tool in m, for drawn postures
    extra: dict = field(default_factory=dict)

    @property
    def names(self):
        return [j.name for j in self.joints]

    @property
    def sliding(self):
        return np.array([j.kind == "P" for j in self.joints])

    @property
    def unit(self):
        """SI of a degree or a mm, by axis."""
        return np.where(self.sliding, 1e-3, np.pi / 180)

    def index(self, name):
        return self.names.index(name)

    @property
    def first_arm(self):
        return next(i for i, j in enumerate(self.joints) if j.role == "arm")

    def loaded(self, kg):
        return replace(self, payload=kg)


def frames(chain, values, twists=None, shift=None):
    """Frames (N, 4, 4) behind every joint's row, the tool's last, of axis values (N, n); `shift` is added behind encoders."""
    twists = twists or {}
    real = values if shift is None else values + shift
    T = np.tile(frame(*chain.base), (len(real), 1, 1))
    out = []
    for i, joint in enumerate(chain.joints):
        if i == chain.first_arm and "root" in twists:
            T = T @ motion(twists["root"])
        alpha, a, theta, d = joint.dh
        fixed = frame(a, 0, 0, 0, 0, 0) @ frame(c=alpha)
        q = joint.sign * (real[:, i] - joint.offset * chain.unit[i])
        J = np.tile(np.eye(4), (len(real), 1, 1))
        turn = np.radians(theta) + (q if joint.kind == "R" else 0)
        J[:, 0, 0], J[:, 0, 1], J[:, 1, 0], J[:, 1, 1] = np.cos(turn), -np.sin(turn), np.sin(turn), np.cos(turn)
        J[:, 2, 3] = d / 1000 + (q if joint.kind == "P" else 0)
        T = T @ J if chain.convention == "standard" else T @ (frame(c=alpha) @ frame(a)) @ J
        if joint.name in twists:
            T = T @ motion(twists[joint.name])
        if chain.convention == "standard":
            T = T @ fixed
        out.append(T)
    T = T @ frame(*chain.tool)
    if "tool" in twists:
        T = T @ motion(twists["tool"])
    out.append(T)
    return out


def tips(chain, values, twists=None, shift=None):
    """Tool frames (N, 4, 4)."""
    return frames(chain, values, twists, shift)[-1]


def _bodies(chain):
    rows = [(chain.names.index(n), m, np.array(c) / 1000) for n, m, c in chain.masses]
    if chain.payload:
        rows.append((len(chain.joints) - 1, chain.payload, 0.5 * frame(*chain.tool)[:3, 3]))
    return rows


def height_energy(chain, values):
    """Potential energy (N,) in J."""
    F = frames(chain, values)
    return sum(m * GRAVITY * (F[i][:, 2, :3] @ c + F[i][:, 2, 3]) for i, m, c in _bodies(chain))


def weights(chain, values):
    """What weight asks of each axis (N, n): the slope of the potential energy, Nm or N."""
    if not _bodies(chain):
        return np.zeros_like(values)
    h, out = 1e-5, np.zeros_like(values)
    for i in range(values.shape[1]):
        step = np.zeros(values.shape[1])
        step[i] = h
        out[:, i] = (height_energy(chain, values + step) - height_energy(chain, values - step)) / (2 * h)
    return out


def overturning(chain, values):
    """Moments (N, 2) about x and y of the world at the root's origin by all weights of the arm, Nm."""
    F = frames(chain, values)
    before = F[chain.first_arm - 1] if chain.first_arm else np.tile(frame(*chain.base), (len(values), 1, 1))
    foot = before[:, :3, 3]
    M = np.zeros((len(values), 2))
    for i, m, c in _bodies(chain):
        if i < chain.first_arm:
            continue
        r = F[i][:, :3, :3] @ c + F[i][:, :3, 3] - foot
        M += m * GRAVITY * np.stack([-r[:, 1], r[:, 0]], axis=1)
    return M


def jacobian(chain, values):
    """(N, 6, n) of tip position (world) and turn (world) by numeric steps."""
    h = 1e-6
    T0 = tips(chain, values)
    J = np.zeros((len(values), 6, values.shape[1]))
    for i in range(values.shape[1]):
        step = np.zeros(values.shape[1])
        step[i] = h
        T = tips(chain, values + step)
        J[:, :3, i] = (T[:, :3, 3] - T0[:, :3, 3]) / h
        J[:, 3:, i] = Rotation.from_matrix(T[:, :3, :3] @ T0[:, :3, :3].transpose(0, 2, 1)).as_rotvec() / h
    return J


def reached(chain, goals, start, free=(), turns=True):
    """Axis values (N, n) whose tips are `goals` (N, 4, 4), all rows from `start` (n,) at once; axes in `free` stand still."""
    values = np.tile(np.asarray(start, float), (len(goals), 1))
    keep = [i for i in range(values.shape[1]) if i not in free]
    rows = slice(0, 6 if turns else 3)
    for _ in range(60):
        T = tips(chain, values)
        e = np.zeros((len(goals), 6))
        e[:, :3] = goals[:, :3, 3] - T[:, :3, 3]
        e[:, 3:] = Rotation.from_matrix(goals[:, :3, :3] @ T[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
        if np.abs(e[:, rows]).max() < 1e-9:
            return values
        J = jacobian(chain, values)[:, rows][:, :, keep]
        A = J @ J.transpose(0, 2, 1) + 1e-10 * np.eye(J.shape[1])
        step = (J.transpose(0, 2, 1) @ np.linalg.solve(A, e[:, rows, None]))[:, :, 0]
        step *= np.minimum(1.0, 0.3 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
        values[:, keep] += step
    raise ValueError(f"{chain.name}: not reached by {np.abs(e[:, rows]).max():.2g}")
