"""The second opinion as a whole: what a program does, what its CL file asks for, and whether the two are the same.

`judge` reads everything from its text: cell.toml, setup.toml, the CL file, the program. It answers with what stands against the
program, what was judged and what was not; it never raises for a program that is wrong, only for inputs that can't be read.
"""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Iterable
from ctypes import CDLL
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from camrob.witness.cl import read_story
from camrob.witness.cl.remainder import from_line, in_clamping
from camrob.witness.happenings import Gap, Kind, Objection, Run, Story
from camrob.witness.job import Job, no_job, read_job
from camrob.witness.machine import Machine, read_machine
from camrob.witness.programs import run_program
from camrob.witness.rules.rules import PATH_CODES, Comparison, Terms, compare
from camrob.witness.rules.rules_state import Fittings, loads_by_frame
from camrob.witness.units import mm_to_m

__all__ = ["AREAS", "Verdict", "judge"]

AREAS = ("path", "frames", "process", "limits")
_FRAMES = ("base-", "external-", "async-", "frame-", "tool-frame", "tool-unknown", "robroot", "world")
_LIMITS = frozenset({"limit", "unreachable", "axis-jump", "singular", "status-turn", "start-unknown"})
_SETUP = "setup.toml"  # beside the CL file: the set-up where none is named
_LONG = 100_000  # motions from which on what a reader leaves behind is worth being looked for: 40 MB
_CHORD = mm_to_m(0.01)  # of arcs, where the set-up names none
_USUAL_RAPID = mm_to_m(100.0)  # m/s, likewise: 6 m/min, whatever the writer takes


@dataclass(slots=True)
class Verdict:
    """What came of it.

    judged: area to True (judged, and nothing stands against it), False (something does), None (not judged, or not all of it).
    unjudged: what was not judged, one line each. points, events: of the CL file, met by the program. complete: all of file and
    program was read and compared. process: events_in_file, events_in_program, spindle [[line, rpm, sense]], tool_changes
    [[line, number]], of the program. notes: choices that the CL file left open. seconds: by stage. files: of the program, by the
    index that an objection has.
    """

    objections: tuple[Objection, ...]
    unjudged: tuple[str, ...]
    judged: dict[str, bool | None]
    judged_points: int
    judged_events: int
    complete: bool
    process: dict[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    files: tuple[str, ...] = ()

    @property
    def errors(self) -> tuple[Objection, ...]:
        """What stands against the program."""
        return tuple(o for o in self.objections if o.severity == "error")

    @property
    def warnings(self) -> tuple[Objection, ...]:
        """What a person should know."""
        return tuple(o for o in self.objections if o.severity != "error")


class _Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage], self._last = round(now - self._last, 3), now


def judge(
    program: Path,
    cell: Path,
    *,
    clfile: Path | None = None,
    setup: Path | None = None,
    dialect: str | None = None,
    units: str | None = None,
    slower_allowed: str = "",
    begin: int = 0,
    clamping: str | None = None,
    usual_rapid: bool = False,
) -> Verdict:
    """Judges a program (its main .src) for a cell (folder or cell.toml), against a CL file by a set-up (else the one beside it).

    Without a CL file: what the program alone shows, which is frames, limits and what isn't understood. dialect, units: over
    what set-up and file say. slower_allowed: why cuts may be slower than the file says. begin: the CL file's line from which on
    the program does what it asks for (a program that is entered again at an operation), 0 for all of it. clamping: the set-up's,
    where it has several: the program does what the file has in its lines. usual_rapid: ways through air are held to 6 m/min where
    the set-up names no feed for them; else they may be as fast as they like.
    Raises CellError, SetupError, ToolpathError, KrlError for what can't be read.
    """
    clock = _Clock()
    if setup is None and clfile is not None and (clfile.parent / _SETUP).is_file():
        setup = clfile.parent / _SETUP
    machine = read_machine(cell)
    job = no_job() if setup is None else read_job(setup, clamping)
    clock.lap("machine")
    run = run_program(program, machine)
    weighed = bool(job.loads) and machine.controller.own.get("load_measured") is not True
    unsettled = [gap for gap in run.unsettled if not (weighed and gap.of_load)]
    settled = replace(run, objections=(*run.objections, *run.conduct), gaps=(*run.gaps, *unsettled))
    clock.lap("program")
    if clfile is None:
        return _alone(_weighed_alone(settled, machine, job), clock)
    story = _story(clfile, job, dialect, units, begin, clamping)
    _let_go(len(run))
    clock.lap("file")
    if not len(run):
        found = Comparison([Objection("motion-lost", "the program has no motion")], 0, 0, list(story.gaps))
    elif not len(story.way):  # nothing of the file was read
        found = Comparison([], 0, 0, list(story.gaps))
    else:
        found = compare(story, run, _terms(machine, job, slower_allowed, _USUAL_RAPID if usual_rapid else None))
    clock.lap("rules")
    run = settled
    objections = (*run.objections, *found.objections)
    complete = story.complete and not run.gaps and not found.unjudged
    return Verdict(
        objections,
        _texts(found.unjudged, run, story),
        _areas(objections, path=not found.unjudged and story.complete, run=run, process=True),
        found.met,
        found.met_events,
        complete,
        _process(run, story),
        story.notes,
        clock.seconds,
        tuple(run.files),
    )


def _story(clfile: Path, job: Job, dialect: str | None, units: str | None, begin: int, clamping: str | None) -> Story:
    """What the program has to do of what the CL file asks for."""
    story = read_story(
        clfile,
        dialect=dialect or job.dialect,
        units=units or job.units,
        default_feed=job.feed,
        default_rpm=job.spindle_rpm,
        tools={number: tool.diameter for number, tool in job.tools.items() if tool.diameter},
        wear=job.wear,
        numbers=job.numbers,
        machine=job.machine,
    )
    if clamping is not None:
        story = in_clamping(story, job.lines, clamping)
    return from_line(story, begin) if begin else story


def _let_go(motions: int) -> None:
    """Frees text and columns that a reader's objects hold in rings, which Python would leave for later, and gives the system back
    what lies free between what stays, where the C library can (glibc's malloc_trim): half of what a long program takes.
    """
    if motions > _LONG:
        gc.collect()
        trim = getattr(CDLL(None), "malloc_trim", None) if os.name == "posix" else None
        if trim is not None:
            trim(0)


def _weighed_alone(run: Run, machine: Machine, job: Job) -> Run:
    """The run with what stands against its loads by the set-up's tools, where it states their masses."""
    terms = _terms(machine, job, "", None)
    against, gaps = loads_by_frame(run, Fittings(terms.tools, loads=terms.loads))
    return replace(run, objections=(*run.objections, *against), gaps=(*run.gaps, *gaps))


def _alone(run: Run, clock: _Clock) -> Verdict:
    """What a program shows by itself."""
    judged = _areas(run.objections, path=False, run=run, process=False)
    texts, process = _texts([], run, None), _process(run, None)
    return Verdict(
        run.objections, texts, judged, 0, 0, not run.gaps, process, seconds=clock.seconds, files=tuple(run.files)
    )


def _terms(machine: Machine, job: Job, slower_allowed: str, usual_rapid: float | None) -> Terms:
    """What the rules have to know of cell and set-up."""
    own = machine.flange_T_tool
    tools = {number: own if tool.flange_T_tool is None else tool.flange_T_tool for number, tool in job.tools.items()}
    corners = [points for name in ("part", "stock") if (points := job.corners(name)) is not None]
    change = machine.controller.tool_change_pose
    return Terms(
        base_T_part=job.base_T_part,
        tools=tools or {0: own},
        loads={} if machine.controller.own.get("load_measured") is True else job.loads,
        home=machine.home,
        endless=np.array([joint.endless for joint in machine.in_order]),
        change=machine.home if change is None else np.array(change),
        corners=np.vstack([np.zeros((0, 3)), *corners]),
        rapid=usual_rapid if job.rapid_feed is None else job.rapid_feed,
        chord=_CHORD if job.chord_tolerance is None else job.chord_tolerance,
        decimated=job.decimate or 0.0,
        spindle_rpm=machine.controller.spindle_rpm,
        hooks=frozenset(machine.controller.hooks),
        slower_allowed=slower_allowed,
        axis_speed=machine.speed,
        sliding=frozenset(joint.word for joint in machine.joints if not joint.turning),
    )


def _areas(objections: Iterable[Objection], *, path: bool, run: Run, process: bool) -> dict[str, bool | None]:
    """True, False, None for each area; path, process: whether all of it was compared."""
    whole = not run.gaps
    moved = all(gap.of_load for gap in run.gaps)  # what hangs on the flange moves neither frames nor axes
    judged: dict[str, bool | None] = {
        "path": (path and whole) or None,
        "frames": moved or None,
        "process": (process and path and whole) or None,
        "limits": moved or None,
    }
    for objection in objections:
        if objection.severity == "error":
            judged[_area(objection.code)] = False
    return judged


def _area(code: str) -> str:
    if code in PATH_CODES:
        return "path"
    if code.startswith(_FRAMES):
        return "frames"
    return "limits" if code in _LIMITS else "process"


def _texts(gaps: Iterable[Gap], run: Run, story: Story | None) -> tuple[str, ...]:
    """What was not judged, one line each: the program's lines by their file, the CL file's as they are."""
    of_file = set(story.gaps) if story is not None else set()
    alike: dict[tuple[bool, int, str], list[Gap]] = {}
    for gap in (*gaps, *run.gaps):
        alike.setdefault((gap in of_file, gap.file, gap.text), []).append(gap)
    texts = []
    for (cl, file, text), same in alike.items():
        first, last = same[0].first_line, same[0].last_line
        more = len({gap.first_line for gap in same}) - 1
        lines = (f"line {first}" if first >= last else f"lines {first}-{last}") + (f" and {more} more" if more else "")
        texts.append(f"{lines}: {text}" if cl else f"{run.files[file]}, {lines}: {text}")
    return tuple(texts)


def _process(run: Run, story: Story | None) -> dict[str, object]:
    """The program's events, for the summary."""
    return {
        "events_in_file": None if story is None else len(story.events),
        "events_in_program": len(run.events),
        "spindle": [[e.line, e.value, e.text] for e in run.events if e.kind == Kind.SPINDLE_ON],
        "tool_changes": [[e.line, e.value] for e in run.events if e.kind == Kind.TOOL],
    }
