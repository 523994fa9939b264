"""Heidenhain's parameters: those of cycles are the program's own, and QL and QR beside Q, in tool calls and repeats, too; and
datum shifts as posts and people write them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story

HOLE = "CYCL DEF 200 A Q200=1 Q201=-10 Q206=100 Q202=20 Q210=0 Q203=0 Q204=9\n"
OVER = "TOOL CALL 4 Z S2000 F200\nL X+0 Y+0 Z+20 R0 FMAX M3\n"


def _both(tmp_path: Path, text: str) -> Toolpath:
    """The program as camrob reads it, held to the witness's reading."""
    (tmp_path / "a.h").write_text(f"BEGIN PGM A MM\n{text}L Z+50 FMAX\nM30\nEND PGM A MM\n", encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))
    return toolpath


def _cuts(toolpath: Toolpath) -> list[list[float]]:
    ends = [region.position[region.move == Move.CUT] for region in toolpath.regions]
    return np.round(np.concatenate(ends) * 1e3, 6).tolist()


@pytest.mark.parametrize(
    ("between", "depth"),
    [
        ("Q201 = -18\n", -18.0),  # directly: holds (TNC 640, "Machining Cycles", 2.1)
        ("FN 0: Q203 = +4\n", -6.0),
        ("Q5 = -18\n", -10.0),  # by which it was defined: does not
    ],
)
def test_what_a_cycle_s_parameter_is_given_holds_from_the_next_call_on(
    tmp_path: Path, between: str, depth: float
) -> None:
    defined = "Q5 = -10\n" + HOLE.replace("Q201=-10", "Q201=Q5")
    cuts = _cuts(_both(tmp_path, OVER + defined + "L X+0 FMAX M99\n" + between + "L X+20 Y+0 FMAX M99\n"))
    assert cuts[0] == [0.0, 0.0, -10.0] and cuts[-1] == [20.0, 0.0, depth]


def test_a_cycle_s_parameter_is_read_by_the_program(tmp_path: Path) -> None:
    cuts = _cuts(_both(tmp_path, OVER + "Q203 = 7\n" + HOLE + "L Z+Q203 F99\n"))
    assert cuts == [[0.0, 0.0, 0.0]]


def test_a_depth_that_makes_no_hole_is_refused_where_it_is_given(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text("BEGIN PGM A MM\n" + OVER + HOLE + "Q201 = 5\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=r"a\.h:5: cycle 200 with a depth"):
        read_toolpath(tmp_path / "a.h")


def test_parameters_that_are_the_program_s_own_or_kept(tmp_path: Path) -> None:
    text = "QL1 = 30\nQR2 = QL1 + 500\nQ7 = 2\n" + OVER + "L Z-1 FQR2\nLBL 1\nL IX+QL1\nCALL LBL 1 REP Q7\n"
    toolpath = _both(tmp_path, text)
    assert _cuts(toolpath)[1:] == [[30.0, 0.0, -1.0], [60.0, 0.0, -1.0], [90.0, 0.0, -1.0]]
    assert {round(f * 6e4, 6) for r in toolpath.regions for f in r.feed[r.move == Move.CUT]} == {530.0}


def test_speed_and_feed_of_a_tool_call_by_parameters(tmp_path: Path) -> None:
    (region,) = _both(tmp_path, "Q1 = 3000\nQL2 = 500\nTOOL CALL 4 Z S+Q1 FQL2\nL X0 Y0 Z9 FMAX M3\nL X5\n").regions
    assert [e.value for e in region.events if e.kind.name == "SPINDLE_ON"] == [3000.0]
    assert region.feed[-2] * 6e4 == pytest.approx(500.0)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("L X+QR20 Y+0 FMAX\n", "QR20 is read and the program has given it no value"),
        ("QL500 = 1\n", "no control has"),
        ("Q5 = 1\nTOOL CALL 4 Z S9 DL+Q5\n", r"DL\+Q5: an offset"),
        ("TOOL CALL 4 Z S9 W5\n", "is not read"),
        ("FN 18: SYSREAD Q1 = ID270 NR1 IDX3\n", "asks for what the control holds"),
        ('ERROR = 13 TOOL CALL "A" Z S50\n', "could not read"),
    ],
)
def test_what_the_file_does_not_say_is_refused(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "a.h").write_text("BEGIN PGM A MM\n" + text + OVER + "L X5 F9\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=why):
        read_toolpath(tmp_path / "a.h")


@pytest.mark.parametrize(
    ("shift", "end"),
    [
        (
            "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1  X + 10\nCYCL DEF 7.2  Y - 5\n",
            "CYCL DEF 7.0\nCYCL DEF 7.1 X0\nCYCL DEF 7.2 Y0\n",
        ),
        ("TRANS DATUM AXIS X+10 Y-5\n", "TRANS DATUM RESET\n"),
        ("TRANS DATUM AXIS X+4\nTRANS DATUM AXIS IX+6 Y-5\n", "TRANS DATUM RESET\n"),
    ],
)
def test_a_datum_shift(tmp_path: Path, shift: str, end: str) -> None:
    """Blanks beside signs, which were passed over with their shift, and the newer words for it."""
    text = (
        OVER + shift + "L X + 0 Y + 0 FMAX\nL Z + 0 F500\nL X + 20\nL Z+9 FMAX\n" + end + "L X+0 Y+0 FMAX\nL Z-1 F500\n"
    )
    assert _cuts(_both(tmp_path, text)) == [[10.0, -5.0, 0.0], [30.0, -5.0, 0.0], [0.0, 0.0, -1.0]]


def test_a_radius_in_steps(tmp_path: Path) -> None:
    cuts = _cuts(_both(tmp_path, OVER + "CC X+10 Y+0\nL Z+0 F500\nLP IPR+5 PA+90\n"))
    assert cuts[-1] == [10.0, 15.0, 0.0]


def test_a_shift_that_can_t_be_read_is_not_passed_over(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text("BEGIN PGM A MM\n" + OVER + "CYCL DEF 7.1 X=10\nL X5 F9\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=r"a\.h:4: a datum shift by 'X=10'"):
        read_toolpath(tmp_path / "a.h")
