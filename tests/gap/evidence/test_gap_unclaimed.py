"""How far off what was claimed may be for what was not, held to machines that are drawn from the priors themselves."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from test_gap_evidence import two_alike

from camrob.gap.evidence.evidence import Evidence
from camrob.gap.unclaimed import open_doubt

MIX, DRAWS = 0.01, 400


def drawn(rng: np.random.Generator) -> tuple[Evidence, np.ndarray]:
    """Two causes alike but for a hundredth, of which the second is there as often as the prior of sets says; what they are."""
    values = rng.normal(0.0, 0.5, 2)
    evidence = two_alike(MIX, (0.0, 0.0))
    odds = np.exp(evidence.prior(frozenset({0, 1})) - evidence.prior(frozenset({0})))
    values[1] *= rng.random() < odds / (1.0 + odds)
    return two_alike(MIX, (float(values[0]), float(values[1])), int(rng.integers(1 << 30))), values


def test_claims_are_as_far_off_as_what_was_not_claimed_leaves_them() -> None:
    """Where the second is not claimed, the first lies within two deviations as often as that says; the set's own covariance,
    which takes for granted that there is no second, has it outside far more often.
    """
    rng, alone, opened = np.random.default_rng(2), [], []
    for _ in range(DRAWS):
        evidence, values = drawn(rng)
        fitted = evidence.fit(frozenset({0}))
        if evidence.fit(frozenset({0, 1})).score > fitted.score:
            continue
        model = SimpleNamespace(evidence=evidence, design=evidence.design, best=fitted)
        doubt = open_doubt(model, frozenset({0}))
        own = fitted.cov[0, 0]
        more = float(np.sum(doubt.root[0] ** 2)) if doubt.root.size else 0.0
        alone.append(abs(fitted.mean[0] - values[0]) / np.sqrt(own))
        opened.append(abs(fitted.mean[0] - values[0]) / np.sqrt(own + more))
    outside = [float(np.mean(np.array(z) > 2.0)) for z in (alone, opened)]
    assert len(alone) > 20 and outside[0] > 0.4 and outside[1] < 0.2  # 19 of 33 and 5 of 33


def test_a_unit_fitted_with_the_others_but_not_claimed_is_as_unsure_as_it_is_large() -> None:
    """Nothing of it is reckoned with: its whole square is in doubt, and it goes with the claim as the data say."""
    evidence = two_alike(0.3, (0.3, 0.4))
    fitted = evidence.fit(frozenset({0, 1}))
    model = SimpleNamespace(evidence=evidence, design=evidence.design, best=fitted)
    doubt = open_doubt(model, frozenset({0}))
    more = doubt.root @ doubt.root.T
    assert doubt.units == (1,)
    np.testing.assert_allclose(more[1, 1], fitted.cov[1, 1] + fitted.mean[1] ** 2, rtol=1e-6)
    np.testing.assert_allclose(more[0, 1], fitted.cov[0, 1], rtol=1e-2)
    assert more[0, 0] < 0.01 * fitted.cov[0, 0]


def test_nothing_is_added_where_nothing_else_could_be_there() -> None:
    """A second cause of another shape is told from none, and leaves the claim as sure as it is."""
    evidence = two_alike(30.0, (0.5, 0.0))
    fitted = evidence.fit(frozenset({0}))
    doubt = open_doubt(SimpleNamespace(evidence=evidence, design=evidence.design, best=fitted), frozenset({0}))
    more = np.sum(doubt.root[:1] ** 2) if doubt.root.size else 0.0
    assert more < 0.05 * fitted.cov[0, 0]
