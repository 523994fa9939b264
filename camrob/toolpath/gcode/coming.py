"""The way from wherever the machine stands to the first place that a program names: moves at a feed that name it bit by bit.

A control begins from its present position: `L Z+5 F9999`, then `L X+20 Y+20`. The first of them ends nowhere that the program
tells, so it can't be made; what it leads to can.
"""

from __future__ import annotations

import math

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.coordinates import ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.state import Modal

__all__ = ["Coming"]

_PLAIN = 170  # G17
_SAID = (
    "a move at a feed begins where the machine happens to stand: it is taken for the way to the first place that is named, and "
    "left out"
)


class Coming:
    """Remembers such moves until the place is known, and above the part: from there the program goes down along the tool, or
    across in rapid. Else they may have been cuts, and are none that can be made.
    """

    def __init__(self, path: PathGrower, frame: ToolFrame, modal: Modal) -> None:
        self._path, self._frame, self._modal = path, frame, modal
        self._line, self._missing, self._first = 0, "", True
        self._named: dict[int, float] = {}
        self._height: float | None = None  # of the first known place, where a cut has led to it

    def takes(self, block: Block, motion: int) -> bool:
        """Whether a move at a feed, which the frame has taken in, is of this kind, and to be left out."""
        frame, modal = self._frame, self._modal
        plain = frame.placeable and frame.plane is None and not frame.tcp and not frame.turned and frame.program.plain
        across = not {"X", "Y"}.isdisjoint(block.words)  # straight down from wherever it is cuts nothing else
        if motion != 10 or self._path.place is not None:
            return False
        if frame.tcp and frame.known and across and not modal.cut and not self._path.adrift and not self._line:
            self._begin(block.line)  # under TCP no way down is known by its letters
            raise self._unknown()
        if not plain:
            return False
        if frame.known and across and not self._line:
            self._begin(block.line)
            if self._path.adrift:
                raise self._unknown()
            self._height, self._named = frame.xyz[2], {0: frame.xyz[0], 1: frame.xyz[1]}
        if frame.known or self._path.adrift:
            return False
        if modal.feed_mode == 930 or modal.plane != _PLAIN or block.corner is not None:
            return False
        named = {"XYZ".index(k) for k in "XYZ" if k in block.words}
        if any(math.isnan(frame.xyz[i]) for i in named):
            return False
        if not self._line:
            self._begin(block.line)
        self._named = {i: v for i, v in enumerate(frame.xyz) if not math.isnan(v)}
        return True

    def _begin(self, line: int) -> None:
        """Such a move stands in that line."""
        self._line, self._first = line, not self._modal.cut
        self._missing = " and ".join(k for k, v in zip("XYZ", self._frame.xyz, strict=True) if math.isnan(v))

    def moved(self, *, rapid: bool) -> None:
        """The frame has taken a move in. Raises ToolpathError where one before it may have been a cut in an unknown place."""
        if not self._line:
            return
        xyz = self._frame.xyz
        kept = all(xyz[i] == v for i, v in self._named.items())
        if self._height is not None:
            kept = (kept and xyz[2] < self._height) or (rapid and xyz[2] == self._height)
        elif kept and not self._frame.known:
            return
        if not kept:
            raise self._unknown()
        if self._height is None and not rapid:
            self._height, self._named = xyz[2], {0: xyz[0], 1: xyz[1]}
            return
        self._path.note("begins-anywhere", _SAID, self._line)
        self._line, self._named, self._height = 0, {}, None

    def ends(self) -> None:
        """Nothing of the kind may be open: before a cycle, an arc, the program's end. Raises ToolpathError."""
        if self._line:
            raise self._unknown()

    def _unknown(self) -> ToolpathError:
        if not self._missing:
            where = "as the first of the program" if self._first else "behind a machine position or a tool change"
            return ToolpathError(
                f"a cut from where the tool is not known to be, {where}",
                hint="go to where it is to begin in a rapid move",
                line=self._line,
            )
        return ToolpathError(
            f"a cut while {self._missing} has no known value",
            hint=f"name {self._missing} in a rapid move before the cut",
            line=self._line,
        )
