"""Chains as fixed frames with a screw about z behind each: where all links are, and what weighs on each axis. mm, rad, N, Nm."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

__all__ = ["Joint", "Lump", "Robot", "about_z", "frame", "inverse", "nudge", "place"]

G = 9.80665


def place(x=0.0, y=0.0, z=0.0, rpy=(0.0, 0.0, 0.0)) -> np.ndarray:
    """A frame by mm and fixed-axis roll, pitch, yaw in degrees (URDF's order)."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", rpy, degrees=True).as_matrix()
    T[:3, 3] = x, y, z
    return T


def frame(xyzabc) -> np.ndarray:
    """A frame by KUKA's X, Y, Z, A, B, C: Rz(A) Ry(B) Rx(C)."""
    x, y, z, a, b, c = xyzabc
    return place(x, y, z, (c, b, a))


def inverse(T: np.ndarray) -> np.ndarray:
    """Of rigid frames (..., 4, 4)."""
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    out = np.zeros_like(T)
    out[..., :3, :3] = R
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", R, T[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def nudge(move, turn) -> np.ndarray:
    """Small frames (N, 4, 4) by translation (mm) and rotation vector (rad), each (3,) or (N, 3)."""
    move, turn = np.broadcast_arrays(np.atleast_2d(np.asarray(move, float)), np.atleast_2d(np.asarray(turn, float)))
    T = np.zeros((len(move), 4, 4))
    T[:, :3, :3] = Rotation.from_rotvec(turn.copy()).as_matrix()
    T[:, :3, 3] = move
    T[:, 3, 3] = 1.0
    return T


def about_z(value: np.ndarray, slides: bool) -> np.ndarray:
    """What a joint does: (N, 4, 4)."""
    T = np.broadcast_to(np.eye(4), (len(value), 4, 4)).copy()
    if slides:
        T[:, 2, 3] = value
    else:
        c, s = np.cos(value), np.sin(value)
        T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = c, -s, s, c
    return T


@dataclass(frozen=True)
class Joint:
    """An axis: its frame behind the one before it, and how the controller counts (rad, mm)."""

    name: str
    pre: np.ndarray
    low: float
    high: float
    speed: float
    slides: bool = False
    sign: float = 1.0
    offset: float = 0.0
    role: str = "arm"
    soft: float = 0.0  # rad/Nm or mm/N, what its drive gives
    big: float = 1.0  # mm that a rad of it moves the tool, roughly


@dataclass(frozen=True)
class Lump:
    """A mass behind a joint, in the frame right behind its motion."""

    after: int
    kg: float
    at: tuple[float, float, float]


@dataclass(frozen=True)
class Robot:
    """A machine as its maker drew it."""

    name: str
    joints: tuple[Joint, ...]
    flange: np.ndarray  # behind the last joint's motion
    tool: np.ndarray
    lumps: tuple[Lump, ...] = ()
    ready: tuple[float, ...] = ()  # a posture in the middle of its work
    files: dict[str, str] = field(default_factory=dict)
    payload: float = 0.0
    tied: tuple[tuple[int, tuple[tuple[int, float], ...]], ...] = ()  # axes that rods turn along with others

    @property
    def names(self) -> list[str]:
        """Of the axes."""
        return [j.name for j in self.joints]

    def index(self, name: str) -> int:
        """Of an axis."""
        return self.names.index(name)

    @property
    def speeds(self) -> np.ndarray:
        """Highest of each axis."""
        return np.array([j.speed for j in self.joints])

    def with_rods(self, q: np.ndarray) -> np.ndarray:
        """Values, those of tied axes by the others'."""
        q = q.copy()
        for i, parts in self.tied:
            q[..., i] = sum(x * q[..., k] for k, x in parts)
        return q

    def behind(self, q: np.ndarray, warp=None) -> list[np.ndarray]:
        """world_T_link right behind each joint's motion, a table held at 0. `warp`: by joint, small frames before it."""
        T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
        out = []
        for i, j in enumerate(self.joints):
            value = j.sign * ((np.zeros(len(q)) if j.role == "workpiece" else q[:, i]) - j.offset)
            T = T @ j.pre
            if warp and i in warp:
                T = T @ warp[i]
            T = T @ about_z(value, j.slides)
            out.append(T)
        return out

    def tip(self, q: np.ndarray, warp=None, tool=None) -> np.ndarray:
        """world_T_tool."""
        return self.behind(q, warp)[-1] @ self.flange @ (self.tool if tool is None else tool)

    def plate(self, q: np.ndarray) -> np.ndarray:
        """world_T_base: the table's plate, turned by its axis."""
        T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
        for i, j in enumerate(self.joints):
            if j.role == "workpiece":
                still = j.pre @ about_z(-j.sign * j.offset * np.ones(len(q)), j.slides)
                T = T @ still @ inverse(j.pre @ about_z(j.sign * (q[:, i] - j.offset), j.slides))
        return T

    def load(self, q: np.ndarray, held: float = 0.0, push=None, own: bool = True) -> np.ndarray:
        """What gravity (of own masses and of `held` at the tool) and a push (N, 3) at the tip make in each axis, in its count."""
        links = self.behind(q)
        tip = links[-1] @ self.flange @ self.tool
        down = np.zeros((len(q), 3))
        down[:, 2] = -G
        forces = []
        for lump in self.lumps if own else ():
            T = links[lump.after]
            forces.append((lump.after, T[:, :3, :3] @ np.array(lump.at) + T[:, :3, 3], lump.kg * down))
        if held:
            centre = 0.5 * (tip[:, :3, 3] + (links[-1] @ self.flange)[:, :3, 3])
            forces.append((len(self.joints) - 1, centre, held * down))
        if push is not None:
            forces.append((len(self.joints) - 1, tip[:, :3, 3], push))
        out = np.zeros(q.shape)
        for i, (j, T) in enumerate(zip(self.joints, links, strict=True)):
            z, o = T[:, :3, 2], T[:, :3, 3]
            if j.role == "workpiece":
                continue
            for after, at, f in forces:
                if after >= i:
                    m = f if j.slides else np.cross(at - o, f) / 1000.0
                    out[:, i] += j.sign * np.sum(z * m, axis=1)
        return out

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """(N, 6, n): mm and rad of the tip by rad (mm) of the axes."""
        links = self.behind(q)
        tip = (links[-1] @ self.flange @ self.tool)[:, :3, 3]
        J = np.zeros((len(q), 6, len(self.joints)))
        for i, (j, T) in enumerate(zip(self.joints, links, strict=True)):
            z = j.sign * T[:, :3, 2]
            if j.role == "workpiece":
                continue
            if j.slides:
                J[:, :3, i] = z
            else:
                J[:, :3, i], J[:, 3:, i] = np.cross(z, tip - T[:, :3, 3]), z
        return J

    def holding(self, tool) -> Robot:
        """With another tool frame."""
        return replace(self, tool=tool)
