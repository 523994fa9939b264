"""Plans for arms whose wrist is no sphere: a UR10e on the KR15's track, roll free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad

# standard rows a, alpha, d of the UR10e, m and rad: Universal Robots, "DH parameters for calculations of kinematics and dynamics"
ROWS = [
    (0.0, np.pi / 2, 0.1807), (-0.6127, 0.0, 0.0), (-0.57155, 0.0, 0.0),
    (0.0, np.pi / 2, 0.17415), (0.0, -np.pi / 2, 0.11985), (0.0, 0.0, 0.11655),
]  # fmt: skip
HOME = np.array([0.0, -1.2, 1.8, -2.0, -np.pi / 2, 0.0])


def ur10e_on_a_track() -> Cell:
    """The KR15 cell with a UR10e on its track."""
    arm = [
        Joint(
            f"A{k + 1}", Role.ARM, False,
            (np.asarray(CELL.foot_T_root) if k == 0 else np.eye(4)) @ dh_before(theta=0.0, d=d), dh_after(a=a, alpha=alpha),
            lower=-6.28, upper=6.28, speed=2.0, acceleration=10.0, jerk=100.0, home=HOME[k], reference=HOME[k],
        )
        for k, (a, alpha, d) in enumerate(ROWS)
    ]  # fmt: skip
    joints = (*CELL.joints[: CELL.index("A1")], *arm, CELL.joints[-1])
    return replace(
        CELL, name="ur10e", joints=joints, wrist_T_flange=np.eye(4), flange_T_tool=np.diag([1.0, -1.0, -1.0, 1.0]), shapes=(),
        masses=(),
    )  # fmt: skip


@pytest.mark.slow
def test_a_ur10e_is_planned_and_does_not_fall_back() -> None:
    cell = ur10e_on_a_track()
    assert Arm.of(cell).closed is None and not Arm.of(cell).searched
    begin = base_T_tool(cell, cell.q_home)
    count = 60
    frames = np.tile(begin, (count, 1, 1))
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    frames[:, 0, 3] += 0.08 * (1.0 - np.cos(turn))
    frames[:, 1, 3] += 0.08 * np.sin(turn)
    safe = np.isin(np.arange(count), (0, count - 1))
    path = ToolPathInBase(
        frames, np.where(safe, Move.RAPID, Move.CUT), np.where(safe, np.nan, 0.02), np.arange(1, count + 1),
        np.zeros(count, np.int32), np.arange(count), safe,
    )  # fmt: skip
    solution = resolve_planned(cell, path)
    assert solution.method == "planned", [f.text for f in solution.findings]
    assert "plan-fell-back" not in [f.code for f in solution.findings]
    position, axis = solution.residual(cell, path)
    assert position.max() < 1e-6 and axis.max() < 1e-6
    q = np.asarray(solution.q)
    assert np.all(q >= cell.q_lower) and np.all(q <= cell.q_upper)
    assert np.abs(np.diff(q[:, cell.arm_slice], axis=0)).max() < deg_to_rad(10.0)
    report = solution.plan
    assert report is not None and np.all(solution.inv_kf <= report.bound + 1e-6)
