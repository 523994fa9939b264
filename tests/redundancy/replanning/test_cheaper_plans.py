"""A plan cheaper than the knee's by the whole objective is posted where it loses nothing, and only there."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.jobs.solving.plan_run import job_run
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.replanning.bettered import RunFigures, is_worth_it, loses_nothing

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

from path_family import drawn_path  # noqa: E402

CELL = read_cell(ROOT / "cells" / "kr15_track_table")


def price(solution):
    return sum(solution.plan.terms.values())


def test_what_loses_nothing():
    old = RunFigures(100.0, 0.9, 200.0)
    assert loses_nothing(old, old) and loses_nothing(RunFigures(90.0, 0.95, 150.0), old)
    assert loses_nothing(RunFigures(100.05, 0.8955, 215.0), old)  # alike
    assert not loses_nothing(RunFigures(100.2, 0.9, 200.0), old)
    assert not loses_nothing(RunFigures(90.0, 0.89, 150.0), old)
    assert not loses_nothing(RunFigures(90.0, 0.95, 221.0), old)


def test_axes_that_stand_still_are_not_set_in_motion_for_half_a_percent():
    assert is_worth_it(0.995, 1.0, moves=False) and not is_worth_it(0.995, 1.0, moves=True)
    assert is_worth_it(0.985, 1.0, moves=True) and not is_worth_it(0.999, 1.0, moves=False)


@pytest.mark.slow
def test_the_cheaper_plan_is_taken_where_it_is_run_as_well_and_the_knee_s_where_not():
    """Two planes back to back, on which a little travel saves a re-posture: 4 s and 29 % of the price."""
    path = drawn_path(CELL, "two-sided", 2)
    knee = resolve_planned(CELL, path)
    taken = resolve_planned(CELL, path, run=job_run(CELL, 0.2))
    assert knee.plan.chosen == "still" and taken.plan.chosen != "still"
    assert price(taken) < 0.8 * price(knee)
    assert (
        taken.plan.chosen in [p.name for p in taken.plan.curve] and "cheaper by the whole objective" in taken.plan.rule
    )
    run = job_run(CELL, 0.2)
    assert loses_nothing(run(path, taken), run(path, knee)) and taken.inv_kf.min() > 0.9 * knee.inv_kf.min()
    position, axis = taken.residual(CELL, path)
    assert position.max() < 1e-9 and axis.max() < 1e-9
    asked = []

    def worse(_path, solution):
        """Every plan but the first that is asked about takes longer."""
        asked.append(solution)
        return RunFigures(100.0 + len(asked) * (solution.plan.chosen != "still"), 0.9, 200.0)

    kept = resolve_planned(CELL, path, run=worse)
    assert kept.plan.chosen == "still" and len(asked) > 1
    np.testing.assert_array_equal(kept.q, knee.q)


@pytest.mark.slow
def test_what_touches_something_is_not_taken_for_being_cheap():
    path = drawn_path(CELL, "two-sided", 2)
    knee = resolve_planned(CELL, path)

    def touching(_path, solution):
        """Whatever moves its table or track while it cuts touches something at the end."""
        moved = np.abs(np.diff(np.asarray(solution.q)[:, :2], axis=0))[path.cutting[1:]].sum() > 1e-2
        hit = np.zeros(len(_path), bool)
        hit[-20:] = moved
        return hit

    taken = resolve_planned(CELL, path, obstacles=touching, run=job_run(CELL, 0.2))
    assert not touching(path, taken).any() and taken.plan.chosen == knee.plan.chosen
