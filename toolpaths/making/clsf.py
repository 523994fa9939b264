"""A writer in the habits of NX CLSF: modal axis and feed, one-shot RAPID, PAINT bookkeeping, reversed arc axes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Clsf"]

Array = NDArray[np.float64]
RAPID, APPROACH, ENGAGE, CUT, STEP = 186, 211, 42, 31, 37  # NX's colours of motion


def _text(values: ArrayLike, decimals: int) -> str:
    return ",".join(f"{v:.{decimals}f}" for v in np.round(np.asarray(values, dtype=float), decimals) + 0.0)


class Clsf:
    """Statements of one CL file. Coordinates are in the operation's MSYS, lengths in mm, feeds in mm/min."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.counts = {"operations": 0, "points": 0, "arcs": 0, "rapids": 0, "holes": 0}
        self._axis = ""
        self._feed = 0.0
        self._color = 0
        self._tool: tuple[float, float] = (0.0, 0.0)

    def operation(self, name: str, tool: str, tldata: Sequence[float], msys: ArrayLike, rpm: int) -> None:
        """Open an operation. tldata: diameter, corner radius, length, taper, tip; msys: origin, X, Y (9 numbers)."""
        frame = np.asarray(msys, dtype=float)
        self._axis, self._feed, self._color, self._tool = "", 0.0, 0, (tldata[0], tldata[1])
        self.counts["operations"] += 1
        self.lines += [
            f"TOOL PATH/{name},TOOL,{tool}",
            f"TLDATA/MILL,{_text(tldata, 4)}",
            f"MSYS/{_text(frame[:3], 4)},{_text(frame[3:], 7)}",
            "$$ centerline data",
            f"SPINDL/RPM,{rpm},CLW ",
            "PAINT/PATH",
            "PAINT/SPEED,10",
        ]

    def end(self) -> None:
        """Close the operation."""
        self.lines += ["PAINT/SPEED,10", "PAINT/TOOL,NOMORE", "END-OF-PATH"]

    def rapid(self, point: ArrayLike, axis: ArrayLike = (0, 0, 1), color: int = RAPID) -> None:
        """One move in the air."""
        self._paint(color)
        self.lines.append("RAPID")
        self._goto(point, axis)
        self.counts["rapids"] += 1

    def cut(self, points: ArrayLike, feed: float, axes: ArrayLike = (0, 0, 1), color: int = CUT) -> None:
        """Moves at a feed: points (n, 3) or (3,), axes (n, 3) or one for all."""
        p = np.atleast_2d(np.asarray(points, dtype=float))
        a = np.broadcast_to(np.asarray(axes, dtype=float), p.shape)
        self._paint(color)
        self._fedrat(feed)
        for point, axis in zip(p, a, strict=True):
            self._goto(point, axis)

    def arc(
        self, center: ArrayLike, turns_about: ArrayLike, radius: float, end: ArrayLike, feed: float, color: int = CUT
    ) -> None:
        """An arc from where the tool is to `end`, right-handed about `turns_about`: NX prints that axis reversed."""
        self._paint(color)
        self._fedrat(feed)
        reversed_axis = -np.asarray(turns_about, dtype=float)
        rest = _text([radius, 0.06, 0.5, *self._tool], 4)
        self.lines.append(f"CIRCLE/{_text(center, 4)},{_text(reversed_axis, 7)},{rest}")
        self._goto(end, (0, 0, 1))
        self.counts["arcs"] += 1

    def drill(self, points: Iterable[ArrayLike], clearance: float, depth: float, feed: float) -> None:
        """A drilling cycle: each point is a hole's top."""
        self._paint(CUT)
        self.lines.append(f"CYCLE/DRILL,RAPTO,{clearance:.4f},FEDTO,{-depth:.4f},MMPM,{feed:.4f}")
        for point in points:
            self._goto(point, (0, 0, 1))
            self.counts["holes"] += 1
        self.lines.append("CYCLE/OFF")

    def text(self) -> str:
        """The file."""
        return "\n".join(self.lines) + "\n"

    def _paint(self, color: int) -> None:
        if color != self._color:
            self.lines.append(f"PAINT/COLOR,{color}")
            self._color = color

    def _fedrat(self, feed: float) -> None:
        if feed != self._feed:
            self.lines.append(f"FEDRAT/MMPM,{feed:.4f}")
            self._feed = feed

    def _goto(self, point: ArrayLike, axis: ArrayLike) -> None:
        printed = _text(axis, 7)
        self.lines.append(f"GOTO/{_text(point, 4)}" + (f",{printed}" if printed != self._axis else ""))
        self._axis = printed
        self.counts["points"] += 1
