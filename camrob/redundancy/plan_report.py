"""What a plan says of itself: its objective term by term, its bound, and the trade of conditioning against external travel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["TERMS", "PlanPoint", "PlanReport"]

Array = NDArray[np.float64]

TERMS = ("conditioning", "margins", "travel", "smoothness", "speed", "arm_steps")
"""Names of the objective's terms, in the order of `plan_objective.prices`."""


@dataclass(frozen=True, slots=True)
class PlanPoint:
    """One point of the curve from still to flowing axes: what it was asked for, and what it gives.

    name: "still", "flowing", or "xW" for external travel at W times the cell's price. inv_kf_mean, inv_kf_min: over what is cut,
    by length; share: mean as a share of the bound's. travel: external axis to rad or m, moved in cutting moves.
    """

    name: str
    inv_kf_mean: float
    inv_kf_min: float
    share: float
    travel: Mapping[str, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "travel", MappingProxyType(dict(self.travel)))


@dataclass(frozen=True, slots=True)
class PlanReport:
    """How a planned solution was chosen.

    chosen: the name of the curve's point that was taken, and `rule` why. bound: (N,) the best 1/k_F that any posture found
    allows at each path point; bound_mean, bound_min: over what is cut, by length. terms: name to price in m (of
    conditioning one), re-postures among them. repostures: how many; retracts: how many of them needed a retract that the path did
    not have.
    """

    mode: str
    chosen: str
    rule: str
    bound: Array
    bound_mean: float
    bound_min: float
    terms: Mapping[str, float]
    curve: tuple[PlanPoint, ...]
    repostures: int
    retracts: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "bound", locked(self.bound, shape=(None,), name="bound"))
        object.__setattr__(self, "terms", MappingProxyType(dict(self.terms)))

    @property
    def shares(self) -> dict[str, float]:
        """Each term's share of the whole price."""
        total = sum(self.terms.values())
        return {name: value / total if total > 0.0 else 0.0 for name, value in self.terms.items()}
