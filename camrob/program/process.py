"""What happens beside moving, from the CL file's events to the program's: in the file's order, with what safety adds.

Between two motions of the file stands what the file has between them. What stands between two regions happens in the clear. A
tool is changed with spindle and coolant off; the spindle turns the other way only after it was off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.findings import Finding
from camrob.program.demanded_hooks import demand_hook
from camrob.toolpath.region import Event, EventKind, Move, Region, goes_on

__all__ = ["SPINDLE_HOOKS", "Place", "Process", "Step", "ToolChange", "plan_process", "tool_changes"]

SPINDLE_HOOKS = {"CLW": "spindle_on", "CCLW": "spindle_on_ccw"}
_SENSES = {"CLW": "clockwise", "CCLW": "counter-clockwise"}
_RUNNING = "the program stops for the operator while the spindle turns; most machine tools stop it there"
_COOLANT = (EventKind.COOLANT_ON, EventKind.COOLANT_OFF)
_SAME_PLACE = 1e-9  # m
_IN_PART = {  # what is said of a cut that is interrupted, as the file has it
    EventKind.SPINDLE_ON: (
        "spindle-in-part",
        "the spindle is switched to another speed or sense in the middle of a cut: the tool waits in the part meanwhile",
    ),
    EventKind.SPINDLE_OFF: (
        "spindle-in-part",
        "the spindle is switched off in the middle of a cut, the tool in the part",
    ),
    EventKind.STOP: ("stop-in-part", "the program stops for the operator in the middle of a cut, the tool in the part"),
}


class Place(IntEnum):
    """Where a step stands."""

    INSIDE = 0  # right after the motion to the point of the region before `point`
    END = 1  # right after the region's last motion
    CLEAR = 2  # in the clear, on the way to the region (their number: on the way from the last one)
    CHANGE = 3  # on that way too, where tools are changed


@dataclass(frozen=True, slots=True)
class Step:
    """Something that happens, in the program's order. `region` counts those with points; `point` is within it.

    kind, value, text, line: as in `Event`; the text of SPINDLE_ON is "CLW" or "CCLW". added: camrob's own.
    """

    place: Place
    region: int
    point: int
    kind: EventKind
    value: float = 0.0
    text: str = ""
    line: int = 0
    added: bool = False


@dataclass(frozen=True, slots=True)
class ToolChange:
    """A change of tools before a region (their number: after the last one); `number` 0 where the file only names the tool."""

    region: int
    number: int
    name: str
    line: int


@dataclass(frozen=True, slots=True)
class Process:
    """All that happens, in order. in_file: how many events of the file they come from, messages to the operator left out.

    urgent: findings to be read first of all.
    """

    steps: tuple[Step, ...]
    changes: tuple[ToolChange, ...]
    in_file: int
    urgent: tuple[Finding, ...] = ()
    findings: tuple[Finding, ...] = ()

    @property
    def mounts_first(self) -> bool:
        """Whether the program itself has the first tool mounted."""
        return any(s.place is Place.CHANGE and s.region == 0 for s in self.steps)

    @property
    def in_program(self) -> int:
        """How many steps the program holds, messages to the operator left out."""
        return sum(step.kind is not EventKind.MESSAGE for step in self.steps)


@dataclass(slots=True)
class _Events:
    """A region's events: what the file has before it and since the region before, within it, and after its last motion."""

    before: list[Event] = field(default_factory=list)
    within: list[Event] = field(default_factory=list)
    after: list[Event] = field(default_factory=list)


def tool_changes(regions: Sequence[Region]) -> tuple[ToolChange, ...]:
    """The changes behind the first region's tool; what mounts that one comes before all motion and is none."""
    worked = [r for r in regions if len(r)]
    sorted_out = _sorted_out(regions)
    found = []
    for k, events in enumerate(sorted_out[1:], start=1):
        said = [e for e in (*sorted_out[k - 1].after, *events.before) if e.kind is EventKind.TOOL_CHANGE]
        if said:
            number = worked[k].tool if k < len(worked) else max(int(said[-1].value), 0)
            found.append(ToolChange(k, number, said[-1].text, said[-1].line))
        elif k < len(worked) and worked[k].tool != worked[k - 1].tool:  # no reader leaves the event out
            found.append(ToolChange(k, worked[k].tool, "", worked[k].first_line))
    return tuple(found)


def plan_process(regions: Sequence[Region], cell: Cell) -> Process:
    """The steps of a toolpath's regions on a cell.

    Raises JobError, with the CL line and what to do, where the cell can't do what the file asks for: a sense or a speed that
    its spindle lacks, a change of tools without a hook or within a cut, a cut behind a change with the spindle not started again.
    """
    return _Planner([r for r in regions if len(r)], _sorted_out(regions), tool_changes(regions), cell).result()


def _sorted_out(regions: Sequence[Region]) -> list[_Events]:
    """The events of the regions with points, and one entry more for what no region is left for."""
    out: list[_Events] = [_Events()]
    before: Region | None = None
    for region in regions:
        if not len(region):
            out[-1].before += region.events
            continue
        opening = _opening(region, before)
        for event in region.events:
            if event.point <= opening:
                out[-1].before.append(event)
            elif event.point < len(region):
                out[-1].within.append(event)
            else:
                out[-1].after.append(event)
        out.append(_Events())
        before = region
    return out


def _opening(region: Region, before: Region | None) -> int:
    """The region's last point that the tool has still to leave for when the region opens.

    A region that begins with a cut is given the place where the tool stands as its first point: what the file says before that
    cut stands behind that point and belongs to the opening.
    """
    if len(region) < 2 or region.move[0] != Move.RAPID:
        return 0
    stood = (
        before is not None
        and not region.detached
        and bool(np.all(np.abs(region.position[0] - before.position[-1]) <= _SAME_PLACE))
    )
    changed = any(e.point == 1 and e.kind is EventKind.TOOL_CHANGE for e in region.events)
    return int(stood or changed)


class _Planner:
    """Goes through the events and keeps what is on."""

    def __init__(
        self, regions: list[Region], events: list[_Events], changes: tuple[ToolChange, ...], cell: Cell
    ) -> None:
        self.regions, self.events, self.cell = regions, events, cell
        self.changes = {c.region: c for c in changes}
        self.steps: list[Step] = []
        self.urgent: list[Finding] = []
        self.findings: list[Finding] = []
        self.spindle = ""  # its sense, while it is on
        self.stopped: ToolChange | None = None  # the change that stopped it, until the file speaks of it again
        self.coolant: Step | None = None  # what switched it on, while it is on
        self.asked: list[Event] = []  # for spindle speeds
        self.kinds: dict[str, int] = {}  # of coolant that the file asks for, with the first line of each

    def result(self) -> Process:
        """All steps, and what there is to say of them."""
        for k, region in enumerate(self.regions):
            self._between(k)
            at = 0
            for event in self.events[k].within:
                self._cuts(region, at, event.point)
                at = event.point
                self._take(event, Place.INSIDE, k)
            self._cuts(region, at, len(region))
        self._between(len(self.regions))
        self._speeds()
        self._coolants()
        all_events = [e for group in self.events for e in (*group.before, *group.within, *group.after)]
        in_file = sum(e.kind is not EventKind.MESSAGE for e in all_events)
        changes = tuple(self.changes.values())
        return Process(tuple(self.steps), changes, in_file, tuple(self.urgent), tuple(self.findings))

    def _between(self, k: int) -> None:
        """What happens between region k - 1 and region k. A dwell behind the last motion, and what is before it, stays there."""
        after = self.events[k - 1].after if k else []
        dwells = [n for n, e in enumerate(after) if e.kind is EventKind.DWELL and not e.retracted]
        at_end = (
            dwells[-1] + 1 if dwells and not any(e.kind is EventKind.TOOL_CHANGE for e in after[: dwells[-1]]) else 0
        )
        for event in after[:at_end]:
            self._take(event, Place.END, k - 1)
        events = [*after[at_end:], *self.events[k].before]
        change = self.changes.get(k)
        if change is not None and not any(e.kind is EventKind.TOOL_CHANGE for e in events):
            said = Event(0, EventKind.TOOL_CHANGE, float(change.number), change.name, change.line)
            events.insert(len(after) - at_end, said)
        place: Place = Place.CLEAR
        wet: Step | None = None  # the coolant that a change interrupts
        for event in events:
            mounted = self._mounts(event, k)
            if mounted is not None:
                wet = self.coolant or wet
                self._stop_for(mounted, place, k)
                place = Place.CHANGE
            elif event.kind in _COOLANT:
                wet = None
            self._take(event, place, k)
        if wet is not None and k < len(self.regions) and not self._speaks_of_coolant(k):
            self._add(Place.CHANGE, k, EventKind.COOLANT_ON, wet.value, wet.text, wet.line)

    def _speaks_of_coolant(self, k: int) -> bool:
        """Whether the file itself switches the coolant in region k before it cuts there."""
        region = self.regions[k]
        cuts = np.flatnonzero(np.asarray(region.move) == Move.CUT)
        first = int(cuts[0]) if len(cuts) else len(region)
        return any(e.kind in _COOLANT and e.point <= first for e in self.events[k].within)

    def _mounts(self, event: Event, k: int) -> ToolChange | None:
        """The change that an event before region k asks for; the first tool counts where the program has to do something."""
        if event.kind is not EventKind.TOOL_CHANGE:
            return None
        if k == 0 and not (event.value > 0.0 and self._hook("tool_change")):
            return None  # the operator mounts what the program names
        return ToolChange(k, max(int(event.value), 0), event.text, event.line)

    def _take(self, event: Event, place: Place, k: int) -> None:
        """One event of the file."""
        point = event.point if place is Place.INSIDE else 0
        self._say_in_part(event, place, k)
        value, text = event.value, event.text
        if event.kind is EventKind.TOOL_CHANGE:
            self._demand_change(event, place, k)
        elif event.kind is EventKind.SPINDLE_ON:
            text = "CCLW" if event.text == "CCLW" else "CLW"
            self._demand_spindle(event, text)
            if self.spindle not in ("", text):
                self._stop(place, k, point, event.line)
            self.spindle, self.stopped = text, None
            self.asked.append(event)
        elif event.kind is EventKind.SPINDLE_OFF:
            self.spindle, self.stopped = "", None
        elif event.kind is EventKind.COOLANT_OFF:
            self.coolant = None
        elif event.kind is EventKind.STOP and self.spindle:
            self.findings.append(Finding("stop-running", _RUNNING, line=event.line))
        step = Step(place, k, point, event.kind, value, text, event.line)
        if event.kind is EventKind.COOLANT_ON:
            self.coolant = step
            self.kinds.setdefault(event.text or "ON", event.line)
        missing = demand_hook(event, self.cell)
        if missing is not None:
            self.findings.append(missing)
        self.steps.append(step)

    def _hook(self, name: str) -> tuple[str, ...]:
        return tuple(self.cell.controller.hooks.get(name, ()))

    def _add(
        self, place: Place, k: int, kind: EventKind, value: float = 0.0, text: str = "", line: int = 0, point: int = 0
    ) -> None:
        """A step of camrob's own."""
        self._take(Event(point, kind, value, text, line), place, k)
        step = self.steps[-1]
        self.steps[-1] = Step(step.place, k, step.point, kind, value, text, line, added=True)

    def _stop(self, place: Place, k: int, point: int, line: int) -> None:
        """The spindle off, before it turns the other way or the tool is changed."""
        if not self._hook("spindle_off"):
            raise JobError(
                f"cell {self.cell.name} can't stop its spindle, which has to be off here; add spindle_off to its hooks",
                line=line,
            )
        self._add(place, k, EventKind.SPINDLE_OFF, line=line, point=point)

    def _stop_for(self, change: ToolChange, place: Place, k: int) -> None:
        """Spindle and coolant off, as far as they are on, before a tool is changed."""
        if self.spindle:
            self._stop(place, k, 0, change.line)
            self.stopped = change
        if self.coolant is not None:
            self._add(place, k, EventKind.COOLANT_OFF, line=change.line)

    def _demand_change(self, event: Event, place: Place, k: int) -> None:
        """Raise JobError for a change of tools that the cell can't make."""
        if place in (Place.INSIDE, Place.END):
            raise JobError(
                "a tool is changed in the middle of an operation; begin a new operation with each tool", line=event.line
            )
        if 0 < k < len(self.regions) and goes_on(self.regions[k - 1], self.regions[k]):
            raise JobError(
                "the tool is changed in the middle of a cut, and the file names no way out of the part and in again; output "
                "a retract (RAPID, GOTO) before the change and an approach behind it",
                line=event.line,
            )
        hook = self._hook("tool_change")
        if k == 0 and self._mounts(event, k) is None:
            return
        if not hook:
            what = f"cell {self.cell.name} has no hook tool_change; add it, or post the operations of each tool by themselves"
            raise JobError(what, line=event.line)
        if not event.value > 0.0 and any("{number}" in line.partition(";")[0] for line in hook):
            what = f"tool {event.text!r} has no number, and the cell's tool_change needs one; number the tools in the CAM system"
            raise JobError(what, line=event.line)

    def _demand_spindle(self, event: Event, sense: str) -> None:
        """Raise JobError for a sense or a speed that the cell's spindle lacks."""
        name, way = self.cell.name, _SENSES[sense]
        limits = self.cell.controller.spindle_rpm
        if not (math.isfinite(event.value) and event.value > 0.0):
            raise JobError(
                "the spindle is started without a speed; state it, or give spindle_rpm in setup.toml", line=event.line
            )
        if not self._hook(SPINDLE_HOOKS[sense]):
            what = f"the file asks for the spindle {way}, for which cell {name} has no hook"
            hint = (
                f"add {SPINDLE_HOOKS[sense]} to [controller.hooks] if the spindle can do it, else change the operation"
            )
            raise JobError(f"{what}; {hint}", line=event.line)
        if limits is not None and not limits[0] <= event.value <= limits[1]:
            span = f"{limits[0]:g} to {limits[1]:g} rev/min"
            what = f"the spindle of cell {name} turns at {span}; change the speed in the CAM system"
            limit = limits[0] if event.value < limits[0] else limits[1]
            raise JobError(what, line=event.line, value=event.value, limit=limit, unit="rev/min")

    def _cuts(self, region: Region, start: int, stop: int) -> None:
        """The motions to points start .. stop of a region are made with what is on now."""
        cuts = np.flatnonzero(np.asarray(region.move[start:stop]) == Move.CUT)
        if self.spindle or not len(cuts):
            return
        line = int(region.line[start + int(cuts[0])])
        if self.stopped is not None:
            which = f"tool {self.stopped.number or self.stopped.name}"
            what = f"{which} (line {self.stopped.line}) cuts and the file has not started the spindle again since the change"
            raise JobError(f"{what}; state the spindle's speed with each tool", line=line)
        if self.cell.controller.spindle_rpm == (0.0, 0.0) or self.urgent:
            return
        all_events = (e for group in self.events for e in (*group.before, *group.within, *group.after))
        if any(e.kind is EventKind.SPINDLE_ON for e in all_events):
            text = "the tool cuts with the spindle off: that is what the file says"
            self.urgent.append(Finding("spindle-off", text, line=line))
        else:
            text = (
                "the tool cuts and the spindle is never on: the file does not start it; give spindle_rpm in setup.toml"
            )
            self.urgent.append(Finding("spindle-never-on", text, line=line))

    def _say_in_part(self, event: Event, place: Place, k: int) -> None:
        """A warning where the file interrupts a cut; a tap's reversal at the bottom of its hole is none."""
        if place is not Place.INSIDE or event.kind not in _IN_PART:
            return
        region, n = self.regions[k], event.point
        if region.move[n - 1] != Move.CUT or region.move[n] != Move.CUT:
            return
        tapped = event.kind is EventKind.SPINDLE_ON and self.spindle not in ("", event.text or "CLW")
        if not tapped and (event.kind is not EventKind.SPINDLE_OFF or self.spindle):
            code, text = _IN_PART[event.kind]
            self.findings.append(Finding(code, f"{text}; that is what the file says", line=event.line))

    def _coolants(self) -> None:
        """A warning where the file tells kinds of coolant apart and the cell has one output for all."""
        kinds = [kind for kind in self.kinds if kind not in ("ON", "FLOOD")]
        if kinds and self._hook("coolant_on"):
            text = f"the cell has one coolant: {' and '.join(kinds)} is switched like any other; check what the output opens"
            self.findings.append(Finding("coolant-kind", text, line=self.kinds[kinds[0]]))

    def _speeds(self) -> None:
        """A warning where nobody says what the spindle can do."""
        if self.asked and self.cell.controller.spindle_rpm is None:
            least, most = (f([e.value for e in self.asked]) for f in (min, max))
            text = (
                f"cell {self.cell.name} does not say what speeds its spindle takes (spindle_rpm in [controller]): "
                f"{least:g}{f' to {most:g}' if most > least else ''} rev/min is not checked"
            )
            self.findings.append(Finding("spindle-range-unknown", text, line=self.asked[0].line))
