"""The arm alone: closed form against forward kinematics and a numeric arm, limits and turns, Status and Turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.status_turn import StatusTurn
from camrob.errors import CellError
from camrob.kinematics.arm import (
    FOLLOW_JUMP,
    FOLLOW_LIMIT,
    FOLLOW_UNREACHED,
    FOLLOWED,
    Arm,
    by_newton,
    to_nearest_branch,
)
from camrob.kinematics.frames import base_T_root, base_T_tool
from camrob.kinematics.spherical_wrist import BRANCH_OK, solve_arm_many, spherical_arm
from camrob.se3 import inverse

ARM = Arm.of(CELL)
PART = CELL.arm_slice
NUMERIC = replace(ARM, closed=None)


def postures(count: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    lower = np.where(np.isfinite(CELL.q_lower), CELL.q_lower, -3.0)
    upper = np.where(np.isfinite(CELL.q_upper), CELL.q_upper, 3.0)
    return rng.uniform(lower, upper, (count, len(CELL)))


def foot_T_tool(q: np.ndarray) -> np.ndarray:
    """By definition: the unrolled tool seen from the arm's foot, postures (..., n)."""
    unrolled = q.copy()
    unrolled[..., CELL.index("roll")] = 0.0
    return inverse(base_T_root(CELL, q) @ inverse(np.asarray(CELL.foot_T_root))) @ base_T_tool(CELL, unrolled)


def test_the_tool_seen_from_the_foot() -> None:
    q = postures(50)
    np.testing.assert_allclose(ARM.foot_T_tool(base_T_tool(CELL, q), q), foot_T_tool(q), atol=1e-12)


def test_all_branches_meet_the_pose_and_hold_the_posture_it_came_from() -> None:
    q = postures(2000)
    poses = foot_T_tool(q)
    Q, why = solve_arm_many(ARM.closed, np.ascontiguousarray(poses), np.ascontiguousarray(q[:, PART]))
    exists = why == BRANCH_OK
    assert exists.any(axis=1).all()
    whole = np.repeat(q[:, None], 8, axis=1)
    whole[:, :, PART] = Q
    reached = foot_T_tool(whole[exists])
    np.testing.assert_allclose(reached, np.repeat(poses[:, None], 8, axis=1)[exists], atol=1e-9)
    apart = np.abs(Q - q[:, None, PART]).max(axis=2)
    assert np.where(exists, apart, np.inf).min(axis=1).max() < 1e-6  # the one that it came from, turn included
    assert set(np.unique(exists.sum(axis=1))) <= {2, 4, 6, 8} and (exists.sum(axis=1) == 8).sum() > 300
    for k in np.flatnonzero(exists.all(axis=1))[:50]:  # and they are eight different ones
        turns = (Q[k][:, None] - Q[k][None] + np.pi) % (2 * np.pi) - np.pi
        assert np.all(np.abs(turns).max(axis=2)[~np.eye(8, dtype=bool)] > 1e-3)


def test_turns_are_the_nearest() -> None:
    q = postures(200, seed=2)
    near = q[:, PART] + 2 * np.pi * np.random.default_rng(3).integers(-2, 3, (200, 6))
    Q, why = solve_arm_many(ARM.closed, np.ascontiguousarray(foot_T_tool(q)), near)
    assert np.all(np.abs(Q - near[:, None])[why == BRANCH_OK] <= np.pi + 1e-9)


def test_branches_against_the_numeric_arm() -> None:
    """Newton's method from many starts knows nothing of the geometry, and finds the same postures."""
    for k, q in enumerate(postures(8, seed=4)):
        pose = foot_T_tool(q)
        closed, numeric = ARM.branches(pose, q[PART]), NUMERIC.branches(pose, q[PART])
        assert closed and len(numeric) >= max(1, len(closed) - 2), k
        for found in numeric:
            turns = [np.abs((found - other + np.pi) % (2 * np.pi) - np.pi).max() for other in closed]
            assert min(turns) < 1e-6


def test_branches_keep_to_limits_by_turning() -> None:
    """An angle beyond its range by turns is brought in; where no turn fits, the branch is none."""
    for q in postures(40, seed=5):
        for found in ARM.branches(foot_T_tool(q), q[PART] + 2 * np.pi * np.array([0, 0, 0, 1, 0, -1])):
            assert np.all(found >= ARM.lower) and np.all(found <= ARM.upper)
    narrow = replace(ARM, lower=CELL.q_home[PART] - 0.01, upper=CELL.q_home[PART] + 0.01)
    pose = foot_T_tool(CELL.q_home)
    assert len(narrow.branches(pose, CELL.q_home[PART])) == 1
    assert sum(narrow.reasons(pose, CELL.q_home[PART]).values()) >= 3


def test_reasons_count_every_branch() -> None:
    far = foot_T_tool(CELL.q_home)
    far[:3, 3] += 5.0
    assert ARM.branches(far, CELL.q_home[PART]) == []
    assert ARM.reasons(far, CELL.q_home[PART]) == {"out of reach": 8}
    reasons = ARM.reasons(foot_T_tool(CELL.q_home), CELL.q_home[PART])
    assert set(reasons) <= {f"at A{k}'s limit" for k in range(1, 7)} and reasons


def test_newton_meets_or_says_no() -> None:
    for q in postures(30, seed=6):
        pose = foot_T_tool(q)
        start = q[PART] + 0.1
        if by_newton(ARM.chain, np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]), start):
            whole = q.copy()
            whole[PART] = start
            np.testing.assert_allclose(foot_T_tool(whole), pose, atol=1e-9)
    pose = foot_T_tool(CELL.q_home)
    pose[:3, 3] += 9.0
    assert not by_newton(ARM.chain, np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]), start)


@pytest.mark.parametrize("arm", [ARM, NUMERIC], ids=["closed", "numeric"])
def test_following(arm: Arm) -> None:
    """Along a smooth way of the arm the same postures come back, past half turns of A6; then each way to fail."""
    s = np.linspace(0.0, 1.0, 150)[:, None]
    start = CELL.to_q(np.array([-20.0, -80.0, 80.0, 30.0, 60.0, -340.0, 0.0, 0.0]))
    stop = CELL.to_q(np.array([40.0, -60.0, 110.0, -60.0, 90.0, 330.0, 0.0, 0.0]))
    q = start + s * (stop - start)
    poses = np.ascontiguousarray(foot_T_tool(q))
    followed, code, count = arm.follow(poses, start[PART], step=0.3)
    assert (code, count) == (FOLLOWED, 150)
    np.testing.assert_allclose(followed, q[:, PART], atol=1e-7)
    assert arm.follow(poses[[0, 140]], start[PART], step=0.3)[1:] == (FOLLOW_JUMP, 1)
    away = poses[:10].copy()
    away[5:, :3, 3] += 7.0
    assert arm.follow(away, start[PART], step=0.3)[1:] == (FOLLOW_UNREACHED, 5)
    upper = arm.upper.copy()
    upper[5] = 0.0
    _, code, count = replace(arm, upper=upper).follow(poses, start[PART], step=0.3)
    assert code == FOLLOW_LIMIT and q[count - 1, PART][5] <= 0.0 < q[count + 1, PART][5]


def test_an_arm_without_closed_form_is_reported() -> None:
    def bent(k: int, change: np.ndarray) -> Cell:
        joints = list(CELL.joints)
        i = CELL.indices(Role.ARM)[k]
        joints[i] = replace(joints[i], after=joints[i].after @ change)
        return replace(CELL, joints=tuple(joints))

    shift = np.eye(4)
    shift[0, 3] = 1e-4  # a tenth of a millimetre off the wrist's centre
    tilt = np.eye(4)
    tilt[:3, :3] = [[1, 0, 0], [0, np.cos(1e-5), -np.sin(1e-5)], [0, np.sin(1e-5), np.cos(1e-5)]]
    assert spherical_arm(CELL) is not None
    for cell in (bent(3, shift), bent(4, shift), bent(1, tilt)):
        assert spherical_arm(cell) is None
        assert Arm.of(cell).closed is None
        with pytest.raises(CellError, match="spherical wrist"):
            StatusTurn.of(cell)
        q = cell.q_home
        found = Arm.of(cell).branches(Arm.of(cell).foot_T_tool(base_T_tool(cell, q), q), q[PART])
        assert min(np.abs(f - q[PART]).max() for f in found) < 1e-6


# ---- Status and Turn


def test_home_is_s_2_t_2_and_the_stretch_is_where_the_page_says() -> None:
    st = StatusTurn.of(CELL)
    home = CELL.to_axis_values(CELL.q_home)[None, :6]
    assert (st.status(home).tolist(), st.turn(home).tolist()) == ([2], [2])
    assert st.stretch_deg == pytest.approx(14.48, abs=0.005)
    assert np.degrees(np.arctan2(155.0, 600.0)) == pytest.approx(st.stretch_deg, abs=1e-6)


def test_status_bits_one_by_one() -> None:
    st = StatusTurn.of(CELL)

    def s(**axes: float) -> int:
        values = {"A1": 0.0, "A2": -90.0, "A3": 90.0, "A4": 0.0, "A5": 60.0, "A6": 0.0, **axes}
        return int(st.status(np.array([list(values.values())]))[0])

    assert s() == 2
    assert s(A3=14.4) == 0 and s(A3=14.6) == 2
    assert s(A5=-60.0) == 6 and s(A5=0.0) == 2
    assert s(A2=-140.0, A3=10.0) & 1 == 1  # leaning back over its head
    assert s(A1=170.0) == s(A1=-170.0) == s(A6=300.0) == 2


def test_overhead_by_the_arms_side_view() -> None:
    """Bit 0 from a drawing of the arm from its side: 300 mm to A2, 650 mm up to A3, 600 mm and 155 mm across to the wrist."""
    axes = CELL.to_axis_values(postures(500, seed=9))[:, :6]
    a2, forearm = np.radians(axes[:, 1]), np.radians(axes[:, 1] + axes[:, 2])
    reach = 300.0 + 650.0 * np.cos(a2) + 600.0 * np.cos(forearm) + 155.0 * np.sin(forearm)
    overhead = StatusTurn.of(CELL).status(axes) & 1
    np.testing.assert_array_equal(overhead, reach < 0.0)
    assert 50 < overhead.sum() < 450


def test_turn_bits_are_signs() -> None:
    axes = np.array([[-1.0, 1, -1, 1, -1, 1], [0, 0, 0, 0, 0, 0], [-1, -1, -1, -1, -1, -1]])
    assert StatusTurn.turn(axes).tolist() == [0b010101, 0, 63]


def test_status_and_turn_tell_branches_apart() -> None:
    """Of the postures that reach a pose within limits, turns of A4 and A6 included, no two have the same S and T."""
    st = StatusTurn.of(CELL)
    for q in postures(60, seed=8):
        found = ARM.branches(foot_T_tool(q), q[PART])
        whole = np.tile(q, (len(found), 1))
        whole[:, PART] = found
        axes = CELL.to_axis_values(whole)[:, :6]
        assert len(set(zip(st.status(axes).tolist(), st.turn(axes).tolist(), strict=True))) == len(found)


def stretched() -> float:
    """The angle of the third axis at which the arm is stretched: its fore arm goes on where the upper arm points."""
    h, fore, upper = ARM.closed.h[2], ARM.closed.wrist - ARM.closed.o[2], ARM.closed.o[2] - ARM.closed.o[1]
    return float(np.arctan2(h @ np.cross(fore, upper), fore @ upper - (h @ fore) * (h @ upper)))


@pytest.mark.parametrize("axis, angle", [(4, 0.0), (2, stretched()), (None, 0.0)], ids=["wrist", "elbow", "anywhere"])
@pytest.mark.parametrize("step", [1e-4, 1e-2, 0.2])
def test_the_branch_that_is_followed_is_the_nearest_of_all_eight(axis: int | None, angle: float, step: float) -> None:
    """Also where branches meet, about a straight wrist and a stretched elbow: to the last bit what comes of all eight."""
    rng = np.random.default_rng(round(1e4 * step))
    q = CELL.q_home + np.cumsum(step * rng.normal(size=(400, len(CELL))), axis=0)
    if axis is not None:
        q[:, PART.start + axis] = angle + step * rng.normal(size=len(q))
    poses = np.ascontiguousarray(foot_T_tool(q))
    free = replace(ARM, lower=np.full(6, -np.inf), upper=np.full(6, np.inf))
    followed, _code, count = free.follow(poses, q[0, PART], step=np.inf)
    assert count == len(q)
    near = q[0, PART].copy()
    Q, why = np.empty((8, 6)), np.empty(8, np.int64)
    for k, pose in enumerate(poses):
        to_nearest_branch(
            *ARM.kernel(), np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]), near, Q, why
        )
        assert np.array_equal(followed[k], near)


@pytest.mark.parametrize("upright", [-85.0, -90.0, -95.0])
def test_overhead_does_not_depend_on_where_a2_and_a3_show_zero(upright: float) -> None:
    """A shoulder on axis 1 and an arm that stands upright at 0, leaning a little back (a VS060's fore arm is 10 mm behind)."""
    joints = list(CELL.joints)
    first, second, third = (CELL.index(name) for name in ("A1", "A2", "A3"))
    after = np.array(joints[first].after)
    after[:3, 3] = 0.0
    joints[first] = replace(joints[first], after=after)
    plain = replace(CELL, joints=tuple(joints))
    for i, degrees in ((second, upright), (third, 0.0)):
        joints[i] = replace(joints[i], offset=joints[i].offset - np.radians(degrees))
    renamed = replace(CELL, joints=tuple(joints))
    q = np.random.default_rng(4).uniform(-2.0, 2.0, (400, len(CELL)))
    ours, theirs = (StatusTurn.of(c).status(c.to_axis_values(q)[:, :6]) & 1 for c in (plain, renamed))
    np.testing.assert_array_equal(ours, theirs)
    assert 50 < ours.sum() < 350
