"""Faults in what a program sets: frames, loads, speeds, how motions are interpolated."""

from __future__ import annotations

from planted.edits import Edit, Planted, after, before, drop, move, replace, sub, text

__all__ = ["SETTINGS"]

SETTINGS: list[Planted] = []

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"  # of mill: the first straight cut
PLUNGE = "LIN {E6POS: X -40.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"


def fault(job: str, name: str, why: str, *edits: Edit) -> None:
    SETTINGS.append(Planted(job, name, why, edits))


# frames in the head
fault("mill", "$ACT_EX_AX = 1", "the table's kinematic is not the one whose base is set", sub("$ACT_EX_AX", "2", "1"))
fault("mill", "$ACT_EX_AX dropped", "whatever the program before left", drop("$ACT_EX_AX"))
fault("mill", "$ACT_EX_AX after $BASE = 0", "external kinematic given up", after("$BASE", "$ACT_EX_AX = 0"))
fault("mill", "$IPO_MODE = #TCP", "the part is taken to be on the flange", after("$TOOL", "$IPO_MODE = #TCP"))
fault("mill", "$IPO_MODE = #TCP in cut", "$BASE and $TOOL swap roles at depth", before(CUT, "$IPO_MODE = #TCP"))
fault(
    "mill", "base without EK", "base stands still while E2 turns", replace("$BASE", "$BASE = {X 0,Y 0,Z 0,A 0,B 0,C 0}")
)
fault(
    "mill",
    "base of mechanism 1",
    "another mechanism's root",
    text(lambda t: t.replace("MACHINE_DEF[2]", "MACHINE_DEF[1]")),
)
fault("mill", "base Z 2 mm", "2 mm too high", sub("$BASE", "Z 0.00000", "Z 2.00000"))
fault("mill", "base A 0.5", "part turned by half a degree", sub("$BASE", "A 0.00000", "A 0.50000"))
fault("mill", "base dropped", "whatever base was active", drop("$BASE"))
fault("mill", "base := BASE_DATA[1]", "some taught base", replace("$BASE", "$BASE = BASE_DATA[1]"))
fault("mill", "$BASE = $NULLFRAME in cut", "base jumps to $WORLD at depth", before(CUT, "$BASE = $NULLFRAME"))
fault("mill", "$BASE.Z in cut", "1.5 mm deeper from here", before(CUT, "$BASE.Z = -1.5"))
fault("mill", "$BASE = $BASE : {Z -1}", "1 mm deeper", before(CUT, "$BASE = $BASE : {X 0,Y 0,Z -1,A 0,B 0,C 0}"))
fault("mill", "BAS(#BASE,1)", "another base through BAS", after("$TOOL", "BAS (#BASE,1 )"))
fault("mill", "BAS(#EX_BASE,1)", "another base through BAS", after("$TOOL", "BAS (#EX_BASE,1 )"))
fault("mill", "BAS(#TOOL,1)", "another tool through BAS", after("$TOOL", "BAS (#TOOL,1 )"))
fault("mill", "BAS(#FRAMES)", "tool and base of the last FDAT", after("$TOOL", "BAS (#FRAMES,0 )"))
fault("mill", "BAS(#INITMOV) in the cut", "default $VEL.CP and frames at depth", before(CUT, "BAS (#INITMOV,0 )"))
fault("mill", "INITMOV behind the settings", "resets $ADVANCE, speeds, base", move("BAS (#INITMOV", "$TOOL"))
fault("mill", "INITMOV dropped", "interpolation as the program before left it", drop("BAS (#INITMOV"))
fault("mill", "$ROBROOT", "foot moved", after("$TOOL", "$ROBROOT = {X 0,Y 0,Z 10,A 0,B 0,C 0}"))
fault("mill", "$WORLD", "world moved", after("$ACT_EX_AX", "$WORLD = {X 0,Y 0,Z 5,A 0,B 0,C 0}"))
fault("mill", "$ET2_TA", "table's own geometry", after("$TOOL", "$ET1_TA1A2.Z = 5.0"))
fault("mill", "tool 5 mm longer", "all is 5 mm too high", sub("$TOOL", "Z 415.57793", "Z 420.57793"))
fault("mill", "tool shorter by 1", "cuts 1 mm deeper", sub("$TOOL", "Z 415.57793", "Z 414.57793"))
fault("mill", "tool C reversed", "spindle tilted by 41 degrees", sub("$TOOL", "C -159", "C 159"))
fault("mill", "tool := TOOL_DATA[1]", "not known here", replace("$TOOL", "$TOOL = TOOL_DATA[1]"))
fault("mill", "$TOOL.Z in cut", "offset creeps in by a macro", before(CUT, "$TOOL.Z = $TOOL.Z - 1.0"))
fault("mill", "$TOOL = $TOOL : {..}", "likewise", before(CUT, "$TOOL = $TOOL : {X 0,Y 0,Z 1,A 0,B 0,C 0}"))
fault("mill", "$TOOL dropped", "the tool of the program before", drop("$TOOL"))
fault("mill", "$LOAD of 500 kg", "dynamic model wrong", after("$TOOL", "$LOAD.M = 500.0"))
fault("mill", "E1 and E2 asynchronous", "track and table no longer follow", after("$TOOL", "$ASYNC_AXIS = 'B0011'"))
fault("mill", "table asynchronous in cut", "E2 stands still", before(CUT, "$ASYNC_AXIS = 'B0010'"))
fault("mill", "$EX_AX_IGNORE", "external axes left out of motions", before(CUT, "$EX_AX_IGNORE = 'B0011'"))
fault("mill", "ASYPTP of the track in the cut", "track runs off by itself", before(CUT, "ASYPTP {E1 500.0}"))
fault("mill", "software limit moved", "limit no longer protects", after("$TOOL", "$SOFTP_END[2] = 100.0"))
# speeds and accelerations
fault("mill", "PTP at 100 %", "ten times the cell's speed in the air", sub("BAS (#VEL_PTP", "10", "100"))
fault("mill", "VEL_PTP dropped", "INITMOV leaves 100 %", drop("BAS (#VEL_PTP"))
fault("mill", "$VEL_AXIS at 100", "likewise", before("PTP {E6POS", "$VEL_AXIS[1] = 100\n$VEL_AXIS[2] = 100"))
fault("mill", "$VEL_AXIS[1] = 1", "A1 crawls: the feed is not held in CP", before("PTP {E6POS", "$VEL_AXIS[1] = 1"))
fault("mill", "$VEL_EXTAX[1] = 1", "track crawls: the cut is slower", before("PTP {E6POS", "$VEL_EXTAX[1] = 1"))
fault("mill", "$ACC_AXIS[2] = 100", "axis acceleration", after("$TOOL", "$ACC_AXIS[2] = 200"))
fault("mill", "$ACC.CP = 20", "beyond the machine", sub("$ACC.CP", "2.0000", "20.0000"))
fault("mill", "$ACC.CP = 0.0001", "never reaches the feed: rubs", sub("$ACC.CP", "2.0000", "0.0001"))
fault("mill", "$OV_PRO = 10", "a tenth of the feed: burns", before(CUT, "$OV_PRO = 10"))
fault("mill", "$RED_VEL = 20", "programmed reduction", before(CUT, "$RED_VEL = 20"))
fault("mill", "BAS(#VEL_CP,0.2) in cut", "rapid at depth", before(CUT, "BAS (#VEL_CP,0.2 )"))
fault("mill", "BAS(#CP_PARAMS,0.2) in cut", "rapid at depth", before(CUT, "BAS (#CP_PARAMS,0.2 )"))
fault("mill", "BAS(#PTP_PARAMS,100)", "PTP at 100 %", before("PTP {E6POS", "BAS (#PTP_PARAMS,100 )"))
fault("mill", "plunge at the rapid", "the feed's line lost", drop("$VEL.CP = 0.003333"))
fault("mill", "feed's decimal slipped", "ten times the feed", sub("$VEL.CP = 0.010000", "0.010000", "0.100000"))
fault("mill", "feed in m/min", "0.6 m/s for 0.6 m/min", sub("$VEL.CP = 0.010000", "0.010000", "0.600000"))
fault("mill", "feed a tenth", "rubs and burns", sub("$VEL.CP = 0.010000", "0.010000", "0.001000"))
fault("mill", "$VEL.CP behind the plunge", "plunge at the rapid", move("$VEL.CP = 0.003333", PLUNGE))
fault("mill", "$VEL aggregate", "rapid at depth", before(CUT, "$VEL = {CP 0.2,ORI1 200.0,ORI2 200.0}"))
fault("mill", "rapid feed back late", "rapid one motion too early", move("$VEL.CP = 0.200000", "WAIT SEC 2.000", nth=1))
fault(
    "mill",
    "feed from an unset variable",
    "REAL F never gets a value",
    after("DEF mill", "DECL REAL F"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = F"),
)
fault(
    "mill",
    "feed from a wrong array element",
    "rapid for feed",
    after("DEF mill", "DECL REAL F[2]"),
    before("BAS (#INITMOV", "F[1] = 0.01\nF[2] = 0.2"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = F[2]"),
)
fault(
    "mill",
    "feed reckoned in integers",
    "600/60000 is 0 in integers",
    sub("$VEL.CP = 0.010000", "0.010000", "600/60000"),
)
fault(
    "mill",
    "feed scaled by $OV_PRO",
    "depends on the override's knob",
    sub("$VEL.CP = 0.010000", "0.010000", "0.0001*$OV_PRO"),
)
fault("five", "$VEL.ORI2 = 0.5", "the swing holds back the feed", sub("$VEL.ORI2", "200.000", "0.500"))
fault("five", "$VEL.ORI1 = 0.5 in cut", "likewise", before("LIN {E6POS: X 0.000,Y 8.000", "$VEL.ORI1 = 0.5"))
fault("five", "$ACC.ORI2 = 0.1", "likewise", sub("$ACC.ORI2", "400.000", "0.100"))
fault("five", "$ORI_TYPE = #CONSTANT", "the tool is not swung", sub("$ORI_TYPE", "#VAR", "#CONSTANT"))
fault(
    "five", "$ORI_TYPE = #CONSTANT in cut", "likewise", before("LIN {E6POS: X 0.000,Y 8.000", "$ORI_TYPE = #CONSTANT")
)
fault("five", "$ORI_TYPE = #JOINT", "wrist interpolated by axes", sub("$ORI_TYPE", "#VAR", "#JOINT"))
fault("mill", "$CIRC_TYPE = #PATH", "wrist turns 90 degrees with the arc", sub("$CIRC_TYPE", "#BASE", "#PATH"))
fault("mill", "$APO.CDIS = 50", "corners cut off by centimetres", sub("$APO.CDIS", "0.500", "50.000"))
fault("mill", "$APO.CDIS = 8 before the pocket", "8 mm corners in the pocket", before(POCKET, "$APO.CDIS = 8"))
fault("mill", "BAS(#APO..) 40", "corners through BAS", before(POCKET, "BAS (#APO_DIS,40 )"))
fault(
    "mill",
    "C_VEL with $APO.CVEL = 100",
    "corner rounded from mid-line on",
    before(POCKET, "$APO.CVEL = 100"),
    sub(POCKET, "C_DIS", "C_VEL"),
)
fault(
    "five",
    "C_ORI with $APO.CORI = 90",
    "swing rounded far ahead",
    before("LIN {E6POS: X 0.000,Y 8.000", "$APO.CORI = 90"),
    sub("LIN {E6POS: X 0.000,Y 8.000", "C_DIS", "C_ORI"),
)
fault("mill", "PTP entry approximated", "$APO.CPTP unset, corner over the part", sub("PTP {E6POS", "", " C_PTP C_DIS"))
fault("mill", "servo filter", "jerk no longer the cell's", after("$TOOL", "$FILTER = 0"))
fault("mill", "collision detection off", "monitoring off", after("$TOOL", "$TORQMON_DEF[1] = 1000"))
