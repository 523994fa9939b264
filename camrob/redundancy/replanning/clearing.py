"""A plan that touches something, or that the follower can't follow, made anew there: its search goes on and is not thrown away.

What touches is forbidden in the lattice where it touches (`forbidding`); the point of the curve that was taken is searched
for and refined anew on the same lattice, and followed; and so on, _ROUNDS times at most. Where nothing leads through any more
the whole curve is made anew, with a retract where there has to be one. Where that is not enough either, the other points of
the first curve are tried, those first that are nearest to the one that was taken. A plan that is not fit when its time is over
gives way to the published method's postures (`hurried`); so where there is an end to the time, one point of the curve is made fit
first, and the others are looked for in what is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.errors import JobError
from camrob.findings import Finding, Severity
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.choice import Choice
from camrob.redundancy.planning.forbidding import FEATURES, marks
from camrob.redundancy.planning.objective import Objective, plan_weights
from camrob.redundancy.planning.retracts import with_retracts
from camrob.redundancy.planning.waypoints import waypoints
from camrob.redundancy.replanning.all_touch import all_touch
from camrob.redundancy.replanning.bettered import Run, RunFigures, cheaper_plans, loses_nothing, whole_price
from camrob.redundancy.replanning.hurried import held_to_published, out_of_time, published
from camrob.redundancy.replanning.idle_retracts import (
    Obstacles,
    retracted_for_nothing,
    told_retracts,
    without_idle_retracts,
)
from camrob.redundancy.replanning.one_plan import (
    COARSE,
    Plan,
    Task,
    followed_plan,
    made_anew,
    make_plan,
    plan_solution,
    with_the_curve,
)
from camrob.redundancy.solution import Solution

__all__ = ["Obstacles", "cleared"]

Array = NDArray[np.float64]
_Planned: TypeAlias = "tuple[ToolPathInBase, Plan, _Mended]"

CLEARANCE = 0.05  # m that a retract goes above all that the path passes
_ROUNDS = 8  # plans made anew: a touch that moves on is followed that often
_BETTER_ROUNDS = 3  # and of a plan that is only cheaper than one that is fit
_CUTS = 3  # plans that are made anew because a retract was put in


@dataclass(frozen=True, slots=True)
class _Found:
    """What came of a plan of a path: its solution (None where it could not be followed, and why), and what is to be forbidden,
    postures (K, 6) of the arm at points (K,) of the path. hit: points that touch, count: how many there are, or 1 where it could
    not be followed. low: points at which it goes from one posture to another by axis values, the tool swung any way, with the
    tool not clear of the part.
    """

    path: ToolPathInBase
    solution: Solution | None
    why: JobError | None
    q: Array
    point: NDArray[np.int64]
    count: int
    low: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    hit: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def fit(self) -> bool:
        """Whether it can be followed, and nothing stands against it."""
        return self.solution is not None and not len(self.point) and not len(self.low)

    @property
    def trouble(self) -> str:
        """What stands against it, in words."""
        if self.solution is None:
            return "could not be followed" + (f" ({self.why.what})" if self.why is not None else "")
        told = [
            f"{what} at {count} point{'s' * (count > 1)}"
            for what, count in (("touched something", self.count), ("changed posture too near the part", len(self.low)))
            if count
        ]
        return " and ".join(told)


def cleared(
    task: Task, given: ToolPathInBase, obstacles: Obstacles | None, report_share: Share, run: Run | None = None
) -> Solution:
    """The solution of a plan that touches nothing and can be followed, or says what it gave up for that, without retracts that
    it does nothing on.

    run: how the controller runs a solution; with it, a plan cheaper than the knee's that loses nothing is taken (`bettered`).
    One that still touches is returned as it is (whoever checks it, finds it); where there is no plan, the published method's.
    Raises JobError for a point that no posture reaches, or where the published method fails too.
    """
    solution = _cleared(task, given, obstacles, report_share, run)
    return without_idle_retracts(task.cell, given, solution, CLEARANCE, obstacles)


def _cleared(
    task: Task, given: ToolPathInBase, obstacles: Obstacles | None, report_share: Share, run: Run | None
) -> Solution:
    path, plan = _with_cuts(task, given, given, _objective(task), report_share, np.zeros((0, FEATURES + 2)))
    if plan is None:
        return published(task.cell, given, "no candidate postures lead through the whole path", report_share)
    mended = _mended(task, given, path, plan, obstacles, report_share, _ROUNDS)
    if mended.hopeless is not None and mended.found.solution is not None:
        touching = mended.found.solution
        return replace(touching, findings=(*touching.findings, mended.hopeless), path=None if path is given else path)
    if mended.solution is None and mended.found.count and task.room is not None and not task.clock.up:
        path, plan, mended = _led_round(replace(task, asks=True), given, obstacles, report_share) or (
            path,
            plan,
            mended,
        )
    timed = task.clock.seconds is not None and task.mode == "knee"
    if mended.solution is None and task.clock.up:
        return out_of_time(task, given, mended.found.trouble, report_share)
    if mended.solution is None:
        plan = with_the_curve(task, path, plan) if timed else plan
        return _another(task, given, path, plan, mended.found, obstacles, report_share)
    if timed and not task.clock.up:
        mended = _bettered(task, given, mended, obstacles, report_share)
    if run is not None and mended.plan.mode == "knee" and task.errors is None:
        mended = _cheapest(task, given, mended, obstacles, run, report_share)
    return held_to_published(task, given, mended.reported(given))


def _led_round(task: Task, given: ToolPathInBase, obstacles: Obstacles | None, report_share: Share) -> _Planned | None:
    """A path, its plan and what came of it, searched round all candidates that touch something, where mending in places doesn't
    lead out; None where that does not do either.
    """
    path, plan = _with_cuts(task, given, given, _objective(task), report_share, np.zeros((0, FEATURES + 2)))
    mended = None if plan is None else _mended(task, given, path, plan, obstacles, report_share, _ROUNDS)
    return None if plan is None or mended is None or mended.solution is None else (path, plan, mended)


def _objective(task: Task) -> Objective:
    return Objective.of(task.cell, task.space, plan_weights(task.cell))


def _mended(
    task: Task,
    given: ToolPathInBase,
    path: ToolPathInBase,
    plan: Plan,
    obstacles: Obstacles | None,
    report_share: Share,
    rounds: int,
    known: _Mended | None = None,
) -> _Mended:
    """A plan of a path, made anew where it touches something or can't be followed, `rounds` times at most. known: what another
    plan of the path has found.
    """
    objective, whole, start = _objective(task), 0, given if known is None else path
    forbidden = np.zeros((0, FEATURES + 2)) if known is None else known.forbidden
    lines, count = list[int](), 0
    for again in range(rounds + 1):
        found = _looked_at(task, path, plan, obstacles)
        report_share(0.95)
        if found.fit:
            return _Mended(plan, found, found.solution, again, whole, tuple(lines), count, forbidden)
        if again == rounds or task.clock.up or not len(found.point) + len(found.low):
            break
        if task.leads is not None and not task.asks and len(found.hit) and np.isin(found.hit, (0, len(path) - 1)).all():
            break  # on a way from or to HOME, which a mark knows nothing of: the search that asks does
        hopeless = all_touch(task, plan, path, found.hit) if again == 0 else None
        if hopeless is not None:
            return _Mended(plan, found, None, again, whole, (), found.count, forbidden, hopeless)
        lines += [int(v) for v in path.line[np.append(found.point, found.low)]]
        count += found.count + len(found.low)
        forbidden = np.concatenate([forbidden, _marks(given, path, objective, found)])
        objective, anew = objective._replace(blocked=_placed(forbidden, given, path)), None
        if len(found.point):
            anew = made_anew(plan, objective)
        else:  # nothing else stands against it
            start = with_retracts(path, found.low, CLEARANCE)
        if anew is None:
            whole += 1
            path, anew = _with_cuts(task, given, start, objective, report_share, forbidden)
        if anew is None:
            break
        plan = anew
    return _Mended(plan, found, None, again, whole, tuple(lines), count, forbidden)


def _bettered(
    task: Task, given: ToolPathInBase, fit: _Mended, obstacles: Obstacles | None, report_share: Share
) -> _Mended:
    """A plan of one point that is fit, bettered in the time that is left: the point of its whole curve that is taken, where that
    is made fit in time; else the plan as it is.
    """
    path = fit.found.path
    plan = with_the_curve(task, path, fit.plan)
    if plan.taken.name != fit.plan.taken.name:
        better = _mended(task, given, path, plan, obstacles, report_share, _ROUNDS, fit)
        if better.solution is None:
            return fit
        again, whole = fit.again + better.again, fit.whole + better.whole
        return replace(better, again=again, whole=whole, lines=fit.lines + better.lines, count=fit.count + better.count)
    k = plan.choice.curve_index
    return fit.told(replace(plan, curve=(*plan.curve[:k], fit.plan.taken, *plan.curve[k + 1 :])), plan.missed)


def _cheapest(
    task: Task, given: ToolPathInBase, knee: _Mended, obstacles: Obstacles | None, run: Run, report_share: Share
) -> _Mended:
    """The first of the plans that are cheaper than the knee's by the whole objective that loses nothing as it is run; else the
    knee's.
    """
    path, known = knee.found.path, knee.solution
    if known is None:
        return knee
    if task.clock.up:
        return knee.hurried()
    as_it_is: RunFigures | None = None
    for plan in cheaper_plans(knee.plan):
        if task.clock.up:
            return knee.hurried()
        followed = followed_plan(task, path, plan)
        if followed.stuck >= 0:
            continue
        as_it_is = as_it_is or run(path, known)
        if not loses_nothing(run(path, plan_solution(task, path, plan, followed)), as_it_is):
            continue
        new = _mended(task, given, path, plan, obstacles, report_share, _BETTER_ROUNDS)
        if new.solution is None or new.whole or retracted_for_nothing(path, new.solution):
            continue
        cheaper = whole_price(new.plan, new.plan.taken) < whole_price(knee.plan, knee.plan.taken)
        if cheaper and (not new.again or loses_nothing(run(path, new.solution), as_it_is)):
            return new
    return knee


@dataclass(frozen=True, slots=True)
class _Mended:
    """A plan made anew until it is fit: its solution, None where that took more rounds than there are; what was last found; how
    often it was made anew (again), and as a whole; the CL lines and the count of points for which that was; and what is
    forbidden, rows (K, 9) by places of the given path. hopeless: that no posture has room at a point, so that nothing was tried.
    """

    plan: Plan
    found: _Found
    solution: Solution | None
    again: int
    whole: int
    lines: tuple[int, ...]
    count: int
    forbidden: Array
    hopeless: Finding | None = None

    def told(self, plan: Plan, missed: int) -> _Mended:
        """The same, known to be the point that is taken of a plan's curve; missed: what there was no time for."""
        if self.solution is None or self.solution.plan is None:
            raise ValueError("a plan that is not fit has no report")
        curve = tuple(p.figures for p in plan.curve)
        report = replace(self.solution.plan, curve=curve, rule=plan.choice.rule, missed=missed)
        return replace(self, plan=plan, solution=replace(self.solution, plan=report))

    def hurried(self) -> _Mended:
        """The same, with the look for a cheaper plan among what there was no time for."""
        return self.told(self.plan, 1 + (self.solution.plan.missed if self.solution and self.solution.plan else 0))

    def reported(self, given: ToolPathInBase) -> Solution:
        """The solution, and what it took."""
        if self.solution is None:
            raise ValueError("a plan that is not fit has no solution")
        return _reported(given, self.found, self.solution, self.again, self.whole, self.lines, self.count)


def _with_cuts(
    task: Task, given: ToolPathInBase, path: ToolPathInBase, objective: Objective, report_share: Share, forbidden: Array
) -> tuple[ToolPathInBase, Plan | None]:
    """The plan of a path, the given one or one with retracts in it, and the path with those that it still needs; no plan where
    nothing leads through. forbidden: rows (K, 9) by places of the given path.
    """
    plan: Plan | NDArray[np.int64] | None = None
    for cut in range(_CUTS + 1):
        if cut and not isinstance(plan, np.ndarray):
            break
        path = with_retracts(path, plan, CLEARANCE) if isinstance(plan, np.ndarray) else path
        plan = make_plan(task.at_least, path, objective._replace(blocked=_placed(forbidden, given, path)), report_share)
    return path, plan if isinstance(plan, Plan) else None


def _looked_at(task: Task, path: ToolPathInBase, plan: Plan, obstacles: Obstacles | None) -> _Found:
    """The plan followed, and held against what it may not touch."""
    followed = followed_plan(task, path, plan)
    none = np.zeros(0, np.int64)
    if followed.torn:  # nothing that could be forbidden mends that
        return _Found(path, None, followed.why, np.empty((0, 6)), none, 0)
    if followed.stuck >= 0:
        w, draft = plan.land.w, plan.taken.draft
        k = int(np.argmin(np.abs(w.s[draft.index] - w.place[followed.stuck])))
        return _Found(path, None, followed.why, draft.q[k : k + 1], np.array([followed.stuck]), 1)
    solution = plan_solution(task, path, plan, followed)
    low = np.array([r.point for r in solution.revisions if r.by_axes and not path.clear[r.point]], np.int64)
    hit = none if obstacles is None else np.flatnonzero(obstacles(path, solution))
    hit = hit[~np.isin(hit, low)]  # what is touched on the way of one that has to go is no reason to forbid its ends
    points = np.unique(np.concatenate([hit, np.maximum(hit - 1, 0)]))
    q = np.asarray(solution.q)[points][:, task.cell.arm_slice]
    return _Found(path, solution, None, q, points, len(hit), low, hit)


def _marks(given: ToolPathInBase, path: ToolPathInBase, objective: Objective, found: _Found) -> Array:
    """What a plan has found to be forbidden, rows (K, 9), by places of the given path."""
    place = waypoints(path, COARSE).place
    new = marks(objective.wrist_zero, found.q, place[found.point], COARSE)
    return _between(new, path, given)


def _placed(forbidden: Array, given: ToolPathInBase, path: ToolPathInBase) -> Array:
    """Forbidden rows by places of a path that retracts were put into."""
    return _between(forbidden, given, path)


def _between(rows: Array, one: ToolPathInBase, other: ToolPathInBase) -> Array:
    """Rows (K, 9) whose places are those of one path, by those of another that has the same points of the CL file."""
    if one is other:
        return rows
    here, there = (waypoints(p, COARSE).place[p.of_toolpath] for p in (one, other))
    out = rows.copy()
    out[:, FEATURES:] = np.interp(rows[:, FEATURES:], here, there)
    return out


def _reported(
    given: ToolPathInBase,
    found: _Found,
    solution: Solution,
    rounds: int = 0,
    whole: int = 0,
    lines: Sequence[int] = (),
    count: int = 0,
) -> Solution:
    """The solution of a plan, with what was made anew for it and which retracts it has."""
    path = found.path
    findings = list(solution.findings)
    if rounds:
        named = sorted({line for line in lines if line > 0})
        where = f" (from line {named[0]} to {named[-1]})" if named else ""
        how = (
            "there, the rest of it stands" if not whole else f"{whole} times as a whole, where nothing else led through"
        )
        what = "touched something, changed posture too near the part or could not be followed"
        text = f"the plan {what} at {count} points{where}: made anew {how}"
        findings.append(Finding("plan-mended", text, Severity.INFO, line=named[0] if named else 0, count=rounds))
    if path is not given:
        findings += told_retracts(path, solution)
    plan = None if solution.plan is None else replace(solution.plan, mended=rounds)
    return replace(solution, plan=plan, findings=tuple(findings), path=None if path is given else path)


def _another(
    task: Task,
    given: ToolPathInBase,
    path: ToolPathInBase,
    plan: Plan,
    found: _Found,
    obstacles: Obstacles | None,
    report_share: Share,
) -> Solution:
    """The nearest other point of a curve that touches nothing; else what there is: the plan that touches least, or the published
    method's postures where no plan could be followed.
    """
    taken = plan.choice.curve_index
    for k in sorted(range(len(plan.curve)), key=lambda k: abs(k - taken)):
        if k == taken:
            continue
        if task.clock.up:
            return out_of_time(task, given, found.trouble, report_share)
        rule = (
            f"in place of {plan.taken.name}, which touches something or can't be followed, also where it was made anew"
        )
        other = _looked_at(task, path, replace(plan, choice=Choice(k, rule)), obstacles)
        if other.solution is not None and other.fit:
            return _reported(given, other, other.solution)
        found = min(found, other, key=lambda one: (one.solution is None, len(one.low), one.count))
    if found.solution is None:
        why = found.why.what if found.why is not None else ""
        if len(found.point):
            why = f"the follower could not follow the plan, nor {_ROUNDS} more made anew where it failed ({why})"
        return published(task.cell, given, why, report_share)
    return _reported(given, found, found.solution)
