"""What programs of other people were refused for by a wrong reason, or were read wrongly: the reason that is theirs."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.witness.cl import read_story
from camrob.witness.cl.foreign.foreign_cycles import ACROSS
from camrob.witness.happenings import Kind

ISO = "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30.\n"
SIEMENS = "N10 G90 G71 G94\nT1 M6\nS5000 M3\nG0 X30 Y105 Z125\nF100\n"
HEIDENHAIN = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n"


@pytest.mark.parametrize(
    ("name", "text", "line", "match"),
    [
        # Fanuc and alike
        ("s0.nc", ISO.replace("S5000", "S0") + "G1 Z0 F300\nM30\n", 5, "switched on at S0"),
        ("fagor.nc", ISO + "G1 Z-1. F300\nG73 Q45\nX10. Y0\nM30\n", 6, "Fagor's turn of the path"),
        ("zeros.nc", "G21\nG10 L2 P1 X1 Y2 A4 B5 C6\nG92 X0 A0 B3\nM30\n", 5, "nothing is cut"),
        ("tap.nc", ISO + "G33.1 Z-1. K0.5\nM30\n", 5, "which needs a spindle coupled to the feed .G33.1. is not read"),
        ("arc.nc", ISO + "G1 Z0 F300\nG2 X2000. I999.5\nM30\n", 6, "1.0000 mm apart in radius"),
        ("s4.nc", ISO + "G4 S3\nG1 Z0 F300\nM30\n", 5, "seconds on printers' controls"),
        (
            "boring.nc",
            ISO + "G1 Z0. F300\nM19\nG0 X0.2\nZ-16.\nM3\nG1 Z-15. F50\nM30\n",
            8,
            "held at an angle .M19 in line 6",
        ),
        ("g53.nc", ISO + "G1 Z-1. F300\nX20.\nG53 X-100.\nG0 Z30.\nM30\n", 7, "a cut to a machine position"),
        (
            "eob.nc",
            "O1\n" + ISO + "G1 Z-1. F300; X20. Y5. ;\nG0 Z30.\nM30\n",
            6,
            r"a block behind a semicolon \(X20. Y5",
        ),
        ("num.nc", ISO + "G81 X20 Y20 Z-12 ER2 F100\nM30\n", 5, "a word of NUM's controls"),
        ("selca.nc", ISO + "G X10 Y0\nM30\n", 5, "G without a number"),
        ("osp.min", "$OKUMA.SSB%\nOSTRT\nG0 X1\nRTS\n", 2, "block names of OSP"),
        # Siemens: known without %_N_, too
        ("case.mpf", "DEF INT A=5\nCASE(A) OF 5 GOTOF L1 DEFAULT GOTOF L2\nL1: G0 X1\nL2: G0 X2\nM30\n", 2, "CASE"),
        ("sub.spf", "PROC RING(REAL RADIUS)\nG1 X=RADIUS F100\nRET\n", 1, "called with values"),
        ("call.mpf", "G0 G90 X0 Y0\nRING_OUT(1,2.5,25)\nM30\n", 2, r"RING_OUT\(...\) is called"),
        ("across.mpf", SIEMENS + "G18\nCYCLE81(112,102,3,80)\nM30\n", 7, "CYCLE81 in G18 or G19"),
        ("holes.mpf", SIEMENS + "G18\nMCALL CYCLE81(112,102,3,80)\nHOLES1(0,0,0,5,9,3)\nM30\n", 8, "G18 or G19"),
        # Heidenhain: a parameter that is the user's is none of the control's
        ("pgm.h", HEIDENHAIN + "3 Q1840 = 1\n4 CALL PGM TNC:PLAN.H\n5 M30\n6 END PGM A MM\n", 5, "CALL PGM"),
        ("own.h", HEIDENHAIN + "3 Q150 = 1\n4 M30\n5 END PGM A MM\n", 4, "a parameter of the control's own"),
    ],
)
def test_a_program_is_refused_for_what_it_is(tmp_path: Path, name: str, text: str, line: int, match: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match) as error:
        read_toolpath(tmp_path / name, spindle_rpm=9000.0)
    assert f"{name}:{line}: " in str(error.value)


def test_the_witness_does_not_drill_across_the_tool_either(tmp_path: Path) -> None:
    file = tmp_path / "a.mpf"
    file.write_text(SIEMENS + "G18\nMCALL CYCLE81(112,102,3,80)\nX0\nMCALL\nG0 Z130\nM30\n", encoding="utf-8")
    (gap,) = read_story(file).gaps
    assert ACROSS in gap.text and gap.first_line == 8


def test_the_set_ups_spindle_starts_also_where_no_cut_could_be_read(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    file.write_text("G21 G90 G17\nG0 X0 Y0 Z0\nG2 X200. I99.96 F300\nM30\n", encoding="utf-8")
    story = read_story(file, default_rpm=9000.0)
    assert story.gaps and [(e.kind, e.value) for e in story.events] == [(Kind.SPINDLE_ON, 9000.0)]


def test_a_printers_message_is_one_and_m19_at_a_tool_change_does_no_harm(tmp_path: Path) -> None:
    text = (
        ISO
        + "M117 Contour 2\nN5 M117 LAYER X5\nG1 Z0. F300\nX5.\nG0 Z30. M19\nX50.\nT2 M6\nM3\nG0 Z1.\nG1 Z0.\nG0 Z30.\nM30\n"
    )
    (tmp_path / "a.nc").write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.nc"), read_story(tmp_path / "a.nc")
    assert [gap.text for gap in story.gaps] == ["M19: not known"] and len(toolpath.regions) == 2


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.mpf", '%_N_A_MPF\nG18 G90 G95\nT="ROUGH" D1\nG96 S200 M4\nG0 X54 Z2\nT="THREAD" D1\nM30\n'),
        ("b.mpf", '%_N_B_MPF\nG17 G90\nT="MILL" D1\nG0 X1 Y2\nT="ROUGH" D1\nLIMS=2000\nM30\n'),
        ("c.mpf", '%_N_C_MPF\nG18 G90\nT1 D1\nG0 X5 Y0\nCYCLE95("A",2,0.4)\nM30\n'),
        ("d.h", "BEGIN PGM D MM\nFUNCTION MODE TURN\nL X+5 Y+0 FMAX\nEND PGM D MM\n"),
    ],
)
def test_turning_is_named_before_its_tools(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ToolpathError, match="a turning program"):
        read_toolpath(tmp_path / name)
