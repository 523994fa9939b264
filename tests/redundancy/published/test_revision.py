"""Posture revision: table first, then track, the cutter's pose held, every posture checked, kept only where it pays."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from follower_twins import CELL, CHAIN

from camrob.cell.joint import Role
from camrob.errors import JobError
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import inverse_kf_many
from camrob.redundancy.published import virtual_joint
from camrob.redundancy.published.revision import MARGIN, revise_posture
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.redundancy.transfers import build_path
from camrob.se3 import frame_from_xyzabc, rotation_log
from camrob.toolpath.region import Move, Region
from camrob.toolpath.toolpath import Toolpath

ARM = Arm.of(CELL)
TABLE, TRACK, PART = CELL.index("E2"), CELL.index("E1"), CELL.arm_slice


def starts(count: int) -> np.ndarray:
    """Postures within limits, off the best conditioning."""
    rng = np.random.default_rng(1)
    axes = rng.uniform([-60, -110, 50, -40, 40, -60, -900, -90], [60, -50, 120, 40, 100, 60, 900, 90], (count, 8))
    return CELL.to_q(axes)


def test_a_revision_raises_the_conditioning_with_the_pose_held() -> None:
    better = 0
    for q in starts(25):
        moves = revise_posture(CELL, CHAIN, ARM, q)
        np.testing.assert_array_equal(moves[0], q)
        assert len(moves) <= 3
        inv_kf = inverse_kf_many(CHAIN, moves)
        assert np.all(np.diff(inv_kf) > 0.0)
        better += inv_kf[-1] > inv_kf[0] + 0.05
        poses = base_T_tool(CELL, moves)
        np.testing.assert_allclose(poses[:, :3, 3], poses[0, :3, 3][None].repeat(len(moves), 0), atol=1e-9)
        turned = rotation_log(np.swapaxes(poses[:1, :3, :3], 1, 2) @ poses[:, :3, :3])
        assert np.linalg.norm(turned, axis=1).max() < 1e-9
    assert better > 10


def test_the_table_moves_first_and_one_axis_at_a_time() -> None:
    seen = set()
    for q in starts(25):
        moves = revise_posture(CELL, CHAIN, ARM, q)
        moved = [tuple(np.flatnonzero(np.abs(d[[TABLE, TRACK]]) > 1e-12)) for d in np.diff(moves, axis=0)]
        assert moved in ([], [(0,)], [(1,)], [(0,), (1,)])
        seen.add(tuple(moved))
    assert ((0,), (1,)) in seen


def test_every_posture_on_the_way_is_within_limits() -> None:
    """Gone through again in steps of a quarter degree and 2 mm, by the arm's inverse at the held pose."""
    for q in starts(12):
        moves = revise_posture(CELL, CHAIN, ARM, q)
        for begin, end in itertools.pairwise(moves):
            i = TABLE if abs(end[TABLE] - begin[TABLE]) > 1e-12 else TRACK
            count = int(np.ceil(abs(end[i] - begin[i]) / 0.004))
            between = np.tile(begin, (count, 1))
            between[:, i] = np.linspace(begin[i], end[i], count)
            poses = np.broadcast_to(base_T_tool(CELL, begin), (count, 4, 4))
            followed, code, reached = ARM.follow(ARM.foot_T_tool(poses, between), begin[PART], step=0.1)
            assert (code, reached) == (0, count)
            np.testing.assert_allclose(followed[-1], end[PART], atol=1e-8)
            assert np.all(end[PART] >= ARM.lower + MARGIN) and np.all(end[PART] <= ARM.upper - MARGIN)
        assert np.all(moves >= CELL.q_lower) and np.all(moves <= CELL.q_upper)


def test_a_posture_that_is_best_stays() -> None:
    q = starts(1)[0]
    for _ in range(6):
        q = revise_posture(CELL, CHAIN, ARM, q)[-1]
    assert len(revise_posture(CELL, CHAIN, ARM, q)) == 1


# ---- within a program


def two_sides() -> Toolpath:
    """Two regions at right angles (the paper's figure 9): a field from above, then one from the front."""
    regions = []
    for k, (axis, along, across, corner) in enumerate(
        (
            ([0, 0, 1.0], [1.0, 0, 0], [0, 1.0, 0], [-0.1, -0.05, 0.15]),
            ([0, -1.0, 0], [1.0, 0, 0], [0, 0, 1.0], [-0.1, -0.08, 0.05]),
        )
    ):
        rows = []
        for row in range(8):
            x = np.linspace(0.0, 0.2, 21)
            x = x if row % 2 == 0 else x[::-1]
            rows.append(np.array(corner) + np.outer(x, along) + 0.01 * row * np.array(across))
        tips = np.concatenate(rows)
        n = len(tips)
        regions.append(
            Region(
                f"side {k}",
                tips,
                np.tile(axis, (n, 1)),
                np.full(n, 0.03),
                np.full(n, int(Move.CUT), np.int8),
                np.arange(n) + 1000 * k + 1,
            )
        )
    return Toolpath(tuple(regions), "sides.cls", "0", "nx-clsf")


PATH = build_path(CELL, two_sides(), frame_from_xyzabc(np.array([0.05, 0.0, 0.2, 0.0, 0.0, 0.0])), clearance=0.06)


def lowest(solution, region: int) -> float:
    return float(np.asarray(solution.inv_kf)[PATH.region == region].min())


def test_a_kept_revision_does_not_lower_the_regions_minimum() -> None:
    with_it, without = resolve_vjm(CELL, PATH), resolve_vjm(CELL, PATH, revise=False)
    assert [r.region for r in with_it.revisions] == [0, 1]
    assert any(r.kept for r in with_it.revisions)
    assert lowest(with_it, 0) >= lowest(without, 0) - 1e-12
    first_kept = next(r for r in with_it.revisions if r.kept)
    if first_kept.region == 1:
        assert lowest(with_it, 1) >= lowest(without, 1) - 1e-12
    for solution in (with_it, without):
        position, angle = solution.residual(CELL, PATH)
        assert position.max() < 1e-9 and angle.max() < 1e-9
        q = np.asarray(solution.q)
        assert np.all(q >= CELL.q_lower) and np.all(q <= CELL.q_upper)
    for r in with_it.revisions:
        if r.kept:
            assert PATH.safe[r.point]
            np.testing.assert_allclose(r.q[-1], with_it.q[r.point], atol=1e-12)
            poses = base_T_tool(CELL, np.asarray(r.q))
            np.testing.assert_allclose(
                poses[:, :3, 3], np.broadcast_to(PATH.base_T_tip[r.point, :3, 3], (len(r.q), 3)), atol=1e-9
            )
        else:
            assert r.reason and r.q.shape[0] == 0


def test_a_revision_that_would_lower_the_minimum_is_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planted bad revision: the track is moved to where the arm must stretch. It is tried, and given up."""
    tried = []

    def bad(cell, chain, arm, q):
        worst, out = 1.0, None
        for mm in np.arange(-900.0, 901.0, 20.0):
            other = q.copy()
            other[TRACK] += mm / 1000.0
            pose = arm.foot_T_tool(base_T_tool(cell, q), other)
            found = arm.branches(pose, q[PART]) if abs(other[TRACK]) < 1.4 else []
            if found:
                other[PART] = min(found, key=lambda f: np.abs(f - q[PART]).max())
                value = float(inverse_kf_many(chain, other[None])[0])
                if value < worst:
                    worst, out = value, other
        tried.append(worst)
        return np.array([q, out])

    monkeypatch.setattr(virtual_joint, "revise_posture", bad)
    solution = resolve_vjm(CELL, PATH)
    without = resolve_vjm(CELL, PATH, revise=False)
    assert tried and min(tried) < lowest(without, 0)
    assert not any(r.kept for r in solution.revisions)
    np.testing.assert_array_equal(solution.q, without.q)


def test_limits_end_the_program_with_line_and_reason() -> None:
    """A field that only leaves E1's range would reach: status 3 with the reason, never beyond the limit. It lies within the
    stretched arm, so that no distance beyond it is said.
    """
    far = build_path(CELL, two_sides(), frame_from_xyzabc(np.array([0.0, 0.0, 1.9, 0.0, 0.0, 0.0])), clearance=0.06)
    with pytest.raises(JobError) as error:
        resolve_vjm(CELL, far)
    assert error.value.line > 0 and "searched, not proved" in str(error.value) and error.value.reasons
    assert str(error.value).isprintable()


def test_carriages_and_tables_are_known_by_their_role() -> None:
    assert CELL.indices(Role.WORKPIECE) == (TABLE,) and CELL.indices(Role.CARRIAGE) == (TRACK,)
