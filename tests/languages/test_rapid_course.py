"""Branches, loops, arrays and parameters of RAPID, as the replay's reader and the witness both read them.

What each program does is worked out by hand from ABB's "Technical reference manual, RAPID kernel"; what depends on anything but
the text is refused, or left open.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import ROOT
from scipy.spatial.transform import Rotation
from test_rapid_scopes import DATA, GO, HOME, at

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.read_rapid import read_rapid
from camrob.witness.machine import read_machine
from camrob.witness.rapid.run_module import run_program

MACHINE = read_machine(ROOT / "cells" / "irb6700_table")
MOVE = "MoveL Offs(p1,{},0,0),v100,fine,tS\\WObj:=wP;\n"


def written(folder: Path, body: str, own: str = "", behind: str = "") -> Path:
    """A module with p1 at X 5, a main procedure of this body, and what stands behind it."""
    declared = f"{DATA}CONST robtarget p1:={at(5)};\n{own}"
    (folder / "a.mod").write_text(f"MODULE a\n{declared}PROC main()\n{HOME}{body}ENDPROC\n{behind}ENDMODULE\n")
    return folder / "a.mod"


def by_both(path: Path) -> list[float]:
    """X of all motions behind the first, in mm, that both read alike and whole."""
    made, text = run_program(path, MACHINE), read_rapid(path)
    assert not made.gaps and not [o for o in made.objections if o.severity == "error"] and not text.findings
    one, other = (1000.0 * made.path.tip[1:, 0]).round(6).tolist(), text.pose[1:, 0].round(6).tolist()
    assert one == other
    return one


COURSES = {
    "up": (f"FOR i FROM 1 TO 3 DO\n{MOVE.format('i*10')}ENDFOR\n", [15, 25, 35]),
    "down without STEP": (f"FOR i FROM 3 TO 1 DO\n{MOVE.format('i*10')}ENDFOR\n", [35, 25, 15]),
    "STEP": (f"FOR i FROM 0 TO 5 STEP 2 DO\n{MOVE.format('i')}ENDFOR\n", [5, 7, 9]),
    "a STEP that leads away": (f"FOR i FROM 1 TO 3 STEP -1 DO\n{MOVE.format('i')}ENDFOR\n{GO}", [5]),
    "a counter hides a datum": (f"VAR num i:=7;\nFOR i FROM 1 TO 1 DO\n{GO}ENDFOR\n{MOVE.format('i')}", [5, 12]),
    "WHILE": (f"VAR num n;\nWHILE n<3 DO\nIncr n;\n{MOVE.format('n')}ENDWHILE\n", [6, 7, 8]),
    "none": (f"WHILE FALSE DO\n{MOVE.format('1')}ENDWHILE\n{GO}", [5]),
    "IF": (f"VAR num n:=2;\nIF n=1 THEN\n{GO}ELSEIF n=2 OR n=3 THEN\n{MOVE.format('2')}ELSE\n{GO}ENDIF\n", [7]),
    "ELSE": (f"IF FALSE THEN\n{MOVE.format('1')}ELSE\n{MOVE.format('3')}ENDIF\n", [8]),
    "TEST": (f"VAR num n:=4;\nTEST n-1\nCASE 1,2:\n{GO}CASE 3,4:\n{MOVE.format('4')}DEFAULT:\n{GO}ENDTEST\n", [9]),
    "DEFAULT": (f"TEST 5\nCASE 1:\n{GO}DEFAULT:\n{MOVE.format('1')}ENDTEST\n{MOVE.format('2')}", [6, 7]),
    "one in the other": (
        f"FOR i FROM 1 TO 2 DO\nFOR j FROM 1 TO 2 DO\nIF i=j THEN\n{MOVE.format('10*i+j')}ENDIF\nENDFOR\nENDFOR\n",
        [16, 27],
    ),
    "arithmetic": (f"VAR num n:=7;\nn:=(n DIV 2)*10+n MOD 2;\n{MOVE.format('n')}{MOVE.format('-n+2*3')}", [36, -20]),
    "Add and its kin": (f"VAR num n:=1;\nAdd n,2*3;\nDecr n;\n{MOVE.format('n')}Clear n;\n{MOVE.format('n')}", [11, 5]),
    "EXIT ends it all": (f"{GO}EXIT;\n{MOVE.format('1')}", [5]),
    "RETURN within a loop": (f"FOR i FROM 1 TO 9 DO\n{MOVE.format('i')}IF i=2 THEN\nRETURN;\nENDIF\nENDFOR\n", [6, 7]),
}


@pytest.mark.parametrize("name", COURSES)
def test_a_course_that_the_text_says_is_run(tmp_path: Path, name: str) -> None:
    body, expected = COURSES[name]
    assert by_both(written(tmp_path, body)) == expected


def test_arrays_by_one_and_two_indices(tmp_path: Path) -> None:
    own = "CONST num s{3}:=[4,-2,6];\nCONST num t{2,2}:=[[1,2],[3,4]];\n"
    body = "VAR robtarget q{2};\nq{2}:=Offs(p1,s{3},0,0);\nq{2}.trans.x:=q{2}.trans.x+t{2,1};\nMoveL q{2},v100,fine,"
    body += f"tS\\WObj:=wP;\n{MOVE.format('s{2}')}{MOVE.format('t{1,2}*10')}"
    assert by_both(written(tmp_path, body, own)) == [14, 3, 25]


@pytest.mark.parametrize("index", ["0", "4", "1.5", "1,1"])
def test_an_element_that_is_not_there_is_not_read(tmp_path: Path, index: str) -> None:
    path = written(tmp_path, MOVE.format(f"s{{{index}}}"), "CONST num s{3}:=[4,-2,6];\n")
    assert run_program(path, MACHINE).gaps
    with pytest.raises(ProgramError, match="not in the program"):
        read_rapid(path)


def test_what_is_handed_is_a_copy(tmp_path: Path) -> None:
    """Parameters by value, over several lines, changed within; the caller's are as they were."""
    behind = (
        f"PROC there(\n  num x,\n  robtarget p1)\nx:=x+1;\np1.trans.x:=p1.trans.x+100;\n{MOVE.format('x')}ENDPROC\n"
    )
    body = f"VAR num n:=3;\nthere n,Offs(p1,10,0,0);\nthere n*2,p1;\n{MOVE.format('n')}"
    assert by_both(written(tmp_path, body, "", behind)) == [119, 112, 8]


@pytest.mark.parametrize("head", ["INOUT num x", "VAR num x", "PERS num x", "var num x"])
def test_what_a_procedure_only_reads_may_be_handed_by_reference(tmp_path: Path, head: str) -> None:
    behind = f"PROC there({head},num y)\nIF x>2 THEN\n{MOVE.format('x+y')}ENDIF\n{MOVE.format('x')}ENDPROC\n"
    assert by_both(written(tmp_path, f"PERS num n:=3;\nthere n,1;\n{GO}", "", behind)) == [9, 8, 5]


@pytest.mark.parametrize(
    ("head", "first"),
    [
        *(
            (head, first)
            for head in ("INOUT num x", "VAR num x")
            for first in ("x:=4;\n", "Incr x;\n", "other;\n", "n:=7;\n")
        ),
        ("\\num x", ""),
        ("num x{*}", ""),
    ],
)
def test_what_is_handed_otherwise_is_not_run(tmp_path: Path, head: str, first: str) -> None:
    behind = f"PROC there({head})\n{first}{MOVE.format('x')}ENDPROC\nPROC other()\nn:=9;\nENDPROC\n"
    path = written(tmp_path, f"there n;\n{GO}", "VAR num n:=3;\n", behind)
    assert run_program(path, MACHINE).gaps
    assert any(f.code == "call-unknown" for f in read_rapid(path).findings)


@pytest.mark.parametrize(
    "body",
    [
        f"FOR i FROM 1 TO others DO\n{GO}ENDFOR\n",
        f"IF DI_1=1 THEN\n{GO}ENDIF\n",
        f"IF DI_1=1 THEN\nsub;\nENDIF\n{GO}",  # a call may move
        f"WHILE DI_1=1 DO\n{GO}ENDWHILE\n",
        f"TEST DI_1\nCASE 1:\n{GO}ENDTEST\n",
        f"VAR num x;\nWHILE x<1 DO\nx:=x+0.1;\n{GO}ENDWHILE\n",  # ten times in single precision, eleven in double
        f"VAR bool b;\nIF NOT b AND b THEN\n{GO}ENDIF\n",
        f"FOR i FROM 1 TO 2 DO\ni:=2;\n{GO}ENDFOR\n",
        f"WHILE TRUE DO\n{GO}ENDWHILE\n",
        f"FOR i TO 2 DO\n{GO}ENDFOR\n",
        f"VAR num q{{others}};\n{MOVE.format('q{1}')}",
    ],
)
def test_a_course_that_the_text_does_not_say_is_not_run(tmp_path: Path, body: str) -> None:
    path = written(tmp_path, body, "", f"PROC sub()\n{GO}ENDPROC\n")
    made = run_program(path, MACHINE)
    assert made.gaps or any(o.severity == "error" for o in made.objections)
    with pytest.raises(ProgramError):
        read_rapid(path)


def test_what_a_branch_may_have_set_is_known_no_more(tmp_path: Path) -> None:
    path = written(tmp_path, f"VAR num n:=1;\nIF DI_1=1 THEN\nn:=2;\nENDIF\n{MOVE.format('n')}")
    with pytest.raises(ProgramError, match="N, which is not in the program"):
        read_rapid(path)
    path = written(tmp_path, f"VAR num n:=1;\nIF DI_1=1 n:=2;\n{MOVE.format('n')}")
    with pytest.raises(ProgramError, match="N, which is not in the program"):
        read_rapid(path)


def test_a_datum_of_the_module_that_the_next_cycle_finds_changed(tmp_path: Path) -> None:
    """A VAR of a module keeps its value where main begins anew: what is set before it is used is all right."""
    own = "VAR num n:=1;\n"
    made = run_program(written(tmp_path, f"{MOVE.format('n')}n:=n+1;\n", own), MACHINE)
    assert "not-repeatable" in [o.code for o in made.conduct]
    made = run_program(written(tmp_path, f"n:=3;\n{MOVE.format('n')}", own), MACHINE)
    assert "not-repeatable" not in [o.code for o in made.conduct] and not made.gaps
    assert np.round(1000.0 * made.path.tip[1, 0], 6) == 8


def test_a_unit_that_the_cell_activates_is_active_before_the_first_motion(tmp_path: Path) -> None:
    path = written(tmp_path, GO)
    assert not run_program(path, MACHINE).objections
    path.write_text(path.read_text().replace("ActUnit STN1; ", ""))
    (said,) = run_program(path, MACHINE).objections
    assert (said.code, said.line) == ("unit-not-active", 6) and "STN1" in said.text


@pytest.mark.parametrize(("turn", "judged"), [("0,0.9999,0,0", True), ("0,0.998,0,0", False)])
def test_a_quaternion_that_is_not_of_length_1_is_not_judged(tmp_path: Path, turn: str, *, judged: bool) -> None:
    """Four decimals are kept; 0.2 % is what a controller stops at."""
    path = written(tmp_path, f"MoveL [[9,0,300],[{turn}],[0,0,0,0],[0,9E9,9E9,9E9,9E9,9E9]],v100,fine,tS\\WObj:=wP;\n")
    assert (not run_program(path, MACHINE).gaps) == judged


def test_no_tip_goes_faster_than_velset_says(tmp_path: Path) -> None:
    """Its second number is the most for the tip, mm/s (ABB's "Technical reference manual, RAPID instructions")."""
    path = written(tmp_path, f"{GO}VelSet 100,30;\n{GO}VelSet 100,5000;\n{GO}")
    made, text = run_program(path, MACHINE), read_rapid(path)
    assert made.speed[1:].tolist() == [0.1, 0.03, 0.1]
    assert text.speed[1:].tolist() == [0.1, 0.03, 0.1] and not text.findings


@pytest.mark.parametrize(
    ("handler", "judged"),
    [("TRYNEXT;", False), ("RETRY;", False), ('TPWrite "x";', False), ("", False), ('TPWrite "x";\nRAISE;', True)],
)
def test_what_is_done_when_a_statement_fails_is_not_judged(tmp_path: Path, handler: str, *, judged: bool) -> None:
    """A handler that reaches its end returns to the caller, as RETURN does."""
    made = run_program(written(tmp_path, f"{GO}ERROR\n{handler}\n"), MACHINE)
    assert all("(ERROR)" not in gap.text for gap in made.unsettled) == judged and not made.gaps


OWN = "FUNC num Out(num n)\nSetDO doSpindle,0;\nRETURN n;\nENDFUNC\n"


@pytest.mark.parametrize(
    "line", ['TPWrite "a"\\Num:=Out(1);', "n:=Out(1);", "SetAO ao1,Out(1);", "TPWrite NumToStr(Far(1),2);"]
)
def test_a_function_that_may_do_anything_is_not_judged(tmp_path: Path, line: str) -> None:
    """One of the program's own, or of a module that isn't at hand; ABB's own that only give a value do nothing."""
    path = written(tmp_path, f"VAR num n;\n{GO}{line}\n", behind=OWN)
    assert any("(), and what that does" in gap.text for gap in run_program(path, MACHINE).gaps)
    path = written(tmp_path, f'{GO}TPWrite "Out(1)"+NumToStr(Round(2.5),2);\n', behind=OWN)
    assert not run_program(path, MACHINE).gaps


@pytest.mark.parametrize("name", ["WaitTime", "TPWrite", "SetDO", "MoveL", "Stop", "AccSet", "Incr"])
def test_a_procedure_that_hides_the_controllers_stands_against_it(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, GO, behind=f"PROC {name}(num n)\nSetDO doSpindle,0;\nENDPROC\n")
    assert "library-replaced" in [o.code for o in run_program(path, MACHINE).objections]
    assert [f.code for f in read_rapid(path).findings] == ["not-understood"]


def test_a_function_that_hides_the_controllers_stands_against_it(tmp_path: Path) -> None:
    own = "LOCAL FUNC robtarget Offs(robtarget p,num x,num y,num z)\nRETURN p;\nENDFUNC\n"
    assert "library-replaced" in [o.code for o in run_program(written(tmp_path, GO, behind=own), MACHINE).objections]


def test_reltool_turns_about_x_then_the_new_y_then_the_new_z(tmp_path: Path) -> None:
    r"""ABB's manual of the function; what it comes to is scipy's. A comma may stand before \Rx, too."""
    to = "MoveL RelTool(p1,1,2,-3{}\\Rx:=10 \\Ry:=-20{}\\Rz:=5*6),v100,fine,tS\\WObj:=wP;\n"
    path = written(tmp_path, to.format("", "") + to.format(",", ", "))
    made, text = run_program(path, MACHINE), read_rapid(path)
    assert not made.gaps and not text.findings
    start = Rotation.from_euler("ZYX", text.pose[1, 3:], degrees=True)
    plain = read_rapid(written(tmp_path, MOVE.format(0)))
    turned = Rotation.from_euler("ZYX", plain.pose[1, 3:], degrees=True) * Rotation.from_euler(
        "XYZ", [10, -20, 30], degrees=True
    )
    assert (start.inv() * turned).magnitude() < 1e-9
    np.testing.assert_allclose(made.path.axis[1], turned.apply([0, 0, 1]), atol=1e-9)
    np.testing.assert_allclose(made.path.axis[2], made.path.axis[1], atol=1e-12)
    np.testing.assert_allclose(text.pose[2], text.pose[1], atol=1e-9)


FUNCTIONS = """FUNC num Half(num n)
RETURN n/2;
ENDFUNC
LOCAL FUNC robtarget There(num x,robtarget p)
VAR num more;
p.trans.x:=x;
IF x>20 THEN
RETURN Offs(p,Half(10),0,0);
ENDIF
FOR i FROM 1 TO 3 DO
more:=more+i;
ENDFOR
TEST x
CASE 7:
more:=100;
ENDTEST
p.trans.x:=p.trans.x+more;
RETURN p;
ENDFUNC
FUNC bool Far(num x)
WHILE x>3 DO
x:=x-3;
ENDWHILE
RETURN x=2;
ENDFUNC
"""


def test_functions_that_only_reckon_give_their_values(tmp_path: Path) -> None:
    """What they are handed they may change: it is a copy. 4+6, 7+100, 30+5; Far of 8 is TRUE."""
    to = "MoveL There({},p1),v100,fine,tS\\WObj:=wP;\n"
    body = to.format("2*2") + to.format("7") + f"IF Far(8) THEN\n{to.format('Half(60)')}ENDIF\n{GO}"
    assert by_both(written(tmp_path, body, behind=FUNCTIONS)) == [10, 107, 35, 5]


@pytest.mark.parametrize(
    "inside",
    [
        "SetDO doSpindle,1;",
        "n:=7;",
        "MoveL p1,v100,fine,tS\\WObj:=wP;",
        "Incr x;",
        "sub;",
        'TPWrite "a";',
        "x:=Out(2);",
    ],
)
def test_a_function_that_does_more_is_not_followed(tmp_path: Path, inside: str) -> None:
    own = f"FUNC num Shift(num x)\n{inside}\nRETURN x;\nENDFUNC\n{OWN}"
    path = written(tmp_path, MOVE.format("Shift(3)"), "VAR num n;\n", own)
    assert run_program(path, MACHINE).gaps
    with pytest.raises(ProgramError, match="not in the program"):
        read_rapid(path)
    made = run_program(written(tmp_path, f"n:=Abs(Shift(3));\n{GO}", "VAR num n;\n", own), MACHINE)
    assert any("SHIFT(), and what that does" in gap.text for gap in made.gaps)


@pytest.mark.parametrize(
    "body",
    [
        f"WHILE TRUE DO\n{GO}ENDWHILE\n",
        f"VAR bool on:=TRUE;\nWHILE on DO\n{GO}ENDWHILE\n",
        f"VAR num n:=1;\nWHILE n>0 DO\n{GO}n:=-n;\nn:=-n;\nENDWHILE\n",
        f"VAR num n:=1;\nWHILE n>0 DO\n{GO}n:=3-n;\nENDWHILE\n",
        f"VAR num n;\nWHILE TRUE DO\nIncr n;\n{GO}ENDWHILE\n",
    ],
)
def test_a_loop_that_never_ends_is_soon_said_to(tmp_path: Path, body: str) -> None:
    path = written(tmp_path, body)
    with pytest.raises(ProgramError, match="never ends"):
        read_rapid(path)
    made = run_program(path, MACHINE)
    assert any("never end" in gap.text for gap in made.gaps) and len(made.path.tip) < 300
