"""A claim that makes withheld samples worse is withdrawn; one that makes them worse by a trifle of the noise is not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from camrob.gap.verdict import withdrawn

NOISE, ROWS = 4e-5, 40


@pytest.mark.parametrize(("share", "kept"), [(0.05, True), (0.5, False)])
def test_a_name_is_withdrawn_for_what_it_worsens_and_not_for_a_trifle_of_the_noise(
    monkeypatch: pytest.MonkeyPatch, share: float, kept: bool
) -> None:
    """A zero whose links show it as well: without it, links alone leave less by a share of the noise's energy."""
    energy = NOISE**2 * ROWS / 3.0
    left = {frozenset({0, 1}): (1.0 + share) * energy, frozenset({0}): energy, frozenset({1}): 1e4 * energy}

    def shrinkage(model: Any, trial: Any, rest: frozenset[int], members: frozenset[int]) -> Any:
        after = np.full((ROWS, 3), np.sqrt(left[members] / ROWS))
        return SimpleNamespace(after=after, block=np.arange(ROWS) // 10)

    units = [SimpleNamespace(effect="geometry"), SimpleNamespace(effect="joint_offset")]
    evidence = SimpleNamespace(effects_of=lambda members: frozenset(units[i].effect for i in members))
    best = SimpleNamespace(members=frozenset({0, 1}))
    model: Any = SimpleNamespace(
        units=units, evidence=evidence, best=best, noise=NOISE, sets={frozenset({"both"}): 1.0}
    )
    fitted: list[frozenset[int]] = []
    model.fit = lambda members: fitted.append(members) or SimpleNamespace(members=members)
    monkeypatch.setattr(withdrawn, "shrinkage", shrinkage)
    monkeypatch.setattr(withdrawn, "behind_encoders", lambda model: frozenset())
    monkeypatch.setattr(withdrawn, "without_drives_rest", lambda model, trial: trial)
    monkeypatch.setattr(
        withdrawn, "members_of", lambda model, name: frozenset(i for i in model.best.members if units[i].effect == name)
    )
    monkeypatch.setattr(withdrawn, "replace", lambda model, **new: SimpleNamespace(**(vars(model) | new)))
    found = withdrawn.without_harmful(model, SimpleNamespace())
    assert (found.best.members == frozenset({0, 1})) == kept
    assert bool(fitted) != kept
