"""What the page says of the paper's statements follows from the program, and changes with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_report import CELL, _made

from camrob.redundancy.published.equilibrium import Equilibrium
from camrob.report.post.paper_section import ALIKE, UNREVISED, paper_statements

PATH, SOLUTION = _made()
N = len(PATH)


def _verdicts(kf, *, bounded=0, acting=0, spread=0.0, alike=None, without=None, method="vjm"):
    """Verdicts by the statement's first words, for 1/k_F `kf` while cutting."""
    weights = np.full((N, len(CELL)), 0.1)
    weights[::2] += spread
    cut = np.flatnonzero(PATH.cutting)
    marks = np.zeros((2, N), bool)
    marks[0, cut[:bounded]] = marks[1, cut[-acting:] if acting else []] = True
    found = Equilibrium(weights, acting=marks[1], bounded=marks[0])
    others = {n: np.full(N, v) for n, v in ((ALIKE, alike), (UNREVISED, without)) if v is not None}
    solution = replace(SOLUTION, inv_kf=np.full(N, kf), method=method)
    return {s.published.split(" ")[0]: s for s in paper_statements(CELL, PATH, solution, found, others)}


@pytest.mark.parametrize("kf, verdict", [(0.6, "holds"), (0.4, "unclear")])
def test_reasonable_is_above_the_threshold(kf: float, verdict: str) -> None:
    assert _verdicts(kf)["1/k_F"].verdict == verdict


def test_what_was_bounded_is_off_the_equilibrium() -> None:
    assert _verdicts(0.6)["Each"].verdict == "holds"
    some = _verdicts(0.6, bounded=int(PATH.cutting.sum()) // 4)["Each"]
    assert some.verdict == "does not hold" and "on 25.0 %" in some.found


@pytest.mark.parametrize(
    "spread, acting, verdict", [(0.1, 3, "holds"), (0.1, 0, "unclear"), (0.0, 3, "unclear"), (0.0, 0, "does not hold")]
)
def test_an_engine_that_changes_nothing_adjusts_nothing(spread: float, acting: int, verdict: str) -> None:
    assert _verdicts(0.6, spread=spread, acting=acting)["Two"].verdict == verdict


@pytest.mark.parametrize("other, verdict", [(0.5, "holds"), (0.6, "does not hold"), (0.7, "does not hold")])
def test_a_gain_is_one_over_the_other_way(other: float, verdict: str) -> None:
    said = _verdicts(0.6, alike=other, without=other)
    assert said["The"].verdict == said["Between"].verdict == verdict
    assert f"{other:.3f} in the mean" in said["Between"].found


def test_nothing_is_said_of_what_was_not_made() -> None:
    assert {"The", "Between"}.isdisjoint(_verdicts(0.6))
    assert not _verdicts(0.6, method="planned")
