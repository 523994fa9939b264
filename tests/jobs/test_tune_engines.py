"""`camrob tune-engines` on a short path: what it writes, what it says, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import InputError
from camrob.jobs.tune_engines import tune_engines
from camrob.redundancy.fuzzy.fis import read_fis
from camrob.report.terminal.tune_text import render_tune
from camrob.summaries.tune_summary import TuneSummary

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
ENGRAVING = ROOT / "toolpaths" / "engraving" / "engraving.cls"


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory):
    calls: list[tuple[str, float]] = []
    out = tmp_path_factory.mktemp("tune") / "out"
    result = tune_engines(
        CELL,
        on=[ENGRAVING],
        withheld=[ENGRAVING.parent],
        out=out,
        budget=30,
        seeds=2,
        points=60,
        progress=lambda stage, share: calls.append((stage, share)),
    )
    return result, out, calls


@pytest.mark.slow
def test_both_engines_open_and_the_summary_is_their_file(fitted) -> None:
    result, out, calls = fitted
    assert {f.name for f in out.iterdir()} == set(result.files)
    assert TuneSummary.from_json(json.loads((out / "tune.json").read_text())) == result.summary
    x = np.random.default_rng(1).uniform([-120, -135], [160, 135], (30, 2))
    constant = read_fis(out / "weights_jnt_constant.fis").evaluate_grid(x)
    weights = list(result.summary.ways[2].weights.values())
    np.testing.assert_allclose(constant, np.tile(weights, (30, 1)), rtol=2e-3)
    rules = read_fis(out / "weights_jnt_rules.fis")
    assert rules.kind == "sugeno" and [v.name for v in rules.inputs] == ["A3", "A5"]
    assert {stage for stage, _ in calls} == {"fit constant", "fit engine"} and calls[-1][1] > 0.9


def test_a_fit_is_never_worse_where_it_was_fitted_than_what_it_began_with(fitted) -> None:
    """Rules begin at the cell's own as constants a term; constants at 0.1 alike. What is withheld here is the same sample."""
    summary = fitted[0].summary
    own, rules, constant = summary.ways
    assert rules.trained.price < 1.05 * own.trained.price
    for way in (rules, constant):
        assert way.trained == way.withheld and way.trained.price == min(way.trained.price_by_seed)
        assert 1 < way.tried <= 2 * 30
    assert summary.best in {w.way for w in summary.ways}
    assert summary.table_error_percent > 50.0  # the shipped cell's even table
    assert render_tune(summary) is not None


@pytest.mark.slow
def test_the_same_seeds_write_the_same_files(fitted, tmp_path: Path) -> None:
    result, out, _ = fitted
    tune_engines(CELL, on=[ENGRAVING], withheld=[ENGRAVING.parent], out=tmp_path, budget=30, seeds=2, points=60)
    for name in result.files:
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes()


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"engine": "wrist"}, "no engine is called"),
        ({"budget": 0}, "budget 0"),
        ({"seeds": 1000}, "seeds 1000"),
        ({"on": []}, "no samples"),
        ({"on": [CELL]}, "holds no samples"),
    ],
)
def test_what_makes_no_sense_is_refused(tmp_path: Path, other: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        tune_engines(CELL, **({"on": [ENGRAVING], "out": tmp_path / "out"} | other))
    assert not (tmp_path / "out").exists()
