"""`camrob post --prove`: what is refused, and a sample's plan held to the best that exists."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import camrob
from camrob.errors import InputError
from camrob.report.post.plan_section import bound_text
from camrob.summaries.post_summary import PriceBound

ROOT = Path(__file__).resolve().parents[2]
CELL, PART = ROOT / "cells" / "kr15_track_table", ROOT / "toolpaths" / "engraving" / "engraving.cls"


@pytest.mark.parametrize("wrong", [{"method": "vjm", "prove": 10.0}, {"method": "planned", "prove": 0.0}])
def test_a_time_without_a_plan_or_none_at_all_is_refused(tmp_path, wrong):
    with pytest.raises(InputError, match="--prove"):
        camrob.post(PART, cell=CELL, out=tmp_path, **wrong)
    assert not list(tmp_path.iterdir())


def test_the_sentence_says_who_proved_it_and_what_is_left_out():
    known = PriceBound(
        price_m=2.0, bound_m=1.9, within_percent=5.0, checked=True, why="", left_out=("collisions",), seconds=1.0,
        certificate="x.proof.npz",
    )  # fmt: skip
    text = bound_text(known)
    assert "within 5.00 % of the best" in text
    assert "by the checker" in text
    assert "left out of the bound: collisions" in text
    none = PriceBound(
        price_m=2.0, bound_m=0.0, within_percent=None, checked=False, why="tools are changed on the way", left_out=(),
        seconds=1.0, certificate="",
    )  # fmt: skip
    assert bound_text(none) == "no bound of the plan's price is proved: tools are changed on the way"


@pytest.mark.slow
def test_a_plan_is_proved_in_its_time_and_without_time_nearly_nothing_is(tmp_path):
    result = camrob.post(PART, cell=CELL, out=tmp_path, method="planned", prove=240.0)
    said = json.loads((tmp_path / "engraving.json").read_text())["plan"]
    proved = said["proved"]
    assert proved["price_m"] == pytest.approx(sum(said["terms"].values()))
    assert proved["within_percent"] == pytest.approx(100.0 * (1.0 - proved["bound_m"] / proved["price_m"]), abs=0.006)
    assert proved["certificate"] in result.files
    assert "of the best that exists" in (tmp_path / "engraving.html").read_text()
    with np.load(tmp_path / proved["certificate"]) as data:
        weight = data["0.weight"].sum()
    # a metre costs at least what it costs at 1/k_F = 1, and a plan that is above the bound is not below it
    assert 0.5**4 * weight * 0.999 < proved["bound_m"] < proved["price_m"]
    late = camrob.post(PART, cell=CELL, out=tmp_path / "late", method="planned", prove=0.01, report=False)
    assert late.summary.plan.proved.within_percent > 80.0
    assert not late.summary.plan.proved.checked
