"""RAPID text: names, comments, numbers and aggregates, made so that no text of any origin can act on the controller."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Sequence

__all__ = ["NAME_LENGTH", "comment_text", "rapid_name", "rapid_number", "row"]

NAME_LENGTH = 24
"""Characters of a program's name: RAPID takes 32 in an identifier, and the names made of it are longer."""

_SPELLED = {
    "ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "đ": "d", "Đ": "D", "ł": "l", "Ł": "L",
    "ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "°": " deg", "µ": "u", "μ": "u", "×": "x",
    "·": ".", "–": "-", "—": "-", "−": "-", "‘": "'", "’": "'", "“": '"', "”": '"', "„": '"', "…": "...", "±": "+-",
    "<": "(", ">": ")",  # placeholders of the pendant's editor stand between them, in comments too
}  # fmt: skip
_RESERVED = frozenset(
    """ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC ENDRECORD
    ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR PERS PROC
    RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR
    MAIN BASE USER BOOL NUM DNUM STRING POS ORIENT POSE CONFDATA EXTJOINT ROBJOINT ROBTARGET JOINTTARGET SPEEDDATA ZONEDATA
    TOOLDATA LOADDATA WOBJDATA FINE VMAX TOOL0 WOBJ0 LOAD0 PI STOP BREAK LOAD SET RESET INCR DECR ADD CLEAR OPEN CLOSE
    WRITE""".split()
)


def _plain(text: str) -> str:
    """The text in printable 7-bit characters on one line."""
    spelled = "".join(_SPELLED.get(c, c) for c in unicodedata.normalize("NFC", text))
    kept = []
    for c in unicodedata.normalize("NFKD", spelled):
        if c.isspace() or not c.isprintable():
            kept.append(" ")
        elif not unicodedata.combining(c):
            kept.append(_SPELLED.get(c, c) if c.isascii() else "?")
    return " ".join("".join(kept).split())


def comment_text(text: str, longest: int) -> str:
    """`text` fit to stand behind `! `, at most `longest` characters: the line's end alone ends a comment, and it has none."""
    plain = _plain(text)
    return plain if len(plain) <= longest else plain[: longest - 2].rstrip() + ".."


def rapid_name(text: str) -> str:
    """A name made from `text`: a letter, then letters, digits and _, 24 at most, no word of RAPID's own, not a motion's."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", _plain(text)).strip("_")
    taken = re.fullmatch(r"[VZ]\d+|STN\d+|ROB_\d+|(MOVE|TRIGG|SEARCH)\w*", name.upper()) or name.upper() in _RESERVED
    if not name or not name[0].isalpha() or taken:
        name = f"P_{name}".rstrip("_")
    return name[:NAME_LENGTH].rstrip("_")


def rapid_number(value: float, decimals: int) -> str:
    """A number with a fixed count of decimals; zero never has a sign. Raises ValueError where it is not finite."""
    if not math.isfinite(value):
        raise ValueError(f"{value} can't be printed")
    text = f"{value:.{decimals}f}"
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def row(values: Sequence[float], decimals: int) -> str:
    """`[..,..]`."""
    return "[" + ",".join(rapid_number(float(v), decimals) for v in values) + "]"
