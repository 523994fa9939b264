"""How a job's controller runs a plan, as the planner asks for it."""

from __future__ import annotations

import numpy as np

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.replanning.bettered import Run, RunFigures
from camrob.redundancy.solution import Solution
from camrob.timing.as_it_stands import program_as_it_stands
from camrob.timing.losses import FEED_KEPT
from camrob.timing.timing import program_time

__all__ = ["job_run"]


def job_run(cell: Cell, rapid_speed: float) -> Run | None:
    """`run` for `resolve_planned`: the controller's model of the program at its own feed, in air at rapid_speed (m/s); None for a
    cell without a controller.
    """
    if cell.controller_section is None:
        return None

    def run(path: ToolPathInBase, solution: Solution) -> RunFigures:
        q, speed = np.asarray(solution.q), path.commanded_speed(rapid_speed)
        timing = program_time(cell, path, q, speed=speed)
        stands = program_as_it_stands(cell, path, q, timing, speed=speed)
        way = path.cut
        seconds = np.diff(np.asarray(timing.at), prepend=0.0)
        kept = (way > 0.0) & (way >= FEED_KEPT * speed * seconds)
        return RunFigures(timing.total, float(np.sum(way[kept])) / max(float(np.sum(way)), 1e-12), stands.total)

    return run
