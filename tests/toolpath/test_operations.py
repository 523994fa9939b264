"""Operations that no robot makes by itself: known by their names, and refused with the line that says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath

NX = "TOOL PATH/A,TOOL,T\nTLDATA/{},6,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nFEDRAT/MMPM,100\n"
HEAD = "G21 G90\nT1 M6\nS900 M3\nG0 X0 Y0 Z5\nG1 Z0 F100\n"
LATHE = "%\nO2\nG21 {}\nG0 X52. Z2.\nG1 Z-30. F0.2\nX54.\nM30\n%\n"


@pytest.mark.parametrize(
    ("name", "text", "line", "match"),
    [
        ("a.nc", LATHE.format("\nT0101"), 4, "turning program .T0101"),
        ("a.nc", LATHE.format("G96 S200 M3"), 3, "turning program .G96"),
        ("a.nc", LATHE.format("\nG50 S2500\nG97 S900 M3"), 4, "turning program .G50 S"),
        ("a.nc", LATHE.format("G28 U0 W0"), 3, "turning program .U0"),
        ("a.nc", LATHE.format("\nG71 P10 Q20 U0.4 F0.2"), 4, "turning program .G71 P"),
        ("a.nc", HEAD + "X10,R2\nM30\n", 6, "rounded or chamfered corner"),
        ("a.nc", HEAD + "X10. ,C2.\nM30\n", 6, "rounded or chamfered corner"),
        ("a.nc", HEAD + "G31 Z-5 F9\nM30\n", 6, "probing"),
        ("a.nc", HEAD + "G38.2 Z-5 F9\nM30\n", 6, "probing"),
        ("a.cls", NX.format("TURN,INVERT,PIN") + "GOTO/0,0,0\nEND-OF-PATH\n", 2, "turning operation"),
        ("a.cls", NX.format("GROOVE") + "GOTO/0,0,0\nEND-OF-PATH\n", 2, "turning operation"),
        (
            "a.cls",
            NX.format("MILL") + "GOTO/0,0,9\nPROBE/ON\nGOTO/0,0,0\nPROBE/OFF\nEND-OF-PATH\n",
            6,
            "measures with a probe",
        ),
        (
            "a.ncl",
            "$$* Pro/CLfile Version 8.0\nPARTNO / T\nMACHIN / UNCL01, 1\nGOTO / 5, 0, 2\nFINI\n",
            3,
            "turning file",
        ),
    ],
)
def test_what_is_refused_by_its_name(tmp_path: Path, name: str, text: str, line: int, match: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ToolpathError, match=match) as caught:
        read_toolpath(tmp_path / name)
    assert caught.value.line == line and caught.value.hint and "\n" not in str(caught.value)


def test_milling_with_four_digits_of_a_tool_is_no_turning(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text(HEAD.replace("T1", "T1012") + "X10\nM30\n")
    assert read_toolpath(tmp_path / "a.nc").tools[0].number == 1012


def test_behind_multax_off_a_tilted_axis_is_not_taken_along(tmp_path: Path) -> None:
    text = "PARTNO X\nUNITS/MM\nMULTAX/ON\nFEDRAT/MMPM,100\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0.6,0,0.8\n{}MULTAX/OFF\nGOTO/2,0,0{}\n"
    file = tmp_path / "a.apt"
    file.write_text(text.format("", "") + "FINI\n")
    with pytest.raises(ToolpathError, match="MULTAX was switched off") as caught:
        read_toolpath(file)
    assert caught.value.line == 8
    for back, axis in (("", ",0,0,1"), ("GOTO/1,0,9,0,0,1\n", "")):
        file.write_text(text.format(back, axis) + "FINI\n")
        assert read_toolpath(file).regions[-1].axis[-1].tolist() == [0.0, 0.0, 1.0]
