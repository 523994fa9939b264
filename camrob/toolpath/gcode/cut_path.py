"""The path that a G-code program cuts, as it grows: points, arcs and events, cut into regions."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Finding, Severity
from camrob.machine_tool import rotary_axes
from camrob.toolpath.gcode.coordinates import Stance, Triple
from camrob.toolpath.region import EventKind, Move, Region
from camrob.toolpath.sampling import arc_angle, arc_radius, sample_arc
from camrob.toolpath.toolpath_builder import RegionBuilder, clean_text
from camrob.units import deg_to_rad

__all__ = ["PathGrower"]

_OFF_ARC = 0.05  # of what the tool axis turns on a piece: how far it may lie off the great arc
_OFF_ANYWAY = deg_to_rad(0.003)  # and this besides, a third of what a cut is held to
_SPLIT_ANGLE = deg_to_rad(10.0)
_SPLIT_COSINE = math.cos(_SPLIT_ANGLE)  # a rapid that turns the tool by more than 10 degrees opens a new region
_STILL = 1e-12  # rad: a tool that turns by less stands still
_MOST_STEPS = 100_000  # of one block's rotary move
_FAR = 1000.0  # m from the origin: no part
_OPERATION = re.compile(r"\bOPERATION\b\s*[:=]?\s*(.*)", re.IGNORECASE)
_CLOSING = re.compile(r"^\W*(?:finish|end)\b", re.IGNORECASE)


class PathGrower:
    """Takes the moves of a program one after the other; `finish` gives the regions.

    A new region begins with a tool change, where the tool's place is lost (a move to a machine position), and where
    rapids turn the tool by more than 10 degrees from the last cut: not with every retract. Rapids without any cut
    behind them in their region are left out, as are those before one rapid that turns the tool by more than 10 degrees
    ahead of the first cut; their events stay.
    """

    def __init__(self, kinematics: str, chord_tolerance: float, angle_tolerance: float) -> None:
        self._kinematics = kinematics.removesuffix("-iso")
        self.chord = chord_tolerance
        self.angle = angle_tolerance
        self._builder = RegionBuilder()
        self._regions: list[Region] = []
        self._last: Stance | None = None  # None: not known where the tool is
        self._lost = False  # that has been so since the last region's end, or rapids behind it are left out
        self._cut_axis: Triple | None = None  # of the last cut in the open region
        self._operation = ""
        self._open_operation = ""
        self._names: dict[str, int] = {}
        self._notes: dict[tuple[str, str], list[int]] = {}
        self._severity: dict[tuple[str, str], Severity] = {}
        self.tool = 0
        self.adrift = False  # where the tool stands is not known, and it may be at the part

    # -- what is said ------------------------------------------------------------------------------------------

    def note(self, code: str, text: str, line: int, severity: Severity = Severity.WARNING) -> None:
        """Remember a finding; the same one again only counts."""
        entry = self._notes.setdefault((code, text), [0, line])
        entry[0] += 1
        self._severity[(code, text)] = severity

    def findings(self) -> tuple[Finding, ...]:
        """All that was said, once a kind, with count and first line."""
        return tuple(
            Finding(code, text, self._severity[(code, text)], line=line, count=count)
            for (code, text), (count, line) in self._notes.items()
        )

    def comment(self, text: str, line: int) -> None:
        """A comment: an operation's name, a message to the operator, or nothing."""
        head, _, tail = text.partition(",")
        if head.strip().upper() == "MSG":
            self.event(EventKind.MESSAGE, 0.0, tail.strip(), line)
        elif not _CLOSING.match(text) and (match := _OPERATION.search(text)):
            name = clean_text(match[1])[:80]
            self._operation = f"operation {name}" if name.isdigit() else name or self._operation

    # -- motion ------------------------------------------------------------------------------------------------

    @property
    def place(self) -> Stance | None:
        """Where the tool is, None while that isn't known."""
        return self._last

    def event(self, kind: EventKind, value: float = 0.0, text: str = "", line: int = 0) -> None:
        """Something that happens before the next move."""
        self._builder.event(kind, value, text[:200], line)

    @property
    def cutting(self) -> bool:
        """Whether the last move was a cut: the tool is in the part."""
        return self._builder.last_move == Move.CUT

    def change_tool(self, number: int, line: int) -> None:
        """A tool change: the region ends here."""
        self.close()
        self.tool = number
        self.event(EventKind.TOOL_CHANGE, float(number), "", line)

    def put_tool_away(self) -> None:
        """The spindle is empty from here on: the region ends."""
        self.close()
        self.tool = 0

    def lose(self, *, home: bool = False) -> None:
        """The tool goes to a place that only the machine knows: the region ends, the next begins with a known point.

        home: it is one of the machine's, above the part, or the program has named no other yet.
        """
        self.close()
        self._last, self._lost, self.adrift = None, True, not home

    def rapid(self, to: Stance, line: int) -> None:
        """A rapid move in a straight line of the tip; small turns of the rotary axes are followed."""
        _check(to.tip)
        last = self._last
        turning = self._cut_axis if self._cut_axis is not None or last is None else last.axis
        if turning is not None and _dot(to.axis, turning) < _SPLIT_COSINE:
            self.close()
            last = None
        self._last = to
        if last is not None and len(self._builder):
            if last.axis != to.axis and self._axis_way(last, to) <= _SPLIT_ANGLE:
                self._turning(last, to, math.nan, Move.RAPID, line)
                return
            if last.tip == to.tip and last.axis == to.axis:
                return
        self._builder.point(to.tip, to.axis, math.nan, Move.RAPID, line)

    def cut(self, to: Stance, feed: float, line: int) -> None:
        """A cutting move: tip on a straight line at `feed` (m/s), rotary axes in proportion."""
        _check(to.tip)
        last = self._last
        turns = last is not None and last.angles != to.angles
        if last is not None and last.tip == to.tip and last.axis == to.axis:
            if not turns or self._axis_way(last, to) < _STILL:
                self._last = to
                return
        self._begin(line)
        self._last = to
        self._cut_axis = to.axis
        if last is None or (last.axis == to.axis and not turns):
            self._builder.point(to.tip, to.axis, feed, Move.CUT, line)
        else:
            self._turning(last, to, feed, Move.CUT, line)

    def arc(
        self, to: Stance, center: NDArray[np.float64], normal: NDArray[np.float64], turns: int, feed: float, line: int
    ) -> None:
        """A circle or helix, right-handed about `normal` through `center` (part frame, m), at `feed` (m/s)."""
        _check(to.tip)
        last = self._last
        if last is None:
            raise ToolpathError("an arc from an unknown place", hint="name X, Y and Z in a move before it")
        self._begin(line)
        start, end = np.array(last.tip), np.array(to.tip)
        rise = float((end - start) @ normal)
        points = sample_arc(start, end, center, normal, rise, turns, self.chord, self.angle)
        radius, other = arc_radius(start, center, normal), arc_radius(end, center, normal)
        angle = arc_angle(start, end, center, normal, turns)
        self._last = to
        self._cut_axis = to.axis
        if last.angles != to.angles or last.axis != to.axis:
            share = np.arange(1, len(points) + 1) / len(points)
            self._builder.points(points, self._axes(last, to, share), feed, Move.CUT, line)
        elif abs(rise) < 1e-9 and abs(radius - other) <= self.chord and angle < math.tau * (1.0 + 1e-9):
            level = center + normal * float((start - center) @ normal)
            self._builder.arc(points, level, normal, radius, angle, to.axis, feed, line)
        else:
            self._builder.points(points, to.axis, feed, Move.CUT, line)

    def _begin(self, line: int) -> None:
        """A region whose first move is a cut starts where the tool stands, if that is known."""
        if not len(self._builder):
            if self._last is not None:
                self._builder.point(self._last.tip, self._last.axis, math.nan, Move.RAPID, line)
            self._open_operation = self._operation
        elif self._cut_axis is None:
            self._open_operation = self._operation

    def _turning(self, last: Stance, to: Stance, feed: float, move: Move, line: int) -> None:
        """Points of a move that turns rotary axes: neighbouring tool axes differ by the angle tolerance at most, and between them
        the tool axis keeps near the great arc from the one to the other, which is the way that a robot takes.
        """
        way = self._axis_way(last, to)
        steps = max(1, math.ceil(way / self.angle - 1e-9))
        while steps <= _MOST_STEPS and not self._keeps_near(last, to, steps):
            steps *= 2
        if steps > _MOST_STEPS:
            raise ToolpathError(
                f"a rotary move through {way / math.tau:.0f} turns would need more than {_MOST_STEPS} points",
                hint="check the rotary words, or choose a coarser angle tolerance",
            )
        if steps == 1:
            self._builder.point(to.tip, to.axis, feed, move, line)
            return
        share = np.arange(1, steps + 1) / steps
        start, end = np.array(last.tip), np.array(to.tip)
        points = start + share[:, None] * (end - start)
        points[-1] = end
        self._builder.points(points, self._axes(last, to, share), feed, move, line)

    def _keeps_near(self, last: Stance, to: Stance, steps: int) -> bool:
        """Whether the middle of each of so many pieces lies near the great arc between its ends."""
        if not (last.rotary and to.rotary):
            return True
        axes = np.vstack([last.axis, self._axes(last, to, np.arange(1, 2 * steps + 1) / (2 * steps))])
        begin, middle, end = axes[:-1:2], axes[1::2], axes[2::2]
        on_arc = begin + end
        length = np.linalg.norm(on_arc, axis=1, keepdims=True)
        off = np.linalg.norm(middle - on_arc / np.maximum(length, 1e-12), axis=1)
        return bool(np.all(off <= _OFF_ARC * np.linalg.norm(end - begin, axis=1) + _OFF_ANYWAY))

    def _axis_way(self, last: Stance, to: Stance) -> float:
        """At most how far (rad) the tool axis travels between two stances while the rotary axes go in proportion."""
        if not (last.rotary and to.rotary):
            return math.acos(max(-1.0, min(1.0, _dot(last.axis, to.axis))))
        tilt0, tilt1 = (s.angles[0] if self._kinematics == "xyzac" else s.angles[1] for s in (last, to))
        swing = abs(tilt1 - tilt0)
        widest = min(1.0, max(abs(math.sin(tilt0)), abs(math.sin(tilt1))) + swing)
        return math.hypot(swing, widest * (to.angles[2] - last.angles[2]))

    def _axes(self, last: Stance, to: Stance, share: NDArray[np.float64]) -> NDArray[np.float64]:
        """Tool axes (N, 3) at shares of the way, with the rotary angles in proportion; the last is exact."""
        if to.vector:
            return _great_arc(np.array(last.axis), np.array(to.axis), share)
        if not (last.rotary and to.rotary):
            raise ToolpathError(
                "the tool turns during a cut between a tilted plane and rotary words", hint="turn it in a rapid move"
            )
        before, after = np.array(last.angles), np.array(to.angles)
        axes = rotary_axes(self._kinematics, before + share[:, None] * (after - before))
        axes[-1] = to.axis
        return axes

    # -- regions -----------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End the open region; without a cut its points go, its events wait for the next one."""
        builder = self._builder
        if not builder.events and not len(builder):
            return
        had_cut = self._cut_axis is not None
        operation = self._open_operation if had_cut else ""
        region = builder.finish(
            self._name(operation) if had_cut else "",
            tool=self.tool,
            operation=operation,
            detached=self._lost and bool(self._regions),
        )
        self._cut_axis = None
        if had_cut:
            self._regions.append(region)
            self._lost = False
        elif len(region):
            self._lost = True
        for event in () if had_cut else region.events:
            builder.event(event.kind, event.value, event.text, event.line)

    def _name(self, operation: str) -> str:
        """A name for the region that no earlier one has."""
        base = operation or "region"
        count = self._names[base] = self._names.get(base, 0) + 1
        return f"{base} {count}" if count > 1 or not operation else base

    def finish(self) -> tuple[Region, ...]:
        """The regions; events after the last cut belong to the last region's end. Raises where nothing is cut."""
        self.close()
        if not self._regions:
            raise ToolpathError(
                "nothing is cut: the program has no G1, G2, G3 or cycle", hint="check that it is complete"
            )
        left = self._builder.finish("")
        if left.events:
            last = self._regions[-1]
            late = tuple(dataclasses.replace(e, point=len(last), retracted=self._lost) for e in left.events)
            self._regions[-1] = dataclasses.replace(last, events=last.events + late)
        return tuple(self._regions)


def _great_arc(start: NDArray[np.float64], end: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (N, 3) at shares (N,) of the turn from one unit vector to the other. Raises for opposite ones."""
    across = np.cross(start, end)
    sine, cosine = float(np.linalg.norm(across)), float(start @ end)
    if sine < _STILL and cosine < 0.0:
        raise ToolpathError("the tool turns right over: which way is not said", hint="name a direction between the two")
    angle = math.atan2(sine, cosine)
    if sine < _STILL:
        return np.broadcast_to(end, (len(share), 3)).copy()
    axes = (np.sin((1.0 - share) * angle)[:, None] * start + np.sin(share * angle)[:, None] * end) / sine
    axes[-1] = end
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def _dot(a: Triple, b: Triple) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _check(tip: Triple) -> None:
    """Refuse a point that no machine reaches."""
    x, y, z = tip
    if not (-_FAR < x < _FAR and -_FAR < y < _FAR and -_FAR < z < _FAR):
        raise ToolpathError(
            "a point more than a kilometre away from the origin", hint="check the coordinates and units"
        )
