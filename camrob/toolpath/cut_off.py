"""A file that was cut off in the middle of a number: its last point would be another one than was meant."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError

__all__ = ["refuse_cut_off"]

_POINT = re.compile(
    rb"(?:^|[\s;])(?:GOTO|GODLTA|FROM|CIRCLE)\s*/[^$]*[\d.,+-]\s*$"  # CL data
    rb"|^(?![^(;]*M\d)[^(;]*[XYZABCUVW]\s*=?\s*[-+]?[\d.]*[ \t]*$",  # a block of G-code without M, which could end the program
    re.IGNORECASE,
)


def refuse_cut_off(data: bytes) -> None:
    """Raises ToolpathError where the last line is a point and has no line end: nothing says that the file ends there."""
    if data.endswith((b"\n", b"\r")):
        return
    last = data[max(data.rfind(b"\n"), data.rfind(b"\r")) + 1 :]
    if _POINT.search(last) is None:
        return
    shown = last.decode("utf-8", "replace").strip()[-40:]
    raise ToolpathError(
        f"the file ends in the middle of a line, at {shown!r}, and nothing ends its program: it may have been cut off there",
        hint="get the whole file, or put a line end behind it where that is all of it",
        line=len(re.split(rb"\r\n|\n|\r", data)),
    )
