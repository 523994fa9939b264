"""Edits that change nothing that matters: verify has to pass them."""

from __future__ import annotations

import re

from planted.edits import Edit, Files, Planted, after, before, drop, file, move, replace, sub, text, wrap

__all__ = ["ARGUABLE", "LEGAL"]

LEGAL: list[Planted] = []
ARGUABLE: list[Planted] = []
"""Reported, and not counted: somebody could want the one or the other."""

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"


def legal(job: str, name: str, why: str, *edits: Edit) -> None:
    LEGAL.append(Planted(job, name, why, edits))


def arguable(job: str, name: str, why: str, *edits: Edit) -> None:
    ARGUABLE.append(Planted(job, name, why, edits))


def _lower(t: str) -> str:
    return t.replace("LIN {E6POS: X", "lin {e6pos: x").replace("$VEL.CP", "$vel.cp").replace("$OUT", "$out")


def _one_file(files: Files) -> None:
    main = re.sub(r"(?m)^EXT face.*\n", "", files["face.src"])
    for name in sorted(n for n in files if n.startswith("face_")):
        main += re.sub(r"(?m)^&.*\n", "", files.pop(name))
    files["face.src"] = main


legal("mill", "lower case", "KRL knows no case", text(_lower))
legal("mill", "CRLF", "line ends of the controller", text(lambda t: t.replace("\n", "\r\n")))
legal(
    "mill",
    "blanks and tabs",
    "free format",
    text(lambda t: t.replace("LIN {E6POS: X ", "  LIN  {E6POS:  X  ").replace(",Y ", ", Y\t")),
)
legal(
    "mill",
    "comments",
    "comments",
    before(CUT, "; first cut of the day\n;FOLD my fold;%{PE}%MKUKATPUSER\n;ENDFOLD"),
    sub(CUT, "", " ; straight"),
)
legal("mill", "untyped aggregate", "as other posts write", text(lambda t: t.replace("LIN {E6POS: ", "LIN {")))
legal("mill", "PTP by E6AXIS untyped", "likewise", text(lambda t: t.replace("PTP {E6AXIS: ", "PTP {")))
legal("mill", "S as bits", "'B10' is 2", sub("PTP {E6POS", "S 2,T 10", "S 'B10',T 'B1010'"))
legal("mill", "feed as an expression", "600/60000.0", sub("$VEL.CP = 0.010000", "0.010000", "600/60000.0"))
legal(
    "mill",
    "feed in a variable",
    "FEED is set before",
    after("DEF mill", "DECL REAL FEED"),
    before("BAS (#INITMOV", "FEED = 0.01"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = FEED"),
)
legal(
    "mill",
    "feed in the .dat",
    "FEED is 0.01 there",
    before("ENDDAT", "DECL REAL FEED=0.01", name="mill.dat"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = FEED"),
)
legal(
    "mill",
    "exact stop in the air",
    "stops at the corner of two rapids",
    sub("LIN {E6POS: X 0.000,Y 0.000,Z 258", " C_DIS", ""),
)
legal("mill", "C_DIS left out in the cut", "exact stops", sub(POCKET, " C_DIS", ""))
legal("mill", "slower PTP", "5 %", sub("BAS (#VEL_PTP", "10", "5"))
legal(
    "mill",
    "slower rapid in the air",
    "0.1 m/s for 0.2",
    text(lambda t: t.replace("$VEL.CP = 0.200000", "$VEL.CP = 0.100000")),
)
legal("mill", "smaller $APO", "0.1 mm", sub("$APO.CDIS", "0.500", "0.100"))
legal("mill", "$ADVANCE = 3", "KUKA's own default", sub("$ADVANCE", "5", "3"))
arguable("mill", "longer run-up", "5 s", sub("WAIT SEC 3.0", "3.0", "5.0"))
arguable("mill", "HALT before the start", "operator confirms at HOME", before("HALT ;change", "HALT"))
arguable(
    "mill", "WAIT FOR before the start", "door closed, at HOME, spindle off", before("HALT ;change", "WAIT FOR $IN[1]")
)
arguable("mill", "spindle off twice", "already off", after("$OUT[1] = FALSE ;spindle off", "$OUT[1] = FALSE"))
legal(
    "mill",
    "a cut in two",
    "a point on the line in between",
    before(CUT, "LIN {E6POS: X -5.000,Y -30.000,Z 196.000,A -140.7656,B 0.0,C 0.0,E1 70.0057,E2 -6.1841} C_DIS"),
)
legal(
    "mill",
    "HOME once more",
    "PTP to where it stands",
    after("PTP {E6AXIS", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}", nth=-1),
)
legal(
    "mill",
    "HOME in a variable",
    "XHOME declared in the .dat",
    before("ENDDAT", "DECL E6AXIS XHM={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 90.0,A6 0.0,E1 0.0,E2 0.0}", name="mill.dat"),
    replace("PTP {E6AXIS", "PTP XHM", nth=-1),
)
legal(
    "mill",
    "A by 360",
    "the same rotation",
    text(
        lambda t: re.sub(
            r"(X 30\.000,Y -30\.000,Z 196\.000,A )(-[\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 360:.4f}", t
        )
    ),
)
legal(
    "mill",
    "retract in a subprogram of the file",
    "the same motions",
    before(POCKET, "KEEP ( )"),
    after("END", "DEF KEEP ( )\n; nothing\nEND", nth=-1),
)
legal(
    "mill",
    "cut in a subprogram of the file",
    "the same motions",
    replace(POCKET, "KEEP ( )"),
    after("END", "DEF KEEP ( )\nLIN {X 20,Y 0,Z 197,A -136.836,B 0,C 0,E1 45.6257,E2 -4.3098} C_DIS\nEND", nth=-1),
)
legal("mill", "IF TRUE", "always", wrap(POCKET, POCKET, "IF TRUE THEN", "ENDIF"))
legal("mill", "FOR 1 TO 1", "once", after("DEF mill", "DECL INT I"), wrap(POCKET, POCKET, "FOR I=1 TO 1", "ENDFOR"))
legal("mill", "header lines gone", "&ACCESS and so on are optional", drop("&ACCESS"), drop("&REL"))
legal("mill", ".dat without EXT", "BAS is global", file("mill.dat", "DEFDAT mill\nENDDAT\n"))
legal("mill", "folds renamed", "comments", text(lambda t: t.replace(";FOLD RIM", ";FOLD my own")))
arguable(
    "two",
    "comment after HALT changed",
    "words only, number kept",
    sub("HALT ;change to tool 2", "change to", "please mount"),
)
legal("two", "unneeded zero", "3.0 for 3000", sub("$ANOUT", "3000 /", "3000.0 /", nth=1))
legal(
    "face", "calls without blanks", "face_001()", text(lambda t: re.sub(r"(?m)^face_00(\d) \( \)", r"face_00\1()", t))
)
legal("face", "all in one file", "subs as local DEFs", _one_file)

legal("mill", "S and T on a LIN", "ignored there", sub(CUT, ",E1", ",S 2,T 10,E1"))
legal("mill", "coolant before the spindle", "both at HOME", move("$OUT[2] = TRUE", "$ANOUT", ahead=True))
legal(
    "mill",
    "base set again",
    "the same",
    before(POCKET, "$BASE = EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,{X 0,Y 0,Z 0,A 0,B 0,C 0})"),
)
legal(
    "mill",
    "tool set again",
    "the same",
    before(POCKET, "$TOOL = {X 0.0,Y -41.76366,Z 415.57793,A 0.0,B 0.0,C -159.57978}"),
)
legal("mill", "$OV_PRO = 100", "what is meant anyway", before("PTP {E6AXIS", "$OV_PRO = 100"))
legal("mill", "$IPO_MODE = #BASE", "what INITMOV sets", after("BAS (#INITMOV", "$IPO_MODE = #BASE"))
legal("mill", "routine never called", "does nothing", after("END", "DEF NEVER ( )\n$OUT[1] = FALSE\nEND", nth=-1))
legal(
    "mill",
    "KUKA's BAS INI",
    "the template's own fold",
    before("BAS (#INITMOV", "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3"),
)
legal(
    "mill", "override in T1", "a lower override by hand mode is the operator's", before("PTP {E6AXIS", "; $OV_PRO = 10")
)
legal("mill", "BAS(#VEL_CP) for $VEL.CP", "the same feed", replace("$VEL.CP = 0.010000", "BAS (#VEL_CP,0.01 )"))
legal("mill", "BAS(#ACC_CP)", "2 m/s2, as set", replace("$ACC.CP", "BAS (#ACC_CP,2.0 )"))
legal(
    "mill",
    "DECL without DECL",
    "REAL FEED alone is a declaration",
    after("DEF mill", "REAL FEED"),
    before("BAS (#INITMOV", "FEED = 0.01"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = FEED"),
)
legal("mill", "SLIN for LIN", "the same line", sub(CUT, "LIN", "SLIN"))
legal("mill", "fewer digits", "3 for 3.000", text(lambda t: t.replace(".000,Y", ",Y")))
legal(
    "mill", "more comments in INI", "comments", before("BAS (#INITMOV", ";FOLD BASISTECH INI\n;ENDFOLD (BASISTECH INI)")
)
legal(
    "mill",
    "WAIT SEC 0 in the air",
    "stops the advance run",
    before("LIN {E6POS: X 0.000,Y 0.000,Z 203.000", "WAIT SEC 0"),
)
legal("drill", "dwell as an expression", "0.25 * 2", sub("WAIT SEC 0.500", "0.500", "0.25 * 2"))
legal(
    "five",
    "E2 kept",
    "left out, so it stays: another posture, the same tool",
    text(lambda t: re.sub(r"(LIN \{E6POS: X 15\.000,Y 5\.000.*),E2 [-\d.]+\}", r"\1}", t)),
)
arguable("mill", "REPEAT UNTIL TRUE", "once", before(POCKET, "REPEAT"), after(POCKET, "UNTIL TRUE"))
arguable("mill", "LOOP with EXIT", "once", before(POCKET, "LOOP"), after(POCKET, "EXIT\nENDLOOP"))
arguable(
    "mill",
    "SWITCH with the case",
    "always",
    before(POCKET, "SWITCH 1\nCASE 1,2"),
    after(POCKET, "DEFAULT\nHALT\nENDSWITCH"),
)
arguable(
    "mill",
    "base through a variable",
    "EK() may have to be set at $BASE itself",
    after("DEF mill", "DECL FRAME F"),
    replace("$BASE", "F = EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 0,Y 0,Z 0,A 0,B 0,C 0})\n$BASE = F"),
)
legal(
    "mill",
    "point of the data list",
    "the same point",
    before(
        "ENDDAT",
        "DECL E6POS XP={X 30.0,Y -30.0,Z 196.0,A -139.7295,B 0.0,C 0.0,S 2,T 10,E1 53.6529,E2 -5.3720}",
        name="mill.dat",
    ),
    replace(CUT, "LIN XP C_DIS"),
)
arguable(
    "two",
    "spindle off behind the way to the change",
    "off before the HALT, but turning on the way",
    move("$OUT[1] = FALSE", "PTP {E6AXIS", to_nth=1, count=2),
)
legal("drill", "a last feed of fewer digits", "0.2 for 0.200000", sub("$VEL.CP = 0.200000", "0.200000", "0.2", nth=-1))
legal(
    "mill",
    "short feed in a routine never called",
    "does nothing",
    after("END", "DEF NEVER ( )\n$VEL.CP = 0.3\nEND", nth=-1),
)
arguable(
    "mill",
    "spindle off lost",
    "off at HOME by the footer, but turning on the way",
    drop("$OUT[1] = FALSE"),
    drop("WAIT SEC 3.0", nth=-1),
)
