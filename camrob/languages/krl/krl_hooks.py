"""What a cell's hooks may say in KRL: outputs, waits and calls; not frames, not how the robot moves, and no motion."""

from __future__ import annotations

import re

from camrob.errors import CellError

__all__ = ["check_statement"]

# what camrob itself writes, and what of the controller it takes for granted
_SET_BY_CAMROB = (
    r"\$(?:BASE|TOOL|IPO_MODE|ACT_EX_AX|ORI_TYPE|CIRC_TYPE|CIRC_MODE|VEL|ACC|APO|VEL_AXIS|ACC_AXIS)"
    r"|\$(?:ROBROOT|WORLD|NULLFRAME|ERSYSROOT|ASYNC_AXIS|EX_KIN|ET[1-6]_\w+|SOFT[NP]_END|MAMES)"
    r"|MACHINE_DEF|BASE_DATA|TOOL_DATA|MACHINE_TOOL_DAT|MACHINE_FRAME_DAT|EX_AX_DATA|FDAT_ACT|PDAT_ACT|LDAT_ACT"
)
_SETS = re.compile(rf"(?<![\w$])({_SET_BY_CAMROB})(?![\w$])\s*(?:\[[^\]]*\])?(?:\s*\.\s*\w+)*\s*=(?!=)", re.IGNORECASE)
_SETS_BY_BAS = re.compile(r"(?<![\w$])BAS\s*\(", re.IGNORECASE)
_MOVES = re.compile(
    r"\s*(S?(?:PTP|LIN|CIRC|SPL)(?:_REL)?|PTPSPLINE|SPLINE|ENDSPLINE|ASYPTP|ASYCONT|ASYSTOP|MOVE_EMI|BRAKE)(?![\w$])",
    re.IGNORECASE,
)
_LEAVES = re.compile(r"\s*((?:GLOBAL\s+)?DEF(?:FCT|DAT)?|END(?:FCT|DAT)?|RETURN|GOTO|RESUME)(?![\w$])", re.IGNORECASE)
_STRING = re.compile(r'"[^"]*"')


def check_statement(name: str, line: str) -> None:
    """Raise CellError where a line of hook `name` does what camrob has to know of.

    A call of a subprogram is its owner's business and stays allowed.
    """
    statement = _STRING.sub('""', line).split(";")[0]
    what = ""
    if found := _SETS.search(statement):
        what = f"sets {found[1]}"
    elif _SETS_BY_BAS.search(statement):
        what = "calls BAS, which sets frames and speeds"
    elif found := _MOVES.match(statement):
        what = f"moves the robot ({found[1].upper()})"
    elif found := _LEAVES.match(statement):
        what = f"leaves the program's course ({found[1].upper()})"
    if what:
        hint = "leave it to camrob, or to a subprogram that puts back what it changes"
        raise CellError(f"hook {name} {what}: {line.strip()[:60]!r}", hint=hint)
