"""Words of shops' programs that had a wrong reason or none: cycle 205, jumps out of a label, words cut short, macros alone."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.language import flow
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story

HEAD = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nM3\nL X+0 Y+0 Z+60 FMAX\n"
END = "M30\nEND PGM A MM\n"
PECKING = (
    "CYCL DEF 205 UNIVERSAL PECKING ~\nQ200=+2 ~\nQ201=-30 ~\nQ206=150 ~\nQ202=10 ~\nQ203=+0 ~\nQ204=50 ~\nQ212=2 ~\nQ205=4 ~\n"
    "Q258=0.5 ~\nQ259=1 ~\nQ257=0 ~\nQ256=0.2 ~\nQ211=0.5"
)
AT = "\nL X+50 Y+20 FMAX M99\n"


def _read(folder: Path, name: str, text: str, *, alike: bool = True) -> Toolpath:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(file), read_story(file)
    assert story.complete == alike
    if alike:
        assert not differences(toolpath, story)
    return toolpath


def _heights(toolpath: Toolpath) -> list[tuple[float, int]]:
    """Z in mm and how it is gone to, of all points."""
    return [
        (round(float(z) * 1e3, 6), int(move))
        for region in toolpath.regions
        for z, move in zip(region.position[:, 2], region.move, strict=True)
    ]


def _refused(folder: Path, name: str, text: str, match: str) -> None:
    (folder / name).write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(folder / name)


def test_cycle_205_pecks_as_the_manual_says(tmp_path: Path) -> None:
    """Bites of 10, 8, 6, 4 (Q205) and what is left; back to 0.5 above the first end, 1 above the last but one, evenly between."""
    found = _heights(_read(tmp_path, "a.h", HEAD + PECKING + AT + END))
    ends, above = [-10.0, -18.0, -24.0, -28.0, -30.0], [0.5, 2 / 3, 5 / 6, 1.0]
    expected = [(60.0, 0), (2.0, 0), (ends[0], 1)]
    for end, before, height in zip(ends[1:], ends, above, strict=False):
        expected += [(2.0, 0), (round(before + height, 6), 0), (end, 1)]
    assert found[-len(expected) - 1 :] == [*expected, (50.0, 0)]


@pytest.mark.parametrize(
    ("more", "bites"), [(" ~\nQ208=300", 5), (" ~\nQ208=99999", 5), (" ~\nQ379=0 ~\nQ253=750 ~\nQ395=0", 5)]
)
def test_cycle_205_with_its_later_parameters(tmp_path: Path, more: str, bites: int) -> None:
    toolpath = _read(tmp_path, "a.h", HEAD + PECKING + more + AT + END)
    assert sum(move for _, move in _heights(toolpath)) == bites + ("Q208=300" in more)


BROKEN = {  # Q257: heights at the feed of bites of 10, 8, 6, 4 and 2, and back by 0.2 behind each that ends none of them
    "3": [-3, -6, -9, -10, -13, -16, -18, -21, -24, -27, -28, -30],
    "5": [-5, -10, -15, -18, -23, -24, -28, -30],
    "10": [-10, -18, -24, -28, -30],
}


@pytest.mark.parametrize("every", BROKEN)
def test_cycle_205_breaks_chips_within_its_bites(tmp_path: Path, every: str) -> None:
    found = _heights(_read(tmp_path, "a.h", HEAD + PECKING.replace("Q257=0", f"Q257={every}") + AT + END))
    assert [z for z, move in found if move] == BROKEN[every]
    back = [b - a for (a, cut), (b, _) in pairwise(found) if cut and b < 2.0]
    assert [round(way, 6) for way in back] == [0.2] * (len(BROKEN[every]) - 5)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (("Q257=0", "Q257=-3"), "makes no hole"),
        (("Q257=0", "Q257=0.0001"), "makes no hole"),
        (("Q211=0.5", "Q211=0 ~\nQ379=5"), "a start inside the hole"),
        (("Q258=0.5", "Q258=-0.5"), "makes no hole"),
        (("Q205=4", "Q205=0"), "makes no hole"),
        (("Q259=1 ~\n", ""), "without Q259"),
    ],
)
def test_cycle_205_is_refused_where_it_isnt_that(tmp_path: Path, change: tuple[str, str], match: str) -> None:
    _refused(tmp_path, "a.h", HEAD + PECKING.replace(*change) + AT + END, match)


CHECKED = (
    'FN 0: Q1900=2\nCALL LBL "Check"\nL X+Q1901 F500\nL X+30\nM30\n'
    'LBL "Check"\nFN 9: IF +Q1900 EQU +1 GOTO LBL "One"\nFN 9: IF +Q1900 EQU +2 GOTO LBL "Two"\nLBL 0\n'
    'LBL "One"\nFN 0: Q1901=4\nLBL 0\nLBL "Two"\nFN 0: Q1901=3\nLBL 0\nEND PGM A MM\n'
)


@pytest.mark.parametrize("word", ["MAX", "FMAX", "F MAX"])
def test_a_way_out_in_rapid_as_fusion_writes_it(tmp_path: Path, word: str) -> None:
    """Q208=MAX without its F; the next hole's own value is a feed again."""
    drilling = (
        "CYCL DEF 203 UNIVERSAL DRILLING ~\nQ200=2 ~\nQ201=-10 ~\nQ206=150 ~\nQ202=10 ~\nQ210=0 ~\nQ203=+0 ~\nQ204=50 ~\n"
        "Q212=0 ~\nQ213=0 ~\nQ205=0 ~\nQ211=0 ~\nQ208=WAY ~\nQ256=0.2"
    )
    first = _heights(_read(tmp_path, "a.h", HEAD + drilling.replace("WAY", word) + AT + END))
    assert first[-3:] == [(-10.0, 1), (2.0, 0), (50.0, 0)]
    fed = _heights(_read(tmp_path, "b.h", HEAD + drilling.replace("WAY", "400") + AT + END))
    assert fed[-3:] == [(-10.0, 1), (2.0, 1), (50.0, 0)]


def test_a_jump_out_of_a_label_returns_at_the_next_lbl_0(tmp_path: Path) -> None:
    toolpath = _read(tmp_path, "a.h", HEAD + CHECKED)
    np.testing.assert_allclose(toolpath.regions[0].position[-2:, 0], [0.003, 0.030], atol=1e-12)


def test_a_jump_back_into_the_program_out_of_a_label_is_not_judged(tmp_path: Path) -> None:
    text = HEAD + (
        'FN 0: Q1=0\nLBL 7\nL X+Q1 F500\nFN 1: Q1 = Q1 + 5\nCALL LBL "Sub"\nM30\n'
        'LBL "Sub"\nFN 12: IF +Q1 LT +12 GOTO LBL 7\nLBL 0\nEND PGM A MM\n'
    )
    _read(tmp_path, "a.h", text, alike=False)


@pytest.mark.parametrize(
    ("statement", "match"),
    [
        ("APPR LCT X+10 Y+10 R5 RL F100", "onto or off a contour that the control offsets"),
        ("DEP LT LEN10 R0", "onto or off a contour that the control offsets"),
        ("CYCL DEF 241 DEEP Q200=3", "switches the spindle's speed"),
        ("CYCL DEF 208 BORE Q200=3", "tool's radius"),
    ],
)
def test_why_klartext_is_refused(tmp_path: Path, statement: str, match: str) -> None:
    _refused(tmp_path, "a.h", HEAD + statement + AT + END, match)


SPIRAL = (
    "%\nO1000(MAIN);\nG21 G90 G54;\nG43 H1 G0 Z50.;\nS1000 M3;\nG65 P3003 A0. B-4. S1. D20. R5. F300. X10. Y20. E1.;\nM30;\n%\n"
    "O3003;\nIF[#1LT#2]GO1;\n#4=RO[#7/2.];\nG90G0X#24Y#25;\nG0Z#18;\nG1Z#1F500;\nG91G#8X-#4Y0.F#9;\n"
    "WH[#1GT#2]DO1;\n#1=#1-#19;\nG3X0Y0I#4J0Z-#19;\nEN1;\nN1G90G1X#24Y#25;\nG0Z#18;\nM99;\n%\n"
)


def test_words_of_macros_by_their_first_two_letters(tmp_path: Path) -> None:
    """The same as with the words in full: four turns down a bore of 20 mm."""
    short = _read(tmp_path, "a.nc", SPIRAL)
    words = SPIRAL.replace("GO1", "GOTO1").replace("RO[", "ROUND[").replace("WH[", "WHILE[").replace("EN1", "END1")
    full = _read(tmp_path, "b.nc", words)
    np.testing.assert_array_equal(
        np.vstack([region.position for region in short.regions]),
        np.vstack([region.position for region in full.regions]),
    )
    assert short.regions[0].position[:, 2].min() == pytest.approx(-0.004)


def test_a_macro_alone_asks_for_its_caller(tmp_path: Path) -> None:
    _refused(tmp_path, "a.nc", "%\nO3003\n" + SPIRAL.split("O3003;\n")[1], "#1 is read .*what G65 gives this macro")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.nc", "O1\nG21 G90\nG0 X0 Y0 Z5.\n#1=1\nWHILE[#1LT10]DO1\nG1 X[#1*10] F100\nEND1\nM30\n"),
        ("a.h", HEAD + "LBL 1\nL X+1 F100\nFN 9: IF +1 EQU +1 GOTO LBL 1\n" + END),
    ],
)
def test_a_program_without_an_end(tmp_path: Path, name: str, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert flow.MOST_STEPS <= 100_000  # some seconds of waiting
    monkeypatch.setattr(flow, "MOST_STEPS", 2_000)
    _refused(tmp_path, name, text, "has not ended after 2000 lines")
