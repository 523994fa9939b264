"""One plan of a path: what its waypoints promise, drafts, the curve and the point that is taken, and the solution of it."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.room import Room, rooms
from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.findings import Finding, Severity
from camrob.kinematics.arm import Arm
from camrob.progress import Share
from camrob.redundancy.accuracy.posture_errors import PostureErrors
from camrob.redundancy.clock import Clock
from camrob.redundancy.following.failure import explain_unreached
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import PlanBasis, PlanReport
from camrob.redundancy.planning.certificate import Certificate, Survey, survey_poses
from camrob.redundancy.planning.choice import Choice, CurvePoint, Knee, chosen_point, plan_terms
from camrob.redundancy.planning.course import RETRACT_NEEDED, RETRACT_PRICE, Draft, coarse_index
from camrob.redundancy.planning.curve import SEARCH_FLOWING, STILL, Landscape, landscape, plan_curve
from camrob.redundancy.planning.followed import Followed, follow_plan
from camrob.redundancy.planning.for_accuracy import pushed, weighed
from camrob.redundancy.planning.forbidding import WANTED, Leads, RoomOf
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.objective import Objective, PlanWeights, plan_weights
from camrob.redundancy.planning.scan_batched import Score
from camrob.redundancy.planning.sought import sought
from camrob.redundancy.planning.waypoints import Waypoints, waypoints
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.redundancy.solution import Solution
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["COARSE", "Plan", "Task", "followed_plan", "made_anew", "make_plan", "plan_solution", "with_the_curve"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SPACING = 0.02  # m of s between waypoints
COARSE = 0.1  # m of s between the waypoints that are searched over
_LEAST_REVOLUTE, _LEAST_PRISMATIC = deg_to_rad(5.0), mm_to_m(20.0)  # that an external axis may move in any case


class _Ground(NamedTuple):
    """What all plans of one path stand on."""

    w: Waypoints
    survey: Survey
    certificate: Certificate
    budget: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Task:
    """What all plans of a job share; errors: of the machine, where the plan looks at the part's error; clock: until when a plan
    is bettered; room: the bodies that may not touch; leads: what they have on the ways from and to HOME. asks: whether the search
    asks for the room of its candidates. `grounds`: what has been found out about the paths so far, by their digests.
    """

    cell: Cell
    space: PlanSpace
    mode: str
    score: Score | None
    clock: Clock
    errors: PostureErrors | None = None
    room: Room | None = None
    leads: Leads | None = None
    asks: bool = False
    grounds: dict[str, _Ground] = field(default_factory=dict)

    @property
    def room_of(self) -> RoomOf | None:
        """What a search asks for the room of candidates."""
        room, leads, cell, free = self.room, self.leads, self.cell, self.space.free
        if room is None:
            return None

        def whole(u: Array, q: Array) -> Array:
            out = np.empty((len(u), len(cell)))
            out[:, free], out[:, cell.arm_slice] = u, q
            return out

        def at(u: Array, q: Array) -> Array:
            return np.asarray(rooms(room, whole(u, q), WANTED))

        def led(u: Array, q: Array, last: bool) -> Array:
            return np.full(len(u), WANTED) if leads is None else leads(whole(u, q), last, WANTED)

        return RoomOf(at, led)

    @property
    def at_least(self) -> Task:
        """The same for a plan of one point, to be bettered when it is fit, where there is an end to the time; else as it is."""
        return self if self.clock.seconds is None else replace(self, clock=Clock(0.0))


@dataclass(frozen=True, slots=True)
class Plan:
    """All that a plan was made of. missed: points of the curve that there was no time for; mode: what was asked for;
    best_error: m, the least error of the part that any posture found expects, None where nobody looks at it.
    """

    land: Landscape
    weights: PlanWeights
    curve: tuple[CurvePoint, ...]
    choice: Choice
    missed: int
    mode: str
    best_error: float | None

    @property
    def taken(self) -> CurvePoint:
        """The point of the curve that is taken."""
        return self.curve[self.choice.curve_index]


def make_plan(task: Task, path: ToolPathInBase, objective: Objective, report_share: Share) -> Plan | Ints | None:
    """The plan of a path; the points at which it needs retracts first; None where no candidates lead through.

    Raises JobError for a waypoint that no posture reaches.
    """
    cell, space, mode = task.cell, task.space, task.mode
    weights, best = plan_weights(cell), None
    w, survey, certificate, budget = _ground(task, path, weights, report_share)
    if task.errors is not None:
        w = pushed(w, path, task.errors)
        objective, survey, best = weighed(cell, space, objective, task.errors, weights, w, survey, certificate)
    land = landscape(
        cell,
        space,
        objective,
        w,
        survey,
        certificate,
        coarse_index(w, COARSE),
        still=mode != "flowing",
        flow=mode != "still",
        room_of=task.room_of if task.asks else None,
    )
    still, flowing = drafts = _ends(land, RETRACT_NEEDED if len(objective.blocked) else RETRACT_PRICE)
    report_share(0.4)
    if not any(drafts):
        return None
    if all(d is None or len(land.cuts(d)) for d in drafts):  # not even the best draft goes through in one piece
        return min((land.cuts(d) for d in _ends(land, RETRACT_NEEDED) if d is not None), key=len)
    still, flowing = (None if d is None or len(land.cuts(d)) else d for d in drafts)
    plan = _chosen(task, land, weights, still, flowing, budget, best)
    report_share(0.8)
    return plan


def _chosen(
    task: Task,
    land: Landscape,
    weights: PlanWeights,
    still: Draft | None,
    flowing: Draft | None,
    budget: Mapping[str, float],
    best: float | None,
) -> Plan:
    """The curve between two drafts, as far as there is time for it, and the point of it that is taken."""
    accurate = land.objective.errors.weight > 0.0
    knee = Knee(land.objective.travel, weights.knee_share, budget, accurate) if task.mode == "knee" else None
    curve, missed = plan_curve(land, still, flowing, knee, task.clock)
    choice = chosen_point([p.figures for p in curve], knee, task.mode)
    return Plan(land, weights, tuple(curve), choice, missed, task.mode, best)


def with_the_curve(task: Task, path: ToolPathInBase, plan: Plan) -> Plan:
    """A plan of one point of its path (`Task.at_least`) with the points that there is time for, by what the objective has come to
    forbid.
    """
    land, draft = plan.land, plan.taken.draft
    still = draft if plan.taken.name == STILL else None
    flowing = land.searched(SEARCH_FLOWING) if still is not None else draft
    flowing = None if flowing is None or len(land.cuts(flowing)) else flowing
    return _chosen(task, land, plan.weights, still, flowing, task.grounds[path.digest].budget, plan.best_error)


def made_anew(plan: Plan, objective: Objective) -> Plan | None:
    """The plan with the point that it takes made anew, by what the objective has come to forbid; None where nothing leads
    through that point's candidates in one piece. All that was found out about the path stays.
    """
    land = replace(plan.land, objective=plan.land.objective._replace(blocked=objective.blocked))
    point = land.again(plan.taken)
    if point is None:
        return None
    k = plan.choice.curve_index
    return replace(plan, land=land, curve=(*plan.curve[:k], point, *plan.curve[k + 1 :]))


def _ground(task: Task, path: ToolPathInBase, weights: PlanWeights, report_share: Share) -> _Ground:
    """Waypoints of a path, the survey, the certificate and the budget of travel: once for each path."""
    known = task.grounds.get(path.digest)
    if known is not None:
        return known
    w = waypoints(path, SPACING)
    survey = survey_poses(task.space, w.base_T_tip, task.score)
    report_share(0.1)
    survey, certificate = sought(task.cell, task.space, w.base_T_tip, survey, task.score)
    report_share(0.25)
    if certificate.unreached >= 0:
        raise _unreached(task.cell, path, w, certificate.unreached)
    budget = _budget(task.cell, path, weights) if task.mode == "knee" else {}
    task.grounds[path.digest] = _Ground(w, survey, certificate, budget)
    return task.grounds[path.digest]


def _ends(land: Landscape, retract: float) -> tuple[Draft | None, Draft | None]:
    """The drafts for still and for flowing axes."""
    with ThreadPoolExecutor(1) as pool:  # the search releases the interpreter's lock
        still = pool.submit(land.searched, 1.0, still=True, retract=retract)
        flowing = land.searched(SEARCH_FLOWING, retract=retract)
        return still.result(), flowing


def _budget(cell: Cell, path: ToolPathInBase, weights: PlanWeights) -> dict[str, float]:
    """What each external axis may move in cutting moves at the knee, rad or m; nothing where the published method fails."""
    try:
        q = resolve_vjm(cell, path).q
    except JobError:
        return {}
    moved = np.abs(np.diff(q, axis=0))[path.cutting[1:]].sum(axis=0)
    least = {j.name: _LEAST_PRISMATIC if j.prismatic else _LEAST_REVOLUTE for j in cell.joints}
    return {
        name: max(weights.knee_travel * float(moved[i]), least[name])
        for i, name in enumerate(cell.names)
        if name in cell.external_names
    }


def _unreached(cell: Cell, path: ToolPathInBase, w: Waypoints, k: int) -> JobError:
    """The error for a waypoint that no posture reaches."""
    base_T_target = np.asarray(w.base_T_tip[k])  # frames: target is tip
    return explain_unreached(cell, Arm.of(cell), path, int(w.point[k]), base_T_target)


def followed_plan(task: Task, path: ToolPathInBase, plan: Plan) -> Followed:
    """What the follower makes of the plan."""
    cell = task.cell
    prismatic = np.array([j.prismatic for j in cell.joints])
    margin = np.where(prismatic, mm_to_m(plan.weights.margin_mm), deg_to_rad(plan.weights.margin_deg))
    name, draft = plan.taken.name, plan.taken.draft
    return follow_plan(cell, path, task.space, plan.land.w, draft, still=name == STILL, margin=margin)


def plan_solution(task: Task, path: ToolPathInBase, plan: Plan, followed: Followed) -> Solution:
    """The solution that a plan has become, with its report."""
    land, point = plan.land, plan.taken
    w = land.w
    bound = np.maximum(land.certificate.along(w.s, w.place), followed.inv_kf)
    length = path.weight
    report = PlanReport(
        mode=plan.mode,
        chosen=point.name,
        rule=plan.choice.rule,
        bound=bound,
        bound_mean=float(np.average(bound, weights=length)),
        bound_min=float(bound[length > 0.0].min()),
        reached_mean=float(np.average(followed.inv_kf, weights=length)),
        terms=plan_terms(land.space, land.objective, w, point.draft),
        curve=tuple(p.figures for p in plan.curve),
        repostures=sum(r.by_axes for r in followed.revisions),
        retracts=int(np.sum((path.source < 0) & (path.region >= 0) & path.safe)),
        best_error=plan.best_error,
        seconds=task.clock.seconds,
        missed=plan.missed,
        bases=(PlanBasis(land.space, land.objective, w, point.draft, np.asarray(land.certificate.inv_kf)),),
    )
    findings = (_finding(report, point.figures.share),)
    return Solution(
        "planned", followed.q, followed.inv_kf, task.cell.digest, path.digest, followed.revisions, findings, report
    )


def _finding(report: PlanReport, share: float) -> Finding:
    """The plan in one line."""
    shares = ", ".join(f"{name} {100.0 * value:.1f} %" for name, value in report.shares.items() if value >= 0.0005)
    return Finding(
        "plan",
        f"planned ({report.chosen}): mean 1/k_F is {100.0 * share:.1f} % of its bound; price: {shares}",
        Severity.INFO,
        value=100.0 * share,
        unit="%",
    )
