"""Between which of a program's motions the steps of its process stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.program.process import SPINDLE_HOOKS, Place, Process, Step
from camrob.program.program import ProgramEvent, ProgramEventKind
from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.toolpath.region import EventKind, Region

__all__ = ["ProgramRows", "RegionPoints", "program_events"]

Indices = NDArray[np.int64]


class RegionPoints:
    """Where in a path the points of its regions stand. A point that repeats the one before it stands where that one does."""

    def __init__(self, path: ToolPathInBase, regions: Sequence[Region]) -> None:
        self.path, self.regions = path, regions
        self.own = np.flatnonzero(path.of_toolpath)
        self.bounds = np.searchsorted(path.region[self.own], np.arange(len(regions) + 1))

    def of(self, region: int) -> Indices:
        """Path points (K,) of a region's own, none where all repeat the end of the region before."""
        return np.asarray(self.own[self.bounds[region] : self.bounds[region + 1]])

    def place(self, region: int) -> Indices:
        """(n,) path point for each of the region's points."""
        here = self.of(region)
        known = np.searchsorted(self.path.source[here], np.arange(len(self.regions[region])), side="right") - 1
        return np.where(known >= 0, here[np.maximum(known, 0)] if len(here) else 0, self.before(region))

    def before(self, region: int) -> int:
        """The last path point of a region before this one, -1 for the first."""
        return int(self.own[self.bounds[region] - 1]) if self.bounds[region] else -1

    def left(self, step: Step) -> int:
        """The path point at which a step within a region, or at its end, happens."""
        here = self.of(step.region)
        if step.place is Place.END:
            return int(here[-1]) if len(here) else self.before(step.region)
        known = int(np.searchsorted(self.path.source[here], step.point, side="left")) - 1
        return int(here[known]) if known >= 0 else self.before(step.region)

    def marked(self, process: Process) -> list[int]:
        """Path points that a motion has to end at: a region's first, and where something happens."""
        firsts = [int(self.of(k)[0]) for k in range(len(self.regions)) if len(self.of(k))]
        return firsts + [self.left(s) for s in process.steps if s.place in (Place.INSIDE, Place.END)]


class ProgramRows:
    """The rows of a program, HOME and the like among them: point (M,) the path point that each leads to, -1 for none."""

    def __init__(self, points: RegionPoints, point: Indices) -> None:
        self.points, self.count = points, len(point)
        self.rows = np.flatnonzero(point >= 0)
        self.point = point[self.rows]

    def at(self, point: int) -> int:
        """The first row that leads to a path point, or to one behind it."""
        k = int(np.searchsorted(self.point, point, side="left"))
        return int(self.rows[k]) if k < len(self.rows) else int(self.rows[-1]) + 1

    def after(self, point: int) -> int:
        """The row behind all that lead to a path point."""
        return int(self.rows[int(np.searchsorted(self.point, point, side="right")) - 1]) + 1

    def start(self, region: int) -> int:
        """The row of a region's first motion."""
        here = self.points.of(region)
        return self.at(int(here[0])) if len(here) else self.after(self.points.before(region))

    def row(self, step: Step) -> int:
        """The row that a step stands before."""
        k = step.region
        if step.place in (Place.INSIDE, Place.END):
            return self.after(self.points.left(step)) if self.points.left(step) >= 0 else self.start(k)
        if k == 0:  # behind HOME; what mounts the first tool, where that is done
            return int(self.rows[0]) if step.place is Place.CHANGE else 1
        path = self.points.path
        if k == len(self.points.regions):
            last = self.after(len(path) - 1)
            return last if step.place is Place.CLEAR else max(self.count - 1, last + 1)
        here = self.points.of(k)
        before = self.points.before(k)
        if len(here) and path.stretch[here[0]] != path.stretch[before]:  # by way of the pose for changes
            first = self.at(int(np.searchsorted(path.stretch, path.stretch[here[0]])))
            return first if step.place is Place.CHANGE else first - 1
        start = self.start(k)
        between = np.flatnonzero(path.region[before + 1 : int(here[0]) if len(here) else before + 1] == TRANSIT)
        return max(start - 1, self.at(before + 1 + int(between[0])) + 1) if len(between) else start


def program_events(
    process: Process, rows: ProgramRows, tools: Mapping[int, int], loads: Mapping[int, int]
) -> tuple[tuple[ProgramEvent, ...], tuple[int, ...]]:
    """What is written between motions, in order, and the row that each step stands before.

    tools: the regions before which the tool's frame becomes another one, and its index in the program's `tools`. loads: likewise
    those before which the load does, and its index in `loads`; at region 0 it is set before the first motion.
    """
    events = [ProgramEvent(0, ProgramEventKind.LOAD, value=float(loads[0]))] if 0 in loads else []
    placed: list[int] = []
    regions = rows.points.regions
    opened = 0
    last_change = {s.region: n for n, s in enumerate(process.steps) if s.kind is EventKind.TOOL_CHANGE}

    def open_to(region: int) -> None:
        nonlocal opened
        while opened < min(region, len(regions)):
            row = rows.row(Step(Place.CLEAR, opened, 0, EventKind.MESSAGE))
            events.append(ProgramEvent(row, ProgramEventKind.REGION, regions[opened].name))
            opened += 1

    for n, step in enumerate(process.steps):
        open_to(step.region + 1)
        row = rows.row(step)
        placed.append(row)
        events += [ProgramEvent(row, *event) for event in _events_of(step)]
        if last_change.get(step.region) == n and step.region in tools:
            events.append(ProgramEvent(row, ProgramEventKind.TOOL, value=float(tools[step.region])))
        if last_change.get(step.region) == n and step.region in loads and step.region > 0:
            events.append(ProgramEvent(row, ProgramEventKind.LOAD, value=float(loads[step.region])))
    open_to(len(regions))
    row = 0
    in_order = []
    for event in events:  # nothing overtakes what the file has before it
        row = max(row, event.motion)
        in_order.append(ProgramEvent(row, event.kind, event.text, event.value))
    return tuple(in_order), tuple(placed)


def _events_of(step: Step) -> list[tuple[ProgramEventKind, str, float]]:
    """What a step writes: kind, text and value of events."""
    if step.kind is EventKind.DWELL:
        return [(ProgramEventKind.DWELL, "", step.value)]
    if step.kind is EventKind.MESSAGE:
        return [(ProgramEventKind.COMMENT, step.text, 0.0)]
    if step.kind is EventKind.SPINDLE_ON:
        return [(ProgramEventKind.HOOK, SPINDLE_HOOKS[step.text], step.value)]
    hook = (ProgramEventKind.HOOK, step.kind.value, step.value)  # hooks bear the names of what happens
    if step.kind is EventKind.TOOL_CHANGE and step.value <= 0.0:  # the file names a tool without a number
        named = (ProgramEventKind.COMMENT, f"tool {step.text}", 0.0)
        return [named, hook] if step.region else [named]
    return [hook]
