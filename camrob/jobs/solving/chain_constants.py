"""A chain's constants as the planner counts them: compliance, shift and coupling of the arm's axes, and frames that stand off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.terms import PARTS, ErrorTerm, TermKind
from camrob.cell.cell import Cell
from camrob.cell.world import world_T_floor
from camrob.redundancy.accuracy.posture_errors import ARM_AXES, PLACES

__all__ = ["ChainConstants", "chain_constants", "reduced_root"]

Array = NDArray[np.float64]

_FIRST = 2 * ARM_AXES  # row of the couplings, behind compliance and shift
_SEEN = 2e-6
"""m that a direction of what was fitted has to move the tool, where all its parts help each other, to be counted."""
_REACH, _TORQUE = 1.0, 100.0  # m and Nm of an ordinary arm, that tell how far a rad and a rad/Nm move its tool


@dataclass(frozen=True)
class ChainConstants:
    """couples: (M, 2) axes of the arm; rows: (12 + M + 6 PLACES, P), what a unit of each of P constants adds to the planner's
    numbers (see `PostureErrors`), SI, zeros for one that it doesn't count; counts: (P,) whether it does.
    """

    couples: NDArray[np.int64]
    rows: Array
    counts: NDArray[np.bool_]

    def shift(self, values: Array) -> Array:
        """(6,) rad of the constants' values (P,)."""
        return np.asarray(self.rows[ARM_AXES:_FIRST] @ values)

    def coupling(self, values: Array) -> Array:
        """(M,)."""
        return np.asarray(self.rows[_FIRST : _FIRST + len(self.couples)] @ values)

    def places(self, values: Array) -> Array:
        """(PLACES, 6), none where no frame stands off."""
        rows = self.rows[_FIRST + len(self.couples) :]
        return np.asarray(rows @ values).reshape(PLACES, 6) if rows.any() else np.zeros((0, 6))

    def root(self, root: Array, moved: Array) -> tuple[Array, Array]:
        """(12 + M + 6 PLACES, K') of a root (P, K) of the constants' covariance, without the places where none stand off; and in
        the same directions moved (R, K), m.
        """
        last = len(self.rows) if self.rows[_FIRST + len(self.couples) :].any() else _FIRST + len(self.couples)
        return reduced_root(self.rows[:last] @ root, moved)


def chain_constants(cell: Cell, terms: Sequence[ErrorTerm]) -> ChainConstants:
    """The constants `terms` of a cell."""
    arm = cell.arm_slice
    axes = {cell.names[i]: i - arm.start for i in range(arm.start, arm.stop)}

    def couple(term: ErrorTerm) -> tuple[int, int] | None:
        own = term.joint - arm.start
        if not 0 <= own < ARM_AXES:
            return None
        if term.kind is TermKind.SCALE:
            return own, own
        return (own, axes[term.by]) if term.kind is TermKind.BY and term.by in axes else None

    pairs = sorted({p for p in map(couple, terms) if p is not None})
    rows = np.zeros((_FIRST + len(pairs) + 6 * PLACES, len(terms)))
    place = _FIRST + len(pairs)
    for k, term in enumerate(terms):
        own, pair, part = term.joint - arm.start, couple(term), term.name.rpartition(".")[2]
        of_arm = 0 <= own < ARM_AXES
        if pair is not None:
            by, other = cell.joints[term.joint], cell.joints[pair[1] + arm.start]
            rows[_FIRST + pairs.index(pair), k] = by.sign * other.sign
            rows[ARM_AXES + own, k] = by.sign * other.offset
        elif term.kind is TermKind.COMPLIANCE and of_arm:
            rows[own, k] = 1.0
        elif term.kind is TermKind.ZERO and of_arm:
            rows[ARM_AXES + own, k] = cell.joints[term.joint].sign
        elif term.kind is TermKind.PLACE and of_arm:
            rows[place + 6 * (own + 1) + PARTS.index(part), k] = 1.0
        elif term.kind is TermKind.PLACE and term.joint < 0:
            frame = (
                _of_floor(cell)[:, PARTS.index(part)] if term.name.startswith("base.") else np.eye(6)[PARTS.index(part)]
            )
            first = place if term.name.startswith("base.") else place + 6 * (PLACES - 1)
            rows[first : first + 6, k] = frame
    return ChainConstants(np.array(pairs, np.int64).reshape(-1, 2), rows, np.asarray(rows.any(axis=0), np.bool_))


def _of_floor(cell: Cell) -> Array:
    """(6, 6): a displacement in `world`, seen from the floor's frame."""
    world_T_next = world_T_floor(cell)
    R, t = world_T_next[:3, :3], world_T_next[:3, 3]
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = R.T
    for k in range(3):
        out[:3, 3 + k] = R.T @ np.cross(np.eye(3)[k], t)
    return out


def reduced_root(root: Array, moved: Array) -> tuple[Array, Array]:
    """(R, K') and (S, K') with nearly the same square as root (R, K) over moved (S, K), m: directions that hardly move the tool
    are left out.
    """
    size = np.ones(len(root) + len(moved))
    size[:ARM_AXES], size[ARM_AXES : len(root)] = _TORQUE * _REACH, _REACH
    left, values, _ = np.linalg.svd(size[:, None] * np.concatenate([root, moved]), full_matrices=False)
    some = values > _SEEN
    both = np.ascontiguousarray(left[:, some] * values[some] / size[:, None])
    return np.ascontiguousarray(both[: len(root)]), both[len(root) :]
