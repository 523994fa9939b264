"""Curves as points: within their tolerances, and no more of them than those ask for, however dense the knots are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from camrob.toolpath.apt.bspline import clamped_spline, sample_spline

CHORD, ANGLE = 1e-5, math.radians(5.0)


def _ring(radius, count):
    """Control points and knots of a cubic that runs round a circle to within a nanometre."""
    t = np.linspace(0.0, 1.0, count)
    curve = make_interp_spline(t, radius * np.stack([np.cos(6.0 * t), np.sin(6.0 * t), 0.1 * t], axis=1), k=3)
    return curve.c, curve.t


def _off(points, curve):
    """The greatest distance of the curve from the polyline, each sample held to every piece."""
    start = curve(curve.t[curve.k])
    a = np.vstack([start, points[:-1]])
    d = points - a
    worst = 0.0
    for c in curve(np.linspace(curve.t[curve.k], curve.t[-1 - curve.k], 20_001)):
        share = np.clip(np.sum((c - a) * d, axis=1) / np.sum(d * d, axis=1), 0.0, 1.0)
        worst = max(worst, float(np.linalg.norm(c - a - share[:, None] * d, axis=1).min()))
    return worst


@pytest.mark.parametrize("count", [60, 4000])
def test_as_many_points_as_a_circle_needs(count: int) -> None:
    """The sagitta says how many chords 6 rad of a circle need; 4000 control points need no more than 60 do."""
    curve = clamped_spline(*_ring(0.05, count))
    points = sample_spline(curve, CHORD, ANGLE)
    needed = 6.0 / (2.0 * math.acos(1.0 - CHORD / 0.05))
    assert needed <= len(points) <= 1.25 * needed
    assert _off(points, curve) <= CHORD
    np.testing.assert_array_equal(points[-1], curve.c[-1])


def test_a_corner_stays_and_costs_no_more_than_its_point() -> None:
    """Three control points in one place: the curve goes straight in and straight out, and turns there on the spot."""
    legs = np.linspace(0.0, 1.0, 30)[:, None]
    corner = np.array([0.1, 0.0, 0.0])
    control = np.vstack([legs * corner, corner, corner, corner + legs * [0.0, 0.08, 0.0]])
    points = sample_spline(clamped_spline(control, np.linspace(0.0, 1.0, len(control) - 2)[1:-1]), CHORD, ANGLE)
    assert np.linalg.norm(points - corner, axis=1).min() < CHORD
    assert len(points) < 12


def test_no_chord_turns_by_more_than_the_angle() -> None:
    """Round a circle so small that the angle, not the chord, decides."""
    curve = clamped_spline(*_ring(0.0005, 200))
    points = np.vstack([curve(curve.t[curve.k]), sample_spline(curve, CHORD, ANGLE)])
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    turns = np.arccos(np.clip(np.sum(steps[1:] * steps[:-1], axis=1), -1.0, 1.0))
    assert turns.max() <= ANGLE + 1e-9
    assert len(points) >= 6.0 / ANGLE


@pytest.mark.parametrize("said", [[0.3, 0.7], [0.3, 0.7, 1.0]])
def test_an_end_that_is_said_with_the_inner_knots_is_none_of_them(said: list[float]) -> None:
    """NX's CLSF says the last knot, 1: six points with two inner knots are a cubic, not a curve of the second degree."""
    control = np.array([[0, 0, 0], [5, 10, 0], [15, 12, -2], [20, 0, -1], [26, -3, 0], [30, 4, 1]], float)
    curve, wanted = clamped_spline(control, np.array(said)), BSpline([0, 0, 0, 0, 0.3, 0.7, 1, 1, 1, 1], control, 3)
    assert curve.k == 3
    np.testing.assert_allclose(curve(np.linspace(0, 1, 50)), wanted(np.linspace(0, 1, 50)), atol=1e-12)
