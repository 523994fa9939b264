"""How soon the RSI loop finds out that it is closed the wrong way round, and how often it says so of a sound one.

Run: OMP_NUM_THREADS=1 python tests/bench/rsi_response.py      (some minutes)

Sound: the study's robot of cells/rx160_tracker (link errors, lags, friction, noise) on square and circle, at the paper's feed and
well above it, at gains up to what is stable. Wrong: its errors without correction, and a correction that reaches the tool through
another frame, with 5 cycles of delay and 75 ms of lag. Nothing here is random from run to run.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.loop.case import read_tracker_case  # noqa: E402
from camrob.loop.loop import LoopRun, simulate  # noqa: E402
from camrob.loop.paths import circle_path, square_path  # noqa: E402
from camrob.loop.rsi.plausible_pose import JumpBound  # noqa: E402
from camrob.loop.rsi.response import ResponseWatch  # noqa: E402
from camrob.loop.rsi.setpoints import SetpointHistory  # noqa: E402
from camrob.se3 import frame_from_xyzabc, rotation_exp  # noqa: E402

FOLDER = ROOT / "cells" / "rx160_tracker"
CELL, CASE = read_cell(FOLDER), replace(read_tracker_case(FOLDER), rest=1.0)
FEEDS = ((700, 0.1), (700, 2.0), (3000, 0.5), (6000, 1.0))  # mm/min, m/s^2
GAINS = (0.005, 0.01, 0.031, 0.06, 0.12, 0.2)  # 0.257 is where the loop becomes unstable
JUMP, JUMP_ANGLE = 5e-4, np.radians(0.1)
FRAMES = {
    "sound": np.eye(3),
    "all signs": -np.eye(3),
    "half a turn about X": rotation_exp(np.array([np.pi, 0, 0])),
    "120 degrees about Z": rotation_exp(np.array([0, 0, np.radians(120)])),
    "sign of X": np.diag([-1.0, 1.0, 1.0]),
    "not applied": np.zeros((3, 3)),
}


def alarms(log) -> tuple[int, str]:
    """Measurements of a run that would be taken for jumps, and the first thing said of its response."""
    law, wanted = log.run.law, np.asarray(log.run.path.wanted)
    watch, history, bound = ResponseWatch(law.gain, law.cycle_s), SetpointHistory(), JumpBound(JUMP, JUMP_ANGLE)
    jumps, said = 0, ""
    for k, seen in enumerate(log.seen):
        at_s, total = k * law.cycle_s, log.correction[k - 1] if k else np.zeros(6)
        history.add(at_s, wanted[k], total)
        pose = frame_from_xyzabc(wanted[k] - seen)
        if bound.too_far(at_s, pose, history):
            jumps += 1
        else:
            bound.believe(at_s, pose)
        said = said or watch.add(at_s, seen, total, wanted[k], history.programmed)
    return jumps, said


def sound() -> None:
    """Every run, and how many raised an alarm."""
    runs, raised, cycles = 0, 0, 0
    for feed, acceleration in FEEDS:
        case = replace(CASE, feed=feed / 60000, acceleration=acceleration)
        paths = square_path(CELL, case), circle_path(CELL, case)
        plans = []
        for gain in GAINS:
            law = replace(case.law, gain=gain, limit_m=0.02, limit_rad=0.05)
            for one in (law, replace(law, step_m=1.0, step_rad=1.0)):
                plans += [LoopRun(path, case.robot, case.noise, case.latency, law=one) for path in paths]
        for log in simulate(CELL, case, plans):
            jumps, said = alarms(log)
            runs, raised, cycles = runs + 1, raised + bool(jumps or said), cycles + len(log.seen)
            if jumps or said:
                law = log.run.law
                print(
                    f"ALARM {feed} mm/min, {log.run.path.name}, gain {law.gain}, step {law.step_m} m: {jumps} jumps; {said}"
                )
    print(f"{runs} sound runs, {cycles} cycles: {raised} with an alarm")


def wrong() -> None:
    """When and at what correction each wrong frame ends, at the published gain and limits of 3 mm and 0.5 degrees."""
    path = circle_path(CELL, CASE)
    alone = simulate(CELL, CASE, [LoopRun(path, CASE.robot, CASE.noise, CASE.latency)])[0].seen
    law = replace(CASE.law, limit_m=3e-3, limit_rad=np.radians(0.5), step_m=2e-5, step_rad=np.radians(0.005))
    for begin, where in ((0, "at rest"), (len(alone) // 3, "under way")):
        for name, frame in FRAMES.items():
            print(f"{where:9}, {name:22}", fate(law, frame, alone[begin:], np.asarray(path.wanted)[begin:]))


def fate(law, frame, alone, wanted) -> str:
    """What becomes of a loop whose correction reaches the tool through `frame`."""
    watch, history = ResponseWatch(law.gain, law.cycle_s), SetpointHistory()
    total, reached, waiting, at_limit = np.zeros(6), np.zeros(6), [np.zeros(6)] * 5, 0
    for k, error_alone in enumerate(alone):
        at_s = k * law.cycle_s
        history.add(at_s, wanted[k], total)
        error = error_alone - np.concatenate([frame @ reached[:3], (frame @ reached[:2:-1])[::-1]])
        said = watch.add(at_s, error, total, wanted[k], history.programmed)
        size = f"error {1e3 * np.linalg.norm(error[:3]):.2f} mm, correction {1e3 * np.linalg.norm(total[:3]):.2f} mm"
        if said:
            return f"response after {at_s:.2f} s: {size}"
        total = np.clip(total + np.clip(law.gain * error, -law.step_limit, law.step_limit), -law.limit, law.limit)
        at_limit = at_limit + 1 if (np.abs(total) / law.limit).max() >= 0.99 else 0
        if at_limit > 250:
            return f"saturated after {at_s:.2f} s: {size}"
        waiting.append(total)
        reached = reached - np.expm1(-law.cycle_s / 0.075) * (waiting.pop(0) - reached)
    return f"runs to its end: {size}"


if __name__ == "__main__":
    wrong()
    sound()
