"""Retracts put into a path where it can't be followed in one posture: out along the tool axis, re-posture, back in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.path import ToolPathInBase
from camrob.toolpath.region import Move

__all__ = ["with_retracts"]

Array = NDArray[np.float64]


def with_retracts(path: ToolPathInBase, points: NDArray[np.int64], clearance: float) -> ToolPathInBase:
    """The path with a retract after each of `points` (indices): a safe point `clearance` m above all that it passes, along the
    tool axis there, and the way back to the point.

    Both are camrob's own (source -1, `Move.LINK`) and keep the point's region and line; the way back has the point's feed. The
    points themselves are safe no more: what is done at a safe point has its place above.
    """
    after = np.unique(points)
    tips = path.base_T_tip[:, :3, 3]
    lifted = np.array(path.base_T_tip[after])
    for frame in lifted:
        axis = frame[:3, 2]
        height = float(np.max(tips[path.of_toolpath] @ axis)) + clearance
        frame[:3, 3] += max(height - float(frame[:3, 3] @ axis), clearance) * axis
    at = np.repeat(after + 1, 2)

    def put(values: NDArray[np.generic], new: NDArray[np.generic]) -> NDArray[np.generic]:
        return np.asarray(np.insert(values, at, new, axis=0))

    n = len(after)
    safe = np.array(path.safe)
    safe[after] = False
    frames = np.stack([lifted, path.base_T_tip[after]], axis=1).reshape(2 * n, 4, 4)
    return ToolPathInBase(
        base_T_tip=put(path.base_T_tip, frames),  # type: ignore[arg-type]
        move=put(path.move, np.full(2 * n, int(Move.LINK), np.int8)),  # type: ignore[arg-type]
        feed=put(path.feed, np.stack([np.full(n, np.nan), path.feed[after]], axis=1).ravel()),  # type: ignore[arg-type]
        line=put(path.line, np.repeat(path.line[after], 2)),  # type: ignore[arg-type]
        region=put(path.region, np.repeat(path.region[after], 2)),  # type: ignore[arg-type]
        source=put(path.source, np.full(2 * n, -1, np.int64)),  # type: ignore[arg-type]
        safe=put(safe, np.tile([True, False], n)),  # type: ignore[arg-type]
        stretch=put(path.stretch, np.repeat(path.stretch[after], 2)),  # type: ignore[arg-type]
        clear=put(path.clear & safe, np.tile([True, False], n)),  # type: ignore[arg-type]
    )
