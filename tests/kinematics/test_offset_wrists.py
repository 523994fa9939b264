"""Arms whose last axis misses the point in which the two before it meet: FANUC CRX, Yaskawa HC10, and drawn ones."""

from __future__ import annotations

import numpy as np
import pytest
from test_screw_arms import random_axes, searched

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.screw_arm import OFFSET, solve_screws, solve_screws_many
from camrob.kinematics.screw_families import screw_arm, screw_displacement
from camrob.kinematics.spherical_wrist import BRANCH_OK

# axes (direction, a point of it in m) at 0 as the makers' ROS packages give them: fanuc_crx_description, motoman_hc10_support
CRX10 = [
    ((0, 0, 1), (0, 0, 0.245)), ((0, 1, 0), (0, 0, 0.245)), ((0, -1, 0), (0, 0, 0.955)),
    ((-1, 0, 0), (0, 0, 0.955)), ((0, -1, 0), (0.54, -0.15, 0.955)), ((-1, 0, 0), (0.7, -0.15, 0.955)),
]  # fmt: skip
HC10 = [
    ((0, 0, 1), (0, 0, 0.275)), ((0, 1, 0), (0, 0, 0.275)), ((0, -1, 0), (0, 0, 0.975)),
    ((0, 0, 1), (0, 0, 0.475)), ((0, -1, 0), (0, 0.162, 0.475)), ((0, 0, 1), (0, 0.162, 0.475)),
]  # fmt: skip


def axes_of(rows: list) -> tuple[np.ndarray, np.ndarray]:
    return np.array([h for h, _ in rows], float), np.array([o for _, o in rows], float)


def drawn(kind: str) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    h, o = random_axes("", rng)
    first, second = (3, 4) if kind == "drawn" else (1, 2)
    o[second] = o[first]
    return h, o


ARMS = {"CRX-10iA": lambda: axes_of(CRX10), "HC10": lambda: axes_of(HC10)}
DRAWN = {"drawn": lambda: drawn("drawn"), "drawn, read backwards": lambda: drawn("backwards")}


def near_most(found: np.ndarray, why: np.ndarray, q: np.ndarray) -> np.ndarray:
    return np.where(why == BRANCH_OK, np.abs(found - q[:, None]).max(axis=2), np.inf).min(axis=1)


@pytest.mark.parametrize("name", [*ARMS, *DRAWN])
def test_nearly_every_posture_is_given_back_and_each_that_is_meets_the_pose(name: str) -> None:
    h, o = {**ARMS, **DRAWN}[name]()
    foot_T_tool = np.eye(4)
    foot_T_tool[:3, 3] = 0.1, 0.2, 0.9
    arm = screw_arm(h, o, foot_T_tool)
    assert arm is not None and (arm.family, arm.mirrored) == (OFFSET, name == "drawn, read backwards")
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (400, 6))
    poses = np.ascontiguousarray(screw_displacement(h, o, q) @ foot_T_tool)
    Q, why = solve_screws_many(arm, poses, q)
    assert np.mean(near_most(Q, why, q) < 1e-6) >= (0.97 if name in ARMS else 0.92)
    k, b = np.nonzero(why == BRANCH_OK)
    np.testing.assert_allclose(screw_displacement(h, o, Q[k, b]) @ foot_T_tool, poses[k], atol=1e-9)
    if name in ARMS:
        assert np.median((why == BRANCH_OK).sum(axis=1)) == 8


def determinant(h: np.ndarray, o: np.ndarray, q: np.ndarray) -> float:
    """Of the six axes where they stand in a posture, their screws taken from displacements alone."""
    rows, step = [], 1e-6
    back = np.linalg.inv(screw_displacement(h, o, q))
    for i in range(6):
        T = screw_displacement(h, o, q + step * np.eye(6)[i]) @ back
        rows.append([*T[:3, 3], T[2, 1], T[0, 2], T[1, 0]])
    return float(np.linalg.det(np.array(rows) / step))


@pytest.mark.parametrize("name", ARMS)
def test_a_posture_keeps_its_row_along_a_path_but_where_the_arm_or_a_way_folds(name: str) -> None:
    """The first three axes may be stretched to the point where the wrist's is, the sixth turned as it is, and the whole arm not
    be singular: there a posture passes from one way to the other.
    """
    h, o = ARMS[name]()
    arm = screw_arm(h, o, np.eye(4))
    rng = np.random.default_rng(2)
    lost = total = folded = 0
    for _ in range(12):
        begin, way = rng.uniform(-2.0, 2.0, 6), rng.normal(size=6)
        q = begin + np.linspace(0.0, 0.6, 121)[:, None] * way / np.linalg.norm(way)
        poses = np.ascontiguousarray(screw_displacement(h, o, q))
        row, sign = -1, 0.0
        for pose, before, posture in zip(poses, q[[0, *range(120)]], q, strict=True):
            Q, why = solve_screws_many(arm, pose[None], before[None])
            off = np.where(why[0] == BRANCH_OK, np.abs(Q[0] - posture).max(axis=1), np.inf)
            k, now = int(np.argmin(off)), np.sign(determinant(h, o, posture))
            total += 1
            if off[k] > 1e-6:
                lost += 1
                continue
            folded += k != row and row >= 0 and now == sign
            row, sign = k, now
    assert lost <= 0.02 * total and folded <= 3


@pytest.mark.parametrize("name", [*ARMS, *DRAWN])
def test_one_row_that_is_asked_for_is_as_among_all(name: str) -> None:
    h, o = {**ARMS, **DRAWN}[name]()
    arm = screw_arm(h, o, np.eye(4))
    rng, found = np.random.default_rng(7), 0
    for q in rng.uniform(-np.pi, np.pi, (2, 6)):
        pose, near = screw_displacement(h, o, q[None])[0], q + 0.2 * rng.normal(size=6)
        every, alone = np.zeros((8, 6)), np.zeros((8, 6))
        why, its = np.zeros(8, np.int64), np.zeros(8, np.int64)
        solve_screws(arm, pose[:3, :3], pose[:3, 3], near, every, why)
        for row in range(8):
            solve_screws(arm, pose[:3, :3], pose[:3, 3], near, alone, its, row)
            assert its[row] == why[row]
            if why[row] == BRANCH_OK:
                np.testing.assert_allclose(alone[row], every[row], atol=1e-8)
                found += 1
    assert found >= 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_search_from_many_starts_finds_hardly_a_posture_more(name: str) -> None:
    h, o = ARMS[name]()
    cell = as_cell(h, o)
    assert not Arm.of(cell).searched and not Arm.of(cell).proves
    rng = np.random.default_rng(3)
    total = missed = 0
    for _ in range(4):
        q = rng.uniform(-3.0, 3.0, 6)
        pose = base_T_tool(cell, q)
        ours = np.array(Arm.of(cell).turned(pose, q))
        for other in searched(cell, pose, {}, 40, rng):
            apart = (ours - other + np.pi) % (2.0 * np.pi) - np.pi
            missed += np.abs(apart).max(axis=1).min() > 1e-4
            total += 1
    assert total >= 12 and missed <= 0.15 * total


def as_cell(h: np.ndarray, o: np.ndarray) -> Cell:
    """The KR15 cell with an arm of these axes, alone."""
    from test_screw_arms import arm_cell

    joints, before = [], np.eye(4)
    for k in range(6):
        z = h[k]
        x = np.cross(z, [0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0])
        frame = np.eye(4)
        frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(z, x), z, o[k]
        joints.append(
            Joint(f"A{k + 1}", Role.ARM, False, np.linalg.inv(before) @ frame, np.eye(4), lower=-6.2, upper=6.2)
        )
        before = frame
    return arm_cell(joints)
