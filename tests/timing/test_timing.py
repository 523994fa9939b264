"""Time of a program by the controller's model: hand calculations, and planted limits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from feed_paths import CELL, path_of, track_path, wave

from camrob.timing.losses import lost_by_axis
from camrob.timing.timing import exact_stops, program_time


def test_a_straight_line_is_a_trapezoid():
    path, q = track_path(np.linspace(0.0, 0.8, 81), feed=0.5)
    timing = program_time(CELL, path, q, speed=np.full(81, 0.5))
    a = 1.5  # the track's acceleration is below $ACC.CP
    assert timing.total == pytest.approx(0.8 / 0.5 + 0.5 / a, rel=1e-9)
    assert timing.speed[[0, -1]].tolist() == [0.0, 0.0]
    assert timing.at[40] == pytest.approx(timing.total / 2, rel=1e-9)


def test_two_points_are_enough_and_short_ways_peak_below_the_feed():
    path, q = track_path(np.array([0.0, 0.01]), feed=0.5)
    assert program_time(CELL, path, q, speed=np.full(2, 0.5)).total == pytest.approx(
        2.0 * np.sqrt(0.01 / 1.5), rel=1e-6
    )


def test_an_axis_at_its_top_speed_is_named():
    path, q = track_path(np.linspace(0.0, 1.4, 1401), feed=1.4)
    timing = program_time(CELL, path, q, speed=np.full(1401, 1.4))
    assert timing.speed.max() == pytest.approx(1.0)  # the track's
    assert timing.total == pytest.approx(1.4 / 1.0 + 1.0 / 1.5, rel=1e-6)
    assert lost_by_axis(timing.losses)["E1"] == pytest.approx((1.4 - 1.0 / 1.5) * (1.0 - 1.0 / 1.4), rel=0.01)
    worst = max((loss for loss in timing.losses if loss.axis), key=lambda loss: loss.lost)
    assert worst.cause == "E1 speed" and worst.feed == 1.4 and worst.first_line > 10


def test_a_corner_is_passed_at_what_its_rounding_allows():
    y = np.concatenate([np.linspace(0.0, 0.1, 11), np.linspace(0.1, 0.0, 11)[1:]])  # turns round on the spot
    path, q = track_path(y, feed=0.2)
    timing = program_time(CELL, path, q, speed=np.full(21, 0.2))
    rounding = 0.0005
    assert timing.speed[10] == pytest.approx(np.sqrt(1.5 * 2 * rounding / 2.0), rel=1e-6)
    assert timing.causes[timing.cause[11]] == "E1 acceleration"


def test_exact_stops_are_where_cutting_begins_and_ends():
    cutting = np.zeros(50, bool)
    cutting[10:30] = True
    path, q = track_path(np.linspace(0.0, 0.5, 50), feed=0.1, cutting=cutting)
    assert np.flatnonzero(exact_stops(path)).tolist() == [0, 9, 29, 49]
    timing = program_time(CELL, path, q, speed=np.full(50, 0.1))
    assert np.all(timing.speed[[9, 29]] == 0.0) and np.all(timing.speed[[5, 20, 40]] > 0.09)


def test_no_point_is_faster_than_its_axes_allow_and_time_only_runs_forward():
    path, q = path_of(wave(), feed=3.0)
    timing = program_time(CELL, path, q, speed=np.full(len(path), 3.0))
    step = np.diff(timing.at)
    assert np.all(step > 0.0)
    limits = CELL.limits_of("speed")
    assert np.all(np.abs(np.diff(q, axis=0)) / step[:, None] <= limits * (1.0 + 1e-9))
    assert timing.losses and all(loss.lost > 0.0 for loss in timing.losses)


def test_repeated_points_and_turns_on_the_spot_take_their_time():
    q = np.tile(CELL.q_home, (4, 1))
    q[2:, CELL.index("A6")] += 0.5
    path, q = path_of(q, feed=0.1)
    still = dataclasses.replace(path, base_T_tip=np.tile(np.asarray(path.base_T_tip[:1]), (4, 1, 1)))
    timing = program_time(CELL, still, q, speed=np.full(4, 0.1))
    assert timing.at[1] == 0.0 and timing.at[3] == timing.at[2] > 0.05


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_speeds_must_be_positive_numbers(value):
    path, q = track_path(np.linspace(0.0, 0.1, 5), feed=0.1)
    with pytest.raises(ValueError, match="positive"):
        program_time(CELL, path, q, speed=np.array([0.1, 0.1, value, 0.1, 0.1]))


def test_two_hundred_thousand_points_are_the_same_trapezoid():
    path, q = track_path(np.linspace(0.0, 0.8, 200_001), feed=0.5)
    timing = program_time(CELL, path, q, speed=np.full(200_001, 0.5))
    assert timing.total == pytest.approx(0.8 / 0.5 + 0.5 / 1.5, rel=1e-9)
