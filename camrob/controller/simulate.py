"""The ideal controller: a program's text in, a log out, row by row as a robot without any error would run it.

The model (all of it from the text and the cell; nothing of the solver takes part): the program begins where its first target
is. PTP moves all axes together; LIN and CIRC lead the tool at the programmed speed, or slower where the acceleration, the
tool's rotation or an axis asks for it. Blended corners are rounded within the programmed distance (by speed, by angle: where
they begin), at most half of the shorter motion; a corner whose rounding would be over within 4 ms is passed at a point, at a
speed that the accelerations can change within that time (rows there may show up to 4/3 of a limit at 12 ms, twice at 4 ms).
As many motions are known ahead as the program says, and where it changes its tool the robot stands. No motion along a line or an
arc takes less than the cell's `block_ms`. Jerk is not limited.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.controller.interpolate import OUT_OF_REACH, PTP, REACHED, to_world
from camrob.controller.layout import CORNER_TIME, Layout, carrier_of, lay_out
from camrob.controller.least_times import LEAST_TIME, ShortBlocks, block_ceilings_of, joined_blocks, short_blocks
from camrob.controller.motion_settings import MotionSettings, motion_settings
from camrob.controller.pieces import course_of, cut, motion_ends
from camrob.controller.replay import Replay, replay
from camrob.controller.speed_profile import CAUSES, FEED, Bounds, brake, cruise, look_ahead, run_up, where_at
from camrob.controller.tool_runs import tool_runs
from camrob.controller.walk import walk_of
from camrob.errors import ProgramError, UnreachableError
from camrob.findings import Finding
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import ORIENTATION, POSITION, MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.program.program_text import ProgramText
from camrob.progress import Share, part_of
from camrob.se3 import rotation_to_abc
from camrob.units import m_to_mm, rad_to_deg

__all__ = [
    "Approximation",
    "FeedLost",
    "Simulation",
    "Timetable",
    "approximation",
    "blocks_of",
    "simulate",
    "timetable",
]

Array = NDArray[np.float64]

CYCLE = 0.012  # s, the controller's usual cycle
_JUMP = 0.35  # rad between nodes; more is a flip, as in the replay
_CHUNK = 100_000
_MOST_ROWS = 20_000_000


@dataclass(frozen=True, slots=True)
class Approximation:
    """Roundings of corners: how many, and the largest deviation (m) from a programmed corner, with its program line.

    line is 0 where nothing is rounded.
    """

    corners: int
    deviation: float
    line: int


@dataclass(frozen=True, slots=True)
class FeedLost:
    """Seconds more than CP motion at its programmed speed throughout would take: as a whole, and by what held the tool back."""

    seconds: float
    by_cause: dict[str, float]


@dataclass(frozen=True, slots=True)
class Simulation:
    """What the ideal controller does with a program.

    log: a row a cycle, encoders equal to set-points, TCP in `world`. duration: s. motion: (N,) row of the program that
    each sample belongs to. peak_speed, peak_acceleration: by axis, the share of its limit that it reaches. blocks: motions that
    are too short for the controller, None where the cell says nothing of it.
    """

    log: MeasurementLog
    duration: float
    motion: NDArray[np.int64]
    approximation: Approximation
    feed_lost: FeedLost
    peak_speed: dict[str, float]
    peak_acceleration: dict[str, float]
    findings: tuple[Finding, ...] = ()
    blocks: ShortBlocks | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", locked(self.motion, dtype=np.int64, name="motion"))


@dataclass(frozen=True, slots=True)
class Timetable:
    """When the ideal controller passes each place of a program.

    place: (K,) rising: m + x where the share x of the motion to row `row[m]` of the program is done. arrive, leave: (K,) s.
    way: (K,) m of the tool's path so far. feed: (K - 1,) s that a step would take as programmed (as long as it does take, where
    that does not apply); cause: (K - 1,) what sets its speed, a number of `causes`.
    """

    row: NDArray[np.int64]
    place: Array
    arrive: Array
    leave: Array
    way: Array
    feed: Array
    cause: NDArray[np.int64]
    causes: tuple[str, ...]


def timetable(program: ProgramText, replayed: Replay) -> Timetable:
    """When a replayed program passes its places, without the rows of a log. Raises what `simulate` does."""
    settings = motion_settings(program, replayed.cell)
    replayed.demand_followed()
    return _Run(program, replayed, settings, CYCLE, None).timetable()


def approximation(program: ProgramText, replayed: Replay) -> Approximation:
    """The largest deviation of a replayed program's roundings from its corners. Raises what `simulate` does."""
    return _largest([_approximation(text, _laid_out(text, done)[0]) for text, done, _ in _by_tool(program, replayed)])


def blocks_of(program: ProgramText, replayed: Replay) -> ShortBlocks | None:
    """The motions of a replayed program that are too short for the controller. Raises what `simulate` does."""
    runs = _by_tool(program, replayed)
    return joined_blocks([short_blocks(done.cell, *_laid_out(text, done)) for text, done, _ in runs])


def _by_tool(program: ProgramText, replayed: Replay) -> list[tuple[ProgramText, Replay, NDArray[np.int64]]]:
    """The program between its changes of tools, replayed, with the rows of the whole."""
    if not replayed.others:
        return [(program, replayed, np.arange(len(program)))]
    replayed.demand_followed()
    return [(text, replay(text, cell), rows) for text, cell, rows in tool_runs(program, replayed)]


def _largest(found: Sequence[Approximation]) -> Approximation:
    worst = max(found, key=lambda one: one.deviation)
    return Approximation(sum(one.corners for one in found), worst.deviation, worst.line)


def _laid_out(program: ProgramText, replayed: Replay) -> tuple[Layout, MotionSettings]:
    """The path of a replayed program, and the settings that it runs with."""
    settings = motion_settings(program, replayed.cell)
    replayed.demand_followed()
    return lay_out(program, replayed, settings), settings


def _approximation(program: ProgramText, layout: Layout) -> Approximation:
    deviation = np.asarray(layout.deviation)
    corners = int(np.sum(np.asarray(layout.reach) > 0.0))
    if deviation.max(initial=0.0) == 0.0:
        return Approximation(corners, 0.0, 0)
    worst = int(np.argmax(deviation))
    return Approximation(corners, float(deviation[worst]), int(program.line[layout.row[worst + 1]]))


def simulate(program: ProgramText, cell: Cell, *, cycle: float = CYCLE, progress: Share | None = None) -> Simulation:
    """Run a program on the ideal controller; a row every `cycle` s.

    Raises ProgramError for settings that no controller takes and CP motions without a speed, UnreachableError (with the line)
    where a motion can't be followed, ValueError for a cycle that is no positive number. Cost: some hundred microseconds
    a motion and five a row.
    """
    if not (np.isfinite(cycle) and cycle > 0.0):
        raise ValueError(f"cycle is {cycle}, a positive number of seconds is needed")
    settings = motion_settings(program, cell)
    replayed = replay(program, cell, progress=None if progress is None else lambda share: progress(0.3 * share))
    replayed.demand_followed()
    if not replayed.others:
        return _Run(program, replayed, settings, cycle, progress).result()
    runs = _by_tool(program, replayed)
    made = []
    for k, (text, done, rows) in enumerate(runs):
        done.demand_followed()
        share = None if progress is None else part_of(progress, k, len(runs))
        one = _Run(text, done, motion_settings(text, done.cell), cycle, share).result()
        made.append(replace(one, motion=rows[np.asarray(one.motion)]))
    return _in_turn(made, cycle, (*replayed.findings, *settings.findings))


def _in_turn(made: Sequence[Simulation], cycle: float, findings: tuple[Finding, ...]) -> Simulation:
    """Runs with one tool each as one: each begins a cycle after the last row of the one before it."""
    columns: dict[str, list[Array]] = {name: [] for name in made[0].log.columns}
    begins, duration = 0.0, 0.0
    lost: dict[str, float] = {}
    for one in made:
        for name, values in one.log.columns.items():
            columns[name].append(np.asarray(values) + (begins if name == "t" else 0.0))
        duration = begins + one.duration
        begins = float(columns["t"][-1][-1]) + cycle
        for cause, seconds in one.feed_lost.by_cause.items():
            lost[cause] = lost.get(cause, 0.0) + seconds
    axes = made[0].peak_speed
    return Simulation(
        MeasurementLog({name: np.concatenate(parts) for name, parts in columns.items()}, made[0].log.info),
        duration,
        np.concatenate([np.asarray(one.motion) for one in made]),
        _largest([one.approximation for one in made]),
        FeedLost(sum(one.feed_lost.seconds for one in made), dict(sorted(lost.items(), key=lambda item: -item[1]))),
        {name: max(one.peak_speed[name] for one in made) for name in axes},
        {name: max(one.peak_acceleration[name] for one in made) for name in axes},
        findings,
        joined_blocks([one.blocks for one in made]),
    )


class _Run:
    """A simulation on its way from the path over the speed to the rows."""

    def __init__(
        self,
        program: ProgramText,
        replayed: Replay,
        settings: MotionSettings,
        cycle: float,
        progress: Share | None,
    ) -> None:
        self.program, self.cell, self.settings, self.cycle = program, replayed.cell, settings, cycle
        self.tell = progress or (lambda share: None)
        self.findings = (*replayed.findings, *settings.findings)
        self.carrier = carrier_of(self.cell)
        self.layout = lay_out(program, replayed, settings)
        self.pieces = cut(self.cell, self.layout, settings)
        self.walk = walk_of(self.cell, self.layout.motions, self.pieces)
        self.start = np.asarray(self.layout.motions.q[0]).copy()
        self.nodes = self._trace()
        self.tell(0.5)
        self.x, self.seconds, self.cause = self._speeds()
        self.arrive, self.leave = self._clock()
        self.tell(0.7)

    def _trace(self) -> tuple[Array, Array]:
        """Postures and tool positions at the nodes."""
        pieces = self.pieces
        K = int(pieces.steps.sum()) + 1
        q, p = np.zeros((K, len(self.cell))), np.zeros((K, 3))
        q[0] = self.start
        code, k = self.walk.nodes(self.start, _JUMP, q, p)
        if code != REACHED:
            line = int(self.program.line[self.layout.row[pieces.motion[k] + 1]])
            what = "the tool leaves the arm's reach" if code == OUT_OF_REACH else "the arm would have to flip"
            where = " in the rounding of the corner behind this motion" if pieces.blend[k] > 0.0 else " on this motion"
            raise UnreachableError(f"{what}{where}; move the target, or the part", line=line, of_program=True)
        return q, p

    def _speeds(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Square speed at the nodes, seconds and cause of the steps."""
        settings = self.settings
        course = course_of(self.layout, settings, self.pieces, *self.nodes)
        bounds = Bounds(
            np.ascontiguousarray(settings.axis_speed),
            np.ascontiguousarray(settings.axis_acceleration),
            settings.turn_speed,
            settings.turn_acceleration,
            CORNER_TIME,
        )
        ceiling = block_ceilings_of(self.cell, self.layout, self.pieces)
        held = np.repeat(ceiling < course.cap, self.pieces.steps)
        course = course._replace(cap=np.minimum(course.cap, ceiling))
        cap, cause = cruise(course, bounds)
        x, why = brake(course, bounds, cap, cause)
        last, piece = motion_ends(self.layout, self.pieces)
        x, why = look_ahead(course, bounds, x, why, settings.advance, last, piece)
        x, seconds, cause = run_up(course, bounds, x, why)
        return x, seconds, np.where(held & (cause == FEED), len(self._texts) - 1, cause)

    def _clock(self) -> tuple[Array, Array]:
        """When each node is reached, and left."""
        rest = np.zeros(len(self.x))
        wait = np.asarray(self.layout.wait)
        rest[0] = wait[0]
        rest[motion_ends(self.layout, self.pieces)[0]] += wait[1:]
        arrive = np.concatenate([[0.0], np.cumsum(self.seconds + rest[:-1])])
        return arrive, arrive + rest

    def result(self) -> Simulation:
        """The rows, and what is reported beside them."""
        duration = float(self.leave[-1])
        if duration / self.cycle > _MOST_ROWS:
            what = f"takes {duration:.3g} s, which is more than {_MOST_ROWS} rows"
            raise ProgramError(what, hint="check speeds and waits, or use a longer cycle", path=self.program.files[0])
        count = int(np.ceil(duration / self.cycle - 1e-9)) + 1
        t = np.asarray(self.cycle * np.arange(count), float)
        q, position, rotation = np.zeros((count, len(self.cell))), np.zeros((count, 3)), np.zeros((count, 3, 3))
        end = np.zeros(count, np.int64)
        for start in range(0, count, _CHUNK):
            rows = slice(start, min(start + _CHUNK, count))
            self._rows(t[rows], q[rows], position[rows], rotation[rows], end[rows])
            self.tell(0.7 + 0.3 * rows.stop / count)
        motion = self.layout.row[end]
        axes = self.cell.to_axis_values(q)
        columns = dict(zip(("t", *POSITION), (t, *m_to_mm(position).T), strict=True))
        columns |= dict(zip(ORIENTATION, rad_to_deg(rotation_to_abc(rotation)).T, strict=True))
        for name, values in zip(self.cell.axis_names, axes.T, strict=True):
            columns[name] = columns[f"c{name}"] = values
        columns["line"] = np.asarray(self.program.line)[motion].astype(float)
        info = LogInfo(program=Path(self.program.files[0]).name, instrument="camrob simulate")
        return Simulation(
            MeasurementLog(columns, info),
            duration,
            motion,
            _approximation(self.program, self.layout),
            self._lost(),
            *self._peaks(q),
            self.findings,
            short_blocks(self.cell, self.layout, self.settings),
        )

    def _rows(self, t: Array, q: Array, position: Array, rotation: Array, end: NDArray[np.int64]) -> None:
        """Fill the rows at times t: posture, TCP in `world`, end of the motion that each belongs to."""
        pieces, motions = self.pieces, self.layout.motions
        if len(pieces.motion) == 0:  # nothing moves
            q[:] = self.start
            world_T_tool = world_T_base(self.cell, q) @ base_T_tool(self.cell, q)
            position[:], rotation[:] = world_T_tool[:, :3, 3], world_T_tool[:, :3, :3]
            return
        piece, at, before = where_at(pieces, self.x, self.arrive, self.leave, t)
        done = self.walk.rows(piece, at, self.nodes[0][before], q, position, rotation)
        m, reach = pieces.motion[piece], pieces.blend[piece]
        end[:] = m + 1 + ((reach > 0.0) & (at > reach))
        resting = (t < self.leave[before]) & (at == 0.0)
        end[resting] = np.where(piece[resting] > 0, pieces.motion[piece[resting] - 1] + 1, 0)
        if done < len(t):
            line = int(self.program.line[self.layout.row[end[done]]])
            raise UnreachableError(
                "the tool leaves the arm's reach on this motion; move the target, or the part",
                line=line,
                of_program=True,
            )
        turning = (motions.kind[m] == PTP) | (not self.layout.in_world)
        if self.carrier is not None:
            to_world(*self.carrier, q, turning, position, rotation)

    def _at_feed(self) -> tuple[Array, NDArray[np.bool_]]:
        """Seconds of every step at the programmed speed, and where that applies: CP motions that lead the tool anywhere."""
        pieces, motions, layout = self.pieces, self.layout.motions, self.layout
        m = np.repeat(pieces.motion, pieces.steps)
        way = np.linalg.norm(np.diff(self.nodes[1], axis=0), axis=1)
        counts = (motions.kind[m] != PTP) & (np.asarray(layout.length)[m] > 1e-6)
        speed = np.where(counts, self.settings.speed[layout.row[1:]][m], 1.0)
        return np.where(counts, way / speed, self.seconds), counts

    @property
    def _texts(self) -> tuple[str, ...]:
        names = self.cell.names
        return (*CAUSES, *(f"{n} speed" for n in names), *(f"{n} acceleration" for n in names), LEAST_TIME)

    def timetable(self) -> Timetable:
        """When each node is passed."""
        pieces, size = self.pieces, np.asarray(self.layout.motions.size)
        k = np.repeat(np.arange(len(pieces.motion)), pieces.steps)
        done = (np.arange(1, len(k) + 1) - pieces.first[k]) * (pieces.length / pieces.steps)[k]
        m, reach = pieces.motion[k], pieces.blend[k]
        beyond = (reach > 0.0) & (done > reach)
        after = np.minimum(m + 1, len(size) - 1)
        inside = np.where(reach > 0.0, size[m] - reach + done, pieces.start[k] + done) / size[m]
        place = np.where(beyond, m + 1.0 + (done - reach) / size[after], m + inside)
        way = np.linalg.norm(np.diff(self.nodes[1], axis=0), axis=1)
        return Timetable(
            self.layout.row[1:],
            np.concatenate([[0.0], np.maximum.accumulate(place)]),
            self.arrive,
            self.leave,
            np.concatenate([[0.0], np.cumsum(way)]),
            self._at_feed()[0],
            self.cause,
            self._texts,
        )

    def _lost(self) -> FeedLost:
        """What the CP motion of the tool loses against its programmed speed."""
        feed, counts = self._at_feed()
        counts &= self.cause != FEED
        lost = np.maximum(self.seconds[counts] - feed[counts], 0.0)
        texts = self._texts
        sums = np.bincount(self.cause[counts], weights=lost, minlength=len(texts))
        by_cause = {texts[k]: float(sums[k]) for k in np.argsort(-sums) if sums[k] > 1e-6}
        return FeedLost(float(lost.sum()), by_cause)

    def _peaks(self, q: Array) -> tuple[dict[str, float], dict[str, float]]:
        """The share of its top speed and acceleration that every axis reaches between the rows."""
        out: list[dict[str, float]] = []
        rate = np.diff(q, axis=0) / self.cycle
        for values, quantity in ((rate, "speed"), (np.diff(rate, axis=0) / self.cycle, "acceleration")):
            share = np.abs(values).max(axis=0, initial=0.0) / self.cell.limits_of(quantity)
            out.append({name: float(share[self.cell.index(name)]) for name in self.cell.axis_names})
        return out[0], out[1]
