"""What must come out of a job, written down by hand: where the tool goes, how, and what happens in between.

A `Story` is told in the part's frame, in mm, degrees and mm/min, next to the CL text of the job and apart from it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mutation.arm import TOOL, frame

Array = NDArray[np.float64]
Triple = Sequence[float]
PRINTED_MM = 0.002  # what rounding to a micrometre moves a point and the arc that runs through it


@dataclass(frozen=True)
class Span:
    """The way from the point before to this one. place and axis: tip and unit tool axis in `base` at a share 0 .. 1.

    feed: mm/min, None in rapid. slack: mm that the file's own chord tolerance adds. arc: the tip leaves the straight line.
    open: mm at its start that have been cut before, so that they may be gone in rapid as well.
    """

    place: Callable[[float], Array]
    axis: Callable[[float], Array]
    feed: float | None
    slack: float = 0.0
    arc: bool = False
    turning: bool = False
    tool: int = 0
    open: float = 0.0


@dataclass
class Story:
    """Points 0 .. n - 1 (span k leads to point k; the way to point 0 is camrob's own), and what happens before each.

    part_in_base: the set-up's. tools: number -> `$TOOL` (0: any). do[k] happens before the tool leaves for point k.
    """

    part_in_base: tuple[float, ...] = (0.0, 0.0, 200.0, 0.0, 0.0, 0.0)
    tools: dict[int, tuple[float, ...]] = field(default_factory=lambda: {0: TOOL})
    tool: int = 0
    spans: list[Span] = field(default_factory=list)
    do: dict[int, list[tuple[str, float]]] = field(default_factory=dict)
    frame_T_part: Array = field(default_factory=lambda: np.eye(4))
    _tool: int = 0
    _here: Array | None = None
    _axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))

    def __len__(self) -> int:
        return len(self.spans)

    def use(self, xyzabc: Sequence[float] = (0, 0, 0, 0, 0, 0)) -> Story:
        """From here on points are in a frame that lies so in the part (an MSYS, a tilted plane)."""
        self.frame_T_part = frame(tuple(map(float, xyzabc)))
        return self

    def event(self, kind: str, value: float = 0.0) -> Story:
        """`change`, `cw`, `ccw`, `off`, `wet`, `dry`, `dwell`, `halt`, before the next point."""
        if kind == "change" and int(value) in self.tools:
            self._tool = int(value)
        self.do.setdefault(len(self.spans), []).append((kind, float(value)))
        return self

    def rapid(self, *xyz: float, axis: Triple | None = None) -> Story:
        return self._line(xyz, axis, None)

    def cut(self, feed: float, *xyz: float, axis: Triple | None = None, open: float = 0.0) -> Story:
        self._line(xyz, axis, feed)
        self.spans[-1] = replace(self.spans[-1], open=open)
        return self

    def follow(self, feed: float | None, *points: Triple) -> Story:
        """One point after the other."""
        for p in points:
            self._line(p, None, feed)
        return self

    def arc(
        self, feed: float, center: Triple, normal: Triple, degrees: float, rise: float = 0.0, slack: float = PRINTED_MM
    ) -> Story:
        """Right-handed about `normal` by `degrees` (negative: left-handed), rising evenly along it.

        A program may say it in chords that leave it by the hundredth of a millimetre that is allowed; `slack` comes on top.
        """
        if self._here is None:
            raise ValueError("an arc has no start")
        pose = self._pose
        c = (pose @ np.array([*center, 1.0]))[:3]
        n = pose[:3, :3] @ np.asarray(normal, float)
        n = n / np.linalg.norm(n)
        start, axis = self._here, self._axis
        foot = c + n * float((start - c) @ n)
        u, v = start - foot, np.cross(n, start - foot)

        def place(s: float) -> Array:
            angle = np.radians(degrees) * s
            return np.asarray(foot + np.cos(angle) * u + np.sin(angle) * v + n * (rise * s))

        self._add(Span(place, lambda s: axis, feed, slack, arc=True), place(1.0), axis)
        return self

    def bezier(self, feed: float, control: Sequence[Triple], slack: float = 0.0) -> Story:
        """A cubic curve by its four control points, from where the tool is."""
        points = np.array([(self._pose @ np.array([*c, 1.0]))[:3] for c in control])
        axis = self._axis

        def place(s: float) -> Array:
            weights = np.array([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s * s * (1 - s), s**3])
            return np.asarray(weights @ points)

        self._add(Span(place, lambda s: axis, feed, slack, arc=True), place(1.0), axis)
        return self

    def swing(self, feed: float | None, xyz: Triple, axis_at: Callable[[float], Triple], slack: float = 0.0) -> Story:
        """The tip straight to xyz, the axis as a function of the share (rotary axes in proportion)."""
        if self._here is None:
            raise ValueError("a swing has no start")
        pose, start = self._pose, self._here
        end = (pose @ np.array([*xyz, 1.0]))[:3]

        def axis(s: float) -> Array:
            return np.asarray(pose[:3, :3] @ np.asarray(axis_at(s), float))

        self._add(Span(lambda s: start + s * (end - start), axis, feed, slack, turning=True), end, axis(1.0))
        return self

    @property
    def _pose(self) -> Array:
        return np.asarray(frame(self.part_in_base) @ self.frame_T_part)

    def _line(self, xyz: Sequence[float], axis: Triple | None, feed: float | None) -> Story:
        pose = self._pose
        end = (pose @ np.array([*xyz, 1.0]))[:3]
        toward = self._axis if axis is None else pose[:3, :3] @ (np.asarray(axis, float) / np.linalg.norm(axis))
        if not self.spans and axis is None:
            toward = pose[:3, :3] @ np.array([0.0, 0.0, 1.0])
        start, before = (end, toward) if self._here is None else (self._here, self._axis)
        turning = float(np.linalg.norm(toward - before)) > 1e-9
        span = Span(lambda s: start + s * (end - start), lambda s: between(before, toward, s), feed, turning=turning)
        self._add(span, end, toward)
        return self

    def _add(self, span: Span, end: Array, axis: Array) -> None:
        self.spans.append(replace(span, tool=self._tool))
        self._here, self._axis = end, axis

    def point(self, k: int) -> Array:
        """Tip (3,) of point k in `base`."""
        return self.spans[k].place(1.0)

    def axis(self, k: int) -> Array:
        """Tool axis (3,) at point k in `base`."""
        return self.spans[k].axis(1.0)

    def points(self) -> Array:
        """All tips (n, 3), arcs with points along them."""
        tips = [self.point(0)]
        for span in self.spans[1:]:
            shares = np.linspace(0.05, 1.0, 20) if span.arc else (1.0,)
            tips += [span.place(float(s)) for s in shares]
        return np.array(tips)


def between(a: Array, b: Array, share: float) -> Array:
    """The unit vector at a share of the great arc from a to b."""
    turn = float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    if turn < 1e-12:
        return np.asarray(a + share * (b - a))
    return np.asarray((np.sin((1.0 - share) * turn) * a + np.sin(share * turn) * b) / np.sin(turn))
