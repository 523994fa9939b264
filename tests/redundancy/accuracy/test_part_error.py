"""The part's expected error in the objective: held to an arm of springs in plain numpy that shares nothing with camrob."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_planned import CELL, OBJECTIVE, SPACE, along, course_of, moves_of, raster

from camrob.redundancy.accuracy.part_error import error_numbers, expected_squares, local_pushes
from camrob.redundancy.accuracy.posture_errors import NoForce, PostureErrors
from camrob.redundancy.plan_report import ExpectedError
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.certificate import certify
from camrob.redundancy.planning.for_accuracy import expected_error, preferred, pushed
from camrob.redundancy.planning.objective import motion_price, plan_prices
from camrob.redundancy.planning.refinement import refine_course
from camrob.redundancy.planning.waypoints import waypoints

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap import generator

COMPLIANCE = np.array([1.2, 1.5, 2.0, 5.0, 8.0, 10.0]) * 1e-6
NOTHING = np.zeros(6)


class Push:
    """A force that is stated."""

    def __init__(self, *newton: float) -> None:
        self.newton = np.array(newton)

    def mean(self, feed, area=None):
        return np.tile(self.newton, (len(feed), 1))


def errors_of(**other) -> PostureErrors:
    given = {
        "compliance": NOTHING,
        "sagging": NOTHING,
        "shift": NOTHING,
        "swing": NOTHING,
        "mark": NOTHING,
        "root": np.zeros((12, 0)),
        "tip": np.zeros(2),
        "force": NoForce(),
    }
    return PostureErrors(**{**given, **other})


def postures(seed: int, count: int):
    """Postures about HOME: u (K, 3), q (K, 6), the generator's axis values (K, 8), and the rolled tool's axes in `world` (K, 3,
    3).
    """
    rng = np.random.default_rng(seed)
    q = CELL.q_home + 0.4 * rng.normal(size=(count, len(CELL)))
    axis_values = CELL.to_axis_values(q)
    order = [CELL.axis_names.index(a) for a in generator.AXES]
    axis = axis_values[:, order] / np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])
    roll = q[:, -1]
    turned = np.zeros((count, 3, 3))
    turned[:, 0, 0] = turned[:, 1, 1] = np.cos(roll)
    turned[:, 1, 0] = np.sin(roll)
    turned[:, 0, 1] = -turned[:, 1, 0]
    turned[:, 2, 2] = 1.0
    tool = generator.pose(axis)[:, :3, :3] @ turned
    return np.ascontiguousarray(q[:, SPACE.free]), np.ascontiguousarray(q[:, CELL.arm_slice]), axis, tool


def test_what_is_expected_is_what_an_arm_of_springs_does():
    """The arm in equilibrium under gravity and a force, found by other code: axes turned until their springs hold both."""
    u, q, axis, tool = postures(5, 12)
    force = np.array([-40.0, 25.0, 60.0])
    push = np.tile([*force, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0], (len(q), 1))
    numbers = error_numbers(CELL, 1, errors_of(compliance=COMPLIANCE, sagging=COMPLIANCE))
    got = np.sqrt(expected_squares(numbers, u, q, push)[0])
    world = np.einsum("kij,j->ki", tool, force)
    turned = np.zeros((len(q), 6))
    for _ in range(30):
        there = axis.copy()
        there[:, :6] += turned
        J = generator.jacobian(there)[:, :3]
        turned = COMPLIANCE * (generator.torques(there) + np.einsum("kij,ki->kj", J, world))
    there = axis.copy()
    there[:, :6] += turned
    moved = generator.pose(there)[:, :3, 3] - generator.pose(axis)[:, :3, 3]
    np.testing.assert_allclose(got, np.linalg.norm(moved, axis=1), rtol=0.01)


def test_each_term_is_the_one_written_down():
    """J^-T C J^-1 and all that stands beside it, by numpy from the other code's Jacobian."""
    rng = np.random.default_rng(8)
    u, q, axis, tool = postures(6, 8)
    n = rng.normal(size=(len(q), 2, 3))  # what counts: two walls
    force = rng.normal(size=(len(q), 3)) * 50.0
    squares = np.einsum("kai,kaj->kij", n, n)[:, (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    push = np.concatenate([force, squares, np.ones((len(q), 1))], axis=1)
    shift, swing, root = rng.normal(size=6) * 1e-4, np.abs(rng.normal(size=6)) * 1e-4, rng.normal(size=(12, 3)) * 1e-5
    root[:6] *= 1e-2
    tip, doubt, any_force, rest = np.array([4e-8, 1e-8]), 0.3, 20.0, 5e-5
    errors = errors_of(
        compliance=COMPLIANCE,
        sagging=COMPLIANCE,
        shift=shift * generator.SIGN,
        swing=swing,
        root=root * np.concatenate([np.ones(6), generator.SIGN])[:, None],
        tip=tip,
        doubt=doubt,
        any_force=any_force,
        rest=rest,
    )
    got, levers = expected_squares(error_numbers(CELL, 1, errors), u, q, push)
    left, _ = expected_squares(error_numbers(CELL, 1, replace(errors, corrected=True)), u, q, push)
    J, torque = generator.jacobian(axis)[:, :3], generator.torques(axis)
    for k in range(len(q)):
        P = n[k] @ tool[k].T  # what of a vector lies along either wall's normal
        f = tool[k] @ force[k]
        z = tool[k][:, 2]
        C = J[k] @ np.diag(COMPLIANCE) @ J[k].T + tip[0] * np.eye(3) + (tip[1] - tip[0]) * np.outer(z, z)
        # a second way to the same compliance: the stiffness J^-T K J^-1 of the whole twist, inverted
        whole = generator.jacobian(axis[k : k + 1])[0]
        stiffness = np.linalg.inv(whole).T @ np.diag(1.0 / COMPLIANCE) @ np.linalg.inv(whole)
        np.testing.assert_allclose(
            np.linalg.inv(stiffness)[:3, :3], J[k] @ np.diag(COMPLIANCE) @ J[k].T, rtol=1e-4, atol=1e-9
        )
        own = torque[k] + J[k].T @ f
        d = C @ f + J[k] @ (COMPLIANCE * torque[k] + shift)
        expected = np.sum((P @ d) ** 2) + doubt**2 * np.sum((P @ C @ f) ** 2) + any_force**2 * np.sum((P @ C) ** 2)
        expected += np.sum((swing * np.linalg.norm(P @ J[k], axis=0)) ** 2)
        expected += np.sum((P @ J[k] @ (root[:6] * own[:, None] + root[6:])) ** 2)
        expected += rest**2 * np.sum(P**2)
        assert got[k] == pytest.approx(expected, rel=1e-5)
        assert left[k] == pytest.approx(expected - np.sum((P @ d) ** 2), rel=1e-5)
        np.testing.assert_allclose(levers[k], np.sum((P @ J[k]) ** 2, axis=0), rtol=1e-5, atol=1e-9)


def test_a_force_is_laid_along_the_feed():
    path = raster(2, 6)
    frames, cutting = np.asarray(path.base_T_tip), np.asarray(path.cutting)
    push = local_pushes(frames, cutting, np.full(len(frames), 0.02), errors_of(force=Push(-60.0, 30.0, 20.0)))
    base = np.einsum("nij,nj->ni", frames[:, :3, :3], push[:, :3])
    way = np.sign(np.diff(frames[:6, 0, 3]))[0]
    np.testing.assert_allclose(base[2], [-60.0 * way, 30.0 * way, 20.0], atol=1e-9)
    np.testing.assert_allclose(base[8], [60.0 * way, -30.0 * way, 20.0], atol=1e-9)
    in_air = local_pushes(frames, np.zeros(len(frames), bool), np.zeros(len(frames)), errors_of(force=Push(1, 1, 1)))
    assert not in_air.any()


def test_refinement_with_the_parts_error_ends_in_an_optimum():
    errors = errors_of(compliance=COMPLIANCE, force=Push(-60.0, 30.0, 20.0), mark=np.array([1e-4, 0, 0, 0, 0, 0]))
    path = raster(2, 6)
    w = pushed(waypoints(path, 0.02), path, errors)
    n = len(w)
    certificate = certify(SPACE, w.base_T_tip)
    u = np.tile(certificate.u[0] + np.array([0.2, 0.1, 0.2]), (n, 1))
    course, push = course_of(w, int(certificate.branch[0]), n), w.pushes(np.arange(n))
    q, good = along(course, u, np.tile(SPACE.center, (n, 1)))
    assert good.all()
    numbers = error_numbers(CELL, 1, errors)
    square = expected_squares(numbers, u, q, push)[0]
    objective = OBJECTIVE._replace(
        errors=numbers._replace(weight=5.0 / square.mean(), turning=np.array([0.3, 0, 0, 0, 0, 0]))
    )
    motion = motion_price(objective, moves_of(n)._replace(cuts_on=np.arange(n) > 0))
    course = course._replace(push=push, motion=motion)

    def price(u, q):
        own = plan_prices(SPACE, OBJECTIVE, u, q, course.weight, push, moves_of(n), course.joined)
        wrong = expected_squares(numbers, u, q, push)[0] @ course.weight * objective.errors.weight
        d = np.diff(q[:, 0])
        return sum(own.values()) + wrong + 0.3 * np.sum(np.sqrt(d**2 + 1e-6) - 1e-3)

    before = price(u, q)
    reached = refine_course(SPACE, objective, course, u, q, np.zeros(3, bool), 200)
    after = price(u, q)
    assert after < 0.9 * before
    assert reached == pytest.approx(after, rel=1e-3)  # external travel is rounded off below a thousandth
    rng = np.random.default_rng(2)
    for _ in range(40):
        other = u + 2e-3 * rng.normal(size=(1, 3)) + 1e-3 * rng.normal(size=(n, 3))
        moved, _good = along(course, other, q)
        assert price(other, moved) > after - 2e-4 * after


def test_plans_for_accuracy_beat_plans_by_conditioning_under_a_force():
    path = raster(4, 6, width=0.12)
    plain = resolve_planned(CELL, path, mode="still")
    errors = errors_of(compliance=COMPLIANCE, force=Push(-60.0, 30.0, 20.0))
    ours = resolve_planned(CELL, path, mode="still", errors=errors)
    report = ours.plan.accuracy
    assert report.taken and report.accuracy.rms < 0.8 * report.conditioning.rms and report.best <= report.accuracy.rms
    assert report.conditioning.rms == expected_error(CELL, errors, path, plain).rms
    assert report.accuracy.rms == expected_error(CELL, errors, path, ours).rms
    assert {"part_error", "turned_back"} <= set(ours.plan.terms) and not {"part_error"} & set(plain.plan.terms)

    # nothing errs, nothing is changed: to the last bit
    idle = resolve_planned(CELL, path, mode="still", errors=errors_of())
    assert idle.q.tobytes() == plain.q.tobytes() and not idle.plan.accuracy.taken


def test_a_plan_does_not_turn_round_an_axis_whose_turns_are_dear():
    path = raster(6, 6, width=0.12)
    errors = errors_of(swing=np.array([1e-5, 0, 0, 0, 0, 0]), mark=np.array([4e-4, 0, 0, 0, 0, 0]))
    ours = resolve_planned(CELL, path, mode="flowing", errors=errors)
    report = ours.plan.accuracy
    assert report.taken and report.conditioning.turns["A1"] >= 4
    assert report.accuracy.turns["A1"] <= 1


def test_percentiles_are_of_what_is_cut():
    error = ExpectedError(np.array([5.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.94, 0.02, 0.04]), {"A1": 2})
    assert error.p95 == 2.0 and error.rms == pytest.approx(np.sqrt(0.94 + 0.08 + 0.36))
    both = error.joined(ExpectedError(np.array([9.0]), np.array([1.0]), {"A1": 1}))
    assert both.p95 == 9.0 and both.turns == {"A1": 3}


@pytest.mark.parametrize(
    ("typical", "tail", "corrected", "taken"),
    [(0.6, 0.6, True, True), (0.2, 1.0, True, False), (0.2, 1.0, False, True), (0.99, 0.99, False, False)],
)
def test_what_compensation_leaves_has_to_be_less_in_its_tail_too(
    typical: float, tail: float, corrected: bool, taken: bool
) -> None:
    """Nine tenths of a path with one error, a tenth with thrice as much, each times what the other plan makes of it."""
    length = np.ones(100)
    before = np.where(np.arange(100) < 90, 1e-4, 3e-4)
    after = before * np.where(np.arange(100) < 90, typical, tail)
    plans = (ExpectedError(error, length, {}) for error in (before, after))
    assert preferred(*plans, corrected=corrected) == taken
