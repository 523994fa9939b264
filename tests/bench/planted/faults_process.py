"""Faults in what runs beside the motions: spindle, coolant, tools, waits, flow, interrupts, triggers, other files."""

from __future__ import annotations

from planted.edits import Edit, Planted, after, before, drop, file, move, repeat, replace, sub, text, wrap

__all__ = ["PROCESS"]

PROCESS: list[Planted] = []

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"
PLUNGE = "LIN {E6POS: X -40.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"
POCKET_END = "LIN {E6POS: X 0.000,Y 0.000,Z 197.000"
SPINDLE_OFF = "$OUT[1] = FALSE"
CHANGE = "HALT ;change to tool 2"


def fault(job: str, name: str, why: str, *edits: Edit) -> None:
    PROCESS.append(Planted(job, name, why, edits))


# spindle
fault("mill", "spindle on as a comment", "cuts with the spindle still", sub("$OUT[1] = TRUE", "$OUT", ";$OUT"))
for _name, _char in (("VT", "\x0b"), ("FF", "\x0c"), ("FS", "\x1c"), ("NEL", "\x85"), ("LS", "\u2028"), ("CR", "\r")):
    fault(
        "mill",
        f"spindle on behind a comment and {_name}",
        "one comment line for the controller",
        text(lambda t, c=_char: t.replace("24000.0\n$OUT[1]", f"24000.0 ;speed{c}$OUT[1]", 1)),
    )
fault("mill", "integer division", "9000 / 24000 is 0: spindle at no speed", sub("$ANOUT", "24000.0", "24000"))
fault("mill", "speed range slipped", "3.75 for 0.375", sub("$ANOUT", "24000.0", "2400.0"))
fault("mill", "another speed", "3000 for 9000", sub("$ANOUT", "9000", "3000"))
fault("mill", "speed on channel 2", "spindle keeps the old speed", sub("$ANOUT", "[1]", "[2]"))
fault("mill", "speed line dropped", "speed of the program before", drop("$ANOUT"))
fault("mill", "second speed dropped", "9000 for 12000 in the pocket", drop("$ANOUT", nth=1))
fault("mill", "spindle on output 10", "another output", sub("$OUT[1] = TRUE", "[1]", "[10]"))
fault("mill", "spindle on after the plunge", "plunges with the spindle still", move("$OUT[1] = TRUE", PLUNGE))
fault("mill", "run-up wait 0.03 s", "cuts before the speed is there", sub("WAIT SEC 3.0", "3.0", "0.03"))
fault("mill", "run-up wait dropped", "likewise", drop("WAIT SEC 3.0"))
fault("mill", "spindle by PULSE", "stops after 3 s", replace("$OUT[1] = TRUE", "PULSE($OUT[1],TRUE,3.0)"))
fault("mill", "PULSE off in the cut", "off for 2 s", before(CUT, "PULSE($OUT[1],FALSE,2.0)"))
fault("mill", "off and on in the cut", "off for a moment at depth", before(POCKET, "$OUT[1] = FALSE\n$OUT[1] = TRUE"))
fault("mill", "spindle from an input", "on only if somebody presses", sub("$OUT[1] = TRUE", "TRUE", "$IN[1]"))
fault("mill", "spindle TRUE AND FALSE", "off, reckoned", sub("$OUT[1] = TRUE", "TRUE", "TRUE AND FALSE"))
fault("mill", "spindle NOT TRUE", "off, reckoned", sub("$OUT[1] = TRUE", "TRUE", "NOT TRUE"))
fault("mill", "$OUT_C off in the cut", "off with the main run", before(POCKET, "$OUT_C[1] = FALSE"))
fault("mill", "CONTINUE before coolant off", "off up to five motions early", before("$OUT[2] = FALSE", "CONTINUE"))
fault("mill", "CONTINUE before the second speed", "speed set in the advance run", before("$ANOUT", "CONTINUE", nth=1))
fault(
    "mill",
    "CONTINUE before spindle off",
    "off ahead of the last motions",
    before(SPINDLE_OFF, "CONTINUE"),
    drop("WAIT SEC 3.0", nth=2),
    drop("$OUT[2] = FALSE"),
)
fault(
    "mill",
    "TRIGGER by distance",
    "spindle off in the middle of a cut",
    before(POCKET, "TRIGGER WHEN DISTANCE=0 DELAY=100 DO $OUT[1]=FALSE"),
)
fault(
    "mill",
    "TRIGGER by path",
    "coolant off 20 mm early",
    before(POCKET, "TRIGGER WHEN PATH=-20 DELAY=0 DO $OUT[2]=FALSE"),
)
fault(
    "mill",
    "TRIGGER that calls",
    "a subprogram amid the cut",
    before(POCKET, "TRIGGER WHEN DISTANCE=0 DELAY=0 DO OFF ( ) PRIO=-1"),
    after("END", "DEF OFF ( )\n$OUT[1] = FALSE\nEND", nth=-1),
)
fault(
    "mill",
    "INTERRUPT on a flag",
    "spindle off when anything sets the flag",
    after("DEF mill", "INTERRUPT DECL 5 WHEN $IN[7]==TRUE DO OFF ( )"),
    before(CUT, "INTERRUPT ON 5"),
    after("END", "DEF OFF ( )\n$OUT[1] = FALSE\nEND", nth=-1),
)
fault(
    "mill",
    "INTERRUPT that is always true",
    "likewise at once",
    before("BAS (#INITMOV", "INTERRUPT DECL 5 WHEN $OUT[1]==TRUE DO $OUT[1]=FALSE\nINTERRUPT ON 5"),
)
fault(
    "mill",
    "cyclic ANOUT",
    "speed follows the path speed",
    before(CUT, "ANOUT ON SPEED = 0.5 * $VEL_ACT\nANOUT OFF SPEED"),
)
fault(
    "mill",
    "SIGNAL names the spindle",
    "off under another name",
    after("DEF mill", "SIGNAL AIR $OUT[1]"),
    before(POCKET, "AIR = FALSE"),
)
fault(
    "mill",
    "SIGNAL in the .dat",
    "off under a name of the data list",
    before("ENDDAT", "SIGNAL AIR $OUT[1]", name="mill.dat"),
    before(POCKET, "AIR = FALSE"),
)
fault(
    "mill",
    "SIGNAL of a group",
    "a byte written over all outputs",
    after("DEF mill", "SIGNAL GRP $OUT[1] TO $OUT[8]"),
    before(POCKET, "GRP = 0"),
)
fault(
    "mill", "output by a variable", "N is 1", after("DEF mill", "DECL INT N"), before(POCKET, "N = 1\n$OUT[N] = FALSE")
)
fault(
    "mill",
    "outputs in a loop",
    "all outputs off at depth",
    after("DEF mill", "DECL INT N"),
    before(POCKET, "FOR N=1 TO 4\n$OUT[N] = FALSE\nENDFOR"),
)
fault("mill", "output in hex", "'H1' is 1", before(POCKET, "$OUT['H1'] = FALSE"))
fault("mill", "foreign output", "door, clamp, who knows", before(POCKET, "$OUT[17] = TRUE"))
fault("mill", "spindle off before the last cut", "last pass with the spindle still", move(SPINDLE_OFF, POCKET, count=2))
fault("mill", "spindle left running", "runs at the end", drop(SPINDLE_OFF), drop("$OUT[1] = FALSE ;spindle off"))
fault("mill", "spindle on at the end", "starts again at HOME", sub("$OUT[1] = FALSE ;spindle off", "FALSE", "TRUE"))
fault("mill", "coolant lost", "dry", drop("$OUT[2] = TRUE"))
fault("mill", "coolant after the cut", "dry first cut", move("$OUT[2] = TRUE", CUT))
fault("mill", "coolant left running", "runs at the end", drop("$OUT[2] = FALSE"), drop("$OUT[2] = FALSE ;coolant off"))
# waits and stops
fault("mill", "dwell lost", "no dwell", drop("WAIT SEC 2.000"))
fault("mill", "dwell 200 s", "burns the corner", sub("WAIT SEC 2.000", "2.000", "200.0"))
fault(
    "mill", "dwell one point later", "at another corner", move("WAIT SEC 2.000", "LIN {E6POS: X -40.000,Y 30.000,Z 196")
)
fault("mill", "HALT in the cut", "stands in the cut", before(POCKET, "HALT"))
fault("mill", "WAIT FOR in the cut", "stands in the cut", before(POCKET, "WAIT FOR $IN[3]"))
fault("mill", "WAIT SEC 30 in the cut", "stands in the cut", before(POCKET, "WAIT SEC 30.0"))
fault("two", "STOP lost", "no stop for the operator", drop("HALT", nth=2))
fault("two", "STOP in the hole", "stops at the bottom", move("HALT", "LIN {E6POS: X 0.000,Y 0.000,Z 192", nth=2))
# tools
fault("two", "change lost", "tool 1 drills", drop(CHANGE))
fault("two", "change with the spindle on", "hands in a turning spindle", move(CHANGE, "$OUT[2] = FALSE"))
fault("two", "spindle on before the change", "likewise", move(CHANGE, "WAIT SEC 3.0", to_nth=2))
fault(
    "two", "change at depth", "HALT for the change in the pocket", move(CHANGE, "LIN {E6POS: X -30.000,Y 20.000,Z 195")
)
fault("two", "way to the change lost", "changes over the part", drop("PTP {E6AXIS", nth=1))
fault("two", "$TOOL not switched", "18 mm deeper with the drill", drop("$TOOL", nth=1))
fault(
    "two",
    "$TOOL of the wrong tool",
    "likewise",
    sub("$TOOL", "Y -48.74200,Z 434.32000", "Y -41.76366,Z 415.57793", nth=1),
)
fault(
    "two",
    "$TOOL switched too early",
    "last cut of tool 1 with the drill's length",
    move("$TOOL", "LIN {E6POS: X 30.000,Y 20.000,Z 195", nth=1),
)
fault(
    "two",
    "$TOOL switched after the entry",
    "entry with the other tool's length",
    move("$TOOL", "PTP {E6POS", nth=1, to_nth=1),
)
fault("two", "change to tool 3", "another tool asked for", sub(CHANGE, "tool 2", "tool 3"))
fault("two", "spindle not on for tool 2", "drills with the spindle still", drop("$OUT[1] = TRUE", nth=1))
fault("two", "regions swapped", "drill first, with the mill", text(lambda t: _regions_swapped(t)))
# flow
fault("mill", "IF around the cut", "cut only if an input is set", wrap(CUT, CUT, "IF $IN[5]==TRUE THEN", "ENDIF"))
fault(
    "mill",
    "IF FALSE around the retract",
    "retract never runs",
    wrap("LIN {E6POS: X -40.000,Y 30.000,Z 258", "LIN {E6POS: X -40.000,Y 30.000,Z 258", "IF FALSE THEN", "ENDIF"),
)
fault("mill", "GOTO over the pocket", "pocket left out", before(POCKET, "GOTO M1"), before(POCKET_END, "M1:", nth=-1))
fault("mill", "GOTO back", "never ends", before(POCKET, "M1:"), after(POCKET_END, "GOTO M1", nth=-1))
fault("mill", "LOOP around the pocket", "never ends", wrap(POCKET, POCKET_END, "LOOP", "ENDLOOP", last_nth=-1))
fault(
    "mill",
    "FOR 1 TO 2",
    "pocket twice",
    after("DEF mill", "DECL INT I"),
    wrap(POCKET, POCKET_END, "FOR I=1 TO 2", "ENDFOR", last_nth=-1),
)
fault(
    "mill",
    "FOR 1 TO 0",
    "pocket not at all",
    after("DEF mill", "DECL INT I"),
    wrap(POCKET, POCKET_END, "FOR I=1 TO 0", "ENDFOR", last_nth=-1),
)
fault("mill", "WHILE FALSE", "pocket not at all", wrap(POCKET, POCKET_END, "WHILE FALSE", "ENDWHILE", last_nth=-1))
fault(
    "mill",
    "REPEAT UNTIL an input",
    "as often as it likes",
    wrap(POCKET, POCKET_END, "REPEAT", "UNTIL $IN[4]", last_nth=-1),
)
fault(
    "mill",
    "SWITCH without the case",
    "retract left out",
    wrap(
        "LIN {E6POS: X -40.000,Y 30.000,Z 258",
        "LIN {E6POS: X -40.000,Y 30.000,Z 258",
        "SWITCH 2\nCASE 1",
        "DEFAULT\nENDSWITCH",
    ),
)
fault("mill", "RETURN in the cut", "ends at depth, spindle on", before(POCKET, "RETURN"))
fault("mill", "END in the cut", "likewise", before(POCKET, "END"))
fault("mill", "RETURN before the retract", "ends at depth", before("$OUT[2] = FALSE", "RETURN"))
fault("mill", "unknown call in the cut", "nobody knows", before(POCKET, "TOOL_CLEAN ( )"))
fault(
    "mill",
    "own sub that moves",
    "2 mm down amid the cut",
    before(POCKET, "NUDGE ( )"),
    after("END", "DEF NUDGE ( )\nLIN_REL {Z -2}\nEND", nth=-1),
)
fault(
    "mill",
    "own sub that sets the base",
    "base moved in a subprogram",
    before(POCKET, "NUDGE ( )"),
    after("END", "DEF NUDGE ( )\n$BASE = $NULLFRAME\nEND", nth=-1),
)
fault(
    "mill",
    "BAS of its own",
    "INITMOV does what somebody wrote below",
    after(
        "END",
        "DEF BAS (CMD :IN,V :IN )\nDECL BAS_COMMAND CMD\nDECL REAL V\n$OV_PRO = 100\n$TOOL = $NULLFRAME\nEND",
        nth=-1,
    ),
)
fault(
    "mill",
    "CWRITE to the command channel",
    "another program started",
    before(POCKET, 'CWRITE($CMD,STAT,MODE,"RUN /R1/OTHER()")'),
)
fault("mill", "RSI correction on", "somebody else moves the tool", before(POCKET, "RET = RSI_ON(#RELATIVE)"))
fault("mill", "RSI_MOVECORR", "motion by a sensor", before(POCKET, "RSI_MOVECORR()"))
fault(
    "mill",
    "function of the file named like a system's",
    "SIN lies",
    before(POCKET, "$VEL.CP = FEED ( )"),
    after("END", "DEFFCT REAL FEED ( )\nRETURN (0.2)\nENDFCT", nth=-1),
)
fault("mill", "ON_ERROR_PROCEED", "the next error is swallowed", before("PTP {E6POS", "ON_ERROR_PROCEED"))
# files
fault("face", "subs swapped", "another order", move("face_003 ( )", "face_001 ( )"))
fault("face", "sub lost", "middle left out, line across", drop("face_003 ( )"))
fault("face", "sub twice", "cut twice", repeat("face_002 ( )", "face_002 ( )"))
fault("face", "sub's file gone", "stops on the machine", file("face_003.src", None))
fault(
    "face",
    "sub's depth",
    "1 mm deeper in one line",
    sub("LIN {E6POS: X 40.000,Y 2.000", "Z 197", "Z 196", name="face_003.src"),
)
fault(
    "face",
    "feed not restated in a sub and changed before",
    "rapid in the cut",
    after("LIN {E6POS: X 40.000,Y -6.000", "$VEL.CP = 0.2", name="face_002.src"),
    drop("$VEL.CP", name="face_003.src"),
)
fault("face", "RETURN first in a sub", "sub does nothing", after("DEF", "RETURN", name="face_003.src"))
fault(
    "face",
    "local sub hides the file",
    "an empty face_003 in the main file",
    after("END", "DEF face_003 ( )\nEND", nth=-1),
)
fault(
    "face",
    "sub's name is another",
    "DEF face_03 in face_003.src",
    sub("DEF", "face_003", "face_03", name="face_003.src"),
)
fault("face", "base set in a sub", "base moved in the middle", after("DEF", "$BASE.Z = -1", name="face_003.src"))
fault("face", "spindle off between subs", "cuts with the spindle still", before("face_003 ( )", "$OUT[1] = FALSE"))
fault("face", "call commented out", "middle left out", sub("face_003 ( )", "face", ";face"))
fault(
    "face",
    "call in a fold's head",
    "a comment to the controller",
    sub("face_003 ( )", "face_003 ( )", ";FOLD face_003 ( )"),
    before("face_004 ( )", ";ENDFOLD"),
)
fault(
    "mill",
    "EXT of another BAS",
    "BAS comes from elsewhere",
    sub("EXT BAS", "EXT BAS", "EXT MYLIB BAS", name="mill.dat"),
)
fault(
    "mill",
    "point from the .dat",
    "XP1 lies 6 mm deeper",
    before(
        "ENDDAT",
        "DECL E6POS XP1={X 30.0,Y -30.0,Z 190.0,A -139.7,B 0.0,C 0.0,S 2,T 10,E1 53.6,E2 -5.4}",
        name="mill.dat",
    ),
    replace(CUT, "LIN XP1 C_DIS"),
)
fault(
    "mill",
    "feed from the .dat",
    "0.2 in the data list",
    before("ENDDAT", "DECL REAL FEED=0.2", name="mill.dat"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = FEED"),
)
fault(
    "mill",
    "feed of the .dat hidden by a local one",
    "local FEED is unset",
    before("ENDDAT", "DECL REAL FEED=0.01", name="mill.dat"),
    after("DEF mill", "DECL REAL FEED"),
    replace("$VEL.CP = 0.010000", "$VEL.CP = FEED"),
)
fault(
    "mill",
    "TRUE through a variable",
    "GO is FALSE in the data list",
    before("ENDDAT", "DECL BOOL GO=FALSE", name="mill.dat"),
    sub("$OUT[1] = TRUE", "TRUE", "GO"),
)


def _regions_swapped(source: str) -> str:
    """Everything between the two folds of `two`, the second first."""
    lines = source.split("\n")
    folds = [i for i, line in enumerate(lines) if line.startswith((";FOLD TWO", ";ENDFOLD"))][-4:]
    a, b, c, d = folds
    return "\n".join([*lines[:a], *lines[c : d + 1], *lines[a : b + 1], *lines[d + 1 :]])
