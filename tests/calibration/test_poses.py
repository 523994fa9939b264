"""Poses to measure next: better than others, and a program that visits them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, ROOT, axis_values, drawn, log_of, measure

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.next_poses import candidate_postures, select_poses
from camrob.calibration.terms import parameter_of, standard_names
from camrob.checks.collisions import check_collisions
from camrob.cli.app import run
from camrob.controller.judge import judge
from camrob.controller.replay import replay
from camrob.errors import CollisionError
from camrob.jobs.solving.measuring import plan_measuring
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log

NAMES = standard_names(CELL)
PATH = CELL.to_q(axis_values(CELL, 40, seed=9) * np.array([0.2, 1, 1, 0.2, 1, 0.2, 0.2, 0.2]))


def expected_error(q: np.ndarray) -> float:
    """The criterion, written out: rms of the position on the path after measuring poses q, m."""
    model, zero = ErrorModel.of(CELL, NAMES), np.zeros(len(NAMES))
    scales = np.array([parameter_of(CELL, n).scale for n in NAMES])
    J = (model.poses_and_jacobian(zero, q)[1][:, :3] * scales / 5e-5).reshape(-1, len(NAMES))
    C = np.linalg.inv(J.T @ J + np.eye(len(NAMES)) / 9.0)
    on_path = model.poses_and_jacobian(zero, PATH)[1][:, :3] * scales
    return float(np.sqrt(np.mean([np.trace(j @ C @ j.T) for j in on_path])))


def test_the_choice_is_the_criterion_s_and_beats_chance() -> None:
    candidates = candidate_postures(CELL, 300)
    choice = select_poses(CELL, NAMES, candidates, PATH, 15)
    assert len(set(choice.chosen.tolist())) == 15
    assert np.all(np.diff(choice.expected) < 0.0)
    assert choice.expected[-1] == pytest.approx(expected_error(candidates[choice.chosen]), rel=1e-6)
    rng = np.random.default_rng(0)
    by_chance = [expected_error(candidates[rng.permutation(300)[:15]]) for _ in range(10)]
    assert choice.expected[-1] < 0.8 * min(by_chance)
    first = [expected_error(candidates[k : k + 1]) for k in range(300)]
    assert int(np.argmin(first)) == choice.chosen[0]  # the best single pose


def test_what_is_measured_already_counts() -> None:
    candidates = candidate_postures(CELL, 200)
    known = CELL.to_q(axis_values(CELL, 100))
    fresh = select_poses(CELL, NAMES, candidates, PATH, 5)
    after = select_poses(CELL, NAMES, candidates, PATH, 5, measured=known)
    assert after.expected[0] < 0.1 * fresh.expected[0]
    with pytest.raises(ValueError, match="5 poses are wanted of 4"):
        select_poses(CELL, NAMES, candidates[:4], PATH, 5)


def test_candidates_lie_within_limits_and_are_always_the_same() -> None:
    q = candidate_postures(CELL, 400)
    assert len(q) > 200 and np.array_equal(q, candidate_postures(CELL, 400))
    assert np.all(q >= CELL.q_lower) and np.all(q <= CELL.q_upper)


def test_the_command_writes_a_program_that_can_be_run(tmp_path: Path, capsys) -> None:
    write_log(log_of(CELL, measure(CELL, drawn(CELL), axis_values(CELL, 60))), tmp_path / "m.csv")
    cell = str(ROOT / "cells" / "kr15_track_table")
    out = tmp_path / "2nd try.toml"
    assert run(["calibrate", str(tmp_path / "m.csv"), "--cell", cell, "--out", str(out), "--next", "8", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["next"]
    assert found["expected_after_mm"] < found["expected_before_mm"] and found["collisions"]["checked"]
    program = read_krl(tmp_path / "P_2nd_try_poses.src")
    assert len(program) == 10
    played = replay(program, CELL)
    assert judge(program, played).good
    assert run(["verify", str(tmp_path / "P_2nd_try_poses.src"), "--cell", cell, "--quiet"]) == 0
    assert np.allclose(CELL.to_axis_values(np.asarray(played.q))[1:-1], found["axis_values"], atol=1e-6)
    nothing = np.zeros(len(program))
    assert check_collisions(CELL, np.asarray(played.q), cutting=nothing, line=nothing, region=nothing).count == 0


@pytest.mark.slow
def test_too_many_poses_are_refused() -> None:
    data = measure(CELL, {}, axis_values(CELL, 20))
    with pytest.raises(CollisionError, match="no 590 poses were found"):
        plan_measuring(CELL, data, ("A2.zero",), np.asarray(data.q), 590, "MANY")
