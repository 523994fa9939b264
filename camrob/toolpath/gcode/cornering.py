"""A corner that has been asked for, and waits for the straight cut behind it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.coordinates import Stance, ToolFrame
from camrob.toolpath.gcode.corner import Corner, cut_corner
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block

__all__ = ["Open", "closes", "no_second_cut"]

_NORMALS = {170: 2, 180: 1, 190: 0}  # which axis stands on the plane
_BESIDE = frozenset("XYZF")


class Open(NamedTuple):
    """A corner at `at`, where a straight cut from `start` ends: (3,) m in the program's frame. `size` in m, feeds in m/s."""

    corner: Corner
    size: float
    start: NDArray[np.float64]
    at: NDArray[np.float64]
    feed: float
    slow: float  # of the corner itself
    plane: int
    line: int

    def cut(self, path: PathGrower, frame: ToolFrame, end: NDArray[np.float64], to: Stance) -> NDArray[np.float64]:
        """Cut up to the corner and round it; gives where that ends, from where the cut to `end` goes on.

        Raises ToolpathError where the corner doesn't fit.
        """
        normal = np.zeros(3)
        normal[_NORMALS[self.plane]] = 1.0
        found = cut_corner(self.start, self.at, end, normal, self.corner.kind, self.size)
        if found is None:
            path.cut(_stance(frame, self.at, to), self.feed, self.line)
            return self.at
        path.cut(_stance(frame, found.begin, to), self.feed, self.line)
        there = _stance(frame, found.end, to)
        if found.center is None or found.normal is None:
            path.cut(there, self.slow, self.line)
        else:
            path.arc(there, frame.point(found.center), frame.normal(found.normal), 0, self.slow, self.line)
        return found.end


def _stance(frame: ToolFrame, point: NDArray[np.float64], to: Stance) -> Stance:
    x, y, z = frame.point(point).tolist()
    return Stance((x, y, z), to.axis, to.angles, to.rotary, to.vector)


def closes(block: Block) -> bool:
    """Whether the block may be the straight cut behind a corner, or only says something: no code acts in between."""
    quiet = not (block.m or block.plane is not False or block.frame is not None or block.vector is not None)
    return quiet and set(block.g) <= {10} and _BESIDE.issuperset(block.words)


def no_second_cut(line: int) -> ToolpathError:
    """That a corner lies between no two straight cuts, as an error to be raised."""
    return ToolpathError(
        "a rounded or chamfered corner (RND, CHF, CHR, or ,R and ,C) that isn't between two straight cuts",
        hint="have the CAM system write the corner out as moves",
        line=line,
    )
