"""Which point of the curve between still and flowing external axes a plan takes, and what each of them gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.accuracy.part_error import expected_squares
from camrob.redundancy.plan_report import PlanPoint
from camrob.redundancy.planning.certificate import Certificate
from camrob.redundancy.planning.course import Draft, draft_terms
from camrob.redundancy.planning.freedoms import PlanSpace, conditioning, plan_work
from camrob.redundancy.planning.objective import Objective
from camrob.redundancy.planning.waypoints import Waypoints

__all__ = ["Choice", "CurvePoint", "Knee", "chosen_point", "plan_point", "plan_terms"]

Array = NDArray[np.float64]


class Choice(NamedTuple):
    """The point of the curve that is taken, and the rule that took it."""

    curve_index: int
    rule: str


class CurvePoint(NamedTuple):
    """A point of the curve: its name, its plan, what the plan gives, and the share of the price of travel that it pays."""

    name: str
    draft: Draft
    figures: PlanPoint
    travel: float


@dataclass(frozen=True, slots=True)
class Knee:
    """What the knee is measured by.

    price (F,): of external travel, m a rad or m; share: of the bound's mean 1/k_F that it shall keep; budget: external axis
    to the most that it shall move in cutting moves, rad or m; where an axis has none it may move as it likes. accurate: the least
    error of the part is looked for, instead of a share of the bound.
    """

    price: Array
    share: float
    budget: Mapping[str, float]
    accurate: bool = False

    def keeps(self, point: PlanPoint) -> bool:
        """Whether a point keeps the share of the bound."""
        return point.share >= self.share

    def within(self, point: PlanPoint) -> bool:
        """Whether every external axis moves within its budget."""
        return all(point.travel.get(name, 0.0) <= most for name, most in self.budget.items())

    def between(self, points: Sequence[CurvePoint]) -> int | None:
        """The point behind which, up to the next, the one that is taken may lie; points go from still to flowing."""
        if self.accurate:
            return None
        both = any(self.keeps(p.figures) and self.within(p.figures) for p in points)
        marks = [self.keeps(p.figures) if both else not self.within(p.figures) for p in points]
        return next((k for k in range(len(marks) - 1) if not marks[k] and marks[k + 1]), None)

    def take(self, points: Sequence[PlanPoint]) -> Choice:
        """The point that the rule written down in `planned` takes."""

        def paid(k: int) -> tuple[float, float]:
            travel = sum(p * t for p, t in zip(self.price, points[k].travel.values(), strict=False))
            return travel, -points[k].share

        if self.accurate:
            return self._most_accurate(points)
        if not points[0].travel:
            best = max(range(len(points)), key=lambda k: points[k].share)
            return Choice(
                best, "the best conditioned; the cell has no external axis, and roll and posture are all that is free"
            )
        percent = f"{100.0 * self.share:g} %"
        good = [k for k, p in enumerate(points) if self.keeps(p)]
        cheap = [k for k, p in enumerate(points) if self.within(p)]
        if set(good) & set(cheap):
            best = min(set(good) & set(cheap), key=paid)
            return Choice(best, f"the least external travel that keeps {percent} of the bound")
        if cheap:
            best = max(cheap, key=lambda k: (points[k].share, -paid(k)[0]))
            return Choice(
                best, f"the best that the budget of external travel allows; it does not buy {percent} of the bound"
            )
        if good:
            return Choice(
                min(good, key=paid), f"the least external travel that keeps {percent} of the bound, above its budget"
            )
        best = max(range(len(points)), key=lambda k: points[k].share)
        return Choice(best, f"no point of the curve keeps {percent} of the bound; this one keeps most")

    def _most_accurate(self, points: Sequence[PlanPoint]) -> Choice:
        cheap = [k for k, p in enumerate(points) if self.within(p)]
        best = min(cheap or range(len(points)), key=lambda k: points[k].error)
        beyond = "that the budget of external travel allows" if cheap else "of all, above the budget of external travel"
        return Choice(best, f"the least expected error of the part {beyond}")


def plan_point(
    cell: Cell, space: PlanSpace, objective: Objective, w: Waypoints, certificate: Certificate, name: str, draft: Draft
) -> PlanPoint:
    """What a draft gives over what is cut."""
    at = draft.index
    cut = np.array(w.cut)[at]
    doubled = np.append(~draft.joined[1:], False)
    cut[doubled] = 0.0
    if not np.any(cut > 0.0):
        cut = np.ones(len(at))
    work = plan_work()
    value = np.array([conditioning(space, q, work) for q in np.ascontiguousarray(draft.q)])
    bound = np.maximum(certificate.inv_kf[at], value)
    moved = np.abs(np.diff(draft.u, axis=0, prepend=draft.u[:1]))[draft.joined & w.cutting[at]]
    names = [cell.names[i] for i in space.free[: len(space.free) - space.roll]]
    return PlanPoint(
        name,
        float(np.average(value, weights=cut)),
        float(value[cut > 0.0].min()),
        float(np.average(value, weights=cut) / np.average(bound, weights=cut)),
        {n: float(moved[:, i].sum()) for i, n in enumerate(names)},
        _error(objective, w, draft, cut),
    )


def _error(objective: Objective, w: Waypoints, draft: Draft, cut: Array) -> float:
    """m, rms of the part's expected error in a draft, weighted by what is cut (K,); NaN where nobody looks at it."""
    if objective.errors.weight == 0.0:
        return float("nan")
    square, _levers = expected_squares(objective.errors, draft.u, np.ascontiguousarray(draft.q), w.pushes(draft.index))
    return float(np.sqrt(np.average(square, weights=cut)))


def chosen_point(points: Sequence[PlanPoint], knee: Knee | None, mode: str) -> Choice:
    """The point that a mode takes: an end of the curve, or the knee."""
    if knee is not None and len(points) > 1:
        return knee.take(points)
    last = len(points) - 1 if mode == "flowing" else 0
    rule = "nothing else leads through without a retract" if mode == "knee" else f"{mode} was asked for"
    return Choice(last, rule)


def plan_terms(space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft) -> dict[str, float]:
    """The objective's terms for a draft, m, re-postures among them."""
    repostures = objective.reposture * float(np.sum(~draft.joined[1:]))
    return draft_terms(space, objective, w, draft) | {"repostures": repostures}
