"""Faults in motions: targets, kinds, order, posture, rounding."""

from __future__ import annotations

import re

from planted.edits import Edit, Planted, after, before, drop, move, repeat, replace, sub, text

__all__ = ["MOTION", "OTHER_POSTURE"]

MOTION: list[Planted] = []
OTHER_POSTURE: list[Planted] = []
"""Another way for the arm, the same one for the tool: reported, and not counted."""

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"
PLUNGE = "LIN {E6POS: X -40.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"
POCKET_END = "LIN {E6POS: X 20.000,Y 15.000,Z 197.000"
RAPID = "LIN {E6POS: X -40.000,Y 30.000,Z 258.000"
HOLE = "LIN {E6POS: X 15.000,Y 0.000,Z 192.000"


def fault(job: str, name: str, why: str, *edits: Edit) -> None:
    MOTION.append(Planted(job, name, why, edits))


def arguable(job: str, name: str, why: str, *edits: Edit) -> None:
    OTHER_POSTURE.append(Planted(job, name, why, edits))


def _turned(turns: float, behind: str) -> Edit:
    """E2 by so many turns on every target behind the line that begins so: consistent, but one LIN turns the table."""

    def change(source: str) -> str:
        head, tail = source.split(behind, 1)
        return head + behind + re.sub(r"E2 (-?[\d.]+)\}", lambda m: f"E2 {float(m[1]) + 360 * turns:.4f}}}", tail)

    return text(change)


# targets
fault("mill", "X 31", "1 mm too far", sub(CUT, "X 30.000", "X 31.000"))
fault("mill", "Z 195.9", "0.1 mm too deep", sub(CUT, "Z 196.000", "Z 195.900"))
fault("mill", "X sign", "other side of the part", sub(POCKET, "X 20.000", "X -20.000"))
fault("mill", "C 0.5", "tool leans by half a degree", sub(CUT, "C 0.0000", "C 0.5000"))
fault("mill", "Z left out", "depth of the line before", sub(PLUNGE, "Z 196.000,", ""))
fault("mill", "Z twice", "which one counts is the controller's word", sub(CUT, "Z 196.000", "Z 196.000,Z 190.000"))
fault("mill", "Z 196,000", "decimal comma", sub(CUT, "Z 196.000", "Z 196,000"))
fault("mill", "B left out of a swing", "swing lost", sub(CUT, "B 0.0000", "B 90.0000"))
fault("mill", "POS for E6POS", "E1, E2 not part of POS", sub(CUT, "E6POS", "POS"))
fault("mill", "FRAME for E6POS", "no external axes in FRAME", sub(CUT, "E6POS", "FRAME"))
fault("mill", "E6AXIS for E6POS", "X.. are none of E6AXIS", sub(CUT, "E6POS", "E6AXIS"))
fault("mill", "E2 as E3", "an axis that the cell has not", sub(CUT, "E2 ", "E3 "))
fault(
    "mill",
    "target : frame",
    "5 mm lower by the geometric operator",
    sub(CUT, "} C_DIS", "}:{X 0,Y 0,Z -5,A 0,B 0,C 0} C_DIS"),
)
fault(
    "mill",
    "frame : target",
    "likewise from the left",
    sub(CUT, "LIN {E6POS", "LIN {FRAME: X 0,Y 0,Z -5,A 0,B 0,C 0}:{E6POS"),
)
fault(
    "mill",
    "target from a variable",
    "P never set to the point",
    after("DEF mill", "DECL E6POS P"),
    before("BAS (#INITMOV", "P = {X 30.0,Y -30.0,Z 190.0,A -139.7,B 0,C 0,E1 53.6,E2 -5.4}"),
    replace(CUT, "LIN P C_DIS"),
)
fault(
    "mill",
    "variable changed by component",
    "P.Z moved by a macro",
    after("DEF mill", "DECL E6POS P"),
    sub(CUT, "LIN {E6POS:", "P = {E6POS:"),
    sub("P = {E6POS", " C_DIS", ""),
    after("P = {E6POS", "P.Z = P.Z - 2\nLIN P C_DIS"),
)
fault("mill", "$POS_ACT : {Z -3}", "3 mm down from where it is", after(CUT, "LIN $POS_ACT:{X 0,Y 0,Z -3,A 0,B 0,C 0}"))
fault("mill", "LIN $POS_FOR", "advance pointer's position, off by some motions", after(CUT, "LIN $POS_FOR"))
# kinds
fault(
    "mill",
    "LIN as PTP in the cut",
    "curved way between two points",
    sub(CUT, "LIN", "PTP"),
    sub("PTP {E6POS: X 30", " C_DIS", ""),
)
fault("mill", "LIN as LIN_REL", "absolute numbers taken relative", sub(CUT, "LIN", "LIN_REL"))
fault("mill", "LIN_REL added", "2 mm deeper", after(CUT, "LIN_REL {Z -2}"))
fault("mill", "LIN_REL #TOOL added", "down along the tool", after(CUT, "LIN_REL {Z -2} #TOOL"))
fault("mill", "PTP_REL at depth", "arm turns at depth", after(CUT, "PTP_REL {A1 1.0}"))
fault(
    "mill",
    "SLIN with its own speed",
    "rapid at depth",
    replace(CUT, "SLIN {X 30,Y -30,Z 196,A -139.7,B 0,C 0,E1 53.65,E2 -5.37} WITH $VEL.CP=0.2"),
)
fault(
    "mill",
    "SLIN with its own base",
    "another base",
    replace(CUT, "SLIN {X 30,Y -30,Z 196,A -139.7,B 0,C 0,E1 53.65,E2 -5.37} WITH $BASE=$NULLFRAME"),
)
fault(
    "mill",
    "pocket as SPLINE of SPL",
    "overshoots the corners",
    before(POCKET, "SPLINE"),
    sub(POCKET, "LIN", "SPL"),
    sub("SPL {", " C_DIS", ""),
    sub(POCKET_END, "LIN", "SPL"),
    sub("SPL {E6POS: X 20.000,Y 15", " C_DIS", ""),
    after("SPL {E6POS: X 20.000,Y 15", "ENDSPLINE"),
)
fault("mill", "CIRC as LIN", "chord instead of the arc", text(lambda t: re.sub(r"CIRC \{[^}]*\},\{", "LIN {", t)))
fault(
    "mill",
    "CIRC's points swapped",
    "another arc",
    text(lambda t: re.sub(r"CIRC (\{[^}]*\}),(\{[^}]*\})", r"CIRC \2,\1", t)),
)
fault(
    "mill",
    "CIRC's helper on the other side",
    "goes round the long way",
    sub("CIRC", "X 37.071,Y -27.071", "X 22.929,Y -12.929"),
)
fault("mill", "CIRC with CA 90", "angle instead of the end point", sub("CIRC", " C_DIS", ", CA 45 C_DIS"))
fault("mill", "CIRC with CA 450", "a whole turn more", sub("CIRC", " C_DIS", ", CA 450 C_DIS"))
fault("mill", "CIRC with CA -270", "the other way round", sub("CIRC", " C_DIS", ", CA -270 C_DIS"))
fault("plate", "half circle's helper mirrored", "bulges into the part", sub("CIRC", "Y 10.000", "Y -10.000"))
# posture
fault("mill", "S of the entry", "elbow or wrist flipped", sub("PTP {E6POS", "S 2", "S 6"))
arguable("mill", "T of the entry", "A6 a turn further", sub("PTP {E6POS", "T 10", "T 42"))
arguable("mill", "S and T left out", "posture of the one before", sub("PTP {E6POS", "S 2,T 10,", ""))
arguable("mill", "T left out", "likewise", sub("PTP {E6POS", "T 10,", ""))
fault("mill", "S 'B110'", "as a bit string, another branch", sub("PTP {E6POS", "S 2", "S 'B110'"))
arguable("mill", "entry PTP dropped", "LIN from HOME through the hall", drop("PTP {E6POS"))
fault("mill", "table a turn in one cutting LIN", "E2 spins 360 degrees at depth", _turned(1, "$VEL.CP = 0.010000"))
fault(
    "mill",
    "table a turn in one rapid",
    "spins a turn over the part",
    _turned(-1, "$VEL.CP = 0.200000\nLIN {E6POS: X -40.000,Y 30.000"),
)
arguable(
    "mill",
    "E1 jumps by 300 in the cut",
    "track dashes 300 mm at depth",
    text(
        lambda t: re.sub(
            r"(LIN \{E6POS: X 20\.000,Y 15\.000.*E1 )(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 300:.4f}", t
        )
    ),
)
fault(
    "mill",
    "E1 off the track",
    "beyond the range",
    text(lambda t: re.sub(r"(LIN \{E6POS: X 20\.000,Y 15\.000.*E1 )(-?[\d.]+)", lambda m: f"{m[1]}1600.0", t)),
)
fault(
    "mill",
    "HOME with A2 forward",
    "arm falls over the table",
    sub("PTP {E6AXIS", "A2 -90.0000,A3 90.0000", "A2 -20.0000,A3 120.0000", nth=-1),
)
fault("mill", "HOME partial", "A5, A6 stay", sub("PTP {E6AXIS", ",A4 0.0000,A5 90.0000,A6 0.0000", "", nth=-1))
fault(
    "mill",
    "PTP home from the bottom",
    "retract lost, PTP out of the pocket",
    drop("LIN {E6POS: X 0.000,Y 0.000,Z 298.000"),
    drop("LIN {E6POS: X 0.000,Y 0.000,Z 258.000", nth=-1),
)
fault("mill", "first HOME by $POS_ACT", "start wherever it stands", replace("PTP {E6AXIS", "PTP $POS_ACT"))
fault(
    "mill",
    "foreign PTP between",
    "through the stock",
    after(RAPID, "PTP {A1 10,A2 -40,A3 110,A4 0,A5 40,A6 0,E1 0,E2 0}"),
)
# order and number
fault("mill", "line lost", "corner left out", drop(CUT))
fault("mill", "lines swapped", "another order", move(POCKET, POCKET_END))
fault("mill", "pass doubled", "cut twice", repeat(POCKET, "LIN {E6POS: X 0.000,Y 0.000,Z 197.000", last_nth=-1))
fault("mill", "clearance lost", "straight through at depth", drop("LIN {E6POS: X 0.000,Y 0.000,Z 258.000"), drop(RAPID))
fault("mill", "retract lost", "rapid across at depth", drop(RAPID))
fault("drill", "hole lost", "one hole of three", drop("LIN {E6POS: X 20.000,Y -20.000,Z 186"))
fault(
    "drill",
    "retract between holes lost",
    "slot from hole to hole",
    drop("LIN {E6POS: X -20.000,Y -20.000,Z 218", nth=1),
)
fault("drill", "peck lost", "no chips out", drop("LIN {E6POS: X 0.000,Y 0.000,Z 201", nth=1))
fault(
    "drill",
    "approach below the top",
    "rapid into the stock",
    sub("LIN {E6POS: X 20.000,Y 20.000,Z 201", "Z 201", "Z 190"),
)
fault(
    "drill",
    "re-entry at rapid below the old bottom",
    "rapid into the hole's bottom",
    sub("LIN {E6POS: X 0.000,Y 0.000,Z 192.500", "192.500", "191.500"),
)
# rounding
fault("two", "C_DIS at a hole's bottom", "hole 0.5 mm short", sub(HOLE, "", " C_DIS"))
fault(
    "two",
    "C_VEL at the cut's end",
    "$APO.CVEL as the program before left it",
    sub("LIN {E6POS: X -30.000,Y 20.000,Z 195", "", " C_VEL"),
)
arguable("mill", "C_PTP on a LIN", "no such thing", sub(CUT, "C_DIS", "C_PTP"))
