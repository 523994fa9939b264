"""Frames that programs set for themselves, by camrob and by the witness, against places worked out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

ISO = "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0. Y0. Z20.\nF60.\n"
SIEMENS = "%_N_A_MPF\nG90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X=0 Y0 Z20\nF60\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S5000 F60\n2 L X+0 Y+0 Z+20 R0 FMAX M3\n"
APT = "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nFEDRAT/300,MMPM\nRAPID\nGOTO/0,0,20\n"
HALF = 0.5**0.5


def ends(folder: Path, name: str, text: str) -> list[list[float]]:
    """Where cuts end, mm, once the two readings are one; of arcs their ends too, among their chords."""
    file = folder / name
    file.write_text(text)
    path, story = read_toolpath(file, chord_tolerance=1e-5), read_story(file)
    assert story.complete, story.gaps
    assert differences(path, story) == []
    cut = [region.position[region.move == Move.CUT] * 1e3 for region in path.regions]
    return (np.concatenate(cut).round(6) + 0.0).tolist()


def holds(found: list[list[float]], *wanted: tuple[float, float, float]) -> None:
    """These places are on the way, in their order."""
    at = 0
    for place in wanted:
        at = next((i + 1 for i in range(at, len(found)) if np.allclose(found[i], place, atol=1e-5)), 0)
        assert at, (place, found)


def refused(folder: Path, name: str, text: str, match: str) -> None:
    file = folder / name
    file.write_text(text)
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(file)


# -- Fanuc and alike


def test_g68_turns_about_the_point_that_it_names(tmp_path: Path) -> None:
    # (14, 5) is 4 mm along X from the centre (10, 5): 4 mm along Y of it, turned by 90 degrees; the arc to its left
    body = "G68 X10. Y5. R90.\nG1 X14. Y5. Z0.\nG3 X10. Y9. I-4.\nG69\nG1 X0. Y0.\nM30\n"
    holds(ends(tmp_path, "a.nc", ISO + body), (10, 9, 0), (6, 5, 0), (0, 0, 0))
    # without X and Y, about where the tool stands
    body = "G1 X10. Y5. Z0.\nG68 R-90.\nX14. Y5.\nG69\nZ5.\nX0. Y0.\nM30\n"
    holds(ends(tmp_path, "b.nc", ISO + body), (10, 5, 0), (10, 1, 0), (10, 1, 5), (0, 0, 5))


def test_a_mirror_turns_arcs_the_other_way(tmp_path: Path) -> None:
    # at X = 10: 16 becomes 4; G3 about (12, 0), mirrored (8, 0), runs clockwise, from (4, 0) over (8, 4)
    body = "G51.1 X10.\nG1 X16. Y0. Z0.\nG3 X12. Y4. I-4.\nG51.1 Y1.\nX12. Y4.\nG50.1 X0. Y0.\nX0. Y0.\nM30\n"
    found = ends(
        tmp_path,
        "a.nc",
        ISO + body.replace("G51.1 Y1.\nX12.", "G51.1 Y1.\nG1 X12.").replace("X0. Y0.\nX0", "X0. Y0.\nG1 X0"),
    )
    holds(found, (4, 0, 0), (8, 4, 0), (8, -2, 0), (0, 0, 0))
    middle = np.array([8.0, 0.0]) + 4.0 * np.array([-HALF, HALF])
    assert min(np.linalg.norm(np.array(found)[:, :2] - middle, axis=1)) < 0.1


def test_g51_scales_about_a_point(tmp_path: Path) -> None:
    body = "G51 X10. Y0. Z0. P2.\nG1 X12. Y1. Z-1.\nG2 X14. Y-1. R2.\nG50\nG1 X0. Y0. Z0.\nM30\n"
    holds(ends(tmp_path, "a.nc", ISO + body), (14, 2, -2), (18, -2, -2), (0, 0, 0))


def test_home_behind_a_turned_frame(tmp_path: Path) -> None:
    body = "G68 X0. Y0. R90.\nG1 X5. Y0. Z0.\nG69\nG0 Z20.\nG91 G28 Z0.\nG91 G28 X0. Y0.\nG90 G0 X3. Y3. Z20.\nG1 Z0.\nM30\n"
    holds(ends(tmp_path, "a.nc", ISO + body), (0, 5, 0), (3, 3, 0))


def test_holes_in_a_turned_frame(tmp_path: Path) -> None:
    body = "G68 X0. Y0. R90.\nG0 X5. Y0.\nG99 G81 X5. Y0. Z-3. R2. F60.\nX9.\nG80\nG69\nG0 X0. Y0. Z20.\nM30\n"
    holds(ends(tmp_path, "a.nc", ISO + body), (0, 5, -3), (0, 9, -3))


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("G68 X0. Y0. R30.\nG1 X5. Z0.", "has not X and Y"),
        ("G68 X0. Y0. R30.\nG91 G1 X5. Y0.", "has not X and Y"),
        ("G68 X0. Y0.", "without its angle"),
        ("G68 X0. Y0. Z0. I0. J1. K0. R30.", "in space"),
        ("G91 G68 X0. Y0. R30.", "incremental"),
        ("G18 G68 X0. Z0. R30.", "another plane"),
        ("G51.1 X0.\nG68 X0. Y0. R30.", "on top of G51.1"),
        ("G68 X0. Y0. R30.\nG52 X5.", "G52 in a turned"),
        ("G51.1 Z0.", "mirroring of another axis"),
        ("G51 X0. Y0. P2", "without decimal point"),
        ("G51 X0. Y0. P2.\nG99 G81 X5. Y0. Z-3. R2.", "while scaling is on"),
        ("G68 X0. Y0. R30.\nG43.4 H1", "centre point switched on"),
        ("G68 X0. Y0. R30.\nG68.2 X0. Y0. Z0. I0. J10. K0.", "inside another frame"),
        ("G51.1 X5.\nG50.1", "without the axes"),
    ],
)
def test_frames_of_fanucs_that_are_refused(tmp_path: Path, body: str, match: str) -> None:
    refused(tmp_path, "a.nc", ISO + body + "\nG1 X1. Y1. Z0.\nM30\n", match)


# -- Siemens


def test_mirror_and_scale_of_siemens(tmp_path: Path) -> None:
    body = (
        "TRANS X20\nAMIRROR X0\nG1 X5 Y0 Z0\nG3 X0 Y5 I-5 J0\nMIRROR Y0\nG1 X3 Y4\nMIRROR\nX3 Y4\n"
        "SCALE X2 Y2\nX3 Y4 Z1\nASCALE Z3\nX1 Y1 Z2\nSCALE\nX1 Y1 Z1\nM30\n"
    )
    holds(
        ends(tmp_path, "a.mpf", SIEMENS + body),
        (15, 0, 0),
        (20, 5, 0),
        (3, -4, 0),
        (3, 4, 0),
        (6, 8, 1),
        (2, 2, 6),
        (1, 1, 1),
    )


def test_frames_within_a_swivelled_plane(tmp_path: Path) -> None:
    # the plane's X is the part's -Z, its Z the part's X; within it 2 along its X, then turned by 90 degrees
    body = (
        'G0 Z100\nCYCLE800(0,"T",100000,57,0,0,50,0,90,0,0,0,0,-1)\nATRANS X2\nAROT RPL=90\nG0 X0 Y0 Z10\nG1 Z0\nX4 Y0\n'
        "G1 X=IC(1) Y=IC(1)\nG0 Z10\nROT\nM30\n"
    )
    text = SIEMENS + body.replace("ROT\nM30", "M30")
    holds(ends(tmp_path, "a.mpf", text), (0, 0, 48), (0, 4, 48), (0, 5, 49))
    refused(tmp_path, "b.mpf", text.replace("ATRANS", "TRANS"), "TRANS on top of CYCLE800")


def test_the_part_s_own_plane_is_no_plane(tmp_path: Path) -> None:
    body = (
        'CYCLE800(0,"T",100000,57,0,0,0,0,20,0,0,0,0,-1)\nG0 X0 Y0 Z10\nCYCLE800(0,"T",100000,57,0,0,0,0,0,0,0,0,0,-1)\n'
        "TRAORI\nG0 X0 Y0 Z10 A3=0 B3=0 C3=1\nG1 Z1\nM30\n"
    )
    assert ends(tmp_path, "a.mpf", SIEMENS + body) == [[0, 0, 1]]
    ended = SIEMENS + body.replace('CYCLE800(0,"T",100000,57,0,0,0,0,0,0,0,0,0,-1)\nTRAORI', "CYCLE800()")
    refused(tmp_path, "b.mpf", ended.replace(" A3=0 B3=0 C3=1", ""), "only the control knows")
    named = ended.replace("CYCLE800()", "CYCLE800()\nG0 A0 C0").replace(" A3=0 B3=0 C3=1", "")
    assert ends(tmp_path, "c.mpf", named) == [[0, 0, 1]]


# -- Heidenhain


def test_cycles_8_and_10_about_the_shifted_datum(tmp_path: Path) -> None:
    body = (
        "3 CYCL DEF 7.0\n4 CYCL DEF 7.1 X+20\n5 CYCL DEF 7.2 Y+10\n6 CYCL DEF 8.0\n7 CYCL DEF 8.1 X\n8 L X+5 Y+0 FMAX\n9 L Z+0\n"
        "10 CC X+0 Y+0\n11 C X+0 Y+5 DR+\n12 CYCL DEF 8.0\n13 CYCL DEF 8.1\n14 CYCL DEF 10.0\n15 CYCL DEF 10.1 ROT+90\n"
        "16 L X+5 Y+0\n17 CYCL DEF 10.1 IROT+90\n18 L X+5 Y+0\n19 CYCL DEF 10.1 ROT+0\n20 CYCL DEF 7.1 X+0\n21 CYCL DEF 7.2 Y+0\n"
        "22 L X+1 Y+2\n23 M30\n24 END PGM A MM\n"
    )
    holds(ends(tmp_path, "a.h", KLARTEXT + body), (15, 10, 0), (20, 15, 0), (15, 10, 0), (1, 2, 0))


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("CYCL DEF 8.1 X\nCYCL DEF 10.1 ROT+30", "at once"),
        ("CYCL DEF 8.1 Z", "another axis than X and Y"),
        ("CYCL DEF 11.1 SCL 0.5", "11.1 SCL 0.5 is not read"),
        ("CYCL DEF 10.1 ROT+30\nCYCL DEF 7.1 X+5", "in a mirrored or turned frame"),
        ("CYCL DEF 10.1 ROT+30\nPLANE SPATIAL SPA+0 SPB+10 SPC+0 TURN FMAX", "PLANE while cycle 8 or 10"),
        ("CYCL DEF 10.1 ROT+30\nL X+5", "has not X and Y"),
        ("CYCL DEF 10.1 ROT+30\nL IX+5 IY+1", "IX from a place that is not known"),
        ("CYCL DEF 8.1 X\nM128", "centre point switched on"),
    ],
)
def test_frames_of_heidenhains_that_are_refused(tmp_path: Path, body: str, match: str) -> None:
    refused(tmp_path, "a.h", KLARTEXT + body + "\nL X+1 Y+1 Z+0\nM30\nEND PGM A MM\n", match)


# -- CL data


def test_trans_behind_motions_moves_what_follows(tmp_path: Path) -> None:
    body = (
        "GOTO/1,2,0\nRAPID\nGOTO/0,0,20\nTRANS/10,0,-1\nGOTO/1,2,0\nTRANS/OFF\nTRANS/0,5,0\nGOTO/1,2,0\nTRANS/NOMORE\n"
        "GOTO/1,2,0\nFINI\n"
    )
    assert ends(tmp_path, "a.apt", APT + body) == [[1, 2, 0], [11, 2, -1], [1, 7, 0], [1, 2, 0]]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (APT.replace("RAPID", "TRANS/1,2,3\nRAPID") + "GOTO/0,0,0\nFINI\n", "before the first motion"),
        (APT + "GOTO/0,0,0\nTRANS/1,2,3,LAST\nFINI\n", "other than by x, y, z"),
        (APT + "GOTO/0,0,0\nTRANS/5\nFINI\n", "other than by x, y, z"),
        (APT + "GOTO/0,0,0\nTRANS/5,0,0\nTRANS/0,0,0\nFINI\n", "TRANS behind TRANS"),
        (APT + "GOTO/0,0,0\nTRANS/1,2,3\nTRACUT/1,0,0,5,0,1,0,0,0,0,1,0\nFINI\n", "TRACUT in a frame"),
    ],
)
def test_trans_that_is_refused(tmp_path: Path, text: str, match: str) -> None:
    refused(tmp_path, "a.apt", text, match)


# -- Heidenhain's planes that leave the tool to a motion of its own, and the machine's own datums


def test_a_plane_that_stays_and_the_motion_that_turns_the_tool(tmp_path: Path) -> None:
    # the plane's X is the part's -Z, its Z the part's X
    body = (
        "3 L Z+100 FMAX\n4 CYCL DEF 7.0\n5 CYCL DEF 7.1 X+10\n6 PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\n7 L B+Q121 C+Q122 FMAX\n"
        "8 L X+0 Y+0 Z+20 FMAX\n9 L Z+5\n10 L X+3\n11 L Z+20 FMAX\n12 PLANE RESET STAY\n13 L Z+300 FMAX M91\n14 L B+0 C+0 FMAX\n"
        "15 CYCL DEF 7.0\n16 CYCL DEF 7.1 X+0\n17 L X+1 Y+2 Z+9 FMAX\n18 L Z+0\n19 M30\n20 END PGM A MM\n"
    )
    holds(ends(tmp_path, "a.h", KLARTEXT + body), (15, 0, 0), (15, 0, -3), (1, 2, 0))
    refused(tmp_path, "b.h", KLARTEXT + body.replace("7 L B+Q121 C+Q122 FMAX\n", ""), "not turned onto it")


def test_another_datum_of_the_table_is_refused(tmp_path: Path) -> None:
    body = "3 L X+1 Y+1 Z+0\n4 CYCL DEF 247 Q339=2\n5 L X+2\n6 M30\n7 END PGM A MM\n"
    first = KLARTEXT.replace("2 L", "2 CYCL DEF 247 Q339=2\n2 L")
    assert ends(tmp_path, "a.h", first + body) == [[1, 1, 0], [2, 1, 0]]
    refused(tmp_path, "b.h", first + body.replace("Q339=2", "Q339=3"), "another datum")
    refused(tmp_path, "c.h", KLARTEXT + body, "another datum")


def test_a_working_plane_that_turns_nothing(tmp_path: Path) -> None:
    body = (
        "3 CYCL DEF 19.0 WORKING PLANE\n4 CYCL DEF 19.1 A+0 B+0.0 C-0\n5 CYCL DEF 19.1\n6 L X+1 Y+1 Z+0\n7 STOP M30\n"
        "8 L X+2 Y+2\n9 END PGM A MM\n"
    )
    assert ends(tmp_path, "a.h", KLARTEXT + body) == [[1, 1, 0]]
    refused(tmp_path, "b.h", KLARTEXT + body.replace("B+0.0", "B+0.5"), "CYCL DEF 19 with angles")
