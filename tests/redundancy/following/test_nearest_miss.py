"""What a refusal rests on: nothing in reach is called out of it, what is proved holds, and the nearest miss is one."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from follower_twins import CELL, narrow

from camrob.cell.cell import Cell
from camrob.cell.joint import dh_after, dh_before
from camrob.cell.read_cell import read_cell
from camrob.errors import UnreachableError
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_root, base_T_tool
from camrob.redundancy.following.failure import explain_unreached
from camrob.redundancy.following.nearest_miss import beyond_span, nearest_miss, way_into_span
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad

CELLS = Path(__file__).resolve().parents[3] / "cells"
BARE = read_cell(CELLS / "kr500_afp")


def drawn(cell: Cell, rng: np.random.Generator) -> np.ndarray:
    """A posture within limits, and within a turn."""
    return rng.uniform(np.maximum(cell.q_lower, -2.5), np.minimum(cell.q_upper, 2.5))


def lifted(z: float) -> np.ndarray:
    frame = np.eye(4)
    frame[2, 3] = z
    return frame


def dot(frame: np.ndarray) -> ToolPathInBase:
    return ToolPathInBase(
        np.repeat(frame[None], 2, axis=0), np.full(2, int(Move.CUT), np.int8), np.full(2, 0.02), np.array([7, 8]),
        np.zeros(2, np.int32), np.arange(2), np.zeros(2, np.bool_),
    )  # fmt: skip


@pytest.mark.parametrize("cell", [CELL, BARE, read_cell(CELLS / "irb6700_table")], ids=lambda c: c.name)
def test_what_a_posture_reaches_is_not_beyond_the_stretched_arm(cell: Cell) -> None:
    rng, arm = np.random.default_rng(1), Arm.of(cell)
    for _ in range(10):
        assert beyond_span(cell, arm, base_T_tool(cell, drawn(cell, rng))) == 0.0


def test_how_far_beyond_is_no_more_than_it_is() -> None:
    """Held to 40 000 places of the foot: the tip of the stretched arm is as far away from each, and not much farther from one."""
    arm, rng = Arm.of(CELL), np.random.default_rng(2)
    span = np.linalg.norm(arm.chain.after[:, :3, 3], axis=1).sum()
    q = np.tile(CELL.q_home, (40_000, 1))
    for i in range(CELL.arm_slice.start):
        q[:, i] = rng.uniform(max(CELL.q_lower[i], -np.pi), min(CELL.q_upper[i], np.pi), len(q))
    base_T_foot = base_T_root(CELL, q) @ np.linalg.inv(np.asarray(CELL.foot_T_root))
    start = (base_T_foot @ np.append(arm.chain.first[:3, 3], 1.0))[:, :3]
    for z in (2.6, 5.0):
        truth = np.linalg.norm(start - [0.0, 0.0, z], axis=1).min() - span
        found = beyond_span(CELL, arm, lifted(z))
        assert 0.5 * truth < found < truth  # never more; a table that turns is coarse in few boxes


def test_the_nearest_miss_is_the_limit_that_is_passed() -> None:
    """An arm without spare freedom whose wrist may bend 3 degrees less than it has to: that much is said, and of that joint."""
    q = np.array(CELL.q_home[CELL.arm_slice]) * 0.5 + 0.2
    value = float(BARE.joints[4].axis_value(q[4]))
    joints = list(narrow(BARE, q, 10.0).joints)
    joints[4] = replace(joints[4], lower=value - 0.3, upper=value - deg_to_rad(3.0))
    cell = replace(BARE, joints=tuple(joints))
    frame = base_T_tool(cell, q)
    miss = nearest_miss(cell, Arm.of(cell), frame, cell.q_home)
    assert not miss.reached and miss.values == 1
    assert miss.past == pytest.approx({"A5": deg_to_rad(3.0)}, abs=1e-6)
    error = explain_unreached(cell, Arm.of(cell), dot(frame), 0, frame)
    assert "proved: all branches by closed form" in error.what and "A5 by 3.0 degrees" in error.what
    assert error.line == 7


def test_narrow_limits_are_searched_between_the_nodes() -> None:
    """Arms that go 10 degrees from a drawn posture: no node of the scan reaches its pose, the search mostly does."""
    rng, found, scanned = np.random.default_rng(3), 0, 0
    for _ in range(8):
        q = drawn(CELL, rng)
        cell = narrow(CELL, q, 10.0)
        arm, frame = Arm.of(cell), base_T_tool(cell, q)
        miss = nearest_miss(cell, arm, frame, cell.q_home)
        scanned += miss.tally.get("in reach", 0) > 1
        if miss.reached:
            found += 1
            np.testing.assert_allclose(base_T_tool(cell, miss.q), frame, atol=1e-9)
            assert np.all(miss.q >= cell.q_lower - 1e-9) and np.all(miss.q <= cell.q_upper + 1e-9)
    assert found >= 6 > scanned


def test_a_refusal_says_whether_it_is_proved() -> None:
    arm = Arm.of(CELL)
    far = explain_unreached(CELL, arm, dot(lifted(5.0)), 0, lifted(5.0))
    assert "proved: 2" in far.what and "wherever E1 and E2 stand" in far.what
    near = explain_unreached(CELL, arm, dot(lifted(1.9)), 0, lifted(1.9))
    assert "searched, not proved" in near.what and "whatever its limits" in near.what
    upward = lifted(0.1)
    upward[1, 1] = upward[2, 2] = -1.0
    assert "passes the limits of A2 by" in explain_unreached(CELL, arm, dot(upward), 0, upward).what


def offset_wrist() -> Cell:
    """The bare arm with its fifth axis 120 mm off the fourth and the sixth off both: no closed form, each posture a search."""
    joints = list(BARE.joints)
    for i, (a, alpha, d) in zip((3, 4), ((0.08, 0.7, 0.3), (0.05, -1.2, 0.12)), strict=True):
        joints[i] = replace(joints[i], after=dh_after(a=a, alpha=alpha), before=dh_before(theta=0.0, d=d))
    return replace(BARE, joints=tuple(joints), shapes=(), masses=())


def test_an_arm_without_closed_form_is_refused_by_what_was_searched() -> None:
    cell = offset_wrist()
    arm, frame = Arm.of(cell), base_T_tool(cell, np.array(cell.q_home))
    assert arm.searched and nearest_miss(cell, arm, frame, cell.q_home).reached
    far = frame.copy()
    far[:3, 3] *= 3.0
    miss = nearest_miss(cell, arm, far, cell.q_home)
    assert miss.tally == {"out of reach": 1} and miss.q is None
    assert "proved: " in explain_unreached(cell, arm, dot(far), 0, far).what
    folded = frame.copy()
    folded[:3, 3] *= 0.05  # within the arm's foot
    assert "searched from 96 starts, which is not a proof" in explain_unreached(cell, arm, dot(folded), 0, folded).what


def test_the_way_into_reach_is_shown_no_longer_than_it_is() -> None:
    """Of an arm that stands still: moved by the way its tip is nowhere beyond any more, by nine tenths of it still."""
    arm = Arm.of(BARE)
    for x in (4.0, 20.0):
        frame = lifted(0.4)
        frame[0, 3] = x
        way = way_into_span(BARE, arm, frame)
        assert np.linalg.norm(way) == pytest.approx(beyond_span(BARE, arm, frame))
        assert beyond_span(BARE, arm, frame) > 0.1
        there, before = frame.copy(), frame.copy()
        there[:3, 3] += way
        before[:3, 3] += 0.9 * way
        assert beyond_span(BARE, arm, there) < 1e-6 < beyond_span(BARE, arm, before)


def test_a_refusal_says_how_far_the_point_lies_and_not_how_far_a_step_missed() -> None:
    """A part at 3, 5 and 20 m was called 25 mm away, all the same: that was the next step of the way there."""
    said = []
    for x in (5.0, 20.0):
        frames = np.repeat(base_T_tool(CELL, np.array(CELL.q_home))[None], 2, axis=0)
        frames[:, 0, 3] = x
        path = replace(dot(frames[0]), base_T_tip=frames)
        with pytest.raises(UnreachableError) as refused:
            resolve_vjm(CELL, path)
        what = refused.value.what
        assert "the tool stays" not in what and "the part has to come that much nearer, as by X -" in what
        said.append(float(re.search(r"proved: (\d+) mm at least", what)[1]))
    assert said[1] - said[0] == pytest.approx(15_000, abs=200) and said[0] > 1000
