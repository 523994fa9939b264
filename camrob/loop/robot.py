"""The simulated robot: link errors, joints that follow late, and friction and lost motion where a joint reverses.

A cycle of joint i: the command that is `delay` cycles old moves the motor by a first-order lag, q <- q + a (c - q) with
a = 1 - exp(-T / lag). Friction has a state s between -1 and 1 that follows the direction of motion within the way `sliding`
(Dahl's model: ds = (sign - s) (1 - exp(-|dq| / sliding))). The link stands `lost` s behind the motor, which its encoder doesn't
show; the motor itself stands `friction` h behind, where h follows the changes of s and dies away with `recovery`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import ChainArrays, chain_arrays, forward_many
from camrob.loop.case import RobotErrors
from camrob.se3 import exp, frame_from_xyzabc, inverse

__all__ = ["RobotBatch", "actual_chain", "friction_state"]

Array = NDArray[np.float64]


def actual_chain(cell: Cell, errors: RobotErrors, q_start: Array, wanted_start: Array) -> ChainArrays:
    """The chain with drawn link errors, and a tool that makes the error at one posture the static one.

    q_start (6,): the nominal posture there; wanted_start (6,): the set-point, x, y, z, A, B, C, m and rad.
    """
    rng = np.random.default_rng(errors.seed)
    sizes = np.array([errors.link] * 3 + [errors.link_angle] * 3)
    joints = tuple(replace(j, after=j.after @ exp(rng.standard_normal(6) * sizes)) for j in cell.joints)
    wrong = replace(cell, joints=joints)
    base_T_real = frame_from_xyzabc(wanted_start - errors.static)
    base_T_drawn = base_T_tool(wrong, q_start)  # frames: drawn is tool
    drawn_T_real = inverse(base_T_drawn) @ base_T_real
    flange_T_drawn = np.asarray(cell.flange_T_tool)  # frames: drawn is tool
    return chain_arrays(wrong.with_tool(flange_T_drawn @ drawn_T_real))  # frames: real is tool


def friction_state(q: Array, sliding: Array) -> Array:
    """s (N, 6) of joints that stand at q (N, 6) one cycle after the other, from rest at s = 0; `sliding` (6,), rad."""
    out = np.zeros_like(q)
    for k in range(1, len(q)):
        out[k] = _slid(out[k - 1], q[k] - q[k - 1], sliding)
    return out


def _slid(s: Array, moved: Array, sliding: Array) -> Array:
    """s after motions of the joints, rad."""
    side = np.sign(moved)
    return np.asarray(s + (side - s) * -np.expm1(-np.abs(moved) / sliding) * (side != 0.0))


class RobotBatch:
    """Robots that run side by side, one a row: all of them are moved and measured together.

    `chains`: what each one really is; robots of one chain share the object.
    """

    def __init__(
        self, chains: Sequence[ChainArrays], errors: Sequence[RobotErrors], start: Array, cycle: float
    ) -> None:
        """Robots at rest at commands `start` (B, 6); `cycle`: s."""
        self._groups = [
            (chain, np.array([i for i, other in enumerate(chains) if other is chain]))
            for k, chain in enumerate(chains)
            if all(chain is not earlier for earlier in chains[:k])
        ]
        lag = np.maximum(np.stack([e.lag for e in errors]), 1e-9)
        self._share = -np.expm1(-cycle / lag)
        self._lost = np.stack([e.lost for e in errors])
        self._friction = np.stack([e.friction for e in errors])
        self._keep = np.exp(-cycle / np.array([e.recovery for e in errors]))[:, None]
        self._sliding = np.stack([e.sliding for e in errors])
        self._delay = np.array([e.delay for e in errors])
        self._sent = np.repeat(start[None], int(self._delay.max()) + 1, axis=0)
        self._rows = np.arange(len(start))
        self._cycle = 0
        self._motor = start.copy()
        self._state, self._held = np.zeros_like(start), np.zeros_like(start)

    def poses(self) -> Array:
        """base_T_tool (B, 4, 4) where the robots really are."""
        q = self._motor - self._lost * self._state - self._friction * self._held
        if len(self._groups) == 1:
            return np.asarray(forward_many(self._groups[0][0], q))
        out = np.empty((len(q), 4, 4))
        for chain, rows in self._groups:
            out[rows] = forward_many(chain, q[rows])
        return out

    def move(self, command: Array) -> None:
        """One cycle on, with new commands (B, 6)."""
        depth = len(self._sent)
        self._sent[self._cycle % depth] = command
        late = self._sent[(self._cycle - self._delay) % depth, self._rows]
        moved = self._share * (late - self._motor)
        self._motor = self._motor + moved
        state = _slid(self._state, moved, self._sliding)
        self._held = self._keep * self._held + (state - self._state)
        self._state = state
        self._cycle += 1
