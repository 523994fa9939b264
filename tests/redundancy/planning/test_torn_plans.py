"""A draft whose branch is several of the arm's is not followed, and says so; of an arm whose branches last it can't be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL

from camrob.cell.cell import Cell
from camrob.cell.joint import dh_after
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.course import Draft
from camrob.redundancy.planning.followed import follow_plan
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.waypoints import waypoints
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad


def askew() -> Cell:
    """The KR15 with A3 turned out of A2's direction by 5 degrees: its first three axes neither meet nor are parallel."""
    k = CELL.index("A2")
    bent = replace(CELL.joints[k], after=dh_after(a=0.65, alpha=deg_to_rad(5.0)))
    return replace(CELL, joints=(*CELL.joints[:k], bent, *CELL.joints[k + 1 :]))


@pytest.mark.parametrize("jump", [0.0, 2.0])
@pytest.mark.parametrize("cell", [CELL, askew()])
def test_a_branch_that_is_several_is_not_followed(cell: Cell, jump: float) -> None:
    frames = np.tile(base_T_tool(cell, cell.q_home), (6, 1, 1))
    frames[:, 0, 3] += 0.02 * np.arange(6)
    path = ToolPathInBase(
        frames, np.full(6, Move.CUT), np.full(6, 0.02), np.arange(6) + 40, np.zeros(6, np.int32), np.arange(6), np.zeros(6, bool)
    )  # fmt: skip
    space, w = plan_space(cell), waypoints(path, 0.02)
    count = len(w)
    q = np.tile(cell.q_home[cell.arm_slice], (count, 1))
    q[count // 2 :, 1] += jump
    joined = np.arange(count) > 0
    u = np.tile(cell.q_home[space.free], (count, 1))
    draft = Draft(np.arange(count), u, q, np.zeros(count, np.int64), joined, joined, 0.0)
    followed = follow_plan(cell, path, space, w, draft, still=True, margin=np.zeros(len(cell)))
    torn = Arm.of(cell).closed is None and jump > 0.0
    assert followed.torn == torn
    if torn:
        assert followed.why is not None and followed.why.axis == "A2" and "115 degrees" in followed.why.what
        assert followed.why.line == int(path.line[w.point[count // 2]]) == int(path.line[followed.stuck])
    assert not follow_plan(
        cell, path, space, w, replace(draft, joined=joined & (np.arange(count) != count // 2)), still=True,
        margin=np.zeros(len(cell)),
    ).torn  # fmt: skip
