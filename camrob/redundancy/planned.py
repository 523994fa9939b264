"""Planned postures: external axes, roll and branch chosen over the whole path, certified, and followed by the one follower.

Waypoints every SPACING metres; a survey and the certificate (`certificate`); candidates and dynamic programming over every
fifth of them (`candidates`, `dynamic_programming`); Newton refinement of all (`refinement`); the follower with the plan as its
moving reference posture (`followed`). What touches something is made anew there (`replanning`). The objective and its units
stand in `objective`.

Modes: "still" keeps the external axes exactly still along each region, or along each stretch of it between re-postures;
"flowing" prices their travel at next to nothing; "knee", the default, is taken from the curve between them by this rule.
Budget: each external axis may move `knee_travel` of what the published method moves it on the same path in cutting moves, or
5 degrees or 20 mm where that is more. Of the points within the budget that keep `knee_share` of the bound's mean 1/k_F the
one with the least external travel, by the cell's prices; where none does both, the one within the budget that keeps most:
still axes hold feed and accuracy better than moving ones. Where no point is within the budget, the least travel that keeps
the share, else the point that keeps most. In the knee's place comes a plan that is cheaper by the whole objective where it is run
as well (`replanning/bettered`). A path that one of the two ends follows without a retract is not cut.
"""

from __future__ import annotations

from dataclasses import replace

from camrob.bodies.room import Room
from camrob.cell.cell import Cell
from camrob.errors import CellError
from camrob.findings import Finding, Severity
from camrob.progress import Share
from camrob.redundancy.accuracy.posture_errors import PostureErrors
from camrob.redundancy.clock import Clock
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import PlanAccuracy
from camrob.redundancy.planning.for_accuracy import expected_error, preferred
from camrob.redundancy.planning.forbidding import Leads
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.scan_batched import Score
from camrob.redundancy.replanning.bettered import Run
from camrob.redundancy.replanning.clearing import Obstacles, cleared
from camrob.redundancy.replanning.hurried import published
from camrob.redundancy.replanning.one_plan import Task
from camrob.redundancy.solution import Solution
from camrob.units import m_to_mm

__all__ = ["MODES", "resolve_planned"]

MODES = ("knee", "still", "flowing")


def resolve_planned(
    cell: Cell,
    path: ToolPathInBase,
    *,
    mode: str = "knee",
    obstacles: Obstacles | None = None,
    room: Room | None = None,
    leads: Leads | None = None,
    score: Score | None = None,
    errors: PostureErrors | None = None,
    run: Run | None = None,
    seconds: float | None = None,
    progress: Share | None = None,
) -> Solution:
    """Postures along a path, planned (see the module); `mode` is one of MODES.

    obstacles(path, solution) says at which points (N,) a solution touches something: the plan is made anew there (a solution
    that still touches is returned; whoever checks it, finds it).
    room: the bodies that may not touch. Where mending a plan doesn't lead out of what it touches, the search goes round all
    candidates that touch something by these, and `obstacles` finds what is touched between them. leads: the room on the
    ways from HOME to postures of the first point and from those of the last one back, by which that search begins and ends.
    score: 1/k_F of batches of arm postures, for the certificate's scan (`scan_batched`); None: the compiled kernels.
    errors: what is known of the machine's errors: the part's expected error then stands in the objective with the weight
    `accuracy` of the cell (FOR_ACCURACY where that is 0), and the plan is returned only where it expects clearly
    less than the one by conditioning (`preferred`); the report says what both expect.
    run(path, solution): how the controller runs a solution (`RunFigures`). With it the knee's plan gives way to one that is
    cheaper by the whole objective, travel priced in full, wherever that one takes no longer, holds the feed as well and has to
    be slowed no more for the axes' limits; without it nobody can tell, and the knee's stays.
    seconds: how long the plan is bettered: when they are over the curve gets no further points, no cheaper plan is looked for,
    and a plan that touches something or can't be followed is not made anew but gives way to the published method's postures, with
    a finding that says so and their gap. What a first plan needs (waypoints, survey, candidates, the search of both ends, one
    following with its look at obstacles) is done however long it takes, and a step that is under way is ended; the report
    says what there was no time for.
    Where the path can't be followed without a re-posture and has no safe point for one, retracts are put in: the
    solution then belongs to `Solution.path`. An arm without closed form, and a path for which no plan is found, is left to
    the published method, with a finding that says so.
    Raises UnreachableError, LimitError or SingularError with line, region, axis and distance; ValueError for another mode.
    """
    if mode not in MODES:
        raise ValueError(f"mode is {mode!r}, expected one of {', '.join(MODES)}")
    report_share = _rising(progress)
    try:
        space = plan_space(cell)
    except CellError as error:
        return published(cell, path, f"{error.what}", report_share)
    if not len(space.free):
        return published(cell, path, f"cell {cell.name} has no spare freedom to plan", report_share)
    task = Task(cell, space, mode, score, Clock(seconds), room=room, leads=leads)
    solution = cleared(task, path, obstacles, report_share, run)
    if errors is not None and solution.method == "planned":
        solution = _for_accuracy(
            task, path, solution, cleared(replace(task, errors=errors), path, obstacles, report_share), errors
        )
    report_share(1.0)
    return solution


def _for_accuracy(task: Task, path: ToolPathInBase, plain: Solution, ours: Solution, errors: PostureErrors) -> Solution:
    """The one of two plans that expects less error of the part, with what both expect."""
    before = expected_error(task.cell, errors, plain.path or path, plain)
    reached = None if ours.plan is None else ours.plan.best_error
    after = before if reached is None else expected_error(task.cell, errors, ours.path or path, ours)
    taken = preferred(before, after, corrected=errors.corrected)
    solution = ours if taken else plain
    if solution.plan is None:
        return solution
    best = min(before.rms if reached is None else reached, before.rms, after.rms)
    accuracy = PlanAccuracy(before, after, taken, best, errors.counted, errors.left_out)
    return replace(
        solution,
        plan=replace(solution.plan, accuracy=accuracy),
        findings=(*solution.findings, _accuracy_finding(accuracy)),
    )


def _accuracy_finding(accuracy: PlanAccuracy) -> Finding:
    """What is gained for the part, in one line."""
    before, after = accuracy.conditioning, accuracy.accuracy
    text = (
        f"expected error of the part {m_to_mm(after.rms):.3f} mm rms ({m_to_mm(after.p95):.3f} mm on 95 %), "
        f"{m_to_mm(before.rms):.3f} mm ({m_to_mm(before.p95):.3f} mm) in the plan by conditioning"
    )
    kept = "" if accuracy.taken else "; that one is kept, as the other is no better"
    return Finding("plan-accuracy", text + kept, Severity.INFO, value=m_to_mm(after.rms), unit="mm")


def _rising(progress: Share | None) -> Share:
    """Progress that never falls back, however often a plan is made anew."""
    highest = [0.0]

    def report_share(share: float) -> None:
        if progress is not None and share > highest[0]:
            highest[0] = share
            progress(share)

    return report_share
