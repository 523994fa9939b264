"""The rule of the events: the same ones, in the same order, each between the same two motions of the file.

What a program may do besides: switch off spindle and coolant before a tool change and at its end, and on again after a change
what the file has on; spindle off before it turns the other way. What it may leave out: what changes nothing, and what the file
itself undoes before anything moves, waits or stops. Where the file has a gap, the program's own events count as the file's.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Event, Kind, Objection, Run, Story, Way
from camrob.witness.rules.rules_geometry import POSITION, Track, lengths_to
from camrob.witness.rules.rules_path import Match

__all__ = ["EventsFound", "State", "event_rule", "last_cut", "states_after"]

_SPINDLE = (Kind.SPINDLE_ON, Kind.SPINDLE_OFF)
_COOLANT = (Kind.COOLANT_ON, Kind.COOLANT_OFF)
_HOLDS = (Kind.DWELL, Kind.STOP)


@dataclass(frozen=True, slots=True)
class State:
    """What is on: spindle (rev/min, sense) and coolant (its kind), None where off; the tool's number, None where it has
    none.
    """

    spindle: tuple[float, str] | None = None
    coolant: str | None = None
    tool: int | None = None

    def after(self, event: Event) -> State:
        """The state that an event leaves."""
        if event.kind in _SPINDLE:
            return replace(self, spindle=(event.value, event.text) if event.kind == Kind.SPINDLE_ON else None)
        if event.kind in _COOLANT:
            return replace(self, coolant=event.text if event.kind == Kind.COOLANT_ON else None)
        if event.kind == Kind.TOOL and np.isfinite(event.value):
            return replace(self, tool=int(event.value) or None)
        return self


def states_after(events: tuple[Event, ...]) -> list[State]:
    """The state before the first event, and after each."""
    states = [State()]
    for event in events:
        states.append(states[-1].after(event))
    return states


@dataclass(slots=True)
class EventsFound:
    """What came out. state: the file's, from its motion (of the placed track) on: (motion, state) in order. added: program's
    events (their indices) that the file lacks and a program may have; turns: such as stop the spindle before it
    turns the other way. met: events of the file that the program has too.
    """

    objections: list[Objection] = field(default_factory=list)
    state: list[tuple[int, State]] = field(default_factory=lambda: [(-1, State())])
    added: list[int] = field(default_factory=list)
    turns: list[int] = field(default_factory=list)
    met: int = 0


def _same(event: Event, wanted: Event) -> bool:
    """Whether a program's event is the file's: kind and value, as far as both say it."""
    if event.kind != wanted.kind:
        return False
    if event.kind == Kind.SPINDLE_ON:
        return (
            abs(event.value - wanted.value) <= 0.5 and event.text == wanted.text
        )  # controllers take whole revolutions
    if event.kind == Kind.COOLANT_ON:
        return event.text == wanted.text or not (event.text and wanted.text)
    if event.kind == Kind.DWELL:
        return abs(event.value - wanted.value) <= 1e-3
    return event.kind != Kind.TOOL or event.value == wanted.value


def event_rule(match: Match, file: Track, story: Story, run: Run) -> EventsFound:
    """The rule over matched stories; OUTPUT events are left to others."""
    found = EventsFound()
    passed = _passed(match, len(file))
    wanted: dict[int, list[tuple[Event, bool]]] = defaultdict(list)
    for event in story.events:
        done = int(np.searchsorted(file.rows, event.before))
        wanted[int(passed[done])].append((event, bool(passed[done] < done)))
    _put_off(wanted, match, file, story, run)
    given: dict[int, list[int]] = defaultdict(list)
    places = _places(match, file, run, np.array(sorted(wanted), dtype=np.int64))
    free: set[int] = set()
    for k, (event, place) in enumerate(zip(run.events, places, strict=True)):
        if event.kind == Kind.OUTPUT:
            continue
        if place is None:
            found.objections.append(
                _objection("event-extra", "stands in the middle of a motion of the file", event, run)
            )
        elif place >= 0:
            given[place].append(k)
            if match.unjudged[event.before]:
                free.add(place)
    broken = not np.isfinite(match.at).all()
    last, cut = int(np.floor(np.nanmax(match.at))), last_cut(file, story)
    file_state, state = State(), State()
    for place in sorted({*wanted, *given}):
        if broken and place > last:
            break
        group = _Group(
            wanted[place], given[place], run, match.flying, file_state, state, place == 0, place >= cut, place in free
        )
        group.match(found)
        file_state, state = group.file_state, group.state
        found.state.append((place, file_state))
    return found


def _put_off(wanted: dict[int, list[tuple[Event, bool]]], match: Match, file: Track, story: Story, run: Run) -> None:
    """A change of tools that the file has before rapids may be made on the way that they go, with all that stands beside it."""
    cut = np.append(story.way[file.rows] != Way.RAPID, True)
    for place in sorted(place for place, group in wanted.items() if any(e.kind == Kind.TOOL for e, _ in group)):
        first = next(e for e, _ in wanted[place] if e.kind == Kind.TOOL)
        latest = place + int(np.argmax(cut[place:]))
        for event in run.events:
            at = float(match.at[event.before])
            if event.kind == Kind.TOOL and event.value == first.value and place < at <= latest:
                wanted[round(at)] = wanted.pop(place) + wanted.get(round(at), [])
                break


def last_cut(file: Track, story: Story) -> int:
    """How many motions of the placed file are done when its last cut is."""
    cuts = np.flatnonzero(story.way[file.rows] != Way.RAPID)
    return int(cuts[-1]) + 1 if len(cuts) else 0


def _passed(match: Match, count: int) -> NDArray[np.int64]:
    """(count + 1,) for each point of the file the one that the program leaves instead, where it passes it by in the air."""
    passed = np.arange(count + 1)
    for begin, end in match.skipped:
        passed[begin + 1 : end] = begin
    return passed


def _places(match: Match, file: Track, run: Run, wanted: NDArray[np.int64]) -> list[int | None]:
    """The point of the file (motions done) at which each event of the program happens; None within a motion, -1 unknown."""
    reached = lengths_to(file)
    places: list[int | None] = []
    for event in run.events:
        at = float(match.at[event.before])
        if not np.isfinite(at):
            places.append(-1)
            continue
        length = float(np.interp(at, np.arange(len(reached)), reached))
        options = [round(at)]
        if len(wanted):
            near = int(np.searchsorted(wanted, at))
            options = [int(k) for k in wanted[max(0, near - 1) : near + 1]] + options
            options.sort(key=lambda k: (abs(k - at), k not in wanted))
        places.append(next((k for k in options if abs(reached[k] - length) <= 2.0 * POSITION), None))
    return places


@dataclass(slots=True)
class _Group:
    """The events of both stories at one point of the file. wanted: the file's, and whether such as it has further on, on a way
    that the program leaves out: these may happen only in the air. given: indices of the run's.
    """

    wanted: list[tuple[Event, bool]]
    given: list[int]
    run: Run
    flying: NDArray[np.bool_]
    file_state: State
    state: State
    begins: bool  # the file has no motion before this point
    ends: bool  # nor a cut after it
    free: bool  # part of what happens here was not read

    def match(self, found: EventsFound) -> None:
        """Pairs them off, and leaves both states as they are afterwards."""
        done = 0
        for at, k in enumerate(self.given):
            event = self.run.events[k]
            hit = self._next(event, done)
            if hit is not None:
                for passed, _ in self.wanted[done : hit + 1]:
                    self.file_state = self.file_state.after(passed)
                found.met += hit + 1 - done
                done = hit + 1
            elif self._turns(event, at):
                found.turns.append(k)
            elif self.free or self._allowed(event, at):
                found.added.append(k)
            else:
                found.objections.append(_objection("event-extra", self._why(done), event, self.run))
            self.state = self.state.after(event)
        final = self._final()
        for k in range(done, len(self.wanted)):
            event, _ = self.wanted[k]
            kept = event.kind in (*_SPINDLE, *_COOLANT) and _alike(self.state, final, event)
            if not (kept or self._idle(k, self.file_state) or self.free):
                found.objections.append(_lost(event))
            else:
                found.met += 1
            self.file_state = self.file_state.after(event)
        if self.free:
            self.file_state = self.state

    def _final(self) -> State:
        """The file's state after all that it has here."""
        final = self.file_state
        for event, _ in self.wanted:
            final = final.after(event)
        return final

    def _next(self, event: Event, done: int) -> int | None:
        """The file's event that this one is, over such as may be left out."""
        state = self.file_state
        for k in range(done, len(self.wanted)):
            wanted, later = self.wanted[k]
            if _same(event, wanted) and (self.flying[event.before] or not later):
                return k
            if not self._idle(k, state):
                return None
            state = state.after(wanted)
        return None

    def _idle(self, k: int, before: State) -> bool:
        """Whether an event of the file may be left out: it changes nothing, or is undone before anything waits or stops; or it
        names the tool with which the file begins, without a number to call it by.
        """
        event, _ = self.wanted[k]
        family = _SPINDLE if event.kind in _SPINDLE else _COOLANT
        if event.kind not in (*_SPINDLE, *_COOLANT):
            return event.kind == Kind.TOOL and self.begins and not event.value
        if before.after(event) == before:
            return True
        for later, _ in self.wanted[k + 1 :]:
            if later.kind in _HOLDS:
                return False
            if later.kind in family or later.kind == Kind.TOOL:
                return True
        return False

    def _turns(self, event: Event, at: int) -> bool:
        """Whether an event stops the spindle for the one behind it to start it the other way."""
        if event.kind != Kind.SPINDLE_OFF or self.state.spindle is None or at + 1 >= len(self.given):
            return False
        later = self.run.events[self.given[at + 1]]
        return later.kind == Kind.SPINDLE_ON and later.text != self.state.spindle[1]

    def _allowed(self, event: Event, at: int) -> bool:
        """Whether a program may have an event that the file lacks."""
        others = [self.run.events[k].kind for k in self.given]
        if event.kind in (Kind.SPINDLE_OFF, Kind.COOLANT_OFF):
            return self.ends or Kind.TOOL in others[at + 1 :]
        if Kind.TOOL not in others[:at] or self.state.after(event) == self.state:
            return False
        return _alike(self.state.after(event), self._final(), event)

    def _why(self, done: int) -> str:
        if done < len(self.wanted):
            event, _ = self.wanted[done]
            return f"where the file has {_name(event)} (line {event.line})"
        return "where the file has no such event"


def _alike(a: State, b: State, event: Event) -> bool:
    """Whether two states are the same in what an event of spindle or coolant is about: coolant of no kind is any."""
    if event.kind in _SPINDLE:
        return a.spindle == b.spindle
    return a.coolant == b.coolant or (a.coolant is not None and b.coolant is not None and not (a.coolant and b.coolant))


def _name(event: Event) -> str:
    value = (
        "" if event.kind in (Kind.SPINDLE_OFF, Kind.COOLANT_OFF, Kind.COOLANT_ON, Kind.STOP) else f" {event.value:g}"
    )
    return f"{event.kind}{value}" + (f" {event.text}" if event.text else "")


def _objection(code: str, why: str, event: Event, run: Run) -> Objection:
    text = f"line {event.line} of the program: {_name(event)}, {why}"
    return Objection(code, text, line=event.line, file=event.file)


def _lost(event: Event) -> Objection:
    text = f"line {event.line} of the file: {_name(event)} is not in the program between the same two motions"
    return Objection("event-lost", text, cl_line=event.line)
