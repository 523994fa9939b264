"""A re-posture by axis values swings the tool any way: where no safe point is high enough for that, a retract is put in."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from camrob.cell.read_cell import read_cell
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.replanning.clearing import CLEARANCE

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

from path_family import drawn_path  # noqa: E402

CELL = read_cell(ROOT / "cells" / "kr15_track_table")


def test_a_low_reposture_gets_a_retract_along_the_tool_above_all_that_the_path_passes() -> None:
    """Two planes back to back: the arm changes posture in the air between them, whose points are all said to be low."""
    path = drawn_path(CELL, "two-sided", 2)
    (before,) = resolve_planned(CELL, path, mode="still").revisions
    assert before.by_axes and path.safe[before.point] and path.source[before.point] < 0
    low = replace(path, clear=np.zeros(len(path), np.bool_))
    solution = resolve_planned(CELL, low, mode="still")
    own, at = solution.path, [r.point for r in solution.revisions if r.by_axes]
    assert own is not None and len(at) == 1 and own.clear[at].all()
    tip, axis = own.base_T_tip[at[0], :3, 3], own.base_T_tip[at[0], :3, 2]
    along = tip - own.base_T_tip[at[0] - 1, :3, 3]
    np.testing.assert_allclose(along, np.linalg.norm(along) * axis, atol=1e-12)
    np.testing.assert_allclose(own.base_T_tip[at[0] + 1], own.base_T_tip[at[0] - 1])
    passed = path.base_T_tip[path.of_toolpath, :3, 3]
    assert (passed @ axis).max() + CLEARANCE <= tip @ axis + 1e-12
    np.testing.assert_array_equal(own.base_T_tip[own.of_toolpath], path.base_T_tip[path.of_toolpath])
    assert solution.residual(CELL, own)[0].max() < 1e-9
    assert "plan-mended" in [f.code for f in solution.findings]
