"""Chains of rows, from the workpiece to the tool: where the tool is, and what weighs on each joint. mm, rad, kg, Nm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

__all__ = ["Joint", "Machine", "frame", "inverse", "small"]

GRAVITY = 9.81


@dataclass(frozen=True)
class Joint:
    """A row: alpha and theta in rad, a and d in mm; axis value = sign * variable + offset."""

    name: str
    kind: str  # R turns, P slides
    row: tuple[float, float, float, float]  # alpha, a, theta, d
    role: str = "arm"
    sign: float = 1.0
    offset: float = 0.0
    modified: bool = False
    low: float = 0.0  # the range that is used, of the axis value
    high: float = 0.0
    speed: float = 1.0  # the most that is used, a second


@dataclass(frozen=True)
class Mass:
    after: str
    kg: float
    center: tuple[float, float, float]


@dataclass(frozen=True)
class Machine:
    """A cell as its file tells it."""

    name: str
    joints: tuple[Joint, ...]
    tool: np.ndarray
    masses: tuple[Mass, ...] = ()
    payload: float = 0.0
    first: np.ndarray = field(default_factory=lambda: np.eye(4))
    flange: np.ndarray = field(default_factory=lambda: np.eye(4))
    keep: tuple[float, float] = (-1e9, 1e9)  # heights of the tool in world that poses keep to
    shipped: str = ""  # the name of a cell that comes with the project

    @property
    def names(self) -> list[str]:
        return [j.name for j in self.joints]

    def at(self, name: str) -> int:
        return self.names.index(name)

    def _rows(self, q: np.ndarray, rows: Mapping[str, np.ndarray], which: list[Joint]) -> list[np.ndarray]:
        found = []
        for joint in which:
            value = joint.sign * (q[:, self.at(joint.name)] - joint.offset)
            err = np.broadcast_to(rows.get(joint.name, np.zeros(4)), (len(q), 4))
            alpha, a, theta, d = (np.full(len(q), x) + err[:, k] for k, x in enumerate(joint.row))
            if joint.kind == "R":
                theta = theta + value
            else:
                d = d + value
            found.append(_row(alpha, a, theta, d, joint.modified))
        return found

    def part(self, q: np.ndarray) -> np.ndarray:
        """world_T_base (N, 4, 4): where the table has turned the part."""
        table = [j for j in self.joints if j.role == "workpiece"]
        still, moved = np.broadcast_to(self.first, (len(q), 4, 4)), np.broadcast_to(self.first, (len(q), 4, 4))
        for row0, row1 in zip(self._rows(0 * q, {}, table), self._rows(q, {}, table), strict=True):
            still, moved = still @ row0, moved @ row1
        return still @ inverse(moved)

    def frames(self, q: np.ndarray, rows: Mapping[str, np.ndarray] | None = None, foot=None, tool=None):
        """The joints' frames before and behind their rows, and world_T_tool; `foot` moves the arm's foot in its own frame."""
        rows = rows or {}
        still = q.copy()
        for k, joint in enumerate(self.joints):
            if joint.role == "workpiece":
                still[:, k] = 0.0
        here = np.broadcast_to(self.first, (len(q), 4, 4))
        before, behind, stood = {}, {}, False
        for joint, row in zip(self.joints, self._rows(still, rows, list(self.joints)), strict=True):
            if joint.role == "arm" and not stood:
                here, stood = here if foot is None else here @ foot, True
            before[joint.name] = here
            here = here @ row
            behind[joint.name] = here
        tip = here @ self.flange @ (self.tool if tool is None else tool)
        return before, behind, tip

    def axes(self, before, behind):
        """Each joint's axis and a point on it, in world."""
        return {
            j.name: (
                (behind if j.modified else before)[j.name][:, :3, 2],
                (behind if j.modified else before)[j.name][:, :3, 3],
            )
            for j in self.joints
        }

    def weight(self, q: np.ndarray, payload: float, center=(0.0, 0.0, 0.0)) -> np.ndarray:
        """Nm (N of what slides) by which gravity turns each axis the positive way; the payload at `center` of the flange, mm."""
        before, behind, _ = self.frames(q)
        axes = self.axes(before, behind)
        order = self.names
        last = order[-1]
        loads = [(m.after, m.kg, np.array([*m.center, 1.0])) for m in self.masses]
        held = [(behind[a] @ c, kg, a) for a, kg, c in loads]
        held.append((behind[last] @ self.flange @ np.array([*center, 1.0]), payload, last))
        out = np.zeros(q.shape)
        for k, joint in enumerate(self.joints):
            if joint.role == "workpiece":
                continue
            z, o = axes[joint.name]
            for place, kg, after in held:
                if order.index(after) < k:
                    continue
                force = np.array([0.0, 0.0, -kg * GRAVITY])
                turned = np.cross((place[:, :3] - o) / 1000.0, force)
                out[:, k] += joint.sign * np.einsum(
                    "ni,ni->n", z, turned if joint.kind == "R" else np.broadcast_to(force, z.shape)
                )
        return out


def _row(alpha, a, theta, d, modified):
    n = len(theta)
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    out = np.zeros((n, 4, 4))
    out[:, 3, 3] = 1.0
    if modified:  # Rx(alpha) Tx(a) Rz(theta) Tz(d)
        out[:, 0, 0], out[:, 0, 1], out[:, 0, 3] = ct, -st, a
        out[:, 1, 0], out[:, 1, 1], out[:, 1, 2], out[:, 1, 3] = st * ca, ct * ca, -sa, -sa * d
        out[:, 2, 0], out[:, 2, 1], out[:, 2, 2], out[:, 2, 3] = st * sa, ct * sa, ca, ca * d
    else:  # Rz(theta) Tz(d) Tx(a) Rx(alpha)
        out[:, 0, 0], out[:, 0, 1], out[:, 0, 2], out[:, 0, 3] = ct, -st * ca, st * sa, a * ct
        out[:, 1, 0], out[:, 1, 1], out[:, 1, 2], out[:, 1, 3] = st, ct * ca, -ct * sa, a * st
        out[:, 2, 1], out[:, 2, 2], out[:, 2, 3] = sa, ca, d
    return out


def frame(values) -> np.ndarray:
    """X, Y, Z, A, B, C in mm and degrees: Rz(A) Ry(B) Rx(C)."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("ZYX", values[3:], degrees=True).as_matrix()
    out[:3, 3] = values[:3]
    return out


def inverse(T: np.ndarray) -> np.ndarray:
    """Of rigid motions, any number of them."""
    out = np.zeros_like(T)
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    out[..., :3, :3], out[..., 3, 3] = R, 1.0
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", R, T[..., :3, 3])
    return out


def small(shift, turn) -> np.ndarray:
    """A rigid motion by its shift (mm) and its rotation vector (rad); one, or (N, 4, 4)."""
    shift, turn = np.asarray(shift, float), np.asarray(turn, float)
    shape = np.broadcast_shapes(shift.shape, turn.shape)[:-1]
    turn = np.array(np.broadcast_to(turn, (*shape, 3)))
    out = np.zeros((*shape, 4, 4))
    out[..., :3, :3] = Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix().reshape(*shape, 3, 3)
    out[..., :3, 3], out[..., 3, 3] = shift, 1.0
    return out
