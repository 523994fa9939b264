"""The course of other people's programs: loops, branches, functions, types; each target worked out by hand.

KUKA, "Expert Programming" (KSS 5 to 8): an INT takes a REAL rounded, two INT divide to an INT, a component such as X is REAL, OUT
hands a value back, the geometric operator chains frames, EXIT leaves the loop round it.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import KR15

from camrob.errors import KrlError
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.witness.krl.run import run_program
from camrob.witness.krl.values import Variables
from camrob.witness.machine import read_machine

HEAD = "DEF a ( )\n{}BAS (#INITMOV,0 )\n$VEL.CP=0.1\np={{X 0,Y 0,Z 50,A 0,B 0,C 180}}\n"
DECLARED = "E6POS p,q\nFRAME f\nINT n,m,k[3]\nREAL r\nENUM mode A,B\nDECL mode way\n"
GO = "LIN {{X {},Y 0,Z 50,A 0,B 0,C 180}}\n"


def places(folder: Path, body: str, behind: str = "", declared: str = DECLARED) -> list[list[float]]:
    """X, Y, Z of each motion, mm."""
    (folder / "a.src").write_text(HEAD.format(declared) + body + "END\n" + behind, encoding="ascii")
    return read_krl(folder / "a.src").pose[:, :3].round(6).tolist()


FLOW = {
    "n=0\nWHILE n<2\nn=n+1\n" + GO.format(1) + "ENDWHILE\n": [1, 1],
    "n=0\nREPEAT\nn=n+2\n" + GO.format(1) + "UNTIL n>=4\n": [1, 1],
    "n=3\nLOOP\nn=n-1\nIF n==0 THEN\nEXIT\nENDIF\n" + GO.format(2) + "ENDLOOP\n" + GO.format(3): [2, 2, 3],
    "n=4\nSWITCH n\nCASE 1\n"
    + GO.format(1)
    + "CASE 2,4\n"
    + GO.format(2)
    + "DEFAULT\n"
    + GO.format(9)
    + "ENDSWITCH\n": [2],
    "way=#B\nSWITCH way\nCASE #A\n" + GO.format(1) + "CASE #B\n" + GO.format(2) + "ENDSWITCH\n": [2],
    "FOR n=1 TO 2\nFOR m=1 TO 3\nIF m==2 THEN\nEXIT\nENDIF\n" + GO.format(7) + "ENDFOR\nENDFOR\n": [7, 7],
}
VALUES = {
    "n=2.6\np.X=n\n": 3.0,
    "n=-2.4\np.X=n\n": -2.0,
    "n=7/2\np.X=n\n": 3.0,
    "n=7.0\np.X=n/2\n": 3.0,
    "r=7\np.X=r/2\n": 3.5,
    "p.X=7\nq=p\np.X=q.X/2\n": 3.5,
    "k[2]=2.7\np.X=k[2]\n": 3.0,
    "n=6 B_AND 3\np.X=n\n": 2.0,
    "p.X=ABS(-3)+COS(60)\n": 3.5,
    "p.X=ATAN2(1,1)+SQRT(2)*SIN(45)\n": 46.0,
    "r=1\ntwice(5,r)\np.X=r\n": 10.0,
    "twice(4,p.X)\n": 8.0,
    "whole(2.6,p)\n": 1.0,
    "p.X=half(9)\n": 4.5,
}
BEHIND = (
    "DEF twice(a:IN,b:OUT)\nREAL a,b\nb=a*2\nEND\nDEF whole(a:IN,b:OUT)\nINT a\nE6POS b\nb.X=a/2\nEND\n"
    "DEFFCT REAL half(a:IN)\nREAL a\nRETURN a/2\nENDFCT\n"
)


@pytest.mark.parametrize("body", FLOW)
def test_loops_and_branches_go_as_their_conditions_say(tmp_path: Path, body: str) -> None:
    assert [x for x, _, _ in places(tmp_path, body)] == FLOW[body]


@pytest.mark.parametrize("body", VALUES)
def test_a_value_is_what_its_type_makes_of_it(tmp_path: Path, body: str) -> None:
    assert places(tmp_path, body + "LIN p\n", BEHIND) == [pytest.approx([VALUES[body], 0.0, 50.0])]


def test_frames_are_chained(tmp_path: Path) -> None:
    """A quarter turn about Z takes X 4 of the second frame along Y of the first."""
    body = "f={X 1,Y 2,Z 3,A 90,B 0,C 0}\nLIN f:{X 4,Y 0,Z 40,A 0,B 0,C 180}\nf=INV_POS(f)\n$BASE=f\n"
    body += "LIN {X 0,Y 0,Z 9,A 0,B 0,C 0}\n"
    assert places(tmp_path, body) == [[1, 6, 43], [0, 0, 9]]
    text = read_krl(tmp_path / "a.src")
    assert text.bases[text.base[1]].xyzabc == pytest.approx([-2, 1, -3, -90, 0, 0])


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ("n=-2.5\np.X=n\nLIN p\n", "no number"),  # which way half of one goes below zero isn't said
        ("$IPO_MODE=#TCP\n" + GO.format(1), "stands by itself"),
        (GO.format(1) + "EXIT\n", "EXIT outside of a loop"),
        ("LOOP\n" + GO.format(1) + "ENDLOOP\n", "never ends"),
        ("n=0\nWHILE n<3\nn=n+1\nn=$ANIN[n]\n" + GO.format(1) + "ENDWHILE\n", "not known any more"),
        (GO.format(1) + "$BASE={X 0,Y 5,Z 0,A 0,B 0,C 0}\nLIN {X 2}\n", "no Y and none is known in this base"),
        (GO.format(1) + "$BASE={X 0,Y 5,Z 0,A 0,B 0,C 0}\np={Z 2}\nLIN p\n", "stands at no target of this base"),
        (GO.format(1) + "CIRC {X 2,Y 1},{X 3,Y 0},CA 90\np={X 2}\nLIN p\n", "stands at no target"),  # it ends elsewhere
        ("p.X=moving(1)\nLIN p\n", "moves, and is a value"),
        ("p.X=ABS(1)\nLIN p\nEND\nDEFFCT REAL ABS(a:IN)\nREAL a\nRETURN 2*a\nENDFCT\nDEF z ( )\n", "one of its own"),
    ],
)
def test_what_a_program_leaves_open_is_refused(tmp_path: Path, body: str, named: str) -> None:
    with pytest.raises(KrlError, match=named):
        places(tmp_path, body, "DEFFCT REAL moving(a:IN)\nREAL a\n" + GO.format(1) + "RETURN a\nENDFCT\n")


def test_the_witness_knows_conditions_in_brackets(tmp_path: Path) -> None:
    """The commonest way to write them: it took their ENDIF for one that closes nothing, and refused the program."""
    body = (
        "n=0\nWHILE (n<2)\nn=n+1\nSWITCH (n)\nCASE 1\nIF (n==1) THEN\n" + GO.format(1) + "ENDIF\nENDSWITCH\nENDWHILE\n"
    )
    assert [x for x, _, _ in places(tmp_path, body)] == [1]
    run = run_program(tmp_path / "a.src", read_machine(KR15))
    assert len(run) == 1 and not any("which way" in gap.text for gap in run.gaps)


def test_the_witness_divides_components_as_reals() -> None:
    variables = Variables()
    variables.put("P", {"X": 7})
    assert variables.value("P.X/2") == 3.5
