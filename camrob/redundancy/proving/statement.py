"""What a bound is proved of: the waypoints of a plan, what each of their metres and moves costs, and how dear a place may be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.plan_report import PlanBasis
from camrob.redundancy.planning.choice import plan_terms
from camrob.redundancy.planning.course import Draft, moves_along, waypoint_weights
from camrob.redundancy.planning.freedoms import PlanSpace, conditioning, plan_work
from camrob.redundancy.planning.objective import Objective, motion_price
from camrob.redundancy.planning.waypoints import Waypoints

__all__ = ["LEFT_OUT", "Statement", "dearest", "price_of", "statement_of", "worth_telling_apart"]

Array = NDArray[np.float64]

LEFT_OUT = (
    "collisions",
    "limits of axes 1, 4 and 6 and of the roll",
    "margins to limits",
    "the part's error",
    "what the motion of roll and arm costs",
    "what lies between waypoints",
)
"""What a bound doesn't count: it holds for more plans than there are, and for lower prices."""
_LEAST_VALUE = 0.02  # 1/k_F below which no posture gets dearer, as `objective.posture_price` has it
# times the best found at the place and the plan's own price: dearer postures are passed over; at 1.15 and 1.05 the engraving's
# bound is 3.6 % lower, higher was not tried
_ABOVE_BEST, _ABOVE_PLAN = 1.3, 1.15


class Statement(NamedTuple):
    """W waypoints: tip, axis (W, 3) of the tool in `base`; weight (W,) m that each counts for; leap (W,): price of a re-posture
    there, inf where there is none. The move to each costs rate |d| + square d^2 + haste (|d| / top - 1)+^2 of the external axes'
    d: rate, square, top (W, E), haste (W,). most (W,): price of a metre above which it doesn't matter how dear a place is.
    """

    tip: Array
    axis: Array
    weight: Array
    leap: Array
    rate: Array
    square: Array
    top: Array
    haste: Array
    most: Array

    def between(self, begin: int, end: int) -> Statement:
        """The waypoints from `begin` to before `end`."""
        return Statement(*(np.ascontiguousarray(column[begin:end]) for column in self))


def dearest(objective: Objective) -> float:
    """The price of a metre for its conditioning alone in the worst of postures."""
    return float(objective.conditioning * (objective.threshold / _LEAST_VALUE) ** objective.power)


def statement_of(space: PlanSpace, objective: Objective, w: Waypoints, most: Array) -> Statement:
    """The statement about all plans through waypoints; most (W,): see `Statement`."""
    motion = motion_price(objective, moves_along(w, np.arange(len(w))), "travel", "smoothness", "speed")
    external, frames = len(space.free) - space.roll, np.asarray(w.base_T_tip)
    return Statement(
        np.ascontiguousarray(frames[:, :3, 3]),
        np.ascontiguousarray(frames[:, :3, 2]),
        waypoint_weights(w),
        np.where(w.safe, objective.reposture, np.inf),
        np.ascontiguousarray(motion.rate[:, :external]),
        np.ascontiguousarray(motion.square[:, :external]),
        np.ascontiguousarray(motion.top[:, :external]),
        motion.haste,
        np.minimum(most, dearest(objective)),
    )


def price_of(basis: PlanBasis, draft: Draft, begin: int = 0, end: int | None = None) -> float:
    """m, of a draft from waypoint `begin` to before `end`: the sum of its terms, without the moves to and from elsewhere."""
    own = np.flatnonzero((draft.index >= begin) & (draft.index < (len(basis.w) if end is None else end)))
    part = Draft(
        draft.index[own],
        draft.u[own],
        draft.q[own],
        draft.branch[own],
        draft.joined[own],
        draft.rigid[own],
        draft.price,
    )
    return float(sum(plan_terms(basis.space, basis.objective, basis.w, part).values()))


def worth_telling_apart(basis: PlanBasis) -> Array:
    """(W,) prices of a metre above which postures are passed over: where to look, by the plan and the searched bound."""
    objective, work = basis.objective, plan_work()
    values = np.array([conditioning(basis.space, q, work) for q in np.ascontiguousarray(basis.draft.q)])
    own = np.zeros(len(basis.w))
    np.maximum.at(own, basis.draft.index, (objective.threshold / values) ** objective.power)
    found = (objective.threshold / np.asarray(basis.found)) ** objective.power
    return np.asarray(objective.conditioning * np.maximum(_ABOVE_BEST * found, _ABOVE_PLAN * own))
