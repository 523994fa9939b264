"""Plans that are cheaper than the knee's by the whole objective, travel priced in full: candidates for being posted in its place.

The knee goes by the share of the bound that is kept and by travel alone. What travel buys, the whole price says; what a moving
axis costs in feed, it doesn't: its accelerations are priced nowhere. So a cheaper plan is taken only where, by the controller's
model, it loses nothing that the knee's plan has (`loses_nothing`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.choice import Choice, CurvePoint, plan_terms
from camrob.redundancy.planning.course import relaxed
from camrob.redundancy.planning.curve import STILL
from camrob.redundancy.replanning.one_plan import Plan
from camrob.redundancy.solution import Solution

__all__ = ["Run", "RunFigures", "cheaper_plans", "is_worth_it", "loses_nothing", "whole_price"]


class RunFigures(NamedTuple):
    """A solution as the controller runs it: seconds; the share of the cutting on which the programmed feed is held; seconds with
    each cut slowed evenly until it keeps all limits on speed, acceleration and jerk.
    """

    seconds: float
    held: float
    within_limits: float


Run: TypeAlias = Callable[[ToolPathInBase, Solution], RunFigures]

_WORTH = 0.002  # of the price: what is not cheaper by that is no other plan
# and what still external axes are set in motion for: less than that is not what a price is known to
_WORTH_MOVING = 0.01
_LONGER, _LESS_HELD = 0.001, 0.005  # shares that are no loss: what runs that are alike differ by
_LONGER_WITHIN = 0.1  # of time within all limits, which the worst single place of a cut decides
_TWINS = 0.01  # m and rad that freedoms differ by at the most where two plans are one
_TRIALS = 4  # plans that are tried, the cheapest first


def whole_price(plan: Plan, point: CurvePoint) -> float:
    """m, by the whole objective, travel priced in full."""
    land = plan.land
    return sum(plan_terms(land.space, land.objective, land.w, point.draft).values())


def loses_nothing(new: RunFigures, old: RunFigures) -> bool:
    """Whether a run takes no longer than another, holds the feed as well, and has to be slowed no more for the limits."""
    return (
        new.seconds <= (1.0 + _LONGER) * old.seconds
        and new.held >= old.held - _LESS_HELD
        and new.within_limits <= (1.0 + _LONGER_WITHIN) * old.within_limits
    )


def is_worth_it(price: float, known: float, *, moves: bool) -> bool:
    """Whether a plan of a price, m, is so much cheaper than the known one that it is another plan; moves: whether it sets
    external axes in motion that stand still in that one.
    """
    return price < (1.0 - (_WORTH_MOVING if moves else _WORTH)) * known


def cheaper_plans(plan: Plan) -> Iterator[Plan]:
    """The plan with another point taken that is cheaper by the whole price: of its curve, or of three of the curve's points
    refined with travel priced in full. The cheapest first, and of those as cheap the one whose external axes move least, as
    these cost feed.
    """
    known = whole_price(plan, plan.taken)
    points = [*enumerate(plan.curve), *((len(plan.curve), p) for p in _in_full(plan))]
    ranked = [(whole_price(plan, p), k, p) for k, p in points if p is not plan.taken]
    ranked.sort(key=lambda row: (_step(row[0] / known), _travel(plan, row[2]), *row[:2]))
    tried = list[CurvePoint]()
    for price, k, point in ranked:
        if len(tried) == _TRIALS:
            return
        moves = plan.taken.name == STILL and any(point.figures.travel.values())
        if not is_worth_it(price, known, moves=moves):
            continue
        if any(_is_twin(point, other) for other in tried):
            continue
        tried.append(point)
        rule = (
            f"{100.0 * (1.0 - price / known):.1f} % cheaper by the whole objective than the knee's own ({plan.taken.name}), and "
            "by the controller's model no slower, with as much of the feed held"
        )
        curve = plan.curve if k < len(plan.curve) else (*plan.curve, point)
        yield replace(plan, curve=curve, choice=Choice(k, rule))


def _step(share: float) -> int:
    """A price as a share of the known one, in steps within which two are alike."""
    return int(np.floor(np.log(share) / _WORTH))


def _travel(plan: Plan, point: CurvePoint) -> float:
    """m, the price of what a point's external axes move in its cuts."""
    return float(sum(p * t for p, t in zip(plan.land.objective.travel, point.figures.travel.values(), strict=False)))


def _is_twin(one: CurvePoint, other: CurvePoint) -> bool:
    """Whether two points of a curve are one plan, begun from elsewhere: prices that are alike don't make them one."""
    a, b = one.draft, other.draft
    return a.u.shape == b.u.shape and bool(np.abs(a.u - b.u).max() < _TWINS)


def _in_full(plan: Plan) -> list[CurvePoint]:
    """The curve's cheapest searched point, its last one let go and its flowing end, refined with travel priced in full."""
    land, named = plan.land, {p.name.split(",")[0]: p for p in plan.curve if p.name != STILL}
    searched = [n for n in named if n.startswith("x")]
    if searched:
        cheapest = min(searched, key=lambda n: whole_price(plan, named[n]))
        named = {n: p for n, p in named.items() if n == cheapest or n not in searched}

    def refined(point: CurvePoint) -> CurvePoint:
        draft = relaxed(land.space, land.objective, land.w, point.draft, 1.0)
        return land.point(f"{point.name.split(',')[0]}, travel in full", draft, 1.0)

    with ThreadPoolExecutor(2) as pool:  # the kernels release the interpreter's lock
        return list(pool.map(refined, named.values()))
