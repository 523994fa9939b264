"""Planning beside toppra on one path, and the cost over the number of points: python tests/bench/bench_feed.py [points]."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from feed_paths import CELL, path_of, wave

from camrob.dynamics.motion_torques import motion_torques
from camrob.timing.as_it_stands import program_as_it_stands
from camrob.timing.optimal import optimal_feed
from camrob.timing.path_spline import MotionBounds, interpolated, speed_caps
from camrob.timing.reachability import fastest_squares
from camrob.timing.timing import program_time


def beside_toppra(count: int) -> None:
    """Speed and acceleration bounds only, one spline, the same grid."""
    import toppra

    toppra.setup_logging("ERROR")
    s = np.linspace(0.0, 1.0, count + 1)
    q = np.column_stack([0.5 * np.sin((3 + k) * s + k) + 0.2 * np.cos(7 * s * (k + 1)) for k in range(6)])
    bounds = MotionBounds(np.inf, np.inf, np.inf, np.full(6, 1.0), np.full(6, 2.0), np.full(6, np.inf))
    for _again in range(2):  # the first round compiles
        start = time.perf_counter()
        control = interpolated(np.hstack([np.zeros((count + 1, 6)), q]), 1.0 / count)
        caps = speed_caps(control, 1.0 / count, np.full(count, 10.0), bounds)
        v = np.sqrt(fastest_squares(control, 1.0 / count, caps, bounds, 0.0, 0.0))
        ours, seconds = float(np.sum(2.0 / count / (v[1:] + v[:-1]))), time.perf_counter() - start
    start = time.perf_counter()
    limits = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-bounds.speed, bounds.speed])),
        toppra.constraint.JointAccelerationConstraint(np.column_stack([-bounds.acceleration, bounds.acceleration])),
    ]
    path = toppra.SplineInterpolator(s, q)
    instance = toppra.algorithm.TOPPRA(limits, path, gridpoints=s, parametrizer="ParametrizeConstAccel")
    theirs = float(instance.compute_trajectory(0, 0).duration)
    print(
        f"{count:7d} points  camrob {ours:.4f} s in {1e3 * seconds:.1f} ms   "
        f"toppra {theirs:.4f} s in {1e3 * (time.perf_counter() - start):.1f} ms"
    )


def whole(count: int) -> None:
    """The KR15 cell's winding path: time as it stands, and planned with jerk."""
    path, q = path_of(wave(count, turns=count / 2500.0), feed=0.5)
    speed = np.full(count, 0.5)
    optimal_feed(CELL, *path_of(wave(200, turns=0.2), feed=0.5), rapid_speed=0.2)
    program_time(CELL, path, q, speed=speed)
    times = [time.process_time()]
    program = program_time(CELL, path, q, speed=speed)
    times.append(time.process_time())
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    times.append(time.process_time())
    stands = program_as_it_stands(CELL, path, q, program, speed=speed)
    times.append(time.process_time())
    motion_torques(CELL, q, stands.speed, stands.acceleration)
    times.append(time.process_time())
    timed, planned, judged, loaded = np.diff(times)
    print(
        f"{count:7d} points over {path.length[-1]:.1f} m, seconds of processor: as it stands {program.total:.3f} s timed in "
        f"{timed:.3f}, {stands.worst[2].times:.1f} times the jerk found in {judged:.2f}, {stands.total:.3f} s slowed evenly; "
        f"planned {plan.total:.3f} s in {planned:.2f}, uses {max(plan.use.values()):.6f}; torques in {loaded:.2f}"
    )


if __name__ == "__main__":
    beside_toppra(1000)
    beside_toppra(20000)
    most = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    for points in (most // 4, most):
        whole(points)
