"""A program against CL points that several tools are to meet: each tool's points by what the program does with that tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.controller.against import Coverage, cover
from camrob.program.motion import Motion

__all__ = ["cover_stretches"]

Array = NDArray[np.float64]


def cover_stretches(
    base_T_tip: Array,
    line: NDArray[np.int64],
    region: NDArray[np.int64],
    stretch: NDArray[np.int64],
    targets: Array,
    kind: NDArray[np.int8],
    *,
    chord_tolerance: float = 0.0,
) -> Coverage:
    """As `cover`, with the points' stretches (N,) between tool changes.

    A stretch's points are looked for behind the first PTP to axis values that follows the last point of the stretch before:
    there the tool is changed, and a place that both tools come to counts for each only when it comes there. A program
    that changes tools in another way is taken as it comes.
    """
    if not len(stretch) or stretch[0] == stretch[-1]:
        return cover(base_T_tip, line, region, targets, kind, chord_tolerance=chord_tolerance)
    bounds = np.flatnonzero(np.diff(stretch, prepend=-1, append=-1))
    found: list[Coverage] = []
    last = 0
    for begin, stop in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        here = slice(begin, stop)
        ways = np.flatnonzero(kind[last + 1 :] == Motion.PTP_AXES) if found else np.zeros(0, np.int64)
        tried = []
        for row in [*(last + 1 + ways[:1]).tolist(), last]:
            part = cover(
                base_T_tip[here], line[here], region[here], targets[row:], kind[row:], chord_tolerance=chord_tolerance
            )
            tried.append(_moved(part, row, begin))
            if part.good:
                break
        part = tried[-1] if tried[-1].good else tried[0]
        found.append(part)
        last = int(part.motion.max(initial=last))
        if not part.good:
            break
    return _joined(found, len(stretch), region)


def _moved(coverage: Coverage, row: int, point: int) -> Coverage:
    """The same, counted from the program's first motion and the first of all points."""
    motion, leaves = (np.where(v >= 0, v + row, -1) for v in (coverage.motion, coverage.leaves))
    findings = tuple(replace(f, point=f.point + point) for f in coverage.findings)
    return replace(coverage, motion=motion, leaves=leaves, findings=findings)


def _joined(found: list[Coverage], count: int, region: NDArray[np.int64]) -> Coverage:
    """All stretches in one; points behind one that is missed are missed too."""
    rest = count - sum(len(c.motion) for c in found)
    missed = np.full(rest, -1)
    return Coverage(
        motion=np.concatenate([*(c.motion for c in found), missed]),
        leaves=np.concatenate([*(c.leaves for c in found), missed]),
        position_error=np.concatenate([*(c.position_error for c in found), np.zeros(rest)]),
        axis_error=np.concatenate([*(c.axis_error for c in found), np.zeros(rest)]),
        deviation=max(c.deviation for c in found),
        joined=np.concatenate([[False], region[1:] == region[:-1]]),
        findings=tuple(f for c in found for f in c.findings),
    )
