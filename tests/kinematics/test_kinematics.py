"""Forward kinematics, Jacobian and conditioning: known truths, derivatives, and the plain twins of the kernels."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from camrob.cell.read_cell import read_cell
from camrob.kinematics import frames, kernels
from camrob.kinematics.best_condition import best_condition
from camrob.se3 import angle_between, frame_from_xyzabc, inverse, rotation_log, xyzabc_from_frame
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)
CHAIN = kernels.chain_arrays(CELL)
with (FOLDER / "poses.csv").open(encoding="utf-8", newline="") as stream:
    POSES = {row["name"]: row for row in csv.DictReader(stream)}


def numbers(row: dict[str, str], *names: str) -> np.ndarray:
    return np.array([float(row[name]) for name in names])


def random_postures(count: int, seed: int = 7) -> np.ndarray:
    rng = np.random.default_rng(seed)
    lower = np.where(np.isfinite(CELL.q_lower), CELL.q_lower, -7.0)
    upper = np.where(np.isfinite(CELL.q_upper), CELL.q_upper, 7.0)
    return rng.uniform(lower, upper, (count, len(CELL)))


def kernel_jacobians(q: np.ndarray) -> np.ndarray:
    n = q.shape[1]
    Z, P, R, p, plate = np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    out = np.empty((len(q), 6, n))
    for k in range(len(q)):
        kernels.forward(CHAIN, q[k], Z, P, R, p, plate)
        kernels.jacobian(CHAIN, Z, P, p, out[k])
    return out


def plain_inverse_kf(q: np.ndarray, length: float) -> float:
    """Eq. 16 from its definition, on numeric derivatives of the mounting plate's pose in `root`."""
    step = 1e-6
    columns = []
    for i in range(CELL.arm_slice.start, CELL.arm_slice.stop):
        dq = np.zeros(len(q))
        dq[i] = step
        ends = [inverse(frames.base_T_root(CELL, x)) @ frames.base_T_flange(CELL, x) for x in (q - dq, q + dq)]
        v = (ends[1][:3, 3] - ends[0][:3, 3]) / (2 * step)
        w = rotation_log(ends[1][:3, :3] @ ends[0][:3, :3].T) / (2 * step)
        columns.append(np.concatenate([v / length, w]))
    H = np.array(columns).T
    return 6.0 / (np.linalg.norm(H) * np.linalg.norm(np.linalg.inv(H)))


@pytest.mark.parametrize("name", POSES)
def test_known_poses(name):
    row = POSES[name]
    axes = numbers(row, *(f"{n}_{'mm' if n == 'E1' else 'deg'}" for n in CELL.axis_names))
    q = numbers(row, *(f"q_{n}_{'m' if n == 'E1' else 'rad'}" for n in CELL.names))
    np.testing.assert_allclose(CELL.to_q(axes), q, atol=1e-12)
    np.testing.assert_allclose(CELL.to_axis_values(q), axes, atol=1e-9)

    xyz_mm, abc_deg = numbers(row, "x_mm", "y_mm", "z_mm"), numbers(row, "a_deg", "b_deg", "c_deg")
    base_T_given = frame_from_xyzabc(np.concatenate([mm_to_m(xyz_mm), deg_to_rad(abc_deg)]))
    for base_T_tool in (frames.base_T_tool(CELL, q), kernels.forward_many(CHAIN, q[None])[0]):
        np.testing.assert_allclose(m_to_mm(base_T_tool[:3, 3]), xyz_mm, atol=6e-4)
        assert rad_to_deg(float(angle_between(base_T_given[:3, :3], base_T_tool[:3, :3]))) < 1e-3
        np.testing.assert_allclose(base_T_tool[:3, 2], numbers(row, "tool_z_x", "tool_z_y", "tool_z_z"), atol=6e-5)
    if row["inv_kf"]:
        assert kernels.inverse_kf_many(CHAIN, q[None])[0] == pytest.approx(float(row["inv_kf"]), abs=6e-5)


def test_home_is_the_papers():
    base_T_tool = frames.base_T_tool(CELL, CELL.q_home)
    np.testing.assert_allclose(m_to_mm(base_T_tool[:3, 3]), [97.0, -41.764, 619.422], atol=5e-4)
    np.testing.assert_allclose(base_T_tool[:3, 2], [0.0, 0.3489, 0.9372], atol=6e-5)
    assert kernels.inverse_kf_many(CHAIN, CELL.q_home[None])[0] == pytest.approx(0.5725, abs=5e-5)


def test_smallest_condition_number_of_the_arm_is_the_papers():
    """k_F = 1.2477 at L = 350.57 mm, found over A2..A6 and L together from the cell's own data."""

    def condition(x):
        q = CELL.q_home.copy()
        q[3:8] = x[:5]
        value = kernels.inverse_kf_many(CHAIN._replace(length=float(np.exp(x[5]))), q[None])[0]
        return 1.0 / max(value, 1e-6)

    rng = np.random.default_rng(3)
    best = None
    for _ in range(12):
        start = np.append(CELL.q_home[3:8] + rng.uniform(-1.0, 1.0, 5), np.log(0.4))
        found = minimize(condition, start, method="BFGS", options={"gtol": 1e-7})
        if best is None or found.fun < best.fun:
            best = found
    polished = minimize(
        condition, best.x, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 4000}
    )
    assert polished.fun == pytest.approx(1.2477, abs=5e-5)
    assert m_to_mm(float(np.exp(polished.x[5]))) == pytest.approx(350.57, abs=5e-3)
    assert m_to_mm(CELL.condition_length) == pytest.approx(350.57)


def test_the_best_condition_of_a_cell_is_the_papers():
    """Section 2.3: 1.247 at 350.6 mm; joints that have no part in k_F stay at HOME."""
    found = best_condition(CELL)
    assert found.kf == pytest.approx(1.2477, abs=5e-5)
    assert m_to_mm(found.length) == pytest.approx(350.57, abs=5e-3)
    assert found.kf < 1.248 and str(found.kf).startswith("1.247")
    chain = CHAIN._replace(length=found.length)
    assert 1.0 / kernels.inverse_kf_many(chain, found.q[None])[0] == pytest.approx(found.kf, abs=1e-8)
    assert np.all(found.q >= CELL.q_lower) and np.all(found.q <= CELL.q_upper)
    for name in ("E2", "E1", "A1", "A6"):
        assert found.q[CELL.index(name)] == CELL.q_home[CELL.index(name)]


def test_inverse_kf_is_equation_16():
    for q in random_postures(20):
        assert kernels.inverse_kf_many(CHAIN, q[None])[0] == pytest.approx(
            plain_inverse_kf(q, CELL.condition_length), abs=2e-8
        )


def test_inverse_kf_ignores_what_is_not_the_arm():
    """Table, track, A1, A6, roll and tool change nothing: k_F is the bare arm's."""
    for q in random_postures(10):
        moved = q.copy()
        moved[[0, 1, 2, 7, 8]] += [1.0, 0.2, -0.7, 0.9, 2.0]
        other = kernels.chain_arrays(CELL.with_tool(frame_from_xyzabc(np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))))
        expected = kernels.inverse_kf_many(CHAIN, q[None])[0]
        assert kernels.inverse_kf_many(CHAIN, moved[None])[0] == pytest.approx(expected, abs=1e-9)
        assert kernels.inverse_kf_many(other, q[None])[0] == pytest.approx(expected, abs=1e-9)


def test_kernels_and_their_plain_twin_agree():
    q = random_postures(500)
    assert np.max(np.abs(kernels.forward_many(CHAIN, q) - frames.base_T_tool(CELL, q))) < 1e-13


def test_jacobian_is_the_derivative():
    q = random_postures(40)
    step = 1e-6
    J = kernel_jacobians(q)
    for i in range(len(CELL)):
        dq = np.zeros(len(CELL))
        dq[i] = step
        before, after = frames.base_T_tool(CELL, q - dq), frames.base_T_tool(CELL, q + dq)
        v = (after[:, :3, 3] - before[:, :3, 3]) / (2 * step)
        w = rotation_log(after[:, :3, :3] @ np.swapaxes(before[:, :3, :3], 1, 2)) / (2 * step)
        np.testing.assert_allclose(J[:, :, i], np.concatenate([v, w], axis=1), atol=2e-9)


def test_roll_is_the_tools_own_axis():
    q = random_postures(20)
    rolled = q.copy()
    rolled[:, -1] += 1.3
    a, b = frames.base_T_tool(CELL, q), frames.base_T_tool(CELL, rolled)
    np.testing.assert_allclose(a[:, :3, 2:], b[:, :3, 2:], atol=1e-12)


def test_world_stands_where_base_is_at_e2_zero():
    np.testing.assert_allclose(frames.world_T_base(CELL, CELL.q_home), np.eye(4), atol=1e-12)
    q = CELL.to_q(np.array([0, -90, 90, 0, 90, 0, 0, 30.0]))
    world_T_base = frames.world_T_base(CELL, q)
    np.testing.assert_allclose(rotation_log(world_T_base[:3, :3]), [0, 0, -deg_to_rad(30.0)], atol=1e-12)
    np.testing.assert_allclose(world_T_base[:3, 3], 0.0, atol=1e-12)


@pytest.mark.parametrize(("e1_mm", "e2_deg"), [(0.0, 0.0), (-900.0, 0.0), (700.0, 123.0), (20.0, -400.0)])
def test_root_runs_along_the_track_and_stays_parallel_to_world(e1_mm, e2_deg):
    q = CELL.to_q(np.array([10, -80, 70, 20, 60, 5, e1_mm, e2_deg]))
    world_T_root = frames.world_T_base(CELL, q) @ frames.base_T_root(CELL, q)
    np.testing.assert_allclose(m_to_mm(world_T_root[:3, 3]), [-803.0, e1_mm, -305.0], atol=1e-9)
    np.testing.assert_allclose(world_T_root[:3, :3], np.eye(3), atol=1e-12)


def test_flange_and_tool_frames_are_kukas():
    """The plate looks down at HOME, z out of it; $TOOL is the spec's."""
    base_T_flange = frames.base_T_flange(CELL, CELL.q_home)
    np.testing.assert_allclose(base_T_flange[:3, 2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(m_to_mm(base_T_flange[:3, 3]), [97.0, 0.0, 1035.0], atol=1e-9)
    xyzabc = xyzabc_from_frame(CELL.flange_T_tool)
    np.testing.assert_allclose(m_to_mm(xyzabc[:3]), [0.0, -41.764, 415.578], atol=5e-4)
    np.testing.assert_allclose(rad_to_deg(xyzabc[3:]), [0.0, 0.0, -159.580], atol=5e-4)


def test_tool_row_is_table_1s_own():
    """The last two rows of Table 1 (A6 with d -443.4 and 0.3564 rad, roll with d -119.7) end in the same tool."""
    q = random_postures(10)
    row_a6 = frame_from_xyzabc(np.array([0, 0, mm_to_m(-443.4), 0, 0, 0.3564]))
    row_roll = frame_from_xyzabc(np.array([0, 0, mm_to_m(-119.7), 0, 0, 0]))
    base_T_a5 = frames.base_T_joint_frames(CELL, q)[CELL.index("A5")]
    turn = np.zeros((len(q), 6))
    turn[:, 3] = q[:, CELL.index("A6")]
    roll = np.zeros((len(q), 6))
    roll[:, 3] = q[:, CELL.index("roll")]
    expected = base_T_a5 @ frame_from_xyzabc(turn) @ row_a6 @ frame_from_xyzabc(roll) @ row_roll
    np.testing.assert_allclose(frames.base_T_tool(CELL, q), expected, atol=1e-8)


def test_tools_of_many_postures_are_those_of_each() -> None:
    """More than are worked on at a time, and none."""
    q = random_postures(5000)
    np.testing.assert_allclose(frames.tool_poses(CELL, q), frames.base_T_tool(CELL, q), rtol=0, atol=1e-12)
    assert frames.tool_poses(CELL, q[:0]).shape == (0, 4, 4)
