"""What machines' own programs hold and nobody writes on purpose: rotary axes sent home, empty words, commands to the control."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

CUT = "S2000 M3\nG0 X10 Y10 Z10\nG1 Z-1 F250\nX20\nG0 Z60\nM30\n"
HOME = 'G17 G710 G90 G94\nSUPA G0 Z=-10 D0\nSUPA X=0 Y=0 {} D1\nT="X" M6\nG54\nCYCLE800()\n' + CUT


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("supa.mpf", HOME.format("A=0 C=0")),
        ("named.mpf", "DEF REAL _A\n_A=0\n" + HOME.format("A=_A C=_A")),
        ("g53.nc", "G21 G90 G17\nG53 G0 A0. C0.\nT1 M6\nG54\n" + CUT.replace("10 ", "10. ")),
        ("g28.nc", "G21 G90 G17\nG0 A30. C0.\nG91 G28 Z0\nG28 A0. C0.\nG90\nT1 M6\nG54\n" + CUT),
    ],
)
def test_rotary_axes_at_the_machines_zero_stand_upright(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    (region,) = read_toolpath(tmp_path / name).regions
    assert region.axis[-1].tolist() == [0.0, 0.0, 1.0]
    assert read_story(tmp_path / name).gaps == ()
    assert [round(x * 1e3, 9) for x in region.position[region.move == Move.CUT][-1]] == [20.0, 10.0, -1.0]


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("supa.mpf", HOME.format("A=30 C=0"), 9),
        ("turned.mpf", HOME.format("A=0 C=90"), 9),
        ("g30.nc", "G21 G90 G17\nG0 A0. C0.\nG30 A0.\nT1 M6\nG54\n" + CUT, 8),
        ("bare.nc", "G21 G90 G17\nG0 A30. C0.\nG28\nT1 M6\nG54\n" + CUT, 8),
    ],
)
def test_rotary_axes_at_another_machine_position_are_not_known(tmp_path: Path, name: str, text: str, line: int) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match="or at a machine position") as error:
        read_toolpath(tmp_path / name)
    assert f"{name}:{line}: " in str(error.value)
    with pytest.raises(ToolpathError, match=rf"\(line {line}: a cut whose place in the part is not known\)"):
        read_story(tmp_path / name)


def test_empty_words_of_a_klartext_block_leave_things_as_they_are(tmp_path: Path) -> None:
    rows = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000\n2 L X+0 Y+0 R0 FMAX M3\n3 L Z+5 R F MAX M\n4 L Z-1 R F200 M\n"
    file = tmp_path / "a.h"
    file.write_text(rows + "5 L X+10 R F M\n6 L Y+5 R F M9\n7 L Z+5 FMAX\n8 L M30\n9 END PGM A MM\n", encoding="utf-8")
    (region,) = read_toolpath(file).regions
    cut = region.move == Move.CUT
    assert (region.position[cut] * 1e3).round(9).tolist() == [[0, 0, -1], [10, 0, -1], [10, 5, -1]]
    assert set(region.feed[cut].round(12).tolist()) == {round(0.2 / 60, 12)}


@pytest.mark.parametrize(
    ("text", "line", "match"),
    [
        ("$I\n$$\nG21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM2\n", 1, r"a command to the control itself \(Grbl\)"),
        ("?\nG21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM2\n", 1, r"a command to the control itself \(Grbl\)"),
        ("G21 G90\nG0 Z5\nG0 @20 ^0\nG1 Z-1 F100\nM2\n", 3, "polar words"),
        ("G21 G90\n#1=20\nG0 Z5\nG0 @#1 ^[#1*2]\nG1 Z-1 F100\nM2\n", 4, "polar words"),
        ("G21\nG18 G8\nG0 X13 Z1 S1000 M3\nG1 X-1 F50\nM2\n", 2, "a turning program .G18 G8"),
        ("G21\nG0 X13 Z1 S1000 M3\nG33 Z-20 K1.5\nG1 X20 F50\nM2\n", 3, "a turning program .G33 Z-20 K"),
    ],
)
def test_what_is_no_milling_block_is_said_by_name(tmp_path: Path, text: str, line: int, match: str) -> None:
    (tmp_path / "a.ngc").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match) as error:
        read_toolpath(tmp_path / "a.ngc")
    assert f"a.ngc:{line}: " in str(error.value)


@pytest.mark.parametrize(
    ("block", "match"), [("G16 H0", "Okuma's machine coordinates"), ("G62 X1 Y0", "by which Okuma's controls mirror")]
)
def test_okumas_words_that_are_other_things_on_fanucs_controls(tmp_path: Path, block: str, match: str) -> None:
    text = "G21 G90 G17\nT1 M6\nG54\n" + CUT.replace("X20\n", f"X20\n{block}\nX12 Y6\n")
    (tmp_path / "a.nc").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(tmp_path / "a.nc")
    assert not read_story(tmp_path / "a.nc").complete
    (tmp_path / "a.nc").write_text(text.replace(f"{block}\n", "G62\n"), encoding="utf-8")
    assert read_story(tmp_path / "a.nc").complete and read_toolpath(tmp_path / "a.nc").points
