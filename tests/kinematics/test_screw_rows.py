"""A row of the closed forms by screw axes is one posture along a path, and changes only where the arm passes a singular one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL
from test_screw_arms import arm_cell, ur10e

from camrob.cell.joint import dh_after
from camrob.kinematics.frames import base_T_joint_axes, base_T_tool
from camrob.kinematics.screw_arm import solve_screws_many
from camrob.kinematics.screw_families import screw_arm, screw_displacement
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.units import deg_to_rad


def axes_of(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The six axes (6, 3), points on them (6, 3) and the tool (4, 4) at q = 0."""
    cell = arm_cell(ur10e()) if name.startswith("ur10e") else CELL
    if name.startswith("askew"):
        k = CELL.index("A2")
        bent = replace(CELL.joints[k], after=dh_after(a=0.65, alpha=deg_to_rad(float(name.split()[1]))))
        cell = replace(CELL, joints=(*CELL.joints[:k], bent, *CELL.joints[k + 1 :]))
    q = np.zeros(len(cell))
    axes = base_T_joint_axes(cell, q)[cell.arm_slice]
    h, o = axes[:, :3, 2].copy(), axes[:, :3, 3].copy()
    if name.endswith("A6 beside A5"):
        o[5] += 0.01 * np.cross(h[5], h[4])
    if name == "backwards":
        h, o = -h[::-1], o[::-1].copy()
    return h, o, base_T_tool(cell, q)


def determinant(h: np.ndarray, o: np.ndarray, q: np.ndarray) -> float:
    """Of the six axes as lines where a posture has brought them: 0 where it is singular."""
    columns, T = [], np.eye(4)
    for i in range(6):
        z, at = T[:3, :3] @ h[i], T[:3, :3] @ o[i] + T[:3, 3]
        columns.append(np.concatenate([np.cross(at, z), z]))
        T = T @ screw_displacement(h[i : i + 1], o[i : i + 1], q[i : i + 1])
    return float(np.linalg.det(np.array(columns)))


@pytest.mark.parametrize("name", ["askew 0.02", "askew 0.3", "askew 2", "ur10e", "ur10e, A6 beside A5", "backwards"])
def test_a_row_is_one_posture_until_a_singular_one(name: str) -> None:
    h, o, foot_T_tool = axes_of(name)
    arm = screw_arm(h, o, foot_T_tool)
    assert arm is not None
    rng = np.random.default_rng(11)
    crossed, steps = 0, 400
    for _ in range(20):
        begin, end = rng.uniform(-np.pi, np.pi, (2, 6))
        q = begin + np.linspace(0.0, 1.0, steps)[:, None] * (end - begin)
        poses = np.ascontiguousarray(screw_displacement(h, o, q) @ foot_T_tool)
        Q, why = solve_screws_many(arm, poses, q)
        off = np.where(why == BRANCH_OK, np.abs(Q - q[:, None]).max(axis=2), np.inf)
        assert off.min(axis=1).max() < 1e-5
        row = off.argmin(axis=1)
        for k in np.flatnonzero(np.diff(row)):
            assert determinant(h, o, q[k]) * determinant(h, o, q[k + 1]) < 0.0
            crossed += 1
    assert crossed > 10
