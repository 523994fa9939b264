"""Ways by axis values around what stands in the straight one: which routes are tried, and that programs with one are released."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import camrob
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs
from camrob.jobs.solving import plan_obstacles
from camrob.jobs.solving.plan_obstacles import free_routes
from camrob.redundancy.published.virtual_joint import resolve_vjm

ROOT = Path(__file__).resolve().parents[3]
SAMPLE, CELL = ROOT / "toolpaths/engraving/engraving.cls", ROOT / "cells/kr15_track_table"


class _Refused:
    """In place of the check of a route: the first `count` of each way touch something."""

    def __init__(self, count: int) -> None:
        self.count, self.tried = count, dict[int, int]()

    def __call__(self, _inputs: object, _path: object, _rows: object, point: int) -> bool:
        tried = self.tried.get(point, 0)
        self.tried[point] = tried + 1 if tried < self.count else 0  # the next way begins anew
        return tried < self.count


@pytest.mark.parametrize("count", [0, 1, 2, 3, 9])
def test_routes_are_tried_in_turn_and_the_one_that_is_free_is_taken(
    monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    """From the last point to HOME; the axes that the postures between have from the one or the other are the route."""
    inputs = read_inputs(SAMPLE, cell_for("post", CELL), None)
    cell, solution = inputs.cell, resolve_vjm(inputs.cell, inputs.path)
    assert cell.names[:3] == ("E2", "E1", "A1")
    monkeypatch.setattr(plan_obstacles, "_blocked", _Refused(count))
    monkeypatch.setattr(plan_obstacles.ClearAir, "holds", lambda _air, frames: np.ones(len(frames), np.bool_))
    (lead,) = free_routes(inputs, inputs.path, solution).leads
    last, home, out = solution.q[-1], cell.q_home, np.asarray(lead.out)
    if count in (0, 9):  # straight: free, or no worse than any other
        assert not len(out) and not len(lead.into)
        return
    arm, shoulder = cell.arm_slice, cell.index("A2")
    folded = out[-1]
    np.testing.assert_array_equal(folded[arm], home[arm])
    middle = 0.5 * (last + home) if count == 1 else last
    np.testing.assert_allclose(folded[:2], middle[:2])
    assert len(out) == (1, 1, 2)[count - 1]
    if count == 3:
        raised = last.copy()
        raised[shoulder] = home[shoulder]
        np.testing.assert_array_equal(out[0], raised)


@pytest.mark.parametrize(("method", "count"), [("vjm", 1), ("vjm", 2), ("planned", 2)])
def test_a_program_that_takes_a_route_is_released(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, method: str, count: int
) -> None:
    """Read back, replayed with its bodies and passed by the witness, which knows nothing of routes."""
    monkeypatch.setattr(plan_obstacles, "_blocked", _Refused(count))
    done = camrob.post(SAMPLE, cell=CELL, out=tmp_path, method=method)
    text = (done.out / "engraving.src").read_text().splitlines()
    ends = [k for k, line in enumerate(text) if line.startswith(("LIN", "CIRC"))]
    before, behind = text[: ends[0]], text[ends[-1] :]
    for lines in (before, behind):
        assert sum(line.startswith("PTP") for line in lines) > (2 if lines is before else 1)
