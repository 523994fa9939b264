"""Replay: what a program's text makes the cell do, held to postures known beforehand and to plain twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL
from krl_rows import HEAD, HOME, circ, e6axis, e6pos, lin, ptp_pose, read_rows

from camrob.controller.replay import replay
from camrob.controller.trace import posture_trace
from camrob.errors import ProgramError
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.se3 import angle_between, pose, slerp

PART = CELL.arm_slice


def posture(*axes: float) -> np.ndarray:
    return CELL.to_q(np.array(axes))


A = posture(-10, -85, 85, 5, 80, -12, 30, 8)
B = posture(-6, -80, 82, -8, 74, 10, 60, 14)
C = posture(-2, -84, 88, -3, 78, 4, 20, 3)


def codes(replayed) -> list[str]:
    return [f.code for f in replayed.findings]


def test_the_postures_come_back(tmp_path) -> None:
    program = read_rows(tmp_path, HOME, ptp_pose(A), lin(B), lin(C), e6axis(CELL.q_home))
    replayed = replay(program, CELL)
    assert codes(replayed) == []
    expected = np.stack([CELL.q_home, A, B, C, CELL.q_home])
    np.testing.assert_allclose(replayed.q, expected, atol=1e-8)
    unrolled = expected.copy()
    unrolled[:, -1] = 0.0
    np.testing.assert_allclose(replayed.base_T_tool, base_T_tool(CELL, unrolled), atol=1e-8)
    assert replayed.samples > 20


def lin_twin(q0: np.ndarray, q1: np.ndarray, count: int) -> np.ndarray:
    """The controller's LIN in plain NumPy: pose straight and along the great arc, external axes even, arm by its inverse."""
    q0, q1 = q0.copy(), q1.copy()
    q0[-1] = q1[-1] = 0.0
    s = np.linspace(0.0, 1.0, count)
    T0, T1 = base_T_tool(CELL, q0), base_T_tool(CELL, q1)
    frames = pose(slerp(T0[None, :3, :3], T1[None, :3, :3], s), T0[:3, 3] + s[:, None] * (T1[:3, 3] - T0[:3, 3]))
    postures = q0 + s[:, None] * (q1 - q0)
    arm = Arm.of(CELL)
    near = q0[PART]
    for k in range(count):
        found = arm.branches(arm.foot_T_tool(frames[k], postures[k]), near)
        near = postures[k, PART] = min(found, key=lambda f: np.abs(f - near).max())
    return postures


def test_what_happens_on_the_way_against_the_twin(tmp_path) -> None:
    program = read_rows(tmp_path, HOME, ptp_pose(A), lin(B))
    replayed = replay(program, CELL)
    twin = lin_twin(A, B, 400)
    margin = np.minimum(twin - CELL.q_lower, CELL.q_upper - twin).min(axis=0)
    real = [i for i in range(len(CELL)) if np.isfinite(margin[i])]
    expected = np.asarray(replayed.margin)[1:3].min(axis=0)  # the way's begin is the PTP's end
    np.testing.assert_allclose(expected[real], margin[real], atol=2e-3)
    chain = chain_arrays(CELL)
    assert replayed.inv_kf[2] == pytest.approx(inverse_kf_many(chain, twin).min(), abs=2e-3)
    assert replayed.bend[2] == pytest.approx(np.abs(np.sin(twin[:, PART][:, 4])).min(), abs=2e-3)
    assert 0.0 < replayed.jump[2] < 0.1


def test_a_circle_is_a_circle(tmp_path) -> None:
    """Half a circle of 30 mm: on its way the tool stays 30 mm from the centre, which a straight line does not."""
    T = base_T_tool(CELL, np.append(A[:-1], 0.0))
    points = []
    for angle in (0.0, np.pi / 2, np.pi):
        frame = T.copy()
        frame[:3, 3] += 0.03 * np.array([np.cos(angle) - 1.0, np.sin(angle), 0.0])
        points.append(frame)
    e = CELL.to_axis_values(A)[6:]
    rows = [f"CIRC {e6pos(points[1], *e)},{e6pos(points[2], *e)}"]
    program = read_rows(tmp_path, HOME, ptp_pose(A), *rows)
    replayed = replay(program, CELL)
    assert codes(replayed) == []
    reached = base_T_tool(CELL, np.asarray(replayed.q))
    np.testing.assert_allclose(reached[3], points[2], atol=1e-8)
    center = T[:3, 3] + np.array([-0.03, 0.0, 0.0])
    assert np.linalg.norm(reached[2, :3, 3] - center) == pytest.approx(0.03, abs=1e-8)
    assert np.linalg.norm(reached[2, :3, 3] - points[1][:3, 3]) < 0.004  # about at the auxiliary point


def test_circ_without_kinematics_between_is_found_by_the_helper(tmp_path) -> None:
    program = read_rows(tmp_path, HOME, ptp_pose(A), circ(B, C))
    assert codes(replay(program, CELL)) == []


def test_out_of_reach_stops_there(tmp_path) -> None:
    far = base_T_tool(CELL, np.append(B[:-1], 0.0))
    far[2, 3] += 3.0
    program = read_rows(tmp_path, HOME, ptp_pose(A), lin(B), f"LIN {e6pos(far, 60, 14)}", lin(C))
    replayed = replay(program, CELL)
    assert codes(replayed) == ["out-of-reach"]
    found = replayed.findings[0]
    assert found.point == 3 and found.line == program.line[3]
    np.testing.assert_allclose(np.asarray(replayed.q)[2], B, atol=1e-8)
    np.testing.assert_array_equal(np.asarray(replayed.q)[4, PART], np.asarray(replayed.q)[3, PART])


def test_a_limit_between_the_ends_is_seen(tmp_path) -> None:
    """Both ends within A3's limits, the middle of the way beyond: the margin is that of the middle."""
    twin = lin_twin(A, B, 400)
    i = CELL.index("A2")
    ends = max(twin[0, i], twin[-1, i])
    top = twin[:, i].max()
    if top <= ends + 1e-6:
        i, ends, top = CELL.index("E1"), 0.0, 0.0
    joints = list(CELL.joints)
    k = CELL.index("A2")
    joints[k] = replace(joints[k], upper=float(joints[k].axis_value(np.asarray(0.5 * (ends + top)))))
    if top > ends:
        replayed = replay(read_rows(tmp_path, HOME, ptp_pose(A), lin(B)), replace(CELL, joints=tuple(joints)))
        assert replayed.margin[2, k] == pytest.approx(0.5 * (ends - top), abs=1e-4)


def test_status_chooses_the_branch_and_turn_the_turn(tmp_path) -> None:
    from camrob.cell.status_turn import StatusTurn

    arm, st = Arm.of(CELL), StatusTurn.of(CELL)
    frame = arm.foot_T_tool(base_T_tool(CELL, A), A)
    found = arm.branches(frame, A[PART])
    turned = A.copy()
    turned[CELL.index("A6")] += 2 * np.pi
    assert len(found) >= 2
    for other in [*found, turned[PART]]:
        q = A.copy()
        q[PART] = other
        axes = CELL.to_axis_values(q)[None, :6]
        row = ptp_pose(A, int(st.status(axes)[0]), int(st.turn(axes)[0]))
        replayed = replay(read_rows(tmp_path, HOME, row), CELL)
        assert codes(replayed) == []
        np.testing.assert_allclose(np.asarray(replayed.q)[1, PART], other, atol=1e-8)


def test_a_status_that_no_posture_has(tmp_path) -> None:
    replayed = replay(read_rows(tmp_path, HOME, ptp_pose(A, status=1), lin(B)), CELL)
    assert codes(replayed) == ["ptp-unreachable"] and "S 1" in replayed.findings[0].text


def test_a_program_that_begins_with_lin_says_so(tmp_path) -> None:
    near_home = CELL.q_home.copy()
    near_home[CELL.index("A1")] += 0.02
    assert codes(replay(read_rows(tmp_path, lin(near_home)), CELL)) == ["no-entry"]


def test_programs_of_another_cell_are_refused(tmp_path) -> None:
    with pytest.raises(ProgramError, match="E3"):
        replay(read_rows(tmp_path, HOME.replace("E2 0", "E2 0,E3 5")), CELL)
    assert codes(replay(read_rows(tmp_path, HOME.replace("E2 0", "E2 0,E3 0")), CELL)) == ["tool-unknown"]
    with pytest.raises(ProgramError, match="no motion"):
        replay(read_rows(tmp_path, ";nothing"), CELL)
    with pytest.raises(ProgramError, match="more than one"):
        replay(read_rows(tmp_path, HOME, lin(A), "$TOOL = {X 0,Y 0,Z 100,A 0,B 0,C 0}", lin(B)), CELL)


def test_a_base_that_is_offset(tmp_path) -> None:
    """The same way, given in a base that lies elsewhere on the table: the same postures."""
    from camrob.se3 import frame_from_xyzabc, inverse

    base_T_krl = frame_from_xyzabc(np.array([0.1, -0.2, 0.05, 0.4, 0.1, -0.2]))
    a, b, c = np.degrees([0.4, 0.1, -0.2])
    expected = f"{{X 100,Y -200,Z 50,A {a:.9f},B {b:.9f},C {c:.9f}}})"
    head = HEAD.replace("{X 0,Y 0,Z 0,A 0,B 0,C 0})", expected)
    frame = inverse(base_T_krl) @ base_T_tool(CELL, np.append(B[:-1], 0.0))
    e = CELL.to_axis_values(B)[6:]
    program = read_rows(tmp_path, e6axis(A), f"LIN {e6pos(frame, *e)}", head=head)
    np.testing.assert_allclose(np.asarray(replay(program, CELL).q)[1], B, atol=1e-8)


def test_the_trace_leaves_no_gap(tmp_path) -> None:
    program = read_rows(tmp_path, HOME, ptp_pose(A), lin(B), lin(C), e6axis(CELL.q_home))
    replayed = replay(program, CELL)
    postures, rows = posture_trace(program, replayed)
    assert np.all(np.diff(rows) >= 0) and set(rows.tolist()) == set(range(5))
    np.testing.assert_allclose(postures[np.append(np.diff(rows) > 0, True)], replayed.q, atol=1e-12)
    inside = np.isin(rows[1:], (2, 3))
    assert np.abs(np.diff(postures, axis=0))[inside].max() < 0.06
    frames = base_T_tool(CELL, postures[rows == 2])
    T0, T1 = np.asarray(replayed.base_T_tool)[[1, 2]]
    s = np.linalg.norm(frames[:, :3, 3] - T0[:3, 3], axis=1) / np.linalg.norm(T1[:3, 3] - T0[:3, 3])
    np.testing.assert_allclose(frames[:, :3, 3], T0[:3, 3] + s[:, None] * (T1[:3, 3] - T0[:3, 3]), atol=1e-9)
    assert angle_between(frames[:, :3, :3], slerp(T0[None, :3, :3], T1[None, :3, :3], s)).max() < 1e-8
