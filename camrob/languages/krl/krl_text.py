"""KRL text: names, comments and single numbers, made so that no text of any origin can act on the controller."""

from __future__ import annotations

import re
from collections.abc import Container, Sequence

from camrob.program.printed import fixed_decimals, plain_text, shortened

__all__ = [
    "NAME_LENGTH",
    "comment_text",
    "frame_aggregate",
    "krl_name",
    "load_aggregate",
]

NAME_LENGTH = 24
"""Characters that a KRL name may have."""

_INSTEAD = {"%": "pct", ";": ",", "{": "(", "}": ")", "&": "+"}
_FOLD = re.compile(r"(?<![A-Za-z])(END)?FOLD", re.IGNORECASE)
_RESERVED = frozenset(
    """AND ANIN ANOUT AXIS BAS BOOL BRAKE BY_NAME CASE CAST_FROM CAST_TO CHANNEL CHAR CIRC CIRC_REL CONFIRM CONST
    CONTINUE COPEN CREAD CWRITE CCLOSE C_DIS C_ORI C_PTP C_VEL DECL DEF DEFAULT DEFDAT DEFFCT DELAY DIGIN DISABLE
    DISTANCE DO E6AXIS E6POS ELSE ENABLE END ENDDAT ENDFCT ENDFOR ENDFOLD ENDIF ENDLOOP ENDSPLINE ENDSWITCH ENDWHILE
    ENUM ERR_RAISE EXIT EXOR EXT EXTFCT FALSE FOLD FOR FRAME GLOBAL GOTO HALT IF IMPORT IN INI INT INTERRUPT IS LIN
    LIN_REL LOOP MAXIMUM MINIMUM NOT ON ONLY OFF OR OUT PATH POS PRIO PTP PTP_REL PUBLIC PULSE REAL REPEAT RESUME
    RETURN SCIRC SEC SIGNAL SLIN SPL SPLINE SPTP SREAD STEP STOP STRUC SWITCH SWRITE THEN TO TRIGGER TRUE UNTIL WAIT
    WHEN WHILE B_AND B_EXOR B_NOT B_OR CON PRN AUX NUL COM1 COM2 COM3 COM4 LPT1 LPT2 LPT3 X Y Z A B C S T A1 A2 A3 A4
    A5 A6 E1 E2 E3 E4 E5 E6""".split()
)
_TAKEN = frozenset(
    """ABS SQRT SIN COS TAN ACOS ATAN2 EK INV_POS INVERSE FORWARD VARTYPE VARSTATE STRADD STRCLEAR STRCOMP STRCOPY
    STRDECLLEN STRFIND STRLEN CELL P00 SPS IR_STOPM MASREF_MAIN MASREF_USER NEW_SERV FLT_SERV USER_GRP USER_SPOT
    HOME HOME1 HOME2 HOME3 HOME4 HOME5 XHOME XHOME1 XHOME2 XHOME3 XHOME4 XHOME5 PDAT_ACT LDAT_ACT FDAT_ACT PDEFAULT
    LDEFAULT FHOME BASE_DATA TOOL_DATA LOAD_DATA BASE_NAME TOOL_NAME MACHINE_DEF MACHINE_FRAME_DAT""".split()
)
"""What every controller has under that name itself: functions, its own modules in R1, variables of $config.dat."""


def comment_text(text: str, longest: int) -> str:
    """`text` fit to stand behind `; ` or `;FOLD `, at most `longest` characters.

    Letters are transliterated, line ends and control characters become blanks; semicolons, braces, percent and
    ampersand signs, and the words FOLD and ENDFOLD lose the form that the pendant's editor acts on.
    """
    return shortened(_FOLD.sub(lambda found: (found[1] or "") + "F-OLD", plain_text(text, _INSTEAD)), longest)


def krl_name(text: str, taken: Container[str] = ()) -> str:
    """A KRL name made from `text`: a letter, then letters, digits and _, 24 at most, no keyword, nothing that the controller has
    itself, and none of `taken`.

    Letters keep their case, which KRL doesn't see.
    """
    name = re.sub(r"[^A-Za-z0-9]+", "_", plain_text(text, _INSTEAD)).strip("_")
    if not name or not name[0].isalpha() or name.upper() in _RESERVED | _TAKEN:
        name = f"P_{name}".rstrip("_")
    name = name[:NAME_LENGTH].rstrip("_")
    unique, count = name, 1
    while unique in taken or unique.upper() in taken:
        count += 1
        unique = name[: NAME_LENGTH - 1 - len(str(count))].rstrip("_") + f"_{count}"
    return unique


def load_aggregate(load: Sequence[float], decimals: int) -> str:
    """`{M ..,CM {..},J {..}}` of a mass in kg, its centre X, Y, Z in mm and moments in kg m^2, its axes the flange's."""
    mass, x, y, z, *moments = (fixed_decimals(float(v), decimals) for v in load)
    jx, jy, jz = moments if any(load[4:]) else ("0.0", "0.0", "0.0")
    return f"{{M {mass},CM {{X {x},Y {y},Z {z},A 0.0,B 0.0,C 0.0}},J {{X {jx},Y {jy},Z {jz}}}}}"


def frame_aggregate(xyzabc: Sequence[float], decimals: int) -> str:
    """`{X ..,Y ..,Z ..,A ..,B ..,C ..}`."""
    parts = (f"{label} {fixed_decimals(float(v), decimals)}" for label, v in zip("XYZABC", xyzabc, strict=True))
    return "{" + ",".join(parts) + "}"
