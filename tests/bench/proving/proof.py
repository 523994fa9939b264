"""A bound of 1/k_F along a path that is proved: no posture of the cell, whatever track, table, roll and branch, beats it.

The searched bound (`planning/certificate`) says what was found. Here boxes of the freedoms are refuted, one by one, for all
poses that are cut and between them: in each of a box's postures 1/k_F is below what was found, times 1 + epsilon. Left out, so
that the proof covers more than there is: collisions, the limits of axes 1, 4 and 6, and those of a roll.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.proving.arm_shape import arm_shape
from proving.branch_and_bound import refute
from proving.bundles import bundled, pieces_of

__all__ = ["EPSILON", "Proof", "prove_path"]

Array = NDArray[np.float64]

EPSILON = 0.01
"""By what share of the searched bound the proved one is above it; half of it costs some three times the boxes."""
BOXES = 40_000_000  # looked at, at most: about a quarter of an hour of one core
_LEAST = 1e-3  # rad or m, weighed: half a box below which it is left open
# what a box's width costs its bound, measured: square root of the loss a m2 or rad2
_PRISMATIC, _ROLL, _TURNING = 1.2, 0.6, 0.3


@dataclass(frozen=True, slots=True)
class Proof:
    """What is proved of a path of N points.

    bound (N,): no posture on the way to the point (from the one before) has a higher 1/k_F; NaN where that way doesn't cut.
    share: of what is cut, by length, for which the bound is the searched one times 1 + epsilon; 1 where the proof is whole.
    boxes: looked at.
    """

    bound: Array
    epsilon: float
    share: float
    boxes: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "bound", locked(self.bound, shape=(None,), name="bound"))


def prove_path(
    cell: Cell, path: ToolPathInBase, searched: Array, *, epsilon: float = EPSILON, boxes: int = BOXES
) -> Proof:
    """Prove that no posture along a path has more than (1 + epsilon) times the searched 1/k_F (N,), linear between its points.

    Where more than `boxes` would have to be looked at, or a posture does have more, the bound is what the boxes left open allow.
    Raises CellError for a cell that the enclosures don't cover.
    """
    axes = path.base_T_tip[path.cutting][:, :3, 2]
    shape = arm_shape(cell, axes.sum(axis=0) if len(axes) else np.array([0.0, 0.0, 1.0]))
    pieces = pieces_of(plan_space(cell), path)
    bound = np.full(len(path), np.nan)
    if not len(pieces.point):
        return Proof(bound, epsilon, 1.0, 0)
    before = searched[pieces.point - 1]
    target = (1.0 + epsilon) * (before + pieces.share * (searched[pieces.point] - before))
    bundles, own = bundled(pieces, target)
    weight = np.where(shape.prismatic, _PRISMATIC, _TURNING)
    shown, used = refute(shape, bundles, np.append(weight, _ROLL), _LEAST, boxes)
    left = np.where(shown > bundles.target, shown, 0.0)
    for k, parts in enumerate(bundles.parts):  # parents first: what is open for a bundle is open for its parts
        left[parts[parts >= 0]] = np.maximum(left[parts[parts >= 0]], left[k])
    proved = np.maximum(left[own], target)
    np.fmax.at(bound, pieces.point, proved)
    length = np.linalg.norm(pieces.origin[:, 1] - pieces.origin[:, 0], axis=1) + 1e-12  # that a turn on the spot counts
    return Proof(bound, epsilon, float(np.average(left[own] <= target, weights=length)), int(used))
