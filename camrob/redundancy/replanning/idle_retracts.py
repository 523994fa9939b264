"""Retracts that a plan was given and, made anew, does nothing on: they are taken out of its path again.

A plan that can't be followed gets a retract where it would change posture. Searched for anew with it there, the way may lead
through without any change; the program would then leave the part, do nothing, and come back. That also leaves a hole by another
way than its cycle says, for which the witness refuses a program.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.findings import Finding, Severity
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.retracts import with_retracts
from camrob.redundancy.solution import Solution
from camrob.units import deg_to_rad

__all__ = ["Obstacles", "retract_tops", "retracted_for_nothing", "told_retracts", "without_idle_retracts"]

Obstacles: TypeAlias = Callable[[ToolPathInBase, Solution], NDArray[np.bool_]]

INSERTED = "retract-inserted"
"""The code of the finding that tells of a retract."""
_ALIKE = deg_to_rad(5.0)  # that the arm's axes and the roll may differ before and after: the way on begins at the first
_STILL = 1e-3  # m or rad, likewise of an external axis


def retract_tops(path: ToolPathInBase) -> NDArray[np.int64]:
    """The points above of the retracts that were put into a path."""
    return np.flatnonzero((path.source < 0) & (path.region >= 0) & path.safe)


def told_retracts(path: ToolPathInBase, solution: Solution) -> list[Finding]:
    """A finding for each retract that was put in, with its reason."""
    why = {r.point: r.reason for r in solution.revisions if r.kept}
    return [
        Finding(
            INSERTED,
            "the path can't be followed in one posture: the tool is retracted here, the arm re-postured, and cutting goes on"
            + (f"; {why[int(k)]}" if int(k) in why else ""),
            Severity.WARNING,
            line=int(path.line[k]),
            region=int(path.region[k]),
            point=int(k),
        )
        for k in retract_tops(path)
    ]


def retracted_for_nothing(path: ToolPathInBase, solution: Solution) -> bool:
    """Whether a path has retracts that a solution doesn't need."""
    return bool(np.any(~np.isin(retract_tops(path), [r.point for r in solution.revisions if r.kept])))


def without_idle_retracts(
    cell: Cell, given: ToolPathInBase, solution: Solution, clearance: float, obstacles: Obstacles | None
) -> Solution:
    """The solution without the retracts on which no posture is changed; as it is where it would touch something without them.

    given: the path that nothing was put into; clearance: m, as `with_retracts` was given it.
    """
    path = solution.path
    if path is None:
        return solution
    tops, q = retract_tops(path), np.asarray(solution.q)
    used = np.isin(tops, [r.point for r in solution.revisions if r.kept])
    most = np.full(len(cell), _ALIKE)
    most[: cell.arm_slice.start] = _STILL
    idle = tops[~used & np.all(np.abs(q[tops + 1] - q[tops - 1]) <= most, axis=1)]
    if not len(idle):
        return solution
    own, keep = np.ones(len(path), np.bool_), np.ones(len(path), np.bool_)
    own[np.concatenate([tops, tops + 1])] = False
    keep[np.concatenate([idle, idle + 1])] = False
    stay = np.setdiff1d(tops, idle)
    shorter = with_retracts(given, np.cumsum(own)[stay - 1] - 1, clearance) if len(stay) else given
    at = np.cumsum(keep) - 1
    plan = solution.plan
    if plan is not None:
        plan = replace(plan, bound=np.asarray(plan.bound)[keep], retracts=plan.retracts - len(idle))
    new = replace(
        solution,
        q=q[keep],
        inv_kf=np.asarray(solution.inv_kf)[keep],
        path_digest=shorter.digest,
        path=shorter if len(stay) else None,
        revisions=tuple(replace(r, point=int(at[r.point])) for r in solution.revisions),
        findings=tuple(
            replace(f, point=int(at[f.point])) if f.code == INSERTED else f
            for f in solution.findings
            if f.code != INSERTED or f.point not in idle
        ),
        plan=plan,
    )
    touches = obstacles is not None and bool(np.any(obstacles(shorter, new)))
    return solution if touches else new
