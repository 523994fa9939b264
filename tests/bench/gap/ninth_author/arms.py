"""Chains of axes that carry weight, as they are drawn and as they are wrong.

A chain is a product of standard Denavit-Hartenberg rows, Rz(theta) Tz(d) Tx(a) Rx(alpha), with rigid frames between them;
what is wrong with it is a small twist (mm and rad as m and rad, x y z then rotation) behind a row, before the foot or at
the tool. Lengths in m, angles in rad, masses in kg. Where an axis carries the part (a table) it is kept apart from the
arm: `tips` gives the tool in world, `tables` the map from world to the turning base.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

__all__ = ["CELLS", "Arm", "euler", "frame", "twist"]

CELLS = Path(__file__).resolve().parents[4] / "cells"
G = 9.81


def frame(v):
    """4x4 of X, Y, Z in mm and KUKA's A, B, C in degrees."""
    a, b, c = np.radians(v[3:])
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    out = np.eye(4)
    out[:3, :3] = [
        [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
        [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
        [-sb, cb * sc, cb * cc],
    ]
    out[:3, 3] = np.array(v[:3]) / 1e3
    return out


def euler(R):
    """A, B, C in degrees of rotations (..., 3, 3)."""
    b = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 0, 0], R[..., 1, 0]))
    a = np.arctan2(R[..., 1, 0], R[..., 0, 0])
    c = np.arctan2(R[..., 2, 1], R[..., 2, 2])
    return np.degrees(np.stack([a, b, c], -1))


def twist(w):
    """4x4 (..., 4, 4) of twists (..., 6): the rotation by Rodrigues, the shift as it stands (exact enough below 0.1 rad)."""
    w = np.asarray(w, float)
    p, r = w[..., :3], w[..., 3:]
    n = np.linalg.norm(r, axis=-1)[..., None, None]
    K = np.zeros((*w.shape[:-1], 3, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -r[..., 2], r[..., 1], -r[..., 0]
    K -= np.swapaxes(K, -1, -2)
    safe = np.where(n < 1e-9, 1.0, n)
    s = np.where(n < 1e-9, 1.0, np.sin(safe) / safe)
    c = np.where(n < 1e-9, 0.5, (1 - np.cos(safe)) / safe**2)
    out = np.zeros((*w.shape[:-1], 4, 4))
    out[..., :3, :3] = np.eye(3) + s * K + c * (K @ K)
    out[..., :3, 3] = p
    out[..., 3, 3] = 1
    return out


def _row(q, row, slides):
    alpha, a, theta, d = row
    th = theta + (0 if slides else q)
    ct, st, ca, sa = np.cos(th), np.sin(th), np.cos(alpha), np.sin(alpha)
    out = np.zeros((len(q), 4, 4))
    out[:, 0, 0], out[:, 0, 1], out[:, 0, 2], out[:, 0, 3] = ct, -st * ca, st * sa, a * ct
    out[:, 1, 0], out[:, 1, 1], out[:, 1, 2], out[:, 1, 3] = st, ct * ca, -ct * sa, a * st
    out[:, 2, 1], out[:, 2, 2], out[:, 2, 3] = sa, ca, d + (q if slides else 0)
    out[:, 3, 3] = 1
    return out


@dataclass(frozen=True)
class Arm:
    """A machine as it is drawn, and the masses and stiffnesses that it really has."""

    name: str
    names: tuple[str, ...]
    rows: np.ndarray
    slides: tuple[bool, ...]
    pre: tuple[np.ndarray, ...]  # frames before each row
    tool: np.ndarray
    sign: np.ndarray
    off: np.ndarray
    middle: np.ndarray  # q about which it works
    spread: np.ndarray
    soft: np.ndarray  # rad/Nm (m/N) of each axis
    masses: tuple[tuple[int, float, tuple[float, float, float]], ...]
    text: str = ""  # cell.toml of its own, or none where the cell is shipped
    shipped: str = ""
    root: np.ndarray = field(
        default_factory=lambda: np.eye(4)
    )  # from the frame that the arm begins at to its foot, z up
    parallel: bool = False  # the forearm's motor stands on the column
    speed: float = 0.5  # rad/s (m/s), of an axis that is jogged

    @property
    def n(self) -> int:
        """How many axes."""
        return len(self.names)

    @property
    def first(self) -> int:
        """The arm's first axis."""
        return next((i for i, n in enumerate(self.names) if n.startswith("A")), 0)

    @property
    def table(self) -> bool:
        """Whether its first axis carries the part."""
        return self.names[0] == "E2"

    def values(self, q):
        """Axis values as the controller shows them, degrees or mm."""
        scale = np.array([1e3 if s else np.degrees(1.0) for s in self.slides])
        return (self.sign * q) * scale + self.off

    def chain(self, q, twists=None):
        """Frames before each row's turn (n, list), and the tool (N, 4, 4) in world."""
        twists, q = twists or {}, q.copy()
        if self.table:
            q[:, 0] = -self.off[0] / self.sign[0] * np.pi / 180  # the table's zero: base and world are one
        T, before, after = np.broadcast_to(np.eye(4), (len(q), 4, 4)), [], []
        if "world" in twists:
            T = twist(twists["world"])
        for i in range(self.n):
            T = T @ self.pre[i]
            if i == self.first and "foot" in twists:
                T = T @ self.root @ twist(twists["foot"]) @ np.linalg.inv(self.root)
            before.append(T)
            T = T @ _row(q[:, i], self.rows[i], self.slides[i])
            if i in twists:
                T = T @ twist(twists[i])
            after.append(T)
        T = T @ self.tool
        if "tool" in twists:
            T = T @ twist(twists["tool"])
        return before, after, T

    def tips(self, q, twists=None):
        """The tool in world (N, 4, 4)."""
        return self.chain(q, twists)[2]

    def tables(self, q, axis=None, wobble=None):
        """base_T_world (N, 4, 4): a turn about the table's axis, which lies askew by `axis` (6,) and wobbles (N, 6)."""
        angle = np.radians(self.values(q)[:, 0])
        w = np.zeros((len(q), 6))
        w[:, 5] = angle
        turn = twist(w) if wobble is None else twist(w) @ twist(wobble)
        if axis is None:
            return turn
        X = twist(axis)
        return X @ turn @ np.linalg.inv(X)

    def jacobian(self, q, point=None):
        """Geometric Jacobian (N, 6, n) of the tool's tip in world."""
        before, _, tip = self.chain(q)
        at = tip[:, :3, 3] if point is None else point
        J = np.zeros((len(q), 6, self.n))
        for i in range(1 if self.table else 0, self.n):
            z = before[i][:, :3, 2]
            if self.slides[i]:
                J[:, :3, i] = z
            else:
                J[:, :3, i], J[:, 3:, i] = np.cross(z, at - before[i][:, :3, 3]), z
        return J

    def weights(self, q, masses=None, extra=()):
        """Places (N, 3) and kg of what hangs on the chain; `extra`: (kg, place in the tool's frame in m)."""
        _, after, tip = self.chain(q)
        out = []
        for i, kg, c in self.masses if masses is None else masses:
            out.append((i, kg, (after[i] @ np.array([*c, 1.0]))[:, :3]))
        return out + [(self.n - 1, kg, (tip @ np.array([*c, 1.0]))[:, :3]) for kg, c in extra]

    def loads(self, q, masses=None, extra=()):
        """What gravity asks of each axis (N, n): the generalised force, Nm (N of a slide)."""
        before, _, _ = self.chain(q)
        out = np.zeros((len(q), self.n))
        for k, kg, p in self.weights(q, masses, extra):
            for i in range(1 if self.table else 0, k + 1):
                z = before[i][:, :3, 2]
                arm = z if self.slides[i] else np.cross(z, p - before[i][:, :3, 3])
                out[:, i] -= kg * G * arm[:, 2]
        return out

    def moment(self, q, extra=()):
        """Overturning moment (N, 3) of all weight about the foot, in the foot's axes (z up)."""
        before, _, _ = self.chain(q)
        foot = before[self.first] @ self.root
        total = 0.0
        for _, kg, p in self.weights(q, extra=extra):
            total = total + np.cross(p - foot[:, :3, 3], [0.0, 0.0, -kg * G])
        return np.einsum("nji,nj->ni", foot[:, :3, :3], total)

    def sag(self, loads):
        """Turns (N, n) by which axes give under loads, linear: of a parallelogram each motor holds a link of its own."""
        out = self.soft * loads
        if self.parallel:
            i = self.first + 1
            two, three = self.soft[i] * (loads[:, i] - loads[:, i + 1]), self.soft[i + 1] * loads[:, i + 1]
            out[:, i], out[:, i + 1] = two, three - two
        return out

    def inverse(self, targets, q, fixed=()):
        """q (N, n) whose tips are the targets (N, 4, 4), as near as the free axes come; begins at q."""
        free = [i for i in range(self.n) if i not in fixed and not (self.table and i == 0)]
        weight = np.array([1, 1, 1, 0.3, 0.3, 0.3])
        if len(free) < 6:
            weight[3:] = 0.02
        for _ in range(14):
            tip = self.tips(q)
            e = np.zeros((len(q), 6))
            e[:, :3] = targets[:, :3, 3] - tip[:, :3, 3]
            R = targets[:, :3, :3] @ np.swapaxes(tip[:, :3, :3], 1, 2)
            e[:, 3:] = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
            J = self.jacobian(q)[:, :, free] * weight[:, None]
            A = np.swapaxes(J, 1, 2) @ J + 1e-6 * np.eye(len(free))
            b = np.einsum("nij,ni->nj", J, e * weight)
            q = q.copy()
            q[:, free] += np.clip(np.linalg.solve(A, b[..., None])[..., 0], -0.2, 0.2)
        return q
