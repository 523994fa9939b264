"""The rule of the state: at every cut the file's spindle, coolant and tool; changes and starts where they do no harm.

- at a cut the program's spindle, coolant and tool number are the file's, and `$TOOL` is the set-up's of that number;
- where the set-up states the mass of that tool, `$LOAD` is that mass at every motion with it;
- a tool change with the spindle off; and it, like a spindle switched off besides what the file says, in the clear, or
  where the cell's own pose for it is;
- the spindle within its range, and not started in the part unless the file says so itself (then a warning), nor before the
  program's first motion, nor the other way while it turns; no coolant while a tool is changed;
- at the start a way to HOME; at the end spindle and coolant off, and the tool at HOME or in the clear;
- an output that no hook accounts for: before the file's last cut an error; before its first motion, and
  after that cut, not judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Event, Gap, Kind, Load, Objection, Run, Story, Way
from camrob.witness.rules.rules_events import EventsFound, State, last_cut, states_after
from camrob.witness.rules.rules_geometry import Clear, Track, Vec
from camrob.witness.rules.rules_path import Match
from camrob.witness.units import deg_to_rad, mm_to_m

__all__ = ["Fittings", "Scene", "load_objections", "loads_by_frame", "state_objections"]

Array = NDArray[np.float64]
_MASS, _CENTER, _MOMENT = 6e-4, 6e-7, 6e-4  # kg, m, kg m^2: what three decimals of `$LOAD` leave
_PLACE, _TURN = 2e-6, deg_to_rad(0.005)  # of `$TOOL`: three decimals


@dataclass(frozen=True, slots=True)
class Fittings:
    """What set-up and cell say. tools: number to flange_T_tool (4, 4), 0 the one that stands for all others; spindle_rpm: least
    and most, None where not known. loads: number to mass (kg) and its centre X, Y, Z on the flange (m), where the set-up has it.
    """

    tools: dict[int, Array]
    spindle_rpm: tuple[float, float] | None = None
    loads: Mapping[int, tuple[float, ...]] = field(default_factory=dict)

    def load(self, number: int | None) -> tuple[float, ...] | None:
        """The load of a number of the file, None where the set-up doesn't say."""
        if number in (None, 0) and len(self.tools) == 1:
            return self.loads.get(next(iter(self.tools)))
        return self.loads.get((number or 0) if (number or 0) in self.tools else 0)

    def tool(self, number: int | None) -> Array | None:
        """`$TOOL` of a number of the file (None: it names none); None where the set-up doesn't say."""
        if number in (None, 0) and len(self.tools) == 1:
            return next(iter(self.tools.values()))
        return self.tools.get(number or 0, self.tools.get(0))


@dataclass(slots=True)
class Scene:
    """Both stories, matched, and where it is clear. home: (M,) whether a motion of the run ends at HOME; change: (M,) likewise
    where the cell changes tools, None where it doesn't say.
    """

    match: Match
    file: Track
    story: Story
    run: Run
    events: EventsFound
    clear: Clear
    home: NDArray[np.bool_]
    change: NDArray[np.bool_] | None = None

    def changes_tools(self, row: int) -> bool:
        """Whether tools may be changed before a motion of the run: in the clear, and where the cell says, where it does."""
        return self.clear_before(row) if self.change is None or row == 0 else bool(self.change[row - 1])

    def clear_before(self, row: int) -> bool:
        """Whether the tool is clear, or at HOME, before a motion of the run; before the first it is the operator's affair."""
        return row == 0 or bool(self.home[row - 1]) or self.clear.holds(self._pose(row)[0], self._pose(row)[1])

    def _pose(self, row: int) -> tuple[Vec, Vec]:
        x, y, z = self.run.path.tip[row - 1].tolist()
        i, j, k = self.run.path.axis[row - 1].tolist()
        return (x, y, z), (i, j, k)

    def between_cuts(self, row: int) -> bool:
        """Whether the file cuts up to where the program is before its motion `row`, and on from there."""
        at = float(self.match.at[row])
        if not np.isfinite(at):
            return False
        k = round(at)
        way = self.story.way[self.file.rows]
        return 0 < k < len(way) and way[k - 1] != Way.RAPID and way[k] != Way.RAPID


def state_objections(scene: Scene, fittings: Fittings) -> list[Objection]:
    """The rule over matched stories."""
    found = [*_at_cuts(scene, fittings), *_changes(scene, fittings), *_end(scene), *_outputs(scene)]
    return found


def _at_cuts(scene: Scene, fittings: Fittings) -> Iterator[Objection]:
    """Each combination of the file's state and the program's that occurs in a cut, once."""
    story, run, match = scene.story, scene.run, scene.match
    states = states_after(run.events)
    j, i = match.pairs[:, 0], match.pairs[:, 1]
    file = np.searchsorted([k for k, _ in scene.events.state], np.searchsorted(scene.file.rows, i), side="right") - 1
    prog = np.searchsorted([event.before for event in run.events], j, side="right")
    cut = (story.way[i] != Way.RAPID).astype(np.int64)
    keys = np.stack([file, prog, run.tool[j], cut], axis=1)
    order = np.lexsort((j, *keys.T[::-1])) if len(keys) else np.zeros(0, np.int64)
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (keys[order][1:] != keys[order][:-1]).any(axis=1)
    said: set[str] = set()
    for k in sorted(order[fresh], key=lambda k: (int(j[k]), int(i[k]))):
        wanted, state = scene.events.state[int(file[k])][1], states[int(prog[k])]
        lines = int(story.path.line[i[k]]), int(run.path.line[j[k]]), int(run.file[j[k]])
        found = dict(_tool_frame(fittings, wanted, run.tools[int(run.tool[j[k]])]))
        if cut[k]:
            found |= dict(_differ(wanted, state))
        for code, text in found.items():
            if code not in said:
                said.add(code)
                severity = "warning" if code == "cut-without-spindle" else "error"
                yield Objection(code, f"line {lines[1]} of the program: {text}", *lines, severity=severity)


def _differ(wanted: State, state: State) -> Iterator[tuple[str, str]]:
    """What a cut has otherwise than the file says, as code and text."""
    if wanted.spindle is None and state.spindle is None:
        yield "cut-without-spindle", "a cut with the spindle off, as in the file"
    elif wanted.spindle is None or state.spindle is None:
        yield "spindle-differs", f"a cut with the spindle {_spindle(state)}, where the file has it {_spindle(wanted)}"
    elif abs(wanted.spindle[0] - state.spindle[0]) > 0.5 or wanted.spindle[1] != state.spindle[1]:
        yield "spindle-differs", f"a cut with the spindle {_spindle(state)}, where the file has it {_spindle(wanted)}"
    if (wanted.coolant is None) != (state.coolant is None) or (
        wanted.coolant and state.coolant and wanted.coolant != state.coolant
    ):
        now, then = (("off" if s.coolant is None else f"on {s.coolant}".strip()) for s in (state, wanted))
        yield "coolant-differs", f"a cut with the coolant {now}, where the file has it {then}"
    if wanted.tool != state.tool:
        yield (
            "tool-differs",
            f"a cut with tool {state.tool or 'unnamed'}, where the file has {wanted.tool or 'none named'}",
        )


def _spindle(state: State) -> str:
    return "off" if state.spindle is None else f"at {state.spindle[0]:g} rev/min {state.spindle[1]}".strip()


def _tool_frame(fittings: Fittings, wanted: State, flange_T_tool: Array) -> Iterator[tuple[str, str]]:
    meant = fittings.tool(wanted.tool)
    if meant is None:
        yield "tool-unknown", f"the set-up has no tool {wanted.tool}; add it as [[tool]]"
        return
    if not _same_frame(meant, flange_T_tool):
        yield "tool-frame", f"the tool's frame is not that of tool {wanted.tool or 0}"


def _same_frame(meant: Array, flange_T_tool: Array) -> bool:
    place = float(np.linalg.norm(meant[:3, 3] - flange_T_tool[:3, 3]))
    turn = float(np.linalg.norm(meant[:3, :3] - flange_T_tool[:3, :3])) / np.sqrt(2.0)
    return place <= _PLACE and turn <= _TURN


def load_objections(scene: Scene, fittings: Fittings) -> tuple[list[Objection], list[Gap]]:
    """Each load that is not that of the mounted tool, where it holds first; and what nobody can say of one."""
    objections: list[Objection] = []
    gaps: list[Gap] = []
    run = scene.run
    if not fittings.loads or not len(scene.match.pairs):
        return objections, gaps
    rows, wanted = _wanted_tools(scene)
    held = np.searchsorted([load.before for load in run.loads], rows, side="right") - 1
    fresh = np.sort(np.unique(np.stack([wanted, held], axis=1), axis=0, return_index=True)[1])
    for k in fresh.tolist():
        number = scene.events.state[int(wanted[k])][1].tool
        load, row = run.loads[int(held[k])] if held[k] >= 0 else None, int(rows[k])
        against, unsure = _weighed(fittings.load(number), load, f"tool {number}" if number else "the tool")
        lines = int(run.path.line[row]), int(run.file[row])
        if against:
            text = f"line {lines[0]} of the program: {against}"
            objections.append(Objection("load-differs", text, 0, *lines))
        elif unsure and load is not None:
            gaps.append(Gap(load.before, load.line, load.line, unsure, load.file))
    return objections, gaps


def loads_by_frame(run: Run, fittings: Fittings) -> tuple[list[Objection], list[Gap]]:
    """The same of a program without its CL file: its motions' tool is the one of the set-up whose frame `$TOOL` is."""
    objections: list[Objection] = []
    gaps: list[Gap] = []
    if not fittings.loads or not len(run):
        return objections, gaps
    alike = [[n for n, frame in fittings.tools.items() if _same_frame(held, frame)] for held in run.tools]
    rows = np.arange(len(run))
    held = np.searchsorted([load.before for load in run.loads], rows, side="right") - 1
    fresh = np.sort(np.unique(np.stack([run.tool, held], axis=1), axis=0, return_index=True)[1])
    for row in fresh.tolist():
        numbers = alike[int(run.tool[row])] if run.tool[row] >= 0 else []
        meant = {fittings.loads.get(number) for number in numbers}
        load, lines = (
            run.loads[int(held[row])] if held[row] >= 0 else None,
            (int(run.path.line[row]), int(run.file[row])),
        )
        if len(meant) != 1:
            which = (
                "is that of several tools of the set-up, with different masses"
                if meant
                else "is no tool's of the set-up"
            )
            text = f"whether the tool weighs what the program's load says isn't judged: the tool's frame {which}"
            gaps.append(Gap(row, lines[0], lines[0], text, lines[1], of_load=bool(meant)))
            continue
        against, unsure = _weighed(meant.pop(), load, f"tool {numbers[0]}" if numbers[0] else "the tool")
        if against:
            objections.append(Objection("load-differs", f"line {lines[0]} of the program: {against}", 0, *lines))
        elif unsure and load is not None:
            gaps.append(Gap(load.before, load.line, load.line, unsure, load.file, of_load=True))
    return objections, gaps


def _wanted_tools(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Motions of the run, and for each the file's state whose tool it is made with: that of the next motion that meets the
    file, or of the one before, with no change of tools of the program between.
    """
    run, events, match = scene.run, scene.events, scene.match
    order = np.argsort(match.pairs[:, 0], kind="stable")
    meets, i = match.pairs[order, 0], match.pairs[order, 1]
    state = np.searchsorted([k for k, _ in events.state], np.searchsorted(scene.file.rows, i), side="right") - 1
    rows = np.arange(len(run))
    changes = [event.before for event in run.events if event.kind == Kind.TOOL]
    stretch = np.searchsorted(changes, rows, side="right")
    after = np.searchsorted(meets, rows)
    ahead = np.minimum(after, len(meets) - 1)
    behind = np.maximum(np.searchsorted(meets, rows, side="right") - 1, 0)
    nearest = np.where(stretch[meets[ahead]] == stretch, ahead, behind)
    known = stretch[meets[nearest]] == stretch
    return rows[known], np.asarray(state[nearest][known], np.int64)


def _weighed(meant: tuple[float, ...] | None, load: Load | None, tool: str) -> tuple[str, str]:
    """What stands against a load with a tool, and what isn't judged of it; "" where nothing."""
    values = None if load is None else load.values
    if meant is None:
        return "", "" if values is None else f"a load is set, and the set-up states no mass of {tool}"
    if values is None:
        return f"a motion with {tool} without its load, where the set-up states its mass", ""
    mass, *rest = values
    center = mm_to_m(np.array(rest[:3]))
    off = abs(mass - meant[0]) > _MASS or bool(np.any(np.abs(center - np.array(meant[1:4])) > _CENTER))
    told = any(meant[4:]) and not any(
        rest[3:6]
    )  # moments that the set-up states, and the centre's axes are the flange's
    off = off or (told and bool(np.any(np.abs(np.array(rest[6:9]) - np.array(meant[4:])) > _MOMENT)))
    if off:
        return (
            f"the load is {mass:g} kg, or lies or turns otherwise than the set-up has it for {tool}, which is {meant[0]:g} kg",
            "",
        )
    said = [mass, *center, *(rest[6:9] if told else ())]
    known = not np.isnan(said).any() and not any(rest[3:6] if told else rest[3:])
    return "", "" if known else "the load holds what the set-up doesn't state, or what the text doesn't say"


def _changes(scene: Scene, fittings: Fittings) -> Iterator[Objection]:
    """Tool changes, starts of the spindle, and what was switched off besides."""
    states, added = states_after(scene.run.events), set(scene.events.added)
    turned = {k + 1 for k in scene.events.turns}
    for k, event in enumerate(scene.run.events):
        before = states[k]
        if event.kind == Kind.TOOL:
            if before.spindle is not None:
                yield _of(event, "change-running", "a tool change while the spindle is on")
            if before.coolant is not None:
                yield _of(event, "change-wet", "a tool change while the coolant is on")
            if not scene.changes_tools(event.before):
                where = "in the clear" if scene.change is None else "at the cell's tool_change_pose"
                yield _of(event, "change-in-part", f"a tool change that is not {where}")
        elif event.kind == Kind.SPINDLE_OFF and k in added and before.spindle is not None:
            if not scene.clear_before(event.before) and not scene.match.unjudged[event.before]:
                yield _of(event, "spindle-off-in-part", "the spindle is switched off where the tool isn't clear")
        elif event.kind == Kind.SPINDLE_ON:
            if fittings.spindle_rpm is not None:
                low, high = fittings.spindle_rpm
                if not low <= event.value <= high:
                    text = f"{event.value:g} rev/min, where the spindle has {low:g} to {high:g}"
                    yield _of(event, "spindle-range", text)
            if event.before == 0:
                text = "the spindle starts before the first motion, which leads from where nobody knows"
                yield _of(event, "spindle-starts-early", text)
            if before.spindle is not None and before.spindle[1] != event.text:
                yield _of(event, "spindle-reversed", "the spindle turns, and is started the other way without a stop")
            starts = before.spindle is None and k not in turned and scene.between_cuts(event.before)
            if starts and not scene.clear_before(event.before):
                yield _of(event, "spindle-starts-in-part", "the spindle starts in the part, as in the file", "warning")


def _end(scene: Scene) -> Iterator[Objection]:
    """How the program finds the machine, and how it leaves it."""
    state, last = states_after(scene.run.events)[-1], len(scene.run)
    if not scene.home[0]:
        text = "the program does not begin with a way to HOME: the way to its first point is not known"
        yield Objection("starts-elsewhere", text, 0, int(scene.run.path.line[0]), int(scene.run.file[0]))
    rests = scene.home if scene.change is None else scene.home | scene.change
    for row in (np.flatnonzero(rests[:-1] & ~scene.run.ptp[1:]) + 1).tolist():
        line, file = int(scene.run.path.line[row]), int(scene.run.file[row])
        text = (
            f"line {line} of the program: a path leaves HOME, or where tools are changed, in the posture it has there"
        )
        yield Objection("path-from-home", text, 0, line, file, severity="warning")
    lines = 0, int(scene.run.path.line[-1]), int(scene.run.file[-1])
    if state.spindle is not None:
        yield Objection("ends-running", "the program ends with the spindle on", *lines)
    if state.coolant is not None:
        yield Objection("ends-running", "the program ends with the coolant on", *lines)
    if scene.run.ptp[-1] and not scene.home[-1]:
        yield Objection("ends-elsewhere", "the program ends with a PTP to another place than HOME", *lines)
    elif not scene.clear_before(last):
        yield Objection("ends-in-part", "the program ends neither at HOME nor in the clear", *lines)
    elif not scene.home[-1]:
        text = "the program ends in the clear, and not at HOME"
        yield Objection("ends-elsewhere", text, *lines, severity="warning")


def _outputs(scene: Scene) -> Iterator[Objection]:
    """Outputs that no hook accounts for, while the file cuts."""
    last = last_cut(scene.file, scene.story)
    for event in scene.run.events:
        at = scene.match.at[event.before]
        if event.kind == Kind.OUTPUT and not (at <= 0.0 or at >= last):
            yield _of(event, "output-unknown", f"{event.text}, which no hook of the cell accounts for")


def _of(event: Event, code: str, text: str, severity: str = "error") -> Objection:
    return Objection(
        code, f"line {event.line} of the program: {text}", line=event.line, file=event.file, severity=severity
    )
