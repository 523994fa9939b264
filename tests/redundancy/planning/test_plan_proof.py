"""The bound of a whole plan's price: planes, steps and nodes are nowhere dearer than postures, moves and plans; planted cases."""

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.kinematics.arm import reach
from camrob.redundancy.clock import Clock
from camrob.redundancy.free_frames import rotation_minimising
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.course import moves_along, waypoint_weights
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work, pose_in_foot
from camrob.redundancy.planning.objective import MotionPrice, Objective, motion_price, plan_prices, plan_weights
from camrob.redundancy.planning.waypoints import waypoints
from camrob.se3 import pose
from camrob.toolpath.region import Move

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from camrob.redundancy.proving.arm_shape import arm_shape
from camrob.redundancy.proving.bin_prices import corner_prices, planes_of_bins
from camrob.redundancy.proving.motion_steps import step_prices
from camrob.redundancy.proving.relaxed import cheapest_through
from camrob.redundancy.proving.seen_bins import bins_of
from camrob.redundancy.proving.seen_from_arm import Lattice, seen_of_cells
from camrob.redundancy.proving.statement import statement_of
from camrob.redundancy.proving.whole_plan import prove_plan

pytestmark = pytest.mark.slow  # its kernels compile for a minute, and no program rests on them yet
CELL = read_cell(Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table")
SPACE, UP = plan_space(CELL), np.array([0.0, 0.0, 1.0])


def poses(count, rng):
    """Poses over the table, tilted by up to 0.6 rad."""
    axes = UP + 0.35 * rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    tips = rng.uniform([-0.15, -0.15, 0.1], [0.15, 0.15, 0.3], (count, 3))
    return pose(rotation_minimising(axes, np.array([1.0, 0.0, 0.0])), tips)


def dearest_first(T, u):
    """1/k_F of the best posture of a pose at freedoms u, 0 where none keeps the limits; and that posture."""
    work, best, own = plan_work(), 0.0, None
    pose_in_foot(SPACE, T, u, work)
    reach(SPACE.arm, SPACE.screws, work.Rt, work.pt, SPACE.center, work.Q, work.why)
    for b in np.flatnonzero(work.why == 0):
        q = work.Q[b].copy()
        if np.all(q >= SPACE.lower) and np.all(q <= SPACE.upper):
            value = conditioning(SPACE, q, plan_work())
            if value > best:
                best, own = value, q
    return best, own


@pytest.mark.parametrize("half", [(0.2, 0.04), (0.05, 0.01)])
def test_no_posture_in_a_cell_is_cheaper_than_what_is_linear_between_the_prices_at_its_corners(half):
    rng = np.random.default_rng(3)
    T = poses(60, rng)
    shape = arm_shape(CELL, UP)
    lattice = Lattice(np.array([-np.pi, -1.5]), 2.0 * np.array(half), np.array(half) * (1.0 + 1e-12) + 1e-12)
    where = np.stack([rng.integers(0, int(np.pi / half[0]), 60), rng.integers(0, int(1.5 / half[1]), 60)], axis=1)
    seen = seen_of_cells(shape, T[:, :3, 3].copy(), T[:, :3, 2].copy(), lattice, np.arange(60), where)
    bins = bins_of(seen, 0.05)
    offset, planes = planes_of_bins(shape, 4.0, 0.5, bins.frame, bins.box, np.full(len(bins.frame), 0.3), 0.03, 20)
    most = np.full(60, (0.5 / 0.3) ** 4)
    corner = corner_prices(seen, bins.own, bins.frame, bins.box, offset, planes, most)
    least, met, caught = np.inf, 0, 0
    for k, T_k in enumerate(T):
        for _ in range(60):
            share = np.where(rng.random(2) < 0.3, rng.integers(0, 2, 2), rng.random(2))
            u = np.append(lattice.low + (where[k] + share) * lattice.step, rng.uniform(-np.pi, np.pi))
            value, _q = dearest_first(T_k, u)
            if value > 0.0:
                a, b = share
                below = (1 - a) * (1 - b) * corner[k, 0] + (1 - a) * b * corner[k, 1] + a * (1 - b) * corner[k, 2]
                below += a * b * corner[k, 3]
                # on either triangle, too
                one = corner[k, 0] + (b * (corner[k, 1] - corner[k, 0]) + a * (corner[k, 3] - corner[k, 1]))
                two = corner[k, 0] + (a * (corner[k, 2] - corner[k, 0]) + b * (corner[k, 3] - corner[k, 2]))
                price = min((0.5 / value) ** 4, most[k])
                assert price >= max(below, one if b >= a else two) - 1e-12
                least, met = min(least, price - below), met + 1
                caught += price < 1.1 * below - 1e-12  # as it would be, were a plane a tenth too high
    assert met > 500
    if half[0] < 0.1:
        assert least < 0.02  # they are not merely low
        assert caught > 0


def test_a_bin_in_which_everything_counts_keeps_to_its_room():
    """Pieces of 0.3 degrees and no posture passed over: all 512 planes are used, and none is written beyond them."""
    shape, box = arm_shape(CELL, UP), np.zeros((1, 2, 5))
    box[0, :, 3], box[0, :, 4], box[0, 1, :2] = (1.4, 0.1), (0.3, 0.1), 0.1
    offset, planes = planes_of_bins(shape, 4.0, 0.5, np.eye(3)[None].copy(), box, np.full(1, 0.01), 0.005, 0)
    assert 480 < offset[1] <= 512 and len(planes) == offset[1]


def test_steps_are_nowhere_dearer_than_the_move_and_near_it():
    rng = np.random.default_rng(5)
    W = 200
    rate, square, haste = rng.uniform(0, 0.1, (W, 1)), rng.uniform(0, 0.1, (W, 1)), rng.uniform(0, 0.1, W)
    top = rng.uniform(0.01, 1.0, (W, 1))
    for h in (0.003, 0.03, 0.3):
        sums = np.hstack(
            [np.zeros((W, 1)), np.cumsum(step_prices(MotionPrice(rate, square, top, haste), 0, h, 8), axis=1)]
        )
        assert np.all(np.diff(sums, 2, axis=1) >= -1e-15)
        d = rng.uniform(0.0, 8.0, (W, 300))
        n = np.minimum(d.astype(int), 7)
        rows = np.arange(W)[:, None]
        line = sums[rows, n] + (d - n) * (sums[rows, n + 1] - sums[rows, n])
        x = d * h
        price = rate * x + square * x * x + haste[:, None] * np.maximum(x / top - 1.0, 0.0) ** 2
        assert np.all(line <= price + 1e-15)
        assert np.all(line >= (1.0 - 1e-8) * rate * x)
        if h == 0.003:
            assert np.all(line >= price - (square + haste[:, None] / top**2) * h * h)  # a square of a step at most


def test_the_cheapest_way_is_that_of_all_ways_and_what_leads_through_each_cell_is_no_dearer():
    rng = np.random.default_rng(7)
    nodes, endless, W = np.array([3, 3]), np.array([True, False]), 3
    for _ in range(5):
        where = np.array(list(product(range(3), range(2))) * W)
        offset, corner = np.arange(W + 1) * 6, rng.uniform(0.1, 2.0, (6 * W, 4))
        most, weight = rng.uniform(0.8, 2.0, W), rng.uniform(0.2, 1.0, W)
        steps = np.sort(rng.uniform(0.0, 0.5, (W, 2, 3)), axis=2)
        leap = np.array([np.inf, rng.uniform(0.0, 0.4), np.inf])
        got, through = cheapest_through(nodes, endless, most, offset, where, corner, weight, steps, leap)
        price = np.tile(most[:, None, None], (1, 3, 3))
        for e, (i, j) in enumerate(where):
            for c in range(4):
                at = (e // 6, (i + c // 2) % 3, j + c % 2)
                price[at] = min(price[at], corner[e, c])
        best, best_through = np.inf, np.full(len(where), np.inf)
        every = list(product(range(3), range(3)))
        for a, b, b2, c in product(every, repeat=4):
            total = weight[0] * price[0][a] + weight[2] * price[2][c]
            total += 0.5 * weight[1] * (price[1][b] + price[1][b2]) + (leap[1] if b != b2 else 0.0)
            for k, (one, other) in ((1, (a, b)), (2, (b2, c))):
                for axis in range(2):
                    d = abs(one[axis] - other[axis])
                    d = min(d, 3 - d) if axis == 0 else d
                    total += steps[k, axis, :d].sum()
            best = min(best, total)
            for e, (i, j) in enumerate(where):
                beside = [((i + s) % 3, j + t) for s in range(2) for t in range(2)]
                if {0: a in beside, 1: b in beside or b2 in beside, 2: c in beside}[e // 6]:
                    best_through[e] = min(best_through[e], total)
        assert got == pytest.approx(best, rel=1e-12)
        assert through == pytest.approx(best_through, rel=1e-12)


def short_path():
    tips = np.array([[0.10, 0.0, 0.1], [0.12, 0.0, 0.1], [0.14, 0.005, 0.1], [0.16, 0.02, 0.1]])
    R = rotation_minimising(np.tile(UP, (4, 1)), np.array([1.0, 0.0, 0.0]))
    return ToolPathInBase(
        pose(R, tips),
        np.full(4, int(Move.CUT), np.int8),
        np.full(4, 0.02),
        np.arange(1, 5),
        np.zeros(4, np.int32),
        np.arange(4),
        np.zeros(4, bool),
    )


def test_no_plan_of_a_short_path_is_below_its_bound_and_the_best_of_many_is_near_it():
    w = waypoints(short_path(), 0.02)
    objective = Objective.of(CELL, SPACE, plan_weights(CELL))
    moves, weight = moves_along(w, np.arange(len(w))), waypoint_weights(w)
    motion = motion_price(objective, moves, "travel", "smoothness", "speed")
    proof = prove_plan(CELL, objective, statement_of(SPACE, objective, w, np.full(len(w), 0.8)), 10.0, levels=4)
    assert [level.bound for level in proof.levels] == sorted(level.bound for level in proof.levels)
    dear = statement_of(SPACE, objective, w, np.full(len(w), 0.2))
    blind = prove_plan(CELL, objective, dear, 10.0, levels=2)  # postures are all passed over
    assert blind.bound <= 0.2 * weight.sum() < proof.bound
    rng, best, joined = np.random.default_rng(11), np.inf, np.ones(len(w), bool)
    good = None
    for trial in range(4000):
        if good is None or trial < 1500:
            u0 = np.array([rng.uniform(-np.pi, np.pi), rng.uniform(-0.6, 0.6), rng.uniform(-np.pi, np.pi)])
            u = u0 + np.cumsum(rng.normal(size=(len(w), 3)) * 10.0 ** rng.uniform(-4, -1), axis=0)
        else:
            u = (
                good
                + rng.normal(size=3) * 10.0 ** rng.uniform(-4, -1.3)
                + rng.normal(size=(len(w), 3)) * 10.0 ** rng.uniform(-5, -2)
            )
        found = [dearest_first(np.ascontiguousarray(T), v) for T, v in zip(w.base_T_tip, u, strict=True)]
        if min(value for value, _q in found) <= 0.0:
            continue
        q = np.array([q for _value, q in found])
        price = sum(
            plan_prices(SPACE, objective, u, q, weight, np.zeros((0, 7)), moves, joined)[name]
            for name in ("conditioning", "travel", "smoothness", "speed")
        )
        price -= motion.paid(u * [0, 0, 1], 0 * q, joined)  # the roll's part is left out of the bound
        assert price >= proof.bound
        if price < best:
            best, good = price, u
    assert proof.bound > 0.93 * best
    assert proof.gap(best) == pytest.approx(1.0 - proof.bound / best)


def test_what_there_is_no_time_for_counts_for_the_least_that_any_posture_costs():
    w = waypoints(short_path(), 0.02)
    objective = Objective.of(CELL, SPACE, plan_weights(CELL))
    stated = statement_of(SPACE, objective, w, np.full(len(w), 0.8))
    told = []
    proof = prove_plan(CELL, objective, stated, 10.0, clock=Clock(0.0), told=told)
    assert len(proof.levels) == 1
    assert proof.bound == pytest.approx(objective.conditioning * 0.5**4 * waypoint_weights(w).sum(), rel=1e-6)
    assert len(told) == 1
    halves = [
        prove_plan(CELL, objective, stated.between(*ends), 10.0, levels=3).bound for ends in ((0, 2), (2, len(w)))
    ]
    assert sum(halves) == pytest.approx(prove_plan(CELL, objective, stated, 10.0, levels=3).bound, rel=0.02)
