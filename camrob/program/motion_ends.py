"""Which points of a path a program's motions end at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.program.arcs import circ_rows
from camrob.program.motion import Motion
from camrob.program.process import Process
from camrob.program.program_events import RegionPoints
from camrob.redundancy.path import ToolPathInBase
from camrob.toolpath.toolpath import Toolpath

__all__ = ["kept_points", "motion_ends"]

Mask = NDArray[np.bool_]


def kept_points(points: RegionPoints, keep: Mask, process: Process) -> tuple[Mask, NDArray[np.int8]]:
    """(N,) the points of a path that stand in its program, and the kind of the motion to each.

    keep: (N,) False for points that decimation leaves out; what something happens at is kept, and of an arc what a CIRC needs.
    """
    kind = np.full(len(points.path), int(Motion.LIN), np.int8)
    keep = keep.copy()
    keep[points.marked(process)] = True
    for index, region in enumerate(points.regions):
        circ_rows(region, points.place(index), kind, keep)
    return keep, kind


def motion_ends(toolpath: Toolpath, path: ToolPathInBase, keep: Mask, process: Process) -> Mask:
    """(N,) True at the points of a path at which a motion of its program ends; keep as of `kept_points`."""
    points = RegionPoints(path, [r for r in toolpath.regions if len(r)])
    kept, kind = kept_points(points, keep, process)
    ends: Mask = kept & (kind != Motion.CIRC_VIA)
    ends[-1:] = True
    return ends
