"""From a place on the path to the posture there: by the kernels where the arm has a closed wrist, else by Newton's method.

The kernels of `interpolate` know one family of arms, whose last three axes meet. For every other arm (Universal Robots, wrists
with an offset) the same places are worked out here in numpy, and the arm follows them by `Arm.follow`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.controller.interpolate import (
    ARC,
    JUMP,
    OUT_OF_REACH,
    PTP,
    REACHED,
    Machine,
    Motions,
    Pieces,
    postures,
    trace,
)
from camrob.controller.replay import constant_transforms
from camrob.kinematics.arm import FOLLOW_UNREACHED, FOLLOWED, Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays
from camrob.runs import runs_of
from camrob.se3 import pose, rotation_exp

__all__ = ["Walk", "walk_of"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Walk(Protocol):
    """Postures along the pieces of a path. Poses are in the frame that they are programmed in; those of a PTP in `base`."""

    def nodes(self, start: Array, jump: float, q: Array, p: Array) -> tuple[int, int]:
        """Fill postures q (K, n) and tool positions p (K, 3) at all nodes, from posture start (n,): see `interpolate.trace`."""

    def rows(self, piece: Indices, at: Array, near: Array, q: Array, p: Array, R: Array) -> int:
        """Fill q (N, n), p (N, 3), R (N, 3, 3) at `at` (N,) from the beginnings of pieces (N,): see `interpolate.postures`."""


def walk_of(cell: Cell, motions: Motions, pieces: Pieces) -> Walk:
    """The way of a cell's arm along a path."""
    arm = Arm.of(cell)
    k = cell.arm_slice.start
    held = np.full(k, np.nan)
    if not cell.base_follows_table:
        for i in cell.indices(Role.WORKPIECE):
            held[i] = float(cell.joints[i].q_value(np.zeros(())))
    if arm.closed is None:
        # limits are the judge's, not the path's
        free = replace(arm, lower=np.full(6, -np.inf), upper=np.full(6, np.inf))
        return _ByNewton(cell, free, motions, pieces, held)
    return _ByKernel(Machine(chain_arrays(cell), constant_transforms(cell, k), arm.closed, held), motions, pieces)


@dataclass(frozen=True)
class _ByKernel:
    machine: Machine
    motions: Motions
    pieces: Pieces

    def nodes(self, start: Array, jump: float, q: Array, p: Array) -> tuple[int, int]:
        code, piece = trace(self.machine, self.motions, self.pieces, start, jump, q, p)
        return int(code), int(piece)

    def rows(self, piece: Indices, at: Array, near: Array, q: Array, p: Array, R: Array) -> int:
        return int(postures(self.machine, self.motions, self.pieces, piece, at, near, q, p, R))


@dataclass(frozen=True)
class _ByNewton:
    cell: Cell
    arm: Arm
    motions: Motions
    pieces: Pieces
    held: Array

    def nodes(self, start: Array, jump: float, q: Array, p: Array) -> tuple[int, int]:
        pieces, arm = self.pieces, self.cell.arm_slice
        q[0] = start
        for part in runs_of(self._is_ptp(np.arange(len(pieces.motion)))):
            first = part.start
            piece = np.repeat(np.arange(first, part.stop), pieces.steps[part])
            at = (np.arange(len(piece)) - (pieces.first[piece] - pieces.first[first]) + 1) * self._step(piece)
            # with the node that the stretch begins in
            piece, at = np.concatenate([[first], piece]), np.concatenate([[0.0], at])
            rows = slice(int(pieces.first[first]), int(pieces.first[first]) + len(piece))
            before = q[rows.start].copy()
            if self._is_ptp(piece[:1])[0]:
                arrived = p[rows.start].copy()
                self._along_axes(piece, at, q[rows], p[rows], np.empty((len(piece), 3, 3)))
                if first > 0:  # where the tool was led to stays in the frame that it was led in
                    p[rows.start] = arrived
                continue
            q[rows] = before
            base_T = self._lead(piece, at, q[rows], p[rows])
            q[rows, arm], code, count = self.arm.follow(self._from_foot(base_T, q[rows]), before[arm], step=jump)
            if code != FOLLOWED:
                return (OUT_OF_REACH if code == FOLLOW_UNREACHED else JUMP), int(piece[count])
        return REACHED, len(pieces.motion)

    def rows(self, piece: Indices, at: Array, near: Array, q: Array, p: Array, R: Array) -> int:
        arm = self.cell.arm_slice
        axes = self._is_ptp(piece)
        for mask in (axes, ~axes):
            if not np.any(mask):
                continue
            q_, p_, R_ = near[mask].copy(), np.empty((int(mask.sum()), 3)), np.empty((int(mask.sum()), 3, 3))
            if mask is axes:
                self._along_axes(piece[mask], at[mask], q_, p_, R_)
            else:
                base_T = self._lead(piece[mask], at[mask], q_, p_)
                R_[:] = base_T[:, :3, :3]
                foot_T = self._from_foot(base_T, q_)
                for i, start in enumerate(q_[:, arm].copy()):  # each from its own neighbour: rows lie far apart
                    q_[i : i + 1, arm], code, _count = self.arm.follow(foot_T[i : i + 1], start, step=np.inf)
                    if code != FOLLOWED:
                        return int(np.flatnonzero(mask)[i])
            q[mask], p[mask], R[mask] = q_, p_, R_
        return len(piece)

    def _is_ptp(self, piece: Indices) -> Flags:
        return np.asarray(self.motions.kind[self.pieces.motion[piece]] == PTP)

    def _step(self, piece: Indices) -> Array:
        return np.asarray(self.pieces.length[piece] / self.pieces.steps[piece])

    def _along_axes(self, piece: Indices, at: Array, q: Array, p: Array, R: Array) -> None:
        """Fill postures and tool of places on PTPs."""
        motions, m, d = self.motions, self.pieces.motion[piece], self.pieces.blend[piece]
        round_ = d > 0.0
        four_d = np.where(round_, 4.0 * d, 1.0)
        last = np.minimum(m + 2, len(motions.q) - 1)  # only a rounding has a motion behind it
        behind = np.minimum(m + 1, len(motions.size) - 1)
        before = np.where(round_, motions.size[m] - (2.0 * d - at) ** 2 / four_d, self.pieces.start[piece] + at)
        after = np.where(round_, at * at / four_d / motions.size[behind], 0.0)
        share = (before / motions.size[m])[:, None]
        q[:] = motions.q[m] + share * (motions.q[m + 1] - motions.q[m])
        q += after[:, None] * (motions.q[last] - motions.q[m + 1])
        tool = base_T_tool(self.cell, q)
        p[:], R[:] = tool[:, :3, 3], tool[:, :3, :3]

    def _lead(self, piece: Indices, at: Array, q: Array, p: Array) -> Array:
        """Fill tool positions and the axes that carry the foot, of places on LINs and CIRCs; the tool's poses (N, 4, 4)."""
        m, d, k = self.pieces.motion[piece], self.pieces.blend[piece], len(self.held)
        R = np.empty((len(piece), 3, 3))
        plain = d <= 0.0
        p[plain], R[plain], q[plain, :k] = self._on(m[plain], self.pieces.start[piece][plain] + at[plain])
        m, d, at = m[~plain], d[~plain], at[~plain]
        p0, R0, e0 = self._on(m, self.motions.size[m] - (2.0 * d - at) ** 2 / (4.0 * d))
        p1, R1, e1 = self._on(m + 1, at**2 / (4.0 * d))
        corner = self.motions.R[m + 1]
        p[~plain] = p0 + p1 - self.motions.p[m + 1]
        R[~plain] = R0 @ (corner.swapaxes(1, 2) @ R1)
        q[~plain, :k] = e0 + e1 - self.motions.e[m + 1]
        return pose(R, p)

    def _on(self, m: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Place, rotation and carrying axes at s of motions m, which are no PTPs."""
        motions = self.motions
        share = (s / motions.size[m])[:, None]
        angle = share * motions.angle[m][:, None]
        on_arc = motions.center[m] + np.cos(angle) * motions.u[m] + np.sin(angle) * motions.v[m]
        on_line = motions.p[m] + share * (motions.p[m + 1] - motions.p[m])
        p = np.where((motions.kind[m] == ARC)[:, None], on_arc, on_line)
        return (
            p,
            motions.R[m] @ rotation_exp(share * motions.w[m]),
            motions.e[m] + share * (motions.e[m + 1] - motions.e[m]),
        )

    def _from_foot(self, base_T: Array, q: Array) -> Array:
        """Poses (N, 4, 4) of the tool from the arm's foot, where the carrying axes stand as q says or are held."""
        at = q.copy()
        stand = ~np.isnan(self.held)
        at[:, : len(self.held)][:, stand] = self.held[stand]
        return np.ascontiguousarray(self.arm.foot_T_tool(base_T, at))
