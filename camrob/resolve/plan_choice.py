"""Which point of the curve between still and flowing external axes a plan takes, and what each of them gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.resolve.certificate import Certificate
from camrob.resolve.plan_course import Draft, surroundings
from camrob.resolve.plan_objective import Objective, prices
from camrob.resolve.plan_report import TERMS, PlanPoint
from camrob.resolve.plan_samples import Waypoints
from camrob.resolve.plan_space import PlanSpace, conditioning, plan_work

__all__ = ["Choice", "Curve", "chosen_point", "plan_point", "plan_terms"]

Array = NDArray[np.float64]
Curve: TypeAlias = list[tuple[str, Draft]]


class Choice(NamedTuple):
    """The point of the curve that is taken, and the rule that took it."""

    curve_index: int
    rule: str


def plan_point(
    cell: Cell, space: PlanSpace, w: Waypoints, certificate: Certificate, name: str, draft: Draft
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
    )


def chosen_point(points: Sequence[PlanPoint], price: Array, share: float, mode: str) -> Choice:
    """The point that a mode takes; for "knee" by the rule that `planned` writes down. price: (E,) of external travel."""
    if mode != "knee" or len(points) == 1:
        last = len(points) - 1 if mode == "flowing" else 0
        return Choice(
            last, f"{mode} was asked for" if mode != "knee" else "nothing else leads through without a retract"
        )
    good = [k for k in range(len(points)) if points[k].share >= share]
    if not good:
        best = max(range(len(points)), key=lambda k: points[k].share)
        return Choice(best, f"no point of the curve keeps {100.0 * share:g} % of the bound; this one keeps most")

    def paid(k: int) -> tuple[float, float]:
        travel = sum(p * t for p, t in zip(price, points[k].travel.values(), strict=False))
        return travel, -points[k].share

    return Choice(min(good, key=paid), f"the least external travel that keeps {100.0 * share:g} % of the bound")


def plan_terms(space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft) -> dict[str, float]:
    """The objective's terms for a draft, m, re-postures among them."""
    course = surroundings(space, w, draft, 1.0)
    values = prices(
        space, objective, draft.u, np.ascontiguousarray(draft.q), course.weight, course.ds, course.dt, course.travel,
        draft.joined, plan_work(),
    )  # fmt: skip
    terms = dict(zip(TERMS, (float(v) for v in values), strict=True))
    terms["repostures"] = objective.reposture * float(np.sum(~draft.joined[1:]))
    return terms
