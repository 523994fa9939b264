"""The state that APT statements act on: frame, units, feed, tool, and the regions that grow from the motions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Finding, Severity
from camrob.toolpath.apt.cycles import Cycle, expand_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect
from camrob.toolpath.apt.feed_units import Feed, FeedReader
from camrob.toolpath.apt.lexer import Rows
from camrob.toolpath.region import Event, EventKind, Move, Region
from camrob.toolpath.toolpath import Tool
from camrob.toolpath.toolpath_builder import RegionBuilder, clean_text

__all__ = ["LARGEST", "Curve", "Machine", "unit_axis"]

Curve = Callable[[NDArray[np.float64], NDArray[np.float64], int], None]
"""What goes along a curve to an end (3,), m, and a tool axis (3,) there, in the part's frame; of the line that names them."""

LARGEST = 1e9  # of any number in a file; beyond lies damage

AXIS_TOLERANCE = 1e-3  # a tool axis this far from length one is rounding; farther, it is a slip


def unit_axis(values: NDArray[np.float64], line: int) -> NDArray[np.float64]:
    """The tool axis (3,) at length one. Raises ToolpathError where it is further than 1e-3 from it."""
    length = float(np.linalg.norm(values))
    if not abs(length - 1.0) <= AXIS_TOLERANCE:
        raise ToolpathError(
            f"the tool axis has the length {length:.4f}, not 1", hint="correct i, j, k in the CAM system", line=line
        )
    return values / length


@dataclass(slots=True)
class _Mark:
    """A new operation has been announced; `hard` ones begin a region wherever the tool is."""

    name: str
    hard: bool


@dataclass(slots=True)
class Machine:
    """Interpreter state: positions and axes in the part's frame and in metres, but `axis_raw` as the file says."""

    dialect: Dialect
    chord: float
    angle: float
    feeds: FeedReader
    part_R_cl: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    part_p_cl: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    plain_frame: bool = True
    transformed: bool = False  # by TRACUT
    shifted: bool = False  # by TRANS
    axis_raw: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    axis_lost: bool = False  # the frame changed after the axis was stated: it must be stated again
    axis_inherited: bool = False  # a new operation, and the axis is still a tilted one of the operation before
    position: NDArray[np.float64] | None = None
    position_axis: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    position_line: int = 0
    lost: bool = False  # where the tool is is not known in the part since the last region's end
    region_detached: bool = False  # likewise, for the region that is being gathered
    rapid: bool = False
    spindle: str = ""  # the last sense that was stated
    turning: bool = False
    speed_given: bool = False  # at the set-up's speed, because the file has not started it
    unloaded: int = 0  # the line in which the tool was put away, 0 while one is loaded
    work_offset: float | None = None  # of the controller's, by its number, where the file names one
    world_points: bool = False  # TRNTYP has said so
    cycle: Cycle | None = None
    tool_number: int = 0
    tool_name: str = ""
    tool_by_number: bool = False  # the file has no LOAD or LOADTL: TOOLNO itself changes the tool
    next_tool_name: str = ""  # said before the tool is loaded
    cutter: tuple[float, float, float] = (0.0, 0.0, 0.0)  # diameter, corner radius, length in metres
    cutter_line: int = 0
    region_tool: Tool = field(default_factory=lambda: Tool(0))
    tools: dict[tuple[int, str], Tool] = field(default_factory=dict)
    program: str = ""
    operation: str = ""
    builder: RegionBuilder = field(default_factory=RegionBuilder)
    regions: list[Region] = field(default_factory=list)
    pending: list[tuple[EventKind, float, str, int]] = field(default_factory=list)
    mark: _Mark | None = None
    announced: int = 0  # how many operations have been announced
    findings: list[Finding] = field(default_factory=list)
    curve: Curve | None = None  # an arc that waits for its end
    curve_line: int = 0
    direction: NDArray[np.float64] | None = None  # INDIRV, in the part's frame
    settle: Callable[[int], None] | None = None  # makes a pending change of frame good, before the next motion
    sections: list[tuple[str, int]] = field(default_factory=list)  # what has been opened and must be closed: text, line

    @property
    def scale(self) -> float:
        """Metres in the file's unit of length."""
        return self.feeds.scale

    @property
    def handed(self) -> float:
        """1.0, or -1.0 where the points are mirrored: arcs about an axis then go the other way round."""
        return 1.0 if self.plain_frame or np.linalg.det(self.part_R_cl) > 0.0 else -1.0

    @property
    def rpm(self) -> float:
        """Programmed spindle speed, 0.0 where the file has stated none."""
        return self.feeds.rpm

    def find(self, code: str, text: str, line: int, severity: Severity = Severity.WARNING) -> None:
        """Note a finding; equal ones are counted together in the end."""
        self.findings.append(Finding(code, clean_text(text), severity, line))

    def cut_feed(self, line: int, own: Feed | None = None) -> float:
        """Feed (m/s) of a cut: its own, or the modal one. Raises ToolpathError where there is none or no tool."""
        if self.unloaded:
            raise ToolpathError(
                f"a cut without a tool: it was put away in line {self.unloaded}",
                hint="load a tool before it",
                line=line,
            )
        rpm = self.feeds.defaults.spindle_rpm
        if not self.feeds.rpm and rpm:  # the set-up's spindle is started for the first cut
            self.feeds.rpm, self.spindle, self.turning, self.speed_given = rpm, self.spindle or "CLW", True, True
        return self.feeds.speed(line, own)

    def cycle_feed(self, cycle: Cycle, line: int) -> float:
        """Feed (m/s) of a cycle: its own, or the modal one."""
        return self.cut_feed(line, None if cycle.feed is None else Feed(cycle.feed[0], cycle.feed[1], cycle.line))

    # -- spindle and tool ---------------------------------------------------------------------------------------

    def spindle_on(self, rpm: float, sense: str, line: int) -> None:
        """The spindle turns: at `rpm`, or (0) at the last speed, or the set-up's. Raises ToolpathError without any."""
        rpm = rpm or self.feeds.rpm
        if not rpm:
            rpm = self.feeds.defaults.spindle_rpm or 0.0
            if not rpm:
                raise ToolpathError(
                    "the spindle is switched on, and its speed is stated nowhere before",
                    hint="state it in SPINDL, or put spindle_rpm into setup.toml",
                    line=line,
                )
            text = f"the spindle is switched on without a speed: spindle_rpm of the set-up is used, {rpm:g} rev/min"
            self.find("spindle-speed-from-setup", text, line)
        self.feeds.rpm, self.spindle, self.turning, self.speed_given = rpm, sense, True, False
        self.event(EventKind.SPINDLE_ON, rpm, sense, line)

    def spindle_off(self, line: int) -> None:
        """The spindle stands; its last speed and sense are kept."""
        self.turning = self.speed_given = False
        self.event(EventKind.SPINDLE_OFF, 0.0, "", line)

    def change_tool(self, number: int, name: str, line: int, operation: str = "") -> None:
        """Another tool: a region begins, wherever the tool is. A spindle that the set-up has started goes on after it."""
        self.tool_number, self.tool_name, self.unloaded = number, name, 0
        self.announce(operation, hard=True)
        self.event(EventKind.TOOL_CHANGE, float(number), name, line)
        if self.speed_given:
            self.event(EventKind.SPINDLE_ON, self.feeds.rpm, self.spindle)

    # -- regions ------------------------------------------------------------------------------------------------

    def announce(self, name: str, *, hard: bool = False) -> None:
        """A new operation begins: a new region as soon as the tool is in the air (at once when `hard`).

        Events that wait happen before it, in the region that is being gathered; but what was said since an earlier
        announcement belongs to the new operation, unless a tool is changed now (`hard`) and none has been before.
        """
        changed = any(kind == EventKind.TOOL_CHANGE for kind, *_ in self.pending)
        if self.mark is None or (hard and not changed):
            self.flush_events()
        self.announced += 1
        already = self.mark is not None and self.mark.hard
        self.mark = _Mark(clean_text(name) or (self.mark.name if self.mark else self.operation), hard or already)

    def event(self, kind: EventKind, value: float = 0.0, text: str = "", line: int = 0) -> None:
        """Something that happens before the next motion."""
        self.pending.append((kind, value, text, line))

    def flush_events(self) -> None:
        """Give the waiting events to the region that is being gathered, where there is one."""
        if len(self.builder):
            self._hand_over()

    def finish_region(self) -> None:
        """Close the region that is being gathered, where it has points."""
        if not len(self.builder):
            return
        tool = self.region_tool
        self.tools[tool.number, tool.name] = tool
        name = self.operation or tool.name or self.program or "path"
        self.regions.append(
            self.builder.finish(name, tool=tool.number, operation=self.operation, detached=self.region_detached)
        )

    def lose(self) -> None:
        """The tool goes to a place that only the machine knows: the region ends here, the next one is detached."""
        self.flush_events()
        self.finish_region()
        self.position, self.lost = None, True

    def finish(self) -> None:
        """Close the last region; events that are left happen after its last point."""
        self.flush_events()
        self.finish_region()
        if self.pending and self.regions:
            last = self.regions[-1]
            tail = tuple(
                Event(len(last), kind, value, clean_text(t), ln, self.lost) for kind, value, t, ln in self.pending
            )
            self.regions[-1] = dataclasses.replace(last, events=last.events + tail)
        self.pending.clear()

    def _begin(self, rapid: bool) -> None:
        """Before a motion: begin the announced region where that is right, and hand over the events."""
        mark = self.mark
        in_air = rapid or not len(self.builder) or self.builder.last_move == Move.RAPID
        if mark is not None and (mark.hard or in_air):
            self.finish_region()
            self.operation = mark.name
            self.mark = None
        self._check_cutter()
        if not len(self.builder):
            self.region_tool = Tool(self.tool_number, self.tool_name, *self.cutter)
            self.region_detached, self.lost = self.lost and bool(self.regions), False
            self._hand_over()  # a tool is changed before it comes to where the cut starts
            if not rapid and self.position is not None:
                # the cut starts where the tool stands: that point belongs to the region, or the cut would be lost
                self.builder.point(self.position, self.position_axis, 0.0, Move.RAPID, self.position_line)
        self._hand_over()

    def _hand_over(self) -> None:
        """Give the waiting events to the region that is being gathered, before its next point."""
        for item in self.pending:
            self.builder.event(*item)
        self.pending.clear()

    def _check_cutter(self) -> None:
        """Say that the cutter's size changes while no tool is changed."""
        old = self.region_tool
        size = (old.diameter, old.corner_radius, old.length)
        known = bool(len(self.builder) or self.regions) and any(size)
        if known and size != self.cutter and (old.number, old.name) == (self.tool_number, self.tool_name):
            text = "the cutter's size changes and no tool is changed: the tool that is in the spindle goes on"
            self.find("cutter-changed", text, self.cutter_line)
            self.region_tool = Tool(old.number, old.name, *self.cutter)

    def take_work_offset(self, word: str, number: float | None, line: int) -> None:
        """A work offset of the controller's is the part's zero as long as it stays the same. Raises ToolpathError for another."""
        if number is None or self.work_offset not in (None, number):
            raise ToolpathError(
                f"{word} names another work offset than before: where it lies, the file doesn't say",
                hint="post the operations of each work offset by themselves",
                line=line,
            )
        self.work_offset = number

    # -- motions ------------------------------------------------------------------------------------------------

    def to_part(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 3) as the file has them, in the part's frame and in metres."""
        metres = values * self.scale
        return metres if self.plain_frame else metres @ self.part_R_cl.T + self.part_p_cl

    def tool_axis(self, line: int) -> NDArray[np.float64]:
        """The modal tool axis (3,) in the part's frame; ToolpathError where a change of frame left it undefined."""
        if self.axis_lost:
            raise ToolpathError(
                "the frame has changed, or MULTAX was switched off, where the tool is or becomes tilted,"
                " and the tool axis is not stated again",
                hint="output i, j, k on the first GOTO of each operation, and of what TRACUT or COPY tilts (MULTAX)",
                line=line,
            )
        if self.axis_inherited:
            self.axis_inherited = False
            self.find(
                "axis-inherited", "an operation states no tool axis: that of the operation before it is kept", line
            )
        return self.axis_raw if self.plain_frame else self.part_R_cl @ self.axis_raw

    def set_axis(self, raw: NDArray[np.float64], line: int) -> None:
        """State the tool axis (3,) in the file's own frame."""
        self.axis_raw = unit_axis(raw, line)
        self.axis_lost = self.axis_inherited = False

    def move(
        self, position: NDArray[np.float64], axis: NDArray[np.float64], move: Move, line: int, feed: float = 0.0
    ) -> None:
        """One point in the part's frame."""
        self._begin(move == Move.RAPID)
        self.builder.point(position, axis, feed, move, line)
        self.position, self.position_axis, self.position_line = position, axis, line

    def begin_curve(self, rapid: bool) -> None:
        """Before the points of a curve are added to the builder by hand."""
        self._begin(rapid)

    def goto(self, values: list[float], line: int) -> None:
        """One GOTO: 3 or 6 numbers as the file has them. Closes a waiting arc, drills a hole where a cycle is open."""
        if self.settle is not None:
            self.settle(line)
        if len(values) == 6:
            self.set_axis(np.array(values[3:]), line)
        axis = self.tool_axis(line)
        point = self.to_part(np.array(values[:3]))
        if self.curve is not None:
            curve, self.curve = self.curve, None
            curve(point, axis, line)
            return
        rapid, self.rapid = self.rapid, False
        if self.cycle is not None:
            expand_cycle(self, point, axis, line)
        else:
            still = self._stands_at(point, axis)
            rapid = self.builder.last_move == Move.RAPID if still else rapid
            feed = 0.0 if rapid else self.builder.last_feed if still else self.cut_feed(line)
            self.move(point, axis, Move.RAPID if rapid else Move.CUT, line, feed)

    def _stands_at(self, point: NDArray[np.float64], axis: NDArray[np.float64]) -> bool:
        """Whether a GOTO only repeats where the tool stands: it is no motion, and comes as the point before it came."""
        if not len(self.builder) or self.position is None or (self.mark is not None and self.mark.hard):
            return False
        return bool((point == self.position).all() and (axis == self.position_axis).all())

    @property
    def takes_rows(self) -> bool:
        """Whether a run of GOTO may be taken at once: no arc waits for its end and no cycle is open."""
        return self.curve is None and self.cycle is None

    def goto_rows(self, rows: Rows) -> None:
        """A run of GOTO at once, with the same result as one `goto` after the other."""
        if self.settle is not None:
            self.settle(int(rows.lines[0]))
        axes = self._axes(rows)
        large = np.flatnonzero(np.max(np.abs(rows.values[:, :3]), axis=1) > LARGEST)
        if len(large):
            raise ToolpathError(
                "GOTO holds a number out of range", hint="get the file again", line=int(rows.lines[large[0]])
            )
        points = self.to_part(rows.values[:, :3])
        axes = np.broadcast_to(axes, points.shape)
        still = self._repeats(points, axes)
        moving = np.maximum.accumulate(np.where(still, -1, np.arange(len(still))))  # the row that came to this place
        before = self.builder.last_move == Move.RAPID
        rapids = np.where(moving < 0, before, rows.rapids[np.maximum(moving, 0)])
        cuts = np.flatnonzero(~rapids & ~still)
        feed = self.cut_feed(int(rows.lines[cuts[0]])) if len(cuts) else 0.0
        feeds = np.where(moving < 0, self.builder.last_feed, feed)
        cut = 0
        if self.mark is not None and not self.mark.hard and len(self.builder) and not before:
            cut = int(np.argmax(rapids)) if rapids.any() else 0  # still cutting: the region begins with the first rapid
        for part in (slice(0, cut), slice(cut, None)):
            if len(points[part]):
                self._begin(bool(rapids[part][0]))
                moves = np.where(rapids[part], np.int8(Move.RAPID), np.int8(Move.CUT))
                self.builder.points(points[part], axes[part], feeds[part], moves, rows.lines[part])
                self.position, self.position_axis = points[part][-1], axes[part][-1]
                self.position_line = int(rows.lines[part][-1])

    def _repeats(self, points: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) whether a point only repeats the one before it (the first: where the tool stands)."""
        still = np.zeros(len(points), np.bool_)
        still[0] = self._stands_at(points[0], axes[0])
        still[1:] = (points[1:] == points[:-1]).all(axis=1) & (axes[1:] == axes[:-1]).all(axis=1)
        return still

    def _axes(self, rows: Rows) -> NDArray[np.float64]:
        """The tool axis of every row, (N, 3) or (3,) for all, in the part's frame: its own or the last one stated."""
        stated = rows.counts == 6
        if not stated.any():
            return self.tool_axis(int(rows.lines[0]))
        if not stated[0]:
            self.tool_axis(int(rows.lines[0]))
        raw = rows.values[stated, 3:6]
        length = np.linalg.norm(raw, axis=1)
        bad = np.flatnonzero(~(np.abs(length - 1.0) <= AXIS_TOLERANCE))
        if len(bad):
            unit_axis(raw[bad[0]], int(rows.lines[stated][bad[0]]))
        raw = raw / length[:, None]
        table = np.vstack([self.axis_raw, raw])
        axes: NDArray[np.float64] = table[np.cumsum(stated)]
        self.axis_raw, self.axis_lost, self.axis_inherited = raw[-1].copy(), False, False
        return axes if self.plain_frame else axes @ self.part_R_cl.T
