"""The witness's reader of G-code, held to numbers worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from cl_stories import happened, mm, ways

from camrob.errors import ToolpathError
from camrob.witness.cl import read_story
from camrob.witness.cl.customs import COMPUTED
from camrob.witness.cl.foreign.computed_values import Values
from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.standing import TURNED
from camrob.witness.cl.teller import UNREAD
from camrob.witness.happenings import Kind, Story, Way


@pytest.fixture
def tell(tmp_path: Path):
    def read(text: str, **options) -> Story:
        path = tmp_path / "a.nc"
        path.write_text(text)
        return read_story(path, **options)

    return read


START = "G21 G90 G17\nG0 X0 Y0 Z50\n"


def test_modal_words_packed_spaced_and_in_lower_case(tell):
    story = tell("%\nO1000 (PART; ONE)\nN10g21g90g0x1.y-.5Z+50\n(X9)N20 G01 Z  2 F600 ; Y9\nX 3\ng0Z50\nM30\nX9\n%")
    assert mm(story) == [[1, -0.5, 50], [1, -0.5, 2], [3, -0.5, 2], [3, -0.5, 50]]
    assert ways(story) == "RFFR" and story.complete and story.path.line.tolist() == [3, 4, 5, 6]
    assert story.feed[1:3].tolist() == [0.01, 0.01] and np.isnan(story.feed[[0, 3]]).all()


def test_only_motions_to_a_place_that_is_known_are_reported(tell):
    story = tell("G0 Z50\nX1 Y2\nG1 Z0 F60\n")
    assert mm(story) == [[1, 2, 50], [1, 2, 0]] and story.joined.tolist() == [False, True]
    assert not tell("G0 Z50\nG1 X1 F60\nY2\nX3\n").complete  # a cut at a Y that is not known


def test_inches_increments_and_feed_modes(tell):
    story = tell("G20 G90\nG0 X1 Y1 Z1\nG91 G1 X1 F10\nY-.5\nG90 X0\nS600 M3\nG95 F.01\nG1 X1\n")
    assert np.allclose(story.path.tip / 0.0254, [[1, 1, 1], [2, 1, 1], [2, 0.5, 1], [0, 0.5, 1], [1, 0.5, 1]])
    assert story.feed[[1, 4]] == pytest.approx([0.254 / 60, 0.000254 * 10]) and story.units == "inch"
    assert tell("G20\nG0 X1 Y1 Z1\n", units="mm").path.tip[0, 0] == 0.001


def test_two_ways_of_moving_in_one_block_are_a_gap(tell):
    assert tell(START + "G1 Z0 F60\nG1 G1 X2\n").complete
    assert tell(START + "G1 Z0 F60\nG80 G1 X2\n").complete
    assert tell(START + "G1 Z0 F60\nG0 G1 X2\n").gaps[0].text == "two ways of moving in one block"


def test_inverse_time(tell):
    """F 2 is half a minute: 30 mm in 30 s are 1 mm/s; half a circle of 10 mm radius in 6 s."""
    story = tell(START + "G93\nG1 X30 F2\nG3 X50 I10 F10\nG94 G1 X0 F60\nG93 G1 X1\nG1 X2 Y0 Z50 F1\n")
    assert story.feed[1] == pytest.approx(0.001) and story.feed[2] == pytest.approx(math.pi * 0.010 / 6)
    assert story.feed[3] == 0.001 and math.isnan(story.feed[4]) and len(story.gaps) == 1


def test_feed_does_not_outlive_its_mode(tell):
    story = tell(START + "G93 G1 X30 F2\nG94 X0\n")
    assert math.isnan(story.feed[2]) and not story.complete


@pytest.mark.parametrize(
    ("block", "center", "normal", "angle"),
    [
        ("G3 X0 Y10 I-10 J0", [0, 0, 0], [0, 0, 1], 90),
        ("G2 X0 Y10 I-10", [0, 0, 0], [0, 0, -1], 270),
        ("G3 X0 Y10 R10", [0, 0, 0], [0, 0, 1], 90),
        ("G3 X0 Y10 R-10", [10, 10, 0], [0, 0, 1], 270),
        ("G2 X0 Y10 R10", [10, 10, 0], [0, 0, -1], 90),
        ("G2 X0 Y10 R-10", [0, 0, 0], [0, 0, -1], 270),
        ("G3 I-10", [0, 0, 0], [0, 0, 1], 360),
        ("G2 X10 Y0 Z5 I-10 P3", [0, 0, 0], [0, 0, -1], 1080),
        ("G3 X-10 Y0 Z4 I-10", [0, 0, 0], [0, 0, 1], 180),
        ("G90.1 G3 X0 Y10 I0 J0", [0, 0, 0], [0, 0, 1], 90),
        ("G18 G3 X0 Z-10 I-10 K0", [0, 0, 0], [0, 1, 0], 90),
        ("G18 G2 X0 Z10 I-10 K0", [0, 0, 0], [0, -1, 0], 90),
        ("G91 G3 X-10 Y10 I-10", [0, 0, 0], [0, 0, 1], 90),
    ],
)
def test_arcs(tell, block, center, normal, angle):
    """From (10, 0, 0). In G18 counter-clockwise is from Z to X, so from X to -Z."""
    story = tell(f"G0 X10 Y0 Z0\nG1 F60\n{block}\n")
    assert story.complete and (story.path.center[1] * 1000).round(6).tolist() == center
    assert story.path.normal[1].tolist() == normal and math.degrees(story.path.angle[1]) == pytest.approx(angle)


def test_an_arc_in_the_plane_of_y_and_z(tell):
    story = tell("G0 X0 Y10 Z0\nG1 F60\nG19 G3 Y0 Z10 J-10 K0\n")
    assert story.path.normal[1].tolist() == [1, 0, 0] and math.degrees(story.path.angle[1]) == pytest.approx(90)


@pytest.mark.parametrize("block", ["G3 X0 Y10 I-9", "G3 X0 Y10 R5", "G3 R5", "G2 X10 Y0 R5"])
def test_arcs_that_are_none(tell, block):
    story = tell(f"G0 X10 Y0 Z0\nG1 F60\n{block}\nG1 X1 Y1\n")
    assert len(story.gaps) == 1 and not story.joined[-1] and np.isnan(story.path.angle).all()


# -- machine positions, frames


def test_g28_leaves_the_part(tell):
    story = tell(START + "G1 Z2 F300\nX20\nG91 G28 Z0\nG90 G0 X26 Y5\nZ5\nG1 Z2\nM30\n")
    assert mm(story) == [[0, 0, 50], [0, 0, 2], [20, 0, 2], [26, 5, 5], [26, 5, 2]]
    assert story.joined.tolist() == [False, True, True, False, True] and story.complete


def test_g28_goes_through_the_point_that_it_names(tell):
    story = tell(START + "G1 Z2 F300\nG28 Z60\nG0 X5 Z60\nG91 G28 X1 Y1 Z1\nG90 G0 X1\nY1\nZ1\n")
    assert mm(story) == [[0, 0, 50], [0, 0, 2], [0, 0, 60], [5, 0, 60], [6, 1, 61], [1, 1, 1]]
    assert ways(story) == "RFRRRR" and story.joined.tolist() == [False, True, True, False, True, False]


@pytest.mark.parametrize("block", ["G53 G0 Z0", "G0 G53 Z-1.5", "G30 Z50", "G28", "G28 G91 Z0"])
def test_other_machine_positions(tell, block):
    story = tell(START + f"{block}\nG90 G0 X7 Y8 Z9\nX1\n")
    assert mm(story) == [[0, 0, 50], [7, 8, 9], [1, 8, 9]] and story.joined.tolist() == [False, False, True]


def test_a_cut_after_a_machine_position_is_a_gap(tell):
    story = tell(START + "G53 G0 Z0\nG1 X5 F60\nZ5\n")
    assert mm(story) == [[0, 0, 50], [5, 0, 5]] and [(g.before, g.first_line) for g in story.gaps] == [(1, 4)]


def test_one_work_frame(tell):
    story = tell("G0 Z9\nG55 G0 X0 Y0\nZ0\nG55 X1\n")
    assert story.complete and mm(story) == [[0, 0, 0], [1, 0, 0]]  # Z9 was of G54
    for first in ("G54 ", ""):  # G54 is in force where none is named
        story = tell(f"{first}G0 X0 Y0 Z0\nG55 X1\nY2 Z2\nG54 X3\nX3 Y3 Z3\n")
        assert mm(story) == [[0, 0, 0], [3, 3, 3]] and story.joined.tolist() == [False, False]
        assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(1, 2, 3)]


@pytest.mark.parametrize(
    ("on", "off"),
    [("G68 X0 Y0", "G69"), ("G51 P2", "G50"), ("G51.1 Z0", "G50.1"), ("G92 A5", "G92.1"), ("G68.2 X1 Q123", "G69")],
)
def test_frames_that_are_moved_hide_what_lies_in_them(tell, on, off):
    story = tell(START + f"{on}\nG1 X1 Y1 Z1 F60\nX2\n{off}\nG0 X3 Y3 Z3\n")
    assert mm(story) == [[0, 0, 50], [3, 3, 3]] and story.joined.tolist() == [False, False]
    assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(1, 3, 5)]


def test_a_shift_by_g52(tell):
    story = tell(START + "G52 X100 Y7\nG1 X1 F60\nG52 X0\nX2\nY2\nG91 X1\nG90 G52 Y0\nX5 Y0\n")
    assert story.complete and story.joined.tolist()[1:] == [True] * 5
    assert mm(story) == [[0, 0, 50], [101, 0, 50], [2, 0, 50], [2, 9, 50], [3, 9, 50], [5, 0, 50]]
    inch = tell("G20 G0 X0 Y0 Z2\nG52 Z1\nG1 Z0.5 F5\n")
    assert mm(inch)[1] == pytest.approx([0, 0, 38.1])


def test_the_point_where_the_tool_stands_is_numbered_anew_by_g92(tell):
    """As LinuxCNC's manual has it: G92 X Y Z gives the current point these coordinates, and nothing moves."""
    story = tell(START + "G1 X10 Y5 F60\nG92 X0 Z20\nX5\nZ0\nG91 Y2\nM30\n")
    assert story.complete and story.joined.tolist()[1:] == [True] * 4
    assert mm(story) == [[0, 0, 50], [10, 5, 50], [15, 5, 50], [15, 5, 30], [15, 7, 30]]
    inch = tell("G20 G0 X1 Y0 Z2\nG92 X0\nG1 X1 F5\n")
    assert mm(inch)[1] == pytest.approx([50.8, 0, 50.8])


def test_g92_before_the_first_move_says_where_the_tool_stands(tell):
    story = tell("G21 G92 X0 Y0 Z50\nG0 X7\nG1 Z2 F60\n")
    assert story.complete and mm(story) == [[7, 0, 50], [7, 0, 2]]


def test_a_shift_behind_g92_is_not_known(tell):
    story = tell(START + "G92 X1\nG52 X5\nG1 X1 F60\n")
    assert mm(story) == [[0, 0, 50]] and not story.complete


def test_cycles_and_arcs_behind_g52(tell):
    story = tell(START + "F60\nG52 X5 Z10\nG99 G81 X0 Y0 Z-5 R2\nG80\n")
    assert mm(story)[1:] == [[5, 0, 50], [5, 0, 12], [5, 0, 5], [5, 0, 12]] and story.complete
    story = tell(START + "G52 X5 Y1\nG90.1 G1 X0 Y0 F60\nG2 X10 Y0 I5 J0\n")
    assert story.path.center[2] * 1000.0 == pytest.approx([10, 1, 50]) and mm(story)[2] == [15, 1, 50]


@pytest.mark.parametrize("blocks", ["G52 A5", "G68 X0 Y0 R30\nG52 X5\nG69", "G52 X5\nG92.1", "G92 X0\nG52 X5\nG92.1"])
def test_a_shift_that_is_not_known_hides_what_lies_behind_it(tell, blocks):
    story = tell(START + f"{blocks}\nG52 X0 Y0 Z0\nG0 X3 Y3 Z3\n")
    assert mm(story) == [[0, 0, 50]] and not story.complete


@pytest.mark.parametrize(
    "block",
    ["G33 Z1 K1", "G1 X1 X2", "U5", "G38.2 Z1"],
)
def test_what_is_not_known_is_a_gap(tell, block):
    story = tell(START + f"{block}\nG0 X1 Y1 Z1\n")
    assert mm(story) == [[0, 0, 50], [1, 1, 1]] and [(g.before, g.first_line) for g in story.gaps] == [(1, 3)]
    assert story.joined.tolist() == [False, False]


@pytest.mark.parametrize(
    "block",
    ["G1 X#1", "M98 P1000", "M97 P5", "G65 P9000 A1.", "O<a> CALL", "WHILE[#1LT5]DO2", "IF [1 EQ 1] GOTO 5"],
)
def test_behind_what_is_not_known_nothing_is_read_to_the_end_of_the_file(tell, block):
    story = tell(START + f"{block}\nG0 X5\nM3 S5\nG0 X1 Y1 Z1\nM30\n\n")
    assert mm(story) == [[0, 0, 50]] and story.events == ()
    assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(1, 3, 7)]
    assert story.gaps[0].text.startswith(UNREAD + COMPUTED)


@pytest.mark.parametrize("text", ["%\nM3 S500\nM30\n%\n", "G1 X1 F5\n"])
def test_no_motion_is_no_story(tell, text):
    with pytest.raises(ToolpathError, match="no motion"):
        tell(text)


def test_look_ahead_and_haas_tool_centre_point_are_read(tell):
    plain = "G21\nG234\nG0 X0 Y0 Z9 A0 C0\nG1 X1 A20 F100\nX5\nM30\n"
    fast = plain.replace("G1 X1", "G5.1 Q1 X0 Y0 Z0\nG05 P10000\nG08 P1\nG187 P3\nG1 X1")
    story, other = tell(fast), tell(plain.replace("G234", "G43.4 H1"))
    assert story.complete and other.complete and story.path.tip == pytest.approx(other.path.tip)
    assert not tell(plain.replace("G1 X1", "G5.1 Q2 X7\nG1 X1")).complete


def test_signs_by_iso_841_turn_the_tool(tell):
    story = tell("G43.4 H1\nG0 X0 Y0 Z9 A20 C30\nG1 X1 F100\nM30\n", dialect="gcode-xyzac-iso")
    a, c = math.radians(20.0), math.radians(30.0)
    wanted = [math.sin(a) * math.sin(c), -math.sin(a) * math.cos(c), math.cos(a)]
    assert story.path.axis[-1] == pytest.approx(wanted)


def test_a_file_that_computes_from_its_first_line_on_is_a_story_without_motions(tell):
    story = tell("O100 SUB\nG1 X1 Y1 Z1\nM2\n")
    assert len(story.way) == 0 and not story.complete and story.gaps[0].last_line == 3
    with pytest.raises(ToolpathError, match="no motion"):
        tell("O100 SUB\nG1 X1 Y1 Z1\nO100 ENDSUB\nM2\n")


# -- the process


def test_tools_spindle_coolant_in_order(tell):
    story = tell(
        "T006M06F800S1800\nM3\nG0 X0 Y0 Z9\nM8\nT7\nG1 Z0\n"
        "M6 T6\nG0 Z9 M5\nM9\nT7\nM6\nS900 M4\nS950\nG0 X5 M7\nG4 P1.5\nM0\nX6 M30\n"
    )
    assert happened(story) == [
        (0, "TOOL", 6, ""),
        (0, "SPINDLE_ON", 1800, "CLW"),
        (1, "COOLANT_ON", 0, "FLOOD"),
        (3, "SPINDLE_OFF", 0, ""),
        (3, "COOLANT_OFF", 0, ""),
        (3, "TOOL", 7, ""),
        (3, "SPINDLE_ON", 900, "CCLW"),
        (3, "SPINDLE_ON", 950, "CCLW"),
        (3, "COOLANT_ON", 0, "MIST"),
        (4, "DWELL", 1.5, ""),
        (4, "STOP", 0, ""),
    ]
    assert story.operation.tolist() == [0, 0, 0, 1, 1] and story.feed[1] == 0.8 / 60


def test_a_preselected_tool_is_not_loaded(tell):
    story = tell("T1 M6\nT2\n" + START + "G1 X1 F9\nM6\nX2\n")
    assert happened(story) == [(0, "TOOL", 1, ""), (2, "TOOL", 2, "")]


@pytest.mark.parametrize(
    ("text", "seconds"), [("G4 P2.5", 2.5), ("G4 P500", 0.5), ("G4 P2", 2.0), ("G04 X1.5", 1.5), ("G4 F3", 3.0)]
)
def test_dwells(tell, text, seconds):
    assert happened(tell(START + text + "\nG0 X1\n")) == [(1, "DWELL", seconds, "")]


def test_a_spindle_switched_on_at_s0_stands_whatever_the_set_up_says(tell):
    story = tell("T1 M6\nS0 M3\n" + START + "G1 X1 F60\n", default_rpm=4000.0)
    assert happened(story) == [(0, "TOOL", 1, ""), (0, "SPINDLE_OFF", 0, "")]


def test_defaults(tell):
    story = tell("T1 M6\n" + START + "G1 X1\nX2 F60\n", default_feed=0.02, default_rpm=4000.0)
    assert story.feed[1:].tolist() == [0.02, 0.001] and story.complete
    assert happened(story) == [(0, "TOOL", 1, ""), (0, "SPINDLE_ON", 4000, "CLW")]
    assert math.isnan(tell(START + "M3\nG1 X1 F9\n").events[0].value)


def test_compensation_and_skipped_blocks_are_noted(tell):
    story = tell(START + "G41 D0 G1 X1 F60\n/G40 X0\n")
    assert len(story.notes) == 3 and story.complete and mm(story)[1:] == [[1, 0, 50], [0, 0, 50]]


# -- drilling


@pytest.mark.parametrize(
    ("block", "ways_", "heights"),
    [
        ("G99 G81 X10 Y0 Z-5 R2", "RRRHRRHR", [50, 50, 2, -5, 2, 2, -5, 2]),
        ("G98 G83 X10 Y0 Z-5 R2 Q1", "RRRHRRRHR", [50, 50, 2, -5, 50, 50, 2, -5, 50]),
        ("G73 X10 Z-5 R2 Q1 G99", "RRRHRRHR", [50, 50, 2, -5, 2, 2, -5, 2]),
        ("G85 X10 Z-5 R2", "RRRHFRRRHFR", [50, 50, 2, -5, 2, 50, 50, 2, -5, 2, 50]),
        ("G91 G99 G81 X10 Z-7 R-48", "RRRHRRHR", [50, 50, 2, -5, 2, 2, -5, 2]),
    ],
)
def test_drilling_cycles_as_their_motions(tell, block, ways_, heights):
    """Over the hole at the height that the tool has, in rapid to R, down to Z, out."""
    second = "X10" if "G91" in block else "X20"
    story = tell(START + f"F60 S300 M3\n{block}\n{second}\nG80\nM30\n")
    assert ways(story) == ways_ and [p[2] for p in mm(story)] == pytest.approx(heights) and story.complete
    assert sorted({p[0] for p in mm(story)}) == [0, 10, 20]


def test_pecks_from_r(tell):
    story = tell(START + "F60 S300 M3\nG98 G83 X10 Y0 Z-5 R2 Q1\nX20\nG81 X30 Z-5 R2\nG73 X40 Z-5 R2 Q2.5\nG80\nM30\n")
    deep = [int(k) for k in np.flatnonzero(story.way == Way.HOLE)]
    assert len(deep) == 4 and [story.pecks[k][:3] if k in story.pecks else None for k in deep] == [
        pytest.approx((0.001, 0.001, True)),
        pytest.approx((0.001, 0.001, True)),
        None,
        pytest.approx((0.0025, 0.0025, False)),
    ]


def test_repeats_and_kept_words(tell):
    story = tell(START + "F60\nG91 G99 G81 X10 Z-7 R-48 L3\nG90 G80\nG0 Z50\n")
    assert [p[0] for p in mm(story) if p[2] == -5] == [10, 20, 30] and mm(story)[-1] == [30, 0, 50]


def test_a_level_below_r_is_risen_to_first(tell):
    story = tell("G0 X0 Y0 Z1\nF60\nG98 G81 X10 Z-5 R2\n")
    assert mm(story) == [[0, 0, 1], [0, 0, 2], [10, 0, 2], [10, 0, -5], [10, 0, 2]]


@pytest.mark.parametrize(("m", "g", "sense", "other"), [("M3", "G84", "CLW", "CCLW"), ("M4", "G74", "CCLW", "CLW")])
def test_taps(tell, m, g, sense, other):
    story = tell(START + f"S300 {m}\nF300\n{g} X0 Z-10 R2\n")
    assert ways(story) == "RRHFR" and [p[2] for p in mm(story)] == [50, 2, -10, 2, 50] and story.complete
    assert happened(story) == [
        (1, "SPINDLE_ON", 300, sense),
        (3, "SPINDLE_ON", 300, other),
        (4, "SPINDLE_ON", 300, sense),
    ]
    assert not tell(START + f"S300 {'M4' if m == 'M3' else 'M3'}\nF300\n{g} X0 Z-10 R2\n").complete


def test_dwell_and_stop_in_cycles(tell):
    assert happened(tell(START + "F60\nG82 X0 Z-5 R2 P.5\n")) == [(3, "DWELL", 0.5, "")]
    story = tell(START + "S300 M3 F60\nG86 X0 Z-5 R2\n")
    assert happened(story)[1:] == [(3, "SPINDLE_OFF", 0, ""), (4, "SPINDLE_ON", 300, "CLW")] and ways(story) == "RRHR"


@pytest.mark.parametrize(
    "block", ["G87 X1 Z-5 R2", "G81 X1 Z-5", "G81 X1 R2", "G81 X1 Z5 R2", "G18 G81 X1 Z-5 R2", "G76 X1 Z-5 R2 Q1"]
)
def test_cycles_that_are_not_known_are_gaps(tell, block):
    story = tell(START + f"F60\n{block}\nG80\nG0 X9 Y9 Z9\n")
    assert len(story) == 2 and len(story.gaps) == 1 and not story.joined[1]


def test_axes_behind_g80_go_on_as_before_the_cycle(tell):
    story = tell(START + "F60\nG99 G81 X0 Z-5 R2\nG80 G0 Z50\nG80\nX5\n")
    assert mm(story)[-1] == [5, 0, 50] and not story.gaps
    story = tell(START + "F60\nG1 X1\nG3 X0 Y1 I-1\nG99 G81 X0 Z-5 R2\nG80\nX5\n")
    assert len(story.gaps) == 1


def test_words_that_controls_write_in_their_own_way(tell):
    story = tell("G71 G90\nT01 T02 M6\nG187 P2 E0.05\nG0 X0 Y0 Z20\nG1 X1 Z1 F100\nG0 Z20\nM6\nG0 X2\nG1 X3 Z1\nM30\n")
    assert [e.value for e in story.events if e.kind is Kind.TOOL] == [1.0, 2.0] and not story.gaps
    assert tell("G70\nG0 X1 Y0 Z0\nG1 X2 F9\n").units == "inch" and tell("G0 X1 Y0 Z0\nG71 Z5\nG1 X2 F9\n").gaps


def test_m13_is_a_clamp_where_m10_to_m12_are(tell):
    story = tell(START + "S900 M3\nM11\nM13\nM12\nG1 X1 F60\n")
    assert not story.gaps and [e.kind for e in story.events] == [Kind.SPINDLE_ON]
    assert tell(START + "S900 M3\nM13\nG1 X1 F60\n").gaps


def test_a_comment_makes_no_program_siemens(tell):
    assert not tell("(T1 D=10. CR=0. - ZMIN=-5.)\n" + START + "F60\nG1 X1\n").gaps


# -- five axes


@pytest.mark.parametrize(
    ("words", "axis"),
    [
        ("A90 C0", [0, 1, 0]),
        ("A90 C90", [1, 0, 0]),
        ("A-90 C0", [0, -1, 0]),
        ("A0 C45", [0, 0, 1]),
        ("B90 C0", [-1, 0, 0]),
        ("B90 C90", [0, 1, 0]),
        ("B-90 C0", [1, 0, 0]),
    ],
)
@pytest.mark.parametrize("on", ["M128", "M428", "G43.4 H1"])
def test_the_axis_of_two_kinematics(tell, words, axis, on):
    story = tell(f"{on}\nG0 X1 Y2 Z3 {words}\nX2\n")
    assert (
        story.path.axis[0] == pytest.approx(axis, abs=1e-12) and mm(story) == [[1, 2, 3], [2, 2, 3]] and story.complete
    )


def test_axes_that_turn_evenly_take_the_tool_off_the_great_arc(tell):
    """C turns a tool that leans by 60 degrees along a circle about z: a degree at a time; A alone keeps to the great arc."""
    story = tell("M128\nG0 X0 Y0 Z0 A0 C0\nG1 X1 A60 F100\nG1 X10 C90\n")
    assert story.complete and len(story) == 2 + 90
    assert story.path.axis[1:, 2] == pytest.approx(np.full(91, 0.5))
    middle = math.sin(math.radians(60)) * math.sin(math.radians(45))
    assert story.path.axis[46].tolist() == pytest.approx([middle, middle, 0.5])
    assert mm(story)[46] == [5.5, 0.0, 0.0] and set(story.path.line[2:].tolist()) == {4}


@pytest.mark.parametrize("off", ["", "M128\nM129\n", "M428\nM429\n", "G43.4 H1\nG49\n"])
def test_turned_axes_without_tool_centre_point(tell, off):
    """A cut with them is a gap; a rapid goes to a machine position, from where the way back is not known either."""
    story = tell(f"{off}G0 X1 Y2 Z3 A0 C0\nG0 X5 A10\nX6\nX7 A0\nA360\nX8\n")
    assert mm(story) == [[1, 2, 3], [7, 2, 3], [8, 2, 3]] and story.joined.tolist() == [False, False, True]
    assert story.complete
    story = tell(f"{off}G0 X1 Y2 Z3 A0 C0\nG1 X5 A10 F60\nX6\nX7 A0\n")
    assert mm(story) == [[1, 2, 3], [7, 2, 3]] and story.joined.tolist() == [False, False]
    first = 2 + off.count("\n")
    assert [(g.before, g.first_line, g.last_line, g.text) for g in story.gaps] == [(1, first, first + 1, TURNED)]


def test_three_rotary_axes_are_a_gap(tell):
    story = tell("M128\nG0 X1 Y2 Z3 A1 C0\nX2 B5\n")
    assert len(story) == 1 and not story.complete


@pytest.mark.parametrize(
    ("text", "value"),
    [("2+3*4", 14.0), ("-(1-3)*SIN(30)", 1.0), ("7/2/2", 1.75), (f"{'(' * 20000}1{')' * 20000}", None), ("1/0", None)],
)
def test_what_a_value_comes_to_is_worked_out_or_unread(text: str, value: float | None) -> None:
    if value is not None:
        assert Values().of(text) == pytest.approx(value, rel=1e-12)
        return
    with pytest.raises(UnreadError, match="computed"):
        Values().of(text)
