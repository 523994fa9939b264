"""A retract on which no posture is changed goes out of the path again, and one on which one is stays."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "planning"))

from test_planned import CELL, raster

from camrob.findings import Finding
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.retracts import with_retracts
from camrob.redundancy.replanning.idle_retracts import INSERTED, retract_tops, without_idle_retracts
from camrob.redundancy.solution import Revision, Solution

GIVEN = raster(3, 6, width=0.1)
PLAIN = resolve_planned(CELL, GIVEN, mode="still")


def put_in(after, turned=()):
    """The plan with retracts after some points; turned: points above at which the posture is changed there and back."""
    path = with_retracts(GIVEN, np.array(after), 0.05)
    q = np.insert(
        np.asarray(PLAIN.q), np.repeat(np.array(after) + 1, 2), np.repeat(np.asarray(PLAIN.q)[after], 2, axis=0), 0
    )
    tops = retract_tops(path)
    kept = tuple(Revision(0, int(k), q[k : k + 1], True, 0.5, 0.6) for k in tops[list(turned)])
    told = tuple(Finding(INSERTED, "retracted", line=int(path.line[k]), point=int(k)) for k in tops)
    return Solution("planned", q, np.full(len(q), 0.6), CELL.digest, path.digest, kept, told, None, path)


def test_idle_ones_go_and_the_plan_is_that_of_the_path_as_given():
    out = without_idle_retracts(CELL, GIVEN, put_in([4, 9]), 0.05, None)
    assert out.path is None and not out.findings
    np.testing.assert_array_equal(out.q, PLAIN.q)
    assert out.residual(CELL, GIVEN)[0].max() < 1e-9


def test_a_roll_that_is_a_little_other_is_no_change():
    solution = put_in([4])
    q = np.array(solution.q)
    q[6:, -1] += 0.02
    other = Solution("planned", q, solution.inv_kf, CELL.digest, solution.path_digest, (), (), None, solution.path)
    assert without_idle_retracts(CELL, GIVEN, other, 0.05, None).path is None


def test_one_on_which_the_posture_is_changed_stays():
    out = without_idle_retracts(CELL, GIVEN, put_in([4, 9], turned=[1]), 0.05, None)
    (top,) = retract_tops(out.path)
    assert [r.point for r in out.revisions] == [top] == [f.point for f in out.findings]
    assert len(out) == len(GIVEN) + 2 == len(out.path) and out.path_digest == out.path.digest
    np.testing.assert_allclose(out.path.base_T_tip[top - 1], GIVEN.base_T_tip[9])


def test_what_would_touch_without_them_keeps_them():
    solution = put_in([4])
    assert without_idle_retracts(CELL, GIVEN, solution, 0.05, lambda path, _: np.ones(len(path), bool)) is solution
    assert without_idle_retracts(CELL, GIVEN, PLAIN, 0.05, None) is PLAIN


def test_an_arm_that_comes_back_turned_keeps_it():
    solution = put_in([4])
    q = np.array(solution.q)
    q[6:, CELL.arm_slice.start] += np.deg2rad(20.0)
    other = Solution("planned", q, solution.inv_kf, CELL.digest, solution.path_digest, (), (), None, solution.path)
    assert without_idle_retracts(CELL, GIVEN, other, 0.05, None) is other
