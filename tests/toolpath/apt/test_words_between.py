"""Single words put into a good CL file: each is done as the words' standard has it, or refused by name; none is passed over.

The paths are worked out by hand; the witness, which shares no code with the reader, has to read the same.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story

HEAD = "PARTNO/A\nUNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nRAPID\nGOTO/0,0,50\nRAPID\nGOTO/0,0,5\nFEDRAT/250,MMPM\nGOTO/0,0,-1\n"
TAIL = "GOTO/20,0,-1\nGOTO/20,20,-1\nRAPID\nGOTO/20,20,50\nFINI\n"
PLAIN = [("R", 0, 0, 50), ("R", 0, 0, 5), ("C", 0, 0, -1), ("C", 20, 0, -1), ("C", 20, 20, -1), ("R", 20, 20, 50)]


def read(folder: Path, words: str, name: str = "a.apt") -> Toolpath:
    file = folder / name
    file.write_text(HEAD + words + "\n" + TAIL)
    return read_toolpath(file, chord_tolerance=1e-6)


def both(folder: Path, words: str) -> Toolpath:
    path = read(folder, words)
    story = read_story(folder / "a.apt")
    assert story.complete, story.gaps
    assert differences(path, story) == []
    return path


def moves(path: Toolpath) -> list[tuple[str, float, float, float]]:
    return [
        ("R" if move == Move.RAPID else "C", *(point * 1e3).round(6).tolist())
        for region in path.regions
        for point, move in zip(region.position, region.move, strict=True)
    ]


def events(path: Toolpath) -> list[tuple[EventKind, float]]:
    return [(e.kind, e.value) for region in path.regions for e in region.events][2:]  # behind tool and spindle


def test_statements_that_semicolons_part_are_all_done(tmp_path: Path) -> None:
    path = both(tmp_path, "SPINDL/OFF; COOLNT/OFF; PPRINT/one; two\nRAPID; GOTO/9,0,5; goto/9,9,5;$\nGOTO/0,9,-1")
    assert moves(path) == [*PLAIN[:3], ("R", 9, 0, 5), ("C", 9, 9, 5), ("C", 0, 9, -1), *PLAIN[3:]]
    assert [kind for kind, _ in events(path)] == [EventKind.SPINDLE_OFF, EventKind.COOLANT_OFF, EventKind.MESSAGE]
    assert path.regions[0].events[-1].text == "one; two"


@pytest.mark.parametrize("off", ["OFF", "NOMORE"])
def test_what_is_switched_off_is_not_switched_on(off: str, tmp_path: Path) -> None:
    path = both(tmp_path, f"RAPID/{off}\nSPINDL/{off}\nCOOLNT/{off}")
    assert moves(path) == PLAIN
    assert [kind for kind, _ in events(path)] == [EventKind.SPINDLE_OFF, EventKind.COOLANT_OFF]


def test_an_arc_behind_rapid_is_a_rapid_and_what_follows_is_none(tmp_path: Path) -> None:
    path = both(tmp_path, "RAPID\nCIRCLE/10,0,-1,0,0,-1,10")
    first, *_, last = moves(path)[3:-2]
    assert {first[0], last[0]} == {"R"}
    assert last == ("R", 20, 0, -1)
    radii = [math.hypot(x - 10, y) for _, x, y, _ in moves(path)[3:-2]]
    assert radii == pytest.approx([10] * len(radii), abs=2e-3)
    assert moves(path)[-2:] == PLAIN[-2:]


def test_catias_arc_behind_rapid_does_not_leave_it_to_the_next_cut(tmp_path: Path) -> None:
    path = both(tmp_path, "RAPID\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/5,0,-1,5),ON,(LINE/5,0,-1,10,0,-1)\nGOTO/15,0,-1")
    assert moves(path)[-4] == ("C", 15, 0, -1)


def test_m_codes_by_auxfun_switch_spindle_and_coolant(tmp_path: Path) -> None:
    path = both(tmp_path, "AUXFUN/5\nAUXFUN/14\nAUXFUN/9")
    kinds = [EventKind.SPINDLE_OFF, EventKind.SPINDLE_ON, EventKind.COOLANT_ON, EventKind.COOLANT_OFF]
    assert [kind for kind, _ in events(path)] == kinds
    assert path.regions[0].events[3].text == "CCLW"


@pytest.mark.parametrize(
    "words",
    "DISPLY/ON,1,2,3 PLABEL/1,2,3 TLSPEC/1,2,3 CHECK/XAXIS,1,2,3 LINTOL/.01 MCHTOL/.01 OPSKIP/OFF FEDRAT/250,UPM".split(),
)
def test_words_of_the_standard_that_move_nothing(words: str, tmp_path: Path) -> None:
    path = both(tmp_path, words)
    assert moves(path) == PLAIN
    assert not events(path)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("FEDRAT/10,FPM", "FPM"),  # feet a minute
        ("FEDRAT/SCALE,50", "SCALE"),
        ("FEDRAT/MAXIPM,20", "MAXIPM"),
        ("FEDRAT/DPM,100", "DPM"),
        ("FEDRAT/250,100,MMPM", "no feed"),
        ("FEDRAT/0.1,IPR,MMPM", "no feed"),
        ("SPINDL/INCR,500", "INCR"),
        ("SPINDL/5000,REVERSE", "REVERSE"),
        ("SPINDL/MAXRPM,2000", "without a speed"),
        ("RAPID/ON", "RAPID/ON"),
        ("RAPID/GOTO/9,0,-1", "not known"),
        ("RAPID/5000,MMPM", "not known"),
        ("/GOTO/9,0,-1", "left out"),
        ("OPSKIP/ON", "leave out"),
        ("DELAY/2,MIN", "no time"),
        ("LOAD/5", "LOAD/5"),
        ("LOAD/HEAD,2", "HEAD"),
        ("AUXFUN/8,9", "one code"),
        ("PITCH/2", "thread"),
        ("OP/THREAD,1,2", "lathe"),
        ("PLUNGE", "PLUNGE"),
        ("ZERO/1", "shifts"),
        ("GOTO/9,0,-1,RAPID", "RAPID, which is not read"),
        ("GODLTA/INCR,5,0,0", "INCR, which is not read"),
        ("INSERT/G0 Z100.", "moves the tool"),
        ("INSERT N10 X20.5 Y3", "moves the tool"),
        ("INSERT/S5000 M3", "switches the spindle"),
        ("INSERT/M6 T2", "changes the tool"),
        ("INSERT/M98 P100", "subprogram"),
        ("INSERT/F500", "feed"),
        ("INSERT/G41D2", "offsets"),
        ("CYCLE/BORE,NODRAG,20,3\nGOTO/9,9,0\nCYCLE/OFF", "NODRAG"),
        ("CYCLE/DRILL,20,3,DWELL,ON\nGOTO/9,9,0\nCYCLE/OFF", "DWELL names no time"),
        ("CYCLE/DRILL,20,-3\nGOTO/9,9,0\nCYCLE/OFF", "below its holes"),
        ("CYCLE/DRILL,20,3\nGODLTA/9,9,0\nCYCLE/OFF", "GODLTA in a drilling cycle"),
        ("RAPID\nNURBS\nCNTRL/0,0,-1,5,0,-1,10,5,-1,15,0,-1", "NURBS in rapid"),
    ],
)
def test_what_would_change_the_path_is_refused_by_name(words: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match=reason) as error:
        read(tmp_path, words)
    assert error.value.line is not None
    assert error.value.line > HEAD.count("\n")


@pytest.mark.parametrize(
    "words", ["INSERT/G91 G28 Z0", "INSERT/G4 X2", "INSERT/M8", "INSERT TOOL D10 R5", "INSERT/G54"]
)
def test_codes_that_move_nothing_in_the_part_are_said(words: str, tmp_path: Path) -> None:
    assert moves(both(tmp_path, words)) == PLAIN


def test_a_feed_read_as_it_is_written(tmp_path: Path) -> None:
    (region,) = both(tmp_path, "fedrat / ipm ,$\n10").regions
    feeds = region.feed[region.move == Move.CUT] * 6e4
    assert feeds.tolist() == pytest.approx([250, 254, 254])
