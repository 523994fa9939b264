"""The gate: each thing that must stop a program does, with axis, line and size, and nothing stops a sound one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL
from krl_rows import HOME, e6axis, lin, ptp_pose, read_rows

from camrob.controller import judge as gate
from camrob.controller.against import cover
from camrob.controller.judge import judge
from camrob.controller.replay import replay
from camrob.kinematics.frames import base_T_tool

START = CELL.to_q(np.array([-10.0, -85, 85, 5, 80, -12, 30, 8]))


def way(count: int = 12) -> np.ndarray:
    """Postures of a dense cut: about a millimetre from one to the next."""
    step = np.radians([0.02, 0.0, 0.05, 0.05, 0.02, 0.04, 0.03, 0.04, 0.0])
    step[CELL.index("E1")] = 0.0003
    return START + np.arange(count)[:, None] * step


def judged(tmp_path, postures, *, feed=0.05, rows=None, cell=CELL):
    """A program through the postures, judged against CL points at them, all but the first cut at 0.05 m/s."""
    rows = [ptp_pose(postures[0]), *(lin(q) for q in postures[1:])] if rows is None else rows
    program = read_rows(tmp_path, HOME, *rows)
    replayed = replay(program, cell)
    unrolled = postures.copy()
    unrolled[:, -1] = 0.0
    n = len(postures)
    coverage = cover(
        base_T_tool(CELL, unrolled),
        np.arange(n) + 1,
        np.zeros(n, np.int64),
        np.asarray(replayed.base_T_tool),
        np.asarray(program.kind),
    )
    feeds = np.full(n, feed)
    feeds[0] = np.nan
    return program, judge(program, replayed, coverage, feeds)


def codes(judgement) -> list[str]:
    return [f.code for f in judgement.findings]


def test_a_sound_program_passes(tmp_path) -> None:
    _, j = judged(tmp_path, way())
    assert j.good and codes(j) == [] and j.singular == 0
    assert j.second_library_poses == 12 and j.second_library_error < 1e-8
    assert set(j.margin) == set(CELL.axis_names) and j.margin["E2"] is None
    margin = CELL.to_axis_values(way())[:, 4].max()
    assert j.margin["A5"] == pytest.approx(135.0 - max(margin, 90.0), abs=0.01)
    assert j.margin["E1"] == pytest.approx(1500.0 - 1e3 * way()[-1, CELL.index("E1")], abs=0.01)


def test_a_limit(tmp_path) -> None:
    joints = list(CELL.joints)
    i = CELL.index("A4")
    top = way()[:, i].max()
    joints[i] = replace(joints[i], upper=float(joints[i].axis_value(np.asarray(top))) - 0.001)
    program, j = judged(tmp_path, way(), cell=replace(CELL, joints=tuple(joints)))
    found = next(f for f in j.findings if f.code == "axis-limit")
    assert not j.good and found.axis == "A4" and found.line in program.line.tolist()
    assert found.value == pytest.approx(np.degrees(0.001), abs=1e-4) and found.unit == "degrees"


def test_a_straight_wrist(tmp_path) -> None:
    postures = way()
    postures[:, CELL.index("A5")] = np.pi - np.linspace(0.02, -0.02, len(postures))
    _, j = judged(tmp_path, postures)
    assert "singular" in codes(j) and j.singular >= 1 and not j.good


@pytest.mark.parametrize(("axis", "far"), [("E1", 0.25), ("E2", np.radians(40))])
def test_a_leap_of_an_external_axis(tmp_path, axis: str, far: float) -> None:
    """One point with the track or the table elsewhere: reached, within limits, on the line, and refused."""
    postures = way()
    odd = postures[6].copy()
    odd[CELL.index(axis)] += far
    from krl_rows import e6pos

    unrolled = postures[6].copy()
    unrolled[-1] = 0.0
    values = CELL.to_axis_values(odd)
    rows = [ptp_pose(postures[0]), *(lin(q) for q in postures[1:])]
    rows[6] = f"LIN {e6pos(base_T_tool(CELL, unrolled), values[6], values[7])}"
    _, j = judged(tmp_path, postures, rows=rows)
    found = [f for f in j.findings if f.code == "axis-jump"]
    assert any(f.axis == axis and f.count == 2 and f.point == 7 for f in found), j.findings
    assert set(codes(j)) == {"axis-jump"}


def test_a_turn_of_the_table_within_one_motion(tmp_path) -> None:
    """Refused wherever it happens, cutting or not: with the base on the table the arm would have to go round it."""
    turned = way()[1].copy()
    turned[CELL.index("E2")] += 2 * np.pi
    turned[CELL.index("A6")] -= 2 * np.pi
    program = read_rows(tmp_path, HOME, ptp_pose(START), lin(turned))
    assert "axis-jump" in codes(judge(program, replay(program, CELL)))
    half = read_rows(tmp_path, HOME, ptp_pose(START), lin(way()[1]))
    assert judge(half, replay(half, CELL)).good


def test_speed(tmp_path) -> None:
    assert judged(tmp_path, way(), feed=0.05)[1].good
    assert judged(tmp_path, way(), feed=0.08)[1].good  # slower than the feed is safe
    _, j = judged(tmp_path, way(), feed=0.0499)
    found = next(f for f in j.findings if f.code == "speed")
    assert found.count == 11 and found.value == pytest.approx(0.05) and found.limit == pytest.approx(0.0499)


def test_no_speed_is_reported_without_a_number(tmp_path) -> None:
    import krl_rows

    postures = way()
    rows = [ptp_pose(postures[0]), *(lin(q) for q in postures[1:])]
    program = read_rows(tmp_path, HOME, *rows, head=krl_rows.HEAD.replace("$VEL.CP = 0.05\n", ""))
    replayed = replay(program, CELL)
    n = len(postures)
    coverage = cover(
        np.asarray(replayed.base_T_tool)[1:],
        np.arange(n),
        np.zeros(n, np.int64),
        np.asarray(replayed.base_T_tool),
        np.asarray(program.kind),
    )
    j = judge(program, replayed, coverage, np.full(n, 0.05))
    assert next(f for f in j.findings if f.code == "speed").value is None


def test_a_ptp_through_a_cut(tmp_path) -> None:
    postures = way()
    rows = [ptp_pose(postures[0]), *(lin(q) for q in postures[1:])]
    rows[6] = ptp_pose(postures[6])
    program, j = judged(tmp_path, postures, rows=rows)
    found = next(f for f in j.findings if f.code == "ptp-cuts")
    assert found.line == program.line[7] and not j.good


def test_the_second_library_is_heard(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another opinion on the poses that differs by 0.1 micrometres stops the release."""
    real = gate.pinocchio_poses

    def off(cell, q):
        out = np.array(real(cell, q))
        out[len(out) // 2, 0, 3] += 1e-7
        return out

    monkeypatch.setattr(gate, "pinocchio_poses", off)
    _, j = judged(tmp_path, way())
    assert codes(j) == ["second-library"] and j.second_library_error == pytest.approx(1e-7, rel=1e-3)


def test_what_replay_and_coverage_say_is_heard(tmp_path) -> None:
    postures = way()
    rows = [ptp_pose(postures[0], status=1), *(lin(q) for q in postures[1:])]
    assert "ptp-unreachable" in codes(judged(tmp_path, postures, rows=rows)[1])
    rows = [ptp_pose(postures[0]), *(lin(q) for q in postures[1:5]), *(lin(q) for q in postures[6:])]
    bent = postures.copy()
    bent[5, CELL.index("A1")] += 0.002
    assert "cl-point-missed" in codes(judged(tmp_path, bent, rows=rows)[1])


def test_home_is_no_singular_posture(tmp_path) -> None:
    program = read_rows(tmp_path, HOME, e6axis(START), e6axis(CELL.q_home))
    j = judge(program, replay(program, CELL))
    assert j.good and j.second_library_poses == 0


@pytest.mark.parametrize(("left", "warned"), [(4.9, True), (5.1, False)])
def test_a_slide_that_comes_close_to_its_end_is_a_warning(tmp_path, left, warned) -> None:
    joints, i = list(CELL.joints), CELL.index("E1")
    top = float(joints[i].axis_value(np.asarray(way()[:, i].max())))
    joints[i] = replace(joints[i], upper=top + 1e-3 * left)
    _, j = judged(tmp_path, way(), cell=replace(CELL, joints=tuple(joints)))
    found = [(f.axis, f.unit, f.limit) for f in j.findings if f.code == "axis-margin"]
    assert j.good and found == [("E1", "mm", pytest.approx(5.0))] * warned


@pytest.mark.parametrize(("left", "warned"), [(0.03, True), (1.9, True), (2.1, False)])
def test_an_axis_that_comes_close_to_its_limit_is_a_warning_with_what_is_left(tmp_path, left, warned) -> None:
    """On lines alone: the PTP before them ends on its target, whatever is rounded."""
    joints, i = list(CELL.joints), CELL.index("A4")
    top = float(joints[i].axis_value(np.asarray(way()[:, i].max())))
    joints[i] = replace(joints[i], upper=top + np.radians(left))
    program, j = judged(tmp_path, way(), cell=replace(CELL, joints=tuple(joints)))
    found = [f for f in j.findings if f.code == "axis-margin"]
    assert j.good and len(found) == warned
    for f in found:
        assert (f.axis, f.unit, f.limit, f.severity) == ("A4", "degrees", pytest.approx(2.0), "warning")
        assert f.value == pytest.approx(left, abs=1e-3) and f.line in program.line.tolist()
        assert "A4 comes within 0.030 degrees of its limit" in f.text or left > 1.0
    held = replace(joints[i], lower=top - np.radians(0.5), upper=top + np.radians(0.5))
    joints[i] = held
    assert "axis-margin" not in codes(judged(tmp_path, way(), cell=replace(CELL, joints=tuple(joints)))[1])
