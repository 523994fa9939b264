"""camrob's reading of a file held to the witness's: the same cuts, feeds and events, and no rapid that the other doesn't know.

The two readers share no code. camrob leaves out rapids that lead to no cut, and what stands still; both may.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.happenings import Kind, Story, Way

__all__ = ["differences"]

Array = NDArray[np.float64]

PLACE = 2e-6  # m: as near as two readings of the same numbers have to be
AXIS = 1e-6
MOST = 0.97  # of the way along a closed piece: its end is then meant by a point there, not its start
NAMES = {
    Kind.SPINDLE_ON: EventKind.SPINDLE_ON,
    Kind.SPINDLE_OFF: EventKind.SPINDLE_OFF,
    Kind.COOLANT_ON: EventKind.COOLANT_ON,
    Kind.COOLANT_OFF: EventKind.COOLANT_OFF,
    Kind.TOOL: EventKind.TOOL_CHANGE,
    Kind.DWELL: EventKind.DWELL,
    Kind.STOP: EventKind.STOP,
}
Said = tuple[int, EventKind, float, str]  # behind how many cuts, what, its value, its sense


class Point(NamedTuple):
    """A point of the toolpath."""

    tip: Array
    axis: Array
    feed: float
    cut: bool
    line: int


class Piece:
    """Cuts of the story that are one piece of camrob's: a motion, or so many rows that are a curve. tip, axis: where it ends."""

    def __init__(self, story: Story, rows: list[int], start: Array | None) -> None:
        path, first, self.rows = story.path, rows[0], len(rows)
        self.tip, self.axis = path.tip[rows[-1]], path.axis[rows[-1]]
        self.hole, self.feed, self.line = story.way[first] == Way.HOLE, story.feed[first], int(path.line[first])
        self.entry = story.pecks[first].entry if first in story.pecks else None  # the first peck's own feed
        self.slack = 0.0
        vertices = path.tip[rows] if start is None else np.vstack([start, path.tip[rows]])
        if start is not None and path.angle[first] > 0.0:
            center, normal, angle = path.center[first], path.normal[first], float(path.angle[first])
            height = float((start - center) @ normal) * normal
            arm, rise = start - center - height, float((vertices[-1] - start) @ normal)
            share = np.linspace(0.0, 1.0, 2 + math.ceil(angle * 200.0))[
                :, None
            ]  # 0.3 degrees a step, 1.3e-5 of its radius
            turned = np.cos(share * angle) * arm + np.sin(share * angle) * np.cross(normal, arm)
            vertices = center + height + turned + share * rise * normal
            self.slack = 4e-6 * float(np.linalg.norm(arm))
        self.vertices = vertices
        self.length = float(np.linalg.norm(np.diff(vertices, axis=0), axis=1).sum())

    def off(self, tip: Array) -> float:
        """How far a point lies from the piece beyond what its steps leave."""
        return _away(tip, self.vertices) - self.slack


def _away(tip: Array, vertices: Array) -> float:
    """How far a point lies from a chain of straight lines."""
    if len(vertices) == 1:
        return float(np.linalg.norm(tip - vertices[0]))
    begin, way = vertices[:-1], np.diff(vertices, axis=0)
    share = ((tip - begin) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-30)
    return float(np.linalg.norm(begin + share.clip(0.0, 1.0)[:, None] * way - tip, axis=1).min())


def _pieces(story: Story) -> Iterator[Piece]:
    path, rows = story.path, list[int]()

    def start(first: int) -> Array | None:
        stands = [stand.tip for stand in story.stands if stand.before == first]
        before = path.tip[first - 1] if first and story.joined[first] else None
        return before if before is not None else stands[0] if stands else None

    for i in np.flatnonzero(story.way != Way.RAPID).tolist():
        last = rows[-1] if rows else -2
        together = last == i - 1 and path.line[last] == path.line[i] and story.way[i] == story.way[last] == Way.FEED
        curve = together and path.angle[i] == 0.0 and path.angle[last] == 0.0
        turning = together and math.isnan(path.angle[i]) and float(np.abs(path.axis[i] - path.axis[last]).max()) > 1e-9
        if rows and not (curve or turning):
            yield Piece(story, rows, start(rows[0]))
            rows = []
        rows.append(i)
    if rows:
        yield Piece(story, rows, start(rows[0]))


def differences(toolpath: Toolpath, story: Story) -> list[str]:
    """Where the two differ, a line each; the first piece that does ends the comparison."""
    pieces = list(_pieces(story))
    known = np.vstack([story.path.tip, *(stand.tip for stand in story.stands)])
    chord = toolpath.chord_tolerance + 2.0 * PLACE
    round_rapids = [
        Piece(story, [i], story.path.tip[i - 1])
        for i in np.flatnonzero((story.way == Way.RAPID) & (story.path.angle > 0.0)).tolist()
        if i
    ]
    done, chunk, said = 0, list[Array](), list[Said]()
    here: tuple[Array, Array] | None = None
    for act in _acts(toolpath):
        if act is None:
            here = None
            continue
        if not isinstance(act, Point):
            said.append((done, *act))
            continue
        place, before = (act.tip, act.axis), here
        here = place
        piece = pieces[done] if done < len(pieces) else None
        if not act.cut:
            if chunk and not (piece and piece.hole):
                return [f"line {act.line}: a rapid where the witness still cuts"]
            if (
                not story.pecks
                and float(np.abs(known - act.tip).max(axis=1).min()) > PLACE
                and not _turned(before, place)
                and not any(arc.off(act.tip) <= chord for arc in round_rapids)
            ):
                return [f"line {act.line}: a rapid that the witness doesn't know, to {act.tip * 1e3} mm"]
            continue
        if (
            before is not None
            and not chunk
            and all(np.abs(a - b).max() < 1e-9 for a, b in zip(before, place, strict=True))
        ):
            continue
        if piece is None:
            return [f"line {act.line}: a cut that the witness doesn't know, to {act.tip * 1e3} mm"]
        if not chunk and before is not None:
            chunk.append(before[0])
        chunk.append(act.tip)
        if max(map(piece.off, chunk[-2:])) > PLACE + (chord if piece.slack == 0.0 and len(piece.vertices) > 2 else 0.0):
            return [f"line {act.line}: {act.tip * 1e3} mm is no point of the witness's cut of line {piece.line}"]
        rises = piece.hole and len(chunk) > 1 and float((chunk[-1] - chunk[-2]) @ (piece.tip - piece.vertices[0])) < 0.0
        feed = piece.feed if piece.entry is None or len(chunk) > 2 else piece.entry
        if not (rises or math.isnan(feed) or abs(act.feed - feed) <= 1e-6 * feed):
            return [f"line {act.line}: {act.feed * 6e4:.3f} mm/min, by the witness {feed * 6e4:.3f}"]
        at_end = float(np.abs(act.tip - piece.tip).max()) < PLACE and float(np.abs(act.axis - piece.axis).max()) < AXIS
        way = float(np.linalg.norm(np.diff(chunk, axis=0), axis=1).sum())
        if at_end and (piece.hole or way > MOST * piece.length - PLACE):
            if not piece.hole and max(_away(v, np.array(chunk)) for v in piece.vertices) > chord:
                return [f"line {act.line}: the witness's cut leaves the path"]
            done, chunk = done + 1, []
    if done < len(pieces):
        return [f"the path ends before the witness's cut of line {pieces[done].line}"]
    return _events(said, story, pieces)


def _turned(before: tuple[Array, Array] | None, place: tuple[Array, Array]) -> bool:
    """Whether a rapid turns the tool: camrob follows its way."""
    return before is not None and float(np.abs(before[1] - place[1]).max()) > 1e-9


def _acts(toolpath: Toolpath) -> Iterator[Point | tuple[EventKind, float, str] | None]:
    """Points and events in their order; None where the tool's place is lost."""
    for region in toolpath.regions:
        if region.detached:
            yield None
        for k in range(len(region) + 1):
            for event in region.events:
                if event.point == k and event.kind is not EventKind.MESSAGE:
                    yield event.kind, event.value, event.text if event.kind is EventKind.SPINDLE_ON else ""
            if k < len(region):
                cut = region.move[k] == Move.CUT
                yield Point(region.position[k], region.axis[k], float(region.feed[k]), cut, int(region.line[k]))


def _events(said: list[Said], story: Story, pieces: list[Piece]) -> list[str]:
    """Spindle, coolant, tool, dwells and stops between the same cuts."""
    ends = np.cumsum([piece.rows for piece in pieces])
    cuts = np.cumsum(np.append(0, story.way != Way.RAPID))
    told = [
        (int((ends <= cuts[e.before]).sum()), NAMES[e.kind], e.value, e.text if e.kind is Kind.SPINDLE_ON else "")
        for e in story.events
    ]
    ours, others = _thin(said, len(pieces)), _thin(told, len(pieces))
    alike = len(ours) == len(others) and all(
        a[:2] == b[:2] and a[3] == b[3] and math.isclose(a[2], b[2], rel_tol=1e-9, abs_tol=1e-9)
        for a, b in zip(ours, others, strict=True)
    )
    return [] if alike else [f"events {ours}, by the witness {others}"]


def _thin(said: list[Said], cuts: int) -> list[Said]:
    """Without what changes nothing, and what is only switched off behind the last cut."""
    kept: list[Said] = []
    state: dict[str, tuple[float, str] | None] = {"SPINDLE": None, "COOLANT": None}
    for event in said:
        what, _, way = event[1].name.partition("_")
        if what in state:
            now = None if way == "OFF" else (event[2], event[3])
            if now == state[what] or (now is None and event[0] >= cuts):
                continue
            state[what] = now
        if not (event[1] is EventKind.STOP and kept[-1:] == [event]):
            kept.append(event)
    return kept
