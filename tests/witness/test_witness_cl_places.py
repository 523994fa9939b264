"""The witness's reader of CL data of the APT family: arcs, frames and drilling cycles, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cl_stories import CAMWORKS, CATIA, CLT, CREO, MAKINO, NX, happened, mm, ways

from camrob.errors import ToolpathError
from camrob.witness.happenings import Kind, Story, Way

# -- arcs


def halfway(story: Story, i: int) -> list[float]:
    """The point in the middle of arc i, mm, by Rodrigues' formula from its start."""
    start = story.path.tip[i - 1] - story.path.center[i]
    n, angle = story.path.normal[i], story.path.angle[i] / 2.0
    turned = start * math.cos(angle) + np.cross(n, start) * math.sin(angle) + n * (n @ start) * (1.0 - math.cos(angle))
    return ((story.path.center[i] + turned) * 1000.0).round(4).tolist()


R = 7.0711  # 10 mm at 45 degrees


@pytest.mark.parametrize(
    ("head", "circle", "angle", "middle"),
    [
        (NX, "CIRCLE/0,0,0,0,0,-1,10,.06,.5,20,0", 90, [R, R, 0]),  # printed -Z, counter-clockwise from +Z
        (NX, "CIRCLE/0,0,0,0,0,1,10,.06,.5,20,0", 270, [-R, -R, 0]),
        (MAKINO, "CIRCLE/0,0,0,-0.0,-0.0,-1,10,.002,.5,10,0", 90, [R, R, 0]),
        (CREO, "CIRCLE/0,0,0,$\n0,0,1,10", 90, [R, R, 0]),
        (CREO, "CIRCLE/0,0,0,$\n0,0,-1,10", 270, [-R, -R, 0]),
        (CAMWORKS, "CIRCLE/0,0,0,0,0,1.", 90, [R, R, 0]),
        (CAMWORKS, "CIRCLE/0,0,0,0,0,-1.", 270, [-R, -R, 0]),
        (CLT, "CIRCLE/ 0,0,0,0,0,1,10,COUNTERCLOCKWISE", 90, [R, R, 0]),
        (CLT, "CIRCLE/ 0,0,0,0,0,1,10,CLOCKWISE", 270, [-R, -R, 0]),
        ("", "CIRCLE/0,0,0,0,0,1,10", 90, [R, R, 0]),
        ("", "CIRCLE/0,0,0,0,0,-1,10,.06,.5,20,0", 90, [R, R, 0]),
    ],
)
def test_the_direction_of_an_arc_by_dialect(tell, head, circle, angle, middle):
    story = tell(f"{head}FEDRAT/9\nGOTO/10,0,0\n{circle}\nGOTO/0,10,0\nGOTO/0,0,0\n")
    assert math.degrees(story.path.angle[1]) == pytest.approx(angle)
    assert halfway(story, 1) == pytest.approx(middle, abs=2e-4)
    assert np.isnan(story.path.angle[[0, 2]]).all() and story.joined.tolist() == [False, True, True]


def test_full_circles_helices_and_further_turns(tell):
    story = tell(
        CAMWORKS + "FEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1\nGOTO/-10,0,5\n"
        "CIRCLE/0,0,0,0,0,1,TIMES,2\nGOTO/10,0,-5\n"
    )
    assert np.degrees(story.path.angle[1:]).tolist() == pytest.approx([360, 180, 180 + 720])
    assert mm(story)[1:] == [[10, 0, 0], [-10, 0, 5], [10, 0, -5]]


def test_an_arc_in_another_plane(tell):
    story = tell(CAMWORKS + "FEDRAT/9\nGOTO/3,10,0\nCIRCLE/3,0,0,1,0,0\nGOTO/3,0,10\n")  # about +X from Y to Z
    assert math.degrees(story.path.angle[1]) == pytest.approx(90) and halfway(story, 1) == pytest.approx(
        [3, R, R], abs=2e-4
    )


@pytest.mark.parametrize(
    "arc", ["CIRCLE/0,0,0,0,0,1\nGOTO/0,10.1,0", "CIRCLE/10,0,0,0,0,1\nGOTO/0,10,0", "CIRCLE/0,0,0\nGOTO/0,10,0"]
)
def test_an_arc_that_is_none_is_a_gap(tell, arc):
    story = tell(CAMWORKS + f"FEDRAT/9\nGOTO/10,0,0\n{arc}\nGOTO/0,0,0\n")
    assert len(story.gaps) == 1 and not story.joined[-2 if len(story) == 3 else -1]


def test_an_arc_from_nowhere_is_a_gap(tell):
    story = tell(CAMWORKS + "FEDRAT/9\nCIRCLE/0,0,0,0,0,1\nGOTO/0,10,0\nGOTO/0,0,0\n")
    assert mm(story) == [[0, 0, 0]] and len(story.gaps) == 1


@pytest.mark.parametrize(("direction", "angle", "on"), [("0,1,0", 90, "ON"), ("0,-1,0", 270, "ON,2,INTOF")])
def test_catia_arcs_set_out_along_indirv(tell, direction, angle, on):
    story = tell(
        f"{CATIA}FEDRAT/ 9.0,MMPM\nGOTO  /  5.00000, 0.00000, 2.00000\nAUTOPS\nINDIRV/ {direction}\n"
        f"TLON,GOFWD/ (CIRCLE/ 0.00000, 0.00000, 2$\n"
        f".00000,$\n 5.00000),{on},(LINE/ 0.00000, 0.00000, 2.00000,$\n 0.00000, 5.00000, 2.00000)\nGOTO/0,0,2\n"
    )
    assert math.degrees(story.path.angle[1]) == pytest.approx(angle)
    assert mm(story)[1:] == [[0, 5, 2], [0, 0, 2]] and story.complete


# -- frames


def test_msys_by_hand(tell):
    """Columns X = (0,1,0), Y = (1,0,0), so Z = (0,0,-1)."""
    story = tell(
        "TOOL PATH/A,TOOL,T\nMSYS/10,20,30,0,1,0,1,0,0\nFEDRAT/MMPM,9\nGOTO/1,2,3,0,0,1\n"
        "CIRCLE/1,7,3,0,0,-1,5,0,0,0,0\nGOTO/6,7,3\n"
    )
    assert mm(story) == [[12, 21, 27], [17, 26, 27]] and story.path.axis[0].tolist() == [0, 0, -1]
    # left-handed about the printed -Z is right-handed about +Z of the frame, which is -Z of the part
    assert story.path.normal[1].tolist() == [0, 0, -1] and (story.path.center[1] * 1000).round(9).tolist() == [
        17,
        21,
        27,
    ]
    assert math.degrees(story.path.angle[1]) == pytest.approx(90)


def test_msys_tilted_by_30_degrees_and_another_one_behind(tell):
    c, s = math.cos(math.radians(30)), 0.5
    text = f"TOOL PATH/A,TOOL,T\nMSYS/0,0,0,1,0,0,0,{c},{s}\nFEDRAT/MMPM,9\nGOTO/0,0,10,0,0,1\n"
    story = tell(text + "END-OF-PATH\nTOOL PATH/B,TOOL,T\nMSYS/0,0,1,1,0,0,0,1,0\nGOTO/0,0,10,0,0,1\n")
    assert mm(story) == [pytest.approx([0, -5, 10 * c]), [0, 0, 11]]
    assert story.path.axis[0] == pytest.approx([0, -0.5, c]) and story.operation.tolist() == [0, 1]


def test_a_frame_that_is_no_rotation_hides_its_points(tell):
    story = tell("FEDRAT/9\nGOTO/0,0,0\nMSYS/0,0,0,1,0,0,1,1,0\nGOTO/1,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nGOTO/2,0,0\n")
    assert mm(story) == [[0, 0, 0], [2, 0, 0]] and [(g.first_line, g.last_line) for g in story.gaps] == [(3, 4)]


def test_camworks_world_points_are_not_moved_again(tell):
    frame = "CSYS/0,0,-1.,5,-1.,0,0,6,0,1.,0,7\n"
    text = (
        CAMWORKS
        + "FEDRAT/9\nTRNTYP/{},0,0,0\n"
        + frame
        + "GOTO/1,2,3\nTRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nGOTO/4,5,6\n"
    )
    world, local = tell(text.format("WORLD")), tell(text.format("LOCAL"))
    assert mm(world) == [[1, 2, 3], [4, 5, 6]] and world.path.axis.tolist() == [[-1, 0, 0], [0, 0, 1]]
    assert mm(local)[0] == [-3 + 5, -1 + 6, 2 + 7] and local.path.axis[0].tolist() == [-1, 0, 0]
    neither = tell("FEDRAT/9\nGOTO/0,0,0\n" + frame + "GOTO/1,2,3\n")
    assert len(neither) == 1 and len(neither.gaps) == 1


def test_creo_prints_points_in_the_frame_of_its_comment_and_in_no_other(tell):
    frame = "$$-> CSYS / 1.0, 0.0, 0.0, {},  $\n            0.0, 1.0, 0.0, 0.0,  $\n            0.0, 0.0, 1.0, 0.0\n"
    text = (
        CREO + frame.format("50.0") + "FEDRAT / 9, MMPM\nGOTO / 1, 2, 3\n" + frame + "GOTO / 4, 5, 6\nGOTO / 7, 8, 9\n"
    )
    same, other = tell(text.format("50.0")), tell(text.format("0.0"))
    assert mm(same) == [[1, 2, 3], [4, 5, 6], [7, 8, 9]] and same.complete
    assert mm(other) == [[1, 2, 3]] and [(g.first_line, g.last_line) for g in other.gaps] == [(7, 11)]


def test_catia_matrix_in_comments(tell):
    text = "$$*CATIA0\n$$ Part.1\n"
    text += "$$ 0.0 1.0 0.0 1.0\n$$ 0.0 0.0 1.0 2.0\n$$ 1.0 0.0 0.0 3.0\nFEDRAT/9.,MMPM\nGOTO/10,20,30,0,0,1\n"
    story = tell(text)
    assert mm(story) == [[21, 32, 13]] and story.path.axis.tolist() == [[0, 1, 0]] and story.dialect == "catia"


def test_clt_names_tools_by_their_measures(tell):
    """Where no statement has a tool's number, another cutter is another tool; the same one again is not."""
    cut = "FEDRAT/MMPM,100\nGOTO/0,0,0\nGOTO/1,0,0\n"
    story = tell(f"{CLT}CUTTER/ 6.0,0.0,3.0,\n{cut}CUTTER/ 6.0,0.0,3.0,\n{cut}CUTTER/ 8.0,0.0,4.0,\n{cut}")
    assert [(e.kind, e.before, e.line) for e in story.events] == [(Kind.TOOL, 0, 2), (Kind.TOOL, 4, 10)]
    apt = tell("LOADTL/1\nCUTTER/6.0\nFEDRAT/100,MMPM\nGOTO/0,0,0\nCUTTER/8.0\nGOTO/1,0,0\n")
    assert [(e.kind, e.value) for e in apt.events] == [(Kind.TOOL, 1.0)]


def test_an_inserted_stop_is_a_stop(tell):
    story = tell(
        "FEDRAT/100,MMPM\nGOTO/0,0,0\nINSERT/STOP  change fixture\nINSERT/Stock Size X1\nINSERT/NON STOP\nGOTO/1,0,0\n"
    )
    assert [(e.kind, e.before, e.line) for e in story.events] == [(Kind.STOP, 1, 3)]


def test_clt_tables_turn_in_radians(tell):
    head = CLT + "TLAXIS/ 0,-1,0\nROTABL/ 1.570796,AAXIS,TABLE,CCLW\nROTABL/ -0.0,BAXIS,TABLE,CCLW\nFEDRAT/ MMPM,9\n"
    story = tell(head + "GOTO/ 1,2,3\n")
    assert mm(story)[0] == pytest.approx([1, -3, 2], abs=1e-4)  # Rx(90): Y to Z, Z to -Y
    assert story.path.axis[0] == pytest.approx([0, -1, 0], abs=1e-6)
    with pytest.raises(ToolpathError):
        tell(head.replace("0,-1,0", "1,0,0") + "GOTO/ 1,2,3\n")
    assert not tell("FEDRAT/9\nGOTO/0,0,0\nROTABL/ 90.0,,TABLE,CLW\nGOTO/1,0,0\n").complete
    assert tell("FEDRAT/9\nGOTO/0,0,0\nROTABL/ 0.0,,TABLE,CLW\nGOTO/1,0,0\n").complete


# -- drilling cycles


def hole(tell, head: str, cycle: str, rows: str = "GOTO/0,0,0\nGOTO/20,0,0", start: str = "0,0,50") -> Story:
    text = f"{head}SPINDL/300,RPM,CLW\nFEDRAT/600.,MMPM\nRAPID\nGOTO/{start},0,0,1\n{cycle}\n{rows}\nCYCLE/OFF\n"
    return tell(text)


@pytest.mark.parametrize(
    ("head", "cycle", "ways_", "heights", "feed"),
    [
        (NX, "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,250.", "RRHRRHR", [50, 3, -20, 3, 3, -20, 3], 250),
        (
            NX,
            "CYCLE/DRILL,DEEP,STEP,5,CLEAR,3.,FEDTO,-20.,RTRCTO,10.,MMPM,250.",
            "RRHRRRHR",
            [50, 3, -20, 10, 10, 3, -20, 10],
            250,
        ),
        (NX, "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,RTRCTO,AUTO", "RRHRRRHR", [50, 3, -20, 50, 50, 3, -20, 50], 600),
        (
            CAMWORKS,
            "CYCLE/INIT\nCYCLE/DEEP2,FEDTO,9.,1STPECK,5.,SUBPECK,2.,MMPM,80,RAPTO,3.,RTRCTO,25.",
            "RRHRRRHR",
            [50, 3, -9, 25, 25, 3, -9, 25],
            80,
        ),
        (
            CREO,
            "CYCLE / DEEP, DEPTH, 3.500000, STEP, 1.000000, MMPM, 50.000000, CLEAR,$\n 1.000000",
            "RRHRRHR",
            [50, 1, -3.5, 1, 1, -3.5, 1],
            50,
        ),
        (CATIA, "CYCLE/DRILL,20.,3.", "RRHRRHR", [50, 3, -20, 3, 3, -20, 3], 600),
        (CATIA, "CYCLE/DRILL,   20.00000,  300.0000,MMPM,    3.00000", "RRHRRHR", [50, 3, -20, 3, 3, -20, 3], 300),
        (
            CLT,
            "CYCLE/ ON\nCYCLE/ DRILL,G98,12.5,PECKING,5.0,2.0,MMPM,187.5,3.0,46.9 46.9 DWELL,0.0",
            "RRHRRRHR",
            [50, 3, -12.5, 46.9, 46.9, 3, -12.5, 46.9],
            187.5,
        ),
        (
            CLT,
            "CYCLE/ DRILL,G99,12.5,PECKING,5.0,2.0,MMPM,187.5,3.0,46.9 46.9",
            "RRHRRHR",
            [50, 3, -12.5, 3, 3, -12.5, 3],
            187.5,
        ),
        ("UNITS/MM\n", "CYCLE/REAM,10,2", "RRHFRHF", [50, 2, -10, 2, 2, -10, 2], 600),
        (
            "UNITS/MM\n",
            "CYCLE/BORE,RAPTO,2,FEDTO,10,RTRCTO,5,MMPR,.2",
            "RRHFRRRHFR",
            [50, 2, -10, 2, 5, 5, 2, -10, 2, 5],
            60,
        ),
    ],
)
def test_a_cycle_as_its_motions(tell, head, cycle, ways_, heights, feed):
    """Rapid to the clear point, down at the feed, out as the kind has it; to the next hole at the greater height."""
    story = hole(tell, head, cycle)
    assert ways(story) == ways_ and [p[2] for p in mm(story)] == pytest.approx(heights)
    assert story.complete and set((story.feed[story.way != Way.RAPID] * 60000.0).round(6)) == {feed}
    x = [p[0] for p in mm(story)]
    assert sorted(set(x)) == [0, 20] and x == sorted(x)


@pytest.mark.parametrize(
    ("head", "cycle", "first", "others"),
    [
        (NX, "CYCLE/DRILL,DEEP,STEP,5,CLEAR,3.,FEDTO,-20.,RTRCTO,10.,MMPM,250.", 8, 5),
        (NX, "CYCLE/BRKCHP,RAPTO,3.,FEDTO,-6.,STEP,4.,MMPM,150.", 7, 4),
        (CAMWORKS, "CYCLE/DEEP2,FEDTO,9.,1STPECK,5.,SUBPECK,2.,MMPM,80,RAPTO,3.,RTRCTO,25.", 8, 2),
        (CAMWORKS, "CYCLE/DEEP2,FEDTO,9.,1STPECK,0.,SUBPECK,2.,MMPM,80,RAPTO,3.,RTRCTO,25.", 5, 2),
        (CREO, "CYCLE / DEEP, DEPTH, 3.500000, STEP, 1.000000, MMPM, 50.000000, CLEAR,$\n 1.000000", 2, 1),
        (CLT, "CYCLE/ DRILL,G98,12.5,PECKING,5.0,2.0,MMPM,187.5,3.0,46.9 46.9 DWELL,0.0", 8, 2),
        (NX, "CYCLE/DRILL,DEEP,STEP,0,CLEAR,3.,FEDTO,-20.,RTRCTO,10.,MMPM,250.", None, None),
        (NX, "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,250.", None, None),
    ],
)
def test_pecks_as_they_are_reported(tell, head, cycle, first, others):
    """From the clear point the first, from where the tool was the others."""
    story = hole(tell, head, cycle)
    deep = [int(k) for k in np.flatnonzero(story.way == Way.HOLE)] if first else []
    assert list(story.pecks) == deep
    for pecks in story.pecks.values():
        assert [v * 1000.0 for v in pecks[:2]] == pytest.approx([first, others])
        assert pecks.out is ("BRKCHP" not in cycle)


@pytest.mark.parametrize(("lower", "ways_"), [(0.0003, "RRHRRHR"), (0.003, "RRHRRRHR")])
def test_holes_that_lie_level_but_for_rounding_have_no_way_down_between_them(tell, lower, ways_):
    rows = f"GOTO/0,0,0\nGOTO/20,0,{-lower:.4f}"
    assert ways(hole(tell, NX, "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,250.", rows)) == ways_


@pytest.mark.parametrize(("sense", "other"), [("CLW", "CCLW"), ("CCLW", "CLW")])
def test_a_tap_turns_the_other_way_at_the_bottom(tell, sense, other):
    story = tell(
        f"SPINDL/300,RPM,{sense}\nRAPID\nGOTO/0,0,5\nFEDRAT/300,MMPM\nCYCLE/TAP,20.,3.\nGOTO/0,0,0\nCYCLE/OFF\nGOTO/0,0,5\n"
    )
    assert mm(story) == [[0, 0, 5], [0, 0, 3], [0, 0, -20], [0, 0, 3], [0, 0, 5]] and ways(story) == "RRHFF"
    assert happened(story) == [
        (0, "SPINDLE_ON", 300, sense),
        (3, "SPINDLE_ON", 300, other),
        (4, "SPINDLE_ON", 300, sense),
    ]


def test_a_tap_goes_on_in_rapid_above_the_clear_point(tell):
    story = hole(tell, NX, "CYCLE/TAP,RAPTO,3,FEDTO,-10,RTRCTO,AUTO,MMPR,1.", "GOTO/0,0,0")
    assert ways(story) == "RRHFR" and [p[2] for p in mm(story)] == [50, 3, -10, 3, 50]
    assert [e[0] for e in happened(story)] == [0, 0, 3, 4] and story.feed[2] * 60000 == pytest.approx(300)


def test_dwell_and_stop_at_the_bottom(tell):
    dwell = hole(tell, NX, "CYCLE/DRILL,RAPTO,3,FEDTO,-10,DWELL,.5", "GOTO/0,0,0")
    assert happened(dwell)[-1] == (3, "DWELL", 0.5, "") and ways(dwell) == "RRHR"
    turns = hole(tell, NX, "CYCLE/DRILL,RAPTO,3,FEDTO,-10,DWELL,REV,5", "GOTO/0,0,0")
    assert happened(turns)[-1] == (3, "DWELL", 1.0, "")
    stopped = hole(tell, NX, "CYCLE/BORE,DRAG,RAPTO,3,FEDTO,-10,RTRCTO,20", "GOTO/0,0,0")
    assert (
        happened(stopped)[2:] == [(3, "SPINDLE_OFF", 0, ""), (4, "SPINDLE_ON", 300, "CLW")] and ways(stopped) == "RRHR"
    )


def test_a_hole_goes_down_the_axis_of_the_tool(tell):
    story = tell(NX + "FEDRAT/MMPM,9\nCYCLE/DRILL,RAPTO,2,FEDTO,-10\nGOTO/0,0,0,0,.6,.8\n")
    assert mm(story) == [[0, 1.2, 1.6], [0, -6, -8], [0, 1.2, 1.6]] and story.joined.tolist() == [False, True, True]


def test_a_hole_that_begins_below_its_clear_point_is_risen_to_first(tell):
    story = hole(tell, NX, "CYCLE/DRILL,RAPTO,3,FEDTO,-10", "GOTO/20,0,10", "0,0,1")
    assert mm(story)[:4] == [[0, 0, 1], [0, 0, 13], [20, 0, 13], [20, 0, 0]]


@pytest.mark.parametrize(
    "cycle",
    [
        "CYCLE/BORE,BACK,RAPTO,3,FEDTO,-10",
        "CYCLE/THREAD,RAPTO,3,FEDTO,-10",
        "CYCLE/DRILL,FEDTO,-10",
        "CYCLE/DRILL,RAPTO,3",
        "CYCLE/DRILL,20.,300.,MMPM,3.",
        "CYCLE/CSINK,5.,RAPTO,3,FEDTO,-10",
        "CYCLE/TAP,DEEP,RAPTO,3,FEDTO,-10",
        "CYCLE/DRILL,RAPTO,3,FEDTO,10",
    ],
)
def test_a_cycle_that_is_not_known_is_a_gap(tell, cycle):
    story = hole(tell, NX, cycle)
    assert len(story) == 1 and [(g.before, g.first_line, g.last_line) for g in story.gaps] == [(1, 8, 9)]
