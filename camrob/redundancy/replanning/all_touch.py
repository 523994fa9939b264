"""Points at which every posture touches something, whatever the freedoms: no search leads out of that, and none is tried."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.findings import Finding, Severity
from camrob.redundancy.accuracy.part_error import PUSH
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.candidates import ROLLS, layer
from camrob.redundancy.replanning.one_plan import Plan, Task
from camrob.redundancy.solution import ALL_TOUCH

__all__ = ["all_touch"]

_LOOKED = 5  # of the points that touch something


def all_touch(task: Task, plan: Plan, path: ToolPathInBase, points: NDArray[np.int64]) -> Finding | None:
    """That at one of some points of a path no posture has room, and how many were looked at there: all branches at the external
    postures and rolls of the plan's own lattice. None where each of the points has one.
    """
    room_of, land = task.room_of, plan.land
    if room_of is None or not len(points):
        return None
    external = len(land.space.free) - land.space.roll
    nodes = [some for some in (land.still_nodes, land.flow_nodes) if some is not None]
    for point in points[np.unique(np.linspace(0, len(points) - 1, _LOOKED).astype(int))]:
        t = int(np.argmin(np.abs(land.w.s[land.coarse] - land.w.place[point])))
        tried = np.concatenate([some.u[some.offset[t] : some.offset[t + 1], :external] for some in nodes])
        u, q, branch, _price = layer(
            land.space,
            land.objective,
            np.ascontiguousarray(path.base_T_tip[point]),
            np.ascontiguousarray(np.unique(tried, axis=0) if external else tried[:1]),
            False,
            np.zeros(len(land.space.free)),
            ROLLS,
            np.zeros(PUSH),
            land.space.lower,
            land.space.upper,
        )
        # whole turns stand alike
        fresh = np.append(True, np.any(u[1:] != u[:-1], axis=1) | (branch[1:] != branch[:-1]))
        if len(u) and not np.any(room_of.at(u[fresh], q[fresh]) > 0.0):
            line, count = int(path.line[point]), int(fresh.sum())
            text = f"at CL line {line} each of the {count} postures that were looked at touches something"
            return Finding(ALL_TOUCH, text, Severity.INFO, line, int(path.region[point]), int(point), count=count)
    return None
