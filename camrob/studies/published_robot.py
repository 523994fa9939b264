"""A simulated robot with drawn errors: what a tracker sees of it, and how a compensated line runs on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.calibration.compensate import compensate_postures, difference_sizes, pose_difference
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.measurements import Measurements
from camrob.calibration.terms import standard_names
from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_tool
from camrob.se3 import rotation_exp
from camrob.studies.published_file import PublishedCase
from camrob.studies.published_newton import compensate_as_published
from camrob.studies.straight_line import straight_line
from camrob.timing.derivative_analysis import DerivativeAnalysis, analyse_derivatives

__all__ = ["TapeLine", "case_line", "drawn_errors", "measured_poses", "tape_line"]

Array = NDArray[np.float64]

_TWINS = 8  # every so many points the published iteration runs beside ours


def drawn_errors(case: PublishedCase, cell: Cell) -> dict[str, float]:
    """The simulated robot's errors by name, SI; always the same ones for a case."""
    rng = np.random.default_rng(case.seed)
    errors: dict[str, float] = {}
    last = cell.joints[cell.arm_slice.stop - 1].name
    for name in standard_names(cell):
        if name.startswith(("base", "tool")):
            continue
        axis, kind = name.split(".")
        drawn = float(rng.normal())
        if kind == "compliance":
            errors[name] = case.compliance[axis] * (1.0 + case.compliance_spread * drawn)
        else:
            errors[name] = drawn * (case.place if kind in ("x", "y") else case.angle)
    for name in standard_names(cell, harmonics=case.ripple_orders):
        if ".cos" in name or ".sin" in name:
            errors[name] = float(rng.normal()) * (case.last_ripple if name.startswith(last) else case.ripple)
    return errors


def measured_poses(
    case: PublishedCase, cell: Cell, errors: Mapping[str, float], count: int, seed: int, name: str
) -> Measurements:
    """What the tracker sees of the robot in `count` postures drawn from the case's range."""
    q = cell.to_q(np.random.default_rng(seed).uniform(case.lower_deg, case.upper_deg, (count, len(case.lower_deg))))
    frames = ErrorModel.of(cell, tuple(errors)).poses(np.array(list(errors.values())), q)
    rng = np.random.default_rng(seed + 1000)
    frames[:, :3, 3] += rng.normal(0.0, case.sigma[0], (count, 3))
    frames[:, :3, :3] = rotation_exp(rng.normal(0.0, case.sigma[1], (count, 3))) @ frames[:, :3, :3]
    return Measurements(q, frames, True, sigma_position=case.sigma[0], sigma_angle=case.sigma[1], name=name)


def case_line(case: PublishedCase, cell: Cell) -> Array:
    """Postures (N, n) of the nominal robot along the case's straight line. Raises UnreachableError where it leaves the reach."""
    middle, direction = cell.to_q(np.asarray(case.middle_deg)), np.asarray(case.direction)
    first = straight_line(cell, middle, -direction, step=case.step, count=case.points // 2 + 1)[-1]
    return straight_line(cell, first, direction, step=case.step, count=case.points)


@dataclass(frozen=True, slots=True)
class TapeLine:
    """The paper's use case, run by the simulated robot. planned (N, n); errors before, after, and after with the extended
    model (N, 2), m and rad. iterations: at most, of ours; published_iterations: from and to, of the published one on every
    eighth point; difference: the farthest between both, rad. analysis: section III, planned and compensated.
    """

    planned: Array
    before: Array
    after: Array
    extended: Array
    iterations: int
    published_iterations: tuple[int, int]
    difference: float
    analysis: tuple[DerivativeAnalysis, DerivativeAnalysis]

    def __post_init__(self) -> None:
        count = len(self.planned)
        object.__setattr__(self, "planned", locked(self.planned, shape=(count, None), name="planned"))
        for name in ("before", "after", "extended"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count, 2), name=name))


def tape_line(
    case: PublishedCase, cell: Cell, errors: Mapping[str, float], plain: Calibration, extended: Calibration
) -> TapeLine:
    """Compensate the case's line with both calibrations and run it. Raises UnreachableError where it leaves the reach."""
    planned = case_line(case, cell)
    targets = base_T_tool(cell, planned)
    real, truth = ErrorModel.of(cell, tuple(errors)), np.array(list(errors.values()))

    def error_of(q: Array) -> Array:
        return difference_sizes(pose_difference(targets, real.poses(truth, q)))

    model, values = plain.model(cell)
    ours = compensate_postures(model, values, planned, targets)
    counts, difference = [], 0.0
    for row in range(0, len(planned), _TWINS):
        theta, count = compensate_as_published(lambda a: model.poses(values, a[None])[0], targets[row], planned[row])
        counts.append(count)
        difference = max(difference, float(np.max(np.abs(theta - np.asarray(ours.q)[row]))))
    further = compensate_postures(*extended.model(cell), planned, targets)
    return TapeLine(
        planned=planned,
        before=error_of(planned),
        after=error_of(np.asarray(ours.q)),
        extended=error_of(np.asarray(further.q)),
        iterations=int(np.max(ours.iterations)),
        published_iterations=(min(counts), max(counts)),
        difference=difference,
        analysis=(analyse_derivatives(cell, planned), analyse_derivatives(cell, np.asarray(ours.q))),
    )
