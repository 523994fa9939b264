"""A second round of faults, where the first one found holes: what is known by name, matched as text, or taken on trust."""

from __future__ import annotations

import hashlib
import json
import re

from planted.edits import Edit, Files, Planted, after, before, drop, file, move, replace, sub, text

__all__ = ["MORE", "NOT_LOADED"]

MORE: list[Planted] = []
NOT_LOADED: list[Planted] = []
"""What the controller would most likely refuse to load: reported, and not counted."""

CUT = "LIN {E6POS: X 30.000,Y -30.000,Z 196.000"
PLUNGE = "LIN {E6POS: X -40.000,Y -30.000,Z 196.000"
POCKET = "LIN {E6POS: X 20.000,Y 0.000,Z 197.000"
FEED = "$VEL.CP = 0.010000"


def fault(job: str, name: str, why: str, *edits: Edit) -> None:
    MORE.append(Planted(job, name, why, edits))


def arguable(job: str, name: str, why: str, *edits: Edit) -> None:
    NOT_LOADED.append(Planted(job, name, why, edits))


def _forged(files: Files) -> None:
    """The feed a tenth, and a NAME.json that says so of just these files."""
    sub(FEED, "0.010000", "0.001000")(files)
    shas = {name: hashlib.sha256(content.encode()).hexdigest() for name, content in files.items()}
    files["mill.json"] = json.dumps({"feed": {"mode": "optimal"}, "manifest": {"program": shas}})


def own(definition: str) -> Edit:
    """A routine behind the main program's END."""
    return after("END", definition, nth=-1)


# what is known by its name
BAS_HEAD = "DEF BAS (CMD :IN,V :IN )\nDECL BAS_COMMAND CMD\nDECL REAL V\n"
fault("mill", "own BAS that moves", "LIN_REL wherever BAS is called", own(BAS_HEAD + "LIN_REL {Z -50}\nEND"))
fault("mill", "own BAS that switches", "outputs wherever BAS is called", own(BAS_HEAD + "$OUT[1] = TRUE\nEND"))
fault(
    "mill",
    "own BAS called in the cut",
    "BAS(#VEL_CP) that does something else",
    before(POCKET, "BAS (#VEL_CP,0.015 )"),
    own(BAS_HEAD + "$VEL.CP = 0.3\nEND"),
)
arguable(
    "mill",
    "own EK",
    "EK() of the file returns another base",
    own("DEFFCT FRAME EK (R :IN,T :IN,F :IN )\nDECL FRAME R,F\nDECL INT T\nRETURN ($NULLFRAME)\nENDFCT"),
)
fault(
    "mill",
    "own ABS",
    "ABS() of the file returns 0.2",
    sub(FEED, "0.010000", "ABS(0.01)"),
    own("DEFFCT REAL ABS (X :IN )\nDECL REAL X\nRETURN (0.2)\nENDFCT"),
)
fault(
    "mill",
    "routine defined twice",
    "which of the two runs?",
    before(POCKET, "KEEP ( )"),
    own("DEF KEEP ( )\nEND\nDEF KEEP ( )\nLIN_REL {Z -2}\nEND"),
)
fault(
    "mill",
    "feed changed through :OUT",
    "the routine hands 0.2 back",
    after("DEF mill", "DECL REAL F"),
    before("BAS (#INITMOV", "F = 0.01\nSETF (F )"),
    replace(FEED, "$VEL.CP = F"),
    own("DEF SETF (X :OUT )\nDECL REAL X\nX = 0.2\nEND"),
)
fault("face", "sub that calls itself", "never ends", after("DEF", "face_003 ( )", name="face_003.src"))
fault("mill", "empty LOOP", "never ends", before(POCKET, "LOOP\nENDLOOP"))
fault("mill", "WHILE TRUE", "never ends", before(POCKET, "WHILE TRUE\nENDWHILE"))
fault(
    "mill",
    "a billion waits",
    "never ends in practice",
    after("DEF mill", "DECL INT I"),
    before(POCKET, "FOR I=1 TO 1000000000\nWAIT SEC 0\nENDFOR"),
)
# hooks matched as text
fault("mill", "speed times 0.1", "900 for 9000", sub("$ANOUT", "24000.0", "24000.0 * 0.1"))
fault("mill", "speed minus", "slower", sub("$ANOUT", "24000.0", "24000.0 - 0.2"))
fault("mill", "speed over 24000.0 + 24000", "half", sub("$ANOUT", "24000.0", "(24000.0 + 24000)"))
fault("mill", "speed set again behind the run-up", "2400 for 9000", after("WAIT SEC 3.0", "$ANOUT[1] = 0.1"))
fault(
    "mill",
    "second spindle speed by integers",
    "12000 / 24000 is 0 in the pocket",
    sub("$ANOUT", "24000.0", "24000", nth=1),
)
fault("two", "tool 2's speed by integers", "drill stands", sub("$ANOUT", "24000.0", "24000", nth=1))
fault("mill", "run-up reckoned away", "3.0 - 3.0", sub("WAIT SEC 3.0", "3.0", "3.0 - 3.0"))
fault("mill", "run-up in the advance run", "CONTINUE before the wait", before("WAIT SEC 3.0", "CONTINUE"))
fault("mill", "dwell in the advance run", "CONTINUE before the dwell", before("WAIT SEC 2.000", "CONTINUE"))
fault(
    "mill",
    "spindle on in the advance run",
    "CONTINUE before it, behind a motion",
    before("$OUT[1] = TRUE", "CONTINUE", nth=1),
)
fault(
    "mill", "HALT for the tool behind spindle on", "hands in the turning spindle", move("HALT ;change", "WAIT SEC 3.0")
)
fault("mill", "spindle on in INI", "turns while the tool is changed", before("PTP {E6AXIS", "$OUT[1] = TRUE"))
fault(
    "mill", "spindle on twice, off once more at the end", "on again behind the footer", before("END", "$OUT[1] = TRUE")
)
# motions outside the file's own
fault("mill", "motion behind the footer", "through the table after the end", before("END", "LIN_REL {Z -600}"))
fault("mill", "motion before HOME", "from wherever it stands", before("PTP {E6AXIS", "LIN_REL {X 100}"))
fault("mill", "first HOME dropped", "entry from wherever it stands", drop("PTP {E6AXIS"))
fault(
    "mill",
    "first HOME by $AXIS_ACT_MEAS, then the entry",
    "entry from wherever it stands",
    replace("PTP {E6AXIS", "PTP $AXIS_ACT_MEAS"),
)
fault(
    "mill",
    "rapid ten times",
    "2 m/s for 0.2 in the air",
    text(lambda t: t.replace("$VEL.CP = 0.200000", "$VEL.CP = 2.000000")),
)
fault(
    "mill",
    "rapid of 10 m/s",
    "above what the controller takes",
    text(lambda t: t.replace("$VEL.CP = 0.200000", "$VEL.CP = 10.0")),
)
fault("mill", "feed 2 % up", "above the file's", sub(FEED, "0.010000", "0.010200"))
fault(
    "mill",
    "table 170 degrees in 15 mm",
    "E2 at three times its speed: the feed is not held",
    text(
        lambda t: re.sub(
            r"(LIN \{E6POS: X 20\.000,Y 15\.000.*E2 )(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 170:.4f}", t
        )
    ),
)
fault(
    "mill",
    "track 1400 mm in 15 mm",
    "E1 above its speed: the feed is not held",
    text(
        lambda t: re.sub(
            r"(LIN \{E6POS: X 20\.000,Y 15\.000.*E1 )(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) - 1400:.4f}", t
        )
    ),
)
fault(
    "five",
    "half-way point with the start's axis",
    "swing all at once, 5 degrees off",
    before(
        "LIN {E6POS: X -15.000,Y 5.000",
        "LIN {E6POS: X -22.5,Y 2.5,Z 195.75,A -141.562,B 7.8636,C 6.1972,E1 100.0,E2 -6.0} C_DIS",
    ),
)
fault(
    "two",
    "re-posture dropped to a PTP at depth",
    "PTP out of the hole",
    sub("LIN {E6POS: X 0.000,Y 0.000,Z 248.000", "LIN", "PTP", nth=-1),
)
fault(
    "plate",
    "helix flattened",
    "one of its points at the old depth",
    sub("LIN {E6POS: X 9.924,Y 0.868", "Z 195.972", "Z 196.100"),
)
# waits and overrides
fault("mill", "WAIT FOR FALSE", "never ends, in the cut", before(POCKET, "WAIT FOR FALSE"))
fault("mill", "WAIT FOR TRUE", "a stop in the advance run: a mark", before(POCKET, "WAIT FOR $OUT[1]"))
fault("two", "WAIT FOR in the hole", "drill rubs at the bottom", before("WAIT SEC 1.500", "WAIT FOR $IN[12]"))
fault("mill", "$OV_PRO = 1 in the pocket", "a hundredth of the feed", before(POCKET, "$OV_PRO = 1"))
fault("mill", "$OV_PRO = 0", "stands in the cut", before(POCKET, "$OV_PRO = 0"))
fault("mill", "$OV_PRO by an input", "who knows", before(POCKET, "IF $IN[9] THEN\n$OV_PRO = 5\nENDIF"))
# text
fault("mill", "underscore in a number", "not KRL; 30 to Python", sub(CUT, "X 30.000", "X 3_0.000"))
fault("mill", "full-width digit", "not KRL; 30 to Python", sub(CUT, "X 30.000", "X \uff13\uff10.000"))
fault("mill", "NaN", "not KRL", sub(CUT, "X 30.000", "X nan"))
fault("mill", "blank in a number", "X 3 0.000", sub(CUT, "X 30.000", "X 3 0.000"))
fault("mill", "statement with rubbish behind", "not KRL", sub(CUT, " C_DIS", " C_DIS C_FOO"))
fault(
    "mill",
    "two statements in a line",
    "not KRL",
    sub("$OUT[1] = TRUE", "$OUT[1] = TRUE", "$OUT[1] = TRUE $OUT[1] = FALSE"),
)
fault("mill", "END missing", "not KRL", drop("END"))
arguable(
    "mill",
    "DEF of another name",
    "module and DEF differ: the controller does not find it",
    sub("DEF mill", "mill", "mull"),
)
fault("mill", "brace missing", "not KRL", sub(CUT, "} C_DIS", " C_DIS"))
fault("mill", "comma missing", "not KRL", sub(CUT, ",Y -30.000", " Y -30.000"))
# data lists
fault(
    "mill",
    "data list's feed doubled at the end",
    "kept by the controller: the next run has twice the feed",
    before("ENDDAT", "DECL REAL FEED=0.01", name="mill.dat"),
    replace(FEED, "$VEL.CP = FEED"),
    before("END", "FEED = FEED * 2"),
)
fault(
    "mill",
    "data list's point moved at the end",
    "kept by the controller: the next run is 1 mm deeper",
    before(
        "ENDDAT",
        "DECL REAL DEPTH=196.0\nDECL E6POS XP={X 30.0,Y -30.0,Z 196.0,A -139.7295,B 0.0,C 0.0,E1 53.6529,E2 -5.3720}",
        name="mill.dat",
    ),
    replace(CUT, "LIN XP C_DIS\nXP.Z = XP.Z - 1"),
)
arguable(
    "mill",
    "data list of another module",
    "DEFDAT mull: BAS is not known",
    sub("DEFDAT", "mill", "mull", name="mill.dat"),
)
fault(
    "mill",
    "$config.dat beside",
    "CONFIG's own values for what is active",
    file("$config.dat", "DEFDAT $CONFIG PUBLIC\nDECL GLOBAL REAL DEF_VEL_CP=3.0\nENDDAT\n"),
    before(POCKET, "$VEL.CP = DEF_VEL_CP"),
)
fault("mill", "forged NAME.json", "a tenth of the feed, and a manifest that says the plan wanted it", _forged)
