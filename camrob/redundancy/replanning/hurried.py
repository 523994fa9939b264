"""The published method's postures in a plan's place: where there is no plan, or none that was fit when its time was over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.findings import Finding, Severity
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.beginnings import resolve_published
from camrob.redundancy.replanning.one_plan import Task
from camrob.redundancy.solution import Solution

__all__ = ["held_to_published", "out_of_time", "published"]

Array = NDArray[np.float64]


def published(cell: Cell, path: ToolPathInBase, why: str, report_share: Share) -> Solution:
    """The published method in the planner's place. Raises JobError where it fails too, which then says why there is no plan."""
    try:
        solution = resolve_published(cell, path, progress=report_share)
    except JobError as error:
        error.what = f"{error.what} (by the published method; there is no plan: {why})"
        raise
    note = Finding("plan-fell-back", f"postures follow the published method, not a plan: {why}", Severity.WARNING)
    return replace(solution, findings=(*solution.findings, note))


def out_of_time(task: Task, given: ToolPathInBase, trouble: str, report_share: Share) -> Solution:
    """The published method's postures where the time to better a plan is over before one is fit, with their gap to the bound
    that the plan had. trouble: what stood against the plan, in words. Raises JobError as `published` does.
    """
    why = f"the {task.clock.seconds:.3g} s to better one were over while it {trouble}; give --seconds more"
    solution = published(task.cell, given, why, report_share)
    ground = task.grounds.get(given.digest)
    if ground is None:
        return solution
    length, reached = given.weight, np.asarray(solution.inv_kf)
    bound = np.maximum(ground.certificate.along(ground.w.s, ground.w.place), reached)
    gap = 100.0 * (1.0 - float(length @ reached) / float(length @ bound))
    *others, fell = solution.findings
    text = f"{fell.text}; mean 1/k_F is {gap:.2f} % below its bound, the best found at each place by itself"
    return replace(solution, findings=(*others, replace(fell, text=text, value=gap, unit="%")))


def held_to_published(task: Task, given: ToolPathInBase, solution: Solution) -> Solution:
    """A plan that there was no time to better all the way, with a warning where its mean 1/k_F is below that of the published
    method's postures.
    """
    plan = solution.plan
    if plan is None or not plan.missed:
        return solution
    try:
        other = resolve_published(task.cell, given)
    except JobError:
        return solution
    mean = float(np.average(np.asarray(other.inv_kf), weights=given.weight))
    if plan.reached_mean >= mean:
        return solution
    text = (
        f"the {task.clock.seconds:.3g} s to better the plan were over too soon: its mean 1/k_F is {plan.reached_mean:.3f}, and "
        f"the published method reaches {mean:.3f}; give --seconds more, or use --method vjm"
    )
    note = Finding("plan-hurried", text, Severity.WARNING, value=plan.reached_mean, limit=mean)
    return replace(solution, findings=(*solution.findings, note))
