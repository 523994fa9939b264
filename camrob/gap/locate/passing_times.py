"""When a run passes the places of its program, beside when the virtual controller would: apart from the gap."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from camrob.controller.simulate import Timetable, timetable
from camrob.errors import CamrobError
from camrob.gap.observation.pauses import Rest, rests_of
from camrob.gap.observation.program_track import ProgramTrack
from camrob.gap.observation.scene import Scene
from camrob.summaries.diagnosis_places import LostTime, RunDuration, RunSpeed, RunTiming, SpeedSpread, SteadySpeed
from camrob.summaries.diagnosis_places import Rest as RestSaid
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["timing_of"]

Array = NDArray[np.float64]

_DISORDER = 0.05  # share of the samples that may lie out of the program's order
_STEP_BACK = 0.5  # motions that a sample may lie behind the one before it
_SLOW = 1.15  # times the time at the programmed speed: a motion that takes as much loses time
_JOINED = 2  # motions between two slow ones that don't part them
_MOST = 6
_LEAST_LOSS = 0.1  # s
_NEAR = 0.05  # share of the programmed speed within which it counts as held
_BIN = 0.01  # of the programmed speed, for the speed that is held most of the time
_STEADY = 0.5  # share of the time for which one speed is called steady
# share of an axis's highest, or the tool's usual, speed within which it counts as at that speed
_TOP, _FLAT = 0.1, 0.03
_PAUSE = "pause"  # a rest that the program doesn't ask for
_MOVES = 0.01  # share of the programmed speed below which the tool rests


def timing_of(scene: Scene, track: ProgramTrack | None, why: str) -> RunTiming:
    """What is said of one log. track: its program laid beside it; why: what is said where there is none."""
    if track is None:
        return _untimed(scene, why)
    try:
        table = timetable(track.program, track.replayed)
    except CamrobError as error:
        return _untimed(scene, f"the virtual controller can't run the program ({error})")
    run = _Run(track, table)
    if not len(table.feed):
        return _untimed(scene, "the program moves nothing")
    if not run.in_order:
        why = "its samples can't be laid along the program in order (it holds no usable program lines)"
        return _untimed(scene, why)
    if run.end <= run.begin or len(run.edges) < 2:
        return _untimed(scene, "the robot does not move along the program in it")
    losses = run.losses()
    return RunTiming(
        log=scene.name,
        reason="",
        duration=run.duration(),
        speed=run.speeds(),
        stops=run.stops,
        lost=tuple(losses[:_MOST]),
        stretches=len(losses),
    )


def _untimed(scene: Scene, why: str) -> RunTiming:
    """What is said of a log that can't be laid along its program."""
    return RunTiming(log=scene.name, reason=why, duration=None, speed=None, stops=(), lost=(), stretches=0)


@dataclass(frozen=True)
class _Run:
    """One log along its program: places in motions done, as in `Timetable`."""

    track: ProgramTrack
    table: Timetable

    @cached_property
    def _raw(self) -> Array:
        row, share = self.track.places(self.track.path(0.0))
        return np.asarray(np.searchsorted(self.table.row, row) + share)

    @cached_property
    def u(self) -> Array:
        """(N,) places, none before the one of the sample before."""
        return np.asarray(isotonic_regression(self._raw).x)

    @property
    def in_order(self) -> bool:
        """True where the samples follow the program."""
        return float(np.mean(np.abs(self._raw - self.u) > _STEP_BACK)) <= _DISORDER

    @cached_property
    def rests(self) -> tuple[Rest, ...]:
        """Where all set-points rest."""
        return rests_of(self.track.scene)

    @cached_property
    def begin(self) -> int:
        """The sample at which motion begins."""
        first = self.rests[0] if self.rests else None
        return first.last if first is not None and first.first == 0 else 0

    @cached_property
    def end(self) -> int:
        """The sample at which it ends."""
        final = self.rests[-1] if self.rests else None
        return final.first if final is not None and final.last == len(self.u) - 1 else len(self.u) - 1

    @cached_property
    def within(self) -> tuple[Rest, ...]:
        """Rests between beginning and end."""
        return tuple(r for r in self.rests if r.first > self.begin and r.last < self.end)

    @cached_property
    def edges(self) -> Array:
        """(E,) places between which time is taken: where the log begins, the ends of motions, where it ends."""
        a, b = float(self.u[self.begin]), float(self.u[self.end])
        return np.unique(np.concatenate([[a], np.arange(np.ceil(a), np.floor(b) + 1.0), [b]]).clip(a, b))

    @cached_property
    def logged(self) -> Array:
        """(E,) s at which the log first is at the edges."""
        t, u = self.track.scene.t[self.begin : self.end + 1], self.u[self.begin : self.end + 1]
        after = np.clip(np.searchsorted(u, self.edges[1:], side="left"), 1, len(u) - 1)
        rise = np.maximum(u[after] - u[after - 1], 1e-12)
        share = np.clip((self.edges[1:] - u[after - 1]) / rise, 0.0, 1.0)
        reached = t[after - 1] + share * (t[after] - t[after - 1])
        reached[-1] = t[-1]
        return np.concatenate([t[:1], reached])

    def _by_table(self, at_nodes: Array) -> Array:
        """(E,) what the timetable has at the edges, of values (K,) at its nodes."""
        return np.asarray(np.interp(self.edges, self.table.place, at_nodes))

    @cached_property
    def predicted(self) -> Array:
        """(E,) s at which the virtual controller is there; a wait before the first motion is over, as it is in the log."""
        out = self._by_table(self.table.arrive)
        out[0] = np.interp(self.edges[0], self.table.place, self.table.leave)
        return out

    @cached_property
    def at_feed(self) -> Array:
        """(E,) s at which it would be there at the programmed speed throughout."""
        return self._by_table(np.concatenate([[0.0], np.cumsum(self.table.feed)]))

    def line(self, edge: int) -> int:
        """The program line of the motion between an edge and the next."""
        motion = min(int(np.floor(self.edges[edge] + 1e-9)), len(self.table.row) - 1)
        return int(self.track.program.line[self.table.row[motion]])

    def duration(self) -> RunDuration:
        """Of the run as logged, by the virtual controller, and at the programmed speed throughout, s."""
        logged, predicted = (float(np.ptp(x)) for x in (self.logged, self.predicted))
        paused = _paused(self.stops)
        return RunDuration(
            logged_s=logged,
            predicted_s=predicted,
            difference_s=logged - predicted,
            difference_percent=100.0 * (logged - predicted) / predicted if predicted > 0.0 else None,
            at_programmed_speed_s=float(np.ptp(self.at_feed)),
            lost_s=logged - float(np.ptp(self.at_feed)),
            paused_s=paused,
            from_line=self.line(0),
            to_line=self.line(len(self.edges) - 2),
        )

    @cached_property
    def _rates(self) -> tuple[Array, Array, Array, Array]:
        """Between samples of the run: seconds, the tool's speed, the programmed one (0 for none), the virtual controller's."""
        rows = slice(self.begin, self.end + 1)
        t, u = self.track.scene.t[rows], self.u[rows]
        path = self.track.path(0.0)
        seconds = np.diff(t)
        speed = np.linalg.norm(np.diff(self.track.led(path)[rows], axis=0), axis=1) / seconds
        middle = 0.5 * (u[1:] + u[:-1])
        motion = self.table.row[np.minimum(middle.astype(np.int64), len(self.table.row) - 1)]
        programmed = np.nan_to_num(np.asarray(self.track.program.speed)[motion])
        step = np.clip(np.searchsorted(self.table.place, middle) - 1, 0, len(self.table.feed) - 1)
        taken = np.maximum((self.table.arrive[1:] - self.table.leave[:-1])[step], 1e-9)
        return seconds, speed, programmed, np.diff(self.table.way)[step] / taken

    def speeds(self) -> RunSpeed | None:
        """The tool's speed in CP motion, at rest left out; None without any."""
        seconds, speed, programmed, model = self._rates
        used = (programmed > 0.0) & (speed > _MOVES * programmed)
        if not used.any():
            return None
        seconds, speed, programmed, model = (x[used] for x in (seconds, speed, programmed, model))
        share = speed / programmed
        bins = np.bincount((share / _BIN).astype(np.int64).clip(0, 1000), weights=seconds, minlength=1001)
        held = np.convolve(bins, np.ones(3), mode="same") / seconds.sum()
        most = int(np.argmax(held))
        at = float(seconds[np.abs(share - 1.0) <= _NEAR].sum() / seconds.sum())
        return RunSpeed(
            programmed_mm_s=_spread(programmed, seconds),
            logged_mm_s=_spread(speed, seconds),
            predicted_mm_s=_spread(model, seconds),
            at_programmed_percent=100.0 * at,
            matches=at >= _STEADY,
            steady_percent=100.0 * _BIN * (most + 0.5) if held[most] >= _STEADY else None,
        )

    @cached_property
    def stops(self) -> tuple[RestSaid, ...]:
        """Rests between beginning and end: pauses, where the program asks for none or a shorter one."""
        out = []
        waits = self.table.leave - self.table.arrive
        for rest in self.within:
            near = np.abs(self.table.place - self.u[rest.first]) < 0.5
            asked = float(waits[near].sum())
            edge = int(np.clip(np.searchsorted(self.edges, self.u[rest.first] - 1e-6, side="right") - 1, 0, None))
            pause = rest.seconds > asked + max(0.5 * asked, rest.grain)
            out.append(
                RestSaid(
                    t_s=float(self.track.scene.t[rest.first]),
                    line=self.line(min(edge, len(self.edges) - 2)),
                    seconds=rest.seconds,
                    programmed_s=asked,
                    what=_PAUSE if pause else "as programmed",
                )
            )
        return tuple(out)

    def losses(self) -> list[LostTime]:
        """The stretches of the program where time is lost against the programmed speed, the worst first."""
        took, feed = np.diff(self.logged), np.diff(self.at_feed)
        slow = np.flatnonzero((took > _SLOW * feed) & (took - feed > 1e-6))
        if not len(slow):
            return []
        parts = np.split(slow, np.flatnonzero(np.diff(slow) > _JOINED + 1) + 1)
        found = [self._loss(int(p[0]), int(p[-1]) + 1) for p in parts]
        return sorted((f for f in found if f.lost_s > _LEAST_LOSS), key=lambda f: -f.lost_s)

    def _loss(self, a: int, b: int) -> LostTime:
        """What is lost between two edges, and what holds the tool back there."""
        logged, predicted, feed = (float(x[b] - x[a]) for x in (self.logged, self.predicted, self.at_feed))
        inside = (self.table.place[:-1] >= self.edges[a]) & (self.table.place[1:] <= self.edges[b])
        steps = np.flatnonzero(inside)
        lost = np.maximum((self.table.arrive[1:] - self.table.leave[:-1])[steps] - self.table.feed[steps], 0.0)
        by_cause = np.bincount(self.table.cause[steps], weights=lost, minlength=len(self.table.causes))
        limit = self.table.causes[int(np.argmax(by_cause))] if by_cause.max() > 0.1 * (logged - feed) else ""
        begin, end = self.logged[a] - 1e-9, self.logged[b] + 1e-9
        return LostTime(
            from_line=self.line(a),
            to_line=self.line(b - 1),
            lost_s=logged - feed,
            logged_s=logged,
            predicted_s=predicted,
            at_programmed_speed_s=feed,
            limit=limit,
            paused_s=_paused(s for s in self.stops if begin <= s.t_s <= end),
            steady=self._steady(begin, end),
        )

    def _steady(self, begin: float, end: float) -> SteadySpeed | None:
        """What runs at one speed for most of a stretch: an axis at its highest of all the log, or the tool; None for nothing."""
        scene = self.track.scene
        rows = np.flatnonzero((scene.t >= begin) & (scene.t <= end))[:-1]
        if len(rows) < 8:
            return None
        rate = np.abs(np.diff(scene.command, axis=0) / np.diff(scene.t)[:, None])
        top = np.quantile(rate, 0.995, axis=0)
        flat = np.mean(rate[rows] > (1.0 - _TOP) * top, axis=0) * (top > 1e-6)
        k = int(np.argmax(flat))
        if flat[k] >= _STEADY:
            axis = scene.cell.index(scene.axes[k])
            prismatic, limit = scene.cell.joints[axis].prismatic, float(scene.cell.limits_of("speed")[axis])
            return SteadySpeed(
                what=scene.axes[k],
                unit="mm/s" if prismatic else "deg/s",
                share=float(flat[k]),
                speed=m_to_mm(float(top[k])) if prismatic else rad_to_deg(float(top[k])),
                percent=100.0 * float(top[k]) / limit if 0.0 < limit < np.inf else None,
                of="its limit in the cell",
            )
        here = rows - self.begin
        _, speed, programmed, _ = (x[here[(here >= 0) & (here < self.end - self.begin)]] for x in self._rates)
        usual = float(np.median(speed)) if len(speed) else 0.0
        share = float(np.mean(np.abs(speed - usual) <= _FLAT * usual)) if usual > 0.0 else 0.0
        if share < _STEADY or np.median(programmed) <= 0.0:
            return None
        return SteadySpeed(
            what="tool",
            unit="mm/s",
            share=share,
            speed=m_to_mm(usual),
            percent=100.0 * usual / float(np.median(programmed)),
            of="the programmed speed",
        )


def _paused(stops: Iterable[RestSaid]) -> float:
    """s that pauses among some rests take beyond what is programmed."""
    return sum(s.seconds - s.programmed_s for s in stops if s.what == _PAUSE)


def _spread(speed: Array, seconds: Array) -> SpeedSpread:
    """Median, 5 % and 95 % over time, mm/s."""
    order = np.argsort(speed)
    passed = (np.cumsum(seconds[order]) - 0.5 * seconds[order]) / seconds.sum()
    at = np.interp([0.05, 0.5, 0.95], passed, speed[order])
    return SpeedSpread(**dict(zip(("p5", "median", "p95"), m_to_mm(at).tolist(), strict=True)))
