"""Closed forms by screw axes: every posture that a search from many starts finds, and none that misses the pose."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from follower_twins import CELL
from scipy.optimize import least_squares

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.errors import CellError
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.freed_chain import freed_chain, freed_chains, reach_chain
from camrob.kinematics.screw_arm import PARALLEL, WRIST, solve_screws_many
from camrob.kinematics.screw_families import screw_arm, screw_displacement
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.kinematics.trig_quartic import conic_angles, square_onto
from camrob.se3 import rotation_log

# standard rows a, alpha, d of the UR10e, m and rad: Universal Robots, "DH parameters for calculations of kinematics and dynamics"
UR10E = [
    (0.0, np.pi / 2, 0.1807),
    (-0.6127, 0.0, 0.0),
    (-0.57155, 0.0, 0.0),
    (0.0, np.pi / 2, 0.17415),
    (0.0, -np.pi / 2, 0.11985),
    (0.0, 0.0, 0.11655),
]
# modified rows a, alpha, d of the Panda: Franka Emika, "Robot and interface specifications"; the last is the flange
PANDA = [
    (0.0, 0.0, 0.333),
    (0.0, -np.pi / 2, 0.0),
    (0.0, np.pi / 2, 0.316),
    (0.0825, np.pi / 2, 0.0),
    (-0.0825, -np.pi / 2, 0.384),
    (0.0, np.pi / 2, 0.0),
    (0.088, np.pi / 2, 0.107),
]
PANDA_LIMITS = [
    (-2.8973, 2.8973),
    (-1.7628, 1.7628),
    (-2.8973, 2.8973),
    (-3.0718, -0.0698),
    (-2.8973, 2.8973),
    (-0.0175, 3.7525),
    (-2.8973, 2.8973),
]


# place in the joint before, m, and axis of the Fetch's arm: Fetch Robotics, fetch_description/robots/fetch.urdf
FETCH = [
    ((0.119525, 0.0, 0.34858), "z"),
    ((0.117, 0.0, 0.06), "y"),
    ((0.219, 0.0, 0.0), "x"),
    ((0.133, 0.0, 0.0), "y"),
    ((0.197, 0.0, 0.0), "x"),
    ((0.1245, 0.0, 0.0), "y"),
    ((0.1385, 0.0, 0.0), "x"),
]


def arm_cell(joints: list[Joint]) -> Cell:
    """The KR15 cell with another arm, alone."""
    return replace(CELL, joints=tuple(joints), wrist_T_flange=np.eye(4), foot_T_root=np.eye(4), shapes=(), masses=())


def ur10e() -> list[Joint]:
    return [
        Joint(
            f"A{k + 1}", Role.ARM, False, dh_before(theta=0.0, d=d), dh_after(a=a, alpha=alpha), lower=-6.2, upper=6.2
        )
        for k, (a, alpha, d) in enumerate(UR10E)
    ]


def panda() -> list[Joint]:
    rows = zip(PANDA, PANDA_LIMITS, strict=True)
    return [
        Joint(
            f"A{k + 1}",
            Role.ARM,
            False,
            dh_after(a=a, alpha=alpha) @ dh_before(theta=0.0, d=d),
            np.eye(4),
            lower=lo,
            upper=up,
        )
        for k, ((a, alpha, d), (lo, up)) in enumerate(rows)
    ]


def fetch() -> list[Joint]:
    onto = {"x": [[0, 0, 1], [1, 0, 0], [0, 1, 0]], "y": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "z": np.eye(3)}
    joints = []
    for k, (place, axis) in enumerate(FETCH):
        before, after = np.eye(4), np.eye(4)
        before[:3, :3], before[:3, 3] = onto[axis], place
        after[:3, :3] = np.transpose(onto[axis])
        joints.append(Joint(f"A{k + 1}", Role.ARM, False, before, after, lower=-2.2, upper=2.2))
    return joints


def random_axes(kind: str, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    h = rng.normal(size=(6, 3))
    h /= np.linalg.norm(h, axis=1)[:, None]
    o = rng.uniform(-0.5, 0.5, (6, 3))
    if "wrist" in kind:
        o[3:] = o[4]
    if "shoulder" in kind:
        o[:3] = o[1]
    if "12 meet" in kind:
        o[0] = o[1]
    if "12 parallel" in kind:
        h[0] = -h[1]
    if "23 parallel" in kind:
        h[1] = -h[2]
    if "234" in kind:
        h[1], h[3] = -h[2], h[2]
    if "345" in kind:
        h[2], h[4] = -h[3], h[3]
    if "56 meet" in kind:
        o[5] = o[4]
    return h, o


KINDS = {
    "wrist": (WRIST, False),
    "wrist, 12 meet": (WRIST, False),
    "wrist, 12 parallel": (WRIST, False),
    "wrist, 23 parallel": (WRIST, False),
    "shoulder": (WRIST, True),
    "234": (PARALLEL, False),
    "234, 56 meet": (PARALLEL, False),
    "345": (PARALLEL, True),
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_family_gives_back_every_posture_and_meets_the_pose(kind: str) -> None:
    rng = np.random.default_rng(list(KINDS).index(kind))
    foot_T_tool = screw_displacement(*random_axes("", rng), rng.uniform(-1, 1, 6))
    tried = 0
    while tried < 4:
        h, o = random_axes(kind, rng)
        if (
            min(np.linalg.norm(np.cross(a, b)) for a, b in pairwise(h[3:] if "wrist" in kind else h[:3])) < 0.1
            and "3" not in kind
        ):
            continue  # three axes that meet and hardly turn against each other are no wrist
        arm = screw_arm(h, o, foot_T_tool)
        if arm is None and "wrist" in kind:
            continue
        assert arm is not None and (arm.family, arm.mirrored) == KINDS[kind]
        tried += 1
        q = rng.uniform(-np.pi, np.pi, (300, 6))
        poses = np.ascontiguousarray(screw_displacement(h, o, q) @ foot_T_tool)
        Q, why = solve_screws_many(arm, poses, q)
        good = why == BRANCH_OK
        off = np.where(good, np.abs(Q - q[:, None]).max(axis=2), np.inf).min(axis=1)
        assert off.max() < 1e-6
        k, b = np.nonzero(good)
        np.testing.assert_allclose(screw_displacement(h, o, Q[k, b]) @ foot_T_tool, poses[k], atol=1e-9)


def searched(
    cell: Cell, pose: np.ndarray, given: dict[int, float], starts: int, rng: np.random.Generator
) -> list[np.ndarray]:
    """Postures within limits by bounded least squares from random starts, each once."""
    free = [i for i in range(len(cell)) if i not in given]
    lower, upper = np.maximum(cell.q_lower, -np.pi)[free], np.minimum(cell.q_upper, np.pi)[free]
    q = np.zeros(len(cell))
    for i, value in given.items():
        q[i] = value

    def error(x: np.ndarray) -> np.ndarray:
        q[free] = x
        T = base_T_tool(cell, q)
        return np.concatenate([T[:3, 3] - pose[:3, 3], rotation_log(T[:3, :3].T @ pose[:3, :3])])

    found: list[np.ndarray] = []
    for _ in range(starts):
        one = least_squares(error, rng.uniform(lower, upper), bounds=(lower, upper), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        inside = np.all((one.x > lower + 1e-6) & (one.x < upper - 1e-6))
        if one.cost < 1e-20 and inside and all(np.abs(one.x - f).max() > 1e-4 for f in found):
            found.append(one.x)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["ur10e", "panda"])
def test_no_search_from_many_starts_finds_a_posture_more(arm: str) -> None:
    cell = arm_cell(ur10e() if arm == "ur10e" else panda())
    chain = freed_chain(cell)
    assert [cell.names[i] for i in chain.given] == ([] if arm == "ur10e" else ["A7"])
    rng = np.random.default_rng(4)
    total = 0
    for _ in range(4):
        q = rng.uniform(np.maximum(cell.q_lower, -np.pi), np.minimum(cell.q_upper, np.pi))
        pose = base_T_tool(cell, q)
        ours = reach_chain(chain, pose, q)
        np.testing.assert_allclose(base_T_tool(cell, ours), np.broadcast_to(pose, (len(ours), 4, 4)), atol=1e-9)
        for other in searched(cell, pose, {int(i): q[i] for i in chain.given}, 40, rng):
            apart = (ours[:, chain.six] - other + np.pi) % (2.0 * np.pi) - np.pi
            assert np.abs(apart).max(axis=1).min() < 1e-4
            total += 1
    assert total >= 8


@pytest.mark.parametrize("arm", ["panda", "fetch"])
def test_an_arm_with_an_axis_to_spare_frees_one_that_leaves_all_postures_and_meets_poses_exactly(arm: str) -> None:
    cell = arm_cell(panda() if arm == "panda" else fetch())
    chains = freed_chains(cell)
    assert {chain.family for chain in chains} == {WRIST}  # several of the other choices have a form that is searched
    assert cell.names[int(chains[0].given[0])] == {"panda": "A7", "fetch": "A1"}[arm]
    for q in np.random.default_rng(9).uniform(np.maximum(cell.q_lower, -2.0), np.minimum(cell.q_upper, 2.0), (20, 7)):
        pose = base_T_tool(cell, q)
        ours = reach_chain(chains[0], pose, q)
        np.testing.assert_allclose(base_T_tool(cell, ours), np.broadcast_to(pose, (len(ours), 4, 4)), atol=1e-11)
        apart = np.abs((ours - q + np.pi) % (2.0 * np.pi) - np.pi)
        assert apart.max(axis=1).min() < 1e-6


def test_the_chain_with_freedoms_has_the_postures_of_the_arm_module() -> None:
    chain, arm = freed_chain(CELL), Arm.of(CELL)
    assert [CELL.names[i] for i in chain.given] == ["E2", "E1", "roll"]
    rng = np.random.default_rng(2)
    lower = np.where(np.isfinite(CELL.q_lower), CELL.q_lower, -3.0)
    upper = np.where(np.isfinite(CELL.q_upper), CELL.q_upper, 3.0)
    wide = replace(arm, lower=np.full(6, -100.0), upper=np.full(6, 100.0))
    for q in rng.uniform(lower, upper, (200, len(CELL))):
        pose = base_T_tool(CELL, q)
        ours = reach_chain(chain, pose, q)[:, CELL.arm_slice]
        theirs = np.array(wide.branches(arm.foot_T_tool(pose, q), q[CELL.arm_slice]))
        assert ours.shape == theirs.shape
        apart = np.abs((ours[:, None] - theirs[None] + np.pi) % (2.0 * np.pi) - np.pi).max(axis=2)
        assert apart.min(axis=0).max() < 1e-6 and apart.min(axis=1).max() < 1e-6


def test_an_arm_that_just_misses_its_family_has_the_postures_of_its_neighbour_continued() -> None:
    rng = np.random.default_rng(8)

    def calibrated(j: Joint) -> Joint:
        slip = dh_before(theta=rng.normal(0, 1e-3), d=rng.normal(0, 5e-4))
        return replace(j, after=j.after @ slip @ dh_after(a=rng.normal(0, 5e-4), alpha=rng.normal(0, 1e-3)))

    joints = [calibrated(j) for j in ur10e()]
    cell = arm_cell(joints)
    arm = Arm.of(cell)
    assert arm.closed is None and arm.screws is not None and not arm.searched
    lost = 0
    q = rng.uniform(-3.0, 3.0, (300, 6))
    for row, pose in zip(q, base_T_tool(cell, q), strict=True):
        found = np.array(arm.branches(arm.foot_T_tool(pose, row), row))
        np.testing.assert_allclose(base_T_tool(cell, found), np.broadcast_to(pose, (len(found), 4, 4)), atol=1e-8)
        lost += not len(found) or np.abs(found - row).max(axis=1).min() > 1e-6
    assert lost <= 6  # at the border of what the neighbour reaches, its postures end


def test_an_arm_without_closed_form_says_that_it_is_searched() -> None:
    rng = np.random.default_rng(1)
    joints = [
        replace(j, after=j.after @ dh_after(a=rng.uniform(0.1, 0.3), alpha=rng.uniform(0.5, 1.0))) for j in ur10e()
    ]
    cell = arm_cell(joints)
    assert Arm.of(cell).searched
    with pytest.raises(CellError, match="no six of its turning axes have a closed form"):
        freed_chain(cell)


def test_angles_of_a_conic_are_all_there_are() -> None:
    rng = np.random.default_rng(6)
    angle = np.linspace(-np.pi, np.pi, 20001)
    counts = set()
    for _ in range(300):
        f = np.zeros(6)
        for sign in (1.0, 1.0, -1.0):
            square_onto(f, sign, *rng.normal(size=3))
        c, s = np.cos(angle), np.sin(angle)
        value = f @ np.stack([np.ones_like(c), c, s, c * c, c * s, s * s])
        crossed = angle[:-1][value[:-1] * value[1:] < 0.0]
        out = np.empty(4)
        found = np.sort((out[: conic_angles(f, out)] + np.pi) % (2.0 * np.pi) - np.pi)
        assert len(found) >= len(crossed)
        for at in crossed:
            assert np.abs(found - at).min() < 1e-3
        counts.add(len(found))
    assert counts == {0, 2, 4}
