"""G-code told from CL data by its first lines, without what reads either."""

from __future__ import annotations

import re

__all__ = ["GCODE_LINE", "looks_like_gcode"]

_HEAD = 65_536  # bytes that are looked at to recognise G-code
GCODE_LINE = re.compile(
    rb"^[ \t]*+/?+[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?[GM][ \t]*+[0-9]{1,3}(?![0-9A-Z_]*[ \t]*+[=/,])", re.I | re.M
)
_PLAIN_LANGUAGE = re.compile(
    rb"^[ \t]*(?:N?\d+[ \t]+)?BEGIN[ \t]+PGM[ \t]|^%_N_|\bTRAORI\b"
    rb"|^[ \t]*(?:N\d+[ \t]*)?(?:DEF[ \t]+(?:REAL|INT|BOOL)[ \t]|PROC[ \t]+\w+[ \t]*(?:\(|;|\r?$)|EXTERN[ \t]+\w)",
    re.I | re.M,
)  # Heidenhain, Siemens
_SIEMENS = (".mpf", ".spf")
_AXIS_LINE = re.compile(
    rb"^[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?[XYZABCTF][ \t]*+[-+]?+[0-9.]++[^/=,\r\n]*+$", re.I | re.M
)
_OTHER_LINE = re.compile(
    rb"^[ \t]*+(?:GOTO[ \t]*+/|[A-Z][A-Z -]{2,}/|\$\$|&[A-Z]|DEF[ \t]|LIN[ \t]|PTP[ \t]|solid )", re.I | re.M
)


def looks_like_gcode(data: bytes, suffix: str = "") -> bool:
    """Whether the bytes begin like G-code: more lines with G or M codes or axis words than of another language, or some in a
    file that is named as Siemens' are.
    """
    head = data[:_HEAD].replace(b"\r", b"\n")  # some controls end their lines with CR alone
    if b"\0" in head:
        return False
    if _PLAIN_LANGUAGE.search(head):
        return True
    codes = len(GCODE_LINE.findall(head))
    if suffix.lower() in _SIEMENS and codes > 0:
        return True
    return codes > 0 and codes + len(_AXIS_LINE.findall(head)) > len(_OTHER_LINE.findall(head))
