"""Further rounds of faults: arithmetic, templates taken for harmless, tool changes, scope, what rounds or holds back."""

from __future__ import annotations

import re

from planted.edits import Edit, Planted, after, before, drop, file, move, replace, sub, text

__all__ = ["LATER"]

LATER: list[Planted] = []

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"
FEED = "$VEL.CP = 0.010000"


def fault(job: str, name: str, why: str, *edits: Edit) -> None:
    LATER.append(Planted(job, name, why, edits))


def own(definition: str) -> Edit:
    """A routine behind the main program's END."""
    return after("END", definition, nth=-1)


# a third round: arithmetic, templates that are taken for harmless, tool changes, scope
INI = "BAS (#INITMOV"
IR_HEAD = "GLOBAL INTERRUPT DECL 3 WHEN "
fault(
    "mill",
    "interrupt 3 on another condition",
    "template's name, own routine and condition: spindle off on an input",
    before(INI, IR_HEAD + "$IN[7]==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3"),
    own("DEF IR_STOPM ( )\n$OUT[1] = FALSE\nEND"),
)
fault(
    "mill",
    "template's interrupt, own routine",
    "IR_STOPM of this file switches the spindle off",
    before(INI, IR_HEAD + "$STOPMESS==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3"),
    own("DEF IR_STOPM ( )\n$OUT[1] = FALSE\nEND"),
)
fault(
    "mill",
    "template's interrupt switched on in the cut",
    "a stop message runs a routine at depth that nobody has read",
    before(INI, IR_HEAD + "$OUT[1]==TRUE DO IR_STOPM ( )"),
    before(POCKET, "INTERRUPT ON 3"),
)
fault(
    "mill",
    "IF NOT $ON_PATH round the spindle",
    "spindle on only off the path",
    before("$OUT[1] = TRUE", "IF NOT $ON_PATH THEN"),
    after("$OUT[1] = TRUE", "ENDIF"),
)
fault(
    "mill",
    "IF $ON_PATH round the retract",
    "retract only on the path",
    before("LIN {E6POS: X -40.000,Y 30.000,Z 258", "IF $ON_PATH THEN"),
    after("LIN {E6POS: X -40.000,Y 30.000,Z 258", "ENDIF"),
)
fault("mill", "IF $MODE_OP round the cut", "cut in T1 only", before(CUT, "IF $MODE_OP==#T1 THEN"), after(CUT, "ENDIF"))
fault(
    "mill",
    "IF $IN_HOME then PTP",
    "another way from HOME",
    before("PTP {E6POS", "IF $IN_HOME THEN\nPTP {A1 30}\nENDIF"),
)
fault("mill", "BAS(#CP_DAT) in the cut", "speeds of the last data set", before(CUT, "BAS (#CP_DAT,0 )"))
fault("mill", "BAS(#ACC_CP,0.0001)", "never reaches the feed", before(CUT, "BAS (#ACC_CP,0.0001 )"))
fault("mill", "BAS(#VEL_PTP,100) before the entry", "PTP at 100 %", before("PTP {E6POS", "BAS (#VEL_PTP,100 )"))
fault(
    "mill",
    "EK with a literal root",
    "the table's root is not the machine's",
    sub("$BASE", "MACHINE_DEF[2].ROOT", "{X 0,Y 0,Z 50,A 0,B 0,C 0}"),
)
fault(
    "mill",
    "EK with another mechanism's kind",
    "turns as mechanism 3 does",
    sub("$BASE", "MACHINE_DEF[2].MECH_TYPE", "MACHINE_DEF[3].MECH_TYPE"),
)
fault("mill", "EK's root another field", "not the root", sub("$BASE", "MACHINE_DEF[2].ROOT", "MACHINE_DEF[2].OFFSET"))
fault("mill", "INT division of negatives", "-7/2 is -3: twice the feed", sub(FEED, "0.010000", "(-7/2+5)*0.01"))
fault(
    "mill",
    "INT rounds 1.6 up",
    "I = 1.6 is 2: 750 for 600 mm/min",
    after("DEF mill", "DECL INT I"),
    before(INI, "I = 1.6"),
    sub(FEED, "0.010000", "I*0.00625"),
)
fault(
    "mill",
    "INT rounds 2.5 up",
    "I = 2.5 is 3: 720 for 600 mm/min",
    after("DEF mill", "DECL INT I"),
    before(INI, "I = 2.5"),
    sub(FEED, "0.010000", "I*0.004"),
)
fault(
    "mill",
    "FOR 3 TO 1 STEP -1",
    "pocket's side thrice",
    after("DEF mill", "DECL INT I"),
    before(POCKET, "FOR I=3 TO 1 STEP -1"),
    after("LIN {E6POS: X 0.000,Y 0.000,Z 197.000", "ENDFOR", nth=-1),
)
fault("mill", "program calls itself", "again without end", before("END", "mill ( )"))
fault("mill", "first tool's HALT dropped", "whatever tool is in the spindle", drop("HALT ;change to tool 1"))
fault("mill", "tool 10 for tool 1", "another tool asked for", sub("HALT ;change", "tool 1", "tool 10"))
fault(
    "mill",
    "turn on the spot at depth",
    "a turn about the tool's axis by 90 degrees: a mark",
    after(
        CUT,
        "LIN {X 30,Y -30,Z 196,A -49.7,B 0,C 0,E1 53.65,E2 -5.37}\nLIN {X 30,Y -30,Z 196,A -139.7295,B 0,C 0,E1 53.65,E2 -5.37}",
    ),
)
fault("mill", "PTP $POS_ACT in the cut", "a stop in the cut", before(POCKET, "PTP $POS_ACT"))
fault(
    "two", "run-down wait at the change dropped", "hands in the spindle that still turns", drop("WAIT SEC 3.0", nth=1)
)
fault("two", "waits, then spindle off", "likewise", move("WAIT SEC 3.0", "$OUT[1] = FALSE", nth=1, ahead=True))
fault("two", "coolant on at the change", "floods the operator", drop("$OUT[2] = FALSE"))
fault(
    "two",
    "change at another pose",
    "not where the operator stands",
    sub("PTP {E6AXIS", "A1 0.0000", "A1 60.0000", nth=1),
)
fault(
    "two",
    "change with the arm over the part",
    "not where the operator stands",
    replace(
        "PTP {E6AXIS",
        "PTP {E6POS: X -30.000,Y 20.000,Z 500.000,A -141.2825,B 0.0000,C 0.0000,S 2,T 10,E1 30.0389,E2 -3.3638}",
        nth=1,
    ),
)
fault(
    "face",
    "point of the sub's own data list",
    "6 mm deeper there, right in the main one",
    before(
        "ENDDAT", "DECL E6POS XP={X 40.0,Y 2.0,Z 197.0,A -136.6608,B 0.0,C 0.0,E1 39.3605,E2 -3.9595}", name="face.dat"
    ),
    file(
        "face_003.dat",
        "DEFDAT face_003\nDECL E6POS XP={X 40.0,Y 2.0,Z 191.0,A -136.6608,B 0.0,C 0.0,E1 39.3605,E2 -3.9595}\nENDDAT\n",
    ),
    replace("LIN {E6POS: X 40.000,Y 2.000", "LIN XP C_DIS", name="face_003.src"),
)


# a fourth round
fault(
    "mill",
    "feed by an INT of 9.6",
    "N is 10: 625 for 600 mm/min",
    after("DEF mill", "DECL INT N"),
    before(INI, "N = 9.6"),
    sub(FEED, "0.010000", "N / 960.0"),
)
fault(
    "mill",
    "speed by an INT",
    "N / 24000 is 0: spindle at no speed",
    after("DEF mill", "DECL INT N"),
    before("$ANOUT", "N = 9000"),
    sub("$ANOUT", "9000 / 24000.0", "N / 24000"),
)
fault("mill", "speed 9000 / 24000 * 1.0", "0 * 1.0", sub("$ANOUT", "24000.0", "24000 * 1.0"))
fault("mill", "BAS(#PTP_DAT)", "axis speeds of the last data set", before("PTP {E6POS", "BAS (#PTP_DAT,0 )"))
fault(
    "mill",
    "BAS(#ACC_PTP,1)",
    "crawls out of HOME: a hundredth of the acceleration",
    before("PTP {E6POS", "BAS (#ACC_PTP,1 )"),
)
fault("mill", "INTERRUPT ON for all", "what the program before declared", before(POCKET, "INTERRUPT ON"))
fault(
    "two",
    "E2 at 4 times its speed while the drill goes down",
    "table turns 170 degrees under a drill",
    text(
        lambda t: re.sub(
            r"(LIN \{E6POS: X 15\.000,Y 0\.000,Z 192.*E2 )(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 170:.4f}", t
        )
    ),
)
fault(
    "five",
    "$VEL.ORI1 of nothing",
    "the swing takes minutes",
    sub("$VEL.ORI1", "200.000", "0.001"),
    sub("$VEL.ORI2", "200.000", "0.001"),
)
fault(
    "drill",
    "C_DIS at the first peck",
    "reversal rounded: peck 0.25 mm short",
    sub("LIN {E6POS: X 0.000,Y 0.000,Z 192.000", "", " C_DIS"),
)
fault(
    "drill",
    "$APO.CDIS = 20 and C_DIS at the bottom",
    "hole 10 mm short",
    sub("$APO.CDIS", "0.500", "20.0"),
    sub("LIN {E6POS: X 0.000,Y 0.000,Z 180.000", "", " C_DIS"),
)
fault(
    "mill",
    "$APO.CDIS = 50 in the last cut",
    "corner cut by millimetres",
    before("LIN {E6POS: X 20.000,Y 15.000", "$APO.CDIS = 50"),
)
