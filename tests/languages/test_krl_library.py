"""What KUKA's library and the controller's numbers make of a program of others: BAS by LDAT_ACT and PDAT_ACT, REAL of 32 bits.

What BAS does is KUKA's BAS.SRC, which lies on every controller; REAL is of single precision ("Expert Programming", data types).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_krl_of_others import HEAD, ends, left_open, run

from camrob.errors import KrlError
from camrob.languages.krl.reader.read_krl import read_krl


def read(tmp_path: Path, body: str, data: str = "", tail: str = ""):
    """What camrob's reader makes of the same program."""
    (tmp_path / "job.src").write_text(f"DEF job ( )\n{HEAD}{body}\nEND\n{tail}", encoding="utf-8")
    (tmp_path / "job.dat").write_text(f"DEFDAT job\n{data}\nENDDAT\n")
    return read_krl(tmp_path / "job.src")


P0 = "LIN {X 97,Y -41.764,Z 610,A 180,B 0,C 20.42}\n"
FORM = "LDAT_ACT={VEL 0.03,ACC 100.0,APO_DIST 0.5,APO_FAC 50.0,ORI_TYP #VAR,CIRC_TYP #BASE}\n"


def test_a_path_s_values_come_from_ldat_act(tmp_path: Path) -> None:
    body = f"{FORM}BAS(#CP_DAT)\n{P0}LDAT_ACT.VEL=0.02\nBAS(#CP_DAT)\nLIN {{X 90}} C_DIS"
    made, program = run(tmp_path, body), read(tmp_path, body)
    assert left_open(made) == [] and made.speed[1:].tolist() == [0.03, 0.02]
    assert np.asarray(program.speed)[1:].tolist() == [0.03, 0.02] and not program.findings


def test_how_the_tool_turns_comes_from_ldat_act(tmp_path: Path) -> None:
    """#CONSTANT keeps the tool as it stands, whatever the target says; what a form leaves out is #VAR."""
    turned = f"{FORM}LDAT_ACT.ORI_TYP=#CONSTANT\nBAS(#CP_DAT)\nLIN {{X 97,Y -41.764,Z 600,A 170,B 0,C 20.42}}"
    back = "\nLDAT_ACT={VEL 0.03,ACC 100.0,APO_DIST 0.5}\nBAS(#CP_DAT)\nLIN {A 170,C 10}"
    made = run(tmp_path, turned + back)
    assert left_open(made) == [] and np.abs(made.path.axis[1] - made.path.axis[0]).max() < 1e-12
    assert np.abs(made.path.axis[2] - made.path.axis[1]).max() > 0.1
    assert [(f.code, f.count) for f in read(tmp_path, turned + back).findings] == [("rotation-type", 1)]
    made = run(tmp_path, "LDAT_ACT=LOTHER\nBAS(#CP_DAT)\nLIN {Z 600}")
    assert any("LDAT_ACT that isn't known" in text for text in left_open(made))


@pytest.mark.parametrize("how", ["$ORI_TYPE=#CONSTANT", "$ORI_TYPE=#JOINT", "$ORI_TYPE=OTHERS"])
def test_a_tool_that_turns_otherwise_for_a_while_is_said(tmp_path: Path, how: str) -> None:
    program = read(tmp_path, f"{how}\nLIN {{X 97,Y -41.764,Z 600,A 170,B 0,C 20.42}}\n$ORI_TYPE=#VAR\nLIN {{Z 590}}")
    assert [f.code for f in program.findings] == ["rotation-type"]
    program = read(tmp_path, f"{how}\nBAS(#INITMOV,0)\n$VEL.CP=0.1\nLIN {{X 97,Y -41.764,Z 600,A 170,B 0,C 20.42}}")
    assert not program.findings


def test_a_circle_that_turns_with_the_path_for_a_while_is_said(tmp_path: Path) -> None:
    body = P0 + "$CIRC_TYPE=#PATH\nCIRC {X 92,Y -36.764},{X 87,Y -41.764}\n$CIRC_TYPE=#BASE"
    assert [f.code for f in read(tmp_path, body).findings] == ["rotation-type"]


def test_a_ptp_s_distance_is_that_of_the_paths_behind_it(tmp_path: Path) -> None:
    form = "PDAT_ACT={VEL 10,ACC 100,APO_DIST 30,APO_MODE #CDIS}\nFDAT_ACT={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\n"
    body = form + "BAS(#PTP_DAT)\nLIN {X 97,Y -41.764,Z 600,A 180,B 0,C 20.42} C_DIS\nLIN {X 90}"
    made = run(tmp_path, body)
    assert any("$APO.CDIS" in o.text for o in made.conduct)
    assert np.asarray(read(tmp_path, body).blend_mm)[1] == 30.0
    other = body.replace(",APO_MODE #CDIS", ",APO_MODE #CPTP")
    assert left_open(run(tmp_path, other)) == [] and np.asarray(read(tmp_path, other).blend_mm)[1] == 0.5


def test_rows_of_the_tables_hold_in_all_files(tmp_path: Path) -> None:
    """A routine of a file of its own finds what the main program has written."""
    (tmp_path / "SETTLE.src").write_text(
        "DEF SETTLE(n:IN)\nINT n\nBAS(#TOOL,n)\nLDAT_ACT.VEL=0.04\nBAS(#CP_DAT)\nEND\n"
    )
    body = (
        f"INT n\nn=11\n{FORM}TOOL_DATA[n]={{X 0,Y -41.763657,Z 315.577926,A 0,B 0,C -159.579784}}\nSETTLE(n)\n"
        "LIN {X 97,Y -41.764,Z 600,A 180,B 0,C 20.42}"
    )
    made = run(tmp_path, body)
    assert left_open(made) == [] and ends(made)[1] == [97, -41.764, 600] and made.speed[1] == 0.04
    assert np.asarray(read(tmp_path, body).speed)[1] == 0.04


def test_a_function_may_call_routines_that_change_its_own_variables(tmp_path: Path) -> None:
    tail = (
        "DEFFCT REAL TWICE(x:IN)\nREAL x,y\ny=x\nDOUBLE(y)\nRETURN y\nENDFCT\nDEF DOUBLE(v:OUT)\nREAL v\nv=v*2.0\nEND\n"
        "DEFFCT REAL SPOILS(v:OUT)\nREAL v\nv=v+1.0\nRETURN v\nENDFCT\n"
    )
    made = run(tmp_path, "REAL z\nz=300\nLIN {X 97,Y -41.764,Z TWICE(z),A 180,B 0,C 20.42}", tail=tail)
    assert left_open(made) == [] and ends(made)[1] == [97, -41.764, 600]
    made = run(tmp_path, "REAL z\nz=599\nLIN {X 97,Y -41.764,Z SPOILS(z),A 180,B 0,C 20.42}", tail=tail)
    assert any("does more than return" in text for text in left_open(made))


def test_steps_of_the_spline_kind_and_roundings_of_steps(tmp_path: Path) -> None:
    made = run(tmp_path, "LIN {X 97,Y -41.764,Z 600,A 180,B 0,C 20.42}\nSLIN_REL {Z -10}\nSLIN_REL {X 5} #TOOL")
    assert not made.gaps and ends(made)[2] == [97, -41.764, 590]
    assert [o.code for o in made.objections] == ["spline-unasked"]
    turned = run(
        tmp_path, "LIN {X 97,Y -41.764,Z 600,A 180,B 0,C 20.42}\nLIN_REL {X 5} #TOOL\nLIN_REL {X -5} C_VEL\nLIN {Z 580}"
    )
    assert any("C_VEL" in text for text in left_open(turned))


# REAL has 32 bits


@pytest.mark.parametrize(
    "body",
    [
        "REAL x\nx=0.0\nWHILE x<1.0\nx=x+0.1\nLIN {Z 600}\nENDWHILE",  # in double 11 times, in single precision 10
        "REAL x\nx=0.0\nREPEAT\nx=x-0.2\nLIN {Z 600}\nUNTIL x==-0.4",
        "REAL x\nx=0.1\nIF x*3==0.3 THEN\nLIN {Z 600}\nENDIF",
        "INT n\nREAL x\nx=0.7\nn=x*5\nFOR i=1 TO n\nLIN {Z 600}\nENDFOR",  # 3.5: whether 3 or 4
        "REAL x\nx=SIN(30)\nIF x>=0.5 THEN\nLIN {Z 600}\nENDIF",
    ],
)
def test_reals_that_single_precision_decides_are_not_decided(tmp_path: Path, body: str) -> None:
    assert left_open(run(tmp_path, P0 + "INT i\n" + body))
    with pytest.raises(KrlError, match=r"course|condition"):
        read(tmp_path, P0 + "INT i\n" + body)


@pytest.mark.parametrize(
    ("body", "count"),
    [
        ("REAL x\nx=0.0\nWHILE x<24.0\nx=x+12\nLIN {Z 600}\nENDWHILE", 2),  # no rounding anywhere
        ("REAL x\nx=0.0\nREPEAT\nx=x+0.25\nLIN {Z 600}\nUNTIL x==1.0", 4),
        ("REAL x\nx=8.3\nIF x==8.3 THEN\nLIN {Z 600}\nENDIF", 1),  # twice the same REAL
        ("REAL x\nx=0.7\nIF x*5>3.4 THEN\nLIN {Z 600}\nENDIF", 1),
        ("INT n\nREAL x\nx=12.3\nn=x/0.1\nIF n==123 THEN\nLIN {Z 600}\nENDIF", 1),
        ("REAL x\nx=16777216.0\nIF x<16777217.0 THEN\nLIN {Z 600}\nENDIF\nLIN {Z 590}", 1),  # the same in 32 bits
    ],
)
def test_reals_that_are_far_enough_apart_are_decided(tmp_path: Path, body: str, count: int) -> None:
    made = run(tmp_path, P0 + body)
    program = read(tmp_path, P0 + body)
    assert left_open(made) == [] and len(made) == len(program) == 2 + count
