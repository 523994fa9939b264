"""The map of the redundancy against arms that can be worked out by hand, and against the whole chain's own reckoning."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.redundancy.redundancy_map import BEYOND_LIMIT, ELSEWHERE, OUT_OF_REACH, TOUCHES, redundancy_map

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"


@pytest.fixture(scope="module")
def posted(tmp_path_factory):
    sample = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    return post(sample, cell=CELL, out=tmp_path_factory.mktemp("map"), report=False)


@pytest.fixture(scope="module")
def found(posted):
    return redundancy_map(read_cell(CELL), posted.path, posted.solution)


def test_the_chosen_line_runs_through_what_it_is_itself(posted, found):
    """Where a slice is cut at the chosen value, the map says the solution's own 1/k_F."""
    cell = read_cell(CELL)
    assert {cell.names[f.joint] for f in found.freedoms} >= {"E1", "E2"} and len(found.freedoms) == 3
    own = np.asarray(posted.solution.inv_kf)[found.point]
    q = np.asarray(posted.solution.q)[found.point]
    for freedom in found.freedoms:
        chosen = q[:, freedom.joint]
        for k in range(0, len(found.point), 9):
            at = np.interp(chosen[k], freedom.values, freedom.look[k])
            assert abs(at - own[k]) < 2e-3  # linear between values that lie some degrees or 30 mm apart


def test_track_values_out_of_reach_are_those_from_which_the_wrist_is_too_far(posted, found):
    """The track moves the foot along a line: reach is an interval of it, whose ends Pythagoras gives."""
    cell = read_cell(CELL)
    track = next(f for f in found.freedoms if cell.names[f.joint] == "E1")
    out = track.look == OUT_OF_REACH
    assert 0.05 < out.mean() < 0.6
    for row in out:  # within the span of what is in reach nothing is out of it
        inside = np.flatnonzero(~row)
        assert not row[inside[0] : inside[-1] + 1].any()
    k = len(found.point) // 2
    inside = np.flatnonzero(~out[k])
    best = inside[np.argmax(track.look[k, inside])]
    assert (
        track.look[k, inside[0]] < 0.3 * track.look[k, best] and track.look[k, inside[-1]] < 0.3 * track.look[k, best]
    )


def test_the_whole_chain_agrees_with_what_the_map_says_of_a_posture(posted, found, monkeypatch):
    """Postures handed to whoever asks what touches: the tool is where the program has it, 1/k_F is the map's."""
    cell, seen = read_cell(CELL), []

    def touches(q, point):
        seen.append((q, point))
        return np.arange(len(q)) % 2 == 0

    asked = redundancy_map(cell, posted.path, posted.solution, touches)
    assert asked.touched and not found.touched and len(seen) == 3
    chain = chain_arrays(cell)
    for freedom, plain, (q, point) in zip(asked.freedoms, found.freedoms, seen, strict=True):
        tool = base_T_tool(cell, q)
        true = np.asarray(posted.path.base_T_tip)[point]
        np.testing.assert_allclose(tool[:, :3, 3], true[:, :3, 3], atol=1e-7)
        np.testing.assert_allclose(tool[:, :3, 2], true[:, :3, 2], atol=1e-7)
        kf = inverse_kf_many(chain, np.ascontiguousarray(q))
        column = np.searchsorted(asked.point, point)
        row = np.abs(freedom.values[None] - q[:, freedom.joint, None]).argmin(axis=1)
        np.testing.assert_allclose(plain.look[column, row], kf, atol=1e-6)
        chosen = np.asarray(posted.solution.q)[asked.point][:, freedom.joint]
        beside = np.abs(freedom.values[None] - chosen[:, None]) < 1.5 * (freedom.values[1] - freedom.values[0])
        assert not np.any(freedom.look[beside] == TOUCHES)  # what was chosen has been checked point by point
        apart = ~beside[column, row]
        said = freedom.look[column, row] == TOUCHES
        assert np.array_equal(said[apart], (np.arange(len(q)) % 2 == 0)[apart]) and apart.sum() > 20


def test_what_an_axis_limit_forbids_is_told_from_what_is_out_of_reach(posted):
    from dataclasses import replace

    cell = read_cell(CELL)
    q = np.asarray(posted.solution.q)
    a1 = cell.index("A1")
    low, high = cell.joints[a1].axis_value(q[:, a1]).min(), cell.joints[a1].axis_value(q[:, a1]).max()
    joints = list(cell.joints)
    joints[a1] = replace(joints[a1], lower=float(low) - 0.02, upper=float(high) + 0.02)
    narrow = replace(cell, joints=tuple(joints))
    wide_map = redundancy_map(cell, posted.path, posted.solution)
    tight_map = redundancy_map(narrow, posted.path, posted.solution)
    for wide, tight in zip(wide_map.freedoms, tight_map.freedoms, strict=True):
        assert np.all((wide.look == OUT_OF_REACH) == (tight.look == OUT_OF_REACH))
        new = (tight.look < 0.0) & (wide.look >= 0.0)
        assert np.all(np.isin(tight.look[new], (BEYOND_LIMIT, ELSEWHERE)))
    track = next(f for f in tight_map.freedoms if cell.names[f.joint] == "E1")
    assert np.mean(np.isin(track.look, (BEYOND_LIMIT, ELSEWHERE))) > 0.3  # A1 turns as the foot moves
