"""The witness on what programs of other makers hold: functions, WITH, triggers, tables of the controller, lists that don't load.

What each statement does is worked out by hand from KUKA's manuals; where the text doesn't say it, the witness has to name it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.languages.krl.reader.read_krl import read_krl
from camrob.witness.happenings import Kind
from camrob.witness.krl.run import run_program
from camrob.witness.machine import read_machine

ROOT = Path(__file__).parents[2]
CELL = (ROOT / "cells" / "kr15_track_table" / "cell.toml").read_text()
MACHINE = read_machine(ROOT / "cells" / "kr15_track_table")
EK = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})"
HEAD = (
    "BAS (#INITMOV,0 )\nBAS (#VEL_PTP,10)\n$ACC.CP = 2.0\n$VEL.ORI1 = 200.0\n$VEL.ORI2 = 200.0\n$ACC.ORI1 = 400.0\n"
    f"$ACC.ORI2 = 400.0\n$APO.CDIS = 0.5\n$ACT_EX_AX = 2\n$BASE = {EK}\n$TOOL = {{X 0,Y -41.763657,Z 415.577926,A 0,B 0,C "
    "-159.579784}\nPTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\n$VEL.CP = 0.05\n"
)
SPLINES = 'ptp_velocity_percent = 10\ngeneration = "KRC4"\nmotions = "SLIN"'


def machine(tmp_path, *changes):
    """The KR15 cell with some of its text changed."""
    text = CELL
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "cell.toml").write_text(text)
    return read_machine(tmp_path / "cell.toml")


def run(tmp_path, body, *, tail="", data=None, cell=MACHINE):
    """A program of this body behind an opening that leaves nothing open, with routines behind it and a data list."""
    (tmp_path / "job.src").write_text(f"DEF job ( )\n{HEAD}{body}\nEND\n{tail}", encoding="utf-8")
    if data is not None:
        (tmp_path / "job.dat").write_text(f"DEFDAT job\n{data}\nENDDAT\n")
    return run_program(tmp_path / "job.src", cell)


def left_open(made):
    return [gap.text for gap in (*made.gaps, *made.unsettled)]


def ends(made):
    return (made.path.tip * 1000).round(6).tolist()


# functions of the program's own


def test_a_function_is_run_with_what_it_is_handed(tmp_path):
    body = "DECL REAL z\nz = 600\nLIN {X 97,Y -41.764,Z 600}\nLIN {Z LESS(z,STEPS(2))}\nLIN {X 90}"
    tail = "DEFFCT REAL LESS(a:IN,b:IN)\nREAL a,b\nRETURN a-b\nENDFCT\nDEFFCT INT STEPS(n:IN)\nINT n,i,s\ns = 0\n"
    tail += "FOR i=1 TO n\ns = s+i\nENDFOR\nRETURN s+0.4\nENDFCT\n"  # 1 + 2, and an INT takes 3.4 rounded
    made = run(tmp_path, body, tail=tail)
    assert left_open(made) == [] and ends(made)[2] == [97, -41.764, 597] and ends(made)[3] == [90, -41.764, 597]


def test_a_function_that_does_more_than_return_is_named(tmp_path):
    for does in ("count = count+1", "LIN {Z 590}", "$VEL.CP = 1.0", "$OUT[3] = TRUE", "n = 5"):
        tail = f"DEFFCT REAL HIGH(n)\nREAL n\n{does}\nRETURN 580\nENDFCT\n"
        made = run(tmp_path, "REAL m\nm = 1\nLIN {Z HIGH(m)}", tail=tail, data="INT count=0")
        assert any("HIGH" in text for text in left_open(made)), does
    made = run(tmp_path, "LIN {Z HIGH(1)}", tail="DEFFCT REAL HIGH(n:IN)\nREAL n\nENDFCT\n")
    assert any("returns isn't known" in text for text in left_open(made))
    made = run(tmp_path, "LIN {Z OTHERS(1)}")
    assert any("OTHERS() is not at hand" in text for text in left_open(made))


def test_a_function_of_krl_is_the_controllers(tmp_path):
    made = run(tmp_path, "LIN {Z 600}", tail="DEFFCT REAL SIN(a:IN)\nREAL a\nRETURN 1\nENDFCT\n")
    assert [o.code for o in made.objections] == ["library-replaced"]


# WITH


FORM = (
    "DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\nDECL LDAT L1={VEL 1.0,ACC 100,APO_DIST 0.5,ORI_TYP #VAR}\n"
    "DECL E6POS XP1={X 97,Y -41.764,Z 600,A 180,B 0,C 20.42,S 2,T 2,E1 0,E2 0}"
)
ROWS = (
    "DECL FRAME TOOL_DATA[16]\nTOOL_DATA[1]={X 0,Y -41.763657,Z 315.577926,A 0,B 0,C -159.579784}\nDECL FRAME BASE_DATA[32]\n"
    "BASE_DATA[2]={X 0,Y 0,Z 10,A 0,B 0,C 0}\nDECL FRAMEDAT MACHINE_FRAME_DAT[32]\nMACHINE_FRAME_DAT[2].MACH_DEF_INDEX=2"
)


def test_an_inline_form_of_kss_8_holds_for_its_motion_alone(tmp_path):
    cell = machine(tmp_path, ("ptp_velocity_percent = 10", SPLINES))
    form = "SLIN XP1 WITH $VEL=SVEL_CP(0.2, , L1), $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO), $IPO_MODE=SIPO_MODE("
    form += "FP1.IPO_FRAME), $LOAD=SLOAD(FP1.TOOL_NO), $ACC=SACC_CP(L1), $ORI_TYPE=SORI_TYP(L1), $APO=SAPO(L1), $JERK=SJERK(L1)"
    made = run(tmp_path, f"{form}\nLIN {{X 97,Y -41.764,Z 600}}", data=f"{FORM}\n{ROWS}", cell=cell)
    assert ends(made)[1] == [97, -41.764, 610] and ends(made)[2] == [97, -41.764, 600]  # 10 mm up, by its own base
    assert made.speed[1:].tolist() == [0.2, 0.05] and made.tool[1] != made.tool[2] == made.tool[0]
    assert {text.split(" isn't")[0] for text in left_open(made)} == {
        "$ACC.CP",
        "$VEL.ORI1",
        "$VEL.ORI2",
    }  # the controller's own


@pytest.mark.parametrize("said", ["$OUT[1]=TRUE", "$VEL=SVEL_CP(unknown, , L1)", "$VEL=OWN(1)", "$ACC=SVEL_CP(1)", ""])
def test_what_with_sets_otherwise_is_named(tmp_path, said):
    cell = machine(tmp_path, ("ptp_velocity_percent = 10", SPLINES))
    made = run(tmp_path, f"SLIN {{Z 600}} WITH $VEL.CP=0.1, {said}", data=FORM, cell=cell)
    assert any(text.startswith("SLIN {Z 600} WITH") for text in left_open(made))


# triggers


def test_triggers_at_points_are_done_there_and_others_named(tmp_path):
    for what, before in (
        ("DISTANCE=0 DELAY=0", 1),
        ("DISTANCE=1 DELAY=0", 2),
        ("PATH=0 DELAY=0.0", 2),
        ("PATH=Z DELAY=Z", 2),
    ):
        made = run(tmp_path, f"INT Z\nZ = 0\nTRIGGER WHEN {what} DO $OUT[2]=TRUE PRIO=-1\nLIN {{Z 600}}\nLIN {{Z 590}}")
        assert [(e.before, e.kind) for e in made.events] == [(before, Kind.COOLANT_ON)] and left_open(made) == []
    for what in (
        "DISTANCE=1 DELAY=20",
        "PATH=-5 DELAY=0",
        "PATH=0 DELAY=-20",
        "PATH=away DELAY=0",
        "PATH=0 ONSTART DELAY=0",
    ):
        made = run(tmp_path, f"TRIGGER WHEN {what} DO $OUT[2]=TRUE\nLIN {{Z 600}}")
        assert len(left_open(made)) == 1 and "TRIGGER" in left_open(made)[0] and not made.events


# the controller's tables


def test_a_base_by_its_row_turns_where_machine_frame_dat_says_so(tmp_path):
    row = "DECL FRAME BASE_DATA[32]\nBASE_DATA[2]={X 0,Y 0,Z 10,A 0,B 0,C 0}\n"
    for index, codes in (("=2", []), ("=1", ["base-other-mechanism"]), ("=0", ["base-stands-still"])):
        made = run(tmp_path, "BAS (#BASE,2)\nLIN {Z 600}", data=f"{row}MACHINE_FRAME_DAT[2].MACH_DEF_INDEX{index}")
        assert [o.code for o in made.objections if o.severity == "error"] == codes and left_open(made) == []
    made = run(tmp_path, "BAS (#BASE,2)\nLIN {Z 600}", data=row)
    assert not made.objections and len(left_open(made)) == 1 and "MACHINE_FRAME_DAT[2]" in left_open(made)[0]
    made = run(tmp_path, f"BAS (#BASE,2)\n$BASE = {EK}\nLIN {{Z 600}}", data=row)  # nothing moves in it
    assert not made.objections and left_open(made) == []
    made = run(tmp_path, "$BASE = BASE_DATA[2]\nLIN {Z 600}", data=row)  # not by BAS: it stands still
    assert [o.code for o in made.objections] == ["base-stands-still"]


def test_a_halt_is_a_change_of_tools_by_its_comment(tmp_path):
    hooks = ('tool_change = ["HALT ;change to tool {number}"]', 'tool_change = ["HALT ;mount the next tool"]')
    cell = machine(tmp_path, hooks, ('stop = ["HALT"]\n', ""))
    for comment, kind in ((";mount the next tool", Kind.TOOL), (";part off", Kind.STOP), ("", Kind.STOP)):
        made = run(tmp_path, f"LIN {{Z 600}}\nHALT {comment}\nLIN {{Z 590}}", cell=cell)
        assert [e.kind for e in made.events] == [kind]


# what is left out


def test_what_an_arcs_end_leaves_out_is_as_before_the_arc(tmp_path):
    made = run(
        tmp_path, "LIN {X 107,Y -41.764,Z 600,A 180,B 0,C 20.42,E1 0,E2 0}\nCIRC {X 112,Y -36.764,E1 5},{Y -31.764}"
    )
    assert ends(made)[-1] == [107, -31.764, 600] and made.axes[-1, 6] == 0
    text = read_krl(tmp_path / "job.src", {})
    assert text.pose[-1, :3].tolist() == [107, -31.764, 600] and text.external[-1, 0] == 0


def test_a_point_of_which_a_part_is_not_known_stays_unknown(tmp_path):
    body = "DECL E6POS p\np = {X 97,Y -41.764,Z away,A 180,B 0,C 20.42,E1 0,E2 0}\np.Z = 590\nLIN p"
    assert any("where it leads isn't known" in text for text in left_open(run(tmp_path, body)))


# what no controller loads


def test_lists_and_lines_that_no_controller_loads(tmp_path):
    for text in ("DEFDAT other\nENDDAT\n", "DEFDAT job\n", "DECL INT a=1\n"):
        (tmp_path / "job.dat").write_text(text)
        assert [o.code for o in run(tmp_path, "LIN {Z 600}").objections] == ["module-name"]
    made = run(tmp_path, "LIN {Z 600}", data="$VEL.CP = 1.0")
    assert any("a data list declares" in text for text in left_open(made))
    made = run(tmp_path, "LIN {Z 600} ;" + "x" * 300, data="")
    assert [(o.code, o.line) for o in made.objections] == [("line-too-long", HEAD.count("\n") + 2)]


def test_a_blank_that_only_python_knows_is_none(tmp_path):
    made = run(tmp_path, "LIN\u00a0{Z 600}\nLIN {Z 590} ;F\u00fcller\nL\u0131N {Z 580}", data="")
    assert [(gap.first_line, gap.last_line) for gap in made.gaps] == [(first := HEAD.count("\n") + 2, first + 2)]
    assert np.allclose(ends(made)[-1][2], 590)
