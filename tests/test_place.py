"""Placement of a part: symmetry about the table's axis, the best of the map, and refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.errors import InputError, UnreachableError
from camrob.jobs.place import place
from camrob.resolve.path import ToolPathInBase
from camrob.resolve.placement import place_part
from camrob.se3 import pose
from camrob.toolpath.region import Move

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)


def two_points(x: float, z: float) -> ToolPathInBase:
    frames = pose(np.repeat(np.eye(3)[None], 2, axis=0), np.array([[x, 0.0, z], [x + 1e-4, 0.0, z]]))
    return ToolPathInBase(
        frames, np.full(2, int(Move.CUT), np.int8), np.full(2, 0.02), np.arange(2) + 1, np.zeros(2, np.int32),
        np.arange(2), np.zeros(2, np.bool_),
    )  # fmt: skip


def test_bounds_of_placements_are_the_known_ones():
    """A point on the axis, moved to known places: 0.623 on the axis, 0.657 100 mm off it on either side, 0.640 higher."""
    shifts = np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.2], [0.0, 0.0, 3.0]])
    found = place_part(CELL, two_points(0.0, 0.2), np.eye(4), shifts)
    np.testing.assert_allclose(found.mean, [0.623, 0.657, 0.657, 0.657, 0.640, 0.0], atol=6e-4)
    assert found.best in (1, 2, 3) and found.here == 0
    np.testing.assert_allclose(found.base_T_part[1:, :3, 3], shifts)


def test_out_of_reach_is_said():
    with pytest.raises(UnreachableError, match="no placement"):
        place_part(CELL, two_points(0.0, 4.0), np.eye(4), np.zeros((1, 3)))


def test_place_writes_a_map_and_its_numbers(tmp_path):
    clfile = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    summary = place(clfile, cell=FOLDER, out=tmp_path, x_mm=150.0, y_mm=0.0, z_mm=100.0).summary
    assert summary == json.loads((tmp_path / "engraving.place.json").read_text())
    assert summary["best"]["inv_kf_bound_mean"] > summary["now"]["inv_kf_bound_mean"]
    assert summary["placements"] == 9 * 5 + 1
    picture = (tmp_path / "engraving.place.svg").read_text()
    assert picture.count("<rect") == summary["placements"] + 1 and picture.count("<circle") == 1
    with pytest.raises(InputError):
        place(clfile, cell=FOLDER, out=tmp_path, x_mm=-1.0)
