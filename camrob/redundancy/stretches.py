"""Where the tool is changed on the way through a path, and how the stretches between changes are solved one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase, joined_paths
from camrob.redundancy.plan_report import ExpectedError, PlanAccuracy, PlanReport
from camrob.redundancy.solution import Lead, Solution

__all__ = ["Stretch", "change_values", "home_values", "joined_solutions", "started_from"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A stretch of the path between two changes of tools, with its path and its solution."""

    path: ToolPathInBase
    solution: Solution


def home_values(cell: Cell, last: Array) -> Array:
    """HOME as axis values (axes,), degrees and mm, endless external axes on the turns that lie nearest to `last` (axes,)."""
    return _near_turns(cell, cell.to_axis_values(cell.q_home), last)


def change_values(cell: Cell, last: Array) -> Array:
    """Where tools are changed, likewise: the cell's pose for it, HOME where it names none."""
    pose = cell.controller.tool_change_pose
    return home_values(cell, last) if pose is None else _near_turns(cell, np.array(pose, float), last)


def _near_turns(cell: Cell, values: Array, last: Array) -> Array:
    out = np.array(values, float)
    for k, external in enumerate(cell.external_names, start=6):
        if cell.joints[cell.index(external)].endless:
            out[k] += 360.0 * np.round((last[k] - out[k]) / 360.0)
    return out


def started_from(cell: Cell, values: Array) -> Cell:
    """The cell as a stretch finds it that starts from axis values (axes,), degrees and mm, in HOME's place."""
    q = cell.to_q(values)
    return replace(cell, joints=tuple(replace(j, home=float(v)) for j, v in zip(cell.joints, q, strict=True)))


def joined_solutions(cell: Cell, stretches: Sequence[Stretch]) -> tuple[ToolPathInBase, Solution]:
    """Path and solution of all stretches as one; `cell` is the one that the whole job goes by."""
    if len(stretches) == 1:
        return stretches[0].path, stretches[0].solution
    path = joined_paths([s.path for s in stretches])
    begins = np.cumsum([0, *(len(s.path) for s in stretches)]).tolist()
    methods = list(dict.fromkeys(s.solution.method for s in stretches))
    placed = list(zip(begins, (s.solution for s in stretches), strict=False))
    whole = Solution(
        method=methods[0] if len(methods) == 1 else "planned",
        q=np.concatenate([np.asarray(s.solution.q) for s in stretches]),
        inv_kf=np.concatenate([np.asarray(s.solution.inv_kf) for s in stretches]),
        cell_digest=cell.digest,
        path_digest=path.digest,
        revisions=tuple(replace(r, point=r.point + begin) for begin, s in placed for r in s.revisions),
        findings=tuple(
            replace(f, point=f.point + begin if f.point >= 0 else -1) for begin, s in placed for f in s.findings
        ),
        plan=_joined_plans(path, stretches),
        leads=tuple(lead for s in stretches for lead in (s.solution.leads or (Lead.straight(len(cell)),))),
    )
    return path, whole


def _joined_plans(path: ToolPathInBase, stretches: Sequence[Stretch]) -> PlanReport | None:
    """What the plans of all stretches say together; None unless each has one. Their curves stay with them."""
    plans = [s.solution.plan for s in stretches]
    reports = [p for p in plans if p is not None]
    if len(reports) != len(plans):
        return None
    bound = np.concatenate([np.asarray(p.bound) for p in reports])
    length = path.weight
    reached = np.concatenate([np.asarray(s.solution.inv_kf) for s in stretches])
    return PlanReport(
        mode=reports[0].mode,
        chosen=", ".join(dict.fromkeys(p.chosen for p in reports)),
        rule="; ".join(dict.fromkeys(p.rule for p in reports)),
        bound=bound,
        bound_mean=float(np.average(bound, weights=length)),
        bound_min=float(bound[length > 0.0].min()),
        terms={name: sum(p.terms[name] for p in reports) for name in reports[0].terms},
        curve=(),
        repostures=sum(p.repostures for p in reports),
        retracts=sum(p.retracts for p in reports),
        reached_mean=float(np.average(reached, weights=length)),
        seconds=reports[0].seconds,
        missed=sum(p.missed for p in reports),
        mended=sum(p.mended for p in reports),
        accuracy=_joined_accuracy(reports),
        bases=tuple(b for p in reports for b in p.bases),
    )


def _joined_accuracy(plans: Sequence[PlanReport]) -> PlanAccuracy | None:
    """What all stretches expect of the part together; None unless each does."""
    found = [p.accuracy for p in plans if p.accuracy is not None]
    if len(found) != len(plans):
        return None
    length = [float(np.asarray(a.accuracy.length).sum()) for a in found]
    square = np.average([a.best**2 for a in found], weights=length if any(length) else None)
    return replace(
        found[0],
        conditioning=reduce(ExpectedError.joined, (a.conditioning for a in found)),
        accuracy=reduce(ExpectedError.joined, (a.accuracy for a in found)),
        taken=any(a.taken for a in found),
        best=float(np.sqrt(square)),
    )
