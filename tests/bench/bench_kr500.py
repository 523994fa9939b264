"""The published calibration and compensation of a KR 500 beside ours: `python tests/bench/bench_kr500.py`.

A report in plain text: errors before and after calibration, the extended model, the compensated tape line, the derivative
analysis of the paper's section III, and how fast compensation is.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from kr500_case import CELL, PUBLISHED, calibrated, means, slowest, tape_line, truth

from camrob.calibrate.compensate import compensate_postures
from camrob.kinematics.frames import base_T_tool


def row(name: str, published: str, ours: str) -> None:
    print(f"| {name:<52} | {published:<20} | {ours:<34} |")


def pair(mean: tuple[float, float]) -> str:
    return f"{mean[0]:.3f} mm, {mean[1]:.4f} deg"


def mm_deg(errors: np.ndarray) -> str:
    return f"{1e3 * errors[:, 0].mean():.4f} mm, {np.rad2deg(errors[:, 1].mean()):.4f} deg"


def main() -> None:
    errors = truth()
    plain, extended = calibrated(errors, 0), calibrated(errors, 2)
    line = tape_line(errors, plain, extended)
    row("", "published", "ours (withheld poses, simulated)")
    row("-" * 52, "-" * 20, "-" * 34)
    before, after, further = means(plain, "nominal"), means(plain, "calibrated"), means(extended, "calibrated")
    row("mean error before", pair(PUBLISHED["before"]), pair(before))
    row("mean error, base and tool fitted alone", "-", pair(means(plain, "frames")))
    row("mean error, 30 geometric and 5 stiffness", pair(PUBLISHED["after"]), pair(after))
    row("mean error, gear ripple too (the declared rest)", "-", pair(further))
    row("tape line of 297 points, uncompensated", "-", mm_deg(line.before))
    row("tape line, compensated", "-", mm_deg(line.after))
    row("tape line, compensated with the extended model", "-", mm_deg(line.extended))
    row("iterations as published (delta 1e-8, eps 1e-15)", "3-5", "{}-{}".format(*line.published_iterations))
    row("iterations, analytic Jacobian, to 1e-11 m", "-", f"at most {line.iterations}")
    row("largest difference between the two, rad", "-", f"{line.largest_difference:.1e}")
    for k, name in enumerate(("speed", "acceleration", "jerk")):
        rates = [slowest(analysis)[k] for analysis in line.analysis]
        row(f"least ds/dt that {name} limits allow, rad/s", "no violation", f"{rates[0]:.4f}, then {rates[1]:.4f}")
    q = np.tile(line.planned, (337, 1))[:100_000]
    targets = base_T_tool(CELL, q)
    model, values = plain.model(CELL)
    start = time.perf_counter()
    compensate_postures(model, values, q, targets)
    row("compensation of 100 000 points", "-", f"{time.perf_counter() - start:.1f} s")
    print()
    print(
        f"{len(plain.parameters)} parameters fitted, {len(plain.held)} held: " + ", ".join(h.name for h in plain.held)
    )
    print(f"condition {plain.condition:.0f}, O1 to O5: " + ", ".join(f"{o:.3g}" for o in plain.observability))
    for warning in plain.warnings:
        print(warning)


if __name__ == "__main__":
    main()
