"""The witness runs programs that compute: held to paths by closed formulas and by loops of this file, not by camrob's reader."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cl_stories import mm

from camrob.witness.cl.running import ordered
from camrob.witness.cl.running.unread import NOWHERE
from camrob.witness.cl.teller import UNREAD

HEAD = "G21 G90 G17 G94\nG0 X0 Y0 Z10.\nF600\n"
SAFE = [[0, 0, 10]]


def ring(count: int, radius: float) -> list[list[float]]:
    angles = np.radians(360.0 / count * np.arange(count))
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(count, -2.0)], axis=1).tolist()


WHILE = "#1=0\n#2=25.\nWHILE [#1 LT 12] DO1\nG1 X[#2*COS[#1*30]] Y[#2*SIN[#1*30]] Z-2.\n#1=#1+1\nEND1\nM30\n"
ENDLESS = "#1=0\nDO2\nG1 X[25.*COS[#1*30]] Y[25.*SIN[#1*30]] Z-2.\n#1=#1+1\nIF[#1 EQ 12] GOTO 5\nEND2\nN5 M30\n"
BACK = "#101=-30.\nN10 #101=#101+30.\nIF[#101GE360.]GOTO20\nG1X[25.*COS[#101]]Y[25.*SIN[#101]]Z-2.\nGOTO10\nN20M30\n"
MACRO = (
    "G65 P9010 R25. H12 Z-2.\nM30\nO9010\n#30=0\nN1 IF[#30 EQ #11] GOTO 2\n#31=#30*360/#11\n"
    "G1 X[#18*COS[#31]] Y[#18*SIN[#31]] Z#26\n#30=#30+1\nGOTO 1\nN2 M99\n"
)
TIMES = "#1=0\nM98 P50 L12\nM30\nO50\nG1 X[25*COS[#1]] Y[25*SIN[#1]] Z-2.\n#1=#1+30\nM99\n"
O_WHILE = (
    "#<n>=0\no100 while [#<n> lt 12]\nG1 X[25*cos[#<n>*30]] Y[25*sin[#<n>*30]] Z-2\n#<n>=[#<n>+1]\no100 endwhile\nM2\n"
)
O_CALL = (
    "o<ring> sub\n#4=0\no1 repeat [#2]\nG1 X[#1*cos[#4*360/#2]] Y[#1*sin[#4*360/#2]] Z#3\n"
    "#4=[#4+1]\no1 endrepeat\no<ring> endsub\no<ring> call [25] [12] [-2]\nM2\n"
)
O_DO = "#31=0\no2 do\nG1 X[25*cos[#31]] Y[25*sin[#31]] Z-2\n#31=[#31+30]\no2 while [#31 lt 360]\nM2\n"


@pytest.mark.parametrize("body", [WHILE, ENDLESS, BACK, MACRO, TIMES, O_WHILE, O_CALL, O_DO])
def test_one_ring_in_eight_ways(tell, body):
    story = tell(HEAD + body, name="a.nc")
    assert story.complete and np.allclose(np.array(mm(story)), SAFE + ring(12, 25.0), atol=1e-6)
    line = HEAD.count("\n") + 1 + next(i for i, row in enumerate(body.split("\n")) if row.startswith(("G1", "G1X")))
    assert set(story.path.line[1:].tolist()) == {line}  # of the file


def test_a_pocket_in_steps_by_loops_in_one_another(tell):
    text = HEAD + (
        "#1=0\nWHILE[#1 LT 3]DO1\n#1=#1+1\nG1 Z-#1\n#2=0\nWHILE[#2 LT 4]DO2\nG1 X[10.*#2] Y[#1+5*#2]\n#2=#2+1\n"
        "IF[#2 EQ 2]THEN #100=#1\nEND2\nEND1\nG1 X#100 Y[-[#1-8.]/2]\nM30\n"
    )
    points = [[0, 0, 10]]
    for z in (1, 2, 3):
        points.append([points[-1][0], points[-1][1], -z])
        points += [[10 * k, z + 5 * k, -z] for k in range(4)]
    story = tell(text, name="a.nc")
    assert story.complete and mm(story) == [*points, [3, 2.5, -3]]


def test_levels_of_variables(tell):
    """G65 has variables of its own, M98 the caller's; what G65 doesn't hand over takes its word along."""
    text = HEAD + (
        "#1=7.\nG65 P10 X5. Y2.\nG65 P10 X6.\nM98 P20\nG1 X#1\nM30\n"
        "O10\nG1 X#24 Y#25\n#1=99.\nIF[#25 EQ #0]GOTO 3\nG1 Z-1.\nN3 M99\nO20\n#1=#1+1\nM99\n"
    )
    story = tell(text, name="a.nc")
    assert story.complete and mm(story) == [[0, 0, 10], [5, 2, 10], [5, 2, -1], [6, 2, -1], [8, 2, -1]]


def test_calls_repeat_nest_and_go_back_to_a_block(tell):
    sub = "O1001\nG91 G1 X1.\nG90\nM98 P1002\nM99\nO1002\nG91 G1 Y1.\nG90 M99\n"
    for call in ("M98 P1001 L3", "M98 P31001", "M98 P00031001"):
        assert mm(tell(HEAD + f"{call}\nM30\n{sub}", name="a.nc"))[-1] == [3, 3, 10]
    back = tell(HEAD + "M98 P1\nG1 X100.\nN7 G1 X9.\nM30\nO0001\nG1 X1.\nM99 P7\n", name="a.nc")
    assert back.complete and [p[0] for p in mm(back)] == [0, 1, 9]
    local = tell(HEAD + "M97 P50 L2\nG1 X9.\nM30\nN50 G91 G1 X1.\nG90 M99\n", name="a.nc")
    assert local.complete and [p[0] for p in mm(local)] == [0, 1, 2, 9]
    counted = tell(HEAD + "#1=2\n#2=50\nM97 P#2 L[#1+1]\nG1 X9.\nM30\nN50 G91 G1 X1.\nG90 M99\n", name="a.nc")
    assert counted.complete and [p[0] for p in mm(counted)] == [0, 1, 2, 3, 9]
    half = tell(HEAD + "#1=2.5\nM97 P50 L#1\nG1 X9.\nM30\nN50 G91 G1 X1.\nG90 M99\n", name="a.nc")
    assert not half.complete
    first = tell("O3\nG1 X3. F60\nM99\nO1\nG21 G0 X0 Y0 Z5.\nM98 P3\nM30\n", name="a.nc")
    assert first.complete and mm(first) == [[0, 0, 5], [3, 0, 5]]


def test_where_the_last_block_ended_and_its_feed(tell):
    story = tell(HEAD + "G1 X3. F500.\n#100=#5001+#5003\nG1 X#100 F[#4109/2]\nIF[1 EQ 2]GOTO 1\nN1 M30\n", name="a.nc")
    assert story.complete and mm(story)[-1] == [13, 0, 10] and story.feed[-1] * 60_000 == pytest.approx(250)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2+3*4", 14.0), ("[2+3]*4", 20.0), ("-[2-5]", 3.0), ("10/4/5", 0.5), ("2-3-4", -5.0), ("17MOD5*2", 4.0),
        ("FIX[-2.7]", -2.0), ("FUP[2.1]", 3.0), ("FUP[-2.1]", -3.0), ("ROUND[2.5]", 3.0), ("ROUND[-2.5]", -3.0),
        ("ATAN[1]/[-1]", 135.0), ("SQRT[9]+ABS[-1]", 4.0), ("ACOS[0.5]", 60.0), ("6OR1", 7.0), ("6AND3*2", 4.0),
        ("6XOR3", 5.0), ("LN[EXP[2]]", 2.0), ("1+6AND3", 3.0), ("#[100+1]", 8.0), ("ATAN[-1]/[1]", None),
        ("ASIN[-0.5]", None), ("-7MOD3", None), ("1/0", None), ("SQRT[-1]", None), ("BCD[5]", None), ("#500", None),
        ("FIX[0.1*3*10]", None), ("1 LT 2", None),
    ],
)  # fmt: skip
def test_expressions_of_custom_macros(tell, expression, value):
    story = tell(f"{HEAD}#101=8\n#102=0.5\n#100={expression}\nG1 X#100 Y1.\nIF[1 EQ 2]GOTO 1\nN1 M30\n", name="a.nc")
    if value is None:
        assert not story.complete and len(story) == 1
    else:
        assert story.complete and mm(story)[-1] == pytest.approx([value, 1, 10], abs=1e-6)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2 + 3 * 4 ** 2", 50.0), ("2 ** 3 ** 2", 64.0), ("[1 lt 2] + 4", 5.0), ("1 + 1 lt 3", 1.0),
        ("3 gt 2 and 0", 0.0), ("1 eq 1 xor 1", 0.0), ("atan[-1]/[1]", -45.0), ("fix[-2.8]", -3.0), ("fup[-2.8]", -2.0),
        ("exists[#<nothing>]", 0.0), ("exists[#<b>]", 1.0), ("17 mod 5", 2.0), ("6 and 1", 1.0), ("-2 ** 2", None),
        ("#<nothing>", None), ("#<_x>", None), ("#5420", None), ("0.1 * 3 eq 0.3", None),
    ],
)  # fmt: skip
def test_expressions_of_linuxcnc(tell, expression, value):
    story = tell(f"{HEAD}#<b> = 1\n#<a> = [{expression}]\nG1 X#<a> Y1\nM2\n", name="a.nc")
    if value is None:
        assert not story.complete and len(story) == 1
    else:
        assert story.complete and mm(story)[-1] == pytest.approx([value, 1, 10], abs=1e-6)


def test_what_controls_compute_differently_is_read_only_where_it_is_known_whose_program_it_is(tell):
    body = "#100=[FIX[{}]]\nG1 X#100\n"
    assert mm(tell(HEAD + body.format("2.7"), name="a.nc"))[-1] == [2, 0, 10]
    assert not tell(HEAD + body.format("-2.7"), name="a.nc").complete
    assert mm(tell(HEAD + body.format("-2.7") + "GOTO 1\nN1 M30\n", name="a.nc"))[-1] == [-2, 0, 10]
    assert mm(tell(HEAD + body.format("-2.7") + "#<a>=1\nM2\n", name="a.nc"))[-1] == [-3, 0, 10]
    assert not tell(HEAD + "#<a>=1\nGOTO 1\nN1 M30\n", name="a.nc").complete


def test_variables_of_linuxcnc_change_behind_their_block_and_belong_to_their_call(tell):
    assert [p[0] for p in mm(tell(HEAD + "#3=5\n#<x>=1\n#3=6 G1 X#3\nX#3\nM2\n", name="a.nc"))] == [0, 5, 6]
    text = HEAD + (
        "o9 sub\n#1=[#1*2]\n#31=#1\n#<in>=3\nG1 X#1 Y#2\no9 endsub [#1+1]\n#1=50\n#<in>=4\no9 call [20]\n"
        "G1 X#1 Y#<in>\nG1 X#31 Y#<_value>\nM2\n"
    )
    story = tell(text, name="a.nc")
    assert story.complete and mm(story) == [[0, 0, 10], [40, 0, 10], [50, 4, 10], [40, 41, 10]]
    # The manual gives a value that isn't passed to the subroutine as the caller has it, the control's source 0.
    open_ = tell(text.replace("#1=50\n", "#1=50\n#2=8\n"), name="a.nc")
    assert [(gap.first_line, "#2" in gap.text) for gap in open_.gaps] == [(8, True)]


@pytest.mark.parametrize(("value", "x"), [(1, 1), (2, 2), (5, 3)])
def test_branches_of_linuxcnc(tell, value, x):
    body = "o1 if [#31 eq 1]\nG1 X1\no1 elseif [#31 eq 2]\nG1 X2\no1 else\nG1 X3\no1 endif\nM2\n"
    assert [p[0] for p in mm(tell(HEAD + f"#31={value}\n{body}", name="a.nc"))] == [0, x]


def test_loops_of_linuxcnc_break_and_continue(tell):
    loop = "#31=0\no2 while [1]\n#31=[#31+1]\no3 if [#31 eq 2]\no2 continue\no3 endif\no4 if [#31 gt 3]\no2 break\n"
    loop += "o4 endif\nG1 X#31\no2 endwhile\no5 repeat [2]\no6 repeat [2]\n#31=[#31+1]\nG1 X#31\no6 endrepeat\no5 endrepeat\nM2\n"
    assert [p[0] for p in mm(tell(HEAD + loop, name="a.nc"))] == [0, 1, 3, 5, 6, 7, 8]
    early = "o7 sub\no8 if [#1 gt 1]\no7 return\no8 endif\nG1 X#1\no7 endsub\no7 call [2]\no7 call [1]\nM2\n"
    assert [p[0] for p in mm(tell(HEAD + early, name="a.nc"))] == [0, 1]


@pytest.mark.parametrize(
    "body",
    [
        "N1 GOTO 1", "#1=0\nN1 G1 X#1\n#1=#1+1\nGOTO 1", "GOTO 99", "#100=1.5\nGOTO #100", "WHILE [1 EQ 2] DO1\nG1 X1.",
        "END1", "M98 P3\nM30\nO3\nM98 P3\nM99", "M98 P3 L99999999999\nM30\nO3\nM99", "M98 P3\nM30\nO3\nG1 X1.\nO4\nM98 P4",
        "M98 P3\nM30\nO3\nM99\nO3\nM99",
        "M98 P3\nGOTO 9\nN9 M30\nO3\nG1 X1.\n%\n", "G65 P9 A10\nM30\nO9\nM99", "G65 P9 A1. A2.\nM30\nO9\nM99",
        "G66 P9", "#3000=1",
        "GOTO 5\nWHILE[1 EQ 2]DO1\nN5 G1 X1.\nEND1", "GOTO 5\nN5 G1 X1.\nN5 X2.", "#1=" + "[" * 30_000 + "1" + "]" * 30_000,
        "#1=" + "#" * 30_000 + "1", "#1=" + "-" * 30_000 + "1", "G65 P9 L2 A1.\nM30\nO9\n#1=#1+1\nM99", "IF [1 EQ 1] FOO",
        "#1=0\nWHILE[#1 LT 1]DO1\n#1=#1+0.1\nG1 X#1\nIF[#1 EQ 0.3]GOTO 9\nEND1\nN9", "/GOTO 5\nN5 X1.", "G1 X[ROUND[2.5]]",
        "#1=#5021", "M98 P#1", "o1 if [1]\nG1 X1", "o1 endif", "o1 do\nG0 X1\no1 while [1]",
        "o1 repeat [1000000000]\no1 endrepeat",
        "o1 sub\no1 call\no1 endsub\no1 call", "o<x> call", "o[1+1] call", "o1 if [1]\no1 endif\no1 if [1]\no1 endif", "o1 break",
        "o1 if [1 eq 1]\no2 if [1]\no1 endif\no2 endif", "o1 call\no1 sub\no1 endsub", "SETVN 100[A]", "#=", "G1 X[1", "#1==1",
    ],
)  # fmt: skip
def test_what_nobody_knows_or_never_ends_is_a_gap(tell, body, monkeypatch):
    monkeypatch.setattr(ordered, "MOST_STEPS", 2_000)
    story = tell(HEAD + body + "\nM30\n", name="a.nc")
    assert not story.complete and [gap.text for gap in story.gaps if gap.text.startswith(UNREAD)]
    assert all(math.isfinite(x) for point in mm(story) for x in point)


def test_two_main_programs_are_not_told_apart(tell):
    story = tell("O1\nG0 X0 Y0 Z5.\nM98 P3\nM30\nO2\nM30\nO3\nM99\n", name="a.nc")
    assert len(story.way) == 0 and not story.complete


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.nc", HEAD + "GOTO 77\nX1.\nM30\n"),
        ("a.nc", HEAD + "M98 P77\nM30\n"),
        ("a.nc", HEAD + "G65 P77\nM30\n"),
        ("a.h", "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 R0 FMAX\n2 CALL LBL 7\n3 END PGM A MM\n"),
        ("a.mpf", "G0 X=0 Y0 Z5\nGOTOF OUT\nX1\nM30\n"),
    ],
)
def test_a_jump_to_what_is_not_there_is_told_as_such(tell, name, text):
    assert NOWHERE in tell(text, name=name).gaps[-1].text
