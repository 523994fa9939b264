"""The witness runs KRL: what each statement does, what stands against a program, what is left unjudged."""

from __future__ import annotations

import gzip
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import KrlError
from camrob.witness.frames import frame
from camrob.witness.happenings import Kind
from camrob.witness.krl.acts import ACTS
from camrob.witness.krl.run import run_program
from camrob.witness.krl.settings import SETTINGS
from camrob.witness.krl.statements import BAS, STATEMENTS, VARIABLES
from camrob.witness.krl.text import read_source
from camrob.witness.machine import read_machine

ROOT = Path(__file__).parents[2]
CORPUS = ROOT.parent / "shared" / "corpus" / "krl"
CELL = (ROOT / "cells" / "kr15_track_table" / "cell.toml").read_text()
MACHINE = read_machine(ROOT / "cells" / "kr15_track_table")
EK = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})"
TOOL = "$TOOL = {X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}"
FRAMES = f"$BASE = {EK}\n{TOOL}\n"
HOME = "PTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\n"
POSE = "X 97.000,Y -41.764,Z 619.422,A 180.000,B 0.000,C 20.420"  # HOME, as the spec has it


def machine_of(tmp_path, *changes):
    """The KR15 cell with some of its text changed."""
    text = CELL
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "cell.toml").write_text(text)
    return read_machine(tmp_path / "cell.toml")


def run(tmp_path, body, *, head=FRAMES + HOME, machine=MACHINE, files=None, tail=""):
    """A program of this body, run."""
    for name, text in (files or {}).items():
        (tmp_path / name).write_text(text)
    path = tmp_path / "job.src"
    path.write_text(f"DEF job ( )\n{head}{body}\nEND\n{tail}", encoding="utf-8")
    return run_program(path, machine)


def codes(made):
    return [objection.code for objection in made.objections]


def kinds(made):
    return [(event.before, event.kind, event.value, event.text) for event in made.events]


def tip_mm(made, row=-1):
    return made.path.tip[row] * 1000


# the table itself


def test_every_row_of_the_table_has_an_act_and_a_document():
    flow = {"leave", "leave_loop", "jump", "call"}
    assert {row.act for row in STATEMENTS} == set(ACTS) | flow
    assert {row.act for row in VARIABLES} == set(SETTINGS)
    for row in (*STATEMENTS, *VARIABLES):
        assert row.does and row.document.startswith("KUKA")
    assert all(does for _, does in BAS.values())


# motions


def test_home_by_axes_and_by_pose(tmp_path):
    made = run(tmp_path, f"PTP {{E6POS: {POSE},S 2,T 2,E1 0,E2 0}}")
    assert made.ptp.all() and not made.objections and not made.gaps
    for row in (0, 1):
        assert np.allclose(tip_mm(made, row), [97.0, -41.763657, 619.422], atol=1e-3)
        assert np.allclose(made.path.axis[row], [0, 0.3489, 0.9372], atol=1e-4)
    assert np.allclose(made.axes[1], [0, -90, 90, 0, 90, 0, 0, 0], atol=1e-3)
    assert made.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    assert made.path.line.tolist() == [4, 5] and np.isnan(made.speed).all()


def test_lin_moves_the_tip_where_it_says(tmp_path):
    made = run(tmp_path, "$VEL.CP = 0.05\nLIN {X 107,Y -41.764,Z 600} C_DIS\nLIN {E6POS: Z 590,E1 20,E2 -30}")
    assert np.allclose(tip_mm(made, 1), [107, -41.764, 600]) and np.allclose(tip_mm(made, 2), [107, -41.764, 590])
    assert made.speed[1:].tolist() == [0.05, 0.05] and made.ptp.tolist() == [True, False, False]
    assert made.exact.tolist() == [True, False, True]
    assert made.axes[2, 6:].tolist() == [20, -30]
    # the axes found take the tool there: the machine's own forward kinematics says so
    base_T_tool = MACHINE.base_T_flange(made.axes) @ made.tools[made.tool[0]]
    assert np.allclose(base_T_tool[:, :3, 3], made.path.tip, atol=1e-9)
    assert np.allclose(base_T_tool[:, :3, 2], made.path.axis, atol=1e-9)


def test_what_is_left_out_keeps_its_value(tmp_path):
    made = run(tmp_path, "PTP {A1 10}\nPTP {A2 -80,E2 5}\nLIN {Z 600}\nLIN {X 90}\nPTP {A6 20}")
    assert made.axes[1].tolist() == [10, -90, 90, 0, 90, 0, 0, 0] and made.axes[2].tolist() == [
        10,
        -80,
        90,
        0,
        90,
        0,
        0,
        5,
    ]
    assert np.allclose(tip_mm(made, 3)[:2], tip_mm(made, 2)[:2]) and tip_mm(made, 3)[2] == pytest.approx(600)
    assert np.allclose(made.path.axis[3], made.path.axis[2]) and np.allclose(made.path.axis[4], made.path.axis[2])
    assert tip_mm(made, 4)[0] == pytest.approx(90) and tip_mm(made, 4)[1] == pytest.approx(tip_mm(made, 2)[1])
    assert np.allclose(made.axes[5, :5], made.axes[4, :5]) and made.axes[5, 5] == 20 and made.axes[5, 7] == 5
    assert not made.gaps and not made.objections


def test_a_left_out_component_after_another_base(tmp_path):
    raised = EK.replace("Z 0", "Z 100")
    made = run(tmp_path, f"LIN {{Z 600}}\n$BASE = {raised}\nLIN {{X 100}}")
    assert np.allclose(tip_mm(made), [100, -41.763657, 600], atol=1e-3)


def test_null_motions_do_nothing(tmp_path):
    made = run(tmp_path, "PTP $POS_ACT\nPTP $AXIS_ACT_MEAS C_PTP\nLIN $POS_ACT\nPTP $AXIS_ACT")
    assert len(made) == 1 and not made.gaps


def test_relative_motions(tmp_path):
    made = run(tmp_path, "LIN_REL {Z -20,E1 5}\nLIN_REL {X 10} C_DIS\nPTP_REL {A1 3}\nPTP_REL {Z 1}\nLIN_REL {A 3}")
    assert np.allclose(tip_mm(made, 1), [97, -41.763657, 599.422], atol=1e-3) and made.axes[1, 6] == 5
    assert np.allclose(tip_mm(made, 2), [107, -41.763657, 599.422], atol=1e-3)
    assert [gap.first_line for gap in made.gaps] == [7, 8, 9]  # axes after a LIN, and angles, are left unjudged
    again = run(tmp_path, "PTP_REL {A1 3,E1 4}\nPTP_REL {Z 1}")
    assert again.axes[1].tolist() == [3, -90, 90, 0, 90, 0, 4, 0] and not again.gaps
    assert tip_mm(again, 2)[2] == pytest.approx(tip_mm(again, 1)[2] + 1)


def test_from_where_the_robot_stands(tmp_path):
    """A program that asks waits: the rounding before it is none. Behind axes the place is known by the chain."""
    ways = (
        "DECL E6POS P\nDECL E6AXIS Q\nLIN {Z 600}\nLIN {X 100} C_DIS\nP=$POS_ACT\nP.Z=P.Z+20\nLIN P C_DIS\nLIN {Y 5}\n"
    )
    made = run(
        tmp_path,
        ways + "PTP {A1 3,A2 -90,A3 90,A4 0,A5 90,A6 0}\nQ=$AXIS_ACT\nQ.A1=Q.A1+4\nPTP Q\nP=$POS_ACT\nP.Z=P.Z+1\nLIN P",
    )
    assert not made.gaps and made.exact.tolist()[1:5] == [True, True, False, True]
    assert np.allclose(tip_mm(made, 3)[[0, 2]], [100, 620], atol=1e-6) and made.axes[6, 0] == 7
    assert np.allclose(tip_mm(made, 7) - tip_mm(made, 6), [0, 0, 1], atol=1e-6)
    (gap,) = run(tmp_path, "DECL E6AXIS Q\nLIN {Z 600}\nQ=$AXIS_ACT\nPTP Q").gaps
    assert "isn't known" in gap.text or "no value" in gap.text


def test_a_step_along_the_tool(tmp_path):
    """At A 90, B 0, C 180 the tool's x is the base's y, its z the base's -z."""
    made = run(
        tmp_path,
        "LIN {X 100,Y 0,Z 600,A 90,B 0,C 180}\nLIN_REL {X 10} #TOOL\nLIN_REL {Z -7} C_DIS #TOOL\nPTP_REL {A1 3} #TOOL",
    )
    assert np.allclose(tip_mm(made, 2), [100, 10, 600], atol=1e-6)
    assert np.allclose(tip_mm(made, 3), [100, 10, 607], atol=1e-6)
    assert [gap.first_line for gap in made.gaps] == [8]


def test_a_circle(tmp_path):
    body = "LIN {X 100,Y 0,Z 600}\nCIRC {X 110,Y 10,Z 600},{X 100,Y 20,Z 600,E1 4} C_DIS\nLIN {X 100,Y 0}"
    made = run(tmp_path, body)
    assert np.allclose(made.path.center[2] * 1000, [100, 10, 600]) and np.allclose(made.path.normal[2], [0, 0, 1])
    assert made.path.angle[2] == pytest.approx(math.pi) and np.isnan(made.path.angle[[0, 1, 3]]).all()
    assert not made.exact[2] and made.axes[2, 6] == 4 and not made.objections
    other = run(tmp_path, body.replace("X 110", "X 90"))
    assert np.allclose(other.path.normal[2], [0, 0, -1])


@pytest.mark.parametrize(("angle", "normal", "end"), [(360, 1, (100, 0)), (90, 1, (110, 10)), (-90, -1, (90, 10))])
def test_a_circle_by_its_angle(tmp_path, angle, normal, end):
    made = run(tmp_path, f"LIN {{X 100,Y 0,Z 600}}\nCIRC {{X 110,Y 10}},{{X 100,Y 20}},CA {angle} C_DIS")
    assert made.path.angle[2] == pytest.approx(math.radians(abs(angle)))
    assert np.allclose(made.path.normal[2], [0, 0, normal]) and np.allclose(tip_mm(made)[:2], end)
    assert not made.gaps


def test_a_circle_by_its_angle_that_also_turns_is_not_judged(tmp_path):
    made = run(tmp_path, "LIN {X 100,Y 0,Z 600}\nCIRC {X 110,Y 10},{X 100,Y 20,A 175},CA 200")
    assert len(made.gaps) == 1 and "CA" in made.gaps[0].text


def test_a_circle_through_two_points(tmp_path):
    made = run(tmp_path, "LIN {X 100,Y 0,Z 600}\nCIRC {X 100,Y 10},{X 100,Y 20}\nCIRC {X 90,Y 15},{X 100,Y 20}")
    assert codes(made) == ["circle", "circle"] and [item.line for item in made.objections] == [6, 7]


def test_points_of_the_data_list_and_inline_forms(tmp_path):
    data = """DEFDAT job
DECL E6POS XP1={X 107.0,Y -41.764,Z 600.0,A 180.0,B 0.0,C 20.42,S 2,T 2,E1 3.0}
DECL E6AXIS XHOME={A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}
DECL FDAT FP1={TOOL_NO 3,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " "}
DECL PDAT PDEFAULT={VEL 100,ACC 100}
DECL FRAME ARR[3]
ARR[1]={X 107,Y -41,Z 601,A 180,B 0,C 20}
ENDDAT
"""
    body = """;FOLD PTP P1 CONT Vel=100 % PDAT1 Tool[3] Base[1];%{PE}%R 5.5.31
$BWDSTART=FALSE
PDAT_ACT=PDEFAULT
PTP XHOME
SPTP XP1 C_PTP
;ENDFOLD
SLIN XP1
LIN XP2"""
    made = run(tmp_path, body, files={"job.dat": data})
    assert len(made) == 4 and np.allclose(tip_mm(made), [107, -41.764, 600]) and made.axes[3, 6] == 3
    assert [gap.first_line for gap in made.gaps if gap.file == 0] == [12]  # XP2 is nowhere


def test_collision_detection_of_inline_forms_leaves_the_way_as_it_is(tmp_path):
    made = run(tmp_path, f"SET_CD_PARAMS (0)\nLIN {{E6POS: {POSE},E1 0,E2 0}}")
    assert not made.gaps and not made.objections


def test_a_ptp_to_a_place_that_nobody_knows_is_no_lack_of_one(tmp_path):
    made = run(tmp_path, f"PTP {{{POSE},S 2,T 10,E1 0,E2 0}}\n{FRAMES}LIN {{E6POS: {POSE},E1 0,E2 0}}", head="")
    assert "start-unknown" not in codes(made) and any("which $BASE holds" in gap.text for gap in made.gaps)


def test_frames_by_number(tmp_path):
    body = """TOOL_DATA[3] = {X 0,Y 0,Z 100,A 0,B 0,C 0}
FDAT_ACT = {TOOL_NO 3,BASE_NO 0,IPO_FRAME #BASE}
BAS(#FRAMES)
PTP {A1 1}
BAS (#TOOL,0 )
PTP {A1 0}
$TOOL = TOOL_DATA[3]
PTP {A1 0}
$TOOL = TOOL_DATA[4]
PTP {A1 0}"""
    made = run(tmp_path, body)
    flange = MACHINE.base_T_flange(made.axes)
    assert np.allclose(made.path.tip[1], (flange[1] @ frame(np.array([0, 0, 100.0, 0, 0, 0])))[:3, 3])
    assert np.allclose(made.path.tip[2], flange[2][:3, 3])
    assert np.allclose(made.path.tip[3], (flange[3] @ frame(np.array([0, 0, 100.0, 0, 0, 0])))[:3, 3])
    assert np.isnan(made.path.tip[4]).all() and not np.isnan(made.axes[4]).any()
    assert [gap.first_line for gap in made.gaps] == [13]


def test_spline_words(tmp_path):
    made = run(
        tmp_path,
        "SLIN {Z 600} WITH $ACC.CP=0.1\nSPLINE\nSPL {X 100}\nSLIN {X 110}\nENDSPLINE\nSCIRC {X 115,Y -36},{X 110,Y -31}",
    )
    assert len(made) == 5 and len(made.gaps) == 2 and codes(made).count("setting-lower") == 1
    assert all("spline" in gap.text for gap in made.gaps)


# frames


def test_the_base_turns_with_the_table(tmp_path):
    made = run(tmp_path, "LIN {Z 600}\nLIN {Z 600,E2 40}")
    assert np.allclose(made.path.tip[1], made.path.tip[2]) and made.axes[2, 0] != pytest.approx(made.axes[1, 0])
    assert not made.ptp[1:].any()


def test_an_offset_base_and_its_components(tmp_path):
    raised = EK.replace("X 0,Y 0,Z 0,A 0", "X 10,Y 0,Z 100,A 90")
    body = f"$BASE = {raised}\nLIN {{X 0,Y -87,Z 500,A 90,B 0,C 20.42}}\n$BASE.Z = 110\n"
    body += "LIN {Z 500}\n$TOOL.Z = 425.577926\nPTP {A1 0}"
    made = run(tmp_path, body)
    assert np.allclose(tip_mm(made, 1), [97, 0, 600], atol=1e-9) and np.allclose(
        tip_mm(made, 2), [97, 0, 610], atol=1e-9
    )
    assert np.allclose(made.path.axis[1], [0, 0.3489, 0.9372], atol=1e-4)  # A 90 in a base turned by A 90
    assert len(made.tools) == 3 and not made.gaps and not made.objections


@pytest.mark.parametrize(
    "text", ["$BASE = {X 0,Y 0,Z 0,A 0,B 0,C 0}", "BAS(#BASE,0)", "$BASE = $NULLFRAME", "$BASE=$WORLD"]
)
def test_a_base_that_stands_still_where_it_should_turn(tmp_path, text):
    made = run(tmp_path, f"{text}\nLIN {{Z 600}}")
    assert codes(made) == ["base-stands-still"] and made.objections[0].line == 5
    harmless = run(tmp_path, f"{text}\nPTP {{A1 1}}\n$BASE = {EK}\nLIN {{Z 600}}")
    assert not harmless.objections  # no pose was read in it


def test_a_literal_base_is_fixed_in_the_world(tmp_path):
    still = machine_of(tmp_path, ("base_follows_table = true", "base_follows_table = false"))
    literal = "$BASE = {X 0,Y 0,Z 0,A 0,B 0,C 0}\n" + TOOL + "\n"
    made = run(tmp_path, f"PTP {{E2 90,A1 0}}\nLIN {{{POSE}}}\nLIN {{E2 50}}", head=literal + HOME, machine=still)
    assert not made.objections
    # the tool has not moved, the table has turned by 90 degrees: the spec's own row of the table at 90
    assert np.allclose(tip_mm(made, 2), [41.764, 97.0, 619.422], atol=1e-3) and np.allclose(
        made.axes[2, :6], made.axes[0, :6], atol=1e-3
    )
    assert made.ptp.tolist() == [True, True, False, True]  # the last is no line on the table


def test_the_base_of_another_mechanism(tmp_path):
    made = run(tmp_path, f"$BASE = {EK.replace('[2]', '[3]')}\nLIN {{Z 600}}")
    assert codes(made) == ["base-other-mechanism"]
    mixed = run(tmp_path, f"$BASE = {EK.replace('[2].ROOT', '[3].ROOT')}\nLIN {{Z 600}}")
    assert codes(mixed) == ["base-other-mechanism"]
    old = run(tmp_path, "$BASE=EK(EX_AX_DATA[1].ROOT,EX_AX_DATA[1].EX_KIN,EX_AX_DATA[1].OFFSET)\nLIN {Z 600}")
    assert [gap.first_line for gap in old.gaps] == [5, 6] and len(old) == 1


def test_frames_that_the_text_does_not_set(tmp_path):
    made = run(tmp_path, f"LIN {{{POSE}}}", head=HOME)
    assert np.isnan(made.path.tip).all() and "$BASE" in made.gaps[0].text
    made = run(tmp_path, "$BASE = {X 1,Y 2}\nLIN {Z 600}\n$TOOL = BASE_DATA[7]\nPTP {A1 3}")
    assert [gap.first_line for gap in made.gaps][:1] == [5] and np.isnan(made.path.tip[1:]).all()


def test_a_tool_that_the_text_does_not_set(tmp_path):
    made = run(tmp_path, f"LIN {{{POSE}}}\nPTP {{{POSE},S 2,T 2}}", head=f"$BASE = {EK}\n" + HOME)
    assert [gap.first_line for gap in made.gaps] == [4] and not made.objections
    assert (
        np.allclose(tip_mm(made, 1), [97, -41.764, 619.422]) and np.isnan(made.path.tip[0]).all()
    )  # the text gives the pose
    assert np.isnan(made.axes[1:]).all() and np.isfinite(made.axes[0]).all()


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("$ROBROOT = {X 0,Y 0,Z 0,A 0,B 0,C 0}", "robroot"),
        ("$ROBROOT.X = 5", "robroot"),
        ("$WORLD = {X 0,Y 0,Z 1,A 0,B 0,C 0}", "world"),
        ("$IPO_MODE = #TCP", "external-tool"),
        ("$ACT_EX_AX = 1", "external-axes"),
        ("$ASYNC_AXIS = 'B0001'", "async-axis"),
        ("$VEL.CP = 0.0", "speed"),
        ("$OV_PRO = 50", "override"),
    ],
)
def test_settings_that_stand_against_a_program(tmp_path, text, code):
    made = run(tmp_path, text)
    assert codes(made) == [code] and made.objections[0].line == 5


@pytest.mark.parametrize(
    "text",
    [
        "$ROBROOT = {X -803,Y 0,Z -305,A 0,B 0,C 0}",
        "$WORLD = $NULLFRAME",
        "$IPO_MODE = #BASE",
        "$ACT_EX_AX = 2",
        "$ASYNC_AXIS = 0",
        "$OV_PRO = 100",
        "$ACT_TOOL = 3",
        "$APO.CDIS = 0.5",
        "$ACC = {CP 1.0,ORI1 100,ORI2 100}",
        "BAS (#INITMOV,0 )",
        "BAS(#VEL_PTP,100)",
        "$ORI_TYPE = #VAR",
        "$CIRC_TYPE=#BASE",
        "INTERRUPT OFF 3",
        "DECL INT i",
        "EXT BAS (BAS_COMMAND :IN,REAL :IN )",
    ],
)
def test_settings_that_do_no_harm(tmp_path, text):
    made = run(tmp_path, f"{text}\nLIN {{Z 600}}")
    assert not made.objections and not made.gaps and not made.events


@pytest.mark.parametrize(
    ("text", "speed"),
    [
        ("$VEL = {CP 0.3,ORI1 100,ORI2 100}", 0.3),
        ("$VEL.CP = 2 * 0.1", 0.2),
        ("BAS(#VEL_CP,0.15)", 0.15),
        ("LDAT_ACT = {VEL 2,ACC 100}\nFDAT_ACT = {TOOL_NO 0,BASE_NO 0,IPO_FRAME #BASE}\nBAS (#CP_PARAMS,0.25 )", 0.25),
        ("LDAT_ACT = {ACC 100}\nBAS(#CP_DAT)", float("nan")),
        ("$VEL.CP = MMPM(300.0)", float("nan")),
        ("$VEL = {ORI1 100}", float("nan")),
    ],
)
def test_speeds(tmp_path, text, speed):
    made = run(tmp_path, f"{text}\nLIN {{{POSE}}}\nPTP {{A1 3}}")
    assert made.speed[1] == pytest.approx(speed, nan_ok=True) and np.isnan(made.speed[[0, 2]]).all()
    assert bool(made.gaps) == (text.startswith("$VEL") and math.isnan(speed))


def test_how_the_tool_turns(tmp_path):
    made = run(tmp_path, "$ORI_TYPE = #CONSTANT\nLIN {Z 600,A 170}\n$ORI_TYPE = #VAR\nLIN {A 170}")
    assert np.allclose(made.path.axis[1], made.path.axis[0]) and not made.gaps
    assert np.allclose(made.path.axis[2], frame(np.array([0, 0, 0, 170, 0, 20.42]))[:3, 2], atol=1e-4)
    assert run(tmp_path, "$ORI_TYPE = #JOINT\nLIN {Z 600}").gaps
    assert not run(tmp_path, "$CIRC_TYPE = #PATH\nLIN {Z 600}").gaps
    assert run(tmp_path, "$CIRC_TYPE = #PATH\nLIN {Z 600}\nCIRC {X 105},{X 107,Y -30}").gaps


# Status and Turn


def test_status_and_turn_choose_the_posture(tmp_path):
    made = run(tmp_path, f"PTP {{{POSE},S 6,T 26}}")
    # the wrist turned over: A4 and A6 by half a turn, A5 to the other side
    assert not made.objections and np.allclose(np.abs(made.axes[1, 3:6]), [180, 90, 180], atol=1e-2)
    assert made.axes[1, 3] < 0 and made.axes[1, 4] < 0 and made.axes[1, 5] > 0
    assert np.allclose(made.path.tip[0], made.path.tip[1], atol=1e-6)
    turned = run(tmp_path, f"PTP {{{POSE},S 6,T 58}}")
    assert turned.axes[1, 5] < 0 and not turned.objections


@pytest.mark.parametrize(
    ("given", "expected"),
    [("S 2,T 3", []), ("S 2,T 2", ["status-turn"]), ("S 3,T 3", ["status-turn"]), ("S 2,T 10", [])],
)
def test_status_or_turn_that_do_not_fit(tmp_path, given, expected):
    # beside the table A1 is below zero, and no posture has the wrist behind axis 1; A4 at 0 may be printed as either
    pose = POSE if given == "S 2,T 10" else POSE.replace("X 97.000", "X 60").replace("Y -41.764", "Y 200")
    made = run(tmp_path, f"PTP {{{pose},{given}}}")
    assert codes(made) == expected


def test_status_left_out_is_a_warning(tmp_path):
    made = run(tmp_path, f"PTP {{{POSE}}}")
    assert [(item.code, item.severity) for item in made.objections] == [("no-status-turn", "warning")]
    assert np.allclose(made.axes[1], made.axes[0], atol=1e-3)


def test_lin_ignores_status_and_turn(tmp_path):
    made = run(tmp_path, f"LIN {{{POSE},S 5,T 63}}")
    assert not made.objections and np.allclose(made.axes[1], made.axes[0], atol=1e-3)


def test_a_lin_first_is_no_start(tmp_path):
    made = run(tmp_path, f"LIN {{{POSE}}}\nLIN {{Z 600}}", head=FRAMES)
    assert codes(made) == ["start-unknown"] and np.allclose(made.axes[0], [0, -90, 90, 0, 90, 0, 0, 0], atol=1e-3)
    partial = run(tmp_path, "PTP {A1 5}", head=FRAMES)
    assert codes(partial) == ["start-unknown"]


# limits, reach, singular postures


def test_limits_on_both_sides(tmp_path):
    inside = "PTP {A1 184.9,A6 -349.9,E1 1500,E2 100000}"
    assert not run(tmp_path, inside).objections
    made = run(tmp_path, "PTP {A1 185.1}\nPTP {A1 0,E1 -1500.5}")
    assert [(item.code, item.axis, item.line, item.value, item.limit, item.unit) for item in made.objections] == [
        ("limit", "A1", 5, 185.1, 185.0, "deg"),
        ("limit", "E1", 6, -1500.5, -1500.0, "mm"),
    ]


def test_out_of_reach_is_reported_once(tmp_path):
    body = "\n".join(f"LIN {{X {2900 + k}.0,Y 0.0,Z 600.0,A 180.0,B 0.0,C 20.0}}" for k in range(20))
    made = run(tmp_path, f"LIN {{Z 600}}\n{body}\nLIN {{X 97,Y 0,Z 600}}")
    assert codes(made) == ["unreachable"] and "21 motions" in made.objections[0].text and made.objections[0].line == 6
    assert np.isnan(made.axes[2:22]).all() and not np.isnan(made.axes[22]).any()
    assert codes(run(tmp_path, f"PTP {{{POSE.replace('X 97', 'X 2997')},S 2,T 2}}")) == ["unreachable"]


def test_a_line_through_a_stretched_wrist(tmp_path):
    made = run(tmp_path, "PTP {A5 0.01}\nLIN_REL {X -5}")
    assert "singular" in codes(made)
    assert not run(tmp_path, "PTP {A5 0}\nPTP {A5 20}\nLIN_REL {X -5}").objections


def test_a_limit_between_the_ends_of_one_line(tmp_path):
    # behind the foot A1 stands at 180; a line on to the other side takes it to 225, though -135 would be in range
    made = run(tmp_path, "PTP {A1 150,A2 -100}\nLIN {X -1400,Y 0,E1 0}\nLIN {X -1300,Y 500}")
    assert [(item.code, item.axis, item.line) for item in made.objections] == [("limit", "A1", 7)]
    assert 220 < made.axes[-1, 0] < 235
    back = run(tmp_path, "PTP {A1 150,A2 -100}\nLIN {X -1400,Y 0,E1 0}\nLIN {X -1300,Y -500}")
    assert not back.objections


def test_an_endless_table_turns_on(tmp_path):
    # the tool stands still in the world while the table goes round five times below it
    poses = []
    for k in range(1, 60):
        c, s = math.cos(math.radians(30 * k)), math.sin(math.radians(30 * k))
        place = f"X {97 * c + 41.764 * s:.3f},Y {97 * s - 41.764 * c:.3f},Z 619.422"
        poses.append(f"LIN {{{place},A {(360 + 30 * k) % 360 - 180:.4f},B 0.0,C 20.42,E2 {30 * k}.0}} C_DIS")
    made = run(tmp_path, "\n".join(poses))
    assert not made.objections and np.allclose(made.axes[:, :6], made.axes[0, :6], atol=1e-2)
    assert made.axes[-1, 7] == 30 * 59
    followed = run(tmp_path, "\n".join(f"LIN {{Z 600.0,E2 {30 * k}.0}} C_DIS" for k in range(1, 60)))
    assert {item.axis for item in followed.objections} == {
        "A6"
    }  # the hand follows the part round, and has no end stop to spare


# process


SPINDLE = ";spindle on\n$ANOUT[1] = 18000 / 24000.0\n$OUT[1] = TRUE\nWAIT SEC 3.0\n"


def test_hooks_become_what_they_stand_for(tmp_path):
    body = f"{SPINDLE}$OUT[2] = TRUE\nLIN {{Z 600}}\n$OUT[2]=FALSE\nWAIT SEC 1.5\n"
    body += "HALT\n$OUT[ 1 ] = FALSE ;off\nwait sec 3\nHALT ;change to tool 12\n"
    made = run(tmp_path, body)
    assert kinds(made) == [
        (1, Kind.SPINDLE_ON, 18000.0, "CLW"),
        (1, Kind.COOLANT_ON, 0.0, ""),
        (2, Kind.COOLANT_OFF, 0.0, ""),
        (2, Kind.DWELL, 1.5, ""),
        (2, Kind.STOP, 0.0, ""),
        (2, Kind.SPINDLE_OFF, 0.0, ""),
        (2, Kind.TOOL, 12.0, ""),
    ]
    assert [event.line for event in made.events] == [6, 9, 11, 12, 13, 14, 16] and not made.gaps


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("$OUT[1] = TRUE", [(Kind.OUTPUT, "$OUT[1] = TRUE")]),
        (
            "$ANOUT[1] = 18000 / 2400.0\n$OUT[1] = TRUE\nWAIT SEC 3.0",
            [(Kind.OUTPUT, "$ANOUT[1] = 18000 / 2400.0"), (Kind.OUTPUT, "$OUT[1] = TRUE"), (Kind.DWELL, "")],
        ),
        ("$OUT[1] = FALSE", [(Kind.OUTPUT, "$OUT[1] = FALSE")]),
        ("$OUT[2] = TRUE ;coolant", [(Kind.COOLANT_ON, "")]),
        ("$OUT[9] = TRUE", [(Kind.OUTPUT, "$OUT[9] = TRUE")]),
        ("PULSE($OUT[5],TRUE,0.5)", [(Kind.OUTPUT, "PULSE($OUT[5],TRUE,0.5)")]),
        ("HALT ; change to  tool 3", [(Kind.TOOL, "")]),
        ("HALT ;change to tool", [(Kind.STOP, "")]),
    ],
)
def test_outputs_that_no_hook_accounts_for(tmp_path, text, expected):
    made = run(tmp_path, text)
    assert [(event.kind, event.text) for event in made.events] == expected


def test_order_within_a_hook_counts(tmp_path):
    made = run(tmp_path, "WAIT SEC 3.0\n$OUT[1] = TRUE\n$ANOUT[1] = 18000 / 24000.0")
    assert Kind.SPINDLE_ON not in [event.kind for event in made.events]


def test_a_motion_parts_a_hook(tmp_path):
    made = run(tmp_path, SPINDLE.replace("WAIT", "LIN {Z 600}\nWAIT"))
    assert [event.kind for event in made.events] == [Kind.OUTPUT, Kind.OUTPUT, Kind.DWELL]
    assert [event.before for event in made.events] == [1, 1, 2]


def test_the_footer_switches_off(tmp_path):
    footer = "$OUT[1] = FALSE ;spindle off, whatever the CL file says\n$OUT[2] = FALSE ;coolant off"
    made = run(tmp_path, footer)
    assert [event.kind for event in made.events] == [Kind.SPINDLE_OFF, Kind.COOLANT_OFF]
    first = run(tmp_path, footer.splitlines()[1])
    assert [event.kind for event in first.events] == [Kind.COOLANT_OFF]


def test_both_senses_and_other_coolants(tmp_path):
    hooks = (
        'coolant_on = ["$OUT[2] = TRUE"]',
        'coolant_on = ["$OUT[2] = TRUE"]\ncoolant_on_mist = ["$OUT[3] = TRUE"]\nspindle_on_ccw = ["REVERSE({speed})"]',
    )
    made = run(tmp_path, "reverse( 500.0 )\n$OUT[3] = TRUE", machine=machine_of(tmp_path, hooks))
    assert kinds(made) == [(1, Kind.SPINDLE_ON, 500.0, "CCLW"), (1, Kind.COOLANT_ON, 0.0, "MIST")] and not made.gaps
    assert run(tmp_path, "reverse( 500.0 )").gaps  # without the hook it is a call of what is not at hand


def test_hooks_that_differ_in_a_comment_alone(tmp_path):
    alike = (
        'stop = ["HALT"]',
        'stop = ["HALT"]\nclamp = ["M_CLAMP ON"]\nwork = ["CLAMP = TRUE", "$CYCFLAG[3] = TRUE"]',
    )
    machine = machine_of(
        tmp_path, alike, ('tool_change = ["HALT ;change to tool {number}"]', 'tool_change = [";tool {number}", "HALT"]')
    )
    made = run(tmp_path, ";tool 4\nHALT\nHALT\n;tool 5\n\nHALT", machine=machine)
    assert kinds(made) == [(1, Kind.TOOL, 4.0, ""), (1, Kind.STOP, 0.0, ""), (1, Kind.TOOL, 5.0, "")] and not made.gaps
    away = run(tmp_path, ";tool 4\nLIN {Z 600}\nHALT", machine=machine)
    assert kinds(away) == [(2, Kind.STOP, 0.0, "")]
    own = run(tmp_path, "M_CLAMP ON\nCLAMP = TRUE\n$CYCFLAG[3] = TRUE", machine=machine)
    assert kinds(own) == [(1, Kind.OUTPUT, 0.0, "hook clamp"), (1, Kind.OUTPUT, 0.0, "hook work")] and not own.gaps
    half = run(tmp_path, "CLAMP = TRUE", machine=machine)
    assert len(half.gaps) == 1 and not half.events
    same = machine_of(tmp_path, ('tool_change = ["HALT ;change to tool {number}"]', 'tool_change = ["HALT"]'))
    assert "can't be told" in run(tmp_path, "HALT", machine=same).gaps[0].text


def test_signals_name_outputs(tmp_path):
    made = run(
        tmp_path,
        "COOL = TRUE\nPUMP = FALSE\nOTHER = TRUE",
        head="SIGNAL COOL $OUT[2]\nSIGNAL PUMP $OUT[7]\n" + FRAMES + HOME,
    )
    assert [(event.kind, event.text) for event in made.events] == [(Kind.COOLANT_ON, ""), (Kind.OUTPUT, "PUMP = FALSE")]
    assert len(made.gaps) == 1 and "OTHER" in made.gaps[0].text


def test_triggers(tmp_path):
    body = "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[2]=TRUE\nLIN {Z 600} C_DIS\n"
    body += "TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[2]=FALSE PRIO=-1\nLIN {Z 590}\nLIN {Z 580}"
    made = run(tmp_path, body)
    assert [(event.before, event.kind) for event in made.events] == [
        (1, Kind.COOLANT_ON),
        (3, Kind.COOLANT_OFF),
    ] and not made.gaps
    assert not made.exact[1]  # a trigger doesn't stop the robot
    for other in (
        "TRIGGER WHEN DISTANCE=0 DELAY=50 DO $OUT[2]=TRUE",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO SUB()",
        "TRIGGER WHEN PATH=3 DELAY=0 DO $OUT[1]=TRUE",
    ):
        assert run(tmp_path, f"{other}\nLIN {{Z 600}}").gaps


def test_triggers_before_rows(tmp_path):
    rows = "\n".join(f"LIN {{X 97.0,Y -41.0,Z {619 - k}.0,A 180.0,B 0.0,C 20.42}} C_DIS" for k in range(12))
    made = run(tmp_path, f"TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[2]=TRUE\n{rows}")
    assert [(event.before, event.kind) for event in made.events] == [(2, Kind.COOLANT_ON)] and len(made) == 13


def test_interrupts(tmp_path):
    usual = "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3"
    assert not run(tmp_path, usual).gaps
    other = "INTERRUPT DECL 5 WHEN $IN[1]==TRUE DO STOPALL()\n"
    assert not run(tmp_path, other).gaps and len(run(tmp_path, other + "INTERRUPT ON 5").gaps) == 1


def test_exact_stops(tmp_path):
    body = "LIN {Z 600} C_DIS\nLIN {Z 595} C_DIS\n$OUT[9] = TRUE\n"
    body += "LIN {Z 590} C_DIS\nWAIT SEC 0.1\nLIN {Z 585} C_VEL\nLIN {Z 580} C_DIS"
    assert run(tmp_path, body).exact.tolist() == [True, False, True, True, False, True]
    stopping = run(tmp_path, f"$ADVANCE = 0\n{body}")
    assert stopping.exact.all() and [o.code for o in stopping.objections] == ["no-advance"]
    for stop in ("HALT", "WAIT FOR TRUE", "PULSE($OUT[9],TRUE,0.1)", "$ANOUT[1] = 0.5", "BAS(#INITMOV,0)"):
        assert run(tmp_path, f"LIN {{Z 600}} C_DIS\n{stop}\nLIN {{Z 590}}").exact[1], stop
    for passing in ("$ADVANCE = 3", "$VEL.CP = 0.1", "BAS(#VEL_PTP,20)", f"$BASE = {EK}"):
        assert not run(tmp_path, f"LIN {{Z 600}} C_DIS\n{passing}\nLIN {{Z 590}}").exact[1], passing
    early = run(tmp_path, "LIN {Z 600} C_DIS\nCONTINUE\n$OUT[9] = TRUE\nLIN {Z 590}")
    assert not early.exact[1] and len(early.gaps) == 1


# flow


def test_local_and_other_routines(tmp_path):
    sub = "DEF part1 ( )\n$VEL.CP=0.02\nLIN {Z 600}\nLIN {Z 590} C_DIS\nEND\n"
    local = "DEF lower (depth:IN)\nLIN {Z depth}\nRETURN\nLIN {Z 0}\nEND\n"
    made = run(tmp_path, "part1 ( )\nlower(580.5)\nLIN {Z 570}\nmissing ( )", files={"PART1.SRC": sub}, tail=local)
    assert np.round(tip_mm(made, slice(1, None))[:, 2], 6).tolist() == [600, 590, 580.5, 570]
    assert [Path(name).name for name in made.files] == ["job.src", "PART1.SRC"] and made.file.tolist() == [
        0,
        1,
        1,
        0,
        0,
    ]
    assert made.path.line.tolist() == [4, 3, 4, 11, 7] and made.speed[1:].tolist() == [0.02] * 4
    assert [(gap.first_line, gap.before) for gap in made.gaps] == [(8, 5)]


def test_values_handed_back(tmp_path):
    tail = "DEF more (n:OUT)\nn = n + 10\nEND\nDEF not_more (n:IN)\nn = n + 10\nEND\n"
    made = run(tmp_path, "DECL REAL z\nz = 580\nmore(z)\nnot_more(z)\nLIN {Z z}", tail=tail)
    assert tip_mm(made)[2] == pytest.approx(590) and not made.gaps


def test_loops_and_conditions(tmp_path):
    body = """DECL INT i
FOR i = 1 TO 3
  LIN {Z 600 - 5 * i}
ENDFOR
FOR i = 3 TO 1 STEP -1
  IF i == 2 THEN
    LIN {Y -40}
  ELSE
    LIN {X 100 + i}
  ENDIF
ENDFOR
i = 0
WHILE i < 2
  i = i + 1
  LIN {Z 580 + i}
ENDWHILE
REPEAT
  i = i - 1
  LIN {Z 570 + i}
UNTIL i <= 0
LOOP
  i = i + 1
  IF i > 2 THEN
    EXIT
  ENDIF
ENDLOOP
SWITCH i
CASE 1, 2
  LIN {Z 0}
CASE 3
  LIN {Z 555}
DEFAULT
  LIN {Z 0}
ENDSWITCH"""
    made = run(tmp_path, body)
    tips = np.round(tip_mm(made, slice(1, None)), 6)
    assert tips[:3, 2].tolist() == [595, 590, 585] and tips[3:6, 0].tolist() == [103, 103, 101]
    assert tips[6:, 2].tolist() == [581, 582, 571, 570, 555] and not made.gaps and not made.objections


def test_ways_out(tmp_path):
    body = """FOR i = 1 TO 9
  IF i == 3 THEN
    EXIT
  ENDIF
  FOR k = 1 TO 2
    EXIT
    LIN {Z 0}
  ENDFOR
  LIN {Z 600 - i}
ENDFOR
early(2)
LIN {Z 590}
RETURN
LIN {Z 0}"""
    tail = "GLOBAL DEF early (n:IN)\nLOOP\nIF n == 2 THEN\nRETURN\nENDIF\nENDLOOP\nLIN {Z 0}\nEND\n"
    made = run(tmp_path, "DECL INT i,k\n" + body, tail=tail)
    assert np.round(tip_mm(made, slice(1, None))[:, 2], 6).tolist() == [599, 598, 590] and not made.gaps


def test_conditions_that_can_not_be_known(tmp_path):
    harmless = "IF NOT $ON_PATH THEN\n  PTP $POS_ACT\n  $BWDSTART = FALSE\n  WAIT FOR TRUE\nENDIF"
    assert not run(tmp_path, harmless).gaps
    for inside in ("LIN {Z 600}", "$OUT[1] = TRUE", "$BASE = $NULLFRAME", "SUB()", "HALT"):
        made = run(tmp_path, f"IF NOT $ON_PATH THEN\n{inside}\nENDIF\nLIN {{Z 595}}")
        assert [(gap.first_line, gap.last_line) for gap in made.gaps] == [(5, 7)] and len(made) == 2 and not made.events
    assert run(tmp_path, "WHILE $IN[1]\nLIN {Z 600}\nENDWHILE").gaps
    assert not run(tmp_path, "IF FALSE THEN\nLIN {Z 0}\nENDIF\nIF TRUE THEN\nLIN {Z 600}\nENDIF").gaps


def test_what_is_not_on_the_list(tmp_path):
    statements = [
        "$CYCFLAG[3] = $IN[2]",
        "ASYPTP {E1 3}",
        "FOO BAR",
        'CWRITE($CMD,STAT,MODE,"RUN")',
        "BAS(#EX_BASE,1)",
        "LIN XP9",
    ]
    for text in statements:
        made = run(tmp_path, f"{text}\nLIN {{X 97,Y -41.764,Z 600,A 180,B 0,C 20.42}}")
        assert [gap.first_line for gap in made.gaps] == [5], text
        assert made.gaps[0].text.startswith(text[:20]) and len(made) == 2
    many = run(tmp_path, "\n".join(["FOO BAR"] * 500))
    assert [(gap.first_line, gap.last_line) for gap in many.gaps] == [(5, 504)]


def test_a_program_without_motions(tmp_path):
    made = run(tmp_path, "$OUT[2] = TRUE", head="")
    assert (
        len(made) == 0 and made.axes.shape == (0, 8) and made.path.tip.shape == (0, 3) and made.path.line.shape == (0,)
    )
    assert kinds(made) == [(0, Kind.COOLANT_ON, 0.0, "")] and not made.objections


def test_the_controllers_own_data(tmp_path):
    config = "DEFDAT $CONFIG PUBLIC\nSIGNAL COOL $OUT[2]\nFRAME TOOL_DATA[3]\nTOOL_DATA[1]={X 0,Y 0,Z 50,A 0,B 0,C 0}\n"
    config += "DECL E6AXIS XHOME={A1 5,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\nENDDAT\n"
    made = run(tmp_path, "PTP XHOME\nCOOL = TRUE\n$TOOL = TOOL_DATA[1]\nPTP {A1 0}", files={"$config.dat": config})
    assert made.axes[1, 0] == 5 and kinds(made) == [(2, Kind.COOLANT_ON, 0.0, "")] and not made.gaps
    assert np.allclose(made.tools[made.tool[2]][:3, 3], [0, 0, 0.05])


def test_endless_programs_end(tmp_path, monkeypatch):
    monkeypatch.setattr("camrob.witness.krl.state._MOST", 5000)
    made = run(tmp_path, "LOOP\nLIN {Z 600}\nENDLOOP\nHALT")
    assert "never end" in made.gaps[-1].text and not made.events
    deep = run(tmp_path, "again()", tail="DEF again ( )\nagain()\nEND\n")
    assert "too deep" in deep.gaps[-1].text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b"", "not a KRL"),
        (b"DEF job ( )\n\0\nEND\n", "not text"),
        (b"DEF job ( )\nLIN {X 1}\n", "no END"),
        (b"DEF job ( )\nIF TRUE THEN\nEND\n", "ENDIF"),
        (b"DEF job ( )\nENDFOR\nEND\n", "closes nothing"),
        (b"DEF job ( )\nDEF other ( )\nEND\n", "before JOB"),
        (b"DEF job ( )\n" + b"LOOP\n" * 60 + b"END\n", "too deep"),
        (b"GOTO/1,2,3\nFINI\n", "not a KRL"),
    ],
)
def test_text_that_is_no_program(tmp_path, text, says):
    path = tmp_path / "job.src"
    path.write_bytes(text)
    with pytest.raises(KrlError, match=says) as caught:
        run_program(path, MACHINE)
    assert str(path) in str(caught.value)
    with pytest.raises(KrlError, match="can't be read"):
        run_program(tmp_path / "none.src", MACHINE)


@pytest.mark.parametrize(
    "text",
    [
        "LIN {X 1e999,Y 0,Z 0,A 0,B 0,C 0}",
        "LIN {X " + "(" * 500 + "1",
        "LIN {X 1,X 2,Z 600}",
        'LIN {Z "a"}',
        "LIN {Z TRUE}",
        "LIN {Z 1/0}",
        "LIN {Z $POS_INT.Z}",
        "LIN {",
        "LIN }{",
        "CIRC {X 1}",
        "PTP {E1 3}",
        "LIN {A1 3}",
        "\u00e4\u00f6\u00fc = 3",
        "$BASE.Q = 3",
        "WAIT SEC x",
        "LIN {Z 'B12'}",
    ],
)
def test_hostile_statements_are_gaps(tmp_path, text):
    made = run(tmp_path, text)
    assert [gap.first_line for gap in made.gaps] == [5] and len(made) == 1


def test_text_of_other_systems(tmp_path):
    path = tmp_path / "job.src"
    text = f"&ACCESS RVP\r\n&REL 1\r\ndef JOB()\r\n{FRAMES}{HOME}"
    text += "  lin {z 600,E1 -0.000}c_dis ; M\u00e4nner\rLIN {Z 590} ;LIN {Z 0}\r\nend"
    path.write_bytes(text.encode("latin-1"))
    made = run_program(path, MACHINE)
    assert np.round(tip_mm(made, slice(1, None))[:, 2], 6).tolist() == [600, 590] and not made.gaps
    assert made.exact.tolist() == [True, False, True]


def test_a_header_line_belongs_into_the_opening(tmp_path):
    path = tmp_path / "job.src"
    path.write_text(f"&ACCESS RVP\n; a word\n\n&REL 1\nDEF JOB()\n{FRAMES}{HOME}END\n")
    assert not run_program(path, MACHINE).gaps
    path.write_text(f"DEF JOB()\n&ACCESS RVP\n{FRAMES}{HOME}END\n")
    with pytest.raises(KrlError, match=r"header line \(&ACCESS RVP\) behind its first statement") as refused:
        run_program(path, MACHINE)
    assert refused.value.line == 2


# rows read as columns


def lines_of(count, seed=0):
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.uniform(-0.5, 0.5, (count, 8)), axis=0) + np.array([97, -41, 600, 180, 0, 20, 0, 0])
    return [
        "LIN {{E6POS: X {:.3f},Y {:.3f},Z {:.3f},A {:.4f},B {:.4f},C {:.4f},E1 {:.4f},E2 {:.4f}}} C_DIS".format(*row)
        for row in values
    ]


def test_rows_and_single_statements_agree(tmp_path):
    lines = [
        text
        for k, line in enumerate(lines_of(300))
        for text in ([line] if k % 7 else [f"$VEL.CP = {0.01 + k / 1e4:.6f}", line])
    ]
    rows = run(tmp_path, "\n".join(lines))
    source = read_source(tmp_path / "job.src")
    assert len(source.row_line) == 300 and len(source.speed_line) == 43
    single = run(tmp_path, "\n".join(f"{line} ;{k}." for k, line in enumerate(lines)))
    source = read_source(tmp_path / "job.src")
    assert len(source.row_line) == 0 and len(source.speed_line) == 0
    for name in ("tip", "axis", "line"):
        assert np.array_equal(getattr(rows.path, name), getattr(single.path, name))
    assert np.array_equal(rows.axes, single.axes) and np.array_equal(rows.exact, single.exact)
    assert np.array_equal(rows.speed, single.speed, equal_nan=True) and not rows.gaps and not rows.objections
    assert np.isfinite(rows.speed[1:]).all() and len(np.unique(rows.speed[1:])) == 43


@pytest.mark.parametrize(
    "change",
    [
        ("Z ", "Z -"),
        ("Z ", "Z --"),
        ("Z ", "Z 1."),
        ("Z ", "Z 1-"),
        ("Z ", "Z - "),
        (",Z", ",Z1"),
        ("E6POS", "E66POS"),
        ("E6POS", "E6P-OS"),
        ("E1 ", "E2 "),
        ("E1 ", "E11 "),
        ("C_DIS", "C_DIS-"),
        ("C_DIS", "C_DIS 5"),
        ("LIN ", "LIN5 "),
        ("LIN ", "5LIN "),
        (": X ", ": -X "),
        ("Y ", "Y 5 "),
        ("X ", "X 000"),
    ],
)
def test_a_line_that_only_looks_like_its_neighbours(tmp_path, change):
    lines = lines_of(40)
    lines[20] = lines[20].replace(*change, 1)
    rows = run(tmp_path, "\n".join(lines))
    single = run(tmp_path, "\n".join(f"{line} ;." for line in lines))
    assert np.array_equal(rows.path.tip, single.path.tip) and np.array_equal(rows.path.line, single.path.line)
    assert len(rows.gaps) == len(single.gaps) and len(rows.gaps) + len(rows) >= 41


def test_rows_within_routines_and_loops(tmp_path):
    body = "FOR i = 1 TO 3\n" + "\n".join(lines_of(20)) + "\nENDFOR\nother()"
    made = run(tmp_path, "DECL INT i\n" + body, tail="DEF other ( )\n" + "\n".join(lines_of(15, 1)) + "\nEND\n")
    assert len(made) == 1 + 60 + 15 and np.array_equal(made.path.tip[1:21], made.path.tip[41:61]) and not made.gaps


def test_rows_in_a_base_that_is_wrong_or_not_known(tmp_path):
    rows = "\n".join(lines_of(20))
    still = run(tmp_path, f"$BASE = $NULLFRAME\n{rows}")
    assert codes(still) == ["base-stands-still"]
    unknown = run(tmp_path, f"$BASE = BASE_DATA[3]\n{rows}")
    assert (
        [gap.first_line for gap in unknown.gaps] == [5, 6]
        and np.isnan(unknown.path.tip[1:]).all()
        and not unknown.objections
    )
    slow = run(tmp_path, "$VEL.CP = 0.000000\n" + rows + "\n$VEL.CP = 0.000000\n" * 10)
    assert codes(slow) == ["speed"] and slow.objections[0].line == 5
    turned = run(tmp_path, f"$ORI_TYPE = #CONSTANT\n{rows}\n$ORI_TYPE = #JOINT\n{rows}")
    assert np.allclose(turned.path.axis[1:21], turned.path.axis[0]) and len(turned.gaps) == 1


def test_rows_keep_external_axes_that_they_leave_out(tmp_path):
    short = [re.sub(r",E1.*}", "}", line) for line in lines_of(20)]
    made = run(tmp_path, "PTP {A1 0,E1 7,E2 3}\n" + "\n".join(short))
    assert (made.axes[1:, 6:] == [7, 3]).all()


# whole programs


@pytest.mark.parametrize("name", ["carving", "engraving", "globe", "relief"])
def test_golden_programs(tmp_path, name):
    golden = ROOT / "toolpaths" / name / "golden"
    shutil.copy(golden / f"{name}.dat", tmp_path)
    text = golden / f"{name}.src"
    (tmp_path / text.name).write_bytes(
        text.read_bytes() if text.exists() else gzip.decompress(golden.joinpath(f"{name}.src.gz").read_bytes())
    )
    made = run_program(tmp_path / text.name, MACHINE)
    assert not made.objections and not made.gaps
    motions = len(re.findall(r"^(?:LIN|PTP|CIRC) ", (tmp_path / text.name).read_text(), re.MULTILINE))
    assert len(made) == motions and np.isfinite(made.axes).all() and np.isfinite(made.path.tip).all()
    base_T_tool = MACHINE.base_T_flange(made.axes) @ made.tools[made.tool[0]]
    assert np.allclose(base_T_tool[:, :3, 3], made.path.tip, atol=1e-8)
    assert {event.kind for event in made.events} == {Kind.SPINDLE_ON, Kind.SPINDLE_OFF, Kind.COOLANT_OFF}
    spindle = [event.value for event in made.events if event.kind is Kind.SPINDLE_ON]
    assert spindle == {"carving": [9000, 9000], "engraving": [18000, 12000], "globe": [9000], "relief": [12000]}[name]


@pytest.mark.skipif(not CORPUS.is_dir(), reason="../shared is not here")
@pytest.mark.parametrize("cell", ["kr15_track_table", "kr500_afp"])
def test_programs_of_other_posts(cell):
    machine = read_machine(ROOT / "cells" / cell)
    for path in sorted(CORPUS.glob("*.src")):
        made = run_program(path, machine)
        text = path.read_text(encoding="latin-1")
        motions = len(re.findall(r"^ *(?:LIN|PTP|CIRC) (?!\$)", text, re.MULTILINE))
        assert len(made) == motions, path.name
        expected = 1 if "CR_PROCESS_FILE" in text else 0
        assert len(made.gaps) == expected, path.name
        assert [event.kind for event in made.events] == [Kind.OUTPUT, Kind.DWELL, Kind.OUTPUT]


@pytest.mark.parametrize(
    ("text", "code", "severity"),
    [
        ("$APO.CDIS = 5.0", "setting-higher", "error"),
        ("$ACC.CP = 4.0", "setting-higher", "error"),
        ("$ACC.CP = 1.0", "setting-lower", "warning"),
        ("$VEL.ORI2 = 0.5", "setting-lower", "error"),
        ("$OV_PRO = 10", "override", "error"),
    ],
)
def test_settings_other_than_the_cells(tmp_path, text, code, severity):
    made = run(tmp_path, f"{text}\nLIN {{Z 600}}")
    assert [(o.code, o.severity) for o in made.objections] == [(code, severity)]


def test_speeds_after_initmov_are_the_controllers(tmp_path):
    made = run(tmp_path, "$VEL.CP = 0.1\nLIN {Z 610}\nBAS (#INITMOV,0 )\nLIN {Z 600}")
    assert np.isfinite(made.speed[1]) and np.isnan(made.speed[2])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("WAIT FOR $IN[3]", "stands still until"),
        ("LOOP\nLIN {Z 600}\nENDLOOP", "without EXIT"),
        ("FOR I=1 TO 1000000\nWAIT SEC 0\nENDFOR", "between two motions"),
        ("FOR I=1 TO 1000000\n$TIMER[1]=0\nENDFOR", "turns of loops"),
    ],
)
def test_waits_and_loops_without_an_end_are_not_judged(tmp_path, text, said):
    made = run(tmp_path, f"INT I\n{text}\nLIN {{Z 600}}")
    assert any(said in gap.text for gap in made.gaps)


@pytest.mark.parametrize(
    ("text", "known"), [("8000 / 24000.0", True), ("8000.0/24000.00", True), ("8000 / 24000", False)]
)
def test_a_quotient_of_whole_numbers_is_another_speed(tmp_path, text, known):
    """INT / INT is cut down to an INT in KRL: 8000 / 24000 is 0, and the spindle stands."""
    made = run(tmp_path, f"$ANOUT[1] = {text}\n$OUT[1] = TRUE\nWAIT SEC 3.0\nLIN {{Z 600}}")
    assert (Kind.SPINDLE_ON in [event.kind for event in made.events]) == known


@pytest.mark.parametrize(
    ("end", "reads"), [(b"\r\n", True), (b"\n", True), (b"\r", True), (b"\r\r\n", True), (b"\n\r", False)]
)
def test_line_ends(tmp_path, end, reads):
    """One kind throughout, or a carriage return too many from a transfer as text; not the wrong way round."""
    (tmp_path / "job.src").write_bytes(b"DEF job()\r\nLIN {X 1}" + end + b"LIN {X 2}\r\nEND\r\n")
    if reads:
        assert [line.code for line in read_source(tmp_path / "job.src").lines][-1] == "END"
    else:
        with pytest.raises(KrlError, match="line ends"):
            read_source(tmp_path / "job.src")


@pytest.mark.parametrize("behind", ["$OUT[1] = TRUE", "WAIT SEC 1", "LIN {X 1,Y 2,Z 3}"])
def test_a_statement_behind_the_programs_end_stands_against_it(tmp_path, behind):
    assert codes(run(tmp_path, HOME, tail=behind + "\n")) == ["outside-def"]
    assert codes(run(tmp_path, HOME, tail=";FOLD\n\n;ENDFOLD\nDEF other ( )\n" + behind + "\nEND\n")) == []
