"""The one table of KRL statements that the witness understands. What is not on it is not judged.

Each row: how the statement looks (capitals, single blanks, no comment), what it does to frames, outputs and motion, the document
that its meaning rests on, and the act (in `acts`) that carries it out. The first row that fits holds. `VARIABLES` is the same for
assignments to system variables. Blocks (IF, FOR, ...) and routines (DEF) are the business of `program` and `run`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["BAS", "STATEMENTS", "VARIABLES", "Row", "statement", "variable"]

EXPERT = "KUKA System Software 5.x, Expert Programming"
SYSTEM = "KUKA System Software 8.3, Operating and Programming Instructions for System Integrators"
NAMES = "KUKA System Software 8.1 to 8.4, System Variables"
LIBRARY = "KUKA BAS.SRC, the library on every controller"

_NAME = r"[$A-Z_][A-Z0-9_$]*(?:\[[^\]]*\])?(?:\.[A-Z_][A-Z0-9_]*(?:\[[^\]]*\])?)*"
_TYPES = r"(?:INT|REAL|BOOL|CHAR|FRAME|POS|E3POS|E6POS|AXIS|E3AXIS|E6AXIS|LOAD|FDAT|LDAT|PDAT|ADAT|SIGINF|STATE_T)"


@dataclass(frozen=True, slots=True)
class Row:
    """One kind of statement. `does`: to frames, outputs and motion. `stops`: the advance run waits here for the robot."""

    pattern: re.Pattern[str]
    act: str
    does: str
    document: str
    stops: bool = False


def _row(pattern: str, act: str, does: str, document: str, stops: bool = False) -> Row:
    return Row(re.compile(pattern), act, does, document, stops)


STATEMENTS = (
    _row(r"(?:GLOBAL )?SIGNAL (?P<name>[A-Z_]\w*) (?P<what>.+)", "signal", "names outputs or inputs", EXPERT),
    _row(
        r"(?:GLOBAL )?(?:DECL |CONST )+(?:GLOBAL )?(?:CONST )?(?P<type>[A-Z_]\w*) (?P<items>.+)",
        "declare",
        "declares variables, in a data list with their values",
        EXPERT,
    ),
    _row(rf"(?:GLOBAL )?(?P<type>{_TYPES}) (?P<items>[A-Z_].*)", "declare", "declares variables", EXPERT),
    _row(
        r"EXT (?P<place>[^ (]+) (?P<name>[A-Z_$]\w*) ?\(.*",
        "borrow",
        "takes a routine from a place of its own: what it does isn't at hand",
        EXPERT,
    ),
    _row(
        r"EXT (?P<place>[^ (]*[\\/:])(?P<name>[A-Z_$]\w*) ?\(.*",
        "borrow",
        "likewise, with no blank between place and name",
        EXPERT,
    ),
    _row(
        r"(?:GLOBAL )?STRUC [A-Z_]\w* (?P<parts>.+)",
        "structure",
        "declares a structure: its INT components are whole",
        EXPERT,
    ),
    _row(r"(?:EXT|EXTFCT|IMPORT|ENUM|GLOBAL ENUM)\b.*", "nothing", "declares; nothing moves", EXPERT),
    _row(
        r"(?:GLOBAL )?INTERRUPT DECL (?P<number>.+?) WHEN (?P<when>.+) DO (?P<what>.+)",
        "interrupt",
        "prepares a routine that may run at any time once switched on; KUKA's own for stop messages only reports",
        EXPERT,
    ),
    _row(r"INTERRUPT ON\b ?(?P<number>.*)", "interrupt_on", "from here on the routine may run", EXPERT),
    _row(r"INTERRUPT (?:OFF|DISABLE|ENABLE)\b.*", "nothing", "the routine no longer runs", EXPERT),
    _row(
        r"SET_CD_PARAMS ?\( ?\d+ ?\)",
        "nothing",
        "of inline forms: the values of the collision detection, which may stop the robot and leaves its way as it is",
        LIBRARY,
    ),
    _row(
        r"TRIGGER WHEN (?P<by>DISTANCE|PATH) ?= ?(?P<where>.+?) DELAY ?= ?(?P<delay>.+?) DO (?P<what>.+?)"
        r"(?: PRIO ?= ?-?\d+)?",
        "trigger",
        "switches where the next motion begins (DISTANCE=0) or ends (DISTANCE=1, PATH=0), without stopping it",
        EXPERT,
    ),
    _row(
        r"(?P<word>S?PTP|S?LIN|S?CIRC|SPL)\b(?! ?[=.\[(]) ?(?P<rest>.+)",
        "motion",
        "moves: PTP by the axes, LIN on a line, CIRC on a circle through the auxiliary point (CA: so many degrees); "
        "C_DIS and its kin round the corner; Status and Turn count for PTP alone; a component left out keeps its value",
        EXPERT + ": Motion programming",
    ),
    _row(
        r"(?P<word>S?LIN|S?PTP)_REL (?P<rest>.+)",
        "relative",
        "moves by the components given, in $BASE, or by axes",
        EXPERT + ": Relative motion",
    ),
    _row(r"WAIT SEC (?P<value>.+)", "wait", "stands still so many seconds", EXPERT, stops=True),
    _row(r"WAIT FOR .+", "wait_for", "stands still until the condition holds", EXPERT, stops=True),
    _row(r"HALT", "halt", "stands still until the operator continues", EXPERT, stops=True),
    _row(r"PULSE ?\(.+\)", "output", "switches an output for some time", EXPERT, stops=True),
    _row(r"(?:ANOUT|DIGOUT) (?:ON|OFF)\b.*", "output", "ties an output to a value", EXPERT, stops=True),
    _row(r"CONTINUE", "continue", "the next statement happens before the robot has arrived", EXPERT),
    _row(r"RETURN\b ?(?P<value>.*)", "leave", "ends the routine, a function with its value", EXPERT),
    _row(r"EXIT", "leave_loop", "ends the loop", EXPERT),
    _row(r"GOTO (?P<name>[A-Z_]\w*)", "jump", "goes on at a mark of the same routine", EXPERT),
    _row(r"[A-Z_]\w* ?:", "nothing", "a mark that GOTO may name", EXPERT),
    _row(r"BAS ?\( ?#(?P<what>[A-Z_]+) ?(?:, ?(?P<value>.+?) ?)?\)", "bas", "see BAS below", LIBRARY),
    _row(rf"(?P<name>{_NAME}) ?= ?(?P<value>[^=].*)", "assign", "see VARIABLES below; else a variable's value", EXPERT),
    _row(r"(?P<name>[A-Z_$]\w*) ?\((?P<inputs>.*)\)", "call", "runs another routine", EXPERT),
)

VARIABLES = (
    _row(
        r"\$BASE(?:\.(?P<part>[XYZABC]))?", "base", "the frame in which poses are read, or one component of it", NAMES
    ),
    _row(r"\$TOOL(?:\.(?P<part>[XYZABC]))?", "tool", "the tool's tip and axes on the plate, or one component", NAMES),
    _row(
        r"\$LOAD(?:\.(?P<part>M|(?:CM|J)(?:\.[XYZABC])?))?",
        "load",
        "what hangs on the plate: mass, centre, inertia",
        NAMES,
    ),
    _row(r"\$VEL\.CP", "speed", "speed of LIN and CIRC in m/s", NAMES),
    _row(r"\$VEL", "speeds", "speed of LIN and CIRC, and of turning", NAMES),
    _row(r"\$ADVANCE", "advance", "how many motions are planned ahead; 0: no corner is rounded", NAMES),
    _row(r"\$ORI_TYPE", "ori_type", "#VAR: turns evenly to the pose's A, B, C; #CONSTANT: doesn't turn", SYSTEM),
    _row(r"\$CIRC_TYPE", "circ_type", "#BASE: turns as on a line; #PATH: with the circle", SYSTEM),
    _row(r"\$IPO_MODE", "ipo_mode", "#BASE: the tool is on the arm; #TCP: it stands in the cell", NAMES),
    _row(r"\$(?P<which>ROBROOT|WORLD)(?:\..+)?", "moved_frame", "moves the robot's foot or the world", NAMES),
    _row(r"\$ACT_EX_AX", "act_ex_ax", "how many external axes take part", NAMES),
    _row(r"\$ASYNC_AXIS", "async_axis", "external axes that no longer follow the motions", NAMES),
    _row(r"\$(?:OUT|ANOUT)\[.+\]", "switch", "an output", NAMES, stops=True),
    _row(r"\$(?:OV_PRO|RED_VEL)", "override", "all speeds in percent", NAMES),
    _row(r"\$ACT_(?:TOOL|BASE)", "row", "the row that panel and load data go by; no frame changes", NAMES),
    _row(
        r"\$(?:APO\.CDIS|ACC\.CP|(?:VEL|ACC)\.ORI[12])",
        "bounded",
        "how far corners are rounded, and how fast it goes and turns: held to the cell's own values",
        NAMES,
    ),
    _row(
        r"\$(?:ACC|APO|JERK|GEAR_JERK|VEL_AXIS|ACC_AXIS|VEL_EXTAX|ACC_EXTAX|LOAD_A[123]|CIRC_MODE"
        r"|SINGUL_STRATEGY)(?:[.\[].*)?",
        "conduct",
        "how fast and how round it goes, loads: away from the controller's default not judged",
        NAMES,
    ),
    _row(r"\$(?:BWDSTART|TIMER|TIMER_STOP|TIMER_FLAG|H_POS)(?:[.\[].*)?", "nothing", "timers and marks", NAMES),
)

# BAS commands: act and what they do. INITMOV stops the advance run, the others don't.
BAS = {
    "INITMOV": ("bas_defaults", "speeds, accelerations and frames to their defaults, $VEL.CP among them"),
    "VEL_PTP": ("bas_ptp", "speed of PTP in percent"),
    "ACC_PTP": ("bas_acc_ptp", "acceleration of PTP in percent"),
    "ACC_CP": ("bas_acc", "acceleration of LIN and CIRC"),
    "PTP_DAT": ("bas_data", "PTP's values from PDAT_ACT"),
    "CP_DAT": ("bas_data", "LIN's and CIRC's values from LDAT_ACT"),
    "LOAD": ("bas_load", "the load's mass"),
    "VEL_CP": ("bas_speed", "$VEL.CP"),
    "TOOL": ("bas_tool", "$TOOL = TOOL_DATA[n], 0 the plate"),
    "BASE": ("bas_base", "$BASE = BASE_DATA[n], 0 the world"),
    "FRAMES": ("bas_frames", "$TOOL and $BASE by the numbers in FDAT_ACT"),
    "PTP_PARAMS": ("bas_frames", "PTP's values from PDAT_ACT, and frames by FDAT_ACT"),
    "CP_PARAMS": ("bas_params", "LIN's values, $VEL.CP, and frames by FDAT_ACT"),
}


def _first(rows: tuple[Row, ...], text: str) -> tuple[Row, re.Match[str]] | None:
    return next(((row, match) for row in rows if (match := row.pattern.fullmatch(text)) is not None), None)


def statement(code: str) -> tuple[Row, re.Match[str]] | None:
    """The row of the table that a statement is on; None where it is on none."""
    return _first(STATEMENTS, code)


def variable(name: str) -> tuple[Row, re.Match[str]] | None:
    """The row of a system variable; None where it is on none."""
    return _first(VARIABLES, name)
