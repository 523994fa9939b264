"""Rows that repeat one another know no more than one of them: the temperature, and what is as sure with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cells import log_of, ur10
from test_gap_evidence import two_alike

from camrob.gap.evidence.model import doubt_of
from camrob.gap.evidence.neighbourhoods import neighbours_in_row
from camrob.gap.evidence.temperature import independent_share
from camrob.gap.observation.scene import make_scene


@pytest.mark.parametrize("count", [40, 300, 3000, 12000])
def test_independent_rows_are_all_independent(count: int) -> None:
    for seed in range(5):
        assert independent_share(np.random.default_rng(seed).normal(size=(count, 3))) > 0.85


@pytest.mark.parametrize("times", [2, 8, 40])
def test_rows_that_are_there_several_times_count_once(times: int) -> None:
    rows = np.random.default_rng(1).normal(size=(600, 3))
    assert independent_share(np.repeat(rows, times, axis=0)) == pytest.approx(1.0 / times, rel=0.35)


def test_a_rest_that_decays_from_row_to_row_counts_as_long_as_its_covariance_says() -> None:
    """An autoregressive rest: the variance of its mean is (1 + r) / (1 - r) times that of independent rows."""
    r, rng = 0.8, np.random.default_rng(2)
    rest = rng.normal(size=(20000, 3))
    for k in range(1, len(rest)):
        rest[k] = r * rest[k - 1] + np.sqrt(1.0 - r * r) * rest[k]
    assert independent_share(rest) == pytest.approx((1.0 - r) / (1.0 + r), rel=0.35)


@pytest.mark.parametrize("times", [3.0, 50.0])
def test_the_same_rows_many_times_say_what_they_say_once(times: float) -> None:
    once = two_alike(0.9, (0.6, 0.5))
    d = once.design
    many = replace(once, design=replace(d, A=times * d.A, b=times * d.b, yy=times * d.yy, rows=times * d.rows))
    weighed = replace(many, temperature=times)
    both = frozenset({0, 1})
    a, b, cold = (e.fit(both) for e in (once, weighed, many))
    # the whole of the fit, not its likelihood alone: a free parameter costs what it costs beside so many independent rows
    assert b.score == pytest.approx(a.score, rel=1e-9)
    assert np.allclose(b.mean, a.mean, rtol=1e-9)
    assert np.allclose(b.cov, a.cov, rtol=1e-9)
    assert np.diag(cold.cov).sum() < 0.5 * np.diag(a.cov).sum()


def test_poses_stand_in_the_order_of_their_postures_whatever_order_they_were_taken_in() -> None:
    rng = np.random.default_rng(3)
    axis = np.deg2rad([20, -90, 60, -60, -90, 10.0]) + rng.uniform(-1, 1, (400, 6)) * np.deg2rad([60, 30, 2, 2, 2, 2])
    scene = make_scene(log_of(ur10(), np.arange(400.0), axis, {}, poses=True), ur10())
    order = neighbours_in_row(scene)
    assert np.array_equal(np.sort(order), np.arange(400))
    step = np.linalg.norm(np.diff(axis[order], axis=0), axis=1)
    assert np.median(step) < 0.35 * np.median(np.linalg.norm(np.diff(axis, axis=0), axis=1))


def test_the_description_of_an_effect_is_late_on_a_path_and_never_at_single_poses() -> None:
    part, share = np.random.default_rng(4).normal(size=(50, 3)), np.full((50, 1), 0.01)
    assert np.allclose(doubt_of(part, share, poses=True), (0.01 * part) ** 2)
    assert np.all(doubt_of(part, share, poses=False) >= doubt_of(part, share, poses=True))
    shuffled = np.random.default_rng(5).permutation(50)
    assert np.allclose(doubt_of(part[shuffled], share, poses=True), doubt_of(part, share, poses=True)[shuffled])
