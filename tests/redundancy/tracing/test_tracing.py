"""Tracing: poses given whole, an arm with an axis to spare, and things in the way; held to the laws, and to brute force."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob.bodies.bodies import base_T_bodies, cell_bodies
from camrob.bodies.room import cell_room, rooms
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.cell.shape import Shape, ShapeKind
from camrob.checks.collisions import check_collisions
from camrob.errors import UnreachableError
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.tracing.traced import TraceSettings, trace_poses

# modified rows alpha, a, theta, d of the Panda, degrees and mm: Franka Emika, "Robot and interface specifications"
ROWS = [
    [0, 0, 0, 333],
    [-90, 0, 0, 0],
    [90, 0, 0, 316],
    [90, 82.5, 0, 0],
    [-90, -82.5, 0, 384],
    [90, 0, 0, 0],
    [90, 88, 0, 107],
]
LIMITS = [
    (-2.8973, 2.8973),
    (-1.7628, 1.7628),
    (-2.8973, 2.8973),
    (-3.0718, -0.0698),
    (-2.8973, 2.8973),
    (-0.0175, 3.7525),
    (-2.8973, 2.8973),
]
START = np.array([0.3, -0.4, 0.2, -2.1, 0.1, 1.9, 0.6])


@pytest.fixture(scope="module")
def panda(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    folder: Path = tmp_path_factory.mktemp("panda")
    text = f'schema = 1\nname = "panda"\nstanding = "datasheet"\n[arm]\nconvention = "modified"\ndh = {ROWS}\n'
    (folder / "cell.toml").write_text(text)
    cell = read_cell(folder)
    joints = tuple(replace(j, lower=lo, upper=up) for j, (lo, up) in zip(cell.joints, LIMITS, strict=True))
    fore = np.eye(4)
    fore[2, 3] = -0.12
    hand = Shape("forearm", "forearm", "A5", ShapeKind.CAPSULE, np.array([0.06, 0.2]), fore)
    return replace(cell, joints=joints, shapes=(hand,))


def circle(cell: Cell, count: int = 60) -> np.ndarray:
    poses = np.tile(base_T_tool(cell, START), (count, 1, 1))
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    poses[:, 1, 3] += 0.1 * np.sin(turn)
    poses[:, 2, 3] += 0.1 * (1.0 - np.cos(turn))
    return poses


def with_box(cell: Cell, center: np.ndarray, size: float) -> Cell:
    at = np.eye(4)
    at[:3, 3] = center
    box = Shape("box", "box", "base", ShapeKind.BOX, np.full(3, size), at)
    return replace(cell, shapes=(*cell.shapes, box))


def kept(cell: Cell, poses: np.ndarray, q: np.ndarray, step: float) -> None:
    np.testing.assert_allclose(base_T_tool(cell, q), poses, atol=1e-8)
    assert np.all(q >= cell.q_lower) and np.all(q <= cell.q_upper)
    assert np.abs(np.diff(q, axis=0)).max() <= step


@pytest.mark.slow
def test_a_trace_keeps_poses_limits_and_steps_and_is_no_longer_than_the_axis_held(panda: Cell) -> None:
    poses, settings = circle(panda), TraceSettings()
    found = trace_poses(panda, poses)
    kept(panda, poses, np.asarray(found.q), settings.step_revolute)
    assert found.given == ("A7",) and found.step_rad == np.abs(np.diff(found.q, axis=0)).max()
    assert found.length_rad == pytest.approx(np.abs(np.diff(found.q, axis=0)).sum())
    # the same with A7 where it begins, followed by Newton's method: what an arm without the freedom would do
    held = [START]
    for pose in poses:
        q = held[-1].copy()
        for _ in range(30):
            T = base_T_tool(panda, q)
            error = np.concatenate([pose[:3, 3] - T[:3, 3], _rotation(T, pose)])
            J = np.stack([_column(panda, q, i) for i in range(6)], axis=1)
            q[:6] += np.linalg.solve(J, error)
        held.append(q)
    assert found.length_rad <= np.abs(np.diff(held[1:], axis=0)).sum()


def _rotation(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    R = b[:3, :3] @ a[:3, :3].T
    return 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


def _column(cell: Cell, q: np.ndarray, i: int, h: float = 1e-6) -> np.ndarray:
    up, down = q.copy(), q.copy()
    up[i] += h
    down[i] -= h
    a, b = base_T_tool(cell, down), base_T_tool(cell, up)
    return np.concatenate([b[:3, 3] - a[:3, 3], _rotation(a, b)]) / (2.0 * h)


@pytest.mark.slow
def test_what_stands_in_the_way_is_kept_clear_of_inside_the_search(panda: Cell) -> None:
    poses = circle(panda)
    free = np.asarray(trace_poses(panda, poses).q)
    elbow = base_T_forearm(panda, free[len(free) // 2])
    cell = with_box(panda, elbow, 0.06)
    room = cell_room(cell)
    assert rooms(room, free, 0.05).min() == 0.0  # the shortest way runs through it
    found = trace_poses(cell, poses, room=room)
    kept(cell, poses, np.asarray(found.q), TraceSettings().step_revolute)
    assert found.room > 0.0 and found.length_rad >= np.abs(np.diff(free, axis=0)).sum() - 0.05
    count = len(poses)
    cutting = np.ones(count, bool)
    report = check_collisions(
        cell, np.asarray(found.q), cutting=cutting, line=np.arange(count), region=np.zeros(count, int)
    )
    assert report.count == 0  # by the release's own check, between the poses too


def base_T_forearm(cell: Cell, q: np.ndarray) -> np.ndarray:
    return np.asarray(base_T_bodies(cell, cell_bodies(cell), q)[0][:3, 3])


@pytest.mark.slow
def test_a_refusal_says_what_was_tried_and_what_was_in_the_way(panda: Cell) -> None:
    poses = circle(panda)
    poses[30:, 0, 3] += 2.0
    with pytest.raises(
        UnreachableError,
        match=r"pose \d+ has no posture with all of closed form's branches at each of \d+ values of A7",
    ):
        trace_poses(panda, poses)
    walled = with_box(panda, circle(panda)[0, :3, 3], 1.5)
    with pytest.raises(UnreachableError, match=r"[1-9]\d* have no room; clear the way"):
        trace_poses(walled, circle(panda), room=cell_room(walled))
