"""What the published method weighs the joints by: the cell's fuzzy engines, or other weights in their place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.fuzzy.surfaces import WeightSurface, compile_surface, constant_surface

__all__ = ["Weighting", "condition_threshold", "constant_weights", "engine_weighting", "even_weights"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Weighting:
    """The weights of h_jnt (`joint`) and of h_cond (`condition`); threshold on 1/k_F below which h_cond acts, 0 for never.

    gradient: h_cond leads down the gradient of k_F, not back to the posture recorded at the threshold (eq. 18).
    """

    joint: WeightSurface
    condition: WeightSurface
    threshold: float
    gradient: bool = False


def condition_threshold(cell: Cell) -> float:
    """The cell's threshold on 1/k_F, 0 where its condition term is off."""
    return 0.0 if cell.resolve.condition_term == "off" else cell.resolve.threshold


def engine_weighting(cell: Cell) -> Weighting:
    """The cell's own engines, all joints alike where it has none. Raises CellError."""
    resolve = cell.resolve
    joint, condition = (
        compile_surface(cell, e) if e.file else constant_surface(np.full(len(cell), e.default_weight))
        for e in (resolve.joint_engine, resolve.condition_engine)
    )
    return Weighting(joint, condition, condition_threshold(cell), resolve.condition_term == "gradient")


def even_weights(cell: Cell) -> Weighting:
    """All joints alike, by the default of Table 2."""
    return constant_weights(cell, np.full(len(cell), cell.resolve.joint_engine.default_weight))


def constant_weights(cell: Cell, weights: Array) -> Weighting:
    """Weights (n,) of h_jnt that don't depend on the posture; h_cond's are all alike."""
    even = constant_surface(np.full(len(cell), cell.resolve.joint_engine.default_weight))
    gradient = cell.resolve.condition_term == "gradient"
    return Weighting(constant_surface(weights), even, condition_threshold(cell), gradient)
