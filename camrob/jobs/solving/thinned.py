"""A path thinned to so many cutting points, for trials that need its course and not every point."""

from __future__ import annotations

import numpy as np

from camrob.redundancy.path import ToolPathInBase

__all__ = ["thinned"]


def thinned(path: ToolPathInBase, points: int) -> ToolPathInBase:
    """The path with about `points` of its cutting points, all others, and the ends of every cut."""
    cutting = path.cutting
    ends = np.ones(len(path), np.bool_)
    ends[1:-1] = ~(cutting[:-2] & cutting[1:-1] & cutting[2:])
    region = np.asarray(path.region)
    change = region[1:] != region[:-1]
    ends[1:] |= change
    ends[:-1] |= change
    step = max(1, int(np.ceil(np.count_nonzero(cutting) / points)))
    keep = ends | (np.arange(len(path)) % step == 0)
    return path.part(keep)
