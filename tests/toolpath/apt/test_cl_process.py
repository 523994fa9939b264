"""CL statements beside motion: tools, spindle, coolant, dwell, lost places and what is used where the file is silent.

Each case was read wrongly once; points in mm, events as they stand between the motions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.apt.read_apt import read_cl
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move, Region
from camrob.toolpath.toolpath import Toolpath
from camrob.units import m_s_to_mm_min, mm_min_to_m_s

REPRO = Path(__file__).resolve().parents[4] / "shared" / "repro"
HEAD = "UNITS/MM\nSPINDL/3000,RPM,CLW\nFEDRAT/300,MMPM\n"
DOWN = "RAPID\nGOTO/0,0,9\nGOTO/0,0,0\n"


def read(text: str, dialect: str | None = "apt", **defaults: float) -> Toolpath:
    return read_cl(Path("part.apt"), text.encode(), dialect=dialect, defaults=Defaults(**defaults))


def refused(text: str, line: int, match: str, dialect: str = "apt", **defaults: float) -> None:
    with pytest.raises(ToolpathError, match=match) as error:
        read(text, dialect, **defaults)
    assert (error.value.line, error.value.path) == (line, Path("part.apt"))
    assert error.value.hint and "\n" not in str(error.value)


def course(region: Region) -> list[str]:
    """A region as one would tell it: events and points in their order, `*` before a cut's point."""
    steps = ["detached"] if region.detached else []
    for n in range(len(region) + 1):
        for e in region.events:
            if e.point == n:
                what = {EventKind.SPINDLE_ON: f" {e.value:g} {e.text}", EventKind.TOOL_CHANGE: f" {e.value:g}"}.get(
                    e.kind, ""
                )
                steps.append(f"{e.kind.value}{what}{' (retracted)' if e.retracted else ''}")
        if n < len(region):
            xyz = " ".join(f"{v:g}" for v in np.round(region.position[n] * 1000.0, 6) + 0.0)
            steps.append(f"{'*' if region.move[n] == Move.CUT else ''}{xyz}")
    return steps


def courses(t: Toolpath) -> list[tuple[int, list[str]]]:
    return [(r.tool, course(r)) for r in t.regions]


def codes(t: Toolpath) -> list[tuple[str, int, int]]:
    return [(f.code, f.line, f.count) for f in t.findings]


# ---- a region has one tool


def test_a_tool_change_in_the_middle_of_an_operation_begins_a_region() -> None:
    t = read(
        "TOOL PATH/A,TOOL,T1\nLOAD/TOOL,1\nSPINDL/RPM,3000,CLW\nRAPID\nGOTO/0,0,25,0,0,1\nFEDRAT/MMPM,300\nGOTO/0,0,2\n"
        "GOTO/20,0,2\nRAPID\nGOTO/20,0,25\nSPINDL/OFF\nCOOLNT/OFF\nLOAD/TOOL,2\nSPINDL/RPM,2000,CCLW\nCOOLNT/MIST\nRAPID\n"
        "GOTO/30,0,25\nGOTO/30,0,2\nEND-OF-PATH\n",
        "nx-clsf",
    )
    assert courses(t) == [
        (
            1,
            [
                "tool_change 1",
                "spindle_on 3000 CLW",
                "0 0 25",
                "*0 0 2",
                "*20 0 2",
                "20 0 25",
                "spindle_off",
                "coolant_off",
            ],
        ),
        (2, ["tool_change 2", "spindle_on 2000 CCLW", "coolant_on", "30 0 25", "*30 0 2"]),
    ]
    assert [r.operation for r in t.regions] == ["A", "A"]


def test_what_closes_an_operation_stays_with_it_when_the_next_one_was_announced_before() -> None:
    t = read(
        HEAD + "LOADTL/1\n$$-> FEATNO / 1\n" + DOWN + "RAPID\nGOTO/0,0,9\n$$-> FEATNO / 2\nSPINDL/OFF\nLOADTL/2\n"
        "SPINDL/500,CLW\n" + DOWN + "FINI\n",
        "creo-ncl",
    )
    assert courses(t) == [
        (1, ["spindle_on 3000 CLW", "tool_change 1", "0 0 9", "*0 0 0", "0 0 9", "spindle_off"]),
        (2, ["tool_change 2", "spindle_on 500 CLW", "0 0 9", "*0 0 0"]),
    ]


def test_a_tool_is_changed_before_it_comes_to_where_its_first_cut_starts() -> None:
    t = read(HEAD + "LOADTL/1\n" + DOWN + "LOADTL/2\nSPINDL/ON\nGOTO/7,0,0\n")
    assert courses(t)[1] == (2, ["tool_change 2", "spindle_on 3000 CLW", "0 0 0", "*7 0 0"])
    t = read("UNITS/MM\nFROM/0,0,50\nLOADTL/1\nSPINDL/900\nFEDRAT/10\nGOTO/0,0,0\n")
    assert courses(t) == [(1, ["tool_change 1", "spindle_on 900 CLW", "0 0 50", "*0 0 0"])]


def test_changes_without_motion_between_them_keep_their_order_at_the_new_region() -> None:
    t = read(HEAD + DOWN + "LOADTL/1\nLOADTL/2\nSPINDL/ON\n" + DOWN)
    assert courses(t)[1][1][:3] == ["tool_change 1", "tool_change 2", "spindle_on 3000 CLW"]


def test_other_words_that_bring_a_tool() -> None:
    t = read(HEAD + "TURRET/3\n" + DOWN + "TURRET/3\nTURRET/LEFT\nGOTO/1,0,0\nTURRET/4\n" + DOWN)
    assert [(r.tool, len(r)) for r in t.regions] == [(3, 3), (4, 2)]
    tools = "TOOLNO/1,MILL\nCUTTER/10\n" + DOWN + "TOOLNO/2,MILL\nCUTTER/6\n" + DOWN
    assert [r.tool for r in read(HEAD + tools).regions] == [1, 2]  # nothing else changes the tool
    assert [r.tool for r in read(HEAD + "LOADTL/7\n" + tools).regions] == [7]  # TOOLNO only describes
    t = read(HEAD + "CUTTER/10\n" + DOWN + "CUTTER/10\n" + DOWN + "CUTTER/6\n" + DOWN)
    assert [[e.text for e in r.events if e.kind is EventKind.TOOL_CHANGE] for r in t.regions] == [[], ["D6 R0"]]


def test_a_cutter_that_changes_without_its_tool_is_said() -> None:
    t = read(HEAD + "LOADTL/1\nCUTTER/10\n" + DOWN + "CUTTER/6\nGOTO/1,0,0\nCUTTER/6\nGOTO/2,0,0\n")
    assert codes(t) == [("cutter-changed", 9, 1)] and len(t.regions) == 1
    assert codes(read(HEAD + "LOADTL/1\nCUTTER/10\n" + DOWN + "CUTTER/6\nLOADTL/2\nSPINDL/ON\nGOTO/1,0,0\n")) == []


def test_a_tool_that_was_put_away_cuts_nothing() -> None:
    refused(HEAD + "LOADTL/1\n" + DOWN + "UNLOAD/TOOL,1\nGOTO/1,0,0\n", 9, "without a tool.*line 8")
    t = read(HEAD + "LOADTL/1\n" + DOWN + "UNLOAD/TOOL,1\nLOADTL/1\n" + DOWN)
    assert [c[1][0] for c in courses(t)][1:] == ["tool_change 1"]


@pytest.mark.parametrize("number", ["-1", "1.5"])
def test_numbers_that_no_tool_has(number: str) -> None:
    refused(HEAD + f"LOADTL/{number}\n" + DOWN, 4, "not a tool number")


# ---- places that are not known in the part


def test_gohome_without_a_point_ends_the_region() -> None:
    t = read(
        HEAD
        + DOWN
        + "GOTO/5,0,0\nCOOLNT/OFF\nGOHOME\nSPINDL/OFF\nLOADTL/2\nSPINDL/ON\n"
        + DOWN
        + "GOHOME/Z\nSPINDL/OFF\n"
    )
    assert courses(t) == [
        (0, ["spindle_on 3000 CLW", "0 0 9", "*0 0 0", "*5 0 0", "coolant_off"]),
        (
            2,
            [
                "detached",
                "spindle_off",
                "tool_change 2",
                "spindle_on 3000 CLW",
                "0 0 9",
                "*0 0 0",
                "spindle_off (retracted)",
            ],
        ),
    ]


def test_what_follows_gohome_starts_from_no_known_place() -> None:
    t = read(HEAD + DOWN + "GOHOME\nGOTO/1,2,3\n")  # a cut right from there: no way through the part is made up
    assert courses(t)[1] == (0, ["detached", "*1 2 3"])
    refused(HEAD + DOWN + "GOHOME\nGODLTA/0,0,5\n", 8, "no point to start from")
    refused(HEAD + DOWN + "GOHOME\nCIRCLE/0,0,0,0,0,1,1\nGOTO/0,1,0\n", 9, "no start")


def test_retrct_and_from_are_lost_places_too() -> None:
    t = read(HEAD + DOWN + "RETRCT\n" + DOWN)
    assert [r.detached for r in t.regions] == [False, True] and codes(t) == [("home", 7, 1)]
    refused(HEAD + DOWN + "RETRCT/ON\n", 7, "may retract")
    t = read(HEAD + DOWN + "FROM/0,0,50\nGOTO/9,0,0\n")
    assert courses(t)[1] == (0, ["detached", "0 0 50", "*9 0 0"])
    assert not any(r.detached for r in read(HEAD + DOWN + "FROM/0,0,0\nGOTO/9,0,0\n").regions)
    assert not read("UNITS/MM\nSPINDL/1,RPM\nFEDRAT/1\nGOHOME\n" + DOWN).regions[0].detached  # nothing was before


# ---- the spindle


def test_speed_and_sense_come_back_after_a_stop() -> None:
    t = read(
        "UNITS/MM\nFEDRAT/9\nSPINDL/500.,RPM,CCLW\n"
        + DOWN
        + "SPINDL/OFF\nSPINDL/ON\nGOTO/1,0,0\nSPINDL/700\nGOTO/2,0,0\n"
    )
    assert courses(t)[0][1] == [
        "spindle_on 500 CCLW",
        "0 0 9",
        "*0 0 0",
        "spindle_off",
        "spindle_on 500 CCLW",
        "*1 0 0",
        "spindle_on 700 CCLW",
        "*2 0 0",
    ]


@pytest.mark.parametrize(
    ("words", "want"),
    [
        ("12000,RPM,CCLW", "spindle_on 12000 CCLW"),
        ("RPM,1000,CCW", "spindle_on 1000 CCLW"),
        ("RANGE,2,RPM,1000,CW", "spindle_on 1000 CLW"),
        ("1000,RPM,CLW,RANGE,HIGH", "spindle_on 1000 CLW"),
        ("SMM,31.41592653589793,CLW", "spindle_on 1000 CLW"),
        ("SMM,314,CLW,MAXRPM,2500", "spindle_on 2500 CLW"),
        ("RPM,0,CLW", "spindle_off"),
        ("LOCK,90", "spindle_off"),
    ],
)
def test_spindl_in_its_spellings(words: str, want: str) -> None:
    t = read(f"UNITS/MM\nCUTTER/10\nFEDRAT/9\nSPINDL/{words}\n" + DOWN)
    assert courses(t)[0][1][0] == want


@pytest.mark.parametrize(
    "words",
    ["nan,RPM", "RPM,inf,CLW", "-inf,RPM", "-5,RPM,CLW", "1e400,RPM", "RPM,100,200", "CLW", "ON", "", "SFM,300,CLW"],
)
def test_spindle_speeds_that_are_none(words: str) -> None:
    refused(f"UNITS/MM\nFEDRAT/9\nSPINDL/{words}\n" + DOWN, 3, "SPINDL|spindle")


def test_auxfun_is_an_m_code() -> None:
    t = read(HEAD + DOWN + "AUXFUN/4\nAUXFUN/8\nGOTO/1,0,0\nAUXFUN/5\nAUXFUN/9\nAUXFUN/77\n")
    assert courses(t)[0][1][3:] == ["spindle_on 3000 CCLW", "coolant_on", "*1 0 0", "spindle_off", "coolant_off"]
    assert codes(t) == [("unknown-word", 12, 1)]
    refused(HEAD + DOWN + "AUXFUN/6\n", 7, "M6")
    refused(HEAD + DOWN + "PREFUN/68\n", 7, "G code")


TAPS = {
    "nx-clsf": "CYCLE/TAP,RAPTO,3.,FEDTO,-10.,DWELL,1,MMPM,300",
    "creo-ncl": "CYCLE / TAP, DEPTH, 10, MMPM, 300, CLEAR, 3, DWELL, 1",
    "camworks-apt": "CYCLE/TAP,FEDTO,10,MMPM,300,RAPTO,3,RTRCTO,3,DWELL,1",
    "camworks-clt": "CYCLE/ TAP,G98,10,DWELL,1,MMPM,300,3,3",
    "catia-apt": "CYCLE/TAP,10,300.,MMPM,3,DWELL,1",
    "makino-cldata": "CYCLE/TAP,DEPTH,10,CLEAR,3,DWELL,1,MMPM,300",
    "apt": "CYCLE/TAP,10,3,DWELL,1,MMPM,300",
}


@pytest.mark.parametrize("dialect", list(TAPS))
@pytest.mark.parametrize(("sense", "other"), [("CLW", "CCLW"), ("CCLW", "CLW")])
def test_tapping_reverses_at_the_bottom_and_goes_on_forward_at_the_top(dialect: str, sense: str, other: str) -> None:
    body = f"UNITS/MM\nSPINDL/RPM,300,{sense}\nFEDRAT/300,MMPM\nRAPID\nGOTO/0,0,30\n{TAPS[dialect]}\nGOTO/0,0,0\nCYCLE/OFF\n"
    text = body + "RAPID\nGOTO/0,0,30\nFINI\n"
    if dialect == "nx-clsf":
        text = "TOOL PATH/A,TOOL,T\n" + text.replace("FINI\n", "END-OF-PATH\n")
    region = read(text, dialect).regions[0]
    lines = course(region)
    assert lines[lines.index("0 0 3") :] == [
        "0 0 3",
        "*0 0 -10",
        "dwell",
        f"spindle_on 300 {other}",
        "*0 0 3",
        f"spindle_on 300 {sense}",
        "0 0 30",
    ]
    cutting = region.move == Move.CUT
    np.testing.assert_allclose(m_s_to_mm_min(np.asarray(region.feed[cutting])), 300.0)


def test_tapping_that_can_not_be_done() -> None:
    refused(HEAD + DOWN + "SPINDL/OFF\nCYCLE/TAP,8,2\nGOTO/0,0,0\n", 9, "spindle stands")
    refused(HEAD + DOWN + "CYCLE/TAP,8,2,STEP,1\nGOTO/0,0,0\n", 7, "TAP,8,2,STEP,1 is not known")
    nx = (
        "TOOL PATH/A,TOOL,T\n" + HEAD + "RAPID\nGOTO/0,0,9\nCYCLE/{},RAPTO,3,FEDTO,-9,MMPM,9\nGOTO/0,0,0\nEND-OF-PATH\n"
    )
    for name in ("TAP,DEEP", "TAP,BRKCHP", "BORE,BACK", "BORE,MANUAL"):
        refused(nx.format(name), 7, f"{name}.* is not known", "nx-clsf")


def test_chips_are_broken_where_nx_says_so() -> None:
    text = "TOOL PATH/A,TOOL,T\n" + HEAD + "RAPID\nGOTO/0,0,9\nCYCLE/DRILL,BRKCHP,RAPTO,3,FEDTO,-9,STEP,4,MMPM,9\n"
    t = read(text + "GOTO/0,0,0\nCYCLE/OFF\nEND-OF-PATH\n", "nx-clsf")
    assert [c for c in course(t.regions[0]) if c.startswith("*")] == ["*0 0 -4", "*0 0 -8", "*0 0 -9"]


# ---- what is used where the file is silent


def test_feed_and_spindle_of_the_setup_are_used_and_said_once() -> None:
    body = "UNIT/MM\nLOAD/TOOL,1\nRAPID/\nGOTO/0,0,25\nGOTO/0,0,2\nGOTO/20,0,2\nLOAD/TOOL,2\nRAPID/\nGOTO/30,0,25\nGOTO/30,0,2\n"
    t = read(body, feed=mm_min_to_m_s(240.0), spindle_rpm=8000.0)
    assert courses(t) == [
        (1, ["tool_change 1", "spindle_on 8000 CLW", "0 0 25", "*0 0 2", "*20 0 2"]),
        (2, ["tool_change 2", "spindle_on 8000 CLW", "30 0 25", "*30 0 2"]),
    ]
    assert np.nanmax(t.regions[1].feed) == pytest.approx(0.004)
    assert codes(t)[:2] == [("feed-from-setup", 5, 1), ("spindle-from-setup", 5, 1)]
    assert "240 mm/min" in t.findings[0].text and "8000 rev/min" in t.findings[1].text
    refused(body, 5, "no feed", spindle_rpm=8000.0)


def test_the_setup_overrides_nothing_that_the_file_states() -> None:
    defaults = {"feed": mm_min_to_m_s(240.0), "spindle_rpm": 8000.0}
    t = read(HEAD + DOWN + "SPINDL/OFF\nGOTO/1,0,0\n", **defaults)
    assert courses(t)[0][1] == ["spindle_on 3000 CLW", "0 0 9", "*0 0 0", "spindle_off", "*1 0 0"] and codes(t) == []
    assert t.regions[0].feed[1] == pytest.approx(0.005)
    refused("UNITS/MM\nFEDRAT/0\n" + DOWN, 5, "feed is 0", **defaults)
    t = read("UNITS/MM\nFEDRAT/60\nSPINDL/CCLW\n" + DOWN, **defaults)
    assert courses(t)[0][1][0] == "spindle_on 8000 CCLW" and codes(t) == [("spindle-speed-from-setup", 3, 1)]


def test_the_setups_spindle_turns_feeds_per_revolution_and_taps() -> None:
    t = read("UNITS/MM\nFEDRAT/0.1,MMPR\n" + DOWN, spindle_rpm=600.0)
    assert t.regions[0].feed[1] == pytest.approx(0.001)
    t = read("UNITS/MM\nFEDRAT/60\nRAPID\nGOTO/0,0,9\nCYCLE/TAP,8,2\nGOTO/0,0,0\nCYCLE/OFF\n", spindle_rpm=60.0)
    assert courses(t)[0][1] == [
        "spindle_on 60 CLW",
        "0 0 9",
        "0 0 2",
        "*0 0 -8",
        "spindle_on 60 CCLW",
        "*0 0 2",
        "spindle_on 60 CLW",
    ]


def test_units_that_nobody_named_are_said_first_with_the_width_in_both() -> None:
    t = read("PPRINT x\nSPINDL/900\nWIBBLE/1\nFEDRAT/100\n" + DOWN + "GOTO/100,0,0\n", feed=0.001)
    assert t.findings[0].code == "units-assumed"
    assert "100.0 mm wide" in t.findings[0].text and "2540.0 mm" in t.findings[0].text
    t = read("SPINDL/900\nFEDRAT/10,IPM\n" + DOWN + "GOTO/100,0,0\n")
    assert t.units == "inch" and codes(t)[0][0] == "units-assumed"
    assert "inches are assumed" in t.findings[0].text and "2540.0 mm wide" in t.findings[0].text
    assert codes(read("SPINDL/900\nFEDRAT/10,MMPM\n" + DOWN)) == []  # as NX writes it


@pytest.mark.parametrize(
    ("fedrat", "match"),
    [
        ("1e-9,MMPM", "too slow"),
        ("0.0599,MMPM", "too slow"),
        ("180001,MMPM", "faster than"),
        ("7087,IPM", "faster than"),
    ],
)
def test_feeds_that_nothing_moves_with(fedrat: str, match: str) -> None:
    refused(f"UNITS/MM\nSPINDL/9\nFEDRAT/{fedrat}\n" + DOWN, 6, rf"line 3\), {match}")
    assert read("UNITS/MM\nSPINDL/9\nFEDRAT/0.06,MMPM\n" + DOWN).regions[0].feed[1] == pytest.approx(1e-6)
    assert read("UNITS/MM\nSPINDL/9\nFEDRAT/180000,MMPM\n" + DOWN).regions[0].feed[1] == pytest.approx(3.0)


def test_a_feed_without_a_unit_after_the_lengths_have_changed_theirs() -> None:
    refused("UNITS/MM\nSPINDL/9\nFEDRAT/MMPM,500\nUNITS/INCHES\nFEDRAT/10\n" + DOWN, 5, "names no unit")
    head = "UNITS/MM\nSPINDL/9\nFEDRAT/MMPM,500\n"
    assert read(head + "FEDRAT/60\n" + DOWN).regions[0].feed[1] == pytest.approx(1e-3)


# ---- words that may not be skipped


@pytest.mark.parametrize(
    "words",
    [
        "SCALE/2",
        "MODIFY/XAXIS,YAXIS",
        "REPEAT/3",
        "THREAD/TURN,1",
        "SET/ORIGIN,5",
        "ROTHED/45",
        "GOCLER/1",
        "GOPARK",
    ],
)
def test_words_that_would_make_another_part(words: str) -> None:
    refused(HEAD + DOWN + words + "\nGOTO/1,0,0\n", 7, "may mean motion")


@pytest.mark.parametrize("words", ["MIRROR/XAXIS", "MIRROR/YZPLAN", "MIRROR", "SET/MIRROR,ON", "ROTATE/TABLE,30"])
def test_words_that_posts_read_differently(words: str) -> None:
    refused(HEAD + DOWN + words + "\nGOTO/1,0,0\n", 7, "posts differ in .*, and is not done")


@pytest.mark.parametrize(
    "words", ["MIRROR/NOMORE", "SCALE/OFF", "TRANS/0,0,0", "ROTATE/0", "COPY/NOMORE", "PREFUN/90", "SET/MODE,ABSOL"]
)
def test_words_that_say_that_they_change_nothing(words: str) -> None:
    assert len(read(HEAD + DOWN + words + "\nGOTO/1,0,0\n").regions[0]) == 3


def test_codes_in_insert_are_said() -> None:
    assert codes(read(HEAD + DOWN + "INSERT/G28 Z0\n")) == [("insert-text", 7, 1)]
    assert codes(read(HEAD + DOWN + "INSERT/check the clamp\n")) == []


# ---- a point that is repeated


SAMPLE = (
    "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\n$$-> FEATNO / 1\nRAPID\nGOTO/0,0,25\nFEDRAT/300,MMPM\nGOTO/0,0,2\nCOOLNT/ON\n"
    "GOTO/20,0,2\nFEDRAT/500,MMPM\nGOTO/20,5,2\nDELAY/1\nGOTO/20,9,2,0,0.6,0.8\nCIRCLE/20,8,2,0,0,1,1\nGOTO/20,7,2\nRAPID\n"
    "GOTO/20,7,25\n$$-> FEATNO / 2\nSPINDL/4000,RPM,CLW\nRAPID\nGOTO/20,7,25\nGOTO/20,7,1\nSPINDL/OFF\nRAPID\nGOTO/20,7,30\n"
    "LOADTL/2\nSPINDL/ON\nGOTO/1,1,1\nGOTO/2,2,2\nGOHOME\nRAPID\nGOTO/5,5,5\nGOTO/5,5,0\nFINI\n"
)


def once(region: Region) -> tuple[list[tuple[object, ...]], list[tuple[object, ...]]]:
    """Points and events with repeated points taken once, the events still between the same motions."""
    place = np.hstack([region.position, region.axis])
    new = np.concatenate([[True], (place[1:] != place[:-1]).any(axis=1)])
    index = np.concatenate([np.cumsum(new) - new, [new.sum()]])  # of the motion that each point's event stands before
    points = [(*place[n].tolist(), int(region.move[n]), str(region.feed[n])) for n in np.flatnonzero(new)]
    return points, [(int(index[e.point]), e.kind, e.value, e.text) for e in region.events]


def test_a_repeated_point_changes_no_motion_and_moves_no_event() -> None:
    lines = SAMPLE.splitlines(keepends=True)
    want = [once(r) for r in read(SAMPLE, "creo-ncl").regions]
    assert len(want) == 4
    for n, line in enumerate(lines):
        if line.startswith("GOTO"):
            for again in (line, line.replace("\n", ",\n")):  # the second comes the slow way
                text = "".join([*lines[: n + 1], again, *lines[n + 1 :]])
                assert [once(r) for r in read(text, "creo-ncl").regions] == want, line


def test_a_rapid_that_goes_nowhere_does_not_bring_the_tool_into_the_air() -> None:
    t = read(
        HEAD + "$$-> FEATNO / 1\n" + DOWN + "$$-> FEATNO / 2\nRAPID\nGOTO/0,0,0\nGOTO/5,0,0\nRAPID\nGOTO/5,0,9\nFINI\n",
        "creo-ncl",
    )
    assert [r.name for r in t.regions] == ["feature 1", "feature 2"]
    assert course(t.regions[0])[1:] == ["0 0 9", "*0 0 0", "*0 0 0", "*5 0 0"]


# ---- the files that came out wrong


def repro(name: str, **defaults: float) -> Toolpath:
    if not REPRO.is_dir():
        pytest.skip("../shared is not here: the small files that came out wrong")
    return read_toolpath(REPRO / name, **defaults)


@pytest.mark.parametrize("name", ["t1.apt", "t1b.apt", "t1n.cls", "g4.ncl", "g5.aptsource", "g3.nc"])
def test_two_tools_are_two_regions_each_with_its_own_change_first(name: str) -> None:
    t = repro(name)
    assert [r.tool for r in t.regions] == [1, 2]
    for r in t.regions:
        assert [(e.point, e.kind) for e in r.events][:2] == [(0, EventKind.TOOL_CHANGE), (0, EventKind.SPINDLE_ON)]
        assert all(e.point == len(r) and e.kind is EventKind.SPINDLE_OFF for e in r.events[2:])
    assert next((e.value, e.text) for r in t.regions for e in r.events if e.kind is EventKind.SPINDLE_ON) == (
        (30000.0, "CCLW") if name in ("t1.apt", "t1b.apt") else (3000.0, "CLW")
    )


def test_the_file_without_a_feed() -> None:
    with pytest.raises(ToolpathError, match="no feed"):
        repro("t2.apt")
    t = repro("t2.apt", feed=0.005, spindle_rpm=8000.0)
    assert courses(t)[0][1][:2] == ["tool_change 1", "spindle_on 8000 CLW"]


def test_auto_retract_goes_back_to_where_the_cycle_began(tmp_path: Path) -> None:
    """RTRCTO,AUTO: out of each hole to the height at which the cycle found the tool, so that ways between holes stay there."""
    lines = (
        "TOOL PATH/D,TOOL,T",
        "SPINDL/RPM,900,CLW",
        "RAPID",
        "GOTO/0,0,50,0,0,1",
        "CYCLE/DRILL,RAPTO,3.,FEDTO,-10.,RTRCTO,AUTO,MMPM,100.",
        "GOTO/0,0,0",
        "GOTO/20,0,8",
        "CYCLE/OFF",
        "END-OF-PATH",
    )
    file = tmp_path / "auto.cls"
    file.write_text("\n".join(lines) + "\n")
    tips = np.concatenate([r.position for r in read_toolpath(file).regions]) * 1000.0
    wanted = [(0, 0, 50), (0, 0, 3), (0, 0, -10), (0, 0, 50), (20, 0, 50), (20, 0, 11), (20, 0, -2), (20, 0, 50)]
    np.testing.assert_allclose(tips, wanted, atol=1e-9)
