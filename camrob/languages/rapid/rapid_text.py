"""RAPID text: names, comments, numbers and aggregates, made so that no text of any origin can act on the controller."""

from __future__ import annotations

import re
from collections.abc import Sequence

from camrob.program.printed import fixed_decimals, plain_text, shortened

__all__ = ["NAME_LENGTH", "comment_text", "rapid_name", "row"]

NAME_LENGTH = 24
"""Characters of a program's name: RAPID takes 32 in an identifier, and the names made of it are longer."""

# placeholders of the pendant's editor stand between them, in comments too
_INSTEAD = {"<": "(", ">": ")"}
_RESERVED = frozenset(
    """ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC ENDRECORD
    ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR PERS PROC
    RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR
    MAIN BASE USER BOOL NUM DNUM STRING POS ORIENT POSE CONFDATA EXTJOINT ROBJOINT ROBTARGET JOINTTARGET SPEEDDATA ZONEDATA
    TOOLDATA LOADDATA WOBJDATA FINE VMAX TOOL0 WOBJ0 LOAD0 PI STOP BREAK LOAD SET RESET INCR DECR ADD CLEAR OPEN CLOSE
    WRITE""".split()
)


def comment_text(text: str, longest: int) -> str:
    """`text` fit to stand behind `! `, at most `longest` characters: the line's end alone ends a comment, and it has none."""
    return shortened(plain_text(text, _INSTEAD), longest)


def rapid_name(text: str) -> str:
    """A name made from `text`: a letter, then letters, digits and _, 24 at most, no word of RAPID's own, not a motion's."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", plain_text(text, _INSTEAD)).strip("_")
    taken = re.fullmatch(r"[VZ]\d+|STN\d+|ROB_\d+|(MOVE|TRIGG|SEARCH)\w*", name.upper()) or name.upper() in _RESERVED
    if not name or not name[0].isalpha() or taken:
        name = f"P_{name}".rstrip("_")
    return name[:NAME_LENGTH].rstrip("_")


def row(values: Sequence[float], decimals: int) -> str:
    """`[..,..]`."""
    return "[" + ",".join(fixed_decimals(float(v), decimals) for v in values) + "]"
