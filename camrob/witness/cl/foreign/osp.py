"""Okuma's OSP, as far as its words are ISO's: G15 H a datum, G56 H the tool's length along Z till G53 (manual of the OSP-P300M).

What else OSP has for itself is a gap: cycles that return by G71 and M52 to M54, lengths along other axes by G54 to G59, a frame
by G11, variables, calls.
"""

from __future__ import annotations

import re

from camrob.witness.cl.gcode import GcodeReader

__all__ = ["OSP", "OspReader"]

OSP = re.compile(
    r"\A\s*\$[\w.-]+\.(?:MIN|SSB|SUB|LIB|SDF)%?\s*$|^[ \t]*(?:N\d+[ \t]*)?G0*15[ \t]*H[ \t]*\d", re.I | re.M
)
"""What only its programs hold."""

_CODE = re.compile(r"([GM])0*(\d+\.?\d*)")
_KEPT = frozenset("0 1 2 3 9 17 18 19 20 21 30 40 41 42 61 64 80 90 91 94 95".split())
_NOT_KEPT = frozenset("13 14 97 98 99".split())  # M codes that are a spindle or a call elsewhere


class OspReader(GcodeReader):
    """Reads a program of OSP block by block, in ISO's words."""

    def read(self, text: str) -> None:
        """Without the line that names the program."""
        super().read(re.sub(r"\A\s*\$[\w.-]+%?[^\n]*", "", text))

    def _read(self, block: str, line: int) -> None:
        words = [(kind, number) for kind, number in _CODE.findall(block)]
        g = [number for kind, number in words if kind == "G"]
        kept = [number for number in g if number in _KEPT or number in ("15", "53", "56")]
        odd = kept != g or any(kind == "M" and number in _NOT_KEPT for kind, number in words)
        named = re.search(r"H0*([1-9]\d*)", block)
        ends = "53" in g and re.search(r"[XYZABC][-+.\d]", block)
        lacks = ("15" in g and not named) or ("56" in g and not (named or "HA" in block)) or {"15", "56"} <= set(g)
        if odd or ends or lacks:
            self._gap(line, f"{block[:30]}: OSP's own")
            return
        if "56" in g:
            block = re.sub(r"G0*56(?!\d)", "G43", block.replace("HA", ""))
        super()._read(re.sub(r"G0*53(?!\d)", "G49", block), line)
