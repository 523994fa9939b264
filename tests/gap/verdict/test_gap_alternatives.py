"""Sets of effects as they are believed: no name is surer in them than it is by itself, and what is taken away is said."""

from __future__ import annotations

import pytest

from camrob.gap.verdict.alternatives import alternatives
from camrob.gap.verdict.belief import BELIEF


def believed_sets(sets, probability):
    return {frozenset(a.effects): a.probability for a in alternatives(sets, probability)}


def test_evidence_without_a_doubt_is_believed_no_more_than_its_names() -> None:
    """Two names that are wrong together: the pair is as sure as each of them, and not their product."""
    found = believed_sets({frozenset({"a", "b"}): 1.0}, {"a": BELIEF.surest, "b": BELIEF.surest})
    assert found[frozenset({"a", "b"})] == pytest.approx(BELIEF.surest, abs=1e-9) or len(found) == 1
    doubted = believed_sets({frozenset({"a", "b"}): 1.0}, {"a": 0.9, "b": 0.6})
    assert doubted == pytest.approx({frozenset({"a", "b"}): 0.6, frozenset({"a"}): 0.3, frozenset(): 0.1})


def test_a_name_that_is_not_believed_is_in_no_set() -> None:
    """Evidence alone said "payload, 1.00" of a foreign cause whose name the verdict had withdrawn."""
    assert believed_sets({frozenset({"payload"}): 1.0}, {"payload": 0.0}) == {frozenset(): 1.0}
    assert believed_sets({frozenset({"payload", "unknown"}): 1.0}, {"payload": 0.05}) == pytest.approx(
        {frozenset(): 0.95, frozenset({"payload"}): 0.05}
    )


def test_sets_sum_to_one_and_no_name_is_surer_than_believed() -> None:
    sets = {
        frozenset({"a", "b"}): 0.6,
        frozenset({"a", "c"}): 0.3,
        frozenset({"b", "unknown"}): 0.08,
        frozenset(): 0.02,
    }
    believed = {"a": 0.78, "b": 0.55, "c": 0.2}
    found = believed_sets(sets, believed)
    assert sum(found.values()) == pytest.approx(1.0)
    for name, p in believed.items():
        # the least likely sets, 3 % together, are not reported
        assert sum(q for s, q in found.items() if name in s) <= p / 0.97 + 1e-9
    plain = {n: p**BELIEF.slope for n, p in sets.items()}
    sure = believed_sets(sets, {"a": 1.0, "b": 1.0, "c": 1.0})
    assert sure[frozenset({"a", "b"})] == pytest.approx(plain[frozenset({"a", "b"})] / sum(plain.values()), rel=0.04)


def test_names_that_are_no_likelier_than_what_is_left_out_double_no_set() -> None:
    """Three names of 2 % each beside one that is sure made eight sets; one of 10 % is told."""
    rare = {"x": 0.02, "y": 0.02, "z": 0.02, "w": 0.10}
    sets: dict[frozenset[str], float] = {frozenset({"a"}): 1.0}
    for name, p in rare.items():
        sets = {k: q * s for names, q in sets.items() for k, s in ((names, 1.0 - p), (names | {name}, p))}
    odds = {names: p ** (1.0 / BELIEF.slope) for names, p in sets.items()}  # as evidence that is believed so much
    found = believed_sets(odds, {"a": 1.0, **rare})
    assert found == pytest.approx({frozenset({"a"}): 0.9, frozenset({"a", "w"}): 0.1}, abs=1e-6)
