"""Files of other kinds: named as what they are, with what to export in their place; and no CL file is taken for one."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.foreign import refuse_foreign
from camrob.toolpath.read import read_toolpath

SHARED = Path(__file__).resolve().parents[3] / "shared" / "corpus"
STEP = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('x'),'2;1');\nENDSEC;\n"
FILES = {
    "part.src": ("&ACCESS RVP\n&REL 1\nDEF part ( )\nBAS (#INITMOV,0 )\nEND\n", "KRL"),
    "bare.src": ("DEF bare()\nPTP HOME\nEND\n", "KRL"),
    "main.mod": ("MODULE MainModule\nPROC main()\nMoveL p10,v100,fine,tool0;\nENDPROC\nENDMODULE\n", "RAPID"),
    "part.stp": (STEP, "STEP"),
    "part.stl": ("solid part\n facet normal 0 0 1\n outer loop\n", "STL"),
    "plan.dxf": ("  0\nSECTION\n  2\nHEADER\n", "DXF"),
    "saved.cls": ("<!DOCTYPE html>\n<html><body>TOOL PATH/A</body></html>\n", "HTML"),
    "part.apt": ("PARTNO X\nP1=POINT/0,0,0\nL1 = LINE/P1,ATANGL,30\nFROM/P1\nTLLFT,GOLFT/L1\nFINI\n", "APT source"),
    "part.i": ("%PART G71 *\nN10 G30 G17 X+0 Y+0 Z-20*\nN40 G00 G40 G90 Z+50 M3*\n", "DIN/ISO"),
    "part.pm": ("%PM9001\nN9001\nN1 G17 T1 M6\nN5 G7 B5=15 L1=1\n", "MillPlus"),
    "headed.pm": ("%PM\nN9001 (PART)\nN1 G17 T1 M6\nN8 G2 X50 Y10 I40 J10\n", "MillPlus"),
    "bare.pm": ("N9001\nN1 G17 T1 M6\nN5 G7 B5=15 L1=1\n", "MillPlus"),
    "part.nci": ("1000\n1 0 1 0 0 1 0. 0. 25.\n1050\nMastercam\n0\n40 0. 0. 25. -2 0\n", "NCI"),
    "probe.nc": ("G90 G17\nIF [@100 != 3]\nG1 X5 F100\nEND_IF\nM30\n", "Syntec"),
    "wood.nc": ("% A.nc\nN2 (A)\nN4 L start.up\nN6 G54 G161\nN8 #RTCP ON\nN10 G1 X5 F100\nM30\n", "ISG"),
    "old.mpf": (
        "%MPF  90\nR11=384.553 R12=213.086\nL100\nN10 G0 G90 Z631.6 D0\nN50 G81 R2=8. R3=-38. R10=8.\n",
        "805 to 880",
    ),
    "at.mpf": ("%5\nN1 @371 R52 K2 K0\nN10 G0 G90 Z631.6\n", "805 to 880"),
    "window.nc": ("N9001\nN1 G17\nN2 G98 X-10 Y-10 Z-30 I120 J120 K40\nN6 G0 X10 Y10 Z2\n", "MAHO"),
    "robofil.iso": (
        "G92 X0 Y0\nG60\nG38\nG90\nG39\nG40\nG0 X-17.5 Y39.6\nG41 D0\nG1 X-9.5 Y39.6\nM02\n",
        "wire erosion",
    ),
    "fanuc.wire": ("%\nO1\nG92 X0 Y0 I20.\nM60\nS1 D1\nG41 G1 X5. F3.\nM50\nM30\n%\n", "wire erosion"),
    "sodick.nc": (
        "C001 = 012 016 0215\nH001 = +000000.15\nG90 G92 X0 Y0\nC001 G41 H001\nG01 X5.\nM02\n",
        "wire erosion",
    ),
    "mitsubishi.nc": ("M20\nM80\nM82\nM84\nG90 G92 X0 Y0\nG42 D1 G01 X5.\nM21\nM02\n", "wire erosion"),
    "colon.nc": (":T1 M06\nN20 G90 G71\nN30 G0 X0 Y0 S2000 M03\n", "Acramatic"),
    "duet.gcode": ('G21\nM98 P"tool1.g"\nG0 X0 Y0\n', "RepRapFirmware"),
    "macro.nc": ("%@MACRO\n#1 := 5;\nG01 X10. F100.\nM99;\n", "Syntec"),
    "holes.drl": ("M48\n; KiCad\nFMAT,2\nMETRIC\nT1C0.800\n%\nG90\nG05\nT1\nX10.5Y-20.3\nT0\nM30\n", "Excellon"),
    "top.gbr": ("G04 board*\n%FSLAX46Y46*%\n%MOMM*%\nG01*\nX1000Y200D02*\nM02*\n", "Gerber"),
    "plot.plt": ("IN;SP1;PU0,0;PD1000,0,1000,1000;PU;SP0;\n", "HPGL"),
    "all.zip": ("PK\x03\x04rest", "archive"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_another_kind_is_called_what_it_is(tmp_path: Path, name: str) -> None:
    text, kind = FILES[name]
    path = tmp_path / name
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ToolpathError) as error:
        read_toolpath(path)
    said = str(error.value)
    assert kind in said and name in said and ";" in said and "\n" not in said


@pytest.mark.parametrize("text", ["G21\nG38\nG39\nG0 Z5\nG1 X5 F100\nM30\n", "G21\n(M80 M82)\nM84\nG1 X5 F100\nM30\n"])
def test_wire_erosion_is_known_by_more_than_a_word(text: str) -> None:
    refuse_foreign(text.encode())


@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/corpus is not here")
def test_no_real_cl_file_is_taken_for_one() -> None:
    files = [f for folder in ("cldata", "gcode") for f in (SHARED / folder).iterdir()]
    assert len(files) > 20
    for file in files:
        refuse_foreign(file.read_bytes())
    for file in [*(SHARED / "krl").glob("*.src"), SHARED / "mesh" / "cycloidal.ply"]:
        with pytest.raises(ToolpathError):
            refuse_foreign(file.read_bytes())
