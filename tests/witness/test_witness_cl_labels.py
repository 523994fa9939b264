"""The witness runs programs of Siemens and Heidenhain that jump, repeat and call: held to paths worked out by hand."""

from __future__ import annotations

import math

import pytest
from cl_stories import mm

from camrob.witness.cl.running import ordered
from camrob.witness.cl.teller import UNREAD

KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 3 Z S5000\n2 L X+0 Y+0 Z+50 R0 FMAX M3\n3 L Z+0 F600\n"
SIEMENS = "G90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z50\nG1 Z=0 F600\n"


@pytest.fixture
def klartext(tell):
    return lambda body: tell(KLARTEXT + body + "90 END PGM A MM\n", name="a.h")


@pytest.fixture
def siemens(tell):
    return lambda body: tell(SIEMENS + body, name="a.mpf")


def ring(count: int, radius: float) -> list[list[float]]:
    turns = [math.tau * k / count for k in range(count)]
    return [[round(radius * math.cos(t), 6), round(radius * math.sin(t), 6), 0.0] for t in turns]


def held(story, points: list[list[float]]) -> None:
    assert story.complete and mm(story)[:2] == [[0, 0, 50], [0, 0, 0]]
    assert [x for point in mm(story)[2:] for x in point] == pytest.approx([x for p in points for x in p], abs=1e-5)


# -- Heidenhain


@pytest.mark.parametrize(
    "body",
    [
        "4 Q1 = 0\n5 LBL 1\n6 Q2 = 25 * COS Q1\n7 Q3 = 25 * SIN Q1\n8 L X+Q2 Y+Q3\n9 Q1 = Q1 + 30\n"
        "10 FN 12: IF +Q1 LT +360 GOTO LBL 1\n11 M30\n",
        '4 FN 0: Q1 = -30\n5 LBL "ON"\n6 CALL LBL 2\n7 CALL LBL "ON" REP11\n8 M30\n9 LBL 2\n10 FN 1: Q1 = +Q1 + +30\n'
        "11 FN 7: Q2 = COS +Q1\n12 FN 3: Q2 = +Q2 * +25\n13 Q3 = 25 * SIN Q1\n14 L X+Q2 Y+Q3\n15 LBL 0\n",
        "4 Q1 = 0\n5 LBL 5\n6 FN 9: IF +Q1 EQU +360 GOTO LBL 6\n7 Q2 = 25 * COS Q1\n8 Q3 = 25 * SIN Q1\n9 L X+Q2 Y+Q3\n"
        "10 Q1 = Q1 + 30\n11 FN 9: IF +0 EQU +0 GOTO LBL 5\n12 LBL 6\n13 M30\n",
    ],
)
def test_a_ring_by_labels(klartext, body):
    held(klartext(body), ring(12, 25.0))


def test_repeats_in_one_another(klartext):
    """LBL 1 to its call runs three times, and in each of them LBL 2 twice."""
    story = klartext("4 LBL 1\n5 L IY+1\n6 LBL 2\n7 L IX+2\n8 CALL LBL 2 REP 1/1\n9 CALL LBL 1 REP2\n10 M30\n")
    points, x, y = [], 0, 0
    for _ in range(3):
        y += 1
        points.append([x, y, 0])
        for _ in range(2):
            x += 2
            points.append([x, y, 0])
    held(story, points)


@pytest.mark.parametrize(
    "body",
    [
        "4 LBL 1\n5 L IX+1\n6 FN 9: IF +0 EQU +0 GOTO LBL 1\n7 M30\n",
        "4 CALL LBL 1\n5 M30\n6 LBL 1\n7 CALL LBL 1\n8 LBL 0\n",
        "4 LBL 1\n5 L X+1\n6 LBL 1\n7 CALL LBL 1 REP2\n",
        "4 CALL LBL 9\n5 M30\n",
        "4 LBL 1\n5 CALL LBL 1 REP99999999999\n",
        "4 CALL LBL 1\n5 M30\n6 LBL 1\n7 L X+1\n",
        "4 Q1 = 0.1 * 3\n5 FN 9: IF +Q1 EQU +0.3 GOTO LBL 1\n6 LBL 1\n",
        "4 FN 9: IF +Q7 EQU +0 GOTO LBL 1\n5 LBL 1\n",
        "4 FN 9: IF +1 NE +0 GOTO LBL 1\n5 LBL 1\n",
        "4 CALL LBL 1 REP2\n5 LBL 1\n",
        "4 CALL LBL 1\n5 LBL 2\n6 M30\n7 LBL 1\n8 FN 9: IF +0 EQU +0 GOTO LBL 2\n9 LBL 0\n",
        "4 CALL PGM B\n",
        "4 Q206 = 9\n5 CYCL DEF 200 Q200=2 Q201=-3 Q206= FMAX Q202=5 Q203=0 Q204=9\n6 L X+Q206\n",
    ],
)
def test_what_nobody_knows_of_labels_is_a_gap(klartext, body, monkeypatch):
    monkeypatch.setattr(ordered, "MOST_STEPS", 2_000)
    story = klartext(body)
    assert not story.complete and story.gaps[-1].text.startswith(UNREAD)


# -- Siemens


@pytest.mark.parametrize(
    "body",
    [
        "R1=0\nWHILE R1<12\nG1 X=25*COS(R1*30) Y=25*SIN(R1*30)\nR1=R1+1\nENDWHILE\nM30\n",
        "DEF INT NN\nFOR NN=0 TO 11\nG1 X=25*COS(NN*30) Y=25*SIN(NN*30)\nENDFOR\nM30\n",
        "R1=0\nREPEAT\nX=25*COS(R1) Y=25*SIN(R1)\nR1=R1+30\nUNTIL R1==360\nM30\n",
        "R1=0\nLOOP\nIF R1>=360 GOTOF OUT\nX=25*COS(R1) Y=25*SIN(R1)\nR1=R1+30\nENDLOOP\nOUT: M30\n",
        "R1=0\nN10 X=25*COS(R1) Y=25*SIN(R1)\nR1=R1+30\nIF (R1>0) AND (R1<360) GOTOB N10\nM30\n",
        "R1=0\nHERE: X=25*COS(R1) Y=25*SIN(R1)\nR1=R1+30\nREPEAT HERE P=11\nM30\n",
        "R1=-30\nGOTOF ON\nONE: R1=R1+30\nTWO: X=25*COS(R1) Y=25*SIN(R1)\nGOTOF OUT\nON: REPEAT ONE TWO P=12\nOUT: M30\n",
        "%_N_RING_SPF\nX=25*COS(R1) Y=25*SIN(R1)\nR1=R1+30\nM17\n",
    ],
)
def test_a_ring_by_structures(tell, siemens, body):
    if "_SPF" in body:
        story = tell(f"%_N_MAIN_MPF\n{SIEMENS}R1=0\nRING P=12\nM30\n{body}", name="a.mpf")
    else:
        story = siemens(body)
    held(story, ring(12, 25.0))


def test_branches_in_loops_in_subprograms(tell):
    """A subprogram's names are its own, R parameters everybody's."""
    text = (
        f"%_N_MAIN_MPF\n{SIEMENS}DEF REAL WAY=3\nSTEPS\nX=WAY Y=R9\nM30\n%_N_STEPS_SPF\nPROC STEPS\nDEF REAL WAY=7\nR9=0\n"
        + ("WHILE R9<4\nIF R9<2\nX=R9 Y=0\nELSE\nIF R9==3\nY=WAY\nENDIF\nENDIF\nR9=R9+1\nENDWHILE\nRET\n")
    )
    story = tell(text, name="a.mpf")
    held(story, [[1, 0, 0], [1, 7, 0], [3, 4, 0]])


@pytest.mark.parametrize(
    "body",
    [
        "ON: GOTOB ON\nM30\n",
        "R1=0\nLOOP\nX=R1\nR1=R1+1\nENDLOOP\nM30\n",
        "GOTOF NOWHERE\nM30\n",
        "WHILE R7<3\nENDWHILE\nM30\n",
        "WHILE 1<2\nM30\n",
        "ENDWHILE\nM30\n",
        "IF 1<2\nFOR R1=0 TO 3\nENDIF\nENDFOR\nM30\n",
        "A1: X1\nAA: X2\nAA: X3\nGOTOB AA\nM30\n",
        "R1=0.1*3\nIF R1==0.3 GOTOF OUT\nX1\nOUT: M30\n",
        "IF 1<2 AND 2<3 GOTOF OUT\nX1\nOUT: M30\n",
        "GOTOB OUT\nX1\nOUT: M30\n",
        "GOTOF IN\nWHILE 1>2\nIN: X1\nENDWHILE\nM30\n",
        "IF " + "(" * 30_000 + "1<2" + ")" * 30_000 + " GOTOF OUT\nOUT: M30\n",
        "DEF INT NN=7/2\nM30\n",
        "AA: X1\nBB: X2\nENDLABEL: X3\nREPEAT AA P=2\nM30\n",
        "AA: X1\nREPEAT AA P=99999999999\nM30\n",
        "DEF INT NN\nFOR NN=1 TO 2\nX=NN*2\nENDFOR\nY=NN*2\nM30\n",
        "/GOTOF OUT\nX1\nOUT: M30\n",
        "CASE R1 OF 1 GOTOF OUT\nOUT: M30\n",
        "SUB1\nM30\n%_N_SUB1_SPF\nSUB1\nM17\n",
        "SUB1\nM30\n%_N_SUB1_SPF\nX1\n",
        "SUB1(5)\nM30\n%_N_SUB1_SPF\nX1\nM17\n",
        "AA: X1\nIF R1==1 GOTOF OUT\nREPEAT AA\nOUT: M30\n",
    ],
)
def test_what_nobody_knows_of_structures_is_a_gap(siemens, body, monkeypatch):
    monkeypatch.setattr(ordered, "MOST_STEPS", 2_000)
    story = siemens(body)
    assert not story.complete and story.gaps[-1].text.startswith(UNREAD)
