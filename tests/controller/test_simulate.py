"""The ideal controller against what paper says: times, circles, roundings, limits; and against runs made by other code."""

from __future__ import annotations

import dataclasses
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.cli import app as cli
from camrob.controller.replay import replay
from camrob.controller.simulate import Simulation, approximation, simulate
from camrob.controller.speed_profile import CAUSES
from camrob.errors import ProgramError, UnreachableError
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log
from camrob.se3 import abc_to_rotation, angle_between, inverse, rotation_exp, rotation_log

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
SAMPLES = ROOT.parent / "shared" / "gap_samples" / "cases"
A, V = 2.0, 0.1  # $ACC.CP m/s2, $VEL.CP m/s
TOOL = "$TOOL={X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}"
LIN = 10  # line of the first motion behind START
HOME = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}"
HEAD = f"$BASE={{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n{TOOL}\n$VEL.CP={V}\n$ACC.CP={A}\n$ADVANCE=3\n$APO.CDIS=2.0"


@cache
def cell():
    return read_cell(CELL)


def lin(x=97.0, y=-41.764, z=600.0, a=180.0, b=0.0, c=20.42, e1=0.0, e2=0.0, after=""):
    return f"LIN {{X {x},Y {y},Z {z},A {a},B {b},C {c},E1 {e1},E2 {e2}}} {after}"


def program(tmp_path: Path, *lines: str, head: str = HEAD):
    path = tmp_path / "p.src"
    path.write_text("\n".join(["DEF p()", *head.split("\n"), *lines, "END"]) + "\n")
    return read_krl(path)


def run(tmp_path: Path, *lines: str, head: str = HEAD, cycle: float = 0.004, machine=None) -> Simulation:
    return simulate(program(tmp_path, *lines, head=head), machine or cell(), cycle=cycle)


def posture(log: MeasurementLog):
    return cell().to_q(log.setpoints(cell().axis_names))


def in_base(log: MeasurementLog):
    """TCP in `base` by the plain twin of forward kinematics, mm and rotations."""
    frames = base_T_tool(cell(), posture(log))
    return frames[:, :3, 3] * 1e3, frames[:, :3, :3]


START = (HOME, lin())


@pytest.mark.parametrize(("way", "seconds"), [(100.0, 0.1 / V + V / A), (2.0, 2.0 * np.sqrt(0.002 / A))])
def test_a_straight_line_takes_the_time_of_a_trapezoid(tmp_path, way, seconds):
    whole = run(tmp_path, *START, lin(x=97 + way))
    part = run(tmp_path, *START)
    assert whole.duration - part.duration == pytest.approx(seconds, rel=1e-4)
    log = whole.log
    speed = np.linalg.norm(np.diff(log.position, axis=0), axis=1) / 0.004
    assert speed.max() <= V * (1 + 1e-6)
    along = log.position[log.line == LIN]
    assert np.abs(along[:, 1:] - along[0, 1:]).max() < 1e-8
    if way > 50:
        assert np.diff(speed).max() / 0.004 == pytest.approx(A, rel=1e-3)


def test_ptp_moves_all_axes_together_in_the_leading_axis_time(tmp_path):
    head = HEAD + "\n" + "\n".join(f"$VEL_AXIS[{i}]=20" for i in range(1, 7))
    s = run(tmp_path, HOME, "PTP {A1 30,A2 -100,A3 100,A4 0,A5 85,A6 3,E1 0,E2 0}", head=head)
    v, a = 0.2 * 152.0, 350.0
    assert s.duration == pytest.approx(30.0 / v + v / a, rel=1e-6)
    moved = s.log.setpoints(cell().axis_names) - s.log.setpoints(cell().axis_names)[0]
    share = moved[:, 0] / 30.0
    assert np.allclose(moved[:, :6], share[:, None] * [30, -10, 10, 0, -5, 3], atol=1e-6)
    assert share[-1] == pytest.approx(1.0) and np.diff(share).min() > -1e-12


def test_ptp_corners_are_rounded_within_limits(tmp_path):
    points = ["A1 20,A2 -90,A3 95", "A1 20,A2 -100,A3 95", "A1 5,A2 -95,A3 90"]
    exact, rounded = (
        run(tmp_path, HOME, *(f"PTP {{{p},A4 0,A5 85,A6 3,E1 0,E2 0}} {after}" for p in points))
        for after in ("", "C_PTP")
    )
    assert rounded.duration < exact.duration - 0.05
    assert max(rounded.peak_acceleration.values()) <= 1.005
    assert rounded.log.setpoints(("A1", "A2"))[-1] == pytest.approx([5, -95], abs=1e-6)


def test_a_corner_is_rounded_as_far_as_paper_says(tmp_path):
    d = 2.0
    corner = (*START, lin(x=127, after="C_DIS"), lin(x=127, y=-11.764))
    s = run(tmp_path, *corner)
    assert s.approximation.corners == 1 and s.approximation.line == LIN
    assert s.approximation.deviation * 1e3 == pytest.approx(d / 2 * np.sin(np.pi / 4), rel=1e-6)
    p = s.log.position * 1e3
    gap = np.linalg.norm(p - [127, -41.764, 600], axis=1)
    assert gap.min() == pytest.approx(d / 2 * np.sin(np.pi / 4), rel=2e-2)
    off = np.minimum(np.abs(p[:, 1] + 41.764), np.abs(p[:, 0] - 127.0))
    late = s.log.line >= LIN
    assert off[late & (gap >= d)].max() < 1e-5 and off[late & (gap < d - 0.2)].max() > 0.1
    # the acceleration across, v^2 |t1 - t0| / 2d, is what slows the corner
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / 4.0
    path = np.sqrt(A * 2 * d * 1e-3 / np.sqrt(2.0))
    near = speed[np.argmin(gap)]
    assert near == pytest.approx(path * np.cos(np.pi / 4), rel=0.03)
    verified = approximation(program(tmp_path, *corner), replay(program(tmp_path, *corner), cell()))
    assert verified == s.approximation


def test_a_rounding_stays_within_half_of_the_shorter_motion(tmp_path):
    head = HEAD.replace("$APO.CDIS=2.0", "$APO.CDIS=50.0")
    s = run(tmp_path, *START, lin(x=107, after="C_DIS"), lin(x=107, y=8.236), head=head)
    assert s.approximation.deviation * 1e3 == pytest.approx(5 / 2 * np.sin(np.pi / 4), rel=1e-6)
    p = s.log.position * 1e3
    assert np.abs(p[p[:, 1] > -41.764 + 5.0, 0] - 107.0).max() < 1e-5


@pytest.mark.parametrize(
    ("after", "extra", "way"),
    [
        ("C_VEL", "$APO.CVEL=50", V * V * 0.75 / (2 * A) * 1e3),
        ("C_ORI", "$APO.CORI=2", 6.0),
        ("C_ORI", "$APO.CORI=40", 15.0),
    ],
)
def test_other_kinds_of_approximation(tmp_path, after, extra, way):
    s = run(tmp_path, *START, lin(x=127, b=10, after=after), lin(x=127, y=-11.764, b=10), head=HEAD + "\n" + extra)
    assert s.approximation.deviation * 1e3 == pytest.approx(way / 2 * np.sin(np.pi / 4), rel=1e-6)


def test_exact_stops_and_waits(tmp_path):
    path = (*START, lin(x=127), lin(x=127, y=-11.764))
    s = run(tmp_path, *path)
    gap = np.linalg.norm(s.log.position * 1e3 - [127, -41.764, 600], axis=1)
    speed = np.linalg.norm(np.diff(s.log.position, axis=0), axis=1) / 0.004
    assert gap.min() < 0.01 and speed[np.argmin(gap) - 1] < A * 0.008
    assert s.approximation.corners == 0 and s.approximation.line == 0
    waiting = run(tmp_path, *path[:3], "WAIT SEC 0.5", path[3], "WAIT SEC 0.25")
    assert waiting.duration == pytest.approx(s.duration + 0.75, abs=1e-9)
    at = np.linalg.norm(waiting.log.position * 1e3 - [127, -41.764, 600], axis=1) < 1e-9
    assert at.sum() in (125, 126) and set(waiting.log.line[at]) <= {LIN}
    assert np.all(np.diff(waiting.log.t) > 0.0) and waiting.log.t[-1] >= waiting.duration - 1e-9
    # a wait behind an approximated motion makes it exact, and so does $ADVANCE = 0
    rounded = (path[0], path[1], lin(x=127, after="C_DIS"), path[3])
    assert run(tmp_path, *rounded).approximation.corners == 1
    assert run(tmp_path, *rounded[:3], "WAIT SEC 0", *rounded[3:]).approximation.corners == 1
    assert run(tmp_path, *rounded[:3], "WAIT SEC 0.1", *rounded[3:]).approximation.corners == 0
    assert run(tmp_path, *rounded, head=HEAD.replace("$ADVANCE=3", "$ADVANCE=0")).duration == s.duration


def test_circles(tmp_path):
    via, end = (
        "{X 117,Y -21.764,Z 600,A 180,B 0,C 20.42,E1 0,E2 0}",
        "{X 97,Y -1.764,Z 600,A 180,B 0,C 20.42,E1 0,E2 0}",
    )
    for text, sweep in (("", np.pi), (",CA 90", np.pi / 2), (",CA 300", np.pi * 5 / 3), (",CA -45", -np.pi / 4)):
        s = run(tmp_path, *START, f"CIRC {via},{end}{text}")
        p = s.log.position[s.log.line == LIN] * 1e3
        radius = np.linalg.norm(p - [97, -21.764, 600], axis=1)
        assert np.abs(radius - 20.0).max() < 1e-5, text
        angle = np.unwrap(np.arctan2(p[:, 1] + 21.764, p[:, 0] - 97.0))
        assert angle[-1] + np.pi / 2 == pytest.approx(sweep, abs=1e-7)
        rest = run(tmp_path, *START).duration
        # on the circle V^2 / r of the acceleration is taken, and the rest is for the ramps
        assert 0.0 < s.duration - rest - (0.02 * abs(sweep) / V + V / A) < 0.01
    s = run(tmp_path, *START, f"CIRC {via},{end},CA 90", lin(x=150))
    p = s.log.position[s.log.line == LIN + 1] * 1e3
    start, way = np.array([117, -21.764, 600]), np.array([150 - 117, -41.764 + 21.764, 0])
    assert np.linalg.norm(np.cross(p - start, way / np.linalg.norm(way)), axis=1).max() < 1e-5


def test_external_axes_and_rotation_go_with_the_way_in_the_turning_base(tmp_path):
    s = run(tmp_path, *START, lin(x=157, z=560, a=175, b=8, c=30, e1=40, e2=-12))
    rows = s.log.line == LIN
    p, R = in_base(s.log.select(rows))
    share = np.linalg.norm(p - [97, -41.764, 600], axis=1) / np.linalg.norm([60, 0, 40])
    axes = s.log.select(rows).setpoints(("E1", "E2"))
    assert np.allclose(axes, share[:, None] * [40, -12], atol=1e-6)
    R0, R1 = abc_to_rotation(np.deg2rad([[180, 0, 20.42], [175, 8, 30]]))
    w = rotation_log(R0.T @ R1)
    assert angle_between(R, R0 @ rotation_exp(share[:, None] * w)).max() < 1e-9
    assert share[-1] == pytest.approx(1.0, abs=1e-9) and 0.2 < share[len(share) // 2] < 0.8


def blended(path, corner: int, tau: float, d: float):
    """Twin of a rounding: position, rotation and externals tau (of path, mm) behind a corner of `path`, a list of poses."""
    (p0, R0, e0), (p1, R1, e1), (p2, R2, e2) = path[corner - 1 : corner + 2]
    back, on = (d - tau) ** 2 / (4 * d), (d + tau) ** 2 / (4 * d)
    b, o = back / np.linalg.norm(p1 - p0), on / np.linalg.norm(p2 - p1)
    R = R1 @ rotation_exp(-b * rotation_log(R0.T @ R1)) @ rotation_exp(o * rotation_log(R1.T @ R2))
    return p1 - b * (p1 - p0) + o * (p2 - p1), R, e1 - b * (e1 - e0) + o * (e2 - e1)


def test_rounding_of_rotation_and_external_axes_against_a_plain_twin(tmp_path):
    stations = [
        (97.0, -41.764, 600.0, 180.0, 0.0, 20.42, 0.0, 0.0),
        (127.0, -41.764, 600.0, 178.0, 3.0, 24.0, 5.0, 2.0),
        (127.0, -11.764, 610.0, 176.0, 1.0, 24.0, 0.0, 6.0),
    ]
    s = run(tmp_path, HOME, lin(), lin(*stations[1], after="C_DIS"), lin(*stations[2]), cycle=0.002)
    path = [(np.array(x[:3]), abc_to_rotation(np.deg2rad(x[3:6])), np.array(x[6:])) for x in stations]
    p, R = in_base(s.log)
    e = s.log.setpoints(("E1", "E2"))
    found = np.flatnonzero(np.linalg.norm(p - path[1][0], axis=1) < 1.9)
    assert len(found) > 10
    for i in found:
        low, high = -2.0, 2.0  # the place along the rounding, by its distance from both ends
        for _ in range(60):
            tau = 0.5 * (low + high)
            at = blended(path, 1, tau, 2.0)[0]
            forward = np.linalg.norm(p[i] - path[0][0]) ** 2 - np.linalg.norm(p[i] - path[2][0]) ** 2
            low, high = (
                (tau, high)
                if np.linalg.norm(at - path[0][0]) ** 2 - np.linalg.norm(at - path[2][0]) ** 2 < forward
                else (low, tau)
            )
        at, turned, carried = blended(path, 1, tau, 2.0)
        assert np.linalg.norm(at - p[i]) < 1e-6
        assert angle_between(turned, R[i]) < 1e-9 and np.abs(carried - e[i]).max() < 1e-6


WILD = (
    lin(x=127, b=6, after="C_DIS"),
    lin(x=127, y=-20, c=28, e2=3, after="C_DIS"),
    lin(x=90, y=-20, z=590, e1=30, after="C_DIS"),
    lin(x=90, y=-60, z=590, a=170, e1=30, e2=-8, after="C_DIS"),
    lin(x=130, y=-60, z=620, a=170, e1=0, e2=2, after="C_DIS"),
    lin(x=130.5, y=-60, z=620, a=182, b=9, after="C_DIS"),
    lin(x=100, y=-50, z=600),
)


@pytest.mark.parametrize("speed", [0.05, 0.5, 2.0])
def test_no_axis_ever_passes_its_limits(tmp_path, speed):
    s = run(tmp_path, *START, *WILD, head=HEAD.replace(f"$VEL.CP={V}", f"$VEL.CP={speed}"), cycle=0.002)
    rate = np.diff(posture(s.log), axis=0) / 0.002
    push = np.diff(rate, axis=0) / 0.002
    fastest = np.abs(rate).max(axis=0) / cell().limits_of("speed")
    hardest = np.abs(push).max(axis=0) / cell().limits_of("acceleration")
    assert fastest.max() <= 1.0 + 1e-6 and hardest.max() <= 1.005
    assert max(s.peak_acceleration.values()) == pytest.approx(hardest.max(), rel=1e-6)
    tip = in_base(s.log)[0] * 1e-3
    assert np.linalg.norm(np.diff(tip, axis=0), axis=1).max() / 0.002 <= speed * (1 + 1e-6)
    assert np.linalg.norm(np.diff(tip, 2, axis=0), axis=1).max() / 0.002**2 <= A * 1.01


def test_it_is_as_fast_as_something_allows(tmp_path):
    """Nearly always speed, or one acceleration, is at its limit: nothing is given away."""
    s = run(tmp_path, *START, *WILD, cycle=0.001)
    q, (p, R) = posture(s.log), in_base(s.log)
    rate, push = np.diff(q, axis=0)[:-1] / 0.001, np.diff(q, 2, axis=0) / 0.001**2
    tip, tip_push = np.diff(p, axis=0)[:-1] * 1e-3 / 0.001, np.diff(p, 2, axis=0) * 1e-3 / 0.001**2
    turn = np.array([rotation_log(R[i].T @ R[i + 1]) for i in range(len(R) - 1)]) / 0.001
    turn_push = np.diff(turn, axis=0) / 0.001
    used = np.max(
        [
            *(np.abs(rate) / cell().limits_of("speed")).T,
            *(np.abs(push) / cell().limits_of("acceleration")).T,
            np.linalg.norm(tip, axis=1) / V,
            np.linalg.norm(tip_push, axis=1) / A,
            np.linalg.norm(turn[:-1], axis=1) / np.deg2rad(200),
            np.linalg.norm(turn_push, axis=1) / np.deg2rad(400),
        ],
        axis=0,
    )
    begun = s.log.line[:-2] >= LIN
    assert np.mean(used[begun] > 0.9) > 0.9
    assert used[begun].max() < 1.02


def test_cycles_of_4_and_12_ms_are_one_motion(tmp_path):
    fine, coarse = (run(tmp_path, *START, *WILD, cycle=c) for c in (0.004, 0.012))
    assert fine.duration == coarse.duration
    every = fine.log.select(slice(None, None, 3))
    both = min(len(every), len(coarse.log)) - 1
    names = [*cell().axis_names]
    assert np.abs(every.axes(names)[:both] - coarse.log.axes(names)[:both]).max() < 1e-9
    assert np.array_equal(every.line[:both], coarse.log.line[:both])


def test_the_encoders_give_the_tool(tmp_path):
    s = run(tmp_path, HOME, "PTP {A1 10,A2 -95,A3 95,A4 5,A5 80,A6 0,E1 50,E2 30}", lin(e1=50, e2=30), *WILD)
    q = posture(s.log)
    frames = world_T_base(cell(), q) @ base_T_tool(cell(), q)
    assert np.abs(frames[:, :3, 3] - s.log.position).max() < 1e-10
    assert angle_between(frames[:, :3, :3], s.log.rotation).max() < 1e-7
    assert np.array_equal(s.log.axes(cell().axis_names), s.log.setpoints(cell().axis_names))
    assert np.ptp(s.log.setpoints(("E2",))) > 20.0


def test_a_base_that_stands_still_is_left_by_the_table(tmp_path):
    still = dataclasses.replace(cell(), base_follows_table=False)
    s = run(tmp_path, *START, lin(x=147, e2=10), machine=still)
    p = s.log.position[s.log.line == LIN] * 1e3
    assert np.abs(p[:, 1:] - [-41.764, 600]).max() < 1e-6 and p[-1, 0] == pytest.approx(147, abs=1e-6)
    follows = run(tmp_path, *START, lin(x=147, e2=10)).log.position * 1e3
    assert abs(follows[-1, 1] + 41.764) > 10.0


def test_look_ahead_limits_dense_points(tmp_path):
    points = [lin(x=97 + 0.2 * k, after="C_DIS") for k in range(1, 300)]
    durations = []
    for advance in (5, 1):
        free = dataclasses.replace(cell(), controller_section=dataclasses.replace(cell().controller, block_ms=0.0))
        s = run(tmp_path, *START, *points, head=HEAD.replace("$ADVANCE=3", f"$ADVANCE={advance}"), machine=free)
        durations.append(s.duration)
        dense = s.log.position[s.log.line > LIN + 2]
        speed = np.linalg.norm(np.diff(dense, axis=0), axis=1).max() / 0.004
        # what is known ahead must do for a stop: at least `advance` motions, at most half a motion more on either side
        assert np.sqrt(2 * A * (advance - 1) * 2e-4) < speed <= np.sqrt(2 * A * (advance + 1) * 2e-4)
        assert s.feed_lost.by_cause[CAUSES[5]] > 0.1
    assert durations[1] > 1.5 * durations[0]
    far = [lin(x=97 + 20.0 * k, after="C_DIS") for k in range(1, 4)]
    assert CAUSES[5] not in run(tmp_path, *START, *far).feed_lost.by_cause


def test_what_slows_the_tool_is_named(tmp_path):
    s = run(tmp_path, *START, lin(x=107, e2=60))
    assert max(s.feed_lost.by_cause, key=s.feed_lost.by_cause.get) in ("E2 speed", "stop")
    assert s.peak_speed["E2"] == pytest.approx(1.0, abs=1e-3)
    assert s.duration > 60.0 / 60.0


def test_a_program_that_moves_nothing(tmp_path):
    s = run(tmp_path, HOME, "WAIT SEC 0.1")
    assert len(s.log) == 26 and np.ptp(s.log.position, axis=0).max() == 0.0
    assert s.log.position[0] * 1e3 == pytest.approx([97, -41.764, 619.422], abs=1e-3)


def test_what_can_t_be_run_is_refused_with_its_line(tmp_path):
    with pytest.raises(UnreachableError, match=f"line {LIN}"):
        run(tmp_path, *START, lin(x=3000))
    with pytest.raises(ProgramError, match=r"p\.src:3.*speed"):
        run(tmp_path, lin(), head=TOOL)
    with pytest.raises(ProgramError, match="ADVANCE"):
        run(tmp_path, *START, head=HEAD.replace("$ADVANCE=3", "$ADVANCE=9"))
    with pytest.raises(ProgramError, match="rows"):
        run(tmp_path, *START, "WAIT SEC 1E9")
    with pytest.raises(ValueError, match="cycle"):
        run(tmp_path, *START, cycle=float("nan"))


def test_the_command(tmp_path, capsys):
    program(tmp_path, *START, *WILD)
    source, out = str(tmp_path / "p.src"), tmp_path / "logs" / "run.csv"
    command = ["simulate", source, "--cell", str(CELL), "--out", str(out)]
    assert cli.run([*command, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["program"] == "p" and summary["cell"] == "kr15_track_table"
    assert summary["approximation"]["corners"] == 6 and summary["approximation"]["deviation_mm_max"] > 0.1
    log = read_log(out)
    assert len(log) == summary["rows"] and log.info.program == "../p.src"
    assert log.t[1] == pytest.approx(0.012) and log.t[-1] >= summary["duration_s"] - 1e-6
    assert sorted(f.name for f in out.parent.iterdir()) == ["run.csv", "run.toml"]
    assert cli.run([*command, "--cycle-ms", "4", "--quiet"]) == 0
    assert len(read_log(out)) == pytest.approx(3 * len(log), abs=3)
    before = out.read_bytes()
    for wrong, message in (
        (["--cycle-ms", "nan"], "cycle-ms"),
        (["--cycle-ms", "0"], "cycle-ms"),
        (["--out", str(tmp_path / "a.txt")], ".csv"),
        (["--out", str(tmp_path / "cell.csv")], "cell.toml"),
    ):
        begun = command[: command.index("--out")] if "--out" in wrong else command
        assert cli.run([*begun, *wrong]) == 2
        assert message in capsys.readouterr().err
    program(tmp_path, *START, lin(x=3000))
    assert cli.run(command) == 3
    assert f"line {LIN}" in capsys.readouterr().err and out.read_bytes() == before
    assert sorted(f.name for f in out.parent.iterdir()) == ["run.csv", "run.toml"]


def test_verify_tells_the_largest_rounding(tmp_path, capsys):
    the_cells_own = HEAD.replace("$APO.CDIS=2.0", "$APO.CDIS=0.5")
    program(tmp_path, *START, lin(x=127, after="C_DIS"), lin(x=127, y=-11.764), head=the_cells_own)
    assert cli.run(["verify", str(tmp_path / "p.src"), "--cell", str(CELL), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert {problem["code"] for problem in found["errors"]} == {"base-stands-still"}, "these lines set it without EK()"
    rounding = found["approximation"]
    assert rounding == {"corners": 1, "deviation_mm_max": pytest.approx(0.70711 / 4, abs=1e-5), "line": LIN}


@pytest.mark.parametrize("name", ["a_nothing/circle1", "a_nothing/dome0", "d_servo_lag/tour0", "sealed3/tour0"])
def test_set_points_made_by_other_code_lie_on_the_path(name):
    source = SAMPLES / f"{name}.src"
    if not source.is_file():
        pytest.skip("../shared is not here: no measured runs of other code")
    s, log = simulate(read_krl(source), cell(), cycle=0.004), read_log(source.with_suffix(".csv"))
    path, _ = in_base(s.log)
    e = s.log.setpoints(("E1", "E2"))
    theirs, _ = in_base(log)
    carried = log.setpoints(("E1", "E2"))
    lines = s.log.line
    off, external = [], []
    for i in range(0, len(log), 3):
        own = np.flatnonzero(np.abs(lines - log.line[i]) <= 1)
        own = own[own + 1 < len(path)]
        step = path[own + 1] - path[own]
        square = np.maximum((step**2).sum(axis=1), 1e-18)
        share = np.clip(((theirs[i] - path[own]) * step).sum(axis=1) / square, 0, 1)
        gap = np.linalg.norm(path[own] + share[:, None] * step - theirs[i], axis=1)
        best = int(np.argmin(gap))
        k = own[best]
        off.append(gap[best])
        external.append(np.abs(e[k] + share[best] * (e[k + 1] - e[k]) - carried[i]).max())
    # their set-points carry 5 decimals of a degree and 4 of a mm; between rows of ours the path is taken as straight
    assert np.median(off) < 1e-4 and np.percentile(off, 95) < 1e-3 and max(off) < 0.02
    assert np.median(external) < 2e-4 and max(external) < 0.02


def test_frames_in_the_log_are_rigid(tmp_path):
    s = run(tmp_path, *START, *WILD)
    R = s.log.rotation
    assert np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max() < 1e-12
    T = world_T_base(cell(), posture(s.log))
    assert np.abs(inverse(T) @ T - np.eye(4)).max() < 1e-12
