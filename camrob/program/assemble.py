"""From a solved path to a program: which motion ends where, at what speed, and what happens between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.status_turn import StatusTurn
from camrob.kinematics.frames import seen_by_program
from camrob.kinematics.kernels import chain_arrays, forward_many
from camrob.kinematics.spherical_wrist import spherical_arm
from camrob.program.axis_turns import turn_of
from camrob.program.builder import build_program, printed_frames
from camrob.program.language import Language
from camrob.program.motion import Motion
from camrob.program.motion_ends import kept_points
from camrob.program.process import Place, Process
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.program.program_events import ProgramRows, RegionPoints, program_events
from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.redundancy.solution import Lead, Solution
from camrob.redundancy.stretches import change_values, home_values
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath

__all__ = ["assemble_program"]

Array = NDArray[np.float64]

_CHUNK = 16_384  # rows whose poses are worked out at once: bounds the memory
_SAID = 0.05  # mm and degrees: what is printed
_ALONG = 0.999999  # cosine to the tool's axis from which a way is one down or up a hole (0.08 degrees)


@dataclass(frozen=True, slots=True)
class _Rows:
    """Rows of a program: the path points that they lead to (-1: none), postures, axis values, kinds, and stretches."""

    point: NDArray[np.int64]
    q: Array
    axis_values: Array
    kind: NDArray[np.int8]
    stretch: NDArray[np.int64]


def assemble_program(
    name: str,
    cell: Cell,
    toolpath: Toolpath,
    path: ToolPathInBase,
    solution: Solution,
    *,
    process: Process,
    cells: Sequence[Cell],
    loads: Array | None = None,
    rapid_speed: float,
    keep: NDArray[np.bool_],
    speed: Array | None = None,
    comment: Sequence[str] = (),
    language: Language,
) -> Program:
    """The program of a solved path: HOME, a PTP to the first point, LIN and CIRC along the path, HOME.

    process: what happens on the way. cells: for each stretch of the path the cell with the tool that it is made with; between
    two of them lies the pose for changes, to which and from which PTP leads. loads: (stretches, 7) kg, mm and kg m^2, what
    hangs on the flange on each, None where nobody says. rapid_speed: m/s of moves in air. keep: (N,) False for points that
    decimation leaves out. speed: (N,) m/s that replaces the feed, where given. Poses are of the eight real axes, the virtual
    roll at 0.
    """
    rounding = language.round
    points = RegionPoints(path, [r for r in toolpath.regions if len(r)])
    rows = _with_leads(cell, path, _path_rows(cell, points, solution, keep, process), points, process, solution.leads)
    point, kind = rows.point, rows.kind
    real = rows.q.copy()
    real[:, list(cell.indices(Role.ROLL))] = 0.0
    axes = rounding.axes(rows.axis_values[:, :6])
    status_turn = StatusTurn.of(cell) if spherical_arm(cell) is not None else None
    feed = _feed(path, path.feed if speed is None else speed, rapid_speed)
    of_path = point >= 0
    of_stretch = np.stack([rounding.frame(printed_frames(np.asarray(c.flange_T_tool))) for c in cells])
    tools, index = np.unique(of_stretch, axis=0, return_inverse=True)
    changed = np.flatnonzero(np.diff(index.ravel())) + 1
    program_rows = ProgramRows(points, point)
    begins = [0, *(c.region for c in process.changes)]
    mounted = {begins[k]: int(index.ravel()[k]) for k in changed.tolist()}
    held = np.zeros((0, 7)) if loads is None else rounding.load(loads)
    other = [k for k in range(len(held)) if k == 0 or not np.array_equal(held[k], held[k - 1])]
    events, placed = program_events(process, program_rows, mounted, {begins[k]: k for k in other})
    events = tuple(sorted([*events, *_revisions_said(cell, rows)], key=lambda e: e.motion))
    return build_program(
        name,
        cells[0],
        rounding,
        kind=kind,
        axis_values=rows.axis_values,
        frames=_frames(cells, real, rows.stretch),
        status=0 if status_turn is None else status_turn.status(axes),
        turn=0 if status_turn is None else turn_of(language.turning, axes),
        speed=np.where(of_path, _slowest(feed, point, kind), rapid_speed),
        approximate=_approximate(path, rows, process, program_rows, placed, everywhere=not language.stops),
        line=np.where(of_path, path.line[point], 0),
        region=np.where(of_path, path.region[point], TRANSIT),
        safe=np.where(of_path, path.safe[point], True) & (kind != Motion.CIRC_VIA),
        comment=comment,
        events=events,
        tools=tools if len(changed) else None,
        loads=held,
    )


def _frames(cells: Sequence[Cell], real: Array, stretch: NDArray[np.int64]) -> Array:
    """Poses (M, 4, 4) of the real tool of each stretch, in the frame that the program's base is printed in."""
    frames = np.empty((len(real), 4, 4))
    for k, cell in enumerate(cells):
        chain, whole = chain_arrays(cell), np.flatnonzero(stretch == k)
        for start in range(0, len(whole), _CHUNK):
            here = whole[start : start + _CHUNK]
            frames[here] = seen_by_program(cell, real[here], forward_many(chain, real[here]))
    return frames


def _with_leads(
    cell: Cell, path: ToolPathInBase, made: _Rows, points: RegionPoints, process: Process, leads: Sequence[Lead]
) -> _Rows:
    """The rows with those that lead to them: HOME, the poses at which tools are changed, HOME, and what lies on the ways there;
    PTP to each stretch's first.
    """
    first = Motion.PTP_AXES if spherical_arm(cell) is None else Motion.PTP_POSE
    kind = made.kind.copy()
    parts: list[_Rows] = []
    last = cell.to_axis_values(cell.q_home)
    parts.append(_lead(cell, home_values(cell, last), 0))
    for k in range(int(path.stretch[-1]) + 1):
        here = np.flatnonzero(made.stretch == k)
        kind[here[0]] = first
        if k or (process.mounts_first and cell.controller.tool_change_pose is not None):
            parts.append(_lead(cell, change_values(cell, last), k))
        last = made.axis_values[here[-1]]
        lead = leads[k] if leads else Lead.straight(len(cell))
        parts += [_lead(cell, values, k) for values in cell.to_axis_values(np.asarray(lead.into))]
        parts.append(_Rows(made.point[here], made.q[here], made.axis_values[here], kind[here], made.stretch[here]))
        parts += [_lead(cell, values, k) for values in cell.to_axis_values(np.asarray(lead.out))]
    behind = any(c.region == len(points.regions) for c in process.changes)
    if behind and cell.controller.tool_change_pose is not None:
        last = change_values(cell, last)
        parts.append(_lead(cell, last, int(path.stretch[-1])))
    parts.append(_lead(cell, home_values(cell, last), int(path.stretch[-1])))
    return _Rows(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(_Rows)))


def _lead(cell: Cell, axis_values: Array, stretch: int) -> _Rows:
    """The row of a PTP to axis values (axes,)."""
    kind = np.array([int(Motion.PTP_AXES)], np.int8)
    return _Rows(np.array([-1]), cell.to_q(axis_values)[None], axis_values[None], kind, np.array([stretch]))


def _feed(path: ToolPathInBase, speed: Array, rapid_speed: float) -> Array:
    """(N,) m/s to each point: `speed` (N,) where it cuts, in air rapid_speed, no more than its feed on the way back in, and no
    more than rapid_speed to a first point that the file comes to at a feed from where only its machine knows.
    """
    feed = np.where(path.cutting, speed, rapid_speed)
    feed[path.entering] = np.minimum(feed, path.feed)[path.entering]
    begins = path.cutting & (path.source == 0)
    feed[begins] = np.minimum(feed, rapid_speed)[begins]
    return feed


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


def _path_rows(
    cell: Cell, points: RegionPoints, solution: Solution, keep: NDArray[np.bool_], process: Process
) -> _Rows:
    """Rows of the motions along the path, posture revisions among them."""
    path = points.path
    keep, kind = kept_points(points, keep, process)
    revisions = {r.point: r for r in solution.revisions if r.kept}
    out: list[tuple[NDArray[np.int64], Array, NDArray[np.int8]]] = []
    begin = 0
    for at in [*sorted(revisions), len(path)]:
        stop = min(at, len(path) - 1) + 1
        here = begin + np.flatnonzero(keep[begin:stop] | (np.arange(begin, stop) == at))
        q = solution.q[here].copy()
        if at in revisions:
            q[-1] = revisions[at].q[0]
        out.append((here, q, kind[here]))
        if at in revisions:
            moves = np.asarray(revisions[at].q[1:])
            motion = Motion.PTP_AXES if revisions[at].by_axes else Motion.LIN
            out.append((np.full(len(moves), at), moves, np.full(len(moves), int(motion), np.int8)))
        begin = at + 1
    point, q, kinds = (np.concatenate(column) for column in zip(*out, strict=True))
    return _Rows(point, q, cell.to_axis_values(q), kinds, path.stretch[point])


def _revisions_said(cell: Cell, rows: _Rows) -> list[ProgramEvent]:
    """A comment before each posture revision, whose first move repeats the point before it: what moves while the tip stays."""
    again = (rows.point[1:] == rows.point[:-1]) & (rows.point[1:] >= 0)
    first = np.flatnonzero(again & ~np.append(False, again[:-1])) + 1
    out = []
    for row in first.tolist():
        stay = np.flatnonzero(rows.point[row:] != rows.point[row])
        last = row + (int(stay[0]) if len(stay) else len(rows.point) - row) - 1
        values = rows.axis_values[[row - 1, last], 6:] + 0.0
        moved = [
            f"{name} {a:.1f} to {b:.1f}"
            for name, (a, b) in zip(cell.external_names, values.T, strict=True)
            if abs(b - a) > _SAID
        ]
        what = ", ".join(moved) if moved else "the arm"
        how = "by axes, the tip swings out" if rows.kind[row] == Motion.PTP_AXES else "the tip stays"
        out.append(ProgramEvent(row, ProgramEventKind.COMMENT, f"posture revision, {how}: {what}"))
    return out


def _turns(frames: Array, kind: NDArray[np.int8]) -> NDArray[np.bool_]:
    """(M,) True where a LIN goes along the tool's axis and the next one back: rounded off, neither a hole's bottom is reached,
    nor, between two pecks, the height at which the tool is out of it.

    frames: (M, 4, 4) poses at the rows' ends.
    """
    way = np.diff(frames[:, :3, 3], axis=0)
    along = np.sum(way * frames[1:, :3, 2], axis=1)
    plain = np.abs(along) > _ALONG * np.linalg.norm(way, axis=1)
    out = np.zeros(len(frames), np.bool_)
    out[1:-1] = (along[:-1] * along[1:] < 0.0) & plain[:-1] & plain[1:]
    out[1:-1] &= (kind[1:-1] == Motion.LIN) & (kind[2:] == Motion.LIN)
    return out


def _approximate(
    path: ToolPathInBase,
    rows: _Rows,
    process: Process,
    program_rows: ProgramRows,
    placed: Sequence[int],
    *,
    everywhere: bool,
) -> NDArray[np.bool_]:
    """(M,) rounded off: everywhere but where cutting begins or ends, at turns in holes, events, HOME and PTP.

    placed: the row that each step of the process stands before. everywhere: also before what happens in air, as the language's
    own statements don't stop the robot.
    """
    point, kind = rows.point, rows.kind
    move = np.where(point >= 0, path.move[np.maximum(point, 0)], int(Move.LINK))
    cutting = move == Move.CUT
    begins = (point >= 0) & (path.source[np.maximum(point, 0)] == 0)
    cutting[1:] &= ~(begins[1:] & (move[:-1] == Move.LINK))  # the way in to a region's first point is no cut yet
    follows = np.append(move[1:] == Move.CUT, False)
    result = (cutting == follows) & (kind != Motion.PTP_AXES) & (kind != Motion.PTP_POSE)
    result[np.flatnonzero(point[1:] < 0)] = False  # before the way to HOME, or to where tools are changed
    result &= kind != Motion.CIRC_VIA
    result &= ~_turns(np.asarray(path.base_T_tip)[np.maximum(point, 0)], kind)
    for step, row in zip(process.steps, placed, strict=True):
        if step.kind is EventKind.MESSAGE:
            continue
        inside = step.place in (Place.INSIDE, Place.END)
        if inside or everywhere:
            result[row - 1] = False
        if not inside and step.region < len(program_rows.points.regions):  # the way in begins at rest
            result[program_rows.start(step.region) - 1] = False
    same = np.append(point[1:] == point[:-1], False)  # a revision's moves end exactly
    result[same] = False
    result[1:][same[:-1]] = False
    return np.asarray(result)
