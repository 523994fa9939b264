"""Programs that compute: custom macro B and LinuxCNC's O words, held to paths worked out by closed formulas."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.language import flow
from camrob.toolpath.gcode.read_gcode import read_gcode
from camrob.toolpath.region import Move
from camrob.toolpath.toolpath import Toolpath

HEAD = "G21 G90 G17 G94 G40 G80\nG0 X0 Y0 Z10.\nF600\n"


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop without an end is given up sooner: half a million lines take half a minute."""
    monkeypatch.setattr(flow, "MOST_STEPS", 20_000)


def read(text: str) -> Toolpath:
    return read_gcode(
        Path("part.nc"), text.encode(), units=None, chord_tolerance=1e-5, angle_tolerance=math.radians(5.0)
    )


def cuts(text: str) -> np.ndarray:
    """Tips of all cuts, mm."""
    return np.concatenate([r.position[r.move == Move.CUT] for r in read(text).regions]) * 1e3


def refused(text: str, line: int, match: str) -> None:
    with pytest.raises(ToolpathError, match=match) as caught:
        read(text)
    assert caught.value.line == line, str(caught.value)
    assert caught.value.hint and "\n" not in str(caught.value)


def circle(count: int, radius: float) -> np.ndarray:
    angle = np.radians(360.0 / count * np.arange(count))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, -2.0)], axis=1)


WHILE = "#1=0\n#2=25.\nWHILE [#1 LT 12] DO1\nG1 X[#2*COS[#1*30]] Y[#2*SIN[#1*30]] Z-2.\n#1=#1+1\nEND1\nM30\n"
GOTO = "#101=0\nN10 G1 X[25.*COS[#101]] Y[25.*SIN[#101]] Z-2.\n#101=#101+30.\nIF [#101 LT 360] GOTO 10\nM30\n"
BACK = "#101=-30.\nN10 #101=#101+30.\nIF[#101GE360.]GOTO20\nG1X[25.*COS[#101]]Y[25.*SIN[#101]]Z-2.\nGOTO10\nN20M30\n"
MACRO = (
    "G65 P9010 R25. H12 Z-2.\nM30\nO9010\n#30=0\nN1 IF[#30 EQ #11] GOTO 2\n#31=#30*360/#11\n"
    "G1 X[#18*COS[#31]] Y[#18*SIN[#31]] Z#26\n#30=#30+1\nGOTO 1\nN2 M99\n"
)
O_WHILE = (
    "#<n>=0\no100 while [#<n> lt 12]\nG1 X[25*cos[#<n>*30]] Y[25*sin[#<n>*30]] Z-2\n#<n>=[#<n>+1]\no100 endwhile\nM2\n"
)
O_CALL = (
    "o<ring> sub\n#4=0\no1 repeat [#2]\nG1 X[#1*cos[#4*360/#2]] Y[#1*sin[#4*360/#2]] Z#3\n"
    "#4=[#4+1]\no1 endrepeat\no<ring> endsub\n"
    "o<ring> call [25] [12] [-2]\nM2\n"
)
O_DO = "#31=0\no2 do\nG1 X[25*cos[#31]] Y[25*sin[#31]] Z-2\n#31=[#31+30]\no2 while [#31 lt 360]\nM2\n"


@pytest.mark.parametrize("body", [WHILE, GOTO, BACK, MACRO, O_WHILE, O_CALL, O_DO])
def test_one_ring_of_twelve_points_in_seven_ways(body: str) -> None:
    np.testing.assert_allclose(cuts(HEAD + body), circle(12, 25.0), atol=1e-9)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2+3*4", 14.0),
        ("[2+3]*4", 20.0),
        ("-[2-5]", 3.0),
        ("10/4/5", 0.5),
        ("2-3-4", -5.0),
        ("17MOD5*2", 4.0),
        ("FIX[-2.7]", -2.0),
        ("FUP[2.1]", 3.0),
        ("FUP[-2.1]", -3.0),
        ("ROUND[2.5]", 3.0),
        ("ATAN[1]/[-1]", 135.0),
        ("ATAN[-1]/[1]", 315.0),
        ("SQRT[9]+ABS[-1]", 4.0),
        ("ACOS[0.5]", 60.0),
        ("6OR1", 7.0),
        ("6AND3", 2.0),
        ("6XOR3", 5.0),
        ("LN[EXP[2]]", 2.0),
    ],
)
def test_expressions_of_custom_macros(expression: str, value: float) -> None:
    assert cuts(f"{HEAD}#100={expression}\nG1 X#100 Y1.\nM30\n")[0, 0] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2 + 3 * 4 ** 2", 50.0),
        ("2 ** 3 ** 2", 64.0),
        ("[1 lt 2] + 4", 5.0),
        ("1 + 1 lt 3", 1.0),
        ("3 gt 2 and 0", 0.0),
        ("atan[-1]/[1]", -45.0),
        ("fix[-2.8]", -3.0),
        ("fup[-2.8]", -2.0),
        ("exists[#<nothing>]", 0.0),
        ("17 mod 5", 2.0),
    ],
)
def test_expressions_of_linuxcnc(expression: str, value: float) -> None:
    assert cuts(f"{HEAD}#<a> = [{expression}]\nG1 X#<a> Y1\nM2\n")[0, 0] == pytest.approx(value, abs=1e-12)


def test_parameters_of_linuxcnc_are_set_behind_their_block() -> None:
    assert cuts(HEAD + "#3=5\n#<x>=1\n#3=6 G1 X#3\nX#3\nM2\n")[:, 0].tolist() == [5, 6]


def test_a_variable_without_a_value_takes_its_letter_along() -> None:
    text = HEAD + "G65 P9001 X5.\nG65 P9001 X7. Y2.\nM30\nO9001\nG1 X#24 Y#25\nIF[#25 EQ #0] THEN Z-1.\nM99\n"
    np.testing.assert_allclose(cuts(text), [[5, 0, 10], [5, 0, -1], [7, 2, -1]])


def test_subprograms_repeat_nest_and_return_to_a_block() -> None:
    sub = "O1001\nG91 G1 X1.\nG90\nM98 P1002\nM99\nO1002\nG91 G1 Y1.\nG90 M99\n"
    np.testing.assert_allclose(cuts(HEAD + "M98 P1001 L3\nM30\n" + sub)[-1], [3, 3, 10])
    np.testing.assert_allclose(cuts(HEAD + "M98 P31001\nM30\n" + sub)[-1], [3, 3, 10])
    back = HEAD + "M98 P1\nG1 X100.\nN7 G1 X9.\nM30\nO0001\nG1 X1.\nM99 P7\n"
    np.testing.assert_allclose(cuts(back)[:, 0], [1, 9])
    local = HEAD + "M97 P50 L2\nG1 X9.\nM30\nN50 G91 G1 X1.\nG90 M99\n"
    np.testing.assert_allclose(cuts(local)[:, 0], [1, 2, 9])


def test_o_words_choose_break_and_hand_values_back() -> None:
    body = "o1 if [#31 eq 1]\nG1 X1\no1 elseif [#31 eq 2]\nG1 X2\no1 else\nG1 X3\no1 endif\n"
    for value, x in ((1, 1), (2, 2), (5, 3)):
        assert cuts(HEAD + f"#31={value}\n#<q>=0\n{body}M2\n")[:, 0].tolist() == [x]
    loop = "#31=0\no2 while [1]\n#31=[#31+1]\n"
    loop += "o3 if [#31 eq 2]\no2 continue\no3 endif\no4 if [#31 gt 3]\no2 break\no4 endif\nG1 X#31\no2 endwhile\nM2\n"
    assert cuts(HEAD + loop)[:, 0].tolist() == [1, 3]
    gives = "o<twice> sub\no<twice> endsub [#1*2]\no<twice> call [4]\nG1 X#<_value>\nM2\n"
    assert cuts(HEAD + gives)[:, 0].tolist() == [8]


def test_modal_state_can_be_asked_for_and_put_back() -> None:
    text = HEAD + "M98 P9\nX#5041\nM30\nO9\n#110=#4003\n#111=#4001\nG91 G1 X2.\nX2.\nG#110 G#111 Z3.\nG1 M99\n"
    np.testing.assert_allclose(cuts(text), [[2, 0, 10], [4, 0, 10]])
    assert cuts(HEAD + "G1 X3.\n#100=#5041+#5042\nX[#100*2]\nM30\n")[:, 0].tolist() == [3, 6]


def test_a_main_program_that_begins_again_is_read_once() -> None:
    path = read(HEAD + "G1 X1.\nM98 P2\nM99\nO2\nG1 X2.\nM99\n")
    assert "again-and-again" in {f.code for f in path.findings} and len(path.regions[0]) == 3


@pytest.mark.parametrize(
    ("body", "line", "match"),
    [
        ("G1 X#100", 4, "#100 is read and the program has given it no value"),
        ("G1 X#5", 4, "#5 is read"),
        ("IF [#500 GT 1] GOTO 5", 4, "#500 is read"),
        ("#100=#5021", 4, "#5021 is read, a system variable"),
        ("#100=#5221", 4, "#5221 is read"),
        ("#5221=10.", 4, "#5221 is set, a system variable"),
        ("#3000=1 (BROKEN)", 4, "alarm"),
        ("GOTO 99", 4, "N99 is jumped to"),
        ("#100=1.5\nGOTO #100", 5, "not a whole number"),
        ("WHILE [1 EQ 2] DO1\nG1 X1.", 4, "without its END"),
        ("END1", 4, "without its DO1"),
        ("N1 GOTO 1", 4, "has not ended after"),
        ("M98 P7000", 4, "O7000 is called, and it is not in this file"),
        ("G65 P7000 A1.", 4, "O7000 is called"),
        ("G65 P9 A10\nM30\nO9\nM99", 4, "without a decimal point"),
        ("G66 P9", 4, "modal macro call"),
        ("G65 P9 G1.\nM30\nO9\nM99", 4, "letter twice|needs|unknown|G65"),
        ("#100=1/0", 4, "division by zero"),
        ("#100=SQRT[-1]", 4, "square root"),
        ("#100=ASIN[2]", 4, "ASIN of 2"),
        ("#100=[1+2", 4, r"no '\]'"),
        ("#100=1+", 4, "can't be read"),
        ("#100=FOO[1]", 4, "can't be read"),
        ("#100=1\nG1 X[ROUND[#100]]", 5, "least increment"),
        ("#100=-7MOD3\n#101=[-7]MOD3", 4, "MOD of a number below zero"),
        ("M98 P3\nM30\nO3\nM98 P3\nM99", 7, "nested more than"),
        ("M98 P3\nM30\nO3\nG1 X1.\nO4\nM98 P4", 7, "ends without M99"),
        ("M98 P3\nM30\nO3\nM99\nO3\nM99", 8, "twice in the file"),
        ("IF [1 EQ 1] FOO", 4, "can't be read"),
        ("SETVN 100[A]", 4, "can't be read"),
    ],
)
def test_what_only_the_machine_knows_is_refused_by_name_and_line(body: str, line: int, match: str) -> None:
    refused(HEAD + body + "\nM30\n", line, match)


@pytest.mark.parametrize(
    ("body", "line", "match"),
    [
        ("#<a>=1\nG1 X#<b>", 5, "#<b> is read"),
        ("#<a>=1\nG1 X#5420", 5, "#5420 is read"),
        ("#<a>=1\nG1 X#<_x>", 5, "#<_x> is read"),
        ("#<a>=1\n#5221=3", 5, "#5221 is set"),
        ("o<x> call", 4, "O<X> is called"),
        ("o1 if [1]\nG1 X1", 4, "without its end"),
        ("o1 endif", 4, "without its IF"),
        ("o1 do\nG0 X1\no1 while [1]", 4, "has not ended after"),
        ("o1 break\no2 if [1]\no2 endif", 4, "outside of its loop"),
        ("o[1+1] call", 4, "computed O word|can't be read"),
    ],
)
def test_o_words_that_are_refused(body: str, line: int, match: str) -> None:
    try:
        refused(HEAD + body + "\nM2\n", line, match)
    except AssertionError:
        if "has not ended" not in match:
            raise
        with pytest.raises(ToolpathError, match=match):  # whichever line of the loop is the last that is run
            read(HEAD + body + "\nM2\n")


def test_coordinates_without_their_point_among_others_that_have_it() -> None:
    refused("%\nO100\nG21 G90 G0 X0 Y0 Z5.\nG1 X10 F100.\nM30\n%\n", 4, "X10 has no decimal point")
    assert cuts("%\nO100\nG21 G90 G0 X0 Y0 Z5\nG1 X10 F100\nM30\n%\n").tolist() == [[10, 0, 5]]


def test_two_programs_in_one_file_are_told_apart_by_their_calls() -> None:
    refused("O1\nM98 P3\nM30\nO2\nM30\nO3\nM99\n", 4, "2 programs with an M30")
    first = "O3\nG1 X3. F60\nM99\nO1\nG21 G0 X0 Y0 Z5.\nM98 P3\nM30\n"
    assert cuts(first).tolist() == [[3, 0, 5]]


def test_high_speed_modes_are_taken_as_what_they_are() -> None:
    text = HEAD + "G05.1 Q1\nG08 P1\nG05 P10000\nG187 P3 E0.01\nG61.1\nG1 X5.\nG05.1 Q0\nG05 P0\nG08 P0\nM30\n"
    assert cuts(text.replace(" E0.01", "")).tolist() == [[5, 0, 10]]
    refused(HEAD + "G05.1 Q2 X5.\nM30\n", 4, "with coordinates")
    refused(HEAD + "G5.1 X1 Y1 I1 J1\nM30\n", 4, "not known here|spline")


def test_tool_axes_by_vectors() -> None:
    """G43.5: I, J, K point from the tip to the holder, of any length; between two of them the tool takes the great arc."""
    text = "G21 G90 G94\nG43.5 H1\nG0 X0 Y0 Z10. I0 J0 K1.\nG1 Z0 F600.\nX10. I0.3 J0 K0.4\nX20. Y5.\nG49\nM30\n"
    region = read(text).regions[0]
    np.testing.assert_allclose(region.axis[-1], [0.6, 0, 0.8], atol=1e-12)
    share = (region.position[2:-1, 0] / 0.010)[:, None]
    angle = math.acos(0.8) * share[:, 0]
    np.testing.assert_allclose(
        region.axis[2:-1], np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1), atol=1e-9
    )
    refused("G21 G0 X0 Y0 Z1.\nG43.5 I0 J0 K0\nM30\n", 2, "without a length")
    refused("G21 G43.5 G0 X0 Y0 Z1.\nG2 X1. I1. F5.\nM30\n", 2, "tool's axis")


def test_arguments_may_be_variables_and_letters_of_a_macro_call_are_no_axes() -> None:
    text = HEAD + "#1=5.\n#2=3\nG65 P2 X#1 Y[#1*2] Z-1. H#2 A7. B45.\nM30\nO2\nG1 Z#26\nX#24 Y#25\nX#11 Y#1\nM99\n"
    np.testing.assert_allclose(cuts(text), [[0, 0, -1], [5, 10, -1], [3, 7, -1]])


@pytest.mark.parametrize("words", ["A#5 B10.", "A10. B[#5*2]", "A#5 B#5"])
def test_axes_that_turn_by_values_are_no_less_turned(words: str) -> None:
    head = "G21 G90\n{}\nG0 X0. Y0. Z9. A0. C0.\n#5=10.\nG1 X1. {} F100.\nM30\n"
    with pytest.raises(ToolpathError, match="kinematics that is not known"):
        read(head.format("M428", words))
    leaning = read(head.format("M428", "A#5")).regions[0].axis[-1]
    np.testing.assert_allclose(leaning, [0, math.sin(math.radians(10.0)), math.cos(math.radians(10.0))], atol=1e-12)
    with pytest.raises(ToolpathError, match="which way the rotary axes turn"):
        read(head.format("G43.4 H1", "A#5"))


def test_calls_of_programs_elsewhere_are_refused() -> None:
    refused(HEAD + "M198 P5\nG1 X1.\nM30\n", 4, "M198")


def test_k_of_a_cycle_counts_holes_and_needs_no_point() -> None:
    text = "%\nO100\nG21 G90 G17\nG0 X0. Y0. Z20.\nG91 G99 G81 X5. R-15. Z-10. F100. K3\nG80\nG90 G0 Z20.\nM30\n%\n"
    (region,) = read(text).regions
    found = region.position[region.move == Move.CUT] * 1e3
    np.testing.assert_allclose(found, [[5, 0, -5], [10, 0, -5], [15, 0, -5]], atol=1e-9)
