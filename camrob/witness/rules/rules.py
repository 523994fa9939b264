"""The rules by which a program is held to its CL file. Each is named, and says in its module what it asks:

- path (`rules_path`, `rules_along`, `rules_air`): every motion of the file in order, nothing else but ways through the clear;
- feed (`rules_feed`): cuts at the file's feed, rapids no faster than the set-up's;
- events (`rules_events`): spindle, coolant, tool, dwell, stop in the file's order, between the same two motions;
- state (`rules_state`): what is on at every cut, changes and starts where they do no harm, a safe end.

Tolerances: 0.01 mm and 0.01 degrees, and the set-up's chord tolerance on arcs that the program runs in chords.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Gap, Kind, Objection, Path, Run, Story, Way
from camrob.witness.rules.rules_along import Tolerance
from camrob.witness.rules.rules_events import event_rule, last_cut
from camrob.witness.rules.rules_feed import axis_speed_objections, feed_objections
from camrob.witness.rules.rules_geometry import Clear, Track, track
from camrob.witness.rules.rules_holes import hole_objections
from camrob.witness.rules.rules_path import Match, walk
from camrob.witness.rules.rules_state import Fittings, Scene, load_objections, state_objections
from camrob.witness.units import mm_to_m

__all__ = ["PATH_CODES", "Comparison", "Terms", "compare"]

Array = NDArray[np.float64]

_CRAWL = 0.4  # of the rapid feed: a way through the air that is slower may be a cut elsewhere

# what stands against the path; all else that the rules object to is against the process
PATH_CODES = frozenset(
    {
        "motion-lost",
        "motion-extra",
        "off-path",
        "hole-rounded",
        "hole-onto-bottom",
        "peck-top-rounded",
        "retract-elsewhere",
        "peck-deeper",
        "peck-ends",
        "peck-left-in",
        "chip-break",
        "peck-higher",
    }
)


@dataclass(frozen=True, slots=True)
class Terms:
    """What the rules have to know besides both stories.

    base_T_part: (4, 4). corners: (K, 3) m, corners of part and stock in `base`. tools: number to flange_T_tool (4, 4), 0 the one
    for all numbers. home: (n,) axis values in the order of `Run.axis_names`; endless: (n,) which of them turn without end.
    change: (n,) where the cell changes tools, None where it doesn't say. rapid: m/s, None where the set-up names none.
    chord, decimated: m, the set-up's. spindle_rpm: least, most. hooks: names of the cell's hooks; a file's coolant or spindle
    is not asked of a cell that has none. slower_allowed: why cuts may be slower than the file says. axis_speed: (n,) the
    most that the axes run, degrees a second, mm of those in `sliding`, None where the cell doesn't say. loads: number (as of
    tools) to mass, kg, and its centre on the flange, m; only of tools whose mass the set-up states.
    """

    base_T_part: Array
    tools: dict[int, Array]
    home: Array
    endless: NDArray[np.bool_]
    corners: Array = field(default_factory=lambda: np.zeros((0, 3)))
    change: Array | None = None
    rapid: float | None = None
    chord: float = mm_to_m(0.01)
    decimated: float = 0.0
    spindle_rpm: tuple[float, float] | None = None
    hooks: frozenset[str] = frozenset({"spindle_on", "coolant_on"})
    slower_allowed: str = ""
    axis_speed: Array | None = None
    sliding: frozenset[str] = frozenset()
    loads: Mapping[int, tuple[float, ...]] = field(default_factory=dict)


@dataclass(slots=True)
class Comparison:
    """What came of it. met: motions of the file that the program makes; met_events likewise. unjudged: what was not compared,
    one line each.
    """

    objections: list[Objection]
    met: int
    met_events: int
    unjudged: list[Gap]


def compare(story: Story, run: Run, terms: Terms) -> Comparison:
    """Holds a program to a CL file, both of one motion or more."""
    story, objections = _askable(_from_where_it_stands(story), terms)
    file = track(story.path, terms.base_T_part, ~story.joined | (story.way == Way.HOLE))
    first = np.arange(len(run)) == 0
    prog = track(run.path, None, run.ptp | first)
    home = _stands(run, terms.home, terms)
    change = None if terms.change is None else _stands(run, terms.change, terms)
    clear = Clear.around(file, story.way[file.rows] == Way.RAPID, story.joined[file.rows], terms.corners)
    match = walk(file, story, prog, run, home, clear, Tolerance(terms.chord, terms.decimated))
    events = event_rule(match, file, story, run)
    scene = Scene(match, file, story, run, events, clear, home, change)
    objections += [*match.objections, *hole_objections(match, file, story, prog, run)]
    objections += feed_objections(match, story, run, terms.rapid, terms.slower_allowed)
    if terms.axis_speed is not None:
        objections += axis_speed_objections(match, story, run, terms.axis_speed, terms.sliding)
    objections += events.objections
    fittings = Fittings(terms.tools, terms.spindle_rpm, terms.loads)
    objections += state_objections(scene, fittings)
    against, gaps = load_objections(scene, fittings)
    objections += against
    objections = [_traced(objection, match, story, run) for objection in objections]
    return Comparison(objections, match.met, events.met, [*_unjudged(match, file, story, run, terms.rapid), *gaps])


def _traced(objection: Objection, match: Match, story: Story, run: Run) -> Objection:
    """The objection with the file's line that its motion is made for, or leads to, where it names the program's alone."""
    if objection.cl_line or not objection.line or not len(match.pairs):
        return objection
    rows = np.flatnonzero((run.path.line == objection.line) & (run.file == objection.file))
    onward = match.pairs[match.pairs[:, 0] >= rows[0]] if len(rows) else match.pairs[:0]
    if not len(onward):
        return objection
    served = onward[np.argmin(onward[:, 0]), 1]
    return replace(objection, cl_line=int(story.path.line[served]))


def _from_where_it_stands(story: Story) -> Story:
    """The story with a way through the air to each place from which, as FROM says, a cut begins."""
    if not story.stands:
        return story
    at = np.array([stand.before for stand in story.stands])
    path, nowhere = story.path, np.full(len(at), np.nan)
    none = np.full((len(at), 3), np.nan)
    joined = story.joined.copy()
    joined[at] = True
    moved = {
        n: n + int(np.searchsorted(at, n)) for n in (*(e.before for e in story.events), *(g.before for g in story.gaps))
    }
    return replace(
        story,
        path=Path(
            np.insert(path.tip, at, [stand.tip for stand in story.stands], axis=0),
            np.insert(path.axis, at, [stand.axis for stand in story.stands], axis=0),
            np.insert(path.center, at, none, axis=0),
            np.insert(path.normal, at, none, axis=0),
            np.insert(path.angle, at, nowhere),
            np.insert(path.line, at, [stand.line for stand in story.stands]),
        ),
        way=np.insert(story.way, at, np.int8(Way.RAPID)),
        feed=np.insert(story.feed, at, nowhere),
        joined=np.insert(joined, at, False),
        operation=np.insert(story.operation, at, story.operation[at]),
        events=tuple(replace(event, before=moved[event.before]) for event in story.events),
        gaps=tuple(replace(gap, before=moved[gap.before]) for gap in story.gaps),
        stands=(),
        pecks={n + int(np.searchsorted(at, n, side="right")): most for n, most in story.pecks.items()},
    )


def _askable(story: Story, terms: Terms) -> tuple[Story, list[Objection]]:
    """The story without what the cell has no means for, and a warning for each such."""
    objections, events = [], list(story.events)
    for hook, kinds in (
        ("spindle_on", (Kind.SPINDLE_ON, Kind.SPINDLE_OFF)),
        ("coolant_on", (Kind.COOLANT_ON, Kind.COOLANT_OFF)),
    ):
        asked = [event for event in events if event.kind in kinds]
        if asked and not any(name.startswith(hook) for name in terms.hooks):
            text = f"the file says {asked[0].kind}, and the cell has no hook {hook}"
            objections.append(Objection("no-hook", text, cl_line=asked[0].line, severity="warning"))
            events = [event for event in events if event.kind not in kinds]
    return replace(story, events=tuple(events)), objections


def _stands(run: Run, pose: Array, terms: Terms) -> NDArray[np.bool_]:
    """(M,) whether a point-to-point motion ends at these axis values, whatever turn an endless axis is on; but a program begins
    on the turn that it was given, or the part would be turned round before anybody expects it.
    """
    rows = np.flatnonzero(run.ptp)
    off = run.axes[rows] - pose
    off = np.where(terms.endless & (rows[:, None] > 0), (off + 180.0) % 360.0 - 180.0, off)
    there = np.zeros(len(run), dtype=bool)
    there[rows] = (np.abs(off) <= 0.01).all(axis=1)
    return there


def _unjudged(match: Match, file: Track, story: Story, run: Run, rapid: float | None) -> list[Gap]:
    """What of the two was not compared."""
    gaps = list(story.gaps)
    air = np.setdiff1d(match.air, match.entries[:, 0])
    air = air[np.isfinite(run.speed[air])]
    slow = air[run.speed[air] < _CRAWL * (rapid or float(run.speed[air].max(initial=0.0)))]
    if len(slow):
        row = int(slow[0])
        text = "it goes through the air at a cut's feed: whether it is a way, or cuts that the file doesn't have, isn't judged"
        gaps.append(Gap(row, int(run.path.line[row]), int(run.path.line[slow[-1]]), text, int(run.file[row])))
    for event in run.events:
        at = match.at[event.before]
        if event.kind == Kind.OUTPUT and (at <= 0.0 or at >= last_cut(file, story)):
            text = f"{event.text}: an output that no hook of the cell accounts for"
            gaps.append(Gap(event.before, event.line, event.line, text, event.file))
    rest = np.flatnonzero(np.isnan(match.at))
    if len(rest):
        row = min(int(rest[0]), len(run) - 1)
        text = "the rest of the program was not compared with the file"
        gaps.append(Gap(row, int(run.path.line[row]), int(run.path.line[-1]), text, int(run.file[row])))
    return gaps
