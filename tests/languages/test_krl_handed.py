"""What is handed to routines, copied and compared, as reader and witness both read it; each X worked out by hand.

KUKA, "Expert Programming" (KSS 5 to 8): an assignment copies a structure, IN hands a value and OUT the variable itself, a name
that a routine declares hides the module's, comparisons bind loosest of all operators, OR looser than EXOR, EXOR than AND. What a
FOR's counter is behind its loop isn't said clearly enough to be relied on.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import KR15

from camrob.errors import KrlError
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.witness.krl.run import run_program
from camrob.witness.machine import read_machine

MACHINE = read_machine(KR15)
FRAME = "Y 0,Z 500,A 180,B 0,C 20"
HEAD = (
    "BAS (#INITMOV,0 )\n$ACT_EX_AX = 2\n$VEL.CP = 0.1\n"
    "$BASE = EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})\n"
    "$TOOL = {X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}\n"
    "PTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\n"
)
DATA = (
    "DEFDAT job\nDECL E6POS p={X 10," + FRAME + ",S 2,T 2}\nDECL E6POS q={X 20," + FRAME + ",S 2,T 2}\n"
    "DECL E6POS k[2]\nk[1]={X 1," + FRAME + ",S 2,T 2}\nk[2]={X 2," + FRAME + ",S 2,T 2}\n"
    "DECL REAL r=4\nDECL INT i=1\nDECL BOOL yes=TRUE\nDECL BOOL no=FALSE\nENDDAT\n"
)
ROUTINES = (
    "DEF out_of (w:OUT)\nDECL E6POS w\nw.X = w.X + 100\nEND\n"
    "DEF in_to (w:IN)\nDECL E6POS w\nw.X = w.X + 100\nLIN w\nEND\n"
    "DEF more (x:OUT)\nDECL REAL x\nx = x + 100\nEND\n"
    "DEF lost (x:OUT)\nDECL REAL x\nx = $ANIN[1]\nEND\n"
    "DEF first (k[]:OUT)\nDECL E6POS k[]\nLIN k[1]\nEND\n"
    "DEF hidden ()\nDECL REAL r\nLIN {X r}\nEND\n"
    "DEF nothing (r:IN)\nDECL REAL r\nLIN {X r}\nEND\n"
    "DEF each (w[]:OUT)\nDECL E6POS w[]\nw[2].X = w[2].X + 100\nEND\n"
)
KNOWN = {
    "q = p\nq.X = 99\nLIN p\nLIN q": [10, 99],
    "k[2] = k[1]\nk[2].X = 99\nLIN k[1]": [1],
    "in_to(p)\nLIN p": [110, 10],
    "out_of(p)\nLIN p": [110],
    "out_of(k[i + 1])\nLIN k[1]\nLIN k[2]": [1, 102],
    "out_of(k[i])\nLIN k[1]": [101],
    "more(p.X)\nLIN p": [110],
    "more(k[i].X)\nLIN k[i]": [101],
    "s.A = 7\nLIN {X s.A / 2," + FRAME + "}": [3],
    "IF yes OR no == FALSE THEN\nLIN q\nENDIF\nLIN p": [10],
    "IF (i == 1) AND yes THEN\nLIN q\nENDIF\nLIN p": [20, 10],
    "IF yes OR yes EXOR yes THEN\nLIN q\nENDIF\nLIN p": [20, 10],
    "IF 7 B_EXOR 5 == 2 THEN\nLIN q\nENDIF\nLIN p": [20, 10],
    "FOR i = 1 TO 2\nLIN k[i]\nENDFOR": [1, 2],
    "p.X = 10 * ATAN2(3.0, -3.0) / 135\nLIN p": [10],
    "LIN {X 10,Y 20,Z 0,A 90,B 0,C 0}:{X 0,Y 5,Z 500,A 90,B 180,C 0}": [5],  # a quarter about Z takes Y 5 to X -5
    "LIN {X 10,Y 0,Z 0,A 0,B 0,C 0}:INV_POS({X 7,Y 0,Z 500,A 180,B 180,C 0})": [3],  # half a turn about X keeps X 7
}
OPEN = {
    "hidden()": "hides the module's r",
    "nothing()": "is handed nothing",
    "nothing($ANIN[1])": "is handed what nobody knows",
    "lost(r)\nLIN {X r," + FRAME + "}": "hands back what nobody knows",
    "IF i == 1 AND yes THEN\nLIN q\nENDIF": "1 AND yes is neither truth nor number",
    "IF i == TRUE THEN\nLIN q\nENDIF": "a number is no truth",
    "FOR i = 1 TO 2\nENDFOR\nLIN {X i," + FRAME + "}": "2, or 3",
    "FOR i = 1 TO 4\nLIN p\ni = i + 1\nENDFOR": "counts while it is counted",
    "LIN p:q": "what : makes of Status, Turn and external axes isn't said",
    "LIN p:{X 5}": "no whole frame",
    "LIN {X ATAN2(1)," + FRAME + "}": "ATAN2 takes two",
    "LIN {X 9,V 1," + FRAME + "}": "no component of a point",
    "WHILE NOT $IN[1]\nENDWHILE\nLIN {X r / $ANIN[1]," + FRAME + "}": "waits for an input",
}
ARRAYS = {"first(k[])\nLIN k[1]": [1, 1], "each(k[])\nLIN k[2]": [102]}


def written(folder: Path, body: str) -> Path:
    """The program with its data list."""
    (folder / "job.dat").write_text(DATA, encoding="ascii")
    text = f"DEF job ( )\nSTRUC sized INT A,REAL B\nDECL sized s\n{HEAD}{body}\nEND\n{ROUTINES}"
    (folder / "job.src").write_text(text, encoding="ascii")
    return folder / "job.src"


def by_witness(path: Path) -> tuple[list[float], list[str]]:
    """X of each motion behind the first, mm, and what the witness leaves open."""
    made = run_program(path, MACHINE)
    return (1000.0 * made.path.tip[1:, 0]).round(6).tolist(), [gap.text for gap in made.gaps]


@pytest.mark.parametrize("body", [*KNOWN, *ARRAYS])
def test_the_witness_reads_what_is_handed_and_copied(tmp_path: Path, body: str) -> None:
    assert by_witness(written(tmp_path, body)) == ((KNOWN | ARRAYS)[body], [])


@pytest.mark.parametrize("body", KNOWN)
def test_the_reader_reads_what_is_handed_and_copied(tmp_path: Path, body: str) -> None:
    assert read_krl(written(tmp_path, body)).pose[1:, 0].round(6).tolist() == KNOWN[body]


@pytest.mark.parametrize("body", [*OPEN, *ARRAYS])
def test_the_reader_refuses_what_it_can_not_know(tmp_path: Path, body: str) -> None:
    with pytest.raises(KrlError):
        read_krl(written(tmp_path, body))


@pytest.mark.parametrize("body", OPEN)
def test_the_witness_leaves_open_what_it_can_not_know(tmp_path: Path, body: str) -> None:
    assert by_witness(written(tmp_path, body))[1], OPEN[body]


def test_a_tool_that_stands_in_the_cell_by_its_frame_data(tmp_path: Path) -> None:
    """IPO_FRAME of FDAT_ACT becomes $IPO_MODE."""
    path = written(tmp_path, "FDAT_ACT = {TOOL_NO 0,BASE_NO 0,IPO_FRAME #TCP}\nBAS (#FRAMES)\n" + HEAD[18:] + "LIN p")
    assert "external-tool" in [objection.code for objection in run_program(path, MACHINE).objections]
    with pytest.raises(KrlError, match="#TCP"):
        read_krl(path)


def test_corners_are_rounded_again_behind_initmov(tmp_path: Path) -> None:
    path = written(tmp_path, "$ADVANCE = 0\nBAS (#INITMOV,0 )\n" + HEAD + "LIN p C_DIS\nLIN q")
    assert run_program(path, MACHINE).exact.tolist()[-2:] == [False, True]


def test_a_whole_number_that_is_too_large_is_no_traceback(tmp_path: Path) -> None:
    path = written(tmp_path, "LIN {X 99999999999999999999," + FRAME + "}")
    assert "unreachable" in [objection.code for objection in run_program(path, MACHINE).objections]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("SWITCH(i)\nCASE 1\nLIN p\nCASE 2\nLIN q\nENDSWITCH", [10]),
        ("SWITCH i\nCASE#other\nLIN p\nCASE(1)\nLIN q\nENDSWITCH", [20]),
        ("IF(i==1)THEN\nLIN q\nENDIF", [20]),
        ("WHILE(i<2)\nLIN q\ni=2\nENDWHILE", [20]),
    ],
)
def test_words_of_structure_need_no_blank_behind_them(tmp_path: Path, body: str, expected: list[float]) -> None:
    """CASE#B was read as a statement of the part before it, which nobody ran, and IF$IN[1] was a traceback."""
    path = written(tmp_path, body)
    assert by_witness(path) == (expected, [])
    assert read_krl(path).pose[1:, 0].round(6).tolist() == expected


@pytest.mark.parametrize("body", ["WHILE<i 3\nENDWHILE", "SWITCH,i\nCASE 1\nLIN p\nENDSWITCH", "out_of(p))\nLIN p"])
def test_broken_words_of_structure_are_left_open(tmp_path: Path, body: str) -> None:
    assert by_witness(written(tmp_path, body))[1]


def test_a_name_that_begins_as_a_word_of_structure_opens_nothing(tmp_path: Path) -> None:
    with pytest.raises(KrlError, match="ENDIF closes nothing"):
        by_witness(written(tmp_path, "IF$IN[1] THEN\nLIN q\nENDIF"))


def test_a_switch_without_a_case_is_no_traceback(tmp_path: Path) -> None:
    program = read_krl(written(tmp_path, "i=1\nSWITCH i\nENDSWITCH\nLIN p"))
    assert program.pose[-1, 0] == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("head", "said"), [("DEF settings (base:IN,tool:IN)", "handed BASE, TOOL"), ("DEF settings ()", "IF whose course")]
)
def test_a_routine_of_another_program_is_called_that(tmp_path: Path, head: str, said: str) -> None:
    (tmp_path / "settings.src").write_text(f"{head}\nDECL INT base, tool\nIF base == 0 THEN\nPTP XHOME\nENDIF\nEND\n")
    with pytest.raises(KrlError, match=said):
        read_krl(tmp_path / "settings.src")
