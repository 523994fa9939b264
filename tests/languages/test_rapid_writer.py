"""RAPID as it is written: a program written by hand, configurations by ABB's table, quaternions by another library, refusals."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from rapid_sample import CONTROLLER, OWN, RAPID, bracket, controller, written
from scipy.spatial.transform import Rotation

from camrob.errors import CellError, JobError
from camrob.languages.rapid.rapid_numbers import quaternions
from camrob.languages.rapid.rapid_text import comment_text, rapid_name
from camrob.program.axis_turns import quarters_of, turn_fits, turn_of
from camrob.program.motion import Motion, Turning
from camrob.program.program import ProgramEvent, ProgramEventKind

GOLDEN = Path(__file__).parents[1] / "golden"
# degrees of axis 1, 4 or 6, and the quarter that ABB counts it in: 0 from 0 to 90, -1 from 0 to -90
QUARTERS = {
    0.0: 0, 0.0001: 0, 45.0: 0, 89.9999: 0, 90.0: 1, 90.0001: 1, 179.9999: 1, 180.0: 2, 269.0: 2, 270.0: 3, 300.0: 3, 359.9: 3,
    360.0: 4, -0.0001: -1, -45.0: -1, -90.0: -1, -90.0001: -2, -135.0: -2, -180.0: -2, -180.0001: -3, -269.0: -3, -300.0: -4,
    -359.9: -4, -360.0: -4,
}  # fmt: skip
# ABB's table of cfx: wrist's centre behind axis 1, behind the lower arm, axis 5 negative
CFX = {
    0: (False, False, False), 1: (False, False, True), 2: (False, True, False), 3: (False, True, True),
    4: (True, False, False), 5: (True, False, True), 6: (True, True, False), 7: (True, True, True),
}  # fmt: skip


def test_the_program_written_by_hand_is_what_is_printed() -> None:
    files = written(bracket())
    assert list(files) == ["Bracket_7.mod", "Bracket_7.pgf"]
    for name, content in files.items():
        assert content.decode("ascii") == (GOLDEN / name).read_bytes().decode("ascii"), name


@pytest.mark.parametrize("axis", [0, 3, 5])
def test_quarters_are_counted_as_abb_counts_them(axis: int) -> None:
    axes = np.zeros((len(QUARTERS), 6))
    axes[:, axis] = list(QUARTERS)
    told = quarters_of(turn_of(Turning.QUARTERS, axes))
    wanted = np.zeros((len(QUARTERS), 3), int)
    wanted[:, [0, 3, 5].index(axis)] = list(QUARTERS.values())
    assert np.array_equal(told, wanted)
    for row, turn in zip(axes, turn_of(Turning.QUARTERS, axes).tolist(), strict=True):
        assert turn_fits(Turning.QUARTERS, turn, row[None]).all()
        past = np.array([row, row]) + np.outer(
            [0.01, -0.01], np.eye(6)[axis]
        )  # over a border it still is its neighbour's
        near = np.isclose(np.abs(row[axis]) % 90.0, 0.0, atol=1e-3) | np.isclose(
            np.abs(row[axis]) % 90.0, 90.0, atol=1e-3
        )
        assert turn_fits(Turning.QUARTERS, turn, past).tolist().count(False) == int(near)


def test_an_axis_beyond_two_turns_has_no_quarter() -> None:
    assert turn_of(Turning.QUARTERS, np.full((1, 6), -720.0)).tolist() == [0]
    for angle in (720.0, -720.1):
        with pytest.raises(ValueError, match="two turns"):
            turn_of(Turning.QUARTERS, np.full((1, 6), angle))


@pytest.mark.parametrize("cfx", CFX)
def test_cfx_is_abbs_table(cfx: int) -> None:
    """KUKA's bits: 1 behind axis 1, 2 the elbow bent to the front, 4 axis 5 negative."""
    behind, behind_arm, negative = CFX[cfx]
    program = bracket()
    status = np.array(program.status)
    status[1] = behind + 2 * (not behind_arm) + 4 * negative
    text = written(dataclasses.replace(program, status=status))["Bracket_7.mod"].decode()
    found = re.search(r"MoveJ \[\[[^\]]*\],\[[^\]]*\],\[(-?\d+),(-?\d+),(-?\d+),(\d)\]", text)
    assert found is not None and [int(v) for v in found.groups()] == [-2, 2, -3, cfx]


def test_quaternions_are_another_librarys() -> None:
    generator = np.random.default_rng(11)
    abc = generator.uniform([-180, -90, -180], [180, 90, 180], (2000, 3))
    abc[:200, 1] = generator.choice([90.0, -90.0, 89.99999, 0.0], 200)
    abc[200:260] = generator.choice([0.0, 90.0, 180.0, -180.0], (60, 3)) * [1, 0.5, 1]
    q = quaternions(abc)
    theirs = Rotation.from_euler("ZYX", abc, degrees=True)
    mine = Rotation.from_quat(q[:, [1, 2, 3, 0]])
    assert (theirs.inv() * mine).magnitude().max() < 2e-8  # rad: what eight decimals leave
    assert np.array_equal(np.round(q, 8) + 0.0, q) and np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < 2e-8
    first = np.array([row[np.flatnonzero(row)[0]] for row in q])
    assert np.all(first > 0.0) and np.all(q[:, 0] >= 0.0)


def test_rounding_a_frame_is_a_fixed_point_and_near_everywhere() -> None:
    generator = np.random.default_rng(4)
    frames = generator.uniform([-3000] * 3 + [-180, -90, -180], [3000] * 3 + [180, 90, 180], (3000, 6))
    frames[::7, 4] = 90.0
    once = RAPID.round.frame(frames)
    assert np.array_equal(RAPID.round.frame(once), once)
    apart = Rotation.from_euler("ZYX", frames[:, 3:], degrees=True).inv() * Rotation.from_euler(
        "ZYX", once[:, 3:], degrees=True
    )
    assert apart.magnitude().max() < 3e-8 and np.abs(once[:, :3] - frames[:, :3]).max() <= 5.1e-6


def test_a_long_program_is_split_and_listed() -> None:
    files = written(bracket(), max_lines=4)
    assert list(files) == ["Bracket_7.mod", "Bracket_7_001.mod", "Bracket_7_002.mod", "Bracket_7.pgf"]
    assert re.findall(r"p_Bracket_7_\d+;", files["Bracket_7.mod"].decode()) == ["p_Bracket_7_001;", "p_Bracket_7_002;"]
    assert re.findall(r"<Module>(.*)</Module>", files["Bracket_7.pgf"].decode()) == list(files)[:3]
    for name in list(files)[1:3]:
        text = files[name].decode()
        assert text.startswith(f"MODULE {name[:-4]}\r\n    PROC p_{name[:-4]}()\r\n") and "PERS" not in text
    words = [line.strip() for file in list(files)[:3] for line in files[file].decode().split("\r\n") if "Move" in line]
    whole = [line.strip() for line in written(bracket())["Bracket_7.mod"].decode().split("\r\n") if "Move" in line]
    assert [w for w in words if not w.startswith("!")] == [w for w in whole if not w.startswith("!")]


def test_names_and_comments() -> None:
    for text, name in (
        ("Flügel 3", "Fluegel_3"), ("main", "P_main"), ("MoveTo", "P_MoveTo"), ("v500", "P_v500"), ("7up", "P_7up"), ("", "P"),
        ("x" * 40, "x" * 24), ("TOOL0", "P_TOOL0"), ("%\"!; proc", "P_proc"), ("endproc", "P_endproc"),
    ):  # fmt: skip
        assert rapid_name(text) == name == rapid_name(name)
    assert comment_text("a\r\nMoveL p1;\u2028<SMT>\t\x00", 100) == "a MoveL p1; (SMT)"
    assert len(comment_text("y" * 300, 80)) == 80


def refused(program, error, match: str, settings=CONTROLLER) -> None:
    with pytest.raises(error, match=match):
        RAPID.check(program, settings)


def test_what_rapid_can_not_say_is_refused() -> None:
    good = bracket()
    pose = np.array(good.pose)
    near, flat, long = pose.copy(), pose.copy(), pose.copy()
    near[4, :3] = pose[3, :3] + [0.05, 0.0, 0.0]
    flat[4, :3], flat[5, :3] = [75, 0.2, 10], [100, 0, 10]  # 0.46 degrees as the start sees them
    long[4, :3], long[5, :3] = [70, 10, 10], [60, -3, 10]  # start, via, end: 253 degrees of a circle
    refused(dataclasses.replace(good, pose=near), JobError, "nearer than 0.1 mm")
    refused(dataclasses.replace(good, pose=flat), JobError, "flatter than 1 degree")
    assert _turned(long) > 240
    refused(dataclasses.replace(good, pose=long), JobError, "more than 240 degrees")
    silent = dataclasses.replace(good, events=tuple(e for e in good.events if e.kind is not ProgramEventKind.LOAD))
    RAPID.check(silent, CONTROLLER)
    refused(silent, JobError, "nobody says what it weighs", controller(tool_data=None))
    late = (*good.events, ProgramEvent(9, ProgramEventKind.LOAD, value=0.0))
    refused(dataclasses.replace(good, events=late), JobError, "behind the last motion")
    refused(good, JobError, "max_line_length", dataclasses.replace(CONTROLLER, max_line_length=200))
    rounded = np.array(good.approximate)
    rounded[2] = True
    refused(dataclasses.replace(good, approximate=rounded), ValueError, "does not wait for the robot")
    axes = np.array(good.axes)
    axes[2, 5] = 721.0
    refused(dataclasses.replace(good, axes=axes), ValueError, "two turns")
    turned = np.array(good.pose)
    turned[2, 3] += 1e-6
    refused(dataclasses.replace(good, pose=turned), ValueError, "more decimals")
    refused(dataclasses.replace(good, external_names=("E1", "E7")), ValueError, "E1 to E6")


def _turned(pose: np.ndarray) -> float:
    """Degrees that the circle through rows 3, 4 and 5 turns, from its centre."""
    a, b, c = (pose[k, :2] for k in (3, 4, 5))
    centre = np.linalg.solve(2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])
    at = [np.arctan2(*(p - centre)[::-1]) for p in (a, b, c)]
    way = (at[2] - at[0]) % (2 * np.pi)
    return float(np.degrees(way if (at[1] - at[0]) % (2 * np.pi) < way else 2 * np.pi - way))


@pytest.mark.parametrize(
    ("own", "match"),
    [
        ({"ptp_speed": None}, "ptp_speed is None"),
        ({"ptp_speed": [1, 2, 3]}, "ptp_speed"),
        ({"ptp_speed": [1, 2, 3, 0]}, "ptp_speed"),
        ({"ptp_speed": [1, 2, 3, True]}, "ptp_speed"),
        ({"mechanical_unit": 'STN1"'}, "mechanical_unit"),
        ({"mechanical_unit": None}, "the work object stands still"),
        ({"active_units": "STN1"}, "active_units"),
        ({"active_units": [""]}, "active_units"),
        ({"tool_data": "a b"}, "tool_data"),
        ({"ori_type": "#VAR"}, "ori_type is nothing that RAPID takes"),
    ],
)
def test_settings_that_are_none_are_refused(own: dict[str, object], match: str) -> None:
    with pytest.raises(CellError, match=match):
        RAPID.settings(controller(**own), follows_table=True)
    RAPID.settings(controller(), follows_table=True)


def test_a_work_object_on_a_unit_needs_a_base_that_follows() -> None:
    with pytest.raises(CellError, match="base_follows_table is false"):
        RAPID.settings(controller(), follows_table=False)
    RAPID.settings(controller(mechanical_unit=None), follows_table=False)
    text = written(bracket(), controller(mechanical_unit=None))["Bracket_7.mod"].decode()
    assert 'wobjdata w_Bracket_7:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[100.00000' in text


@pytest.mark.parametrize(
    "line",
    [
        "MoveL p1,v5,fine,tool0;", "moveabsj p1,v5,fine,tool0;", "TriggL p1,v5,t1,fine,tool0;", "SetDO a,1; SetDO b,1;",
        "SetDO a,1",        "SetDO a,1; ! text", "! text", "t_part.tframe:=pose0;", "t2_part:=tool0;",
        "w_part.oframe.trans.x:=1;",
        "PDispOn p1,tool0;",        "ConfL\\On;", "AccSet 20,20;", "VelSet 50,800;", "IF a=1 Stop;", "RETURN;",
        "ENDPROC", "ActUnit STN2;", "GripLoad load0;",
        "VAR num x;", ";", "[1,2];", "EXIT;", "UnLoad \"a.mod\";", "other.tload:=load0;",
    ],
)  # fmt: skip
def test_a_hook_may_not_do_what_camrob_has_to_know_of(line: str) -> None:
    with pytest.raises(CellError, match="hook stop"):
        RAPID.settings(dataclasses.replace(CONTROLLER, hooks={"stop": (line,)}), follows_table=True)


@pytest.mark.parametrize(
    "line",
    [
        "Stop;",
        "SetDO\\SDelay:=0.2,doA,1;",
        'TPWrite "a; b ! MoveL";',
        "count:=count+1;",
        "ToolChange 7;",
        "WaitDI diReady,1;",
    ],
)
def test_a_hook_may_switch_wait_and_call(line: str) -> None:
    RAPID.settings(dataclasses.replace(CONTROLLER, hooks={"stop": (line,)}), follows_table=True)


def test_a_program_on_nothing_but_axes() -> None:
    """A program of joint motions, without external axes."""
    program = bracket()
    rows = np.array([0, 8])
    short = dataclasses.replace(
        program,
        **{
            n: np.asarray(getattr(program, n))[rows]
            for n in ("kind", "pose", "axes", "status", "turn", "speed", "approximate")
        },
        **{n: np.asarray(getattr(program, n))[rows] for n in ("line", "region", "safe")},
        external=np.zeros((2, 0)),
        external_names=(),
        events=(),
    )
    text = written(short)["Bracket_7.mod"].decode()
    assert text.count("[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs") == 2 and set(program.kind[rows].tolist()) == {
        Motion.PTP_AXES
    }
    assert f"{OWN['tool_data']}.tload;" in text
