"""Dips of a plan written into a program: within the limits as the controller's model runs it, and on the way that was given."""

from __future__ import annotations

import numpy as np
import pytest
from feed_paths import CELL, path_of, track_path

from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.spherical_wrist import BRANCH_OK, solve_arm_many
from camrob.se3 import pose, slerp
from camrob.timing.as_it_stands import program_as_it_stands
from camrob.timing.dips import written_feed
from camrob.timing.held import held_speeds
from camrob.timing.optimal import optimal_feed
from camrob.timing.timing import program_time

OVER = 1.0 + 1e-6


def corner_path(feed: float = 0.1):
    """Two legs of 40 mm in 2 moves each with a right angle between, on the track and the arm, from HOME."""
    home = base_T_tool(CELL, CELL.q_home[None])[0]
    offset = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.04, 0.0, 0.0], [0.04, 0.02, 0.0], [0.04, 0.04, 0.0]])
    frames = np.tile(home, (5, 1, 1))
    frames[:, :3, 3] += offset - [0.02, 0.02, 0.0]
    q = np.tile(CELL.q_home, (5, 1))
    arm = Arm.of(CELL)
    near = np.ascontiguousarray(q[:, CELL.arm_slice])
    found, why = solve_arm_many(arm.closed, np.ascontiguousarray(arm.foot_T_tool(frames, q)), near)
    off = np.where(why == BRANCH_OK, np.abs(found - near[:, None]).max(axis=2), np.inf)
    q[:, CELL.arm_slice] = found[np.arange(5), np.argmin(off, axis=1)]
    path, q = path_of(q, feed=feed)
    assert np.allclose(path.base_T_tip, frames, atol=1e-9)
    return path, q


def programmed(path, speed):
    return np.where(path.cutting, path.feed, speed)


def judged(path, q, speed):
    timing = program_time(CELL, path, q, speed=speed)
    return timing, program_as_it_stands(CELL, path, q, timing, speed=speed, programmed=programmed(path, speed))


def test_a_sharp_corner_in_long_moves_is_held_with_points_of_its_own():
    path, q = corner_path()
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    before = judged(path, q, plan.speed)[1]
    assert before.past > 0.0 and max(w.times for w in before.worst) > 1.5
    order = written_feed(CELL, path, q, plan)
    timing, after = judged(order.path, order.q, order.speed)
    assert after.past == 0.0 and max(w.times for w in after.worst) <= OVER
    slowed, alone = judged(path, q, held_speeds(CELL, path, q, plan.speed, programmed(path, plan.speed)))
    assert alone.past == 0.0 and timing.total < 0.8 * slowed.total  # without points the whole moves would be slow
    assert 1 <= np.count_nonzero(order.added) <= 12
    assert timing.total < 1.5 * plan.total


def test_added_points_lie_on_the_way_and_the_given_ones_stay():
    path, q = corner_path()
    order = written_feed(CELL, path, q, optimal_feed(CELL, path, q, rapid_speed=0.2))
    own = ~order.added
    assert order.added.any()
    assert np.array_equal(order.path.base_T_tip[own], path.base_T_tip) and np.array_equal(order.q[own], q)
    assert np.array_equal(order.path.source[own], path.source) and np.all(order.path.source[order.added] == -1)
    tip = base_T_tool(CELL, order.q)
    assert np.abs(tip - order.path.base_T_tip).max() < 1e-9
    number = np.cumsum(own) - 1  # of the given point before
    for k in np.flatnonzero(order.added).tolist():
        a, b = path.base_T_tip[number[k]], path.base_T_tip[number[k] + 1]
        way = b[:3, 3] - a[:3, 3]
        share = float((tip[k, :3, 3] - a[:3, 3]) @ way / (way @ way))
        assert 0.0 < share < 1.0
        on_it = pose(slerp(a[:3, :3], b[:3, :3], np.array(share)), a[:3, 3] + share * way)
        assert np.abs(tip[k] - on_it).max() < 1e-9
        assert order.path.line[k] == path.line[number[k] + 1]
    gaps = np.diff(order.path.length)
    assert gaps.min() >= 1e-3 - 1e-9
    values = np.arange(len(path))
    assert np.array_equal(order.spread(values), np.where(own, number, number + 1))


def test_a_feed_that_the_machine_keeps_gets_no_points_and_stays():
    path, q = track_path(np.linspace(0.0, 0.5, 101), feed=0.02)
    order = written_feed(CELL, path, q, optimal_feed(CELL, path, q, rapid_speed=0.2))
    assert not order.added.any() and len(order.path) == len(path)
    assert order.speed[1:] == pytest.approx(0.02, rel=0.03) and order.speed.max() <= 0.02


def test_held_speeds_are_never_above_and_leave_air_alone():
    y = np.concatenate([np.linspace(0.0, 0.1, 11), np.linspace(0.1, 0.0, 11)[1:], np.linspace(0.0, 0.3, 11)[1:]])
    cutting = np.arange(31) <= 20
    path, q = track_path(y, feed=0.2, cutting=cutting)
    speed = np.where(cutting, 0.2, 0.3)
    held = held_speeds(CELL, path, q, speed, speed)
    assert np.all(held <= speed) and np.all(held > 0.0) and np.all(held[~cutting] == 0.3)
    assert held[5] == 0.2 or held[5] > held[10]  # slow at the turn, fast before
    assert judged(path, q, speed)[1].past > judged(path, q, held)[1].past


def test_the_axis_of_added_points_is_on_the_great_arc_where_the_tool_also_turns_about_it():
    q = np.tile(CELL.q_home, (4, 1))
    q[1:, CELL.arm_slice] += [0.05, 0.02, -0.04, 0.1, 0.15, -0.3]
    q[2:, CELL.arm_slice] += [-0.04, 0.01, 0.03, -0.2, -0.1, 0.2]
    q[3:, CELL.arm_slice] += [0.05, 0.02, -0.04, 0.1, 0.15, -0.3]
    path, q = path_of(q, feed=0.3)
    order = written_feed(CELL, path, q, optimal_feed(CELL, path, q, rapid_speed=0.4))
    assert np.count_nonzero(order.added) >= 5
    own = np.cumsum(~order.added) - 1
    beside = []
    for k in np.flatnonzero(order.added).tolist():
        a, b, z = path.base_T_tip[own[k]], path.base_T_tip[own[k] + 1], order.path.base_T_tip[k, :3, 2]
        way = b[:3, 3] - a[:3, 3]
        share = float((order.path.base_T_tip[k, :3, 3] - a[:3, 3]) @ way / (way @ way))
        angle = np.arccos(a[:3, 2] @ b[:3, 2])
        z_meant = (np.sin((1.0 - share) * angle) * a[:3, 2] + np.sin(share * angle) * b[:3, 2]) / np.sin(angle)
        assert np.abs(z - z_meant).max() < 1e-9
        beside.append(slerp(a[:3, :3], b[:3, :3], np.array(share))[:, 2] - z_meant)
    assert np.abs(beside).max() > 1e-3  # orientations on their great arc would have it elsewhere
