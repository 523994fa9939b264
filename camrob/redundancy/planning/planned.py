"""Planned postures: external axes, roll and branch chosen over the whole path, certified, and followed by the one tracker.

Waypoints every SPACING metres; a survey and the certificate (`certificate`); candidates and dynamic programming over every
fifth of them (`candidates`, `dynamic_programming`); Newton refinement of all (`refinement`); the tracker with the plan as its
moving reference posture (`followed`). The objective and its units stand in `objective`.

Modes: "still" keeps the external axes exactly still along each region, or along each stretch of it between re-postures;
"flowing" prices their travel at next to nothing; "knee", the default, is taken from the curve between them by this rule.
Budget: each external axis may move `knee_travel` of what the published method moves it on the same path in cutting moves, or
5 degrees or 20 mm where that is more. Of the points within the budget that keep `knee_share` of the bound's mean 1/k_F the
one with the least external travel, by the cell's prices; where none does both, the one within the budget that keeps most:
still axes hold feed and accuracy better than moving ones. Where no point is within the budget, the least travel that keeps
the share, else the point that keeps most. A path that one of the two ends follows without a retract is not cut.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import CellError, JobError
from camrob.findings import Finding, Severity
from camrob.kinematics.arm import Arm
from camrob.progress import Share
from camrob.redundancy.following.failure import explain_failure
from camrob.redundancy.following.follower import FAILED_NOT_REACHED
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import PlanAccuracy, PlanReport
from camrob.redundancy.planning.certificate import Certificate, certify, survey_poses
from camrob.redundancy.planning.choice import Choice, CurvePoint, Knee, chosen_point, plan_terms
from camrob.redundancy.planning.course import RETRACT_NEEDED, RETRACT_PRICE, Draft, coarse_index
from camrob.redundancy.planning.curve import SEARCH_FLOWING, Landscape, landscape, plan_curve
from camrob.redundancy.planning.followed import serve
from camrob.redundancy.planning.for_accuracy import WORTH, expected_error, pushed, weighed
from camrob.redundancy.planning.freedoms import PlanSpace, plan_space
from camrob.redundancy.planning.objective import BLOCKED_REACH, Objective, PlanWeights, plan_weights, posture_features
from camrob.redundancy.planning.posture_errors import PostureErrors
from camrob.redundancy.planning.retracts import with_retracts
from camrob.redundancy.planning.scan_batched import Score
from camrob.redundancy.planning.waypoints import Waypoints, waypoints
from camrob.redundancy.published.virtual_joint import PathTracker, resolve_vjm
from camrob.redundancy.published.weighting import even_weights
from camrob.redundancy.solution import Solution
from camrob.units import deg_to_rad, m_to_mm, mm_to_m

__all__ = ["MODES", "resolve_planned"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

Obstacles: TypeAlias = Callable[[ToolPathInBase, Solution], NDArray[np.bool_]]

MODES = ("knee", "still", "flowing")
SPACING = 0.02  # m of s between waypoints
COARSE = 0.1  # m of s between the waypoints that are searched over
CLEARANCE = 0.05  # m that a retract goes above all that the path passes
_AVOIDINGS = 3  # further plans that keep clear of what the one before touched
_BLOCKED = 24  # postures that stand for all that touch
_LEAST_REVOLUTE, _LEAST_PRISMATIC = deg_to_rad(5.0), mm_to_m(20.0)  # that an external axis may move in any case
_ROUNDS = 3  # plans that are made anew because a retract was put in


def resolve_planned(
    cell: Cell,
    path: ToolPathInBase,
    *,
    mode: str = "knee",
    obstacles: Obstacles | None = None,
    score: Score | None = None,
    errors: PostureErrors | None = None,
    progress: Share | None = None,
) -> Solution:
    """Postures along a path, planned (see the module); `mode` is one of MODES.

    obstacles(path, solution) says at which points (N,) a solution touches something: what it names is kept clear of in
    up to three further plans (a solution that still touches is returned; whoever checks it, finds it).
    score: 1/k_F of batches of arm postures, for the certificate's scan (`scan_batched`); None: the compiled kernels.
    errors: what is known of the machine's errors: the part's expected error then stands in the objective with the weight
    `accuracy` of the cell (FOR_ACCURACY where that is 0), and the plan is returned only where it expects WORTH times the error of
    the one by conditioning or less; the report says what both expect.
    Where the path can't be followed without a re-posture and has no safe point for one, retracts are put in: the
    solution then belongs to `Solution.path`. An arm without closed form, and a path for which no plan is found, is left to
    the published method, with a finding that says so.
    Raises UnreachableError, LimitError or SingularError with line, region, axis and distance; ValueError for another mode.
    """
    if mode not in MODES:
        raise ValueError(f"mode is {mode!r}, expected one of {', '.join(MODES)}")
    told = _rising(progress)
    try:
        space = plan_space(cell)
    except CellError as error:
        return _published(cell, path, f"{error.what}", told)
    if not len(space.free):
        return _published(cell, path, f"cell {cell.name} has no spare freedom to plan", told)
    task = _Task(cell, space, mode, score)
    solution = _clear(task, path, obstacles, told)
    if errors is not None and solution.method == "planned":
        solution = _for_accuracy(
            task, path, solution, _clear(replace(task, errors=errors), path, obstacles, told), errors
        )
    told(1.0)
    return solution


@dataclass(frozen=True, slots=True)
class _Task:
    """What all plans of a job share; errors: of the machine, where the plan looks at the part's error."""

    cell: Cell
    space: PlanSpace
    mode: str
    score: Score | None
    errors: PostureErrors | None = None


def _clear(task: _Task, path: ToolPathInBase, obstacles: Obstacles | None, told: Share) -> Solution:
    """The solution of a plan that keeps clear of what the ones before it touched."""
    cell = task.cell
    objective = Objective.of(cell, task.space, plan_weights(cell))
    for again in range(_AVOIDINGS + 1):
        solution = _resolved(task, path, objective, told)
        touching = _touching(cell, objective, solution.path or path, solution, obstacles)
        if len(touching) == 0 or again == _AVOIDINGS or solution.method != "planned":
            break
        objective = objective._replace(blocked=np.concatenate([objective.blocked, touching]))
    return solution


def _for_accuracy(
    task: _Task, path: ToolPathInBase, plain: Solution, ours: Solution, errors: PostureErrors
) -> Solution:
    """The one of two plans that expects less error of the part, told what both expect."""
    before = expected_error(task.cell, errors, plain.path or path, plain)
    reached = None if ours.plan is None else ours.plan.best_error
    after = before if reached is None else expected_error(task.cell, errors, ours.path or path, ours)
    taken = after.rms < WORTH * before.rms
    solution = ours if taken else plain
    if solution.plan is None:
        return solution
    best = min(before.rms if reached is None else reached, before.rms, after.rms)
    told = PlanAccuracy(before, after, taken, best, errors.counted, errors.left_out)
    return replace(
        solution, plan=replace(solution.plan, accuracy=told), findings=(*solution.findings, _accuracy_finding(told))
    )


def _accuracy_finding(told: PlanAccuracy) -> Finding:
    """What is gained for the part, in one line."""
    before, after = told.conditioning, told.accuracy
    text = (
        f"expected error of the part {m_to_mm(after.rms):.3f} mm rms ({m_to_mm(after.p95):.3f} mm on 95 %), "
        f"{m_to_mm(before.rms):.3f} mm ({m_to_mm(before.p95):.3f} mm) in the plan by conditioning"
    )
    kept = "" if told.taken else "; that one is kept, as the other is no better"
    return Finding("plan-accuracy", text + kept, Severity.INFO, value=m_to_mm(after.rms), unit="mm")


def _rising(progress: Share | None) -> Share:
    """Progress that never falls back, however often a plan is made anew."""
    highest = [0.0]

    def told(share: float) -> None:
        if progress is not None and share > highest[0]:
            highest[0] = share
            progress(share)

    return told


def _touching(
    cell: Cell, objective: Objective, path: ToolPathInBase, solution: Solution, obstacles: Obstacles | None
) -> Array:
    """Features (K, 7) of a few of the arm's postures that stand for all that touch something."""
    chosen: list[Array] = []
    if obstacles is not None:
        hit = np.flatnonzero(obstacles(path, solution))
        for q in solution.q[np.unique(np.concatenate([hit, np.maximum(hit - 1, 0)]))][:, cell.arm_slice]:
            feature = posture_features(objective.wrist_zero, np.ascontiguousarray(q))
            apart = all(np.linalg.norm(feature - other) > 0.5 * BLOCKED_REACH for other in chosen)
            if apart and len(chosen) < _BLOCKED:
                chosen.append(feature)
    return np.array(chosen).reshape(-1, 7)


def _resolved(
    task: _Task,
    path: ToolPathInBase,
    objective: Objective,
    told: Share,
) -> Solution:
    """The solution of one plan, with retracts put in where it needs them."""
    cell = task.cell
    given, plan = path, _plan(task, path, objective, told)
    for _round in range(_ROUNDS):
        if isinstance(plan, np.ndarray):
            path = with_retracts(path, plan, CLEARANCE)
            plan = _plan(task, path, objective, told)
    if not isinstance(plan, _Plan):
        return _published(cell, given, "no candidate postures lead through the whole path", told)
    try:
        solution = _served(cell, path, plan, told)
    except JobError as error:
        return _published(cell, given, f"the tracker could not follow the plan ({error.what})", told)
    return (
        solution
        if path is given
        else replace(solution, path=path, findings=(*solution.findings, *_retracts(path, solution)))
    )


@dataclass(frozen=True, slots=True)
class _Plan:
    """All that a plan was made of."""

    space: PlanSpace
    objective: Objective
    weights: PlanWeights
    w: Waypoints
    certificate: Certificate
    curve: list[CurvePoint]
    choice: Choice
    mode: str
    best_error: float | None


def _plan(
    task: _Task,
    path: ToolPathInBase,
    objective: Objective,
    told: Share,
) -> _Plan | Ints | None:
    """The plan of a path; the points at which it needs retracts first; None where no candidates lead through."""
    cell, space, mode = task.cell, task.space, task.mode
    weights, best = plan_weights(cell), None
    w = waypoints(path, SPACING)
    survey = survey_poses(space, w.base_T_tip, task.score)
    told(0.1)
    certificate = certify(space, w.base_T_tip, survey)
    told(0.25)
    if np.any(certificate.inv_kf <= 0.0):
        raise _unreached(cell, path, w, int(np.argmin(certificate.inv_kf)))
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
    )
    touched = len(objective.blocked) > 0
    still, flowing = drafts = _ends(land, RETRACT_NEEDED if touched else RETRACT_PRICE)
    told(0.4)
    if not any(drafts):
        return None
    if all(d is None or len(land.cuts(d)) for d in drafts):  # not even the best draft goes through in one piece
        return min((land.cuts(d) for d in _ends(land, RETRACT_NEEDED) if d is not None), key=len)
    still, flowing = (None if d is None or len(land.cuts(d)) else d for d in drafts)
    accurate = objective.errors.weight > 0.0
    budget = _budget(cell, path, weights) if mode == "knee" else {}
    knee = Knee(objective.travel, weights.knee_share, budget, accurate) if mode == "knee" else None
    curve = plan_curve(land, still, flowing, knee)
    told(0.8)
    choice = chosen_point([p.told for p in curve], knee, mode)
    return _Plan(space, objective, weights, w, certificate, curve, choice, mode, best)


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
    point = int(w.point[k])
    state = PathTracker(cell, path, weighting=even_weights(cell)).home()
    base_T_target = np.asarray(w.base_T_tip[k])  # frames: target is tip
    return explain_failure(cell, Arm.of(cell), path, point, base_T_target, FAILED_NOT_REACHED, state)


def _served(cell: Cell, path: ToolPathInBase, plan: _Plan, told: Share) -> Solution:
    """The solution that the tracker makes of the plan. Raises JobError where it can't follow it."""
    name, draft, point = plan.curve[plan.choice.curve_index]
    prismatic = np.array([j.prismatic for j in cell.joints])
    margin = np.where(prismatic, mm_to_m(plan.weights.margin_mm), deg_to_rad(plan.weights.margin_deg))
    served = serve(cell, path, plan.space, plan.w, draft, still=name == "still", margin=margin)
    told(0.95)
    w = plan.w
    bound = np.maximum(plan.certificate.along(w.s, w.place), served.inv_kf)
    length = np.diff(path.length, prepend=0.0) * path.cutting
    if not np.any(length > 0.0):
        length = np.ones(len(path))
    report = PlanReport(
        mode=plan.mode,
        chosen=name,
        rule=plan.choice.rule,
        bound=bound,
        bound_mean=float(np.average(bound, weights=length)),
        bound_min=float(bound[length > 0.0].min()),
        terms=plan_terms(plan.space, plan.objective, w, draft),
        curve=tuple(p.told for p in plan.curve),
        repostures=sum(r.by_axes for r in served.revisions),
        retracts=int(np.sum((path.source < 0) & (path.region >= 0) & path.safe)),
        best_error=plan.best_error,
    )
    findings = (_finding(report, point.share),)
    return Solution("planned", served.q, served.inv_kf, cell.digest, path.digest, served.revisions, findings, report)


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


def _retracts(path: ToolPathInBase, solution: Solution) -> list[Finding]:
    """A finding for each retract that was put in, with its reason."""
    why = {r.point: r.reason for r in solution.revisions if r.kept}
    own = np.flatnonzero((path.source < 0) & (path.region >= 0) & path.safe)
    return [
        Finding(
            "retract-inserted",
            "the path can't be followed in one posture: the tool is retracted here, the arm re-postured, and cutting goes on"
            + (f"; {why[int(k)]}" if int(k) in why else ""),
            Severity.WARNING,
            line=int(path.line[k]),
            region=int(path.region[k]),
            point=int(k),
        )
        for k in own
    ]


def _published(cell: Cell, path: ToolPathInBase, why: str, told: Share) -> Solution:
    """The published method in the planner's place. Raises JobError where it fails too, which then says why there is no plan."""
    try:
        solution = resolve_vjm(cell, path, progress=told)
    except JobError as error:
        error.what = f"{error.what} (by the published method; there is no plan: {why})"
        raise
    note = Finding("plan-fell-back", f"postures follow the published method, not a plan: {why}", Severity.WARNING)
    return replace(solution, findings=(*solution.findings, note))
