"""Words that programs of other people hold every day, and that were refused for no reason of theirs, or read wrongly.

Ends are worked out by hand from the makers' rules: Heidenhain, "TNC 640 User's Manual, Klartext Programming", 5.2 (F, FU, FZ),
and "Machining Cycles" (M99: where the block ends); Siemens, "Programming Manual Fundamentals" (G74, G75), "Job planning"
(CYCLE800 without parameters ends its frames); Fanuc B-63944EN (at power-up G0 or G1, by a
parameter; G1 without a feed is an alarm).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000 F400\n2 L Z+50 R0 FMAX M3\n3 L X+0 Y+0 FMAX\n"
DRILL = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-10 ~\n Q206={} ~\n Q202=10 ~\n Q210=0 ~\n Q203=+0 ~\n Q204=20 ~\n Q211=0\n"
END = "L Z+50 FMAX\nM30\nEND PGM A MM\n"
SIEMENS = "G90 G17 G710 G94\nT1 M6\nS5000 M3\n"


def rows(folder: Path, name: str, text: str) -> list[list[float]]:
    """X, Y, Z (mm) and feed (mm/min; 0 in rapid) of all points; the witness has to read all of the file, too."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    found = [
        [*(1e3 * tip).round(6), 0.0 if move == Move.RAPID else round(float(feed) * 6e4, 6)]
        for region in read_toolpath(file).regions
        for tip, feed, move in zip(region.position, region.feed, region.move, strict=True)
    ]
    assert read_story(file).complete, [gap.text for gap in read_story(file).gaps]
    return found


def refused(folder: Path, name: str, text: str, match: str) -> None:
    (folder / name).write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(folder / name)


# -- Heidenhain


@pytest.mark.parametrize("there", ["LP PR+10 PA+90 FMAX M99", "CC X+0 Y+10\nLP PR+0 PA+0 FMAX M99", "L Y+10 FMAX\nM99"])
def test_m99_drills_where_its_block_ends(tmp_path: Path, there: str) -> None:
    """Polar blocks and M99 by itself drilled nothing: a hole less, of which nobody was told."""
    found = rows(tmp_path, "a.h", KLARTEXT + DRILL.format("150") + f"CC X+0 Y+0\n{there}\n" + END)
    assert found[-5:] == [[0, 10, 50, 0], [0, 10, 2, 0], [0, 10, -10, 150], [0, 10, 20, 0], [0, 10, 50, 0]]


def test_m99_behind_an_arc(tmp_path: Path) -> None:
    body = "L X+10 Y+0 Z+2 FMAX\nCC X+0 Y+0\nC X+0 Y+10 DR+ F300 M99\n"
    found = rows(tmp_path, "a.h", KLARTEXT + DRILL.format("150") + body + END)
    assert found[-4:] == [[0, 10, 2, 300], [0, 10, -10, 150], [0, 10, 20, 0], [0, 10, 50, 0]]


@pytest.mark.parametrize(
    "motion", ["LP PR+10 PA+0 FMAX", "CP IPA+90 DR+ F100", "C X+0 Y+1 DR+ F100", "CR X+9 R+9 DR+ F100"]
)
def test_machine_positions_are_no_place_for_arcs(tmp_path: Path, motion: str) -> None:
    refused(tmp_path, "a.h", KLARTEXT + f"L X+1 Z+0 F100\nCC X+0 Y+0\n{motion} M91\n" + END, "M91 or M92")


def test_feeds_of_cycles_and_per_turn(tmp_path: Path) -> None:
    """FAUTO: TOOL CALL's 400. FU0.1 at 2000 rev/min: 200 mm/min, and modal."""
    body = DRILL.format("FAUTO") + "L X+5 FMAX M99\nL Z+0 F500\nL X+9 FU0.1\nL X+12\nL X+15 F AUTO\n"
    found = rows(tmp_path, "a.h", KLARTEXT + body + END)
    cuts = [row for row in found if row[3]]
    assert cuts == [[5, 0, -10, 400], [5, 0, 0, 500], [9, 0, 0, 200], [12, 0, 0, 200], [15, 0, 0, 400]]


def test_a_drill_that_comes_out_in_rapid(tmp_path: Path) -> None:
    cycle = (
        "CYCL DEF 201 REAMING ~\n Q200=2 ~\n Q201=-10 ~\n Q206=FAUTO ~\n Q211=0 ~\n Q208=FMAX ~\n Q203=+0 ~\n Q204=20\n"
    )
    found = rows(tmp_path, "a.h", KLARTEXT + cycle + "L X+5 FMAX M99\n" + END)
    assert found[-5:-1] == [[5, 0, 2, 0], [5, 0, -10, 400], [5, 0, 2, 0], [5, 0, 20, 0]]


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("L Z+0 FZ0.05\n", "FZ, a feed per tooth"),
        ("TOOL CALL 2 Z S2000 FZ0.05\nL Z+50 FMAX\n", "TOOL CALL with FZ"),
        ("TOOL CALL 2 Z S2000 FU0.1\nL Z+50 FMAX\n", "TOOL CALL with FU"),
        ("L Z+0 FU0.1\nTOOL CALL S3000\nL X+5\n", "behind another speed"),
        ("CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 B+30\n", "a machine parameter says"),
    ],
)
def test_feeds_and_planes_that_only_the_machine_knows(tmp_path: Path, body: str, match: str) -> None:
    refused(tmp_path, "a.h", KLARTEXT + body + "L X+9 F100\n" + END, match)


# -- Siemens


@pytest.mark.parametrize("away", ["G75 Z0 FP=1", "G75 FP=2 X0 Y0 Z0", "G74 Z1=0", "G75 POS=1 Z1=0"])
def test_fixed_points_of_the_machine(tmp_path: Path, away: str) -> None:
    """In rapid to where the machine has them; what was in force before goes on behind it, from places that are named anew."""
    found = rows(tmp_path, "a.mpf", SIEMENS + f"G0 X0 Y0 Z50\nG1 Z-1 F300\n{away}\nG0 X5 Y5 Z50\nG1 Z-2\n{away}\nM30\n")
    assert found == [[0, 0, 50, 0], [0, 0, -1, 300], [5, 5, 50, 0], [5, 5, -2, 300]]
    refused(tmp_path, "b.mpf", SIEMENS + f"G0 X0 Y0 Z50\nG1 Z-1 F300\n{away}\nX5\nM30\n", "has no known value")


def test_cycle800_without_brackets_ends_its_frames(tmp_path: Path) -> None:
    """_A = 30 about X: 2 below the plane is (0, 2 sin 30, -2 cos 30) off its zero (5, 0, 0)."""
    swivel = 'CYCLE800(1,"T",0,57,5,0,0,30,0,0,0,0,0,-1)\nG0 X0 Y0 Z50\nG1 Z-2 F300\nG0 Z50\n'
    body = "CYCLE800\nG54\n" + swivel + "CYCLE800\nG0 A0 C0\nG0 X1 Y2 Z50\nG1 Z3\nCYCLE832\nM30\n"
    cuts = [row for row in rows(tmp_path, "a.mpf", SIEMENS + body) if row[3]]
    np.testing.assert_allclose(cuts, [[5, 1, -np.sqrt(3.0), 300], [1, 2, 3, 300]], atol=1e-6)


@pytest.mark.parametrize(
    ("block", "match"),
    [
        ("G2 AR=90 I5 J0 X5", "AR= without a centre or an end, or with both"),
        ("G1 AP=45", "a polar motion"),
        ("G1 ANG=45 X-20", "a line that doesn't lead to its end"),
    ],
)
def test_words_that_are_refused_by_name(tmp_path: Path, block: str, match: str) -> None:
    refused(tmp_path, "a.mpf", SIEMENS + f"G0 X0 Y0 Z5\nG1 Z0 F300\n{block}\nM30\n", match)


def test_g710_alone_says_whose_program_it_is(tmp_path: Path) -> None:
    text = "G54 G90 G17 G710\nT1 M6\nS8000 M3\nTRAORI(1)\nG0 X0 Y0 Z50 A3=0 B3=0 C3=1\nG1 Z3 F1800\nTRAFOOF\nM30\n"
    assert rows(tmp_path, "a.mpf", text)[-1] == [0, 0, 3, 1800]


# -- Fanuc and alike


def test_a_first_move_without_its_kind(tmp_path: Path) -> None:
    """G0 or, by a parameter, G1, which stops for want of a feed: nothing is cut there."""
    head = "O1\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nS3000 M3\nG43 H1 Z50.\n"
    found = rows(tmp_path, "a.nc", head + "G0 X0 Y0\nG1 Z-1. F200\nM30\n")
    assert found == [[0, 0, 50, 0], [0, 0, -1, 200]]
    said = {finding.code for finding in read_toolpath(tmp_path / "a.nc").findings}
    assert "rapid-by-default" in said
    refused(tmp_path, "b.nc", head.replace("S3000", "F200 S3000") + "G1 X0\nM30\n", "before any of G0")
    refused(
        tmp_path, "c.nc", head.replace("G49 ", "").replace("Z50.", "Z50. F200") + "G1 X0\nM30\n", "before any of G0"
    )


# -- CL data


@pytest.mark.parametrize("tool", ["TOOLNO/1,TURN", "TOOLNO/3,GROOVE,1.0", "TLDATA/TURN,1.0"])
def test_lathes_of_catia_are_known_by_their_tools(tmp_path: Path, tool: str) -> None:
    """Such a file was posted as if its X and Z were those of a mill."""
    text = f"$$ CATIA APT VERSION 1.0\n{tool}\nFEDRAT/0.4,MMPR\nSPINDL/ 2000.0,RPM,CLW\nGOTO / 77, 0, 45\nGOTO / 28, 0, 2\nFINI\n"
    refused(tmp_path, "a.aptsource", text, "a turning operation")
    gaps = [gap.text for gap in read_story(tmp_path / "a.aptsource").gaps]
    assert any("a turning tool" in text for text in gaps), "the witness releases none either"
