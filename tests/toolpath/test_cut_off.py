"""A file that ends in the middle of a point is refused: half a number is another number."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath

APT = "UNITS/MM\nSPINDL/RPM,9000,CLW\nFEDRAT/MMPM,300\nGOTO/0,0,5,0,0,1\nGOTO/60,0,5\n"
GCODE = "G21 G90 G17 G54\nS9000 M3\nG0 X0. Y0. Z9.\nG1 Z5. F300.\nX60. F900.\n"
PLAIN = "BEGIN PGM A MM\nTOOL CALL 1 Z S9000\nL X+0 Y+0 Z+5 R0 FMAX M3\nL X+60 F900\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.cls", APT + "GOTO/60,0,5"),
        ("a.cls", APT + "GOTO/60,"),
        ("a.nc", GCODE + "Y1.5"),
        ("a.nc", GCODE + "N50 G1 X10. Y-"),
        ("a.nc", GCODE + "(a comment)\r\nX3."),
        ("a.h", PLAIN + "L X+60 Z+1"),
    ],
)
def test_a_point_without_a_line_end_is_refused(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8", newline="")
    with pytest.raises(ToolpathError) as refused:
        read_toolpath(tmp_path / name)
    assert refused.value.path == tmp_path / name and refused.value.line == text.count("\n") + 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.cls", APT + "GOTO/60,0,5\n"),
        ("a.cls", APT + "GOTO/60,0,5\r"),
        ("a.cls", APT + "FINI"),
        ("a.cls", APT + "GOTO/60,0,5 $$ home"),
        ("a.nc", GCODE + "Y1.5\n"),
        ("a.nc", GCODE + "M30"),
        ("a.nc", GCODE + "G0 Z50. M30"),
        ("a.nc", GCODE + "M5\nM2\n%"),
        ("a.h", PLAIN + "END PGM A MM"),
    ],
)
def test_what_ends_as_files_do_is_read(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8", newline="")
    assert read_toolpath(tmp_path / name).points >= 2
