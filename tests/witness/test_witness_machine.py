"""The witness's machine and job: kinematics against poses off the spec, Pinocchio and hand-worked numbers; set-ups read alone."""

from __future__ import annotations

import csv
import itertools
import math
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from camrob.errors import CellError, SetupError
from camrob.witness.arm import BRANCHES, wrapped
from camrob.witness.follow import Leg, follow
from camrob.witness.frames import angle_of, euler, frame, inverse, rotation_vector, rotations_about, to_values
from camrob.witness.job import no_job, read_job
from camrob.witness.machine import read_machine

CELLS = Path(__file__).parents[2] / "cells"
KR15 = CELLS / "kr15_track_table"


def row(name, role, alpha, a, theta, d, *, sign=1, offset=0.0, slide=False, home=0.0, limits="endless = true"):
    """A [[joint]] of a cell.toml, mm and degrees."""
    unit = "mm" if slide else "deg"
    return f"""
[[joint]]
name = "{name}"
role = "{role}"
type = "{"prismatic" if slide else "revolute"}"
dh = {{ alpha_deg = {alpha!r}, a_mm = {a!r}, theta_deg = {theta!r}, d_mm = {d!r} }}
axis = {{ sign = {sign}, offset_{unit} = {offset!r} }}
home_{unit} = {home!r}
limits = {{ {limits} }}
"""


def cell(tmp_path, rows, head="", follows="false"):
    """A cell.toml of these rows."""
    text = f"""
name = "made"
[kinematics]
base_follows_table = {follows}
base_to_first = [10.0, -20.0, 30.0, 40.0, 50.0, -60.0]
foot_to_root = [0, 0, 0, 0, 180, 0]
wrist_to_flange = [1.0, 2.0, 3.0, 10.0, 20.0, 30.0]
{"".join(rows)}
{head}
"""
    path = tmp_path / "cell.toml"
    path.write_text(text)
    return path


def arm_rows(offsets=(0.0,) * 6, signs=(1, 1, 1, 1, -1, 1), **changes):
    """The KR15's arm, with theta_deg of each row; `changes` replace (alpha, a, d) of A1..A6."""
    rows = {
        "A1": (90.0, 300.0, -675.0),
        "A2": (0.0, 650.0, 0.0),
        "A3": (90.0, 155.0, 0.0),
        "A4": (90.0, 0.0, -600.0),
        "A5": (90.0, 0.0, 0.0),
        "A6": (0.0, 0.0, -140.0),
    } | changes
    parts = zip(rows.items(), offsets, signs, strict=True)
    return [row(name, "arm", al, a, theta, d, sign=sign) for (name, (al, a, d)), theta, sign in parts]


def truth(entries, q):
    """Pinocchio's end of a chain of rows (alpha, a, theta, d, slides) in degrees and mm, for q in rad and m."""
    model, placement = pin.Model(), pin.SE3.Identity()
    parent = 0
    for alpha, a, theta, d, slides in entries:
        joint = pin.JointModelPZ() if slides else pin.JointModelRZ()
        parent = model.addJoint(parent, joint, placement, f"j{parent}")
        turn_z, turn_x = pin.rpy.rotate("z", math.radians(theta)), pin.rpy.rotate("x", math.radians(alpha))
        along = pin.SE3(np.eye(3), np.array([a / 1000, 0.0, d / 1000]))
        placement = pin.SE3(turn_z, np.zeros(3)) * along * pin.SE3(turn_x, np.zeros(3))
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    return (data.oMi[parent] * placement).homogeneous


def test_poses_of_the_kr15():
    machine = read_machine(KR15)
    assert machine.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    rows = list(csv.DictReader((KR15 / "poses.csv").open()))
    assert len(rows) == 13
    for entry in rows:
        axes = np.array([[float(entry[f"{name}_{'mm' if name == 'E1' else 'deg'}"]) for name in machine.axis_names]])
        base_T_tool = machine.base_T_flange(axes)[0] @ machine.flange_T_tool
        wanted = frame(np.array([float(entry[key]) for key in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")]))
        assert np.linalg.norm(base_T_tool[:3, 3] - wanted[:3, 3]) < 1e-6, entry["name"]
        assert math.degrees(angle_of((wanted[:3, :3].T @ base_T_tool[:3, :3])[None])[0]) < 1e-3, entry["name"]
        axis = [float(entry[f"tool_z_{k}"]) for k in "xyz"]
        assert np.allclose(base_T_tool[:3, 2], axis, atol=6e-5), entry["name"]
        if entry["S"]:
            assert machine.arm.status(axes[:, :6])[0] == int(entry["S"])
            assert machine.arm.turn(axes[:, :6])[0] == int(entry["T"])


def test_hand_worked_frames_of_the_kr15():
    machine = read_machine(KR15)
    axes = np.zeros((1, 8))
    axes[0, 6:] = 250.0, 90.0
    base_T_root, base_T_world = machine.base_T_root(axes)[0], machine.base_T_world(axes)[0]
    world_T_root = inverse(base_T_world) @ base_T_root
    assert np.allclose(world_T_root, frame(np.array([-803.0, 250.0, -305.0, 0, 0, 0])), atol=1e-12)
    # a positive E2 turns the table about -z of world: base's x axis has gone to world's -y
    assert np.allclose(inverse(base_T_world)[:3, 0], [0.0, -1.0, 0.0], atol=1e-12)
    assert machine.home.tolist() == [0, -90, 90, 0, 90, 0, 0, 0]
    assert machine.high[7] == np.inf and machine.low[1] == -145
    assert machine.controller.mechanism == 2 and machine.controller.act_ex_ax == 2
    assert machine.arm.stretched_deg() == pytest.approx(14.48473356, abs=1e-7)


@pytest.mark.parametrize("seed", range(12))
def test_random_rows_against_pinocchio(tmp_path, seed):
    rng = np.random.default_rng(seed)
    slides = [False, True] if seed % 2 else [True, False]
    entries, texts, axes, q = [], [], [], []
    words = ["E2", "E1", *(f"A{k}" for k in range(1, 7))]
    roles = ["workpiece", "carriage", *["arm"] * 6]
    for name, role, slide in zip(words, roles, [*slides, *[False] * 6], strict=True):
        alpha, theta = rng.uniform(-180, 180, 2)
        a, d = rng.uniform(-500, 500, 2)
        sign, offset, value = int(rng.choice([-1, 1])), float(rng.uniform(-90, 90)), float(rng.uniform(-170, 170))
        entries.append((alpha, a, theta, d, slide))
        keys = {"sign": sign, "offset": offset, "slide": slide}
        texts.append(row(name, role, float(alpha), float(a), float(theta), float(d), **keys))
        axes.append(value)
        moved = sign * (value - offset)
        q.append(moved / 1000 if slide else math.radians(moved))
    machine = read_machine(cell(tmp_path, texts))
    in_order = np.array([[*axes[2:], axes[1], axes[0]]])  # A1..A6, E1, E2
    first = frame(np.array([10.0, -20.0, 30.0, 40.0, 50.0, -60.0]))
    last = frame(np.array([1.0, 2.0, 3.0, 10.0, 20.0, 30.0]))
    wanted = first @ truth(entries, np.array(q)) @ last
    assert np.allclose(machine.base_T_flange(in_order)[0], wanted, atol=1e-12)
    assert np.allclose(machine.base_T_flange(np.repeat(in_order, 3, axis=0))[2], wanted, atol=1e-12)
    foot = first @ truth(entries[:2], np.array(q[:2])) @ frame(np.array([0, 0, 0, 0, 180.0, 0]))
    assert np.allclose(machine.base_T_root(in_order)[0], foot, atol=1e-12)


def test_every_number_of_a_row_counts(tmp_path):
    axes = np.array([[10.0, -80, 95, 20, 60, 30]])
    plain = read_machine(cell(tmp_path, arm_rows())).base_T_flange(axes)
    for k in range(6):
        offsets = [0.0] * 6
        offsets[k] = 45.0
        turned = read_machine(cell(tmp_path, arm_rows(tuple(offsets)))).base_T_flange(axes)
        assert np.abs(turned - plain).max() > 0.1
    at = axes.copy()
    at[0, 1] -= 45.0  # 45 degrees of theta on A2 are 45 degrees of A2
    assert np.allclose(
        read_machine(cell(tmp_path, arm_rows((0, 45.0, 0, 0, 0, 0)))).base_T_flange(at), plain, atol=1e-12
    )


@pytest.mark.parametrize("name", ["kr15_track_table", "kr500_afp", "rx160_tracker", "ta1400_weld"])
def test_inverse_on_every_branch(name):
    arm = read_machine(CELLS / name).arm
    assert arm.spherical
    theta = np.random.default_rng(1).uniform(-np.pi, np.pi, (400, 6))
    turn, place = arm.forward(theta)
    met = np.zeros(400, dtype=bool)
    for branch in BRANCHES:
        found, reached, _ = arm.solve((turn, place), branch)
        back = arm.forward(found[reached])
        assert np.allclose(back[0], turn[reached], atol=1e-11) and np.allclose(back[1], place[reached], atol=1e-12)
        assert np.isnan(found[~reached]).all()
        assert {arm.branch(posture) for posture in found[reached]} == {branch}
        with np.errstate(invalid="ignore"):
            met |= np.abs(wrapped(np.degrees(found - theta))).max(axis=1) < 1e-6
    assert met.all()


@pytest.mark.parametrize("seed", range(6))
def test_inverse_with_offsets_and_odd_rows(tmp_path, seed):
    rng = np.random.default_rng(seed)
    offsets = tuple(float(value) for value in rng.uniform(-180, 180, 6))
    signs = tuple(int(value) for value in rng.choice([-1, 1], 6))
    changes = {
        "A1": (float(rng.choice([-90, 90])), 300.0, 400.0),
        "A2": (float(rng.choice([0, 180])), 650.0, 80.0),
        "A3": (float(rng.choice([-90, 90, 60])), 155.0, -50.0),
        "A4": (float(rng.choice([-90, 90])), 0.0, 600.0),
        "A5": (float(rng.choice([-90, 90])), 0.0, 0.0),
        "A6": (33.0, 20.0, 140.0),
    }
    arm = read_machine(cell(tmp_path, arm_rows(offsets, signs, **changes))).arm
    axes = rng.uniform(-170, 170, (200, 6))
    wanted = arm.forward(arm.theta(axes))
    met = np.zeros(200, dtype=bool)
    for branch in BRANCHES:
        found, reached, _ = arm.solve(wanted, branch)
        back = arm.forward(found[reached])
        assert np.allclose(back[0], wanted[0][reached], atol=1e-10) and np.allclose(
            back[1], wanted[1][reached], atol=1e-11
        )
        with np.errstate(invalid="ignore"):
            met |= np.abs(wrapped(arm.axes(found) - axes)).max(axis=1) < 1e-5
    assert met.all()


def test_status_bits_one_by_one():
    arm = read_machine(KR15).arm
    home = [0.0, -90, 90, 0, 90, 0]

    def status(**changes):
        values = [changes.get(f"A{k + 1}", home[k]) for k in range(6)]
        return int(arm.status(np.array([values]))[0])

    assert status() == 2
    # bit 0: leaning back until the wrist is behind axis 1, whatever A1 is
    assert [status(A2=-180, A3=90, A1=a1) for a1 in (0, 90, -135)] == [3, 3, 3]
    assert [status(A1=a1) & 1 for a1 in (0, 90, -170, 180)] == [0, 0, 0, 0]
    # bit 1: A3 below its stretched value of 14.4847 degrees
    assert (status(A3=14.49) & 2, status(A3=14.48) & 2, status(A3=-30) & 2) == (2, 0, 0)
    # bit 2: A5 below zero
    assert (status(A5=0.1) & 4, status(A5=-0.1) & 4, status(A5=0.0) & 4) == (0, 4, 0)


def test_overhead_by_hand():
    # A2 = -90 holds the upper arm upright above axis 2, which is 300 mm ahead of axis 1; A3 = 90 lays the forearm level,
    # so the wrist is 900 ahead; A3 = -61 or so swings it back over the head
    arm = read_machine(KR15).arm
    for a3, expected in ((90.0, 0), (-90.0, 1)):
        axes = np.array([[0.0, -90.0, a3, 0, 90, 0]])
        angle = math.radians(a3)
        ahead = 300 + 600 * math.sin(angle) - 155 * math.cos(angle)
        assert (ahead < 0) == bool(expected)
        assert arm.status(axes)[0] & 1 == expected


def test_turn_bits():
    arm = read_machine(KR15).arm
    for k in range(6):
        axes = np.full((1, 6), 1.0)
        axes[0, k] = -1.0
        assert arm.turn(axes)[0] == 1 << k
    assert arm.turn(np.array([[0.0, -90, 90, -10, 90, 0]]))[0] == 10  # as the engraving sample prints it


@pytest.mark.slow
def test_an_arm_without_a_spherical_wrist(tmp_path):
    machine = read_machine(cell(tmp_path, arm_rows(A5=(90.0, 40.0, 25.0))))
    arm = machine.arm
    assert not arm.spherical
    theta = arm.theta(np.array([[10.0, -80, 100, 20, 70, 30]]))
    pose = arm.forward(theta)
    found = arm.newton(pose, theta[0] + 0.2)
    assert found is not None and np.allclose(found, theta[0], atol=1e-8)
    far = (pose[0], pose[1] + 5.0)
    assert arm.newton(far, theta[0]) is None
    every = arm.all_postures(pose, theta[0])
    assert len(every) >= 4  # both elbows and both wrists at least
    for posture in every:
        assert np.allclose(arm.forward(posture[None])[1], pose[1], atol=1e-8)


def test_a_path_with_an_arm_without_a_spherical_wrist(tmp_path):
    machine = read_machine(cell(tmp_path, arm_rows(A5=(90.0, 40.0, 25.0))))
    axes = np.linspace([10.0, -80, 100, 20, 70, 30], [14.0, -84, 96, 24, 66, 36], 40)
    base_T_tool = machine.base_T_flange(axes) @ machine.flange_T_tool
    found, findings = follow(machine, leg_of(machine, base_T_tool, np.zeros((40, 0))), axes[0])
    assert np.allclose(found, axes[1:], atol=1e-6) and not findings


def leg_of(machine, base_T_tool, external):
    """Lines through these poses."""
    count = len(base_T_tool) - 1
    turn, place = base_T_tool[:, :3, :3], base_T_tool[:, :3, 3]
    none = np.full((count, 3), np.nan)
    fixed = np.zeros(count, dtype=bool)
    return Leg(turn, place, external, none, none, none[:, 0], fixed, machine.flange_T_tool)


def path(begin, end, steps):
    """The KR15 between two postures, even steps of the axes."""
    machine = read_machine(KR15)
    axes = np.linspace(begin, end, steps)
    return machine, axes, machine.base_T_flange(axes) @ machine.flange_T_tool


def test_axes_along_a_path_are_continuous_and_turn_on():
    begin, end = [0, -90, 90, -200, 60, 300, 0, -700], [30, -70, 110, 200, 70, -300, 500, 900]
    machine, axes, base_T_tool = path(np.array(begin, float), np.array(end, float), 400)
    found, findings = follow(machine, leg_of(machine, base_T_tool, axes[:, 6:]), axes[0])
    assert np.allclose(found, axes[1:], atol=1e-7) and not findings


def test_findings_along_a_path():
    home = np.array([0, -90, 90, 0, 90, 0, 0, 0], float)

    def codes(end, begin=home, steps=200):
        machine, axes, base_T_tool = path(begin, np.array(end, float), steps)
        findings = follow(machine, leg_of(machine, base_T_tool, axes[:, 6:]), axes[0])[1]
        return {(finding.code, machine.axis_names[finding.axis] if finding.axis >= 0 else "") for finding in findings}

    assert codes([20, -80, 80, 20, 60, 20, 100, 50]) == set()
    assert codes([0, -90, 90, 0, 136, 0, 0, 0]) == {("limit", "A5")}
    assert codes([0, -90, 90, 0, 134, 0, 0, 0]) == set()
    assert codes([0, -90, 90, 0, 90, 351, 0, 0]) == {("limit", "A6")}
    assert codes([0, -90, 90, 0, 90, 0, 1501, 0]) == {("limit", "E1")}
    assert codes([0, -90, 90, 0, 90, 0, 0, 4000]) == set()  # the table turns without end
    assert ("singular-wrist", "") in codes([0, -90, 90, 0, 0, 0, 0, 0])
    assert ("singular-elbow", "") in codes([0, -90, 14.5, 0, 90, 0, 0, 0])


def test_between_two_points_of_a_long_line():
    # both ends are 700 mm beside the foot and in reach; half-way the line passes over it, where the arm has to flip
    machine = read_machine(KR15)
    begin = np.array([90.0, -90, 90, 0, 90, 0, 0, 0])
    base_T_begin = (machine.base_T_flange(begin[None]) @ machine.flange_T_tool)[0]
    root = machine.base_T_root(begin[None])[0][:3, 3]
    base_T_end = base_T_begin.copy()
    base_T_end[:2, 3] = 2 * root[:2] - base_T_begin[:2, 3]
    poses = np.stack([base_T_begin, base_T_end])
    findings = follow(machine, leg_of(machine, poses, np.zeros((2, 2))), begin)[1]
    assert {finding.code for finding in findings} & {"unreachable", "axis-jump", "singular-foot", "limit"}
    away = base_T_begin.copy()
    away[0, 3] += 0.02
    assert not follow(machine, leg_of(machine, np.stack([base_T_begin, away]), np.zeros((2, 2))), begin)[1]
    far = base_T_begin.copy()
    far[0, 3] += 3.0
    found, findings = follow(machine, leg_of(machine, np.stack([base_T_begin, far]), np.zeros((2, 2))), begin)
    assert [finding.code for finding in findings] == ["unreachable"] and np.isnan(found[0]).all()


def test_passing_the_stretched_wrist_closely_is_a_jump():
    # the hand swings past A5 = 0 at a hundredth of a degree: A4 has to turn by half a turn within a hair's breadth
    machine = read_machine(KR15)
    begin = np.array([0.0, -90, 90, 0, 3.0, 0, 0, 0])
    base_T_begin = (machine.base_T_flange(begin[None]) @ machine.flange_T_tool)[0]
    base_T_end = base_T_begin.copy()
    base_T_end[:3, :3] = euler(np.array([0.03, 0.0, 0.0])) @ euler(np.array([0.0, -6.0, 0.0])) @ base_T_begin[:3, :3]
    findings = follow(machine, leg_of(machine, np.stack([base_T_begin, base_T_end]), np.zeros((2, 2))), begin)[1]
    assert {finding.code for finding in findings} & {"axis-jump", "singular-wrist"}


def test_rotations():
    rng = np.random.default_rng(3)
    vectors = rng.normal(size=(200, 3))
    vectors *= (rng.uniform(0, np.pi, 200) / np.linalg.norm(vectors, axis=1))[:, None]
    vectors[:3] = [[0, 0, 0], [1e-9, 0, 0], [0, np.pi - 1e-9, 0]]
    turns = rotations_about(vectors)
    assert np.allclose(turns, np.array([pin.exp3(vector) for vector in vectors]), atol=1e-12)
    assert np.allclose(rotation_vector(turns), vectors, atol=1e-7)
    assert np.allclose(angle_of(turns), np.linalg.norm(vectors, axis=1), atol=1e-7)
    values = np.array([1.0, 2.0, 3.0, 170.0, -80.0, -170.0])
    assert np.allclose(to_values(frame(values)), values)
    for upright in (90.0, -90.0):
        posed = frame(np.array([0, 0, 0, 25.0, upright, 10.0]))
        assert np.allclose(frame(to_values(posed)), posed, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('role = "arm"', 'role = "leg"'), "roles"),
        ((", d_mm = -675.0 }", " }"), "d_mm"),
        (("theta_deg = 0.0, d_mm = -675.0", "theta_deg = nan, d_mm = -675.0"), "finite"),
        (("sign = 1,", "sign = 2,"), "sign"),
        (('name = "A2"', 'name = "A1"'), "order"),
        (("base_follows_table = false", "base_follows_table = 0"), "base_follows_table"),
        (("limits = { endless = true }", "limits = { range_deg = [5, -5] }"), "range_deg"),
        (("limits = { endless = true }", "limits = { }"), "range_deg"),
    ],
)
def test_a_cell_that_is_wrong_is_refused(tmp_path, change, says):
    path = cell(tmp_path, arm_rows())
    read_machine(path)
    text = path.read_text()
    assert change[0] in text
    path.write_text(text.replace(*change, 1))
    with pytest.raises(CellError, match=says) as caught:
        read_machine(path)
    assert str(path) in str(caught.value)


def test_roles_not_names(tmp_path):
    rows = [text.replace('name = "A', 'name = "axis ') for text in arm_rows()]
    table = row("E1", "workpiece", 0.0, 0.0, 0.0, 0.0)
    roll = row("spin", "roll", 0.0, 0.0, 0.0, 0.0)
    machine = read_machine(cell(tmp_path, [table, *rows, roll]))
    assert machine.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6", "E1")
    for bad in (row("spin", "roll", 0.0, 0.0, 5.0, 0.0), row("spin", "roll", 0.0, 0.0, 0.0, 0.0) * 2):
        with pytest.raises(CellError):
            read_machine(cell(tmp_path, [table, *rows, bad]))
    with pytest.raises(CellError, match="E1 to E6"):
        read_machine(cell(tmp_path, [table.replace("E1", "table"), *rows]))


def test_the_controller(tmp_path):
    head = """
[controller]
spindle_rpm = [1000, 24000]
tool_change_pose = [1, 2, 3, 4, 5, 6]
[controller.hooks]
stop = ["HALT"]
"""
    controller = read_machine(cell(tmp_path, arm_rows(), head)).controller
    assert controller.spindle_rpm == (1000.0, 24000.0) and controller.tool_change_pose == (1, 2, 3, 4, 5, 6)
    assert controller.hooks == {"stop": ("HALT",)} and controller.mechanism is None
    named = head.replace("[1, 2, 3, 4, 5, 6]", "{ A1 = 1, A2 = 2, A3 = 3, A4 = 4, A5 = 5, A6 = 6 }")
    assert read_machine(cell(tmp_path, arm_rows(), named)).controller.tool_change_pose == (1, 2, 3, 4, 5, 6)
    with pytest.raises(CellError, match="stop"):
        read_machine(cell(tmp_path, arm_rows(), head.replace('["HALT"]', '"HALT"')))
    with pytest.raises(CellError, match="can't be read"):
        read_machine(tmp_path / "nowhere.toml")


def setup(tmp_path, text):
    path = tmp_path / "setup.toml"
    path.write_text(text)
    return path


def test_a_set_up(tmp_path):
    text = """
part_in_base = [100, 0, 50, 90, 0, 0]
feed_mm_min = 1200
rapid_feed_mm_min = 12000
spindle_rpm = 8000
chord_tolerance_mm = 0.02
clearance_mm = 40
units = "inch"
[[tool]]
number = 1
flange_to_tool = [0, 0, 200, 0, 0, 0]
diameter_mm = 10
[[tool]]
number = 7
name = "ball 6"
length_mm = 60
[stock]
box_mm = [0, 0, 0, 10, 20, 30]
"""
    job = read_job(setup(tmp_path, text))
    assert job.feed == pytest.approx(0.02) and job.rapid_feed == pytest.approx(0.2) and job.spindle_rpm == 8000
    assert job.chord_tolerance == pytest.approx(2e-5) and job.clearance == pytest.approx(0.04) and job.decimate is None
    assert job.units == "inch" and job.dialect is None and job.given and not no_job().given
    one, seven = job.tool(1), job.tool(7)
    assert one is not None and seven is not None and job.tool(2) is None
    assert one.flange_T_tool is not None and one.flange_T_tool[2, 3] == pytest.approx(0.2)
    assert seven.flange_T_tool is None and seven.length == pytest.approx(0.06) and one.diameter == pytest.approx(0.01)
    corners = job.corners("stock")
    assert corners is not None and corners.shape == (8, 3) and job.corners("part") is None
    # turned by 90 degrees about z: the part's y goes to base's -x
    expected = {(0.1 - y, x, 0.05 + z) for x, y, z in itertools.product((0, 0.01), (0, 0.02), (0, 0.03))}
    assert {tuple(np.round(corner, 9)) for corner in corners} == {tuple(np.round(corner, 9)) for corner in expected}


def test_one_tool_serves_all_numbers(tmp_path):
    job = read_job(setup(tmp_path, "[tool]\ndiameter_mm = 3\n"))
    assert job.tool(5) is job.tool(0) and np.array_equal(job.base_T_part, np.eye(4))


@pytest.mark.parametrize(("unit", "scale"), [("", 1e-3), ('unit = "inch"', 0.0254), ('unit = "m"', 1.0)])
def test_a_mesh(tmp_path, unit, scale):
    facets = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 4\nendloop\nendfacet\n"
    (tmp_path / "part.stl").write_text(f"solid a\n{facets}endsolid a\n")
    job = read_job(setup(tmp_path, f'part_in_base = [0, 0, 0, 0, 0, 0]\n[part]\nmesh = "part.stl"\n{unit}\n'))
    corners = job.corners("part")
    assert corners is not None and np.allclose(corners.max(axis=0), np.array([2, 3, 4]) * scale)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("part_in_base = [1, 2, 3]", "part_in_base"),
        ("part_in_base = [1, 2, 3, 4, 5, inf]", "finite"),
        ("feed_mm_min = 0", "feed_mm_min"),
        ("clearance_mm = -1", "clearance_mm"),
        ("[[tool]]\nnumber = 1\n[[tool]]\nnumber = 1", "twice"),
        ("[[tool]]\nnumber = 1\n[[tool]]\nlength_mm = 3", "without"),
        ("[tool]\nnumber = 1.5", "number"),
        ("[stock]\nbox_mm = [0, 0, 0, 1, 1, 0]", "rise"),
        ("[stock]", "box_mm"),
        ("part_in_bace = [1, 2, 3, 4, 5, 6]", "part_in_bace is not a key"),
        ("[tool]\nlength = 75", "tool.*length is not a key"),
        ("[stock]\nbox_mm = [0, 0, 0, 1, 1, 1]\nunits = 'mm'", "units is not a key"),
        ("[part]\nmesh = 'a.stl'\nunit = 'ft'", "unit"),
        ("units = 3", "units"),
        ("tool = 3", "tool"),
        ("part_in_base = ", "TOML"),
    ],
)
def test_a_set_up_that_is_wrong_is_refused(tmp_path, text, says):
    with pytest.raises(SetupError, match=says):
        read_job(setup(tmp_path, text))


def test_a_mesh_that_cannot_be_read(tmp_path):
    (tmp_path / "part.stl").write_bytes(b"\x00\x01")
    job = read_job(setup(tmp_path, '[part]\nmesh = "part.stl"\n[stock]\nmesh = "none.stl"\n'))
    for name in ("part", "stock"):
        with pytest.raises(SetupError, match="mesh"):
            job.corners(name)
