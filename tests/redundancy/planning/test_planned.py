"""Planned postures: the bound, the search, the refinement, still axes, retracts, and what a sample gets."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import torch

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.cli import app as cli
from camrob.errors import CellError, UnreachableError
from camrob.frozen import locked
from camrob.kinematics.arm import Arm
from camrob.kinematics.batched import BatchedKinematics
from camrob.kinematics.kernels import chain_arrays, forward_many, inverse_kf_many
from camrob.redundancy.accuracy.part_error import PUSH
from camrob.redundancy.free_frames import rotation_minimising
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning import objective as planner_objective
from camrob.redundancy.planning.certificate import Certificate, certify, external_grid, scan
from camrob.redundancy.planning.dynamic_programming import Layers, cheapest_way
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work, pose_in_foot, posture
from camrob.redundancy.planning.objective import (
    Moves,
    Objective,
    motion_price,
    plan_prices,
    plan_weights,
    posture_price,
)
from camrob.redundancy.planning.refinement import Course, arm_along, refine_course
from camrob.redundancy.planning.scan_batched import scan_batched
from camrob.redundancy.planning.waypoints import waypoints
from camrob.redundancy.published.virtual_joint import PathFollower
from camrob.redundancy.published.weighting import even_weights
from camrob.redundancy.transfers import build_path
from camrob.se3 import pose
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

ROOT = Path(__file__).resolve().parents[3]
CELL = read_cell(ROOT / "cells" / "kr15_track_table")
SPACE = plan_space(CELL)
WEIGHTS = plan_weights(CELL)
OBJECTIVE = Objective.of(CELL, SPACE, WEIGHTS)
EXTERNAL = [0, 1]  # E2, E1


def frame(position, axis):
    z = np.array(axis, float)
    x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return pose(np.stack([x, np.cross(z, x), z], axis=1), np.array(position, float))


def path_of(tips, axes, *, feed=0.02, safe=()):
    n = len(tips)
    mask = np.zeros(n, bool)
    mask[list(safe)] = True
    move = np.where(mask, int(Move.RAPID), int(Move.CUT)).astype(np.int8)
    R = rotation_minimising(np.ascontiguousarray(axes), np.array([0.3, 0.5, 0.8]))
    return ToolPathInBase(
        pose(R, tips), move, np.where(mask, np.nan, feed), np.arange(n) + 10, np.zeros(n, np.int32), np.arange(n), mask
    )


def raster(lines=6, points=12, width=0.2):
    x = np.linspace(-0.5 * width, 0.5 * width, points)
    tips = [[(x if k % 2 == 0 else -x)[i], 0.01 * k, 0.25] for k in range(lines) for i in range(points)]
    return path_of(np.array(tips), np.tile([0.0, 0.0, 1.0], (lines * points, 1)))


def helix(turns, n):
    a = np.linspace(0.0, 2.0 * np.pi * turns, n)
    axes = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1)
    return path_of(0.1 * axes + np.array([0.0, 0.0, 0.2]) + np.linspace(0, 0.05, n)[:, None] * [0.0, 0.0, 1.0], axes)


# the space and the certificate


def test_posture_is_the_arm_module_in_closed_form():
    rng = np.random.default_rng(3)
    arm, work = Arm.of(CELL), plan_work()
    for _ in range(20):
        q = CELL.q_home + rng.normal(size=len(CELL)) * 0.4
        base_T_tool = forward_many(chain_arrays(CELL), q[None])[0]
        u = q[SPACE.free]
        pose_in_foot(SPACE, base_T_tool, u, work)
        expected = arm.foot_T_tool(base_T_tool, q)
        np.testing.assert_allclose(work.Rt, expected[:3, :3], atol=1e-12)
        np.testing.assert_allclose(work.pt, expected[:3, 3], atol=1e-12)
        near, found = q[CELL.arm_slice].copy(), np.empty((8, 6))
        met = [b for b in range(8) if posture(SPACE, base_T_tool, u, b, near, found[b], work)]
        assert min(np.abs(found[b] - near).max() for b in met) < 1e-9
        assert conditioning(SPACE, near, work) == pytest.approx(
            inverse_kf_many(chain_arrays(CELL), q[None])[0], abs=1e-12
        )


@pytest.mark.parametrize(
    ("position", "axis", "bound"),
    [
        ((0.1, 0, 0.05), (0, 0, 1), 0.597),
        ((0.1, 0, 0.2), (0, 0, 1), 0.657),
        ((0.1, 0, 0.4), (0, 0, 1), 0.680),
        ((0, 0, 0.05), (0, 0, 1), 0.576),
        ((0, 0, 0.2), (0, 0, 1), 0.623),
        ((0, 0, 0.4), (0, 0, 1), 0.640),
        ((0.1, 0, 0.2), (1, 0, 0), 0.717),
        ((0, 0, 0.2), (1, 0, 0), 0.706),
    ],
)
def test_bound_is_what_others_found(position, axis, bound):
    """Numbers computed independently for this cell, tool straight down or level."""
    assert certify(SPACE, locked(frame(position, axis)[None])).inv_kf[0] == pytest.approx(bound, abs=6e-4)


def test_no_posture_beats_its_certificate():
    path = raster()
    w = waypoints(path, 0.05)
    certificate = certify(SPACE, w.base_T_tip)
    rng = np.random.default_rng(5)
    work, q = plan_work(), np.empty(6)
    for k in range(0, len(w), 24):
        tried = 0.0
        for _ in range(1500):
            u = np.array([rng.uniform(-np.pi, np.pi), rng.uniform(-1.0, 1.0), rng.uniform(-np.pi, np.pi)])
            b = int(rng.integers(8))
            if posture(SPACE, w.base_T_tip[k], u, b, SPACE.center, q, work) and np.all(
                (q >= SPACE.lower) & (q <= SPACE.upper)
            ):
                tried = max(tried, conditioning(SPACE, q, work))
        assert 0.9 * certificate.inv_kf[k] < tried <= certificate.inv_kf[k] + 1e-4
    reached = np.array([_value(certificate, w, k) for k in range(len(w))])
    np.testing.assert_allclose(reached, certificate.inv_kf, atol=1e-12)


def _value(certificate, w, k):
    q, work = np.empty(6), plan_work()
    assert posture(SPACE, w.base_T_tip[k], certificate.u[k], int(certificate.branch[k]), SPACE.center, q, work)
    return conditioning(SPACE, q, work)


def test_scan_counts_both_wrists_and_respects_limits():
    at = locked(frame((0.1, 0, 0.2), (0, 0, 1)))
    found = scan(SPACE, at, external_grid(SPACE), 6)
    assert found.max() < 0.6573
    both = (found[..., 0::2] > 0) & (found[..., 1::2] > 0)
    np.testing.assert_array_equal(found[..., 0::2][both], found[..., 1::2][both])
    narrow = SPACE._replace(upper=SPACE.upper - 0.3, lower=SPACE.lower + 0.3)
    assert (scan(narrow, at, external_grid(SPACE), 6) > 0).sum() < (found > 0).sum()


def test_bound_between_waypoints_is_never_below_the_chord():
    s = np.linspace(0.0, 1.0, 11)
    certificate = Certificate(0.6 + 0.05 * np.sin(3.0 * s), np.zeros((11, 3)), np.zeros(11, np.int64))
    fine = np.linspace(0.0, 1.0, 301)
    bound = certificate.along(s, fine)
    assert np.all(bound >= np.interp(fine, s, certificate.inv_kf) - 1e-12)
    inner = (fine > 0.1) & (fine < 0.9)
    assert np.all(bound[inner] >= (0.6 + 0.05 * np.sin(3.0 * fine) - 1e-4)[inner])
    assert certificate.raised(np.full(11, 0.63)).inv_kf.min() == 0.63


# the search


def layers_of(x, price, *, window=1.0, rate=1.0, square=0.0, jump=np.inf, endless=False):
    """Layers of one-coordinate nodes x (T, K), price (T, K)."""
    T, K = x.shape
    ones = np.ones((T, 1))
    return Layers(
        np.arange(0, T * K + 1, K),
        x.reshape(-1, 1).astype(float),
        price.ravel().astype(float),
        window * ones,
        rate * ones,
        square * ones,
        np.inf * ones,
        np.zeros(T),
        np.array([endless]),
        np.broadcast_to(np.asarray(jump, float), (T,)).copy(),
    )


def brute(x, price, window, rate, square):
    T, K = x.shape
    best = np.inf
    for way in product(range(K), repeat=T):
        d = np.abs(np.diff([x[t, k] for t, k in enumerate(way)]))
        if np.all(d <= window):
            best = min(best, sum(price[t, k] for t, k in enumerate(way)) + rate * d.sum() + square * (d**2).sum())
    return best


def test_search_is_exhaustive_search():
    rng = np.random.default_rng(7)
    for _ in range(30):
        x, price = rng.uniform(0, 3, (6, 4)), rng.uniform(0, 1, (6, 4))
        way = cheapest_way(layers_of(x, price, window=1.4, rate=0.2, square=0.1))
        assert way.price == pytest.approx(brute(x, price, 1.4, 0.2, 0.1), abs=1e-12) or not np.isfinite(way.price)
        assert np.isfinite(way.price) == np.isfinite(brute(x, price, 1.4, 0.2, 0.1))


def test_planted_way_is_found_among_decoys():
    """A smooth way of price 0.1 a layer among cheaper nodes that lead nowhere."""
    rng = np.random.default_rng(11)
    T, K = 200, 60
    x = rng.uniform(-50.0, 50.0, (T, K))
    price = rng.uniform(0.0, 0.09, (T, K))  # each decoy is cheaper, but no neighbour lies within the window
    planted = rng.integers(K, size=T)
    line = 10.0 * np.sin(np.arange(T) / 15.0)
    for t in range(T):
        far = np.abs(x[t] - line[t]) < 4.0
        x[t, far] += 300.0 + 10.0 * t
        x[t, np.arange(K) != planted[t]] += 1000.0 * (t % 2)
        x[t, planted[t]], price[t, planted[t]] = line[t], 0.1
    way = cheapest_way(layers_of(x, price, window=1.0, rate=0.01))
    assert list(way.leave - np.arange(T) * K) == list(planted)
    assert way.price == pytest.approx(0.1 * T + 0.01 * np.abs(np.diff(line)).sum(), rel=1e-12)


def test_a_way_and_its_reverse_cost_the_same():
    rng = np.random.default_rng(13)
    x, price = rng.uniform(0, 3, (40, 9)), rng.uniform(0, 1, (40, 9))
    jump = np.where(np.arange(40) % 7 == 3, 0.02, np.inf)
    there = cheapest_way(layers_of(x, price, window=0.7, rate=0.2, jump=jump))
    back = cheapest_way(layers_of(x[::-1], price[::-1], window=0.7, rate=0.2, jump=jump[::-1]))
    assert there.price == pytest.approx(back.price, rel=1e-12)
    assert np.any(there.arrive != there.leave)


def test_a_way_that_breaks_is_cut_where_it_is_cheapest():
    """Two tracks that never meet: the first ends at layer 6, the second begins at layer 3; the jump costs least at 5."""
    x = np.tile([0.0, 10.0], (10, 1))
    price = np.zeros((10, 2))
    price[7:, 0], price[:3, 1] = 100.0, 100.0
    jump = np.array([9, 9, 9, 3, 2, 1, 2, 9, 9, 9], float)
    way = cheapest_way(layers_of(x, price, jump=jump))
    assert list(np.flatnonzero(way.arrive != way.leave)) == [5]
    assert way.price == pytest.approx(1.0)
    assert cheapest_way(layers_of(x, np.where(price > 0, np.inf, price))).reached == 7


def test_endless_coordinates_wrap():
    x = np.array([[3.1], [-3.1], [-3.0]])
    assert cheapest_way(layers_of(x, np.zeros((3, 1)), window=0.3, endless=True)).price == pytest.approx(
        2 * np.pi - 6.2 + 0.1
    )
    assert cheapest_way(layers_of(x, np.zeros((3, 1)), window=0.3)).reached == 1


# the objective and its refinement


def moves_of(n):
    return Moves(np.full(n, 0.02), np.full(n, 1.0), np.full(n, 0.3), np.zeros(n))


def along(course, u, start):
    return arm_along(SPACE, course.frames, course.branch, course.joined, u, start)


def course_of(w, branch, n):
    return Course(
        np.array(w.base_T_tip),
        np.full(n, branch),
        np.full(n, 0.02),
        motion_price(OBJECTIVE, moves_of(n)),
        np.arange(n) > 0,
        np.zeros((0, PUSH)),
        np.zeros((n, 0), bool),
    )


def test_refinement_ends_in_an_optimum():
    w = waypoints(raster(2, 6), 0.02)
    n = len(w)
    certificate = certify(SPACE, w.base_T_tip)
    branch = int(certificate.branch[0])
    u = np.tile(certificate.u[0] + np.array([0.2, 0.1, 0.2]), (n, 1))
    course = course_of(w, branch, n)
    q, good = along(course, u, np.tile(SPACE.center, (n, 1)))
    assert good.all()
    free = np.zeros(3, bool)

    def price(u, q):
        return sum(plan_prices(SPACE, OBJECTIVE, u, q, course.weight, course.push, moves_of(n), course.joined).values())

    before = price(u, q)
    refine_course(SPACE, OBJECTIVE, course, u, q, free, 200)
    after = price(u, q)
    assert after < 0.97 * before
    rng = np.random.default_rng(2)
    for _ in range(40):
        other = u + 2e-3 * rng.normal(size=(1, 3)) + 1e-3 * rng.normal(size=(n, 3))
        moved, _good = along(course, other, q)
        assert price(other, moved) > after - 2e-4 * after
    np.testing.assert_allclose(along(course, u, q)[0], q, atol=1e-9)


def test_prices_are_those_written_down():
    rng = np.random.default_rng(4)
    n = 5
    q = CELL.q_home + 0.1 * rng.normal(size=(n, 9))
    q[2, 5] = CELL.q_upper[5] - np.deg2rad(4.0)  # A4 is 4 degrees from its limit
    u, arm = np.ascontiguousarray(q[:, SPACE.free]), np.ascontiguousarray(q[:, CELL.arm_slice])
    weight, ds, dt = np.full(n, 0.5), np.full(n, 0.2), np.full(n, 0.001)
    moves = Moves(ds, dt, np.ones(n), np.zeros(n))
    got = plan_prices(SPACE, OBJECTIVE, u, arm, weight, np.zeros((0, PUSH)), moves, np.arange(n) > 0)
    x = inverse_kf_many(chain_arrays(CELL), q)
    d = np.abs(np.diff(u, axis=0))
    room = np.minimum(q - CELL.q_lower, CELL.q_upper - q)
    margin = np.full(9, np.deg2rad(5.0))
    margin[1] = 0.02
    ratio = np.where(np.isfinite(room), room / margin, np.inf)
    barrier = np.maximum(2.0 - ratio, 0.0) ** 2 + 10.0 * np.maximum(1.0 - ratio, 0.0) ** 2
    over = np.maximum(d[:, :2] / (0.8 * CELL.limits_of("speed")[:2] * 0.001) - 1.0, 0.0)
    expected = [
        (weight * (0.5 / x) ** 4).sum(),
        (weight[:, None] * barrier).sum(),
        (d[:, 0] * 0.04 + d[:, 1] * 0.02).sum(),
        (0.0002 * d**2 / 0.2).sum(),
        (over**2 * 0.2).sum(),
        (0.0001 * np.diff(arm, axis=0) ** 2 / 0.2).sum(),
    ]
    names = ["conditioning", "margins", "travel", "smoothness", "speed", "arm_steps"]
    assert set(names) <= set(got)
    np.testing.assert_allclose([got[name] for name in names], expected, rtol=1e-9)
    assert expected[1] > 0.0
    assert posture_price(SPACE, OBJECTIVE, u[0], arm[0], 0.5)[0] == pytest.approx(1.0)


def test_a_term_of_motion_is_one_function(monkeypatch):
    """A term that nothing else knows is searched for, refined and reported."""

    def wrist(objective, moves, price):
        price.rate[:, -1] += 0.5
        price.rate[:, -2] += 0.5

    path = raster(3, 6)
    plain = resolve_planned(CELL, path, mode="flowing")
    monkeypatch.setattr(planner_objective, "MOTION_TERMS", {**planner_objective.MOTION_TERMS, "planted": wrist})
    priced = resolve_planned(CELL, path, mode="flowing")
    turned = [np.abs(np.diff(s.q[:, CELL.arm_slice][:, 4:], axis=0)).sum() for s in (plain, priced)]
    assert turned[1] < 0.8 * turned[0]
    assert "planted" not in plain.plan.terms
    assert priced.plan.terms["planted"] == pytest.approx(
        0.5 * turned[1], rel=0.1
    )  # of waypoints, which are fewer than points


def test_weights_with_unknown_names_are_refused():
    settings = replace(CELL.resolve, planned={"conditoning": 1.0})
    with pytest.raises(CellError, match="conditoning"):
        plan_weights(replace(CELL, resolve_section=settings))


def test_waypoints_grow_with_the_path_and_keep_its_length():
    short, long = raster(4, 12), raster(16, 12)
    counts = [len(waypoints(p, 0.02)) for p in (short, long)]
    assert 3.5 < counts[1] / counts[0] < 4.6
    dense = path_of(np.repeat(long.base_T_tip[:, :3, 3], 1, axis=0), long.base_T_tip[:, :3, 2])
    for path in (short, long, dense):
        w = waypoints(path, 0.02)
        assert w.cut.sum() == pytest.approx(np.linalg.norm(np.diff(path.base_T_tip[:, :3, 3], axis=0), axis=1).sum())
        assert np.all(np.diff(w.s) <= 0.02 + 1e-9)
        np.testing.assert_array_equal(w.base_T_tip[w.on_point], path.base_T_tip[w.point[w.on_point]])


# whole plans


@pytest.fixture(scope="module")
def engraving():
    folder = ROOT / "toolpaths" / "engraving"
    setup = read_setup(folder / "setup.toml", CELL)
    return build_path(CELL, read_toolpath(folder / "engraving.cls"), setup.base_T_part, clearance=setup.clearance)


def moved_while_cutting(path, q):
    steps = np.abs(np.diff(q[:, EXTERNAL], axis=0))
    return steps[path.cutting[1:]]


def shares(path, solution):
    length = np.diff(path.length, prepend=0.0) * path.cutting
    plan = solution.plan
    return np.average(solution.inv_kf, weights=length) / plan.bound_mean, solution.inv_kf[
        length > 0
    ].min() / plan.bound_min


def check(path, solution):
    position, axis = solution.residual(CELL, path)
    assert position.max() < 1e-9 and axis.max() < 1e-9
    assert np.all(solution.inv_kf <= solution.plan.bound + 1e-12)
    limited = np.isfinite(CELL.q_lower)
    room = np.minimum(solution.q - CELL.q_lower, CELL.q_upper - solution.q)[:, limited]
    margin = np.where([j.prismatic for j, has in zip(CELL.joints, limited, strict=True) if has], 0.02, np.deg2rad(5.0))
    assert np.all(room >= margin - 1e-9)


def test_still_axes_are_exactly_still(engraving):
    solution = resolve_planned(CELL, engraving, mode="still")
    check(engraving, solution)
    assert np.all(moved_while_cutting(engraving, solution.q) == 0.0)
    mean, _worst = shares(engraving, solution)
    assert mean > 0.96
    assert solution.method == "planned" and solution.path is None


@pytest.mark.slow
def test_flowing_axes_come_near_the_bound(engraving):
    solution = resolve_planned(CELL, engraving, mode="flowing")
    check(engraving, solution)
    mean, worst = shares(engraving, solution)
    assert mean > 0.98 and worst > 0.9
    speed = CELL.limits_of("speed")[EXTERNAL]
    step = np.linalg.norm(np.diff(engraving.base_T_tip[:, :3, 3], axis=0), axis=1)
    time = (step / np.where(np.isfinite(engraving.feed[1:]), engraving.feed[1:], 0.2))[engraving.cutting[1:]]
    assert np.all(moved_while_cutting(engraving, solution.q) <= speed * time[:, None] + 1e-6)
    assert sum(solution.plan.shares.values()) == pytest.approx(1.0)


@pytest.mark.slow
def test_default_is_the_knee_of_a_curve(engraving):
    ticks: list[float] = []
    solution = resolve_planned(CELL, engraving, progress=ticks.append)
    plan = solution.plan
    assert ticks == sorted(ticks) and ticks[-1] == 1.0
    names = [p.name for p in plan.curve]
    assert names[0] == "still" and names[-1] == "flowing" and plan.chosen in names
    assert plan.curve[0].share < plan.curve[-1].share
    assert plan.curve[0].travel["E2"] == 0.0 < plan.curve[-1].travel["E2"]
    assert plan.curve[names.index(plan.chosen)].share >= 0.96
    again = resolve_planned(CELL, engraving)
    np.testing.assert_array_equal(again.q, solution.q)


def test_a_path_that_winds_an_axis_up_is_retracted_and_cut():
    """Two and a half times around the part with a table that turns a little over once."""
    table = replace(CELL.joints[0], lower=np.deg2rad(-200.0), upper=np.deg2rad(200.0))
    cell = replace(CELL, joints=(table, *CELL.joints[1:]))
    path = helix(2.5, 250)
    solution = resolve_planned(cell, path, mode="flowing")
    longer = solution.path
    assert longer is not None and len(longer) > len(path)
    np.testing.assert_array_equal(longer.base_T_tip[longer.source >= 0], path.base_T_tip)
    assert solution.residual(cell, longer)[0].max() < 1e-9
    kept = [r for r in solution.revisions if r.kept]
    assert len(kept) >= 1 and all(longer.safe[r.point] and r.reason for r in kept)
    assert solution.plan.retracts >= len(kept)
    found = [f for f in solution.findings if f.code == "retract-inserted"]
    assert found and all(f.line >= 10 for f in found)
    assert np.all(solution.q[:, 0] >= cell.q_lower[0]) and np.all(solution.q[:, 0] <= cell.q_upper[0])
    for r in kept:  # the pose is the same before and after
        before, after = forward_many(chain_arrays(cell), np.asarray(r.q[[0, -1]]))
        np.testing.assert_allclose(before, after, atol=1e-9)
        np.testing.assert_array_equal(r.q[-1], solution.q[r.point])


def test_what_no_posture_reaches_is_said_with_its_line():
    tips = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0]])
    with pytest.raises(UnreachableError) as caught:
        resolve_planned(CELL, path_of(tips, np.tile([0.0, 0.0, 1.0], (3, 1))))
    assert caught.value.line in (11, 12)


def test_unknown_modes_are_refused():
    with pytest.raises(ValueError, match="sideways"):
        resolve_planned(CELL, raster(1, 3), mode="sideways")


def test_locked_joints_stand_where_the_reference_has_them():
    path = raster(1, 8)
    follower = PathFollower(CELL, path, weighting=even_weights(CELL))
    locked = np.zeros(len(CELL), bool)
    locked[EXTERNAL] = True
    follower.settings = follower.settings._replace(locked=locked)
    rows = np.tile(CELL.q_home, (len(path), 1))
    rows[:, 1] = np.linspace(0.0, 0.1, len(path))
    rows[:, 0] += np.linspace(0.0, -0.2, len(path))
    free = PathFollower(CELL, path, weighting=even_weights(CELL)).follow(follower.home(), CELL.q_home, 0, len(path))
    held = follower.follow(follower.home(), rows, 0, len(path), bounded=False)
    np.testing.assert_array_equal(held.q[:, EXTERNAL], rows[:, EXTERNAL])
    assert np.abs(free.q[:, EXTERNAL] - rows[:, EXTERNAL]).max() > 1e-3
    base_T_tool = forward_many(chain_arrays(CELL), held.q)
    np.testing.assert_allclose(base_T_tool, path.base_T_tip, atol=1e-9)


# ---- batches on a device


@pytest.mark.slow
def test_a_scan_in_batches_gives_the_same_plan(engraving) -> None:
    """pytorch-kinematics scores the scan instead of the compiled kernel: the same numbers to float32, and the same plan."""
    score = BatchedKinematics(CELL).arm_inverse_kf
    space = plan_space(CELL)
    grid = np.ascontiguousarray(external_grid(space)[::9])
    frame_ = np.ascontiguousarray(np.asarray(engraving.base_T_tip)[40])
    one, other = scan(space, frame_, grid, 6), scan_batched(space, frame_, grid, 6, score)
    assert np.array_equal(one > 0.0, other > 0.0) and one.max() > 0.5
    assert np.abs(one - other).max() < 2e-7
    compiled, batched = (resolve_planned(CELL, engraving, mode="still", score=s) for s in (None, score))
    assert np.abs(np.asarray(compiled.q) - np.asarray(batched.q)).max() < 1e-6
    assert np.abs(np.asarray(compiled.plan.bound) - np.asarray(batched.plan.bound)).max() < 1e-6


def test_a_gpu_that_is_not_there(tmp_path, capfd) -> None:
    """Asked for and absent: one line, status 2, and nothing is written. (Where there is one, nothing is to be tested here.)"""
    if torch.cuda.is_available():
        pytest.skip("this machine has a GPU")
    sample = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    command = ["post", str(sample), "--cell", str(ROOT / "cells" / "kr15_track_table"), "--out", str(tmp_path / "o")]
    assert cli.run([*command, "--method", "planned", "--device", "cuda"]) == 2
    printed = capfd.readouterr().err
    assert printed.count("\n") == 1 and "no GPU" in printed and not (tmp_path / "o").exists()
