"""Programs of other controls from file to KRL: what the witness does not read it says, and the motions are those meant."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from process_story import KR15, cell_with, posted, text_of
from scipy.spatial.transform import Rotation

from camrob.errors import SetupError, ToolpathError, VerificationError
from camrob.jobs.verify import verify
from camrob.toolpath.gcode import interpreter
from camrob.toolpath.gcode.controls import heidenhain_moves, siemens_words

PLACE = "part_in_base = [0, 0, 200, 0, 0, 0]\n"
MACRO = (
    "%\nO100\nG21 G90 G17 G94\nT1 M6\nS6000 M3\nG0 X0. Y0. Z40.\nG1 Z0 F500.\n#1=0\n"
    "WHILE[#1 LT 4]DO1\nG1 X[10.*COS[#1*90]] Y[10.*SIN[#1*90]]\n#1=#1+1\nEND1\nG0 Z40.\nM5\nM30\n%\n"
)
SIEMENS = (
    "N10 G90 G17 G710 G94\nN20 T1 M6\nN30 S6000 M3\nN40 TRAORI\nN50 G0 X0 Y0 Z40 A3=0 B3=0 C3=1\nN60 G1 Z0 F500\n"
    "N70 X10 A3=0.1 B3=0 C3=1\nN80 G0 Z40\nN90 TRAFOOF\nN100 M5\nN110 M30\n"
)
KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L Z+40 R0 FMAX M3\n3 L X+0 Y+0 FMAX\n4 L Z+0 F500\n5 L X+10\n6 L Z+40 FMAX\n"
    "7 M5\n8 M30\n9 END PGM A MM\n"
)
WORDS = (
    "G21 G90 G17 G94\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\n#1=0\no1 repeat [4]\nG1 X[10*COS[#1]] Y[10*SIN[#1]]\n"
    "#1=[#1+90]\no1 endrepeat\no2 if [#1 gt 360]\nX5\no2 else\nX-5\no2 endif\nG0 Z40\nM5\nM2\n"
)
SIGNED = "G21 G90 G94\nT1 M6\nS6000 M3\nG43.4 H1\nG0 X0 Y0 Z40 A0 C0\nG1 Z0 F500\nX10 A8 C40\nG0 Z40\nG49\nM5\nM30\n"
POINT = re.compile(r"\{E6POS: X (\S+?),Y (\S+?),Z (\S+?),A (\S+?),B (\S+?),C (\S+?)[,}]")


@pytest.mark.parametrize(
    ("name", "text", "lines"),
    [
        ("macro.nc", MACRO.replace("#1=0", "#9=ATAN[-1]/[1]\n#1=0"), "lines 8-17"),
        ("a.mpf", SIEMENS.replace("N70 X10", "N65 R9=7 MOD 4\nN70 X10"), "lines 7-12"),
        ("a.h", KLARTEXT.replace("5 L X+10", "5 Q9 = LN 1\n6 L X+10"), "lines 6-11"),
    ],
)
def test_what_the_witness_does_not_read_is_verified_in_part(tmp_path: Path, name: str, text: str, lines: str) -> None:
    made = posted(tmp_path, name, text, setup=PLACE)
    (said,) = [f for f in made.findings if f.code == "verified-in-part"]
    assert f"{lines}: not read by the second opinion" in said.text
    points = np.array(
        [[float(v) for v in m.groups()] for m in POINT.finditer(next(made.out.glob("*.src")).read_text())]
    )
    far = np.array([0.0, 10.0, 200.0]) if name == "macro.nc" else np.array([10.0, 0.0, 200.0])
    assert np.linalg.norm(points[:, :3] - far, axis=1).min() < 0.001


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.mpf", SIEMENS),
        ("a.h", KLARTEXT),
        ("q.h", KLARTEXT.replace("5 L X+10", "5 Q1 = 4 * 2 + 2\n6 L X+Q1")),
        ("v.mpf", SIEMENS.replace("N70 X10", "N65 R1=5 R2=R1*SIN(30)\nN70 X=R1+2*R2")),
        ("r.mpf", SIEMENS.replace("N70 X10 A3=0.1 B3=0 C3=1", "N70 X10 RND=2\nN75 Y9 CHF=1\nN76 X0 CHR=1\nN77 Y0")),
        ("r.h", KLARTEXT.replace("5 L X+10", "5 L X+10\n5 RND R2 F100\n5 L Y+9\n5 CHF 1\n5 L X+0")),
        ("macro.nc", MACRO),
        ("words.ngc", WORDS),
        ("jump.mpf", SIEMENS.replace("N70 X10", "N65 IF 1>0 GOTOF N70\nN68 X99\nN70 X10")),
        ("label.h", KLARTEXT.replace("5 L X+10", "5 LBL 1\n6 L IX+5\n6 CALL LBL 1 REP1")),
        ("t.nc", "G21 G90 G94\nT1\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\nX10\nG0 Z40\nM5\nM30\n"),
        ("t0.nc", "G21 G90 G94\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\nX10\nG0 Z40\nM5\nT0 M6\nM30\n"),
        ("r.nc", "G21 G90\nT1 M6\nS3000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\nX9 ,R2\nY9 ,C1\nX0\nG0 Z40\nM30\n"),
    ],
)
def test_plain_programs_of_siemens_and_heidenhain_are_verified_whole(tmp_path: Path, name: str, text: str) -> None:
    made = posted(tmp_path, name, text, setup=PLACE)
    assert not [f for f in made.findings if f.code == "verified-in-part"] and made.summary.witness.complete


@pytest.mark.parametrize("text", [MACRO, WORDS, KLARTEXT.replace("5 L X+10", "5 LBL 1\n6 L IX+5\n6 CALL LBL 1 REP1")])
def test_a_turn_of_a_loop_too_few_or_another_branch_is_refused(tmp_path: Path, text: str) -> None:
    """Each cut of the written program left out, and each moved 1 mm, in turn: none passes."""
    name = "a.h" if text.startswith("0 BEGIN") else "a.nc"
    made = posted(tmp_path, name, text, setup=PLACE)
    (source,) = made.out.glob("*.src")
    lines = source.read_text().splitlines(keepends=True)
    assert made.summary.witness.complete
    cuts = [i for i, line in enumerate(lines) if line.startswith(("LIN {", "LIN_REL", "SLIN"))]
    assert len(cuts) >= 2
    for i in cuts:
        moved = re.sub(r"X (-?[\d.]+)", lambda found: f"X {float(found[1]) + 1.0:.4f}", lines[i], count=1)
        for other in ("", moved):
            source.write_text("".join([*lines[:i], other, *lines[i + 1 :]]))
            assert not verify(
                source, cell=KR15, against=tmp_path / "in" / name, setup=tmp_path / "in" / "setup.toml"
            ).summary.ok


@pytest.mark.parametrize(
    ("name", "text", "owner", "function", "fault"),
    [
        ("a.mpf", SIEMENS, siemens_words, "signed", lambda reader: -(reader.number() or 0.0)),
        (
            "a.h",
            KLARTEXT,
            heidenhain_moves.HeidenhainMoves,
            "_place",
            lambda self, words: {"X": 7.0, "Y": 0.0, "Z": 5.0},
        ),
    ],
)
def test_a_fault_of_the_reader_is_not_released(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, text: str, owner: object, function: str, fault: object
) -> None:
    monkeypatch.setattr(owner, function, fault)
    with pytest.raises((ToolpathError, VerificationError)):
        posted(tmp_path, name, text, setup=PLACE)


def test_rotary_words_by_iso_841_are_verified_whole(tmp_path: Path) -> None:
    made = posted(tmp_path, "signed.nc", SIGNED, setup=PLACE + 'dialect = "gcode-xyzac-iso"\n')
    assert not [f for f in made.findings if f.code == "verified-in-part"]
    points = np.array(
        [[float(v) for v in m.groups()] for m in POINT.finditer(next(made.out.glob("*.src")).read_text())]
    )
    axes = Rotation.from_euler("ZYX", points[:, 3:], degrees=True).apply([0, 0, 1])
    wanted = Rotation.from_euler("ZX", [40, 8], degrees=True).apply([0, 0, 1])
    at = np.linalg.norm(points[:, :3] - [10.0, 0.0, 200.0], axis=1).argmin()
    assert abs(abs(float(axes[at] @ wanted)) - 1.0) < 1e-6


WORN = "G21 G90 G17\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\nG41 D1 X10\nY5\nG40 X0\nG0 Z40\nM5\nM30\n"


def _folder(path: Path, name: str) -> Path:
    (path / name).mkdir()
    return path / name


def test_a_compensated_path_is_posted_where_the_set_up_says_wear_and_verified_whole(tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match="would offset the path"):
        posted(_folder(tmp_path, "without"), "worn.nc", WORN, setup=PLACE)
    made = posted(_folder(tmp_path, "with"), "worn.nc", WORN, setup=PLACE + 'cutter_compensation = "wear"\n')
    assert {"cutter-compensation"} == {f.code for f in made.findings} & {"cutter-compensation", "verified-in-part"}
    with pytest.raises(SetupError, match="cutter_compensation"):
        posted(_folder(tmp_path, "other"), "worn.nc", WORN, setup=PLACE + 'cutter_compensation = "control"\n')


def test_a_path_that_a_control_would_offset_is_not_released_where_the_reader_lets_it_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interpreter, "compensate", lambda block, modal, path: None)
    with pytest.raises(VerificationError, match=r"not released.*offset by the tool's radius"):
        posted(tmp_path, "worn.nc", WORN, setup=PLACE)


HEAD = "N10 G90 G17 G710 G94\nN20 T1 M6\nN30 S2000 M3\nN35 F100\nN50 G0 X=0 Y0 Z40\n"
HOLES = "MCALL CYCLE82(40,0,2,-5,,0.5)\nHOLES1(1,2,30,5,10,3)\nHOLES2(0,0,12,90,0,3)\nMCALL\n"
KEY = KLARTEXT.partition("4 L")[0].replace("S6000", "S2000 F300")
ENDS = "8 L Z+40 FMAX M5\n9 M30\n9 END PGM A MM\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("holes.mpf", HEAD + HOLES + "G0 Z40\nM5\nM30\n"),
        ("tap.mpf", HEAD + "CYCLE84(40,0,2,-5,,,,,1,,1500,1500)\nX9\nCYCLE840(40,0,2,-5,,,4,3,1,6)\nG0 Z40\nM5\nM30\n"),
        ("tap.h", KEY + "4 CYCL DEF 207 T Q200=2 Q201=-5 Q239=1 Q203=0 Q204=20\n5 L X+5 FMAX M99\n" + ENDS),
        (
            "float.h",
            KEY + "4 CYCL DEF 206 T Q200=2 Q201=-5 Q206=900 Q211=0.5 Q203=0 Q204=20\n5 L X+5 FMAX M99\n" + ENDS,
        ),
        (  # drawn out at a feed above the rapid one, as the file says
            "out.h",
            KEY + "4 CYCL DEF 203 D Q200=3 Q201=-9.041 Q206=68 Q202=1 Q210=0 Q203=0 Q204=30 Q212=0 Q213=2 Q205=1 Q211=0"
            " Q208=25000 Q256=0.2\n5 L X+5 FMAX M99\n" + ENDS,
        ),
        (
            "place.h",
            KEY.replace("CALL 1", 'CALL "MILL"')
            + "4 CYCL DEF 200 D Q200=2 Q201=-5 Q206=100 Q202=2 Q210=0 Q203=1 Q204=20"
            " Q211=0\n4 PLANE RESET STAY\n5 CYCL CALL POS X+4 Y+5 Z+0 FMAX M8\n5 CYCL CALL POS X+6 Y+5 Z+0 FMAX\n5 L Z+5 F AUTO\n"
            "5 M9\n" + ENDS,
        ),
    ],
)
def test_patterns_and_taps_are_verified_whole(tmp_path: Path, name: str, text: str) -> None:
    reversing = (
        "^spindle_off = ",
        'spindle_on_ccw = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[3] = TRUE"]\nspindle_off = ',
    )
    made = posted(tmp_path, name, text, setup=PLACE, cell=cell_with(tmp_path, reversing))
    assert not [f for f in made.findings if f.code == "verified-in-part"] and made.summary.witness.complete


def test_the_interrupt_for_stop_messages_is_declared_where_the_cell_asks_for_it(tmp_path: Path) -> None:
    cell = cell_with(tmp_path, ("^act_ex_ax = 2", "act_ex_ax = 2\nstop_message = true"))
    made = posted(tmp_path, "a.mpf", SIEMENS, setup=PLACE, cell=cell)
    text = next(made.out.glob("*.src")).read_text()
    lines = [line.strip() for line in text.splitlines()]
    at = lines.index("GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )")
    assert lines[at - 1 : at + 3] == [";FOLD INI", lines[at], "INTERRUPT ON 3", "BAS (#INITMOV,0 )"]
    assert made.summary.witness.complete and not [f for f in made.findings if f.code == "verified-in-part"]


def test_a_side_that_a_machines_table_turns_up_is_cut_where_it_lies_in_the_part(tmp_path) -> None:
    """In the machine's own axes: its table tilts 85 mm below the program's zero. The rapid between the sides is the robot's."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "mill.toml").write_text(
        '[[table]]\nword = "A"\ndirection = [-1, 0, 0]\npoint_mm = [12, -30, -85]\n'
        '[[table]]\nword = "C"\ndirection = [0, 0, -1]\npoint_mm = [5, 8, 0]\n'
    )
    text = (
        "G21 G90 G17 G94\nT1 M6\nS9000 M3\nG0 X20 Y10 Z60 A0 C0\nG1 Z-2 F400\nX40\nG0 Z120\nG0 A45. C90.\nG0 X30 Y0 Z60\n"
        "G1 Z20 F400\nX45\nY12\nG0 Z120\nM5\nM30\n"
    )
    made = posted(tmp_path, "a.nc", text, setup='machine = "mill.toml"\n' + PLACE)
    points = np.array([row.groups() for row in POINT.finditer(text_of(made))], float)
    on_a, on_c = np.array([12, -30, -85]), np.array([5, 8, 0])
    for a, c, xyz in ((0, 0, (40, 10, -2)), (45, 90, (30, 0, 20)), (45, 90, (45, 0, 20)), (45, 90, (45, 12, 20))):
        about_c = Rotation.from_euler("z", c, degrees=True)  # the part sees the tool turn the other way than the table
        about_a = Rotation.from_euler("x", a, degrees=True)
        tip = about_c.apply(about_a.apply(np.array(xyz) - on_a) + on_a - on_c) + on_c
        tool = about_c.apply(about_a.apply([0, 0, 1]))
        row = points[np.linalg.norm(points[:, :3] - tip - [0, 0, 200], axis=1).argmin()]
        assert np.linalg.norm(row[:3] - tip - [0, 0, 200]) < 0.001
        assert np.linalg.norm(Rotation.from_euler("ZYX", row[3:], degrees=True).apply([0, 0, 1]) - tool) < 1e-5


TURNED = {
    "a.nc": (
        "%\nO1\nG21 G17 G90 G94 G54\nT1 M6\nS6000 M3\nG0 A0 C0\nX0 Y0\nG43 H1 Z50\nG0 A10 C20\nX5 Y-3\nZ45\nG1 Z30 F500\n"
        "X15 Y2 A15 C30\nG91 X5 C5\nG90 G0 Z60\nA12 C33\nX10 Y0\nZ32\nG1 Z28 F300\nG0 Z80\nA0 C0\nM5\nM30\n%\n"
    ),
    "a.mpf": (
        "N1 G17 G710 G90 G94 G54\nN2 T1 D1\nN3 M6\nN4 S6000 M3\nN5 TRAFOOF\nN6 G0 A0 C0\nN7 X0 Y0 Z50\nN8 A=10 C=DC(20)\n"
        "N9 X5 Y-3\nN10 Z45\nN11 G1 Z30 F500\nN12 X15 Y2 A=15 C=30\nN13 G91 X5 C=IC(5)\nN14 G90 G0 Z60\nN15 A12 C33\n"
        "N16 X10 Y0\nN17 Z32\nN18 G1 Z28 F300\nN19 G0 Z80\nN20 A0 C0\nN21 M5\nN22 M30\n"
    ),
    "a.h": (
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 M129\n3 L Z+80 R0 FMAX M3\n4 L A+0 C+0 FMAX\n5 L X+0 Y+0 FMAX\n"
        "6 L Z+50 FMAX\n7 L A+10 C+20 FMAX\n8 L X+5 Y-3 FMAX\n9 L Z+45 FMAX\n10 L Z+30 F500\n11 L X+15 Y+2 A+15 C+30\n"
        "12 L IX+5 IC+5\n13 L Z+60 FMAX\n14 L A+12 C+33 FMAX\n15 L X+10 Y+0 FMAX\n16 L Z+32 FMAX\n17 L Z+28 F300\n"
        "18 L Z+80 FMAX\n19 L A+0 C+0 FMAX\n20 M5\n21 M30\n22 END PGM A MM\n"
    ),
}


@pytest.mark.parametrize("name", TURNED)
def test_a_small_turn_in_rapid_low_above_the_part_is_the_robots_own_way(tmp_path: Path, name: str) -> None:
    """The machine's axes of three controls: the tip swings on a way of the machine's between two places that it names."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "mill.toml").write_text(
        'feed = "linear"\n[[table]]\nword = "A"\ndirection = [-1, 0, 0]\npoint_mm = [0, 0, -120]\n'
        '[[table]]\nword = "C"\ndirection = [0, 0, -1]\npoint_mm = [0, 0, 0]\n'
    )
    made = posted(tmp_path, name, TURNED[name], setup='machine = "mill.toml"\n' + PLACE)
    assert "verified-in-part" not in {f.code for f in made.findings}
    points = np.array([row.groups() for row in POINT.finditer(text_of(made))], float)
    ends = ((10, 20, (5, -3, 30)), (15, 30, (15, 2, 30)), (15, 35, (20, 2, 30)), (12, 33, (10, 0, 28)))
    for a, c, xyz in ends:
        about_a, about_c = (Rotation.from_euler(axis, v, degrees=True) for axis, v in (("x", a), ("z", c)))
        tip = about_c.apply(about_a.apply(np.add(xyz, (0, 0, 120))) - [0, 0, 120])
        tool = about_c.apply(about_a.apply([0, 0, 1]))
        row = points[np.linalg.norm(points[:, :3] - tip - [0, 0, 200], axis=1).argmin()]
        assert np.linalg.norm(row[:3] - tip - [0, 0, 200]) < 0.001
        assert np.linalg.norm(Rotation.from_euler("ZYX", row[3:], degrees=True).apply([0, 0, 1]) - tool) < 1e-5
