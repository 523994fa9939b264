"""The witness on how a program moves besides its frames and its feed, and on what outlives or interrupts a run."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from camrob.witness.happenings import Kind, Run
from camrob.witness.judge import judge
from camrob.witness.krl.run import run_program
from camrob.witness.machine import Machine, read_machine

CELL = Path(__file__).parents[2] / "cells" / "kr15_track_table"
MACHINE = read_machine(CELL)
SPLINES = replace(MACHINE, controller=replace(MACHINE.controller, own={**MACHINE.controller.own, "motions": "SLIN"}))
EK = "$BASE = EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})"
TOOL = "$TOOL = {X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}"
STATED = [
    "$ACC.CP = 2.0",
    "$VEL.ORI1 = 200",
    "$VEL.ORI2 = 200",
    "$ACC.ORI1 = 400",
    "$ACC.ORI2 = 400",
    "$APO.CDIS = 0.5",
    "$ACT_EX_AX = 2",
]
HEAD = ["BAS (#INITMOV,0 )", "BAS (#VEL_PTP,10 )", *STATED, EK, TOOL, "$VEL.CP = 0.05"]
HOME = "PTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}"
WAY = ["LIN {Z 600} C_DIS", "LIN {Z 590}"]


def run(
    folder: Path, *lines: str, head: list[str] = HEAD, data: str = "", tail: str = "", machine: Machine = MACHINE
) -> Run:
    """A program of these lines behind a head and a way to HOME; data: of its data list; tail: behind its END."""
    (folder / "job.src").write_text("\n".join(["DEF job ( )", *head, HOME, *lines, "END", tail, ""]))
    (folder / "job.dat").write_text(f"DEFDAT job\n{data}\nENDDAT\n")
    return run_program(folder / "job.src", machine)


def said(made: Run) -> list[str]:
    """What stands against it and what isn't judged."""
    return [o.code for o in (*made.objections, *made.conduct)] + [gap.text for gap in (*made.gaps, *made.unsettled)]


def only(made: Run, text: str) -> bool:
    """Whether just this is said."""
    found = said(made)
    return bool(found) and all(text in one for one in found)


def test_a_program_that_sets_what_the_cell_states_passes(tmp_path: Path) -> None:
    assert said(run(tmp_path, *WAY)) == []


# --- what the cell states holds in every motion


@pytest.mark.parametrize("line", ["BAS (#INITMOV,0 )", *STATED])
def test_a_setting_that_is_left_out_is_not_judged(tmp_path: Path, line: str) -> None:
    made = run(tmp_path, *WAY, head=[text for text in HEAD if text != line])
    assert only(made, line.split(" = ")[0].replace(" (", "(").split(",")[0])


def test_a_rounding_distance_matters_where_a_corner_is_rounded(tmp_path: Path) -> None:
    assert said(run(tmp_path, "LIN {Z 600}", head=[text for text in HEAD if "CDIS" not in text])) == []


def test_ptp_is_no_faster_than_the_cell_says(tmp_path: Path) -> None:
    others = [text for text in HEAD if "VEL_PTP" not in text]
    assert said(run(tmp_path, *WAY, head=others)) == ["setting-higher"]  # INITMOV leaves 100 percent
    assert said(run(tmp_path, "BAS (#VEL_PTP,5 )", "PTP {A1 1}", "BAS (#VEL_PTP,50 )", *WAY)) == []
    assert said(run(tmp_path, "BAS (#VEL_PTP,50 )", "PTP {A1 1}")) == ["setting-higher"]
    assert said(run(tmp_path, "BAS (#PTP_PARAMS,100)", "PTP {A1 1}"))[0] == "setting-higher"


@pytest.mark.parametrize("after", range(1, 5))
def test_the_initialisation_undoes_what_was_set_before_it(tmp_path: Path, after: int) -> None:
    head = [*HEAD[1 : 1 + 2 * after], HEAD[0], *HEAD[1 + 2 * after :]]
    assert said(run(tmp_path, *WAY, head=head))
    assert said(run(tmp_path, *WAY, head=[*head, *HEAD])) == []


def test_frames_are_set_behind_the_initialisation(tmp_path: Path) -> None:
    late = [*HEAD, "BAS (#INITMOV,0 )", "BAS (#VEL_PTP,10 )", *STATED, "$VEL.CP = 0.05"]
    assert any("$BASE" in text for text in said(run(tmp_path, *WAY, head=late)))
    assert said(run(tmp_path, *WAY, head=[*late, EK, TOOL])) == []


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("BAS (#ACC_CP,2.0 )", ""),
        ("BAS (#ACC_CP,0.0001 )", "setting-lower"),
        ("BAS (#ACC_CP,9 )", "setting-higher"),
        ("$ACC.CP = 0.0001", "setting-lower"),
        ("$ACC.CP = 1.5", ""),
        ("$ACC = {CP 2,ORI1 400,ORI2 400}", ""),
        ("$ACC = {CP 2,ORI1 4,ORI2 400}", "setting-lower"),
        ("$VEL = {CP 0.05,ORI1 900,ORI2 200}", "setting-higher"),
        ("$APO = {CDIS 30}", "setting-higher"),
        ("$RED_VEL = 20", "override"),
        ("$RED_VEL = 100", ""),
    ],
)
def test_settings_that_the_cell_states_by_other_ways(tmp_path: Path, line: str, code: str) -> None:
    made = run(tmp_path, line, *WAY)
    errors = {o.code for o in (*made.objections, *made.conduct) if o.severity == "error"}
    assert errors == ({code} if code else set()) and not made.gaps and not made.unsettled


# --- what it doesn't state is left at the controller's default


@pytest.mark.parametrize(
    "line",
    [
        "$LOAD.M = 500.0",
        "$LOAD = {M 5,CM {X 0,Y 0,Z 0,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}",
        "$VEL_AXIS[2] = 1",
        "$VEL_AXIS[1] = 100",
        "$VEL_EXTAX[1] = 1",
        "$ACC_AXIS[2] = 200",
        "BAS (#ACC_PTP,1 )",
        "$APO.CVEL = 100",
        "$APO.CORI = 90",
        "$GEAR_JERK[1] = 9",
        "BAS (#PTP_DAT,0 )",
        "BAS (#CP_DAT,0 )",
        "BAS (#LOAD,3 )",
        "$SINGUL_STRATEGY = 1",
        "$VEL_AXIS[1] = $OV_PRO",
    ],
)
def test_settings_that_the_cell_does_not_state(tmp_path: Path, line: str) -> None:
    made = run(tmp_path, line, "PTP {A1 1}", *WAY)
    assert said(made) and not made.objections


@pytest.mark.parametrize(
    "line", ["$VEL_AXIS[2] = 10", "$ACC_AXIS[1] = 100", "BAS (#ACC_PTP,100 )", "$BWDSTART = FALSE"]
)
def test_defaults_of_what_the_cell_does_not_state(tmp_path: Path, line: str) -> None:
    assert said(run(tmp_path, line, *WAY)) == []


def test_sets_of_motion_data_that_are_known(tmp_path: Path) -> None:
    known = "DECL LDAT L1={VEL 0.05,ACC 100.0,APO_DIST 0.4,APO_FAC 50.0}\nDECL PDAT P1={VEL 8.0,ACC 100.0,APO_DIST 1.0}"
    lines = ["LDAT_ACT = L1", "BAS (#CP_DAT,0 )", *WAY, "PDAT_ACT = P1", "BAS (#PTP_DAT,0 )", "PTP {A1 1}"]
    made = run(tmp_path, *lines, data=known)
    assert said(made) == [] and made.speed[1] == 0.05
    assert said(run(tmp_path, *lines, data=known.replace("0.4", "40.0"))) == ["setting-higher"]
    assert said(run(tmp_path, *lines, data=known.replace("8.0", "80.0"))) == ["setting-higher"]


# --- roundings of a size that nobody states, stops on the way


@pytest.mark.parametrize("word", ["C_VEL", "C_ORI", "C_DIS C_ORI"])
def test_roundings_of_unknown_size(tmp_path: Path, word: str) -> None:
    assert only(run(tmp_path, f"LIN {{Z 600}} {word}", "LIN {Z 590}"), "how far")
    assert said(run(tmp_path, f"LIN {{Z 600}} {word}", "WAIT SEC 0", "LIN {Z 590}")) == []  # it stops there anyway
    rows = [f"LIN {{X 97.0,Y -41.0,Z {619 - k}.0,A 180.0,B 0.0,C 20.42}} {word}" for k in range(12)]
    assert only(run(tmp_path, *rows), "how far")


def test_a_rounded_ptp_is_not_judged(tmp_path: Path) -> None:
    assert only(run(tmp_path, "PTP {A1 1} C_PTP", *WAY), "how far")
    assert said(run(tmp_path, "PTP {A1 1} C_PTP", "HALT", *WAY)) == []


@pytest.mark.parametrize("here", ["PTP $POS_ACT", "PTP $AXIS_ACT", "LIN $POS_ACT", "SPTP $AXIS_ACT_MEAS"])
def test_a_motion_to_where_the_robot_stands(tmp_path: Path, here: str) -> None:
    assert only(run(tmp_path, WAY[0], here, WAY[1]), "it stops on the way")
    assert said(run(tmp_path, here, *WAY)) == []


# --- interrupts and routines from elsewhere

DECLARED = "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )"


def test_the_templates_interrupt_passes(tmp_path: Path) -> None:
    assert said(run(tmp_path, *WAY, head=[DECLARED, "INTERRUPT ON 3", *HEAD])) == []


@pytest.mark.parametrize(
    ("head", "lines"),
    [
        ([DECLARED.replace("$STOPMESS==TRUE", "$OUT[1]==TRUE"), "INTERRUPT ON 3"], []),
        ([DECLARED.replace("IR_STOPM", "OTHER"), "INTERRUPT ON 3"], []),
        ([DECLARED], ["LIN {Z 610}", "INTERRUPT ON 3"]),
        ([DECLARED], ["INTERRUPT ON"]),
        ([], ["INTERRUPT ON 7"]),
        (["EXT MYLIB BAS (BAS_COMMAND :IN,REAL :IN )"], []),
    ],
)
def test_routines_that_may_run_and_are_not_at_hand(tmp_path: Path, head: list[str], lines: list[str]) -> None:
    made = run(tmp_path, *lines, *WAY, head=[*head, *HEAD])
    assert len(made.gaps) == 1 and ("may run at any time" in made.gaps[0].text or "MYLIB" in made.gaps[0].text)


@pytest.mark.parametrize("name", ["BAS", "IR_STOPM"])
def test_a_library_of_the_programs_own_stands_against_it(tmp_path: Path, name: str) -> None:
    own = f"DEF {name} ( )\n$OUT[1] = FALSE\nEND\n"
    assert "library-replaced" in said(run(tmp_path, *WAY, tail=own))
    (tmp_path / f"{name}.src").write_text(own)
    assert "library-replaced" in said(run(tmp_path, *WAY))


# --- types and data lists


@pytest.mark.parametrize(
    ("lines", "speed"),
    [
        (["I = 2.5", "$VEL.CP = I * 0.01"], 0.03),
        (["I = 2.4", "$VEL.CP = I * 0.01"], 0.02),
        (["I = -2.5", "$VEL.CP = I * -0.01"], 0.03),
        (["R = 3", "$VEL.CP = R / 60"], 0.05),
        (["I = 3", "$VEL.CP = 0.01 + I / 60"], 0.01),
        (["N[2] = 1.6", "$VEL.CP = N[2] * 0.01"], 0.02),
    ],
)
def test_whole_numbers_are_rounded_and_reals_are_none(tmp_path: Path, lines: list[str], speed: float) -> None:
    made = run(tmp_path, *lines, *WAY, head=["DECL INT I, N[3]", "DECL REAL R", *HEAD])
    assert made.speed[1] == pytest.approx(speed) and said(made) == []


def test_a_parameter_is_of_the_type_that_its_routine_says(tmp_path: Path) -> None:
    own = "DEF FEED (I :IN )\nDECL INT I\n$VEL.CP = I * 0.01\nEND\n"
    assert run(tmp_path, "FEED (2.5 )", *WAY, tail=own).speed[1] == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("lines", "again"),
    [
        (["$VEL.CP = F", *WAY, "F = F * 2"], False),
        (["F = 0.02", "$VEL.CP = F", *WAY, "F = F * 2"], True),
        (["LIN XP", "XP.Z = XP.Z - 1"], False),
        (["XP.Z = 600", "LIN XP"], True),
        (["$VEL.CP = F", *WAY], True),
        (["IF F > 0.05 THEN", "$OUT[2] = TRUE", "ENDIF", *WAY, "F = 0.1"], False),
        (["F = $ANIN[1]", *WAY, "F = 0.05"], True),
    ],
)
def test_what_a_data_list_keeps_makes_the_next_run_the_same(tmp_path: Path, lines: list[str], again: bool) -> None:
    data = "DECL REAL F=0.05\nDECL E6POS XP={X 97.0,Y -41.7,Z 600.0,A 180.0,B 0.0,C 20.4,E1 0.0,E2 0.0}"
    assert said(run(tmp_path, *lines, data=data)) == ([] if again else ["not-repeatable"])


def test_what_all_programs_share_is_kept_too(tmp_path: Path) -> None:
    data = "DECL GLOBAL REAL F=0.05"
    assert said(run(tmp_path, "$VEL.CP = F", *WAY, "F = F * 2", data=data)) == ["not-repeatable"]
    assert said(run(tmp_path, "$VEL.CP = F", *WAY, data=data)) == []


def test_a_count_that_goes_on_is_not_judged(tmp_path: Path) -> None:
    assert only(run(tmp_path, "PARTS = PARTS + 1", *WAY, data="DECL INT PARTS=0"), "with every run")


def test_variables_of_the_run_are_not_kept(tmp_path: Path) -> None:
    assert said(run(tmp_path, "F = 0.05", "F = F * 2", "$VEL.CP = F", *WAY, head=["DECL REAL F", *HEAD])) == []


# --- text, hooks by number, GOTO, splines


@pytest.mark.parametrize("sign", ["\r", "\x1a", "\x0b"])
def test_a_control_character_is_not_judged(tmp_path: Path, sign: str) -> None:
    path = tmp_path / "job.src"
    text = "\n".join(["DEF job ( )", *HEAD, HOME, *WAY, "END", ""])
    for written, wrong in (
        (text.replace("\n", "\r\n"), False),
        (text + "\x1a", False),
        (text.replace("LIN", f"; note{sign}LIN", 1), True),
    ):
        path.write_bytes(written.encode())
        assert bool(said(run_program(path, MACHINE))) == wrong


@pytest.mark.parametrize(
    ("value", "speed"),
    [
        ("9000 / 24000.0", 9000),
        ("0.375", 9000),
        ("4500.0 / 12000.0", 9000),
        ("S / 24000.0", 9000),
        ("0.33333333", 8000),
        ("(3 + 6) / 24.0", 9000),
        ("0.0", None),
        ("9000 / 24000", None),
        ("$ANIN[1]", None),
    ],
)
def test_a_hook_is_known_by_the_number_that_it_comes_to(tmp_path: Path, value: str, speed: float | None) -> None:
    made = run(
        tmp_path, "S = 9000", f"$ANOUT[1] = {value}", "$OUT[1] = TRUE", "WAIT SEC 1.5 * 2", *WAY, head=["INT S", *HEAD]
    )
    found = [event.value for event in made.events if event.kind == Kind.SPINDLE_ON]
    assert found == ([] if speed is None else [pytest.approx(speed, abs=0.01)])


def test_goto_leads_to_its_mark(tmp_path: Path) -> None:
    made = run(tmp_path, "LIN {Z 610}", "GOTO ON", "LIN {Z 400}", "ON:", "LIN {Z 600}")
    assert said(made) == [] and len(made) == 3
    out = run(tmp_path, "IF TRUE THEN", "LIN {Z 610}", "GOTO ON", "ENDIF", "LIN {Z 400}", "ON :", "LIN {Z 600}")
    assert said(out) == [] and len(out) == 3
    for lines in (["GOTO NOWHERE"], ["GOTO IN", "IF TRUE THEN", "IN:", "ENDIF"], ["A:", *WAY, "GOTO A"]):
        endless = run(tmp_path, *lines, *WAY)
        assert endless.gaps and np.isfinite(endless.axes).all()


def test_a_spline_of_lines_is_lines(tmp_path: Path) -> None:
    run_splines = partial(run, machine=SPLINES)
    assert said(run(tmp_path, "SPLINE", "SLIN {Z 600}", "SLIN {Z 590}", "ENDSPLINE")) == ["spline-unasked"]
    assert said(run_splines(tmp_path, "SPLINE", "SLIN {Z 600}", "SLIN {Z 590}", "ENDSPLINE")) == []
    assert only(run_splines(tmp_path, "SPLINE", "SLIN {Z 600}", "SPL {Z 590}", "ENDSPLINE"), "spline")
    made = run_splines(
        tmp_path,
        "SPLINE WITH $VEL.CP = 1",
        "SLIN {Z 600}",
        "SLIN {Z 595} WITH $VEL = {CP 0.2}",
        "ENDSPLINE",
        "LIN {Z 594}",
    )
    assert said(made) == [] and made.speed.tolist()[-3:] == [1.0, 0.2, 0.05]
    assert said(run_splines(tmp_path, "SPLINE WITH $ACC.CP = 1", "SLIN {Z 600}", "ENDSPLINE")) == ["setting-lower"]
    assert only(run_splines(tmp_path, "SPLINE WITH $OUT[1] = TRUE", "SLIN {Z 600}", "ENDSPLINE"), "WITH")
    assert only(run_splines(tmp_path, "SPLINE", "SLIN {Z 600}", "ENDSPLINE C_SPL"), "spline")
    for inside in ("LIN {Z 590}", "SLIN {Z 590} C_SPL", "$VEL.CP = 0.1", "WAIT SEC 1"):
        assert "spline-block" in said(run_splines(tmp_path, "SPLINE", "SLIN {Z 600}", inside, "ENDSPLINE")), inside


def test_the_judge_counts_it(tmp_path: Path) -> None:
    """What is said of how it moves reaches the verdict: an error makes it wrong, what isn't judged keeps it open."""
    run(tmp_path, *WAY)
    assert judge(tmp_path / "job.src", CELL).judged["limits"] is True
    run(tmp_path, "$LOAD.M = 90", *WAY)
    open_one = judge(tmp_path / "job.src", CELL)
    assert open_one.judged["process"] is None and not open_one.complete
    assert any("weighs what the program's load says" in text for text in open_one.unjudged)
    run(tmp_path, "UNHEARD_OF ( )", *WAY)
    assert judge(tmp_path / "job.src", CELL).judged["limits"] is None
    run(tmp_path, "BAS (#VEL_PTP,90 )", "PTP {A1 1}")
    assert judge(tmp_path / "job.src", CELL).judged["process"] is False


# --- rows of the controller's tables


NUMBERED = replace(
    MACHINE, controller=replace(MACHINE.controller, own={**MACHINE.controller.own, "tool_number": 5, "base_number": 7})
)


@pytest.mark.parametrize("line", ["$ACT_TOOL = 6", "$ACT_BASE = 5", "BAS (#TOOL,4 )", "BAS (#BASE,0 )"])
def test_a_row_other_than_the_cells_stands_against_it(tmp_path: Path, line: str) -> None:
    """Load data, hand guiding and an entry after a stop go by it, whatever the frames are that the program sets."""
    made = run(tmp_path, *WAY, head=[*HEAD[:2], line, *HEAD[2:]], machine=NUMBERED)
    assert "other-number" in said(made)
    assert "other-number" not in said(run(tmp_path, *WAY, head=[*HEAD[:2], line, *HEAD[2:]]))


def test_the_cells_own_rows_stand_against_nothing(tmp_path: Path) -> None:
    head = [*HEAD[:2], "$ACT_TOOL = 6", "$ACT_TOOL = 5", "BAS (#BASE,7 )", *HEAD[2:]]
    assert said(run(tmp_path, *WAY, head=head, machine=NUMBERED)) == []


@pytest.mark.parametrize("place", ["/R1/OTHER/", "KRC:\\R1\\", "/R1/OTHER "])
def test_a_routine_from_a_place_of_its_own_is_not_judged(tmp_path: Path, place: str) -> None:
    assert only(run(tmp_path, *WAY, data=f"EXT {place}BAS (BAS_COMMAND :IN,REAL :IN )"), "it takes BAS from")
