"""Self-motion is no faster than an axis: within regions, at safe points between them, and where a revision is kept."""

from __future__ import annotations

import numpy as np
import pytest
from follower_twins import CELL
from test_revision import PATH

from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.published import virtual_joint
from camrob.redundancy.published.virtual_joint import AIR_SPEED, Attempt, PathFollower, resolve_vjm

TRACK, TABLE = CELL.index("E1"), CELL.index("E2")


def aside(q: np.ndarray, index: int, by: float) -> np.ndarray:
    """The posture with an external axis moved so far, its pose held by the arm; as far as the arm can."""
    arm, part = Arm.of(CELL), CELL.arm_slice
    rows = np.tile(q, (81, 1))
    rows[:, index] += np.linspace(0.0, by, 81)
    pose = base_T_tool(CELL, q)
    followed, _code, count = arm.follow(arm.foot_T_tool(np.broadcast_to(pose, (81, 4, 4)), rows), q[part], step=0.35)
    rows[:count, part] = followed[:count]
    return rows[count - 1]


@pytest.mark.parametrize(("index", "by"), [(TRACK, 0.7), (TRACK, -0.7), (TABLE, 1.2), (TABLE, -1.2)])
def test_no_axis_is_asked_to_run_faster_than_it_can_at_a_safe_point(index: int, by: float) -> None:
    """From a posture far from the one that weights and reference ask for, through air and a region. Reckoned from the
    postures and the tip's way alone; what the tool's own motion asks of an axis is at most that motion.
    """
    solution = resolve_vjm(CELL, PATH, revise=False)
    first = int(np.flatnonzero(PATH.region == 1)[0]) - 3  # in the air between the regions
    assert PATH.safe[first + 1 : first + 3].all()
    begin = aside(np.array(solution.q[first]), index, by)
    assert abs(begin[index] - solution.q[first, index]) > 0.3
    follower = PathFollower(CELL, PATH)
    way = follower.follow(follower.at(begin), CELL.q_reference, first + 1, len(PATH))
    q, path = np.vstack([begin, way.q]), PATH.part(slice(first, len(PATH)))
    step = np.linalg.norm(np.diff(path.base_T_tip[:, :3, 3], axis=0), axis=1)
    axis = path.base_T_tip[:, :3, 2]
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", axis[1:], axis[:-1]), -1.0, 1.0))
    speed = np.where(np.isfinite(path.feed[1:]), path.feed[1:], AIR_SPEED)
    time = np.maximum(step / speed, turn)
    moved = np.abs(np.diff(q, axis=0))
    for i, own in ((TABLE, step / 0.3 + turn), (TRACK, step + 0.5 * turn)):
        assert np.all(moved[:, i] <= time * CELL.limits_of("speed")[i] + own + 1e-3)


def test_a_revision_that_gains_next_to_nothing_moves_no_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both ways through a region are planted: lowest and mean 1/k_F as they were, then with more of one or the other."""
    plain = np.linspace(0.5, 0.6, 11)

    def attempt(inv_kf: np.ndarray) -> Attempt:
        return Attempt(np.zeros((11, len(CELL))), inv_kf, PathFollower(CELL, PATH).home())

    def kept(inv_kf: np.ndarray) -> bool:
        return virtual_joint._worth_it(attempt(inv_kf), attempt(plain))

    assert not kept(plain) and not kept(plain + 0.004)
    assert kept(plain + 0.006)
    assert kept(np.maximum(plain, 0.52))  # the lowest alone
    assert kept(np.where(plain > 0.55, plain + 0.02, plain))  # the mean alone
    assert not kept(np.where(plain < 0.505, plain - 0.001, plain + 0.05))  # the lowest falls
    monkeypatch.setattr(virtual_joint, "_worth_it", lambda *_ways: False)
    solution, without = resolve_vjm(CELL, PATH), resolve_vjm(CELL, PATH, revise=False)
    assert not any(r.kept for r in solution.revisions)
    assert any("hardly rise" in r.reason for r in solution.revisions)
    np.testing.assert_array_equal(solution.q, without.q)
