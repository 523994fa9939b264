"""Programs as they come from shops: set-up sheets before them, words with odd blanks, other line ends, cut short."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import CamrobError, ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n"
CUT = "3 L Z+0 F300\n4 L X+10\n"
END = "8 L Z+40 FMAX\n9 M5\n10 M30\n11 END PGM A MM\n"
ISO = "%\nO1 (A)\nG21 G90 G17\nT1 M6\nS5000 M3\nG0 X0. Y0. Z30.\nG1 Z-1. F500.\nG2 X10. Y0. I5. J0.\nG0 Z30.\nM5\nM30\n%\n"


def _read(tmp_path: Path, name: str, data: bytes):
    (tmp_path / name).write_bytes(data)
    return read_toolpath(tmp_path / name)


def _points(tmp_path: Path, name: str, data: bytes):
    return np.vstack([region.position for region in _read(tmp_path, name, data).regions])


@pytest.mark.parametrize(
    "text",
    [
        '( Sheet\n(   Machine: "DMU"\n' + HEAD + CUT + END,
        HEAD + CUT + "5 CYCL DEF9 .0 IDO\n6 CYCL DEF9.1 V.IDO5\n" + END,
    ],
)
def test_a_sheet_before_the_program_and_a_dwell_in_another_language(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.h").write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))
    waits = [event.value for region in toolpath.regions for event in region.events if event.kind.name == "DWELL"]
    assert waits == ([5.0] if "IDO" in text else [])


REASONS = {
    "a.mpf": ("%_N_A_MPF\nG90 G71 G17\n$P_UIFR[1]=CTRANS(X,1)\nG1 X5 F100\nM30\n", "P_UIFR"),
    "b.nc": ("O1\nG21 G90\nG0 X0. Y0. Z5.\nG1 Z0. F9.\nG6.2 P3 K0. K0. K0. X1. Y1. R1.\nM30\n", "NURBS"),
    "d.nc": ("O1\nG21 G90\nG100 T1 X0. Y0. Z50. S5000 M3 G54\nG1 Z-1. F9\nM30\n", "Brother's G100"),
    "g.nc": ("O1\nG21 G90\nT1 M6\nS9 M3\nG0 X0. Y0. Z5.\nG73 Q30.\nG1 Z0. F9.\nX5.\nM30\n", "Fagor's turn of the path"),
    "e.nc": ("O1\nG21 G90\nG54\nG268 X1. Y0. Z0. I0. J30. K0.\nM30\n", "feature coordinate system"),
    "f.h": (HEAD + "4 CYCL DEF 4.0 POCKET\n" + END, "CYCL DEF 4.0 is not read: how the control cuts it"),
    "h.nc": ("O1\nG21 G90\nG0 X0. Y0. Z5.\nG1 Z0. F9.\nG6.2 P3 K0. X1. Y1. R1.\nM30\n", "NURBS"),
    "i.mpf": ("%_N_A_MPF\nG90 G71 G17\nTRAORI\nG1 X5 A2=10 B2=0 C2=5 F100\nM30\n", "by angles"),
    "j.mpf": ("%_N_A_MPF\nG90 G71 G17\nTRAORI\nG1 X5 LEAD=5 TILT=0 F100\nM30\n", "against the path"),
    "c.h": (HEAD + CUT + "5 CALL PGM TNC:\\PLAN.H\n" + END, "PLAN.H: another program"),
}


@pytest.mark.parametrize("name", REASONS)
def test_the_reason_is_the_true_one(tmp_path: Path, name: str) -> None:
    text, said = REASONS[name]
    with pytest.raises(ToolpathError, match=said):
        _read(tmp_path, name, text.encode())


SAME = {
    "no line ends but CR": lambda text: text.replace("\n", "\r").encode(),
    "CR and LF": lambda text: text.replace("\n", "\r\n").encode(),
    "tabs": lambda text: text.replace(" ", "\t").encode(),
    "small letters": lambda text: text.lower().encode(),
    "a mark of the encoding": lambda text: b"\xef\xbb\xbf" + text.encode(),
    "Latin-1 in a comment": lambda text: text.replace("(A)", "(Fr\xe4sen)").encode("latin-1"),
    "block numbers that begin again": lambda text: "\n".join(
        f"N{(9990 + 10 * k) % 10000} {row}" if row[:1] in "GTSM" else row for k, row in enumerate(text.split("\n"))
    ).encode(),
    "filled up with zeros": lambda text: b"\0" * 100 + text.encode() + b"\0" * 1000,
    "a long comment": lambda text: text.replace("T1 M6", "(x)\n" * 50_000 + "T1 M6").encode(),
}


@pytest.mark.parametrize("case", SAME)
def test_how_a_file_is_written_changes_nothing(tmp_path: Path, case: str) -> None:
    wanted = _points(tmp_path, "plain.nc", ISO.encode())
    found = _points(tmp_path, "other.nc", SAME[case](ISO))
    assert found.shape == wanted.shape and np.allclose(found, wanted)


def test_a_file_cut_short_anywhere_is_read_as_far_as_it_goes_or_refused_in_a_line(tmp_path: Path) -> None:
    whole = _points(tmp_path, "plain.nc", ISO.encode())
    read = 0
    for length in range(0, len(ISO), 3):
        try:
            found = _points(tmp_path, "short.nc", ISO[:length].encode())
        except CamrobError as error:
            assert "\n" not in str(error)
            continue
        read += 1
        assert len(found) <= len(whole)
    assert read  # some of them end behind a whole cut


def test_two_bytes_a_character_is_read_right_or_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(CamrobError) as error:
        _read(tmp_path, "wide.nc", ISO.encode("utf-16"))
    assert "\n" not in str(error.value) and ";" in str(error.value)


def test_words_of_older_heidenhain_programs(tmp_path: Path) -> None:
    """R alone leaves the compensation as it is; M functions with a zero before them; a feed in words of its own."""
    text = HEAD.replace("FMAX M3", "F MAX M03") + "3 L Z+0 R F300\n4 L X+10 R F MAX M09\n" + END.replace("M5", "M05")
    (tmp_path / "a.h").write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))
    assert np.vstack([region.position for region in toolpath.regions])[2] * 1e3 == pytest.approx([10, 0, 0])


def test_blocks_numbered_with_n_from_the_first_one_on(tmp_path: Path) -> None:
    text = "\n".join(f"N{row}" for row in (HEAD + CUT + END).split("\n") if row)
    (tmp_path / "a.h").write_text(f"( Sheet\n{text}\n", encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))


def test_the_second_opinion_reads_no_turn_of_the_path_as_nothing(tmp_path: Path) -> None:
    (tmp_path / "g.nc").write_text(REASONS["g.nc"][0], encoding="utf-8")
    assert "G73" in read_story(tmp_path / "g.nc").gaps[0].text


def test_no_offset_yet_and_then_one(tmp_path: Path) -> None:
    """Siemens' G500 in a program's head, before G54."""
    text = "N10 G17 G90 G94 G71 G500\nT1 D1\nM6\nS5000 M3\nG54\nG0 X0 Y0 Z30\nG1 Z-1 F500\nX10\nG0 Z30\nM30\n"
    (tmp_path / "a.mpf").write_text("%_N_A_MPF\n" + text, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.mpf"), read_story(tmp_path / "a.mpf")
    assert story.complete and not list(differences(toolpath, story))
    behind = text.replace("G0 Z30\nM30", "G0 Z30\nG500\nG0 X5 Y5 Z50\nM30")
    (tmp_path / "a.mpf").write_text("%_N_A_MPF\n" + behind, encoding="utf-8")
    assert not read_story(tmp_path / "a.mpf").complete


def test_a_program_without_an_offset_throughout(tmp_path: Path) -> None:
    """G53 alone before each tool, as a post of NX writes it: the same zero for all, whatever the control takes it for."""
    tool = "T{} M6\nG53\nG0 G90 X{}. Y0. S900 M3\nG43 Z11. H{}\nG1 Z-1. F250.\nX5.\nG0 Z11.\nM5\n"
    (tmp_path / "a.nc").write_text("O1\nG17 G21 G90\n" + tool.format(1, 0, 1) + tool.format(2, 9, 2) + "M2\n", "utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.nc"), read_story(tmp_path / "a.nc")
    assert story.complete and not list(differences(toolpath, story)) and len(toolpath.regions) == 2


@pytest.mark.parametrize(
    ("between", "refused"),
    [("G0 Z500\n", ""), ("G0 X0 Y0 Z5\nG1 Z-1 F99\nG0 Z500\n", "several work offsets")],
)
def test_out_of_no_offset_through_the_air(tmp_path: Path, between: str, refused: str) -> None:
    text = "%_N_A_MPF\nG71 G90 G17 G500\nT1 D1\nM6\nS900 M3\n" + between
    text += "G54\nG0 X0 Y0 Z50\nG1 Z-1 F100\nX50\nG0 Z50\nM30\n"
    (tmp_path / "a.mpf").write_text(text, encoding="utf-8")
    if refused:
        with pytest.raises(ToolpathError, match=refused):
            read_toolpath(tmp_path / "a.mpf")
        return
    toolpath, story = read_toolpath(tmp_path / "a.mpf"), read_story(tmp_path / "a.mpf")
    assert story.complete and not list(differences(toolpath, story))
    assert len(toolpath.regions[0]) == 4


def test_a_file_with_linuxcncs_suffix_has_its_parameters(tmp_path: Path) -> None:
    """#31 to #4999 are the user's own there; Fanuc's macros in such a file stay Fanuc's. As rs274 runs it."""
    text = "G21 G90\n#34=5\n#210=[#34*20]\nG0 X0 Y0 Z10\nG1 Z-1 F#210\n#34=7 G1 X#34\nX#34\nG0 Z10\nM2\n"
    file = tmp_path / "a.ngc"
    file.write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(file), read_story(file)
    assert story.complete and not differences(toolpath, story)
    cut = np.vstack([region.position[region.move == Move.CUT] for region in toolpath.regions]) * 1e3
    np.testing.assert_allclose(cut, [[0, 0, -1], [5, 0, -1], [7, 0, -1]], atol=1e-9)
    macro = tmp_path / "b.ngc"
    macro.write_text(text.replace("X#34\nG0", "IF[#34GT9]GOTO5\nN5X#34\nG0"), encoding="utf-8")
    with pytest.raises(ToolpathError, match="a system variable of Fanuc's"):
        read_toolpath(macro)
