"""Values of claims beside names that nobody claims: an arm by other code, whose links are off and whose joints give way."""

from __future__ import annotations

from dataclasses import replace

import pytest
from test_gap_far_off import NEAR, measured

from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import shrinkage, trial_of
from camrob.gap.verdict.in_company import without_company

BOTH = frozenset({"geometry", "joint_compliance"})


@pytest.fixture(scope="module")
def model() -> Model:
    """The best set is made to hold both names, whichever the search ended with."""
    found = compare([measured(NEAR, 300, 1)], [e for e in library() if e.name in BOTH])
    held = max((m for m in found.scores if found.evidence.effects_of(m) == BOTH), key=lambda m: found.scores[m])
    return replace(found, best=found.fit(held))


def test_what_is_claimed_alone_is_fitted_alone_where_that_leaves_less(model: Model) -> None:
    """Compliance is not claimed and stays: links fitted beside it leave what it makes, links alone show most of it near by."""
    blocks = trial_of(model, ())
    links = frozenset(i for i in model.best.members if model.units[i].effect == "geometry")
    beside = shrinkage(model, blocks, model.best.members, links).rms_after
    found = without_company(model, blocks, {"geometry"})
    assert found.evidence.effects_of(found.best.members) == {"geometry"}
    assert shrinkage(found, blocks, found.best.members, links).rms_after < 0.7 * beside


def test_nothing_changes_where_all_names_are_claimed_or_none_is(model: Model) -> None:
    blocks = trial_of(model, ())
    assert without_company(model, blocks, BOTH) is model
    assert without_company(model, blocks, ()) is model
