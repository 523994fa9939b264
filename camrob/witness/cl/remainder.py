"""A part of what a CL file asks for: from one of its lines on, of a program that is entered again at an operation, or in the
lines of one clamping of the part.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from camrob.errors import ToolpathError
from camrob.witness.happenings import Event, Kind, Path, Story, Way

__all__ = ["from_line", "in_clamping"]

_STATES = ({Kind.TOOL}, {Kind.SPINDLE_ON, Kind.SPINDLE_OFF}, {Kind.COOLANT_ON, Kind.COOLANT_OFF})
_OFF = {Kind.SPINDLE_OFF, Kind.COOLANT_OFF}


def in_clamping(story: Story, lines: Mapping[str, tuple[int, int]], name: str) -> Story:
    """The motions that stand in a clamping's lines; tool, spindle and coolant are before them as the file has left them.

    Raises ToolpathError where a motion stands in no clamping or in several, or the clamping's don't follow each other.
    """
    line = story.path.line
    owners = np.sum([(line >= low) & (line <= high) for low, high in lines.values()], axis=0)
    for row in np.flatnonzero(owners != 1)[:1].tolist():
        how = "several clampings" if owners[row] else "no clamping"
        raise ToolpathError(f"line {int(line[row])} moves the tool in {how}", hint="correct `lines` of the set-up")
    first, last = lines[name]
    rows = np.flatnonzero((line >= first) & (line <= last))
    if not len(rows) or rows[-1] - rows[0] + 1 != len(rows):
        raise ToolpathError(f"lines {first}-{last} of clamping {name} hold no motions in a row", hint="correct `lines`")
    ended = _to_line(story, int(rows[-1]) + 1, last)
    return from_line(ended, first) if rows[0] else ended


def _to_line(story: Story, stop: int, last: int) -> Story:
    """The motions before row `stop`, and what happens behind them up to a line."""
    path = story.path
    return replace(
        story,
        path=Path(
            path.tip[:stop],
            path.axis[:stop],
            path.center[:stop],
            path.normal[:stop],
            path.angle[:stop],
            path.line[:stop],
        ),
        way=story.way[:stop],
        feed=story.feed[:stop],
        joined=story.joined[:stop],
        operation=story.operation[:stop],
        events=tuple(e for e in story.events if e.before < stop or (e.before == stop and e.line <= last)),
        gaps=tuple(g for g in story.gaps if g.before < stop or (g.before == stop and g.first_line <= last)),
        stands=tuple(s for s in story.stands if s.before < stop),
        pecks={row: pecks for row, pecks in story.pecks.items() if row < stop},
    )


def from_line(story: Story, line: int) -> Story:
    """The motions that stand in this line and behind it; tool, spindle and coolant are before them as the file has left them.

    Raises ToolpathError where no motion stands there, the first of them is a cut, or lines are run again across the border.
    """
    rows = np.flatnonzero(story.path.line >= line)
    first = int(rows[0]) if len(rows) else len(story)
    if not 0 < first < len(story) or len(rows) != len(story) - first:
        raise ToolpathError(
            f"no motion from line {line} on that all others stand before", hint="name an operation's first line"
        )
    if story.way[first] != Way.RAPID:
        raise ToolpathError(
            f"line {int(story.path.line[first])} begins with a cut", hint="name an operation's first line"
        )
    past = [e for e in story.events if e.before <= first]
    state: list[Event] = []
    for kinds in _STATES:
        last = next((e for e in reversed(past) if e.kind in kinds), None)
        if last is not None and last.kind not in _OFF:
            state.append(replace(last, before=0))
    state.sort(key=lambda e: (e.kind is not Kind.TOOL, e.line))
    path = story.path
    joined = story.joined[first:].copy()
    joined[0] = False
    return replace(
        story,
        path=Path(
            path.tip[first:],
            path.axis[first:],
            path.center[first:],
            path.normal[first:],
            path.angle[first:],
            path.line[first:],
        ),
        way=story.way[first:],
        feed=story.feed[first:],
        joined=joined,
        operation=story.operation[first:] - story.operation[first],
        events=(*state, *(replace(e, before=e.before - first) for e in story.events if e.before > first)),
        gaps=tuple(replace(g, before=g.before - first) for g in story.gaps if g.before >= first),
        stands=tuple(replace(s, before=s.before - first) for s in story.stands if s.before >= first),
        pecks={row - first: pecks for row, pecks in story.pecks.items() if row >= first},
    )
