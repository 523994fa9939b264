"""The tracker loop: eq. 1 to 3 against another library, the loop's theory against simulation, and what must be refused."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.errors import CellError, InputError, JobError, SingularError, UnreachableError
from camrob.jobs.tracker import tracker
from camrob.kinematics.frames import base_T_tool, tool_jacobians
from camrob.loop.analysis import JointLoop
from camrob.loop.case import TrackerNoise, read_tracker_case
from camrob.loop.gain import check_gain, choose_gain, joint_loops
from camrob.loop.identified_joints import JointLags, ahead_of, identify_lags, joint_errors
from camrob.loop.learning import best_lead, contraction
from camrob.loop.loop import LoopRun, measured_noise, simulate
from camrob.loop.measures import Size, across, measure_run, off_path, reversals
from camrob.loop.paths import circle_path, square_path, travelled
from camrob.loop.robot import friction_state
from camrob.loop.tracker_error import (
    TrackerReading,
    base_pose,
    components,
    printed_order,
    reading_of,
    setpoint_error,
    tracker_pose,
)
from camrob.se3 import frame_from_xyzabc, inverse

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "cells" / "rx160_tracker"
CELL = read_cell(FOLDER)
CASE = read_tracker_case(FOLDER)
SILENT = TrackerNoise(0.0, 0.0, 1000.0)
NONE = np.zeros(6)
# a robot without errors of any kind, and with the static one alone
PERFECT = replace(CASE.robot, delay=0, lag=NONE, lost=NONE, friction=NONE, link=0.0, link_angle=0.0, static=NONE)
STATIC = replace(PERFECT, static=CASE.robot.static)
SMALL = replace(CASE, side=0.06, radius=0.04, rest=0.6, switched_on=2.0)


@cache
def small_paths():
    return square_path(CELL, SMALL), circle_path(CELL, SMALL)


def run_of(path, robot, **more):
    return replace(LoopRun(path, robot, SILENT, 0), **more)


# ---- the machine


def test_the_cell_is_as_tall_and_as_long_as_its_maker_says():
    upright = base_T_tool(CELL, CELL.to_q(np.zeros(6)))[:3, 3]
    assert upright[2] == pytest.approx(0.550 + 0.825 + 0.625 + 0.110 + 0.150)  # with the target 150 mm before the plate
    stretched = base_T_tool(CELL, CELL.to_q(np.array([0.0, 90.0, 0.0, 0.0, 0.0, 0.0])))[:3, 3]
    assert stretched[0] == pytest.approx(1.600 + 0.110 + 0.150)  # 1600 mm of reach up to axis 5
    assert CELL.masses == ()  # two sources disagree: neither is used
    assert {"paper", "assumed"} == set(CASE.provenance.values())
    assert CASE.provenance["loop.gain"] == CASE.provenance["tracker.noise_mm"] == "paper"
    assert all(s == "assumed" for k, s in CASE.provenance.items() if k.startswith("robot."))


# ---- eq. 1 to 3


def test_equation_1_is_the_rotation_of_another_library_and_spherical_coordinates():
    turns = Rotation.random(300, random_state=1)
    rng = np.random.default_rng(2)
    r, theta, alpha = rng.uniform(0.5, 9.0, 300), rng.uniform(-3.1, 3.1, 300), rng.uniform(0.05, 3.0, 300)
    reading = TrackerReading(r, theta, alpha, turns.as_quat(scalar_first=True))
    T = tracker_pose(reading)
    assert np.allclose(T[:, :3, :3], turns.as_matrix(), atol=1e-14)
    assert np.allclose(np.linalg.norm(T[:, :3, 3], axis=1), r)
    assert np.allclose(T[:, 2, 3], r * np.cos(alpha))
    straight = tracker_pose(TrackerReading(*(np.array([v]) for v in (2.0, np.pi / 2, np.pi / 2)), np.eye(4)[:1]))
    assert np.allclose(straight[0, :3, 3], [0.0, 2.0, 0.0]) and np.allclose(straight[0, :3, :3], np.eye(3))
    back = reading_of(T)
    assert np.allclose(tracker_pose(back), T, atol=1e-12)
    for half in (np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1])):
        T[0, :3, :3] = half
        assert np.allclose(tracker_pose(reading_of(T[:1])), T[:1], atol=1e-12)


def test_equation_2_holds_in_the_other_order_only():
    base_T_tracker = frame_from_xyzabc(np.array([3.2, -0.9, 0.9, 2.9, 0.1, -0.2]))
    base_T_tcp = frame_from_xyzabc(np.array([0.9, 0.1, 0.5, 0.1, 0.2, 0.3]))
    tracker_T_tcp = inverse(base_T_tracker) @ base_T_tcp
    assert np.allclose(base_pose(base_T_tracker, tracker_T_tcp), base_T_tcp, atol=1e-14)
    assert np.linalg.norm(printed_order(base_T_tracker, tracker_T_tcp)[:3, 3] - base_T_tcp[:3, 3]) > 1.0
    shift = frame_from_xyzabc(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]))
    assert np.allclose(printed_order(shift, shift), base_pose(shift, shift))  # shifts commute, so there both serve


def test_equation_3_takes_extrinsic_angles_within_half_a_turn():
    turns = Rotation.random(200, random_state=3)
    T = np.tile(np.eye(4), (200, 1, 1))
    T[:, :3, :3] = turns.as_matrix()
    level = np.abs(np.cos(turns.as_euler("xyz")[:, 1])) > 0.05
    roll_pitch_yaw = turns.as_euler("xyz")[level]  # small letters: extrinsic
    assert np.allclose(components(T[level])[:, 3:], roll_pitch_yaw[:, ::-1], atol=1e-10)
    near, beyond = np.array([0, 0, 0, np.pi - 0.01, 0, 0]), np.array([0, 0, 0, -np.pi + 0.01, 0, 0])
    assert setpoint_error(near, beyond)[3] == pytest.approx(-0.02)


def test_measurements_that_are_none_are_refused():
    good = reading_of(frame_from_xyzabc(np.array([[2.0, 1.0, 0.5, 0.1, 0.2, 0.3]])))
    for wrong, words in (
        (good._replace(distance=np.array([np.nan])), "not a number"),
        (good._replace(vertical=np.array([np.inf])), "not a number"),
        (good._replace(quaternion=good.quaternion * np.nan), "not a number"),
        (good._replace(distance=np.array([0.0])), "not above 0"),
        (good._replace(quaternion=1.1 * good.quaternion), "length 1.1"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            tracker_pose(wrong)
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="not a number"):
        setpoint_error(np.zeros(6), np.full(6, np.nan))
    with pytest.raises(SingularError, match="quarter turn"):
        components(frame_from_xyzabc(np.array([0, 0, 0, 0.3, np.pi / 2, 0.1])))
    with pytest.raises(InputError, match="not a number"):
        Size.of(np.array([1.0, np.nan]))


def test_noise_through_the_equations_is_as_large_as_said():
    path = small_paths()[0]
    drawn = measured_noise(CASE, path, TrackerNoise(25e-6, 5e-5, 1000.0), 4)
    assert np.allclose(drawn[:, :3].std(axis=0), 25e-6, rtol=0.03)
    assert np.allclose(drawn[:, 3:].std(axis=0), 5e-5, rtol=0.03)
    assert not np.any(measured_noise(CASE, path, SILENT, 4).round(12))


# ---- theory of the loop


def test_the_loop_without_lag_has_the_textbooks_pole_limit_and_noise():
    for gain in (0.01, 0.2, 0.9):
        loop = JointLoop(0.0, 0, 0, 0.004)
        assert np.abs(loop.poles(gain)).max() == pytest.approx(1.0 - gain)
        assert loop.noise(gain) == pytest.approx(gain / (2.0 - gain), rel=1e-6)
    for late in range(8):
        limit = JointLoop(0.0, late, 0, 0.004).limit()
        # in closed form without lag, the correction showing late + 1 cycles on
        closed_form = 2.0 * np.sin(np.pi / (4.0 * (late + 1) - 2.0))
        assert limit == pytest.approx(closed_form, rel=1e-10)
        assert limit == pytest.approx(JointLoop(0.0, 0, late, 0.004).limit(), rel=1e-10)


def test_a_ramp_leaves_its_speed_times_cycle_over_gain():
    ramp = 0.002 * 0.004 * np.arange(8000)
    for lag, delay, latency in ((0.0, 0, 0), (0.07, 3, 1)):
        left = JointLoop(lag, delay, latency, 0.004).remaining(0.01, ramp)
        assert left[-1] == pytest.approx(0.002 * 0.004 / 0.01, rel=1e-6)


def recursion(loop: JointLoop, gain: float, disturbance: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """The loop of one joint, cycle by cycle, written down again: where the joint stands beyond its set-point 0."""
    motor, total, sent, was = 0.0, 0.0, [0.0] * (loop.delay + 1), [0.0] * (loop.latency + 1)
    share = 1.0 if loop.lag == 0.0 else 1.0 - np.exp(-loop.cycle / loop.lag)
    out = np.empty(len(disturbance))
    for k in range(len(out)):
        out[k] = motor + disturbance[k]
        was = [*was[1:], out[k] + noise[k]]
        total += gain * (0.0 - was[0])
        sent = [*sent[1:], total]
        motor += share * (sent[0] - motor)
    return out


@pytest.mark.parametrize(("lag", "delay", "latency"), [(0.0, 2, 3), (0.076, 3, 1), (0.076, 3, 10), (0.03, 0, 25)])
def test_the_limit_against_latency_is_where_the_simulation_turns_over(lag, delay, latency):
    loop = JointLoop(lag, delay, latency, 0.004)
    limit, push, quiet = loop.limit(), np.zeros(6000), np.zeros(6000)
    push[5:] = 1.0
    below, above = (recursion(loop, f * limit, push, quiet) for f in (0.97, 1.03))
    early, late = slice(500, 1500), slice(5000, 6000)
    assert np.abs(below[late]).max() < 0.8 * np.abs(below[early]).max()
    assert np.abs(above[late]).max() > 1.25 * np.abs(above[early]).max()
    assert np.allclose(-recursion(loop, 0.3 * limit, push, quiet), loop.remaining(0.3 * limit, -push), atol=1e-9)


def test_noise_of_a_simulated_loop_is_the_predicted_one():
    loop = JointLoop(0.05, 2, 1, 0.004)
    drawn = np.random.default_rng(5).standard_normal(120_000)
    moved = recursion(loop, 0.04, np.zeros(len(drawn)), drawn)[2000:]
    assert moved.var() == pytest.approx(loop.noise(0.04), rel=0.08)


def test_margins_are_distances_to_instability():
    loop = JointLoop(0.076, 3, 1, 0.004)
    found = loop.margins(0.03)
    assert loop.stable(0.03 * found.gain * 0.999) and not loop.stable(0.03 * found.gain * 1.001)
    assert JointLoop(0.076, 3, 1 + int(found.delay), 0.004).stable(0.03)
    assert not JointLoop(0.076, 3, 3 + int(found.delay), 0.004).stable(0.03)
    assert loop.noise(10.0) == np.inf
    assert found.peak > 1.0 and found.noise == loop.noise(0.03)


def test_learning_shrinks_a_wave_by_the_predicted_factor():
    loop, gain, lead, smoothing, step = JointLoop(0.07, 3, 1, 0.004), 0.01, 14, 0.05, 0.7
    N = 20_000
    for cycles_of_it in (20, 120):
        omega = 2.0 * np.pi * cycles_of_it / (N * loop.cycle)
        factor = float(contraction(loop, gain, lead, smoothing, step, np.array([omega]))[0])
        z = np.exp(1j * omega * loop.cycle)
        L = loop.open_loop(gain, np.array([omega]))[0]
        follow = L * (1.0 - 1.0 / z) / gain
        Q = np.exp(-0.5 * (omega * smoothing) ** 2)
        w, errors = 0.0, []
        for _lap in range(40):
            e = (1.0 - follow * w) / (1.0 + L)
            errors.append(e)
            w = Q * (w + step * (gain / (1.0 - 1.0 / z) * e + z**lead * e))
        assert abs(errors[1] - errors[-1]) == pytest.approx(factor * abs(errors[0] - errors[-1]), rel=1e-6)
    lead, worst = best_lead([loop], gain, smoothing, step)
    assert 10 <= lead <= 25 and worst < 0.6
    with pytest.raises(JobError, match="no lead makes learning converge"):
        best_lead([JointLoop(0.0, 200, 0, 0.004)], 0.001, 0.0, 1.0)


# ---- the simulated robot and loop


def test_a_perfect_robot_is_one_cycle_late_and_nothing_else():
    path = small_paths()[0]
    log = simulate(CELL, SMALL, [run_of(path, PERFECT)])[0]
    wanted = np.asarray(path.wanted)
    behind = wanted[1:] - wanted[:-1]
    assert np.allclose(log.error[1:], behind, atol=1e-9)
    assert np.abs(log.error[path.corners]).max() < 1e-6


@pytest.mark.slow
def test_an_arm_without_closed_form_serves_too(tmp_path):
    folder = tmp_path / "cell"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("poses.csv"))  # those of the true arm
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    old = "dh = { alpha_deg = -90, a_mm = 0, theta_deg = 0, d_mm = 625 }"
    assert old in text
    (folder / "cell.toml").write_text(text.replace(old, old.replace("a_mm = 0", "a_mm = 20")), encoding="utf-8")
    cell, small = read_cell(folder), replace(SMALL, radius=0.01)
    path = circle_path(cell, small)
    log = simulate(cell, small, [run_of(path, PERFECT, law=replace(CASE.law, gain=0.05))])[0]
    steady = path.moving & (path.time > 2.0) & (path.time < path.time[-1] - 1.5)
    speed = np.linalg.norm(np.diff(path.wanted[:, :3], axis=0), axis=1).max() / 0.004
    assert np.abs(log.error[steady, :3]).max() < 0.2 * speed * 0.004 / 0.05
    assert np.abs(log.error[:, 3:]).max() < 1e-9


@pytest.mark.slow
def test_the_whole_loop_takes_a_static_error_away_by_its_pole():
    path, law = small_paths()[1], replace(CASE.law, gain=0.05, step_m=1.0, step_rad=1.0)
    small = replace(STATIC, static=0.01 * STATIC.static)  # so small that turns and shifts don't mix
    log = simulate(CELL, SMALL, [run_of(path, small, law=law)])[0]
    rest = int(path.corners[0])
    assert np.allclose(log.error[0], small.static, atol=1e-12)
    k = np.arange(rest)
    assert np.allclose(log.error[:rest], small.static * 0.95 ** k[:, None], atol=2e-9)
    assert not log.saturated.any()
    bounded = simulate(CELL, SMALL, [run_of(path, STATIC, law=replace(CASE.law, gain=0.05))])[0]
    first = np.abs(np.diff(bounded.correction[:4], axis=0)).max(axis=0)
    assert bounded.saturated[0] and np.all(first <= CASE.law.step_limit * (1.0 + 1e-9))


@pytest.mark.slow
def test_latency_without_alignment_leads_the_tool_ahead_by_that_much():
    path = small_paths()[0]
    law = replace(CASE.law, gain=0.1, step_m=1.0, step_rad=1.0)
    ways = ({}, {"aligned": True}, {"aligned": True, "averaged": True})
    runs = [run_of(path, PERFECT, law=law, latency=5, **way) for way in ways]
    plain, aligned, averaged = simulate(CELL, SMALL, runs)
    steady = (int(path.corners[0]) + int(path.corners[1])) // 2
    speed = np.linalg.norm(np.diff(path.wanted[:, :3], axis=0), axis=1).max() / CASE.law.cycle_s
    assert plain.error[steady, 0] == pytest.approx(-5 * speed * CASE.law.cycle_s, rel=1e-3)
    assert abs(aligned.error[steady, 0]) < 1e-8 and abs(averaged.error[steady, 0]) < 1e-8
    newest, mean = simulate(
        CELL, SMALL, [run_of(path, PERFECT, noise=CASE.noise, aligned=True, averaged=a) for a in (False, True)]
    )
    rest = slice(10, int(path.corners[0]))  # four samples a cycle: half the noise
    assert np.allclose(mean.seen[rest], 0.5 * newest.seen[rest], atol=1e-12)


def test_a_link_is_lost_twice_at_a_reversal_and_never_runs_backwards():
    q = np.concatenate([np.linspace(0, 0.01, 400), np.linspace(0.01, 0, 400)])[:, None] * np.ones(6)
    r = CASE.robot
    s = friction_state(q, np.asarray(r.sliding))
    assert np.allclose(s[399], 1.0, atol=1e-6) and np.allclose(s[-1], -1.0, atol=1e-6)
    link = q - (r.lost + r.friction) * s
    direction = np.sign(np.diff(q, axis=0))
    assert np.all(np.diff(link, axis=0) * direction >= -1e-12)
    assert np.allclose(link[-1] - q[-1] - (link[399] - q[399]), 2.0 * (r.lost + r.friction), atol=1e-9)


def test_joint_errors_are_those_of_the_jacobian():
    path = small_paths()[1]
    J = tool_jacobians(CELL, np.asarray(path.q[::500]))
    h = 1e-6
    for i in range(6):
        step = np.zeros(6)
        step[i] = h
        ends = [base_T_tool(CELL, np.asarray(path.q[::500]) + sign * step) for sign in (1.0, -1.0)]
        assert np.allclose(J[:, :3, i], (ends[0] - ends[1])[:, :3, 3] / (2 * h), atol=1e-8)
    moved = np.random.default_rng(6).normal(0.0, 1e-6, (len(path), 6))
    error = components(base_T_tool(CELL, np.asarray(path.q) + moved)) - np.asarray(path.wanted)
    assert np.allclose(joint_errors(CELL, path, error), moved, atol=1e-10)


def test_planted_lags_and_lost_motion_are_found_and_sent_ahead_of():
    paths = small_paths()
    robot = replace(STATIC, delay=3, lag=CASE.robot.lag, lost=CASE.robot.lost, sliding=CASE.robot.sliding)
    case = replace(SMALL, robot=robot, latency=1)
    logs = simulate(CELL, case, [run_of(path, robot, latency=1) for path in paths])
    found = identify_lags(CELL, case, logs)
    moved = np.asarray(found.moved)
    assert not moved[3] and moved[[0, 1, 2, 4, 5]].all()
    assert np.allclose(found.lag(case)[moved], robot.lag[moved], atol=0.0005)
    assert np.allclose(found.lost[moved], robot.lost[moved], rtol=0.06)
    exact = JointLags(robot.lag + 4.5 * 0.004, NONE, robot.lost, NONE, moved)
    path = paths[1]
    law = replace(CASE.law, gain=0.05, step_m=1.0, step_rad=1.0)
    runs = [run_of(path, robot, latency=1, aligned=True, law=law, ahead=a) for a in (None, ahead_of(case, path, exact))]
    late, early = (measure_run(log, 0.0).tool.rms for log in simulate(CELL, case, runs))
    assert early < 0.1 * late and early < 5e-6


@pytest.mark.slow
def test_the_expected_error_is_the_simulated_one():
    path = small_paths()[1]
    robot = replace(CASE.robot, lost=NONE, friction=NONE)
    case = replace(SMALL, robot=robot, noise=SILENT, law=replace(CASE.law, step_m=1.0, step_rad=1.0))
    log = simulate(CELL, case, [run_of(path, robot, latency=1)])[0]
    lags = JointLags(robot.lag + 4.5 * 0.004, NONE, NONE, NONE, np.ones(6, bool))
    choice = choose_gain(CELL, case, [log], lags)
    at = int(np.argmin(np.abs(choice.gains - 0.02)))
    law = replace(case.law, gain=float(choice.gains[at]))
    simulated = measure_run(simulate(CELL, case, [run_of(path, robot, latency=1, law=law)])[0], 0.0).tool.rms
    assert choice.expected[at, 0] == pytest.approx(simulated, rel=0.05)
    assert choice.peak[choice.gains == choice.chosen][0] <= 1.5


def test_the_feed_is_a_ramp_from_rest_to_rest():
    way = travelled(0.4, 700.0 / 60000.0, 0.1, 0.004)
    speed = np.diff(way) / 0.004
    assert way[0] == 0.0 and way[-1] == pytest.approx(0.4) and np.all(speed > -1e-12)
    assert speed.max() == pytest.approx(700.0 / 60000.0, rel=2e-3) and np.abs(np.diff(speed) / 0.004).max() <= 0.1
    short = travelled(1e-5, 700.0 / 60000.0, 0.1, 0.004)
    assert short[-1] == pytest.approx(1e-5) and np.all(np.diff(short) >= 0.0)


def test_deviation_from_the_paths_is_counted_outwards():
    square, circle = small_paths()
    error = np.zeros((len(circle), 6))
    around = np.asarray(circle.wanted)[:, :2] - circle.center[:2]
    error[:, :2] = -2e-4 * around / circle.radius  # the tool stands outside
    assert np.allclose(across(circle, error), 2e-4, atol=1e-12)
    shift = np.tile([3e-4, 0.0, 0.0, 0.0, 0.0, 0.0], (len(square), 1))  # and here to the left of everything
    assert across(square, shift)[square.moving & (square.side == 3)].max() == pytest.approx(3e-4)
    middle = (int(square.corners[0]) + int(square.corners[1])) // 2
    assert off_path(square, shift)[middle] == pytest.approx(0.0, abs=1e-9)
    turns = reversals(circle)
    assert {i for t in turns for i in t.axes} >= {0, 1, 2}


# ---- the command


@pytest.fixture
def small_cell(tmp_path):
    """The cell with tests that take seconds; `change` goes over tracker.toml."""

    def make(change=lambda text: text) -> Path:
        folder = tmp_path / "cell"
        shutil.copytree(FOLDER, folder)
        file = folder / "tracker.toml"
        text = file.read_text(encoding="utf-8")
        for old, new in (
            ("side_mm = 400", "side_mm = 40"),
            ("radius_mm = 150", "radius_mm = 30"),
            ("rest_s = 5", "rest_s = 1"),
            ("on_s = 22", "on_s = 2"),
        ):
            assert old in text
            text = text.replace(old, new)
        file.write_text(change(text), encoding="utf-8")
        return folder

    return make


@pytest.mark.slow
def test_the_study_from_end_to_end(small_cell, tmp_path):
    result = tracker(cell=small_cell(), out=tmp_path / "out", gain=0.02, laps=2)
    summary = json.loads((tmp_path / "out" / "tracker.json").read_text(encoding="utf-8"))
    assert summary == json.loads(json.dumps(result.summary.to_json())) and result.status == 0
    rms = {v["key"]: v["circle"]["tool_mm"]["rms"] for v in summary["variants"]}
    assert rms["none"] > 5 * rms["published"] > 5 * rms["asked"] > 0
    assert rms["published"] > rms["gain"] > rms["aligned"] > 3 * rms["ahead"]
    assert rms["learned_published"] < 0.7 * rms["published"]
    assert {"66 %", "80 to 90 %", "0.1 to 0.4 mm", "0.1 to 0.15 deg", "above 1 mm"} <= {
        row["published"] for row in summary["published"]
    }
    assert {row["kind"] for row in summary["published"]} == {"tuned", "result", "checked"}
    assert summary["equation_2_off_mm"] > 1000.0
    assert [x["cycles"] for x in summary["latency"]] == sorted(x["cycles"] for x in summary["latency"])
    needs = {(x["latency_cycles"], x["noise_mm"]): x["gain"] for x in summary["gain_needs"]}
    for late, noise in needs:  # later or noisier measurements never ask for a higher gain
        assert all(needs[a, b] <= needs[late, noise] for a, b in needs if a >= late and b >= noise)
    assert len(set(needs.values())) > 3
    limits = [x["limit"] for x in summary["latency"]]
    assert limits == sorted(limits, reverse=True)
    page = (tmp_path / "out" / "tracker.html").read_text(encoding="utf-8")
    for figure in ("Figure 5 a", "Figure 5 d", "Figure 6", "Figure 7"):
        assert figure in page
    assert (
        "NaN" not in page[page.index("<main>") : page.index("</main>")]
        and "http://" not in page[: page.index("<main>")]
    )


def refused(capsys, arguments, status, *words):
    assert run(["tracker", *map(str, arguments)]) == status
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    for word in words:
        assert word in printed.err


def test_wrong_cells_and_numbers_end_with_one_line_and_no_file(small_cell, tmp_path, capsys):
    out = tmp_path / "out"
    refused(capsys, ["--cell", ROOT / "cells" / "ta1400_weld", "--out", out], 2, "no tracker loop", "tracker.toml")
    folder = tmp_path / "track"
    shutil.copytree(ROOT / "cells" / "kr15_track_table", folder)
    shutil.copy(FOLDER / "tracker.toml", folder)
    refused(capsys, ["--cell", folder, "--out", out], 2, "for an arm alone")
    cell = small_cell()
    refused(
        capsys, ["--cell", cell, "--out", out, "--gain", "0.4"], 3, "unstable", "axis A3; 0.4 where the limit is 0."
    )
    refused(capsys, ["--cell", cell, "--out", out, "--gain", "nan"], 2, "gain")
    refused(capsys, ["--cell", cell], 2, "--out")
    refused(capsys, ["--out", out], 2, "--cell")
    assert not out.exists()
    with pytest.raises(InputError, match="laps"):
        tracker(cell=cell, out=out, laps=-1)


@pytest.mark.parametrize(
    ("old", "new", "error", "words"),
    [
        ("noise_mm = 0.025", "noise_mm = nan", CellError, "finite"),
        ("latency_cycles = 1", "latency_cycles = -1", CellError, "latency_cycles"),
        ("sliding_deg = [0.014", "sliding_deg = [0.001", CellError, "backwards"),
        ("lag_ms = [70", "lag_ms = [-70", CellError, "lag_ms"),
        ("gain = 0.01", "gain = 2", CellError, "gain"),
        ("gain = 0.01", "gain = 0.3", JobError, "unstable"),
        ("on_s = 2", "on_s = 900", InputError, "after the square's end"),
        ("corner_mm = [760, -60, 500]", "corner_mm = [2760, -60, 500]", UnreachableError, "out of reach"),
        ("limit_mm = 5 ", "limit_mm = 0.2 ", JobError, "reached its bound"),
    ],
)
def test_a_case_that_makes_no_sense_is_refused(small_cell, tmp_path, old, new, error, words):
    def change(text: str) -> str:
        assert old in text
        return text.replace(old, new)

    with pytest.raises(error, match=words) as caught:
        tracker(cell=small_cell(change), out=tmp_path / "out")
    assert "\n" not in str(caught.value) and not (tmp_path / "out").exists()


def test_a_path_through_a_singular_posture_is_refused():
    """With the tool 260 mm below the wrist, A5 is straight where forearm and tool line up."""
    q = CELL.to_q(np.array([0.0, 30.0, 150.0, 0.0, 0.0, 0.0]))
    pitch_down = base_T_tool(CELL, q)
    with pytest.raises(JobError, match=r"singular|follow|reach"):
        square_path(CELL, replace(SMALL, corner=pitch_down[:3, 3] - [0.03, 0.0, 0.0], side=0.06))


def test_an_unstable_gain_is_named_with_the_joint_and_the_limit():
    loops = joint_loops(CASE, np.asarray(CASE.robot.lag))
    limit = min(loop.limit() for loop in loops)
    check_gain(loops, 0.999 * limit)
    with pytest.raises(JobError) as caught:
        check_gain(loops, limit)
    assert caught.value.axis == "A3" and caught.value.limit == pytest.approx(limit)


def test_options_of_the_server_are_refused_by_the_study(tmp_path, capsys):
    for option, value in (("--instrument", "127.0.0.1:1"), ("--duration", "1"), ("--set", "far_mm=1")):
        assert run(["tracker", "--cell", str(CELL.folder), "--out", str(tmp_path / "out"), option, value]) == 2
        assert f"{option} has no meaning here" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
