"""Frames along a path: they turn as little as can be, where the paper's Frenet frames flip or don't exist."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.redundancy.free_frames import refine, rotation_minimising
from camrob.se3 import angle_between, rotation_exp


def zigzag(rows: int = 6, points: int = 20) -> np.ndarray:
    """Tips (N, 3) of a zig-zag over a gently curved surface."""
    out = []
    for row in range(rows):
        x = np.linspace(0.0, 0.1, points)
        x = x if row % 2 == 0 else x[::-1]
        out.append(np.stack([x, np.full(points, 0.005 * row), 0.01 * np.sin(20 * x)], axis=1))
    return np.concatenate(out)


def normals(tips: np.ndarray) -> np.ndarray:
    slope = 0.2 * np.cos(20 * tips[:, 0])
    n = np.stack([-slope, np.zeros(len(tips)), np.ones(len(tips))], axis=1)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def frenet(tips: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The paper's frames (section 3): x along the tangent, z the tool axis."""
    t = np.gradient(tips, axis=0)
    x = t - np.sum(t * axis, axis=1, keepdims=True) * axis
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(axis, x), axis], axis=2)


def largest_turn(R: np.ndarray) -> float:
    return float(angle_between(R[:-1], R[1:]).max())


def test_no_flip_on_a_zigzag_where_frenet_flips() -> None:
    tips = zigzag()
    axis = normals(tips)
    R = rotation_minimising(axis, np.array([1.0, 0.0, 0.0]))
    assert largest_turn(frenet(tips, axis)) > 1.5
    tilt = np.arccos(np.clip(np.sum(axis[1:] * axis[:-1], axis=1), -1, 1)).max()
    assert largest_turn(R) == pytest.approx(tilt, abs=1e-6)  # no more than the axis itself


def test_frames_are_rotations_with_the_axis_as_z() -> None:
    rng = np.random.default_rng(1)
    axis = rng.normal(size=(200, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    R = rotation_minimising(axis, np.array([0.3, -1.0, 0.2]))
    np.testing.assert_allclose(np.swapaxes(R, 1, 2) @ R, np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)
    np.testing.assert_allclose(R[:, :, 2], axis, atol=1e-12)


def test_every_step_is_the_least_rotation() -> None:
    """Parallel transport: from one frame to the next the rotation has no part about the tool's axis."""
    rng = np.random.default_rng(2)
    w = np.cumsum(rng.normal(0, 0.05, (300, 3)), axis=0)
    axis = rotation_exp(w)[:, :, 2]
    R = rotation_minimising(np.ascontiguousarray(axis), np.array([1.0, 0.0, 0.0]))
    turned = angle_between(R[:-1], R[1:])
    between = np.arctan2(np.linalg.norm(np.cross(axis[:-1], axis[1:]), axis=1), np.sum(axis[:-1] * axis[1:], axis=1))
    np.testing.assert_allclose(turned, between, atol=1e-9)


def test_a_round_trip_turns_by_the_solid_angle() -> None:
    """What is known on paper: carried round a spherical triangle of three right angles, x turns by a right angle."""
    corners = np.eye(3)
    edges = []
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        s = np.linspace(0.0, np.pi / 2, 50)[:, None]
        edges.append(np.cos(s) * a + np.sin(s) * b)
    R = rotation_minimising(np.ascontiguousarray(np.concatenate(edges)), np.array([0.0, 1.0, 0.0]))
    assert float(angle_between(R[0], R[-1])) == pytest.approx(np.pi / 2, abs=1e-9)


def test_the_first_x_is_kept_as_far_as_it_goes() -> None:
    axis = np.tile([0.0, 0.0, 1.0], (3, 1))
    R = rotation_minimising(axis, np.array([3.0, 0.0, 7.0]))
    np.testing.assert_allclose(R, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-15)


def test_hard_cases_stay_rotations() -> None:
    up = np.array([0.0, 0.0, 1.0])
    for axis, first in (
        (np.array([up, -up, up]), np.array([1.0, 0.0, 0.0])),  # half turns
        (np.array([up, up]), up),  # x_first along the axis
        (np.array([up, up]), np.zeros(3)),
        (np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([1.0, 0.0, 0.0])),
    ):
        R = rotation_minimising(axis, first)
        np.testing.assert_allclose(np.swapaxes(R, 1, 2) @ R, np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
        np.testing.assert_allclose(R[:, :, 2], axis, atol=1e-12)


def test_refining_keeps_the_points_and_its_promises() -> None:
    rng = np.random.default_rng(3)
    tips = np.cumsum(rng.normal(0, 0.03, (50, 3)), axis=0)
    axis = rotation_exp(np.cumsum(rng.normal(0, 0.1, (50, 3)), axis=0))[:, :, 2]
    tips[20] = tips[19]  # a turn on the spot
    axis[30], tips[31] = axis[29], tips[30]
    axis[31] = axis[30]  # the same point twice
    points, axes, where = refine(tips, np.ascontiguousarray(axis), 0.02, 0.05)
    np.testing.assert_array_equal(points[where], tips)
    np.testing.assert_array_equal(axes[where], axis)
    assert where[0] == 0 and where[-1] == len(points) - 1 and np.all(np.diff(where) >= 1)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= 0.02 * (1 + 1e-6)
    turn = np.arctan2(np.linalg.norm(np.cross(axes[:-1], axes[1:]), axis=1), np.sum(axes[:-1] * axes[1:], axis=1))
    assert turn.max() <= 0.05 * (1 + 1e-6)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0, atol=1e-12)
    for k in range(1, len(where)):  # on the straight line and the great arc, evenly
        inside = slice(where[k - 1], where[k] + 1)
        s = np.linspace(0.0, 1.0, where[k] - where[k - 1] + 1)[:, None]
        np.testing.assert_allclose(points[inside], tips[k - 1] + s * (tips[k] - tips[k - 1]), atol=1e-12)
        normal = np.cross(axis[k - 1], axis[k])
        np.testing.assert_allclose(axes[inside] @ normal, 0.0, atol=1e-12)


def test_nothing_to_refine() -> None:
    tips = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]])
    axis = np.tile([0.0, 0.0, 1.0], (2, 1))
    points, _, where = refine(tips, axis, 0.02, 0.05)
    assert len(points) == 2 and where.tolist() == [0, 1]
    points, _, where = refine(tips[:1], axis[:1], 0.02, 0.05)
    assert len(points) == 1 and where.tolist() == [0]
