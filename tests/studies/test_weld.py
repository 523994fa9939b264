"""The welding robot: kinematics against differences, the published scheme, true optima, torques against point masses."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from feed_paths import CELL as KR15
from feed_paths import wave

from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.dynamics.torques import joint_torques
from camrob.errors import InputError, SingularError
from camrob.jobs.feed import feed
from camrob.jobs.studies.weld import weld
from camrob.kinematics.adjusting import follow_points, point_jacobians
from camrob.kinematics.frames import base_T_joint_frames, base_T_tool, world_T_base
from camrob.report.feed.page import weld_statements
from camrob.studies.published_feed import constant_feed_bound, marched_feed, raised_feed
from camrob.studies.seam import read_seam, seam_motion
from camrob.studies.weld_study import study_weld

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "ta1400_weld"
CELL = read_cell(FOLDER)


@cache
def study():
    return study_weld(CELL, read_seam(FOLDER))


def test_the_printed_limits_and_start_are_the_cells():
    assert CELL.limits_of("speed").tolist() == pytest.approx([2.97, 3.32, 3.32, 6.64, 6.54, 10.5], rel=1e-12)
    assert CELL.limits_of("acceleration").tolist() == pytest.approx([7.4, 8.3, 8.3, 16.2, 16.4, 26.3], rel=1e-12)
    assert CELL.limits_of("jerk").tolist() == pytest.approx([37, 41.5, 41.5, 81, 82, 131.5], rel=1e-12)
    assert CELL.q_home.tolist() == pytest.approx([0.78, 1.34, 0.23, 0.15, 1.22, 0.0], abs=1e-12)
    assert sum(m.mass for m in CELL.masses) == pytest.approx(50 + 39 + 46 + 20 + 3.2 + 2.7)
    # the printed posture stands near the seam's first point (0.7, 0.7, 0.8), so Table I is read as it was meant
    assert np.linalg.norm(base_T_tool(CELL, CELL.q_home)[:3, 3] - [0.7, 0.7, 0.8]) < 0.045


def test_derivatives_of_the_jacobian_are_those_of_differences_on_both_cells():
    for cell in (CELL, KR15):
        rng = np.random.default_rng(3)
        a, b, q = (rng.standard_normal((1, len(cell))) for _ in range(3))
        h = 1e-4

        def at(t, cell=cell, a=a, b=b, q=q):
            return point_jacobians(cell, q + a * t + 0.5 * b * t * t, a + b * t, b)

        J, J1, J2 = at(0.0)
        assert np.allclose(J1, (at(h)[0] - at(-h)[0]) / (2 * h), atol=1e-6)
        assert np.allclose(J2, (at(h)[0] - 2 * J + at(-h)[0]) / h**2, atol=1e-5)
        e = np.zeros((1, len(cell)))
        e[0, 1] = h
        tips = [base_T_tool(cell, q + sign * e)[0, :3, 3] for sign in (1, -1)]
        assert np.allclose(J[0, :, 1], (tips[0] - tips[1]) / (2 * h), atol=1e-6)


def test_true_derivatives_hold_and_the_printed_ones_do_not():
    motion = seam_motion(CELL, read_seam(FOLDER), 500)
    assert motion.error.max() < 1e-12
    inner = slice(4, -4)
    second = np.gradient(motion.joints.d1, motion.s, axis=0)[inner]
    third = np.gradient(motion.joints.d2, motion.s, axis=0)[inner]
    true2, true3 = motion.joints.d2[inner], motion.joints.d3[inner]
    assert np.abs(true2 - second).max() < 2e-4 * np.abs(second).max()
    assert np.abs(true3 - third).max() < 5e-4 * np.abs(third).max()
    slip, _jerk_slip, curve_slip = study().slip
    assert 0.01 < slip < 0.05 and curve_slip > 0.1
    assert np.abs(motion.printed.d2[inner] - second).max() > 20.0 * np.abs(true2 - second).max()
    assert np.abs(motion.printed.d3[inner] - third).max() > 20.0 * np.abs(true3 - third).max()
    # the correction itself, as one formula
    J, J1, _ = point_jacobians(CELL, motion.joints.q, motion.joints.d1, motion.joints.d2)
    JT = np.swapaxes(J, 1, 2)
    plus = JT @ np.linalg.inv(J @ JT)
    y = np.linalg.solve(J @ JT, motion.x1[..., None])
    missing = (np.eye(6) - plus @ J) @ np.swapaxes(J1, 1, 2) @ y
    assert np.allclose(motion.printed.d2 + missing[..., 0], motion.joints.d2, atol=1e-10)


def test_the_seams_own_derivatives_over_length():
    motion = seam_motion(CELL, read_seam(FOLDER), 400)
    inner = slice(3, -3)
    assert np.allclose(np.linalg.norm(motion.x1, axis=1), 1.0)
    assert np.allclose(np.gradient(motion.x1, motion.s, axis=0)[inner], motion.x2[inner], atol=2e-3)
    assert np.abs(np.gradient(motion.x1, motion.s, axis=0)[inner] - motion.printed_x2[inner]).max() > 1.0
    assert np.allclose(np.sum(motion.x1 * motion.x2, axis=1), 0.0, atol=1e-12)


def test_no_limit_binds_below_half_a_metre_a_second():
    joints = study().fine.joints
    bound = constant_feed_bound(joints.d1, joints.d2, joints.d3, study().bounds)
    assert bound.min() == pytest.approx(0.526, abs=0.003)
    low, high = study().schemes
    assert np.all(low.published.feed == pytest.approx(0.3))
    assert high.published.feed.min() == pytest.approx(0.525) and high.published.feed.max() == pytest.approx(1.2)


def test_the_scheme_stops_at_the_last_step_below_a_planted_bound():
    d1 = np.array([[2.0], [4.0], [100.0]])
    zero = np.zeros_like(d1)
    bounds = study().bounds._replace(speed=np.array([1.0]), acceleration=np.array([1.0]), jerk=np.array([1.0]))
    found = raised_feed(d1, zero, zero, bounds, first=0.01, step=0.02, top=0.4)
    assert found.feed.tolist() == pytest.approx([0.39, 0.25, 0.01])
    assert found.stopped.tolist() == [-1, 0, 0]


def test_a_march_climbs_a_step_a_point_and_falls_back_where_a_planted_bound_breaks():
    """Speeds of 1 rad/s at 2 rad/m allow 0.5 m/s, at 4 rad/m 0.25: the steps below, of 0.1 from 0.01 on, are 0.41 and 0.21."""
    d1 = np.repeat([[2.0], [4.0], [2.0]], [7, 2, 2], axis=0)
    zero, s = np.zeros_like(d1), 0.1 * np.arange(len(d1))
    free = study().bounds._replace(speed=np.array([1.0]), acceleration=np.array([np.inf]), jerk=np.array([np.inf]))
    found = marched_feed(s, d1, zero, zero, free, first=0.01, step=0.1, top=1.0)
    assert found == pytest.approx([0.01, 0.11, 0.21, 0.31, 0.41, 0.41, 0.41, 0.21, 0.21, 0.31, 0.41])
    slow = free._replace(acceleration=np.array([0.5]))  # of 2 rad/m times u, which a first step takes to 0.12
    assert marched_feed(s, d1, zero, zero, slow, first=0.01, step=0.1, top=1.0)[:3] == pytest.approx([0.01, 0.11, 0.21])
    slower = free._replace(acceleration=np.array([0.11]))
    assert marched_feed(s, d1, zero, zero, slower, first=0.01, step=0.1, top=1.0)[:3] == pytest.approx(
        [0.01, 0.01, 0.01]
    )


def test_both_readings_of_the_scheme_are_told():
    low, high = study().schemes
    assert low.marched[:59] == pytest.approx(0.01 + 0.005 * np.arange(59)) and np.all(
        low.marched[58:] == pytest.approx(0.3)
    )
    assert high.marched[-1] == pytest.approx(0.51)  # 100 steps: it never comes to a limit
    assert max(low.marched_use.max(), high.marched_use.max()) < 0.6
    told = weld_statements(CELL, study())[2]
    assert told.verdict == "unclear" and "0.300 m/s throughout" in told.found and "0.010 to 0.300 m/s" in told.found


def test_the_true_optimum_is_not_slower_and_breaks_nothing():
    low, high = study().schemes
    assert low.use.max() < 1.0  # the published profile at 0.3 m/s is feasible: the optimum must reach it
    assert low.moving.grid.at[-1] <= low.at[-1] * (1.0 + 1e-6)
    assert high.use[2] > 2.0  # at 1.2 m/s it is not, with its own df/dt and d2f/dt2
    for scheme in (low, high):
        for found in (scheme.moving, scheme.resting):
            assert found.use.max() <= 1.0 + 1e-9
            b = study().bounds
            inner = slice(20, -20)
            assert np.abs(found.acceleration / b.acceleration).max() <= 1.001
            assert np.abs(found.jerk / b.jerk)[inner].max() <= 1.01


def test_the_assumed_torch_changes_figures_and_not_findings():
    tools = study().tools
    assert len(tools) == 5 and tools[0].feed == pytest.approx(study().bound.min())
    assert len({round(t.feed, 4) for t in tools}) == 5
    assert all(t.feed > 0.3 and int(np.argmax(t.largest)) == 1 for t in tools)


def test_joint_2_carries_the_largest_torque():
    largest = np.abs(study().torques.total).max(axis=0)
    assert int(np.argmax(largest)) == 1
    assert all(int(np.argmax(case.largest)) == 1 for case in study().loads)
    assert 300.0 < largest[1] < 600.0


@pytest.mark.parametrize("cell", [CELL, KR15], ids=["ta1400", "kr15"])
def test_torques_are_those_of_point_masses(cell):
    """d'Alembert over point masses in the hall, by differences of their positions: no recursion, no Pinocchio."""
    rng = np.random.default_rng(5)
    q0 = wave(7)[3:4] if cell is KR15 else cell.q_home[None]
    v, a = 0.3 * rng.standard_normal((2, 1, len(cell)))
    moving = [i for i, j in enumerate(cell.joints) if j.role.value in ("carriage", "arm")]
    for i in range(len(cell)):
        if i not in moving:
            v[0, i] = a[0, i] = 0.0
    got = joint_torques(cell, q0, v, a)
    h, g = 1e-4, np.array([0.0, 0.0, 9.80665])

    def centres(q):
        frames = base_T_joint_frames(cell, q)
        world = world_T_base(cell, q)
        return np.array([(world @ frames[cell.index(m.after)])[:3] @ [*m.center, 1.0] for m in cell.masses])

    here = q0[0]
    path = [centres(here + v[0] * t + 0.5 * a[0] * t * t) for t in (-h, 0.0, h)]
    push = (path[0] - 2 * path[1] + path[2]) / h**2 + g
    masses = np.array([m.mass for m in cell.masses])
    for i in moving:
        e = np.zeros(len(cell))
        e[i] = 1e-6
        along = (centres(here + e) - centres(here - e)) / 2e-6
        assert got.total[0, i] == pytest.approx(np.sum(masses * np.sum(push * along, axis=1)), rel=1e-4, abs=1e-3)
        assert got.gravity[0, i] == pytest.approx(np.sum(masses * (along @ g)), rel=1e-4, abs=1e-3)
    assert np.all(got.total[0, [i for i in range(len(cell)) if i not in moving]] == 0.0)


def test_a_point_out_of_reach_is_reported():
    with pytest.raises(SingularError):
        follow_points(CELL, CELL.q_home, np.array([[5.0, 0.0, 0.0]]))


def test_the_command_writes_the_report_and_a_summary(tmp_path, capsys):
    assert run(["study", "weld", "--cell", str(FOLDER), "--out", str(tmp_path), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["torque_max_nm"]["A2"] > summary["torque_max_nm"]["A3"]
    assert {s["verdict"] for s in summary["statements"]} <= {"holds", "does not hold", "unclear"}
    page = (tmp_path / "feed.html").read_text(encoding="utf-8")
    assert "Figure 6" in page and "Joint 2 carries the largest torque" in page


def test_a_cell_without_a_seam_says_what_to_do(tmp_path):
    cell = FOLDER.parent / "kr15_track_table"
    old = "no path to analyse, and this cell has no paper's own; give a solved path or a program"
    with pytest.warns(DeprecationWarning, match="camrob study weld"), pytest.raises(InputError, match=old):
        feed(None, cell=cell, out=tmp_path)
    with pytest.raises(InputError, match=r"no seam.toml, the weld seam .*; add it, as in cells/ta1400_weld"):
        weld(cell=cell, out=tmp_path)
    assert not list(tmp_path.iterdir())
