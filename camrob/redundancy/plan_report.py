"""What a plan says of itself: its objective term by term, its bound, and the trade of conditioning against external travel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

if TYPE_CHECKING:  # the planner is loaded where something is planned
    from camrob.redundancy.planning.course import Draft
    from camrob.redundancy.planning.freedoms import PlanSpace
    from camrob.redundancy.planning.objective import Objective
    from camrob.redundancy.planning.waypoints import Waypoints

__all__ = ["ExpectedError", "PlanAccuracy", "PlanBasis", "PlanPoint", "PlanReport"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlanPoint:
    """One point of the curve from still to flowing axes: what it was asked for, and what it gives.

    name: "still", "flowing", or "xW" for external travel at W times the cell's price. inv_kf_mean, inv_kf_min: over what is cut,
    by length; share: mean as a share of the bound's. travel: external axis to rad or m, moved in cutting moves. error: m, the
    rms of the part's expected error, NaN where nobody looked at it.
    """

    name: str
    inv_kf_mean: float
    inv_kf_min: float
    share: float
    travel: Mapping[str, float]
    error: float = float("nan")

    def __post_init__(self) -> None:
        object.__setattr__(self, "travel", MappingProxyType(dict(self.travel)))


@dataclass(frozen=True, slots=True)
class ExpectedError:
    """The part's error that is to be expected of postures along a path: error (N,) m, the root of the expected square at each
    point, length (N,) m that is cut on the way to it, or what of all that is cut the surface left there
    counts for; turns: how often an axis turns round in cuts, of those on which a turn
    leaves a mark.
    """

    error: Array
    length: Array
    turns: Mapping[str, int]

    def __post_init__(self) -> None:
        for name in ("error", "length"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(None,), name=name))
        object.__setattr__(self, "turns", MappingProxyType(dict(self.turns)))

    @property
    def rms(self) -> float:
        """m."""
        return float(np.sqrt(np.average(np.asarray(self.error) ** 2, weights=self._weight)))

    @property
    def p95(self) -> float:
        """m: 95 % of what is cut has no larger one."""
        order = np.argsort(self.error, kind="stable")
        share = np.cumsum(self._weight[order])
        return float(np.asarray(self.error)[order][np.searchsorted(share, 0.95 * share[-1])])

    @property
    def _weight(self) -> Array:
        length = np.asarray(self.length)
        return length if np.any(length > 0.0) else np.ones(len(length))

    def joined(self, other: ExpectedError) -> ExpectedError:
        """This and what follows it."""
        turns = {name: count + other.turns.get(name, 0) for name, count in self.turns.items()}
        return ExpectedError(
            np.concatenate([self.error, other.error]), np.concatenate([self.length, other.length]), turns
        )


@dataclass(frozen=True, slots=True)
class PlanAccuracy:
    """What was gained for the part: what is to be expected of the plan by conditioning, and of the one that looks at its error.

    taken: whether the second is the solution; where it is no better, the first is. best: m, rms of the error at each place's best
    posture of a scan. counted, left_out: which errors that holds, and which it doesn't, in words.
    """

    conditioning: ExpectedError
    accuracy: ExpectedError
    taken: bool
    best: float
    counted: tuple[str, ...]
    left_out: tuple[str, ...]


class PlanBasis(NamedTuple):
    """What a plan's price is reckoned from: W waypoints, its draft, the best 1/k_F (W,) found at each, its objective."""

    space: PlanSpace
    objective: Objective
    w: Waypoints
    draft: Draft
    found: Array


@dataclass(frozen=True, slots=True)
class PlanReport:
    """How a planned solution was chosen.

    chosen: the name of the curve's point that was taken, and `rule` why. bound: (N,) the best 1/k_F that any posture found
    allows at each path point; bound_mean, bound_min: over what is cut, by length. terms: name to price in m (of
    conditioning one), re-postures among them. repostures: how many; retracts: how many of them needed a retract that the path did
    not have. best_error: m, rms of the part's error at each place's best posture of a scan, None of a plan that doesn't look at
    it; accuracy: what looking at it has gained. reached_mean: of 1/k_F, by length as the bound's. seconds: how long the plan was
    to be bettered, None for as long as it takes; missed: points of the curve that there was no time for, and the look for a
    cheaper plan, which counts for one. mended: how often it was made anew because it touched something or could not be followed.
    bases: what its price is reckoned from, one for each stretch between tool changes.
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
    reached_mean: float
    best_error: float | None = None
    accuracy: PlanAccuracy | None = None
    seconds: float | None = None
    missed: int = 0
    mended: int = 0
    bases: tuple[PlanBasis, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bound", locked(self.bound, shape=(None,), name="bound"))
        object.__setattr__(self, "terms", MappingProxyType(dict(self.terms)))

    @property
    def gap(self) -> float:
        """How much of the bound's mean 1/k_F the plan does not reach, as a share of it.

        The bound looks at each place by itself: what no plan can reach for the travel between places is in the gap, too.
        """
        return 1.0 - self.reached_mean / self.bound_mean

    @property
    def shares(self) -> dict[str, float]:
        """Each term's share of the whole price."""
        total = sum(self.terms.values())
        return {name: value / total if total > 0.0 else 0.0 for name, value in self.terms.items()}
