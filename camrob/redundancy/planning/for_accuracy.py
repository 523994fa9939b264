"""Plans that look at the part's error: what it weighs beside conditioning, and what is to be expected of a solution."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.accuracy.part_error import MARK, SHARE, STROKE, error_numbers, expected_squares, local_pushes
from camrob.redundancy.accuracy.posture_errors import ForceOfCut, LeftSurface, PostureErrors
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import ExpectedError
from camrob.redundancy.planning.candidates import external_prices
from camrob.redundancy.planning.certificate import ROLLS, Certificate, Survey
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.objective import Objective, PlanWeights
from camrob.redundancy.planning.refinement import arm_along
from camrob.redundancy.planning.waypoints import Waypoints
from camrob.redundancy.solution import Solution

__all__ = ["FOR_ACCURACY", "Weighed", "expected_error", "preferred", "pushed", "surface_squares", "weighed"]

Array = NDArray[np.float64]

FOR_ACCURACY = 10.0
"""What `accuracy` weighs where a plan for accuracy is asked for and the cell says nothing: the part's error before all else."""
_WORTH = 0.95
"""Of the error that the plan by conditioning expects: a plan has to expect less than that to be preferred, as what is expected
is no surer than some hundredths."""
STEADY = 10.0
"""Times `accuracy`, by which smoothness and steps of the arm are dearer: the best posture turns with the feed at every corner
of a path, and an arm that followed it would swing there.
"""
_LEAST_CUT = 1e-3  # m that a waypoint stands for, taken where it stands for less
_TURN = 1e-4  # rad that an axis has to go back before it has turned round
_LEAST = 1e-9  # m: an error that small is none, and there is nothing to weigh


class Weighed(NamedTuple):
    """The objective with the part's error in it, the survey with what its external postures cost, and m, rms of the error at the
    best posture of the scan.
    """

    objective: Objective
    survey: Survey
    best: float


def pushed(w: Waypoints, path: ToolPathInBase, errors: PostureErrors) -> Waypoints:
    """The waypoints with what pushes on the tool there, and the surface that is left."""
    feed, squares = np.asarray(path.feed)[w.point], surface_squares(path, np.asarray(w.place), np.asarray(w.s), errors)
    if squares is not None:
        # of a metre cut; in the mean over all that is cut, 1
        cut = np.asarray(w.cut)
        squares *= cut.sum() / max(float(np.trace(squares.sum(axis=0))), 1e-300)
        squares /= np.maximum(cut, _LEAST_CUT)[:, None, None]
    pushing = replace(errors, force=ForceOfCut(errors.force, _area_cut(path, errors)[w.point]))
    return replace(w, push=local_pushes(np.asarray(w.base_T_tip), np.asarray(w.cutting), feed, pushing, squares))


def _area_cut(path: ToolPathInBase, errors: PostureErrors) -> Array:
    """(N,) m2 that is cut across the way to each point of a path, or from it where the way to it cuts nothing; zeros where the
    surface is not known.
    """
    left = _left(path, errors)
    if left is None:
        return np.zeros(len(path.cutting))
    return np.where(path.cutting, left.taken, np.append(left.taken[1:], 0.0))


def _left(path: ToolPathInBase, errors: PostureErrors) -> LeftSurface | None:
    if errors.normals is None:
        return None
    return errors.normals.left(np.asarray(path.base_T_tip), np.asarray(path.cutting))


def surface_squares(path: ToolPathInBase, place: Array, s: Array, errors: PostureErrors) -> Array | None:
    """(W, 3, 3) m2, sums of n n^T in `base` over the surface that is left nearest to each of some places s (W,), rising, along a
    path whose points lie at `place` (N,); None where it is not known.
    """
    left = _left(path, errors)
    if left is None:
        return None
    at = place[left.move - 1] * (1.0 - left.at) + place[left.move] * left.at
    nearest = np.searchsorted(0.5 * (s[1:] + s[:-1]), at)
    out = np.zeros((len(s), 3, 3))
    for i in range(3):
        for j in range(3):
            weight = left.area * left.normal[:, i] * left.normal[:, j]
            out[:, i, j] = np.bincount(nearest, weight, minlength=len(s))
    return out


def weighed(
    cell: Cell,
    space: PlanSpace,
    objective: Objective,
    errors: PostureErrors,
    weights: PlanWeights,
    w: Waypoints,
    survey: Survey,
    certificate: Certificate,
) -> Weighed:
    """Bring the part's error into the objective (see `part_error`); nothing changes where nothing errs in what is cut."""
    numbers = error_numbers(cell, space.roll, errors)
    q = _postures(space, w, certificate)
    push = np.array(w.push)
    square, levers = expected_squares(numbers, np.array(certificate.u), q, push)
    cut = np.asarray(w.cut) * push[:, SHARE]
    if not np.any(cut > 0.0) or np.average(square, weights=cut) < _LEAST**2:
        return Weighed(objective, survey, 0.0)
    weight = (weights.accuracy or FOR_ACCURACY) / float(np.average(square, weights=cut))
    lever = np.average(levers, axis=0, weights=cut)
    turning = weight * np.asarray(errors.mark) ** 2 * lever * MARK / STROKE
    steady = 1.0 + STEADY * (weights.accuracy or FOR_ACCURACY)
    objective = objective._replace(
        errors=numbers._replace(weight=weight, turning=turning),
        arm_step=steady * objective.arm_step,
        u_smooth=steady * objective.u_smooth,
    )
    price = np.empty(survey.best.shape)
    least = np.zeros(len(survey.anchors))
    for k, anchor in enumerate(survey.anchors.tolist()):
        frame = np.array(w.base_T_tip[anchor])
        price[k], least[k] = external_prices(space, objective, frame, survey.grid, ROLLS, push[anchor])
    known = np.isfinite(least)[survey.nearest] * cut
    best = np.average(np.where(np.isfinite(least), least, 0.0)[survey.nearest], weights=known) if known.any() else 0.0
    return Weighed(objective, replace(survey, price=price), float(np.sqrt(best / weight)))


def _postures(space: PlanSpace, w: Waypoints, certificate: Certificate) -> Array:
    """The arm's postures (W, 6) that the certificate's bounds belong to."""
    n = len(w)
    frames, alone = np.array(w.base_T_tip), np.zeros(n, np.bool_)
    start = np.tile(space.center, (n, 1))
    q, _good = arm_along(space, frames, np.array(certificate.branch), alone, np.array(certificate.u), start)
    return np.asarray(q)


def expected_error(cell: Cell, errors: PostureErrors, path: ToolPathInBase, solution: Solution) -> ExpectedError:
    """What is to be expected of a solution of a path, at all its points."""
    frames, cutting = np.asarray(path.base_T_tip), np.asarray(path.cutting)
    feed = np.where(np.isfinite(path.feed), path.feed, 0.0)
    squares = surface_squares(path, np.asarray(path.length), np.asarray(path.length), errors)
    pushing = replace(errors, force=ForceOfCut(errors.force, _area_cut(path, errors)))
    push = local_pushes(frames, cutting, feed, pushing, squares)
    arm = cell.arm_slice
    free = np.setdiff1d(np.arange(len(cell)), np.arange(arm.start, arm.stop))
    q = np.asarray(solution.q)
    numbers = error_numbers(cell, len(free) - arm.start, errors)
    # the path's frames are the tool's as it is rolled
    square, _levers = expected_squares(numbers, np.ascontiguousarray(q[:, free]), np.ascontiguousarray(q[:, arm]), push)
    length = path.cut
    if squares is None:
        length *= push[:, SHARE]
    else:
        length = push[:, SHARE] * (length.sum() / max(float(push[:, SHARE].sum()), 1e-300))
    names = [cell.names[i] for i in range(arm.start, arm.stop)]
    turns = {n: _turns(q[:, arm.start + i], cutting) for i, n in enumerate(names) if errors.mark[i] > 0.0}
    return ExpectedError(np.sqrt(np.maximum(square, 0.0)), length, turns)


def preferred(before: ExpectedError, after: ExpectedError, *, corrected: bool) -> bool:
    """Whether a plan for accuracy is to be preferred, by what the plan by conditioning and it expect.

    corrected: for what compensation leaves. Such a plan leaves postures that were measured for doubts that are a little smaller,
    and has to expect less on 95 % of the surface, too: where it expected less in the mean alone, the part came out worse.
    """
    return after.rms < _WORTH * before.rms and (not corrected or after.p95 < _WORTH * before.p95)


def _turns(values: Array, cutting: NDArray[np.bool_]) -> int:
    """How often an axis turns round in cuts."""
    count, way, far = 0, 0, float(values[0])
    for value, cuts in zip(values.tolist(), cutting.tolist(), strict=True):
        if not cuts:
            way, far = 0, value
        elif way == 0:
            if abs(value - far) > _TURN:
                way, far = (1 if value > far else -1), value
        elif way * (value - far) >= 0.0:
            far = value
        elif way * (far - value) > _TURN:
            count, way, far = count + 1, -way, value
    return count
