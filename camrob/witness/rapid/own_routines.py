"""Routines that a RAPID program brings itself: those that hide the controller's of the same name, and functions, which may do
anything while a statement only seems to reckon ("Technical reference manual, RAPID kernel": scope rules, functions).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["functions_called", "hiding"]

_STATEMENTS = frozenset(
    """MOVEABSJ MOVEJ MOVEL MOVEC WAITTIME SETDO SETAO SETGO SET RESET PULSEDO INVERTDO STOP BREAK WAITDI WAITDO WAITUNTIL
    WAITAI WAITGI WAITSYNCTASK TPWRITE TPERASE CLKRESET CLKSTART CLKSTOP ERRWRITE PATHACCLIM ACCSET VELSET CONFJ
    CONFL SINGAREA CIRPATHMODE PDISPOFF EOFFSOFF ACTUNIT INCR DECR CLEAR ADD""".split()
)
_FUNCTIONS = frozenset("OFFS RELTOOL ABS SQRT SIN COS TAN ATAN2".split())
_VALUES = _FUNCTIONS | frozenset(
    """ACOS ASIN ATAN EXP POW ROUND TRUNC QUAD NUMTOSTR DNUMTOSTR VALTOSTR BYTETOSTR STRTOBYTE STRTOVAL STRLEN STRPART
    STRFIND STRMATCH STRMAP STRMEMB STRORDER STRDIGCMP CDATE CTIME GETTIME CLKREAD CROBT CJOINTT CPOS CTOOL CWOBJ
    CALCROBT CALCJOINTT ORIENTZYX EULERZYX NORIENT POSEMULT POSEINV POSEVECT DISTANCE DOTPROD VECTMAGN DEFFRAME DIM
    PRESENT ISPERS ISVAR OPMODE RUNMODE ROBNAME ROBOS GETTASKNAME TESTDI DINPUT DOUTPUT AINPUT AOUTPUT GINPUT
    GOUTPUT NUMTODNUM DNUMTONUM BITAND BITOR BITXOR BITNEG BITCHECK""".split()
)
"""ABB's functions that give a value and do nothing else."""
_WORDS = frozenset("IF ELSEIF WHILE TEST CASE FOR FROM TO STEP AND OR XOR NOT DIV MOD RETURN".split())
_TEXT = re.compile(r'"(?:[^"]|"")*"')
_CALL = re.compile(r"(?<![\w.\\])([A-Z_]\w*) ?\(")


def hiding(names: Iterable[str]) -> list[str]:
    """Those of a program's routines, in capitals, that hide one of the controller's that is read as ABB's."""
    return sorted(name for name in names if name in _STATEMENTS or name in _FUNCTIONS)


def functions_called(code: str) -> list[str]:
    """Functions called by a statement, in capitals, that are none of ABB's that only give a value."""
    found = (match for match in _CALL.finditer(_TEXT.sub('""', code)) if match.start() > 0)  # behind its own word
    return [match[1] for match in found if match[1] not in _VALUES and match[1] not in _WORDS]
