"""The compiled arithmetic of one set, held to the same in plain NumPy; and what an exploration tells of the sets that it met."""

from __future__ import annotations

import numpy as np
import pytest
from test_gap_evidence import dense_design

from camrob.gap.evidence.evidence import Evidence
from camrob.gap.evidence.posteriors.set_posterior import effects_moves, fitted_widths, let_loose
from camrob.gap.evidence.scan import _gain, _gains
from camrob.gap.evidence.search import explore
from camrob.gap.evidence.temperature import _LAGS, _lagged

EFFECT = np.array([-1, 0, 0, 1, 1, 1, 2, 3], np.int64)  # by parameter
LEAST = np.array([0.05, 0.3, np.nan, 0.1])  # by effect
OWN = np.array([0, 1, 2, 3, 4, 5, 6], np.int64)  # all but the last effect


def case() -> dict[str, np.ndarray]:
    """Parameters of four effects and of one that is always in, some of them nearly alike, beside a gap that two of them made."""
    rng = np.random.default_rng(3)
    X = rng.normal(size=(60, 8)) @ (np.eye(8) + 0.3 * rng.normal(size=(8, 8)))
    y = X[:, :3] @ np.array([0.8, -0.5, 0.7]) + 0.3 * rng.normal(size=60)
    scale, usual = np.full(8, 0.02), rng.uniform(0.2, 2.0, 8)
    precision = np.outer(scale, scale) * (X.T @ X) + np.eye(8)
    base = np.linalg.inv(precision)
    return {"X": X, "y": y, "scale": scale, "usual": usual, "base": base, "start": base @ (scale * (X.T @ y))}


def plain_posterior(c: dict[str, np.ndarray], widths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) mean and (K, K) covariance with priors of some widths, from all rows."""
    cov = np.linalg.inv(c["X"].T @ c["X"] + np.diag(widths**-2.0))
    return cov @ (c["X"].T @ c["y"]), cov


def plain_widths(c: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """What `fitted_widths` gives, each turn with the whole posterior."""
    widths, shares = c["scale"].copy(), np.full(4, np.nan)
    widths[OWN] = c["usual"][OWN]
    for _ in range(2):
        mean, cov = plain_posterior(c, widths)
        for number in (0, 1):
            own = EFFECT == number
            known = max(np.sum(1.0 - np.diag(cov)[own] / widths[own] ** 2), 0.3)
            share = np.sqrt(np.sum((mean[own] / c["usual"][own]) ** 2) / known)
            shares[number] = np.clip(share, LEAST[number], 5.0)
            widths[own] = np.maximum(shares[number] * c["usual"][own], c["scale"][own])
    return widths, shares


def test_widths_are_those_of_plain_numpy() -> None:
    c = case()
    widths, shares = fitted_widths(c["base"], c["start"], c["scale"], c["usual"], EFFECT, LEAST, OWN)
    expected, by_effect = plain_widths(c)
    np.testing.assert_allclose(widths, expected, rtol=1e-9)
    np.testing.assert_allclose(shares, by_effect, rtol=1e-9)
    assert widths[7] == c["scale"][7]
    unnamed, none = fitted_widths(c["base"], c["start"], c["scale"], c["usual"], EFFECT, LEAST, OWN[6:])
    assert unnamed[6] == c["usual"][6]
    assert np.isnan(none).all()


def test_a_set_let_loose_is_the_posterior_of_plain_numpy() -> None:
    c = case()
    widths = plain_widths(c)[0]
    mean, R, better, cost = let_loose(c["base"], c["start"], c["scale"], OWN, widths)
    expected, cov = plain_posterior(c, widths)
    np.testing.assert_allclose(mean, expected, rtol=1e-8)
    found = (c["base"] + R.T @ R) * np.outer(c["scale"], c["scale"])
    np.testing.assert_allclose(found, cov, rtol=1e-7, atol=1e-12)
    rows = [np.eye(60) + (c["X"] * w**2) @ c["X"].T for w in (c["scale"], widths)]
    fits = [-0.5 * c["y"] @ np.linalg.solve(r, c["y"]) for r in rows]
    halves = [0.5 * np.linalg.slogdet(r)[1] for r in rows]
    assert better == pytest.approx(fits[1] - fits[0], rel=1e-8)
    assert cost == pytest.approx(halves[1] - halves[0], rel=1e-8)
    none = let_loose(c["base"], c["start"], c["scale"], OWN[:0], c["scale"])
    np.testing.assert_allclose(none[0], c["start"] * c["scale"])
    assert none[1].shape == (0, 8)
    assert none[2:] == (0.0, 0.0)


def test_what_effects_move_is_that_of_plain_numpy() -> None:
    c = case()
    widths, moves = plain_widths(c)[0], c["X"].T @ c["X"] / 60.0
    mean, R, _, _ = let_loose(c["base"], c["start"], c["scale"], OWN, widths)
    energy, spread, whole = effects_moves(c["base"], R, c["scale"], mean, moves, EFFECT, OWN, 4)
    cov = plain_posterior(c, widths)[1]
    for number in range(4):
        own = np.flatnonzero(EFFECT == number)
        own = own[np.isin(own, OWN)]
        pull = moves[np.ix_(own, own)] @ mean[own]
        assert energy[number] == pytest.approx(mean[own] @ pull, rel=1e-9)
        assert spread[number] == pytest.approx(pull @ cov[np.ix_(own, own)] @ pull, rel=1e-7)
    named = OWN[EFFECT[OWN] >= 0]
    assert whole == pytest.approx(mean[named] @ moves[np.ix_(named, named)] @ mean[named], rel=1e-9)


def test_an_exploration_tells_sets_scores_and_what_counts_in_them() -> None:
    evidence = Evidence(dense_design(np.random.default_rng(5)), 0.1)
    found = explore(evidence)
    scores, counting = found.scores, found.counting
    assert scores.keys() == counting.keys()
    assert scores[found.best.members] == found.best.score == max(scores.values())
    for members in scores:
        assert counting[members]().keys() == evidence.effects_of(members)
    # of four units all sixteen sets are near enough to be met, each scored as a fit or from the set beside it
    assert len(scores) == 16
    for members, score in scores.items():
        assert score == pytest.approx(evidence.fit(members).score, abs=1.0)


def test_what_many_functions_explain_of_many_targets_is_what_each_explains_alone() -> None:
    rng = np.random.default_rng(11)
    bases = [np.polynomial.legendre.legvander(rng.uniform(-1.0, 1.0, 300), d)[:, 1:].T.copy() for d in (1, 5)]
    bases.append((np.arange(300) > 120)[None].astype(float))
    rows = [(rng.normal(size=300), rng.uniform(0.0, 3.0, 300)) for _ in range(4)]
    rows.append((rows[0][0], np.zeros(300)))  # nothing weighs
    found = _gains(bases, rows)
    for t, (z, w) in enumerate(rows):
        for q, X in enumerate(bases):
            assert found[t, q] == pytest.approx(_gain(X, z, w)[0], rel=1e-9)


@pytest.mark.parametrize("count", [5, 30, 400])
def test_products_with_the_rows_before_are_those_of_each_distance(count: int) -> None:
    rest = np.random.default_rng(2).normal(size=(count, 3))
    each = sum(float(np.sum(rest[n:] * rest[:-n])) for n in range(1, min(_LAGS, count)))
    assert _lagged(rest) == pytest.approx(each, rel=1e-9)
