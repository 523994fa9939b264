"""Programs for Siemens' and Heidenhain's controls, held to paths worked out by closed formulas from the makers' rules."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move, Region

SIEMENS = "N10 G90 G17 G710 G94\nN20 T1 M6\nN30 S5000 M3\nN35 CYCLE832(0.01,1)\nN40 SOFT FFWON COMPCAD G642\n"
UP = "G0 X0 Y0 Z50\nF600\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S5000\n2 L Z+50 R0 FMAX M3\n3 L X+0 Y+0 FMAX\n"


def regions(folder: Path, text: str, name: str, dialect: str | None = None) -> tuple[Region, ...]:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return read_toolpath(file, dialect=dialect).regions


def ends(folder: Path, text: str, name: str, dialect: str | None = None) -> np.ndarray:
    """Tip (mm) and axis at the end of each line that cuts, (N, 6)."""
    rows = []
    for region in regions(folder, text, name, dialect):
        cut = region.move == Move.CUT
        last = cut & np.append(region.line[1:] != region.line[:-1], True)
        rows.append(np.hstack([region.position[last] * 1e3, region.axis[last]]))
    return np.concatenate(rows)


def refused(folder: Path, text: str, name: str, line: int, match: str) -> None:
    with pytest.raises(ToolpathError, match=match) as caught:
        regions(folder, text, name)
    assert caught.value.line == line, str(caught.value)
    assert caught.value.hint and "\n" not in str(caught.value)


def siemens(folder: Path, body: str) -> np.ndarray:
    return ends(folder, SIEMENS + UP + body + "M30\n", "a.mpf")


def klartext(folder: Path, body: str) -> np.ndarray:
    return ends(folder, KLARTEXT + body + "L Z+50 FMAX M30\nEND PGM A MM\n", "a.h")


# -- what a control says of itself ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "dialect"),
    [(SIEMENS + UP + "G1 X1\nM30\n", "gcode-siemens"), (KLARTEXT + "L X+1 F9 M30\nEND PGM A MM\n", "gcode-heidenhain")],
)
def test_a_file_can_be_read_as_the_dialect_that_it_was_found_to_have(tmp_path: Path, text: str, dialect: str) -> None:
    file = tmp_path / "a.nc"
    file.write_text(text, encoding="utf-8")
    assert read_toolpath(file).dialect == read_toolpath(file, dialect=dialect).dialect == dialect
    with pytest.raises(ToolpathError, match="no dialect 'gcode-ros'"):
        read_toolpath(file, dialect="gcode-ros")


# -- Siemens ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body",
    [
        "R1=0\nWHILE R1<12\nG1 X=25*COS(R1*30) Y=25*SIN(R1*30) Z-2\nR1=R1+1\nENDWHILE\n",
        "FOR R1=0 TO 11\nG1 X=25*COS(R1*30) Y=25*SIN(R1*30) Z=-2\nENDFOR\n",
        "DEF REAL W=0\nNEXT: G1 X=25*COS(W) Y=25*SIN(W) Z-2\nW=W+30\nIF W<360 GOTOB NEXT\n",
        "R5=0\nREPEAT\nG1 X=25*COS(R5) Y=25*SIN(R5) Z-2\nR5=R5+30\nUNTIL R5>=360\n",
        "R5=-30\nLOOP\nR5=R5+30\nIF R5>=360 GOTOF DONE\nG1 X=25*COS(R5) Y=25*SIN(R5) Z-2\nENDLOOP\nDONE:\n",
        "R1=0\nN500 IF (R1 MOD 2)==0\nG1 X=25*COS(R1*30) Y=25*SIN(R1*30) Z-2\nELSE\nG1 X=25*COS(R1*30) Y=25*SIN(R1*30) Z-2\n"
        "ENDIF\nR1=R1+1\nIF R1<12 GOTO N500\n",
    ],
)
def test_one_ring_of_twelve_points_by_siemens_loops(tmp_path: Path, body: str) -> None:
    angle = np.radians(30.0 * np.arange(12))
    ring = np.stack([25 * np.cos(angle), 25 * np.sin(angle), np.full(12, -2.0)], axis=1)
    (region,) = regions(tmp_path, SIEMENS + UP + body + "M30\n", "a.mpf")
    np.testing.assert_allclose(region.position[region.move == Move.CUT] * 1e3, ring, atol=1e-9)


def test_vectors_of_siemens_turn_the_tool_also_without_a_move(tmp_path: Path) -> None:
    body = "TRAORI\nORIWKS\nORIVECT\nG0 X0 Y0 Z20 A3=0 B3=0 C3=1\nG1 Z0\nG1 A3=3 B3=0 C3=4\nX=10 A3=0 B3=1 C3=1\n"
    body += "G0 Z40\nTRAFOOF\n"
    half = math.sqrt(0.5)
    np.testing.assert_allclose(
        siemens(tmp_path, body), [[0, 0, 0, 0, 0, 1], [0, 0, 0, 0.6, 0, 0.8], [10, 0, 0, 0, half, half]], atol=1e-9
    )


@pytest.mark.parametrize(
    ("mode", "order", "angles"), [(57, "XYZ", (20, 30, 40)), (39, "ZXY", (20, 30, 40)), (27, "ZYX", (10, -25, 5))]
)
def test_cycle800_sets_the_plane_that_its_mode_says(
    tmp_path: Path, mode: int, order: str, angles: tuple[float, ...]
) -> None:
    """Against scipy: each turn about the axis as it has been turned so far, between the two shifts."""
    a, b, c = angles
    body = (
        f'CYCLE800(1,"TC1",0,{mode},10,20,30,{a},{b},{c},1,2,3,-1,0)\nG0 X0 Y0 Z9\nG1 Z0\nX5 Y6\nG0 Z40\nCYCLE800()\n'
    )
    turn = Rotation.from_euler(order, angles, degrees=True)
    found = siemens(tmp_path, body)
    origin = np.array([10, 20, 30]) + turn.apply([1, 2, 3])
    np.testing.assert_allclose(found[:, :3], [origin, origin + turn.apply([5, 6, 0])], atol=1e-9)
    np.testing.assert_allclose(found[:, 3:], [turn.apply([0, 0, 1])] * 2, atol=1e-9)


def test_words_of_siemens_as_iso_means_them(tmp_path: Path) -> None:
    found = siemens(tmp_path, "TRANS X10\nATRANS Y5\nG1 X0 Y0 Z0\nX=IC(3) Y=IC(1)\nTRANS\nX=AC(7) Y0\n")
    np.testing.assert_allclose(found[:, :3], [[10, 5, 0], [13, 6, 0], [7, 0, 0]], atol=1e-9)
    beside = siemens(tmp_path, "G91 G1 X=AC(4) Y=AC(2)\nX1\nG90 X=IC(2) Y=IC(2)\nX3 Y=AC(3)\n")
    np.testing.assert_allclose(beside[:, :2], [[4, 2], [5, 2], [7, 4], [3, 3]], atol=1e-9)
    refused(tmp_path, SIEMENS + UP + "G1 X10 Y0\nG3 X0 Y10 I=AC(0) J0\nM30\n", "a.mpf", 9, "some of a centre's")
    arc = siemens(tmp_path, "G1 X10 Y0 Z0\nG3 X-10 Y0 CR=10\nG3 X10 Y0 I=AC(0) J=AC(0)\nG3 X10 Y0 I-10 J0 Z-3 TURN=2\n")
    np.testing.assert_allclose(arc[:, :3], [[10, 0, 0], [-10, 0, 0], [10, 0, 0], [10, 0, -3]], atol=1e-9)
    (helix,) = regions(tmp_path, SIEMENS + UP + "G1 X10 Z0\nG3 X10 Y0 I-10 J0 Z-3 TURN=2\nM30\n", "h.mpf")
    turned = np.unwrap(np.arctan2(helix.position[1:, 1], helix.position[1:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(6.0 * math.pi)  # one turn, and two further ones
    inch = ends(tmp_path, SIEMENS.replace("G710", "G700") + UP + "G1 X1\nM30\n", "i.mpf")
    assert inch[0, 0] == pytest.approx(25.4)


def test_supa_is_a_machine_position_and_one_tool_by_its_name_is_the_set_ups(tmp_path: Path) -> None:
    body = 'G71\nT="MILL_D10"\nM6\nS900 M3\nG0 X0 Y0 Z5\nG1 X5 F100\nSUPA G0 Z0 D0\nG0 X1 Y1 Z5\nG1 Z0\nM30\n'
    found = regions(tmp_path, body, "t.mpf")
    assert [r.tool for r in found] == [0, 0]
    np.testing.assert_allclose(ends(tmp_path, body, "t.mpf")[:, :3], [[5, 0, 5], [1, 1, 0]], atol=1e-9)
    refused(tmp_path, body.replace("SUPA", 'T="DRILL"\nSUPA'), "t.mpf", 2, "several tools by their names")


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("G1 X=R7", "R7 is read"),
        ("R1=$AA_IM[X]", "system variable"),
        ("X=R1 GOTOF NOWHERE", "R1 is read|NOWHERE"),
        ("GOTOF NOWHERE", "NOWHERE is jumped to"),
        ("POCKET3(50,0,2)", "POCKET3"),
        ("MCALL SLOT1(50,0,2,-5)", "modal call"),
        ("L100", "subprogram call"),
        ("MY_SUB", "MY_SUB is not known"),
        ("ROT X30", "turned frame"),
        ("AROT Y5 Z30", "turned frame"),
        ("MIRROR Z0", "mirroring of another axis"),
        ("SCALE X2", "by two factors"),
        ("CIP X10 Y0 Z9 I1=5 J1=5", "circle through a point"),
        ("BSPLINE X1", "a spline"),
        ("A3=0 B3=0 C3=1", "centre point off"),
        ('CYCLE800(1,"TC",0,192,0,0,0,30,0,0)', "MODE 192"),
        ('CYCLE800(1,"TC",1,57,0,0,0,30,0,0)', "adds to the plane"),
        ("G1 X10 RND=2", "RND"),
        ("G58 X10 Y5", "G58 of Siemens"),
        ("G1 X10 CHF=2", "CHF"),
        ("G1 ANG=30 X-10", "ANG"),
        ("G110 X0 Y0 F100", "G110"),
        ("TRAORI\nG1 X1 A30 C10", "which way the rotary axes turn"),
        ("G1 X1 C=ACP(30)", "turned rotary axes"),
        ("R1=1/0", "division by zero"),
        ("ENDWHILE", "without its WHILE"),
        ("G291", "G291"),
        ("G1 X1 LEAD=3", "LEAD"),
        ("UNKNOWN=3", "has not declared"),
        ('EXTCALL "BIG"', "EXTCALL"),
    ],
)
def test_what_siemens_programs_are_refused_for(tmp_path: Path, body: str, match: str) -> None:
    refused(tmp_path, SIEMENS + UP + body + "\nM30\n", "r.mpf", 8 + body.count("\n"), match)


# -- Heidenhain ------------------------------------------------------------------------------------------------------


def test_lines_circles_and_helices_of_klartext(tmp_path: Path) -> None:
    body = (
        "L Z-1 F500\nCC X+10 Y+0\nC X+20 Y+0 DR-\nCP IPA+720 IZ-2 DR+\nCR X+0 Y+0 R+10 DR+\nCC X+0 Y+0\nL IX+5\nLP PR+8 PA+90\n"
        "CP PA+180 DR+\n"
    )
    expected = [[0, 0, -1], [20, 0, -1], [20, 0, -3], [0, 0, -3], [5, 0, -3], [0, 8, -3], [-8, 0, -3]]
    np.testing.assert_allclose(klartext(tmp_path, body)[:, :3], expected, atol=1e-9)
    (region,) = regions(tmp_path, KLARTEXT + body + "L Z+50 FMAX M30\nEND PGM A MM\n", "b.h")
    helix = region.position[region.line == 8] * 1e3
    np.testing.assert_allclose(np.hypot(helix[:, 0] - 10, helix[:, 1]), 10.0)
    assert np.unwrap(np.arctan2(helix[:, 1], helix[:, 0] - 10))[-1] == pytest.approx(4 * math.pi)
    down = region.position[region.line == 7] * 1e3
    assert down[len(down) // 2, 1] > 9.9  # DR- from (0, 0) about (10, 0) goes over the top


def test_vectors_of_klartext(tmp_path: Path) -> None:
    body = "M128\nL X+0 Y+0 Z+20 FMAX\nLN X+5 Y+0 Z+0 NX+0 NY+0 NZ+1 TX+0.6 TY+0 TZ+0.8 F800\nL X+6 F100\nM129\n"
    np.testing.assert_allclose(klartext(tmp_path, body), [[5, 0, 0, 0.6, 0, 0.8], [6, 0, 0, 0.6, 0, 0.8]], atol=1e-9)


@pytest.mark.parametrize("angles", [(0, 30, 0), (20, 0, 45), (10, -20, 130)])
def test_plane_spatial_turns_about_fixed_axes(tmp_path: Path, angles: tuple[float, float, float]) -> None:
    """Against scipy: SPA about X, then SPB about Y, then SPC about Z, all of the frame that stands still."""
    a, b, c = angles
    body = (
        "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Z-5\n"
        f"PLANE SPATIAL SPA{a:+} SPB{b:+} SPC{c:+} TURN MB MAX FMAX SEQ- TABLE ROT\nL X+0 Y+0 Z+9 FMAX\nL Z+0 F300\nL X+4 Y+3\n"
        "L Z+50 FMAX\nPLANE RESET TURN FMAX\nL X+0 Y+0 Z+20 FMAX\nL Z+5 F100\n"
    )
    turn = Rotation.from_euler("xyz", angles, degrees=True)
    found = klartext(tmp_path, body)
    np.testing.assert_allclose(found[:2, :3], np.array([10, 0, -5]) + turn.apply([[0, 0, 0], [4, 3, 0]]), atol=1e-9)
    np.testing.assert_allclose(found[:2, 3:], [turn.apply([0, 0, 1])] * 2, atol=1e-9)
    np.testing.assert_allclose(found[2], [10, 0, 0, 0, 0, 1], atol=1e-9)


def test_parameters_labels_and_repeats_of_klartext(tmp_path: Path) -> None:
    body = (
        "FN 0: Q1 = +0\nLBL 1\nQ2 = 25 * COS ( Q1 * 30 )\nQ3 = 25 * SIN ( Q1 * 30 )\nL X+Q2 Y+Q3 Z-2 F200\nFN 1: Q1 = +Q1 + +1\n"
        "CALL LBL 1 REP 11\n"
    )
    (region,) = regions(tmp_path, KLARTEXT + body + "L Z+50 FMAX M30\nEND PGM A MM\n", "q.h")
    angle = np.radians(30.0 * np.arange(12))
    ring = 25 * np.stack([np.cos(angle), np.sin(angle)], 1)
    np.testing.assert_allclose(region.position[region.move == Move.CUT][:, :2] * 1e3, ring, atol=1e-9)
    sub = "L Z-1 F200\nCALL LBL 5\nL Y+9\nCALL LBL 5\nFN 9: IF +1 EQU +1 GOTO LBL 99\nLBL 5\nL IX+2\nLBL 0\nLBL 99\n"
    np.testing.assert_allclose(klartext(tmp_path, sub)[:, :2], [[0, 0], [2, 0], [2, 9], [4, 9]], atol=1e-9)


def test_cycle_200_hole_by_hole(tmp_path: Path) -> None:
    values = ("Q200=+2 ;SET-UP", "Q201=-10", "Q206=+150", "Q202=+4", "Q210=+0", "Q203=+1", "Q204=+20")
    cycle = "CYCL DEF 200 DRILLING ~\n " + " ~\n ".join(values) + " ~\n Q211=+0.5\n"
    text = KLARTEXT + cycle + "L X+30 Y+30 FMAX M99\nL X+40\nCYCL CALL\nL Z+50 FMAX M30\nEND PGM A MM\n"
    (region,) = regions(tmp_path, text.replace("L X+40", "L X+40 FMAX"), "c.h")
    z = region.position[:, 2] * 1e3
    hole = [3, -3, 3, -1, -7, 3, -5, -9, 21]
    np.testing.assert_allclose(z[2:], [*hole, 21, *hole, 50], atol=1e-9)
    cut = region.move[2:11] == Move.CUT
    assert cut.tolist() == [False, True, False, False, True, False, False, True, False]
    assert [e.value for e in region.events if e.kind is EventKind.DWELL] == [0.5, 0.5]
    assert region.feed[3] == pytest.approx(0.15 / 60.0)


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("L X+5 RL F100", "radius compensation"),
        ("RND R2", "behind no straight cut"),
        ("APPR LCT X+5 Y+5 R2 RL F100", "is not read"),
        ("CT X+5 Y+5", "whose direction is known"),
        ("CYCL DEF 19.1 A+30", "CYCL DEF 19 with angles"),
        ("CYCL DEF 26.1 X 0.9", "CYCL DEF 26.1"),
        ("CYCL DEF 205 PECKING Q200=2", "cycle 205 without Q201"),
        ("PLANE VECTOR BX1 BY0 BZ0 NX0 NY0 NZ1 TURN", "is not read"),
        ("FUNCTION TCPM F TCP AXIS SPAT", "is not read"),
        ("L X+Q7 F100", "Q7 is read"),
        ("L X+Q120 F100", "Q120 is read"),
        ("CALL PGM TNC:SUB.H", "another program"),
        ("CALL LBL 77", "LBL 77"),
        ('TOOL CALL "D10" Z S100', "several tools"),
        ("TOOL CALL 2 Z S100 DL+0.5", "DL"),
        ("TOOL CALL 2 X S100", "along X"),
        ("C X+5 Y+5 DR+", "without a centre"),
        ("M128\nL X+5 A+30 C+10 F100", "which way the rotary axes turn"),
        ("L X+5 F100 M109", "M109"),
        ("CYCL CALL", "without a cycle"),
        ("L X+5 W+3 F100", "not a word"),
    ],
)
def test_what_klartext_programs_are_refused_for(tmp_path: Path, body: str, match: str) -> None:
    text = KLARTEXT + body + "\nL Z+50 FMAX M30\nEND PGM A MM\n"
    refused(tmp_path, text, "r.h", 5 + body.count("\n"), match)


# -- which way rotary axes turn --------------------------------------------------------------------------------------


@pytest.mark.parametrize("on", ["G43.4 H1", "M128", "G234", "TRAORI"])
def test_the_signs_of_rotary_axes_are_asked_for(tmp_path: Path, on: str) -> None:
    """ISO 841: a positive word turns the tool about the part, right-handedly: Rz(C) Rx(A) z, whether head or table turns."""
    text = f"G21 G90 G94\n{on}\nG0 X0 Y0 Z10 A20 C30\nG1 X1 F600\nM30\n"
    refused(tmp_path, text, "a.nc", 3, "which way the rotary axes turn")
    by_tool = Rotation.from_euler("ZX", [30, 20], degrees=True).apply([0, 0, 1])
    by_table = Rotation.from_euler("ZX", [-30, -20], degrees=True).apply([0, 0, 1])
    np.testing.assert_allclose(ends(tmp_path, text, "a.nc", "gcode-xyzac-iso")[0, 3:], by_tool, atol=1e-12)
    np.testing.assert_allclose(ends(tmp_path, text, "a.nc", "gcode-xyzac")[0, 3:], by_table, atol=1e-12)
    other = text.replace("A20", "B20")
    by_tool = Rotation.from_euler("ZY", [30, 20], degrees=True).apply([0, 0, 1])
    np.testing.assert_allclose(ends(tmp_path, other, "a.nc", "gcode-xyzbc-iso")[0, 3:], by_tool, atol=1e-12)


def test_a_dialect_that_names_no_machine_we_know(tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match="no dialect 'gcode-xyzab'"):
        regions(tmp_path, "G21\nG0 X0 Y0 Z5\nG1 X1 F5\nM30\n", "a.nc", "gcode-xyzab")


def test_what_a_cycle_or_a_block_leaves_behind(tmp_path: Path) -> None:
    """FMAX, written in one word or two, holds for its block; cycle 200's feed is its own."""
    values = "Q200=+2 Q201=-3 Q206=+150 Q202=+4 Q210=+0 Q203=+0 Q204=+9 Q211=+0"
    body = f"L Z-1 F500\nL Z+20 F MAX\nCYCL DEF 200 DRILLING {values}\nCYCL CALL\nL Z+1\n"
    body += "L M140 MB MAX FMAX\nL X+0 Y+0 FMAX\nL Z+9 FMAX\nL X+1\n"
    found = regions(tmp_path, KLARTEXT + body + "L Z+50 FMAX M30\nEND PGM A MM\n", "f.h")
    feeds = np.concatenate([r.feed[r.move == Move.CUT] for r in found]) * 60e3
    np.testing.assert_allclose(feeds, [500, 150, 500, 500])
    text = KLARTEXT + f"CYCL DEF 200 DRILLING {values}\nCYCL CALL\nL X+1\nEND PGM A MM\n"
    refused(tmp_path, text, "f.h", 7, "without a feed behind a cycle")


def test_both_rotary_axes_named_behind_a_plane_are_all_that_there_are(tmp_path: Path) -> None:
    body = (
        "PLANE SPATIAL SPA+0 SPB+20 SPC+0 TURN FMAX\nL X+0 Y+0 Z+5 FMAX\nL Z+0 F300\nL Z+50 FMAX\nPLANE RESET STAY\n"
        "{}\nL X+5 Y+5 FMAX\nL Z+5 FMAX\nL Z+1 F100\n"
    )
    np.testing.assert_allclose(klartext(tmp_path, body.format("L B+0 C+0 FMAX"))[-1], [5, 5, 1, 0, 0, 1], atol=1e-9)
    text = KLARTEXT + body.format("L C+0 FMAX") + "END PGM A MM\n"
    refused(tmp_path, text, "p.h", 13, "centre point is off|only the control knows")


def test_several_assignments_and_the_shortest_way_in_a_rapid(tmp_path: Path) -> None:
    body = "R1=5 R2=R1*2 R3=-3\nG1 Z=R3 F=R2*50 CTOL=0.01\nX=R1 Y=R2\nG0 C=DC(0)\n"
    np.testing.assert_allclose(siemens(tmp_path, body)[:, :3], [[0, 0, -3], [5, 10, -3]], atol=1e-9)
    refused(tmp_path, SIEMENS + UP + "TRAORI\nG0 Z5\nG1 X1 C=DC(180)\nM30\n", "d.mpf", 10, "half a turn")


def test_a_work_offset_out_of_force_cuts_nothing(tmp_path: Path) -> None:
    head = "G71 G90\nT1\nG500\nSUPA G0 Z0\nG54\nS900 M3\nG0 X0 Y0 Z5\nG1 X5 F100\nG0 Z9\nG500\n"
    np.testing.assert_allclose(ends(tmp_path, head + "SUPA G0 Z0\nM30\n", "o.mpf")[:, 0], [5])
    refused(tmp_path, head + "G0 X0 Y0 Z5\nG1 X5\nM30\n", "o.mpf", 12, "without the work offset")


# -- drilling cycles --------------------------------------------------------------------------------------------------


def _moved(folder: Path, body: str) -> list[tuple[str, float, float, float, float]]:
    """Each motion's way, end (mm) and feed (mm/min, 0 in rapid), in order."""
    out = []
    for region in regions(folder, SIEMENS + UP + body + "M30\n", "c.mpf"):
        for p, move, feed in zip(region.position * 1e3, region.move, region.feed, strict=True):
            way = "cut" if move == Move.CUT else "rapid"
            out.append(
                (way, *(round(float(v), 6) + 0.0 for v in p), 0.0 if way == "rapid" else round(float(feed) * 6e4, 6))
            )
    return out


def test_siemens_drills_where_mcall_stands_behind_every_way(tmp_path: Path) -> None:
    body = "G1 X1 F300\nG0 Z30\nMCALL CYCLE82(20,1,2,-5,,0.5)\nX10 Y5\nMCALL\nX20\nG1 Z0\n"
    assert _moved(tmp_path, body)[2:] == [
        ("rapid", 1, 0, 30, 0),
        ("rapid", 10, 5, 30, 0),
        ("rapid", 10, 5, 3, 0),
        ("cut", 10, 5, -5, 300),
        ("rapid", 10, 5, 20, 0),
        ("rapid", 20, 5, 20, 0),
        ("cut", 20, 5, 0, 300),
    ]
    (region,) = regions(tmp_path, SIEMENS + UP + body + "M30\n", "c.mpf")
    assert [(e.kind, e.value) for e in region.events if e.kind is EventKind.DWELL] == [(EventKind.DWELL, 0.5)]


@pytest.mark.parametrize(
    ("call", "heights"),
    [
        ("CYCLE81(20,1,2,,6)", [(3, 0), (-5, 600), (20, 0)]),
        ("CYCLE85(20,0,2,-5,,0,120,240)", [(2, 0), (-5, 120), (2, 240), (20, 0)]),
        # bites of 4, 3, 2, 2 and what is left; out to the clearance, in again to 0.6 above (DIS1 left out, less than 30 deep)
        (
            "CYCLE83(20,0,2,-12,,-4,,1,0,0,1,1,3,2)",
            [
                (2, 0),
                (-4, 600),
                (2, 0),
                (-3.4, 0),
                (-7, 600),
                (2, 0),
                (-6.4, 0),
                (-9, 600),
                (2, 0),
                (-8.4, 0),
                (-11, 600),
                (2, 0),
                (-10.4, 0),
                (-12, 600),
                (20, 0),
            ],
        ),
        # deeper than 30: a fiftieth of the depth, 1.2, at most 7; DIS1 itself where it stands
        ("CYCLE83(20,0,2,-60,,-40,,0,0,0,1,1)", [(2, 0), (-40, 600), (2, 0), (-38.8, 0), (-60, 600), (20, 0)]),
        ("CYCLE83(20,0,2,-400,,-300,,0,0,0,1,1)", [(2, 0), (-300, 600), (2, 0), (-293, 0), (-400, 600), (20, 0)]),
        ("CYCLE83(20,0,2,-60,,-40,,0,0,0,1,1,3,,,,2)", [(2, 0), (-40, 600), (2, 0), (-38, 0), (-60, 600), (20, 0)]),
        (
            "CYCLE83(20,0,2,-8,,,3,0,0,0,0.5,0,0,3,0.5)",
            [(2, 0), (-3, 300), (-2.5, 600), (-6, 600), (-5.5, 600), (-8, 600), (20, 0)],
        ),
        (
            "CYCLE83(20,0,2,-8,,,4,-0.5,0,0,1,0,0,1,1)",
            [(2, 0), (-4, 600), (-3, 600), (-6, 600), (-5, 600), (-7, 600), (-6, 600), (-8, 600), (20, 0)],
        ),
        # CYCLE89 comes out at the feed at which it went in; FRF in hundredths of the feed where it is above 1
        ("CYCLE89(20,0,2,-5)", [(2, 0), (-5, 600), (2, 600), (20, 0)]),
        ("CYCLE83(20,0,2,-8,,,4,0,0,0,100,1)", [(2, 0), (-4, 600), (2, 0), (-3.4, 0), (-8, 600), (20, 0)]),
        ("CYCLE83(20,0,2,-8,,,4,0,0,0,25,1)", [(2, 0), (-4, 150), (2, 0), (-3.4, 0), (-8, 600), (20, 0)]),
        ("CYCLE84(20,0,2,-8,,0,3,,0.8,0,1000,1000,0,1,,0,,,,,)", [(2, 0), (-8, 800), (2, 800), (20, 0)]),
    ],
)
def test_siemens_cycles_by_their_values(tmp_path: Path, call: str, heights: list[tuple[float, float]]) -> None:
    found = _moved(tmp_path, f"G0 X4 Y5 Z30\n{call}\nG1 X5\n")
    assert [(z, feed) for _, x, _, z, feed in found[2:-1]] == heights
    assert found[-1] == ("cut", 5, 5, 20, 600)


def test_a_cycle_leaves_g91_and_the_motion_as_they_were(tmp_path: Path) -> None:
    found = _moved(tmp_path, "G0 Z20\nG91 G1 X5 F200\nCYCLE81(20,0,2,-5)\nX1\n")
    assert found[-1] == ("cut", 6, 0, 20, 200)


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("CYCLE84(5,0,2,-9)", "without its pitch"),
        ("CYCLE84(5,0,2,-9,,0,3,,1,0,900,900,0,2)", "another unit"),
        ("MCALL CYCLE84(5,0,2,-9,,0,3,,1,0,900,900,0,1,,1,3,0.5)", "in bites"),
        ("CYCLE83(5,0,2,-9,,-3,,0,0,0,101,1)", "FRF"),
        ("MCALL CYCLE86(5,0,2,-9,,0,3,1,0,0,0)", "stands at an angle"),
        ("CYCLE88(5,0,2,-9,,0,3)", "an operator"),
        ("MCALL HOLES1(0,0,0,5,5,3)", "MCALL HOLES1"),
        ("CYCLE81(5,0,2)", "without its depth"),
        ("CYCLE81(5,0,2,-9,3)", "two depths"),
        ("CYCLE81(5,0,2,9)", "no hole"),
        ("CYCLE82(5,0,2,-9,,-3)", "turns of the spindle"),
        ("CYCLE83(5,0,2,-9,,-1,,-0.01,0,0,1,1)", "never end"),
        ("CYCLE81(5,0,2,-9,0,0,0,1,11)", "another way"),
    ],
)
def test_cycles_of_siemens_that_are_refused(tmp_path: Path, body: str, match: str) -> None:
    refused(tmp_path, SIEMENS + UP + f"G1 X1\n{body}\nX5\nM30\n", "a.mpf", 9, match)


def test_a_machine_position_leaves_the_kind_of_motion_alone(tmp_path: Path) -> None:
    found = _moved(tmp_path, "G1 X5\nSUPA Z300\nG0 X0 Y0 Z20\nG1 Z5\nSUPA Z300\nX1 Y1 Z6\nZ5\nX2\n")
    assert found[-1] == ("cut", 2, 1, 5, 600)


BASE = "Q200=+2 Q201=-8 Q206=+150 Q203=+1 Q204=+20 Q211=+0"
TWIST = BASE + " Q202=+4 Q210=+0 Q212=+0 Q213=+0 Q205=+0 Q208=+0"


@pytest.mark.parametrize(
    ("cycle", "heights"),
    [
        ("201 REAMING " + BASE + " Q208=+300", [(3, 0), (-7, 150), (3, 300), (21, 0)]),
        ("201 REAMING " + BASE + " Q208=+0", [(3, 0), (-7, 150), (3, 150), (21, 0)]),
        ("240 CENTERING " + BASE + " Q343=+0", [(3, 0), (-7, 150), (21, 0)]),
        ("203 UNIVERSAL " + TWIST, [(3, 0), (-3, 150), (3, 150), (-1, 0), (-7, 150), (3, 150), (21, 0)]),
        # bites of 4, 3 and what is left; the chip is broken once, by 0.5 mm, and the tool comes out in rapid
        (
            "203 UNIVERSAL "
            + TWIST.replace("Q212=+0", "Q212=+1")
            .replace("Q213=+0", "Q213=+1")
            .replace("Q205=+0", "Q205=+2")
            .replace("Q208=+0", "Q208=99999")
            + " Q256=+0.5",
            [(3, 0), (-3, 150), (-2.5, 0), (-6, 150), (3, 0), (-4, 0), (-7, 150), (3, 0), (21, 0)],
        ),
    ],
)
def test_cycles_of_heidenhain_by_their_values(tmp_path: Path, cycle: str, heights: list[tuple[float, float]]) -> None:
    text = KLARTEXT + f"L X+4 Y+5 Z+30 FMAX\nCYCL DEF {cycle}\nCYCL CALL\nL X+5 F100\nEND PGM A MM\n"
    (region,) = regions(tmp_path, text, "c.h")
    rows = [
        (round(float(p[2] * 1e3), 6) + 0.0, 0.0 if move == Move.RAPID else round(float(feed) * 6e4, 6))
        for p, move, feed in zip(region.position, region.move, region.feed, strict=True)
    ]
    first = next(i for i, p in enumerate(region.position) if p[0] > 0.0)
    assert rows[first + 1 : -1] == heights and rows[-1] == (21, 100)


@pytest.mark.parametrize(
    ("cycle", "match"),
    [
        ("200 D " + TWIST + " Q395=+1", "tip angle"),
        ("240 C " + BASE + " Q343=+1", "tip angle"),
        ("203 U " + BASE, "without Q202"),
        ("203 U " + TWIST.replace("Q212=+0", "Q212=+1"), "no hole"),
        ("201 R " + BASE.replace("Q201=-8", "Q201=+8") + " Q208=0", "no hole"),
    ],
)
def test_cycles_of_heidenhain_that_are_refused(tmp_path: Path, cycle: str, match: str) -> None:
    refused(tmp_path, KLARTEXT + f"CYCL DEF {cycle}\nCYCL CALL\nEND PGM A MM\n", "c.h", 5, match)


def test_commas_as_points_and_the_feed_of_the_tool(tmp_path: Path) -> None:
    text = (
        KLARTEXT.replace("S5000", "S5000 F250")
        + "L X+10,5 Y-3,25 Z+0 F AUTO\nL X+0 F100\nL Z+50 FMAX M30\nEND PGM A MM\n"
    )
    (region,) = regions(tmp_path, text, "a.h")
    cut = region.move == Move.CUT
    np.testing.assert_allclose(region.position[cut] * 1e3, [[10.5, -3.25, 0], [0, -3.25, 0]], atol=1e-9)
    assert region.feed[cut] * 6e4 == pytest.approx([250, 100])
    refused(tmp_path, KLARTEXT + "L X+1 F AUTO\nEND PGM A MM\n", "a.h", 5, "TOOL CALL has named no feed")


@pytest.mark.parametrize("name", [":0001", "<PART-1>", "O<PART_1> (ROUGH)", "O0012"])
def test_programs_by_number_or_name(tmp_path: Path, name: str) -> None:
    found = ends(tmp_path, f"%\n{name}\nG21 G90\nT1 M6\nS900 M3\nG0 X0 Y0 Z5\nG1 X4 F60\nM30\n%\n", "a.nc")
    assert found[:, :3].tolist() == [[4, 0, 5]]


def test_siemens_frames_that_turn_about_the_tool(tmp_path: Path) -> None:
    """Against scipy: ROT begins anew, AROT and ATRANS go on from the turned axes; arcs turn along, and all of it ends."""
    body = (
        "G1 X1 Y2\nTRANS X10 Y20 Z1\nAROT RPL=30\nX4 Y5 Z0\nATRANS X2\nX4 Y5\nG3 X0 Y9 I-4 J0\nG1 X4 Y5\nROT Z-15\nX4\nX4 Y5\n"
        "TRANS X3\nX4 Y5\nROT\nX4 Y5\n"
    ).replace("G3 X0 Y9 I-4 J0\n", "G2 X4 Y-5 I0 J-5\n")
    found = siemens(tmp_path, body)[:, :3]

    def at(angle: float, place: tuple[float, ...], *xyz: float) -> np.ndarray:
        return Rotation.from_euler("z", angle, degrees=True).apply(xyz) + place

    place = at(30, (10, 20, 1), 2, 0, 0)
    wanted = [
        (1, 2, 50),
        at(30, (10, 20, 1), 4, 5, 0),
        at(30, place, 4, 5, 0),
        at(30, place, 4, -5, 0),
        at(30, place, 4, 5, 0),
    ]
    np.testing.assert_allclose(found[:5], wanted, atol=1e-9)
    here = at(15, (0, 0, 0), *wanted[4])  # the same place in the frame that ROT Z-15 sets
    np.testing.assert_allclose(found[5], at(-15, (0, 0, 0), 4, here[1], here[2]), atol=1e-9)
    np.testing.assert_allclose(found[6], at(-15, (0, 0, 0), 4, 5, here[2]), atol=1e-9)
    np.testing.assert_allclose(found[7:, :2], [[7, 5], [4, 5]], atol=1e-9)
    refused(
        tmp_path,
        SIEMENS + UP + "G1 X1\nCYCLE800(1,,0,57,0,0,0,30,0,0)\nROT Z5\nM30\n",
        "a.mpf",
        10,
        "on top of CYCLE800",
    )
    refused(
        tmp_path, SIEMENS + UP + "G1 X1\nROT Z5\nCYCLE800(1,,0,57,0,0,0,30,0,0)\nM30\n", "a.mpf", 10, "on top of TRANS"
    )


def test_subprograms_of_siemens_in_one_file(tmp_path: Path) -> None:
    body = "G1 X0 Y0 Z0\nEDGE P=2\nX9 Y9\nM30\n%_N_EDGE_SPF\nG91 G1 X1\nDEEPER\nG90 M17\n%_N_DEEPER_SPF\nY1\nRET\n"
    found = ends(tmp_path, "%_N_MAIN_MPF\n" + SIEMENS + UP + body, "a.mpf")
    np.testing.assert_allclose(found[:, :2], [[0, 0], [1, 0], [1, 1], [2, 1], [2, 2], [9, 9]], atol=1e-9)
    last = "%_N_EDGE_SPF\nG1 X5 Z0 M17\n%_N_MAIN_MPF\n" + SIEMENS + UP + "EDGE\nX7\nM30\n"
    np.testing.assert_allclose(ends(tmp_path, last, "b.mpf")[:, 0], [5, 7], atol=1e-9)
    refused(tmp_path, SIEMENS + UP + "KONTUR P2\nM30\n", "c.mpf", 8, "KONTUR is not known")
    refused(tmp_path, "%_N_A_MPF\n" + SIEMENS + UP + "M30\n%_N_B_MPF\nG1 X1\nM30\n", "d.mpf", 10, "several main")


@pytest.mark.parametrize(("call", "times"), [("REPEAT AA EE", 2), ("REPEAT AA EE P=3", 4), ("REPEAT AA", 2)])
def test_siemens_repeats_a_part_between_labels(tmp_path: Path, call: str, times: int) -> None:
    found = siemens(tmp_path, f"G1 X0 Y0 Z0\nAA:\nG91 X1\nG90 Y1\nEE: Y0\n{call}\nX9\n")
    want = [[0, 0], *[[k + i, y] for k in range(times) for i, y in ((1, 0), (1, 1), (1, 0))], [9, 0]]
    np.testing.assert_allclose(found[:, :2], want, atol=1e-9)


def test_what_klartext_writes_beside_tool_centre_points(tmp_path: Path) -> None:
    body = (
        "5 L B+0 C+0 FMAX M94 C\n6 M128 F20000\n7 LN X+1 Y+0 Z+5 TX+0 TY+0 TZ+1 F100\n8 LN X+2 Y+0 Z+5 TX+0 TY+0 TZ+1\n"
    )
    np.testing.assert_allclose(klartext(tmp_path, body)[:, 0], [1, 2], atol=1e-9)


def bottoms(folder: Path, text: str, name: str) -> np.ndarray:
    """Tips of all cuts, mm."""
    return np.concatenate([r.position[r.move == Move.CUT] * 1e3 for r in regions(folder, text, name)])


def test_patterns_of_siemens_hold_the_modal_cycle(tmp_path: Path) -> None:
    body = "MCALL CYCLE81(50,0,2,-5)\nHOLES1(1,2,30,5,10,3)\nHOLES2(0,0,20,90,0,4)\nMCALL\nG1 X0 Y0 Z0\n"
    found = bottoms(tmp_path, SIEMENS + UP + body + "M30\n", "h.mpf")[:-1]
    ray = np.array([math.cos(math.radians(30)), 0.5])
    row = np.outer([5, 15, 25], ray) + np.array([1, 2])
    ring = [[0, 20], [-20, 0], [0, -20], [20, 0]]
    np.testing.assert_allclose(found, [[*xy, -5] for xy in (*row, *ring)], atol=1e-9)
    free = (
        "MCALL CYCLE81(50,0,2,-5)\nCYCLE802(111111111,111111111,20,5,-3.5,,8,9,,,,,,,,,,,,,0,0,1)\nMCALL\nG1 X0 Y0 Z0\n"
    )
    refused(tmp_path, SIEMENS + UP + free + "M30\n", "c.mpf", 9, "X or Y alone")
    found = bottoms(tmp_path, SIEMENS + UP + free.replace(",-3.5,,", ",-3.5,0,") + "M30\n", "d.mpf")[:-1]
    np.testing.assert_allclose(found, [[20, 5, -5], [-3.5, 0, -5], [8, 9, -5]], atol=1e-9)
    refused(tmp_path, SIEMENS + UP + free.replace("802(111111111", "802(111111121") + "M30\n", "e.mpf", 9, "by steps")
    refused(tmp_path, SIEMENS + UP + "HOLES2(0,0,20,90,0,4)\nM30\n", "a.mpf", 8, "HOLES2")
    refused(tmp_path, SIEMENS + UP + "MCALL CYCLE81(50,0,2,-5)\nHOLES2(0,0,0,90,0,4)\nM30\n", "b.mpf", 9, "radius")


@pytest.mark.parametrize(
    ("name", "text", "sense"),
    [
        ("a.mpf", SIEMENS + UP + "CYCLE84(50,0,2,-9,,,,,1.25,,800,800)\nM30\n", "CLW"),
        ("b.mpf", SIEMENS.replace("S5000", "S800") + UP + "CYCLE84(50,0,2,-9,,,,8)\nM30\n", "CLW"),
        ("c.mpf", SIEMENS.replace("S5000", "S800") + UP + "CYCLE840(50,0,2,-9,,,4,3,1,,1.25)\nM30\n", "CLW"),
        ("d.mpf", SIEMENS.replace("S5000 M3", "S800 M4") + UP + "CYCLE84(50,0,2,-9,,,,-8)\nM30\n", "CCLW"),
        (
            "a.h",
            KLARTEXT.replace("S5000", "S800") + "CYCL DEF 207 T Q200=2 Q201=-9 Q239=1.25 Q203=0 Q204=50\n"
            "L X+0 Y+0 FMAX M99\nM30\nEND PGM A MM\n",
            "CLW",
        ),
        (
            "b.h",
            KLARTEXT.replace("S5000", "S800") + "CYCL DEF 206 T Q200=2 Q201=-9 Q206=1000 Q211=0 Q203=0 Q204=50\n"
            "CYCL CALL POS X+0 Y+0 Z+0 FMAX\nM30\nEND PGM A MM\n",
            "CLW",
        ),
    ],
)
def test_taps_go_in_and_out_by_their_pitch_with_the_spindle_reversed_between(
    tmp_path: Path, name: str, text: str, sense: str
) -> None:
    (region,) = regions(tmp_path, text, name)
    cut = region.move == Move.CUT
    np.testing.assert_allclose(region.position[cut][:, 2] * 1e3, [-9, 2], atol=1e-9)
    assert region.feed[cut] * 6e4 == pytest.approx([1000, 1000])  # 800 turns of 1.25 mm
    bottom = int(np.flatnonzero(cut)[0])
    other = {"CLW": "CCLW", "CCLW": "CLW"}[sense]
    turned = [(e.point - bottom, e.text, e.value) for e in region.events if e.kind is EventKind.SPINDLE_ON][-3:]
    assert (1, other, 800.0) in turned and (2, sense, 800.0) in turned


def test_a_call_at_a_place_and_the_only_tool_by_its_name(tmp_path: Path) -> None:
    text = KLARTEXT.replace("CALL 1", 'CALL "MILL 10"') + (
        "CYCL DEF 200 D Q200=2 Q201=-5 Q206=100 Q202=9 Q210=0 Q203=1 Q204=20 Q211=0\n"
        "CYCL CALL POS X+4 Y+5 Z+0 FMAX M8\nCYCL CALL POS X+6 Y+5 Z+0 FMAX\nM30\nEND PGM A MM\n"
    )
    np.testing.assert_allclose(bottoms(tmp_path, text, "a.h"), [[4, 5, -4], [6, 5, -4]], atol=1e-9)
    (region,) = regions(tmp_path, text, "a.h")
    assert region.tool == 0 and np.isclose(region.position[region.move == Move.RAPID][-1, 2], 0.021)
    refused(tmp_path, text.replace("Z+0 FMAX M8", "Z+1 FMAX"), "b.h", 6, "another Z than 0")
    refused(tmp_path, text.replace("M30", 'TOOL CALL "B" Z S9\nM30'), "c.h", 2, "several tools by their names")


def test_what_oriaxes_means_is_said(tmp_path: Path) -> None:
    (tmp_path / "a.mpf").write_text(SIEMENS + UP + "TRAORI\nORIWKS ORIAXES\nG0 A3=0 B3=0 C3=1 X0 Y0 Z9\nG1 Z0\nM30\n")
    (said,) = [f for f in read_toolpath(tmp_path / "a.mpf").findings if "ORIAXES" in f.text]
    assert "great arc" in said.text and said.line == 9
