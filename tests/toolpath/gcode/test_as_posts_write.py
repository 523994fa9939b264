"""What posts for real machines write, and was refused: ends worked out by hand from the controls' rules.

Siemens, "Job planning" (CYCLE83: FRF, VRT, _DTD; .MPF and .SPF are its files); Heidenhain, "TNC 640 User's Manual, Klartext
Programming" (IC is a step of the axis; L with nothing but M moves nothing); LinuxCNC, "G-Codes" (M67 E- Q- sets an output); a
change of tools takes the tool up along Z, how far only the machine knows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import KR15, posted
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story
from camrob.witness.judge import judge

ISO = "G21 G17 G40 G49 G80 G90\nT1 M6\nG54 G0 X0. Y0. S5000 M3\nG43 H1 Z20.\nG1 Z-1. F100.\nX10. F500.\n"
SIEMENS = "N1 G17 {} G90 G40 G94\nN2 T1 M6\nN3 D1 S2000 M3\nN4 G54 G0 X0 Y0 Z{}\n{}\nN9 M30\n"
KLARTEXT = "BEGIN PGM A MM\nTOOL CALL 1 Z S9000\nM3\n{}L Z+60 R0 FMAX\nM30\nEND PGM A MM\n"
DRILL = "CYCL DEF 200 D Q200=2 Q201=-6 Q206=200 Q202=6 Q210=0 Q203=+0 Q204=50 Q211=0\n"
PLACE = "part_in_base = [0, 0, 200, 0, 0, 0]\n"


def cuts(folder: Path, name: str, text: str, dialect: str | None = None) -> np.ndarray:
    """X, Y, Z (mm) and the axis where each cut ends; both readings understand all of the file, and agree."""
    (folder / name).write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(folder / name, dialect=dialect), read_story(folder / name, dialect=dialect)
    assert story.complete, [gap.text for gap in story.gaps]
    assert not list(differences(toolpath, story))
    rows = [np.hstack([1e3 * r.position, r.axis])[r.move == Move.CUT] for r in toolpath.regions]
    return np.vstack(rows)


@pytest.mark.parametrize("then", ["G0 X0. Y5.\nG43 H2\nG1 Z-2. F80.\n", "X0. Y5. Z-2. F80.\n"])
def test_a_change_straight_out_of_a_cut(tmp_path: Path, then: str) -> None:
    """The way there doesn't lie in the part: the one reading took the rapid for one at the cut's depth."""
    text = ISO + f"T2 M6\nS6000 M3\n{then}X10. F300.\nG0 Z20.\nM30\n"
    if then[0] == "X":  # at a feed, from wherever the machine went: perhaps through the part
        (tmp_path / "a.nc").write_text(text, encoding="utf-8")
        with pytest.raises(ToolpathError, match="where the tool is not known to be"):
            read_toolpath(tmp_path / "a.nc")
        return
    found = cuts(tmp_path, "a.nc", text)
    assert found[:, :3] == pytest.approx(np.array([[0, 0, -1], [10, 0, -1], [0, 5, -2], [10, 5, -2]]))


def test_mazak_says_how_much_it_slows_at_corners(tmp_path: Path) -> None:
    """A percentage behind G61.1 moves nothing, and is no coordinate without a point."""
    found = cuts(
        tmp_path, "a.eia", "O10\n" + ISO.replace("G54 ", "G54\nG61.1,K20\n") + "G61.1 , K 5.\nY5.\nG0 Z20.\nM30\n"
    )
    np.testing.assert_allclose(found[:, :3], [[0, 0, -1], [10, 0, -1], [10, 5, -1]], atol=1e-9)


def test_no_cut_goes_on_from_where_the_change_left_the_tool(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text(ISO + "T2 M6\nS6000 M3\nG1 X0. F80.\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match="Z has no known value"):
        read_toolpath(tmp_path / "a.nc")
    assert not read_story(tmp_path / "a.nc").complete


def test_a_file_is_siemens_by_its_name(tmp_path: Path) -> None:
    found = cuts(tmp_path, "A.MPF", SIEMENS.format("G700", 1, "G1 Z-0.1 F10\nX1"))
    assert found[:, :3] == pytest.approx(25.4 * np.array([[0, 0, -0.1], [1, 0, -0.1]]))


def test_an_output_moves_nothing(tmp_path: Path) -> None:
    (tmp_path / "a.ngc").write_text(ISO + "M67 E0 Q40\nX20.\nG0 Z20.\nM2\n", encoding="utf-8")
    assert 1e3 * read_toolpath(tmp_path / "a.ngc").regions[0].position[-2] == pytest.approx([20, 0, -1])
    assert [gap.text for gap in read_story(tmp_path / "a.ngc").gaps] == ["M67: not known"]


def test_functions_behind_a_cycle_need_no_feed(tmp_path: Path) -> None:
    body = "L X+0 Y+0 Z+50 R0 FMAX\n" + DRILL + "CYCL CALL\nL Z+0 FMAX M91\nL M9\nL M5\n"
    assert cuts(tmp_path, "a.h", KLARTEXT.format(body))[:, 2] == pytest.approx([-6])


def test_a_rotary_axis_goes_on_by_a_step(tmp_path: Path) -> None:
    body = "L B+10 C+0 FMAX\nM128\nL X+0 Y+0 Z+60 R0 FMAX\nL Z-1 F300\nL X+10 IC+30\nL IC+20 IB-10\nL Z+20\nM129\n"
    found = cuts(tmp_path, "a.h", KLARTEXT.format(body), "gcode-xyzbc-iso")
    tilt, turn = np.radians(10.0), np.radians(30.0)
    axis = [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)]
    assert np.abs(found - [10, 0, -1, *axis]).max(axis=1).min() < 1e-9
    assert found[-1] == pytest.approx(np.array([10, 0, 20, 0, 0, 1]), abs=1e-9)


def test_axes_that_turn_much_on_a_short_way_leave_the_great_arc(tmp_path: Path) -> None:
    """The witness looked for the place by the axis alone, and refused right programs as errors of camrob's."""
    body = "N5 G0 A10 C10\nN6 TRAORI\nN7 G0 X5 Y0 Z60\nN8 G1 Z-1 F300\nY5 A15 C=DC(340) F800\nZ20\nTRAFOOF"
    posted(tmp_path, "a.mpf", SIEMENS.format("G71", 60, body), setup=PLACE, dialect="gcode-xyzac-iso")


def test_m126_turns_the_shorter_way_round(tmp_path: Path) -> None:
    """From 350 to 10 degrees are 20, and 340 without it: the tool swept the long way."""
    body = "L A+10 C+350 FMAX\n{}M128\nL X+0 Y+0 FMAX\nL Z-1 F300\nL X+10 C+10 F900\nL X+12 IC-5\nL Z+20\nM129\n"
    found = cuts(tmp_path, "a.h", KLARTEXT.format(body.format("M126\n")), "gcode-xyzac-iso")
    turns = np.degrees(np.arctan2(found[:, 3], -found[:, 4]))
    assert (
        turns.min() == pytest.approx(-10.0) and turns.max() == pytest.approx(10.0) and turns[-1] == pytest.approx(5.0)
    )
    long = cuts(tmp_path, "b.h", KLARTEXT.format(body.format("")), "gcode-xyzac-iso")
    assert np.degrees(np.arctan2(long[:, 3], -long[:, 4])).max() > 170.0
    body = body.format("M126\n").replace("C+10 F900", "C+170 F900")
    (tmp_path / "c.h").write_text(KLARTEXT.format(body), encoding="utf-8")
    with pytest.raises(ToolpathError, match="half a turn wide"):
        read_toolpath(tmp_path / "c.h", dialect="gcode-xyzac-iso")
    assert "either way" in read_story(tmp_path / "c.h", dialect="gcode-xyzac-iso").gaps[0].text


REFUSED = {
    "L10 P3": "no use for it",  # Siemens' subprogram, in a file that shows nothing of Siemens'
    "P5000": "no use for it",
    "G1 X15. L3": "no use for it",
    "G43 H2": "how its lengths lie",
    "H2": "how its lengths lie",
    "G10 L10 P1 R5.": "the length in use",
    "G43 H0": "how its lengths lie",
    "G55": "several work offsets",
    "%": "ends at this %",
    "G22 X0. Y0. Z-9. I50. J50. K9.": "fence the working area",
    "G22 X15. Y5.": "fence the working area",  # was read as a cut
    "G25 X5. Y5.": "fence the working area",
}


@pytest.mark.parametrize("block", REFUSED)
def test_what_was_passed_over_or_cut_is_refused(tmp_path: Path, block: str) -> None:
    (tmp_path / "a.nc").write_text(ISO + block + "\nX20.\nG0 Z20.\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=REFUSED[block]):
        read_toolpath(tmp_path / "a.nc")
    assert block == "%" or read_story(tmp_path / "a.nc").gaps  # it reads up to the %


@pytest.mark.parametrize(
    ("word", "fine"), [("D1", True), ("D0", False), ("D2", False), ("SUPA G0 Z0 D0\nG0 X0 Y0 D1\nG0 Z-1\nG1", True)]
)
def test_an_edge_of_the_tool_has_its_own_length(tmp_path: Path, word: str, fine: bool) -> None:
    """Siemens: D0 puts the length out of force, D2 is another edge's; both were passed over."""
    text = SIEMENS.format("G71", 20, f"G1 Z-1 F100\nX10\n{word}\nX20")
    if fine:
        assert cuts(tmp_path, "a.mpf", text)[-1, :3] == pytest.approx([20, 0, -1])
        return
    (tmp_path / "a.mpf").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match="how its lengths lie"):
        read_toolpath(tmp_path / "a.mpf")
    assert any("lengths" in gap.text for gap in read_story(tmp_path / "a.mpf").gaps)


def test_each_tool_has_its_own_length(tmp_path: Path) -> None:
    change = "G0 Z20.\nT2 M6\nG43 H2 Z20.\nG1 Z-2.\nX0.\nG0 Z20.\nT1 M6\nG43 H1 Z20.\nG1 Z-3.\n"
    assert cuts(tmp_path, "a.nc", ISO + change + "G0 Z20.\nM30\n")[-1, :3] == pytest.approx([0, 0, -3])


def test_half_a_turn_in_a_cut_may_go_either_way(tmp_path: Path) -> None:
    """Fanuc's parameter 1008: a rotary axis that rolls over goes the shorter way from 350 to 10 degrees."""
    text = ISO.replace("G43 H1 Z20.", "G0 A10. C350.\nG43.4 H1 X0. Y0. Z20.") + "X15. C10.\nG0 Z20.\nG49\nM30\n"
    (tmp_path / "a.nc").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match="rolls over"):
        read_toolpath(tmp_path / "a.nc", dialect="gcode-xyzac-iso")
    assert "half a turn" in read_story(tmp_path / "a.nc", dialect="gcode-xyzac-iso").gaps[0].text
    found = cuts(tmp_path, "b.nc", text.replace("C10.", "C370."), "gcode-xyzac-iso")
    assert np.degrees(np.arctan2(found[:, 3], -found[:, 4])) == pytest.approx([-10.0, -10.0, 10.0])


def test_a_rapid_high_above_the_part_before_a_tilted_plane(tmp_path: Path) -> None:
    """It leads to no cut with the tool upright: that the program comes in below it was refused as an error of camrob's."""
    plane = "G0 Z120.\nG68.2 X0. Y0. Z0. I0. J20. K0.\nG53.1\nG0 X0. Y0. Z30.\nG1 Z-1. F100.\nX5.\nG0 Z30.\nG69\nM30\n"
    posted(tmp_path, "a.nc", ISO.partition("G1 Z")[0] + plane, setup=PLACE)


@pytest.mark.parametrize(
    ("cycle", "heights", "dwell"),
    [
        ("CYCLE83(30,0,1,-10,,-4,,0,0,0,1,0)", [-4, -3, -8, -7, -10], 0.0),
        ("CYCLE83(30,0,1,-10,,-4,,1,0,0,0.5,0,,,0.4,0.7)", [-4, -3.6, -7, -6.6, -9, -8.6, -10], 0.7),
        ("CYCLE83(30,0,1,-10,,,4,0,0,0,50,1,,,,,2)", [-4, 1, -2, -8, 1, -6, -10], 0.0),
    ],
)
def test_deep_holes_are_judged_whole(tmp_path: Path, cycle: str, heights: list[float], dwell: float) -> None:
    made = posted(tmp_path, "a.mpf", SIEMENS.format("G71", 30, f"F120\n{cycle}"), setup=PLACE)
    assert not any("part" in warning.code for warning in made.summary.warnings)
    program = next(made.out.glob("*.src"))
    text = program.read_text(encoding="ascii")
    assert (f"WAIT SEC {dwell:.1f}" in text) == bool(dwell)
    down = [float(row.split("Z ")[1].split(",")[0]) - 200.0 for row in text.split("\n") if row.startswith("LIN")]
    first = down.index(1.0) + 1
    assert down[first : first + len(heights)] == pytest.approx(heights, abs=1e-3)
    if "0.5" in cycle:  # the first bite at half the feed, and no faster
        assert text.count("$VEL.CP = 0.001000") == 1
        program.write_text(text.replace("$VEL.CP = 0.001000", "$VEL.CP = 0.002000"), encoding="ascii")
        found = judge(program, KR15, clfile=tmp_path / "in" / "a.mpf").objections
        assert "feed-higher" in {objection.code for objection in found}
