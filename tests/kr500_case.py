"""The published calibration of a KR 500 with a tape-laying head, in simulation: a drawn robot, a tracker, a tape's line.

Published: 2.04 mm and 0.147 degrees mean error before, 0.58 mm and 0.095 degrees after fitting 30 geometric and 5 stiffness
parameters. The simulated robot has errors of these 35 kinds and a declared part outside of them, gear ripple of the first
two orders, sized so that the same means come out; the extended model knows ripple too.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camrob.calibrate.calibrate import calibrate_cell
from camrob.calibrate.calibration import Calibration
from camrob.calibrate.compensate import compensate_postures, pose_difference
from camrob.calibrate.error_model import ErrorModel
from camrob.calibrate.measurements import Measurements
from camrob.calibrate.paper_newton import compensate_as_published
from camrob.calibrate.terms import standard_names
from camrob.cell.read_cell import read_cell
from camrob.feed.derivative_analysis import DerivativeAnalysis, analyse_derivatives
from camrob.kinematics.arm import FOLLOWED, Arm
from camrob.kinematics.frames import base_T_tool
from camrob.se3 import inverse, pose, rotation_exp

CELL = read_cell(Path(__file__).resolve().parents[1] / "cells" / "kr500_afp")
PUBLISHED = {"before": (2.040, 0.147), "after": (0.580, 0.095)}
FITTED, WITHHELD = 200, 300  # poses; 200 suffice, says the paper's reference [8]
SIGMA, SIGMA_ANGLE = 3e-5, 5e-5  # a tracker with an orientation target: m and rad an axis
# sizes of the drawn errors, found so that the means of poses that took no part are the published ones
PLACES, ANGLES, RIPPLE, LAST_RIPPLE = 4.5e-4, 1.44e-4, 5.92e-4, 1.773e-3
COMPLIANCE = {"A2": 0.2e-7, "A3": 0.3e-7, "A4": 2e-7, "A5": 1.5e-7, "A6": 4e-7}


def truth(places=PLACES, angles=ANGLES, ripple=RIPPLE, last=LAST_RIPPLE) -> dict[str, float]:
    """The simulated robot's errors, SI."""
    rng = np.random.default_rng(500)
    own = [n for n in standard_names(CELL) if n[:4] not in ("base", "tool")]
    errors = {}
    for name in own:
        axis, kind = name.split(".")
        drawn = float(rng.normal())
        if kind == "compliance":
            errors[name] = COMPLIANCE[axis] * (1.0 + 0.2 * drawn)
        else:
            errors[name] = drawn * (places if kind in ("x", "y") else angles)
    for name in standard_names(CELL, harmonics=2):
        if ".cos" in name or ".sin" in name:
            errors[name] = float(rng.normal()) * (last if name[1] == "6" else ripple)
    return errors


def postures(n: int, seed: int) -> np.ndarray:
    """Postures over the tape-laying volume."""
    rng = np.random.default_rng(seed)
    return CELL.to_q(rng.uniform([-70, -100, 50, -90, 20, -120], [70, -35, 130, 90, 90, 120], (n, 6)))


def measured(errors: dict[str, float], n: int, seed: int) -> Measurements:
    """What the tracker sees."""
    rng = np.random.default_rng(seed + 1000)
    q = postures(n, seed)
    frames = ErrorModel.of(CELL, tuple(errors)).poses(np.array(list(errors.values())), q)
    frames[:, :3, 3] += rng.normal(0.0, SIGMA, (n, 3))
    frames[:, :3, :3] = rotation_exp(rng.normal(0.0, SIGMA_ANGLE, (n, 3))) @ frames[:, :3, :3]
    return Measurements(q, frames, True, sigma_position=SIGMA, sigma_angle=SIGMA_ANGLE)


def calibrated(errors: dict[str, float], harmonics: int) -> Calibration:
    """The calibration of the published size, or the extended one."""
    return calibrate_cell(
        CELL,
        measured(errors, FITTED, 1),
        candidates=standard_names(CELL, harmonics=harmonics),
        withheld=measured(errors, WITHHELD, 2),
    )


@dataclass(frozen=True)
class Line:
    """The paper's use case: a straight line of 297 points 5 mm apart. Errors (N, 2): m and rad, of the simulated robot."""

    planned: np.ndarray
    before: np.ndarray
    after: np.ndarray
    extended: np.ndarray
    iterations: int
    published_iterations: tuple[int, int]
    largest_difference: float
    analysis: tuple[DerivativeAnalysis, DerivativeAnalysis]


def tape_line(errors: dict[str, float], plain: Calibration, extended: Calibration) -> Line:
    """Compensate the line with both calibrations and run it on the simulated robot."""
    near = CELL.to_q(np.array([0.0, -75.0, 100.0, 5.0, 55.0, -5.0]))
    direction = np.array([0.15, -1.0, 0.05]) / np.linalg.norm([0.15, -1.0, 0.05])
    middle = base_T_tool(CELL, near)
    places = middle[:3, 3] + 0.005 * np.arange(-148, 149)[:, None] * direction
    targets = pose(np.broadcast_to(middle[:3, :3], (297, 3, 3)), places)
    foot_T_tool = inverse(np.asarray(CELL.base_T_first)) @ targets
    arm = Arm.of(CELL)
    to_begin = arm.follow(foot_T_tool[148::-1], near, step=0.2)[0]
    planned, code, _ = arm.follow(foot_T_tool, to_begin[-1], step=0.2)
    if code != FOLLOWED:
        raise RuntimeError("the tape's line leaves the arm's reach")
    real, truth_values = ErrorModel.of(CELL, tuple(errors)), np.array(list(errors.values()))

    def error_of(q: np.ndarray) -> np.ndarray:
        e = pose_difference(targets, real.poses(truth_values, q))
        return np.stack([np.linalg.norm(e[:, :3], axis=1), np.linalg.norm(e[:, 3:], axis=1)], axis=1)

    model, values = plain.model(CELL)
    ours = compensate_postures(model, values, planned, targets)
    counts, difference = [], 0.0
    for row in range(0, 297, 8):
        theta, count = compensate_as_published(lambda a: model.poses(values, a[None])[0], targets[row], planned[row])
        counts.append(count)
        difference = max(difference, float(np.max(np.abs(theta - ours.q[row]))))
    further = compensate_postures(*extended.model(CELL), planned, targets)
    return Line(
        planned, error_of(planned), error_of(np.asarray(ours.q)), error_of(np.asarray(further.q)),
        int(np.max(ours.iterations)), (min(counts), max(counts)), difference,
        (analyse_derivatives(CELL, planned), analyse_derivatives(CELL, np.asarray(ours.q))),
    )  # fmt: skip


def slowest(analysis: DerivativeAnalysis) -> tuple[float, float, float]:
    """The least ds/dt that the axes' speeds, accelerations and jerks allow, rad/s."""
    rates = (analysis.rate_speed, analysis.rate_acceleration, analysis.rate_jerk)
    return float(rates[0].min()), float(rates[1].min()), float(rates[2].min())


def means(calibration: Calibration, stage: str) -> tuple[float, float]:
    """Mean errors, mm and degrees, of the withheld poses."""
    size = calibration.errors[f"{stage}/withheld"]
    return 1e3 * size.mean, float(np.rad2deg(size.mean_angle))


__all__ = ["PUBLISHED", "calibrated", "means", "slowest", "tape_line", "truth"]
