"""What turns evidence into belief is what the recorded cases say, and says the right thing at its ends."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from camrob.gap.verdict.belief import BELIEF

CASES = Path(__file__).with_name("belief_cases.csv")
NEVER = 1e-9


def recorded() -> tuple[np.ndarray, np.ndarray]:
    """Evidence (N,) of effects in simulated cases, and whether they were at work."""
    with CASES.open() as file:
        rows = list(csv.DictReader(file))
    return np.array([float(r["evidence"]) for r in rows]), np.array([float(r["right"]) for r in rows])


def test_slope_and_surest_are_those_that_the_recorded_cases_make_likeliest() -> None:
    evidence, right = recorded()
    p = np.clip(evidence, NEVER, 1.0 - NEVER)
    odds = np.log(p / (1.0 - p))

    def unlikely(x: np.ndarray) -> float:
        q = np.clip(x[1] / (1.0 + np.exp(-x[0] * odds)), NEVER, 1.0 - NEVER)
        return -float(np.sum(right * np.log(q) + (1.0 - right) * np.log(1.0 - q)))

    slope, surest = minimize(unlikely, [1.0, 0.95], bounds=[(0.05, 3.0), (0.5, 0.999)]).x
    assert pytest.approx(slope, abs=0.02) == BELIEF.slope
    assert pytest.approx(surest, abs=0.005) == BELIEF.surest


def test_belief_is_calibrated_on_the_recorded_cases() -> None:
    evidence, right = recorded()
    said = np.array([BELIEF.effect(e) for e in evidence])
    for low, high in ((0.0, 0.1), (0.1, 0.5), (0.5, 1.0)):
        own = (said >= low) & (said < high)
        spread = 2.0 * np.sqrt(np.mean(said[own] * (1.0 - said[own])) / own.sum())
        assert np.mean(right[own]) == pytest.approx(np.mean(said[own]), abs=spread + 0.02)


def test_more_evidence_is_never_less_belief_and_no_evidence_is_certain() -> None:
    said = [BELIEF.effect(e) for e in np.linspace(0.0, 1.0, 101)]
    assert np.all(np.diff(said) >= 0.0)
    assert said[-1] <= BELIEF.surest < 1.0
    assert BELIEF.effect(1.0, impossible=True) < 0.1


def test_what_stays_is_unknown_where_it_is_both_beyond_the_noise_and_a_part_of_the_gap() -> None:
    assert BELIEF.unknown(5.0, 0.5) > 0.99
    assert BELIEF.unknown(5.0, 0.001) < 0.01
    assert BELIEF.unknown(0.1, 0.5) < 0.01
    assert BELIEF.unknown(BELIEF.stays, 1.0) == pytest.approx(0.5)


def test_a_withheld_log_surprises_beyond_noise_discrepancy_and_doubt_alone() -> None:
    assert BELIEF.surprised(4e-8, noise=1e-4, discrepancy=0.0, doubt=0.0)
    assert not BELIEF.surprised(4e-8, noise=1e-4, discrepancy=5e-4, doubt=0.0)
    assert not BELIEF.surprised(4e-8, noise=1e-4, discrepancy=0.0, doubt=2e-4)
    assert not BELIEF.surprised(-1e-8, noise=1e-4, discrepancy=0.0, doubt=0.0)


def delivered() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of names in recorded cases of two makers (N,): how sure each can be by what it takes, whether it was at work, the maker."""
    with CASES.with_name("delivery_cases.csv").open() as file:
        rows = list(csv.DictReader(file))
    most = np.array([min(BELIEF.delivers(float(r["far"])), BELIEF.delivers(float(r["near"]))) for r in rows])
    return most, np.array([float(r["right"]) for r in rows]), np.array([r["maker"] for r in rows])


@pytest.mark.parametrize("most", [BELIEF.takes_less, BELIEF.takes_more, BELIEF.takes_else])
def test_a_name_that_takes_less_or_more_than_it_moves_is_as_sure_as_it_was_right(most: float) -> None:
    said, right, _ = delivered()
    own = said == most
    assert own.sum() >= 5
    assert np.mean(right[own]) == pytest.approx(most, abs=2.0 * np.sqrt(most * (1.0 - most) / own.sum()))


@pytest.mark.parametrize("maker", ["first", "second"])
def test_a_name_that_takes_what_it_moves_is_right_more_often_whoever_made_the_case(maker: str) -> None:
    said, right, makers = delivered()
    in_full = (said == BELIEF.surest) & (makers == maker)
    others = (said < BELIEF.surest) & (makers == maker)
    assert np.mean(right[in_full]) > np.mean(right[others]) + 0.2
