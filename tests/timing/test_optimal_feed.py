"""The fastest feed: bounds on a finer grid, known optima, and toppra beside it."""

from __future__ import annotations

import numpy as np
import pytest
from feed_paths import CELL, path_of, track_path, wave

from camrob.timing.optimal import coarsen, optimal_feed
from camrob.timing.path_spline import MotionBounds, interpolated, smoothed, speed_caps, spline_at
from camrob.timing.profile import fastest_profile, fine_grid, worst_use
from camrob.timing.reachability import fastest_squares


def bounds(axes: int, jerk: float = np.inf, speed: float = 1.0, acceleration: float = 2.0) -> MotionBounds:
    return MotionBounds(np.inf, np.inf, np.inf, np.full(axes, speed), np.full(axes, acceleration), np.full(axes, jerk))


def curve(count: int, axes: int = 6) -> tuple[np.ndarray, np.ndarray]:
    s = np.linspace(0.0, 1.0, count + 1)
    q = np.column_stack([0.5 * np.sin((3 + k) * s + k) + 0.2 * np.cos(7 * s * (k + 1)) for k in range(axes)])
    return s, q


def line(count: int, length: float) -> np.ndarray:
    values = np.zeros((count + 1, 7))
    values[:, 6] = np.linspace(0.0, length, count + 1)
    return interpolated(values, length / count)


def test_toppra_agrees_where_speed_and_acceleration_bind():
    import toppra

    count = 1000
    s, q = curve(count)
    control = interpolated(np.hstack([np.zeros((count + 1, 6)), q]), 1.0 / count)
    b = bounds(6)
    caps = speed_caps(control, 1.0 / count, np.full(count, 10.0), b)
    v = np.sqrt(fastest_squares(control, 1.0 / count, caps, b, 0.0, 0.0))
    ours = float(np.sum(2.0 / count / (v[1:] + v[:-1])))
    toppra.setup_logging("ERROR")
    limits = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-b.speed, b.speed])),
        toppra.constraint.JointAccelerationConstraint(np.column_stack([-b.acceleration, b.acceleration])),
    ]
    path = toppra.SplineInterpolator(s, q)
    instance = toppra.algorithm.TOPPRA(limits, path, gridpoints=s, parametrizer="ParametrizeConstAccel")
    assert ours == pytest.approx(instance.compute_trajectory(0, 0).duration, rel=0.01)


def test_bang_bang_on_a_line():
    control = line(200, 0.5)
    b = bounds(1)
    v = np.sqrt(fastest_squares(control, 0.0025, speed_caps(control, 0.0025, np.full(200, 9.0), b), b, 0.0, 0.0))
    assert v.max() == pytest.approx(1.0, rel=1e-6)  # 0.5 m at 2 m/s2: just reached in the middle
    assert np.sum(0.005 / (v[1:] + v[:-1])) == pytest.approx(1.0, rel=1e-3)


def test_seven_phases_on_a_line():
    """From rest to rest over 1 m with v 1, a 2, j 20: 1 + 1/2 + 2/20 s, the textbook's S-curve."""
    control = line(1000, 1.0)
    profile = fastest_profile(control, 0.001, np.full(1000, 9.0), bounds(1, jerk=20.0))
    assert fine_grid(profile, 4).at[-1] == pytest.approx(1.0 / 1.0 + 1.0 / 2.0 + 2.0 / 20.0, rel=5e-3)


@pytest.mark.parametrize("jerk", [5.0, 20.0, 200.0])
def test_no_limit_is_broken_on_a_ten_times_finer_grid(jerk):
    """Checked here in plain NumPy from the spline's values alone, by numeric differentiation over time."""
    count = 300
    _s, q = curve(count)
    values = np.hstack([np.zeros((count + 1, 6)), q])
    b = bounds(6, jerk=jerk)
    control = interpolated(values, 1.0 / count)
    profile = fastest_profile(control, 1.0 / count, np.full(count, 10.0), b)
    use = worst_use(control, profile, b, np.full(count, 10.0), 10)[0]
    assert use.max() <= 1.0 + 1e-9
    assert use.max() > 0.99
    grid = fine_grid(profile, 10)
    out, fine = np.empty(12), np.empty((len(grid.s), 6))
    for f in range(len(grid.s)):
        i = min(f // 10, count - 1)
        spline_at(control, 1.0 / count, i, f / 10 - i, 0, out)
        fine[f] = out[6:]
    middle = slice(30, -30)
    t = grid.at
    speed = np.diff(fine, axis=0) / np.diff(t)[:, None]
    centre = 0.5 * (t[1:] + t[:-1])
    acceleration = np.diff(speed, axis=0) / np.diff(centre)[:, None]
    twitch = np.diff(acceleration, axis=0) / np.diff(0.5 * (centre[1:] + centre[:-1]))[:, None]
    assert np.abs(speed[middle]).max() <= 1.0 * 1.001
    assert np.abs(acceleration[middle]).max() <= 2.0 * 1.005
    assert np.abs(twitch[middle]).max() <= jerk * 1.05


def test_a_planted_violation_is_seen():
    control = line(100, 0.2)
    b = bounds(1, jerk=20.0)
    profile = fastest_profile(control, 0.002, np.full(100, 9.0), b)
    tight = b._replace(jerk=b.jerk * 0.5)
    assert worst_use(control, profile, tight, np.full(100, 9.0), 10)[0][:, 2].max() > 1.9


def test_the_plan_keeps_the_feed_where_the_machine_can():
    path, q = track_path(np.linspace(0.0, 0.5, 1001), feed=0.1)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert plan.planned[200:800] == pytest.approx(0.1, rel=2e-3)
    assert plan.speed[1:] == pytest.approx(0.1, rel=0.021) and plan.speed[1:].max() <= 0.1
    assert plan.changes <= 4
    assert max(plan.use.values()) <= 1.0 + 1e-9
    assert 5.0 < plan.total < 5.3


def test_a_winding_path_is_slowed_by_its_axes_and_they_are_named():
    path, q = path_of(wave(800), feed=2.0)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert max(plan.use.values()) <= 1.0 + 1e-9
    assert plan.unjerked < plan.cutting
    assert set(plan.lost_by_axis) - {""} <= set(CELL.names) and plan.lost_by_axis
    assert plan.deviation < 1.8e-4  # what a right angle rounded within 0.5 mm is left by
    assert np.all(plan.speed[1:] <= 2.0) and np.all(plan.speed > 0.0)


def test_moves_through_air_keep_their_speed():
    cutting = np.zeros(300, bool)
    cutting[100:200] = True
    path, q = track_path(np.linspace(0.0, 0.3, 300), feed=0.05, cutting=cutting)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert np.all(plan.speed[~cutting] == 0.2)
    assert plan.planned[[99, 199]] == pytest.approx(0.0, abs=1e-12)
    assert plan.cutting == pytest.approx(0.1 / 0.05, rel=0.1)


def test_coarsened_speeds_are_never_above_and_change_rarely():
    rng = np.random.default_rng(4)
    speed = 0.1 * (1.0 + 0.3 * np.sin(np.linspace(0.0, 20.0, 2000))) * (1.0 + 0.005 * rng.random(2000))
    coarse = coarsen(speed, 0.02)
    assert np.all(coarse <= speed) and np.all(coarse >= speed * 0.98 - 1e-5)
    assert np.count_nonzero(np.diff(coarse)) < 250
    assert np.count_nonzero(np.diff(coarsen(np.full(50, 0.1), 0.02))) == 0


def test_smoothing_takes_noise_out_and_keeps_corners_within_tolerance():
    rng = np.random.default_rng(2)
    count = 2000
    s = np.linspace(0.0, 1.0, count + 1)
    values = np.zeros((count + 1, 7))
    values[:, 0] = np.where(s < 0.5, s, 0.5)
    values[:, 1] = np.where(s < 0.5, 0.0, s - 0.5)
    values[:, 6] = 0.3 * np.sin(3.0 * s)
    noisy = values + np.column_stack([np.zeros((count + 1, 6)), 1e-7 * rng.standard_normal(count + 1)])
    control, deviation = smoothed(s, noisy, count, 0.02, np.array([5e-5, 1e-3]))
    assert deviation[:, 0].max() <= 1.2 * 5e-5 and deviation[:, 0].max() > 1e-5
    third = np.diff(control[:, 6], 3) * count**3
    raw = np.diff(noisy[:, 6], 3) * count**3
    away = np.abs(s[:-1] - 0.5) > 0.05
    assert np.abs(third[away]).max() < 15.0 < 100.0 < np.abs(raw[away[1:-1]]).max()
    assert np.allclose((control[0] + 4 * control[1] + control[2]) / 6, noisy[0], atol=1e-9)


@pytest.mark.parametrize("length", [1e-6, 1e-4, 0.003])
def test_a_tiny_cut_is_planned(length):
    path, q = track_path(np.array([0.0, length]), feed=0.1)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert 0.0 < plan.total < 1.0 and max(plan.use.values()) <= 1.0 + 1e-9


def test_a_turn_on_the_spot_within_a_cut_is_planned():
    q = np.tile(CELL.q_home, (60, 1))
    q[:20, CELL.index("E1")] = np.linspace(0.0, 0.02, 20)
    q[20:40, CELL.index("E1")] = 0.02
    q[20:, CELL.index("A6")] += np.concatenate([np.linspace(0.0, 0.2, 20), np.full(20, 0.2)])
    q[40:, CELL.index("E1")] = np.linspace(0.02, 0.04, 20)
    path, q = path_of(q, feed=0.1)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert np.all(np.isfinite(plan.at)) and np.all(np.diff(plan.at) >= 0.0)
    assert max(plan.use.values()) <= 1.0 + 1e-9


def test_a_slow_plunge_takes_no_longer_than_its_feed_and_ramps():
    """9 mm at 5 mm/s: a ramp of one long span from rest would cost a fifth of a second at each end."""
    path, q = track_path(np.array([0.0, 0.009]), feed=0.005)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert 1.8 < plan.total < 1.9 and max(plan.use.values()) <= 1.0 + 1e-9


def test_a_loss_is_laid_to_what_binds_and_not_to_the_feed():
    y = np.concatenate([np.linspace(0.0, 0.1, 11), np.linspace(0.1, 0.0, 11)[1:]])  # turns round on the spot
    path, q = track_path(y, feed=0.2)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    at_turn = [loss for loss in plan.losses if loss.start <= 10 < loss.stop]
    assert [loss.cause for loss in at_turn] == ["E1 jerk"]
    assert sum(loss.lost for loss in plan.losses if loss.axis == "E1") > 0.9 * sum(loss.lost for loss in plan.losses)


def test_a_constant_feed_that_is_feasible_is_the_optimum_to_a_millionth():
    """With moving ends nothing is faster than the feed itself; the profile must not be slower by more than 1e-6."""
    count = 300
    _s, q = curve(count)
    control = interpolated(np.hstack([np.zeros((count + 1, 6)), q]), 1.0 / count)
    feed = np.full(count, 0.05)
    profile = fastest_profile(control, 1.0 / count, feed, bounds(6, jerk=20.0), start=False, end=False)
    assert 0.0 <= fine_grid(profile, 10).at[-1] / (1.0 / 0.05) - 1.0 < 1e-6
