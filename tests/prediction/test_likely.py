"""How large errors are likely to be, held to what normal distributions have in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from camrob.gap.unexplained import SIZE_DOUBT
from camrob.prediction.band import band_within
from camrob.prediction.likely import likely_distances, likely_sizes

UP = np.tile([0.0, 0.0, 1.0], (5000, 1))
NONE, NOTHING = np.zeros((5000, 0)), np.zeros(5000)
MANY = {"rel": 0.12}  # 400 machines know a percentile of theirs no better


def of_a_field(p: np.ndarray) -> np.ndarray:
    """What a normal variable whose size is lognormal stays below, by its distribution summed over sizes."""
    x, size = np.linspace(0.0, 9.0, 9001), np.exp(SIZE_DOUBT * norm.ppf((np.arange(400) + 0.5) / 400))
    return np.interp(p, norm.cdf(x[:, None] / size).mean(axis=1), x)


@pytest.mark.parametrize(("share", "wide"), [(0.0, norm.ppf(0.975)), (1.0, of_a_field(np.array([0.975]))[0])])
def test_a_size_in_doubt_widens_the_band(share: float, wide: float) -> None:
    variance = np.array([4e-10, 0.0])
    assert band_within(variance, share * variance) == pytest.approx([2e-5 * wide, 0.0], rel=2e-3)


def test_a_band_of_two_parts_holds_what_it_says() -> None:
    """Half of the variance of a sure size, half of one that is drawn."""
    rng = np.random.default_rng(3)
    drawn = rng.normal(size=200_000) + np.exp(SIZE_DOUBT * rng.normal(size=200_000)) * rng.normal(size=200_000)
    assert np.mean(np.abs(drawn) < band_within(np.full(1, 2.0), np.ones(1))) == pytest.approx(0.95, abs=2e-3)


def test_without_doubt_it_is_what_is_expected() -> None:
    expected = np.linspace(-1e-4, 3e-4, 5000)
    got = likely_sizes(expected, UP, NONE, NONE, NOTHING)
    assert got.rms == pytest.approx(np.full(3, np.sqrt(np.mean(expected**2))))
    assert got.p95 == pytest.approx(np.full(3, np.quantile(np.abs(expected), 0.95)))


@pytest.mark.parametrize("field", [False, True])
def test_one_thing_that_moves_all_of_the_part_is_another_on_each_machine(field: bool) -> None:
    """|z| of a standard normal z: its median is 0.674, and 97.5 % lie below 2.24."""
    load = np.full((5000, 1), 2e-5)
    got = likely_sizes(NOTHING, UP, NONE if field else load, load if field else NONE, NOTHING)
    low, middle, high = 2e-5 * (of_a_field if field else norm.ppf)(0.5 + 0.5 * np.array([0.025, 0.5, 0.975]))
    assert got.p95 == pytest.approx(got.rms)
    assert got.p95[1:] == pytest.approx([middle, high], **MANY) and got.p95[0] == pytest.approx(low, abs=1e-6)


def test_what_is_another_at_each_point_is_alike_on_all_machines() -> None:
    got = likely_sizes(NOTHING, UP, NONE, NONE, np.full(5000, 2e-5))
    assert got.rms == pytest.approx(np.full(3, 2e-5), rel=0.03)
    assert got.p95 == pytest.approx(np.full(3, 2e-5 * norm.ppf(0.975)), rel=0.04)


def test_doubt_makes_a_part_worse_than_what_is_expected_of_it() -> None:
    """One thing of 4e-5 beside 3e-5 that is expected: median of |3 + 4 z|, by the folded normal distribution."""
    got = likely_sizes(np.full(5000, 3e-5), UP, np.full((5000, 1), 4e-5), NONE, NOTHING)
    x = np.linspace(0.0, 2e-4, 20001)
    below = norm.cdf((x - 3e-5) / 4e-5) - norm.cdf((-x - 3e-5) / 4e-5)
    assert got.p95[1] == pytest.approx(float(np.interp(0.5, below, x)), **MANY) and got.p95[1] > 3.3e-5


def test_a_field_acts_along_the_normal_alone() -> None:
    """A wall and a floor that one smooth field moves: two directions, independent of each other."""
    normals = np.concatenate([UP[:2500], np.tile([1.0, 0.0, 0.0], (2500, 1))])
    got = likely_sizes(NOTHING, normals, NONE, np.full((5000, 1), 1e-5), NOTHING)
    rms = 1e-5 * np.sqrt(np.log(2.0))  # median of a chi-square of two degrees is 2 ln 2; a size's median is 1
    assert got.rms[1] == pytest.approx(rms, **MANY)


def test_what_lies_along_the_way_counts_nothing_and_all_else_by_formula() -> None:
    """One sure thing aside, one along it; what is another at each place is Rayleigh's; a field alike everywhere, too."""
    P, way = 4000, np.tile([0.6, 0.0, 0.8], (4000, 1))
    aside, none = np.cross(way, [0.0, 1.0, 0.0]), np.zeros((P, 3, 0))
    zero, still, no_field = np.zeros((P, 3)), np.zeros(P), np.zeros((P, 0))
    assert np.allclose(likely_distances(0.2 * aside, way, none, no_field, still).p95, 0.2)
    assert np.allclose(likely_distances(0.2 * way, way, 0.1 * way[:, :, None], no_field, still).rms, 0.0)
    assert likely_distances(zero, way, 0.1 * aside[:, :, None], no_field, still).p95[1] == pytest.approx(
        0.0674, rel=0.1
    )
    apart = likely_distances(zero, way, none, no_field, np.full(P, 0.1))
    assert apart.rms[1] == pytest.approx(0.1 * np.sqrt(2.0), rel=0.02)
    assert apart.p95[1] == pytest.approx(0.1 * np.sqrt(-2.0 * np.log(0.05)), rel=0.02)
    field = likely_distances(zero, way, none, np.full((P, 1), 0.1), still)
    assert field.p95[1] == pytest.approx(0.1 * np.sqrt(2.0 * np.log(2.0)), rel=0.1)
    assert not np.any(likely_distances(zero[:0], way[:0], none[:0], no_field[:0], still[:0]).p95)
