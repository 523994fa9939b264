"""Words of APT text that the reader has no verb for, and what it says of them."""

from __future__ import annotations

import re

__all__ = ["ACTS", "CANCELS", "CURVE", "DRIVE", "ENDS", "HIDING", "NOTHING", "NO_AXIS", "ONCE", "STRANGE", "TO_MACHINE"]

NO_AXIS = "a tool axis whose length is not 1"
STRANGE = "not known, and its numbers may mean motion"

NOTHING = frozenset(
    """PAINT PPRINT PARTNO REMARK INSERT TPRINT LETTER MACHIN SEQNO PPFUN MOVE_ATTRIB OPFEATEND BOX SETUP SWITCH REWIND
    RECIPE FEEDOVER CUTTER TLDATA TOOLNO SELECT INTOL OUTTOL TOLER AUTOPS AUTOPOS MULTAX CLPRNT NOPOST PRINT DISPLY PLOT
    LEADER CLEARP CLRSRF MAXDPM WPLANE MCHTOL LINTOL ARCSLP CHECK VERIFY HEAD TMARK TITLES IDENT PARTID TOOLPATH TOOLPATH_TYPE
    PLABEL TLSPEC LPRINT OVPLOT MATERL CSI_TOOL_PATH CSI_PATH_TOLERANCE OPNAME""".split()
)
HIDING = (
    "OPSKIP INCR INCREMENTAL MIRROR ROTATE SCALE REFSYS LOOPST MACRO DNTCUT".split()
)  # motions, till they are cancelled
ENDS = {"LOOPND": "LOOPST", "TERMAC": "MACRO", "CUT": "DNTCUT"}
CANCELS = {"OFF", "NOMORE", "NONE"}
CURVE = ("NURBS", "KNOT", "CNTRL")
ONCE = ("SPLINE", "CALL", "CALLSUB", "PATERN", "THREAD")
DRIVE = re.compile(
    r"(?:TL(?:LFT|RGT|ON),?)?GO(?:FWD|LFT|RGT|BACK|UP|DOWN|OFF|CLEAR)?|TL(?:LFT|RGT|ON)|PSIS|THICK|IF\s*\(.*"
)
TO_MACHINE = re.compile(
    r"(?:^|[^A-Z\d])G0*(?:10|16|51|51\.1|52|68|68\.[1-4]|92|101)(?:[^\d.]|$)|\bA?(?:TRANS|ROT|MIRROR|SCALE)\s*(?:[XYZ]\s*[-+=\d]|RPL)",
    re.I,
)
"""Codes of a machine's that shift, turn, mirror or scale all points behind them."""

ACTS = re.compile(
    r"\s*(?:N\d+\s*)?(?!.*G(?:0*4|28|30|53)(?:\D|$))(?=.*(?:[XYZABCSF]\s*[-+.\d]|G0*[0123](?:\D|$)|G(?:41|42|65|66|91|93|95)(?:\D|$)"
    r"|M0*(?:3|4|5|6|13|14|19|97|98)(?:\D|$)))(?:[A-Z]\s*[-+]?[\d.]+\s*|\([^)]*\)\s*)+",
    re.I,
)
"""A block of codes that move the tool, or switch its spindle, tool or feed."""
