"""What stands in the way of a plan: the bodies of a job's cell, part and stock, as the planner asks for them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.check.collisions import check_collisions
from camrob.jobs.inputs import JobInputs
from camrob.resolve.path import ToolPathInBase
from camrob.resolve.solution import Solution

__all__ = ["job_obstacles"]


def job_obstacles(inputs: JobInputs) -> Callable[[ToolPathInBase, Solution], NDArray[np.bool_]]:
    """`obstacles` for `resolve_planned`: at which points (N,) of a path a solution's bodies touch, its re-postures and the
    ways from and to HOME included.
    """

    def touching(path: ToolPathInBase, solution: Solution) -> NDArray[np.bool_]:
        n = len(path)
        q = [inputs.cell.q_home[None], np.asarray(solution.q), inputs.cell.q_home[None]]
        order = np.concatenate([[-0.5], np.arange(n), [n - 0.5]])
        for revision in solution.revisions:
            if revision.kept:  # the last posture of a re-posture is the solution's own at the point
                before = np.asarray(revision.q[:-1])
                q.append(before)
                order = np.append(order, revision.point - 0.4 + 0.3 * np.arange(len(before)) / len(before))
        sort = np.argsort(order, kind="stable")
        point = np.clip(np.ceil(order[sort]).astype(np.int64), 0, n - 1)
        own = order[sort] == np.floor(order[sort])
        report = check_collisions(
            inputs.cell, np.concatenate(q)[sort], cutting=path.cutting[point] & own, line=path.line[point],
            region=path.region[point], part_mesh=inputs.part, stock_mesh=inputs.stock,
            base_T_part=np.asarray(inputs.setup.base_T_part), tool=inputs.tool,
        )  # fmt: skip
        out = np.zeros(n, np.bool_)
        out[point[report.hit]] = True
        return out

    return touching
