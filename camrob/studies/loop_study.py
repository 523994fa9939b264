"""The study of the tracker loop: the paper's two tests in simulation, and what does better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.loop.analysis import Margins
from camrob.loop.case import RobotErrors, TrackerCase, TrackerNoise
from camrob.loop.gain import (
    GainChoice,
    GainNeed,
    check_gain,
    choose_gain,
    gain_needs,
    joint_loops,
    worst_margins,
)
from camrob.loop.identified_joints import JointLags, ahead_of, identify_lags
from camrob.loop.law import CorrectionLaw
from camrob.loop.learning import best_lead, learned_after
from camrob.loop.loop import LoopLog, LoopRun, check_arm_alone, simulate
from camrob.loop.measures import RunMeasure, measure_run
from camrob.loop.paths import TestPath, circle_path, square_path
from camrob.loop.tracker_error import printed_order, reading_of, tracker_pose
from camrob.progress import Progress, silent
from camrob.se3 import frame_from_xyzabc, inverse

__all__ = ["Latency", "Learning", "Sensitivity", "TrackerStudy", "Variant", "study_tracker"]

Array = NDArray[np.float64]

SETTLED = 3.0  # s after the correction is switched on, from which its effect is measured
SMOOTHING, STEP = 0.05, 0.7  # of what is learned: its width, s, and what share of a lap's findings is taken over
LATENCIES = (0, 1, 2, 5, 10, 25, 50)  # cycles, shown beside the case's own
NEED_LATENCIES, NOISES = (0, 1, 5, 10, 25), (1.0, 4.0, 16.0, 64.0)  # cycles; times the tracker's noise
_MOST_LAPS = 20
_TRIED = (0.005, 0.02, 0.06)  # gains that are simulated beside the expected curve


@dataclass(frozen=True, slots=True)
class Variant:
    """One way to run the two tests, corrected from the start: `key` for programs, `name` for people."""

    key: str
    name: str
    square: LoopLog
    circle: LoopLog
    of_square: RunMeasure
    of_circle: RunMeasure


@dataclass(frozen=True, slots=True)
class Learning:
    """Lap after lap: `lead`, cycles; `factor`, the worst by which a lap multiplies an error; measures (lap, test) of the laps."""

    name: str
    lead: int
    factor: float
    laps: tuple[tuple[RunMeasure, RunMeasure], ...]


@dataclass(frozen=True, slots=True)
class Latency:
    """The joints' loops when the measurement is `cycles` old: the gain's limit, and the margins of two gains (None: unstable)."""

    cycles: int
    limit: float
    published: Margins | None
    chosen: Margins | None


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """What one assumption does: measures of the circle without and with the published correction."""

    name: str
    before: RunMeasure
    after: RunMeasure


@dataclass(frozen=True, slots=True)
class TrackerStudy:
    """All that the report shows. before, switched: the square without, and with the correction switched on under way, measured
    over the same time. tried: gains simulated on the circle, with the tool's rms error, m. order_off: by how far
    eq. 2 as printed misses the tool, m, mean over the square. eq1_off: how far eq. 1 is from the pose it was given, at most.
    """

    case: TrackerCase
    paths: tuple[TestPath, TestPath]
    before: RunMeasure
    switched: LoopLog
    of_switched: RunMeasure
    variants: tuple[Variant, ...]
    lags: JointLags
    choice: GainChoice
    tried: tuple[tuple[float, float], ...]
    needs: tuple[GainNeed, ...]
    latencies: tuple[Latency, ...]
    learning: tuple[Learning, ...]
    sensitivity: tuple[Sensitivity, ...]
    order_off: float
    eq1_off: float

    def variant(self, key: str) -> Variant:
        """One of the variants. Raises KeyError."""
        for variant in self.variants:
            if variant.key == key:
                return variant
        raise KeyError(key)


def study_tracker(
    cell: Cell, case: TrackerCase, *, laps: int = 3, gain: float | None = None, progress: Progress | None = None
) -> TrackerStudy:
    """Run the study; `gain`: one more to run. About a minute.

    Raises InputError for a number of laps that makes no sense, CellError for a cell that has more than an arm, JobError for a
    gain that makes the loop unstable, and what the paths raise.
    """
    if not 0 <= laps <= _MOST_LAPS:
        raise InputError(f"{laps} laps can't be learned from", hint=f"give 0 to {_MOST_LAPS}")
    check_arm_alone(cell)
    asked = None if gain is None else replace(case.law, gain=gain)
    for law in (case.law, asked):
        if law is not None:
            check_gain(joint_loops(case, np.asarray(case.robot.lag)), law.gain)
    tell = progress or silent
    square, circle = square_path(cell, case), circle_path(cell, case)
    if case.switched_on + SETTLED >= float(square.time[square.corners[-1]]):
        raise InputError(
            "the correction is switched on after the square's end", hint="correct square.on_s in tracker.toml"
        )
    tell("the tests as published", 0.02)
    begin = round(case.switched_on / case.law.cycle_s)
    plain, law = _run(case, square), case.law
    logs = simulate(
        cell, case,
        [plain, _run(case, circle), replace(plain, law=law, begin=begin), replace(plain, law=law), _run(case, circle, law=law)],
    )  # fmt: skip
    from_on = case.switched_on + SETTLED
    tell("gain by analysis", 0.25)
    lags = identify_lags(cell, case, logs[:2])
    choice = choose_gain(cell, case, logs[:2], lags)
    noises = [case.noise.position * factor for factor in NOISES]
    needs = gain_needs(cell, case, [logs[1]], lags, NEED_LATENCIES, noises)
    none = _variant("none", "no correction", logs[0], logs[1])
    published = _variant("published", f"published law, K = {law.gain:g}", logs[3], logs[4])
    tell("better variants", 0.3)
    better, tried = _better(cell, case, (square, circle), lags, choice, asked)
    tell("learning", 0.5)
    learning, learned = _learn(cell, case, lags, (published, better[-1]), laps)
    tell("what the assumptions do", 0.85)
    order_off, eq1_off = _equations(case, square)
    return TrackerStudy(
        case=case, paths=(square, circle), before=measure_run(logs[0], from_on), switched=logs[2],
        of_switched=measure_run(logs[2], from_on), variants=(none, published, *better, *learned), lags=lags, choice=choice,
        tried=tried,
        needs=needs, latencies=_latencies(case, lags, choice.chosen), learning=learning,
        sensitivity=_sensitivity(cell, case, circle), order_off=order_off, eq1_off=eq1_off,
    )  # fmt: skip


def _run(case: TrackerCase, path: TestPath, **more: object) -> LoopRun:
    return replace(LoopRun(path, case.robot, case.noise, case.latency), **more)  # type: ignore[arg-type]


def _variant(key: str, name: str, square: LoopLog, circle: LoopLog) -> Variant:
    return Variant(key, name, square, circle, measure_run(square, 0.0), measure_run(circle, 0.0))


def _better(
    cell: Cell,
    case: TrackerCase,
    paths: tuple[TestPath, TestPath],
    lags: JointLags,
    choice: GainChoice,
    asked: CorrectionLaw | None,
) -> tuple[list[Variant], tuple[tuple[float, float], ...]]:
    """Variants that need what the first runs showed, the last one with all of it; and the gains that are tried on the circle."""
    law = replace(case.law, gain=choice.chosen)
    ways: list[tuple[str, str, dict[str, object]]] = [
        ("gain", f"gain by analysis, K = {law.gain:g}", {"law": law}),
        ("aligned", "and set-point of the measured instant", {"law": law, "aligned": True}),
        ("averaged", "and mean of the samples of a cycle", {"law": law, "aligned": True, "averaged": True}),
    ]
    if asked is not None:
        ways.insert(0, ("asked", f"gain asked for, K = {asked.gain:g}", {"law": asked}))
    runs = [_run(case, path, **how) for _key, _name, how in ways for path in paths]
    for path in paths:
        runs.append(_run(case, path, law=law, aligned=True, averaged=True, ahead=ahead_of(case, path, lags)))
    runs += [_run(case, paths[1], law=replace(case.law, gain=g)) for g in _TRIED]
    logs = simulate(cell, case, runs)
    ways.append(("ahead", "and joints sent ahead of their lag and lost motion", {}))
    variants = [_variant(key, name, logs[2 * k], logs[2 * k + 1]) for k, (key, name, _how) in enumerate(ways)]
    rest = logs[2 * len(ways) :]
    return variants, tuple((g, measure_run(log, 0.0).tool.rms) for g, log in zip(_TRIED, rest, strict=True))


def _learn(
    cell: Cell, case: TrackerCase, lags: JointLags, starts: Sequence[Variant], laps: int
) -> tuple[tuple[Learning, ...], list[Variant]]:
    """Laps after those of some variants, all side by side; and what their last laps are as variants."""
    plans = []
    for start in starts:
        law = start.square.run.law or case.law
        loops = [loop for loop, moved in zip(joint_loops(case, lags.lag(case)), lags.moved, strict=True) if moved]
        plans.append(best_lead(loops, law.gain, SMOOTHING, STEP))
    logs = [log for start in starts for log in (start.square, start.circle)]
    measures = [[(start.of_square, start.of_circle)] for start in starts]
    for lap in range(1, laps + 1):
        runs = []
        for k, log in enumerate(logs):
            learned = learned_after(log, plans[k // 2][0], SMOOTHING, STEP)
            runs.append(replace(log.run, learned=learned, noise_seed=1 + lap))
        logs = simulate(cell, case, runs)
        for k in range(len(starts)):
            measures[k].append((measure_run(logs[2 * k], 0.0), measure_run(logs[2 * k + 1], 0.0)))
    names = ("published law", "with all of the above")
    learning = tuple(
        Learning(name, *plan, tuple(found)) for name, plan, found in zip(names, plans, measures, strict=True)
    )
    if laps == 0:
        return learning, []
    return learning, [
        _variant(f"learned_{start.key}", f"learning, {laps} laps, {name}", logs[2 * k], logs[2 * k + 1])
        for k, (start, name) in enumerate(zip(starts, names, strict=True))
    ]


def _latencies(case: TrackerCase, lags: JointLags, chosen: float) -> tuple[Latency, ...]:
    out = []
    for cycles in sorted({*LATENCIES, case.latency}):
        loops = joint_loops(case, lags.lag(case), cycles)
        limit = min(loop.limit() for loop in loops)
        both = [worst_margins(loops, g) if g < limit else None for g in (case.law.gain, chosen)]
        out.append(Latency(cycles, limit, both[0], both[1]))
    return tuple(out)


def _equations(case: TrackerCase, path: TestPath) -> tuple[float, float]:
    """How far eq. 2 as printed misses, m, and eq. 1 after a way there and back."""
    base_T_tcp = frame_from_xyzabc(np.asarray(path.wanted)[::100])
    base_T_tracker = np.asarray(case.base_T_tracker)
    tracker_T_tcp = inverse(base_T_tracker) @ base_T_tcp
    off = printed_order(base_T_tracker, tracker_T_tcp)[:, :3, 3] - base_T_tcp[:, :3, 3]
    again = tracker_pose(reading_of(tracker_T_tcp))
    return float(np.linalg.norm(off, axis=1).mean()), float(np.abs(again - tracker_T_tcp).max())


def _sensitivity(cell: Cell, case: TrackerCase, path: TestPath) -> tuple[Sensitivity, ...]:
    """The circle under other assumptions, one at a time."""
    r, noise = case.robot, case.noise
    cases: list[tuple[str, RobotErrors, TrackerNoise, int]] = [
        ("as assumed", r, noise, case.latency),
        ("joint lags halved", replace(r, lag=0.5 * r.lag), noise, case.latency),
        ("joint lags half as large again", replace(r, lag=1.5 * r.lag), noise, case.latency),
        ("all joints equally late", replace(r, lag=np.full(6, float(np.mean(r.lag[:3])))), noise, case.latency),
        ("no friction, no lost motion", replace(r, lost=0.0 * r.lost, friction=0.0 * r.friction), noise, case.latency),
        (
            "three times of both",
            replace(r, lost=3.0 * r.lost, friction=3.0 * r.friction, sliding=3.0 * r.sliding),
            noise,
            case.latency,
        ),
        ("no link errors", replace(r, link=0.0, link_angle=0.0), noise, case.latency),
        ("link errors doubled", replace(r, link=2.0 * r.link, link_angle=2.0 * r.link_angle), noise, case.latency),
        ("other link errors drawn", replace(r, seed=r.seed + 1), noise, case.latency),
        ("others again", replace(r, seed=r.seed + 2), noise, case.latency),
        ("no static error at the start", replace(r, static=0.0 * r.static), noise, case.latency),
        ("no noise of the tracker", r, replace(noise, position=0.0, angle=0.0), case.latency),
        ("four times the noise", r, replace(noise, position=4 * noise.position, angle=4 * noise.angle), case.latency),
        ("measurement not late", r, noise, 0),
        ("measurement 5 cycles late", r, noise, 5),
    ]
    runs = [LoopRun(path, e, n, late, law=law) for _name, e, n, late in cases for law in (None, case.law)]
    logs = simulate(cell, case, runs)
    return tuple(
        Sensitivity(name, measure_run(logs[2 * k], 0.0), measure_run(logs[2 * k + 1], 0.0))
        for k, (name, *_rest) in enumerate(cases)
    )
