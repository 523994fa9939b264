"""How far values stand out: planted values and covariances, and what it told of sure names on four makers' cases."""

from __future__ import annotations

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.plausible import doubted_unless_clear, held_to_values, squares

CASES = Path(__file__).with_name("sure_cases.csv")
STRANGERS = ("second", "third", "fourth")  # makers who had not read the library


class Fitted:
    """A best set of two names: one parameter of the first, two of the second; a third unit stays out."""

    def __init__(self, values: list[float], cov: list[list[float]]) -> None:
        self.units = [SimpleNamespace(effect=n) for n in ("one", "two", "two")]
        self.design = SimpleNamespace(owner=np.array([0, 1, 1, 2]))
        self.best = SimpleNamespace(members=frozenset({0, 1}), mean=np.array([*values, 9.0]), cov=np.eye(4))
        self.best.cov[:3, :3] = cov
        self.evidence = SimpleNamespace(effects_of=lambda _: {"one", "two"})


def test_values_are_counted_in_standard_errors_as_they_hang_together() -> None:
    model = Fitted([6e-3, 4.0, 3.0], [[1e-6, 0.0, 0.0], [0.0, 4.0, 1.2], [0.0, 1.2, 1.0]])
    assert squares(model, "one") == pytest.approx(36.0)  # type: ignore[arg-type]
    # inverse of the covariance by hand: (1, -1.2; -1.2, 4) / 2.56
    by_hand = (16.0 - 2.0 * 1.2 * 12.0 + 4.0 * 9.0) / 2.56
    assert squares(model, "two") == pytest.approx(by_hand / 2.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("errors", "said"), [(5.0, BELIEF.likely), (9.0, 0.97)])
def test_only_a_name_whose_values_stand_out_is_nearly_sure(errors: float, said: float) -> None:
    model = Fitted([errors, 4.0, 3.0], np.eye(3).tolist())
    told = held_to_values(model, {"one": 0.97, "two": 0.6, "absent": 0.9})  # type: ignore[arg-type]
    assert told == {"one": pytest.approx(said), "two": 0.6, "absent": 0.9}


def test_a_name_as_likely_as_not_of_whose_values_little_is_known_is_no_claim() -> None:
    model = Fitted([5.0, 40.0, 3.0], np.eye(3).tolist())
    for said, one in ((0.55, BELIEF.unclear), (0.51, BELIEF.unclear), (0.6, 0.6), (0.4, 0.4)):
        told = doubted_unless_clear(model, {"one": said, "two": said, "absent": said})  # type: ignore[arg-type]
        assert told == {"one": one, "two": said, "absent": said}


def recorded() -> list[tuple[str, float, bool]]:
    """Maker, squares, and whether it was at work, of names that would be sure without this."""
    with CASES.open() as file:
        rows = [r for r in csv.DictReader(file) if float(r["said"]) > 0.8]
    return [(r["maker"], float(r["squares"]), r["right"] == "1") for r in rows]


def test_sure_names_of_strangers_that_stand_out_are_wrong_less_often() -> None:
    rows = [r for r in recorded() if r[0] in STRANGERS]
    out, others = ([right for _, s, right in rows if (s >= BELIEF.stands_out) is far] for far in (True, False))
    assert len(others) >= 20
    assert len(out) > 2 * len(others)
    assert np.mean(out) > np.mean(others) + 0.05


def test_few_right_names_of_the_first_maker_are_less_sure_by_it() -> None:
    own = [s >= BELIEF.stands_out for maker, s, right in recorded() if maker == "first" and right]
    assert np.mean(own) >= 0.9
