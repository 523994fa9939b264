"""Chains by their axes: where each lies, where the tip is, what weight asks of each; small motions beside a joint. SI."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

G = 9.81


def placed(x=0.0, y=0.0, z=0.0, a=0.0, b=0.0, c=0.0):
    """(4, 4) in m of mm and Rz(a) Ry(b) Rx(c) in degrees."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    T[:3, 3] = np.array([x, y, z]) / 1000
    return T


def nudged(twist):
    """(N, 4, 4) of (N, 6): a shift and a rotation vector."""
    T = np.tile(np.eye(4), (len(twist), 1, 1))
    T[:, :3, 3] = twist[:, :3]
    T[:, :3, :3] = Rotation.from_rotvec(twist[:, 3:]).as_matrix()
    return T


@dataclass(frozen=True)
class Axis:
    """A value v moves it by sign * (v - zero) about or along its z."""

    name: str
    row: tuple  # alpha degrees, a mm, theta degrees, d mm
    lo: float
    hi: float
    top: float = 80.0  # degrees/s or mm/s as it is run
    slides: bool = False
    role: str = "arm"
    sign: int = 1
    zero: float = 0.0


@dataclass(frozen=True)
class Machine:
    name: str
    axes: tuple
    tool: tuple
    home: tuple
    craig: bool = False  # modified rows
    base: tuple = (0,) * 6  # base_to_first
    lumps: tuple = ()  # (axis, kg, (x, y, z) mm where its row ends)
    load: float = 0.0
    floor: float | None = None  # least height of the tip, m
    reach: float = 9.0  # greatest distance of the tip from the arm's first axis, m

    @property
    def names(self):
        return [a.name for a in self.axes]

    @property
    def slides(self):
        return np.array([a.slides for a in self.axes])

    @property
    def unit(self):
        return np.where(self.slides, 1e-3, np.pi / 180)

    @property
    def limits(self):
        return np.array([(a.lo, a.hi) for a in self.axes]) * self.unit[:, None]

    @property
    def tops(self):
        return np.array([a.top for a in self.axes]) * self.unit

    @property
    def at_home(self):
        return np.array(self.home) * self.unit

    @property
    def first(self):
        return next(i for i, a in enumerate(self.axes) if a.role == "arm")

    def of(self, names):
        return [self.names.index(n) for n in names]

    def carrying(self, kg):
        return replace(self, load=kg)


def chain(m, v, near=None, far=None, shift=None):
    """Axis frames, row ends and the tip (N, 4, 4); `near` and `far`: twists (N, 6) before and behind a joint's motion."""
    near, far = near or {}, far or {}
    v = v if shift is None else v + shift
    T = np.tile(placed(*m.base), (len(v), 1, 1))
    at, ends = [], []
    for i, axis in enumerate(m.axes):
        if i == m.first:
            if "foot" in near:
                T = T @ nudged(near["foot"])
        alpha, a, theta, d = axis.row
        lead, trail = placed(c=alpha), placed(x=a)
        if m.craig and axis.role == "arm":
            T = T @ lead @ trail
        if axis.name in near:
            T = T @ nudged(near[axis.name])
        at.append(T)
        q = axis.sign * (v[:, i] - axis.zero * m.unit[i])
        M = np.tile(np.eye(4), (len(v), 1, 1))
        M[:, :3, :3] = Rotation.from_rotvec(
            np.outer(np.radians(theta) + (0 if axis.slides else q), [0, 0, 1])
        ).as_matrix()
        M[:, 2, 3] = d / 1000 + (q if axis.slides else 0)
        T = T @ M
        if axis.name in far:
            T = T @ nudged(far[axis.name])
        if not (m.craig and axis.role == "arm"):
            T = T @ trail @ lead
        ends.append(T)
    if "flange" in far:
        T = T @ nudged(far["flange"])
    T = T @ placed(*m.tool)
    if "tool" in far:
        T = T @ nudged(far["tool"])
    return at, ends, T


def tip(m, v, near=None, far=None, shift=None):
    return chain(m, v, near, far, shift)[2]


def jacobian(m, v):
    """(N, 6, n): the tip's shift and turn by each axis value, by geometry."""
    at, _, T = chain(m, v)
    J = np.zeros((len(v), 6, v.shape[1]))
    for i, axis in enumerate(m.axes):
        z = axis.sign * at[i][:, :3, 2]
        if axis.slides:
            J[:, :3, i] = z
        else:
            J[:, :3, i] = np.cross(z, T[:, :3, 3] - at[i][:, :3, 3])
            J[:, 3:, i] = z
    return J


def _hung(m, ends):
    """Mass points: (index of the axis that carries it, kg, (N, 3))."""
    out = [(m.names.index(n), kg, ends[m.names.index(n)] @ placed(*c)) for n, kg, c in m.lumps]
    if m.load:
        out.append((len(m.axes) - 1, m.load, ends[-1] @ placed(*(0.5 * np.array(m.tool[:3])))))
    return [(i, kg, T[:, :3, 3]) for i, kg, T in out]


def level(m, v):
    """Values with workpiece axes at zero, where the frame of the plate is that of the floor."""
    out = v.copy()
    out[:, [i for i, a in enumerate(m.axes) if a.role == "workpiece"]] = 0.0
    return out


def weight(m, v):
    """(N, n) Nm or N that weight asks of each axis of rail and arm: slope of height energy by its value."""
    v = level(m, v)
    at, ends, _ = chain(m, v)
    out = np.zeros_like(v)
    for carried, kg, p in _hung(m, ends):
        for i in range(carried + 1):
            if m.axes[i].role == "workpiece":
                continue
            z = m.axes[i].sign * at[i][:, :3, 2]
            way = z if m.slides[i] else np.cross(z, p - at[i][:, :3, 3])
            out[:, i] += kg * G * way[:, 2]
    return out


def moment_at(m, v, i):
    """(N, 3) Nm of all weight behind axis i about its own frame's origin, in that frame (it does not turn with the value)."""
    v = level(m, v)
    at, ends, _ = chain(m, v)
    M = np.zeros((len(v), 3))
    for carried, kg, p in _hung(m, ends):
        if carried >= i:
            M += np.cross(p - at[i][:, :3, 3], np.array([0, 0, -kg * G]))
    return np.einsum("nji,nj->ni", at[i][:, :3, :3], M)


def solved(m, goals, start, free=(), turns=True, most=80):
    """Axis values whose tips are `goals` (N, 4, 4); axes in `free` stand still at `start`."""
    v = np.tile(start, (len(goals), 1)) if np.ndim(start) == 1 else start.copy()
    keep = [i for i in range(v.shape[1]) if i not in free]
    rows = slice(0, 6 if turns else 3)
    for _ in range(most):
        T = tip(m, v)
        e = np.zeros((len(v), 6))
        e[:, :3] = goals[:, :3, 3] - T[:, :3, 3]
        e[:, 3:] = Rotation.from_matrix(goals[:, :3, :3] @ T[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
        if np.abs(e[:, rows]).max() < 1e-9:
            return v
        J = jacobian(m, v)[:, rows][:, :, keep]
        A = J @ J.transpose(0, 2, 1) + 1e-9 * np.eye(J.shape[1])
        step = np.einsum("nij,ni->nj", J, np.linalg.solve(A, e[:, rows, None])[:, :, 0])
        v[:, keep] += step * np.minimum(1, 0.25 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
    raise ValueError(f"{m.name}: {np.abs(e[:, rows]).max():.1g} short of its goals")
