"""Two accounts of one gap, weighed by what they leave of a log that took no part."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap.eighth_author.case import SEED, made, write

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.field_size import no_sizes
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Trial, trial_of
from camrob.gap.observation.scene import make_scene
from camrob.gap.rival_account import rival_account
from camrob.measurement.read_log import read_log

CUT, CLEAN = 27, 20  # a logged force along the feed of a wall; two zeros and nothing else
FEW = {"latency", "acceleration_error", "cutting_force", "payload", "joint_offset", "frame_base"}


def compared(number: int, folder: Path) -> tuple[Model, Trial]:
    """The comparison of some effects on a case's runs, and its withheld log."""
    write(made(SEED, number), folder)
    cell = read_cell(folder / "cell")
    runs, kept = ([make_scene(read_log(p), cell) for p in sorted(folder.glob(n))] for n in ("run*.csv", "withheld.csv"))
    model = compare(runs, [e for e in library() if e.name in FEW])
    return model, trial_of(model, kept)


def names(model: Model) -> set[str]:
    """What is more likely than not."""
    return {n for n in FEW if sum(p for names, p in model.sets.items() if n in names) >= 0.5}


def test_a_field_that_has_swallowed_a_cause_loses_against_few_causes_and_rows_that_repeat_one_another(
    tmp_path: Path,
) -> None:
    model, trial = compared(CUT, tmp_path)
    assert "latency" in names(model)
    rival = rival_account(model, trial)
    assert rival is not None
    assert names(rival) >= {"cutting_force"}
    assert "latency" not in names(rival)
    assert rival.discrepancy == 0.0
    assert rival.evidence.temperature > 1.0
    assert sum(rival.sets.values()) == pytest.approx(1.0)
    assert np.all(np.array(list(rival.sets.values())) >= 0.0)


def test_no_rival_is_asked_without_a_named_log_nor_without_a_field(tmp_path: Path) -> None:
    model, trial = compared(CUT, tmp_path)
    assert rival_account(model, trial_of(model, ())) is None
    bare = replace(model, evidence=replace(model.evidence, sizes=no_sizes()))
    assert rival_account(bare, trial) is None


def test_no_rival_is_heard_where_the_first_account_leaves_noise(tmp_path: Path) -> None:
    assert rival_account(*compared(CLEAN, tmp_path)) is None


@pytest.mark.slow
def test_a_logged_cutting_force_along_the_feed_is_no_latency(tmp_path: Path) -> None:
    write(made(SEED, CUT), tmp_path)
    cell = read_cell(tmp_path / "cell")
    log, kept = read_log(tmp_path / "run1.csv"), read_log(tmp_path / "withheld.csv")
    said = diagnose([log], cell, withheld=[kept]).summary.to_json()
    claims = {e["effect"]: e["probability"] for e in said["effects"] if e["probability"] >= 0.5}
    assert set(claims) == {"cutting_force"}
    assert claims["cutting_force"] > 0.9
    assert said["together"]["shrink"] == pytest.approx(said["together"]["predicted_shrink"], abs=0.05)
    assert said["together"]["shrink"] > 0.8
