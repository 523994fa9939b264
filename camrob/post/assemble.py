"""From a solved path to a program: which motion ends where, at what speed, and what happens between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.kinematics.frames import world_T_base
from camrob.kinematics.kernels import chain_arrays, forward_many
from camrob.kinematics.spherical_wrist import spherical_arm
from camrob.kinematics.status_turn import StatusTurn
from camrob.post.arcs import circ_rows
from camrob.post.krl_round import round_axes, round_frame, round_pose, round_speed
from camrob.post.program import Motion, Program, ProgramEvent, ProgramEventKind
from camrob.resolve.path import TRANSIT, ToolPathInBase
from camrob.resolve.solution import Solution
from camrob.se3 import xyzabc_from_frame
from camrob.toolpath.region import Event, EventKind, Move, Region
from camrob.toolpath.toolpath import Toolpath
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["assemble_program", "printed_frames"]

Array = NDArray[np.float64]

_HOOKS = {
    EventKind.SPINDLE_ON: "spindle_on",
    EventKind.SPINDLE_OFF: "spindle_off",
    EventKind.COOLANT_ON: "coolant_on",
    EventKind.COOLANT_OFF: "coolant_off",
    EventKind.TOOL_CHANGE: "tool_change",
    EventKind.STOP: "stop",
}


@dataclass(slots=True)
class _Rows:
    """Rows of a program in the making: indices into the path, postures, kinds."""

    point: list[NDArray[np.int64]] = field(default_factory=list)
    q: list[Array] = field(default_factory=list)
    kind: list[NDArray[np.int8]] = field(default_factory=list)
    count: int = 0

    def add(self, point: NDArray[np.int64], q: Array, kind: NDArray[np.int8]) -> None:
        self.point.append(point)
        self.q.append(q)
        self.kind.append(kind)
        self.count += len(point)


def printed_frames(frames: Array) -> Array:
    """X, Y, Z, A, B, C (N, 6), mm and degrees, of poses (N, 4, 4)."""
    values = xyzabc_from_frame(frames)
    values[..., :3] = m_to_mm(values[..., :3])
    values[..., 3:] = rad_to_deg(values[..., 3:])
    return np.asarray(values)


def assemble_program(
    name: str,
    cell: Cell,
    toolpath: Toolpath,
    path: ToolPathInBase,
    solution: Solution,
    *,
    rapid_speed: float,
    keep: NDArray[np.bool_],
    speed: Array | None = None,
    comment: Sequence[str] = (),
) -> Program:
    """The program of a solved path: HOME, a PTP to the first point, LIN and CIRC along the path, HOME.

    rapid_speed: m/s of moves in air. keep: (N,) False for points that decimation leaves out. speed: (N,) m/s that replaces
    the programmed feed, where given. Poses are forward kinematics of the eight real axes, the virtual roll at 0.
    """
    rows, start_of = _rows(toolpath, path, solution, keep)
    point = np.concatenate(rows.point)
    q = np.concatenate(rows.q)
    kind = np.concatenate(rows.kind)
    axis_values = cell.to_axis_values(q)
    home = cell.to_axis_values(cell.q_home)[None]
    last_home = _home_without_unwinding(cell, home, axis_values[-1])
    axis_values = np.concatenate([home, axis_values, last_home])
    real = np.concatenate([cell.q_home[None], q, cell.to_q(last_home)])
    if cell.names[-1] == "roll":
        real[:, -1] = 0.0
    kind = np.concatenate([[Motion.PTP_AXES], kind, [Motion.PTP_AXES]])
    status_turn = StatusTurn.of(cell) if spherical_arm(cell) is not None else None
    kind[1] = Motion.PTP_AXES if status_turn is None else Motion.PTP_POSE
    point = np.concatenate([[-1], point, [-1]])
    frames = forward_many(chain_arrays(cell), real)
    if not cell.base_follows_table:  # $BASE stands in the hall, where `base` is when the table is at 0
        frames = world_T_base(cell, real) @ frames
    pose, external_values = round_pose(printed_frames(frames), axis_values[:, 6:])
    axes = round_axes(axis_values[:, :6])
    none = np.zeros(len(kind), np.int16)
    feed = _feed(path, path.feed if speed is None else speed, rapid_speed)
    of_path = point >= 0
    ptp = (kind == Motion.PTP_AXES) | (kind == Motion.PTP_POSE)
    return Program(
        name=name,
        kind=kind,
        pose=pose,
        axes=axes,
        external=external_values,
        external_names=cell.external_names,
        status=none if status_turn is None else status_turn.status(axes),
        turn=none if status_turn is None else status_turn.turn(axes),
        speed=round_speed(np.where(ptp, 0.0, np.where(of_path, _slowest(feed, point, kind), rapid_speed))),
        approximate=_approximate(path, point, kind, start_of, toolpath),
        line=np.where(of_path, path.line[point], 0),
        region=np.where(of_path, path.region[point], TRANSIT),
        safe=np.where(of_path, path.safe[point], True) & (kind != Motion.CIRC_VIA),
        tool=round_frame(printed_frames(np.asarray(cell.flange_T_tool))),
        base=np.zeros(6),
        comment=tuple(comment),
        events=_events(toolpath, start_of, kind),
    )


def _feed(path: ToolPathInBase, speed: Array, rapid_speed: float) -> Array:
    """(N,) m/s to each point: `speed` (N,) where it cuts, in air rapid_speed, and no more than its feed on the way back in."""
    feed = np.where(path.cutting, speed, rapid_speed)
    feed[path.entering] = np.minimum(feed, path.feed)[path.entering]
    return feed


def _home_without_unwinding(cell: Cell, home: Array, last: Array) -> Array:
    """HOME (1, axes) on the turns of endless external axes that lie nearest to the program's last point."""
    out = home.copy()
    for k, external in enumerate(cell.external_names, start=6):
        if cell.joints[cell.index(external)].endless:
            out[0, k] += 360.0 * np.round((last[k] - home[0, k]) / 360.0)
    return out


def _slowest(feed: Array, point: NDArray[np.int64], kind: NDArray[np.int8]) -> Array:
    """(rows,) speed of each motion: the slowest of the path points that it stands for, one for both rows of a CIRC."""
    ends = np.unique(point[point >= 0])
    starts = np.concatenate([[0], ends[:-1] + 1])
    slowest = np.full(len(feed), np.inf)
    slowest[ends] = np.minimum.reduceat(feed, starts)
    out = slowest[np.maximum(point, 0)]
    end = np.flatnonzero(kind == Motion.CIRC_END)
    out[end] = out[end - 1] = np.minimum(out[end], out[end - 1])
    return out


def _rows(
    toolpath: Toolpath, path: ToolPathInBase, solution: Solution, keep: NDArray[np.bool_]
) -> tuple[_Rows, dict[tuple[int, int], int]]:
    """Rows of the motions between the two HOMEs, and the row (HOME counted) of every kept point (region, source)."""
    rows = _Rows()
    regions = [r for r in toolpath.regions if len(r)]
    kind = np.full(len(path), int(Motion.LIN), np.int8)
    keep = keep.copy()
    places = [np.flatnonzero((path.region == index) & (path.source >= 0)) for index in range(len(regions))]
    marked = _marked(regions, places)
    keep[marked] = True
    for region, place in zip(regions, places, strict=True):
        circ_rows(region, place, kind, keep)
    revisions = {r.point: r for r in solution.revisions if r.kept}
    begin = 0
    for at in [*sorted(revisions), len(path)]:
        stop = min(at, len(path) - 1) + 1
        points = begin + np.flatnonzero(keep[begin:stop] | (np.arange(begin, stop) == at))
        q = solution.q[points].copy()
        if at in revisions:
            q[-1] = revisions[at].q[0]
        rows.add(points, q, kind[points])
        if at in revisions:
            moves = np.asarray(revisions[at].q[1:])
            motion = Motion.PTP_AXES if revisions[at].by_axes else Motion.LIN
            rows.add(np.full(len(moves), at), moves, np.full(len(moves), int(motion), np.int8))
        begin = at + 1
    point = np.concatenate(rows.point)
    row_of = np.full(len(path), -1)
    row_of[point[::-1]] = np.arange(len(point), 0, -1)  # first row of each point, HOME counted
    return rows, {(int(path.region[i]), int(path.source[i])): int(row_of[i]) for i in marked}


def _marked(regions: Sequence[Region], places: Sequence[NDArray[np.int64]]) -> list[int]:
    """Path points that events and region titles hang on."""
    marked: list[int] = []
    for region, place in zip(regions, places, strict=True):
        wanted = {0, *(min(e.point, len(region) - 1) for e in region.events)}
        marked += [int(place[k]) for k in sorted(wanted)]
    return marked


def _approximate(
    path: ToolPathInBase,
    point: NDArray[np.int64],
    kind: NDArray[np.int8],
    start_of: dict[tuple[int, int], int],
    toolpath: Toolpath,
) -> NDArray[np.bool_]:
    """(rows,) C_DIS: everywhere but where cutting begins or ends, where something happens, and at HOME and PTP."""
    move = np.where(point >= 0, path.move[np.maximum(point, 0)], int(Move.LINK))
    cutting = move == Move.CUT
    follows = np.append(cutting[1:], False)
    result = (cutting == follows) & (kind != Motion.PTP_AXES) & (kind != Motion.PTP_POSE)
    result[-2] = False
    result &= kind != Motion.CIRC_VIA
    regions = [r for r in toolpath.regions if len(r)]
    for index, region in enumerate(regions):
        for event in region.events:
            if event.kind is not EventKind.MESSAGE:
                row = start_of.get((index, min(event.point, len(region) - 1)), 0)
                if row > 0:
                    result[row - 1 if event.point < len(region) else row] = False
    same = np.append(point[1:] == point[:-1], False)  # a revision's moves end exactly
    result[same] = False
    result[1:][same[:-1]] = False
    return np.asarray(result)


def _events(
    toolpath: Toolpath, start_of: dict[tuple[int, int], int], kind: NDArray[np.int8]
) -> tuple[ProgramEvent, ...]:
    """What is written between motions, in order."""
    events: list[tuple[int, ProgramEvent]] = []
    regions = [r for r in toolpath.regions if len(r)]
    for index, region in enumerate(regions):
        start = start_of[index, 0]
        # a region's opening stands before its way in, so that a tool is changed in the clear
        opening = 1 if index == 0 else max(start - 1, 1)
        events.append((opening, ProgramEvent(opening, ProgramEventKind.FOLD, region.name)))
        for event in region.events:
            row = start_of.get((index, min(event.point, len(region) - 1)), start)
            row = opening if event.point == 0 else row + (event.point >= len(region))
            row = min(row, len(kind) - 1)
            if kind[row] == Motion.CIRC_END:  # nothing can stand between a CIRC's two points
                row -= 1
            events.append((row, _event(event, row)))
    return tuple(e for _, e in sorted(events, key=lambda pair: pair[0]))


def _event(event: Event, row: int) -> ProgramEvent:
    if event.kind is EventKind.DWELL:
        return ProgramEvent(row, ProgramEventKind.DWELL, value=event.value)
    if event.kind is EventKind.MESSAGE:
        return ProgramEvent(row, ProgramEventKind.COMMENT, event.text)
    if event.kind is EventKind.TOOL_CHANGE and event.value <= 0.0:  # the file names a tool without a number
        return ProgramEvent(row, ProgramEventKind.COMMENT, f"tool {event.text}")
    return ProgramEvent(row, ProgramEventKind.HOOK, _HOOKS[event.kind], event.value)
