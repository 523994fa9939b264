"""The witness's reader of CL data of the APT family, held to numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cl_stories import NX, happened, mm, ways

from camrob.errors import ToolpathError
from camrob.witness.cl import read_story
from camrob.witness.cl.words import NO_AXIS, STRANGE
from camrob.witness.happenings import Kind, Way

# -- points, axes, units


def test_the_axis_is_modal_and_starts_as_z(tell):
    story = tell("FEDRAT/100\nGOTO/1,2,3\nGOTO / 4, 5, 6, 0, .6, .8\nGOTO/7,8,9\n")
    assert mm(story) == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert story.path.axis.tolist() == [[0, 0, 1], [0, 0.6, 0.8], [0, 0.6, 0.8]]
    assert ways(story) == "FFF" and story.joined.tolist() == [False, True, True] and story.complete


def test_from_sets_the_axis_and_makes_no_motion(tell):
    story = tell("FROM/0,0,50,1,0,0\nFEDRAT/100\nGOTO/1,2,3\n")
    assert mm(story) == [[1, 2, 3]] and story.path.axis.tolist() == [[1, 0, 0]]
    assert story.joined.tolist() == [True]


def test_from_elsewhere_in_mid_file_is_no_place_that_was_gone_to(tell):
    story = tell("FEDRAT/100\nGOTO/1,2,3\nFROM/0,0,50\nGOTO/5,5,5\n")
    assert story.joined.tolist() == [False, False]


def test_runs_of_goto_lines_read_the_same_as_single_statements(tell):
    rows = [f"GOTO/{i}.25,-{i},.5" + (",0,.6,.8" if i % 7 == 3 else "") for i in range(40)]
    rows[20] = rows[19]
    head = NX + "FEDRAT/MMPM,250.\nRAPID\nGOTO/9,9,9\n"
    quick, slow = tell(head + "\n".join(rows)), tell(head + "\n".join(f"{row} $$" for row in rows))
    assert len(quick) == len(slow) == 40
    for a, b in zip((quick.path.tip, quick.path.axis), (slow.path.tip, slow.path.axis), strict=True):
        assert np.abs(a - b).max() < 1e-12
    assert quick.path.line.tolist() == slow.path.line.tolist()
    assert quick.feed[1:].tolist() == slow.feed[1:].tolist() == [250 / 60000] * 39
    assert quick.joined.tolist() == slow.joined.tolist() == [False] + [True] * 39


@pytest.mark.parametrize("fault", ["GOTO/1 2,,3", "GOTO/1,2,", "GOTO/1.2.3,4,5", "GOTO/1,,2", "GOTO/-,1,2"])
def test_a_fault_in_a_run_is_named_with_its_line(tell, fault):
    rows = [f"GOTO/{i},0,0" for i in range(30)]
    rows[17] = fault
    if fault == "GOTO/1,2,":
        story = tell("FEDRAT/9\n" + "\n".join(rows))
        assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(17, 19, 19)]
        assert not story.joined[17]
        return
    with pytest.raises(ToolpathError) as error:
        tell("FEDRAT/9\n" + "\n".join(rows))
    assert error.value.line == 19


@pytest.mark.parametrize(
    ("head", "options", "metres", "units"),
    [
        ("UNITS/MM\nFEDRAT/MMPM,100\n", {}, 0.001, "mm"),
        ("UNITS / INCHES\nFEDRAT/10,IPM\n", {}, 0.0254, "inch"),
        ("UNIT/INCH\nFEDRAT/10,IPM\n", {"units": "mm"}, 0.001, "mm"),
        ("FEDRAT/10.0,  IPM\n", {}, 0.0254, "inch"),
        ("FEDRAT/10.0,IPM\nFEDRAT/MMPM,10\n", {}, 0.001, "mm"),
        ("UNITS/MM\nFEDRAT/10.0,IPM\n", {}, 0.001, "mm"),
    ],
)
def test_units(tell, head, options, metres, units):
    story = tell(head + "GOTO/1,0,0\n", **options)
    assert story.path.tip[0, 0] == pytest.approx(metres) and story.units == units


@pytest.mark.parametrize(
    ("text", "mm_min"),
    [
        ("FEDRAT/MMPM,250.", 250.0),
        ("FEDRAT/PERMIN,250", 250.0),
        ("FEDRAT/250.,MMPM", 250.0),
        ("FEDRAT/  250.,  MMPM", 250.0),
        ("FEDRAT/250", 250.0),
        ("FEDRAT/10,IPM", 254.0),
        ("SPINDL/3000,RPM,CLW\nFEDRAT/.1,MMPR", 300.0),
        ("FEDRAT/.01,IPR\nSPINDL/RPM,600,CLW", 152.4),
        ("SPINDL/3000,RPM,CLW\nFEDRAT/.1,MMPR\nFEDRAT/.2", 600.0),
    ],
)
def test_feed_in_every_order_and_unit(tell, text, mm_min):
    story = tell(f"UNITS/MM\n{text}\nGOTO/1,0,0\n")
    assert story.feed[0] * 60000.0 == pytest.approx(mm_min) and story.complete


@pytest.mark.parametrize("text", ["", "FEDRAT/MMPM,0", "FEDRAT/.1,MMPR", "FEDRAT/INVERS,2", "FEDRAT/-5"])
def test_a_cut_without_a_feed_is_a_gap_and_no_zero(tell, text):
    story = tell(f"{text}\nRAPID\nGOTO/0,0,9\nGOTO/0,0,0\nGOTO/1,0,0\n")
    assert np.isnan(story.feed).all() and not story.complete and len(story) == 3
    assert story.joined.tolist() == [False, True, True]


def test_a_default_feed_serves_where_the_file_is_silent(tell):
    story = tell("GOTO/0,0,0\nGOTO/1,0,0\nFEDRAT/600\nGOTO/2,0,0\n", default_feed=0.02)
    assert story.feed.tolist() == [0.02, 0.02, 0.01] and story.complete


def test_rapid_holds_for_one_goto(tell):
    story = tell("FEDRAT/300\nGOTO/0,0,0\nRAPID/ \nGOTO/1,0,0\nGOTO/2,0,0\n")
    assert ways(story) == "FRF" and np.isnan(story.feed[1]) and story.feed[2] == story.feed[0]


def test_repeated_points_are_no_motions_and_keep_their_events(tell):
    text = "FEDRAT/9\nGOTO/0,0,0\nGOTO/1,0,0\nCOOLNT/ON\nRAPID\nGOTO/1,0,0\nSPINDL/OFF\nGOTO/1,0,0\nGOTO/2,0,0\n"
    story = tell(text)
    assert mm(story) == [[0, 0, 0], [1, 0, 0], [2, 0, 0]] and ways(story) == "FFF"
    assert happened(story) == [(2, "COOLANT_ON", 0, ""), (2, "SPINDLE_OFF", 0, "")]


def test_godlta_and_gohome(tell):
    text = "FEDRAT/9\nGOTO/1,1,1,0,.6,.8\nGODLTA/1,2,3\nGODLTA/-10\nGOHOME/0,0,50\nGOTO/0,0,0\nGOHOME/Z\nGOTO/5,5,5\n"
    story = tell(text)
    assert mm(story) == [[1, 1, 1], [2, 3, 4], [2, -3, -4], [0, 0, 50], [0, 0, 0], [5, 5, 5]]
    assert ways(story) == "FFFRFF" and story.joined.tolist() == [False, True, True, True, True, False]


# -- the lexical layer


def test_continuations(tell):
    story = tell(
        "PARTNO A/B GOTO/9,9,9\nPPRINT GOTO/8,8,8 $\nGOTO/7,7,7\nPPRINT COSTS $5\n"
        "FEDRAT/1$\n0.$ what follows is ignored\n0,MMPM\n"
        "GOTO / 1, 2,  $\n$$ between\n   3, 0,0,1\nGOTO/4,5,6$$ GOTO/1,1,1\nGOTO/0$\n.500000,0,0\n"
        "$$-> CSYS / 1,0,0,5,  $\n   0,1,0,5,  $\n   0,0,1,5\n$$ ends in $\nGOTO/2,2,2\nFINI\njunk"
    )
    assert mm(story) == [[1, 2, 3], [4, 5, 6], [0.5, 0, 0], [2, 2, 2]]
    assert story.feed[0] == pytest.approx(10 / 60000) and story.complete
    assert story.path.line.tolist() == [8, 11, 12, 18]


def test_line_ends_case_and_latin_1(tell):
    story = tell("pprint Fräsen\r\nfedrat/9\r\nrapid\r\ngoto/1,2,3\ngoto/4,5,6\r\n".encode("latin-1"))
    assert mm(story) == [[1, 2, 3], [4, 5, 6]] and ways(story) == "RF"


def test_a_synonym_can_make_a_comment_of_a_word(tell):
    text = "TLAXIS/1,0,0\nFEDRAT/9\nGOTO/1,2,3\n"
    assert tell(text).path.axis.tolist() == [[1, 0, 0]]
    assert tell("SYN/'TLAXIS','$$*TLAXIS'\n" + text).path.axis.tolist() == [[0, 0, 1]]


def test_words_that_carry_nothing_are_skipped_and_others_are_gaps(tell):
    story = tell(
        "FEDRAT/9\nPAINT/SPEED,10\nGOTO/0,0,0\nSEQNO/START,100\nFOO/BAR\nGOTO/1,0,0\nBENDTO/3,4,5\nGOTO/2,0,0\n"
        "NURBS/1,2\nKNOT/.5,.6\nCNTRL/1,2,3\nCNTRL/4,5,6\nGOTO/3,0,0\nGOTO/4,0,0\n"
    )
    assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(2, 7, 7), (3, 9, 12)]
    assert "BENDTO" in story.gaps[0].text and "NURBS" in story.gaps[1].text
    assert story.joined.tolist() == [False, True, False, False, True]
    assert any("FOO" in note for note in story.notes)


@pytest.mark.parametrize(
    ("first", "last"),
    [
        ("MIRROR/1,0,0,0", "MIRROR/OFF"),
        ("TRANS/5,5,5,LAST", "TRANS/NOMORE"),
        ("LOOPST", "LOOPND"),
        ("SET/MODE,INCR", "SET/MODE,ABSOL"),
    ],
)
def test_points_that_are_not_where_they_are_printed_are_hidden(tell, first, last):
    rows = "\n".join(f"GOTO/{i},1,1" for i in range(20))
    story = tell(f"FEDRAT/9\nGOTO/0,0,0\n{first}\n{rows}\n{last}\nGOTO/1,0,0\n")
    assert mm(story) == [[0, 0, 0], [1, 0, 0]] and story.joined.tolist() == [False, False]
    assert [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(1, 3, 23)]


def test_motions_behind_the_end_are_a_gap(tell):
    assert tell("FEDRAT/9\nGOTO/0,0,0\nFINI\nxyzzy\n").complete
    assert not tell("FEDRAT/9\nGOTO/0,0,0\nFINI\nGOTO/1,1,1\n").complete


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("pl1=plane/0,0,1,0\ngoto/1,2,3\n", 1),
        ("FEDRAT/9\nGOTO/1,2,3\nGOTO/PT3\n", 3),
        ("GOTO/1,2,3\ntllft,gofwd/ln1,past,ln2\n", 2),
        ("GOTO/1,2,3\nTLON,GOFWD/C1,ON,L2\n", 2),
        ("GOTO/1,\x00,3\n", 0),
        ("", 0),
        ("just some text\n", 0),
        ("PARTNO A\nFINI\n", 0),
        ("UNITS/FEET\nGOTO/1,2,3\n", 1),
    ],
)
def test_files_that_are_no_cl_data_are_refused(tell, text, line):
    with pytest.raises(ToolpathError) as error:
        tell(text)
    assert error.value.line == line and error.value.path is not None and error.value.path.name == "a.apt"


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ToolpathError, match=r"gone\.cls"):
        read_story(tmp_path / "gone.cls")


# -- the process


@pytest.mark.parametrize(
    ("text", "event"),
    [
        ("SPINDL/RPM,1000,CLW ", ("SPINDLE_ON", 1000, "CLW")),
        ("SPINDL/12000,RPM,CCLW", ("SPINDLE_ON", 12000, "CCLW")),
        ("SPINDL / RPM, 9000.000000,  CLW", ("SPINDLE_ON", 9000, "CLW")),
        ("SPINDL/1000, CLW", ("SPINDLE_ON", 1000, "CLW")),
        ("SPINDL/OFF", ("SPINDLE_OFF", 0, "")),
        ("SPINDL/MAXRPM,5000,RPM,900,CCLW", ("SPINDLE_ON", 900, "CCLW")),
        ("COOLNT/ON", ("COOLANT_ON", 0, "")),
        ("COOLNT/FLOOD", ("COOLANT_ON", 0, "FLOOD")),
        ("COOLNT/OFF", ("COOLANT_OFF", 0, "")),
        ("LOAD/TOOL,12,ADJUST,2 ", ("TOOL", 12, "")),
        ("LOADTL/3,1,3", ("TOOL", 3, "")),
        ("TOOL PATH/A,TOOL,Ball 10", ("TOOL", 0, "Ball 10")),
        ("DELAY / 2.5", ("DWELL", 2.5, "")),
        ("DWELL/2.5", ("DWELL", 2.5, "")),
        ("STOP", ("STOP", 0, "")),
        ("OPSTOP", ("STOP", 0, "")),
    ],
)
def test_events_stand_between_the_motions(tell, text, event):
    story = tell(f"FEDRAT/9\nGOTO/0,0,0\n{text}\nGOTO/1,0,0\n")
    assert happened(story) == [(1, *event)] and story.events[0].line == 3 and story.complete


def test_spindle_on_again_and_dwells_in_turns(tell):
    story = tell("FEDRAT/9\nSPINDL/300,RPM,CCLW\nGOTO/0,0,0\nSPINDL/OFF\nSPINDL/ON\nDELAY/5,REV\nGOTO/1,0,0\n")
    assert happened(story)[2:] == [(1, "SPINDLE_ON", 300, "CCLW"), (1, "DWELL", 1.0, "")]


@pytest.mark.parametrize("text", ["SPINDL/500.,SFM,CLW", "SPINDL/nan", "SPINDL/ON", "SPINDL/-10,CLW"])
def test_a_spindle_speed_that_is_none_is_a_gap(tell, text):
    story = tell(f"FEDRAT/9\n{text}\nGOTO/0,0,0\n")
    assert math.isnan(story.events[0].value) and len(story.gaps) == 1


def test_the_same_tool_again_is_no_change(tell):
    story = tell(
        "FEDRAT/9\nLOADTL/1\nGOTO/0,0,0\nLOADTL/1,1\nGOTO/1,0,0\nSELECT/TOOL,2\nGOTO/2,0,0\nLOADTL/2\nGOTO/3,0,0\n"
    )
    assert happened(story) == [(0, "TOOL", 1, ""), (3, "TOOL", 2, "")] and story.operation.tolist() == [0, 0, 0, 1]


def test_nx_names_its_tools_and_may_number_them(tell):
    path = "TOOL PATH/{},TOOL,{}\n{}FEDRAT/MMPM,9\nGOTO/{},0,0\nEND-OF-PATH\n"
    story = tell(
        path.format("A", "MILL", "", 0)
        + path.format("B", "MILL", "", 1)
        + path.format("C", "DRILL", "LOAD/TOOL,7\n", 2)
    )
    assert happened(story) == [(0, "TOOL", 0, "MILL"), (2, "TOOL", 7, "DRILL")] and story.operation.tolist() == [
        0,
        1,
        2,
    ]
    story = tell(path.format("A", "MILL", "", 0) + "LOAD/TOOL,7\nGOTO/1,0,0\n")  # loaded after motions: another tool
    assert happened(story) == [(0, "TOOL", 0, "MILL"), (1, "TOOL", 7, "")]


def test_default_spindle_from_motion_0_where_the_file_cuts_before_it_starts_one(tell):
    text = "LOADTL/1\nFEDRAT/9\nRAPID\nGOTO/0,0,9\n{}GOTO/0,0,0\nSPINDL/OFF\n"
    silent = tell(text.format(""), default_rpm=5000.0)
    assert happened(silent)[:2] == [(0, "TOOL", 1, ""), (0, "SPINDLE_ON", 5000, "CLW")]
    said = tell(text.format("SPINDL/900,CCLW\n"), default_rpm=5000.0)
    assert happened(said)[:2] == [(0, "TOOL", 1, ""), (1, "SPINDLE_ON", 900, "CCLW")]
    assert any("spindle" in note for note in tell(text.format("")).notes)
    assert Way.RAPID == 0 and Kind.TOOL == "tool"


def test_cutcom_is_not_applied_and_said_once(tell):
    story = tell("FEDRAT/9\nGOTO/0,0,0\nCUTCOM/LEFT\nGOTO/1,0,0\nCUTCOM/OFF\nCUTCOM/RIGHT,XYPLAN\nGOTO/2,0,0\n")
    assert len(story.notes) == 2 and story.complete and mm(story)[1:] == [[1, 0, 0], [2, 0, 0]]


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("GOTO/1,2,3,0,0,0.5", NO_AXIS),
        ("MOVETO/25,0,5", STRANGE),
        ("ORIGIN/0,0,0", "ORIGIN: not known"),
        ("STEP/1,2", "not known"),
    ],
)
def test_what_camrob_refuses_is_told_from_what_only_this_reader_does_not_know(tell, line, text):
    gap = tell(f"FEDRAT/MMPM,9\nGOTO/0,0,0\n{line}\nGOTO/1,0,0\n").gaps[0]
    assert text in gap.text and (text in (NO_AXIS, STRANGE)) == any(t in gap.text for t in (NO_AXIS, STRANGE))


def test_settings_of_camworks_and_clearance_planes_move_nothing(tell):
    assert tell("CSI_SET_TOOL/1,2,3\nCLRSRF/0,0,1,50\nFEDRAT/MMPM,9\nGOTO/0,0,0\nGOTO/1,0,0\n").complete


@pytest.mark.parametrize(
    ("begin", "end"),
    [("TOOL PATH/A,TOOL,T", "END-OF-PATH"), ("OPFEATSTART/Drill1", "OPFEATEND/Drill1")],
)
def test_a_file_that_ends_within_an_operation_was_cut_off(tell, begin, end):
    text = f"{begin}\nFEDRAT/MMPM,9\nGOTO/0,0,0\nGOTO/1,0,0\n"
    assert len(tell(f"{text}{end}\n", whole=False).way) == 2
    with pytest.raises(ToolpathError, match="line 1 begins: it was cut off"):
        tell(text, whole=False)
    with pytest.raises(ToolpathError, match="line 6 begins"):
        tell(f"{text}{end}\n{begin}\nGOTO/2,0,0\n", whole=False)
