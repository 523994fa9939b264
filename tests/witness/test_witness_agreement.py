"""Programs of many controls from their manuals' rules: camrob and the witness both read the path that was worked out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story
from camrob.witness.happenings import Kind, Story

ISO = "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0. Y0. Z20.\n"
SIEMENS = "%_N_A_MPF\nG90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X=0 Y0 Z20\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y+0 Z+20 R0 FMAX M3\n"
APT = "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nFEDRAT/300,MMPM\nRAPID\nGOTO/0,0,20\n"


def both(folder: Path, name: str, text: str, **options) -> tuple[Toolpath, Story]:
    """The two readings, which have to be one."""
    file = folder / name
    file.write_text(text)
    path, story = read_toolpath(file, chord_tolerance=1e-6, **options), read_story(file)
    assert story.complete, story.gaps
    assert differences(path, story) == []
    return path, story


def cuts(path: Toolpath) -> list[list[float]]:
    """Ends of the straight cuts and the points of arcs, mm."""
    found = [region.position[region.move == Move.CUT] * 1e3 for region in path.regions]
    return (np.concatenate(found).round(6) + 0.0).tolist()


def happened(path: Toolpath) -> list[tuple[str, float]]:
    return [(e.kind.name, e.value) for region in path.regions for e in region.events]


# -- where the two readings differed


def test_a_subprograms_own_names_are_gone_behind_it(tmp_path: Path) -> None:
    sub = "%_N_RING_SPF\nPROC RING\nDEF REAL WAY=7\nWAY=WAY+1\nG1 X=WAY F60\nM17\n"
    body = "DEF REAL WAY=3\nRING P2\nG1 Y=WAY\nM30\n"
    path, _ = both(tmp_path, "a.mpf", SIEMENS + body + sub)
    assert cuts(path) == [[8, 0, 20], [8, 3, 20]]
    file = tmp_path / "b.mpf"
    file.write_text(SIEMENS + "RING\nG1 Y=WAY\nM30\n" + sub)
    with pytest.raises(ToolpathError, match="WAY"):
        read_toolpath(file)


def test_what_starts_in_the_block_of_a_cycles_call_starts_before_it(tmp_path: Path) -> None:
    hole = "3 CYCL DEF 200 DRILLING Q200=2 Q201=-6 Q206=120 Q203=+0 Q204=10 Q202=9 Q210=0 Q211=0\n"
    path, _ = both(tmp_path, "a.h", KLARTEXT + hole + "4 CYCL CALL M8\n5 M30\n6 END PGM A MM\n")
    (wet,) = [e for e in path.regions[0].events if e.kind is EventKind.COOLANT_ON]
    assert path.regions[0].position[wet.point, 2] == pytest.approx(0.002)


def test_a_feed_without_its_unit_counts_as_the_one_before(tmp_path: Path) -> None:
    path, _ = both(tmp_path, "a.apt", APT + "FEDRAT/.1,MMPR\nGOTO/0,0,0\nFEDRAT/.2\nGOTO/9,0,0\nFINI\n")
    assert (path.regions[0].feed[-2:] * 6e4).tolist() == pytest.approx([300, 600])
    (tmp_path / "b.apt").write_text(
        APT.replace("MM\n", "INCH\n", 1) + "FEDRAT/.1,MMPR\nGOTO/0,0,0\nFEDRAT/.2\nGOTO/9,0,0\nFINI\n"
    )
    with pytest.raises(ToolpathError, match="names no unit"):
        read_toolpath(tmp_path / "b.apt")


def test_feeds_in_both_units_say_nothing_of_lengths(tmp_path: Path) -> None:
    text = "FEDRAT/10,IPM\nGOTO/0,0,0\nFEDRAT/MMPM,10\nGOTO/9,0,0\nFINI\n"
    (tmp_path / "a.apt").write_text(text)
    with pytest.raises(ToolpathError, match="in millimetres and in inches") as error:
        read_toolpath(tmp_path / "a.apt")
    assert "--units" in error.value.hint
    for units, feeds in (("mm", [10, 10]), ("inch", [254, 10])):  # of a file that is wrong about its unit, the slower
        story = read_story(tmp_path / "a.apt", units=units)
        (region,) = read_toolpath(tmp_path / "a.apt", units=units).regions
        assert (story.feed * 6e4).tolist() == pytest.approx(feeds) and region.feed * 6e4 == pytest.approx(feeds)


def test_t_changes_the_tool_where_nothing_else_does(tmp_path: Path) -> None:
    text = "G21 G90 G17 G94\nT1\nS5000 M3\nG0 X0. Y0. Z20.\nG1 Z0. F60\nG0 Z20.\nT2\nS4000 M3\nG1 Z1.\nG0 Z20.\nM30\n"
    path, story = both(tmp_path, "a.nc", text)
    assert [r.tool for r in path.regions] == [1, 2]
    assert [(e.before, e.value) for e in story.events if e.kind is Kind.TOOL] == [(0, 1), (3, 2)]
    both(tmp_path, "a.mpf", SIEMENS.replace(" M6", "") + "G1 Z0 F60\nG0 Z20\nT2\nS4000 M3\nG1 Z1\nG0 Z20\nM30\n")


def test_a_tool_that_is_put_away_is_no_change_and_cuts_nothing(tmp_path: Path) -> None:
    body = "G1 Z0. F60\nG0 Z20.\nM5\nT0 M6\n"
    both(tmp_path, "a.nc", ISO + body + "M30\n")
    _, story = both(tmp_path, "b.nc", ISO + body + "T1 M6\nM3\nG1 Z1.\nM30\n")
    assert [e.value for e in story.events if e.kind is Kind.TOOL] == [1, 1]
    (tmp_path / "c.nc").write_text(ISO + body + "M3\nG1 Z1.\nM30\n")
    assert [gap.text for gap in read_story(tmp_path / "c.nc").gaps] == ["a cut without a tool, which was put away"]
    with pytest.raises(ToolpathError, match="without a tool"):
        read_toolpath(tmp_path / "c.nc")
    both(tmp_path, "d.apt", APT + "GOTO/0,0,0\nRAPID\nGOTO/0,0,20\nUNLOAD/TOOL,1\nFINI\n")


def test_a_block_that_changes_the_tool_first_switches_off(tmp_path: Path) -> None:
    _, story = both(tmp_path, "a.nc", ISO + "M8\nG1 Z0. F60\nG0 Z20.\nM5 M9 T2 M6\nM3\nG1 Z1.\nG0 Z20.\nM30\n")
    assert [e.kind for e in story.events if e.before == 3] == [
        Kind.SPINDLE_OFF,
        Kind.COOLANT_OFF,
        Kind.TOOL,
        Kind.SPINDLE_ON,
    ]


def test_a_speed_behind_a_change_starts_no_spindle(tmp_path: Path) -> None:
    _, story = both(tmp_path, "a.nc", ISO + "G1 Z0. F60\nG0 Z20.\nT2 M6\nS4000\nG0 X5.\nM3\nG1 Z1.\nM30\n")
    assert [(e.before, e.value) for e in story.events if e.kind is Kind.SPINDLE_ON] == [(0, 5000), (4, 4000)]


def test_turrets_and_senses_of_apt(tmp_path: Path) -> None:
    path, _ = both(tmp_path, "a.apt", APT.replace("CLW", "CCW") + "TURRET/LEFT\nGOTO/0,0,0\nFINI\n")
    assert happened(path) == [("TOOL_CHANGE", 1), ("SPINDLE_ON", 3000)]
    number = APT.replace("LOADTL/1", "TOOLNO/1,MILL\nCUTTER/10")
    path, _ = both(
        tmp_path, "b.apt", number + "GOTO/0,0,0\nRAPID\nGOTO/0,0,20\nTOOLNO/2,MILL\nCUTTER/6\nGOTO/0,0,1\nFINI\n"
    )
    assert [r.tool for r in path.regions] == [1, 2]
    wide = APT.replace("LOADTL/1", "CUTTER/10")
    path, _ = both(tmp_path, "c.apt", wide + "GOTO/0,0,0\nRAPID\nGOTO/0,0,20\nCUTTER/6\nGOTO/0,0,1\nFINI\n")
    assert len(path.regions) == 2


@pytest.mark.parametrize("pair", ["G20 G21", "G90 G91", "G17 G19", "G94 G95", "G98 G99", "G90.1 G91.1"])
def test_two_modes_of_a_group_in_a_block_are_refused(tmp_path: Path, pair: str) -> None:
    (tmp_path / "a.nc").write_text(ISO + f"{pair}\nG1 Z1. F60\nM30\n")
    with pytest.raises(ToolpathError, match="in one block"):
        read_toolpath(tmp_path / "a.nc")


def test_what_a_stop_switches_off_stands_when_the_operator_comes(tmp_path: Path) -> None:
    path, story = both(
        tmp_path, "a.h", KLARTEXT + "3 L Z+0 F60\n4 STOP M5 M9\n5 L Z+20 FMAX M3\n6 L Z+1\n7 M30\n8 END PGM A MM\n"
    )
    assert [kind for kind, _ in happened(path)][2:5] == ["SPINDLE_OFF", "STOP", "SPINDLE_ON"]
    assert [e.kind for e in story.events if e.before == 2][-2:] == [Kind.STOP, Kind.SPINDLE_ON]


def test_the_feed_of_a_tools_call_holds_behind_a_cycle(tmp_path: Path) -> None:
    hole = "3 CYCL DEF 200 DRILLING Q200=2 Q201=-6 Q206=120 Q203=+0 Q204=10 Q202=9 Q210=0 Q211=0\n4 CYCL CALL\n"
    text = KLARTEXT.replace("S5000", "S5000 F300") + hole + "5 L X+5\n6 M30\n7 END PGM A MM\n"
    path, _ = both(tmp_path, "a.h", text)
    assert path.regions[0].feed[-1] * 6e4 == pytest.approx(300)


def test_a_hole_is_approached_at_the_height_at_which_it_is_left(tmp_path: Path) -> None:
    cycle = "GOTO/-9,0,3\nCYCLE/DRILL,DEPTH,5,MMPM,90,CLEAR,2,RETURN,12\nGOTO/9,0,0\nCYCLE/OFF\nFINI\n"
    path, _ = both(tmp_path, "a.apt", APT + cycle)
    ends = (path.regions[0].position * 1e3).round(9).tolist()
    assert ends[2:] == [[-9, 0, 12], [9, 0, 12], [9, 0, 2], [9, 0, -5], [9, 0, 12]]


# -- deep holes, by the manuals: where each bite ends


@pytest.mark.parametrize(
    ("cycle", "bites", "most", "out"),
    [
        ("CYCLE83(20,0,2,-3,,-9,,0,0.5,0,1,1)", [-3], None, True),
        (
            "203 Q200=2 Q201=-8 Q206=90 Q202=4 Q210=0 Q203=0 Q204=20 Q212=0 Q213=0 Q205=0 Q208=99999",
            [-4, -8],
            (6, 4),
            True,
        ),
    ],
)
def test_deep_holes_bite_by_bite(
    tmp_path: Path, cycle: str, bites: list[float], most: tuple[float, float] | None, out: bool
) -> None:
    if cycle.startswith("203"):
        name, text = "a.h", KLARTEXT + f"3 CYCL DEF {cycle}\n4 CYCL CALL\n5 M30\n6 END PGM A MM\n"
    else:
        name, text = "a.mpf", SIEMENS + f"F200\n{cycle}\nM30\n"
    path, story = both(tmp_path, name, text)
    lowest, found = 0.0, []
    for _, _, z in cuts(path):
        if z < lowest:
            found, lowest = [*found, z], z
    assert found == bites
    pecks = [(round(p.first * 1e3, 9), round(p.others * 1e3, 9), p.out) for p in story.pecks.values()]
    assert pecks == ([] if most is None else [(*most, out)])


def test_a_datum_that_moves_on_from_where_it_is(tmp_path: Path) -> None:
    body = "3 CYCL DEF 7.0 DATUM SHIFT\n4 CYCL DEF 7.1 X+10\n5 CYCL DEF 7.0 DATUM SHIFT\n6 CYCL DEF 7.1 IX+5\n7 L X+1 Y+2 F90\n"
    path, _ = both(tmp_path, "a.h", KLARTEXT + body + "8 M30\n9 END PGM A MM\n")
    assert cuts(path) == [[16, 2, 20]]


# -- programs of one control each: the ends of their cuts, worked out by hand

FANUC = "%\nO0001\nG21 G90 G17 G94 G40 G49 G80\nT1 M6\nS5000 M3\nG54\nG0 X0. Y0. Z20.\n"
OWN = {
    # increments, planes and words that stay: from (0, 0, 20) by 5 in X twice, then a half circle in ZX about its middle
    "g91.nc": (
        FANUC + "G91 G1 X5. F100.\nX5.\nG18 G2 X10. Z0. R5.\nG17 G90\nM30\n%\n",
        [[5, 0, 20], [10, 0, 20], [20, 0, 20]],
    ),
    # G52 moves the program's zero, and takes itself back; G54 said again moves nothing
    "g52.nc": (FANUC + "G52 X10. Y-5.\nG1 X0. Y0. F100.\nG52 X0. Y0.\nG54\nX1.\nM30\n%\n", [[10, -5, 20], [1, -5, 20]]),
    # inch and millimetres in one program
    "g20.nc": (FANUC + "G20\nG1 X1. F10.\nG21\nY10. F100.\nM30\n%\n", [[25.4, 0, 20], [25.4, 10, 20]]),
    # a helix of one turn and a quarter is not one block: a turn (I only), then a quarter
    "turn.nc": (FANUC + "G3 X0. Y0. Z18. I5. J0. F100.\nG3 X5. Y-5. I5. J0.\nM30\n%\n", [[0, 0, 18], [5, -5, 18]]),
    # custom macro B: three holes' places by a loop, and a subprogram with L
    "while.nc": (
        FANUC + "#1=1\nWHILE[#1 LE 3]DO1\nG1 X[#1*10.] Y[10.-#1] F100.\n#1=#1+1\nEND1\n"
        "M98 P0002 L2\nM30\nO0002\nG91\nG1 Z-1.\nG90\nM99\n%\n",
        [[10, 9, 20], [20, 8, 20], [30, 7, 20], [30, 7, 19], [30, 7, 18]],
    ),
    # G98: back to where the first cycle began (20); G99 to R
    "g98.nc": (
        FANUC + "G99 G81 X5. Z-3. R2. F80.\nG98 X9.\nG80\nG1 X0. Z19.\nM30\n%\n",
        [[5, 0, -3], [9, 0, -3], [0, 0, 19]],
    ),
    # a chamfer of 2 before the corner and behind it
    "corner.nc": (FANUC + "G1 X10. ,C2. F100.\nY10.\nM30\n%\n", [[8, 0, 20], [10, 2, 20], [10, 10, 20]]),
    # LinuxCNC: a named parameter, and a block that sets it behind itself
    "words.ngc": (
        "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z20\n#<a>=4\nF100\n#<a>=9 G1 X#<a>\nY[#<a>/3]\n"
        "o1 repeat [2]\nG91 Z-1\no1 endrepeat\n"
        "G90\nM2\n",
        [[4, 0, 20], [4, 3, 20], [4, 3, 19], [4, 3, 18]],
    ),
    # Siemens: IC and AC, a label, REPEAT of it once more
    "ic.mpf": (
        SIEMENS + "F100\nG1 X=IC(4) Y=3\nSTEP: G91 X2\nG90\nREPEAT STEP P=1\nX=AC(0)\nM30\n",
        [[4, 3, 20], [6, 3, 20], [8, 3, 20], [0, 3, 20]],
    ),
    # IC, AC and what G90 or G91 says, axis by axis, in a frame that TRANS has moved
    "mixed.mpf": (
        SIEMENS + "F100\nTRANS X10\nG1 X=IC(4) Y=3\nG91 X=AC(1) Y2\nG90 X2 Y=IC(1) Z=AC(19)\nM30\n",
        [[4, 3, 20], [11, 5, 20], [12, 6, 19]],
    ),
    # ATRANS adds to TRANS; the frame's zero lies at (5, 0, -1), then (5, 2, -1)
    "trans.mpf": (
        SIEMENS + "F100\nTRANS X5 Z-1\nG1 X0 Y0 Z0\nATRANS Y2\nX1 Y1\nTRANS\nX0\nM30\n",
        [[5, 0, -1], [6, 3, -1], [0, 3, -1]],
    ),
    # a FOR that counts to 3, and a condition
    "for.mpf": (
        SIEMENS + "DEF INT NR\nF100\nFOR NR=1 TO 3\nIF NR==2\nG1 Y5\nELSE\nG1 X=NR*2\nENDIF\nENDFOR\nM30\n",
        [[2, 0, 20], [2, 5, 20], [6, 5, 20]],
    ),
    # CR below 0 is the greater part of the circle; its end is what counts here
    "cr.mpf": (SIEMENS + "F100\nG2 X10 Y0 CR=-10\nG1 Z19\nM30\n", [[10, 0, 20], [10, 0, 19]]),
    # a row of three holes at 90 degrees from (2, 1), the first 4 off
    "holes.mpf": (
        SIEMENS + "F80\nMCALL CYCLE81(20,0,2,-5)\nHOLES1(2,1,90,4,3,3)\nMCALL\nG1 X0 Y0\nM30\n",
        [[2, 5, -5], [2, 8, -5], [2, 11, -5], [0, 0, 20]],
    ),
    # Heidenhain: increments by axis, a pole and its angle, a full turn by IPA
    "polar.h": (
        KLARTEXT
        + "3 L IX+5 Y+2 F100\n4 CC X+5 Y+0\n5 LP PR+4 PA+90\n6 CP IPA+360 DR+\n7 LP PR+4 PA+0\n8 M30\n9 END PGM A MM\n",
        [[5, 2, 20], [5, 4, 20], [5, 4, 20], [9, 0, 20]],
    ),
    # a label three times: once as it stands, twice more
    "label.h": (
        KLARTEXT + "3 LBL 1\n4 L IX+2 F100\n5 CALL LBL 1 REP2\n6 M30\n7 END PGM A MM\n",
        [[2, 0, 20], [4, 0, 20], [6, 0, 20]],
    ),
    # Q parameters by FN, and a jump that is taken
    "fn.h": (
        KLARTEXT
        + "3 Q1 = 4\n4 FN 3: Q2 = +Q1 * +3\n5 FN 12: IF +Q1 LT +Q2 GOTO LBL 9\n6 L X+99 F100\n7 LBL 9\n8 L X+Q2 Y-Q1 F100\n"
        "9 M30\n10 END PGM A MM\n",
        [[12, -4, 20]],
    ),
    # inch: BEGIN PGM says it
    "inch.h": (
        KLARTEXT.replace("MM", "INCH", 1) + "3 L X+1 F10\n4 M30\n5 END PGM A INCH\n",
        [[25.4, 0, 508]],
    ),
    # APT: a frame of TRACUT, points in it; a copy one pitch on; GODLTA along the axis
    "tracut.apt": (
        APT + "TRACUT/0,-1,0,10,1,0,0,0,0,0,1,0\nGOTO/1,2,3\nTRACUT/NOMORE\nGOTO/1,2,3\nGODLTA/-2\nFINI\n",
        [[8, 1, 3], [1, 2, 3], [1, 2, 1]],
    ),
    "copy.apt": (
        APT + "INDEX/1\nRAPID\nGOTO/0,0,5\nGOTO/0,0,0\nGOTO/1,0,0\nCOPY/1,TRANSL,0,4,0,2\nFINI\n",
        [[0, 0, 0], [1, 0, 0], [0, 4, 0], [1, 4, 0], [0, 8, 0], [1, 8, 0]],
    ),
    # NX prints a circle's axis the other way round; the frame's Z is the part's X
    "nx.cls": (
        "TOOL PATH/A,TOOL,T\nTLDATA/MILL,10.,0.,75.,0.,0.\nMSYS/0,0,0,0,1,0,0,0,1\nLOAD/TOOL,1\nSPINDL/RPM,3000,CLW\n"
        "RAPID\nGOTO/0,0,20\nFEDRAT/MMPM,100\nGOTO/1,2,3\nEND-OF-PATH\n",
        [[3, 1, 2]],
    ),
    # Creo: DEPTH below the point, CLEAR above it, RETURN where it leaves
    "creo.ncl": (
        "$$*  Pro/CLfile\nUNITS / MM\nLOADTL / 1\nSPINDL / RPM, 900.0, CLW\nRAPID\nGOTO / 0, 0, 20\n"
        "CYCLE / DRILL, DEPTH, 4, MMPM, 90, CLEAR, 1, RETURN, 5\nGOTO / 3, 0, 1\nGOTO / 6, 0, 1\nCYCLE / OFF\nFINI\n",
        [[3, 0, -3], [6, 0, -3]],
    ),
}


@pytest.mark.parametrize("name", OWN)
def test_programs_of_our_own_by_hand(tmp_path: Path, name: str) -> None:
    text, ends = OWN[name]
    path, story = both(tmp_path, name, text)
    told = story.path.tip[story.way != 0] * 1e3
    np.testing.assert_allclose(told, ends, atol=1e-6)
    assert path.points >= len(ends)
